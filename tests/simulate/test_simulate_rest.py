"""The simulator against plain integration of the modes, through impacts, chatter, rest and release; and bars that
start on the wall."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from percuss import Load, System
from percuss.blow import Rod
from percuss.blow.periods import run_by_waves
from percuss.model import External, Reversed, UniformBar
from percuss.simulate import Start, Stop, run

TURN = 2.0 * np.pi


# -- plain integration -----------------------------------------------------------------------------------------------


def signs(modes):
    n = np.arange(modes + 1)
    return np.where(n == 0, 1.0, np.where(n % 2, -2.0, 2.0))


def integrated(system, u, v, begin, end, modes, wait):
    """Impacts, rests and releases (kind, time, speed) from u_n, u_n', and a function for the state between them.

    A chatter is taken for rest when its impacts are slower than 1e-7. `wait`: how long after a release no contact is
    looked for.
    """
    stiffness, sign = (np.arange(modes + 1) * np.pi * system.s) ** 2, signs(modes)
    x, t, events, pieces, free_from = np.concatenate([u, v]), begin, [], [], begin
    breaks = np.asarray(system.load.breaks)
    while t < end:
        stop, inside = end, 0.5 * TURN
        if breaks.size:
            later = np.concatenate([breaks + k * TURN for k in range(int(t // TURN), int(t // TURN) + 2)])
            stop = min(end, later[later > t + 1e-9].min())
            inside = 0.5 * (t + stop)

        def rate(at, x, inside=inside):
            p = float(system.load.value(inside if breaks.size else at))
            return np.concatenate([x[modes + 1 :], p - system.d * x[modes + 1 :] - stiffness * x[: modes + 1]])

        def contact(at, x, free_from=free_from):
            return sign @ x[: modes + 1] if at > free_from else -1.0

        contact.terminal, contact.direction = True, 1.0
        flight = solve_ivp(
            rate, (t, stop), x, "DOP853", dense_output=True, events=contact, rtol=1e-12, atol=1e-14, max_step=0.05
        )
        pieces.append((t, flight.t[-1], flight.sol))
        t, x = flight.t[-1], flight.y[:, -1]
        if flight.status == 0:
            continue
        speed = sign @ x[modes + 1 :]
        events.append(("impact", t, speed))
        x[modes + 1 :] *= -system.restitution
        x[0] -= sign @ x[: modes + 1]
        free_from = t + min(1e-4, 0.2 * abs(speed) * system.restitution)
        if system.restitution * speed < 1e-7:
            events.append(("rest", t, 0.0))
            later = t + np.linspace(0.0, TURN, 200_001)
            pulling = later[system.load.value(later) < 0.0]
            if not pulling.size:
                break
            low, high = max(pulling[0] - TURN / 200_000, t), pulling[0]
            for _ in range(60):
                low, high = (low, m) if system.load.value(m := 0.5 * (low + high)) < 0.0 else (m, high)
            pieces.append((t, high, None))
            t, x, free_from = high, np.zeros(2 * modes + 2), high + wait
            if t < end:
                events.append(("release", t, 0.0))
    return events, pieces


SMOOTH, STEPS = Load.fourier([0.7, 1.0, 0.2j]), Load.steps([0.4, 2.5, 4.1], [1.5, 0.4, -1.0])
MOTIONS = [
    pytest.param(load, restitution, modes, s, d, marks=[pytest.mark.slow] * (modes == 3))
    for load, s, d in ((SMOOTH, 2.3, 0.1), (STEPS, 2.3, 0.1), (SMOOTH, 0.7, 3.0), (STEPS, 5.0, 0.0))
    for restitution in (0.0, 0.4, 1.0)
    for modes in (0, 1, 3)
]


@pytest.mark.parametrize(("load", "restitution", "modes", "s", "d"), MOTIONS)
def test_against_plain_integration(load, restitution, modes, s, d):
    system = System(s=s, d=d, restitution=restitution, load=load)
    rng = np.random.default_rng(modes)
    u, v = rng.normal(size=(2, modes + 1)) * np.array([[0.02], [0.2]]) / (1.0 + np.arange(modes + 1))
    u[0] = -signs(modes)[1:] @ u[1:] - 0.4
    begin = 7.1
    motion = run(system, Start.modal(u, v, begin), modes=modes, stop=Stop(time=12.0, impacts=9999, periodic=False))
    wait = (1.0 + 0.5 / modes) / s if modes else 1e-3
    events, pieces = integrated(system, u, v, begin, begin + 12.0, modes, wait)
    ours = [(e.kind, e.time, e.impact_velocity) for e in motion.events if e.kind in ("impact", "rest", "release")]
    fast = 3e-4  # the tails of a chatter are too fine for the integrator
    hits = [e for e in events if e[0] != "impact" or e[2] > fast]
    mine = [e for e in ours if e[0] != "impact" or e[2] > fast]
    assert [e[0] for e in mine] == [e[0] for e in hits]
    assert len(hits) > 1
    times = np.array([[a[1], b[1]] for a, b in zip(mine, hits, strict=True)])
    speeds = np.array([[a[2], b[2]] for a, b in zip(mine, hits, strict=True)])
    loose = 1e-3 if restitution == 0.4 and any(e[0] == "rest" for e in events) else 1e-7
    rests = np.array([e[0] == "rest" for e in hits])
    assert np.abs(times[~rests, 0] - times[~rests, 1]).max() < 2e-7
    assert np.abs(times[:, 0] - times[:, 1]).max() < loose
    assert np.abs(speeds[:, 0] - speeds[:, 1]).max() < 2e-6
    fields_agree(motion, pieces, modes, rng)


def fields_agree(motion, pieces, modes, rng):
    """Position and velocity at random places and times, and the strain at the ends."""
    x, n = rng.uniform(0.0, 1.0, 7), np.arange(modes + 1)
    shape = np.where(n == 0, 1.0, 2.0) * np.cos(np.pi * np.outer(x, n))
    for begin, stop, solution in pieces:
        end = min(stop, motion.end_time)
        if end - begin < 0.05:
            continue
        t = np.sort(rng.uniform(begin + 0.01, end - 0.01, 5))
        state = np.zeros((2 * modes + 2, t.size)) if solution is None else solution(t)
        assert np.abs(motion.position(x, t) - shape @ state[: modes + 1]).max() < 3e-6
        assert np.abs(motion.bar_velocity(x, t) - shape @ state[modes + 1 :]).max() < 2e-5
        # the strain is that of the whole bar: −s² u_x(0) = p and u_x(1) = 0, theory (3), (4); none in a bar that rests
        pushed = 0.0 if solution is None else motion.system.load.value(t) / motion.system.s**2
        assert np.abs(motion.strain([0.0], t)[0] + pushed).max() < 1e-12 / motion.system.s**2 + 1e-12
        assert np.abs(motion.strain([1.0], t)).max() < 1e-12


# -- rest and release ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("modes", [0, 1, 2, 5, 8])
@pytest.mark.parametrize(("s", "d"), [(3.0, 0.0), (0.8, 0.1), (40.0, 0.01), (5.0, 20.0)])
def test_released_where_the_load_begins_to_pull(modes, s, d):
    system = System(s=s, d=d, restitution=0.0, load=Load.harmonic(0.4, 1.0))
    motion = run(system, Start.rigid(0.0, time=0.1), modes=modes, stop=Stop(time=40.0, periodic=False))
    assert motion.resting
    pull = np.arccos(-0.4)
    released = motion.events.of("release")
    assert len(released) > 1
    assert np.abs(released.phase - pull).max() < 1e-14
    assert np.all(motion.contact_force(np.linspace(0.1, pull, 9)[:-1]) > 0.0)
    at = motion.modal(released.time)
    assert np.abs(at.displacement).max() < 1e-13 and np.abs(at.velocity).max() < 1e-13
    # it leaves undeformed and does not strike before the wave has come to the striking end
    struck = motion.events.of("impact").time
    assert struck[0] - released.time[0] > 1.0 / s
    # the rigid bar's own motion, by quadrature, as long as it flies
    if d == 0.0:
        t = np.linspace(released.time[0], struck[0], 20)
        mean = motion.modal(t, "left").displacement[0]
        h = t - pull
        exact = 0.2 * h**2 + np.cos(pull) - np.cos(t) - h * np.sin(pull)
        assert np.abs(mean - exact).max() < 1e-12


def test_rest_for_good():
    for load in (Load.fourier([1.0]), Load.harmonic(1.2, 1.0), Load.steps([0.0, 3.0], [1.0, 0.0])):
        for restitution in (0.0, 0.5, 0.95):
            system = System(s=9.0, d=0.1, restitution=restitution, load=load)
            motion = run(system, Start.rigid(-0.1), modes=0, stop=Stop(impacts=10**5))
            if motion.outcome == "rest":
                assert motion.label == "rest" and motion.events.kind[-1] == "rest"
            else:
                assert restitution > 0.5 and motion.cycle is not None
            if restitution == 0.0:
                assert motion.events.kind.tolist() == ["impact", "rest"]


# -- bars that start on the wall -------------------------------------------------------------------------------------


@pytest.mark.parametrize("modes", [0, 3])
def test_starts_on_the_wall(modes):
    push = System(s=4.0, d=0.1, restitution=0.5, load=Load.harmonic(2.0, 1.0))
    pull = System(s=4.0, d=0.1, restitution=0.5, load=Load.harmonic(-2.0, 1.0))
    stop = Stop(impacts=5, time=50.0, periodic=False)

    moving_in = run(push, Start.rigid(0.0, 0.7, 1.1), modes=modes, stop=stop).events
    assert moving_in.kind[0] == "impact" and moving_in.time[0] == pytest.approx(1.1, abs=1e-15)
    assert moving_in.impact_velocity[0] == pytest.approx(0.7, rel=1e-14)
    moving_out = run(push, Start.rigid(0.0, -0.7, 1.1), modes=modes, stop=stop).events
    assert moving_out.kind[0] == "impact" and moving_out.time[0] > 1.3

    still = run(push, Start.rigid(0.0, 0.0, 1.1), modes=modes, stop=stop)
    assert (still.outcome, still.label, len(still.events), still.impacts) == ("rest", "rest", 0, 0)
    assert still.gap([1.1]) == 0.0
    pulled = run(pull, Start.rigid(0.0, 0.0, 1.1), modes=modes, stop=stop)
    assert pulled.events.kind.tolist() == ["release"] and pulled.events.time[0] == pytest.approx(1.1, abs=1e-15)
    gone = run(pull, Start.rigid(0.0, 0.0, 1.1), modes=modes)
    assert gone.outcome == gone.label == "departed"
    struck = run(pull, Start.rigid(0.0, 0.7, 1.1), modes=modes, stop=stop).events
    assert struck.kind[0] == "impact" and struck.rebound_velocity[0] == pytest.approx(-0.35, rel=1e-14)


@pytest.mark.parametrize("modes", [0, 2])
def test_restitution_one_and_zero(modes):
    load = Load.harmonic(0.6, 1.0)
    perfect = run(System(s=4.0, d=0.3, restitution=1.0, load=load), modes=modes, stop=Stop(impacts=300, periodic=False))
    assert set(perfect.events.kind.tolist()) == {"impact"} and perfect.impacts == 300
    assert np.array_equal(perfect.events.rebound_velocity, -perfect.events.impact_velocity)
    assert np.all(perfect.events.energy_lost == 0.0)
    dead = run(System(s=40.0, d=0.3, restitution=0.0, load=load), modes=modes, stop=Stop(impacts=20, periodic=False))
    kinds = dead.events.kind.tolist()
    pushed = dead.system.load.value(dead.events.of("impact").time) > 0.0
    after = [kinds[i + 1] for i in range(len(kinds) - 1) if kinds[i] == "impact"]
    assert all(kind == "rest" for kind, pushes in zip(after, pushed, strict=False) if pushes)
    assert np.all(dead.events.rebound_velocity == 0.0)


# -- a bar that the load holds down ----------------------------------------------------------------------------------


def pressed(seed):
    """A bar whose impacts turn the strain over, under a harmonic load, and the gap and the phase of its start."""
    rng = np.random.default_rng(seed)
    s, R, mean = float(np.exp(rng.uniform(0.0, 3.0))), float(rng.uniform(0.02, 0.8)), float(rng.uniform(0.2, 1.3))
    body = UniformBar(s, External(float(rng.uniform(0.0, 0.05))))
    system = System(body, Load.harmonic(mean, 1.0), Reversed(R))
    return system, float(rng.uniform(0.3, 3.0)), float(rng.uniform(0.0, 6.0))


def test_a_load_holds_a_bar_down_within_the_time_of_a_contact_and_takes_no_more_than_is_said():
    told = 0
    for seed in range(60):
        system, gap, phase = pressed(seed)
        motion = run(system, Start.rigid(-gap, time=phase), modes=4, stop=Stop(impacts=300, periodic=False))
        events, s = motion.events, system.body.s
        struck, fastest = events.of("impact").time, system.load.value(events.phase) / s
        given_up = []
        for i in np.flatnonzero((events.kind == "rest") | (events.kind == "chatter")):
            before = i - 1 if events.kind[i - 1] == "impact" else None
            if before is None or events.time[before] != events.time[i] or events.rebound_velocity[before] > -1e-9:
                continue
            given_up.append(events.energy_lost[i] / events.kinetic_energy.max())
            assert np.diff(struck[struck <= events.time[i]])[-1] < 2.0 / s
            assert events.energy_lost[i] <= fastest[i] ** 2 * (1.0 + 1e-9), seed
        assert motion.events.held_down == pytest.approx(given_up)
        told += len(given_up)
    assert told > 60


def test_a_bar_that_waves_bring_to_rest_comes_to_rest():
    """Under a load that always pushes; without its hold the law that turns the strain over feeds the bounces."""
    seen = 0
    for seed in range(100, 160):
        system, gap, phase = pressed(seed)
        if system.load.mean < 1.02 or system.body.s < 2.0 or seen == 6:
            continue
        R, s, seen = system.contact.restitution, system.body.s, seen + 1
        rod, limits = (Rod.of_impedance(s * (1.0 + R) / (1.0 - R)), Stop(impacts=10**5, time=60 * TURN, periodic=False))
        waves = run_by_waves(system, rod, Start.rigid(-gap, time=phase), limits, cells=40, estimate=False)
        quiet = waves.impacts.given[waves.impacts.start > 30 * TURN].sum() < 1e-3
        by_law = run(system, Start.rigid(-gap, time=phase), modes=8, stop=Stop(time=60 * TURN, periodic=False))
        assert (by_law.outcome == "rest") == quiet, seed
        assert quiet and by_law.events.held_down.size
    assert seen == 6
