"""Records of the force on a piston that switches its own valve, as sensors give them: sampled, filtered, with noise."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from percuss.model import Chamber, Contact, External, Machine, Port, UniformBar, Valve
from percuss.steady.self_excited.piston import Piston, settled

MASS = 88.8  # kg, of the piston of the breaker


def breaker(return_delay: float = 0.5e-3, front: float = 4e-3, pressure: float = 160.0, delay: float = 5e-3) -> Valve:
    """A breaker of the class 19–28 t at a supply pressure (bar), per kg of its piston, in m and s."""
    back, push = -8.2e-4 * pressure * 1e5, 7.8e-4 * pressure * 1e5
    ports = [
        Port("power", behind=0.130, side="back", delay=delay),
        Port("return", behind=front, side="front", delay=return_delay),
    ]
    states = {"return": back / MASS, "power": push / MASS}
    return Valve(states, ports, chamber=Chamber(9e3 / MASS, 20e3 / MASS))


def drifter() -> Valve:
    """A drifter of the class 18–19 kW, per kg of its piston."""
    ports = [
        Port("power", behind=0.022, side="back", delay=1e-3),
        Port("return", behind=0.005, side="front", delay=0.5e-3),
    ]
    return Valve({"return": -2.04e3 / 5.05, "power": 9.18e3 / 5.05}, ports)


@dataclass
class Told:
    """A record, and what it was made of."""

    time: np.ndarray
    force: np.ndarray
    behind: np.ndarray
    blows: np.ndarray
    speeds: np.ndarray


def recorded_machine(
    valves: list[Valve] | Valve,
    contacts: list[Contact] | Contact,
    *,
    drag: float = 0.5,
    cycles: int = 20,
    rate: float = 20e3,
    noise: float = 0.0,
    rise: float = 0.0,
    ringing: float = 0.0,
    seed: int = 1,
) -> Told:
    """Cycles from the settled motion on, under one valve and contact or another one in each cycle.

    `noise` is the standard deviation over the greatest difference of the states, `rise` the time constant of the force
    after a switch, `ringing` the size of what rings then, over the jump.
    """
    valves = valves if isinstance(valves, list) else [valves] * cycles
    contacts = contacts if isinstance(contacts, list) else [contacts] * cycles
    machines = [
        Machine(UniformBar(20.0, External(drag)), valve, law) for valve, law in zip(valves, contacts, strict=True)
    ]
    cycle, *_ = settled(machines[0])
    assert cycle is not None
    legs, rebound = [], cycle.rebound
    for machine in machines:
        legs.append(Piston(machine).leg(rebound))
        rebound = legs[-1].rebound
        assert rebound is not None
    blows = np.concatenate([[0.0], np.cumsum([leg.duration for leg in legs])])
    time = np.arange(0.0, blows[-1], 1.0 / rate)
    force, behind = np.zeros(time.size), np.zeros(time.size)
    jumps, before = [], None
    for start, valve, leg in zip(blows, valves, legs, strict=False):
        gas = valve.chamber
        for flight in leg.flights:
            begin = start + flight.time
            on = (time >= begin) & (time <= begin + flight.duration)
            behind[on] = -flight.at(time[on] - begin)[0][0]
            level = valve.force(flight.state)
            force[on] = level + gas.stiffness * behind[on]
            if before is not None and level != before:
                jumps.append((begin, level - before))
            before = level
    span = max(abs(jump) for _, jump in jumps)
    for begin, jump in jumps:
        since = time - begin
        after = since >= 0.0
        if rise:
            force[after] -= jump * np.exp(-since[after] / rise)
        if ringing:
            period = 0.03 * (blows[-1] / len(legs))
            force[after] += ringing * jump * np.exp(-since[after] / period) * np.sin(2 * np.pi * since[after] / period)
    force += noise * span * np.random.default_rng(seed).standard_normal(time.size)
    return Told(time, force, behind, blows, np.array([leg.blow_speed for leg in legs]))
