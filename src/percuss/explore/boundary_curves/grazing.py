"""Where a steady motion begins or ceases to be possible: the striking end touches the wall between two impacts."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import lru_cache
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from percuss.explore.boundary_curves.crossings import Crossing
from percuss.explore.boundary_curves.lines import GRAZING_SAMPLES, Stretch, orbit_on
from percuss.explore.boundary_curves.roots import bracketed_roots
from percuss.model.checks import Array
from percuss.steady import Orbit
from percuss.steady.admissible import a_passage, start_acceleration, stays_off, tops

__all__ = ["GRAZING", "admissible_on", "grazings"]

GRAZING = "grazing"

_AWAY = 1e-3  # the samples stay this far inside: where the load ceases to push, touches are hard to tell from misses
_NEAR = 1e-6  # share of the stroke by which a first look may mistake one maximum for another
_SLOPE = 1e-6  # half the step in t of slopes
_REACH = 1e-9  # how far beside a touch the motion is asked whether it is possible
_MANY = 256  # looks at a motion from which on those are spared where bounds leave no room for the greatest y
_LOOKS = 17  # places of a maximum that are looked at at once
_PEAKS = 4  # maxima of nearly the same height that are looked at closely
_HALVES = 5  # before a touch is solved for
_STEPS = 80  # halves, or touches that are not the first


def grazings(stretch: Stretch, samples: int | None, told: Callable[[float], None] | None = None) -> list[Crossing]:
    """Where the motion begins or ceases to be possible: the bar touches the wall between two impacts.

    At R = 0, where the bar starts from rest, also where it would start into the wall; and where the striking speed
    vanishes.

    Parameters
    ----------
    samples
        Motions that are asked at first; None for 25 and more for many harmonics.
    told
        Called with the share of these that is done, 0 to 1.
    """
    return [crossing for _, crossing in _switches(stretch, samples, told)[1]]


def admissible_on(stretch: Stretch, t: Array, samples: int | None = None) -> npt.NDArray[np.bool_]:
    """Whether the motions at many places of a branch are possible, from the places where that changes."""
    first, switches = _switches(stretch, samples)
    turned = np.searchsorted(np.array([place for place, _ in switches]), np.asarray(t))
    return np.asarray((turned % 2 == 0) == first)


def _switches(
    stretch: Stretch, samples: int | None, told: Callable[[float], None] | None = None
) -> tuple[bool, list[tuple[float, Crossing]]]:
    """Whether the first motion is possible, and every place where that changes."""

    @lru_cache(maxsize=4096)
    def orbit(t: float) -> Orbit:
        stretch.line.go_on()
        return orbit_on(stretch, t)[0]

    nodes = stretch.nodes(samples, _AWAY, GRAZING_SAMPLES)
    first = before = _possible(orbit(float(nodes[0])))
    found = []
    for i in range(1, nodes.size):
        here = _possible(orbit(float(nodes[i])))
        if here != before:
            good, bad = (nodes[i - 1], nodes[i]) if before else (nodes[i], nodes[i - 1])
            found.append(_grazing(stretch, orbit, float(good), float(bad)))
        before = here
        if told is not None:
            told(i / (nodes.size - 1))
    return first, found


def _possible(motion: Orbit) -> bool:
    """Whether a motion is admissible; where a look is enough to say no, the rest of the proof is spared."""
    return motion.impact_velocity > 0.0 and stays_off(motion)


def _grazing(stretch: Stretch, orbit: Callable[[float], Orbit], good: float, bad: float) -> tuple[float, Crossing]:
    """The root of what makes the bad motion impossible; where another touch comes first, the root of that; else halves.

    A few halves first: a motion that hardly passes the wall does so at one place. The motion a hair nearer to the good
    one proves that it is the first.
    """
    far, halves = good, _HALVES
    for _ in range(_STEPS):
        if abs(good - bad) <= 4.0 * np.finfo(float).eps * max(good, bad):
            break
        # a passage too shallow to be told from a touch counts as none: farther away the bar is off the wall
        touch = None if halves else _touch(orbit, good, bad) or _touch(orbit, far, bad)
        if touch is None:
            halves = halves - 1 if halves else _HALVES
            middle = 0.5 * (good + bad)
            good, bad = (middle, bad) if _possible(orbit(middle)) else (good, middle)
            continue
        beside = touch.place + math.copysign(_REACH * max(1.0, abs(touch.place)), good - bad)
        if (beside - good) * (bad - good) <= 0.0 or _possible(orbit(beside)):
            return touch.place, _crossing(stretch, touch)
        bad = beside
    ys, phases = stretch.place(np.array([good, bad]))
    return good, Crossing(GRAZING, float(ys[0]), float(phases[0]), abs(float(ys[1] - ys[0])))


class _Touch(NamedTuple):
    """A place of a stretch, and the step in t that Newton's method would still make there."""

    place: float
    off: float


def _crossing(stretch: Stretch, touch: _Touch) -> Crossing:
    y, phase = stretch.place(np.array([touch.place]))
    ys = stretch.place(np.array([max(touch.place - _SLOPE, 0.0), min(touch.place + _SLOPE, 1.0)]))[0]
    slope = abs(float(ys[1] - ys[0])) / (2.0 * _SLOPE)
    return Crossing(GRAZING, float(y[0]), float(phase[0]), touch.off * slope)


def _touch(orbit: Callable[[float], Orbit], good: float, bad: float) -> _Touch | None:
    """The place between the two at which the first motion ceases to be what makes it possible; None when unseen."""
    depth = _fault(orbit(bad))

    def excess(places: Array) -> Array:
        return np.array([depth(orbit(place)) for place in places.tolist()])

    ends = np.array([good]), np.array([bad])
    values = excess(ends[0]), excess(ends[1])
    if not values[0][0] < 0.0 < values[1][0]:
        return None
    place = float(bracketed_roots(excess, *ends, *values)[0])
    around = excess(np.clip(np.array([place - _SLOPE, place, place + _SLOPE]), min(good, bad), max(good, bad)))
    rise = float(around[2] - around[0])
    return _Touch(place, abs(float(around[1]) / rise) * 2.0 * _SLOPE if rise else math.nan)


def _fault(motion: Orbit) -> Callable[[Orbit], float]:
    """What is wrong with a motion, as a function of motions: positive where it is wrong, negative where it is right."""
    if motion.impact_velocity <= 0.0:
        return lambda other: -other.impact_velocity
    if not motion.system.contact.rebounds and start_acceleration(motion) >= 0.0:
        return start_acceleration
    low, high = _beyond(motion)
    return lambda other: _highest(other, low, high)


def _beyond(motion: Orbit) -> tuple[float, float]:
    """The times about a passage through the wall at whose ends the bar is off it, or at an impact."""
    modes, when = motion.truncation.some, a_passage(motion)
    reach = _fine(motion, modes)
    low, high = max(when - reach, 0.0), min(when + reach, motion.period)
    while reach < motion.period:
        y = motion.end_motion(np.array([low, high]), modes)[0]
        if y.max() < 0.0 or (low == 0.0 and high == motion.period):
            break
        reach *= 2.0
        low = max(low - reach, 0.0) if y[0] >= 0.0 else low
        high = min(high + reach, motion.period) if y[1] >= 0.0 else high
    step = min(_fine(motion, modes), 0.25 * (high - low))
    return max(low, step), min(high, motion.period - step)


def _fine(motion: Orbit, modes: int) -> float:
    """A step of time that shows every maximum of so many modes, and of the load."""
    load = motion.system.load
    ringing = float(motion.system.body.modes(modes, load.at).omega[-1]) if modes else 0.0
    fastest = max(ringing, float(load.harmonics.max(initial=1)), 16.0)
    return 2.0 * math.pi / (6.0 * fastest)


def _highest(motion: Orbit, low: float, high: float) -> float:
    """The greatest y between two times: where bounds leave room for it, and there with all modes."""
    count = math.ceil((high - low) / _fine(motion, motion.truncation.some)) + 1
    if count <= _MANY:
        t = np.linspace(low, high, max(count, 5))
    else:
        centres, half = tops(motion, low, high)
        t = np.unique(np.clip(np.concatenate([centres - half, centres, centres + half]), low, high))
    y = motion.end_motion(t, motion.truncation.some)[0]
    middle = np.append(np.insert((y[1:-1] >= y[:-2]) & (y[1:-1] >= y[2:]), 0, y[0] >= y[1]), y[-1] >= y[-2])
    found = np.flatnonzero(middle & (y >= y.max() - _NEAR * motion.rigid_stroke))
    found = found[np.argsort(-y[found])][:_PEAKS]
    return max(_peak(motion, float(t[max(i - 1, 0)]), float(t[min(i + 1, t.size - 1)])) for i in found.tolist())


def _peak(motion: Orbit, low: float, high: float) -> float:
    """The greatest y of one maximum, with all modes: ever narrower looks, then where the speed vanishes."""
    best = -math.inf
    while True:
        t = np.linspace(low, high, _LOOKS)
        y, speed = motion.end_motion(t, motion.modes)
        i = int(np.argmax(y))
        best = max(best, float(y[i]))
        low, high = float(t[max(i - 1, 0)]), float(t[min(i + 1, _LOOKS - 1)])
        if high - low < 1e-7 * motion.period or float(np.ptp(y)) <= 1e-15 * motion.rigid_stroke:
            break
    other = min(max(i + (1 if speed[i] > 0.0 else -1), 0), _LOOKS - 1)
    if speed[i] * speed[other] < 0.0:
        turn = t[i] + (t[other] - t[i]) * speed[i] / (speed[i] - speed[other])
        best = max(best, float(motion.end_motion(np.array([turn]), motion.modes)[0][0]))
    return best
