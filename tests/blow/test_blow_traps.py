"""What rounding gets wrong unless care is taken, each where the answer is known."""

import math

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from percuss.blow import BlowOutcome, Rock, Rod, Wall, strike
from percuss.errors import Interrupted
from percuss.halting import halting
from percuss.model import Bar, Section, SectionedBar, UniformBar


def unit_section(impedance, transit):
    """With E = ρ = 1 the length is the transit time, and the area the impedance."""
    return Section(transit, area=impedance, youngs_modulus=1.0, density=1.0)


def unit_bar(*sections):
    return SectionedBar([unit_section(z, tau) for z, tau in sections])


def pieces(blow):
    return len(blow.face_force.times) - 1


def test_arrivals_that_coincide_by_design_are_one():
    """0.1 + 0.2 is not 0.3 in floating point: still no pieces without width, and no peaks that are none."""
    whole = strike(unit_bar((1.0, 1.0), (2.0, 2.0), (1.5, 3.0)), Wall(), 1.0, until=100.0)
    tenths = strike(unit_bar((1.0, 0.1), (2.0, 0.2), (1.5, 0.3)), Wall(), 1.0, until=10.0)
    assert pieces(tenths) == pieces(whole)
    assert np.diff(tenths.face_force.times).min() > 0.01
    for one, other in zip(tenths.peaks, whole.peaks, strict=True):
        assert one.compression == pytest.approx(other.compression, rel=1e-12)
        assert one.tension == pytest.approx(other.tension, rel=1e-12)


@pytest.mark.parametrize("gap", [0.0, 1e-9, 0.1, 1.0 / 3.0, 2.0, 17.3])
def test_the_faces_meet_where_the_gap_is_0(gap):
    """A contact begins at gap/v, and is the same whenever it begins."""
    blow = strike(unit_bar((1.0, 0.5), (3.0, 0.7)), Wall(gap), 2.0, until=gap / 2.0 + 20.0)
    near = strike(unit_bar((1.0, 0.5), (3.0, 0.7)), Wall(), 2.0, until=20.0)
    assert blow.contacts[0].start == pytest.approx(0.5 * gap, abs=1e-15 * (1.0 + gap))
    assert blow.effective_restitution == pytest.approx(near.effective_restitution, abs=1e-12)
    assert len(blow.contacts) == len(near.contacts)


def test_a_touch_without_force_is_no_contact_but_is_counted():
    """Impedances 2:1, lengths 2:3 on a wall: the gap comes back to exactly 0 at seven fifths of a round trip."""
    blow = strike(unit_bar((2.0, 2.0), (1.0, 3.0)), Wall(), 1.0, until=40.0)
    other = strike(unit_bar((1.0, 2.0), (2.0, 3.0)), Wall(), 1.0, until=40.0)
    assert blow.grazes + other.grazes >= 1
    for one in (blow, other):
        least = min(spell.impulse for spell in one.contacts)
        assert least > 1e-6 * one.impulse
        assert sum(spell.impulse for spell in one.contacts) == pytest.approx(one.impulse, rel=1e-12)


ULP = np.spacing(1.0)


@settings(max_examples=30)
@given(
    steps=st.lists(st.integers(-12, 12), min_size=2, max_size=5),
    transits=st.lists(st.floats(0.2, 3.0), min_size=5, max_size=5),
    end=st.sampled_from(["free", "fixed"]),
)
@example(steps=[10, 0, 10], transits=[1.0] * 5, end="free")
def test_impedances_that_differ_by_rounding_are_one(steps, transits, end):
    """What such a step sends back closes no gap, however long it goes on: once a blow did not end for it."""

    def blow(most):
        sections = [
            unit_section(1.0 + min(most, abs(n)) * np.sign(n) * ULP, t) for n, t in zip(steps, transits, strict=False)
        ]
        return strike(SectionedBar(sections[:1]), Rod(sections[1:], end), 1.0, until=8.0)

    same, one = blow(12), blow(0)
    assert same.impulse == pytest.approx(one.impulse, abs=1e-12)
    assert same.striker_momentum_after == pytest.approx(one.striker_momentum_after, abs=1e-12)
    assert same.work_through_face == pytest.approx(one.work_through_face, abs=1e-12)


def test_a_load_at_a_bar_that_touches_the_wall():
    """Pushed from rest: 2 P at the wall for one round trip, nothing for the next, and so on; the gap stays 0."""
    blow = strike(unit_bar((1.0, 1.0)), Wall(), 0.0, until=10.5, load=[(0.0, 0.25)])
    assert [(one.start, one.end) for one in blow.contacts] == [(1.0, 3.0), (5.0, 7.0), (9.0, None)]
    assert [one.peak_force for one in blow.contacts] == [0.5] * 3
    assert blow.gap_after == 0.0
    assert blow.effective_restitution is None
    assert blow.outcome is BlowOutcome.STILL_IN_CONTACT


def test_a_load_that_pulls_ends_the_contact_when_its_wave_arrives():
    pulled = strike(unit_bar((1.0, 1.0)), Wall(), 1.0, until=4.0, load=[(0.0, -5.0)])
    assert [(one.start, one.end) for one in pulled.contacts] == [(0.0, 1.0)]


@pytest.mark.parametrize("mass", [0.0, 1e-7])
def test_a_bit_without_mass_moves_at_once_when_a_step_arrives(mass):
    """The rock force under two steps of a wave, F' = κ (2 Z f − F): 1 − e^{−κt}, then on toward the second step.

    A bit of almost no mass does the same but for its own short time.
    """
    stiffness, second = 0.8, 0.25
    # behind the head a section that sends a wave of `second` after one round trip through the head
    striker = unit_bar((1.0 / 3.0, 30.0), (1.0, 0.5))
    rod = Rod([unit_section(1.0, 40.0)], "rock", bit_mass=mass, rock=Rock(stiffness, 0.5))
    blow = strike(striker, rod, 1.0, until=43.0)
    heights = blow.waves_at(0.0).incident.at([0.5, 1.5])
    assert heights == pytest.approx([0.5, second], abs=1e-14)
    at_step = -math.expm1(-stiffness)
    turning = at_step - 2.0 * second
    assert turning > 0.0  # the second step is too low to load any further: the rock unloads at once
    later = 2.0 * second + turning * math.exp(-stiffness / 0.5 * 0.1)
    assert blow.bit_force.at(41.0 - 1e-9) == pytest.approx(at_step, abs=1e-6)
    assert blow.bit_force.at(41.1) == pytest.approx(later, abs=1e-12 if mass == 0.0 else 1e-5)
    assert blow.greatest_penetration == pytest.approx(at_step / stiffness, abs=1e-12 if mass == 0.0 else 1e-5)


def test_a_matched_rod_takes_everything_and_the_contact_ends():
    blow = strike(UniformBar(20.0), Rod.of_impedance(20.0), 1.0)
    assert blow.outcome in (BlowOutcome.OVER, BlowOutcome.SPENT)
    assert blow.contact_duration == pytest.approx(0.1, rel=1e-14)
    assert math.copysign(1.0, blow.effective_restitution) == 1.0
    assert blow.effective_restitution == 0.0


def test_a_striker_that_moves_away_never_strikes():
    blow = strike(unit_bar((1.0, 1.0), (2.0, 1.5)), Wall(), -1.0, until=5.0)
    assert blow.contacts == ()
    assert blow.impulse == 0.0
    assert (blow.contact_duration, blow.force_centroid) == (None, None)
    assert blow.gap_after == pytest.approx(5.0, rel=1e-14)


def test_too_many_pieces_cut_the_window_short_and_what_came_before_is_whole():
    striker = unit_bar((1.0, 1.0), (2.0, math.sqrt(2.0)), (5.0, math.pi), (1.0, 0.01))
    blow = strike(striker, Wall(), 1.0, until=60.0, most_pieces=2000)
    assert blow.outcome is BlowOutcome.TOO_MANY_PIECES
    assert 0.0 < blow.until < 60.0
    assert blow.energy_error < 1e-12
    assert blow.momentum_error < 1e-12


def test_a_blow_can_be_told_to_stop():
    striker = unit_bar((1.0, 1.0), (2.0, math.sqrt(2.0)), (5.0, math.pi), (1.0, 0.01))
    with halting(lambda: True), pytest.raises(Interrupted):
        strike(striker, Wall(), 1.0, until=60.0)


def test_no_window_is_asked_for_and_the_blow_ends_by_itself():
    """On a wall and on an endless rod it is proved to be over, and a longer window says the same."""
    striker = unit_bar((1.0, 1.0), (3.0, 0.7), (0.8, 1.1))
    for target in (Wall(), Rod([unit_section(2.0, None)]), Rod([unit_section(2.0, 3.0)], "free")):
        blow = strike(striker, target, 1.0)
        longer = strike(striker, target, 1.0, until=blow.until + 30.0)
        assert blow.outcome is BlowOutcome.OVER
        assert len(longer.contacts) == len(blow.contacts)
        assert longer.effective_restitution == pytest.approx(blow.effective_restitution, abs=1e-12)


def test_a_field_before_the_blow_is_the_striker_at_another_time():
    """A uniform striker in free flight, its field handed over in the middle of it."""
    bar = Bar(1.0, 1.0, 1.0, 1.0)
    whole = strike(bar, Wall(0.8), [1.0], until=6.0)
    for share in (0.25, 0.7):
        later = strike(
            bar, Wall(0.8 - share), field=(lambda x: np.ones_like(x), lambda x: np.zeros_like(x)), until=6.0 - share
        )
        assert later.contacts[0].start == pytest.approx(whole.contacts[0].start - share, abs=1e-14)
        assert later.effective_restitution == pytest.approx(whole.effective_restitution, abs=1e-13)


def test_kinetic_energy_of_a_field_with_strain():
    """v = 1 + cos πx, N = sin πx in a bar of unit numbers: kinetic energy 3/4, strain energy 1/4."""
    blow = strike(
        Bar(1.0, 1.0, 1.0, 1.0),
        Wall(),
        field=(lambda x: 1.0 + np.cos(np.pi * x), lambda x: np.sin(np.pi * x)),
        until=1.0,
    )
    assert blow.kinetic_energy_before == pytest.approx(0.75, rel=1e-12)
    assert blow.energy_before == pytest.approx(1.0, rel=1e-12)
