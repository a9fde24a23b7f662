"""Structures that are held, simulated: their orbits come back, the energy closes, starts are what they say."""

import math
from functools import cache

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from percuss import Start, Stop, run
from percuss.errors import ParameterError
from percuss.explore import BranchEvent, SystemFamily, follow_point
from percuss.mechanics.flow import propagator
from percuss.model import Kept, Load, ModalBody, Mounted, System
from percuss.simulate.events import KINDS
from percuss.steady import orbits, rest_cycles
from random_hammers import random_structure

TURN = 2.0 * math.pi
BODY = ModalBody((0.6, 2.3), (0.05, 0.1), (1.0, 0.8), (1.0, -0.5), 0.3)
TWO = System(BODY, Load.harmonic(0.2, 1.0), Kept(0.7))
STEPS = System(BODY, Load.square(1.0, 0.8), Kept(0.6))
OSCILLATOR = System(ModalBody((1 / 2.8,), (0.0,), (1.0,), (1 / 2.8**2,), -0.1), Load.harmonic(0.0, 1.0), Kept(0.8))
BAR = System(Mounted(0.8, 0.05, s=4.0, gap=0.2), Load.harmonic(0.1, 1.0), Kept(0.5))


@pytest.mark.parametrize(("system", "modes"), [(TWO, 2), (OSCILLATOR, 1), (BAR, 6)])
@pytest.mark.parametrize("nearer", [-0.004, 0.004])
def test_the_orbit_of_another_gap_starts_on_the_wall_of_this_one(system, modes, nearer):
    moved = SystemFamily(system).system({"gap": system.body.gap + nearer})
    orbit = min(orbits(system, 1, 1, modes=modes).orbits, key=lambda one: one.multipliers().largest)
    start = Start.orbit(orbit)
    u, _, gap = start.state(modes, moved)
    assert gap == 0.0 and u[0] == pytest.approx(-moved.body.gap, abs=1e-13)
    motion = run(moved, start, modes=modes, stop=Stop(impacts=2000))
    here = min(orbits(moved, 1, 1, modes=modes).orbits, key=lambda one: one.multipliers().largest)
    assert motion.label == "z=1/1" and motion.events.phase[-1] == pytest.approx(here.phase, abs=1e-7)
    assert abs(here.phase - orbit.phase) > 1e-4


@pytest.mark.parametrize("system", [TWO, STEPS])
def test_a_motion_settles_on_the_stable_orbit_and_its_energy_closes(system):
    (orbit,) = orbits(system, 1, 1).orbits
    motion = run(system, Start.rigid(-0.5, 0.2, 1.0), stop=Stop(impacts=3000))
    assert motion.label == "z=1/1" and motion.events.phase[-1] == pytest.approx(orbit.phase, abs=1e-8)
    assert abs(motion.energy_balance().imbalance) < 1e-9
    assert motion.displacement[:, 0] == pytest.approx(-0.3, abs=1e-12)  # u_0 stands still
    assert motion.velocity[:, 0] == pytest.approx(0.0, abs=1e-12)
    again = run(system, Start.rigid(-0.5, 0.2, 1.0), stop=Stop(impacts=40)).continued(Stop(impacts=3000))
    assert again.events.time.tolist() == motion.events.time.tolist()


bodies = st.integers(1, 3).flatmap(
    lambda n: st.builds(
        ModalBody,
        st.lists(st.floats(0.2, 8.0), min_size=n, max_size=n).map(tuple),
        st.lists(st.floats(0.0, 20.0), min_size=n, max_size=n).map(tuple),
        st.lists(st.floats(0.2, 2.0), min_size=n, max_size=n).map(tuple),
        st.lists(st.floats(0.2, 2.0), min_size=n, max_size=n).map(tuple),
        st.floats(0.0, 1.0),
    )
)


@settings(max_examples=20)
@given(bodies, st.floats(-1.0, 1.0), st.floats(-2.0, -0.1), st.floats(-1.0, 1.0), st.floats(0.0, 6.0))
def test_the_first_impact_is_that_of_an_integrator(body, mean, place, speed, time):
    system = System(body, Load.harmonic(mean, 1.0), Kept(0.5))
    if any(abs(omega - 1.0) < 0.05 and delta < 0.05 for omega, delta in zip(body.omega, body.delta, strict=True)):
        return  # near resonance
    start = Start.rigid(place, speed, time)
    u, v, gap = start.state(body.most_modes, system)
    omega, delta, b, a = (np.array(values) for values in (body.omega, body.delta, body.drive, body.contact))
    assert a @ (b * u[1:]) - body.gap == pytest.approx(place, abs=1e-9) and gap == place
    assert a @ (b * v[1:]) == pytest.approx(speed, abs=1e-9)

    def rates(t, y):
        q, w = np.split(y, 2)
        return np.concatenate([w, b * (mean + math.cos(t)) - delta * w - omega**2 * q])

    motion = run(system, start, stop=Stop(time=20.0, impacts=1))
    struck, end = motion.events.of("impact"), motion.end_time
    given_state, times = np.concatenate([b * u[1:], b * v[1:]]), np.linspace(time, end, 400)
    flown = solve_ivp(rates, (time, end), given_state, method="DOP853", rtol=1e-10, atol=1e-11, t_eval=times)
    places = a @ flown.y[: omega.size] - body.gap
    assert places.max() < 1e-6 * (1.0 + np.abs(places).max())
    if len(struck):
        assert places[-1] == pytest.approx(0.0, abs=1e-6 * (1.0 + np.abs(places).max()))
        fastest = np.abs(flown.y[omega.size :]).max()
        assert struck.impact_velocity[0] == pytest.approx(a @ flown.y[omega.size :, -1], abs=1e-5 * (1.0 + fastest))


# -- at the wall, and what is refused ---------------------------------------------------------------------------------


def test_a_structure_that_the_load_holds_to_the_wall_ends_there():
    motion = run(System(BODY, Load.harmonic(5.0, 1.0), Kept(0.3)), Start.rigid(-0.5))
    assert motion.outcome == "rest" and motion.label == "rest"
    struck = motion.events.of("impact")
    assert struck.impact_velocity[-1] < 1e-4 and abs(motion.energy_balance().imbalance) < 1e-9
    assert motion.displacement[-1] == pytest.approx(motion.displacement[len(struck) - 1], abs=1e-12)
    assert motion.velocity[-1] == pytest.approx(0.0, abs=1e-12)
    assert motion.gap([motion.end_time]) == pytest.approx(0.0, abs=1e-9)


def test_a_wall_out_of_reach_is_never_struck():
    far = System(ModalBody((0.6, 2.3), (0.05, 0.1), (1.0, 0.8), (1.0, -0.5), 50.0), TWO.load, Kept(0.7))
    motion = run(far, Start.rigid(-0.1), stop=Stop(time=500.0))
    assert motion.impacts == 0 and motion.outcome in ("time", "departed")


def test_without_rebound_the_structure_leaves_when_its_own_forces_pull():
    motion = run(System(BODY, TWO.load, Kept(0.0)), Start.rigid(-0.5), stop=Stop(impacts=20))
    assert motion.impacts >= 1


def test_starts_that_a_structure_does_not_have():
    with pytest.raises(ParameterError, match="modes"):
        run(TWO, Start.field(lambda x: -1.0 - 0.0 * x))
    modal = Start.modal([0.0, 0.1, 0.0])
    assert modal.state(2, TWO)[2] == pytest.approx(0.1 - 0.3)
    with pytest.raises(ParameterError, match="wall"):
        Start.modal([0.0, 5.0, 0.0]).state(2, TWO)


# -- chatter, rest and release -----------------------------------------------------------------------------------------


COSINE = Load.harmonic(0.0, 1.0)


def oscillator(omega, damping, spring, restitution, load=COSINE, drive=1.0):
    """One mode that its spring pulls from the wall with a force, or presses on it where that is negative."""
    return System(ModalBody((omega,), (damping,), (1.0,), (drive,), spring / omega**2), load, Kept(restitution))


def integrated(omega, damping, spring, restitution, release):
    """Impacts of y'' + d y' + ω² y = cos t − spring from y = y' = 0 on, until the flights are of 1e-4; their end."""

    def rates(t, y):
        return [y[1], math.cos(t) - spring - omega**2 * y[0] - damping * y[1]]

    def touch(t, y):
        return y[0]

    touch.terminal, touch.direction = True, 1.0
    tight = {"rtol": 1e-12, "atol": 1e-15, "method": "DOP853"}
    begun = solve_ivp(rates, (release, release + 1e-2), [0.0, 0.0], **tight)
    time, state, found = release + 1e-2, begun.y[:, -1], []
    while True:
        flight = solve_ivp(rates, (time, time + 20.0), state, events=touch, max_step=0.1, **tight)
        time, rebound = float(flight.t_events[0][0]), restitution * float(flight.y_events[0][0][1])
        found.append((time, rebound / restitution))
        force = math.cos(time) - spring
        left = 2.0 * rebound / ((1.0 - restitution) * force)
        if 0.0 < left < 1e-4:
            rate = -math.sin(time)
            return np.array(found), time + left * (1.0 - damping * left / 6.0 - rate * left / (3.0 * force))
        state = [0.0, -rebound]


@pytest.mark.parametrize("damping", [0.3, 1.41, 1.5, 5.0, 400.0])
def test_the_versine_of_a_mode_that_creeps_keeps_its_digits_however_short_the_time(damping):
    """Beside 60 digits: as a difference of exponentials it took those of the last bounces of a chatter with it."""
    times = np.geomspace(1e-7, 10.0, 30)
    with mpmath.workdps(60):
        half, omega = mpmath.mpf(damping) / 2, mpmath.mpf(0.7)
        rate = mpmath.sqrt(omega**2 - half**2)
        for t, found in zip(times.tolist(), propagator(0.7, damping, times).versine.tolist(), strict=True):
            exact = float((mpmath.exp(-half * t) * (1 - mpmath.cos(rate * t))).real)
            assert found == pytest.approx(exact, rel=1e-12, abs=1e-300)


@pytest.mark.parametrize(
    ("omega", "damping", "spring", "restitution"),
    [(3.3, 0.3, -0.1, 0.4), (2.5, 0.1, 0.05, 0.3), (5.0, 2.0, 0.3, 0.5), (2.8, 0.0, 0.0, 0.1), (0.7, 5.0, -0.5, 0.4)],
)
def test_the_integrated_motion_chatters_as_it_does(omega, damping, spring, restitution):
    system = oscillator(omega, damping, spring, restitution)
    (cycle,) = rest_cycles(system).orbits
    assert cycle.label == "chatter/1"
    assert math.cos(cycle.release_phase) == pytest.approx(spring, abs=1e-13)
    impacts, end = integrated(omega, damping, spring, restitution, cycle.release_phase)
    many = min(len(impacts), cycle.speeds.size)
    assert many >= 4
    assert cycle.times[:many] == pytest.approx(impacts[:many, 0], abs=1e-10)
    assert cycle.speeds[:many] == pytest.approx(impacts[:many, 1], abs=1e-10)
    assert end % TURN == pytest.approx(cycle.rest_phase, abs=1e-10)

    motion = run(system, Start.rigid(-0.5, 0.1, 0.3))
    assert motion.label == "chatter/1"
    release, rest = motion.events.of("release"), motion.events.of("rest")
    assert release.phase[-1] == pytest.approx(cycle.release_phase, abs=1e-13)
    assert rest.phase[-1] == pytest.approx(cycle.rest_phase, abs=1e-11)
    assert abs(motion.energy_balance().imbalance) < 1e-9
    lying = 0.5 * (rest.time[rest.time < release.time[-1]][-1] + release.time[-1])
    assert motion.gap([lying])[0] == pytest.approx(0.0, abs=1e-14)


def test_a_mass_on_a_spring_and_its_mode_rest_alike():
    mode = oscillator(2.5, 0.1, -0.1, 0.5)
    mass = System(Mounted(6.25, 0.1, gap=-0.1 / 6.25), COSINE, Kept(0.5))
    one, other = (rest_cycles(system).orbits[0] for system in (mode, mass))
    assert other.times == pytest.approx(one.times, abs=1e-13) and other.rest_phase == pytest.approx(one.rest_phase)


def test_a_load_that_pushes_the_other_way_is_half_a_period_late():
    one, other = (rest_cycles(oscillator(2.5, 0.1, -0.1, 0.5, drive=sign)).orbits[0] for sign in (1.0, -1.0))
    late = np.mod(other.release_phase - one.release_phase, TURN)
    assert late == pytest.approx(math.pi, abs=1e-12) and other.speeds == pytest.approx(one.speeds, abs=1e-12)
    motion = run(oscillator(2.5, 0.1, -0.1, 0.5, drive=-1.0))
    assert motion.events.of("release").phase[-1] == pytest.approx(other.release_phase, abs=1e-12)


def test_a_hardly_held_mass_chatters_as_a_free_one():
    """The spring fades, and its gap, very far behind, is the mean load."""
    soft = 1e-5
    held = oscillator(soft, 0.0, -0.8, 0.5)
    free = System(5.0, 0.0, 0.5, Load.harmonic(0.8, 1.0))
    one, other = rest_cycles(held).orbits[0], rest_cycles(free, modes=0).orbits[0]
    assert one.release_phase == pytest.approx(other.release_phase, abs=1e-9)
    assert one.rest_phase == pytest.approx(other.rest_phase, abs=1e-8)


def test_modes_far_slower_than_the_load_rest_in_every_period():
    body = ModalBody((1e-3, 9e-4), (0.0, 0.0), (1.0, 1.0), (0.5, 0.5), -8e5)
    motion = run(System(body, COSINE, Kept(0.5)), Start.rigid(-0.3, 0.0, 0.4), stop=Stop(impacts=3000, time=60.0))
    assert np.diff(motion.events.of("release").time[2:]) == pytest.approx(np.full(6, TURN), abs=1e-4)
    assert motion.gap(np.linspace(0.4, motion.end_time, 2000)).max() < 1e-9


@settings(max_examples=15)
@given(
    st.floats(0.3, 8.0), st.floats(0.0, 3.0), st.floats(-0.9, 0.9), st.floats(0.0, 0.7),
    st.sampled_from([COSINE, Load.square(1.0, 1.2), Load.fourier([0.1, 0.6, 0.3j])]),
    st.sampled_from([1.0, -0.5]),
)  # fmt: skip
def test_what_rests_in_simulation_is_a_cycle_that_is_found(omega, damping, spring, restitution, load, drive):
    if abs(omega - round(omega)) < 0.05 and damping < 0.05:
        return  # near resonance
    system = oscillator(omega, damping, spring, restitution, load, drive)
    motion = run(system, Start.rigid(-0.3, 0.0, 0.4), stop=Stop(impacts=300, time=3000.0))
    if motion.cycle is None or motion.cycle.kind == 0 or motion.cycle.periods > 16:
        return
    found = rest_cycles(system, most=16)
    phases = motion.events.of("release").phase
    off = [np.abs(np.exp(1j * phases[-1]) - np.exp(1j * cycle.release_phases)).min() for cycle in found.orbits]
    near = [cycle for cycle, distance in zip(found.orbits, off, strict=True) if distance < 1e-9]
    assert [cycle.label for cycle in near] == [motion.label]
    rests = motion.events.of("rest").phase[-1]
    assert np.abs(np.exp(1j * rests) - np.exp(1j * near[0].rest_phases)).min() < 1e-8


def test_a_mode_that_the_wall_holds_for_good_rests():
    motion = run(oscillator(0.8, 0.1, -1.5, 0.5), Start.rigid(-0.1))
    assert motion.label == "rest" and motion.gap([motion.end_time])[0] == pytest.approx(0.0, abs=1e-14)
    assert rest_cycles(motion.system).orbits == ()


PAIR = ModalBody((3.3, 7.3), (0.3, 0.1), (1.0, 0.8), (1.0, -0.5), -0.01)
THREE = ModalBody((3.3, 7.3, 11.0), (0.3, 0.1, 30.0), (1.0, 0.8, 0.4), (1.0, -0.5, 0.7), -0.02)


@pytest.mark.parametrize(
    ("body", "load", "restitution"),
    [(PAIR, COSINE, 0.4), (THREE, COSINE, 0.3), (PAIR, Load.square(1.0, 1.2), 0.4),
     (PAIR, Load.steps([0.2, 1.0, 3.0], [0.5, -0.4, 1.0]), 0.0)],
)  # fmt: skip
def test_several_modes_move_on_while_the_wall_holds_the_contact(body, load, restitution):
    """The held structure integrated, with the force that keeps its contact still, to where that would pull."""
    start, stop = Start.rigid(-0.3, 0.0, 0.4), Stop(impacts=30, time=40.0, periodic=False)
    motion = run(System(body, load, Kept(restitution)), start, stop=stop)
    assert abs(motion.energy_balance().imbalance) < 1e-12
    rest = int(np.flatnonzero(motion.events.code == KINDS.index("rest"))[0])
    begin, release = motion.events[rest].time, motion.events[rest + 1].time
    assert motion.events[rest + 1].kind == "release"
    omega, delta, contact, drive = map(np.array, (body.omega, body.delta, body.contact, body.drive))

    def force(t, y):
        q, w = np.split(y, 2)
        return float(contact @ (drive * float(load.value(t)) - delta * w - omega**2 * q)) / (contact @ contact)

    def rates(t, y):
        q, w = np.split(y, 2)
        return np.append(w, drive * float(load.value(t)) - delta * w - omega**2 * q - contact * force(t, y))

    lies = np.append(motion.displacement[rest][1:] * drive, np.zeros(omega.size))
    t = np.linspace(begin, release, 40)[1:-1]
    found = solve_ivp(rates, (begin, release), lies, rtol=1e-11, atol=1e-13, max_step=0.02, dense_output=True)
    forces = np.array([force(time, found.sol(time)) for time in t])
    assert forces.min() > 0.0 and force(release, found.y[:, -1]) == pytest.approx(0.0, abs=1e-8)
    assert motion.contact_force(t) == pytest.approx(forces, abs=1e-8)
    assert pytest.approx(found.sol(t)[: omega.size], abs=1e-9) == (motion.modal(t).displacement[1:].T * drive).T
    after = np.append(motion.displacement[rest + 1][1:] * drive, motion.velocity[rest + 1][1:] * drive)
    assert after == pytest.approx(found.y[:, -1], abs=1e-9)
    assert motion.gap(np.linspace(release, motion.events[rest + 2].time, 50)).max() < 1e-14


# -- cycles with rest of several modes: the map from rest to rest --


SEVERAL = [
    System(PAIR, COSINE, Kept(0.4)), System(THREE, COSINE, Kept(0.3)), System(PAIR, Load.square(1.0, 1.2), Kept(0.4)),
    System(PAIR, Load.steps([0.2, 1.0, 3.0], [0.5, -0.4, 1.0]), Kept(0.0)),
    *map(random_structure, (2, 5, 7, 13, 16, 22, 23)),
]  # fmt: skip


@cache
def resting_cycles(number):
    return rest_cycles(SEVERAL[number], most=4)


def simulated_from_rest(system, time, shape, rests, later=0.0):
    """The motion from a rest on, at which the modes move the contact by so much, past so many rests more."""
    gamma = system.body.modes(len(shape), 0).gamma
    start = Start.modal(np.append(0.0, shape / gamma), np.zeros(len(shape) + 1), time)
    motion = run(system, start, stop=Stop(impacts=10**5, time=later + 4.5 * TURN, periodic=False))
    ends = np.flatnonzero(motion.events.code == KINDS.index("rest"))
    return motion, int(ends[ends > 0][rests - 1] if motion.events[0].kind == "rest" else ends[rests - 1])


@pytest.mark.parametrize("number", range(len(SEVERAL)))
def test_a_cycle_with_rest_of_several_modes_is_what_is_simulated_from_it(number):
    """Stable or not: from its rest on for a cycle, with its energy; and what simulations settle on is among them."""
    system, found = SEVERAL[number], resting_cycles(number)
    assert found.orbits and not found.complete
    for cycle in found.orbits:
        lying = cycle.lying[-1]
        motion, last = simulated_from_rest(system, lying.time, lying.shape, len(cycle.chains))
        events, turn = motion.events[: last + 1], cycle.period
        kind, times = events.kind, events.time - turn
        assert times[kind == "release"] == pytest.approx([chain.release for chain in cycle.chains], abs=1e-10)
        assert times[kind == "rest"][-len(cycle.chains) :] == pytest.approx(
            [one.time for one in cycle.lying], abs=1e-10
        )
        struck, speeds = times[kind == "impact"], events.impact_velocity[kind == "impact"]
        assert speeds.max() == pytest.approx(cycle.impact_velocity, abs=1e-10)
        if len(cycle.chains) == 1:
            many = min(struck.size, cycle.speeds.size)
            assert struck[:many] == pytest.approx(np.array(cycle.times[:many]), abs=1e-10)
            assert speeds[:many] == pytest.approx(cycle.speeds[:many], abs=1e-10)
        gamma = system.body.modes(lying.shape.size, 0).gamma
        assert motion.displacement[last][1:] * gamma == pytest.approx(lying.shape, abs=1e-10)
        since = np.linspace(0.01, 0.99, 80) * turn
        first = cycle.chains[0].release + turn
        assert cycle.motion(since) == pytest.approx(motion.gap(first + since), abs=1e-9)
        balance = motion.energy_balance(lying.time, lying.time + turn)
        assert cycle.energy.input == pytest.approx(balance.input, rel=1e-8)
        assert cycle.label.startswith("chatter" if system.restitution else "rest") and cycle.rest_times.min() > 0.0
    settled = run(system, Start.rigid(-0.3, 0.0, 0.4), stop=Stop(impacts=3000, time=3000.0))
    if settled.cycle is not None and settled.cycle.kind and settled.cycle.periods <= 4:
        phases = settled.events.of("release").phase[-1]
        near = [
            one for one in found.orbits if np.abs(np.exp(1j * phases) - np.exp(1j * one.release_phases)).min() < 1e-8
        ]
        assert [one.label for one in near] == [settled.label] and near[0].stable


def has_multipliers_of_the_simulated_map(cycle):
    """From shape and time of a rest to those of the next, by differences."""
    system, aside, lying, rests = cycle.system, 1e-7, cycle.lying[-1], len(cycle.chains)
    known = system.body.modes(lying.shape.size, 0)
    root = np.sqrt(known.inertia)
    across = np.linalg.svd((1.0 / root)[None])[2][1:].T

    def mapped(off):
        shape = lying.shape + across @ off[:-1] / root
        motion, last = simulated_from_rest(system, lying.time + off[-1], shape, rests)
        return np.append(across.T @ (root * known.gamma * motion.displacement[last][1:]), motion.events[last].time)

    columns = [(mapped(aside * one) - mapped(-aside * one)) / (2.0 * aside) for one in np.eye(root.size)]
    seen, told = np.linalg.eigvals(np.array(columns).T), cycle.multipliers().values
    assert told.size == 2 * root.size and (told[root.size :] == 0.0).all()
    scale = max(1.0, cycle.multipliers().largest)
    assert np.poly(seen) == pytest.approx(np.poly(told[: root.size]), abs=1e-6 * scale**2)


@pytest.mark.parametrize("number", range(len(SEVERAL)))
def test_multipliers_of_a_cycle_with_rest_are_those_of_the_simulated_map(number):
    for cycle in resting_cycles(number).orbits:
        has_multipliers_of_the_simulated_map(cycle)


def settled_beside(cycle):
    """What a simulation settles on from beside the last rest of a cycle."""
    lying, zeros = cycle.lying[-1], np.zeros(cycle.modes + 1)
    gamma = cycle.system.body.modes(cycle.modes, 0).gamma
    start = Start.modal(np.append(0.0, lying.shape / gamma), zeros, lying.time + 1e-4)
    return run(cycle.system, start, stop=Stop(impacts=20_000, time=400.0 * TURN))


@pytest.mark.parametrize("number", [1, pytest.param(2, marks=pytest.mark.slow)])
def test_a_branch_of_cycles_with_rest_goes_round_its_folds(number):
    """The cycles that a search finds between the folds are all on it, and that beyond; so it is from either end."""
    found, places = resting_cycles(0).orbits, [-0.0125, -0.0113140723999, -0.010904488965, -0.0063370798975, -0.0055]
    branch = found[number].follow("gap", (-0.0125, -0.0055), points=5)
    beyond = rest_cycles(SystemFamily(SEVERAL[0]).system({"gap": -0.006}), most=1).orbits
    for value, known in ((-0.01, found), (-0.006, beyond)):
        releases = sorted(branch.releases_at(value))
        assert releases == pytest.approx(sorted(one.release_phase for one in known), abs=0.02)
    told = sorted((one.value, one.kind.value) for one in branch.points)
    assert [value for value, _ in told] == pytest.approx(places, abs=1e-12)
    assert [kind for _, kind in told] == ["limit", "fold", "neimark_sacker", "fold", "limit"]
    for fold in branch.at("fold"):
        assert np.abs(fold.multipliers - 1.0).min() < 1e-5


def test_a_pair_of_multipliers_of_several_modes_leaves_the_unit_circle():
    """A simulation comes back to the cycle on one side, and not on the other."""
    cycle = next(one for one in resting_cycles(0).orbits if one.remembered[0].imag)
    branch = cycle.follow("gap", (-0.0112, -0.01), points=5)
    (pair,) = branch.at("neimark_sacker")
    assert np.abs(pair.multipliers[:2]) == pytest.approx(1.0, abs=1e-9) and pair.multipliers[0].imag
    has_multipliers_of_the_simulated_map(pair.cycle)
    for end in (branch.cycles[0], branch.cycles[-1]):
        phase = settled_beside(end).events.of("release").phase[-1]
        assert (abs(np.exp(1j * phase) - np.exp(1j * end.release_phase)) < 1e-6) == end.stable
    assert branch.cycles[0].stable != branch.cycles[-1].stable
    with pytest.raises(ParameterError, match="several modes"):
        follow_point(branch.points[0], ("gap", "restitution"))


@pytest.mark.slow
def test_a_fold_of_several_modes_is_followed_through_two_parameters():
    """From a fold over one parameter to that over the other one."""
    cycle = next(one for one in resting_cycles(0).orbits if one.remembered[0].imag)
    branch = cycle.follow("restitution", (0.4, 0.46), points=5)
    (fold,) = branch.at("fold")
    curve = follow_point(fold, ("restitution=0.4:0.4504", "gap=-0.012:-0.0099"))
    assert (curve.kind, curve.is_orbit.all(), curve.releases.shape[1]) == ("fold", True, 1)
    end = min(curve.ends, key=lambda one: one.values[0])
    assert end.kind is BranchEvent.LIMIT and end.values == pytest.approx((0.4, -0.0113140723999), abs=1e-10)


def test_the_doubled_cycle_of_several_modes_begins_at_a_flip():
    """Simulations settle on the cycle before it, and beyond on that of twice the period, with two rests."""
    branch = resting_cycles(4).orbits[0].follow("mean", (0.0925, 0.1), points=5, switch=1)
    (flip,) = branch.at("flip")
    assert np.abs(flip.multipliers + 1.0).min() < 1e-9 and (flip.side, flip.criticality) == ("smaller", "supercritical")
    has_multipliers_of_the_simulated_map(flip.cycle)
    for end in follow_point(flip, ("mean=0.09:0.097", "restitution=0.19:0.21")).ends:
        assert end.kind is BranchEvent.LIMIT and np.abs(end.cycle.multipliers().values + 1.0).min() < 1e-8
        has_multipliers_of_the_simulated_map(end.cycle)
    (doubled,) = branch.switched
    first, last = doubled.ends
    assert (doubled.label, doubled.releases.shape[1]) == ("chatter/2", 2)
    assert (first.kind, last.kind) == (BranchEvent.HALVING, BranchEvent.LIMIT)
    assert first.value == pytest.approx(flip.value, abs=1e-12)
    for cycle in (branch.cycles[-1], last.cycle):
        motion = settled_beside(cycle)
        assert motion.label == cycle.label
        phases = motion.events.of("release").phase[-len(cycle.chains) :]
        assert sorted(phases) == pytest.approx(sorted(cycle.release_phases), abs=1e-7)


def test_a_second_mode_that_does_not_move_the_contact_changes_nothing():
    one = System(ModalBody((3.3,), (0.3,), (1.0,), (1.0,), -0.01), COSINE, Kept(0.4))
    two = System(ModalBody((3.3, 7.3), (0.3, 0.1), (1.0, 0.0), (1.0, -0.5), -0.01), COSINE, Kept(0.4))
    (alone,), (beside,) = rest_cycles(one).orbits, rest_cycles(two).orbits
    assert beside.label == alone.label and alone.remembered == () and len(beside.remembered) == 2
    assert beside.release_phase == pytest.approx(alone.release_phase, abs=1e-10)
    assert beside.rest_phase == pytest.approx(alone.rest_phase, abs=1e-10)
    many = min(alone.speeds.size, beside.speeds.size)
    assert beside.speeds[:many] == pytest.approx(alone.speeds[:many], abs=1e-10)


def test_without_rebound_several_modes_leave_under_steps_when_they_are_pulled():
    body = ModalBody((0.6, 2.3), (0.05, 0.1), (1.0, 0.8), (1.0, 0.5), 0.0)
    system = System(body, Load.steps([0.0, 3.0], [-0.2, -1.0]), Kept(0.0))
    motion = run(system, Start.rigid(-0.5, 3.0), stop=Stop(time=50.0))
    assert motion.impacts and motion.outcome != "rest"  # never held: the load always pulls
    assert motion.events.rebound_velocity == pytest.approx(0.0, abs=1e-200)
    held = run(System(body, Load.steps([0.0, 3.0], [0.6, 1.0]), Kept(0.0)), Start.rigid(-0.5), stop=Stop(impacts=50))
    assert held.label == "rest" and not len(held.events.of("chatter"))
