"""The periodic motions of a machine that switches its own valve, by their labels: blows / valve cycles in a period."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

import numpy as np

from percuss.errors import ParameterError, PercussError
from percuss.explore.continuation.machine_walk import doubled_cycles
from percuss.explore.continuation.walk import varied
from percuss.model import Machine
from percuss.model.checks import callback, count, instance
from percuss.shown import Shown
from percuss.simulate import Start, Stop, Trajectory, run
from percuss.steady.self_excited import Rhythm, ValveCycle, self_excited_motion
from percuss.steady.self_excited.event_sequence import EventSequence, sequence_in, sequence_of

_MOST_BLOWS = 64
_SAME = 1e-7  # of the period and of the speeds, by which two cycles that are one may differ
_IMPACTS = 400  # of a simulated motion, at most
_SPREAD = 0.3  # of the times between the events of a repeated cycle, by which they are moved
_AROUND = 0.2  # of the parameter, on either side, in which flips are looked for


@dataclass(frozen=True)
class FoundCycles(Shown):
    """The cycles of a label that were found; made by `valve_cycles`.

    Parameters
    ----------
    label, modes
        Blows and valve cycles in a period, such as "2/2", and N.
    orbits
        The cycles, stable ones first; none of them rests on the wall.
    tries
        How many starts were simulated, and orders of events tried.
    """

    label: str
    modes: int
    orbits: tuple[ValveCycle, ...] = field(repr=False)
    tries: int


def valve_cycles(
    machine: Machine,
    label: str,
    *,
    modes: int = 32,
    starts: int = 64,
    tries: int = 64,
    switch: bool = True,
    seed: int = 0,
    halt: Callable[[], bool] | None = None,
) -> FoundCycles:
    """The cycles of a label: of simulated motions, of repeated orders of events, and of what begins at flips.

    Parameters
    ----------
    machine
        Which switches its own valve.
    label
        Blows and valve cycles in a period.
    modes
        N.
    starts
        Random starts that are simulated.
    tries
        Times at which Newton's method starts, around those of shorter cycles repeated.
    switch
        Whether shorter cycles are followed through the pressure or the flow for the flips at which these begin.
    seed
        Of the random numbers.
    halt
        Once it returns true the answer is what has been found.

    Raises
    ------
    ParameterError
        For numbers out of range.

    Examples
    --------
    >>> from percuss.case import load_case
    >>> found = valve_cycles(load_case("valve-breaker").machine(), "1/1", modes=0, starts=4)
    >>> [f"{cycle.blow_speed:.5f}" for cycle in found.orbits]
    ['9.19297']
    """
    instance("machine", machine, Machine)
    count("starts", starts, least=0, most=10**6)
    callback("halt", halt)
    draw, found = np.random.default_rng(count("seed", seed, least=0)), list[ValveCycle]()
    asked, blows = 0, label_numbers(label)[0]

    def add(cycle: ValveCycle | None) -> None:
        if cycle is not None and not any(_same(cycle, other) for other in found):
            found.append(cycle)

    own = self_excited_motion(machine, modes=modes).cycle
    add(own if own is not None and not own.rests else None)
    for start in machine_starts(machine, starts, draw):
        if halt is not None and halt():
            break
        asked += 1
        add(settled_cycle(machine, run(machine, start, modes=modes, stop=Stop(_IMPACTS)), modes))
    shorter = [cycle for cycle in found if cycle.label != label and blows % cycle.blows == 0]
    for cycle in shorter:
        times = blows // cycle.blows
        for _ in range(tries if halt is None or not halt() else 0):
            asked += 1
            add(_repeated(machine, cycle, times, draw))
        if switch and times == 2:
            for one in _begun_at_flips(machine, cycle, halt):
                add(_proved(sequence_of(one), machine, modes, sequence_of(one).unknowns(one)))
    kept = sorted((cycle for cycle in found if cycle.label == label), key=lambda cycle: abs(cycle.multiplier))
    return FoundCycles(label, modes, tuple(kept), asked)


def label_numbers(label: str) -> tuple[int, int]:
    """Blows and valve cycles of a label."""
    parts = label.split("/")
    if len(parts) != 2 or not all(part.strip().isdecimal() for part in parts):
        raise ParameterError("label", label, "blows and valve cycles in a period, such as 2/2")
    blows, turns = (int(part) for part in parts)
    return count("label", blows, most=_MOST_BLOWS), count("label", turns, most=_MOST_BLOWS)


def settled_cycle(machine: Machine, motion: Trajectory, modes: int) -> ValveCycle | None:
    """The cycle that a simulated motion has settled on, solved for; None for none, and for one with a rest."""
    if motion.cycle is None or motion.cycle.kind or not motion.cycle.impacts:
        return None
    states = {"port": "port", "valve": "state", "impact": "impact_velocity"}
    events = [(one.time, one.kind, getattr(one, states[one.kind])) for one in motion.events if one.kind in states]
    try:
        rhythm = Rhythm.of_events(machine.valve, events, motion.cycle.impacts)
    except PercussError:
        return None
    sequence = sequence_in(machine.valve, rhythm)
    return (
        None if sequence is None else _proved(sequence, machine, modes, np.array([time for time, _ in rhythm.guarded]))
    )


def cycle_start(cycle: ValveCycle) -> Start:
    """The start of a cycle, just after a blow, of its piston as a whole."""
    return Start.rigid(0.0, -cycle.rebound.speed).with_valve(cycle.state, cycle.orders)


def _proved(sequence: EventSequence, machine: Machine, modes: int, unknowns: np.ndarray) -> ValveCycle | None:
    """The cycle near given times, if it is one."""
    try:
        found = sequence.solved(machine, modes, unknowns)
    except (PercussError, np.linalg.LinAlgError):
        return None
    return found if found is not None and sequence.fault(found) is None else None


def _same(one: ValveCycle, other: ValveCycle) -> bool:
    """Whether two cycles are one, whichever blow comes first, or one is the other repeated."""
    if one.blows % other.blows:
        return False
    times = one.blows // other.blows
    if abs(one.period - times * other.period) > _SAME * one.period:
        return False
    mine, its = np.array(one.blow_speeds), np.tile(other.blow_speeds, times)
    scale = _SAME * float(mine.max())
    return any(bool(np.all(np.abs(np.roll(mine, shift) - its) < scale)) for shift in range(one.blows))


def machine_starts(machine: Machine, number: int, draw: np.random.Generator) -> Iterator[Start]:
    """Random starts behind the wall, with any state of the valve."""
    valve = machine.valve
    way = max((port.behind for port in valve.ports if port.behind is not None), default=1.0)
    push = max(abs(valve.force(name)) for name, _ in valve.pairs)
    speed, names = math.sqrt(2.0 * push * way), [name for name, _ in valve.pairs]
    for _ in range(number):
        behind, velocity = 1.5 * way * draw.random(), speed * draw.uniform(-1.0, 1.0)
        yield Start.rigid(-behind, velocity).with_valve(names[int(draw.integers(len(names)))])


def _repeated(machine: Machine, cycle: ValveCycle, times: int, draw: np.random.Generator) -> ValveCycle | None:
    """A cycle of so many of another's orders of events, from times that are moved by chance."""
    period, rhythm = cycle.period, cycle.rhythm
    blows = tuple(time + turn * period for turn in range(times) for time in rhythm.blow_times)
    passages = tuple((time + turn * period, port) for turn in range(times) for time, port in rhythm.passages)
    sequence = sequence_in(machine.valve, Rhythm(blows, passages, rhythm.state, rhythm.orders))
    if sequence is None:
        return None
    unknowns = np.tile(sequence_of(cycle).unknowns(cycle), times).reshape(times, -1)
    longer = 1.0 + draw.uniform(-_SPREAD, _SPREAD, (times, 1))
    begins = np.append(0.0, np.cumsum(period * longer[:-1, 0]))[:, None]
    return _proved(sequence, machine, cycle.modes, (begins + unknowns * longer).reshape(-1))


def _begun_at_flips(machine: Machine, cycle: ValveCycle, halt: Callable[[], bool] | None) -> list[ValveCycle]:
    """The cycles of twice as many blows that begin at flips nearby and come by the machine itself."""
    supply = machine.valve.supply
    name, here = ("pressure", 1.0) if supply is None else ("supply.flow", supply.flow)
    try:
        over = varied(machine, None, [name], [((1.0 - _AROUND) * here, (1.0 + _AROUND) * here)], [here])
        return doubled_cycles(cycle, over, halt)
    except PercussError:
        return []
