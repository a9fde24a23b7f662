"""Structures that are held, simulated: their orbits come back, the energy closes, starts are what they say."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from percuss import Start, Starts, Stop, run, simulate_many
from percuss.errors import ParameterError
from percuss.explore import SystemFamily
from percuss.model import Kept, Load, ModalBody, Mounted, System
from percuss.steady import orbits

TURN = 2.0 * math.pi
BODY = ModalBody((0.6, 2.3), (0.05, 0.1), (1.0, 0.8), (1.0, -0.5), 0.3)
TWO = System(BODY, Load.harmonic(0.2, 1.0), Kept(0.7))
STEPS = System(BODY, Load.square(1.0, 0.8), Kept(0.6))
OSCILLATOR = System(ModalBody((1 / 2.8,), (0.0,), (1.0,), (1 / 2.8**2,), -0.1), Load.harmonic(0.0, 1.0), Kept(0.8))
BAR = System(Mounted(0.8, 0.05, s=4.0, gap=0.2), Load.harmonic(0.1, 1.0), Kept(0.5))


@pytest.mark.parametrize(("system", "modes"), [(TWO, 2), (STEPS, 2), (OSCILLATOR, 1), (BAR, 6)])
def test_an_orbit_comes_back(system, modes):
    for orbit in orbits(system, 1, 1, modes=modes).orbits:
        motion = run(system, Start.orbit(orbit), modes=modes, stop=Stop(impacts=1))
        assert motion.events.time[0] == pytest.approx(orbit.phase + TURN, abs=1e-10)
        assert motion.events.impact_velocity[0] == pytest.approx(orbit.speeds[0], abs=1e-10)


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


def test_an_orbit_of_two_impacts_comes_back():
    flipped = System(ModalBody((1 / 2.8,), (0.0,), (1.0,), (1 / 2.8**2,), -0.06), OSCILLATOR.load, Kept(0.8))
    (orbit,) = orbits(flipped, 2, 2, tries=60).orbits
    motion = run(flipped, Start.orbit(orbit), modes=1, stop=Stop(impacts=4))
    assert np.diff(motion.events.time)[[0, 2]] == pytest.approx(orbit.flight_times[[1, 1]], abs=1e-9)
    assert motion.events.impact_velocity == pytest.approx(orbit.speeds[[1, 0, 1, 0]], abs=1e-9)


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


def test_many_motions_are_those_of_single_ones():
    starts = Starts.random(TWO, 8, seed=3, distribution="ringing")
    many = simulate_many(TWO, starts, stop=Stop(impacts=30, periodic=False), keep=30, workers=1)
    for i in range(8):
        motion = run(TWO, starts[i], stop=Stop(impacts=30, periodic=False))
        assert many.last_velocity[i].tolist() == motion.events.of("impact").impact_velocity.tolist()
    rigid = simulate_many(STEPS, Starts.rigid([-0.2, -1.0]), keep=5, stop=Stop(impacts=5), workers=1)
    one = run(STEPS, Start.rigid(-1.0), stop=Stop(impacts=5))
    assert rigid.last_time[1].tolist() == one.events.time.tolist()


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
