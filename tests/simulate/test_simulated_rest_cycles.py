"""Cycles with rest and the simulator, which share no code: chain by chain from the same release."""

from __future__ import annotations

import math

import numpy as np
import pytest

from percuss import Load, System
from percuss.errors import ResonanceError
from percuss.simulate import Start, Stop, Trajectory, run
from percuss.steady import rest_cycles
from percuss.steady.resting.flight_chain import RestPath, RestSearch, Swing, release_phases

TURN = 2.0 * math.pi
LONG = 3  # load periods followed


def drawn(random: np.random.Generator) -> tuple[System, int]:
    """A system whose load pulls for a part of its period, and a number of modes."""
    restitution = 0.0 if random.random() < 0.15 else random.uniform(0.0, 0.9)
    damping = 0.0 if random.random() < 0.3 else 10.0 ** random.uniform(-6.0, 0.5)
    if random.random() < 0.35:
        pull = random.uniform(-1.0, -0.05)
        load = Load.steps(np.sort(random.uniform(0.0, TURN, 3)), random.permutation([pull, 0.7, 1.0]))
    else:
        waves = random.normal(size=3) + 1j * random.normal(size=3)
        alone = Load.fourier([0.0, *waves])
        low = float(alone.value(np.linspace(0.0, TURN, 200)).min())
        load = alone.with_mean(-low * random.uniform(0.3, 0.95))
    modes = int(random.choice([0, 0, 8]))
    return System(10.0 ** random.uniform(-0.3, 1.5), damping, restitution, load), modes


def followed(system: System, modes: int, release: float, impacts: int) -> Trajectory:
    start = Start.rigid(position=0.0, velocity=0.0, time=release - 1e-5)
    return run(system, start, modes=modes, stop=Stop(impacts, periodic=False))


def told(chain: RestPath, other: RestPath) -> np.ndarray:
    """By how much rounding may move the impacts of a chain, from one that is let go 1e-11 later."""
    both = min(len(chain.impacts), len(other.impacts))
    moved = [abs(b.time - a.time) for a, b in zip(chain.impacts[:both], other.impacts[:both], strict=True)]
    return 2e-10 + 10.0 * np.maximum.accumulate(np.array(moved))


@pytest.mark.parametrize("seed", range(40))
def test_from_a_release_to_the_next_rest(seed: int) -> None:
    system, modes = drawn(np.random.default_rng(seed))
    release = float(release_phases(system.load)[0])
    try:
        swing = Swing(system, modes)
        chain = RestSearch(swing, release, release + TURN * LONG).chain()
    except ResonanceError:
        return
    motion = followed(system, modes, release, len(chain.impacts) + 400)
    events = motion.events[int(np.flatnonzero(motion.events.kind == "release")[0]) :]
    assert events.time[0] == pytest.approx(chain.release, rel=0, abs=1e-12)
    room = told(chain, RestSearch(swing, release + 1e-11, release + TURN * LONG).chain())
    sure = room < 1e-9  # what lies beyond differs between any two computations
    times = np.array([impact.time for impact in chain.impacts])[: room.size][sure]
    rests = np.flatnonzero(events.kind == "rest")
    struck = events if not rests.size else events[: int(rests[0])]
    struck = struck[struck.kind == "impact"].time
    many = min(times.size, struck.size)
    assert many >= min(times.size, 3)
    assert np.all(np.abs(struck[:many] - times[:many]) <= room[sure][:many])
    if chain.rest is not None and sure.all():
        assert events.time[rests[0]] == pytest.approx(chain.rest, rel=0, abs=1e-9)


@pytest.mark.parametrize(
    ("mean", "restitution", "modes"),
    [(0.5, 0.2, 0), (0.7, 0.5, 0), (0.7, 0.5, 8), (0.55, 0.2, 8), (0.6, 0.0, 8), (0.7, 0.0, 0), (0.9, 0.8, 0)],
)
def test_attractors_that_rest_are_found(mean: float, restitution: float, modes: int) -> None:
    """From beside the wall: from farther away the last of these systems comes to z=2/2, which is stable, too."""
    system = System(s=5.0, d=0.0048, restitution=restitution, load=Load.harmonic(mean, 1.0))
    motion = run(system, Start.rigid(position=-0.2, time=0.3), modes=modes)
    assert motion.label.startswith(("chatter/", "rest/"))
    (cycle,) = rest_cycles(system, modes=modes).labelled(motion.label)
    events = motion.events
    last = int(np.flatnonzero(events.kind == "rest")[-1])
    assert events.phase[last] == pytest.approx(cycle.rest_phase, rel=0, abs=1e-9)
    releases = events.phase[events.kind == "release"]
    assert releases[-1] == pytest.approx(cycle.release_phase, rel=0, abs=1e-12)
