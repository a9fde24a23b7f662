"""The cycle of an elastic machine near a rhythm: Newton's method on the times of its events, then the proof."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from percuss.model import Machine, MachineModes
from percuss.model.checks import Array
from percuss.steady.self_excited.elastic_chain import Chain, Closed
from percuss.steady.self_excited.elastic_cycle import Blow, ElasticCycle
from percuss.steady.self_excited.elastic_following import watched
from percuss.steady.self_excited.elastic_multipliers import cycle_map
from percuss.steady.self_excited.first_entering import first_entering
from percuss.steady.self_excited.modal_flight import ModalFlight
from percuss.steady.self_excited.piston_records import Switch, Uncovering
from percuss.steady.self_excited.rhythm import Rhythm, orders_after, steps_of

__all__ = ["Solved", "blow_of", "solved", "switch_of"]

_STEPS = 30
_CLOSED = 2e-14  # of the period
_NEARLY = 1e-11  # … where rounding lets no step be smaller
_HALVINGS = 5
_OUT_OF_ORDER = 0.02  # of the period, on the way to the solution
_TOGETHER = 1e-12  # of the period: simultaneous events

Problem = Literal["order", "no root", "direction", "wall", "port"]
"""Why there is no cycle: the valve is not as it was after a cycle, or events change their order; Newton's method finds
none; a port or the wall is met from the wrong side; the bar strikes, or enters a port's region, at another time."""


@dataclass(frozen=True)
class Solved:
    """The cycle, or why it is none and when that shows."""

    cycle: ElasticCycle | None
    problem: Problem | None = None
    time: float | None = None
    proven: bool = True


def solved(machine: Machine, count: int, rhythm: Rhythm) -> Solved:
    """The cycle with this order of events to which Newton's method leads from these times."""
    steps = steps_of(machine.valve, rhythm)
    if steps is None:
        return Solved(None, "order")
    chain = Chain(machine, count, steps, rhythm.state, rhythm.orders.last)
    found = _root(chain, np.array([step.time for step in steps if step.kind != "due"]))
    if found is None:
        return Solved(None, "no root")
    unknowns, motion = found
    times = np.concatenate([[0.0], chain.times(unknowns)])
    if np.any(np.diff(times) < -_TOGETHER * times[-1]):
        return Solved(None, "order", float(times[1:][np.diff(times) < 0.0][0]))
    for row, state, step, time in zip(chain.rows, motion.states, steps, times[1:], strict=True):
        if step.kind != "due" and chain.sign(step) * float(row @ state[:, 1]) <= 0.0:
            return Solved(None, "direction", float(time))
    flights = _flights(chain, times, motion)
    proven = True
    for flight in flights:
        regions, ports = watched(machine, chain.modes, flight.last)
        other = first_entering(flight, regions)
        proven &= other.proven
        if other.which >= 0:
            return Solved(None, "wall" if ports[other.which] < 0 else "port", flight.time + other.time)
    return Solved(_cycle(chain, unknowns, motion, flights, rhythm), proven=proven)


def _root(chain: Chain, unknowns: Array) -> tuple[Array, Closed] | None:
    """The times at which everything closes, by Newton's method with steps that keep the order of events."""
    try:
        motion = chain.closed(unknowns)
        smallest = np.inf
        for _ in range(_STEPS):
            step = np.linalg.solve(motion.slope, -motion.error)
            size = float(np.abs(step).max() / unknowns[-1])
            if not np.isfinite(size):
                return None
            if size <= _CLOSED or (smallest <= _NEARLY and size >= 0.5 * smallest):
                return unknowns + step, chain.closed(unknowns + step)
            smallest = min(smallest, size)
            for _ in range(_HALVINGS):
                after = unknowns + step
                if after[-1] > 0.0 and np.all(np.diff(chain.times(after)) > -_OUT_OF_ORDER * after[-1]):
                    break
                step = 0.5 * step
            else:
                return None
            unknowns = unknowns + step
            motion = chain.closed(unknowns)
    except (np.linalg.LinAlgError, FloatingPointError):
        return None
    return None


def _flights(chain: Chain, times: Array, motion: Closed) -> tuple[ModalFlight, ...]:
    begins = [motion.start, *motion.states[:-1]]
    begins = [begins[0], *(chain.turn * z if chain.turns(i) else z for i, z in enumerate(begins[1:]))]
    return tuple(
        ModalFlight(chain.modes, state, last, force, float(start), float(end - start), begin)
        for state, last, force, start, end, begin in zip(
            chain.states, chain.lasts, chain.forces, times, times[1:], begins, strict=False
        )
    )


def blow_of(modes: MachineModes, time: float, state: Array) -> Blow:
    """The blow that a state just before it makes."""
    speed, strained = state[:, 1], modes.omega * state[:, 0]
    return Blow(time, float(modes.end @ speed), 0.5 * float(speed @ speed), 0.5 * float(strained @ strained))


def switch_of(machine: Machine, driven: Array, time: float, change: tuple[str, str], state: Array) -> Switch:
    """A change of the valve from one state to another."""
    rise = machine.valve.force(change[1]) - machine.valve.force(change[0])
    behind = -float(driven @ state[:, 0])
    return Switch(time, change[1], behind, -float(driven @ state[:, 1]), rise * behind)


def _cycle(
    chain: Chain, unknowns: Array, motion: Closed, flights: tuple[ModalFlight, ...], rhythm: Rhythm
) -> ElasticCycle:
    modes, machine = chain.modes, chain.machine
    struck, changed, passed = [], [], []
    for i, (step, state) in enumerate(zip(chain.steps, motion.states, strict=True)):
        time = flights[i].time + flights[i].duration
        if step.kind == "blow":
            struck.append(blow_of(modes, time, state))
        elif step.kind == "port":
            passed.append(Uncovering(step.port, time, -float(chain.rows[i] @ state[:, 1])))
        else:
            changed.append(switch_of(machine, modes.driven, time, (chain.states[i], step.state), state))
    times, ports = tuple(blow.time for blow in struck), tuple((one.time, one.port) for one in passed)
    now = Rhythm(times, ports, rhythm.state, rhythm.orders)
    now = replace(now, orders=orders_after(machine.valve, now))
    slope = cycle_map(chain, unknowns, motion)
    return ElasticCycle(machine, modes.size, flights, tuple(struck), tuple(changed), tuple(passed), slope, now)
