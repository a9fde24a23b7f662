"""Branches along a parameter that is an explicit function of the impact phase: the load factor, R, mean, amplitude."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from percuss.explore.boundary_curves.lines import SAMPLES, Fold, Line, Stretch, phase_at, places
from percuss.explore.family import SystemFamily
from percuss.model.checks import Array
from percuss.model.contact import Result
from percuss.stability.reduced import quadratic_coefficients
from percuss.steady.level import level_at, ratio_at
from percuss.steady.phases import Arcs, forced_response
from percuss.steady.trigonometric import harmonic_sums, on_circle

__all__ = ["Heights", "PhaseStretch", "by_phase", "heights_of"]

_FIRST = 1e-12  # share of the range at which a load factor's range from 0 begins


@dataclass(frozen=True)
class Heights:
    """How y goes with the height of v_f of the middle system that it needs, both ways; broadcasts.

    `size` is the factor by which y makes the alternating load larger than the middle system's.
    """

    of: Callable[[Array], Array]
    y: Callable[[Array], Array]
    mean: Callable[[Array], Array]
    restitution: Callable[[Array], Array]
    size: Callable[[Array], Array]


def heights_of(line: Line) -> Heights | None:
    if line.name not in ("load_factor", "restitution", "mean", "amplitude"):
        return None
    if line.name == "restitution" and not line.middle.contact.keeps_strain:
        return None  # R moves the curve itself
    if line.name in ("mean", "amplitude") and (
        not isinstance(line.family, SystemFamily) or "load_factor" in line.fixed
    ):
        return None
    system, period = line.middle, line.period
    contact, r, d, mean = system.contact, system.restitution, system.d, system.load.mean
    unit = abs(complex(system.load.coefficients[system.load.harmonics[0]]))
    factor = _factor(line)

    def constant(value: float) -> Callable[[Array], Array]:
        return lambda y: np.full_like(y, value)

    if line.name == "restitution":
        return Heights(
            lambda y: level_at(mean, d, contact.impedance_ratios(y), period),
            lambda height: contact.restitutions_of(ratio_at(mean, d, height, period)),
            constant(mean),
            lambda y: y,
            constant(1.0),
        )
    if line.name == "amplitude":
        c = mean * factor
        return Heights(lambda y: c * unit / y, lambda h: c * unit / h, constant(mean), constant(r), lambda y: y / unit)
    scale = unit if line.name == "load_factor" else 1.0
    return Heights(
        lambda y: y * scale * factor,
        lambda h: h / (scale * factor),
        lambda y: y * scale,
        constant(r),
        constant(1.0),
    )


@dataclass(frozen=True)
class PhaseStretch:
    """A part of one arc of the circle, followed by the phase from `start` to `stop`."""

    line: Line
    branch: int
    start: float
    stop: float
    heights: Heights = field(repr=False)
    arcs: Arcs = field(repr=False)

    def nodes(self, samples: int | None, inside: float, least: int = SAMPLES) -> Array:
        return np.linspace(inside, 1.0 - inside, samples or places(self.line, least))

    def place(self, t: Array) -> tuple[Array, Array]:
        phase = self.start + (self.stop - self.start) * t
        y = self.heights.y(self.arcs.response.rigid_velocity(phase))
        return np.clip(y, self.line.low, self.line.high), on_circle(phase)

    def quadratic(self, t: Array) -> tuple[Array, Array, Array]:
        y, _ = self.place(t)
        phase = self.start + (self.stop - self.start) * t
        heights, system, period = self.heights, self.line.middle, self.line.period
        response = forced_response(system)
        push, elastic = heights.mean(y) / heights.size(y), response.by_harmonics
        k, end = elastic.k, elastic.end_shape()
        ringing, slope = harmonic_sums(phase, k, 1j * k * elastic.p * end, 1j * k * elastic.rigid_factor)
        if not response.is_smooth:
            slope = response.slope_on(self.branch, phase)
        sigma = ringing / (push * period) if system.contact.holds(Result.FEEDBACK) else np.zeros_like(phase)
        beta = system.contact.velocity_factors(heights.restitution(y))
        return quadratic_coefficients(system.d, beta, period, sigma, slope / push)


def _factor(line: Line) -> float:
    """The height that a mean load of 1 needs of the middle system's curve."""
    system = line.middle
    return line.condition_of(system.with_load(system.load.with_mean(1.0))).level


def by_phase(line: Line, heights: Heights) -> tuple[list[Fold], list[Stretch]]:
    system = line.middle
    arcs = line.condition(0.5 * (line.low + line.high)).arcs
    low = line.low if line.low > 0.0 or line.name == "restitution" else _FIRST * line.high
    folds: list[Fold] = []
    stretches: list[Stretch] = []
    if system.load.mean <= 0.0 and line.name in ("restitution", "amplitude"):
        return folds, stretches
    if _factor(line) == 0.0 and line.name != "restitution":
        return folds, stretches  # nothing is lost at the impact: the level is 0 for every load
    least, most = sorted(float(h) for h in heights.of(np.array([low, line.high])))
    v = arcs.velocities
    for j in range(v.size - 1):
        turns = (v[j] - v[j - 1 if j else -2]) * (v[j + 1] - v[j]) < 0.0
        if turns and least <= v[j] <= most:
            y = float(heights.y(v[j : j + 1])[0])
            miss = heights.y(2.0 * v[j : j + 1] - heights.of(np.array([y])))  # where twice the error would lead
            folds.append(Fold(y, float(on_circle(arcs.ends[j])), j, abs(float(miss[0]) - y)))
        bottom, top = max(min(v[j], v[j + 1]), least), min(max(v[j], v[j + 1]), most)
        if bottom < top:
            ends = [phase_at(arcs, j, h) for h in (bottom, top)]
            stretches.append(PhaseStretch(line, j, min(ends), max(ends), heights, arcs))
    return folds, stretches
