"""One periodic motion with p impacts in n load periods, as a value: is it possible, where does the bar go?"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from percuss.model.checks import Array, array
from percuss.steady.admissible import Contactless, Violation, flight_check
from percuss.steady.periodic.flight import Flight
from percuss.steady.periodic.impact_motion import ImpactMotion
from percuss.steady.periodic.sameness import canonical, load_turn
from percuss.steady.periodic.sampled_flights import sampled_flights, samples_are_many
from percuss.steady.reason import Reason

__all__ = ["PeriodicOrbit"]


@dataclass(frozen=True)
class PeriodicOrbit(ImpactMotion):
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

    @property
    def from_first(self) -> PeriodicOrbit:
        """The same orbit told from the impact with the least phase of the load on, in the first period of the load."""
        turn = load_turn(self.system.load)
        moved, first = canonical(np.array(self.times), self.period, turn)
        kept = float(self.rigid_rebounds[first]) if self._chain.is_neutral else None
        return PeriodicOrbit(self.system, self.periods, tuple(moved.tolist()), self.modes, kept)

    # -- motion --

    @cached_property
    def flights(self) -> tuple[Flight, ...]:
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
        for i, flight in enumerate(self.flights):
            here = which == i
            if here.any():
                found[here] = flight.end_motion(times[here] - starts[i], self.modes)[0]
        return found

    # -- is it real --

    @cached_property
    def _contactless(self) -> tuple[Contactless, ...]:
        # the times of several impacts come from compiled functions, so that these need not be loaded for it
        if self.impacts > 1 and not samples_are_many(self) and sampled_flights(self).proven:
            return (Contactless(None),) * self.impacts
        return tuple(flight_check(flight) for flight in self.flights)

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
