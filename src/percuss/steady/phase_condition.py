"""Which load phases are impact phases: the roots of v_f = c (B77 14), for every contact law.

Over an impact period the bar as a whole comes back to where it was just after the impact. A law that changes the strain
moves it there by a = Σ γ_n (u_n⁺ − u_n⁻), as the striking end stays at the wall, so that (14) becomes

    v_f(φ) + a(φ) [d/(1 − e^{−dT}) − dR/(1 + R)] = c

where a is linear in the load: under harmonics the left side is a sum of waves again, and all of its roots are found.
Its size is that of the elastic motion over the rigid one, 1/s².
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from percuss.model import System
from percuss.model.checks import Array, ComplexArray
from percuss.steady.harmonic import HarmonicResponse
from percuss.steady.impact_state import modal_state
from percuss.steady.level import level_of
from percuss.steady.oscillator import phi1
from percuss.steady.phases import Arcs, forced_response
from percuss.steady.response import Response
from percuss.steady.trigonometric import on_circle
from percuss.steady.truncation import RELEASED_MODES

__all__ = ["PhaseCondition", "phase_condition"]

_STEPS = 60
_EPS = float(np.finfo(float).eps)


@dataclass(frozen=True)
class PhaseCondition:
    """The curve that meets a level at the impact phases.

    Parameters
    ----------
    arcs
        The arcs of the circle on which the curve is monotone.
    level
        c, less what the mean load adds to the curve.
    """

    arcs: Arcs
    level: float

    def roots(self) -> tuple[Array, Array]:
        """All impact phases, increasing, and whether each is a fold."""
        return self.arcs.roots(self.level)


@dataclass(frozen=True)
class _Polished(PhaseCondition):
    """The roots of B77 (14), each followed to the phase that a law which changes the strain asks for."""

    system: System
    period: float
    modes: int

    def roots(self) -> tuple[Array, Array]:
        phases, folds = self.arcs.roots(self.level)
        found = np.array([self._followed(float(phase)) for phase in phases], dtype=float)
        kept = np.isfinite(found)
        order = np.argsort(found[kept])
        return on_circle(found[kept])[order], folds[kept][order]

    def _off(self, phase: float) -> float:
        here = np.array([phase])
        moved = _rebasing(self.system, self.period, self.modes, phase)
        velocity = float(self.arcs.response.rigid_velocity(here)[0])
        return velocity - self.level + moved * _weight(self.system, self.period)

    def _followed(self, phase: float) -> float:
        """By the secant method; NaN where it leads nowhere, as beside a fold."""
        before, off_before = phase, self._off(phase)
        slope = float(np.asarray(forced_response(self.system).rigid_acceleration(np.array([phase])))[0])
        if off_before == 0.0 or slope == 0.0:
            return phase if off_before == 0.0 else math.nan
        now = phase - off_before / slope
        noise = 64.0 * _EPS * (abs(self.level) + self.arcs.response.rigid_bounds()[0])
        for _ in range(_STEPS):
            off = self._off(now)
            if abs(off) <= noise or off == off_before:
                return now if abs(off) <= 1e3 * noise else math.nan
            before, now, off_before = now, now - off * (now - before) / (off - off_before), off
            if not abs(now - phase) < math.pi:
                return math.nan
        return math.nan


def phase_condition(system: System, periods: int, modes: int | None = None) -> PhaseCondition:
    """The condition for impacts once in `periods` load periods, of the bar with `modes` modes or with all of them."""
    period = 2.0 * math.pi * periods
    response = forced_response(system)
    level = level_of(system, period)
    n = RELEASED_MODES if modes is None else modes
    if system.contact.keeps_strain or n == 0:
        return PhaseCondition(Arcs.of(response), level)
    if not response.is_smooth:
        return _Polished(Arcs.of(response), level, system, period, n)
    curve, raised = _rebased(system, period, n)
    return PhaseCondition(Arcs.of(curve), level - raised)


class _Rebased(HarmonicResponse):
    """The response with what the rebasing adds to the waves of its rigid velocity, for `Arcs`."""

    def __init__(self, system: System, added: ComplexArray) -> None:
        super().__init__(system)
        self.rigid_factor = self.rigid_factor + added


@lru_cache(maxsize=32)
def _rebased(system: System, period: float, modes: int) -> tuple[Response, float]:
    """The curve under harmonics, and what the mean load adds to it."""
    response = forced_response(system).by_harmonics
    gain, k = response.gains(modes), response.k
    change = system.contact.strain_factor - 1.0
    gamma = system.body.modes(modes, system.load.at).gamma
    # the displacement before the impact per unit of forced displacement, and of forced velocity
    nothing, one = np.zeros(modes), np.ones(modes)
    still = gamma * modal_state(system, period, (one, nothing)).displacement
    moving = gamma * modal_state(system, period, (nothing, one)).displacement
    each = change * _weight(system, period) * (still @ gain + 1j * k * (moving @ gain))
    raised = change * _weight(system, period) * float(still @ (1.0 / system.body.modes(modes).omega ** 2))
    return _Rebased(system, each * response.p), raised * system.load.mean


def _rebasing(system: System, period: float, modes: int, phase: float) -> float:
    """a(φ), of so many modes."""
    f, velocity = forced_response(system).modal(modes, np.array([phase]))
    state = modal_state(system, period, (f[:, 0], velocity[:, 0]))
    change = system.contact.strain_factor - 1.0
    return change * float(system.body.modes(modes, system.load.at).gamma @ state.displacement)


def _weight(system: System, period: float) -> float:
    """What a unit of a adds to v_f in (14): 1/T without damping."""
    d, contact = system.d, system.contact
    return 1.0 / (period * float(phi1(d * period))) + d * contact.velocity_factor / contact.impulse
