"""The far corners: sections a hundred thousand times thinner or shorter, hard and soft rock, late contacts."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import smooth_program
from blow_strategies import collisions, section, struck
from collisions import Collision
from percuss.blow import BlowOutcome, Rock, Rod, Wall, strike
from percuss.model import SectionedBar
from strategies import decades

WILD = decades(-2.5, 2.5)


def assert_sound(case: Collision) -> None:
    """Balances close, and nothing pulls."""
    blow = struck(case)
    assert blow.outcome is not BlowOutcome.TOO_MANY_PIECES
    assert abs(blow.energy_error) < 1e-11
    assert abs(blow.momentum_error) < 1e-11
    assert all(one.impulse > 0.0 and one.peak_force > 0.0 for one in blow.contacts)
    assert all(one.end is None or one.end > one.start for one in blow.contacts)
    assert all(one.end is not None and one.end <= two.start for one, two in pairwise(blow.contacts))


@settings(max_examples=25)
@given(case=collisions(impedances=WILD))
def test_thin_and_thick_sections(case: Collision) -> None:
    assert_sound(case)


@pytest.mark.parametrize("share", [1e-2, 1e-3, 1e-4])
def test_one_tiny_section_is_hardly_there(share: float) -> None:
    case = Collision(((1.0, 1.0), (2.0, 0.7)), (1.0, 1.0), 4.0, ((1.5, None),))
    tiny = replace(case, striker=((1.0, 1.0), (2.0, 0.7), (3.0, share)), velocity=(1.0, 1.0, 1.0))
    assert_sound(tiny)
    assert struck(tiny).impulse == pytest.approx(struck(case).impulse, rel=10.0 * share)


@pytest.mark.parametrize("stiffness", 10.0 ** np.arange(-6.0, 7.0, 2.0))
@pytest.mark.parametrize("bit_mass", [0.0, 1e-2, 1e2, 1e6])
@pytest.mark.parametrize("gamma", [0.05, 0.3, 1.0])
def test_rock_from_soft_to_hard_under_bits_from_light_to_heavy(stiffness: float, bit_mass: float, gamma: float) -> None:
    case = Collision(
        ((1.0, 1.0),), (1.0,), 8.0, ((1.0, 2.5),), "rock", k1=stiffness, gamma=gamma, bit_mass=bit_mass
    )  # fmt: skip
    assert_sound(case)
    blow = struck(case)
    assert 0.0 <= blow.efficiency <= 1.0 + 1e-12
    if bit_mass == 0.0:  # one rectangular wave of unit speed/2 and duration 2 (Lundberg 1973)
        beta = 2.0 * stiffness
        deepest = -math.expm1(-beta) / stiffness
        window = struck(replace(case, until=4.6))
        assert window.greatest_penetration == pytest.approx(deepest, rel=1e-9)


@pytest.mark.parametrize("stiffness", [1.0, 1e2, 1e4])
def test_a_bit_that_is_next_to_nothing_is_nothing(stiffness: float) -> None:
    """A millionth of the striker's mass: first order in it."""
    case = Collision(((1.0, 1.0),), (1.0,), 8.0, ((1.0, 2.5),), "rock", k1=stiffness, gamma=0.3)
    light, none = struck(replace(case, bit_mass=1e-6), most_pieces=1000), struck(case)
    assert light.outcome is not BlowOutcome.TOO_MANY_PIECES
    assert light.efficiency == pytest.approx(none.efficiency, rel=1e-2)


@pytest.mark.parametrize("impedance", [0.5, 0.05, 1e-3])
def test_a_striker_far_heavier_than_the_rod_gives_its_momentum_away_in_steps(impedance: float) -> None:
    striker, rod = SectionedBar([section(1.0, 1.0)]), Rod.of_impedance(impedance)
    blow = strike(striker, rod, 1.0, until=40.0)
    mu = (1.0 - impedance) / (1.0 + impedance)
    assert len(blow.contacts) == 1
    assert blow.contacts[0].end is None
    assert blow.mean_velocity_after == pytest.approx(mu**20, rel=1e-9)
    steps = impedance * mu ** np.arange(20) / (1.0 + impedance)
    assert blow.face_force.at(2.0 * np.arange(20) + 1.0) == pytest.approx(steps, rel=1e-9)


@pytest.mark.parametrize("gap", [1.0, 1e3, 9e5])
def test_a_gap_that_closes_late(gap: float) -> None:
    striker = SectionedBar([section(1.0, 1.0)])
    blow = strike(striker, Wall(gap), 1.0, until=gap + 5.0)
    assert len(blow.contacts) == 1
    contact = blow.contacts[0]
    assert contact.start == pytest.approx(gap, rel=1e-12)
    assert contact.end == pytest.approx(gap + 2.0, rel=1e-12)
    assert blow.effective_restitution == pytest.approx(1.0, abs=1e-12)


@settings(max_examples=20)
@given(speeds=st.lists(st.floats(-1.0, 1.0), min_size=2, max_size=5))
def test_sections_that_move_apart_and_together(speeds: list[float]) -> None:
    striker = tuple((1.0 + 0.3 * i, 1.0 + 0.17 * i) for i in range(len(speeds)))
    assert_sound(Collision(striker, (*speeds[:-1], abs(speeds[-1]) + 0.1), 12.0, ((2.0, None),)))


@pytest.mark.parametrize("force", [-0.5, -2.0])
def test_a_load_that_pulls_the_striker_off(force: float) -> None:
    """The face is left earlier than by the striker's own waves, and nothing pulls the rod."""
    case = Collision(((1.0, 1.0),), (1.0,), 6.0, ((0.3, None),), load=((0.0, force),))
    assert_sound(case)
    blow, free = struck(case), struck(replace(case, load=()))
    assert blow.impulse < free.impulse
    assert blow.contacts[0].end is not None


def test_a_load_that_pushes_holds_the_striker_on_the_wall() -> None:
    """A steady push on a bar at a wall brings it back, blow after blow, as a ball on a floor."""
    case = Collision(((1.0, 1.0),), (0.1,), 100.0, load=((0.0, 0.2),))
    assert_sound(case)
    assert len(struck(case).contacts) > 5


@pytest.mark.parametrize("sections", [2, 3, 4])
def test_incommensurable_lengths_do_not_make_pieces_without_end(sections: int) -> None:
    roots = np.sqrt([2.0, 3.0, 5.0, 7.0, 11.0, 13.0, 17.0, 19.0])[:sections]
    striker = tuple((1.0 + i % 3, tau) for i, tau in enumerate(roots))
    case = Collision(striker, (1.0,) * sections, 6.0 * float(roots.sum()), ((2.0, 1.7), (1.5, None)))
    blow = struck(case)
    assert abs(blow.energy_error) < 1e-10
    assert blow.outcome is not BlowOutcome.TOO_MANY_PIECES


def test_more_pieces_than_allowed_end_the_window_and_what_is_told_is_sound() -> None:
    roots = np.sqrt([2.0, 3.0, 5.0, 7.0, 11.0, 13.0, 17.0, 19.0])
    striker = tuple((1.0 + i % 3, float(tau)) for i, tau in enumerate(roots))
    case = Collision(striker, (1.0,) * 8, 6.0 * float(roots.sum()), ((2.0, 1.7), (1.0, 2.9), (1.5, None)))
    blow = struck(case, most_pieces=50_000)
    assert blow.outcome is BlowOutcome.TOO_MANY_PIECES
    assert blow.until < case.until
    assert abs(blow.energy_error) < 1e-11
    assert abs(blow.momentum_error) < 1e-11


def test_rock_whose_force_rises_in_a_thousandth_of_a_wave() -> None:
    """The bit on hard rock, to the digits of the smooth program."""
    case = Collision(
        ((1.0, 1.0),), (1.0,), 5.0, ((1.0, 1.0),), "rock", k1=200.0, gamma=0.5, bit_mass=1e-2
    )  # fmt: skip
    blow, other = struck(case), smooth_program.blow(case)
    assert other.bit is not None
    assert blow.rock_work == pytest.approx(other.bit.work, rel=1e-8)
    assert blow.greatest_penetration == pytest.approx(other.bit.deepest, rel=1e-8)
    assert blow.impulse == pytest.approx(other.impulse, rel=1e-8)


def test_a_bar_on_rock_in_the_dimensionless_form_of_a_rod() -> None:
    """Rock directly under a rod as long as nothing: a rod of a thousandth of the striker is nearly none."""
    striker = SectionedBar([section(1.0, 1.0)])
    ends = []
    for time in (1e-2, 1e-3):
        rod = Rod([section(1.0, time)], "rock", rock=Rock(1.0, unloading_ratio=0.5))
        ends.append(strike(striker, rod, 1.0, until=2.0).greatest_penetration)
    assert ends[1] == pytest.approx(-math.expm1(-2.0), rel=5e-3)
    assert abs(ends[1] + math.expm1(-2.0)) < abs(ends[0] + math.expm1(-2.0))
