"""The walk along cycles of machines that switch their own valve: what happens on it, and what begins there."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import partial
from itertools import pairwise, product
from typing import Any

import numpy as np

from percuss.errors import ParameterError
from percuss.explore.continuation.branch import Branch, BranchEvent, BranchPoint
from percuss.explore.continuation.branch_events import Side, in_words, outside, side_told
from percuss.explore.continuation.machine_cycles import OF_FAULTS, MachineCurve, kind_of
from percuss.explore.continuation.missed_events import dying_impact, nearest, sheet_jump
from percuss.explore.continuation.oil_curve import OilCurve
from percuss.explore.continuation.walk import (
    FIRST,
    CorrectorFailed,
    CurvePoint,
    CurveSegment,
    LocatedEvent,
    Look,
    Problem,
    Target,
    Varied,
    Walk,
    both_ways,
    joined,
    refused,
)
from percuss.explore.family import drives_itself
from percuss.halting import halting
from percuss.model.checks import Array, ComplexArray
from percuss.steady.multipliers import TURNING
from percuss.steady.self_excited.event_sequence import sequence_of
from percuss.steady.self_excited.valve_cycle import ValveCycle

# ---- What happens within a step

_INSIDE = 1e-10  # of a step, before the place where two events change places
_BEFORE = 1e-7  # of a step, before an end, where it is asked whether another one comes first
_ENDS = 8  # that may hide each other in a step
_UNMET = BranchEvent.DEATH, BranchEvent.PORT_LOST  # where a guard is met without speed
_ASIDE = 1e-3  # of a step, beside a fold or flip
_FINE = 1e-12  # of a step, to which the number of multipliers outside the unit circle tells a place
_TURNED, _FEWEST, _MOST_LOOKS = 0.8, 4, 64  # rad of a mode in a part of a step that is looked at for flips; parts
_CALM, _LIVELY = 0.5, 0.9  # of what is left of every disturbance after a cycle, at both ends of a step: below the first
# there is no flip in it, below the second no pair that leaves the unit circle and comes back
_NEXT, _PARABOLAS = 1e-3, 6  # of a step, beside its ends; towards a least value
_DEEP, _DOUBTFUL = 0.1, 1e-2  # of what is beside a least value: one that is sought, and one that is solved for
_SEEN, _LEVEL, _REFINED = 9, 0.3, 1e-5  # looks at a step; part of a slope; a step in which nothing more is looked for
_ASTRAY = 0.06  # rad, between a chord and the mean of its tangents: ringing ripples a branch by 0.05 and less
_STANDSTILL = 3.0  # times as long as at first is a cycle that comes to none
_FRESH = 5e-3  # of each time, for the first step from a flip


def end_of(segment: CurveSegment) -> LocatedEvent | None:
    """The first thing in a step beyond which a machine does something else: a test below 0, or what the proof finds."""
    curve, last, found = segment.curve, segment.length, None
    for _ in range(_ENDS):
        x = segment.at(last).x
        sure = any(value < 0.0 for value in curve.tests(x, ()).values())
        fault = None if sure else curve.fault(x)
        if not sure and fault is None:
            break
        below = [name for name, value in curve.tests(x).items() if value < 0.0]
        for name in reversed(below):  # speeds last, which come first where rounding decides
            kind, which = kind_of(name)
            place = segment.root(partial(_test, curve, name), 0.0, last)
            if kind is BranchEvent.CORNER:  # where the order is known, and the flight before it is none yet
                place = max(place - _INSIDE * segment.length, 0.0)
            if found is None or place - _BEFORE * segment.length * (kind in _UNMET) < found.place:
                found = segment.event(kind, place, which)
        if fault is not None and not below:
            kind = OF_FAULTS[fault.kind]
            found = segment.event(kind, _bisected(segment, last))
            if kind is BranchEvent.TOUCH and curve.motion(found.point.x).contact.velocity_factor == 0.0:
                found = found._replace(kind=BranchEvent.STICKING)
        assert found is not None
        last = found.place - _BEFORE * segment.length
        if last <= 0.0:
            break
    return found


def turns_twice(segment: CurveSegment) -> bool:
    """Whether the cubic through the ends of a step and their tangents has two turns of the parameter, or nearly."""
    start, stop, length = segment.start, segment.stop, segment.length
    if length == 0.0:
        return False
    first, last = float(start.tangent[-1]), float(stop.tangent[-1] / (stop.tangent @ start.tangent))
    if first * last <= 0.0:
        return False
    mean, u = float(stop.x[-1] - start.x[-1]) / length, np.linspace(0.0, 1.0, _SEEN)
    slopes = first * (1.0 - u) * (1.0 - 3.0 * u) + last * u * (3.0 * u - 2.0) + 6.0 * mean * u * (1.0 - u)
    return bool(np.min(slopes / first) < _LEVEL * min(1.0, last / first))


def _test(curve: MachineCurve, name: str, point: CurvePoint) -> float:
    found = curve.test(name, point.x)
    return 1.0 if found is None else found


def _bisected(segment: CurveSegment, last: float) -> float:
    low, high = 0.0, last
    while high - low > _FINE * segment.length:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if segment.curve.fault(segment.at(middle).x) is None else (low, middle)
    return low


def changes_of_stability(segment: CurveSegment, last: float, fresh: bool) -> list[LocatedEvent]:
    """Folds, flips and pairs on the unit circle in a step up to a place, in order."""
    stop = segment.at(last)

    def along(point: CurvePoint) -> float:
        return float(point.tangent[-1])

    found = []
    if not fresh and along(segment.start) * along(stop) < 0.0:
        found.append(segment.event(BranchEvent.FOLD, segment.root(along, 0.0, last)))
    if not fresh:
        found += _flips(segment, last)
    places = sorted([0.0, *(one.place for one in found), last])
    if not fresh:
        for low, high in pairwise(places):
            found += _pair(segment, low, high)
    return sorted(found, key=lambda one: one.place)


def _flips(segment: CurveSegment, last: float) -> list[LocatedEvent]:
    """The flips in a step up to a place; between which places they are is told by quick looks at its parts."""
    curve = segment.curve
    if not last > 0.0 or max(curve.motion(point.x).contraction for point in (segment.start, segment.stop)) < _CALM:
        return []
    quick, turned = curve.flips_about(segment.start, segment.stop)

    def about(place: float) -> float:
        return float(quick(segment.beside(place)))

    parts = min(max(math.ceil(turned * last / segment.length / _TURNED), _FEWEST), _MOST_LOOKS)
    places = [*np.linspace(0.0, last, parts + 1).tolist()]
    if last < segment.length:  # at an end a guard may be met without speed, where the number has a pole
        places.insert(-1, max(last - _ASIDE * segment.length, 0.5 * (places[-2] + last)))
    values = [curve.flip(segment.start), *map(about, places[1:-1]), curve.flip(segment.at(last))]
    ends = _near_zero(about, places, values)
    signs = [(place, curve.flip(segment.at(place))) for place in ends]
    found = []
    for one, other in pairwise(pair for pair in signs if math.isfinite(pair[1])):
        if one[1] * other[1] < 0.0:
            place = segment.root(curve.flip, one[0], other[0])
            if abs(curve.flip(segment.at(place))) < min(abs(one[1]), abs(other[1])):  # else it is a pole
                found.append(segment.event(BranchEvent.FLIP, place))
    return found


def _near_zero(number: Callable[[float], float], places: Sequence[float], values: Sequence[float]) -> list[float]:
    """Places between which a number may pass 0: the outer ones, where its sign changes, where it turns close to 0."""
    seen = list(zip(places, values, strict=True))
    for end, inner, way in ((0, 1, 1.0), (-1, -2, -1.0)):  # a least value may be between an end and what is next to it
        if values[end] * values[inner] > 0.0 and abs(values[end]) <= abs(values[inner]):
            place = places[end] + way * _NEXT * (places[-1] - places[0])
            seen.append((place, number(place)))
    seen.sort()
    ends = {seen[0][0], seen[-1][0]}
    for one, other in pairwise(seen):
        ends |= {one[0], other[0]} if one[1] * other[1] < 0.0 else set()
    for before, here, after in zip(seen, seen[1:], seen[2:], strict=False):
        ends |= _least(number, before, here, after)
    return sorted(ends)


def _least(number: Callable[[float], float], *three: tuple[float, float]) -> set[float]:
    """The place between the outer two of three at which a number comes near 0 and turns, if it does."""
    (low, first), (place, least), (high, last) = three
    sign = math.copysign(1.0, least)
    first, least, last = sign * first, sign * least, sign * last
    if not (first >= least and last >= least):
        return set()
    for _ in range(_PARABOLAS):
        left, right = (first - least) / (low - place), (last - least) / (high - place)
        bend = (right - left) / (high - low)
        slope = left + bend * (place - low)
        if not bend > 0.0:
            break
        step = -0.5 * slope / bend
        if least - 0.25 * slope * slope / bend > _LEVEL * least and least > _DEEP * max(first, last):
            break
        step = step or 1e-3 * (high - low)
        new, value = place + step, sign * number(place + step)
        if not low < new < high or not math.isfinite(value):
            break
        if value < least:
            low, first, high, last = (place, least, high, last) if step > 0.0 else (low, first, place, least)
            place, least = new, value
        elif step > 0.0:
            high, last = new, value
        else:
            low, first = new, value
        if least < 0.0:
            break
    return {place} if least < _DOUBTFUL * max(first, last) else set()


def _pair(segment: CurveSegment, low: float, high: float) -> list[LocatedEvent]:
    """Where a pair of multipliers passes the unit circle, if two more or fewer are outside, at an end or inside."""
    curve, aside = segment.curve, _ASIDE * segment.length

    def values(place: float) -> ComplexArray:
        return np.asarray(curve.motion(segment.at(place).x).multipliers().values)

    low, high = low + (aside if low else 0.0), high - (aside if high < segment.length else 0.0)
    if low >= high:
        return []
    ends = [curve.motion(segment.at(place).x) for place in (low, high)]
    counts = tuple(curve.unstable(segment.at(place).x) for place in (low, high))
    if counts[0] == counts[1] and max(one.contraction for one in ends) > _LIVELY:

        def off(place: float) -> float:
            sizes = np.abs(values(place)) - 1.0
            return float(np.append(sizes[: counts[0]], -sizes[counts[0] :]).min())

        places = np.linspace(low, high, _FEWEST + 1).tolist()
        for inner in _near_zero(off, places, [off(place) for place in places])[1:-1]:
            if outside(values(inner)) != counts[0]:
                return _pair(segment, low, inner) + _pair(segment, inner, high)
    if abs(counts[1] - counts[0]) < 2:
        return []
    while high - low > _FINE * segment.length:
        middle = 0.5 * (low + high)
        here = outside(values(middle))
        if abs(here - counts[0]) >= abs(counts[1] - here):
            high = middle
        else:
            low = middle
    seen = values(high)
    turning = seen[seen.imag > TURNING * np.abs(seen)]
    if not turning.size:
        return []
    pair = complex(turning[np.argmin(np.abs(np.abs(turning) - 1.0))])
    first, stop = max(low - 1e-6 * segment.length, 0.0), min(high + 1e-6 * segment.length, segment.length)

    def modulus(point: CurvePoint) -> float:
        return abs(nearest(curve.motion(point.x).multipliers().values, pair)) - 1.0

    return [segment.event(BranchEvent.NEIMARK_SACKER, segment.root(modulus, first, stop))]


_PAST = (1e-2, 1e-4)  # of a step, beyond the place where two events change places
_ASIDE_OF_IT = (1e-4, 1e-6)  # rad, in which the other order is looked at


def other_order(one: LocatedEvent, segment: CurveSegment) -> CurvePoint | BranchEvent:
    """The point at which two events change places on the curve of their other order, with the tangent beyond it.

    Where that changes nothing for the bar both curves go through the point. Else what the end of the curve is called:
    beyond it no machine does this, or it has another label.
    """
    ended = BranchEvent.ORDER_LOST
    for past in _PAST:
        try:
            place = min(one.place + past * segment.length, segment.length)
            found = segment.curve.reordered(segment.at(place).x)
            if found is None:
                continue
            curve, x = found
            if curve.label != segment.curve.label:
                rests = len(curve.sequence.lying) - len(segment.curve.sequence.lying)
                ended = BranchEvent.ONSET if rests else BranchEvent.CHANGE
                continue
            x[-1:] = one.point.x[-1:]
            level = np.eye(x.size)[-1]
            corner: CurvePoint = curve.corrected(x, level, level, one.point._replace(matrix=None))
        except CorrectorFailed:
            continue
        for size, way in product(_ASIDE_OF_IT, (1.0, -1.0)):
            tangent = way * corner.tangent
            try:
                beside = curve.corrected(corner.x + size * tangent, tangent, tangent, corner)
                if curve.follows(beside.x):
                    return corner._replace(tangent=tangent)
            except CorrectorFailed:
                continue
    return ended


_ONE, _HALVED, _NEAR_HALVED = 1e-8, 0.01, 3.0  # rad, between the halves of a cycle: they are one, or nearly
_ROUNDS, _NEARLY, _ASIDE_OF_ALL = 12, 1e-8, 1e-6


def _flip_near(curve: MachineCurve, x: Array) -> Array:
    """The flip near unknowns, by Newton's method; CorrectorFailed where there is none."""
    for _ in range(_ROUNDS):
        matrix, off = curve.linearised(x)
        here, ways = curve.flip(CurvePoint(x, x, 0)), _ASIDE_OF_ALL * np.eye(x.size)
        sides = [[curve.flip(CurvePoint(x + one, x, 0)) for one in (way, -way)] for way in ways]
        row = np.diff(sides, axis=1).T / (-2.0 * _ASIDE_OF_ALL)
        try:
            step = np.linalg.solve(np.vstack([matrix, row]), -np.append(off, here))
        except np.linalg.LinAlgError:
            break
        if not float(np.abs(step).max()) < 0.5:
            break
        x = x + step
        if float(np.abs(step).max()) < _NEARLY:
            return x
    raise CorrectorFailed("no flip")


# ---- The walk


class MachineWalk(Walk):
    """A walk along cycles; its marks are how many multipliers are outside, `fresh` where it begins at a flip."""

    def __init__(
        self, curve: Any, start: CurvePoint, bounds: Sequence[tuple[float, float]], *, fresh: bool = False
    ) -> None:
        super().__init__(curve, start, bounds)
        self.fresh = fresh
        if fresh:
            self.size = _FRESH * self.scale

    def keep(self, point: CurvePoint, mark: int) -> None:
        super().keep(point._replace(motion=point.curve.motion(point.x)), mark)

    def mark(self) -> int:
        return int(self.curve.unstable(self.here.x))

    def look(self, target: Target) -> Look:
        segment = CurveSegment(self.curve, self.here, target.point)
        halving = None if self.fresh else self._halving(segment)
        if halving is not None:
            return Look(segment, [], None, halving)
        if self.size > _REFINED * self.scale and (sheet_jump(segment, _ASTRAY) or turns_twice(segment)):
            raise CorrectorFailed("the branch may turn back twice in the step")
        found, last = self.what_happens(segment)
        return Look(segment, found, target.limit, last)

    def what_happens(self, segment: CurveSegment) -> tuple[list[LocatedEvent], LocatedEvent | None]:
        """Where stability changes in a step, in order, and what ends it; CorrectorFailed where a shorter one tells."""
        last = end_of(segment)
        length = segment.length if last is None else last.place
        found = changes_of_stability(segment, length, self.fresh)
        if last is not None and last.kind in _UNMET:
            # the time at which a guard is met turns back where it is met without speed: that is no fold
            found = [one for one in found if last.place - one.place > _ASIDE * segment.length]
        return found, last

    def _halving(self, segment: CurveSegment) -> LocatedEvent | None:
        """Where both halves of the cycle become one, which is the flip of the cycle of one of them.

        Near it Newton's method decides by rounding between the branch, its image, and the branch of that cycle.
        """
        first, second = (self.curve.halves(point.x) for point in (segment.start, segment.stop))
        if first is None or second is None:
            return None
        before, after = (float(np.linalg.norm(side[1])) for side in (first, second))
        passed = float(first[1] @ second[1]) < 0.0 or after < _ONE
        if before < _ONE or not (passed or (after < before and after < _HALVED)):
            return None
        narrow, share = self.curve.halved(segment.start.x), before / (before + after) if passed else 1.0
        if narrow is None:
            return None
        x = _flip_near(narrow, (1.0 - share) * first[0] + share * second[0])
        made = narrow.doubled(x)
        if made is None or float(np.abs(made[1] - segment.stop.x).max()) > _NEAR_HALVED * max(before, segment.length):
            if passed:
                raise CorrectorFailed("another flip")
            return None
        point = CurvePoint(made[1], segment.start.tangent, 0, None, self.curve)
        return LocatedEvent(BranchEvent.HALVING, segment.length, point)

    def went(self, look: Look) -> None:
        if self.fresh:
            self.fresh, self.size = False, FIRST * self.scale
        super().went(look)

    def at_last(self, one: LocatedEvent, look: Look) -> None:
        if one.kind is not BranchEvent.CORNER:
            super().at_last(one, look)
            return
        beyond = other_order(one, look.segment)
        if isinstance(beyond, BranchEvent):
            super().at_last(one._replace(kind=beyond), look)
            return
        turned = beyond.tangent[-1] * one.point.tangent[-1] < 0.0
        self.keep(one.point, self.marks[-1])
        self.happened.append(one._replace(kind=BranchEvent.NONSMOOTH_FOLD if turned else BranchEvent.CORNER))
        self.curve, self.size = beyond.curve, min(self.size, FIRST * self.scale)
        self.arrive(beyond)

    def home(self, segment: CurveSegment) -> CurvePoint | None:
        return super().home(segment) if self.points[0].curve == self.curve else None

    def told(self, one: LocatedEvent) -> BranchPoint:
        """What is told of something that happened."""
        return cycle_point(one, self)

    def stuck(self) -> None:
        m = self.curve.impacts
        if self.here.x[m - 1] > _STANDSTILL * self.points[0].x[m - 1]:
            self.end(BranchEvent.STALL)
        elif (death := dying_impact(self.points, lambda point: point.motion.blow_speeds)) is not None:
            super().at_last(death, Look(CurveSegment(self.curve, self.here, death.point), []))
        else:
            self.end(BranchEvent.LOST if self.refusal is None else refused(self.refusal))


# ---- Where the following of a cycle begins, and the branches that begin at flips


_SAME = 1e-6  # rad, by which the cycle may be inexact


def beginning(curve: Problem, x: Array) -> CurvePoint | None:
    """The point near unknowns with the tangent towards greater values of the parameter; None where there is none."""
    try:
        found = curve.settled(x)
    except CorrectorFailed:
        return None
    return found if found.tangent[-1] >= 0.0 else found._replace(tangent=-found.tangent)


def doubled(point: CurvePoint) -> tuple[Any, CurvePoint] | None:
    """The branch of twice as many blows that begins at a flip."""
    made = point.curve.doubled(point.x)
    if made is None:
        return None
    wide, x = made
    own = wide.matrix(x)[:, : wide.places[0]]
    way = np.append(np.linalg.svd(own)[2][-1], np.zeros(len(wide.names)))
    return wide, CurvePoint(x, way / np.linalg.norm(way), 0, None, wide)


def cycle_point(one: LocatedEvent, walk: Walk) -> BranchPoint:
    """What is told of a point."""
    curve = one.point.curve
    cycle = (curve.halved(one.point.x) or curve) if one.kind is BranchEvent.HALVING else curve
    x = one.point.x
    if cycle is not curve:
        halves = curve.halves(x)
        assert halves is not None
        x = halves[0]
    motion = cycle.motion(x)
    unbounded = isinstance(motion, ValveCycle) and not np.all(np.isfinite(motion.slope))
    values = None if unbounded else motion.multipliers().values
    beyond, side = one.kind.words, None
    if one.kind is BranchEvent.FOLD:
        told = f"{curve.names[0]} = {curve.value(one.point.x):.9g}"
        beyond = f"the branch turns back; beyond {told} neither of its two cycles exists"
    elif one.kind is BranchEvent.FLIP:
        beyond, side = _flip(curve, one.point)
    elif one.kind is BranchEvent.NEIMARK_SACKER and values is not None:
        turning = values[values.imag > TURNING * np.abs(values)]
        pair = turning[np.argmin(np.abs(np.abs(turning) - 1.0))]
        turn = math.degrees(float(np.angle(pair)))
        beyond = f"motions on a torus may begin, which turn by {turn:.4g}° in a cycle"
    elif one.kind in (BranchEvent.CORNER, BranchEvent.NONSMOOTH_FOLD):
        way = "goes on" if one.kind is BranchEvent.CORNER else "turns back"
        beyond = f"two events of the valve exchange their order; the branch {way} with a corner"
    elif one.kind is BranchEvent.ONSET:
        told = "the valve lets go as soon as the bar has come to rest: beyond, it does not"
        beyond = told if motion.lying else "the valve presses the bar on the wall after a blow: beyond, it rests there"
    elif one.kind is BranchEvent.CHANGE:
        beyond = (
            "an order of the valve is replaced before it is due, or no longer: the cycle goes on with another label"
        )
    elif one.kind is BranchEvent.TOUCH:
        beyond = "the striking end touches the wall between two blows: double blow"
    elif one.kind is BranchEvent.NO_SYSTEM and walk.refusal is not None:
        beyond = f"there is no such machine: {in_words(walk.refusal)}"
    elif one.kind in (BranchEvent.LIMIT, BranchEvent.STOPPED):
        beyond = "the branch goes on"
    impact = one.which + 1 if one.kind is BranchEvent.DEATH else None
    towards, criticality = (None, None) if side is None else (side.towards, side.criticality)
    return BranchPoint(
        one.kind, curve.values(one.point.x), motion, beyond, values, impact, None, towards, criticality
    )  # fmt: skip


_TRIED = 0.02 * 0.5 ** np.arange(8.0)  # of times and the parameter together, into a branch, until two tell the same


def _flip(curve: MachineCurve, point: CurvePoint) -> tuple[str, Side | None]:
    """Where the doubled cycle begins, and whether it is stable there, by steps into it."""
    partner = doubled(point)
    if partner is None:
        return "a cycle of twice as many blows begins", None
    wide, start = partner
    values = curve.motion(point.x).multipliers().values
    settled = not outside(np.delete(values, np.argmin(np.abs(values + 1.0))))
    side = last = None
    for size in _TRIED:
        try:
            found = wide.corrected(start.x + size * start.tangent, start.tangent, start.tangent, start)
        except CorrectorFailed:
            continue
        by, last = float(found.x[-1] - start.x[-1]), side
        flipped = _flipped(curve, point, by)
        side = Side(by > 0.0, not wide.unstable(found.x), flipped)
        if side == last and side.stable == (flipped and settled):  # else it is beyond a fold of its own
            break
    else:
        side = None
    return f"{wide.label} begins{side_told(curve.names[0], side)}", side


def _flipped(curve: MachineCurve, point: CurvePoint, by: float) -> bool | None:
    """Whether the cycle is no longer stable in this direction at a value that differs by so much from its flip's."""
    if not (by and point.tangent[-1]):
        return None
    try:
        x = point.x + by / point.tangent[-1] * point.tangent
        beside = curve.corrected(x, np.eye(x.size)[-1], point.tangent, point)
    except CorrectorFailed:
        return None
    return abs(nearest(curve.motion(beside.x).multipliers().values, -1.0)) > 1.0


# ---- Cycles of machines followed through a parameter, both ways

_FEW = 400  # points of a branch along which a cycle of another label is looked for
_MET = 1e-7  # of a parameter, within which two branches begin at one flip


def curve_of(cycle: ValveCycle, over: Varied) -> MachineCurve:
    """The curve of a cycle over the parameters of a family."""
    family = over.family
    assert drives_itself(family)
    if cycle.oil is not None:
        return OilCurve.through(cycle, family, over.names, over.units)
    tick = cycle.period / (2.0 * math.pi)
    return MachineCurve(family, over.names, over.units, sequence_of(cycle), cycle.modes, tick)


def follow_cycle(
    cycle: ValveCycle,
    over: Varied,
    *,
    switch: int = 0,
    most: int = 4000,
    halt: Callable[[], bool] | None = None,
) -> Branch:
    """The branch of a cycle; see `percuss.explore.follow`."""
    curve = curve_of(cycle, over)
    with halting(halt):
        x = curve.unknowns(cycle, *over.here)
        start = beginning(curve, x)
        if start is None or float(np.abs(start.x - x).max()) > _SAME:
            raise ParameterError("orbit", str(cycle), f"a cycle of the machine with {over}")
        if (fault := curve.fault(start.x)) is not None:
            raise ParameterError("orbit", str(cycle), f"a possible cycle, without another {fault.kind}")
        ways = both_ways(lambda point: MachineWalk(curve, point, over.bounds), start, most)
    return branch_of(curve, ways, over.bounds, most, switch, halt, [])


def doubled_cycles(cycle: ValveCycle, over: Varied) -> list[ValveCycle]:
    """The cycles at the value of a cycle on the branches that begin at the flips of its own."""
    found, curve = list[ValveCycle](), curve_of(cycle, over)
    start = beginning(curve, curve.unknowns(cycle, *over.here))
    ways = () if start is None else both_ways(lambda point: MachineWalk(curve, point, over.bounds), start, _FEW)
    for one in (one for way in ways for one in way.happened if one.kind is BranchEvent.FLIP):
        partner = doubled(one.point)
        if partner is None:
            continue
        wide, begin = partner
        walk = MachineWalk(wide, begin, over.bounds, fresh=True).walked(_FEW)
        off = np.array([point.x[-1] for point in walk.points]) - np.divide(over.here, over.units)
        for i in np.flatnonzero(off[:-1] * off[1:] < 0.0).tolist():
            first, last = walk.points[i : i + 2]
            if first.curve.sequence != last.curve.sequence:
                continue
            x = first.x + off[i] / (off[i] - off[i + 1]) * (last.x - first.x)
            held = np.eye(x.size)[-1]
            found.append(first.curve.motion(first.curve.corrected(x, held, first.tangent, first).x))
    return found


def branch_of(
    curve: Any,
    ways: Sequence[MachineWalk],
    bounds: Sequence[tuple[float, float]],
    most: int,
    depth: int,
    halt: Callable[[], bool] | None,
    met: list[tuple[str, float]],
) -> Branch:
    """The branch of walks from one point, and those that begin at its flips; `met` are those that were followed."""
    points, marks, happened = joined(ways)
    motions = [point.motion for point in points]
    found = tuple(way.told(one) for one, way in happened)
    met += [(curve.label, point.value) for point in found if point.kind is BranchEvent.HALVING]
    switched = []
    for one, _ in happened if depth else ():
        partner = doubled(one.point) if one.kind is BranchEvent.FLIP else None
        if partner is None or (halt is not None and halt()):
            continue
        wide, start = partner
        key = wide.label, curve.value(one.point.x)
        if any(key[0] == label and abs(key[1] - value) < _MET * max(1.0, abs(value)) for label, value in met):
            continue
        met.append(key)
        with halting(halt):
            walk = type(ways[0])(wide, start, bounds, fresh=True).walked(most)
        walk.happened.insert(0, LocatedEvent(BranchEvent.HALVING, 0.0, start))
        switched.append(branch_of(wide, (walk,), bounds, most, depth - 1, halt, met))
    return Branch(
        parameters=curve.names, label=curve.label, modes=curve.modes,
        values=np.array([curve.value(point.x) for point in points]),
        unstable=np.array(marks, dtype=np.int64), points=found, motions=tuple(motions), switched=tuple(switched),
        **curve.along(motions),
    )  # fmt: skip
