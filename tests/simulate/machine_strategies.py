"""Random machines and starts, over all that a machine may be."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from percuss.model import Chamber, Kept, Machine, Port, Reversed, Supply, UniformBar, Valve
from percuss.model.body import External, KelvinVoigt, Ratio, Table
from percuss.simulate import Start


def random_machine(rng: np.random.Generator, most_modes: int = 6, speeds: bool = False) -> tuple[Machine, int]:
    """A machine and its modes; with `speeds` half of its ports read a speed."""
    modes = int(rng.choice([0, 0, 1, 2, most_modes]))
    s = float(rng.uniform(2.0, 12.0))
    damping = [
        External(0.0), External(float(rng.uniform(0.0, 0.2))), External(float(10.0 ** rng.uniform(-1, 2))),
        Ratio(float(rng.uniform(0.0, 1.0))), KelvinVoigt(float(10.0 ** rng.uniform(-4, -0.5))),
        Table(tuple(rng.uniform(0.0, 30.0, 3))),
    ][int(rng.integers(6))]  # fmt: skip
    restitution = float(rng.choice([0.0, 0.2, 0.5, 0.8, 1.0, rng.uniform()]))
    contact = (Kept if rng.uniform() < 0.8 else Reversed)(restitution)
    forces = {"return": -float(rng.uniform(0.05, 3.0)), "power": float(rng.uniform(0.05, 3.0))}
    if rng.uniform() < 0.3:
        forces["third"] = float(rng.uniform(-1.5, 1.5))
    names = list(forces)

    def delay() -> float:
        return float(rng.choice([0.0, rng.uniform(0.0, 0.3), rng.uniform(0.0, 2.0)]))

    def reads() -> object:
        return "centre" if rng.uniform() < 0.6 else float(rng.choice([0.0, 1.0, rng.uniform()]))

    ports = [Port("power", behind=float(rng.uniform(0.3, 1.5)), side="back", delay=delay(), reads=reads())]
    if rng.uniform() < 0.5:
        ports.append(Port("return", on="impact", delay=delay()))
    else:
        ports.append(Port("return", behind=float(rng.uniform(0.02, 0.4)), side="front", delay=delay(), reads=reads()))
    for _ in range(int(rng.integers(0, 3))):
        to, side = str(rng.choice(names)), str(rng.choice(["back", "front"]))
        ports.append(Port(to, behind=float(rng.uniform(0.02, 1.5)), side=side, delay=delay(), reads=reads()))
    if speeds:
        ports = [
            port if port.on == "impact" or rng.uniform() < 0.5
            else replace(port, behind=None, speed=float(rng.uniform(0.05, 1.5)))
            for port in ports
        ]  # fmt: skip
    stiffness = 0.0 if rng.uniform() < 0.5 else float(10.0 ** rng.uniform(-2, 1))
    valve = Valve(forces, ports, chamber=Chamber(float(rng.uniform(-0.2, 0.4)), stiffness))
    return Machine(UniformBar(s, damping), valve, contact), modes


def random_start(rng: np.random.Generator, machine: Machine, modes: int) -> Start:
    """A start off the wall, or on it and leaving; ringing in most cases."""
    u, v = np.zeros(modes + 1), np.zeros(modes + 1)
    v[0] = rng.uniform(-1.5, 1.5)
    if modes:
        n = np.arange(1, modes + 1)
        ring = rng.choice([0.0, 0.02, 0.3])
        u[1:], v[1:] = ring * rng.normal(size=modes) / n**2 / machine.body.s, ring * rng.normal(size=modes) / n
    gap = float(rng.choice([0.0, -rng.uniform(0.0, 1.5), -(10.0 ** rng.uniform(-6, 0))]))
    at_end = 2.0 * np.where(np.arange(1, modes + 1) % 2, -1.0, 1.0)
    u[0] = gap - at_end @ u[1:]
    if gap == 0.0 and v[0] + at_end @ v[1:] > 0.0:
        v = -v
    states = [name for name, _ in machine.valve.pairs]
    return Start(tuple(u.tolist()), tuple(v.tolist()), gap=gap).with_valve(str(rng.choice(states)))


def random_supplied(rng: np.random.Generator) -> tuple[Machine, Start]:
    """Over all that a machine with a supply may be, from stiff accumulators to very great ones."""

    def delay() -> float:
        return float(rng.choice([0.0, rng.uniform(0.0, 0.5)]))

    forces = {"return": -float(rng.uniform(0.05, 2.0)), "power": float(rng.uniform(0.1, 3.0))}
    if rng.uniform() < 0.3:
        forces["third"] = float(rng.choice([0.0, rng.uniform(-1.0, 1.0)]))
    ports = [Port("power", float(rng.uniform(0.3, 1.5)), "back", delay())]
    if rng.uniform() < 0.5:
        ports.append(Port("return", on="impact", delay=delay()))
    else:
        ports.append(Port("return", float(rng.uniform(0.02, 0.2)), "front", delay()))
    if "third" in forces:
        ports.append(Port("third", float(rng.uniform(0.3, 1.5)), str(rng.choice(["back", "front"])), delay()))
    stiffness = float(rng.choice([0.0, 10.0 ** rng.uniform(-2, 0.5)]))
    start = float(rng.uniform(0.2, 1.5))
    supply = Supply(float(10.0 ** rng.uniform(-1, 0.5)), float(10.0 ** rng.uniform(-0.5, 3)), start)
    valve = Valve(forces, ports, None, Chamber(float(rng.uniform(0.0, 0.2)), stiffness), supply=supply)
    drag = float(rng.choice([0.0, rng.uniform(0.0, 0.3), rng.uniform(0.0, 5.0)]))
    contact = Kept(float(rng.choice([0.2, 0.5, rng.uniform(0.05, 0.8)])))
    made = Machine(UniformBar(20.0, External(drag)), valve, contact)
    start = Start.rigid(-float(rng.uniform(0.05, 1.2)), float(rng.uniform(-1.0, 1.0)))
    supply = replace(supply, quickening=float(rng.choice([0.0, rng.uniform(0.0, 0.9)])))
    return made.with_valve(replace(valve, supply=supply)), start
