"""The greatest compression and tension in every section, over its whole length and the whole window."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from percuss.blow.course import Course
from percuss.blow.kernels.extremes import BLOCK, greatest_pair, piece_bounds
from percuss.model.checks import Array

__all__ = ["Extreme", "force_extremes"]

_NOTHING = 1e-12
"""Share of the greatest force of all sections that is rounding."""


class Extreme(NamedTuple):
    """A greatest force, the time of a wave from the section's left end to where it is, and when; None without any."""

    force: float
    place: float | None
    time: float | None


def force_extremes(course: Course) -> list[tuple[Extreme, Extreme]]:
    """Greatest compression and greatest tension of each section, in the scales of the blow."""
    found = [_of_section(course, i) for i in range(course.size)]
    least = _NOTHING * max(max(one.force, other.force) for one, other in found)
    return [(_or_none(one, least), _or_none(other, least)) for one, other in found]


def _or_none(extreme: Extreme, least: float) -> Extreme:
    return extreme if extreme.force > least else Extreme(0.0, None, None)


def _of_section(course: Course, section: int) -> tuple[Extreme, Extreme]:
    """N = Z (f − g), pairs of what left both ends (Kolsky 1963, ch. 3)."""
    z, tick = float(course.impedance[section]), course.tick
    if course.endless(section):
        pieces = course.trace(2 * section)
        peaks, falls = pieces.piece_peaks, pieces.scaled(-1.0).piece_peaks
        return _sent(pieces.times, peaks, z), _sent(pieces.times, falls, z)
    waves, transit = course.held.waves, course.transit[section]
    work, row = course.held.state.work, 2 * section
    found, pair = [], np.zeros(3)
    for sign in (1.0, -1.0):
        high, low = _bounds(course, row, sign), _bounds(course, row + 1, -sign)
        highs, lows = _greatest(high[0]), _greatest(low[0])
        order, near = np.argsort(-highs, kind="stable"), course.held.problem.near
        greatest_pair(waves, row, transit, course.end, near, sign, order, high, low, highs, lows, work, pair)
        value, s, r = pair.tolist()
        found.append(Extreme(z * value, 0.5 * tick * (transit + r - s), 0.5 * tick * (transit + r + s)))
    return found[0], found[1]


def _sent(times: Array, peaks: Array, z: float) -> Extreme:
    """In an endless section nothing comes back: every value passes everywhere, at its face first."""
    k = int(np.argmax(peaks))
    return Extreme(z * float(peaks[k]), 0.0, float(times[k]))


def _bounds(course: Course, row: int, sign: float) -> Array:
    """What a wave times a sign does not exceed in each piece, and a place yet to be found; shape (2, pieces)."""
    found = np.zeros((2, int(course.held.waves.pieces[row])))
    piece_bounds(course.held.waves, row, sign, found)
    return found


def _greatest(bounds: Array) -> Array:
    """The greatest of every block of pieces."""
    return np.asarray(np.maximum.reduceat(bounds, np.arange(0, bounds.size, BLOCK)))
