"""Flights and single blows on the lattice: against modes under every law of damping, closed forms and known answers."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from machine_cases import DRIFTER, TURN, S, bar, contacts_of_blow, followed, one_blow, rod_for
from percuss.blow import Rod, Wall, strike
from percuss.blow.periods.lattice import MOST_STEPS, lattice_of, load_means
from percuss.errors import ParameterError
from percuss.model import Load
from percuss.model.body import External, KelvinVoigt, Ratio
from percuss.model.body.damping import UNDAMPED, Table
from percuss.simulate import Start

# -- flights on the lattice: against modes in closed form under every law of damping; load means; the lattice itself


SECTIONS = (1.2, 2.0, 0.9), (0.2, 0.5, 0.3)
LOAD = Load.fourier([0.3, 1.0, 0.2j, 0.1])
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
    return at_load * (steady + free), np.abs(at_load).max() * np.abs(LOAD.coefficients).sum() / modes.omega[0]


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
    system = bar(20.0, *SECTIONS, load=LOAD, damping=damping)
    course = followed(system, Wall(), 200, Start.rigid(-1e3))
    found, scale = exact_velocities(system.body, LOAD, TURN, COUNT)
    assert np.abs(modal_velocities(course, system.body, COUNT) - found).max() < tolerance * scale


def test_the_rigid_motion_is_that_of_a_point_mass():
    """u' = p − d u' in closed form; the elastic laws leave it alone."""
    for damping in (UNDAMPED, Ratio(0.01), KelvinVoigt(1e-4)):
        course = followed(bar(20.0, *SECTIONS, load=LOAD, damping=damping), Wall(), 100, Start.rigid(-1e3, 0.7))
        assert course.momentum == pytest.approx(0.7 + 0.3 * TURN, abs=1e-11)
    d = 0.1
    course = followed(bar(20.0, *SECTIONS, load=LOAD, damping=External(d)), Wall(), 100, Start.rigid(-1e3, 0.7))
    k = np.arange(1, 4)
    steady = 0.3 / d + (LOAD.coefficients[1:] / (d + 1j * k)).sum().real
    assert course.momentum == pytest.approx(steady + (0.7 - steady) * np.exp(-d * TURN), rel=1e-4)


def test_undamped_waves_keep_their_energy():
    course = followed(bar(20.0, *SECTIONS), Wall(), 100, Start.rigid(-1e3, 1.0), periods=3)
    assert course.energy == pytest.approx(0.5, rel=1e-12)
    pushed = followed(bar(20.0, *SECTIONS, load=LOAD), Wall(), 100, Start.rigid(-1e3))
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
    [LOAD, Load.square(1.7, 1.3), Load.steps([0.3, 1.0, 4.0], [1.0, -2.0, 0.5]), Load.fourier([0.5] + [0.1] * 80)],
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
