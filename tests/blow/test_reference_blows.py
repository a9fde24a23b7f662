"""Nine blows that two programs without common code have computed: the package on every number, and the judges too.

The judges are judged first: the rational, the lattice and the smooth program on the reference blows, and on each other.
"""

from __future__ import annotations

import math
from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from hypothesis import example, given, reject, settings

import lattice_program
import rational_program
import smooth_program
from blow_strategies import collisions, exact_collisions, struck
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


# -- The package against the second programs ---------------------------------------------------------------------------


EXACT = 1e-12
SMOOTH = 1e-8
MOST_EVENTS = 120  # of a blow whose peaks are looked for among all pairs of waves


def scales(case: Collision) -> tuple[float, float, float]:
    """Momentum, energy and time that errors are measured in: what the striker has, and what a load brings."""
    pushed = max((abs(float(force)) for _, force in case.load), default=0.0) * float(case.until)
    speed = max(abs(float(v)) for v in case.velocity) + pushed / float(case.mass)
    return float(case.mass) * speed, float(case.mass) * speed**2, float(case.until)


def told_of(spells: Any, momentum: float) -> list[tuple[float, float, float]]:
    """(start, end, impulse) of the contacts that are more than rounding; those that touch are one."""
    found: list[tuple[float, float, float]] = []
    for start, end, impulse, *_ in spells:
        if impulse <= 1e-10 * momentum:
            continue
        last = math.inf if end is None else float(end)
        if found and start - found[-1][1] < 1e-9:
            start, impulse = found[-1][0], impulse + found.pop()[2]
        found.append((float(start), last, float(impulse)))
    return found


def of_package(blow: Any) -> list[tuple[float, float | None, float, float]]:
    return [(one.start, one.end, one.impulse, one.peak_force) for one in blow.contacts]


def without_touches(
    spells: list[tuple[float, float, float]], touches: list[tuple[float, float]], near: float
) -> list[tuple[float, float, float]]:
    """As if every time of touching without force were open at its ends, and shut between two contacts.

    Where no force is felt and no gap opens, rounding decides whether the faces are in contact.
    """
    found: list[tuple[float, float, float]] = []
    for start, end, impulse in spells:
        for first, last in touches:
            if first - near <= start <= last + near:
                start = last
                if found and found[-1][1] >= first - near:
                    start, impulse = found[-1][0], impulse + found.pop()[2]
        for first, last in reversed(touches):
            end = first if first - near <= end <= last + near else end
        found.append((start, end, impulse))
    return found


def assert_same_contacts(
    ours: Any, theirs: Any, case: Collision, tolerance: float, touches: list[tuple[float, float]] | None = None
) -> None:
    momentum, _, time = scales(case)
    near = tolerance * time
    mine, other = (without_touches(told_of(spells, momentum), touches or [], near) for spells in (ours, theirs))
    assert len(mine) == len(other)
    for one, two in zip(mine, other, strict=True):
        assert one[0] == pytest.approx(two[0], abs=tolerance * time)
        if math.isfinite(one[1]) and math.isfinite(two[1]):
            assert one[1] == pytest.approx(two[1], abs=tolerance * time)
        assert one[2] == pytest.approx(two[2], abs=tolerance * momentum)


def assert_is_rational(case: Collision) -> None:
    blow, exact = struck(case), rational_program.blow(case)
    momentum, energy, time = scales(case)
    assert_same_contacts(of_package(blow), _shut(exact), case, 1e-10)
    for ours, theirs, scale in (
        (blow.impulse, exact.impulse, momentum),
        (blow.striker_momentum_after, exact.momentum_after, momentum),
        (blow.kinetic_energy_before, case.energy_before, energy),
        (blow.rigid_energy_after, exact.rigid_energy_after, energy),
        (blow.vibration_energy_after, exact.vibration_energy_after, energy),
        (blow.work_through_face, exact.work_through_face, energy),
        (blow.load_work, exact.load_work, energy),
        (blow.gap_after, exact.gap_after, momentum / float(case.mass) * time),
    ):
        assert ours == pytest.approx(float(theirs), abs=EXACT * scale)
    if exact.impulse > momentum * Fraction(1, 10**6):
        assert blow.force_centroid == pytest.approx(float(exact.force_centroid), abs=1e-9 * time)
    if exact.events > MOST_EVENTS:
        return
    for section, peak in zip(exact.striker, blow.peaks, strict=False):
        compression, tension = map(float, exact.peak_forces(section))
        largest, area = max(compression, tension), float(section.impedance)
        assert peak.compression * area == pytest.approx(compression, abs=1e-11 * largest + 1e-14)
        assert peak.tension * area == pytest.approx(tension, abs=1e-11 * largest + 1e-14)


def _shut(exact: rational_program.Outcome) -> list[tuple[float, float | None, float, float]]:
    """Contacts, those parted by a time without force and without a gap as one."""
    return [
        (float(a), None if b is None else float(b), float(impulse), float(peak))
        for a, b, impulse, peak in exact.contacts
    ]


@settings(max_examples=20)
@given(case=exact_collisions(transits=4))
def test_blow_is_what_rational_numbers_say(case: Collision) -> None:
    assert_is_rational(case)


def assert_is_smooth(case: Collision, tolerance: float = SMOOTH) -> None:
    blow = struck(case)
    try:
        other = smooth_program.blow(case)
    except smooth_program.TooMany:
        reject()
    momentum, energy, time = scales(case)
    assert_same_contacts(of_package(blow), other.contacts, case, 1e-6, other.touches)
    for ours, theirs, scale in (
        (blow.impulse, other.impulse, momentum),
        (blow.striker_momentum_after, other.momentum_after, momentum),
        (blow.rigid_energy_after + blow.vibration_energy_after, other.striker_energy_after, energy),
        (blow.work_through_face, other.work_through_face, energy),
        (blow.load_work, other.load_work, energy),
        (blow.gap_after, other.gap_after, momentum / float(case.mass) * time),
    ):
        assert ours == pytest.approx(theirs, abs=tolerance * scale)
    if other.bit is not None and case.end == "rock":
        assert blow.rock_work == pytest.approx(other.bit.work, abs=tolerance * energy)
        length = momentum / float(case.mass) * time
        assert blow.greatest_penetration == pytest.approx(other.bit.deepest, abs=tolerance * length)
        assert blow.penetration_after == pytest.approx(other.bit.position, abs=tolerance * length)


@settings(max_examples=12)
@given(case=collisions(sections=2, transits=3.0))
def test_blow_is_what_the_smooth_program_says(case: Collision) -> None:
    assert_is_smooth(case)


# faces that open for 3e-10 of a transit, and faces whose force is a rounding error for 3e-8
SHORT_GAP = Collision(
    ((1.0, 1.0), (10.0**0.5, 1.0)), (0.0, 1.0), 6.0, ((10.0, 1.0000000001399305),), "fixed",
)  # fmt: skip
FAINT_FORCE = Collision(
    ((1.000000000000001, 10.0**0.5),), (1.0,), 9.486832980505138, ((0.999999999999, 0.9999976868402354),), "rock",
    k1=6.586073530314961, gamma=0.8186265750900974,
)  # fmt: skip


@pytest.mark.slow
@settings(max_examples=150)
@given(case=collisions(transits=3.0))
@example(case=SHORT_GAP)
@example(case=FAINT_FORCE)
def test_many_blows_are_what_the_smooth_program_says(case: Collision) -> None:
    assert_is_smooth(case)


@pytest.mark.slow
@settings(max_examples=150)
@given(case=exact_collisions(transits=10))
def test_many_blows_are_what_rational_numbers_say(case: Collision) -> None:
    assert_is_rational(case)


def on_cells(case: Collision, dt: float) -> Collision:
    """With transit times that are whole numbers of cells, so that what the lattice rounds is nothing but events."""
    return lattice_program.cells(case, dt)


@settings(max_examples=10)
@given(case=collisions(transits=3.0))
def test_lattice_comes_to_the_blow(case: Collision) -> None:
    """The mean error over quantities falls as the step; a bound, for one blow may be lucky at the coarse step."""
    coarse = min(tau for _, tau in (*case.striker, *(case.rod or ())) if tau is not None) / 2.0
    case = on_cells(case, coarse)
    blow = struck(case)
    momentum, energy, _ = scales(case)
    found = lattice_program.blow(case, coarse / 64.0)
    errors = np.abs(
        [
            (found.impulse - blow.impulse) / momentum,
            (found.momentum_after - blow.striker_momentum_after) / momentum,
            (found.work_through_face - blow.work_through_face) / energy,
        ]
    )
    assert errors.max() < 0.05
