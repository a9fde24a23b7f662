"""First contacts where rounding is hardest: overdamped and critical modes, strong damping, long and tiny flights.

The engine against ball arithmetic, as in `test_first_contact`, but with the error that each flight's own sums allow;
and the examples that once went wrong.
"""

import math

import numpy as np
import pytest

from damped_flights import REGIONS, Sums, damped_flight
from interval_oracle import Flight, first_contact, gap
from percuss.model import Load, System
from percuss.simulate import Start, Stop, run
from percuss.simulate.kernels.modes import creep
from test_first_contact import simulated

ERROR = 8e-15  # of a gap or its rate, times the sums of the absolute values of what makes it up
DIGITS = 4e-15  # of a phase
FLIGHTS = 7000
CONTACTS = {"overdamped": 0.6, "critical": 0.67, "stiff": 0.55, "crawling": 0.73, "strained": 0.7, "touching": 0.62}
assert 4 * FLIGHTS * sum(CONTACTS.values()) > 1e5


def agrees(flight: Flight, horizon: float, on_wall: bool) -> str:
    """Kind, time and speed by the engine, held against the oracle; returns the oracle's kind."""
    true = first_contact(flight, horizon, on_wall)
    kind, time, speed = simulated(flight, horizon, restitution=1.0)
    where = f"{flight}\n{flight.displacement.tolist()}\n{flight.velocity.tolist()}\n"
    where += f"horizon {horizon}, on the wall {on_wall}\noracle {true}, engine {kind} at {time} with {speed}"
    if kind == "graze":  # as near the wall as rounding tells, and no way across
        y, rate, curve = gap(flight, time, on_wall)
        sums = Sums.of(flight, time, on_wall)
        error = ERROR * sums.place
        assert abs(y) < error and (rate * rate < 4.0 * abs(curve) * error or abs(rate) < ERROR * sums.rate), where
        return true.kind
    if true.kind == "graze":
        return true.kind  # deeper than rounding, but within the oracle's own 1e-13
    assert kind == true.kind, where
    if kind == "contact":
        curve, sums = abs(gap(flight, true.time, on_wall)[2]), Sums.of(flight, true.time, on_wall)
        error = ERROR * sums.place
        late = error / true.speed
        if curve * error > 0.0:
            late = min(late, math.sqrt(2.0 * error / curve))
        late += DIGITS * (1.0 + flight.time + true.time)
        assert abs(time - true.time) < late, where
        assert abs(speed - true.speed) < 3e-11 * true.speed + ERROR * sums.rate + curve * late, where
    return true.kind


def in_region(region: str, seed: int, flights: int) -> list[str]:
    rng = np.random.default_rng(seed)
    return [agrees(*damped_flight(rng, region)) for _ in range(flights)]


@pytest.mark.parametrize("region", REGIONS)
def test_a_few(region):
    assert in_region(region, 1977, 60).count("contact") > 20


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("region", REGIONS[::2])
def test_many(region, seed):
    """With the other regions, in `test_first_contact_long`, more than 1e5 first contacts."""
    many(region, seed)


def many(region: str, seed: int) -> None:
    """A quarter of a region's flights, and at least the share of contacts that makes 1e5 of all together."""
    assert in_region(region, seed, FLIGHTS).count("contact") > CONTACTS[region] * FLIGHTS


# -- examples -------------------------------------------------------------------------------------------------------


def rigid(s, d, coefficients, position, velocity=0.0, time=0.0, modes=1):
    """The same start as a flight for the oracle."""
    rest = [0.0] * modes
    return Flight(s, d, coefficients, (), (), time, np.array([position, *rest]), np.array([velocity, *rest]))


def test_no_impact_far_from_the_wall():
    """A free part of 900 beside a gap of 0.06: the increment of a graze, not an impact at time 0."""
    flight = rigid(0.01, 2.0, (0.3, 1.0), -0.06482451117675933, 0.5)
    assert agrees(flight, 50.0, False) == "graze"
    kind, time, _ = simulated(flight, 50.0, restitution=0.6)
    assert kind in ("graze", "none") and time > 0.28


def test_a_slow_and_strongly_damped_bar_stops_at_the_wall():
    """s = 0.0025, d = 16.2: static shapes of 1e4, whose rounding is more than the gap."""
    rng = np.random.default_rng(162)
    for _ in range(40):
        wall, leave = rng.random() < 0.5, 10.0 ** rng.uniform(-7, -1)
        coefficients = (float(rng.uniform(0.05, 1.0)), 1.0)
        position = 0.0 if wall else -(10.0 ** rng.uniform(-5, -1))
        phase = float(rng.uniform(0, 6.0))
        agrees(rigid(0.0025, 16.2, coefficients, position, -leave, phase, modes=8), 30.0, wall)


@pytest.mark.parametrize("leave", [1e-3, 1e-5, 1e-7, 1e-9])
def test_a_strained_bar_leaves_the_wall_slowly(leave):
    """Time and speed of a tiny flight under a free part of hundreds (s = 0.02, d = 1)."""
    u = np.array([0.0, 0.3, -0.1])
    u[0] = -float(np.array([-2.0, 2.0]) @ u[1:])
    for mean in (0.2, 0.5, 0.9):
        flight = Flight(0.02, 1.0, (mean, 1.0), (), (), 0.3, u, np.array([-leave, 0.0, 0.0]))
        assert agrees(flight, 10.0, True) == "contact"
        _, time, speed = simulated(flight, 10.0, restitution=1.0)
        assert time > 0.0 and speed > 0.5 * leave


def test_a_bar_that_rebounds_fully_does_not_come_to_rest():
    system = System(0.05, 1.8, 1.0, Load.harmonic(1.05, 1.0))
    motion = run(system, Start.rigid(0.0, -1e-7, 0.82), modes=8, stop=Stop(impacts=200, periodic=False))
    assert motion.outcome == "impacts"
    assert motion.events.impact_velocity.min() > 0.9e-7
    agrees(rigid(0.05, 1.8, (1.05, 1.0), 0.0, -1e-7, 0.82, modes=8), 10.0, True)


def test_long_flights_under_strong_damping_end_at_the_wall():
    """d = 1000: the drift is mean t/d, and so is what rounding is measured by, not mean t²."""
    system = System(1.0, 1000.0, 1.0, Load.harmonic(0.001, 1.0))
    motion = run(system, Start.rigid(-0.9636961687321455), modes=0, stop=Stop(impacts=1, periodic=False))
    assert motion.events.kind.tolist() == ["impact"]
    assert motion.events.time[0] == pytest.approx(962698.589, abs=5e-4)
    rng = np.random.default_rng(3)
    for _ in range(8):
        flight = rigid(1.0, 1000.0, (0.001, 1.0), -float(rng.uniform(0.01, 1.0)), modes=0)
        assert agrees(flight, 2e6, False) == "contact"


def test_a_graze_leaves_the_bar_where_it_is():
    """A rigid bar whose flight has its summit at −4 ulp of 1024, exactly: it is not put on the wall."""
    low = 1024.0 + 4 * 2.0**-42
    system, stop = System(1.0, 0.0, 0.5, Load.fourier([-0.5])), Stop(impacts=1, time=1e4, periodic=False)
    motion = run(system, Start.rigid(-low, 32.0), modes=0, stop=stop)
    assert motion.events.kind.tolist() == ["grazing"]
    assert motion.events.time[0] == pytest.approx(64.0, rel=1e-12)
    assert motion.states[0, 0] == pytest.approx(1024.0 - low, rel=1e-3, abs=0.0)


def test_bounds_fade_with_the_ringing():
    """Six ringing modes that die out before a flight of 1e5: hundreds of evaluations, not a step for every wave."""
    rng = np.random.default_rng(1)
    u = np.zeros(33)
    u[1:7] = 0.01 * rng.normal(size=6)
    u[0] = -0.011 - 2.0 * np.abs(u).sum() - float(np.where(np.arange(1, 33) % 2, -2.0, 2.0) @ u[1:])
    system, stop = System(20.0, 0.5, 0.6, Load.harmonic(0.0, 0.01)), Stop(time=1e5, periodic=False)
    motion = run(system, Start.modal(u, np.zeros(33)), modes=32, stop=stop)
    assert motion.outcome == "time"
    assert motion.snapshot["count"]["work"][0] < 2000


@pytest.mark.parametrize("off", [1e-15, 1e-12, 1e-9, 1e-7, 1e-3])
@pytest.mark.parametrize("above", [1.0, -1.0])
def test_critical_damping_is_no_special_case(off, above):
    """The motion in closed form beside critical damping, of the engine and of the trajectory, against balls."""
    s = 0.7
    d = 2.0 * math.pi * s * (1.0 + above * off)
    flight = Flight(s, d, (0.4, 1.0), (), (), 0.3, np.array([-0.9, 0.2]), np.array([0.1, -0.3]))
    assert agrees(flight, 20.0, False) == "contact"
    motion = run(
        System(s, d, 1.0, Load.harmonic(0.4, 1.0)), Start.modal([-0.9, 0.2], [0.1, -0.3], 0.3), modes=1,
        stop=Stop(impacts=1, periodic=False),
    )  # fmt: skip
    for tau in (0.01, 0.03, 0.1, *np.linspace(0.2, motion.events.time[0] - 0.3, 5)[:-1]):
        assert motion.gap(0.3 + tau) == pytest.approx(gap(flight, (0.3 + tau) - 0.3)[0], rel=0.0, abs=1e-14)


@pytest.mark.parametrize("spread", [3e-16, 1e-14, 1e-10, 1e-6, 0.3, 30.0])
def test_the_free_motion_of_a_damped_mode(spread):
    """g, h and h' against their definition in 60 digits, from times far below the period to far beyond it."""
    import mpmath
    import numba

    creeping = numba.njit(creep.py_func)
    with mpmath.workdps(60):
        omega, d = mpmath.mpf(2), 4 * (1 + mpmath.mpf(spread))
        d = mpmath.mpf(float(d))
        kappa = mpmath.sqrt(d * d / 4 - omega * omega)
        slow, quick = d / 2 - kappa, d / 2 + kappa
        square = float(omega * omega - d * d / 4)
        for tau in (1e-9, 1e-4, 0.1, 0.24, 0.26, 1.0, 5.0, 40.0):
            e, f = mpmath.exp(-slow * tau), mpmath.exp(-quick * tau)
            h, left = (e - f) / (2 * kappa), (quick * e - slow * f) / (2 * kappa)
            exact = (1 - left, h, (quick * f - slow * e) / (2 * kappa), left)
            found = creeping(float(d), square, 2.0, tau)
            for i in (0, 1, 3):
                assert found[i] == pytest.approx(float(exact[i]), rel=4e-14, abs=0.0)
            assert found[2] == pytest.approx(float(exact[2]), rel=1e-13, abs=4e-16)
