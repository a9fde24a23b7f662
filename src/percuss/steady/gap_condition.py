"""Which load phases are impact phases of a body that is held: the contact reaches the wall there.

For impacts every T = 2πm at the phase φ the modes have one state each, and the contact is at

    y(φ) = Σ γ_n [f_n(φ) − (1 + R) c_n f_n'(φ)],    c_n = [(I − DΦ_n(T))⁻¹]_12,

just before an impact; y(φ) = g then says when. Under harmonics this is a sum of waves with those of the load, all of
whose roots are found, as for the single oscillators of Shaw & Holmes (J. Sound Vib. 90 (1983) 129–155) and of Budd &
Dux (Phil. Trans. R. Soc. A 347 (1994) 365–389), which it is for one mode. Under steps it is smooth on each of them, and
bounds of its derivatives leave no root out.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Protocol

import numpy as np

from percuss.halting import look
from percuss.model import System
from percuss.model.checks import Array, ComplexArray
from percuss.steady.harmonic import HarmonicResponse
from percuss.steady.impact_state import modal_state
from percuss.steady.oscillator import propagator
from percuss.steady.phases import Arcs, forced_response
from percuss.steady.piecewise import PiecewiseResponse

__all__ = ["FREE_AMPLITUDE", "GapCondition", "gap_condition"]

FREE_AMPLITUDE = (
    "a mode comes back by itself after every impact period, so that its amplitude is free (internal resonance): give "
    "it some damping"
)
_NARROWEST = 1e-9  # rad: the width of a cell in which a root is double
_TOUCH = 1e-13


class GapCondition(Protocol):
    """The curve that meets the gap at the impact phases."""

    @property
    def highest(self) -> float:
        """Its greatest value: no motion exists beyond."""
        ...

    def value(self, phases: Array) -> Array:
        """y(φ); shape of `phases`."""
        ...

    def roots(self) -> tuple[Array, Array]:
        """All impact phases, increasing, and whether each is a fold."""
        ...


@lru_cache(maxsize=16)
def gap_condition(system: System, periods: int, modes: int) -> GapCondition | None:
    """The condition for impacts once in `periods` load periods; None in internal resonance."""
    period, response = 2.0 * math.pi * periods, forced_response(system)
    nothing, one = np.zeros(modes), np.ones(modes)
    answer = modal_state(system, period, (nothing, one))
    gamma = system.body.modes(modes, system.load.at).gamma
    if np.any((answer.velocity == 0.0) & (gamma != 0.0)):  # so it is told by `modal_state`
        return None
    moving = gamma * answer.displacement  # γ_n times −(1 + R) c_n
    if isinstance(response, PiecewiseResponse):
        return _Stepped(response, gamma, moving)
    harmonics = response.by_harmonics
    gains, k = harmonics.gains(modes), harmonics.k
    still = system.load.mean * float(gamma @ (1.0 / answer.omega**2))
    waves = (gamma @ gains + 1j * k * (moving @ gains)) * harmonics.p
    return _Waves(Arcs.of(_Curve(system, np.asarray(waves))), still, system.body.gap)


class _Curve(HarmonicResponse):
    """The response with the curve in place of its rigid velocity, for `Arcs`."""

    def __init__(self, system: System, waves: ComplexArray) -> None:
        super().__init__(system)
        self.rigid_factor = waves

    def rigid_bounds(self) -> tuple[float, float]:
        """A bound of the curve, which rounding is measured by."""
        return float(np.abs(self.rigid_factor).sum()), 0.0


@dataclass(frozen=True)
class _Waves:
    """The curve under harmonics: waves about `still`, its place under the mean load."""

    arcs: Arcs
    still: float
    gap: float

    @property
    def highest(self) -> float:
        return self.arcs.highest + self.still

    def value(self, phases: Array) -> Array:
        return self.arcs.response.rigid_velocity(phases) + self.still

    def roots(self) -> tuple[Array, Array]:
        return self.arcs.roots(self.gap - self.still)


@dataclass(frozen=True)
class _Stepped:
    """The curve under steps: modes that swing about a constant place on each of them."""

    response: PiecewiseResponse
    gamma: Array
    moving: Array

    @property
    def highest(self) -> float:
        """Of 4096 samples."""
        return float(self.value(np.linspace(0.0, 2.0 * math.pi, 4096, endpoint=False)).max())

    def value(self, phases: Array) -> Array:
        f, rate = self.response.modal(self.gamma.size, phases)
        return np.asarray((self.gamma @ f + self.moving @ rate).reshape(np.shape(phases)))

    def roots(self) -> tuple[Array, Array]:
        response, found, folds = self.response, [], []
        for i, (start, length) in enumerate(zip(response.starts, response.lengths, strict=True)):
            roots, double = self._on_step(i, float(start), float(length))
            found += roots
            folds += double
        phases, tangent = np.mod(np.array(found), 2.0 * math.pi), np.array(folds, dtype=bool)
        order = np.argsort(phases)
        return phases[order], tangent[order]

    def _at(self, i: int, since: Array) -> tuple[Array, Array]:
        """y − g and its derivative on a step, so long after its beginning."""
        n, system = self.gamma.size, self.response.system
        known = system.body.modes(n, system.load.at)
        omega, d = known.omega[:, None], known.damping[:, None]
        step = propagator(omega, d, since[None, :])
        u, v = (row[i][:, None] for row in self.response.knots(n))
        away, rate = step.a * u + step.b * v, step.c * u + step.e * v
        place = away + float(self.response.values[i]) / omega**2
        turn = -d * rate - omega**2 * away
        return self.gamma @ place + self.moving @ rate - system.body.gap, self.gamma @ rate + self.moving @ turn

    def _on_step(self, i: int, start: float, length: float) -> tuple[list[float], list[bool]]:
        """The roots on one step: cells are halved until bounds of y'' decide, or until they are next to nothing."""
        n, system = self.gamma.size, self.response.system
        known = system.body.modes(n, system.load.at)
        u, v = (row[i] for row in self.response.knots(n))
        size = np.hypot(u, v / known.omega)  # never grows
        rise = known.omega**2 + known.damping * known.omega
        bend = float(np.sum(size * rise * (np.abs(self.gamma) + np.abs(self.moving) * (known.omega + known.damping))))
        scale = float(np.sum(size * (np.abs(self.gamma) + np.abs(self.moving) * known.omega))) + abs(system.body.gap)
        half = 0.5 * length / 64
        centres: Array = np.asarray(half * (2.0 * np.arange(64) + 1.0), dtype=float)
        found: list[float] = []
        folds: list[bool] = []
        while centres.size:
            look()
            y, slope = self._at(i, centres)
            clear = np.abs(y) > np.abs(slope) * half + 0.5 * bend * half**2
            steep = ~clear & (np.abs(slope) > bend * half)
            for centre in centres[steep]:
                found += self._crossing(i, float(centre) - half, float(centre) + half, start)
            folds += [False] * (len(found) - len(folds))
            open_ = centres[~clear & ~steep]
            if half < _NARROWEST:
                near = open_[np.abs(self._at(i, open_)[0]) <= 0.5 * bend * half**2 + _TOUCH * scale]
                for centre in near:
                    if not found or abs(start + centre - found[-1]) > 4.0 * _NARROWEST:
                        found.append(start + float(centre))
                        folds.append(True)
                break
            half *= 0.5
            centres = np.sort(np.concatenate([open_ - half, open_ + half]))
        return found, folds

    def _crossing(self, i: int, low: float, high: float, start: float) -> list[float]:
        """The root in a cell in which the curve is monotone, its left end counted; none or one."""
        ends = self._at(i, np.array([low, high]))[0]
        if not (ends[0] == 0.0 or ends[0] * ends[1] < 0.0):
            return []
        for _ in range(60):
            middle = 0.5 * (low + high)
            y = float(self._at(i, np.array([middle]))[0][0])
            low, high = (middle, high) if (y < 0.0) == (ends[0] < 0.0) and ends[0] != 0.0 else (low, middle)
        return [start + 0.5 * (low + high)]
