"""The records of the compiled functions: a question in the scales of the blow, and what they fill."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from percuss.blow.initial_waves import Piece, initial_waves
from percuss.blow.kernels.layout import (
    ENDLESS,
    FAR,
    FIXED,
    FREE,
    LOAD,
    NOW,
    OFF,
    ROCK,
    ROWS,
    TRACED,
    WALL,
    WIDTH,
    Problem,
    State,
    Waves,
)
from percuss.blow.question import Question
from percuss.blow.target import Rod
from percuss.errors import ParameterError

__all__ = ["Scales", "Tables", "enlarged", "tables"]

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
class Tables:
    """A blow as the compiled functions know it."""

    scales: Scales
    problem: Problem
    waves: Waves
    state: State


def tables(question: Question) -> Tables:
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
    return Tables(scales, problem, waves, _state(question, scales, problem))


def _problem(question: Question, scales: Scales, ticks: np.ndarray, tick: float, near: int, until: int) -> Problem:
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
    return Problem(
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


def _waves(rows: list[list[Piece]], problem: Problem, scales: Scales, finite: np.ndarray) -> Waves:
    """The rows with what is in the striker before the blow; nothing is in the rod."""
    sections = problem.impedance.size
    size = 2 * sections + TRACED
    most = max(_FIRST, 2 * max(map(len, rows)))
    waves = Waves(
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
        pieces = rows[row] if row < len(rows) else [Piece(0.0, 1.0, np.zeros(1))]
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


def _state(question: Question, scales: Scales, problem: Problem) -> State:
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


def enlarged(held: Tables) -> Tables:
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
    return Tables(held.scales, held.problem, more, state._replace(contact=contact))
