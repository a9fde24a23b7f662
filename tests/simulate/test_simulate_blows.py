"""Main blows: which impacts they are, and what is told of them."""

import numpy as np
import pytest

from percuss import Load, System
from percuss.case import load_case, simulation_answer
from percuss.case.answers.simulation_answer import motion_report
from percuss.simulate import Start, Starts, Stop, run, simulate_many

TURN = 2.0 * np.pi


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
