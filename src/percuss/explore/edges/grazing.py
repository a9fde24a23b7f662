"""Where a steady motion begins or ceases to be possible: the striking end touches the wall between two impacts."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import lru_cache

import numpy as np
import numpy.typing as npt

from percuss.explore.edges.crossings import Crossing
from percuss.explore.edges.lines import Stretch, orbit_on
from percuss.explore.edges.roots import bracketed_roots
from percuss.model.checks import Array
from percuss.steady import Orbit

__all__ = ["GRAZING", "admissible_on", "grazings"]

GRAZING = "grazing"

_AWAY = 1e-3  # the samples stay this far inside: where the load ceases to push, touches are hard to tell from misses
_PLAIN = 1e-5  # share of the stroke beyond the wall that no error of the modes left out can make
_SLOPE = 1e-6  # half the step in t of slopes


def grazings(stretch: Stretch, samples: int) -> list[Crossing]:
    """Where the motion begins or ceases to be possible: the bar touches the wall between two impacts.

    At R = 0, where the bar starts from rest, also where it would start into the wall; and where the striking speed
    vanishes.
    """

    @lru_cache(maxsize=4096)
    def orbit(t: float) -> Orbit:
        return orbit_on(stretch, t)[0]

    return [crossing for _, crossing in _switches(stretch, orbit, stretch.nodes(samples, _AWAY))[1]]


def admissible_on(stretch: Stretch, t: Array, samples: int = 25) -> npt.NDArray[np.bool_]:
    """Whether the motions at many places of a branch are possible, from the places where that changes."""

    @lru_cache(maxsize=4096)
    def orbit(place: float) -> Orbit:
        return orbit_on(stretch, place)[0]

    first, switches = _switches(stretch, orbit, stretch.nodes(samples, _AWAY))
    turned = np.searchsorted(np.array([place for place, _ in switches]), np.asarray(t))
    return np.asarray((turned % 2 == 0) == first)


def _switches(
    stretch: Stretch, orbit: Callable[[float], Orbit], nodes: Array
) -> tuple[bool, list[tuple[float, Crossing]]]:
    """Whether the first motion is possible, and every place where that changes."""
    possible = [_possible(orbit(t)) for t in nodes.tolist()]
    found = []
    for i in range(nodes.size - 1):
        if possible[i] != possible[i + 1]:
            good, bad = (nodes[i], nodes[i + 1]) if possible[i] else (nodes[i + 1], nodes[i])
            found.append(_grazing(stretch, orbit, float(good), float(bad)))
    return possible[0], found


def _possible(motion: Orbit) -> bool:
    """Whether a motion is admissible; where a look is enough to say no, the proof is spared."""
    t = np.linspace(0.0, motion.period, 128 * motion.periods + 1)[1:-1]
    if float(motion.end_motion(t, motion.modes)[0].max()) > _PLAIN * motion.rigid_stroke:
        return False
    return motion.admissible


def _grazing(stretch: Stretch, orbit: Callable[[float], Orbit], good: float, bad: float) -> tuple[float, Crossing]:
    """Halves of the step until the touch can be followed in time; then a root of its depth; else halves to the end."""
    while abs(good - bad) > 4.0 * np.finfo(float).eps * max(good, bad):
        middle = 0.5 * (good + bad)
        if abs(good - bad) < 2e-2:
            touch = _touch(orbit, good, bad)
            if touch is not None:
                place, off = touch
                y, phase = stretch.place(np.array([place]))
                ys = stretch.place(np.array([max(place - _SLOPE, 0.0), min(place + _SLOPE, 1.0)]))[0]
                slope = abs(float(ys[1] - ys[0])) / (2.0 * _SLOPE)
                return place, Crossing(GRAZING, float(y[0]), float(phase[0]), off * slope)
        if _possible(orbit(middle)):
            good = middle
        else:
            bad = middle
    ys, phases = stretch.place(np.array([good, bad]))
    return good, Crossing(GRAZING, float(ys[0]), float(phases[0]), abs(float(ys[1] - ys[0])))


def _touch(orbit: Callable[[float], Orbit], good: float, bad: float) -> tuple[float, float] | None:
    """The root of the greatest interior maximum of the gap, if it is there on both sides; and the last step."""
    time = _greatest(orbit(bad), None)
    start = time if time is None else _greatest(orbit(good), time)
    if time is None or start is None:
        return None

    def depth(t: Array) -> Array:
        values = []
        for value in t.tolist():
            motion = orbit(value)
            when = _greatest(motion, time)
            values.append(math.nan if when is None else float(motion.end_motion(np.array([when]), motion.modes)[0][0]))
        return np.array(values)

    ends = np.array([good]), np.array([bad])
    values = depth(ends[0]), depth(ends[1])
    if not values[0][0] < 0.0 < values[1][0]:
        return None
    place = float(bracketed_roots(depth, *ends, *values)[0])
    around = depth(np.array([place - _SLOPE, place, place + _SLOPE]))
    if not np.all(np.isfinite(around)) or around[2] == around[0]:
        return None
    reach = 1e-9 * max(1.0, abs(place))
    sides = [orbit(min(max(place + step, 0.0), 1.0)).admissible for step in (-reach, reach)]
    if sides[0] == sides[1] or sides[0] != (good < bad):  # another touch comes first
        return None
    return place, abs(float(around[1]) / float(around[2] - around[0])) * 2.0 * _SLOPE


def _greatest(motion: Orbit, near: float | None) -> float | None:
    """When the gap has its greatest maximum between the impacts, or the maximum nearest to a given time; else None."""
    detail = 16 * max(4, 2 * int(min(motion.system.load.harmonics.max(initial=1), 64)))
    if near is None:
        t = np.linspace(0.0, motion.period, detail * motion.periods + 1)
    else:
        t = np.linspace(max(near - 0.3, 0.0), min(near + 0.3, motion.period), 129)
    _, speed = motion.end_motion(t, motion.modes)
    tops = np.flatnonzero((speed[:-1] > 0.0) & (speed[1:] <= 0.0))
    if not tops.size:
        return None

    def rate(when: Array) -> Array:
        return motion.end_motion(when, motion.modes)[1]

    times = bracketed_roots(rate, t[tops], t[tops + 1], speed[tops], speed[tops + 1])
    if near is not None:
        return float(times[np.argmin(np.abs(times - near))])
    return float(times[np.argmax(motion.end_motion(times, motion.modes)[0])])
