"""The greatest compression and tension in every section, over its whole length and the whole window."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from percuss.blow.bodies import Sections
from percuss.blow.kernels.extremes import BLOCK, greatest_pair, piece_bounds
from percuss.blow.wave_history import WaveHistory
from percuss.model.checks import Array

_NOTHING = 1e-12
"""Share of the greatest force of all sections that is rounding."""


class Extreme(NamedTuple):
    """A greatest force, the time of a wave from the section's left end to where it is, and when; None without any."""

    force: float
    place: float | None
    time: float | None


def force_extremes(course: WaveHistory) -> list[tuple[Extreme, Extreme]]:
    """Greatest compression and greatest tension of each section, in the scales of the blow."""
    found = [_of_section(course, i) for i in range(course.size)]
    least = _NOTHING * max(max(one.force, other.force) for one, other in found)
    return [(_or_none(one, least), _or_none(other, least)) for one, other in found]


def _or_none(extreme: Extreme, least: float) -> Extreme:
    return extreme if extreme.force > least else Extreme(0.0, None, None)


def _of_section(course: WaveHistory, section: int) -> tuple[Extreme, Extreme]:
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


def _bounds(course: WaveHistory, row: int, sign: float) -> Array:
    """What a wave times a sign does not exceed in each piece, and a place yet to be found; shape (2, pieces)."""
    found = np.zeros((2, int(course.held.waves.pieces[row])))
    piece_bounds(course.held.waves, row, sign, found)
    return found


def _greatest(bounds: Array) -> Array:
    """The greatest of every block of pieces."""
    return np.asarray(np.maximum.reduceat(bounds, np.arange(0, bounds.size, BLOCK)))


# ---- Force and velocity along striker and rod at one time: for x–t diagrams and moving pictures

_POINTS = np.linspace(0.0, 1.0, 9)  # of a piece that is no constant


@dataclass(frozen=True, eq=False)
class AlongBody:
    """Force and velocity along a body, with both values at each jump.

    Parameters
    ----------
    places
        From the driven end of the striker or the struck face of the rod, not decreasing, shape (n,); an endless section
        goes as far as its waves have come.
    force, velocity
        There: compression positive, and toward the rock positive; shape (n,).
    section
        Number of the section that each point belongs to, shape (n,).
    """

    places: Array
    force: Array
    velocity: Array
    section: Array


@dataclass(frozen=True, eq=False)
class StringState:
    """Striker and rod at one time; `rod` is None where the target is a wall."""

    time: float
    striker: AlongBody
    rod: AlongBody | None


def along(
    course: WaveHistory, first: int, sections: Sections, tick: int, unit: float
) -> tuple[Array, Array, Array, Array]:
    """Places, forces, velocities and numbers of sections of a body whose first section is `first`, at a tick.

    `unit` is the time of the blow's scale; places are in the units of the sections, the rest in the scales of the blow.
    """
    parts, start = [], 0.0
    for number in range(sections.impedance.size):
        i = first + number
        span = tick if course.endless(i) else course.transit[i]
        length = sections.speed[number] * tick * course.tick * unit if course.endless(i) else sections.length[number]
        if span == 0:
            continue
        f = course.trace(2 * i, 0, tick - span, tick)
        if course.endless(i):
            edges = np.unique(tick * course.tick - f.times)
        else:
            g = course.trace(2 * i + 1, 0, tick - span, tick)
            edges = np.unique(np.concatenate([tick * course.tick - f.times, g.times - (tick - span) * course.tick]))
        edges = edges[np.append(True, np.diff(edges) > 1e-12 * span * course.tick)]
        edges[0], edges[-1] = 0.0, span * course.tick
        bent = f.coefficients.shape[1] > 1 or (not course.endless(i) and g.coefficients.shape[1] > 1)
        share = _POINTS if bent else _POINTS[[0, -1]]
        middle, half = 0.5 * (edges[:-1] + edges[1:])[:, None], 0.5 * np.diff(edges)[:, None]
        y = middle + half * (2.0 * share - 1.0) * (1.0 - 1e-9)  # each side of a jump has its own value
        right = f.at(tick * course.tick - y)
        left = np.zeros_like(right) if course.endless(i) else g.at((tick - span) * course.tick + y)
        places = edges[:-1, None] + np.diff(edges)[:, None] * share
        z = course.impedance[i]
        scaled = start + length * places / (span * course.tick)
        parts.append((scaled.ravel(), (z * (right - left)).ravel(), (right + left).ravel(), np.full(y.size, number)))
        start += float(length)
    joined = [np.concatenate(column) for column in zip(*parts, strict=True)] if parts else [np.zeros(0)] * 4
    return joined[0], joined[1], joined[2], joined[3]
