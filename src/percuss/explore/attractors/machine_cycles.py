"""Motions of machines that switch their own valves, followed to what they settle on, as columns of numbers."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from percuss.explore.attractors.motion_columns import some
from percuss.explore.jobs.job import Column, Columns

if TYPE_CHECKING:
    from percuss.model import Machine
    from percuss.simulate import MachineStart, MachineStarts, Stop

__all__ = ["MACHINE_COLUMNS", "blows_of", "followed", "labels", "motion_keys"]

_BLOCK = 1024  # members at once

MACHINE_COLUMNS: dict[str, Column] = {
    "code": Column("int8", meaning="how the simulation ended, its number in percuss.simulate.MACHINE_OUTCOMES"),
    "stall": Column("int8", meaning="where it stalls, its number in percuss.simulate.STALLS; -1: it does not"),
    "impacts": Column("int64", meaning="impacts from the start"),
    "end_time": Column(unit="machine's unit of time", meaning="time from the start to the last event"),
    "blows": Column("int64", meaning="main blows in a period; 0: none, or no period was found"),
    "valve_cycles": Column("int64", meaning="how often the valve comes to the same state in a period; 0: none found"),
    "cycle_kind": Column("int8", meaning="periodic motion without rest (0), with rest (1), with chatter and rest (2)"),
    "wanders": Column("bool", meaning="whether the last changes of the valve do not come near any earlier ones"),
    "period": Column(unit="machine's unit of time", meaning="of the periodic motion"),
    "blow_speed": Column(meaning="striking speed of the strongest blow of a period"),
    "energy_lost": Column(meaning="what blows, chatter and rest take in a period, per unit of mass"),
}
"""What is kept of every motion."""


def followed(
    machine: Machine,
    starts: MachineStarts,
    modes: int,
    stop: Stop,
    threads: int | None,
    stopped: Callable[[], bool],
) -> Columns:
    """`MACHINE_COLUMNS` of the motions from all starts, each by itself."""
    from percuss.simulate import MACHINE_OUTCOMES, simulate_machines

    parts: list[Columns] = []
    for first in range(0, len(starts), _BLOCK):
        block = some(starts, slice(first, first + _BLOCK))
        many = simulate_machines(machine, block, modes=modes, stop=stop, threads=threads, progress=lambda _: stopped())
        code = np.array([MACHINE_OUTCOMES.index(word) for word in many.outcome.tolist()])
        same = {name: getattr(many, name) for name in MACHINE_COLUMNS if name not in ("code", "cycle_kind")}
        parts.append({**same, "code": code, "cycle_kind": many.kind})
        if stopped():
            break
    return {
        name: np.concatenate([part[name] for part in parts]).astype(column.dtype)
        for name, column in MACHINE_COLUMNS.items()
    }


def motion_keys(columns: Columns) -> npt.NDArray[np.int64]:
    """A whole number for each label: equal keys, equal labels; from `PERIODIC` on of motions with a period."""
    from percuss.simulate import STALLS

    blows, turns = columns["blows"].astype(np.int64), columns["valve_cycles"].astype(np.int64)
    rests = np.minimum(columns["cycle_kind"].astype(np.int64), 1)
    size = int(blows.max(initial=0)) + 1
    key = np.where(columns["wanders"], len(STALLS), len(STALLS) + 1)
    key = np.where(turns > 0, PERIODIC + rests + 2 * (blows + size * turns), key)
    return np.asarray(np.where(columns["stall"] >= 0, columns["stall"].astype(np.int64), key), dtype=np.int64)


PERIODIC = 8


def labels(columns: Columns) -> npt.NDArray[np.str_]:
    """What motion each is at its end, as `MachineTrajectory.label`."""
    key = motion_keys(columns)
    _, first, which = np.unique(key, return_index=True, return_inverse=True)
    return np.array([_label(columns, int(i)) for i in first], dtype=str)[which.reshape(-1)]


def _label(columns: Columns, i: int) -> str:
    from percuss.simulate import STALLS, MachineCycle
    from percuss.simulate.machine.machine_summary import machine_label

    stall, turns = int(columns["stall"][i]), int(columns["valve_cycles"][i])
    cycle = None
    if turns:
        numbers = (float(columns[name][i]) for name in ("period", "energy_lost", "blow_speed"))
        cycle = MachineCycle(0, int(columns["blows"][i]), turns, int(columns["cycle_kind"][i]), *numbers)
    return machine_label(STALLS[stall] if stall >= 0 else "", cycle, bool(columns["wanders"][i]))


def blows_of(
    machine: Machine, start: MachineStart, modes: int, stop: Stop
) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Speeds and energies of the blows of one period, in order of time from the strongest on; empty without a period.

    The motion from a start, followed once more. Bounces of a chatter are no blows of their own.
    """
    from percuss.simulate import run_machine

    motion = run_machine(machine, start, modes=modes, stop=stop)
    cycle = motion.cycle
    if cycle is None or not cycle.blows:
        return (), ()
    struck = motion.events.of("impact")
    last = float(motion.events.time[-1])
    inside = np.flatnonzero(struck.time > last - cycle.period * (1.0 - 1e-9))
    strongest = np.sort(np.argsort(-struck.velocity[inside], kind="stable")[: cycle.blows])
    main = inside[strongest]  # what bounces is weaker than the blow that it follows
    if not main.size:
        return (), ()
    order = np.roll(main, -int(np.argmax(struck.velocity[main])))
    return tuple(struck.velocity[order].tolist()), tuple(struck.kinetic_energy[order].tolist())
