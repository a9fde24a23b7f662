"""Does the bar pass through the wall between two impacts? Decided with bounds, not with a scan (theory §4).

For the flight of a steady motion with one impact in a cycle, and for every flight of an orbit with several.

A cell of time is dropped only when Taylor's theorem, with a bound of the acceleration, proves y < 0 on all of it. The
first pass uses few modes and a bound of what the others can add; cells that this cannot decide are looked at with all.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from percuss.model.checks import Array
from percuss.shown import Shown
from percuss.steady.flight import Flown, ringing

_TOUCH = 1e-13  # share of the stroke below which a touch cannot be told from a miss
_DEPTH = 1e-9  # relative accuracy of the greatest depth
_MOST_DOUBT = 1e-6  # share of the stroke above which a passage is one whatever the modes left out may do
_NARROWEST = 1e-14  # share of the period below which a cell is not split further
_MOST_WORK = 20_000_000  # modes × times


@dataclass(frozen=True)
class Violation(Shown):
    """A passage through the wall between two impacts.

    Parameters
    ----------
    time
        When the striking end first passes the wall's place, in rad of the load after the impact.
    depth
        Greatest penetration during the flight, in bar lengths.
    """

    time: float
    depth: float


class _Bounds(NamedTuple):
    """Bounds of |y''| and |y'''| of the sums with a number of modes."""

    acceleration: float
    jerk: float


@dataclass(frozen=True)
class Contactless:
    """The first passage through the wall between impacts, or None, and whether it is proved: not when work ran out."""

    violation: Violation | None
    proven: bool = True


def flight_check(motion: Flown) -> Contactless:
    """Find the first passage of the striking end through the wall within the flight, or prove that there is none.

    A touch within 1e-13 of the stroke counts as none: rounding makes it undecidable. So does one within the error that
    the modes left out may make, up to 1e-6 of the stroke; the answer is then not proven.
    """
    first, proven, _ = _search(motion, np.inf)
    if not np.isfinite(first):
        return Contactless(None, proven)
    at_once = motion.rebound_velocity > 0.0 and motion.start_gap == 0.0
    answer = Contactless(Violation(0.0 if at_once else first, _depth(motion)), proven)
    doubt = min(motion.error_bound, _MOST_DOUBT) * motion.rigid_stroke if motion.requested_modes is None else 0.0
    return Contactless(None, False) if answer.violation is not None and answer.violation.depth <= doubt else answer


def stays_off(motion: Flown) -> bool:
    """Whether `flight_check` finds no passage: where one is deeper than any doubt, its time and depth are spared."""
    first, _, deep = _search(motion, _MOST_DOUBT * motion.rigid_stroke)
    return not deep and (not np.isfinite(first) or flight_check(motion).violation is None)


def a_passage(motion: Flown) -> float:
    """A time at which the bar is seen beyond the wall, inf for none; not always the first one."""
    return _search(motion, 0.0).first


class _Found(NamedTuple):
    """Where the bar is first seen beyond the wall (inf: nowhere), whether that is proved, whether it was `enough`."""

    first: float
    proven: bool
    deep: bool


def _search(motion: Flown, enough: float) -> _Found:
    """The first passage; the search ends at any place that is farther beyond the wall than `enough`."""
    few, touch = motion.truncation.few, _TOUCH * motion.rigid_stroke
    period, full = motion.period, _bounds(motion, motion.modes)
    start, stop = _safe_ends(motion, full)
    if start is None:
        return _Found(0.0, True, False)
    rest, rest_speed = _left_out(motion, few)
    acceleration = _bounds(motion, few).acceleration
    cells = 64 * motion.periods
    half = 0.5 * (stop - start) / cells
    centres: Array = np.asarray(start + half * (2.0 * np.arange(cells) + 1.0), dtype=float)
    first, work = np.inf, 0
    while centres.size and half > _NARROWEST * period:
        exact = few == motion.modes or 0.5 * acceleration * half**2 < rest
        work += centres.size * max(motion.modes if exact else few, 1)
        if work > _MOST_WORK:
            break
        y, speed = motion.end_motion(centres, motion.modes if exact else few)
        near_end = np.minimum(centres, period - centres) + half
        margin = 0.0 * y if exact else np.minimum(2.0 * rest, rest_speed * near_end)
        through = y - margin > touch
        if through.any():
            first = min(first, float(centres[through].min()))
            if float((y - margin).max()) > enough:
                return _Found(first, False, True)
        curvature = full.acceleration if exact else acceleration
        safe = y + np.abs(speed) * half + 0.5 * curvature * half**2 + margin < 0.0
        left = centres[~safe & (centres - half < first)]
        half *= 0.5
        centres = np.sort(np.concatenate([left - half, left + half]))
    return _Found(float(first), bool(not centres.size or half <= _NARROWEST * period), False)


def _depth(motion: Flown) -> float:
    """Greatest y of the flight, by branch and bound: cells that cannot beat the best value found are dropped."""
    modes = motion.truncation.some
    acceleration = _bounds(motion, modes).acceleration
    cells = 64 * motion.periods
    half = 0.5 * motion.period / cells
    centres: Array = np.asarray(half * (2.0 * np.arange(cells) + 1.0), dtype=float)
    best, when, work = 0.0, 0.0, 0
    while centres.size and half > _NARROWEST * motion.period and work < _MOST_WORK:
        work += centres.size * max(modes, 1)
        y, speed = motion.end_motion(centres, modes)
        if float(y.max()) > best:
            best, when = float(y.max()), float(centres[np.argmax(y)])
        reach = y + np.abs(speed) * half + 0.5 * acceleration * half**2
        left = centres[reach > best + _DEPTH * best + _TOUCH * motion.rigid_stroke]
        half *= 0.5
        centres = np.sort(np.concatenate([left - half, left + half]))
    return float(motion.end_motion(np.array([when]), motion.modes)[0][0]) if when > 0.0 else best


def tops(motion: Flown, low: float, high: float) -> tuple[Array, float]:
    """The cells of time between two times in which y may be greatest: their centres, and half their width.

    By branch and bound, ever more modes the narrower the cells: in the end all of a second look, and cells in which y
    bends by less than the modes after them could add, or by a millionth of the stroke.
    """
    most = motion.truncation.some
    modes, cells = motion.truncation.few, 64 * motion.periods
    half = 0.5 * (high - low) / cells
    centres: Array = np.asarray(low + half * (2.0 * np.arange(cells) + 1.0), dtype=float)
    while True:
        acceleration, rest = _bounds(motion, modes).acceleration, 2.0 * _left_out(motion, modes)[0]
        bend = max(rest if modes < most else 0.0, _MOST_DOUBT * motion.rigid_stroke)
        while True:
            y, speed = motion.end_motion(centres, modes)
            reach = y + np.abs(speed) * half + 0.5 * acceleration * half**2
            centres = centres[reach + 2.0 * rest >= float(y.max())]
            if 0.5 * acceleration * half**2 < bend or half < _NARROWEST * motion.period:
                break
            half *= 0.5
            centres = np.sort(np.concatenate([centres - half, centres + half]))
        if modes >= most:
            return centres, half
        modes = min(4 * modes, most)


def _safe_ends(motion: Flown, bounds: _Bounds) -> tuple[float | None, float]:
    """Times up to which, and from which on, the speeds at the impacts alone keep the bar off the wall."""
    speed = motion.impact_velocity
    start = 0.0 if motion.start_gap else _quotient(-2.0 * motion.rebound_velocity, bounds.acceleration)
    if not motion.system.contact.rebounds and not motion.start_gap:  # it starts from rest: its acceleration decides
        begin = start_acceleration(motion)
        if begin >= 0.0:
            return None, motion.period
        start = max(start, min(_quotient(-3.0 * begin, bounds.jerk), _next_break(motion)))
    stop = motion.period - _quotient(2.0 * speed, bounds.acceleration)
    return min(start, 0.5 * motion.period), max(stop, 0.5 * motion.period)


def _quotient(speed: float, rate: float) -> float:
    """How long a positive speed lasts against a rate of change that bounds its loss; 0 for none."""
    if speed <= 0.0:
        return 0.0
    return speed / rate if rate > 0.0 else np.inf


def start_acceleration(motion: Flown) -> float:
    """y''(0⁺) of the modes kept, when the bar starts from rest (R = 0)."""
    force = float(motion.system.load.value(motion.phase))
    modes, state = motion.system.body.modes(motion.modes, motion.system.load.at), motion.state
    rigid = force if motion.system.body.is_free else 0.0
    return rigid + float(modes.gamma @ (force - state.omega**2 * state.rebound))


def _next_break(motion: Flown) -> float:
    breaks = np.asarray(motion.system.load.breaks)
    if not breaks.size:
        return np.inf
    ahead = np.mod(breaks - motion.phase, 2.0 * np.pi)
    return float(ahead[ahead > 1e-12].min(initial=2.0 * np.pi))


def _bounds(motion: Flown, modes: int) -> _Bounds:
    d, push = motion.system.d, motion.system.push
    speed, force = motion.response.rigid_bounds()
    fastest = speed + push * motion.period + abs(motion.rigid_rebound) + speed
    rigid = force + push + d * fastest
    known = motion.system.body.modes(modes, motion.system.load.at)
    omega, damping = known.omega, known.damping
    swing = np.abs(known.gamma) * ringing(motion, motion.state.amplitude[:modes]) * (omega**2 + damping * omega)
    forced = motion.response.end_rates(modes, cut=motion.cut)
    acceleration = rigid + float(swing.sum()) + forced[0]
    return _Bounds(acceleration, d * rigid + float((swing * (omega + damping)).sum()) + forced[1])


def _left_out(motion: Flown, few: int) -> tuple[float, float]:
    """Bounds of the position and the speed that the modes after the first `few` add at the striking end."""
    known = motion.system.body.modes(motion.modes, motion.system.load.at)
    rest = (np.abs(known.gamma) * ringing(motion, motion.state.amplitude))[few:]
    return float(rest.sum()), float(rest @ known.omega[few:])
