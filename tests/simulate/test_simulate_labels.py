"""What a motion is called, and what is told of it."""

import numpy as np
import pytest

from percuss import Bar, Kept, Load, System, steady_states
from percuss.case import load_case, simulation_answer
from percuss.case.answers.simulation_answer import motion_report
from percuss.simulate import MotionCycle, Start, Starts, Stop, run, simulate_many
from percuss.stability import floquet_multipliers

TURN = 2.0 * np.pi


def rigid(restitution, mean, amplitude=1.0, harmonic=1, d=0.0):
    return System(s=1.0, d=d, restitution=restitution, load=Load.harmonic(mean, amplitude, harmonic))


@pytest.mark.parametrize(
    ("periods", "mean", "damping"), [(1, 0.95, 0.01), (2, 0.9, 0.01), (3, 0.7, 0.01), (4, 0.5, 0.01)]
)
def test_one_impact_in_some_periods(periods, mean, damping):
    system = System(s=6.0, d=damping, restitution=0.8, load=Load.harmonic(mean, 1.0))
    labels = set()
    for orbit in steady_states(system, periods, modes=4).orbits:
        if not (orbit.admissible and floquet_multipliers(orbit, 4).largest < 1.0):
            continue
        motion = run(system, Start.orbit(orbit, velocity=[-1e-4]), modes=4, stop=Stop(impacts=20_000))
        labels.add(motion.label)
        assert motion.outcome == "periodic"
        assert motion.summary.blow_rate == pytest.approx(1.0 / periods, rel=1e-9)
        assert motion.summary.interval_std < 1e-6
    assert labels == {f"z=1/{periods}"}


def test_more_impacts_in_a_period():
    # three equal pushes a period: an impact each time, the same state, but a load period only after three
    phase = (np.pi - np.arcsin(0.9 * np.pi / 4.0)) / 3.0
    motion = run(rigid(0.6, 0.9, harmonic=3), Start.rigid(0.0, -0.715, phase), modes=0)
    assert (motion.label, motion.outcome) == ("z=3/1", "periodic")
    assert motion.summary.blow_rate == pytest.approx(3.0, rel=1e-9)
    assert motion.summary.interval_std < 1e-7


@pytest.mark.parametrize(
    ("restitution", "ratio", "impacts"), [(0.5, 1.6, 2), (0.5, 1.68, 4), (0.5, 1.7, 8), (0.8, 1.25, 8)]
)
def test_several_impacts_in_as_many_periods(restitution, ratio, impacts):
    motion = run(rigid(restitution, 1.0, ratio), near_orbit(restitution, ratio), modes=0, stop=Stop(impacts=20_000))
    assert motion.label == f"z={impacts}/{impacts}"
    cycle = motion.events.phase[-impacts:]
    assert np.ptp(cycle) > 1e-3
    assert motion.events.phase[-2 * impacts : -impacts] == pytest.approx(cycle, abs=1e-8)


def near_orbit(restitution, ratio):
    """A start near the motion of one impact a period, B77 (35)."""
    sine = np.pi / ratio * (1.0 - restitution) / (1.0 + restitution)
    return Start.rigid(0.0, -1.02 * TURN * restitution / (1.0 + restitution), np.pi - np.arcsin(sine))


def test_negative_multiplier_is_no_doubling():
    # R = 0.5 doubles at 1.526824: just below, the multiplier is near −1 and every other return is the nearer one
    for ratio in (1.40, 1.48, 1.515, 1.524):
        for tolerance in (1e-9, 1e-6, 1e-4):
            stop = Stop(impacts=30_000, tolerance=tolerance)
            assert run(rigid(0.5, 1.0, ratio), near_orbit(0.5, ratio), modes=0, stop=stop).label == "z=1/1"


def test_a_chatter_cycle():
    system = rigid(0.4, 0.7)
    motion = run(system, Start.rigid(time=0.3), modes=0, stop=Stop(impacts=3000))
    assert motion.label.startswith("chatter/") and motion.outcome == "periodic"
    cycle = motion.cycle
    assert cycle.kind == 2 and cycle.impacts > 5
    summary = motion.summary
    assert summary.blow_rate == pytest.approx(cycle.impacts / cycle.periods, rel=1e-9)
    assert np.ptp(motion.events.of("release").phase) < 1e-14
    main = motion.main_blows
    struck = motion.events.of("impact").time
    last = struck[-1]
    inside = (struck > last - cycle.periods * TURN + 1e-6) & (struck <= last + 1e-9)
    assert np.count_nonzero(inside) == cycle.impacts
    assert summary.main_blow_rate == pytest.approx(np.count_nonzero(main[inside]) / cycle.periods, rel=1e-6)
    assert summary.main_blow_rate < 0.5 * summary.blow_rate


def test_a_chatter_cycle_does_not_depend_on_the_tolerance():
    system = System(s=20.0, d=0.0048, restitution=0.6, load=Load.harmonic(0.9, 1.0))
    cycles = set()
    for tolerance in (1e-4, 1e-6, 1e-9):
        motion = run(system, Start.rigid(time=0.3), modes=8, stop=Stop(tolerance=tolerance))
        assert motion.label == "chatter/1"
        cycles.add(motion.cycle.impacts)
    assert len(cycles) == 1


def test_a_rest_cycle():
    motion = run(rigid(0.0, 0.4), Start.rigid(time=0.3), modes=0)
    assert motion.label.startswith("rest/") and motion.outcome == "periodic"
    assert motion.cycle.kind == 1
    assert motion.summary.blow_rate == pytest.approx(motion.cycle.impacts / motion.cycle.periods, rel=1e-9)


def test_rest_and_departed():
    assert run(rigid(0.5, 2.0), modes=0).label == "rest"
    assert run(rigid(0.5, -0.2), modes=0).label == "departed"
    assert run(rigid(0.5, 0.0, 0.0 + 1e-3), Start.rigid(-1.0, -0.5), modes=0).label == "departed"
    assert run(rigid(0.5, -2.0), Start.rigid(0.0), modes=0).label == "departed"


def test_aperiodic_and_undecided():
    system = rigid(0.5, 1.0, 1.75)
    chaotic = run(system, near_orbit(0.5, 1.75), modes=0, stop=Stop(impacts=20_000))
    assert chaotic.label == "aperiodic" and chaotic.outcome == "impacts" and chaotic.cycle is None
    short = run(system, near_orbit(0.5, 1.75), modes=0, stop=Stop(impacts=20))
    assert short.label == "undecided"
    # no losses and a constant load: it comes back, but there is no load period to count by
    ball = run(System(s=1.0, d=0.0, restitution=1.0, load=Load.fourier([1.0])), modes=0, stop=Stop(impacts=500))
    assert ball.label == "undecided" and ball.impacts == 500


def test_transient_and_tolerance():
    system = System(s=20.0, d=0.0048, restitution=0.6, load=Load.harmonic(0.9, 1.0))
    start = Start.orbit(steady_states(system, modes=8).orbits[1], velocity=[-0.02])
    transients = []
    for tolerance in (1e-4, 1e-7, 1e-10):
        motion = run(system, start, modes=8, stop=Stop(tolerance=tolerance))
        assert motion.label == "z=1/1"
        transients.append(motion.transient)
        phase = motion.events.phase
        assert np.abs(phase[motion.transient :] - phase[-1]).max() < 30.0 * tolerance
    assert transients == sorted(transients) and transients[0] < transients[-1]
    on = run(system, start, modes=8, stop=Stop(impacts=700, periodic=False))
    assert (
        on.impacts == 700
        and on.outcome == "impacts"
        and on.label == "z=1/1"
        and on.cycle == MotionCycle(on.cycle.first, 1, 1, 0)
    )


def test_summary_of_whole_cycles():
    system = rigid(0.5, 1.0, 1.6)  # between the doublings
    motion = run(system, Start.rigid(0.0, -2.2, 2.4), modes=0, stop=Stop(impacts=3001, periodic=False))
    assert motion.label == "z=2/2"
    summary = motion.summary
    assert (summary.last - summary.first) % 2 == 0
    hits = motion.events.of("impact")
    assert summary.interval_mean == pytest.approx(TURN, rel=1e-12)
    assert summary.interval_std == pytest.approx(np.diff(hits.time[-3:]).std(), rel=1e-5)
    assert summary.impact_velocity == pytest.approx(hits.impact_velocity[-2:].mean(), rel=1e-8)
    assert summary.energy_lost_per_period == pytest.approx(hits.energy_lost[-2:].mean(), rel=1e-8)


def test_summary_in_si():
    bar = Bar(length=0.5, diameter=0.05)
    system = System.from_si(bar, Load.harmonic(700.0, 1000.0, frequency=40.0), Kept(restitution=0.5))
    orbit = steady_states(system, modes=4).orbits[1]
    motion = run(system, Start.orbit(orbit, velocity=[-1e-5]), modes=4, stop=Stop(impacts=4000))
    assert motion.outcome == "periodic"
    summary, si = motion.summary, motion.summary.si
    assert si.blow_rate_Hz == pytest.approx(40.0 * summary.blow_rate)
    assert si.impact_velocity_m_s == pytest.approx(summary.impact_velocity * system.speed_scale)
    assert si.blow_energy_J == pytest.approx(0.5 * bar.mass * si.impact_velocity_m_s**2, rel=0.02)
    assert si.delivered_power_kW == pytest.approx(1e-3 * si.delivered_energy_J * si.blow_rate_Hz, rel=1e-6)


# -- main blows --------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def jackleg():
    case = load_case("pneumatic-jackleg").varied({"load.amplitude": "5.23 bar"})  # nearer to the fold: it rests
    bar = case.system().bar
    drag = 2e-5 * np.pi * bar.wave_speed * bar.pieces[0].mass / bar.length**2
    b77 = {"bar.damping_ratio": None, "bar.drag": f"{drag!r} N*s/m^2", "contact.strain": "kept"}
    return simulation_answer(case.varied(b77))


def bounces(motion):
    """Which impacts are bounces, by the definition: loops, the load on a fine grid, nothing of the package's own."""
    kinds, times = motion.events.kind.tolist(), motion.events.time
    unfelt = 1.0 / motion.system.s if motion.modes else 0.0  # a wave needs that long from the load to the wall
    struck = [i for i, kind in enumerate(kinds) if kind == "impact"]
    bounce = dict.fromkeys(struck, False)
    for end in (i for i, kind in enumerate(kinds) if kind == "chatter"):
        row = []
        for i in reversed([i for i in struck if i < end]):
            row.insert(0, i)
            if kinds[i - 1] != "impact":
                break
        for k in range(len(row) - 1, 0, -1):
            flight = times[row[k]] - times[row[k - 1]]
            pulled = np.any(motion.system.load.value(np.linspace(times[row[k - 1]], times[row[k]], 2001)) < -1e-9)
            pulled = pulled and flight >= unfelt
            longer = k == 1 or flight < times[row[k - 1]] - times[row[k - 2]]
            if pulled or not longer:
                break
            bounce[row[k]] = True
    return np.array(list(bounce.values()))


def test_two_strong_blows_before_one_rest(jackleg):
    # 7.46 and 7.03 m/s in successive periods of 33 Hz, then chatter: 33 main blows a second
    motion, si = jackleg.motion, jackleg.summary.si
    assert motion.label == "chatter/2"
    assert si.main_blow_rate_Hz == pytest.approx(33.0, rel=1e-6)
    assert si.cycle_velocities_m_s == pytest.approx([7.464, 7.030], abs=2e-3)
    assert si.impact_velocity_m_s == pytest.approx(7.247, abs=2e-3)
    half = 0.5 * jackleg.system.bar.mass
    energies = [half * v * v for v in si.cycle_velocities_m_s]
    assert si.cycle_energies_J == pytest.approx(energies, rel=0.01)  # next to rigid
    assert si.blow_energy_J == pytest.approx(np.mean(energies), rel=0.01)
    # what is delivered in a period: all that the two blows lose and what their bounces have left, next to all of it
    assert si.delivered_energy_per_period_J == pytest.approx(np.mean(energies), rel=0.02)
    assert si.delivered_power_kW == pytest.approx(1e-3 * 33.0 * si.delivered_energy_per_period_J, rel=1e-6)


def test_report_and_json_tell_of_the_main_blows(jackleg):
    report = motion_report(jackleg, 0)
    assert "7.464 m/s and 7.03 m/s" in report.summary and "33 main blows/s" in report.summary
    rows = dict(report.sections[2].rows)
    assert rows["striking speed"].startswith("7.464 m/s and 7.03 m/s")
    assert "per load period" in rows["taken"]
    tree = jackleg.to_json_dict()["summary"]
    assert len(tree["si"]["cycle_velocities_m_s"]) == len(tree["cycle_energies"]) == 2


@pytest.mark.parametrize("load", [Load.harmonic(0.4, 1.0), Load.harmonic(0.7, 1.0), Load.fourier([0.2, 0.4, 1.0j]),
                                  Load.square(1.0, 1.4)])  # fmt: skip
@pytest.mark.parametrize("restitution", [0.15, 0.5, 0.8])
def test_which_impacts_are_main_blows(load, restitution):
    system = System(s=20.0, d=0.02, restitution=restitution, load=load)
    motion = run(system, Start.rigid(), modes=0, stop=Stop(impacts=300, periodic=False))
    assert np.array_equal(motion.main_blows, ~bounces(motion))
    # the first blow after each release is one
    kinds = motion.events.kind
    struck = np.flatnonzero(kinds == "impact")
    fresh = kinds[np.maximum(struck - 1, 0)] == "release"
    assert np.all(motion.main_blows[fresh])


@pytest.mark.parametrize("modes", [1, 8, 32])
@pytest.mark.parametrize("damping", [3e3, 1e4, 1e5, 1e6])
def test_bounces_of_a_strained_bar_under_a_pull(damping, modes):
    # a strongly damped bar gives its strain back long after the load has begun to pull: it bounces under the pull
    system = System(20.0, damping, 0.5, Load.harmonic(0.3, 1.0))
    start = Start.rigid(-1e-7, 0.0, 0.0)
    motion = run(system, start, modes=modes, stop=Stop(impacts=300, periodic=False))
    assert np.array_equal(motion.main_blows, ~bounces(motion))
    # far fewer main blows than impacts; each bounce near the end has R of the speed of the one before
    chatters = motion.events.of("chatter").resolved
    assert np.all(chatters > 10)
    ended = motion.events.of("impact").time <= motion.events.of("chatter").time[-1]  # the last row is still open
    assert np.count_nonzero(motion.main_blows[ended]) <= 2 * len(chatters) + 2
    speeds, main = motion.events.of("impact").impact_velocity, motion.main_blows
    quick = np.flatnonzero(~main[1:]) + 1
    assert np.all(speeds[quick] < 0.51 * speeds[quick - 1])
    settled = run(system, start, modes=modes, stop=Stop(impacts=2000))
    many = simulate_many(system, start, modes=modes, stop=Stop(impacts=2000))
    assert settled.label == many.label[0] and settled.label.startswith("chatter/")
    assert many.main_blow_rate[0] == pytest.approx(settled.summary.main_blow_rate, rel=1e-6)
    if modes > 1:
        assert settled.label == "chatter/1"
        assert settled.summary.main_blow_rate == pytest.approx(1.0, rel=1e-8)
        whole = run(system, start, modes=modes, stop=Stop(time=400.0, impacts=5000, periodic=False))
        released = whole.events.of("release").time
        assert np.diff(released)[-5:] == pytest.approx(TURN, abs=1e-6)


@pytest.mark.parametrize("restitution", [0.0, 0.15, 0.4])
def test_figures_of_one_and_of_many(restitution):
    system = System(s=20.0, d=0.0174, restitution=restitution, load=Load.harmonic(0.3977, 1.0))
    starts = Starts.random(system, 12, seed=2)
    many = simulate_many(system, starts, modes=2, stop=Stop(impacts=600))
    cycles = 0
    for i, start in enumerate(starts):
        motion = run(system, start, modes=2, stop=Stop(impacts=600))
        assert many.label[i] == motion.label
        if motion.cycle is None:
            continue
        cycles += 1
        summary = motion.summary
        for name in ("impact_velocity", "blow_energy", "main_blow_rate", "energy_lost_per_period"):
            assert getattr(many, name)[i] == pytest.approx(getattr(summary, name), rel=1e-6), name
        if summary.cycle_velocities is not None:
            assert len(summary.cycle_velocities) == round(summary.main_blow_rate * motion.cycle.periods)
            assert np.mean(summary.cycle_velocities) == pytest.approx(summary.impact_velocity, rel=1e-6)
            assert np.mean(summary.cycle_energies) == pytest.approx(summary.blow_energy, rel=1e-6)
    assert cycles > 3


def test_means_without_a_cycle():
    system = System(s=20.0, d=0.0, restitution=0.6, load=Load.harmonic(0.34688, 1.0))
    stop = Stop(impacts=800, periodic=False)
    motion = run(system, Start.rigid(), modes=0, stop=stop)
    many = simulate_many(system, Start.rigid(), modes=0, stop=stop, discard=400)
    assert motion.cycle is None and motion.summary.cycle_velocities is None
    main = motion.main_blows.copy()
    blows = motion.events.of("impact")[400:]
    assert many.impact_velocity[0] == pytest.approx(blows.impact_velocity[main[400:]].mean(), rel=1e-9)
    assert many.blow_energy[0] == pytest.approx(blows.kinetic_energy[main[400:]].mean(), rel=1e-9)
    assert motion.summary.impact_velocity > 1.5 * blows.impact_velocity.mean()
