"""One flight of an orbit, from impact to impact: the motion of the striking end, for the proof that it stays off."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from percuss.halting import look
from percuss.model import System
from percuss.model.checks import Array
from percuss.steady.impact_state import ModalState
from percuss.steady.oscillator import free_sum, phi1, phi2
from percuss.steady.phases import forced_response
from percuss.steady.response import Response
from percuss.steady.truncation import Truncation

__all__ = ["Flight", "state_at"]

_SAMPLES = 64


def state_at(omega: Array, before: tuple[Array, Array], forced: tuple[Array, Array], system: System) -> ModalState:
    """The elastic modes at an impact, from u_n, u_n' just before it and from f_n, f_n'; shapes (N,)."""
    (u, v), (f, forced_velocity) = before, forced
    after, rate = system.contact.after(u, v)
    return ModalState(omega, u, v, after, after - f, rate - forced_velocity, forced_velocity, np.ones_like(omega))


@dataclass(frozen=True)
class Flight:
    """A flight from any state at the wall; times in radians of the load after the impact that it starts from.

    Parameters
    ----------
    system, modes
        The bar of modes 0 … N.
    phase
        Load phase at its start.
    period
        Its duration.
    state
        The elastic modes at the impact that it starts from.
    rigid_rebound
        Mean velocity of the bar at its start.
    rebound_velocity, impact_velocity
        Velocity of the striking end at its start, and at its end.
    rigid_stroke
        Range of the mean motion over the whole orbit, the scale of errors.
    """

    system: System
    modes: int
    phase: float
    period: float
    state: ModalState
    rigid_rebound: float
    rebound_velocity: float
    impact_velocity: float
    rigid_stroke: float

    @property
    def periods(self) -> int:
        """The load periods that it takes, rounded up."""
        return max(1, math.ceil(self.period / (2.0 * math.pi)))

    @property
    def requested_modes(self) -> int:
        """N: the bar has no other modes."""
        return self.modes

    @property
    def cut(self) -> bool:
        """The forced part ends with the modes, too."""
        return True

    @property
    def tolerance(self) -> float:
        """Wanted error of the striking end's position: none."""
        return 0.0

    @property
    def error_bound(self) -> float:
        """Nothing is left out."""
        return 0.0

    @cached_property
    def response(self) -> Response:
        """The forced response of the bar."""
        return forced_response(self.system)

    @cached_property
    def truncation(self) -> Truncation:
        """All modes, at every look."""
        return Truncation(self, self.modes, self.modes, self.modes, self.state, 0.0)

    def modal_state(self, modes: int) -> ModalState:
        """The first elastic modes at the impact that it starts from."""
        return self.state.first(modes)

    def end_motion(self, t: Array, modes: int) -> tuple[Array, Array]:
        """Gap function and its velocity with the first `modes` elastic modes; each of shape (len(t),)."""
        look()
        forced, forced_velocity = self.response.end_motion(self.phase + t, modes, cut=True)
        drift, drift_velocity = self._drift(t)
        known = self.system.body.modes(self.modes, self.system.load.at)
        rows = known.gamma[None, :modes]
        z, z_velocity = free_sum(known.omega, known.damping, (self.state.z, self.state.z_velocity), t, rows)
        start = self.response.end_motion(np.array([self.phase]), modes, cut=True)[0][0] + rows[0] @ self.state.z[:modes]
        return forced + drift + z[0] - start, forced_velocity + drift_velocity + z_velocity[0]

    def _drift(self, t: Array) -> tuple[Array, Array]:
        """What the mean load and the start add to the periodic rigid motion, and its velocity."""
        d, mean = self.system.d, self.system.push
        start = self.rigid_rebound - float(self.response.rigid_velocity(np.array([self.phase]))[0])
        fade = t * phi1(d * t)
        return mean * t**2 * phi2(d * t) + start * fade, mean * fade + start * np.exp(-d * t)

    def mean_range(self) -> float:
        """Range of the mean motion over the flight; of that of the contact itself where the body is held."""
        t = np.linspace(0.0, self.period, _SAMPLES * self.periods + 1)
        if not self.system.body.is_free:
            return float(np.ptp(self.end_motion(t, self.modes)[0]))
        return float(np.ptp(self.response.rigid_displacement(self.phase + t) + self._drift(t)[0]))
