"""Periods of the load by waves: against what is known of blows that are short, and what every motion must keep."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from machine_cases import DRIFTER, TURN, S, bar, rod_for, settled, uniform
from percuss import Load, System
from percuss.blow import Rod, Wall
from percuss.blow.periods import run_by_waves
from percuss.errors import ParameterError
from percuss.model.body import External, KelvinVoigt, Ratio, Section, SectionedBar, SteppedBar
from percuss.simulate import Start, Stop

LOAD = Load.harmonic(0.9, 1.0)
R = 0.6
RATIO = (1.0 + R) / (1.0 - R)


def phase_of(level):
    """Of the stable root of sin φ = level."""
    return math.pi - math.asin(level)


def rigid_level(advance_impedance=math.inf):
    """v_f(φ) = c − a/T of a uniform striker: e = 2 t_J − t_c = 0, a = J/Z_rod, J = p_0 T."""
    return 0.9 * math.pi * (1.0 - R) / (1.0 + R) - 0.9 / advance_impedance


@pytest.mark.parametrize(("s", "tolerance"), [(10.0, 6e-5), (20.0, 2e-5), (40.0, 5e-6)])
def test_a_uniform_machine_has_the_phase_of_its_finite_blow(s, tolerance):
    """The exact blow puts the phase at v_f = c − a/T, to the order s⁻²; b77's is off by 0.3/s."""
    system = uniform(s, LOAD)
    motion = settled(system, rod_for(system, RATIO), quiet=True)
    assert motion.label == "z=1/1"
    assert motion.phases[0] == pytest.approx(phase_of(rigid_level(s * RATIO)), abs=tolerance)
    assert abs(motion.phases[0] - phase_of(rigid_level())) == pytest.approx(0.317 / s, rel=0.03)
    assert motion.velocities[0] == pytest.approx(0.9 * TURN / (1.0 + R), rel=1e-4)
    assert motion.settled.restitution[0] == pytest.approx(R, abs=3e-5)
    assert motion.settled.duration[0] == pytest.approx(2.0 / s, rel=1e-3)


@pytest.mark.parametrize("s", [10.0, 40.0])
def test_a_rod_pushed_back_leaves_b77s_phase(s):
    """No advance from blow to blow: v_f(φ_J) = c, to the order s⁻²."""
    system = uniform(s, LOAD)
    motion = settled(system, rod_for(system, RATIO), quiet=True, pushed_back=True)
    assert motion.phases[0] == pytest.approx(phase_of(rigid_level()), abs=0.006 / s**2 * 10.0)


def test_the_drifter_machine_has_its_known_phase():
    """Three sections on a rod, s = 40, p = 0.66 + cos t (an independent program, ringing gone between blows)."""
    system = bar(40.0, *DRIFTER, load=Load.harmonic(0.66, 1.0))
    motion = settled(system, rod_for(system, 4.0), quiet=True, cells=400)
    assert motion.phases[0] == pytest.approx(2.12777, abs=4e-4)
    assert motion.phases[0] == pytest.approx(2.1280786383417226, abs=3e-4)  # b77-blow, first order in t_c/T
    assert motion.phases[0] - 2.1128830416367776 == pytest.approx(0.015, abs=1e-3)  # b77
    assert motion.uncertainty.phase < 4e-4


def test_the_error_of_a_phase_falls_as_the_square_of_the_cell():
    """Half the cells, four times the error or more, where no transit time is rounded (s = k/2π)."""
    system = uniform(4.0 * S, LOAD)
    found = [
        settled(
            system,
            rod_for(system, RATIO),
            quiet=True,
            cells=n,
            stop=Stop(time=400 * TURN, tolerance=1e-10),
            estimate=False,
        )
        for n in (20, 40, 80, 320)
    ]
    best = found[-1].phases[0]
    errors = [abs(motion.phases[0] - best) for motion in found[:-1]]
    assert errors[1] < 0.35 * errors[0]
    assert errors[2] < 0.35 * errors[1]
    assert errors[2] < 1e-6


@given(
    sections=st.lists(st.tuples(st.floats(0.3, 3.0), st.floats(0.2, 1.0)), min_size=1, max_size=3),
    s=st.floats(3.0, 15.0),
    ratio=st.one_of(st.none(), st.floats(0.4, 10.0)),
    p=st.lists(st.floats(-0.5, 0.5), min_size=3, max_size=3),
    damping=st.sampled_from([External(0.0), External(0.1), Ratio(3e-3), KelvinVoigt(1e-4)]),
    square=st.booleans(),
    pushed_back=st.booleans(),
)
@settings(max_examples=25)
def test_what_every_motion_keeps(sections, s, ratio, p, damping, square, pushed_back):
    """Momentum and energy close; faces only push; contacts come one after another; an impact takes no energy in."""
    impedances, times = zip(*sections, strict=True)
    load = Load.square(1.5, 1.2) if square else Load.fourier([0.4 + p[0], 1.0 + 1j * p[1], p[2]])
    system = bar(s, impedances, times, load=load, damping=damping)
    target = Wall() if ratio is None else rod_for(system, ratio)
    limits = Stop(time=6 * TURN, tolerance=1e-6)
    motion = run_by_waves(system, target, Start.rigid(-0.5), limits, cells=40, pushed_back=pushed_back, estimate=False)
    assert motion.energy.error < 1e-11
    assert motion.energy.damped >= 0.0
    assert motion.energy.given >= -1e-12
    assert (motion.energy.given == 0.0) == (ratio is None or not motion.impacts.size)
    impacts = motion.impacts
    assert np.all(impacts.impulse > 0.0)
    assert np.all(impacts.peak_force > 0.0)
    assert np.all(impacts.start[1:] >= impacts.end[:-1])
    assert np.all((impacts.start <= impacts.centroid) & (impacts.centroid <= impacts.end + 1e-12))
    if damping.rigid == 0.0 and impacts.size and not motion.touching:
        last = impacts.end[-1]
        to_last = load.mean * last + load.antiderivative(last) - load.antiderivative(0.0)
        assert impacts.mean_after[-1] == pytest.approx(to_last - impacts.impulse.sum(), abs=1e-4)


@pytest.mark.parametrize("damping", [External(0.0), Ratio(2e-3), KelvinVoigt(2e-5)])
def test_the_impulse_per_period_is_that_of_the_load(damping):
    system = uniform(20.0, LOAD, damping)
    motion = settled(system, rod_for(system, RATIO))
    assert motion.impulse_per_period == pytest.approx(0.9 * TURN, rel=1e-7)


def test_a_stronger_load_moves_everything_in_proportion():
    """Nothing but ratios of forces and speeds enters."""
    system = bar(10.0, *DRIFTER, load=Load.harmonic(0.66, 1.0), damping=Ratio(5e-3))
    twice = system.with_load(system.load.scaled(2.0))
    one = run_by_waves(
        system, rod_for(system, 4.0), Start.rigid(-1.0), Stop(time=8 * TURN, tolerance=1e-6), cells=60, estimate=False
    )
    other = run_by_waves(
        twice, rod_for(twice, 4.0), Start.rigid(-2.0), Stop(time=8 * TURN, tolerance=1e-6), cells=60, estimate=False
    )
    assert other.impacts.start == pytest.approx(one.impacts.start, abs=1e-9)
    assert other.impacts.impulse == pytest.approx(2.0 * one.impacts.impulse, rel=1e-9)


def test_a_section_cut_in_two_changes_nothing():
    load = Load.harmonic(0.66, 1.0)
    one, two = bar(10.0, (1.0, 2.0), (1.0, 1.0), load=load), bar(10.0, (1.0, 1.0, 2.0), (0.5, 0.5, 1.0), load=load)
    a, b = (settled(x, rod_for(x, 3.0), quiet=True, stop=Stop(time=400 * TURN, tolerance=1e-9)) for x in (one, two))
    assert a.phases == pytest.approx(b.phases, abs=1e-4)
    assert a.settled.restitution == pytest.approx(b.settled.restitution, abs=1e-4)


def test_a_start_nearby_ends_in_the_same_motion_and_a_shifted_load_shifts_it():
    system = uniform(20.0, LOAD)
    a = settled(system, rod_for(system, RATIO), Start.rigid(-2.0, 0.0, 0.3))
    b = settled(system, rod_for(system, RATIO), Start.rigid(-2.3, 0.2, 0.1))
    assert a.phases == pytest.approx(b.phases, abs=1e-5)
    turned = system.with_load(LOAD.shifted(0.8))
    c = settled(turned, rod_for(turned, RATIO), Start.rigid(-2.0, 0.0, 2.0 * math.pi - 0.5))
    assert c.phases + 0.8 == pytest.approx(a.phases, abs=1e-5)


def test_chatter_that_ends_in_rest_is_one_cycle():
    """From a gap of one length at rest this machine ends in chatter: the load presses for most of the period."""
    system = uniform(20.0, LOAD, Ratio(2e-3))
    motion = settled(system, rod_for(system, RATIO), Start.rigid(-1.0))
    assert motion.settled.duration.max() > 3.0
    assert motion.impulse_per_period == pytest.approx(0.9 * TURN, rel=1e-6)


def test_a_load_that_only_presses_ends_in_rest():
    system = uniform(10.0, Load.harmonic(1.0, 0.2), Ratio(0.01))
    motion = run_by_waves(system, Wall(), Start.rigid(-0.1), Stop(time=60 * TURN, tolerance=1e-6), cells=40)
    assert motion.label == "rest"
    assert motion.rests


def test_a_load_that_pulls_strikes_nothing():
    motion = run_by_waves(
        uniform(10.0, Load.harmonic(-0.2, 1.0)),
        Wall(),
        Start.rigid(-10.0),
        Stop(time=5 * TURN, tolerance=1e-6),
        cells=40,
    )
    assert motion.label == "none"
    assert motion.outcome == "time"
    assert math.isnan(motion.blow_rate)


def test_the_end_of_a_motion():
    system = uniform(10.0, LOAD)
    rod = rod_for(system, RATIO)
    motion = run_by_waves(system, rod, stop=Stop(impacts=3, periodic=False), cells=40)
    assert motion.outcome == "impacts"
    assert 3 <= motion.impacts.size < 12
    motion = run_by_waves(system, rod, stop=Stop(time=4 * TURN, periodic=False), cells=40)
    assert motion.end_time == pytest.approx(4.0 * TURN)
    seen = []
    motion = run_by_waves(system, rod, cells=40, progress=lambda p: seen.append(p) or len(seen) == 3)
    assert motion.outcome == "cancelled"
    assert [p.fraction for p in seen] == sorted(p.fraction for p in seen)


def test_a_machine_in_si_is_its_dimensionless_one():
    piston = SectionedBar([Section(0.2, area=1e-3), Section(0.3, area=2e-3)])
    load = Load.harmonic(6e3, 1e4, frequency=40.0)
    system = System.from_si(piston, load, uniform(1.0, LOAD).contact)
    area = 8e-3
    start, limits = Start.rigid(-0.05, 0.0, 0.3), Stop(time=3 * TURN, tolerance=1e-6)
    si = run_by_waves(system, Rod([Section(None, area=area)]), start, limits, cells=100)
    plain = System(system.body, system.load, system.contact)
    assert isinstance(plain.body, SteppedBar)
    same = run_by_waves(plain, rod_for(plain, area / 2e-3), start, limits, cells=100)
    assert si.impacts.size > 2
    assert si.impacts.start == pytest.approx(same.impacts.start, abs=1e-9)
    assert si.impacts.impulse == pytest.approx(same.impacts.impulse, rel=1e-6)
    assert 0.0 < si.delivered_power * system.power_scale < 1e5


def test_what_cannot_be_followed_is_refused():
    system = System.from_si(
        SectionedBar([Section(0.5, area=1e-3)]), Load.harmonic(6e3, 1e4, frequency=40.0), bar(1.0).contact
    )
    steel = Section(1.0, area=1e-3)
    with pytest.raises(ParameterError, match="short section"):
        run_by_waves(system, Rod([steel, Section(None, area=1e-3)], joint_masses=[(1, 2.0)]))
    with pytest.raises(ParameterError, match="of_impedance"):
        run_by_waves(uniform(10.0, LOAD), Rod([Section(None, area=1e-3)]))
    for wrong in ({"start": 3}, {"stop": 3}, {"cells": 3}, {"quiet": 1}, {"progress": 3}):
        with pytest.raises(ParameterError):
            run_by_waves(uniform(10.0, LOAD), Wall(), **wrong)
    with pytest.raises(ParameterError):
        run_by_waves(uniform(10.0, LOAD), 3.0)
