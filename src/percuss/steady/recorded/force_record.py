"""A recorded force blow by blow: the motion that it implies, its cycles and blows, and when it switches in each."""

from __future__ import annotations

import math
import warnings
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import Literal

import numpy as np
import numpy.typing as npt

from percuss.errors import LoadError, ParameterError
from percuss.mechanics.flow import phi1
from percuss.model import System
from percuss.model.checks import Array, finite, numbers
from percuss.recordings.cycle_fit import recorded_phases
from percuss.short_repr import ShortRepr
from percuss.steady.orbit import Orbit
from percuss.steady.phases import phase_condition
from percuss.steady.states import SteadyStates

# ---- The motion of the piston that a recorded force implies: from the mean cycle, or blow by blow through a record
#
# The piston is taken to be rigid, as its centre of mass is whatever the blow does to the elastic modes. With p the
# force per mass towards the wall and u = −x, u″ + d u′ = p, so that with V(t) = ∫ e^{−d(t−s)} p(s) ds and X = ∫ V u =
# X(t) − X(B) + (u′(B) − V(B)) (1 − e^{−d(t−B)})/d after a blow at the time B. That u is 0 at the next blow gives the
# speed u′(B) just after the first one, when the times of the blows are known; where they are not, they follow from
# the restitution, all at once (theory, "From a record to the valve").

_POINTS = 4096
_STEPS = 40
_CLOSED = 1e-10
_MOST_FADING = 30.0  # d t within which exponentials are summed
_LONGEST_STEP = 0.02  # of a period, of a blow in a step of Newton's method


@dataclass(frozen=True)
class Implied:
    """A rigid piston from blow to blow, (n,): two times at each inner blow, force per mass, place and rate; blows."""

    time: Array
    force: Array
    behind: Array
    velocity: Array
    blows: Array

    @property
    def speeds(self) -> Array:
        """Speed before each blow but the first."""
        return np.asarray(-self.velocity[np.searchsorted(self.time, self.blows[1:], side="left")])

    @property
    def rebounds(self) -> Array:
        """Speed after each blow but the last."""
        return np.asarray(self.velocity[np.searchsorted(self.time, self.blows[:-1], side="right") - 1])

    def at(self, time: npt.ArrayLike) -> tuple[Array, Array]:
        """Distance behind the wall and velocity away from it at any times within; cubic between the samples."""
        t = np.asarray(time, dtype=float)
        right = np.clip(np.searchsorted(self.time, t, side="right"), 1, self.time.size - 1)
        left = right - 1
        h = self.time[right] - self.time[left]
        h = np.where(h > 0.0, h, 1.0)
        s = np.clip((t - self.time[left]) / h, 0.0, 1.0)
        x, y, v, w = self.behind[left], self.behind[right], h * self.velocity[left], h * self.velocity[right]
        rise = y - x
        c2, c3 = 3.0 * rise - 2.0 * v - w, v + w - 2.0 * rise
        return x + s * (v + s * (c2 + s * c3)), (v + s * (2.0 * c2 + 3.0 * s * c3)) / h


def implied_by_orbit(orbit: Orbit) -> Implied:
    """One period from blow to blow of a steady motion under a clocked load, in the units of its system."""
    t = np.linspace(0.0, orbit.period, _POINTS + 1)
    moved, velocity = orbit.rigid_motion(t)
    force = np.asarray(orbit.system.load.value(orbit.phase + t))
    return Implied(t, force, -moved, -velocity, np.array([0.0, orbit.period]))


def implied_by_record(time: Array, force: Array, blows: Array, drag: float) -> Implied:
    """The motion from the first blow to the last (force per mass toward the wall), with rebounds that lead on."""
    through = _Through(time, force, drag)
    parts = []
    behind, ahead = np.searchsorted(time, blows, side="right").tolist(), np.searchsorted(time, blows).tolist()
    for i, (before, after) in enumerate(pairwise(blows.tolist())):
        t = np.concatenate([[before], time[behind[i] : ahead[i + 1]], [after]])
        start = -through.moved(before, after) / float(_faded(drag, after - before))
        u, v = through.from_blow(t, before, start)
        parts.append((t, np.interp(t, time, force), -u, -v))
    t, p, x, v = (np.concatenate(rows) for rows in zip(*parts, strict=True))
    return Implied(t, p, x, v, np.asarray(blows, dtype=float))


def sought_blows(time: Array, force: Array, blows: Array, drag: float, factor: float) -> Array | None:
    """The times of blows near given ones whose velocity is multiplied by a known factor, −R, or None; ends stay."""
    # With n flights 2n conditions, each ends at the wall and begins with the rebound before it, for n − 1 times and n +
    # 1 speeds.
    from scipy.sparse import csc_matrix
    from scipy.sparse.linalg import MatrixRankWarning, spsolve

    through, n = _Through(time, force, drag), blows.size - 1
    found, period = blows.astype(float).copy(), float(np.mean(np.diff(blows)))
    motion = implied_by_record(time, force, blows, drag)
    speeds = np.concatenate([motion.speeds[:1], motion.speeds])
    scale = float(np.mean(speeds))
    for _ in range(_STEPS):
        gap = np.diff(found)
        fade, ease = np.exp(-drag * gap), _faded(drag, gap)
        begin, end = through.velocity(found[:-1]), through.velocity(found[1:])
        start = factor * speeds[:-1] - begin  # u′ − V just after each blow
        closed = through.place(found[1:]) - through.place(found[:-1]) + start * ease
        struck = end + start * fade - speeds[1:]
        if max(np.abs(closed).max() / period, np.abs(struck).max()) <= _CLOSED * scale:
            return found
        pb, pe = np.interp(found[:-1], time, force), np.interp(found[1:], time, force)
        begun, ended = pb - drag * begin, pe - drag * end  # V′
        flight, speed = np.arange(n), n - 1 + np.arange(n)  # the times between the ends, then the speeds
        rows = (
            (flight, flight - 1, -begin - begun * ease - start * fade),
            (flight, np.where(flight < n - 1, flight, -1), end + start * fade),
            (flight, speed, factor * ease),
            (n + flight, flight - 1, -begun * fade + drag * start * fade),
            (n + flight, np.where(flight < n - 1, flight, -1), ended - drag * start * fade),
            (n + flight, speed, factor * fade),
            (n + flight, speed + 1, np.full(n, -1.0)),
        )
        i, j, entries = (np.concatenate(parts) for parts in zip(*rows, strict=True))
        moves = j >= 0  # the ends do not
        matrix = csc_matrix((entries[moves], (i[moves], j[moves])), shape=(2 * n, 2 * n))
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", MatrixRankWarning)
            step = np.asarray(spsolve(matrix, -np.concatenate([closed, struck])))
        if not np.all(np.isfinite(step)):
            return None
        longest = float(np.abs(step[: n - 1]).max(initial=0.0)) / (_LONGEST_STEP * period)
        step /= max(1.0, longest)
        found[1:-1] += step[: n - 1]
        speeds = speeds + step[n - 1 :]
        if np.any(np.diff(found) <= 0.0):
            return None
    return None


class _Through:
    """V and X of a sampled force, at any time; between the samples the force is linear."""

    def __init__(self, time: Array, force: Array, drag: float) -> None:
        self.time, self.force, self.drag = time, force, drag
        h = np.diff(time)
        gained = 0.5 * _faded(drag, h) * (force[1:] + force[:-1])
        self._velocity = _summed(time, gained, drag)
        bent = 0.5 * (force[:-1] - drag * self._velocity[:-1]) + np.diff(force) / 6.0
        self._place = np.concatenate([[0.0], np.cumsum(h * (self._velocity[:-1] + h * bent))])

    def velocity(self, t: npt.ArrayLike) -> Array:
        return self._at(t)[1]

    def place(self, t: npt.ArrayLike) -> Array:
        return self._at(t)[0]

    def moved(self, begin: float, end: float) -> float:
        """u at the end of a flight that begins at rest at the wall."""
        ease = float(_faded(self.drag, end - begin))
        return float(self.place(end) - self.place(begin) - self.velocity(begin) * ease)

    def from_blow(self, t: Array, begin: float, start: float) -> tuple[Array, Array]:
        """u and u′ after a blow at `begin`, with the velocity `start` just after it."""
        place, velocity = self._at(t)
        before, rate = self._at(begin)
        left = start - rate
        return place - before + left * _faded(self.drag, t - begin), velocity + left * np.exp(-self.drag * (t - begin))

    def _at(self, t: npt.ArrayLike) -> tuple[Array, Array]:
        t = np.asarray(t, dtype=float)
        left = np.clip(np.searchsorted(self.time, t, side="right") - 1, 0, self.time.size - 2)
        s, h = t - self.time[left], self.time[left + 1] - self.time[left]
        p, slope = self.force[left], (self.force[left + 1] - self.force[left]) / h
        v = self._velocity[left]
        acceleration = p - self.drag * v
        return (
            self._place[left] + s * (v + s * (0.5 * acceleration + s * slope / 6.0)),
            v + s * (acceleration + 0.5 * s * (slope - self.drag * acceleration)),
        )


def _summed(time: Array, gained: Array, drag: float) -> Array:
    """V at the samples: what is gained in each step, faded since; in blocks, so that no exponential is too large."""
    velocity = np.zeros(time.size)
    blocks = max(1, int(np.ceil(drag * (time[-1] - time[0]) / _MOST_FADING)))
    edges = np.unique(np.linspace(0, time.size - 1, blocks + 1).astype(int))
    for a, b in pairwise(edges.tolist()):
        grown = np.exp(drag * (time[a + 1 : b + 1] - time[a]))
        velocity[a + 1 : b + 1] = (velocity[a] + np.cumsum(grown * gained[a:b])) / grown
    return velocity


def _faded(drag: float, t: npt.ArrayLike) -> Array:
    """(1 − e^{−dt})/d."""
    t = np.asarray(t, dtype=float)
    return np.asarray(t * phi1(drag * t))


# ---- Where a recorded force switches: its edges, the levels between them, and how it grows with the distance behind
#
# An edge is where the mean force after a moment differs most from that before it. Its time is that of the step with the
# same momentum: ringing, noise and a gradual rise do not move it. The levels and the slope against the distance, which
# is the stiffness of a gas chamber, are those of least squares of the force between the edges.

WINDOW = 1.0 / 32.0  # of the period: over how long the force is averaged before and after an edge
_LEAST = 0.2  # of the range of the force, of a jump
_SAME = 0.12  # of the range, between levels of one state
_ROUNDS = 6
_CLEARLY = 4.0  # times better: an edge that is then on the other side of the blow


@dataclass(frozen=True)
class Levels:
    """What a force that switches is between edges, at the wall, plus `stiffness` per distance, and `scatter`."""

    at_wall: Array
    stiffness: float
    error: float
    scatter: float

    @property
    def states(self) -> tuple[list[int], list[float]]:
        """To which state each stretch belongs, and the forces of the states at the wall, in rising order."""
        order = np.argsort(self.at_wall)
        groups: list[list[int]] = [[int(order[0])]]
        least = _SAME * float(np.ptp(self.at_wall))
        for i in order[1:].tolist():
            if self.at_wall[i] - self.at_wall[groups[-1][-1]] > least:
                groups.append([])
            groups[-1].append(i)
        number = {i: n for n, group in enumerate(groups) for i in group}
        return [number[i] for i in range(self.at_wall.size)], [float(self.at_wall[group].mean()) for group in groups]


def changes(force: Array) -> Array:
    """By how much the mean force after each moment of one period at even distances is above that before it."""
    n, w = force.size, _samples(force)
    sums = np.concatenate([[0.0], np.cumsum(np.concatenate([force, force, force]))])
    i = np.arange(n, 2 * n)
    return np.asarray((sums[i + w] - 2.0 * sums[i] + sums[i - w]) / w)


def rough_edges(force: Array) -> npt.NDArray[np.intp]:
    """The edges of one period of a force at even distances, as indices of its samples, increasing."""
    w, change = _samples(force), changes(force)
    least = _LEAST * float(np.subtract(*np.percentile(force, [98.0, 2.0])))
    around = np.lib.stride_tricks.sliding_window_view(np.concatenate([change[-w:], change, change[:w]]), 2 * w + 1)
    size = np.abs(change)
    return np.flatnonzero((size >= np.abs(around).max(axis=1)) & (size > least))


def levels_between(motion: Implied, edges: Array, period: float, told: float, sloped: bool = True) -> Levels:
    """The levels of the stretches after each edge, and the slope against the distance; 0 unless `sloped`."""
    since = np.searchsorted(motion.blows, motion.time, side="right") - 1
    t = motion.time - motion.blows[np.clip(since, 0, motion.blows.size - 2)]
    stretch = (np.searchsorted(edges, t, side="right") - 1) % edges.size
    away = np.abs((t[:, None] - edges + 0.5 * period) % period - 0.5 * period).min(axis=1)
    kept = away > 0.5 * WINDOW * period
    size = edges.size
    rows = np.zeros((int(kept.sum()), size + 1))
    rows[np.arange(rows.shape[0]), stretch[kept]] = 1.0
    x, p = motion.behind[kept], motion.force[kept]
    scale = float(np.abs(x).max()) or 1.0
    rows[:, size] = x / scale if sloped else 0.0
    found, *_ = np.linalg.lstsq(rows, p, rcond=None)
    rest = p - rows @ found
    scatter = float(np.sqrt(np.mean(rest**2)))
    share = float(np.sqrt(np.linalg.pinv(rows.T @ rows)[size, size] * max(1.0, t.size / told)))
    return Levels(found[:size], float(found[size]) / scale, scatter * share / scale, scatter)


def edge_times(time: Array, force: Array, rough: Array, levels: tuple[Array, Array], window: float) -> Array:
    """The times of steps with the momentum of the force, less its slope, near each rough edge; NaN outside."""
    momentum = np.concatenate([[0.0], np.cumsum(0.5 * np.diff(time) * (force[1:] + force[:-1]))])
    before, after = levels
    now = rough.astype(float)
    for _ in range(_ROUNDS):
        a, b = now - window, now + window
        gained = np.interp(b, time, momentum) - np.interp(a, time, momentum)
        step = (before * (now - a) + after * (b - now) - gained) / (after - before)
        now = now + np.clip(step, -0.5 * window, 0.5 * window)
    now[(now - window < time[0]) | (now + window > time[-1])] = np.nan
    return now


def by_momentum(motion: Implied, edges: Array, levels: Levels) -> tuple[Array, Levels, int]:
    """The steps whose momentum from blow to blow is nearest to that of a mean cycle, and the same at the next blow.

    A force that falls gradually, before and behind the blow, is no step that has its momentum on both sides: an edge
    near the blow is tried on either side. The last number is by how many places that turns the edges round.
    """
    period = float(motion.blows[-1])
    near, tries = WINDOW * period, [(edges, 0)]
    if edges[-1] > period - near:
        tries.append((np.concatenate([[0.1 * near], edges[:-1]]), 1))
    if edges[0] < near:
        tries.append((np.concatenate([edges[1:], [period - 0.1 * near]]), -1))
    fits = [(*_by_momentum(motion, at, np.roll(levels.at_wall, turn), levels.stiffness), turn) for at, turn in tries]
    _, edges, at_wall, turn = min(fits, key=lambda one: one[0] * (_CLEARLY if one[-1] else 1.0))
    return edges, replace(levels, at_wall=at_wall), turn


def _by_momentum(motion: Implied, edges: Array, at_wall: Array, stiffness: float) -> tuple[float, Array, Array]:
    """The sum of squares that is left, the edges and the levels."""
    t, period = motion.time, float(motion.blows[-1])
    bare = motion.force - stiffness * motion.behind
    gained = np.concatenate([[0.0], np.cumsum(0.5 * np.diff(t) * (bare[1:] + bare[:-1]))])
    weight = np.where(t < t[-1], 1.0, float(t.size))[:, None]
    left = math.inf
    for _ in range(_ROUNDS):
        ends = np.concatenate([[0.0], edges, [period]])
        spent = np.clip(t[:, None], ends[:-1], ends[1:]) - ends[:-1]
        spent = spent[:, 1:] + np.pad(spent[:, :1], ((0, 0), (edges.size - 1, 0)))  # the last state goes on at the blow
        moved = (np.roll(at_wall, 1) - at_wall) * (t[:, None] > edges)
        rest = gained - spent @ at_wall
        left = float(np.sum(rest**2))
        step, *_ = np.linalg.lstsq(weight * np.hstack([spent, moved]), weight[:, 0] * rest, rcond=None)
        at_wall, edges = at_wall + step[: edges.size], np.clip(edges + step[edges.size :], 0.0, period)
    return left, edges, at_wall


def _samples(force: Array) -> int:
    return max(2, round(WINDOW * force.size))


# ---- A recorded force blow by blow: its cycles, their blows, and when it switches in each of them

Known = Literal["measured", "restitution", "phase"]

_FEWEST = 3  # blows of which a record tells anything
_NEAR = 1.0 / 8.0  # of a period: an edge farther from where the mean cycle has it is another one
_LOOKS = 257
_MEDIAN = 0.6745  # the median of |x| of a normal x, over its deviation
_SEEN = 0.5  # of the jump of the mean cycle
_FAR = 0.2  # of a period: a blow farther from where the mean cycle has it is another one


@dataclass(frozen=True)
class ForceRecord(ShortRepr):
    """The record that a load was made from, and the times of its blows where they were measured.

    Parameters
    ----------
    time
        Shape (n,), s, increasing.
    force
        Shape (n,), in any unit: it is scaled to the load.
    blows
        Times of the blows (s) on the same clock, by strain, sound or acceleration; None where they are not known.

    Examples
    --------
    >>> ForceRecord([0.0, 1e-4, 2e-4], [1.0, 1.0, -2.0]).blows is None
    True
    """

    time: Array = field(repr=False)
    force: Array = field(repr=False)
    blows: Array | None = field(default=None, repr=False)

    def __init__(self, time: npt.ArrayLike, force: npt.ArrayLike, blows: npt.ArrayLike | None = None) -> None:
        t, p = numbers("time", time), numbers("force", force)
        struck = None if blows is None else numbers("blows", blows)
        if t.ndim != 1 or t.shape != p.shape or t.size < 2:
            raise ParameterError("force", f"shape {p.shape}", "as many values as times, two or more")
        for name, row in (("time", t), ("blows", struck)):
            if row is not None and (row.ndim != 1 or np.any(np.diff(row) <= 0.0)):
                raise ParameterError(name, f"shape {row.shape}", "a row of increasing times")
        for name, row in (("time", t), ("force", p), ("blows", struck)):
            object.__setattr__(self, name, row)


@dataclass(frozen=True)
class Cycles:
    """The cycles of a record, their motion from the first blow to the last one.

    `switches` tells when each edge of the mean cycle occurs in each cycle, NaN where it was not seen, shape (cycles,
    edges); `sample` is the time between samples, `noise` the deviation of the force, and `blows` whence their times are
    known: measured, those that the restitution asks for, or at the phase of the mean cycle.
    """

    motion: Implied
    switches: Array
    sample: float
    noise: float
    blows: Known


def recorded_cycles(
    system: System,
    record: ForceRecord,
    phases: Array,
    rate: float,
    phase: float,
    edges: Array,
    levels: Levels,
    added: float = 0.0,
) -> Cycles | None:
    """The cycles of the record that the load of a system was made from, or None where there are too few."""
    # `phases` are the load's (rad) at the samples, `rate` what goes by of it in a unit of time of the result; `phase`
    # and `edges` are of the mean cycle: at its blow, and after that; `added` is added to the load.
    load = system.load
    frequency = (phases[-1] - phases[0]) / (2.0 * np.pi * (record.time[-1] - record.time[0]))
    seconds = system.time_scale if system.is_si else 1.0 / (2.0 * np.pi * frequency)
    unit = 1.0 / (rate * seconds)  # of the result, per second
    time = record.time * unit
    told = load.value(phases)
    scale = float(np.vdot(told, told) / np.vdot(record.force, told))  # the load holds a part of the record's harmonics
    force, period = rate**2 * (scale * record.force + added), 2.0 * np.pi / rate
    first, last = np.ceil((phases[0] - phase) / (2.0 * np.pi)), np.floor((phases[-1] - phase) / (2.0 * np.pi))
    wanted = np.interp(phase + 2.0 * np.pi * np.arange(first, last + 1.0), phases, time)
    blows = wanted if record.blows is None else _beside(record.blows * unit, wanted, _FAR * period)
    if blows.size < _FEWEST:
        return None
    drag = system.d * rate
    sought = None
    if record.blows is None:
        sought = sought_blows(time, force, blows, drag, system.contact.velocity_factor)
        blows = blows if sought is None else sought
    motion = implied_by_record(time, force, blows, drag)
    bare = force - levels.stiffness * np.interp(time, motion.time, motion.behind)
    switches = _switches(time, bare, motion.blows, edges, levels.at_wall)
    switches[(switches < blows[0]) | (switches > blows[-1])] = np.nan
    known: Known = "phase" if sought is None else "restitution"
    if record.blows is not None:
        known = "measured"
    steps = np.diff(force, 2)  # of white noise with √6 times its deviation
    noise = float(np.median(np.abs(steps))) / (_MEDIAN * math.sqrt(6.0))
    return Cycles(motion, switches, float(np.median(np.diff(time))), noise, known)


def load_phases(system: System, record: ForceRecord) -> Array:
    """The phase of the load (rad) at every sample of the record that it was made from."""
    report = system.load.report
    frequency = system.frequency if report is None else report.frequency
    return recorded_phases(record.time, record.force, frequency)


@dataclass(frozen=True)
class MeasuredForce(ShortRepr):
    """A recorded force beside that of a model, sample by sample.

    Attributes
    ----------
    turns
        How many cycles have gone by at every sample, shape (n,); whole numbers where one begins.
    measured, model
        Both forces, in the units of the model.
    """

    turns: Array = field(repr=False)
    measured: Array = field(repr=False)
    model: Array = field(repr=False)

    @property
    def off(self) -> float:
        """Root mean square of measured less model, over that of the measured force about its mean."""
        return float(np.std(self.measured - self.model) / np.std(self.measured))


def measured_load(system: System, record: ForceRecord) -> MeasuredForce:
    """The record that the load of a system was made from, beside that load; a cycle begins at its phase 0."""
    phases = load_phases(system, record)
    told = system.load.value(phases)
    known = 1.0 / system.force_scale if system.is_si else np.vdot(told, told) / np.vdot(record.force, told)
    return MeasuredForce(phases / (2.0 * np.pi), float(known) * record.force, told)


def _switches(time: Array, force: Array, blows: Array, edges: Array, at_wall: Array) -> Array:
    """When each edge of the mean cycle occurs in each cycle, by the levels of that cycle; shape (cycles, edges)."""
    momentum = np.concatenate([[0.0], np.cumsum(0.5 * np.diff(time) * (force[1:] + force[:-1]))])
    period = float(np.mean(np.diff(blows)))
    window, near = WINDOW * period, np.linspace(-_NEAR * period, _NEAR * period, _LOOKS)
    jumps = at_wall - np.roll(at_wall, 1)
    found = np.full((blows.size - 1, edges.size), np.nan)
    for j, edge in enumerate(edges.tolist()):
        beside = blows[:-1] + edge if 2.0 * edge < period else blows[1:] + (edge - period)
        t = beside[:, None] + near
        rise, now, fall = (np.interp(t + shift, time, momentum) for shift in (window, 0.0, -window))
        change = (rise - 2.0 * now + fall) / (window * jumps[j])
        best = np.argmax(change, axis=1)
        row = np.arange(best.size)
        found[:, j] = np.where(change[row, best] > _SEEN, t[row, best], np.nan)
    ends = found.reshape(-1)
    begin, end = ends + 0.5 * window, np.append(ends[1:], np.nan) - 0.5 * window
    length = end - begin
    with np.errstate(invalid="ignore"):
        level = (np.interp(end, time, momentum) - np.interp(begin, time, momentum)) / length
        level = np.where(length > window, level, np.tile(at_wall, blows.size - 1))
    before = np.concatenate([at_wall[-1:], level[:-1]])
    return edge_times(time, force, ends, (before, level), window).reshape(found.shape)


def _beside(measured: Array, wanted: Array, far: float) -> Array:
    """The longest run of measured blows each of which lies near one of the mean cycle's, one after the other."""
    near = np.abs(measured[:, None] - wanted[None, :])
    which = np.argmin(near, axis=1)
    good = near[np.arange(measured.size), which] < far
    best: list[int] = []
    run: list[int] = []
    for i in range(measured.size):
        run = [*run, i] if good[i] and run and which[i] == which[run[-1]] + 1 else [i] if good[i] else []
        best = run if len(run) > len(best) else best
    return measured[best]


# ---- The motion of the mean cycle: which of the possible blows it has, and what is done where there is none

_TURN = 2.0 * math.pi
_SAMPLES = 4096
_INTO = 1e-6  # of the stroke, how far rounding takes a piston through the wall


@dataclass(frozen=True)
class MeanCycle:
    """The mean cycle from blow to blow in the machine's time, the load's phase there, and what was assumed."""

    system: System
    phase: float
    motion: Implied
    notes: tuple[str, ...]


def measured_phase(record: ForceRecord, phases: Array) -> float | None:
    """The mean phase of the load at the measured blows, or None without any."""
    if record.blows is None:
        return None
    struck = np.interp(record.blows, record.time, phases, left=np.nan, right=np.nan)
    struck = struck[np.isfinite(struck)]
    return float(np.angle(np.exp(1j * struck).mean()) % _TURN) if struck.size else None


def mean_cycle(states: SteadyStates, rate: float, blow: float | None, measured: float | None) -> MeanCycle:
    """The mean cycle that strikes nearest to phase `blow` under the clock; if `measured` just there, whatever R."""
    system = states.system
    if measured is not None:
        t = np.linspace(0.0, _TURN, _SAMPLES + 1)
        force = np.asarray(system.load.value(measured + t))
        motion = implied_by_record(t, force, np.array([0.0, _TURN]), system.d)
        note = "the blows are where they were measured, and the restitution is that of the record"
        return MeanCycle(system, measured, _in_time(motion, rate), (note,))
    if not states.orbits:
        orbit, note = _at_the_fold(states)
        return MeanCycle(orbit.system, orbit.phase, _in_time(implied_by_orbit(orbit), rate), (note,))
    sampled = np.asarray(system.load.value(_TURN * np.arange(_SAMPLES) / _SAMPLES))
    fall = _TURN * float(np.argmin(changes(sampled))) / _SAMPLES
    wanted = fall if blow is None else finite("blow", blow)
    behind = [implied_by_orbit(one).behind for one in states.orbits]  # which stays behind the wall all the time
    possible = [one for one, x in zip(states.orbits, behind, strict=True) if x.min() >= -_INTO * x.max()]
    if not possible:
        raise LoadError(
            "the piston would pass through the wall in every motion that has the momentum of this load",
            "give the whole force on the piston, of a machine with one blow in a period",
        )
    orbit = min(possible, key=lambda one: abs(math.remainder(one.phase - wanted, _TURN)))
    notes = []
    if blow is None and len(possible) > 1:
        others = ", ".join(f"{one.phase:.4g}" for one in possible if one is not orbit)
        notes.append(
            f"where the blow falls was not measured: of the possible phases, {orbit.phase:.4g} rad is nearest to the "
            f"fall of the force ({others} rad besides)"
        )
    return MeanCycle(system, orbit.phase, _in_time(implied_by_orbit(orbit), rate), tuple(notes))


def _at_the_fold(states: SteadyStates) -> tuple[Orbit, str]:
    """The motion at the tip of v_f, which a smaller mean load allows: the blow as the force falls."""
    system, nearest = states.system, states.nearest
    assert nearest is not None
    arcs = phase_condition(system, 1).arcs
    tip = float(arcs.ends[int(np.argmax(arcs.velocities))]) % _TURN
    note = (
        f"no blow fits the whole load, so that its mean is taken {1.0 - nearest.mean / system.load.mean:.2g} of itself "
        "lower: then the blow comes just as the force falls"
    )
    return Orbit(system.with_load(system.load.with_mean(nearest.mean)), 1, tip, True), note


def _in_time(motion: Implied, rate: float) -> Implied:
    """The same motion in another unit of time."""
    return Implied(
        motion.time / rate, motion.force * rate**2, motion.behind, motion.velocity * rate, motion.blows / rate
    )
