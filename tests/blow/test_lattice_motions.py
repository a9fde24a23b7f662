"""Periods of the load by waves: against what is known of short blows and of rock, and what every motion must keep."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from machine_cases import DRIFTER, TURN, S, bar, contacts_of_blow, followed, one_blow, rod_for, settled, uniform
from percuss import Load, System, Timed, timed_states
from percuss.blow import Rock, Rod, Wall, effective_blow, strike
from percuss.blow.kernels.lattice_motion import follow
from percuss.blow.periods import run_by_waves
from percuss.blow.periods.lattice import MOST_STEPS, lattice_of, load_means, machine_record
from percuss.blow.periods.wave_motion import LatticeRun
from percuss.errors import ParameterError
from percuss.model import Bar, Kept, Section, SectionedBar
from percuss.model.body import External, KelvinVoigt, Ratio, SteppedBar
from percuss.model.body.damping import UNDAMPED, Table
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


def supplied_machine(frequency, rod, advance=True, amplitude=16e3):
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
    motion, orbit = supplied_machine(frequency, Rod([ONE], "rock", bit_mass=bit_mass, rock=Rock(3e8, ratio)))
    assert motion.label == "z=1/1"
    assert motion.phases[0] == pytest.approx(orbit.phase, abs=3e-5)
    assert orbit.phase_shift > 0.015
    assert motion.velocities[0] == pytest.approx(orbit.rigid_velocity, rel=1e-6)
    assert motion.settled.fed[0] == pytest.approx(orbit.advance, rel=1e-3)


def test_a_tool_pushed_back_strikes_at_b77s_phase():
    motion, orbit = supplied_machine(80.0, Rod([ONE], "rock", rock=Rock(3e8, 0.3)), advance=False)
    assert motion.phases[0] == pytest.approx(orbit.phase_b77, abs=5e-6)
    assert motion.settled.fed[0] == 0.0
    assert motion.settled.rock_work[0] > 0.0
    free, orbit = supplied_machine(80.0, Rod([Section(1.0, area=20e-4)], "free"), advance=False)
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
        (PLAIN, Rod([ONE], **ROCKY), {}, "of_impedance"),
        (PLAIN, Rod([Section(None, area=1e-3)]), {}, "of_impedance"),
        (PLAIN, 3.0, {}, "target"),
        *((PLAIN, Wall(), {name: 3}, name) for name in ("start", "stop", "cells", "quiet", "progress")),
    ],
)
def test_what_cannot_be_followed_is_refused(system, target, wrong, says):
    with pytest.raises(ParameterError, match=says):
        run_by_waves(system, target, **wrong)


# -- flights and single blows on the lattice ---------------------------------------------------------------------------


# -- flights on the lattice: against modes in closed form under every law of damping; load means; the lattice itself


SECTIONS = (1.2, 2.0, 0.9), (0.2, 0.5, 0.3)
PUSH = Load.fourier([0.3, 1.0, 0.2j, 0.1])
COUNT = 10


def modal_velocities(course, body, count):
    """∫ φ_n v dm of what the cells hold."""
    chain, sections = course.machine.striker, body.sections
    velocity, mass, places = [], [], []
    for i, (first, n, slot) in enumerate(zip(chain.first, chain.cells, chain.slot, strict=True)):
        right, left = (np.roll(wave[first : first + n], -slot) for wave in (chain.right, chain.left))
        velocity.append(right[::-1] + left)
        mass.append(np.full(n, chain.impedance[i] * course.machine.step))
        places.append(sections.start[i] + sections.width[i] * (np.arange(n) + 0.5) / n)
    modes = body.modes(count)
    shapes = body.shapes(np.concatenate(places), count).displacement * modes.end
    return shapes.T @ (np.concatenate(mass) * np.concatenate(velocity))


def exact_velocities(body, load, time, count):
    """q_n' with q_n'' + d_n q_n' + ω_n² q_n = φ_n(0) p(t), from rest; the scale of each."""
    modes = body.modes(count)
    at_load = modes.at_load * modes.end
    k = np.append(0, load.harmonics)
    gains = load.coefficients[k] / modes.stiffness(k)
    waves = np.exp(1j * k * time)
    steady = (gains * 1j * k * waves).sum(axis=1).real
    place, speed = -gains.sum(axis=1).real, -(gains * 1j * k).sum(axis=1).real
    half = modes.damping / 2.0
    own = np.sqrt((modes.omega**2 - half**2).astype(complex))
    sine, cosine = (np.sin(own * time) / own).real, np.cos(own * time).real
    free = np.exp(-half * time) * (speed * (cosine - half * sine) - modes.omega**2 * place * sine)
    return at_load * (steady + free), np.abs(at_load).max() * np.abs(PUSH.coefficients).sum() / modes.omega[0]


@pytest.mark.parametrize(
    ("damping", "tolerance"),
    [
        (UNDAMPED, 5e-4),
        (External(0.1), 1e-3),
        (Ratio(2e-3), 4e-3),
        (KelvinVoigt(2e-5), 4e-3),
        (Table((0.1, 0.3, 0.2)), 4e-3),
    ],
)
def test_a_flight_is_that_of_the_damped_modes(damping, tolerance):
    """251 transit times long; the greatest error of ten modes over the amplitude that the start gives the first."""
    system = bar(20.0, *SECTIONS, load=PUSH, damping=damping)
    course = followed(system, Wall(), 200, Start.rigid(-1e3))
    found, scale = exact_velocities(system.body, PUSH, TURN, COUNT)
    assert np.abs(modal_velocities(course, system.body, COUNT) - found).max() < tolerance * scale


def test_the_rigid_motion_is_that_of_a_point_mass():
    """u' = p − d u' in closed form; the elastic laws leave it alone."""
    for damping in (UNDAMPED, Ratio(0.01), KelvinVoigt(1e-4)):
        course = followed(bar(20.0, *SECTIONS, load=PUSH, damping=damping), Wall(), 100, Start.rigid(-1e3, 0.7))
        assert course.momentum == pytest.approx(0.7 + 0.3 * TURN, abs=1e-11)
    d = 0.1
    course = followed(bar(20.0, *SECTIONS, load=PUSH, damping=External(d)), Wall(), 100, Start.rigid(-1e3, 0.7))
    k = np.arange(1, 4)
    steady = 0.3 / d + (PUSH.coefficients[1:] / (d + 1j * k)).sum().real
    assert course.momentum == pytest.approx(steady + (0.7 - steady) * np.exp(-d * TURN), rel=1e-4)


def test_undamped_waves_keep_their_energy():
    course = followed(bar(20.0, *SECTIONS), Wall(), 100, Start.rigid(-1e3, 1.0), periods=3)
    assert course.energy == pytest.approx(0.5, rel=1e-12)
    pushed = followed(bar(20.0, *SECTIONS, load=PUSH), Wall(), 100, Start.rigid(-1e3))
    assert pushed.energy == pytest.approx(float(pushed.now["load_work"][0]), rel=1e-12)


def test_a_load_at_a_step_sends_half_waves_both_ways():
    """At a step of nothing: the bar moves as its mass does, and a symmetric pair of waves leaves no asymmetry."""
    system = bar(5.0, (1.0, 1.0), (1.0, 1.0), load=Load.harmonic(1.0, 0.0).acting_at(1))
    course = followed(system, Wall(), 40, Start.rigid(-1e3))
    assert course.momentum == pytest.approx(TURN, rel=1e-12)
    chain = course.machine.striker
    halves = [np.roll(chain.right[f : f + n], -s) for f, n, s in zip(chain.first, chain.cells, chain.slot, strict=True)]
    mirrored = [
        np.roll(chain.left[f : f + n], -s) for f, n, s in zip(chain.first, chain.cells, chain.slot, strict=True)
    ]
    assert halves[0] == pytest.approx(mirrored[1], abs=1e-12)


@pytest.mark.parametrize(
    "load",
    [PUSH, Load.square(1.7, 1.3), Load.steps([0.3, 1.0, 4.0], [1.0, -2.0, 0.5]), Load.fourier([0.5] + [0.1] * 80)],
)
@pytest.mark.parametrize("steps", [57, 1000, 3042])
def test_means_of_the_load_are_its_integrals(load, steps):
    found, fine = load_means(load, steps), 40
    values = load.value((np.arange(steps * fine) + 0.5) * (TURN / (steps * fine))).reshape(steps, fine)
    worst = 0.51 / fine * np.abs(np.diff(load.values)).max(initial=0.0) + 1e-2 * np.ptp(values, axis=1).max() / fine
    assert np.abs(found - values.mean(axis=1)).max() <= worst + 1e-12
    assert found.mean() == pytest.approx(load.mean, abs=1e-11)


@given(
    st.lists(st.tuples(st.floats(0.1, 10.0), st.floats(0.05, 1.0)), min_size=1, max_size=6),
    st.floats(0.3, 100.0),
    st.integers(20, 150),
)
def test_a_lattice_keeps_masses_and_rounds_times_by_less_than_half_a_cell(sections, s, cells):
    impedances, times = np.array(sections).T
    times = times / times.sum() / s
    lattice = lattice_of(impedances, times, len(sections), cells)
    numbers = np.array(lattice.cells)
    found = np.array(lattice.impedances)
    assert (found * numbers * lattice.step).sum() == pytest.approx(1.0, rel=1e-12)
    assert found / found[0] == pytest.approx(impedances / impedances[0], rel=1e-12)
    assert lattice.steps * lattice.step == pytest.approx(TURN)
    off = np.abs(numbers * lattice.step - times)
    assert off.max() * s == pytest.approx(lattice.rounding, abs=1e-12)
    assert lattice.rounding <= 0.5000001 / cells or numbers.min() == 1


def test_waves_too_fast_for_a_lattice_are_refused():
    with pytest.raises(ParameterError, match="instantaneous"):
        lattice_of(np.ones(1), np.array([1e-6]), 1, 400)
    assert lattice_of(np.ones(1), np.array([TURN * 400 / MOST_STEPS * 1.01]), 1, 400).cells == (400,)


# -- single blows on the lattice: closed forms and known answers of contacts, impulses and durations


RHOS = -0.45, -0.2, 0.1, 0.3
INCOMMENSURABLE = (0.0012566, 0.0019635, 0.0009503), (0.0731, 0.2187, 0.1493)
BLOWS = {
    **{f"uniform on a wall, gap {gap}": ((1.0,), (1.0,), None, 50, gap, 1e-9) for gap in (0.0, 0.0123, 0.3)},
    **{f"uniform, R = {r}": ((1.0,), (1.0,), (1.0 + r) / (1.0 - r), 50, 0.0123, 1e-9) for r in (0.0, 0.3, 0.6, 0.9)},
    "a thick striker's staircase": ((1.0,), (1.0,), 0.5, 60, 0.0, 1e-9),
    **{f"two sections, ρ = {rho}": ((1.0 + rho, 1.0 - rho), (1.0, 1.0), None, 64, 0.0123, 1e-6) for rho in RHOS},
    "a heavy head, two contacts": ((1.0, 1.0, 4.0), (2.0, 1.0, 1.0), None, 80, 0.0123, 5e-3),
    "four contacts of a thick head": ((1.0, 2.0, 4.0), (15.0, 5.0, 10.0), 0.5, 300, 0.0123, 2e-4),
    "the drifter on a wall": (*INCOMMENSURABLE, None, 400, 0.0123, 2e-3),
    "the drifter on its rod": (*DRIFTER, 4.0, 800, 0.0123, 5e-4),
}
"""Impedances and transit times of the sections, impedance of the rod over that of the head (None: a wall), cells, gap,
and how near the lattice must come."""


@pytest.mark.parametrize(("impedances", "times", "ratio", "cells", "gap", "close"), BLOWS.values(), ids=BLOWS)
def test_a_blow_on_the_lattice_is_that_of_exact_pieces(impedances, times, ratio, cells, gap, close):
    """Every contact, and the impact that they make, as `strike` has them, which knows the closed forms."""
    system = bar(S, impedances, times)
    target = Wall(gap) if ratio is None else Rod.of_impedance(rod_for(system, ratio).impedance, gap)
    exact, contacts = strike(system.body, target, 1.0, until=TURN), contacts_of_blow(system, target, cells, gap)
    assert len(contacts) == len(exact.contacts)
    for one, other in zip(contacts, exact.contacts, strict=True):
        assert one["impulse"] == pytest.approx(other.impulse, abs=close)
        assert one["start"] * S == pytest.approx(other.start * S, abs=2.0 * close)
        assert other.end is None or one["end"] * S == pytest.approx(other.end * S, abs=2.0 * close)
    impact = one_blow(system, target, cells, gap).part(slice(0, 1))
    if exact.contact_duration is None or impact.contacts[0] < len(contacts):
        return
    assert impact.peak_force[0] == pytest.approx(max(one.peak_force for one in exact.contacts), rel=max(close, 1e-6))
    assert impact.mean_after[0] == pytest.approx(exact.mean_velocity_after, abs=close)
    assert impact.restitution[0] == pytest.approx(exact.effective_restitution, abs=close)
    assert (impact.centroid[0] - impact.start[0]) * S == pytest.approx(exact.force_centroid * S, abs=close)
    assert impact.ringing_share[0] == pytest.approx(exact.vibration_energy_after / exact.energy_before, abs=4.0 * close)
    assert impact.given[0] == pytest.approx(exact.work_through_face, abs=close)


def test_an_impulse_is_off_by_the_square_of_the_cell():
    """Contact starts anywhere in a cell; equal transit times of all sections, so that nothing is rounded."""
    system = bar(S, (1.0, 1.0, 4.0), (2.0, 1.0, 1.0))
    errors = []
    for cells in (40, 80, 160):
        gaps = 0.1 + 0.013 * np.arange(12)
        found = [contacts_of_blow(system, Wall(), cells, gap)["impulse"].sum() for gap in gaps]
        errors.append(np.abs(np.array(found) - 1.773714).max())
    assert errors[2] < 3e-5, errors


@pytest.mark.parametrize("ratio", [0.7, 2.0])
def test_a_section_of_the_rods_own_impedance_changes_nothing(ratio):
    from percuss.model import System
    from percuss.model.body import Section, SectionedBar

    piston = SectionedBar([Section(0.2, area=1e-3), Section(0.3, area=2e-3)])
    load = bar(S).load.scaled(1.0, frequency=30.0)
    system = System.from_si(piston, load, bar(S).contact)
    area = 2e-3 * ratio
    plain = contacts_of_blow(system, Rod([Section(None, area=area)]), 100, gap=0.01)
    longer = contacts_of_blow(system, Rod([Section(0.25, area=area), Section(None, area=area)]), 100, gap=0.01)
    assert longer["impulse"].sum() == pytest.approx(plain["impulse"].sum(), abs=1e-4)
    fixed = contacts_of_blow(system, Rod([Section(0.25, area=area)], "fixed"), 100, gap=0.01)
    assert fixed["impulse"].sum() > plain["impulse"].sum()
