"""Starts: rigid, modal, along the bar, from an orbit, and drawn at random."""

import mpmath
import numpy as np
import pytest

from percuss import Kept, Load, System, steady_states
from percuss.errors import ParameterError
from percuss.model import Mounted
from percuss.simulate import DISTRIBUTIONS, Start, Starts, Stop, run, simulate_many

SYSTEM = System(s=5.0, d=0.1, restitution=0.5, load=Load.harmonic(0.8, 1.0))


def signs(modes):
    n = np.arange(modes + 1)
    return np.where(n == 0, 1.0, np.where(n % 2, -2.0, 2.0))


def test_rigid():
    u, v, gap = Start.rigid(-0.7, 0.2, 1.5).state(4)
    assert u.tolist() == [-0.7, 0, 0, 0, 0] and v.tolist() == [0.2, 0, 0, 0, 0] and gap == -0.7
    motion = run(SYSTEM, Start.rigid(-0.7, 0.2, 1.5), modes=4, stop=Stop(impacts=0))
    assert motion.position([0.0, 0.3, 1.0], [1.5]).reshape(-1) == pytest.approx([-0.7] * 3, abs=1e-15)
    assert motion.bar_velocity([0.0, 0.3, 1.0], [1.5]).reshape(-1) == pytest.approx([0.2] * 3, abs=1e-15)


def test_modal():
    rng = np.random.default_rng(2)
    u, v = 0.1 * rng.normal(size=(2, 6))
    u[0] = -1.0
    motion = run(SYSTEM, Start(tuple(u), tuple(v), -2.0), modes=8, stop=Stop(time=1e-3))
    assert motion.begin_time == -2.0
    at = motion.modal([-2.0])
    assert at.displacement[:6, 0] == pytest.approx(u, abs=1e-14) and np.abs(at.displacement[6:]).max() < 1e-15
    assert at.velocity[:6, 0] == pytest.approx(v, abs=1e-13) and np.abs(at.velocity[6:]).max() < 1e-13
    assert motion.gap([-2.0])[0] == pytest.approx(signs(5) @ u, abs=1e-14)


def test_field_by_a_function():
    # ∫ e^{ax} cos nπx dx = a (e^a (−1)ⁿ − 1)/(a² + n²π²)
    n, a = np.arange(33), 0.7
    exact = a * (np.exp(a) * (-1.0) ** n - 1.0) / (a * a + (n * np.pi) ** 2)
    start = Start.field(lambda x: -3.0 + np.exp(a * x), lambda x: np.exp(a * x), 0.4)
    u, v, gap = start.state(32)
    assert v == pytest.approx(exact, abs=1e-14)
    assert u[1:] == pytest.approx(exact[1:], abs=1e-14)
    # the place of the striking end is kept; what the modes left out would add moves the rest
    assert gap == pytest.approx(-3.0 + np.exp(a), abs=1e-14) and signs(32) @ u == pytest.approx(gap, abs=1e-13)
    assert u[0] == pytest.approx(-3.0 + exact[0], abs=0.02)


def test_field_by_samples():
    # straight lines between samples: u = −1 − |x − ½|, ∫ |x − ½| cos nπx dx = (1 − 2 cos(nπ/2) + (−1)ⁿ)/(nπ)²
    n = np.arange(1, 21)
    exact = -(1.0 - 2.0 * np.cos(0.5 * n * np.pi) + (-1.0) ** n) / (n * np.pi) ** 2
    u, v, gap = Start.field([-1.5, -1.0, -1.5], -0.3).state(20)
    assert u[1:] == pytest.approx(exact, abs=1e-15)
    assert gap == -1.5
    assert v[0] == -0.3 and np.abs(v[1:]).max() < 1e-16
    fine = np.linspace(0.0, 1.0, 2001)
    by_function = Start.field(lambda x: -1.5 + 0.1 * np.sin(3.0 * x)).state(10)
    by_samples = Start.field(-1.5 + 0.1 * np.sin(3.0 * fine)).state(10)
    assert by_samples[0] == pytest.approx(by_function[0], abs=1e-6)


def test_field_converges_to_itself():
    profile = lambda x: -0.5 - 0.1 * np.cos(np.pi * x) + 0.05 * np.cos(3.0 * np.pi * x)  # noqa: E731
    motion = run(SYSTEM, Start.field(profile), modes=6, stop=Stop(impacts=0))
    x = np.linspace(0.0, 1.0, 50)
    assert motion.position(x, [0.0])[:, 0] == pytest.approx(profile(x), abs=1e-14)


def test_orbit_and_perturbation():
    for orbit in steady_states(SYSTEM, modes=6).orbits:
        u, v, gap = Start.orbit(orbit).state(6)
        assert gap == 0.0 and signs(6) @ u == pytest.approx(0.0, abs=1e-15)
        assert signs(6) @ v == pytest.approx(-0.5 * orbit.impact_velocity, rel=1e-12)
        x = np.linspace(0.0, 1.0, 9)
        shape = np.where(np.arange(7) == 0, 1.0, 2.0) * np.cos(np.pi * np.outer(x, np.arange(7)))
        # up to where the bar stands: the wall is at the striking end
        there = orbit.position(x, [0.0])[:, 0]
        assert shape @ u == pytest.approx(there - there[-1], abs=1e-12)
        du, dv = [-0.01, 0.002], [0.03, 0.0, -0.02]
        u1, v1, gap1 = Start.orbit(orbit, du, dv).state(6)
        assert u1 - u == pytest.approx([-0.01, 0.002, 0, 0, 0, 0, 0], abs=1e-15)
        assert v1 - v == pytest.approx([0.03, 0.0, -0.02, 0, 0, 0, 0], abs=1e-15)
        assert gap1 == pytest.approx(-0.014, abs=1e-15)
        with pytest.raises(ParameterError):
            Start.orbit(orbit, [0.01]).state(6)


@pytest.mark.parametrize("distribution", DISTRIBUTIONS)
def test_random(distribution):
    starts = Starts.random(SYSTEM, 4000, seed=7, distribution=distribution, modes=5)
    again = Starts.random(SYSTEM, 4000, seed=7, distribution=distribution, modes=5)
    other = Starts.random(SYSTEM, 4000, seed=8, distribution=distribution, modes=5)
    for name in ("displacement", "velocity", "gap", "time"):
        assert np.array_equal(getattr(starts, name), getattr(again, name))
    assert not np.array_equal(starts.time, other.time)
    scale = 1.8
    assert starts.gap.min() >= -5.0 * scale and starts.gap.max() <= 0.0
    assert starts.gap.mean() == pytest.approx(-2.5 * scale, rel=0.05)
    assert starts.time.min() >= 0.0 and starts.time.max() < 2.0 * np.pi and abs(starts.time.mean() - np.pi) < 0.1
    mean = starts.velocity[:, 0]
    if distribution == "still":
        assert np.all(mean == 0.0)
    else:
        assert abs(mean).max() <= 3.0 * scale and mean.std() == pytest.approx(3.0 * scale / np.sqrt(3.0), rel=0.05)
    if distribution == "ringing":
        # each mode: energy in velocity and displacement alike
        omega = np.pi * SYSTEM.s * np.arange(1, 6)
        assert (starts.displacement[:, 1:] * omega).std(axis=0) == pytest.approx(
            starts.velocity[:, 1:].std(axis=0), rel=0.1
        )
        assert starts.velocity[:, 1:].std(axis=0) == pytest.approx(scale / 3.0 / np.arange(1, 6) / np.sqrt(2), rel=0.1)
    one = Start.random(SYSTEM, 7, distribution, modes=5)
    assert one.time == Starts.random(SYSTEM, 1, seed=7, distribution=distribution, modes=5).time[0]
    u, v, gap = starts[17].state(5)
    assert gap == starts.gap[17] and u[1:].tolist() == [*starts.displacement[17, 1:], *[0.0] * 5][:5]
    assert v[0] == starts.velocity[17, 0]


def test_a_start_at_a_time_or_a_period_later():
    for load in (SYSTEM.load, Load.steps([0.3, 2.0], [1.0, -0.2])):
        system = System(s=5.0, d=0.5, restitution=0.3, load=load)
        start = Start.rigid(-0.3, 0.1, 0.75)
        first = run(system, start, modes=3, stop=Stop(impacts=8, periodic=False)).events
        later = run(system, start.at(0.75 + 8.0 * np.pi), modes=3, stop=Stop(impacts=8, periodic=False)).events
        assert later.period.tolist() == (first.period + 4).tolist()
        assert later.phase == pytest.approx(first.phase, abs=1e-9)


@pytest.mark.parametrize(
    "make",
    [
        lambda: Start.rigid(position=0.1),
        lambda: Start.rigid(velocity=np.nan),
        lambda: Start.rigid(time=np.inf),
        lambda: Start.rigid(time=1e16),
        lambda: Start.modal([]),
        lambda: Start.modal([-1.0, 0.1], [0.0]),
        lambda: Start.modal(["a"]),
        lambda: Start.modal([0.5]).state(0),
        lambda: Start.modal([-1.0, -0.6]).state(1),
        lambda: Start.modal([-1.0, 0.1, 0.1]).state(1),
        lambda: Start.field([0.0, 0.2]).state(3),
        lambda: Start.field(lambda x: x * np.nan).state(3),
        lambda: Starts.random(SYSTEM, 3, distribution="odd"),
        lambda: Starts.random(SYSTEM, 0),
        lambda: Starts.rigid([-1.0, -2.0], [0.0, 0.0, 0.0]),
        lambda: Starts.rigid([-1.0, 0.2]),
        lambda: Starts.rigid([-1.0, np.nan]),
        lambda: Starts.of([], 3),
        lambda: Stop(impacts=-1),
        lambda: Stop(time=0.0),
        lambda: Stop(tolerance=1.0),
        lambda: run(SYSTEM, modes=-1),
        lambda: run(SYSTEM, modes=5000),
    ],
)
def test_nonsense_is_refused(make):
    with pytest.raises(ParameterError):
        make()


TURN = 2.0 * np.pi
STEPPED = {
    "a step at phase 0": ([0.0, 3.3], [1.0, -0.8]),
    "steps elsewhere": ([0.7, 2.0, 5.9], [1.0, 0.3, -0.9]),
    "a step an ulp before a turn": ([0.4, 3.0, float(np.nextafter(TURN, 0.0))], [0.2, -0.8, 1.0]),
    "a step an ulp after 0": ([5e-324, 2.5], [-0.6, 1.0]),
}
LIMIT = 60.0


def parabolas(breaks, values, time, position, velocity):
    """Time until a rigid undamped bar strikes, parabola by parabola in 40 digits; `LIMIT` if not before."""
    mp = mpmath.MPContext()
    mp.dps = 40
    place, rate, gone, piece = mp.mpf(position), mp.mpf(velocity), mp.mpf(0), len(breaks) - 1
    phase = mp.fmod(mp.mpf(time), 2 * mp.pi) % (2 * mp.pi)
    for i, b in enumerate(breaks):
        piece = i if phase >= b else piece
    while gone < LIMIT:
        force, following = mp.mpf(values[piece]), (piece + 1) % len(breaks)
        length = (mp.mpf(breaks[following]) - phase) % (2 * mp.pi)
        disc = rate * rate - 2 * force * place
        roots = [(-rate + sign * mp.sqrt(disc)) / force for sign in (-1, 1)] if disc >= 0 else []
        struck = [t for t in roots if 0 < t <= length and rate + force * t > 0]
        if struck:
            return float(min(gone + min(struck), LIMIT))
        place, rate = place + rate * length + force * length**2 / 2, rate + force * length
        gone, phase, piece = gone + length, mp.mpf(breaks[following]), following
    return LIMIT


def near_steps(breaks, ulps):
    """Doubles so many ulps beside each break, in turns before and after 0 up to very many; and the break."""
    for turn in (-(10**6), -40, -3, -1, 0, 1, 2, 17, 1000, 10**7):
        for b in breaks:
            time = b + turn * TURN
            for n in ulps:
                yield time + n * float(np.spacing(max(abs(time), TURN))), b


@pytest.mark.parametrize("form", STEPPED)
def test_a_rigid_bar_started_within_rounding_of_a_step(form):
    """It is under the force of that step: against parabolas in 40 digits."""
    breaks, values = STEPPED[form]
    system = System(s=5.0, d=0.0, restitution=0.5, load=Load.steps(breaks, values))
    stop = Stop(impacts=1, time=LIMIT, periodic=False)
    times = [time for time, _ in near_steps(breaks, (-40, -13, -12, -9, -5, -2, -1, 0, 1, 2, 7, 13, 40))]
    many = simulate_many(system, Starts.rigid(-0.5, 0.1, times), modes=0, stop=stop, keep=1)
    for time, struck in zip(times, many.last_time[:, 0], strict=True):
        exact, error = parabolas(breaks, values, time, -0.5, 0.1), 1e-9 + 1e3 * np.spacing(abs(time))
        alone = run(system, Start.rigid(-0.5, 0.1, time), modes=0, stop=stop).events.time
        assert float(alone[0] - time if len(alone) else LIMIT) == pytest.approx(exact, abs=error), time
        assert np.nan_to_num(struck - time, nan=LIMIT) == pytest.approx(exact, abs=error), time


@pytest.mark.parametrize("form", STEPPED)
@pytest.mark.parametrize("name", ["bar", "resting bar", "structure of one mode", "structure", "resting structure"])
def test_a_start_within_rounding_of_a_step_is_one_at_that_step(form, name):
    breaks, values = STEPPED[form]
    load, resting = Load.steps(breaks, values), name.startswith("resting")
    bar = System(s=5.0, d=0.1, restitution=0.4, load=load)
    held = System(Mounted(0.3, 0.05, 4.0, gap=-0.1), load, Kept(0.4))
    system, modes = (bar, 3) if "bar" in name else (held, 4 if name == "structure" else 1)
    place, speed = (0.0, 0.0) if resting else (-0.5, 0.1)
    stop = Stop(impacts=3, time=LIMIT, periodic=False)
    for time, b in near_steps(breaks, (-4, -2, -1, 0, 1, 2, 4)):
        error = 1e-8 + 1e4 * np.spacing(abs(time))
        at, near = (run(system, Start.rigid(place, speed, t), modes=modes, stop=stop) for t in (b, time))
        assert near.events.kind.tolist() == at.events.kind.tolist(), time
        assert near.events.time - time == pytest.approx(at.events.time - b, abs=error), time


@pytest.mark.parametrize("modes", [0, 4])
def test_an_orbit_that_strikes_where_a_step_begins_comes_back_from_within_rounding_of_it(modes):
    breaks, values = [0.4, 3.0, 4.0], [0.9, -0.4, -0.1]
    orbit = steady_states(System(s=5.0, d=0.1, restitution=0.5, load=Load.steps(breaks, values)), modes=modes).orbits[0]
    moved = np.sort([0.0, *((np.array(breaks) - orbit.phase) % TURN)])  # its impact at phase 0, where a step begins
    middles = moved + 0.5 * np.diff(moved, append=TURN)
    load = Load.steps(moved, orbit.system.load.value(middles + orbit.phase))
    same = System(s=5.0, d=0.1, restitution=0.5, load=load)
    (here,) = (o for o in steady_states(same, modes=modes).orbits if min(o.phase, TURN - o.phase) < 1e-9)
    for time, _ in near_steps([0.0], range(-12, 13)):
        motion = run(same, Start.orbit(here).at(time), modes=modes, stop=Stop(impacts=3, periodic=False))
        error = 1e-8 + 1e4 * np.spacing(abs(time))
        assert motion.events.time - time == pytest.approx(TURN * np.arange(1, 4), abs=error), time
        assert motion.events.impact_velocity == pytest.approx(orbit.impact_velocity, rel=100.0 * error), time
