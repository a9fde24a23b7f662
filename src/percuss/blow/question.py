"""A blow as it is asked for, checked: what strikes what, how fast, under which load, for how long."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from percuss.blow.bodies import Rod, Sections, Striker, Target, Wall, rod_sections, striker_sections
from percuss.blow.kernels.wave_records import (
    ENDLESS,
    FAR,
    FIXED,
    FREE,
    LOAD,
    MOST_DEGREE,
    NOW,
    OFF,
    ROCK,
    ROWS,
    TRACED,
    WALL,
    WIDTH,
    BlowProblem,
    State,
    WaveRows,
)
from percuss.errors import ParameterError
from percuss.model.checks import Array, callback, count, finite, numbers, positive, several

MOST_TRANSITS = 20
"""Transit times of the striker for which a blow is followed unless told otherwise."""

LONGEST = 1e6
"""Transit times that a window may have."""

Field = tuple[Callable[[Array], Array], Callable[[Array], Array]]
"""Velocity and compressive force of the striker before the blow, as functions of x from 0 to 1."""


@dataclass(frozen=True)
class Question:
    """What `strike` is asked, in the striker's units; see there."""

    striker: Striker
    target: Target
    velocity: Array | None
    field: Field | None
    load: tuple[tuple[float, float], ...]
    load_at: int
    until: float | None

    @classmethod
    def checked(
        cls, striker: Striker, target: Target, velocity: Any, field: Any, load: Any, load_at: int, until: Any
    ) -> Question:
        """The question, or a ParameterError that says what is wrong with it."""
        sections = striker_sections(striker).impedance.size
        if not isinstance(target, Wall | Rod):
            raise ParameterError("target", target, "a Wall or a Rod")
        steps = _load(load)
        count("load_at", load_at, 0, sections - 1)
        if (velocity is None) == (field is None):
            raise ParameterError("velocity", velocity, "a velocity, or a field of them", "give one of the two")
        speeds = None if velocity is None else _velocities(velocity, sections)
        until = None if until is None else positive("until", until)
        found = cls(striker, target, speeds, _field(field), steps, load_at, until)
        longest = LONGEST * float(found.sections.transit.sum())
        if until is not None and until > longest:
            raise ParameterError("until", until, f"at most {longest:g}, a million transit times of the striker")
        return found

    @cached_property
    def transits(self) -> float:
        """Transit times of the striker that are followed unless told otherwise, and once through the rod and back."""
        rod = np.zeros(0) if self.rod is None else self.rod.transit
        return MOST_TRANSITS + 2.0 * float(rod[np.isfinite(rod)].sum() / self.sections.transit.sum())

    @cached_property
    def sections(self) -> Sections:
        """Of the striker."""
        return striker_sections(self.striker)

    @cached_property
    def rod(self) -> Sections | None:
        """Sections of the rod; None where the target is a wall."""
        return rod_sections(self.target, self.striker) if isinstance(self.target, Rod) else None


def _velocities(given: Any, sections: int) -> Array:
    accepted = f"a number, or one for each of {sections} sections" if sections > 1 else "a number"
    found = np.atleast_1d(numbers("velocity", given, accepted))
    if found.ndim != 1 or found.size not in (1, sections):
        raise ParameterError("velocity", given, accepted)
    return np.array(np.broadcast_to(found, sections))


def _field(given: Any) -> Field | None:
    if given is None:
        return None
    both = several("field", given, "two functions of x: velocity and force")
    if len(both) != 2 or any(one is None for one in both):
        raise ParameterError("field", given, "two functions of x: velocity and force")
    for one in both:
        callback("field", one)
    return both[0], both[1]


def _load(given: Any) -> tuple[tuple[float, float], ...]:
    accepted = "pairs (time, force), with times that increase from 0 or later on"
    pairs = [several("load", pair, accepted) for pair in several("load", given, accepted)]
    if any(len(pair) != 2 for pair in pairs):
        raise ParameterError("load", given, accepted)
    found = tuple((finite("load", time), finite("load", force)) for time, force in pairs)
    times = [time for time, _ in found]
    if any(time < 0.0 for time in times) or any(a >= b for a, b in pairwise(times)):
        raise ParameterError("load", given, accepted)
    return found


# ---- The waves that are in the striker before the blow, from its velocity and the forces in it

_ENOUGH = 1e-13  # of the greatest value: last coefficients of a piece that follows a field
_FINEST = 2.0**-30  # share of a section: where a field jumps, its pieces are not made shorter


class WavePiece(NamedTuple):
    """A share of the time before the blow, from 0 to 1, and the Chebyshev coefficients of what left an end in it."""

    begin: float
    end: float
    values: Array


def initial_waves(question: Question) -> list[list[WavePiece]]:
    """For each section of the striker the wave to the right and the wave to the left, in the order of their leaving.

    What is at the share y of a section left its start at −y τ to the right, and its end at −(1 − y) τ to the left.
    """
    sections = question.sections
    if question.velocity is not None:
        halves = 0.5 * question.velocity
        return [[WavePiece(0.0, 1.0, np.array([half]))] for half in halves for _ in range(2)]
    assert question.field is not None
    rows, ends = [], np.cumsum(sections.length) / sections.length.sum()
    starts = np.append(0.0, ends[:-1])
    for z, low, high in zip(sections.impedance, starts, ends, strict=True):
        for side in (1.0, -1.0):
            rows.append(_followed(_wave(question.field, float(z), float(low), float(high), side)))
    return rows


def _wave(
    field: tuple[Callable[[Array], Array], ...], z: float, low: float, high: float, side: float
) -> Callable[[Array], Array]:
    """What leaves an end of a section at the share y of the time before the blow."""

    def at(y: Array) -> Array:
        place = low + (high - low) * (1.0 - y if side > 0.0 else y)
        values = []
        for function in field:
            try:
                found = np.asarray(function(place), dtype=float)
                values.append(np.broadcast_to(found, y.shape))
            except (TypeError, ValueError) as error:
                raise ParameterError("field", function, "functions that give numbers for an array of x") from error
        if not np.isfinite(values).all():
            raise ParameterError("field", field, "functions with finite values from x = 0 to 1")
        return np.asarray(0.5 * (values[0] + side * values[1] / z))

    return at


def _followed(function: Callable[[Array], Array]) -> list[WavePiece]:
    """A function on [0, 1] as polynomials, each as long as its last coefficients are nothing."""
    n = MOST_DEGREE
    angles = np.pi * (np.arange(n + 1) + 0.5) / (n + 1)
    transform = 2.0 / (n + 1) * np.cos(np.outer(np.arange(n + 1), angles))
    transform[0] *= 0.5
    nodes, found, rest = np.cos(angles), [], [(0.0, 1.0)]
    size = float(abs(function(0.5 + 0.5 * nodes)).max())
    while rest:
        low, high = rest.pop()
        values = transform @ function(low + 0.5 * (high - low) * (1.0 + nodes))
        size = max(size, float(abs(values).max()))
        if abs(values[-3:]).max() > _ENOUGH * size and high - low > _FINEST:
            middle = 0.5 * (low + high)
            rest += [(middle, high), (low, middle)]
            continue
        kept = np.flatnonzero(abs(values) > 1e-16 * size)
        found.append(WavePiece(low, high, values[: (kept[-1] if kept.size else 0) + 1]))
    return found


# ---- The records of the compiled functions: a question in the scales of the blow, and what they fill

_ENDS = {"infinite": ENDLESS, "free": FREE, "fixed": FIXED, "rock": ROCK}
_TICKS = 60  # of the window's length, as a power of 2: whole numbers go to 2^63
_COINCIDENT = 1e-13  # of the shortest transit time: two arrivals that are one
_ROUNDING = 4e-15  # of the window: what sums of rounded transit times can differ by
_GROWTH = 4  # by how much rows that are full get longer
_FIRST = 512  # pieces of a row to begin with


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


@dataclass(frozen=True)
class BlowTables:
    """A blow as the compiled functions know it."""

    scales: Scales
    problem: BlowProblem
    waves: WaveRows
    state: State


def tables(question: Question) -> BlowTables:
    """The records of a blow before it begins."""
    striker, rod = question.sections, question.rod
    unit, window = float(striker.transit.sum()), question.until
    horizon = question.transits if window is None else window / unit
    force = max((abs(p) for _, p in question.load), default=0.0)
    rows = initial_waves(question)
    speed = max(max(abs(piece.values).max() for row in rows for piece in row), force / float(striker.impedance[-1]))
    if not speed > 0.0:
        raise ParameterError("velocity", 0.0, "something that moves", "give a velocity or a load")
    scales = Scales(unit, float(striker.impedance[-1]), float(speed))

    transit = np.concatenate([striker.transit, () if rod is None else rod.transit]) / unit
    finite = np.isfinite(transit)
    longest = max(horizon, float(transit[finite].max()))
    if horizon > 1e6 * longest or not longest < 1e9:
        raise ParameterError("sections", longest, "transit times of a striker and a rod that can be compared")
    tick = 2.0 ** (math.ceil(math.log2(longest)) - _TICKS)
    near = max(2, int(max(_COINCIDENT * transit.min(), _ROUNDING * horizon) / tick))
    ticks = np.array([round(t / tick) if np.isfinite(t) else 0 for t in transit], dtype=np.int64)
    if ticks[finite].min() < 100 * near:
        raise ParameterError(
            "sections", float(transit.min()), "transit times that differ less", "leave out the shortest"
        )
    problem = _problem(question, scales, ticks, tick, near, round(horizon / tick))
    waves = _waves(rows, problem, scales, finite)
    return BlowTables(scales, problem, waves, _state(question, scales, problem))


def _problem(question: Question, scales: Scales, ticks: np.ndarray, tick: float, near: int, until: int) -> BlowProblem:
    rod, target, striker = question.rod, question.target, question.sections
    impedance = np.concatenate([striker.impedance, () if rod is None else rod.impedance]) / scales.impedance
    mass = np.zeros(impedance.size + 1)
    stiffness, ratio, end, unit = 0.0, 1.0, WALL, scales.impedance * scales.time
    if isinstance(target, Rod):
        end = _ENDS[target.end]
        mass[-1] = target.bit_mass / unit
        for step, value in target.joint_masses:
            mass[striker.impedance.size + step] = value / unit
        if target.rock is not None:
            stiffness = target.rock.stiffness * scales.time / scales.impedance
            ratio = target.rock.unloading_ratio
    most = FAR * tick
    return BlowProblem(
        impedance=impedance,
        transit=ticks,
        joint_mass=mass,
        load_start=np.array([round(min(t / scales.time, most) / tick) for t, _ in question.load], dtype=np.int64),
        load_force=np.array([p / scales.force for _, p in question.load], dtype=float),
        load_node=question.load_at,
        striker=striker.impedance.size,
        end=end,
        stiffness=stiffness,
        unloading=stiffness / ratio,
        ratio=ratio,
        tick=tick,
        near=near,
        until=until,
    )


def _waves(rows: list[list[WavePiece]], problem: BlowProblem, scales: Scales, finite: np.ndarray) -> WaveRows:
    """The rows with what is in the striker before the blow; nothing is in the rod."""
    sections = problem.impedance.size
    size = 2 * sections + TRACED
    most = max(_FIRST, 2 * max(map(len, rows)))
    waves = WaveRows(
        start=np.zeros((size, most), dtype=np.int64),
        degree=np.zeros((size, most), dtype=np.int64),
        first=np.zeros((size, most)),
        rest=np.zeros((size, most), dtype=np.int64),
        pool=np.zeros(64 * _FIRST),
        pieces=np.zeros(size, dtype=np.int64),
        known=np.zeros(size, dtype=np.int64),
        cursor=np.zeros(size, dtype=np.int64),
        used=np.zeros(1, dtype=np.int64),
        spent=np.zeros(size),
    )
    for row in range(2 * sections):
        transit = int(problem.transit[row >> 1])
        pieces = rows[row] if row < len(rows) else [WavePiece(0.0, 1.0, np.zeros(1))]
        for k, piece in enumerate(pieces):
            waves.start[row, k] = round((piece.begin - 1.0) * transit)
            waves.first[row, k] = piece.values[0] / scales.velocity
            n = piece.values.size - 1
            waves.degree[row, k] = n
            used = int(waves.used[0])
            waves.rest[row, k] = used
            waves.pool[used : used + n] = piece.values[1:] / scales.velocity
            waves.used[0] += n
        waves.pieces[row] = len(pieces)
        if not finite[row >> 1]:
            waves.start[row, 0] = -FAR
            waves.known[row] = FAR if row % 2 else 0
    return waves


def _state(question: Question, scales: Scales, problem: BlowProblem) -> State:
    nodes = problem.impedance.size + 1
    now = np.zeros(1, dtype=NOW).view(np.recarray)
    now[0].gap = question.target.gap / scales.length
    rock = question.target.rock if isinstance(question.target, Rod) else None
    gap = 0.0 if rock is None else rock.gap / scales.length
    now[0].penetration = -gap
    now[0].branch = LOAD if rock is not None and gap == 0.0 else OFF
    return State(
        now=now,
        time=np.zeros(nodes, dtype=np.int64),
        velocity=np.zeros(nodes),
        contact=np.zeros(_FIRST, dtype=np.int64),
        work=np.zeros((ROWS, WIDTH)),
    )


def enlarged(held: BlowTables) -> BlowTables:
    """The same with four times the room. What is not used yet is not touched, so that it takes no memory."""
    waves, state = held.waves, held.state
    size, used = int(waves.pieces.max()), int(waves.used[0])

    def wider(array: np.ndarray, filled: int) -> np.ndarray:
        found = np.zeros((*array.shape[:-1], _GROWTH * array.shape[-1]), dtype=array.dtype)
        found[..., :filled] = array[..., :filled]
        return found

    more = waves._replace(
        **{name: wider(getattr(waves, name), size) for name in ("start", "degree", "first", "rest")},
        pool=wider(waves.pool, used),
    )
    contact = wider(state.contact, int(state.now[0].noted))
    return BlowTables(held.scales, held.problem, more, state._replace(contact=contact))
