"""The simulator as a map from blow to blow of a machine: an oracle for its cycles, which knows nothing of them."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from percuss.model.load.valve import Orders, port_at
from percuss.simulate import Start, Stop, run
from percuss.simulate.valve import mechanism
from percuss.steady import ValveCycle


class Landed(NamedTuple):
    """Times of blows, and of the last one the numbers just after it; last demand and pending states there."""

    times: np.ndarray
    numbers: np.ndarray
    last: str
    waiting: tuple[str, ...]


def beginning(cycle: ValveCycle) -> np.ndarray:
    """u_n, u_n', the pressure where it is free, and the times of the pending orders just after the blow at time 0."""
    machine, first = cycle.machine, cycle.flights[0]
    own = (first.modes.mixing @ first.begin).T / mechanism(machine, cycle.modes).own_units
    pressure = [] if machine.valve.supply is None else [first.pressure]
    return np.concatenate([own.reshape(-1), pressure, [due for due, _ in cycle.orders.pending]])


def landed(cycle: ValveCycle, numbers: np.ndarray) -> Landed:
    """Where the machine of a cycle is after as many blows, from the numbers just after one."""
    n, machine, waiting = cycle.modes + 1, cycle.machine, [to for _, to in cycle.orders.pending]
    valve, supply = machine.valve, machine.valve.supply
    dues = numbers[numbers.size - len(waiting) :].tolist()
    orders = Orders(cycle.orders.last, tuple(zip(dues, waiting, strict=True)))
    begins = 1.0 if supply is None else float(numbers[2 * n])
    for i, port in enumerate(valve.ports):
        orders = orders.after(0.0, port_at(valve, i, begins)) if port.on == "impact" else orders
    if supply is not None:
        machine = machine.with_valve(replace(valve, supply=replace(supply, start=begins)))
    start = Start(tuple(numbers[:n].tolist()), tuple(numbers[n : 2 * n].tolist()), gap=0.0)
    stop = Stop(impacts=cycle.blows, periodic=False)
    motion = run(machine, start.with_valve(cycle.state, orders), modes=cycle.modes, stop=stop)
    assert motion.impacts == cycle.blows, motion.label
    blows = motion.blow_times
    ports = [event for event in motion.events if event.kind == "port" and event.time < blows[-1]]
    for event in ports:
        pressure = 1.0 if supply is None else float(motion.pressure([event.time])[0])
        orders = _left(orders, event.time).after(event.time, port_at(valve, event.port, pressure))
    orders = _left(orders, blows[-1])
    after = motion.modal(blows[-1:])
    told = [after.displacement[:, 0], after.velocity[:, 0], *([] if supply is None else [motion.pressure(blows[-1:])])]
    told.append(np.array([due - blows[-1] for due, _ in orders.pending]))
    return Landed(blows, np.concatenate(told), orders.last, tuple(to for _, to in orders.pending))


def _left(orders: Orders, time: float) -> Orders:
    """Without those that were due before."""
    return replace(orders, pending=tuple(order for order in orders.pending if not order[0] < time))


def differences(cycle: ValveCycle, step: float = 1e-5) -> np.ndarray:
    """The derivative of that map on the wall, by differences of the fourth order: u_0 follows from the others."""
    begin, n = beginning(cycle), cycle.modes + 1
    at_end = np.concatenate([[1.0], 2.0 * (-1.0) ** np.arange(1, n)])  # of a uniform bar
    columns = []
    for i in range(1, begin.size):
        aside = np.zeros(begin.size)
        aside[i] = step
        aside[0] = -at_end[1:] @ aside[1:n]
        near, far = (
            (landed(cycle, begin + k * aside).numbers - landed(cycle, begin - k * aside).numbers) / (2.0 * k * step)
            for k in (1.0, 2.0)
        )
        columns.append((4.0 * near - far) / 3.0)
    return np.array(columns).T[1:]
