"""What ends a branch of cycles with rest at one of its points, as a condition on the way of the bar."""

from __future__ import annotations

import math

import numpy as np

from percuss.errors import ParameterError
from percuss.explore.continuation.rest_branch import RestBranchPoint, RestEvent
from percuss.explore.continuation.rest_ends import short_rest
from percuss.explore.point_curves.onsets import Held, Late, Vanishing
from percuss.explore.point_curves.rest_conditions import Grazing, Pulling, RestCondition
from percuss.explore.point_curves.rest_way import TURN, RestWay, Struck, near, struck
from percuss.model.contact.falling_push import FallingPush
from percuss.model.set_at_wall import set_at_wall, wall_load
from percuss.steady import RestCycle
from percuss.steady.resting.chain import Chain, Course
from percuss.steady.resting.leg import Swing
from percuss.steady.resting.releases import release_phases

__all__ = ["REST_FOLLOWED", "rest_condition"]

REST_FOLLOWED = (RestEvent.ONSET, RestEvent.TOUCH, RestEvent.DEATH, RestEvent.RELEASE_LOST)
"""The kinds of ends of which there are curves."""

_CALM = 0.3  # of c, within which a chatter piles up as the push vanishes
_GONE, _HELD = 1e-2, 0.1  # of the greatest push, below which it vanishes, and where the bar is held before
_PILED = 0.5  # of c, below which a chatter piles up whatever becomes of the push
_RELEASE = 1e-6


def rest_condition(point: RestBranchPoint) -> tuple[RestCondition, float]:
    """The condition that holds at a point of a branch of cycles with rest, and the sign of its number on the branch.

    Raises
    ------
    ParameterError
        For a point of another kind, and for one after a bar was let go at no release phase.
    """
    cycle = point.cycle
    if point.kind is RestEvent.RELEASE_LOST:
        return Pulling(RestWay(cycle.modes, cycle.release_phase, (), cycle.periods)), 1.0
    if point.kind is RestEvent.ONSET:
        return _onset(point), 1.0 if cycle.rest_times.min() < short_rest(cycle) else -1.0
    if point.kind in (RestEvent.TOUCH, RestEvent.DEATH) and point.impact is not None:
        return _grazing(point, point.impact), 1.0 if point.kind is RestEvent.DEATH else -1.0
    known = ", ".join(one.value for one in REST_FOLLOWED)
    raise ParameterError("point", str(point), f"a point of one of the kinds {known}")


def _way(point: RestBranchPoint, chain: Chain, number: int) -> RestWay:
    """The way of a chain up to an impact."""
    cycle = point.cycle
    off = [
        abs(math.remainder(float(phase) - chain.release, TURN))
        for phase in release_phases(wall_load(cycle.system, cycle.modes))
    ]
    if min(off, default=math.inf) > _RELEASE:
        raise ParameterError(
            "point", str(point), "one after a release where the load begins to pull", "this bar was laid down later"
        )
    return RestWay(cycle.modes, chain.release, chain.impacts[:number], cycle.periods)


def _onset(point: RestBranchPoint) -> RestCondition:
    """A rest that is about to vanish, or one that is about to begin."""
    cycle = point.cycle
    system, short = cycle.system, int(np.argmin(cycle.rest_times))
    chains = [cycle.chains[short]] if cycle.rest_times[short] < short_rest(cycle) else list(cycle.chains)
    factor = -system.contact.velocity_factor
    if factor == 0.0:
        ends = [(chain, i) for chain in chains for i in range(1, len(chain.impacts) + 1)]
        if len(chains) == 1 and chains[0] is cycle.chains[short]:
            ends = ends[-1:]
        chain, number = min(ends, key=lambda end: _off_release(cycle, end[0].impacts[end[1] - 1].time))
        way = _way(point, chain, number)
        return Late(way) if (cycle.modes and system.body.is_free) or system.load.is_piecewise else Vanishing(way)
    best = None
    for chain in chains:
        found = _vanishing(cycle, chain, FallingPush(factor))
        if found is not None and (best is None or found[1] < best[1]):
            best = chain, found[1], found[0]
    if best is not None:
        way = _way(point, best[0], best[2])
        return Vanishing(way) if system.contact.keeps_strain else Held(way)
    chain = chains[0]
    if chain.rest == chain.impacts[-1].time:
        told = "the ringing bar is held by one of its last, irregular impacts: of a rigid bar it can be, with 0 modes"
        raise ParameterError("point", str(point), "an onset that can be followed", told)
    return Late(_way(point, chain, _piled(cycle, chain, FallingPush(factor))))


def _off_release(cycle: RestCycle, time: float) -> float:
    return min(
        abs(math.remainder(time - float(phase), TURN)) for phase in release_phases(wall_load(cycle.system, cycle.modes))
    )


def _left(cycle: RestCycle, chain: Chain) -> list[Struck]:
    """What each impact of a chain leaves."""
    course = Course(Swing(set_at_wall(cycle.system, cycle.modes), cycle.modes), chain.release, chain.stop + TURN)
    return [struck(course) for _ in chain.impacts]


def _vanishing(cycle: RestCycle, chain: Chain, limit: FallingPush) -> tuple[int, float] | None:
    """The first of the impacts that pile up as the push vanishes, and the least push; None where none do."""
    left = _left(cycle, chain)
    best, begun = None, None
    gone = (_GONE if cycle.system.contact.keeps_strain else _HELD) * max(one.push for one in left)
    for number, one in enumerate(left, 1):
        if abs(one.share / limit.critical - 1.0) >= _CALM:
            begun = None
            continue
        begun = number if begun is None else begun
        if one.push < gone and (best is None or one.push < best[1]):
            best = begun, one.push
    return best


def _piled(cycle: RestCycle, chain: Chain, limit: FallingPush) -> int:
    """The first impact from which on the others pile up anyway."""
    piled = [one.share < _PILED * limit.critical for one in _left(cycle, chain)]
    first = len(piled)
    while first > 1 and piled[first - 2]:
        first -= 1
    return first


def _grazing(point: RestBranchPoint, impact: int) -> Grazing:
    """An impact that is born or dies."""
    number = impact - 1
    for chain in point.cycle.chains:
        if number < len(chain.impacts):
            break
        number -= len(chain.impacts)
    way, here = _way(point, chain, number), chain.impacts[number].time
    if point.kind is RestEvent.TOUCH:
        assert point.touch_phase is not None
        begin = chain.impacts[number - 1].time if number else chain.release
        first = near(point.touch_phase, begin)
        times = [first + TURN * turn for turn in range(point.cycle.periods + 2)]
        here = min((time for time in times if begin < time < here), default=here)
    return Grazing(way, point.kind, here - chain.release)
