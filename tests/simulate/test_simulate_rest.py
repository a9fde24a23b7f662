"""The simulator against plain integration of the modes, through impacts, chatter, rest and release; and bars that
start on the wall."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from percuss import Load, System
from percuss.blow import Rod
from percuss.blow.periods import run_by_waves
from percuss.case.answers.simulation_answer import label_sentence
from percuss.errors import ParameterError, PercussError, ResonanceError
from percuss.model import External, Reversed, UniformBar
from percuss.simulate import Start, Starts, Stop, Trajectory, run, simulate_many
from percuss.steady import rest_cycles
from percuss.steady.resting.flight_chain import ForcedResponse, RestPath, RestSearch, release_phases
from random_hammers import random_hammer

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


# -- rest and release where rounding matters ---------------------------------------------------------------------------


def hammer(factor, restitution=0.8, s=20.0, d=0.005):
    return System(s=s, d=d, restitution=restitution, load=Load.harmonic(factor, 1.0))


# -- laid on the wall when the load begins to pull ---------------------------------------------------------------------


@pytest.mark.parametrize("ulps", [0, 1, 5, 12, 40, -1, -12])
def test_laid_down_as_the_load_begins_to_pull(ulps):
    # p = cos t − cos φ falls through 0 at φ, and the bar is put on the wall some ulps beside it
    rng = np.random.default_rng(3)
    means = [-0.872, *rng.uniform(-0.99, 0.99, 40)]
    for mean in means:
        phase = math.acos(-mean)
        begin = phase + ulps * np.spacing(phase)
        motion = run(System(1.0, 0.0, 0.5, Load.harmonic(mean, 1.0)), Start.rigid(0.0, 0.0, begin), modes=0,
                     stop=Stop(time=0.5))  # fmt: skip
        assert motion.events.kind.tolist() == ["release"], mean
        assert abs(motion.events.time[0] - begin) < 1e-13


def test_laid_down_where_the_load_only_touches_zero():
    # p = cos t − 1 pulls at all times but one, p = 1 + cos t pushes at all times but one
    pulled = run(System(1.0, 0.0, 0.5, Load.harmonic(-1.0, 1.0)), Start.rigid(0.0), modes=0, stop=Stop(time=3.0))
    assert pulled.events.kind.tolist() == ["release"] and pulled.events.time[0] == 0.0
    pushed = run(System(1.0, 0.0, 0.5, Load.harmonic(1.0, 1.0)), Start.rigid(0.0, time=np.pi), modes=0)
    assert (pushed.outcome, len(pushed.events)) == ("rest", 0)
    # p = cos t − cos φ rises through 0 at 2π − φ: no release there, but at the next φ
    phase = math.acos(-0.3)
    for ulps in (-12, -1, 0, 1, 12):
        begin = TURN - phase + ulps * np.spacing(TURN - phase)
        motion = run(System(1.0, 0.0, 0.5, Load.harmonic(0.3, 1.0)), Start.rigid(0.0, time=begin), modes=0,
                     stop=Stop(time=6.0))  # fmt: skip
        assert motion.events.of("release").time == pytest.approx([TURN + phase], abs=1e-12)
    nothing = run(System(1.0, 0.0, 0.5, Load.fourier([0.0])), Start.rigid(0.0), modes=0)
    assert (nothing.outcome, len(nothing.events)) == ("rest", 0)


# -- no contact while the load pulls -----------------------------------------------------------------------------------


def pulls_until(load, begin):
    """When a load that pulls from `begin` on pushes again, on a fine grid."""
    t = begin + np.linspace(1e-6, TURN, 20_001)
    pushes = load.value(t) > 1e-9
    return t[np.argmax(pushes)] if pushes.any() else np.inf


@pytest.mark.parametrize("load", [Load.harmonic(0.4, 1.0), Load.harmonic(-0.1, 1.0), Load.fourier([0.2, 1.0, 0.8j]),
                                  Load.steps([0.0, 2.0, 3.0, 4.5], [1.0, -0.2, 0.0, -1.0])])  # fmt: skip
@pytest.mark.parametrize("modes", [1, 2, 4])
def test_a_released_bar_strikes_nothing_while_the_load_pulls(load, modes):
    # what comes through the bar to its end is pulls alone, so that the end only moves away (d'Alembert)
    seen = 0
    for s, d, restitution in ((2.71, 33.8, 0.0), (2.71, 33.8, 0.5), (0.7, 12.0, 0.5), (1.0, 300.0, 0.3), (9.0, 0.1, 0)):
        system = System(s, d, restitution, load)
        motion = run(system, Start.rigid(0.0, 0.0, 0.3), modes=modes, stop=Stop(time=30.0, periodic=False))
        released, struck = motion.events.of("release").time, motion.events.of("impact").time
        for at in released:
            seen += 1
            free = min(pulls_until(load, at), motion.end_time)
            assert not np.any((struck > at) & (struck < free - 1e-3)), (s, d, restitution)
            assert np.count_nonzero((released > at) & (released < free - 1e-3)) == 0
    assert seen > 4


# -- finitely many impacts ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize("modes", [0, 3])
@pytest.mark.parametrize("load", [Load.harmonic, lambda mean, _: Load.square(1.0, 1.0 + mean)])
def test_without_restitution_there_is_no_chatter(load, modes):
    names = set()
    for mean in np.linspace(0.02, 0.8, 25):
        system = System(s=6.0, d=0.02, restitution=0.0, load=load(mean, 1.0))
        motion = run(system, Start.rigid(-0.5, time=0.3), modes=modes, stop=Stop(impacts=400))
        assert "chatter" not in motion.events.kind, mean
        names.add(motion.label.split("/")[0])
        assert np.all(motion.main_blows)
    assert "rest" in names and "chatter" not in names
    many = simulate_many(system, Starts.random(system, 40, seed=1), modes=modes, stop=Stop(impacts=200))
    assert not any(label.startswith("chatter") for label in many.label)
    moving = run(System(1.0, 0.0, 0.0, Load.fourier([1.0])), Start.rigid(0.0, -1e-7), modes=0)
    assert moving.events.kind.tolist() == ["impact", "rest"]


# -- released twice in the same state ----------------------------------------------------------------------------------


def test_ends_at_the_second_equal_release():
    start = Start.rigid(0.0, -2.4, 2.85)
    motion = run(hammer(0.7837), start, modes=0)
    assert (motion.label, motion.outcome) == ("chatter/5", "periodic") and motion.impacts < 2000
    released = motion.events.of("release")
    assert len(released) == 2 and released.phase[0] == released.phase[1] == pytest.approx(math.acos(-0.7837))
    assert np.diff(released.period) == [5]
    # the impacts after the first release come again after the second
    on = motion.continued(Stop(impacts=motion.impacts + motion.cycle.impacts, periodic=False))
    assert on.label == "chatter/5"
    phases = on.events.of("impact").phase[motion.cycle.first :]
    again = phases[motion.cycle.impacts :]
    assert again == pytest.approx(phases[: again.size], abs=1e-9)
    many = simulate_many(hammer(0.7837), start, modes=0)
    found = (many.label[0], many.impacts[0], many.first[0], many.cycle_impacts[0])
    assert found == ("chatter/5", motion.impacts, motion.cycle.first, motion.cycle.impacts)


def test_of_several_releases_in_a_period():
    load = Load.fourier([0.5, 0.3, 1.0])  # it begins to pull twice in a period
    for restitution in (0.0, 0.1, 0.35):
        motion = run(System(5.0, 0.05, restitution, load), Start.rigid(), modes=2)
        assert motion.outcome == "periodic" and motion.label.split("/")[0] in ("chatter", "rest")
        released = motion.events.of("release")
        same = released.phase == released.phase[-1]
        assert motion.cycle.periods in np.diff(released.period[same])
        assert len(released) <= 6


# p = 0.34688 + cos t, R = 0.6: between two rests the bar bounces for a hundred periods, and errors grow on the way
LONG = 0.34688


@pytest.mark.parametrize("shift", [0.0, 1e-15, 2e-15, 3e-15])
def test_a_period_that_hangs_on_rounding_is_not_stated(shift):
    motion = run(System(20.0, 1e-9, 0.6 + shift, Load.harmonic(LONG, 1.0)), Start.rigid(), modes=0)
    assert (motion.label, motion.cycle, motion.period_unresolved) == ("chatter/?", None, True)
    first, second = motion.events.of("release").phase[-2:]
    assert (motion.outcome, first) == ("unresolved", second)
    assert "rounding" in label_sentence(motion)
    many = simulate_many(motion.system, Start.rigid(), modes=0)
    assert many.label.tolist() == ["chatter/?"] and many.impacts[0] == motion.impacts
    assert many.outcome.tolist() == ["unresolved"]
    on = run(motion.system, Start.rigid(), modes=0, stop=Stop(periodic=False))
    assert (on.outcome, on.impacts, on.period_unresolved) == ("impacts", 2000, True)


def test_a_period_that_is_stated_does_not_hang_on_rounding():
    rng = np.random.default_rng(7)
    stated = 0
    for _ in range(25):
        restitution, mean = rng.uniform(0.2, 0.8), rng.uniform(0.15, 0.8)
        near = [
            run(System(5.0, 0.003, r, Load.harmonic(mean, 1.0)), Start.rigid(), modes=0, stop=Stop(impacts=1500))
            for r in restitution * (1.0 + np.array([0.0, 1e-15, 1e-14, 1e-13]))
        ]
        if near[0].cycle is not None and near[0].cycle.kind:
            stated += 1
            assert len({motion.label for motion in near}) == 1, (restitution, mean)
            assert not near[0].period_unresolved
    assert stated > 8


@pytest.mark.parametrize(("modes", "stated"), [(0, True), (8, False), (32, False)])
def test_the_verdict_is_that_of_the_neighbours(modes, stated):
    # R moved by some ulps, and the release followed to the next rest: the same cycle, or another one each time
    near = 0.8 * (1.0 - np.array([0.0, 1e-15, 1e-14, 1e-13]))
    found, start = [], Start.rigid(0.0, 0.0, math.acos(-0.7837))  # where the load begins to pull
    for restitution in near:
        motion = run(hammer(0.7837, restitution), start, modes=modes, stop=Stop(impacts=1500, time=800 * TURN))
        released = motion.events.of("release").period
        found.append(int(released[1] - released[0]) if released.size > 1 else None)
        if stated:
            assert motion.label == "chatter/5"
        else:
            assert motion.label == ("chatter/?" if motion.period_unresolved else "aperiodic")
            assert motion.period_unresolved == (motion.outcome == "unresolved")
    assert (len(set(found)) == 1) == stated, found


def test_going_on_keeps_the_verdict(tmp_path):
    for system, impacts in ((hammer(0.7837), 2400), (System(20.0, 1e-9, 0.6, Load.harmonic(LONG, 1.0)), 900)):
        stop = Stop(impacts=impacts, periodic=False)
        whole = run(system, modes=0, stop=stop)
        for part in (impacts - 100, impacts - 30):
            first = run(system, modes=0, stop=Stop(impacts=part, periodic=False))
            first.save(tmp_path / "part.nc")
            again = Trajectory.load(tmp_path / "part.nc").continued(stop)
            assert (again.label, again.cycle, again.period_unresolved) == (
                whole.label, whole.cycle, whole.period_unresolved,
            )  # fmt: skip
            assert all(again.snapshot[name].tobytes() == whole.snapshot[name].tobytes() for name in ("now", "sums"))


def test_a_file_of_an_older_version_is_refused(tmp_path):
    dataset = run(hammer(0.95), modes=0, stop=Stop(impacts=3)).to_xarray()
    dataset.attrs |= {"format": "percuss trajectory 1", "percuss_version": "0.1"}
    dataset.to_netcdf(tmp_path / "old.nc", engine="h5netcdf")
    with pytest.raises(PercussError, match=r"written by percuss 0\.1.*from its start"):
        Trajectory.load(tmp_path / "old.nc")


@pytest.mark.parametrize("restitution", [0.0, 0.5])
def test_a_start_at_a_step_within_rounding_is_released_once(restitution):
    """A bar at rest on the wall, its clock one digit before the step that pulls: not laid down between."""
    load = Load.steps([0.0, 1.1, 2.0], [0.5, -0.7, 0.3])
    start = Start.rigid(0.0, 0.0, float(np.nextafter(1.1, 0.0)))
    motion = run(System(1.0, 0.0, restitution, load), start, modes=0, stop=Stop(impacts=3, periodic=False))
    assert motion.events.kind[:2].tolist() == ["release", "impact"]


# -- cycles with rest, chain by chain ----------------------------------------------------------------------------------


FOLLOWED = 3  # load periods followed


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
        swing = ForcedResponse(system, modes)
        chain = RestSearch(swing, release, release + TURN * FOLLOWED).chain()
    except ResonanceError:
        return
    motion = followed(system, modes, release, len(chain.impacts) + 400)
    events = motion.events[int(np.flatnonzero(motion.events.kind == "release")[0]) :]
    assert events.time[0] == pytest.approx(chain.release, rel=0, abs=1e-12)
    room = told(chain, RestSearch(swing, release + 1e-11, release + TURN * FOLLOWED).chain())
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


@pytest.mark.parametrize(("seed", "modes"), [(1, 4), (8, 8), (31, 4)])
def test_attractors_that_are_always_let_go_at_once_are_found(seed: int, modes: int) -> None:
    """Ringing lays the bar down while the load pulls: no phase of the load is that of its release."""
    system = random_hammer(seed).system
    motion = run(system, Start.rigid(0.0, -1.0, 0.3), modes=modes)
    (cycle,) = rest_cycles(system, modes=modes, most=4)
    assert motion.label == cycle.label and system.load.value(cycle.release_phase) < 0.0
    events = motion.events
    releases = events.phase[events.kind == "release"]
    assert releases[-1] == pytest.approx(cycle.release_phase, rel=0, abs=1e-8)
    struck = events.of("impact")
    fast = cycle.speeds > 1e-3
    number = int(fast.sum())
    since = int(np.flatnonzero(struck.time < events.time[events.kind == "release"][-2])[-1]) + 1
    assert struck.impact_velocity[since : since + number] == pytest.approx(cycle.speeds[fast], rel=0, abs=1e-7)
    off = releases - cycle.release_phase
    last = np.flatnonzero(np.abs(off) > 1e-6)[-1]
    assert off[last + 1] / off[last] == pytest.approx(cycle.remembered[0].real, abs=1e-3)
    assert cycle.stable and cycle.multipliers().values[0] == cycle.remembered[0]
    balance = motion.energy_balance(events.time[-1] - 2.0 * cycle.period)
    assert balance.input == pytest.approx(2.0 * cycle.energy.input, rel=1e-6)
    with pytest.raises(ParameterError, match="always let go at once"):
        cycle.follow("restitution")
