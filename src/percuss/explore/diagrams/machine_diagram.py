"""The items of a diagram of machines that switch their own valve: passes of simulations, and branches of cycles."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from percuss.errors import PercussError
from percuss.explore.continuation.branch import Branch
from percuss.explore.continuation.following import follow
from percuss.explore.diagrams.diagram_lines import SettledMotion, line_of, with_new
from percuss.explore.family import SwitchingFamily
from percuss.explore.jobs.job import Columns
from percuss.explore.orbit_starts import last_rhythm, orbit_seeds
from percuss.model import Machine
from percuss.model.checks import Array
from percuss.steady import orbits
from percuss.steady.oil.oil_cycle import cycle_from
from percuss.steady.self_excited.settling import rest_cycles_of, solved

if TYPE_CHECKING:
    from percuss.simulate import Start, Stop, Trajectory
    from percuss.steady import ValveCycle

_STARTS = 16  # at each value at which cycles are searched for
_FEW = 4  # at each value at which that is followed on which simulations settle
_IMPACTS = 600  # of a simulation, where its stop rule allows more
_SAME = 1e-4  # of the greatest speed, by which the blows of two motions that are one may differ
_TURN = 2.0 * np.pi


def machine_branches(
    family: SwitchingFamily,
    name: str,
    between: tuple[float, float],
    values: Sequence[float],
    label: tuple[int, int] | None,
    *,
    switch: int,
    tries: int,
    modes: int,
    stopped: Callable[[], bool],
) -> list[Branch]:
    """All branches on which a cycle of a label was found at one of the values, and those that begin at their flips.

    Without a label those that some simulations settle on.
    """
    found: list[Branch] = []
    for value in values:
        if stopped():
            break
        try:
            machine = family.machine({name: value})
            known = _settled_on(machine, modes) if label is None else _searched(machine, label, modes, tries, stopped)
        except PercussError:  # there is no such machine
            continue
        for cycle in known:
            rows = [line.speeds_at(value) for line in found if line.label == cycle.label]
            told = slice(-1, None) if cycle.rests else slice(None)  # a chatter is told to some length
            if any(_alike(np.sort(cycle.blow_speeds)[told], np.sort(row)[told], 0.05) for its in rows for row in its):
                continue
            try:
                branch = follow(
                    cycle, name, between, family=family, value=value, switch=switch, progress=lambda _: stopped()
                )
            except PercussError:  # at an end of what can be followed
                continue
            lines = [line_of(one, lambda at: family.machine({name: at})) for one in branch.family()]
            found = with_new(found, lines)
    return found


def _searched(
    machine: Machine, label: tuple[int, int], modes: int, tries: int, stopped: Callable[[], bool]
) -> list[ValveCycle]:
    near = {} if machine.valve.flows else orbit_seeds(machine, *label, modes=modes, motions=_STARTS)
    found = orbits(machine, *label, modes=modes, tries=tries, near=near, progress=lambda _: stopped())
    known: Sequence[Any] = found.orbits
    return [*known, *(rest_cycles_of(machine, modes) if label == (1, 1) else ())]


def _settled_on(machine: Machine, modes: int) -> list[ValveCycle]:
    """The cycles that a few simulations settle on, solved for."""
    from percuss.explore.attractors.drawn_starts import named, speed_scale
    from percuss.simulate import Stop, run

    found, rests = [], False
    for start in named(machine, "wall" if speed_scale(machine) else "field", _FEW):
        motion = run(machine, start, modes=modes, stop=Stop(_IMPACTS))
        cycle = motion.cycle
        rests |= cycle is not None and cycle.kind > 0
        if machine.valve.flows:
            if cycle is not None and cycle.impacts:
                from percuss.simulate.oil import FlowingOil

                found.append(cycle_from(FlowingOil.restored(machine, modes, motion.snapshot).motion, cycle.impacts))
        elif cycle is not None and cycle.impacts and not cycle.kind:
            rhythm = last_rhythm(machine, start, motion, cycle.impacts)
            found.append(None if rhythm is None else solved(machine, modes, rhythm))
    return [*(one for one in found if one is not None), *(rest_cycles_of(machine, modes) if rests else ())]


# ---- What simulations settle on

_CYCLE, _IRREGULAR, _UNDECIDED = 0, 100, 101

_ROUNDING = 1e-6  # share of a period within which an impact is the one a period later


def machine_pass(
    machines: Sequence[Machine | None],
    modes: int,
    stop: Stop,
    seed: int,
    found: Columns,
    taken_along: bool,
    stopped: Callable[[], bool],
) -> Columns:
    """A random start for each machine, or one motion taken along, up the values; what is kept is put into `found`."""
    from percuss.explore.attractors.drawn_starts import named, speed_scale
    from percuss.simulate import STALLS, Stop, run

    begun = None
    limited = Stop(min(stop.impacts or _IMPACTS, _IMPACTS), stop.time, stop.periodic, stop.tolerance)
    for i, machine in enumerate(machines):
        if machine is None or stopped():
            continue
        if begun is None:
            (begun,) = named(machine, "wall" if speed_scale(machine) else "field", 1, seed + i)
        motion = run(machine, begun, modes=modes, stop=limited)
        cycle, stalls = motion.cycle, motion.label.partition("(")[2].rstrip(")")
        code = STALLS.index(stalls) + 1 if stalls in STALLS else _CYCLE if cycle is not None else _IRREGULAR
        found["code"][i] = _UNDECIDED if motion.label == "undecided" else code
        if cycle is not None:
            found["cycle_impacts"][i], found["cycle_periods"][i] = cycle.impacts, cycle.periods
            found["cycle_kind"][i] = cycle.kind
        _put(found, i, motion)
        begun = _going_on(machine, begun, motion) if taken_along and cycle is not None else None
    return found


def _put(found: Columns, i: int, motion: Trajectory) -> None:
    """Phases in the cycle, and speeds, of its impacts, of a long chatter the fastest ones, or of the last ones."""
    struck = motion.events.of("impact")
    room, cycle = found["phases"].shape[-1], motion.cycle
    times, speeds = np.asarray(struck.time), np.asarray(struck.impact_velocity)
    energies = np.asarray(struck.kinetic_energy)
    if not times.size:
        return
    last = np.arange(max(0, times.size - room), times.size)
    mains = last
    if cycle is not None and cycle.impacts:
        last = np.flatnonzero(times > times[-1] - cycle.period * (1.0 - _ROUNDING))
        fastest = last[np.argsort(-speeds[last], kind="stable")]
        last, mains = np.sort(fastest[:room]), fastest[: cycle.impacts]
    found["blow_energy"][i] = float(np.mean(energies[mains]))
    found["speeds"][i, : last.size] = speeds[last]
    period = cycle.period if cycle is not None else float(times[last[-1]] - times[last[0]]) or 1.0
    found["phases"][i, : last.size] = np.mod(_TURN * (times[last] - times[-1]) / period, _TURN)


def _going_on(machine: Machine, begun: Start, motion: Trajectory) -> Start | None:
    """The motion of the piston as a whole just after its last blow but one, as a start of another machine."""
    from percuss.simulate import Start

    rhythm = last_rhythm(machine, begun, motion)
    struck = motion.events.of("impact")
    if rhythm is None or len(struck) < 2:
        return None
    return Start.rigid(0.0, float(struck.rebound_velocity[-2])).with_valve(rhythm.state, rhythm.orders)


def machine_settled_at(passes: Columns, i: int, value: float, scales: Array) -> list[SettledMotion]:
    """What the passes settled on at value number i."""
    from percuss.simulate import STALLS, MotionCycle
    from percuss.simulate.events import machine_label

    groups: dict[tuple[object, ...], list[int]] = {}
    for row in np.flatnonzero(passes["code"][:, i] >= 0).tolist():
        code = int(passes["code"][row, i])
        p, n, kind = (int(passes[name][row, i]) for name in ("cycle_impacts", "cycle_periods", "cycle_kind"))
        cycle = MotionCycle(0, p, n, kind, np.nan, np.nan, np.nan) if code == _CYCLE else None
        label = machine_label(STALLS[code - 1] if 0 < code < _IRREGULAR else "", cycle, code == _IRREGULAR)
        speeds = np.sort(passes["speeds"][row, i][np.isfinite(passes["speeds"][row, i])]) if cycle else np.empty(0)
        key = next((key for key in groups if key[0] == label and _alike(np.array(key[1:]), speeds)), None)
        groups.setdefault(key or (label, *speeds.tolist()), []).append(row)
    made = (float(scales[0]), float(scales[1])) if scales[0] > 0.0 else None
    found = []
    for key, rows in sorted(groups.items(), key=lambda item: -len(item[1])):
        phases, speeds = (passes[name][rows[0], i] for name in ("phases", "speeds"))
        kept = np.isfinite(phases)
        energy = float(passes["blow_energy"][rows[0], i])
        found.append(SettledMotion(value, str(key[0]), len(rows), phases[kept], speeds[kept], energy, made))
    return found


def _alike(one: Array, other: Array, near: float = _SAME) -> bool:
    return one.shape == other.shape and bool(
        np.all(np.abs(one - other) <= near * (1e-300 + np.abs(one).max(initial=0.0)))
    )
