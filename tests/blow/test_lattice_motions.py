"""Periods of the load by waves: against what is known of short blows and of rock, and what every motion must keep."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from machine_cases import DRIFTER, TURN, S, bar, rod_for, settled, uniform
from percuss import Load, System, Timed, timed_states
from percuss.blow import Rock, Rod, Wall, effective_blow, strike
from percuss.blow.kernels.lattice_motion import follow
from percuss.blow.periods import run_by_waves
from percuss.blow.periods.lattice import machine_record
from percuss.blow.periods.wave_motion import LatticeRun
from percuss.errors import ParameterError
from percuss.model import Bar, Kept, Section, SectionedBar
from percuss.model.body import External, KelvinVoigt, Ratio, SteppedBar
from percuss.simulate import Start, Stop

# -- periods of the load by waves: against what is known of blows that are short, and what every motion must keep


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
    assert motion.outcome == "interrupted"
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


# -- tools on rock, or with a free end, in a machine by waves: single blows against exact pieces, then whole motions


PISTON = SectionedBar([Section(0.1, area=12e-4), Section(0.2, area=16e-4)])
BIT = (Section(0.6, area=12e-4), Section(0.2, area=30e-4))
ONE = Section(1.0, area=20e-4)
RODS = {
    "no mass": Rod([ONE], "rock", rock=Rock(3e8, 0.3)),
    "a bit of 2 kg": Rod([ONE], "rock", bit_mass=2.0, rock=Rock(3e8, 0.3)),
    "a bit that swings": Rod([ONE], "rock", bit_mass=2.0, rock=Rock(3e9, 0.5)),
    "two sections and a gap": Rod(BIT, "rock", bit_mass=0.5, rock=Rock(6e8, 0.5, gap=2e-4)),
    "elastic, struck twice": Rod(BIT, "rock", rock=Rock(6e9, 1.0)),
    "hard, plastic, struck again": Rod(BIT, "rock", bit_mass=0.1, rock=Rock(2e9, 0.1)),
    "free": Rod([Section(0.6, area=12e-4)], "free", bit_mass=0.3),
}
WINDOW, SPEED = 4e-3, 10.0


def hammer(bar, load):
    return System.from_si(bar, load, Kept(0.5))


def blow_on_the_lattice(rod, cells=400):
    """The contacts of one blow on the lattice, within the window, as the record has them; the course and its system."""
    system = hammer(PISTON, Load.harmonic(0.0, 0.0, frequency=40.0))
    machine = machine_record(system, rod, cells, pushed_back=rod.end == "free", quiet=False)[1]
    course = LatticeRun(machine, 1e-3, SPEED / system.speed_scale)
    follow(machine, course.now, course.count, course._log, int(WINDOW / system.time_scale / machine.step))
    return course, system


@pytest.mark.parametrize("name", RODS)
def test_a_blow_is_that_of_exact_pieces(name):
    """Impulses, times, penetration and the work that the rock keeps, as `strike` has them without a lattice."""
    rod = RODS[name]
    exact = strike(PISTON, rod, SPEED, until=WINDOW)
    course, system = blow_on_the_lattice(rod)
    found, momentum = course.contacts, system.energy_scale / system.speed_scale
    assert len(found) == len(exact.contacts)
    for one, other in zip(found, exact.contacts, strict=True):
        assert one["impulse"] * momentum == pytest.approx(other.impulse, abs=2e-5 * exact.impulse)
        assert (one["start"] - found["start"][0]) * system.time_scale == pytest.approx(other.start, abs=1e-6)
    if rod.rock is not None:
        residual = (1.0 - rod.rock.unloading_ratio) * float(course.now["greatest"][0]) * system.length_scale
        assert residual == pytest.approx(exact.residual_penetration, rel=3e-4, abs=1e-12)
        kept = 0.5 * rod.rock.stiffness * residual**2 / max(1.0 - rod.rock.unloading_ratio, 1e-9)
        assert course.rock_work * system.energy_scale == pytest.approx(kept, rel=1e-6, abs=1e-9)


def test_the_ends_of_stiffness():
    """Rock that hardly yields is a fixed end, rock that hardly resists a free one."""
    fixed, free = Rod([ONE], "fixed"), Rod([ONE], "free")
    hard, soft = (Rod([ONE], "rock", rock=Rock(k, 1.0)) for k in (1e14, 1.0))
    for one, other in ((hard, fixed), (soft, free)):
        a, b = (blow_on_the_lattice(rod, 100)[0].contacts["impulse"] for rod in (one, other))
        assert a == pytest.approx(b, rel=1e-4)


def fed_machine(frequency, rod, advance=True, amplitude=16e3):
    """A uniform piston by waves from the phase of B77, ringing ended; its law of the blow; their steady motion."""
    bar = Bar(0.3, 16e-4)
    blow = effective_blow(bar, rod)
    system = System.from_si(bar, Load.harmonic(6e3, amplitude, frequency=frequency), Kept(blow.restitution))
    assert blow.duration is not None and blow.centroid is not None and blow.contacts == 1
    law = Timed(blow.restitution, blow.duration / system.time_scale, blow.centroid / system.time_scale)
    a = blow.advance / system.time_scale / law.impulse(1.0, 0.0) if advance else 0.0
    law = Timed(law.restitution, law.duration, law.force_centroid, a)
    orbit = timed_states(system, law).orbits[-1]
    start = Start.rigid(0.0, orbit.rebound_velocity, orbit.phase)
    motion = run_by_waves(system, rod, start, cells=100, quiet=True, pushed_back=not advance, estimate=False)
    return motion, orbit


@pytest.mark.parametrize(
    ("frequency", "bit_mass", "ratio"), [(40.0, 0.0, 0.3), (80.0, 0.0, 0.3), (80.0, 2.0, 0.05), (160.0, 0.0, 0.3)]
)
def test_a_drill_that_is_fed_strikes_when_the_law_of_its_blow_says(frequency, bit_mass, ratio):
    """One contact: b77-blow with the residual penetration as its advance; B77 is early by up to 0.06 rad."""
    motion, orbit = fed_machine(frequency, Rod([ONE], "rock", bit_mass=bit_mass, rock=Rock(3e8, ratio)))
    assert motion.label == "z=1/1"
    assert motion.phases[0] == pytest.approx(orbit.phase, abs=3e-5)
    assert orbit.phase_shift > 0.015
    assert motion.velocities[0] == pytest.approx(orbit.rigid_velocity, rel=1e-6)
    assert motion.settled.fed[0] == pytest.approx(orbit.advance, rel=1e-3)


def test_a_tool_pushed_back_strikes_at_b77s_phase():
    motion, orbit = fed_machine(80.0, Rod([ONE], "rock", rock=Rock(3e8, 0.3)), advance=False)
    assert motion.phases[0] == pytest.approx(orbit.phase_b77, abs=5e-6)
    assert motion.settled.fed[0] == 0.0
    assert motion.settled.rock_work[0] > 0.0
    free, orbit = fed_machine(80.0, Rod([Section(1.0, area=20e-4)], "free"), advance=False)
    assert free.phases[0] == pytest.approx(orbit.phase_b77, abs=5e-6)
    assert free.rock_power == 0.0


@given(
    sections=st.lists(st.tuples(st.floats(0.1, 1.5), st.floats(3e-4, 5e-3)), min_size=1, max_size=3),
    stiffness=st.floats(6.0, 11.0).map(lambda x: 10.0**x),
    ratio=st.floats(0.02, 1.0),
    bit_mass=st.sampled_from([0.0, 1e-3, 0.5, 10.0]),
    gap=st.sampled_from([0.0, 1e-4]),
    pushed_back=st.booleans(),
    amplitude=st.floats(5e3, 3e4),
)
@settings(max_examples=12)
def test_what_every_motion_on_rock_keeps(sections, stiffness, ratio, bit_mass, gap, pushed_back, amplitude):
    """Energy closes; the rock keeps less than the tool is given; the tool is fed forward, or not at all."""
    rod = Rod(
        [Section(length, area=area) for length, area in sections],
        "rock",
        bit_mass=bit_mass,
        rock=Rock(stiffness, ratio, gap),
    )
    system = hammer(PISTON, Load.harmonic(6e3, amplitude, frequency=60.0))
    limits = Stop(time=12.0 * np.pi, tolerance=1e-6)
    motion = run_by_waves(system, rod, Start.rigid(-0.1), limits, cells=40, pushed_back=pushed_back, estimate=False)
    impacts = motion.impacts
    assert motion.energy.error < 1e-11
    assert np.all(impacts.impulse > 0.0)
    assert np.all(impacts.start[1:] >= impacts.end[:-1])
    slack = 1e-3 * np.sum(impacts.given)
    assert np.all((impacts.rock_work >= 0.0) & (impacts.rock_work <= impacts.given + slack))
    assert np.all(impacts.fed >= 0.0)
    if pushed_back or ratio == 1.0:
        assert np.all(impacts.fed == 0.0)
    # ½ (1 − γ) K u_m² and (1 − γ) u_m are of one u_m
    elif impacts.size:
        scale = system.energy_scale / system.length_scale**2
        work = 0.5 * stiffness / scale / (1.0 - ratio) * impacts.fed**2
        assert impacts.rock_work == pytest.approx(work, rel=2e-2, abs=1e-12 * impacts.given.max())


def test_a_striker_that_lies_on_its_tool_leaves_it_where_the_load_presses_it():
    """Pressed for good, the tool is never fed; the penetration is not less than that of the load at rest."""
    system = hammer(PISTON, Load.harmonic(2e4, 1e3, frequency=60.0))
    rod = RODS["no mass"]
    course = LatticeRun(machine_record(system, rod, 40, pushed_back=False, quiet=False)[1], 0.0, 0.01)
    for _ in range(20):
        for _ in course.period():
            pass
    assert course.touching
    pressed = float(course.now["greatest"][0]) * system.length_scale
    assert 2e4 / 3e8 * 0.99 <= pressed < 10 * 2e4 / 3e8


DRILL = hammer(PISTON, Load.harmonic(6e3, 1e4, frequency=40.0))
PLAIN = uniform(10.0, LOAD)
ROCKY = {"end": "rock", "rock": Rock(1e8)}


@pytest.mark.parametrize(
    ("system", "target", "wrong", "says"),
    [
        (DRILL, Rod([ONE], "free"), {}, "nothing else brings back"),
        (DRILL, Rod([ONE, ONE], **ROCKY, joint_masses=[(1, 2.0)]), {}, "short section"),
        (DRILL, Rod([ONE, Section(None, area=1e-3)], joint_masses=[(1, 2.0)]), {}, "short section"),
        (PLAIN, Rod([ONE], **ROCKY), {}, "of_impedance"),
        (PLAIN, Rod([Section(None, area=1e-3)]), {}, "of_impedance"),
        (PLAIN, 3.0, {}, "target"),
        *((PLAIN, Wall(), {name: 3}, name) for name in ("start", "stop", "cells", "quiet", "progress")),
    ],
)
def test_what_cannot_be_followed_is_refused(system, target, wrong, says):
    with pytest.raises(ParameterError, match=says):
        run_by_waves(system, target, **wrong)
