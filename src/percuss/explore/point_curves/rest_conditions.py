"""What ends cycles with rest, as a number of the system that vanishes there and goes on smoothly to the other side.

All of it belongs to one way of the bar: let go at a release phase, it flies and strikes as far as the number asks for.
Here are touches, deaths of impacts and the last release.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol, Self

import numpy as np

from percuss.explore.continuation.next_point import Strayed
from percuss.explore.continuation.rest_branch import RestEvent
from percuss.explore.point_curves.rest_way import RestWay, near
from percuss.model import System
from percuss.steady.resting.leg import Leg
from percuss.steady.trigonometric import trigonometric_roots

__all__ = ["Grazing", "Pulling", "RestCondition"]

_STEPS, _CLOSE, _ASIDE = 30, 1e-12, 0.3


class RestCondition(Protocol):
    """What ends the cycles."""

    @property
    def kind(self) -> RestEvent:
        """How they end."""
        ...

    @property
    def way(self) -> RestWay:
        """The way of the bar."""
        ...

    def number(self, system: System) -> float:
        """What vanishes; Strayed where it is not known."""
        ...

    def renewed(self, system: System) -> Self:
        """The same with what belongs to a place on the curve taken anew."""
        ...

    def phase(self, system: System) -> float:
        """When it happens, in rad of the load."""
        ...


@dataclass(frozen=True)
class Grazing:
    """The bar just reaches the wall in the flight after the impacts of the way: a touch, or an impact without speed.

    Parameters
    ----------
    way
        Up to the impact before.
    kind
        A touch or a death.
    time
        When it does, after the release.
    """

    way: RestWay
    kind: RestEvent
    time: float

    def _top(self, system: System) -> tuple[float, float]:
        """When the gap function has its maximum, after the release, and this."""
        course = self.way.course(system)
        begin = course.impacts[-1].time if course.impacts else course.release
        leg, time, last = course.leg, course.release + self.time, math.inf
        widest = _ASIDE * (time - begin)
        for _ in range(_STEPS):
            leg = _leg_at(course.leg, time)
            after, h = time - leg.time, 1e-6
            y, v = leg.gap(np.array([after, after + h]))
            bend = float(v[1] - v[0]) / h
            step = -float(v[0]) / bend if bend < 0.0 else math.inf
            if abs(time + step - course.release - self.time) > widest:
                raise Strayed("no maximum")
            time += step
            if abs(step) < _CLOSE or (abs(step) < 1e-9 and abs(step) >= abs(last)):
                return time - course.release, float(y[0])
            last = step
        raise Strayed("no maximum")

    def number(self, system: System) -> float:
        """The greatest height of the gap function there."""
        return self._top(system)[1]

    def renewed(self, system: System) -> Grazing:
        """With the impacts and the time of here."""
        course = self.way.course(system)
        return Grazing(self.way.after(course, len(self.way.impacts)), self.kind, self._top(system)[0])

    def phase(self, system: System) -> float:
        """When it grazes."""
        return self.way.released(system) + self._top(system)[0]


def _leg_at(leg: Leg, time: float) -> Leg:
    """The part of a flight, between jumps of the load, that a time is in."""
    while (end := leg.swing.breaks_after(leg.time)) < time:
        leg = Leg(leg.swing, end, leg.at(end - leg.time))
    return leg


@dataclass(frozen=True)
class Pulling:
    """A load that just no longer pulls: the number is how hard it does."""

    way: RestWay

    @property
    def kind(self) -> RestEvent:
        """No release."""
        return RestEvent.RELEASE_LOST

    def _deepest(self, system: System) -> tuple[float, float]:
        """The phase of the least load near the release, and that load."""
        load = system.load
        if load.is_piecewise:
            values, breaks = np.asarray(load.values), np.asarray(load.breaks)
            down = np.flatnonzero(values < np.roll(values, 1))
            times = [near(float(breaks[i]), self.way.release) for i in down]
            best = int(np.argmin(np.abs(np.array(times) - self.way.release)))
            return times[best], float(values[down[best]])
        k = load.harmonics.astype(float)
        rate = 1j * k * load.coefficients[load.harmonics]
        phases = trigonometric_roots(np.append(0.0, k), np.append(0.0j, rate))
        bends = [float((1j * k * rate * np.exp(1j * k * phase)).real.sum()) for phase in phases.tolist()]
        lows = [phase for phase, bend in zip(phases.tolist(), bends, strict=True) if bend > 0.0]
        if not lows:
            raise Strayed("a constant load")
        time = min((near(phase, self.way.release) for phase in lows), key=lambda one: abs(one - self.way.release))
        return time, float(load.value(time))

    def number(self, system: System) -> float:
        """Minus the least load."""
        return -self._deepest(system)[1]

    def renewed(self, system: System) -> Pulling:
        """With the phase of here."""
        way = self.way
        return Pulling(RestWay(way.modes, self._deepest(system)[0], (), way.periods))

    def phase(self, system: System) -> float:
        """When the load is least."""
        return self._deepest(system)[0]
