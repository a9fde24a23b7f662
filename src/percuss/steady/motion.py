"""The motion of a bar that strikes once in m load periods: its speeds and its fields at any place and time."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
import numpy.typing as npt

from percuss.halting import look
from percuss.model import Modes, System
from percuss.model.checks import Array, array
from percuss.shown import Shown
from percuss.steady.harmonic import Field
from percuss.steady.impact_state import ModalState, modal_state
from percuss.steady.oscillator import free_sum, phi1, phi2, propagator
from percuss.steady.phases import forced_response
from percuss.steady.response import Response
from percuss.steady.truncation import Truncation, truncation

__all__ = ["Motion"]


@dataclass(frozen=True)
class Motion(Shown):
    """What an `Orbit` is before anything is asked of it: the sums over the modes; see there for the parameters."""

    system: System
    periods: int
    phase: float
    fold: bool = False
    requested_modes: int | None = None
    tolerance: float = 1e-10

    # -- how it is computed --

    @cached_property
    def response(self) -> Response:
        """The forced response of the bar."""
        return forced_response(self.system)

    @cached_property
    def truncation(self) -> Truncation:
        """The modes kept, and what is known of the others."""
        return truncation(self)

    @property
    def modes(self) -> int:
        """N, the number of elastic modes in the sums."""
        return self.truncation.modes

    @property
    def error_bound(self) -> float:
        """Bound of the error of the striking end's position that the left-out modes make, relative to the stroke."""
        return self.truncation.error_bound

    @cached_property
    def state(self) -> ModalState:
        """The elastic modes at the impact."""
        return self.truncation.state

    def modal_state(self, modes: int) -> ModalState:
        """The elastic modes 1 … `modes` at the impact, however many the sums use."""
        known: ModalState | None = self.__dict__.get("_longest")
        if known is None or known.omega.size < modes:
            f, velocity = self.response.modal(modes, np.array([self.phase]))
            known = modal_state(self.system, self.period, (f[:, 0], velocity[:, 0]))
            self.__dict__["_longest"] = known
        return known.first(modes)

    @property
    def continuum(self) -> tuple[float, float] | None:
        """First and last of the phases (rad) that are all impact phases, where v_f stays at the level; or None.

        That is so under a load of steps where one step just keeps up v_f. Every phase between has its motion.
        """
        return self.response.plateau(self.phase) if self.fold else None

    @property
    def cut(self) -> bool:
        """Whether the forced part ends with the modes of the sums, too: those of a bar of so many modes."""
        return self.requested_modes is not None

    # -- speeds and energies --

    @property
    def period(self) -> float:
        """T = 2πm, from impact to impact."""
        return 2.0 * math.pi * self.periods

    @cached_property
    def rebasing(self) -> float:
        """How far an impact moves the bar as a whole against its striking end, dimensionless.

        By Σ γ_n (u_n⁺ − u_n⁻), as the striking end stays at the wall; 0 when the strain is kept.
        """
        if self.system.contact.keeps_strain:
            return 0.0
        return (self.system.contact.strain_factor - 1.0) * float(self._end_rows[0] @ self.state.displacement)

    @property
    def rigid_velocity(self) -> float:
        """Mean velocity of the bar just before the impact: w_0 = p_0 T/(1 + R) whatever the damping (B77)."""
        system = self.system
        dragged = system.d * self.rebasing if system.d > 0.0 else 0.0  # over the period the bar moves as far
        return (system.push * self.period - dragged) / system.contact.impulse

    @property
    def rigid_rebound(self) -> float:
        """Mean velocity of the bar just after the impact."""
        return self.system.contact.velocity_factor * self.rigid_velocity

    @cached_property
    def impact_velocity(self) -> float:
        """Striking speed u_t(1, 0⁻) of the striking end."""
        forced = self.response.end_velocity(self.phase, self.modes, cut=self.cut)
        free = self.state.velocity - self.state.forced_velocity
        return self.rigid_velocity + forced + float(self._end_rows[0] @ free)

    @property
    def rebound_velocity(self) -> float:
        """Velocity u_t(1, 0⁺) = −R u_t(1, 0⁻) of the striking end just after the impact."""
        return self.system.contact.velocity_factor * self.impact_velocity

    @property
    def blow_energy(self) -> float:
        """Kinetic energy ½ ∫ u_t² dx just before the impact, all modes."""
        return 0.5 * self.rigid_velocity**2 + float(np.sum(0.5 * self._weight * self.state.velocity**2))

    @property
    def strain_energy(self) -> float:
        """Strain energy just before the impact, of the modes of the sums."""
        return float(np.sum(0.5 * self._weight * (self.state.omega * self.state.displacement) ** 2))

    @property
    def delivered_energy(self) -> float:
        """What the impact takes: (1 − R²) times the blow energy, and of the strain energy if it changes the strain."""
        return self.system.contact.energy_taken(self.blow_energy, self.strain_energy)

    @cached_property
    def rigid_stroke(self) -> float:
        """Range of the mean motion over the impact period: the scale of all relative errors."""
        t, pushed, faded = _looks(self.system.d, self.periods)
        if not self.system.body.is_free:  # the range of the contact itself
            return float(np.ptp(self.end_motion(t, self.modes)[0])) or 1.0
        contact, mean = self.system.contact, self.system.load.mean
        start = contact.velocity_factor * (mean * self.period / contact.impulse) - self._rigid_start[1]
        moved = self.response.rigid_displacement(self.phase + t) + mean * pushed + start * faded
        return float(np.ptp(moved)) or 1.0

    # -- motion --

    def displacement(self, x: npt.ArrayLike, t: npt.ArrayLike) -> Array:
        """u(x, t), with the wall at u = 0; shape (len(x), len(t))."""
        return self.field(x, t).displacement

    def velocity(self, x: npt.ArrayLike, t: npt.ArrayLike) -> Array:
        """u_t(x, t); after the impact at t = 0, before the next one at t = T. Shape (len(x), len(t))."""
        return self.field(x, t).velocity

    def strain(self, x: npt.ArrayLike, t: npt.ArrayLike) -> Array:
        """u_x(x, t), negative in compression; shape (len(x), len(t))."""
        return self.field(x, t).strain

    def end_point(self, t: npt.ArrayLike) -> Array:
        """Gap function y(t) = u(1, t): 0 at the impacts, negative between them. Shape (len(t),)."""
        return np.asarray(self.displacement(1.0, t)[0])

    def driven_end(self, t: npt.ArrayLike) -> Array:
        """u(0, t), shape (len(t),)."""
        return np.asarray(self.displacement(0.0, t)[0])

    def impact_field(self, x: npt.ArrayLike) -> Array:
        """u_t(x, 0⁻), the velocity along the bar just before the impact; shape (len(x),)."""
        positions = array("x", x, 0.0, 1.0)
        rows = self.system.body.driven_shapes(positions, self.modes, self.system.load.at).displacement
        forced = self.forced_elastic(positions, np.array([self.phase])).velocity[:, 0]
        transient = self.state.velocity - self.state.forced_velocity
        return np.asarray(self.rigid_velocity + forced + rows @ transient)

    def field(self, x: npt.ArrayLike, t: npt.ArrayLike) -> Field:
        """Displacement, velocity and strain together; each of shape (len(x), len(t))."""
        positions, given = array("x", x, 0.0, 1.0), array("t", t, -np.inf, np.inf)
        times = np.mod(given, self.period)
        times = np.where((given != 0.0) & (times == 0.0), self.period, times)
        rigid, rigid_velocity = self.rigid_motion(times)
        forced = self.forced_elastic(positions, self.phase + times)
        rows = np.concatenate(self.system.body.driven_shapes(positions, self.modes, self.system.load.at))
        z, z_velocity = self._free_sum(times, rows)
        n = positions.size
        return Field(
            self._offset + rigid + forced.displacement + z[:n],
            rigid_velocity + forced.velocity + z_velocity[:n],
            forced.strain + z[n:],
        )

    def rigid_motion(self, t: Array) -> tuple[Array, Array]:
        """Displacement since the impact and velocity of the mean of the bar; each of the shape of `t`."""
        theta, (drift, drift_velocity) = self.phase + t, self._drift(t)
        moved = self.response.rigid_displacement(theta) - self._rigid_start[0]
        return moved + drift, self.response.rigid_velocity(theta) + drift_velocity

    def _drift(self, t: Array) -> tuple[Array, Array]:
        """What the mean load and the impact add to the periodic rigid motion, and its velocity."""
        d, mean = self.system.d, self.system.push
        start = self.rigid_rebound - self._rigid_start[1]
        fade = t * phi1(d * t)
        return mean * t**2 * phi2(d * t) + start * fade, mean * fade + start * np.exp(-d * t)

    @cached_property
    def _rigid_start(self) -> tuple[float, float]:
        """Periodic displacement and velocity of the rigid motion at the impact phase."""
        here = np.array([self.phase])
        return float(self.response.rigid_displacement(here)[0]), float(self.response.rigid_velocity(here)[0])

    def _free_sum(self, t: Array, rows: Array) -> tuple[Array, Array]:
        state = self.state
        return free_sum(state.omega, self._known.damping, (state.z, state.z_velocity), t, rows)

    def transient(self, t: Array) -> tuple[Array, Array]:
        """z_n(t) and z_n'(t), the free part of the elastic modes; each of shape (modes, len(t))."""
        state = self.state
        step = propagator(state.omega[:, None], self._known.damping[:, None], t[None, :])
        z, v = state.z[:, None], state.z_velocity[:, None]
        return step.a * z + step.b * v, step.c * z + step.e * v

    def forced_elastic(self, x: Array, theta: Array) -> Field:
        """Elastic part of the forced motion at load phases `theta`; each of shape (len(x), len(θ))."""
        return self.response.elastic(x, theta, self.modes, cut=self.cut)

    def end_motion(self, t: Array, modes: int) -> tuple[Array, Array]:
        """Gap function and its velocity with the first `modes` modes of the sums only; each of shape (len(t),)."""
        look()
        forced, forced_velocity = self._forced_end(t, modes)
        drift, drift_velocity = self._drift(t)
        rows = self._end_rows[:, :modes]
        z, z_velocity = self._free_sum(t, rows)
        known: dict[int, float] = self.__dict__.setdefault("_starts", {})
        if modes not in known:
            known[modes] = float(self._forced_end(np.zeros(1), modes)[0][0] + rows[0] @ self.state.z[:modes])
        return forced + drift + z[0] - known[modes], forced_velocity + drift_velocity + z_velocity[0]

    def _forced_end(self, t: Array, modes: int) -> tuple[Array, Array]:
        return self.response.end_motion(self.phase + t, modes, cut=self.cut)

    @cached_property
    def _known(self) -> Modes:
        return self.system.body.modes(self.modes, self.system.load.at)

    @cached_property
    def _weight(self) -> Array:
        return self._known.weight

    @cached_property
    def _end_rows(self) -> Array:
        """γ_n, by which the modes move the striking end; shape (1, modes)."""
        return self._known.gamma[None, :]

    @cached_property
    def _offset(self) -> float:
        """Where the wall stands: B77's arbitrary constant, from y(0⁺) = 0."""
        forced = self.forced_elastic(np.array([1.0]), np.array([self.phase])).displacement[0, 0]
        return -float(forced + (self._end_rows @ self.state.z)[0])


@lru_cache(maxsize=32)
def _looks(d: float, periods: int) -> tuple[Array, Array, Array]:
    """Times over an impact period, and what a unit mean load and a unit start velocity have moved by then."""
    t = np.linspace(0.0, 2.0 * math.pi * periods, 64 * periods + 1)
    looks = t, np.asarray(t**2 * phi2(d * t)), np.asarray(t * phi1(d * t))
    for values in looks:
        values.setflags(write=False)
    return looks
