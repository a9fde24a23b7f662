"""One periodic motion with p impacts in n load periods, as a value: is it possible, what does it carry?"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from percuss.errors import ParameterError
from percuss.model import System
from percuss.model.checks import Array, array, choice, finite, instance
from percuss.model.load import Side
from percuss.shown import Shown
from percuss.steady.admissible import Contactless, Violation, flight_check
from percuss.steady.impact_state import ModalState
from percuss.steady.periodic.flight import Flight, state_at
from percuss.steady.periodic.impact_chain import ImpactChain
from percuss.steady.periodic.linearised import bordered, eliminated
from percuss.steady.periodic.passage import Passage
from percuss.steady.reason import Reason

__all__ = ["PeriodicOrbit"]

TURN = 2.0 * math.pi


@dataclass(frozen=True)
class PeriodicOrbit(Shown):
    """A periodic motion z=p/n with p impacts in n load periods; made by `orbits` and `orbit_near`.

    An orbit is told by the times of its impacts; all else follows. Times are in radians of the load's fundamental, all
    quantities are dimensionless. The bar has the modes 0 … N, forced part included, exactly as a simulation with N
    modes moves: `Start.orbit` starts one just after the first impact.

    Parameters
    ----------
    system
        What moves.
    periods
        n.
    times
        t_1 < … < t_p < t_1 + 2πn, unwrapped; the first impact is that with the least phase of the load.
    modes
        N.
    rebound
        Mean velocity of the bar just after the first impact, where it does not follow from the times: R = 1, no drag
        and an even number of impacts. Else None.
    """

    system: System
    periods: int
    times: tuple[float, ...]
    modes: int
    rebound: float | None = None

    # -- the impacts --

    @property
    def impacts(self) -> int:
        """p."""
        return len(self.times)

    @property
    def label(self) -> str:
        """z=p/n."""
        return f"z={self.impacts}/{self.periods}"

    @property
    def period(self) -> float:
        """T = 2πn."""
        return TURN * self.periods

    @property
    def phases(self) -> Array:
        """Phase of the load at each impact, in [0, 2π); shape (p,)."""
        return np.mod(self.times, TURN)

    @property
    def flight_times(self) -> Array:
        """How long the bar flies after each impact; shape (p,)."""
        return self._passage.flights

    @property
    def speeds(self) -> Array:
        """Speed of the striking end just before each impact; shape (p,)."""
        return self._passage.speed

    @property
    def rebound_speeds(self) -> Array:
        """Speed with which the striking end leaves the wall after each impact: R times that before; shape (p,)."""
        return np.asarray(-self.system.contact.velocity_factor * self.speeds)

    @property
    def rigid_velocities(self) -> Array:
        """Mean velocity of the bar just before each impact; shape (p,)."""
        return self._passage.rigid

    @property
    def blow_energies(self) -> Array:
        """Kinetic energy of all modes just before each impact; shape (p,)."""
        weight = self._chain.known.weight
        return np.asarray(0.5 * self._passage.rigid**2 + 0.5 * self._passage.velocity**2 @ weight)

    @cached_property
    def states(self) -> tuple[ModalState, ...]:
        """The elastic modes at each impact, just before and just after it."""
        known, passage = self._chain.known, self._passage
        rows = zip(
            zip(passage.displacement, passage.velocity, strict=True),
            zip(passage.forced, passage.forced_velocity, strict=True),
            strict=True,
        )
        return tuple(state_at(known.omega, before, forced, self.system) for before, forced in rows)

    # -- just after the first impact, as for a steady motion --

    @property
    def phase(self) -> float:
        """Phase of the load at the first impact."""
        return float(self.phases[0])

    @property
    def rigid_velocity(self) -> float:
        """Mean velocity of the bar just before the first impact."""
        return float(self.rigid_velocities[0])

    def modal_state(self, modes: int) -> ModalState:
        """The first elastic modes at the first impact.

        Raises
        ------
        ParameterError
            When the orbit is one of a bar with fewer.
        """
        if modes > self.modes:
            raise ParameterError("modes", modes, f"at most {self.modes}, the modes of the orbit")
        return self.states[0].first(modes)

    # -- how it is computed --

    @cached_property
    def _chain(self) -> ImpactChain:
        return ImpactChain(self.system, self.impacts, self.periods, self.modes)

    @cached_property
    def _passage(self) -> Passage:
        return self._passage_on("right")

    def _passage_on(self, side: Side) -> Passage:
        rebound = None if self.rebound is None else np.array(self.rebound)
        return self._chain.passage(np.array(self.times), rebound, side)

    @property
    def residual(self) -> float:
        """How far the striking end is from the wall at the impacts, at most: rounding."""
        return float(max(np.abs(self._passage.gap).max(), abs(float(self._passage.closure))))

    def off(self, system: System) -> Array:
        """The equations for the times, with the times of this orbit and another system: 0 if it has this orbit, too.

        The p equations of the flights, and by how much the rigid velocity after the first impact changes in a cycle
        where it does not follow from the times. Shape (p + 1,).
        """
        chain = ImpactChain(instance("system", system, System), self.impacts, self.periods, self.modes)
        passage = chain.passage(np.array(self.times), None if self.rebound is None else np.array(self.rebound))
        return np.append(passage.gap, passage.closure)

    def linearised(self, xi: complex = 1.0, side: Side = "right") -> npt.NDArray[np.complex128] | Array:
        """K(ξ), which is singular where ξ is a multiplier of the orbit; shape (p, p).

        K(1) is the derivative of the p equations for the impact times, the matrix of Newton's method. A fold has
        det K(1) = 0, a flip det K(−1) = 0; nothing is divided by the speed of an impact.

        Parameters
        ----------
        xi
            ξ, real or complex.
        side
            Which value of the load counts where it jumps at an impact.
        """
        return eliminated(self.bordered(xi, side))

    def bordered(self, xi: complex = 1.0, side: Side = "right") -> npt.NDArray[np.complex128] | Array:
        """K(ξ) before the rigid velocity is eliminated, which is finite where that does not follow from the times.

        The last column belongs to a change of the mean velocity after the first impact, the last row says that it is ξ
        times itself after a cycle. Shape (p + 1, p + 1).

        Parameters
        ----------
        xi, side
            As for `linearised`.
        """
        choice("side", side, "left", "right")
        if not isinstance(xi, complex):
            xi = finite("xi", xi)
        passage = self._passage if side == "right" else self._passage_on(side)
        return bordered(self._chain, passage, xi)

    def modal_determinants(self, xi: complex = 1.0) -> npt.NDArray[np.complex128] | Array:
        """det(ξ − M_n), with M_n the map of mode n through the cycle with the times of the impacts held; shape (N,).

        Where one of them vanishes at ξ = 1 the amplitude of the mode is free: internal resonance.
        """
        if not isinstance(xi, complex):
            xi = finite("xi", xi)
        blocks = self._passage.blocks
        return np.asarray((xi - blocks.a) * (xi - blocks.e) - blocks.b * blocks.c)

    # -- motion --

    @cached_property
    def _flights(self) -> tuple[Flight, ...]:
        """The flights, with the range of the mean motion over all of them."""
        found = [self._flight(i, 1.0) for i in range(self.impacts)]
        stroke = max(flight.mean_range() for flight in found) or 1.0
        return tuple(self._flight(i, stroke) for i in range(self.impacts))

    def _flight(self, i: int, stroke: float) -> Flight:
        passage = self._passage
        return Flight(
            self.system,
            self.modes,
            phase=float(passage.times[i]),
            period=float(passage.flights[i]),
            state=self.states[i],
            rigid_rebound=float(passage.rebound[i]),
            rebound_velocity=-float(self.rebound_speeds[i]),
            impact_velocity=float(passage.speed[(i + 1) % self.impacts]),
            rigid_stroke=stroke,
        )

    def end_point(self, t: npt.ArrayLike) -> Array:
        """Gap function y(t) = u(1, t) at times after the first impact: 0 at impacts, negative between. Shape (len(t),).

        Times beyond a cycle are taken back into it.
        """
        times = np.mod(array("t", t, -np.inf, np.inf), self.period)
        starts = np.array(self.times) - self.times[0]
        which, found = np.searchsorted(starts, times, side="right") - 1, np.empty_like(times)
        for i, flight in enumerate(self._flights):
            here = which == i
            if here.any():
                found[here] = flight.end_motion(times[here] - starts[i], self.modes)[0]
        return found

    # -- is it real --

    @cached_property
    def _contactless(self) -> tuple[Contactless, ...]:
        return tuple(flight_check(flight) for flight in self._flights)

    @cached_property
    def violation(self) -> Violation | None:
        """Where the bar would first pass through the wall within a flight, in rad after the first impact; or None."""
        for start, found in zip(self.times, self._contactless, strict=True):
            if found.violation is not None:
                return Violation(start - self.times[0] + found.violation.time, found.violation.depth)
        return None

    @property
    def proven(self) -> bool:
        """Whether the absence of a contact between the impacts, or the first one, is proved."""
        return all(found.proven for found in self._contactless)

    @property
    def obstacle(self) -> Reason | None:
        """Why the motion is not physical: `Reason.NO_BLOW` or `Reason.THROUGH_WALL`; None for one that is."""
        if not np.all(self.speeds > 0.0):
            return Reason.NO_BLOW
        return None if self.violation is None else Reason.THROUGH_WALL

    @property
    def admissible(self) -> bool:
        """Whether the motion is physical: each impact strikes forward, and y < 0 between impacts."""
        return self.obstacle is None

    @property
    def resonant_modes(self) -> tuple[int, ...]:
        """Modes n that come back after a cycle by themselves, so that their amplitude is free: internal resonance."""
        return tuple(int(n) + 1 for n in np.flatnonzero(self._passage.resonant))

    def __str__(self) -> str:
        phases = ", ".join(f"{phase:.6f}" for phase in self.phases[:4])
        more = ", …" if self.impacts > 4 else ""
        where = "admissible" if self.admissible else f"not admissible ({self.obstacle.value if self.obstacle else ''})"
        return f"PeriodicOrbit {self.label}: phases {phases}{more} rad, {where}, {self.modes} modes"
