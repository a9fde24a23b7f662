"""Simulations over the values of a parameter: from new starts at each, or one motion taken along up and down."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from percuss.explore.attractors.cycles import INVARIANTS, invariants_of
from percuss.explore.attractors.grouping import matched
from percuss.explore.attractors.start_distributions import FIELD_DEPTH, FIELD_SPEED
from percuss.explore.jobs.job import Column, Columns
from percuss.model import HeldBody, System

if TYPE_CHECKING:
    from percuss.simulate import Ensemble, Start, Stop, Trajectory

__all__ = ["KEPT", "UNKNOWN", "fresh_pass", "pass_columns", "running_pass"]

KEPT = 64
"""Impacts that are kept of a motion: those of its cycle, or its last ones."""

UNKNOWN = -1
"""The code of a value at which nothing was simulated."""

_WINDOW = 256
_LOOKED = 32  # random starts among whose motions one is chosen to be taken along
_TURN = 2.0 * np.pi


def pass_columns(values: int) -> dict[str, Column]:
    """What is kept of the motions at so many values."""
    at = (values,)
    return {
        "code": Column("int8", at, meaning="how the simulation ended, its number in percuss.simulate.OUTCOMES"),
        "cycle_impacts": Column("int64", at, meaning="impacts of the periodic motion; 0: none found"),
        "cycle_periods": Column("int64", at, unit="load periods", meaning="length of the periodic motion"),
        "cycle_kind": Column("int8", at, meaning="periodic motion without rest (0), with rest (1), with chatter (2)"),
        "wanders": Column("bool", at, meaning="whether the last impacts do not come near any earlier ones"),
        "blow_energy": Column(shape=at, meaning="mean kinetic energy just before a main blow"),
        "invariants": Column(shape=(*at, INVARIANTS), meaning="of the set of impacts of the periodic motion"),
        "phases": Column(shape=(*at, KEPT), unit="rad", meaning="load phases of the impacts"),
        "speeds": Column(shape=(*at, KEPT), meaning="striking speeds of the impacts"),
    }


def _empty(values: int) -> Columns:
    return {
        name: np.full(column.shape, column.empty, dtype=column.dtype) for name, column in pass_columns(values).items()
    }


def fresh_pass(
    systems: Sequence[System | None], modes: int, stop: Stop, seed: int, number: int, stopped: Callable[[], bool]
) -> Columns:
    """A new random start for each system: every pass has another one, and each value its own.

    Half of them leave the wall as in the distribution ``wall`` of experiments, half come from afar as in ``field``.
    """
    from percuss.simulate import simulate_many

    found = _empty(len(systems))
    there = [i for i, system in enumerate(systems) if system is not None]
    if not there:
        return found
    known = [system for system in systems if system is not None]
    starts = [start for _, start in zip(there, _starts(known, seed, number), strict=True)]
    many = simulate_many(
        known, starts, modes=modes, stop=stop, keep=_WINDOW, threads=1, progress=lambda _: stopped()
    )  # fmt: skip
    assert many.last_phase is not None and many.last_velocity is not None
    for row, i in enumerate(there):
        _put(found, i, many, row, many.last_phase[row], many.last_velocity[row], known[row])
    return found


def running_pass(
    systems: Sequence[System | None],
    modes: int,
    stop: Stop,
    seed: int,
    place: float,
    rank: int,
    stopped: Callable[[], bool],
) -> Columns:
    """One motion taken along: from a system upwards and downwards, each from where the motion of the one before ended.

    Parameters
    ----------
    systems
        One for each value; None where there is none, which no motion passes.
    modes, stop, seed
        Of the simulations.
    place, rank
        At which share of the values it begins, and with which of the motions that random starts settle on there: 0 for
        the most frequent. Where there are fewer there is nothing to take along.
    stopped
        Whether the answer is no longer wanted.
    """
    found, first = _empty(len(systems)), min(int(place * len(systems)), len(systems) - 1)
    here = systems[first]
    begun = None if here is None else _begun(here, modes, stop, seed, rank)
    if begun is None:
        return found
    settled = None
    for ways in (range(first, len(systems)), range(first - 1, -1, -1)):
        start: Start | None = begun if settled is None else settled
        for i in ways:
            system = systems[i]
            if stopped() or system is None or start is None:
                break
            start = _followed(found, i, system, start, modes, stop)
            settled = start if i == first else settled
    return found


def _begun(system: System, modes: int, stop: Stop, seed: int, rank: int) -> Start | None:
    """A start that settles on the motion of a rank; None where there are fewer."""
    from percuss.simulate import simulate_many

    starts = [start for number in (0, 1) for start in _starts([system] * (_LOOKED // 2), seed, number)]
    many = simulate_many(system, starts, modes=modes, stop=stop, keep=_WINDOW, threads=1)
    assert many.last_phase is not None and many.last_velocity is not None
    rows = _empty(len(starts))
    for i in range(len(starts)):
        _put(rows, i, many, i, many.last_phase[i], many.last_velocity[i], system)
    number = matched(rows, float(np.abs(system.load.coefficients).sum()))
    return starts[int(np.argmax(number == rank))] if rank <= int(number.max()) else None


def _followed(found: Columns, i: int, system: System, start: Start, modes: int, stop: Stop) -> Start | None:
    """Simulate at value number i; the state in which the motion ends."""
    from percuss.simulate import simulate_many

    start = _at_wall(system, start)
    many = simulate_many(system, start, modes=modes, stop=stop, keep="everything", threads=1)
    motion = many.trajectories[0]
    events = motion.events[motion.events.kind == "impact"]
    _put(found, i, many, 0, events.phase[-_WINDOW:], events.impact_velocity[-_WINDOW:], system)
    return _end(motion)


def _starts(systems: Sequence[System], seed: int, number: int) -> Iterator[Start]:
    from percuss.simulate import Start

    random = np.random.default_rng([seed, number])
    for system in systems:
        phase, speed, depth = _TURN * random.random(), random.standard_normal(), random.random()
        if number % 2:
            yield Start.rigid(-FIELD_DEPTH * depth, FIELD_SPEED * speed, phase)
        else:
            scale = _TURN * abs(system.load.mean) / system.contact.impulse
            yield Start.rigid(0.0, -max(scale * abs(speed), 1e-3), phase)


def _end(motion: Trajectory) -> Start | None:
    """The state after the last event, as a start; None of a motion that has left for good, or never struck."""
    from percuss.simulate import Start

    if motion.outcome == "departed" or not len(motion.events):
        return None
    u, v = motion.displacement[-1], motion.velocity[-1]
    return Start(tuple(u.tolist()), tuple(v.tolist()), float(motion.events.phase[-1]), gap=0.0)


def _at_wall(system: System, start: Start) -> Start:
    """The end of another system's motion as a start: a structure whose wall was elsewhere is bent until it is there."""
    from percuss.simulate import Start
    from percuss.simulate.spectrum import units

    body, modes = system.body, len(start.displacement) - 1
    if not isinstance(body, HeldBody) or not modes:
        return start
    u, shape = np.array(start.displacement[1:]), body.bent(modes, system.load.at)
    by = body.gap - float(u @ units(body.modes(modes, system.load.at)))
    return Start((-body.gap, *(u + by * shape).tolist()), start.velocity, start.time, gap=0.0)


def _put(
    found: Columns, i: int, many: Ensemble, row: int, phases: np.ndarray, speeds: np.ndarray, system: System
) -> None:
    """The motion of one system as a row."""
    for name in ("code", "cycle_impacts", "cycle_periods", "cycle_kind", "wanders", "blow_energy"):
        found[name][i] = getattr(many, name)[row]
    p = int(many.cycle_impacts[row])
    short = np.array([p if p <= phases.size else 0])
    lasting = np.array([int(many.cycle_periods[row])])
    invariants, _, _ = invariants_of(phases[None], speeds[None], short, lasting, system.load.harmonics)
    found["invariants"][i] = invariants[0]
    if str(many.outcome[row]) in ("rest", "departed"):
        return
    wanted = min(p or KEPT, phases.size)
    last = np.arange(phases.size - wanted, phases.size)
    last = last[np.isfinite(phases[last])]
    if last.size > KEPT:  # of a long chatter the fastest
        last = np.sort(last[np.argsort(speeds[last])[-KEPT:]])
    found["phases"][i, : last.size] = phases[last]
    found["speeds"][i, : last.size] = speeds[last]
