"""Tools on rock, or with a free end, in a machine by waves: single blows against exact pieces, then whole motions."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from percuss import Load, System, Timed, timed_states
from percuss.blow import Rock, Rod, effective_blow, strike
from percuss.blow.kernels.lattice_motion import follow
from percuss.blow.periods import run_by_waves
from percuss.blow.periods.lattice import machine_record
from percuss.blow.periods.wave_motion import LatticeRun
from percuss.errors import ParameterError
from percuss.model import Bar, Kept, Section, SectionedBar
from percuss.simulate import Start, Stop

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


def test_a_free_end_must_be_pushed_back_and_masses_between_sections_are_refused():
    system = hammer(PISTON, Load.harmonic(6e3, 1e4, frequency=40.0))
    with pytest.raises(ParameterError, match="nothing else brings back"):
        run_by_waves(system, Rod([ONE], "free"))
    with pytest.raises(ParameterError, match="short section"):
        run_by_waves(system, Rod([ONE, ONE], "rock", rock=Rock(1e8), joint_masses=[(1, 2.0)]))
    with pytest.raises(ParameterError, match="of_impedance"):
        run_by_waves(System(20.0, 0.0, 0.6, Load.harmonic(0.9, 1.0)), Rod([ONE], "rock", rock=Rock(1e8)))
