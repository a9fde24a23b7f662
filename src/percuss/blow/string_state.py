"""Force and velocity along striker and rod at one time: for x–t diagrams and moving pictures."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from percuss.blow.course import Course
from percuss.blow.striker import Sections
from percuss.model.checks import Array

__all__ = ["AlongBody", "StringState", "along"]

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


def along(course: Course, first: int, sections: Sections, tick: int, unit: float) -> tuple[Array, Array, Array, Array]:
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
