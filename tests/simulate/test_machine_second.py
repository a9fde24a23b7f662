"""The simulated machine beside a second program, on random machines from random starts, fed by a pump and not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from machine_oracle import second
from machine_strategies import random_machine, random_start, random_supplied
from percuss.model import (
    Chamber,
    External,
    KelvinVoigt,
    Kept,
    Machine,
    Port,
    Ratio,
    Reversed,
    Supply,
    UniformBar,
    Valve,
)
from percuss.simulate import Start, Stop, run, simulate_many

CAP = 12.0
PORTS = (Port("power", 1.0, "back"), Port("return", on="impact"))


def agrees(machine: Machine, modes: int, start: Start, most: int) -> None:
    """The first events, those at time 0 besides."""
    motion = run(machine, start, modes=modes, stop=Stop(time=CAP, impacts=60, periodic=False))
    other = second(machine, modes, start)
    other.run(CAP, len(other.events) + most)
    own = [event for event in motion.events if event.kind in ("port", "valve", "impact")]
    assert motion.outcome != "work"
    if not other.ending and not {"rest", "grazing"} & set(motion.events.kind):
        assert len(own) >= len(other.events)
    for event, (time, kind, detail) in zip(own, other.events, strict=False):
        assert event.kind == kind
        assert event.time == pytest.approx(time, abs=1e-9 * (1.0 + time))
        found = {"port": event.port, "valve": event.state, "impact": event.impact_velocity}[kind]
        assert found == (pytest.approx(detail, abs=1e-7) if kind == "impact" else detail)
    if machine.valve.supply is not None and len(own) > len(other.events) and not other.ending:
        assert motion.pressure([other.time])[0] == pytest.approx(other.pressure, rel=1e-7)


def agrees_on(seed: int, most: int, speeds: bool = False) -> None:
    rng = np.random.default_rng(seed)
    machine, modes = random_machine(rng, speeds=speeds)
    agrees(machine, modes, random_start(rng, machine, modes), most)


def test_first_events_of_random_starts() -> None:
    for seed in range(300):
        agrees_on(seed, 1)


def test_many_events_of_random_machines() -> None:
    for seed in range(1000, 1200):
        agrees_on(seed, 14, speeds=seed % 2 == 1)


@pytest.mark.slow
def test_first_events_of_ten_thousand_random_starts() -> None:
    for seed in range(10_000, 20_000):
        agrees_on(seed, 1)


def supplied(seed: int) -> tuple[Machine, int, Start]:
    """A machine on a pump, rigid or elastic, of any damping and either law, and a start."""
    rng = np.random.default_rng(seed)
    (machine, start), modes = random_supplied(rng), int(rng.choice([0, 0, 2, 4]))
    if modes:
        damping = [External(0.0), Ratio(0.3), KelvinVoigt(0.01), External(3.0)][int(rng.integers(4))]
        law = (Kept, Reversed)[int(rng.integers(2))](machine.contact.restitution)
        machine = replace(machine, body=UniformBar(float(rng.uniform(3.0, 12.0)), damping), contact=law)
    return machine, modes, start


def test_events_of_random_machines_on_a_pump() -> None:
    for seed in range(60):
        machine, modes, start = supplied(seed)
        agrees(machine, modes, start, 14)


@pytest.mark.parametrize("seed", range(16))
def test_energy_closes_with_a_pump(seed: int) -> None:
    machine, modes, start = supplied(1000 + seed)
    motion = run(machine, start, modes=modes, stop=Stop(impacts=8, time=40.0))
    balance = motion.energy_balance()
    size = max(abs(balance.input), abs(balance.impacts), abs(balance.stored), float(motion.energy(0.0)[0]))
    assert abs(balance.imbalance) <= 1e-10 * size


# -- after a stall is proved ------------------------------------------------------------------------------------------


def stalling(rng: np.random.Generator) -> tuple[Machine, Start]:
    """A machine on its gas that a blow leaves without the way to its port, in most cases."""
    gas = Chamber(float(rng.uniform(-0.1, 0.1)), float(rng.uniform(0.9, 1.6)))
    valve = Valve({"return": -0.3, "power": 0.8}, PORTS, None, gas)
    damping = External(float(rng.choice([0.0, rng.uniform(0.0, 0.2)])))
    machine = Machine(UniformBar(5.0, damping), valve, Kept(float(rng.uniform(0.3, 0.7))))
    return machine, Start.rigid(-float(rng.uniform(0.3, 1.2)), float(rng.uniform(-0.3, 0.5))).with_valve("power")


@pytest.mark.parametrize("modes", [0, 3])
def test_the_blows_after_a_stall_is_proved(modes: int) -> None:
    """They are followed to the time asked for, and without one till none comes; ensembles count them as well."""
    rng, stalled, later, cap = np.random.default_rng(5), 0, 0, 40.0
    while stalled < 10:
        machine, start = stalling(rng)
        motion = run(machine, start, modes=modes, stop=Stop(time=cap))
        if motion.label != "stalls (in the chamber)":
            continue
        stalled += 1
        assert (motion.outcome, motion.end_time) == ("stalls", cap)
        other = second(machine, modes, start).run(cap, 1000)
        theirs = [time for time, kind, _ in other.events if kind == "impact"]
        ours = motion.blow_times[: len(theirs)] if other.ending else motion.blow_times
        assert ours == pytest.approx(theirs, abs=1e-8)
        later += int(np.count_nonzero(ours > motion.events.of("valve").time[-1]))
        times = np.linspace(0.0, cap, 4000)
        since = times[:, None] - motion.events.of("release").time  # when the ripple of few modes may lap over the wall
        assert motion.gap(times[~((since > 0.0) & (since < 0.35)).any(axis=1)]).max() < 1e-9
        many = simulate_many(machine, start, modes=modes, stop=Stop(time=cap))
        assert (many.impacts[0], many.outcome[0], many.label[0]) == (motion.impacts, "stalls", motion.label)
        free = run(machine, start, modes=modes)
        assert (free.label, free.outcome) == (motion.label, "stalls")
        assert free.blow_times[: len(ours)].tolist() == ours.tolist()
    assert later > 10


LASTING = {
    "stalls (on the tool)": (Valve({"power": 1.0}, (Port("power", on="impact"),), supply=Supply(1.0, 2.0)), 0.0),
    "stalls (leaves)": (Valve({"power": -1.0}, (Port("power", 0.5, "back"),), supply=Supply(1.0, 2.0)), 2.0),
    "stalls (in the chamber)": (
        Valve({"return": 0.0, "power": 0.8}, PORTS, None, Chamber(-0.2, 1.15), supply=Supply(0.5, 5.0)), 0.12,
    ),
}  # fmt: skip


@pytest.mark.parametrize("label", LASTING)
def test_a_stall_on_a_pump_is_told_and_followed_to_the_time_asked_for(label: str) -> None:
    valve, drag = LASTING[label]
    machine = Machine(UniformBar(20.0, External(drag)), valve, Kept(0.45))
    start = Start.rigid(-0.8, 0.3).with_valve("power")
    motion = run(machine, start, modes=0, stop=Stop(time=30.0))
    assert (motion.label, motion.outcome, motion.end_time) == (label, "stalls", 30.0)
    assert motion.position(1.0, np.linspace(0.0, 30.0, 3000)).max() < 1e-12
    other = second(machine, 0, start).run(30.0)
    theirs = [time for time, kind, _ in other.events if kind == "impact"]
    assert motion.blow_times[: len(theirs)] == pytest.approx(theirs, abs=1e-9)
    assert other.ending or len(theirs) == motion.impacts
    assert run(machine, start, modes=0).impacts == motion.impacts
