"""A blow as pictures in time: force and velocity in cells along striker and rod, and where the energy is."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from percuss.blow.bodies import Sections
from percuss.blow.kernels.wave_records import ROCK
from percuss.blow.wave_history import Trace, WaveHistory
from percuss.model.checks import Array, count, positive

if TYPE_CHECKING:
    from percuss.blow.blow import Blow


@dataclass(frozen=True, eq=False)
class CellsOverTime:
    """Force and velocity in the middle of cells along a body, shape (times, cells); no cell has a step within it.

    `edges` count from the driven end of the striker, or from the struck face of the rod. Compression is positive.
    """

    edges: Array
    section: npt.NDArray[np.intp]
    force: Array
    velocity: Array


@dataclass(frozen=True, eq=False)
class EnergyOverTime:
    """Where the energy is, each of shape (times,).

    `rod`: with the masses at its joints and the bit; `rock_stored`: what the rock could still give back.
    """

    rigid: Array
    vibration: Array
    rod: Array
    rock_dissipated: Array
    rock_stored: Array


def cells_over_time(blow: Blow, times: Array, cells: int, reach: float) -> tuple[CellsOverTime, CellsOverTime | None]:
    """Of the striker, and of the rod (None for a wall), at times in the window, in about so many cells of each body.

    `reach`: how far an endless section is told of, in the units of the rod's places.

    Examples
    --------
    >>> from percuss.blow import Wall, strike
    >>> from percuss.model import UniformBar
    >>> own, rod = cells_over_time(strike(UniformBar(1.0), Wall(), 1.0), np.array([0.5]), 4, 1.0)
    >>> own.force.round(9).tolist(), rod
    ([[0.0, 0.0, 1.0, 1.0]], None)
    """
    ticks = np.clip(times / (blow._scales.time * blow._course.tick), 0.0, blow._course.end)
    rod = blow._question.rod
    own = _cells(blow, 0, blow._question.sections, ticks, cells, reach)
    return own, None if rod is None else _cells(blow, blow._course.striker, rod, ticks, cells, reach)


def _cells(blow: Blow, first: int, sections: Sections, ticks: Array, cells: int, reach: float) -> CellsOverTime:
    course, force, velocity = blow._course, [], []
    edges, section, shares = _grid(sections, cells, reach)
    for number, (length, share) in enumerate(shares):
        i = first + number
        if course.endless(i):
            delay = share * length / (sections.speed[number] * blow._scales.time * course.tick)
        else:
            delay = share * course.transit[i]
        right, left = _waves(course, i, ticks[:, None], delay)
        z = course.impedance[i]
        force.append(blow._scales.force * z * (right - left))
        velocity.append(blow._scales.velocity * (right + left))
    return CellsOverTime(edges, section, np.concatenate(force, axis=1), np.concatenate(velocity, axis=1))


def _grid(
    sections: Sections, cells: int, reach: float
) -> tuple[Array, npt.NDArray[np.intp], list[tuple[float, Array]]]:
    """Edges and sections of about so many cells; of each section its length, and where in it the cells' middles are."""
    lengths = np.where(np.isfinite(sections.length), sections.length, reach)
    edges, section, shares = [np.zeros(1)], [], []
    for number, length in enumerate(lengths.tolist()):
        count = max(2, round(cells * length / float(lengths.sum())))
        shares.append((length, (np.arange(count) + 0.5) / count))
        edges.append(edges[-1][-1] + length * np.arange(1, count + 1) / count)
        section.append(np.full(count, number))
    return np.concatenate(edges), np.concatenate(section), shares


def _waves(course: WaveHistory, section: int, ticks: Array, delay: Array) -> tuple[Array, Array]:
    """Both waves so far from the left end of a section, in ticks; where none has come there is none."""
    span, tick = course.transit[section], course.tick
    last = _last(course, float(ticks.max(initial=0.0)))
    if course.endless(section):
        begun = ticks - delay
        right = np.where(begun >= 0.0, course.trace(2 * section, 0, 0, last).at(begun * tick), 0.0)
        return right, np.zeros_like(right)
    f, g = _rows(course, section, last)
    return f.at((ticks - delay) * tick), g.at((ticks - (span - delay)) * tick)


def _last(course: WaveHistory, tick: float) -> int:
    """A tick of the window not before this one: later waves need not be looked at."""
    return min(max(int(np.ceil(tick)), course.end // 1000, 1), course.end)


def _rows(course: WaveHistory, section: int, last: int) -> tuple[Trace, Trace]:
    """Both waves of a section with an end, from what was in it before on."""
    back = course.transit[section]
    return course.trace(2 * section, 0, -back, last), course.trace(2 * section + 1, 0, -back, last)


# -- energies ----------------------------------------------------------------------------------------------------------


def energy_over_time(blow: Blow, times: Array) -> EnergyOverTime:
    """Where the energy is at times in the window; together with the work of the load it stays the same.

    Examples
    --------
    >>> from percuss.blow import Wall, strike
    >>> from percuss.model import UniformBar
    >>> found = energy_over_time(strike(UniformBar(1.0), Wall(), 1.0), np.array([0.0, 1.0, 2.0]))
    >>> found.rigid.round(9).tolist(), found.vibration.round(9).tolist()
    ([0.5, 0.0, 0.5], [0.0, 0.5, 0.0])
    """
    course = blow._course
    t = np.clip(times / blow._scales.time, 0.0, course.end * course.tick)
    striker, momentum = np.zeros(t.size), np.zeros(t.size)
    for i in range(course.striker):
        energy, own = _section_sums(course, i, t)
        striker, momentum = striker + energy, momentum + own
    rod = np.zeros(t.size)
    for i in range(course.striker, course.size if course.has_rod else course.striker):
        rod = rod + _section_sums(course, i, t)[0]
    if course.has_rod:
        joints, bit = course.lumped_energy([min(round(time / course.tick), course.end) for time in t.tolist()])
        rod = rod + (joints + bit)
    rigid = 0.5 * momentum**2 / course.mass
    dissipated, stored = _rock(course, t)
    parts = (rigid, np.maximum(striker - rigid, 0.0), rod, dissipated, stored)
    return EnergyOverTime(*(blow._scales.energy * part for part in parts))


def _section_sums(course: WaveHistory, section: int, t: Array) -> tuple[Array, Array]:
    """Energy Z ∫(f² + g²) and momentum Z ∫(f + g) over the time that a wave is in the section."""
    z = float(course.impedance[section])
    last = _last(course, float(t.max(initial=0.0)) / course.tick)
    if course.endless(section):
        plain, square = _cumulated(course.trace(2 * section, 0, 0, last), t)
        return z * square, z * plain
    back = course.transit[section] * course.tick
    energy, momentum = np.zeros(t.size), np.zeros(t.size)
    for row in _rows(course, section, last):
        plain, square = _cumulated(row, np.concatenate([t - back, t]))
        energy += z * (square[t.size :] - square[: t.size])
        momentum += z * (plain[t.size :] - plain[: t.size])
    return energy, momentum


def _cumulated(trace: Trace, times: Array) -> tuple[Array, Array]:
    """∫ and ∫ of the square from the trace's beginning to each time, by Gauss's rule between breaks and times."""
    edges = np.unique(np.concatenate([trace.times, np.clip(times, trace.times[0], trace.times[-1])]))
    nodes, weights = np.polynomial.legendre.leggauss(trace.coefficients.shape[1])
    half = 0.5 * np.diff(edges)[:, None]
    values = trace.at(edges[:-1, None] + half * (1.0 + nodes))
    place = np.searchsorted(edges, np.clip(times, edges[0], edges[-1]))
    plain, square = (np.append(0.0, np.cumsum(np.sum(half * weights * v, axis=1))) for v in (values, values**2))
    return plain[place], square[place]


def _rock(course: WaveHistory, t: Array) -> tuple[Array, Array]:
    """Lost and stored in the rock so far (Lundberg 1973)."""
    problem = course.held.problem
    if problem.end != ROCK:
        return np.zeros(t.size), np.zeros(t.size)
    depth, force = course.trace(2 * course.size + 1), course.trace(2 * course.size + 2)
    edges = np.sort(np.append(depth.times, t))
    deepest = np.maximum.accumulate(np.maximum(depth.before(edges), 0.0))
    greatest = deepest[np.searchsorted(edges, t)]
    dissipated = 0.5 * (1.0 - problem.ratio) * problem.stiffness * greatest**2
    return dissipated, 0.5 * force.before(t) ** 2 / problem.unloading


# ---- The greatest compression and tension at every place along striker and rod

_INSTANTS = 4000
"""Of the window, at which the force of bent waves is looked at; waves of no more pieces also between all breaks."""
_NO_WIDTH = 1e-9
"""Share of the window that lies between arrivals that coincide but for rounding."""


@dataclass(frozen=True, eq=False)
class ForceEnvelope:
    """The greatest forces over the window in the middle of such cells, shape (cells,); not negative."""

    edges: Array
    section: npt.NDArray[np.intp]
    compression: Array
    tension: Array


def force_envelope(blow: Blow, cells: int, reach: float) -> tuple[ForceEnvelope, ForceEnvelope | None]:
    """Of the striker, and of the rod (None for a wall).

    Stepwise waves are looked at between all their breaks, which is exact; bent waves, and those of very many pieces, at
    4000 instants. `Blow.peaks` has the greatest of each section, always exact.

    `cells`, `reach`: as for `cells_over_time`.

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
    course, extremes = blow._course, []
    edges, section, shares = _grid(sections, cells, reach)
    for number, (length, share) in enumerate(shares):
        i = first + number
        span = length / float(sections.speed[number]) / blow._scales.time
        factor = blow._scales.force * float(course.impedance[i])
        extremes.append(factor * _extremes(course, i, share * span))
    high, low = np.concatenate(extremes, axis=1)
    return ForceEnvelope(edges, section, np.maximum(high, 0.0), np.maximum(-low, 0.0))


def _extremes(course: WaveHistory, section: int, delays: Array) -> Array:
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
