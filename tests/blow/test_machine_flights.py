"""Flights on the lattice: against modes in closed form under every law of damping; load means; the lattice itself."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from machine_cases import TURN, bar, followed
from percuss.blow import Wall
from percuss.blow.periods.lattice import MOST_STEPS, lattice_of, load_means
from percuss.errors import ParameterError
from percuss.model import Load
from percuss.model.body import External, KelvinVoigt, Ratio
from percuss.model.body.damping import UNDAMPED, Table
from percuss.simulate import Start

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
