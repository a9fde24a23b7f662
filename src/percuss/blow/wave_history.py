"""The waves of a blow over its window: a quantity over time in pieces, and what the rows of the kernels hold."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import NamedTuple, TypeVar

import numpy as np
import numpy.typing as npt
from numpy.polynomial.chebyshev import chebder, chebroots, chebval

from percuss.blow.bodies import Sections
from percuss.blow.figures import ContactInterval
from percuss.blow.kernels.rows import faded_integrals, integrals, value_before
from percuss.blow.kernels.wave_records import (
    ELASTIC,
    ENDLESS,
    FAR,
    FED,
    FREE,
    RIGID,
    WALL,
    BlowProblem,
    State,
    WaveRows,
)
from percuss.model.checks import Array, count, numbers


@dataclass(frozen=True, eq=False, repr=False)
class Trace:
    """A function of time from the first to the last of its breaks, continued as a constant beyond them.

    Parameters
    ----------
    times
        Breaks, increasing, shape (n + 1,); s, or radians of a dimensionless striker.
    coefficients
        Chebyshev coefficients of each piece over its own length, shape (n, degree + 1).

    Examples
    --------
    >>> steps = Trace(np.array([0.0, 1.0, 3.0]), np.array([[2.0], [-1.0]]))
    >>> steps.at([0.5, 1.0]).tolist(), steps.integral(), steps.peak
    ([2.0, -1.0], 0.0, 2.0)
    """

    times: Array
    coefficients: Array

    def at(self, time: npt.ArrayLike) -> Array:
        """Values at times, at a break that of the later piece; the shape of `time`.

        ParameterError for times that are not finite numbers.
        """
        t = np.clip(numbers("time", time), self.times[0], self.times[-1])
        return self._values(self._pieces(t), t)

    def before(self, time: npt.ArrayLike) -> Array:
        """The same, at a break that of the earlier piece."""
        t = np.clip(numbers("time", time), self.times[0], self.times[-1])
        piece = np.clip(np.searchsorted(self.times, t, side="left") - 1, 0, len(self.coefficients) - 1)
        return self._values(piece, t)

    def _values(self, piece: npt.NDArray[np.intp], t: Array) -> Array:
        low, high = self.times[piece], self.times[piece + 1]
        x = 2.0 * (t - low) / (high - low) - 1.0
        one, two = np.zeros_like(x), np.zeros_like(x)
        for k in range(int(self._degrees[piece].max(initial=0)), 0, -1):
            one, two = self.coefficients[piece, k] + 2.0 * x * one - two, one
        return np.asarray(self.coefficients[piece, 0] + x * one - two)

    def sampled(self, size: int) -> tuple[Array, Array]:
        """Times and values for a curve, with both values at each jump and `size` points more; two arrays."""
        inside = np.linspace(self.times[0], self.times[-1], count("size", size, 2, 1 << 24))
        times = np.concatenate([self.times[:-1], self.times[1:], inside])
        values = np.concatenate([self.at(self.times[:-1]), self.before(self.times[1:]), self.at(inside)])
        # at a break the earlier piece's value comes first
        breaks = len(self.times) - 1
        order = np.lexsort((np.r_[np.full(breaks, 1), np.zeros(breaks), np.ones(size)], times))
        return times[order], values[order]

    def integral(self) -> float:
        """∫ over all its pieces."""
        return float(np.sum(self.piece_integrals))

    @cached_property
    def piece_integrals(self) -> Array:
        """∫ over each piece, shape (n,)."""
        k = np.arange(0, self.coefficients.shape[1], 2)
        return np.asarray(np.diff(self.times) * (self.coefficients[:, ::2] @ (1.0 / (1.0 - k * k))))

    @cached_property
    def piece_moments(self) -> Array:
        """∫ (t − start of the piece) over each piece, shape (n,)."""
        degree = self.coefficients.shape[1] - 1
        # x T_k = (T_{k+1} + T_{|k−1|})/2
        even = {k: 1.0 / (1.0 - k * k) for k in range(0, degree + 2, 2)}
        weights = [0.5 * (even.get(k + 1, 0.0) + even.get(abs(k - 1), 0.0)) for k in range(degree + 1)]
        half = 0.5 * np.diff(self.times)
        return np.asarray(half * self.piece_integrals + 2.0 * half**2 * (self.coefficients @ np.array(weights)))

    @property
    def peak(self) -> float:
        """The greatest value."""
        return float(self.piece_peaks.max())

    @cached_property
    def piece_peaks(self) -> Array:
        """The greatest value of each piece, shape (n,)."""
        k = np.arange(self.coefficients.shape[1])
        even, odd = self.coefficients[:, ::2].sum(axis=1), self.coefficients[:, 1::2].sum(axis=1)
        found = np.maximum(even + odd, even - odd)  # T_k(±1)
        steepness = abs(self.coefficients) * k**2  # bounds |T_k'|
        turning = np.flatnonzero(steepness[:, 2:].sum(axis=1) > steepness[:, 1:2].sum(axis=1))
        found[turning] = [extreme(row) for row in self.coefficients[turning]]
        return np.asarray(found)

    def product_integral(self, other: Trace) -> float:
        """∫ of the product with another trace over the time that both have."""
        if other is self:
            return self._square_integral()
        low, high = max(self.times[0], other.times[0]), min(self.times[-1], other.times[-1])
        edges = np.unique(np.concatenate([self.times, other.times]))
        edges = np.unique(np.clip(edges, low, high))
        middle, half, total = 0.5 * (edges[:-1] + edges[1:]), 0.5 * np.diff(edges), 0.0
        one, two = self._pieces(middle), other._pieces(middle)
        needed = (self._degrees[one] + other._degrees[two]) // 2 + 1
        for size in np.unique(needed).tolist():
            here = needed == size
            nodes, weights = np.polynomial.legendre.leggauss(size)
            at = middle[here, None] + half[here, None] * nodes
            values = self._values(one[here, None], at) * other._values(two[here, None], at)
            total += float(half[here] @ (values @ weights))
        return total

    @cached_property
    def _degrees(self) -> npt.NDArray[np.intp]:
        """Of each piece, shape (n,)."""
        k = np.arange(self.coefficients.shape[1])
        return np.asarray(np.max((self.coefficients != 0.0) * k, axis=1))

    def degrees_at(self, time: Array) -> npt.NDArray[np.intp]:
        """The degree of the piece at each time; 0 where it is a constant, and beyond the breaks."""
        inside = (time > self.times[0]) & (time < self.times[-1])
        return np.asarray(np.where(inside, self._degrees[self._pieces(time)], 0))

    def _pieces(self, time: Array) -> npt.NDArray[np.intp]:
        """The piece at each time, at a break the later one."""
        return np.clip(np.searchsorted(self.times, time, side="right") - 1, 0, len(self.coefficients) - 1)

    def _square_integral(self) -> float:
        """∫ of the square, from T_i T_j = (T_{i+j} + T_{|i−j|})/2."""
        k = np.arange(self.coefficients.shape[1])
        plus, minus = k[:, None] + k, k[:, None] - k
        even = plus % 2 == 0
        weights = np.where(even, 0.5 / (1.0 - (plus * even) ** 2) + 0.5 / (1.0 - (minus * even) ** 2), 0.0)
        return float(np.diff(self.times) @ np.sum(self.coefficients @ weights * self.coefficients, axis=1))

    def around(self, start: float, end: float) -> Trace:
        """The pieces that have a part between two times, whole; all where none has."""
        here = np.flatnonzero((self.times[:-1] < end) & (self.times[1:] > start))
        first, last = (here[0], here[-1] + 1) if here.size else (0, len(self.coefficients))
        return Trace(self.times[first : last + 1], self.coefficients[first:last])

    def scaled(self, factor: float, time: float = 1.0) -> Trace:
        """Values times a factor, times as well."""
        return Trace(self.times * time, self.coefficients * factor)

    def __repr__(self) -> str:
        return f"Trace({len(self.coefficients)} pieces from {self.times[0]:.6g} to {self.times[-1]:.6g})"


def extreme(row: Array) -> float:
    """The greatest value of a Chebyshev series on [−1, 1]."""
    return float(chebval(np.concatenate([[-1.0, 1.0], turning_points(row)]), row).max())


def turning_points(row: Array) -> Array:
    """Where a Chebyshev series on [−1, 1] turns."""
    kept = np.flatnonzero(abs(row) > 1e-30 * abs(row).max(initial=0.0))  # numpy divides by the last one
    if not kept.size or kept[-1] < 2:
        return np.zeros(0)
    places = chebroots(chebder(row[: kept[-1] + 1]))
    return np.asarray(places.real[(abs(places.imag) < 1e-6) & (abs(places.real) < 1.0)])


# ---- A blow that was followed: its waves in the scales of the blow, and the sums of them that results are made of


T = TypeVar("T")


@dataclass(frozen=True)
class Scales:
    """What the numbers of the compiled functions are multiples of."""

    time: float
    impedance: float
    velocity: float

    @property
    def force(self) -> float:
        return self.impedance * self.velocity

    @property
    def length(self) -> float:
        return self.velocity * self.time

    @property
    def momentum(self) -> float:
        return self.force * self.time

    @property
    def energy(self) -> float:
        return self.force * self.length


class BlowTables(NamedTuple):
    """A blow as the compiled functions know it, and the sections of striker and rod (None for a wall) behind it.

    `struck_before`: whether the tool is as an earlier blow left it, in place of its static state.
    """

    own: Sections
    rod: Sections | None
    scales: Scales
    problem: BlowProblem
    waves: WaveRows
    state: State
    attenuation: Array | None = None
    feed_at: int | None = None
    crater: float = 0.0
    struck_before: bool = False


class Sums(NamedTuple):
    """∫ p dt, ∫ p² dt and ∫ p (t − begin) dt."""

    plain: float
    square: float
    moment: float


class FeedWork(NamedTuple):
    """∫ over the time that a feed acts: F v, −k y v, c v², and its force."""

    constant: float
    spring: float
    damper: float
    impulse: float

    @property
    def total(self) -> float:
        return self.constant + self.spring - self.damper


@dataclass(frozen=True, eq=False)
class WaveHistory:
    """A blow until the tick `end`; `first_gap` is that before it."""

    # Rows 2i and 2i + 1: the waves to the right and to the left in section i, by the time at which they leave its left
    # end; sections from the driven end through the face to the far end. Waves are departures from the static state: the
    # rows have no preload, and what arrives of them is `fade` times what left.

    held: BlowTables
    end: int
    first_gap: float

    @property
    def scales(self) -> Scales:
        return self.held.scales

    @property
    def striker(self) -> int:
        """Number of sections of the striker."""
        return self.held.problem.striker

    @property
    def size(self) -> int:
        """Number of all sections."""
        return int(self.held.problem.impedance.size)

    @property
    def tick(self) -> float:
        return self.held.problem.tick

    @property
    def impedance(self) -> Array:
        return self.held.problem.impedance

    @property
    def ending(self) -> int:
        """Number of the sections that have an end: an endless one is the last."""
        return self.size - 1 if self.endless(self.size - 1) else self.size

    @cached_property
    def transit(self) -> list[int]:
        """Ticks; 0 of an endless section."""
        return [int(t) for t in self.held.problem.transit]

    @cached_property
    def feed_node(self) -> int:
        """The node that a feed acts on; −1 without one."""
        held = self.held.feed_at
        return -1 if held is None else self.striker + held

    @property
    def crater(self) -> float:
        """Greatest penetration before the blow."""
        return self.held.crater

    @cached_property
    def mass(self) -> float:
        """Of the striker."""
        return float(sum(self.impedance[i] * self.transit[i] * self.tick for i in range(self.striker)))

    @property
    def has_rod(self) -> bool:
        return self.held.problem.end != WALL

    def of_each(self, told: Callable[[int, Sections], T]) -> tuple[T, T | None]:
        """What a function of a body's first section and its sections tells of the striker, and of the rod."""
        return told(0, self.held.own), None if self.held.rod is None else told(self.striker, self.held.rod)

    @cached_property
    def turns(self) -> list[int]:
        """Ticks at which the faces met and parted, in turn."""
        return self.turns_of(0)

    def turns_of(self, which: int) -> list[int]:
        """The same of the faces with a record of that number."""
        state = self.held.state
        return [int(t) for t in state.contact[which, : state.now[which].noted] if t < self.end]

    @property
    def in_contact(self) -> bool:
        """Whether the faces are pressed together at the end of the window."""
        return len(self.turns) % 2 == 1

    def endless(self, section: int) -> bool:
        return self.transit[section] == 0

    def preload(self, section: int) -> float:
        """The static force in a section."""
        return float(self.held.problem.preload[section])

    @cached_property
    def rate(self) -> list[float]:
        """a = α c of each section: what departs from the static state falls as e^{−a t}."""
        rod, losses, found = self.held.rod, self.held.attenuation, [0.0] * self.size
        if rod is not None and losses is not None:
            found[self.striker :] = (losses * rod.speed * self.scales.time).tolist()
        return found

    def fade(self, section: int, time: Array | float) -> Array:
        """What is left of a departure after a time in a section."""
        return np.exp(-self.rate[section] * np.asarray(time))

    def sums(self, row: int, begin: int, end: int) -> Sums:
        """Of what leaves from one tick to another."""
        return Sums(*integrals(self.held.waves, row, begin, end, self.tick, self.held.state.work))

    def arrived(self, row: int, begin: int, end: int) -> Sums:
        """Of what arrives at the other end from one tick to another; the moment from `begin` on."""
        section = row >> 1
        back, decay = self.transit[section], float(self.held.problem.decay[section])
        if self.endless(section):
            return Sums(0.0, 0.0, 0.0)
        found = self.sums(row, begin - back, end - back)
        return Sums(decay * found.plain, decay**2 * found.square, decay * found.moment)

    def value(self, row: int, time: int) -> float:
        """What leaves just before a tick, so that several rows tell of the same side of a jump."""
        return float(value_before(self.held.waves, row, time, self.held.problem.near, self.held.state.work))

    def section_sums(self, section: int, time: int) -> tuple[Sums, Sums]:
        """Of both waves over a section at a tick, f first; of an endless one over all that was sent into it."""
        if (found := self._known.get((section, time))) is not None:
            return found
        start = 0 if self.endless(section) else time - self.transit[section]
        if self.rate[section] == 0.0 or self.endless(section):
            found = self.sums(2 * section, start, time), self.sums(2 * section + 1, start, time)
        else:
            f, g = (self._faded(2 * section + way, start, time) for way in (0, 1))
            found = Sums(*f, math.nan), Sums(*g, math.nan)
        self._known[section, time] = found
        return found

    @cached_property
    def _known(self) -> dict[tuple[int, int], tuple[Sums, Sums]]:
        """Sums that energy and momentum both need."""
        return {}

    def _faded(self, row: int, start: int, time: int) -> tuple[float, float]:
        """∫ p dt and ∫ p² dt of what has left since and run on until the tick `time`."""
        found = faded_integrals(self.held.waves, row, start, time, self.rate[row >> 1], self.tick, self.held.state.work)
        return float(found[0]), float(found[1])

    def energy(self, first: int, last: int, time: int) -> float:
        """Kinetic and strain energy in the sections from `first` to before `last`."""
        found = self.dynamic_energy(first, last, time)
        for i in range(first, last):
            if (force := self.preload(i)) != 0.0:  # Z (f_0 + f')² + Z (−f_0 + g')², f_0 = N_0/2Z
                f, g = self.section_sums(i, time)
                found += force * (f.plain - g.plain) + self.static_energy(i)
        return found

    def static_energy(self, section: int) -> float:
        """Strain energy N_0² τ/2Z in a section before the blow."""
        time = self.transit[section] * self.tick
        return 0.5 * self.preload(section) ** 2 * time / float(self.impedance[section])

    def dynamic_energy(self, first: int, last: int, time: int) -> float:
        """Z ∫(f'² + g'²) dt of the departure from the static state."""
        return self._in_sections(first, last, time, 1)

    def momentum(self, first: int, last: int, time: int) -> float:
        return self._in_sections(first, last, time, 0)

    def _in_sections(self, first: int, last: int, time: int, which: int) -> float:
        """Σ Z (f + g) of one of the sums over the waves in sections."""
        found = 0.0
        for i in range(first, last):
            f, g = self.section_sums(i, time)
            found += float(self.impedance[i]) * (f[which] + g[which])
        return found

    def lost_on_the_way(self, time: int) -> tuple[float, float]:
        """Total energy, and momentum, that the steel has taken until a tick from what has left."""
        energy, momentum = 0.0, 0.0
        for row in range(2 * self.striker, 2 * self.size) if any(self.rate) else ():
            i = row >> 1
            if self.rate[i] == 0.0 or self.endless(i):
                continue
            z, back, sign = float(self.impedance[i]), self.transit[i], 1.0 - 2.0 * (row % 2)
            sent, gone = self.sums(row, 0, time), self.arrived(row, 0, time)
            came, left = (self._faded(row, t - back, t) for t in (0, time))
            plain, square = (sent[j] - gone[j] + came[j] - left[j] for j in (0, 1))
            energy += z * square + sign * self.preload(i) * plain
            momentum += z * plain
        return energy, momentum

    def node_velocity(self, section: int, time: int) -> float:
        """Velocity of the left end of a section."""
        decay = float(self.held.problem.decay[section])
        return self.value(2 * section, time) + decay * self.value(2 * section + 1, time - self.transit[section])

    def lumped_masses(self, ticks: list[int]) -> list[tuple[float, Array]]:
        """The masses at the joints of the rod, then the bit, with their velocities from one side of a jump."""
        masses, found = self.held.problem.joint_mass, []
        for node in range(self.striker + 1, self.size):
            if masses[node] > 0.0:
                found.append((float(masses[node]), np.array([self.node_velocity(node, t) for t in ticks])))
        row, back, decay, bit = 2 * self.size - 2, self.transit[-1], float(self.held.problem.decay[-1]), 0.0
        speeds = np.zeros(len(ticks))
        if masses[-1] > 0.0 and self.held.problem.end != ENDLESS:
            bit = float(masses[-1])
            speeds = np.array([decay * self.value(row, t - back) + self.value(row + 1, t) for t in ticks])
        return [*found, (bit, speeds)]

    def lumped_momentum(self, time: int) -> tuple[float, float]:
        """Momentum of the masses at joints, and of the bit."""
        *joints, bit = (mass * float(speed[0]) for mass, speed in self.lumped_masses([time]))
        return sum(joints), bit

    def lumped_energy(self, ticks: list[int]) -> tuple[Array, Array]:
        """Energy of the joints of the rod, of springs above that before the blow, and kinetic energy of the bit."""
        *joints, bit = (0.5 * mass * speed**2 for mass, speed in self.lumped_masses(ticks))
        found, problem = np.zeros(len(ticks)), self.held.problem
        for one in joints:
            found += one
        for node in np.flatnonzero(problem.kind == ELASTIC).tolist():
            length = np.array([self.value(int(problem.traced[node]) + 1, t) for t in ticks])
            found += (0.5 * float(problem.spring[node]) * length + self.preload(node)) * length
        return found, bit

    def joint_loss(self) -> float:
        """What dashpots of joints have taken, ∫ (N − k δ)²/c dt."""
        problem, found = self.held.problem, 0.0
        for node in np.flatnonzero((problem.kind == ELASTIC) & (problem.dashpot > 0.0)).tolist():
            force, length = (self.trace(int(problem.traced[node]) + i) for i in (0, 1))
            k, c = float(problem.spring[node]), float(problem.dashpot[node])
            squares = force.product_integral(force) + k * k * length.product_integral(length)
            found += (squares - 2.0 * k * force.product_integral(length)) / c
        return found

    def feed_work(self) -> FeedWork:
        """What the feed has done; all 0 without one."""
        problem, feed_node = self.held.problem, self.feed_node
        if feed_node < 0:
            return FeedWork(0.0, 0.0, 0.0, 0.0)
        if problem.kind[feed_node] != FED:
            work = problem.feed_force * self.travelled(feed_node, 0, self.end)
            return FeedWork(work, 0.0, 0.0, problem.feed_force * self.end * self.tick)
        row = int(problem.traced[feed_node])
        force, speed = self.trace(row), self.trace(row + 1)
        constant, damper = problem.feed_force * speed.integral(), problem.feed_damping * speed.product_integral(speed)
        spring = force.product_integral(speed) - constant + damper
        return FeedWork(constant, spring if problem.feed_stiffness > 0.0 else 0.0, damper, force.integral())

    def travelled(self, section: int, begin: int, end: int) -> float:
        """How far the left end of a section moves."""
        return self.sums(2 * section, begin, end).plain + self.arrived(2 * section + 1, begin, end).plain

    def trace(self, row: int, shift: int = 0, first: int = 0, last: int | None = None) -> Trace:
        """A row, as it leaves or `shift` ticks later, over the window or from one tick to another, in its scales."""
        last = self.end if last is None else last
        waves = self.held.waves
        size = int(waves.pieces[row])
        starts = np.append(waves.start[row, :size], waves.known[row] if waves.known[row] < FAR else FAR)
        starts = np.where(abs(starts) >= FAR, np.sign(starts) * FAR, starts + shift)
        here = np.flatnonzero((starts[:-1] < last) & (starts[1:] > first))
        low, high = int(here[0]), int(here[-1]) + 1
        degrees, rest = waves.degree[row, low:high], waves.rest[row, low:high]
        coefficients = np.zeros((high - low, int(degrees.max()) + 1))
        coefficients[:, 0] = waves.first[row, low:high]
        for k in range(1, coefficients.shape[1]):
            bent = np.flatnonzero(degrees >= k)
            coefficients[bent, k] = waves.pool[rest[bent] + k - 1]
        edges = starts[low : high + 1].copy()
        for k in sorted({0, high - low - 1}):
            begin, end = max(first, int(edges[k])), min(last, int(edges[k + 1]))
            if degrees[k] and (begin, end) != (edges[k], edges[k + 1]):
                span = 2.0 / float(edges[k + 1] - edges[k])
                at = span * (np.array([begin, end]) - edges[k]) - 1.0
                coefficients[k] = _restricted(coefficients[k], float(at[0]), float(at[1]))
        edges[0], edges[-1] = first, last
        # a break next to an end of the window leaves a piece of no width
        wide = np.diff(edges) > self.held.problem.near
        wide[0] |= not wide.any()
        edges = np.append(edges[:-1][wide], last)
        edges[0] = first
        return Trace(edges * self.tick, coefficients[wide])


def _restricted(row: Array, low: float, high: float) -> Array:
    """A Chebyshev series on [low, high] as one on [−1, 1]."""
    n = row.size - 1
    angles = np.pi * (np.arange(n + 1) + 0.5) / (n + 1)
    values = chebval(0.5 * (low + high) + 0.5 * (high - low) * np.cos(angles), row)
    found = 2.0 / (n + 1) * (np.cos(np.outer(np.arange(n + 1), angles)) @ values)
    found[0] *= 0.5
    return np.asarray(found)


# ---- When a blow is over: no further contact is possible, or nothing is left to pass on

_LEFT = 1e-9  # share of the momentum that no longer matters


def is_over(course: WaveHistory) -> bool:
    """Whether the faces can never meet again after the window, which is proved by energy (Cauchy–Schwarz)."""
    # A free bar's end is never further from where it would be without stress than sqrt(2 E G), E the energy of its
    # vibration and G the compliance of the end under inertia relief. So two free bodies cannot touch once the distance
    # of their unstressed ends exceeds both reaches and grows. A wall, and the face of an endless uniform rod without a
    # force on it, stay where they are.
    if not _unloaded(course) or course.in_contact:
        return False
    problem = course.held.problem
    plain = not problem.joint_mass.any() and (problem.kind == RIGID).all() and not any(course.rate)
    free = course.has_rod and problem.end == FREE and plain
    stays = not course.has_rod or (problem.end == ENDLESS and course.size - course.striker == 1)
    if not (free or stays):
        return False
    reached, speed, reach = _free_body(course, 0, course.striker, True)
    distance, speed = gap(course) + reached, -speed
    if free:
        other = _free_body(course, course.striker, course.size, False)
        distance, speed, reach = distance - other[0], speed + other[1], reach + other[2]
    return speed >= 0.0 and distance > reach


def is_spent(course: WaveHistory) -> bool:
    """Whether the striker has neither momentum nor energy left, as after a long staircase."""
    if not _unloaded(course):
        return False
    before = course.energy(0, course.striker, 0)
    # Cauchy–Schwarz: the momentum is at most the square root of 2 M E
    return course.energy(0, course.striker, course.end) <= _LEFT**2 * before


def gap(course: WaveHistory) -> float:
    """Distance between the faces at the end of the window."""
    last = course.striker - 1
    back = course.transit[last]
    arrived = course.sums(2 * last, -back, course.end - back).plain
    own = arrived + course.sums(2 * last + 1, 0, course.end).plain
    other = course.travelled(course.striker, 0, course.end) if course.has_rod else 0.0
    return course.first_gap + other - own


def _unloaded(course: WaveHistory) -> bool:
    """Whether no force acts from the end of the window on."""
    problem = course.held.problem
    acting = 0.0
    for start, force in zip(problem.load_start, problem.load_force, strict=True):
        if start > course.end and force != 0.0:
            return False
        acting = force
    return acting == 0.0


def _free_body(course: WaveHistory, first: int, last: int, right: bool) -> tuple[float, float, float]:
    """Of a free body: its end's distance from where it would be without stress, mean velocity, and greatest reach."""
    time, tick = course.end, course.tick
    masses = [float(course.impedance[i]) * course.transit[i] * tick for i in range(first, last)]
    mass, before = sum(masses), 0.0
    end, compliance = 0.0, 0.0
    for i, own in zip(range(first, last), masses, strict=True):
        z, transit = float(course.impedance[i]), course.transit[i] * tick
        low, high = before / mass, (before + own) / mass
        if not right:  # the mass on the other side, with the opposite sign
            low, high = low - 1.0, high - 1.0
        f, g = course.section_sums(i, time)
        end -= high * f.plain - z / mass * f.moment - low * g.plain - z / mass * g.moment
        compliance += transit / z * (low * low + low * high + high * high) / 3.0
        before += own
    momentum, energy = course.momentum(first, last, time), course.energy(first, last, time)
    ringing = max(0.0, energy - 0.5 * momentum**2 / mass)
    return end, momentum / mass, math.sqrt(2.0 * ringing * compliance)


# ---- The contacts of a blow: when the faces were pressed together, with which impulse and which greatest force

_GRAZING = 1e-12  # share of the greatest impulse below which a contact is rounding, or a touch without force


def contacts(course: WaveHistory) -> tuple[tuple[ContactInterval, ...], int]:
    """The contacts, and how many touches without an impulse there were besides."""
    turns = [*course.turns, course.end] if course.in_contact else course.turns
    force, scales = course.trace(2 * course.size), course.scales
    peaks, middle = force.piece_peaks, 0.5 * (force.times[:-1] + force.times[1:])
    found = []
    for begin, end in list(pairwise(turns))[::2]:
        inside = (middle > begin * course.tick) & (middle < end * course.tick)
        impulse = scales.momentum * course.sums(2 * course.size, begin, end).plain
        last = None if end == course.end and course.in_contact else scales.time * (end * course.tick)
        peak = scales.force * float(peaks[inside].max(initial=0.0))
        found.append(ContactInterval(scales.time * (begin * course.tick), last, impulse, peak))
    least = _GRAZING * max((spell.impulse for spell in found), default=0.0)
    kept = tuple(spell for spell in found if spell.impulse > least)
    return kept, len(found) - len(kept) + int(course.held.state.now[0].grazes)


def centroid(force: Trace) -> float:
    """∫ N t dt / ∫ N dt, from the time 0 on; NaN without a force."""
    moment = float(np.sum(force.piece_moments + force.times[:-1] * force.piece_integrals))
    impulse = force.integral()
    return moment / impulse if impulse > 0.0 else float("nan")
