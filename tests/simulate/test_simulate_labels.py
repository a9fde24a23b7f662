"""What a motion is called, and what is told of it."""

import numpy as np
import pytest

from percuss import Bar, Kept, Load, System, steady_states
from percuss.simulate import MotionCycle, Start, Stop, run
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
