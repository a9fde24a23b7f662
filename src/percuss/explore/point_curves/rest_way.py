"""The way of a bar from a release up to what ends a cycle with rest, at one system after the other."""

from __future__ import annotations

import math
from dataclasses import dataclass

from percuss.explore.continuation.next_point import Strayed
from percuss.explore.continuation.rest_branch import RestEvent
from percuss.model import System
from percuss.steady.resting.chain import Course, Impact
from percuss.steady.resting.leg import Leg, Swing
from percuss.steady.resting.releases import release_phases

__all__ = ["TURN", "RestWay", "Struck", "Unlike", "near", "struck"]

TURN = 2.0 * math.pi
_JUMP = 1.5  # factor by which a flight may change in a step
_FEW = 1e-2  # an impact that is so much slower than at the last place is another one


class Unlike(Strayed):
    """Not the impacts that there were: one was born, or died."""

    def __init__(self, kind: RestEvent) -> None:
        super().__init__("other impacts")
        self.kind = kind


class Struck:
    """What an impact leaves: the time, the speed of the rebound, the push, and how fast that falls.

    The push is the acceleration of a striking end without velocity; it falls as the load does while the strain stays.
    """

    def __init__(self, leg: Leg) -> None:
        swing, load = leg.swing, leg.swing.system.load
        self.time, self.rebound = leg.time, -leg.rate
        whole = 1.0 if swing.system.body.is_free else 0.0
        self.push = leg.acceleration - (swing.system.d if whole else float(swing.known.damping[0])) * self.rebound
        k = swing.harmonics
        rate = float((1j * k * load.coefficients[k.astype(int)] * leg.turned).real.sum())
        self.fall = -rate * (whole + float(swing.known.gamma.sum()))

    @property
    def share(self) -> float:
        """q of `FallingPush`; inf without a push."""
        return self.rebound * self.fall / self.push**2 if self.push > 0.0 else math.inf


def struck(course: Course) -> Struck:
    """What the next impact leaves; Strayed where there is none."""
    if not course.strikes():
        raise Strayed("no further impact")
    return Struck(course.leg)


def near(phase: float, place: float) -> float:
    """A phase as the time nearest to a place."""
    return place + math.remainder(phase - place, TURN)


@dataclass(frozen=True)
class RestWay:
    """A bar let go at a release phase, and its first impacts.

    Parameters
    ----------
    modes
        N.
    release
        When it is let go.
    impacts
        Those that it has then; at another system as many, of about these times and speeds.
    periods
        Load periods for which it is followed.
    """

    modes: int
    release: float
    impacts: tuple[Impact, ...]
    periods: int

    def released(self, system: System) -> float:
        """When it is let go; Strayed where the load lets go nowhere."""
        phases = release_phases(system.load)
        if not phases.size:
            raise Strayed("no release")
        return min((near(float(phase), self.release) for phase in phases), key=lambda time: abs(time - self.release))

    def course(self, system: System) -> Course:
        """The bar just after the last of these impacts; Unlike where they are others."""
        release = self.released(system)
        course = Course(Swing(system, self.modes), release, release + TURN * (self.periods + 1))
        last, before = release, self.release
        for one in self.impacts:
            if not course.strikes():
                raise Unlike(RestEvent.DEATH)
            its = course.impacts[-1]
            ratio = (its.time - last) / (one.time - before)
            if not 1.0 / _JUMP < ratio < _JUMP or its.speed < _FEW * one.speed:
                raise Unlike(RestEvent.TOUCH if its.speed < one.speed else RestEvent.DEATH)
            last, before = its.time, one.time
        return course

    def after(self, course: Course, number: int) -> RestWay:
        """The same from here, with the first impacts of a course that has gone this way."""
        return RestWay(self.modes, course.release, tuple(course.impacts[:number]), self.periods)
