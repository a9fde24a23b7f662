"""The cells of a map of machines that switch their own valves: what each does, failures as values."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

from percuss.errors import PercussError
from percuss.explore.cells import empty_columns, failure
from percuss.explore.family import SwitchingFamily
from percuss.explore.jobs.job import Columns
from percuss.explore.machine_quantities import MACHINE_QUANTITIES, STALLS
from percuss.model import Machine
from percuss.steady.self_excited import Obstacle, SelfExcited, self_excited_motion
from percuss.steady.self_excited.many_pistons import rigid_cycles

__all__ = ["machine_columns"]

_NUMBERS = {obstacle: STALLS.index(obstacle.value) for obstacle in Obstacle}
_PORTION = 256  # machines looked at between two looks at whether the answer is still wanted


def machine_columns(
    family: SwitchingFamily,
    cells: Sequence[Mapping[str, float]],
    names: Sequence[str],
    modes: int,
    si: bool,
    stopped: Callable[[], bool],
) -> tuple[Columns, list[Machine | None]]:
    """The columns of cells, and their machines.

    Parameters
    ----------
    cells
        The parameters of each.
    names
        Of the quantities.
    modes
        N, the elastic modes.
    si
        Whether the machines have scales: energies are in J then.
    """
    out = empty_columns(names, len(cells), si, MACHINE_QUANTITIES)
    out["outcome"][:] = 0
    machines: list[Machine | None] = []
    for i, cell in enumerate(cells):
        machine = None
        try:
            machine = family.machine(cell)
        except (PercussError, ArithmeticError) as error:
            out["outcome"][i] = failure(error)
        machines.append(machine)
    if not any(MACHINE_QUANTITIES[name].group == "machine" for name in names):
        return out, machines
    there = [(i, machine) for i, machine in enumerate(machines) if machine is not None]
    for first in range(0, len(there), _PORTION):
        if stopped():
            break
        _of_machines(out, family, there[first : first + _PORTION], modes, si)
    return out, machines


class _Cycle(NamedTuple):
    """What is used of a cycle with one blow, per unit of mass."""

    period: float
    speed: float
    energy: float
    stroke: float
    work: float
    taken: float
    duty: float
    multiplier: float


def _of_machines(
    out: Columns, family: SwitchingFamily, there: Sequence[tuple[int, Machine]], modes: int, si: bool
) -> None:
    """What some machines do: rigid pistons all at once."""
    left = there
    if modes == 0:
        machines = [machine for _, machine in there]
        found = rigid_cycles(machines, [family.room(machine) for machine in machines], starts="starts" in out)
        arrays = (getattr(found, name).tolist() for name in _Cycle._fields)
        rows = zip(there, found.answered, found.obstacles, zip(*arrays, strict=True), found.starts, strict=True)
        left = []
        for one, answered, obstacle, numbers, starts in rows:
            if answered:
                _put(out, *one, obstacle, _Cycle(*numbers), starts, si)
            else:
                left.append(one)
    for i, machine in left:
        try:
            kept = modes if machine.valve.supply is None else 0  # the piston of a machine with a supply is rigid
            motion = self_excited_motion(machine, modes=kept, room=family.room(machine))
            starts = "starts" in out and motion.starts_from_rest
            _put(out, i, machine, motion.obstacle, _of(motion), starts, si)
        except (PercussError, ArithmeticError) as error:
            out["outcome"][i] = failure(error)


def _of(motion: SelfExcited) -> _Cycle | None:
    cycle = motion.cycle
    if cycle is None or cycle.blows > 1:
        return None
    return _Cycle(
        cycle.period,
        cycle.blow_speed,
        cycle.blow_energy,
        cycle.stroke,
        cycle.work,
        cycle.taken,
        cycle.duty,
        abs(cycle.multiplier),
    )


def _put(
    out: Columns, i: int, machine: Machine, obstacle: Obstacle | None, cycle: _Cycle | None, starts: bool, si: bool
) -> None:
    """Fill in one cell."""
    found: dict[str, float | None] = {"runs": obstacle is None, "starts": starts}
    found["stall"] = 0 if obstacle is None else _NUMBERS[obstacle]
    if cycle is not None:
        found["multiplier"] = cycle.multiplier
        if obstacle is None:
            found |= _figures(machine, cycle, si)
    for name, values in out.items():
        value = found.get(name)
        if value is not None:
            values[i] = value


def _figures(machine: Machine, cycle: _Cycle, si: bool) -> dict[str, float | None]:
    """Of a machine that runs, in SI or dimensionless; None where there is no such figure."""
    length, time, energy = (machine.length_scale, machine.time_scale, machine.energy_scale) if si else (1.0, 1.0, 1.0)
    period = cycle.period * time
    drawn, supply = None, machine.valve.supply
    volume = cycle.work if supply is None else supply.flow * cycle.period
    if machine.pressure is not None and si:
        drawn = volume * energy / machine.pressure
    elif not si:
        forces = [force for _, force in machine.valve.pairs]
        drawn = volume / (max(forces) - min(forces))
    return {
        "blow_energy": cycle.energy * energy,
        "rate": 1.0 / period,
        "speed": cycle.speed * length / time,
        "stroke": cycle.stroke * length,
        "power": cycle.taken * energy / period,
        "flow": None if drawn is None else drawn / period,
        "efficiency": cycle.taken / cycle.work,
        "duty": cycle.duty,
    }
