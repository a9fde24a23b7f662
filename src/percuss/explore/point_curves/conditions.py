"""What makes an orbit a grazing, a corner …: one equation more than its unknowns, smooth along a curve of them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from percuss.errors import ParameterError
from percuss.explore.continuation.corners import step_of, steps_passed
from percuss.explore.continuation.kinds import BranchEvent
from percuss.model import System
from percuss.model.checks import Array
from percuss.steady import PeriodicOrbit

__all__ = ["Condition", "Corner", "Death", "Plain", "Touch", "curvature"]

_LATE = 1e-4  # rad, by which the acceleration of the end is asked for


class Condition(Protocol):
    """What is asked of an orbit, besides that it is one."""

    @property
    def kind(self) -> BranchEvent:
        """What the orbit is where it holds."""
        ...

    @property
    def extras(self) -> int:
        """Unknowns that it brings."""
        ...

    def placed(self, system: System, times: Array) -> Array:
        """The times of the impacts as they stand in the equations."""
        ...

    def off(self, orbit: PeriodicOrbit, times: Array, extra: Array) -> Array:
        """By how much it does not hold; shape (1 + extras,)."""
        ...

    def renewed(self, orbit: PeriodicOrbit, extra: Array) -> Condition:
        """The same with what belongs to a place on the curve taken anew there."""
        ...


@dataclass(frozen=True)
class Plain:
    """A condition on the times as they are, which belongs to no place."""

    @property
    def extras(self) -> int:
        """None."""
        return 0

    def placed(self, system: System, times: Array) -> Array:
        """The times."""
        return times


@dataclass(frozen=True)
class Death(Plain):
    """An impact without speed: number `which`."""

    which: int

    @property
    def kind(self) -> BranchEvent:
        """The death of an impact."""
        return BranchEvent.DEATH

    def off(self, orbit: PeriodicOrbit, times: Array, extra: Array) -> Array:
        """Its speed."""
        return np.array([orbit.speeds[self.which]])

    def renewed(self, orbit: PeriodicOrbit, extra: Array) -> Death:
        """The same."""
        return self


@dataclass(frozen=True)
class Touch(Plain):
    """The bar touches the wall in flight `flight`, at a time after its start that is an unknown."""

    flight: int

    @property
    def kind(self) -> BranchEvent:
        """A touch."""
        return BranchEvent.TOUCH

    @property
    def extras(self) -> int:
        """The time of the touch."""
        return 1

    def off(self, orbit: PeriodicOrbit, times: Array, extra: Array) -> Array:
        """y and y' there."""
        y, velocity = orbit.flights[self.flight].end_motion(extra, orbit.modes)
        return np.array([y[0], velocity[0]])

    def renewed(self, orbit: PeriodicOrbit, extra: Array) -> Touch:
        """The same."""
        return self


@dataclass(frozen=True)
class Corner:
    """Impact `which` falls on step `number` of the load, counted from time 0 on.

    The impact is put on the step before anything else is computed, so that the step may move with the parameters: as a
    function of the times alone the equations have a corner there.
    """

    which: int
    number: int

    @staticmethod
    def of(orbit: PeriodicOrbit, which: int) -> Corner:
        """The step that an impact of an orbit is at."""
        if not orbit.system.load.breaks:
            raise ParameterError("point", str(orbit), "an orbit whose load has steps")
        last = int(steps_passed(orbit)[which])
        numbers = (last - 1, last)
        return Corner(which, min(numbers, key=lambda n: abs(step_of(orbit.system, n) - orbit.times[which])))

    @property
    def kind(self) -> BranchEvent:
        """A corner."""
        return BranchEvent.CORNER

    @property
    def extras(self) -> int:
        """None."""
        return 0

    def placed(self, system: System, times: Array) -> Array:
        """The times with the impact on the step."""
        found = np.array(times)
        found[self.which] = step_of(system, self.number)
        return found

    def off(self, orbit: PeriodicOrbit, times: Array, extra: Array) -> Array:
        """The time from the step to the impact."""
        return np.array([times[self.which] - orbit.times[self.which]])

    def renewed(self, orbit: PeriodicOrbit, extra: Array) -> Corner:
        """The same."""
        return self


def curvature(orbit: PeriodicOrbit, condition: Condition, extra: Array) -> float:
    """The acceleration of the striking end where it grazes, just after: negative where it really does."""
    if isinstance(condition, Touch):
        flight, time = orbit.flights[condition.flight], float(extra[0])
        velocity = flight.end_motion(np.array([time - _LATE, time + _LATE]), orbit.modes)[1]
        return float(velocity[1] - velocity[0]) / (2.0 * _LATE)
    assert isinstance(condition, Death)
    flight = orbit.flights[condition.which]
    velocity = flight.end_motion(np.array([0.0, _LATE]), orbit.modes)[1]
    return float(velocity[1] - velocity[0]) / _LATE
