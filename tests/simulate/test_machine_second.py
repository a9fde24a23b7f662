"""The simulated machine beside a second program, on random machines from random starts."""

from __future__ import annotations

import numpy as np
import pytest

from machine_oracle import Second
from machine_strategies import random_machine, random_start
from percuss.model import Chamber, External, Kept, Machine, Port, UniformBar, Valve
from percuss.simulate import Start, Stop, run, simulate_many
from percuss.simulate.valve import mechanism

CAP = 12.0


def second(machine: Machine, modes: int, start: Start) -> Second:
    """The other program at the same start."""
    u, v, _ = start.state(modes, machine)
    numbers = mechanism(machine, modes)
    return Second(machine, modes, *(numbers.ends(given) / numbers.end for given in (u, v)), start.valve_state)


def agrees(seed: int, most: int, speeds: bool = False) -> None:
    """The first events of a random machine from a random start, those at time 0 besides."""
    rng = np.random.default_rng(seed)
    machine, modes = random_machine(rng, speeds=speeds)
    start = random_start(rng, machine, modes)
    motion = run(machine, start, modes=modes, stop=Stop(time=CAP, impacts=60, periodic=False))
    u, v, _ = start.state(modes, machine)
    mechanism = motion.mechanism
    other = Second(
        machine, modes, mechanism.ends(u) / mechanism.end, mechanism.ends(v) / mechanism.end, start.valve_state
    )
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


def test_first_events_of_random_starts() -> None:
    for seed in range(300):
        agrees(seed, 1)


def test_many_events_of_random_machines() -> None:
    for seed in range(1000, 1200):
        agrees(seed, 14, speeds=seed % 2 == 1)


def stalling(rng: np.random.Generator) -> tuple[Machine, Start]:
    """A machine on its gas that a blow leaves without the way to its port, in most cases."""
    gas = Chamber(float(rng.uniform(-0.1, 0.1)), float(rng.uniform(0.9, 1.6)))
    valve = Valve({"return": -0.3, "power": 0.8}, (Port("power", 1.0, "back"), Port("return", on="impact")), None, gas)
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
        other = second(machine, modes, start)
        other.run(cap, 1000)
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


@pytest.mark.slow
def test_first_events_of_ten_thousand_random_starts() -> None:
    for seed in range(10_000, 20_000):
        agrees(seed, 1)
