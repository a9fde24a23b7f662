"""The simulator and the closed-form steady motions, which share no code, agree: an orbit is kept, and what is near it
departs or returns as its exact multipliers say."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.optimize import linear_sum_assignment

from orbit_cases import both_ways
from percuss import Kept, Load, System, steady_states
from percuss.explore import orbit_seeds
from percuss.explore.parameters import PARAMETERS
from percuss.model import KelvinVoigt, ModalBody, Mounted, Ratio, Reversed, SteppedBar, UniformBar
from percuss.simulate import Start, Starts, Stop, run, simulate_many
from percuss.stability import floquet_multipliers, stability_of
from percuss.steady import PeriodicOrbit, orbits
from percuss.steady.periodic.periodic_orbit import differences, load_turn
from random_hammers import RandomHammer, random_hammer

TURN = 2.0 * np.pi


def away(a, b):
    """Distance of phases."""
    return np.abs((np.asarray(a) - b + np.pi) % TURN - np.pi)


SYSTEMS = {
    "long bar": (System(s=20.0, d=0.0048, restitution=0.6, load=Load.harmonic(0.9, 1.0)), 1),
    "short waves": (System(s=1.7, d=0.02, restitution=0.55, load=Load.harmonic(0.85, 1.0)), 1),
    "damped": (System(s=3.0, d=0.7, restitution=0.6, load=Load.harmonic(0.3, 1.0)), 1),
    "every second": (System(s=5.0, d=0.05, restitution=0.8, load=Load.harmonic(0.5, 1.0)), 2),
    "harmonics": (System(s=7.0, d=0.01, restitution=0.5, load=Load.fourier([0.7, 1.0, 0.3 - 0.2j, 0.1j, -0.05])), 1),
    "cut square": (System(s=4.0, d=0.1, restitution=0.5, load=Load.fourier(Load.square(1.0, 1.2, 12).coefficients)), 1),
}


def orbits_of(name, modes):
    system, periods = SYSTEMS[name]
    return [orbit for orbit in steady_states(system, periods, modes=modes).orbits if orbit.admissible]


def state_of(orbit, modes):
    """u_n, u_n' just after the impact, in the form that `Start.orbit` makes."""
    u, v, _ = Start.orbit(orbit).state(modes)
    return u, v


CASES = [(name, modes) for name in SYSTEMS for modes in (0, 1, 8)]


@pytest.mark.parametrize(("name", "modes"), CASES)
def test_an_orbit_is_kept(name, modes):
    orbits = orbits_of(name, modes)
    assert orbits
    for orbit in orbits:
        largest = floquet_multipliers(orbit, modes).largest
        impacts = 50 if largest < 1.0 + 1e-9 else min(50, int(np.log(1e4) / np.log(largest)))
        bound = 1e-9 if largest < 1.0 + 1e-9 else 1e-14 * largest**impacts * 1e3
        motion = run(orbit.system, Start.orbit(orbit), modes=modes, stop=Stop(impacts=impacts, periodic=False))
        assert motion.impacts == impacts
        assert away(motion.events.phase, orbit.phase).max() < bound
        expected = orbit.impact_history(impacts + 1)[1:]
        assert np.abs(motion.events.time - expected[:, 0]).max() < bound * impacts + 1e-12 * expected[-1, 0]
        assert np.abs(motion.events.impact_velocity / orbit.impact_velocity - 1.0).max() < 10.0 * bound
        assert np.abs(motion.events.rebound_velocity / orbit.rebound_velocity - 1.0).max() < 10.0 * bound
        assert motion.events.kinetic_energy == pytest.approx(orbit.blow_energy, rel=10.0 * bound)


def test_a_stable_orbit_is_found_and_named():
    for name, modes in CASES:
        for orbit in orbits_of(name, modes):
            if floquet_multipliers(orbit, modes).largest > 0.95:
                continue
            motion = run(orbit.system, Start.orbit(orbit, velocity=[-1e-4]), modes=modes)
            assert (motion.label, motion.outcome) == (f"z=1/{orbit.periods}", "periodic")
            assert away(motion.events.phase[-1], orbit.phase) < 1e-7


# -- the map from impact to impact, by differences -------------------------------------------------------------------


def start_of(x, modes):
    """A start on the wall from phase, u_1 … u_N, u_0' … u_N'."""
    sign = np.where(np.arange(1, modes + 1) % 2, -2.0, 2.0)
    u = np.concatenate([[-sign @ x[1 : modes + 1]], x[1 : modes + 1]])
    return Start.modal(u, x[modes + 1 :], x[0])


def mapped(system, x, modes, impacts=1):
    """The state after the next impacts, in the same form."""
    motion = run(system, start_of(x, modes), modes=modes, stop=Stop(impacts=impacts, periodic=False))
    assert motion.impacts == impacts == len(motion.events)
    return np.concatenate([[motion.events.phase[-1]], motion.displacement[-1, 1:], motion.velocity[-1]])


def derivative(system, x, modes, step=2e-6, impacts=1):
    """Of the map at x, by central differences of the fourth order."""
    columns = []
    for i in range(x.size):
        e = np.zeros(x.size)
        e[i] = step
        moved = [mapped(system, x + h * e, modes, impacts) for h in (1.0, -1.0, 2.0, -2.0)]
        first, second = moved[0] - moved[1], moved[2] - moved[3]
        for part in (first, second):
            part[0] = (part[0] + np.pi) % TURN - np.pi
        columns.append((8.0 * first - second) / (12.0 * step))
    return np.array(columns).T


def vector(orbit, modes):
    u, v = state_of(orbit, modes)
    return np.concatenate([[orbit.phase], u[1:], v])


@pytest.mark.parametrize(("name", "modes"), [case for case in CASES if case[1] != 1])
def test_multipliers(name, modes):
    for orbit in orbits_of(name, modes):
        found = np.linalg.eigvals(derivative(orbit.system, vector(orbit, modes), modes))
        exact = stability_of(orbit, modes=modes).multipliers.values
        distance = np.abs(found[:, None] - exact[None, :])
        rows, columns = linear_sum_assignment(distance)
        assert distance[rows, columns].max() < 1e-5 * max(1.0, np.abs(exact[0]))


def test_elastic_instability_beyond_b77():
    # theory §5: B77's criterion calls it stable
    system = System(s=5.0, d=0.0, restitution=0.8, load=Load.harmonic(0.9, 1.0))
    moduli = []
    for orbit in steady_states(system, 2, modes=8).orbits:
        values = np.linalg.eigvals(derivative(system, vector(orbit, 8), 8, step=1e-5))
        moduli.append(np.abs(values).max())
    assert min(abs(modulus - 1.000147) for modulus in moduli) < 2e-6


# -- orbits with several impacts ---------------------------------------------------------------------------------------


TWO = ModalBody((0.6, 2.3), (0.05, 0.1), (1.0, 0.8), (1.0, -0.5), 0.3)


def stopped(gap: float) -> System:
    body = ModalBody((1 / 2.8,), (0.0,), (1.0,), (1 / 2.8**2,), gap)
    return System(body, Load.harmonic(0.0, 1.0), Kept(0.8))


COSINE, THREE = Load.harmonic(0.62, 1.0), Load.fourier([0.5, 1.0, 0.4j, -0.2])
SEVERAL = {
    "rigid": (System(s=5.0, d=0.0, restitution=0.5, load=COSINE), 0, [(2, 1), (3, 1), (2, 2), (5, 1)]),
    "eight modes": (System(s=5.0, d=0.0048, restitution=0.5, load=COSINE), 8, [(2, 1), (2, 2)]),
    "thirty-two modes": (System(s=20.0, d=0.02, restitution=0.5, load=COSINE), 32, [(2, 1)]),
    "dragged": (System(s=3.0, d=0.4, restitution=0.6, load=Load.harmonic(0.4, 1.0)), 4, [(2, 1), (2, 2)]),
    "harmonics": (System(s=2.0, d=0.01, restitution=0.6, load=THREE), 6, [(2, 1), (3, 2)]),
    "waves turned over": (System(UniformBar(5.0, Ratio(1e-3)), COSINE, Reversed(0.5)), 8, [(2, 1), (2, 2)]),
    "overdamped": (System(UniformBar(1.0, KelvinVoigt(0.2)), THREE, Kept(0.5)), 5, [(2, 1), (2, 2)]),
    "square": (System(s=5.0, d=0.01, restitution=0.5, load=Load.square(1.0, 1.2)), 8, [(2, 2)]),
    "steps": (System(s=5.0, d=0.05, restitution=0.4, load=Load.steps([0.0, 1.5, 3.5], [1.4, 0.5, -0.9])), 0, [(2, 3)]),
    "full rebound": (System(s=5.0, d=0.0, restitution=1.0, load=Load.fourier([0.2, 1.0, 0.4j, 0.3])), 0, [(2, 2)]),
    "structure": (System(TWO, Load.harmonic(0.2, 1.0), Kept(0.7)), 2, [(1, 1)]),
    "structure under steps": (System(TWO, Load.square(1.0, 0.8), Kept(0.6)), 2, [(1, 1)]),
    "oscillator": (stopped(-0.1), 1, [(1, 1)]),
    "oscillator behind its flip": (stopped(-0.06), 1, [(1, 1), (2, 2)]),
    "bar on a spring": (System(Mounted(0.8, 0.05, s=4.0, gap=0.2), Load.harmonic(0.1, 1.0), Kept(0.5)), 6, [(1, 1)]),
    "stepped": (System(SteppedBar(6.0, (1.0, 2.0), (1.0, 1.0)), COSINE, Kept(0.5)), 5, [(2, 1)]),
}
FOUND: dict[str, list[PeriodicOrbit]] = {}


def found(name: str) -> list[PeriodicOrbit]:
    """The orbits of a system, searched for once."""
    if name not in FOUND:
        system, modes, labels = SEVERAL[name]
        FOUND[name] = [orbit for p, n in labels for orbit in orbits(system, p, n, modes=modes, tries=128).orbits]
    return FOUND[name]


def check_orbit(orbit: PeriodicOrbit, room: float = 1e-11) -> None:
    """The simulator goes round the orbit once, from just after its first impact."""
    motion = run(orbit.system, Start.orbit(orbit), modes=orbit.modes, stop=Stop(orbit.impacts, periodic=False))
    struck = motion.events.of("impact")
    assert len(struck) == motion.impacts == orbit.impacts
    assert {event.kind for event in motion.events} <= {"impact", "release"}  # a release: R = 0, pulled at once
    room *= max(1.0, orbit.multipliers().largest / 10.0)
    assert struck.time == pytest.approx(np.append(orbit.times[1:], orbit.times[0] + orbit.period), rel=0, abs=room)
    scale = 10.0 * max(1.0, float(orbit.speeds.max()))
    assert struck.impact_velocity == pytest.approx(np.roll(orbit.speeds, -1), rel=0, abs=scale * room)
    assert struck.kinetic_energy == pytest.approx(np.roll(orbit.blow_energies, -1), rel=0, abs=scale**2 * room)


@pytest.mark.parametrize("name", SEVERAL)
def test_a_motion_started_on_an_orbit_stays_on_it(name: str) -> None:
    assert found(name)
    for orbit in found(name):
        check_orbit(orbit)


def test_a_stable_orbit_is_found_by_the_simulation_and_has_its_label() -> None:
    system = System(s=5.0, d=0.0, restitution=0.5, load=Load.harmonic(0.665, 1.0))
    stable = [orbit for orbit in orbits(system, 2, modes=0, tries=60).orbits if orbit.multipliers().stable]
    assert len(stable) == 1
    motion = run(system, Start.orbit(stable[0], velocity=[-1e-4]), modes=0)
    assert (motion.label, motion.outcome) == (stable[0].label, "periodic")
    last = np.sort(np.mod(motion.events.time[-2:], 2.0 * math.pi))
    assert last == pytest.approx(np.sort(stable[0].phases), abs=1e-7)


@pytest.mark.parametrize("name", ["rigid", "harmonics", "waves turned over", "square", "dragged"])
def test_multipliers_by_differences_of_the_simulated_cycle(name: str) -> None:
    """A disturbance of the state after the first impact, carried through the cycle, moves as W says.

    The start stands at the wall, so that only disturbances which leave the striking end there are made; the later time
    of the last impact is taken back to a fixed one by the motion after it.
    """
    orbit = min(found(name), key=lambda one: one.multipliers().largest)
    modes, p = orbit.modes, orbit.impacts
    gamma = np.append(1.0, orbit.system.body.modes(modes, orbit.system.load.at).gamma)
    whole, step = orbit.map().dense(), 1e-6
    for direction in (np.eye(modes + 1)[0], np.eye(modes + 1)[-1]):  # of the velocities
        ends = []
        for sign in (1.0, -1.0):
            start = Start.orbit(orbit, velocity=tuple(sign * step * direction))
            motion = run(orbit.system, start, modes=modes, stop=Stop(p, periodic=False))
            assert motion.impacts == p
            u, v, when = motion.displacement[-1], motion.velocity[-1], motion.events.time[-1]
            known = orbit.system.body.modes(modes, orbit.system.load.at)
            omega, damping = np.append(0.0, known.omega), np.append(orbit.system.d, known.damping)
            force = float(orbit.system.load.value(when))
            back = orbit.times[0] + orbit.period - when
            rate = force - damping * v - omega**2 * u
            ends.append((u + v * back, v + rate * back))
        moved = [(one - other) / (2.0 * step) for one, other in zip(*ends, strict=True)]
        u, v = np.zeros_like(direction), direction
        wanted = whole @ np.stack([u, v], axis=1).reshape(-1)
        scale = np.abs(wanted).max()
        assert moved[0] == pytest.approx(wanted[0::2], abs=1e-4 * scale)
        assert moved[1] == pytest.approx(wanted[1::2], abs=1e-4 * scale)
        assert gamma.size == direction.size


# -- hammers drawn at random -------------------------------------------------------------------------------------------


LABELS = [(1, 1), (2, 1), (2, 2), (3, 2)]
LONGEST = 6


def found_orbits(hammer: RandomHammer, seed: int, tries: int) -> list[PeriodicOrbit]:
    """Orbits of one of the labels; none where the load is refused."""
    p, n = LABELS[seed // 3 % len(LABELS)]
    return list(orbits(hammer.system, p, n, modes=hammer.modes, tries=tries).orbits)


def attractors(hammer: RandomHammer, seed: int) -> dict[tuple[int, int], list[np.ndarray]]:
    """Impact times of one cycle of each periodic motion without rest that simulations settle on, by label."""
    starts = Starts.random(hammer.system, 16, seed=seed)
    many = simulate_many(hammer.system, starts, modes=hammer.modes, stop=Stop(600), keep=LONGEST, threads=1)
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
    return both_ways(found[0], name, between, 1e-8)


@pytest.mark.parametrize("seed", range(12))
def test_orbits_are_motions_of_the_simulator(seed: int) -> None:
    hammer = random_hammer(seed)
    for orbit in found_orbits(hammer, seed, 16):
        if orbit.multipliers().largest < 10.0:
            check_orbit(orbit, 1e-10)


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
                check_orbit(orbit, 1e-10)
                checked += 1
        motions += check_attractors(hammer, seed, 16)
        branches += check_branch(hammer, seed, 8) if seed % 20 == first // 100 else 0
    assert checked > 20
    assert motions > 20
    assert branches > 0
