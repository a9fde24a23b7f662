"""The flight of a bar as a whole between two blows that take time, and whether it passes the plane of the next one.

Decided with bounds: a cell of time is dropped only when Taylor's theorem, with a bound of the acceleration, proves that
the bar stays off.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from percuss.model import System
from percuss.model.checks import Array
from percuss.steady.admissible import Violation
from percuss.steady.oscillator import phi1, phi2
from percuss.steady.phases import forced_response

__all__ = ["RigidFlight"]

_TOUCH = 1e-13  # share of the scale of the motion that rounding hides
_NARROWEST = 1e-14  # share of the flight below which a cell is not split further
_DEPTH = 1e-6  # relative accuracy of the greatest depth
_CELLS = 64  # per load period, to begin with


@dataclass(frozen=True)
class RigidFlight:
    """The mean motion of a bar under its load.

    Parameters
    ----------
    system
        The bar and its load.
    phase
        Phase of the load at time 0.
    velocity
        Mean velocity at time 0.
    """

    system: System
    phase: float
    velocity: float

    @cached_property
    def _start(self) -> tuple[float, float]:
        """Periodic displacement and velocity of the rigid motion at time 0."""
        response, here = forced_response(self.system), np.array([self.phase])
        return float(response.rigid_displacement(here)[0]), float(response.rigid_velocity(here)[0])

    def motion(self, t: Array) -> tuple[Array, Array]:
        """Displacement since time 0 and velocity; shapes of `t`."""
        t = np.asarray(t, dtype=float)
        response, d, mean = forced_response(self.system), self.system.d, self.system.load.mean
        place, velocity = self._start
        free, fade = self.velocity - velocity, t * phi1(d * t)
        moved = response.rigid_displacement(self.phase + t) - place + mean * t**2 * phi2(d * t) + free * fade
        speed = response.rigid_velocity(self.phase + t) + mean * fade + free * np.exp(-d * t)
        return np.asarray(moved), np.asarray(speed)

    @cached_property
    def greatest_force(self) -> float:
        """A bound of the load."""
        return float(forced_response(self.system).rigid_bounds()[1]) + abs(self.system.load.mean)

    def passage(self, start: float, stop: float, undecided: float) -> Violation | None:
        """The first passage through the place at the time `stop`, or None where there is proof of none.

        Parameters
        ----------
        start, stop
            The flight.
        undecided
            Passages less deep than this are none.
        """
        ends, speeds = self.motion(np.array([stop]))
        fastest = 2.0 * forced_response(self.system).rigid_bounds()[0] + self.system.load.mean * stop
        fastest += abs(self.velocity)
        bend = self.greatest_force + self.system.d * fastest
        plane, arrival = float(ends[0]) + undecided + _TOUCH * fastest * stop, float(speeds[0])
        # at the end the bar comes to the plane from its own side
        last = max(stop - 2.0 * arrival / bend, start) if arrival > 0.0 else stop
        count = int(_CELLS * np.ceil(stop / (2.0 * np.pi)))
        half = 0.5 * (last - start) / count
        centres: Array = np.asarray(start + half * (2.0 * np.arange(count) + 1.0), dtype=float)
        first, best = np.inf, 0.0
        while centres.size and half > _NARROWEST * stop:
            place, speed = self.motion(centres)
            beyond = place - plane
            through = beyond > 0.0
            if through.any():
                first, best = min(first, float(centres[through].min())), max(best, float(beyond.max()))
            reach = beyond + np.abs(speed) * half + 0.5 * bend * half**2
            # what is left may hold an earlier passage, or a deeper one
            earlier = (centres - half < first) & ~through
            left = centres[(reach > 0.0) & (earlier | (reach > (1.0 + _DEPTH) * best))]
            half *= 0.5
            centres = np.sort(np.concatenate([left - half, left + half]))
        return Violation(first, best + plane - float(ends[0])) if np.isfinite(first) else None
