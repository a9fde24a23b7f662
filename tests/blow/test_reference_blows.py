"""Blows that other programs and formulas know: reference figures, closed forms."""

import json
import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from percuss.blow import Outcome, Rock, Rod, Wall, closed_forms, effective_blow, strike
from percuss.errors import ParameterError
from percuss.model import Bar, Section, SectionedBar, SteppedBar, UniformBar
from strategies import decades

# -- nine blows that two programs without common code have computed --------------------------------------------------


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


# -- the closed forms against the waves, over the whole range in which they hold -------------------------------------


def unit_section(impedance, transit):
    """With E = ρ = 1 the length is the transit time, and the area the impedance."""
    return Section(transit, area=impedance, youngs_modulus=1.0, density=1.0)


def test_st_venant():
    """L = 1 m, E = 210 GPa, ρ = 7800 kg/m³, S = 3.14 cm², 0.1 m/s."""
    bar = Bar(1.0, 3.14e-4, 210e9, 7800.0)
    blow = strike(bar, Wall(), 0.1)
    assert blow.outcome is Outcome.OVER
    assert blow.contact_duration == pytest.approx(3.854496446637726e-4, rel=1e-14)
    assert blow.contacts[0].peak_force == pytest.approx(1270.82747846, rel=1e-11)
    assert blow.effective_restitution == pytest.approx(1.0, abs=1e-14)
    closed = closed_forms.uniform_blow(bar.impedance, bar.transit_time, 0.1)
    assert closed.force == pytest.approx(blow.contacts[0].peak_force, rel=1e-14)
    assert closed.duration == pytest.approx(blow.contact_duration, rel=1e-14)


@given(s=decades(-1.0, 3.0), ratio=decades(0.0, 4.0))
def test_a_uniform_striker_on_a_rod_that_is_no_less_stiff(s, ratio):
    """One contact of two transit times, R = (Z_2 − Z)/(Z_2 + Z), and no ringing: B77's law is exact."""
    found = effective_blow(UniformBar(s), Rod.of_impedance(ratio * s))
    closed = closed_forms.uniform_blow(s, 1.0 / s, 1.0, ratio * s)
    assert found.restitution == pytest.approx(closed.restitution, abs=1e-13)
    assert found.duration == pytest.approx(closed.duration, rel=1e-12)
    assert found.centroid == pytest.approx(0.5 * closed.duration, rel=1e-12)
    assert found.advance == pytest.approx((1.0 - closed.restitution) / s, rel=1e-10, abs=1e-13)
    assert found.ringing == pytest.approx(0.0, abs=1e-14)
    assert found.contacts == 1


@given(ratio=decades(0.01, 3.0), steps=st.integers(1, 8))
def test_the_staircase(ratio, steps):
    """Force and velocity after each round trip of a striker that is stiffer than the rod."""
    blow = strike(Bar(0.5, ratio, 1.0, 1.0), Rod([unit_section(1.0, None)]), 2.0, until=float(steps) + 0.5)
    for k in range(steps):
        force = closed_forms.staircase_force(ratio, 1.0, 2.0, k)
        assert blow.face_force.at(k + 0.5) == pytest.approx(force, abs=1e-13 * ratio)
    state = blow.state_at(float(steps)).striker
    assert state.velocity[1:-1] == pytest.approx(closed_forms.staircase_velocity(ratio, 1.0, 2.0, steps), abs=1e-13)
    if steps == 1:
        passed = closed_forms.uniform_blow(ratio, 1.0, 1.0, 1.0).passed
        first = strike(Bar(0.5, ratio, 1.0, 1.0), Rod([unit_section(1.0, None)]), 2.0, until=1.0)
        assert first.work_through_face == pytest.approx(passed * first.energy_before, rel=1e-12)


@given(rho=st.floats(-0.499, 0.309))
def test_two_sections_of_equal_transit_times_on_a_wall(rho):
    rear, head = 1.0 + rho, 1.0 - rho
    found = effective_blow(SteppedBar(4.0, (rear, head), (1.0, 1.0)), Wall())
    assert found.restitution == pytest.approx(closed_forms.two_section_restitution(rear, head), abs=1e-12)
    assert found.ringing == pytest.approx(4.0 * rho**2 * (1.0 - rho**2), abs=1e-12)


@given(beta=decades(-1.5, 1.2), gamma=st.floats(0.01, 1.0))
def test_a_matched_hammer_on_rock(beta, gamma):
    """Lundberg's efficiency: the rod is long enough for the first wave to have gone back before anything returns."""
    rod = Rod([unit_section(1.0, 50.0)], "rock", rock=Rock(0.5 * beta, gamma))
    blow = strike(Bar(1.0, 1.0, 1.0, 1.0), rod, 1.0, until=95.0)
    assert blow.rock_dissipated / blow.energy_before == pytest.approx(
        closed_forms.matched_efficiency(beta, gamma), abs=1e-12
    )
    assert blow.bit_force.at(51.0) == pytest.approx(-math.expm1(-0.5 * beta), rel=1e-12)


def test_the_best_beta_is_the_best():
    best = closed_forms.matched_efficiency(closed_forms.BEST_BETA, 0.25)
    assert math.exp(closed_forms.BEST_BETA) == pytest.approx(1.0 + 2.0 * closed_forms.BEST_BETA, rel=1e-14)
    assert best == pytest.approx(0.75 * 0.8145287552, rel=1e-10)
    for other in (0.99, 1.01):
        assert closed_forms.matched_efficiency(other * closed_forms.BEST_BETA, 0.25) < best


def test_an_exponential_wave_does_the_most_work():
    """The best wave of a duration, sent as the field of a long striker through a matched rod."""
    beta, gamma = 2.0, 0.2
    rod = Rod([unit_section(1.0, 60.0)], "rock", rock=Rock(beta, gamma))
    # what is at x in the striker, all of it going right, arrives the later the further it is from the face
    wave = lambda x: math.e ** (beta * (1.0 - x))  # noqa: E731
    blow = strike(Bar(1.0, 1.0, 1.0, 1.0), rod, field=(wave, wave), until=100.0)
    assert blow.rock_dissipated / blow.energy_before == pytest.approx(
        closed_forms.best_efficiency(beta, gamma), rel=1e-10
    )


@given(mass_ratio=decades(-1.0, 2.0))
def test_a_heavy_bit_is_a_fixed_end_and_a_light_one_is_none(mass_ratio):
    assume(mass_ratio > 0.2)
    striker = Bar(1.0, 1.0, 1.0, 1.0)
    rod = [unit_section(mass_ratio, 2.5)]
    fixed, heavy = (
        strike(striker, Rod(rod, "fixed"), 1.0, until=12.0),
        strike(striker, Rod(rod, "free", bit_mass=1e9), 1.0, until=12.0),
    )
    free, light = (
        strike(striker, Rod(rod, "free"), 1.0, until=12.0),
        strike(striker, Rod(rod, "free", bit_mass=1e-7), 1.0, until=12.0),
    )
    for limit, near in ((fixed, heavy), (free, light)):
        assert near.impulse == pytest.approx(limit.impulse, abs=1e-6)
        assert near.rod_energy == pytest.approx(limit.rod_energy, abs=1e-6)


@pytest.mark.parametrize(
    "refused",
    [
        lambda: closed_forms.staircase_force(1.0, 2.0, 1.0, 0),
        lambda: closed_forms.two_section_restitution(10.0, 1.0),
        lambda: closed_forms.matched_efficiency(0.0, 0.5),
        lambda: closed_forms.best_efficiency(1.0, 1.5),
    ],
)
def test_outside_their_range_they_refuse(refused):
    with pytest.raises(ParameterError):
        refused()


def test_stepped_pistons_of_the_literature():
    """Three sections on a wall, and heavy heads 1:1:4: restitution, ringing and contacts."""
    drifter = SectionedBar(
        [
            Section(length, area=area, youngs_modulus=206e9, density=7850.0)
            for length, area in ((0.0731, 1.2566e-3), (0.2187, 1.9635e-3), (0.1493, 9.503e-4))
        ]
    )
    found = effective_blow(drifter, Wall())
    assert (round(found.restitution, 6), round(found.ringing, 3)) == (0.869177, 0.245)
    heavy = effective_blow(SteppedBar(1.0, (1.0, 1.0, 4.0), (2.0, 1.0, 1.0)), Wall())
    assert (round(heavy.restitution, 6), heavy.contacts) == (0.773714, 2)
    equal = effective_blow(SteppedBar(1.0, (1.0, 1.0, 4.0), (1.0, 1.0, 1.0)), Wall())
    assert equal.restitution == pytest.approx(0.44, abs=0.005)
    assert equal.ringing == pytest.approx(0.80, abs=0.01)
