"""The greatest compression and tension in every section, over its whole length and the whole window."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from percuss.blow.course import Course
from percuss.blow.kernels.extremes import greatest_pair, piece_extremes
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
    f, g = _extremes(course, row), _extremes(course, row + 1)
    found, pair = [], np.zeros(3)
    for sign in (1.0, -1.0):
        high = f[[0, 2]] if sign > 0.0 else -f[[1, 3]] * [[1.0], [-1.0]]
        low = g[[1, 3]] if sign > 0.0 else -g[[0, 2]] * [[1.0], [-1.0]]
        greatest_pair(waves, row, transit, course.end, course.held.problem.near, sign, high, low, work, pair)
        value, s, r = pair.tolist()
        found.append(Extreme(z * value, 0.5 * tick * (transit + r - s), 0.5 * tick * (transit + r + s)))
    return found[0], found[1]


def _sent(times: Array, peaks: Array, z: float) -> Extreme:
    """In an endless section nothing comes back: every value passes everywhere, at its face first."""
    k = int(np.argmax(peaks))
    return Extreme(z * float(peaks[k]), 0.0, float(times[k]))


def _extremes(course: Course, row: int) -> Array:
    """Greatest and least value of each piece, and where; shape (4, pieces)."""
    found = np.zeros((4, int(course.held.waves.pieces[row])))
    piece_extremes(course.held.waves, row, found, course.held.state.work)
    return found
