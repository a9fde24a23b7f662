"""Onsets: a rest that is about to vanish, or to begin, as a number that vanishes there (theory, Onset of chatter)."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

from percuss.explore.continuation.next_point import Strayed
from percuss.explore.continuation.rest_branch import RestEvent
from percuss.explore.point_curves.rest_way import RestWay, Struck, near, struck
from percuss.model import System
from percuss.model.contact.falling_push import FallingPush
from percuss.steady.resting.chain import Course, chatter_left
from percuss.steady.resting.releases import release_phases

__all__ = ["Endless", "Held", "Late", "Vanishing"]

_MOST_IMPACTS = 400
_SLOWEST = 1.01  # of the growth of q − c, below which so many impacts do not tell it
_LOW, _HIGH = 0.5, 0.36  # of c, and itself: between these q is followed on; above 3/8 the bar is not thrown back
_OVER = 1e30  # in place of the q of an impact after the push is gone
_CALM = 0.3  # share of c by which q may differ from the first impact on that counts
_FINE = 1e-14  # rad of the load, beyond which later impacts have no say
_SURE = 0.5  # of a contact, left over where the bar is held without doubt


class Endless(Strayed):
    """More impacts than are followed."""


@dataclass(frozen=True)
class Vanishing:
    """A chatter that piles up just as the push that presses the bar on the wall is gone.

    The number is the push that is missing at the last of the impacts of the way: negative where the chatter does not
    come to its end. From there on impact by impact q departs from c, in a known way; where q is asked for late enough
    the number is exact.
    """

    way: RestWay

    @property
    def kind(self) -> RestEvent:
        """An onset."""
        return RestEvent.ONSET

    def number(self, system: System) -> float:
        """The missing push, in the unit of the load."""
        course = self.way.course(system)
        first = Struck(course.leg)
        limit = FallingPush(-system.contact.velocity_factor)
        root = math.sqrt(limit.critical)
        found = root * first.push - math.sqrt(max(first.rebound * first.fall, 0.0))
        for excess, share, here in _followed(course, first, limit):
            found = share * (min(here.push, 0.0) - 0.5 * excess * first.push / root)
        return found

    def renewed(self, system: System) -> Vanishing:
        """With the first impact from which on q stays near c."""
        known, critical = len(self.way.impacts), FallingPush(-system.contact.velocity_factor).critical
        course = self.way.course(system)
        if system.contact.velocity_factor == 0.0:
            return Vanishing(self.way.after(course, known))
        if self._calm(course, critical):
            last = Course(course.swing, course.release, course.stop)
            going = [last.strikes() for _ in range(known - 1)]
            first = known - 1 if all(going) and going and self._calm(last, critical) else known
        else:
            first = self._first_calm(course, critical) or known
        return Vanishing(self.way.after(course, first))

    def _first_calm(self, course: Course, critical: float) -> int:
        """How many impacts there are once q has come near c, with those of the course; 0 where it does not."""
        for _ in range(_MOST_IMPACTS):
            if not course.strikes() or Struck(course.leg).push <= 0.0:
                return 0
            if self._calm(course, critical):
                return len(course.impacts)
        return 0

    @staticmethod
    def _calm(course: Course, critical: float) -> bool:
        """Whether q is near c after the last impact."""
        return abs(Struck(course.leg).share / critical - 1.0) < _CALM

    def phase(self, system: System) -> float:
        """When the load lets go."""
        course = self.way.course(system)
        here = Struck(course.leg)
        return _release_after(system, here.time + max(here.push / here.fall, 0.0))


def _followed(course: Course, first: Struck, limit: FallingPush) -> Iterator[tuple[float, float, Struck]]:
    """Of each impact while q stays near c: its excess, the share of the first in it, and what it leaves."""
    if math.isinf(limit.growth) or first.push <= 0.0:
        return
    if limit.growth < _SLOWEST:
        raise Endless("too many impacts")
    here, share = first, 1.0
    for _ in range(_MOST_IMPACTS):
        if here.fall <= 0.0:
            return
        yield limit.excess(min(here.share, _OVER)), share, here
        if not _LOW * limit.critical < here.share < _HIGH or share * here.push < _FINE * here.fall:
            return
        here, share = struck(course), share / limit.growth
    raise Endless("too many impacts")


@dataclass(frozen=True)
class Late:
    """A bar that comes to rest just as the load lets go, still pressed on the wall by its strain, or by a step.

    The number is the time from the rest to the release.
    """

    way: RestWay

    @property
    def kind(self) -> RestEvent:
        """An onset."""
        return RestEvent.ONSET

    def _rest(self, system: System) -> tuple[float, Course]:
        course = self.way.course(system)
        factor = system.contact.velocity_factor
        for _ in range(_MOST_IMPACTS):
            left = chatter_left(course.leg, factor) if factor < 0.0 else 0.0
            if left is not None:
                return course.leg.time + left, course
            struck(course)
        raise Endless("too many impacts")

    def number(self, system: System) -> float:
        """The time from the rest to the release."""
        rest, _ = self._rest(system)
        return _release_after(system, rest) - rest

    def renewed(self, system: System) -> Late:
        """With the impacts of here."""
        return Late(self.way.after(self._rest(system)[1], len(self.way.impacts)))

    def phase(self, system: System) -> float:
        """When the load lets go."""
        return _release_after(system, self._rest(system)[0])


@dataclass(frozen=True)
class Held(Vanishing):
    """The same by a law that turns the strain over: the bar is held already where its flights are short.

    Where that is, `spare` vanishes: a little beyond the place at which the chatter piles up as the push is gone.
    """

    def spare(self, system: System) -> float:
        """By how much flight and rebound of the best of the impacts are shorter than a contact, in rad of the load."""
        course = self.way.course(system)
        contact, best = 2.0 * system.body.transit_time, -math.inf
        for _ in range(_MOST_IMPACTS):
            push = float(system.load.value(course.leg.time))
            if push <= 0.0:
                break
            spare = contact - max(course.flight, -2.0 * course.leg.start.rigid / push)
            if spare < best or spare > _SURE * contact:
                return max(best, spare)
            best = spare
            struck(course)
        return best

    def renewed(self, system: System) -> Held:
        """With the first impact from which on q stays near c."""
        return Held(super().renewed(system).way)


def _release_after(system: System, time: float) -> float:
    """The release nearest to a time."""
    phases = release_phases(system.load)
    if not phases.size:
        raise Strayed("no release")
    return min((near(float(phase), time) for phase in phases), key=lambda one: abs(one - time))
