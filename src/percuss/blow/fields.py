"""Fields along striker and rod: at one time, in cells over time, where the energy is, and the greatest forces."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from numpy.polynomial.chebyshev import chebpts1, chebval, chebvander

from percuss.blow.bodies import Sections
from percuss.blow.figures import Peak
from percuss.blow.kernels.extremes import BLOCK, greatest_at, greatest_pair, piece_bounds
from percuss.blow.kernels.wave_records import ROCK
from percuss.blow.wave_history import Trace, WaveHistory, turning_points
from percuss.model.checks import Array

# ---- Force and velocity along striker and rod at one time: for x–t diagrams and moving pictures

_POINTS = np.linspace(0.0, 1.0, 9)  # of a piece that is no constant


@dataclass(frozen=True, eq=False)
class AlongBody:
    """Force and velocity along a body, with both values at each jump; every array of shape (n,).

    Places count from the driven end of the striker or the struck face of the rod and do not decrease; an endless
    section goes as far as its waves have come. Compression is positive, and so is a velocity toward the rock. `section`
    is the number of the section that each point belongs to.
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


def along(course: WaveHistory, first: int, sections: Sections, tick: int) -> AlongBody:
    """A body whose first section is `first`, at a tick."""
    parts, start, scales = [], 0.0, course.scales
    for number in range(sections.impedance.size):
        i = first + number
        endless = course.endless(i)
        span = tick if endless else course.transit[i]
        length = sections.speed[number] * tick * course.tick * scales.time if endless else sections.length[number]
        if span == 0:
            continue
        f = course.trace(2 * i, 0, tick - span, tick)
        g = None if endless else course.trace(2 * i + 1, 0, tick - span, tick)
        edges = tick * course.tick - f.times
        if g is not None:
            edges = np.concatenate([edges, g.times - (tick - span) * course.tick])
        edges = np.unique(edges)
        edges = edges[np.append(True, np.diff(edges) > 1e-12 * span * course.tick)]
        edges[0], edges[-1] = 0.0, span * course.tick
        bent = f.coefficients.shape[1] > 1 or (g is not None and g.coefficients.shape[1] > 1)
        share = _POINTS if bent else _POINTS[[0, -1]]
        middle, half = 0.5 * (edges[:-1] + edges[1:])[:, None], 0.5 * np.diff(edges)[:, None]
        y = middle + half * (2.0 * share - 1.0) * (1.0 - 1e-9)  # each side of a jump has its own value
        right = f.at(tick * course.tick - y) * course.fade(i, y)
        left = np.zeros_like(right) if g is None else g.at((tick - span) * course.tick + y)
        left = left * course.fade(i, span * course.tick - y)
        places = edges[:-1, None] + np.diff(edges)[:, None] * share
        z = course.impedance[i]
        scaled = start + length * places / (span * course.tick)
        force = z * (right - left) + course.preload(i)
        parts.append((scaled.ravel(), force.ravel(), (right + left).ravel(), np.full(y.size, number)))
        start += float(length)
    places, force, velocity, section = (
        [np.concatenate(column) for column in zip(*parts, strict=True)] if parts else [np.zeros(0)] * 4
    )
    return AlongBody(places, force * scales.force, velocity * scales.velocity, section)


# ---- Force and velocity in cells along a body over time


@dataclass(frozen=True, eq=False)
class CellsOverTime:
    """Force and velocity in the middle of cells along a body, shape (times, cells); no cell has a step within it.

    `edges` count from the driven end of the striker, or from the struck face of the rod. Compression is positive.
    """

    edges: Array
    section: npt.NDArray[np.intp]
    force: Array
    velocity: Array


def cells(course: WaveHistory, first: int, sections: Sections, ticks: Array, size: int, reach: float) -> CellsOverTime:
    """A body whose first section is `first`, at ticks, in about so many cells."""
    force, velocity, scales = [], [], course.scales
    edges, section, shares = _grid(sections, size, reach)
    for number, (length, share) in enumerate(shares):
        i = first + number
        if course.endless(i):
            delay = share * length / (sections.speed[number] * scales.time * course.tick)
        else:
            delay = share * course.transit[i]
        right, left = _waves(course, i, ticks[:, None], delay)
        z = course.impedance[i]
        force.append(scales.force * (z * (right - left) + course.preload(i)))
        velocity.append(scales.velocity * (right + left))
    return CellsOverTime(edges, section, np.concatenate(force, axis=1), np.concatenate(velocity, axis=1))


def _grid(sections: Sections, size: int, reach: float) -> tuple[Array, npt.NDArray[np.intp], list[tuple[float, Array]]]:
    """Edges and sections of about so many cells; of each section its length, and where in it the cells' middles are."""
    lengths = np.where(np.isfinite(sections.length), sections.length, reach)
    edges, section, shares = [np.zeros(1)], [], []
    for number, length in enumerate(lengths.tolist()):
        count = max(2, round(size * length / float(lengths.sum())))
        shares.append((length, (np.arange(count) + 0.5) / count))
        edges.append(edges[-1][-1] + length * np.arange(1, count + 1) / count)
        section.append(np.full(count, number))
    return np.concatenate(edges), np.concatenate(section), shares


def _waves(course: WaveHistory, section: int, ticks: Array, delay: Array) -> tuple[Array, Array]:
    """Both waves so far from the left end of a section, in ticks; where none has come there is none."""
    tick, rows = course.tick, _rows(course, section, float(ticks.max(initial=0.0)))
    if len(rows) == 1:
        begun = ticks - delay
        right = np.where(begun >= 0.0, rows[0].at(begun * tick), 0.0) * course.fade(section, delay * tick)
        return right, np.zeros_like(right)
    back = course.transit[section] - delay
    right, left = rows[0].at((ticks - delay) * tick), rows[1].at((ticks - back) * tick)
    return right * course.fade(section, delay * tick), left * course.fade(section, back * tick)


def _rows(course: WaveHistory, section: int, tick: float) -> list[Trace]:
    """Both waves of a section until a tick of the window, from what was in it before on; one of an endless section."""
    last = min(max(int(np.ceil(tick)), course.end // 1000, 1), course.end)  # later waves need not be looked at
    back, ways = course.transit[section], 1 if course.endless(section) else 2
    return [course.trace(2 * section + way, 0, -back, last) for way in range(ways)]


# ---- Where the energy is over time


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


def energy_over_time(course: WaveHistory, times: Array) -> EnergyOverTime:
    t = np.clip(times / course.scales.time, 0.0, course.end * course.tick)
    striker, momentum, rod = np.zeros(t.size), np.zeros(t.size), np.zeros(t.size)
    for i in range(course.size):
        energy, own = _section_sums(course, i, t)
        if i < course.striker:
            striker, momentum = striker + energy, momentum + own
        else:
            rod = rod + energy
    if course.has_rod:
        joints, bit = course.lumped_energy([min(round(time / course.tick), course.end) for time in t.tolist()])
        rod = rod + (joints + bit)
    rigid = 0.5 * momentum**2 / course.mass
    parts = (rigid, np.maximum(striker - rigid, 0.0), rod, *_rock(course, t))
    return EnergyOverTime(*(course.scales.energy * part for part in parts))


def _section_sums(course: WaveHistory, section: int, t: Array) -> tuple[Array, Array]:
    """Energy Z ∫(f² + g²) and momentum Z ∫(f + g) over the time that a wave is in the section."""
    z, rows = float(course.impedance[section]), _rows(course, section, float(t.max(initial=0.0)) / course.tick)
    if len(rows) == 1:
        plain, square = _cumulated(rows[0], t)
        return z * square, z * plain
    back, rate = course.transit[section] * course.tick, course.rate[section]
    energy, momentum, left = np.full(t.size, course.static_energy(section)), np.zeros(t.size), course.fade(section, t)
    for row, sign in zip(rows, (1.0, -1.0), strict=True):
        plain, square = _cumulated(row, np.concatenate([t - back, t]), rate)
        gone = left * (plain[t.size :] - plain[: t.size])
        energy += z * left**2 * (square[t.size :] - square[: t.size]) + sign * course.preload(section) * gone
        momentum += z * gone
    return energy, momentum


def _cumulated(trace: Trace, times: Array, rate: float = 0.0) -> tuple[Array, Array]:
    """∫ and ∫ of the square from the trace's beginning to each time, by Gauss's rule between breaks and times.

    With a rate, of the trace times e^{rate t}.
    """
    edges = np.unique(np.concatenate([trace.times, np.clip(times, trace.times[0], trace.times[-1])]))
    nodes, weights = np.polynomial.legendre.leggauss(trace.coefficients.shape[1] + (8 if rate else 0))
    half = 0.5 * np.diff(edges)[:, None]
    at = edges[:-1, None] + half * (1.0 + nodes)
    values = trace.at(at) * np.exp(rate * at) if rate else trace.at(at)
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
    deepest = np.maximum.accumulate(np.maximum(depth.before(edges), course.crater))
    greatest = deepest[np.searchsorted(edges, t)]
    dissipated = 0.5 * (1.0 - problem.ratio) * problem.stiffness * (greatest**2 - course.crater**2)
    return dissipated, 0.5 * force.before(t) ** 2 / problem.unloading


# ---- The greatest compression and tension at every place of a body

_INSTANTS = 4000
"""Of the window, at which the force of bent waves is looked at; waves of no more pieces also between all breaks."""
_NO_WIDTH = 1e-9  # share of the window that lies between arrivals that coincide but for rounding


@dataclass(frozen=True, eq=False)
class ForceEnvelope:
    """The greatest forces over the window in the middle of such cells, shape (cells,); not negative."""

    edges: Array
    section: npt.NDArray[np.intp]
    compression: Array
    tension: Array


def envelope(course: WaveHistory, first: int, sections: Sections, size: int, reach: float) -> ForceEnvelope:
    """Of a body whose first section is `first`."""
    extremes = []
    edges, section, shares = _grid(sections, size, reach)
    for number, (length, share) in enumerate(shares):
        i = first + number
        span = length / float(sections.speed[number]) / course.scales.time
        factor = course.scales.force * float(course.impedance[i])
        extremes.append(factor * _at_places(course, i, share * span))
    high, low = np.concatenate(extremes, axis=1)
    return ForceEnvelope(edges, section, np.maximum(high, 0.0), np.maximum(-low, 0.0))


def _at_places(course: WaveHistory, section: int, delays: Array) -> Array:
    """Greatest and least f − g so far from the left end of a section; shape (2, delays)."""
    end, back = course.end * course.tick, course.transit[section]
    f, *others = _rows(course, section, float(course.end))
    found = np.zeros((2, delays.size))
    for k, delay in enumerate(delays.tolist()):
        arrivals = [(f, delay), *((g, back * course.tick - delay) for g in others)]
        times = _instants(arrivals, end)
        if not others:
            times = times[times >= delay]  # before, nothing has come
        force = f.at(times - delay) * course.fade(section, delay) + course.preload(section) / course.impedance[section]
        force -= sum(g.at(times - later) * course.fade(section, later) for g, later in arrivals[1:])
        if force.size:
            found[:, k] = force.max(), force.min()
    return found


def _instants(arrivals: list[tuple[Trace, float]], end: float) -> Array:
    """Instants of the window between arrivals at a place, and at equal steps."""
    edges = [np.linspace(0.0, end, _INSTANTS + 1)]
    edges += [np.clip(wave.times + later, 0.0, end) for wave, later in arrivals if wave.times.size <= _INSTANTS]
    times = np.sort(np.concatenate(edges))
    wide = np.diff(times) > _NO_WIDTH * end
    return np.asarray((0.5 * (times[1:] + times[:-1]))[wide])


# ---- The force at places over the window, by its turning points, which are exact


def force_turns(course: WaveHistory, section: int, shares: Array) -> tuple[Array, ...]:
    """The force at shares of a section's length from its left end: both ends of each piece, and turns between them."""
    end, back = course.end * course.tick, course.transit[section] * course.tick
    rows, factor = _rows(course, section, float(course.end)), course.scales.force * float(course.impedance[section])
    found = []
    for share in shares.tolist():
        arrivals = [
            (wave, sign * float(course.fade(section, later)), later)
            for wave, sign, later in zip(rows, (factor, -factor), (share * back, back - share * back), strict=False)
        ]
        found.append(_turns(arrivals, end) + course.preload(section) * course.scales.force)
    return tuple(found)


def _turns(arrivals: list[tuple[Trace, float, float]], end: float) -> Array:
    """Of a sum of waves, each with a factor and with the time at which it arrives."""
    edges = np.concatenate([[0.0, end], *(np.clip(wave.times + later, 0.0, end) for wave, _, later in arrivals)])
    edges = np.unique(edges)
    edges = edges[np.append(True, np.diff(edges) > _NO_WIDTH * end)]
    middle, half = 0.5 * (edges[1:] + edges[:-1]), 0.5 * np.diff(edges)
    degrees = np.max([wave.degrees_at(middle - later) for wave, _, later in arrivals], axis=0)
    places, values = [], []
    for degree in np.unique(degrees).tolist():
        here = np.flatnonzero(degrees == degree)
        nodes = chebpts1(degree + 1)
        times = middle[here, None] + half[here, None] * nodes
        force = sum(sign * wave.at(times - later) for wave, sign, later in arrivals)
        series = force @ np.linalg.inv(chebvander(nodes, degree)).T
        for at, x in ((0.0, -1.0), (0.999, 1.0)):
            places.append(here + at)
            values.append(chebval(x, series.T))
        turning = (abs(series) * np.arange(degree + 1) ** 2)[:, 2:].sum(axis=1) > abs(series[:, 1:2]).sum(axis=1)
        for row, i in zip(series[turning], here[turning].tolist(), strict=True):
            turns = turning_points(row)
            places.append(i + 0.4995 * (1.0 + turns))
            values.append(chebval(turns, row))
    return np.concatenate(values)[np.argsort(np.concatenate(places), kind="stable")]


# ---- The greatest compression and tension in every section, over its whole length and the whole window, exactly

_NOTHING = 1e-12  # share of the greatest force of all sections that is rounding
_ENDS = np.array([1e-4, 2e-4, 5e-4, 1e-3, 2e-3, 4e-3, 8e-3])  # next to them short waves meet
_PLACES = np.concatenate([np.linspace(0.0, 1.0, 65), _ENDS, 1.0 - _ENDS])
"""Of a section that takes from its waves, at which its forces are looked at, besides where they would be greatest if it
took nothing: so a peak that is shorter than the distance between places may be missed."""
_Extreme = tuple[float, float, float]
"""A greatest force, the time of a wave from the section's left end to where it is, and when."""


def force_peaks(course: WaveHistory) -> tuple[Peak, ...]:
    """Of the sections of the striker, then of the rod."""
    found = [_of_section(course, i) for i in range(course.size)]
    least = _NOTHING * max(one[0] for both in found for one in both)
    time = course.scales.time

    def told(first: int, sections: Sections) -> list[Peak]:
        starts, peaks = np.append(0.0, np.cumsum(sections.length)), []
        for i, both in enumerate(found[first : first + sections.impedance.size]):
            factor = course.scales.force / (1.0 if sections.area is None else float(sections.area[i]))
            values: list[Any] = []
            for force, place, when in both:
                there = float(starts[i]) + place * time * float(sections.speed[i])
                values += [factor * force, there, when * time] if force > least else [0.0, None, None]
            peaks.append(Peak(*values))
        return peaks

    own, rod = course.of_each(told)
    return (*own, *(rod or ()))


def _of_section(course: WaveHistory, section: int) -> tuple[_Extreme, _Extreme]:
    """N = Z (f − g), pairs of what left both ends (Kolsky 1963, ch. 3)."""
    z, tick = float(course.impedance[section]), course.tick
    if course.endless(section):
        pieces = course.trace(2 * section)
        return _sent(pieces.times, pieces.piece_peaks, z), _sent(pieces.times, pieces.scaled(-1.0).piece_peaks, z)
    waves, transit = course.held.waves, course.transit[section]
    work, row, near = course.held.state.work, 2 * section, course.held.problem.near
    found, pair = [], np.zeros(3)
    for sign in (1.0, -1.0):
        high, low = _bounds(course, row, sign), _bounds(course, row + 1, -sign)
        highs, lows = (np.maximum.reduceat(one[0], np.arange(0, one[0].size, BLOCK)) for one in (high, low))
        order = np.argsort(-highs, kind="stable")
        greatest_pair(waves, row, transit, course.end, near, sign, order, high, low, highs, lows, work, pair)
        value, s, r = pair.tolist()
        place, when = 0.5 * tick * (transit + r - s), 0.5 * tick * (transit + r + s)
        if course.rate[section] != 0.0:
            alike, value = 0.5 * (transit + r - s) / transit, -math.inf
            for share in (alike, *_PLACES.tolist()):
                back = min(max(round(share * transit), 0), transit)
                left = [float(course.fade(section, tick * time)) for time in (back, transit - back)]
                greatest_at(waves, row, back, transit - back, course.end, near, sign, *left, high, low, work, pair)
                if pair[0] > value:
                    value, place, when = float(pair[0]), tick * back, tick * float(pair[1])
        found.append((z * value + sign * course.preload(section), place, when))
    return found[0], found[1]


def _sent(times: Array, peaks: Array, z: float) -> _Extreme:
    """In an endless section nothing comes back: every value passes everywhere, at its face first."""
    k = int(np.argmax(peaks))
    return z * float(peaks[k]), 0.0, float(times[k])


def _bounds(course: WaveHistory, row: int, sign: float) -> Array:
    """What a wave times a sign does not exceed in each piece, and a place yet to be found; shape (2, pieces)."""
    found = np.zeros((2, int(course.held.waves.pieces[row])))
    piece_bounds(course.held.waves, row, sign, found)
    return found
