"""The greatest compression and tension at every place along striker and rod."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from percuss.blow.course import Course
from percuss.blow.striker import Sections
from percuss.blow.trace import Trace
from percuss.model.checks import Array, count, positive

if TYPE_CHECKING:
    from percuss.blow.blow import Blow

__all__ = ["ForceEnvelope", "force_envelope"]

_INSTANTS = 4000
"""Of the window, at which the force of bent waves is looked at; waves of no more pieces also between all breaks."""
_NO_WIDTH = 1e-9
"""Share of the window that lies between arrivals that coincide but for rounding."""


@dataclass(frozen=True, eq=False)
class ForceEnvelope:
    """The greatest forces over the window in the middle of cells along a body; no cell has a step within it.

    Parameters
    ----------
    edges
        Of the cells, from the driven end of the striker or the struck face of the rod, shape (cells + 1,).
    section
        Number of the section of each cell, shape (cells,).
    compression, tension
        Shape (cells,); not negative.
    """

    edges: Array
    section: npt.NDArray[np.intp]
    compression: Array
    tension: Array


def force_envelope(blow: Blow, cells: int, reach: float) -> tuple[ForceEnvelope, ForceEnvelope | None]:
    """Of the striker, and of the rod (None for a wall).

    Stepwise waves are looked at between all their breaks, which is exact; bent waves, and those of very many pieces, at
    4000 instants. `Blow.peaks` has the greatest of each section, always exact.

    Parameters
    ----------
    cells
        About how many of each body; every section has some.
    reach
        How far an endless section is told of, in the units of the rod's places.

    Raises
    ------
    ParameterError
        For values out of range.

    Examples
    --------
    >>> from percuss.blow import Wall, strike
    >>> from percuss.model import SectionedBar, Section
    >>> striker = SectionedBar([Section(0.2, area=1e-3), Section(0.2, area=2e-3)])
    >>> blow = strike(striker, Wall(), 10.0)
    >>> own, _ = force_envelope(blow, 8, 1.0)
    >>> bool(own.compression.max() <= blow.face_force.peak)
    True
    """
    cells, reach = count("cells", cells, 1, 100_000), positive("reach", reach)
    rod = blow._question.rod
    own = _envelope(blow, 0, blow._question.sections, cells, reach)
    return own, None if rod is None else _envelope(blow, blow._course.striker, rod, cells, reach)


def _envelope(blow: Blow, first: int, sections: Sections, cells: int, reach: float) -> ForceEnvelope:
    course = blow._course
    lengths = np.where(np.isfinite(sections.length), sections.length, reach)
    edges, section, extremes = [np.zeros(1)], [], []
    for number, length in enumerate(lengths.tolist()):
        i = first + number
        size = max(2, round(cells * length / float(lengths.sum())))
        share = (np.arange(size) + 0.5) / size
        span = length / float(sections.speed[number]) / blow._time
        factor = blow._force * float(course.impedance[i])
        extremes.append(factor * _extremes(course, i, share * span))
        edges.append(edges[-1][-1] + length * np.arange(1, size + 1) / size)
        section.append(np.full(size, number))
    high, low = np.concatenate(extremes, axis=1)
    return ForceEnvelope(np.concatenate(edges), np.concatenate(section), np.maximum(high, 0.0), np.maximum(-low, 0.0))


def _extremes(course: Course, section: int, delays: Array) -> Array:
    """Greatest and least f − g so far from the left end of a section; shape (2, delays)."""
    end, back = course.end * course.tick, course.transit[section]
    f = course.trace(2 * section, 0, -back)
    g = None if course.endless(section) else course.trace(2 * section + 1, 0, -back)
    found = np.zeros((2, delays.size))
    for k, delay in enumerate(delays.tolist()):
        arrival = back * course.tick - delay
        times = _instants(f, delay, end) if g is None else _instants(f, delay, end, g, arrival)
        if g is None:
            times = times[times >= delay]  # before, nothing has come
        force = f.at(times - delay) - (0.0 if g is None else g.at(times - arrival))
        if force.size:
            found[:, k] = force.max(), force.min()
    return found


def _instants(f: Trace, delay: float, end: float, g: Trace | None = None, arrival: float = 0.0) -> Array:
    """Instants of the window between arrivals at a place, and at equal steps."""
    edges = [np.linspace(0.0, end, _INSTANTS + 1)]
    for wave, later in ((f, delay), (g, arrival)):
        if wave is not None and wave.times.size <= _INSTANTS:
            edges.append(np.clip(wave.times + later, 0.0, end))
    times = np.sort(np.concatenate(edges))
    wide = np.diff(times) > _NO_WIDTH * end
    return np.asarray((0.5 * (times[1:] + times[:-1]))[wide])
