"""Nine blows that two programs without common code have computed: every number of each, to 1e-9 of its scale."""

import json
from pathlib import Path

import numpy as np
import pytest

from percuss.blow import Rock, Rod, Wall, strike
from percuss.model import Section, SectionedBar

CASES = json.loads((Path(__file__).parent / "reference_blows.json").read_text(encoding="utf-8"))
CLOSE = 1e-9

OTHER_NAMES = {
    "rod_energy_after": "rod_energy",
    "rod_momentum_after": "rod_momentum",
    "rock_work_dissipated": "rock_dissipated",
}


def section(row):
    length, area, modulus, density = row
    return Section(length, area=area, youngs_modulus=modulus, density=density)


def target_of(case):
    told = case["target"]
    if told["kind"] == "wall":
        return Wall(case["gap"])
    rock = told.get("rock")
    return Rod(
        [section(row) for row in told["sections"]],
        told["end"],
        bit_mass=told.get("bit_mass", 0.0),
        rock=None if rock is None else Rock(rock["k1"], rock["gamma"], rock["gap"]),
        gap=case["gap"],
    )


@pytest.fixture(scope="module", params=CASES, ids=lambda case: case["name"])
def told(request):
    case = request.param
    striker = SectionedBar([section(row) for row in case["striker"]["sections"]])
    velocity = case["striker"]["velocity"]
    blow = strike(striker, target_of(case), velocity, until=case["until"], load=case.get("load", ()))
    return case, blow


def natural_scale(name, case):
    expect = case["expect"]
    if name in ("effective_restitution", "restitution_from_impulse", "efficiency", "efficiency_with_rebound"):
        return 1.0
    if name == "striker_mass":
        return expect["striker_mass"]
    if "velocity" in name:
        return expect["mean_velocity_before"]
    if "momentum" in name or name == "impulse":
        return expect["striker_mass"] * expect["mean_velocity_before"]
    if "gap" in name or "penetration" in name:
        return expect["mean_velocity_before"] * case["until"]
    return expect["kinetic_energy_before"]


def test_every_number(told):
    case, blow = told
    elsewhere = {"contacts", "face_force_at", "peak_compressive_stress", "peak_tensile_stress", "greatest_rock_force"}
    for name, value in case["expect"].items():
        if name not in elsewhere:
            found = getattr(blow, OTHER_NAMES.get(name, name))
            assert found == pytest.approx(value, rel=0.0, abs=CLOSE * natural_scale(name, case)), name


def test_contacts(told):
    case, blow = told
    rows = case["expect"]["contacts"]
    strongest = max(row[3] for row in rows)
    assert len(blow.contacts) == len(rows)
    for spell, (start, end, impulse, peak) in zip(blow.contacts, rows, strict=True):
        assert spell.start == pytest.approx(start, abs=CLOSE * case["until"])
        assert (spell.end is None) == (end is None)
        if end is not None:
            assert spell.end == pytest.approx(end, abs=CLOSE * case["until"])
        assert spell.impulse == pytest.approx(impulse, abs=CLOSE * case["expect"]["impulse"])
        assert spell.peak_force == pytest.approx(peak, abs=CLOSE * strongest)


def test_forces_and_stresses(told):
    case, blow = told
    expect = case["expect"]
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
