"""Hammers drawn at random: orbits and simulator, which share no code, agree; branches are the same both ways."""

from __future__ import annotations

import math

import numpy as np
import pytest

from percuss.explore import BranchEvent, SystemFamily, follow, orbit_seeds
from percuss.explore.parameters import PARAMETERS
from percuss.simulate import Start, Starts, Stop, run, simulate_many
from percuss.steady import PeriodicOrbit, orbits
from percuss.steady.periodic.periodic_orbit import differences, load_turn
from random_hammers import RandomHammer, random_hammer

TURN = 2.0 * math.pi
LABELS = [(1, 1), (2, 1), (2, 2), (3, 2)]
LONGEST = 6


def found_orbits(hammer: RandomHammer, seed: int, tries: int) -> list[PeriodicOrbit]:
    """Orbits of one of the labels; none where the load is refused."""
    p, n = LABELS[seed // 3 % len(LABELS)]
    return list(orbits(hammer.system, p, n, modes=hammer.modes, tries=tries).orbits)


def check_orbit(orbit: PeriodicOrbit) -> None:
    """The simulator goes round the orbit once, from just after its first impact, to 1e-10."""
    motion = run(orbit.system, Start.orbit(orbit), modes=orbit.modes, stop=Stop(orbit.impacts, periodic=False))
    struck = motion.events.of("impact")
    assert len(struck) == orbit.impacts
    assert {event.kind for event in motion.events} <= {"impact", "release"}  # a release: R = 0, pulled at once
    assert struck.time == pytest.approx(np.append(orbit.times[1:], orbit.times[0] + orbit.period), rel=0, abs=1e-10)
    scale = max(1.0, float(orbit.speeds.max()))
    assert struck.impact_velocity == pytest.approx(np.roll(orbit.speeds, -1), rel=0, abs=1e-10 * scale)


def attractors(hammer: RandomHammer, seed: int) -> dict[tuple[int, int], list[np.ndarray]]:
    """Impact times of one cycle of each periodic motion without rest that simulations settle on, by label."""
    starts = Starts.random(hammer.system, 16, seed=seed)
    many = simulate_many(hammer.system, starts, modes=hammer.modes, stop=Stop(600), keep=LONGEST, workers=1)
    labels, found = many.label.tolist(), {}
    for i, label in enumerate(labels):
        if label.startswith("z="):
            p, n = (int(part) for part in label[2:].split("/"))
            if p <= LONGEST and n <= LONGEST:
                found.setdefault((p, n), []).append(np.asarray(many.last_time)[i][-p:])
    return found


def check_attractors(hammer: RandomHammer, seed: int, tries: int) -> int:
    """The search finds each of them, from other starts where they are no rare ones; how many motions there were."""
    motions = 0
    for (p, n), cycles in attractors(hammer, seed).items():
        if p == 1:
            seeds = None
        elif len(cycles) > 1:
            seeds = orbit_seeds(hammer.system, p, n, modes=hammer.modes, motions=64, seed=seed + 1000)
        else:
            seeds = {"itself": cycles}
        found = orbits(hammer.system, p, n, modes=hammer.modes, tries=tries, near=seeds)
        known = np.array([orbit.times for orbit in found.orbits]).reshape(-1, p)
        turn = load_turn(hammer.system.load)
        for times in cycles:
            off = np.abs(differences(times, known, TURN * n, turn)).max(axis=-1)
            assert off.min(initial=math.inf) < 1e-6, (p, n)
            motions += 1
    return motions


def check_branch(hammer: RandomHammer, seed: int, tries: int) -> bool:
    """The same events are met from two places of a branch; whether there was one."""
    found = found_orbits(hammer, seed, tries)
    random = np.random.default_rng([17, seed])
    name = str(random.choice(["restitution", "load_factor", "mean", "s"]))
    value = PARAMETERS[name].get(hammer.system)
    if not found or not value or (name == "restitution" and value == 1.0):
        return False
    between = 0.98 * value, min(1.02 * value, 1.0 if name == "restitution" else math.inf)
    branch = follow(found[0], name, between)
    assert BranchEvent.LOST not in {point.kind for point in branch.points}
    family = SystemFamily(hammer.system)
    middle = branch.values.size // 3
    there = float(branch.values[middle])
    system = family.system({name: there})
    other = PeriodicOrbit(system, found[0].periods, tuple(branch.times[middle].tolist()), hammer.modes).from_first
    if not other.admissible:  # a place at an end, where it has just ceased to be
        return False
    again = follow(other, name, between, family=family, value=there)
    expected, ours = ([(p.kind, p.value) for p in one.points] for one in (branch, again))
    if [kind for kind, _ in expected] != [kind for kind, _ in ours] or not near(expected, ours):
        ours.reverse()
    assert [kind for kind, _ in ours] == [kind for kind, _ in expected]
    assert near(expected, ours)
    return True


def near(one: list, other: list) -> bool:
    """Whether values of the parameter are the same."""
    return all(abs(a - b) <= 1e-8 * max(1.0, abs(a)) for (_, a), (_, b) in zip(one, other, strict=True))


@pytest.mark.parametrize("seed", range(12))
def test_orbits_are_motions_of_the_simulator(seed: int) -> None:
    hammer = random_hammer(seed)
    for orbit in found_orbits(hammer, seed, 16):
        if orbit.multipliers().largest < 10.0:
            check_orbit(orbit)


@pytest.mark.parametrize("seed", [3, 20, 221])
def test_attractors_are_found(seed: int) -> None:
    assert check_attractors(random_hammer(seed), seed, 16)


@pytest.mark.parametrize(("seed", "tries"), [(12, 16), (40, 16), (125, 8), (289, 8)])
def test_a_branch_is_the_same_from_both_places(seed: int, tries: int) -> None:
    """125 has two sheets of 32 modes, 1e-5 rad apart; 289 flips and ends where undamped modes swing up for a moment."""
    assert check_branch(random_hammer(seed), seed, tries)


@pytest.mark.slow
@pytest.mark.parametrize("first", range(0, 500, 100))
def test_five_hundred_hammers(first: int) -> None:
    checked = motions = branches = 0
    for seed in range(first, first + 100):
        hammer = random_hammer(seed)
        for orbit in found_orbits(hammer, seed, 16):
            if orbit.multipliers().largest < 10.0:
                check_orbit(orbit)
                checked += 1
        motions += check_attractors(hammer, seed, 16)
        branches += check_branch(hammer, seed, 8) if seed % 20 == first // 100 else 0
    assert checked > 20
    assert motions > 20
    assert branches > 0
