"""The branches of steady motions along one parameter: curves of (y, phase) that are followed without folds in the way.

On an arc of the circle on which v_f is monotone there is at most one steady motion for every level (B77 14). Where the
parameter y moves only the level, or only the size of v_f, it is an explicit function of the phase, and the arc is
followed by its phase. Any other parameter moves the arcs themselves: then a branch is followed by y, between the folds
that end it.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from percuss.explore.boundary_curves.plane_lines import (
    FOLD,
    SAMPLES,
    BoundaryCrossing,
    Function,
    Line,
    MotionArc,
    phase_at,
    roots_on,
)
from percuss.explore.family import SystemFamily
from percuss.model.checks import Array
from percuss.stability.verdict import coefficients_at
from percuss.steady.forced import forced_response
from percuss.steady.phases import Arcs, level_at, ratio_at
from percuss.steady.trigonometric import on_circle

# ---- Branches along a parameter that moves the arcs of v_f themselves: d, κ, s, any quantity of a case

_MODES, _PEAKS = 64, 40  # modes whose resonances with the load are looked at, and the most of these


@dataclass(frozen=True)
class ParameterArc(MotionArc):
    """A branch between two values of y, which crowd toward both ends, where it may turn back in a fold."""

    _rows: dict[float, tuple[float, float, float]] = field(default_factory=dict, repr=False)

    def nodes(self, samples: int | None, inside: float, least: int = SAMPLES) -> Array:
        even = super().nodes(samples, inside, least)
        near = _near_resonances(self.line) if self.line.name == "s" and samples is None else np.empty(0)
        near = near[(near > self.start) & (near < self.stop)]
        t = 2.0 / np.pi * np.arcsin(np.sqrt((near - self.start) / (self.stop - self.start)))
        return np.unique(np.clip(np.concatenate([even, t]), inside, 1.0 - inside))

    def place(self, t: Array) -> tuple[Array, Array]:
        y = self._y(t)
        return y, np.array([self._found(value)[1] for value in y.reshape(-1).tolist()]).reshape(y.shape)

    def quadratic(self, t: Array) -> tuple[Array, Array, Array]:
        return tuple(np.array(row) for row in zip(*(self._row(y) for y in self._y(t).tolist()), strict=True))  # type: ignore[return-value]

    def _y(self, t: Array) -> Array:
        return np.asarray(self.start + (self.stop - self.start) * np.sin(0.5 * np.pi * np.asarray(t)) ** 2)

    def _found(self, y: float) -> tuple[Arcs, float]:
        """The arcs at y, and the phase on this branch's; beyond a fold by rounding, the fold's."""
        arcs, level = self.line.condition(y).arcs, self.line.condition(y).level
        low, high = sorted(arcs.velocities[self.branch : self.branch + 2])
        height = min(max(level, float(low)), float(high))
        return arcs, float(on_circle(np.array(phase_at(arcs, self.branch, height))))

    def _row(self, y: float) -> tuple[float, float, float]:
        if y not in self._rows:
            arcs, phase = self._found(y)
            system, place = arcs.response.system, np.array([phase])
            mean, beta = np.array([system.load.mean]), np.array([system.contact.velocity_factor])
            slope = forced_response(system).slope_on(self.branch, place)
            _, _, row = coefficients_at(system, self.line.period, place, mean, beta, slope)
            self._rows[y] = (float(row[0][0]), float(row[1][0]), float(row[2][0]))
        return self._rows[y]


def _near_resonances(line: Line) -> Array:
    """Wave speeds on both sides of those at which ω_n = k, where σ has a narrow peak (B77 16): k/(nπ), uniform bar."""
    body = line.middle.body
    per_speed = body.frequencies(_MODES) / body.s  # ω_n goes with s
    found = (line.middle.load.harmonics[:, None] / per_speed).reshape(-1)
    places = np.sort(found[(found >= line.low) & (found <= line.high)])[-_PEAKS:]
    return np.asarray(np.concatenate([places * (1.0 + sign * 10.0**-j) for j in range(1, 6) for sign in (-1.0, 1.0)]))


def by_parameter(line: Line, samples: int, folds_alone: bool) -> tuple[list[BoundaryCrossing], list[MotionArc]]:
    folds: list[BoundaryCrossing] = []
    stretches: list[MotionArc] = []
    for low, high, form in _same_form(line, _crowded(line.low, line.high, samples)):
        count = abs(form)
        excess, nodes = [_excess(line, form, j) for j in range(count)], _crowded(low, high, samples)
        turns = [roots_on(one, nodes) for one in excess]
        for j, found in enumerate(turns):
            folds += [fold for y in found.tolist() if (fold := _fold(line, y, j)) is not None]
        for j in range(count if not folds_alone else 0):
            both = np.unique(np.concatenate([[low, high], turns[j], turns[(j + 1) % count]]))
            for start, stop in pairwise(both.tolist()):
                middle = np.array([0.5 * (start + stop)])
                if float((excess[j](middle) * excess[(j + 1) % count](middle))[0]) < 0.0:
                    stretches.append(ParameterArc(line, j, start, stop))
    return folds, stretches


def _crowded(low: float, high: float, samples: int) -> Array:
    """Values that crowd toward both ends, which are among them."""
    return np.asarray(low + (high - low) * np.sin(0.5 * np.pi * np.linspace(0.0, 1.0, samples)) ** 2)


def _fold(line: Line, y: float, end: int) -> BoundaryCrossing | None:
    """The fold at an end of the arcs, unless v_f only has a kink there and goes on."""
    arcs, level = line.condition(y).arcs, line.condition(y).level
    v = arcs.velocities
    if (v[end] - v[end - 1 if end else -2]) * (v[end + 1] - v[end]) >= 0.0:
        return None
    step = 1e-6 * (line.high - line.low)
    around = [line.condition(value) for value in (max(y - step, line.low), min(y + step, line.high))]
    rise = [float(near.arcs.velocities[end]) - near.level for near in around]
    slope = (rise[1] - rise[0]) / (min(y + step, line.high) - max(y - step, line.low))
    off = abs(float(v[end]) - level)
    return _fold_at(arcs, end, y, off / abs(slope) if slope else math.nan)


def _fold_at(arcs: Arcs, end: int, y: float, off: float) -> BoundaryCrossing:
    return BoundaryCrossing(FOLD, end, y, float(on_circle(arcs.ends[end])), off, 0.0)


def _excess(line: Line, form: int, end: int) -> Function:
    """v_f at an end of the arcs less the level, of an array of y; NaN where the arcs have another form."""

    def excess(y: float) -> float:
        condition = line.condition(y)
        v = condition.arcs.velocities
        return float(v[end]) - condition.level if _form_of(v) == form else math.nan

    return lambda y: np.array([excess(value) for value in y.tolist()])


def _form(line: Line, y: float) -> int:
    """Number of arcs at y, negative when the first falls: it changes when an end passes phase 0, too; 0: no push."""
    load = line.system(y).load
    return 0 if load.is_constant or load.mean <= 0.0 else _form_of(line.condition(y).arcs.velocities)


def _form_of(velocities: Array) -> int:
    return (velocities.size - 1) * (1 if velocities[1] > velocities[0] else -1)


def _same_form(line: Line, nodes: Array) -> list[tuple[float, float, int]]:
    """The parts of the range on which the arcs keep their form: first and last value, and the form."""
    forms = [_form(line, y) for y in nodes.tolist()]
    parts: list[tuple[float, float, int]] = []
    start = float(nodes[0])
    for i in range(1, nodes.size):
        if forms[i] == forms[i - 1]:
            continue
        low, high = float(nodes[i - 1]), float(nodes[i])
        for _ in range(60):
            middle = 0.5 * (low + high)
            if not low < middle < high:
                break
            if _form(line, middle) == forms[i - 1]:
                low = middle
            else:
                high = middle
        parts.append((start, low, forms[i - 1]))
        start = high
    parts.append((start, float(nodes[-1]), forms[-1]))
    return [part for part in parts if part[1] > part[0] and part[2] != 0]


# ---- Branches along a parameter that is an explicit function of the impact phase: the load factor, R, mean, amplitude

_FIRST = 1e-12  # share of the range at which a load factor's range from 0 begins


@dataclass(frozen=True)
class Heights:
    """How y goes with the height of v_f of the middle system, both ways; `size`: its factor on the alternating load."""

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
        lambda y: y * scale * factor, lambda h: h / (scale * factor), lambda y: y * scale, constant(r), constant(1.0)
    )


@dataclass(frozen=True)
class PhaseArc(MotionArc):
    """A part of one arc of the circle, followed by the phase from `start` to `stop`."""

    heights: Heights = field(repr=False)
    arcs: Arcs = field(repr=False)

    def place(self, t: Array) -> tuple[Array, Array]:
        phase = self.start + (self.stop - self.start) * t
        y = self.heights.y(self.arcs.response.rigid_velocity(phase))
        return np.clip(y, self.line.low, self.line.high), on_circle(phase)

    def quadratic(self, t: Array) -> tuple[Array, Array, Array]:
        y, _ = self.place(t)
        phase = self.start + (self.stop - self.start) * t
        heights, system, period = self.heights, self.line.middle, self.line.period
        response, beta = forced_response(system), system.contact.velocity_factors(heights.restitution(y))
        slope = None if response.is_smooth else response.slope_on(self.branch, phase)
        return coefficients_at(system, period, phase, heights.mean(y) / heights.size(y), beta, slope)[2]


def _factor(line: Line) -> float:
    """The height that a mean load of 1 needs of the middle system's curve."""
    system = line.middle
    return line.condition_of(system.with_load(system.load.with_mean(1.0))).level


def by_phase(line: Line, heights: Heights) -> tuple[list[BoundaryCrossing], list[MotionArc]]:
    system = line.middle
    arcs = line.condition(0.5 * (line.low + line.high)).arcs
    low = line.low if line.low > 0.0 or line.name == "restitution" else _FIRST * line.high
    folds: list[BoundaryCrossing] = []
    stretches: list[MotionArc] = []
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
            folds.append(_fold_at(arcs, j, y, abs(float(miss[0]) - y)))
        bottom, top = max(min(v[j], v[j + 1]), least), min(max(v[j], v[j + 1]), most)
        if bottom < top:
            ends = [phase_at(arcs, j, h) for h in (bottom, top)]
            stretches.append(PhaseArc(line, j, min(ends), max(ends), heights, arcs))
    return folds, stretches


def folds_and_stretches(
    line: Line, samples: int, folds_alone: bool = False
) -> tuple[list[BoundaryCrossing], list[MotionArc]]:
    """All folds on a line, and all branches between them unless only folds are wanted."""
    heights = heights_of(line)
    return by_parameter(line, samples, folds_alone) if heights is None else by_phase(line, heights)
