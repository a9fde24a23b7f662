"""Nine blows that two programs without common code have computed: the package on every number, and the judges too.

The judges are judged first: the rational, the lattice and the smooth program on the reference blows, and on each other.
"""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

import lattice_program
import rational_program
import smooth_program
from collisions import Collision, Reference, references, simple
from percuss.blow import Rock, Rod, Wall, strike
from percuss.model import Section, SectionedBar

BLOWS = references()
CONSTANT = [one for one in BLOWS if one.collision.end != "rock"]


def named(blows: list[Reference]) -> pytest.MarkDecorator:
    return pytest.mark.parametrize("reference", blows, ids=[one.name for one in blows])


@named(CONSTANT)
def test_rational_program_has_every_figure_of_the_references(reference: Reference) -> None:
    case, expected = reference.collision.turned_into(simple), reference.expected
    found = rational_program.blow(case)
    assert len(found.contacts) == len(expected["contacts"])
    for ours, theirs in zip(found.contacts, expected["contacts"], strict=True):
        assert (ours[1] is None) == (theirs[1] is None)
        for number, wanted in zip(ours, theirs, strict=True):
            assert wanted is None or float(number) == pytest.approx(wanted, rel=1e-9, abs=1e-9 * case.until)
    energy = expected["kinetic_energy_before"]
    for name in ("rigid_energy_after", "vibration_energy_after", "work_through_face", "load_work"):
        assert float(getattr(found, name)) == pytest.approx(expected.get(name, 0.0), abs=1e-9 * energy)
    assert float(found.gap_after) == pytest.approx(expected["gap_after"], abs=1e-9 * expected["mean_velocity_before"])
    assert float(found.momentum_after) == pytest.approx(expected["striker_momentum_after"], abs=1e-9 * found.impulse)


@named([one for one in CONSTANT if "four contacts" not in one.name])
def test_rational_program_has_the_peak_stresses(reference: Reference) -> None:
    found, expected = rational_program.blow(reference.collision.turned_into(simple)), reference.expected
    largest = max(expected["peak_compressive_stress"])
    for i, (section, (_, area, _, _)) in enumerate(zip(found.striker, reference.sections, strict=True)):
        compression, tension = found.peak_forces(section)
        assert float(compression) / area == pytest.approx(expected["peak_compressive_stress"][i], abs=1e-9 * largest)
        assert float(tension) / area == pytest.approx(expected["peak_tensile_stress"][i], abs=1e-9 * largest)


@named(CONSTANT)
def test_rational_program_loses_nothing(reference: Reference) -> None:
    """Momentum and energy, not rounded: equal."""
    found = rational_program.blow(reference.collision.turned_into(simple))
    case = found.collision
    assert case.mass * case.velocity_before + found.load_impulse == found.momentum_after + found.impulse
    assert case.energy_before + found.load_work == found.striker_energy_after + found.work_through_face
    if case.rod and case.end == "infinite":
        assert found.rod_energy_after == found.work_through_face
        assert found.rod_momentum_after == found.impulse


@named(BLOWS)
def test_lattice_comes_to_the_references(reference: Reference) -> None:
    case, expected = reference.collision, reference.expected
    found = lattice_program.blow(case, 2.5e-7 if "incommensurable" not in reference.name else 1.25e-7)
    assert len(found.contacts) == len(expected["contacts"])
    assert found.impulse == pytest.approx(expected["impulse"], rel=2e-3)
    energy = expected["kinetic_energy_before"]
    assert found.work_through_face == pytest.approx(expected["work_through_face"], abs=2e-3 * energy)
    assert found.vibration_energy_after == pytest.approx(expected["vibration_energy_after"], abs=2e-3 * energy)
    if found.rock is not None:
        assert found.rock.work == pytest.approx(expected["rock_work"], abs=1e-5 * energy)
        assert found.rock.residual == pytest.approx(expected["residual_penetration"], rel=1e-5)


@named(BLOWS)
def test_smooth_program_has_every_figure_of_the_references(reference: Reference) -> None:
    case, expected = reference.collision, reference.expected
    found = smooth_program.blow(case)
    assert len(found.contacts) == len(expected["contacts"])
    for ours, theirs in zip(found.contacts, expected["contacts"], strict=True):
        for number, wanted in zip(ours, theirs, strict=True):
            assert wanted is None or number == pytest.approx(wanted, rel=1e-9, abs=1e-9 * case.until)
    energy, speed = expected["kinetic_energy_before"], expected["mean_velocity_before"]
    assert found.striker_energy_after == pytest.approx(
        expected["rigid_energy_after"] + expected["vibration_energy_after"], abs=1e-9 * energy
    )
    assert found.work_through_face == pytest.approx(expected["work_through_face"], abs=1e-9 * energy)
    assert found.gap_after == pytest.approx(expected["gap_after"], abs=1e-9 * speed * case.until)
    if found.bit is not None:
        assert found.bit.work == pytest.approx(expected["rock_work"], abs=1e-9 * energy)
        assert found.bit.deepest == pytest.approx(expected["greatest_penetration"], rel=1e-9)
        assert found.bit.position == pytest.approx(expected["penetration_after"], abs=1e-9 * speed * case.until)
        assert found.bit.greatest_force == pytest.approx(expected["greatest_rock_force"], rel=1e-9)


def pushed_on_a_fixed_rod(*velocity: Fraction) -> Collision:
    return Collision(
        striker=((Fraction(3), Fraction(2)), (Fraction(1), Fraction(3))),
        velocity=velocity,
        rod=((Fraction(2), Fraction(4)), (Fraction(5), Fraction(1))),
        end="fixed",
        load=((Fraction(0), Fraction(1)), (Fraction(5), Fraction(-1))),
        load_at=1,
        until=Fraction(14),
    )


FIGURES = ("impulse", "momentum_after", "striker_energy_after", "rod_energy_after", "load_work", "gap_after")


def test_lattice_is_the_rational_program_where_all_happens_on_it() -> None:
    case = pushed_on_a_fixed_rod(Fraction(1), Fraction(3, 2))
    exact, lattice = rational_program.blow(case), lattice_program.blow(case, 0.125, peaks=True)
    assert len(exact.contacts) == len(lattice.contacts) == 1
    for name in FIGURES:
        assert getattr(lattice, name) == pytest.approx(float(getattr(exact, name)), abs=1e-12)
    for section, seen in zip(exact.striker, lattice.peaks, strict=True):
        assert seen == pytest.approx(tuple(map(float, exact.peak_forces(section))), abs=1e-12)


def test_lattice_errs_by_its_step_where_contacts_begin_between() -> None:
    case = pushed_on_a_fixed_rod(Fraction(-1, 2), Fraction(1))
    exact = rational_program.blow(case)
    assert exact.contacts[1][0] == Fraction(1539, 181)
    for name in FIGURES:
        wanted = float(getattr(exact, name))
        errors = [abs(getattr(lattice_program.blow(case, dt), name) - wanted) for dt in (2.0**-5, 2.0**-9)]
        assert errors[1] <= 2.0**-8 * (1.0 + abs(wanted))
        assert errors[1] <= errors[0] / 4.0 + 1e-12


BIT_AND_JOINT = Collision(
    striker=((1.0, 1.0), (2.0, 0.7)),
    velocity=(1.0, 1.0),
    rod=((1.5, 0.6), (0.8, 1.1)),
    end="rock",
    k1=1.3,
    gamma=0.4,
    bit_mass=0.5,
    joint_masses=((1, 0.3),),
    until=5.0,
)


@pytest.mark.parametrize("bit_mass", [0.0, 0.5])
@pytest.mark.parametrize("gamma", [0.4, 1.0])
@pytest.mark.parametrize("rock_gap", [0.0, 0.2])
def test_lattice_comes_to_the_smooth_program(bit_mass: float, gamma: float, rock_gap: float) -> None:
    case = replace(BIT_AND_JOINT, bit_mass=bit_mass, gamma=gamma, rock_gap=rock_gap)
    smooth, lattice = smooth_program.blow(case), lattice_program.blow(case, 1.0 / 512.0)
    assert smooth.bit is not None
    assert lattice.rock is not None
    assert lattice.impulse == pytest.approx(smooth.impulse, rel=5e-3)
    assert lattice.rock.work == pytest.approx(smooth.bit.work, abs=5e-3 * case.energy_before)
    assert lattice.rock.deepest == pytest.approx(smooth.bit.deepest, rel=5e-3)
    assert lattice.striker_energy_after == pytest.approx(smooth.striker_energy_after, abs=1e-2 * case.energy_before)


# -- the package: every number of each, to 1e-9 of its scale

CLOSE = 1e-9

OTHER_NAMES = {
    "rod_energy_after": "rod_energy",
    "rod_momentum_after": "rod_momentum",
    "rock_work_dissipated": "rock_dissipated",
}


@pytest.fixture(scope="module", params=references(), ids=lambda one: one.name)
def told(request):
    """A reference and the blow by the package, its sections with their sizes."""
    one, case = request.param, request.param.collision
    rows = [[Section(*row[:2], None, 0.0, *row[2:]) for row in rows] for rows in (one.sections, one.rod_sections)]
    striker, rod = rows
    rock = Rock(case.k1, case.gamma, case.rock_gap) if case.end == "rock" else None
    target = Rod(rod, case.end, bit_mass=case.bit_mass, rock=rock, gap=case.gap) if rod else Wall(case.gap)
    return one, strike(SectionedBar(striker), target, list(case.velocity), until=case.until, load=case.load)


def natural_scale(name, case):
    expect = case.expected
    if name in ("effective_restitution", "restitution_from_impulse", "efficiency", "efficiency_with_rebound"):
        return 1.0
    if name == "striker_mass":
        return expect["striker_mass"]
    if "velocity" in name:
        return expect["mean_velocity_before"]
    if "momentum" in name or name == "impulse":
        return expect["striker_mass"] * expect["mean_velocity_before"]
    if "gap" in name or "penetration" in name:
        return expect["mean_velocity_before"] * case.collision.until
    return expect["kinetic_energy_before"]


def test_every_number(told):
    case, blow = told
    elsewhere = {"contacts", "face_force_at", "peak_compressive_stress", "peak_tensile_stress", "greatest_rock_force"}
    for name, value in case.expected.items():
        if name not in elsewhere:
            found = getattr(blow, OTHER_NAMES.get(name, name))
            assert found == pytest.approx(value, rel=0.0, abs=CLOSE * natural_scale(name, case)), name


def test_contacts(told):
    case, blow = told
    rows = case.expected["contacts"]
    strongest = max(row[3] for row in rows)
    assert len(blow.contacts) == len(rows)
    for spell, (start, end, impulse, peak) in zip(blow.contacts, rows, strict=True):
        assert spell.start == pytest.approx(start, abs=CLOSE * case.collision.until)
        assert (spell.end is None) == (end is None)
        if end is not None:
            assert spell.end == pytest.approx(end, abs=CLOSE * case.collision.until)
        assert spell.impulse == pytest.approx(impulse, abs=CLOSE * case.expected["impulse"])
        assert spell.peak_force == pytest.approx(peak, abs=CLOSE * strongest)


def test_forces_and_stresses(told):
    case, blow = told
    expect = case.expected
    strongest = max(row[3] for row in expect["contacts"])
    for time, force in expect["face_force_at"]:
        assert blow.face_force.at(time) == pytest.approx(force, abs=CLOSE * strongest)
    if "peak_compressive_stress" in expect:
        compressions, tensions = expect["peak_compressive_stress"], expect["peak_tensile_stress"]
        for peak, compression, tension in zip(blow.peaks, compressions, tensions, strict=False):
            assert peak.compression == pytest.approx(compression, abs=CLOSE * max(compressions))
            assert peak.tension == pytest.approx(tension, abs=CLOSE * max(compressions))
    if "greatest_rock_force" in expect:
        assert blow.bit_force.peak == pytest.approx(expect["greatest_rock_force"], rel=CLOSE)


def test_balances_close_to_rounding(told):
    _, blow = told
    assert blow.energy_error < 1e-13
    assert blow.momentum_error < 1e-13


def test_the_place_and_time_of_a_peak_is_where_it_is(told):
    _, blow = told
    largest = max(peak.compression for peak in blow.peaks)
    for number, peak in enumerate(blow.peaks[: len(blow.striker.sections)]):
        area = blow.striker.sections[number].area
        for value, place, time, sign in (
            (peak.compression, peak.compression_place, peak.compression_time, 1.0),
            (peak.tension, peak.tension_place, peak.tension_time, -1.0),
        ):
            if value == 0.0:
                assert place is None and time is None
                continue
            times = [time + late * blow.until for late in (-1e-9, 0.0, 1e-9)]
            seen = np.concatenate([sign * force_near(blow, number, place, one) for one in times])
            assert seen.max() / area == pytest.approx(value, abs=0.02 * largest)


def force_near(blow, number, place, time):
    """The forces in a section of the striker next to a place, where there is a jump on both sides of it."""
    state = blow.state_at(min(max(time, 0.0), blow.until)).striker
    here = state.section == number
    away = abs(state.places[here] - place)
    near = np.flatnonzero(away <= away.min() + 1e-6 * state.places[-1])
    around = np.clip(np.concatenate([near - 1, near, near + 1]), 0, away.size - 1)
    return state.force[here][around]
