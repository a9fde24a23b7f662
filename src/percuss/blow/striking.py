"""One blow of a striker on a target: what is asked, checked; the waves before it; the waves carried on."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from percuss.blow.blow import Blow, balance
from percuss.blow.bodies import Rod, Sections, Striker, Target, Wall, rod_sections, striker_sections
from percuss.blow.figures import BlowOutcome, Fineness
from percuss.blow.kernels import wave_records as kn
from percuss.blow.kernels.nodes import go_on
from percuss.blow.wave_history import BlowTables, Scales, WaveHistory, is_over, is_spent
from percuss.errors import ConvergenceError, ParameterError
from percuss.halting import check_interrupted
from percuss.model.checks import Array, count, finite, flag, instance, non_negative, numbers, positive, several

# ---- A blow as it is asked for, checked: what strikes what, how fast, under which load, for how long

_MOST_TRANSITS = 20  # transit times of the striker for which a blow is followed unless told otherwise
_LONGEST = 1e6  # transit times that a window may have
Field = tuple[Callable[[Array], Array], Callable[[Array], Array]]
"""Velocity and compressive force of the striker before the blow, as functions of x from 0 to 1."""


class _Question(NamedTuple):
    """What `strike` is asked, in the striker's units; see there. `own` and `rod` are the sections."""

    striker: Striker
    own: Sections
    rod: Sections | None
    target: Target
    velocity: Array | None
    field: Field | None
    load: tuple[tuple[float, float], ...]
    load_at: int
    until: float | None
    crater: float = 0.0

    @property
    def transits(self) -> float:
        """Transit times of the striker that are followed unless told otherwise, and once through the rod and back."""
        rod = np.zeros(0) if self.rod is None else self.rod.transit
        return _MOST_TRANSITS + 2.0 * float(rod[np.isfinite(rod)].sum() / self.own.transit.sum())


def _checked(
    striker: Striker, target: Target, velocity: Any, field: Any, load: Any, load_at: int, until: Any,
    crater: Any,
) -> _Question:  # fmt: skip
    own = striker_sections(striker)
    sections = own.impedance.size
    if not isinstance(target, Wall | Rod):
        raise ParameterError("target", target, "a Wall or a Rod")
    steps = _load(load)
    count("load_at", load_at, 0, sections - 1)
    if (velocity is None) == (field is None):
        raise ParameterError("velocity", velocity, "a velocity, or a field of them", "give one of the two")
    speeds = None if velocity is None else _velocities(velocity, sections)
    until, longest = None if until is None else positive("until", until), _LONGEST * float(own.transit.sum())
    if until is not None and until > longest:
        raise ParameterError("until", until, f"at most {longest:g}, a million transit times of the striker")
    rod = rod_sections(target, striker) if isinstance(target, Rod) else None
    deepest = non_negative("crater", crater)
    rock = target.rock if isinstance(target, Rod) else None
    if deepest > 0.0 and (rock is None or rock.gap > 0.0):
        raise ParameterError("crater", crater, "0 without rock, and beside a gap in front of it")
    return _Question(striker, own, rod, target, speeds, _field(field), steps, load_at, until, deepest)


def _velocities(given: Any, sections: int) -> Array:
    accepted = f"a number, or one for each of {sections} sections" if sections > 1 else "a number"
    found = np.atleast_1d(numbers("velocity", given, accepted))
    if found.ndim != 1 or found.size not in (1, sections):
        raise ParameterError("velocity", given, accepted)
    return np.array(np.broadcast_to(found, sections))


def _field(given: Any) -> Field | None:
    if given is None:
        return None
    accepted = "two functions of x: velocity and force"
    both = several("field", given, accepted)
    if len(both) != 2 or not all(map(callable, both)):
        raise ParameterError("field", given, accepted)
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


class _Piece(NamedTuple):
    """A share of the time before the blow, from 0 to 1, and the Chebyshev coefficients of what left an end in it."""

    begin: float
    end: float
    values: Array


def _initial_waves(question: _Question) -> list[list[_Piece]]:
    """Each section's two waves as they leave: the share y of it left its start at −yτ, its end at −(1 − y)τ."""
    sections = question.own
    if question.velocity is not None:
        halves = 0.5 * question.velocity
        return [[_Piece(0.0, 1.0, np.array([half]))] for half in halves for _ in range(2)]
    assert question.field is not None
    rows, ends = [], np.cumsum(sections.length) / sections.length.sum()
    starts = np.append(0.0, ends[:-1])
    for z, low, high in zip(sections.impedance, starts, ends, strict=True):
        for side in (1.0, -1.0):
            rows.append(_as_pieces(_wave(question.field, float(z), float(low), float(high), side)))
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


def _as_pieces(function: Callable[[Array], Array]) -> list[_Piece]:
    """A function on [0, 1] as polynomials, each as long as its last coefficients are nothing."""
    n = kn.MOST_DEGREE
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
        found.append(_Piece(low, high, values[: (kept[-1] if kept.size else 0) + 1]))
    return found


# ---- The records of the compiled functions: a question in the scales of the blow, and what they fill

_ENDS = {"infinite": kn.ENDLESS, "free": kn.FREE, "fixed": kn.FIXED, "rock": kn.ROCK}
_TICKS = 60  # of the window's length, as a power of 2: whole numbers go to 2^63
_ROUNDING = 4e-15  # of the window: what sums of rounded transit times can differ by
_GROWTH = 4  # by how much rows that are full get longer
_FIRST = 512  # pieces of a row to begin with


class _Least(NamedTuple):
    """Steps and bends of the waves, in the striker's speed, and times, of the shortest transit time, that are none."""

    step: float
    bend: float
    time: float


_LEAST = {
    Fineness.EXACT: _Least(kn.JOINED, kn.APART, 1e-13),
    Fineness.SMOOTHED: _Least(1e-4, 5e-3, 1e-13),
    Fineness.COARSE: _Least(1e-3, 1e-2, 4e-3),
}


def _tables(question: _Question, least: _Least) -> BlowTables:
    """The records of a blow before it begins."""
    striker, rod = question.own, question.rod
    unit, window = float(striker.transit.sum()), question.until
    horizon = question.transits if window is None else window / unit
    force = max((abs(p) for _, p in question.load), default=0.0)
    rows, feed = _initial_waves(question), getattr(question.target, "feed", None)
    speed = max(max(abs(piece.values).max() for row in rows for piece in row), force / float(striker.impedance[-1]))
    if feed is not None and speed > 0.0:
        speed = max(speed, feed.force / float(striker.impedance[-1]))
    if not speed > 0.0:
        raise ParameterError("velocity", 0.0, "something that moves", "give a velocity or a load")
    scales = Scales(unit, float(striker.impedance[-1]), float(speed))

    transit = np.concatenate([striker.transit, () if rod is None else rod.transit]) / unit
    finite = np.isfinite(transit)
    longest = max(horizon, float(transit[finite].max()))
    if horizon > 1e6 * longest or not longest < 1e9:
        raise ParameterError("sections", longest, "transit times of a striker and a rod that can be compared")
    tick = 2.0 ** (math.ceil(math.log2(longest)) - _TICKS)
    near = max(2, int(max(least.time * transit.min(), _ROUNDING * horizon) / tick))
    ticks = np.array([round(t / tick) if np.isfinite(t) else 0 for t in transit], dtype=np.int64)
    if ticks[finite].min() < 100 * near:
        raise ParameterError(
            "sections", float(transit.min()), "transit times that differ less", "leave out the shortest"
        )
    problem = _problem(question, scales, ticks, tick, near, round(horizon / tick))
    waves = _waves(rows, problem, scales, finite, least)
    losses = np.array(question.target.attenuation) if isinstance(question.target, Rod) else None
    state = _state(question, scales, problem)
    at, deepest = None if feed is None else feed.at, float(state.now[0].greatest)
    return BlowTables(striker, rod, scales, problem, waves, state, losses, at, deepest)


def _problem(
    question: _Question, scales: Scales, ticks: np.ndarray, tick: float, near: int, until: int
) -> kn.BlowProblem:
    rod, target, striker = question.rod, question.target, question.own
    impedance = np.concatenate([striker.impedance, () if rod is None else rod.impedance]) / scales.impedance
    mass = np.zeros(impedance.size + 1)
    stiffness, ratio, end, unit = 0.0, 1.0, kn.WALL, scales.impedance * scales.time
    held = _held(question, scales, impedance.size)
    if isinstance(target, Rod):
        end = _ENDS[target.end]
        mass[-1] = target.bit_mass / unit
        for step, joint in target.joint_at.items():
            mass[striker.impedance.size + step] = joint.mass / unit
        if target.rock is not None:
            stiffness = target.rock.stiffness * scales.time / scales.impedance
            ratio = target.rock.unloading_ratio
    most = kn.FAR * tick
    return kn.BlowProblem(
        impedance=impedance,
        transit=ticks,
        joint_mass=mass,
        **held,
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


def _held(question: _Question, scales: Scales, sections: int) -> dict[str, Any]:
    """What holds a rod, by the names of the problem: preload, attenuation, joints, feed."""
    own, target, rod = question.own.impedance.size, question.target, question.rod
    preload, decay = np.zeros(sections), np.ones(sections)
    kind, traced = (np.zeros(sections + 1, dtype=np.int64) for _ in range(2))
    spring, dashpot, slack, row = np.zeros(sections + 1), np.zeros(sections + 1), [float(kn.FAR)], 2 * sections
    row, feed = row + kn.TRACED, target.feed if isinstance(target, Rod) else None
    if isinstance(target, Rod) and rod is not None:
        for i, alpha in enumerate(target.attenuation):
            if alpha > 0.0 and math.isfinite(rod.length[i]):
                decay[own + i] = math.exp(-alpha * rod.length[i])
        for step, joint in target.joint_at.items():
            if joint.kind == "elastic":
                kind[own + step], traced[own + step], row = kn.ELASTIC, row, row + 2
                spring[own + step] = joint.stiffness * scales.time / scales.impedance
                dashpot[own + step] = joint.damping / scales.impedance
            elif joint.kind == "contact" and joint.slack != 0.0:
                kind[own + step], traced[own + step] = kn.CONTACT, len(slack)
                slack.append(float(kn.FAR) if joint.slack is None else joint.slack / scales.length)
    if feed is not None:
        preload[own + feed.at :] = feed.force / scales.force
        if feed.stiffness > 0.0 or feed.damping > 0.0:
            kind[own + feed.at], traced[own + feed.at] = kn.FED, row
    return {
        "preload": preload, "decay": decay, "kind": kind, "spring": spring, "dashpot": dashpot, "traced": traced,
        "slack": np.array(slack),
        "feed_force": 0.0 if feed is None else feed.force / scales.force,
        "feed_stiffness": 0.0 if feed is None else feed.stiffness * scales.time / scales.impedance,
        "feed_damping": 0.0 if feed is None else feed.damping / scales.impedance,
    }  # fmt: skip


def _waves(
    rows: list[list[_Piece]], problem: kn.BlowProblem, scales: Scales, finite: np.ndarray, least: _Least
) -> kn.WaveRows:
    """The rows with what is in the striker before the blow; nothing is in the rod."""
    sections = problem.impedance.size
    size = 2 * sections + kn.TRACED + 2 * int(np.isin(problem.kind, (kn.ELASTIC, kn.FED)).sum())
    most = max(_FIRST, 2 * max(map(len, rows)))
    waves = kn.WaveRows(
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
        waves=2 * sections,
        joined=least.step,
        apart=least.bend,
    )
    for row in range(2 * sections):
        transit = int(problem.transit[row >> 1])
        pieces = rows[row] if row < len(rows) else [_Piece(0.0, 1.0, np.zeros(1))]
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
            waves.start[row, 0] = -kn.FAR
            waves.known[row] = kn.FAR if row % 2 else 0
    return waves


def _state(question: _Question, scales: Scales, problem: kn.BlowProblem) -> kn.State:
    nodes = problem.impedance.size + 1
    now = np.zeros(problem.slack.size, dtype=kn.NOW).view(np.recarray)
    now[0].gap = question.target.gap / scales.length
    rock = question.target.rock if isinstance(question.target, Rod) else None
    gap = 0.0 if rock is None else rock.gap / scales.length
    now[0].penetration = -gap
    now[0].branch = kn.LOAD if rock is not None and gap == 0.0 else kn.OFF
    fed, deepest = float(problem.preload[-1]), question.crater / scales.length
    if rock is not None and (fed > 0.0 or deepest > 0.0):
        now[0].greatest = now[0].penetration = max(deepest, fed / problem.stiffness)
        if deepest * problem.stiffness > fed:
            now[0].branch = kn.UNLOAD
            now[0].penetration = (1.0 - problem.ratio) * deepest + fed / problem.unloading
    return kn.State(
        now=now,
        time=np.zeros(nodes, dtype=np.int64),
        velocity=np.zeros(nodes),
        contact=np.zeros((problem.slack.size, _FIRST), dtype=np.int64),
        work=np.zeros((kn.ROWS, kn.WIDTH)),
    )


_OF_TOOL = ("penetration", "greatest", "bit_velocity", "branch", "lifted", "fed_place")
_OF_JOINT = ("gap", "closed", "arriving", "flank", "across")


def _taken_over(held: BlowTables, before: WaveHistory, new_rock: bool) -> BlowTables:
    """The tables of a blow that finds the tool as another one, of the same question, has left it."""
    problem, size, end, old = held.problem, before.size, before.end, before.held.waves
    kept = dict[int, slice]()
    for row in range(2 * before.striker, 2 * size):
        if not before.endless(row >> 1):
            starts, since = old.start[row, : old.pieces[row]], end - before.transit[row >> 1] - 8 * problem.near
            kept[row] = slice(max(0, int(np.searchsorted(starts, since, "right")) - 1), starts.size)
    used = int(held.waves.used[0]) + sum(int(old.degree[row, here].sum()) for row, here in kept.items())
    widest = max((here.stop - here.start for here in kept.values()), default=0)
    while 2 * widest > held.waves.start.shape[1] or 2 * used > held.waves.pool.size:
        held = _enlarged(held)
    waves, state, was = held.waves, held.state, before.held.state
    for row, here in kept.items():
        n, degree, at = here.stop - here.start, old.degree[row, here], int(waves.used[0])
        first = np.cumsum(degree) - degree
        from_pool = np.repeat(old.rest[row, here] - first, degree) + np.arange(degree.sum())
        waves.start[row, :n], waves.first[row, :n] = old.start[row, here] - end, old.first[row, here]
        waves.degree[row, :n], waves.rest[row, :n] = degree, at + first
        waves.pool[at : at + from_pool.size] = old.pool[from_pool]
        waves.used[0] += from_pool.size
        waves.pieces[row], waves.known[row], waves.spent[row] = n, 0, old.spent[row]
    for name in _OF_TOOL:
        state.now[name][0] = was.now[name][0]
    for name in _OF_JOINT:
        state.now[name][1:] = was.now[name][1:]
    state.velocity[before.striker :] = was.velocity[before.striker :]
    told = {int(problem.traced[i]) + 1: state.velocity[i] for i in np.flatnonzero(problem.kind == kn.ELASTIC)}
    if problem.end == kn.ROCK:
        force = _met(problem, state.now[0], new_rock)
        told |= {2 * size + 1: state.now[0].penetration, 2 * size + 2: force}
    for row, value in told.items():
        waves.start[row, 0], waves.first[row, 0], waves.pieces[row] = -8 * problem.near, value, 1
    return held._replace(crater=float(state.now[0].greatest), struck_before=True)


def _met(problem: kn.BlowProblem, now: Any, new_rock: bool) -> float:
    """The force on the bit; `new_rock` is laid before it at the same force, and before a bit that is off as far off."""
    residual = 0.0 if now.branch == kn.LOAD else (1.0 - problem.ratio) * now.greatest
    stiffness = {kn.LOAD: problem.stiffness, kn.UNLOAD: problem.unloading}.get(int(now.branch), 0.0)
    force = max(0.0, float(stiffness * (now.penetration - residual)))
    if new_rock:
        bottom = force / problem.stiffness
        place, branch = (bottom, kn.LOAD) if force > 0.0 else (min(now.penetration - residual, 0.0), kn.OFF)
        now.fed_place -= now.penetration - place  # the machine follows
        now.penetration, now.greatest, now.branch = place, bottom, branch
    return force


def _enlarged(held: BlowTables) -> BlowTables:
    """The same with four times the room. What is not used yet is not touched, so that it takes no memory."""
    waves, state = held.waves, held.state
    size, used = int(waves.pieces.max()), int(waves.used[0])

    def wider(array: np.ndarray, filled: int) -> np.ndarray:
        found = np.zeros((*array.shape[:-1], _GROWTH * array.shape[-1]), dtype=array.dtype)
        found[..., :filled] = array[..., :filled]
        return found

    more = waves._replace(
        start=wider(waves.start, size),
        degree=wider(waves.degree, size),
        first=wider(waves.first, size),
        rest=wider(waves.rest, size),
        pool=wider(waves.pool, used),
    )
    contact = wider(state.contact, int(state.now["noted"].max()))
    return held._replace(waves=more, state=state._replace(contact=contact))


# ---- The blow carried on to the end of its window

_AT_ONCE = 1 << 14  # steps between two looks whether anybody still waits
_IDLE = 20  # looks without a new piece after which nothing but rounding goes on


def _carried_to(held: BlowTables, target: int, most_pieces: int) -> tuple[BlowTables, bool]:
    """The blow with every node at least at the tick `target`; whether it got there."""
    idle, before = 0, -1
    while True:
        code = go_on(held.problem, held.waves, held.state, target, _AT_ONCE)
        if code == kn.REACHED:
            return held, True
        pieces = int(held.waves.pieces.sum())
        idle, before = (idle + 1 if code == kn.PAUSED and pieces == before else 0), pieces
        if idle > _IDLE and (held.problem.kind == kn.CONTACT).any():
            remedy = "give the feed a force, or the joint another slack"
            raise ConvergenceError("faces of a joint without preload rattle within the rounding of numbers", remedy)
        if held.waves.pieces.sum() > most_pieces:
            return held, False
        if code == kn.FULL:
            held = _enlarged(held)
        check_interrupted()


MOST_PIECES = 4_000_000  # pieces of waves of one blow, unless told otherwise: half a gigabyte
FEW_PIECES = 200_000  # of a blow of which only some figures are wanted, and soon


def strike(
    striker: Striker,
    target: Target,
    velocity: Any = None,
    *,
    until: float | None = None,
    load: Iterable[tuple[float, float]] = (),
    load_at: int = 0,
    field: Field | None = None,
    crater: float = 0.0,
    most_pieces: int = MOST_PIECES,
    few_pieces: int | None = None,
) -> Blow:
    """One blow, resolved by one-dimensional waves, exactly but for rounding (St Venant 1867; Fischer 1959).

    Striker and rod are chains of sections, the striker without damping; a `Rod` says what it loses and what holds it.
    Their faces push each other and never pull. There is no lattice: sections may have any lengths. Exact waves of many
    sections whose transit times have no common measure can have too many pieces: then small steps of them are left out,
    as the blow's `fineness` says.

    Parameters
    ----------
    striker
        A bar with sizes (`Bar`, `SectionedBar`), then all numbers are SI; or a dimensionless one (`UniformBar`,
        `SteppedBar`), then mass, length and angular frequency are 1.
    target
        A `Wall` or a `Rod`, at rest; a rod that is fed in its static state.
    velocity
        Of the striker toward the target, one number or one for each section; the striker is free of stress. None
        with `field`.
    until
        End of the window. None: until no further contact is possible, where that can be proved, or nothing is left;
        at most 20 transit times of the striker, and once through the rod and back.
    load, load_at
        Steps (time, force): the force on the striker toward the target from each time on; and its place, 0 the driven
        end, i the step after the i-th section.
    field
        Velocity and compressive force in the striker at the start, functions of x, an array from 0 to 1.
    crater
        Greatest penetration of earlier blows, where the bit stands in their crater, from the original surface; the bit
        begins where it bears the feed.
    most_pieces
        Pieces of waves after which they are followed less finely; with the least `Fineness` the window is cut short
        there, as the blow's `outcome` says then.
    few_pieces
        The same for each but the least fineness, where that is less.

    Raises
    ------
    Interrupted
        When the computation was told to stop.

    Examples
    --------
    >>> from percuss.blow import Rod, strike
    >>> from percuss.model import Bar, Section
    >>> blow = strike(Bar(0.5, 1e-3), Rod([Section(None, area=4e-3)]), 10.0)
    >>> print(f"R = {blow.effective_restitution:.6f}, {len(blow.contacts)} contact, {blow.outcome.name}")
    R = 0.600000, 1 contact, OVER
    """
    most = count("most_pieces", most_pieces, 1, 1 << 40)
    few = most if few_pieces is None else min(most, count("few_pieces", few_pieces, 1, 1 << 40))
    question = _checked(striker, target, velocity, field, load, load_at, until, crater)
    course, outcome, fineness = _finest(question, few, most)
    return _blow_of(question, course, outcome, fineness)


def _blow_of(question: _Question, course: WaveHistory, outcome: BlowOutcome, fineness: Fineness) -> Blow:
    problem, reached = course.held.problem, question.until
    if reached is None or course.end != problem.until:
        reached = course.end * problem.tick * course.scales.time
    return Blow(
        **vars(balance(course)),
        striker=question.striker,
        target=question.target,
        velocity=question.velocity,
        until=reached,
        outcome=outcome,
        fineness=fineness,
        _course=course,
    )


def strike_again(blow: Blow, *, new_rock: bool = False, most_pieces: int = MOST_PIECES) -> Blow:
    """The blow that follows at the end of another one's window: a fresh striker touches the tool as that one left it.

    The earlier striker is gone; the new one is as fast, free of stress, and followed as finely, for as long.

    Parameters
    ----------
    blow
        On a rod, by a `velocity`, without a load.
    new_rock
        Whether fresh rock is laid before the bit: under the same force, or as far from it as it was.
    most_pieces
        Pieces of waves after which the window is cut short.

    Raises
    ------
    ParameterError
        For a blow on a wall, of a striker under load or with stress, and for one whose window was cut short.

    Examples
    --------
    >>> from percuss.blow import Feed, Rock, Rod, strike, strike_again
    >>> from percuss.model import Bar, Section
    >>> tool = Rod([Section(1.0, area=1e-3)], "rock", rock=Rock(4e8, 0.1), attenuation=0.06, feed=Feed(12e3))
    >>> first = strike(Bar(0.5, 1e-3), tool, 10.0, until=6e-3)
    >>> f"{strike_again(first).rock_dissipated / first.rock_dissipated:.3f}"
    '0.294'
    """
    instance("blow", blow, Blow)
    flag("new_rock", new_rock)
    most = count("most_pieces", most_pieces, 1, 1 << 40)
    course = blow._course
    problem = course.held.problem
    if blow.velocity is None or problem.load_start.size or not course.has_rod or course.end != problem.until:
        accepted = "one on a rod, by a velocity, without a load, followed to the end of its window"
        raise ParameterError("blow", blow, accepted)
    question = _checked(blow.striker, blow.target, blow.velocity, None, (), 0, blow.until, 0.0)
    held = _taken_over(_tables(question, _LEAST[blow.fineness]), course, new_rock)
    return _blow_of(question, *_followed(held, False, most), blow.fineness)


def _finest(question: _Question, few: int, most: int) -> tuple[WaveHistory, BlowOutcome, Fineness]:
    """The blow of the finest waves that do not have too many pieces, else cut short."""
    for fineness in (Fineness.EXACT, Fineness.SMOOTHED):
        found = _followed(_tables(question, _LEAST[fineness]), question.until is None, few)
        if found[1] is not BlowOutcome.TOO_MANY_PIECES:
            return *found, fineness
        del found  # half a gigabyte
    return *_followed(_tables(question, _LEAST[Fineness.COARSE]), question.until is None, most), Fineness.COARSE


def _followed(held: BlowTables, until_over: bool, most: int) -> tuple[WaveHistory, BlowOutcome]:
    """The blow to the end of its window, and how that ended."""
    problem, gap = held.problem, float(held.state.now[0].gap)
    transit = round(1.0 / problem.tick)
    ends_early = until_over and (problem.end == kn.FREE or not problem.stiffness > 0.0)
    target, spent = transit if ends_early else problem.until, False
    while True:
        target = min(target, problem.until)
        held, there = _carried_to(held, target, most)
        if not there:
            nodes = problem.impedance.size + (problem.end != kn.ENDLESS)  # nothing happens at an end at infinity
            return WaveHistory(held, int(held.state.time[:nodes].min()), gap), BlowOutcome.TOO_MANY_PIECES
        course = WaveHistory(held, target, gap)
        if ends_early and held.state.now[0].noted > 0:
            if is_over(course):
                return course, BlowOutcome.OVER
            if spent:  # a transit ago; meanwhile faces without a force have parted
                return course, BlowOutcome.SPENT
            spent = is_spent(course)
        if target == problem.until:
            return course, _ended(course)
        target += transit


def _ended(course: WaveHistory) -> BlowOutcome:
    """How a window ended that was not cut short."""
    if is_over(course):
        return BlowOutcome.OVER
    if course.in_contact:
        return BlowOutcome.SPENT if is_spent(course) else BlowOutcome.STILL_IN_CONTACT
    striker = course.striker
    own = course.momentum(0, striker, course.end) / course.mass
    face = course.node_velocity(striker, course.end) if course.has_rod else 0.0
    return BlowOutcome.GAP_CLOSING if own > face else BlowOutcome.WINDOW_ENDED


# ---- What the instantaneous laws need of a blow: restitution, duration, force centroid, advance; computed once, kept


@dataclass(frozen=True)
class EffectiveBlow:
    """One load-free blow of a striker without stress, by the few numbers that a law of contact needs.

    Attributes
    ----------
    restitution
        R_eff = −V_1/V_0; below 0 where the striker goes on.
    duration, centroid
        t_c and t_J from the start of the first contact; None where the contact never ends.
    advance
        How far the plane of impact moves in the blow, per speed of the striker, in s: J/Z of an endless rod that stays
        where it is left, the residual penetration of a rod on rock, 0 of a wall and of any other rod, which is pushed
        back.
    ringing
        Share of the energy before that rings in the striker afterwards.
    contacts, outcome
        How many there were, and how the window ended.
    """

    restitution: float
    duration: float | None
    centroid: float | None
    advance: float
    ringing: float
    contacts: int
    outcome: BlowOutcome


def effective_blow(
    striker: Striker, target: Target, velocity: float = 1.0, *, until: float | None = None
) -> EffectiveBlow:
    """The blow of a striker on a target from rest, with the last 256 questions kept.

    Without gaps no time and no ratio depends on the velocity; the rock's law is homogeneous as well. The window ends as
    that of `strike` does, or with `until`.

    Raises
    ------
    ParameterError
        For anything that `strike` refuses.
    ConvergenceError
        When the blow has too many pieces of waves to be followed.

    Examples
    --------
    >>> from percuss.blow import Rod
    >>> from percuss.model import UniformBar
    >>> found = effective_blow(UniformBar(20.0), Rod.of_impedance(80.0))
    >>> round(found.restitution, 12), round(found.duration, 12), round(found.centroid, 12)
    (0.6, 0.1, 0.05)
    """
    striker_sections(striker)
    if not isinstance(target, Wall | Rod):
        raise ParameterError("target", target, "a Wall or a Rod")
    end = None if until is None else positive("until", until)
    return _known(striker, target, positive("velocity", velocity), end)


@lru_cache(maxsize=256)
def _known(striker: Striker, target: Target, velocity: float, until: float | None) -> EffectiveBlow:
    blow = strike(striker, target, velocity, until=until, few_pieces=FEW_PIECES)
    if blow.outcome is BlowOutcome.TOO_MANY_PIECES:
        raise ConvergenceError("the waves of this blow have too many pieces", "leave the shortest sections out")
    advance = blow.residual_penetration or 0.0
    if isinstance(target, Rod) and target.end == "infinite":
        advance = blow.impulse / target.end_impedance
    return EffectiveBlow(
        restitution=float(blow.effective_restitution or 0.0),
        duration=blow.contact_duration,
        centroid=blow.force_centroid,
        advance=advance / velocity,
        ringing=blow.vibration_energy_after / blow.energy_before,
        contacts=len(blow.contacts),
        outcome=blow.outcome,
    )
