"""The simulated machine beside a second program, on random machines from random starts."""

from __future__ import annotations

import numpy as np
import pytest

from machine_oracle import Second
from machine_strategies import random_machine, random_start
from percuss.simulate import Stop, run_machine
from percuss.simulate.machine.machine_start import placed

CAP = 12.0


def agrees(seed: int, most: int) -> None:
    """The first events of a random machine from a random start, those at time 0 besides."""
    rng = np.random.default_rng(seed)
    machine, modes = random_machine(rng)
    start = random_start(rng, machine, modes)
    motion = run_machine(machine, start, modes=modes, stop=Stop(time=CAP, impacts=60, periodic=False))
    u, v, _ = placed(start, machine, modes)
    mechanism = motion.mechanism
    other = Second(machine, modes, mechanism.ends(u) / mechanism.end, mechanism.ends(v) / mechanism.end, start.state)
    other.run(CAP, len(other.events) + most)
    own = [event for event in motion.events if event.kind in ("port", "valve", "impact")]
    assert motion.outcome != "work"
    if not other.ending and not {"rest", "grazing"} & set(motion.events.kind):
        assert len(own) >= len(other.events)
    for event, (time, kind, detail) in zip(own, other.events, strict=False):
        assert event.kind == kind
        assert event.time == pytest.approx(time, abs=1e-9 * (1.0 + time))
        found = {"port": event.port, "valve": event.state, "impact": event.velocity}[kind]
        assert found == (pytest.approx(detail, abs=1e-7) if kind == "impact" else detail)


def test_first_events_of_random_starts() -> None:
    for seed in range(300):
        agrees(seed, 1)


def test_many_events_of_random_machines() -> None:
    for seed in range(1000, 1200):
        agrees(seed, 14)


@pytest.mark.slow
def test_first_events_of_ten_thousand_random_starts() -> None:
    for seed in range(10_000, 20_000):
        agrees(seed, 1)
