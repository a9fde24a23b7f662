"""Where rounding goes wrong unless care is taken, and the far corners: thin, short, heavy, hard, late."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from numba import njit
from numpy.polynomial import chebyshev

import smooth_program
from blow_strategies import collisions, section, struck
from collisions import Collision
from percuss.blow import BlowOutcome, Rock, Rod, Wall, strike
from percuss.blow.figures import Fineness
from percuss.blow.kernels.rows import joined
from percuss.blow.kernels.wave_records import APART, MOST_JOINED, WIDTH
from percuss.errors import Interrupted
from percuss.halting import halting
from percuss.model import Bar, Section, SectionedBar, UniformBar
from strategies import decades

# -- what rounding gets wrong unless care is taken, each where the answer is known


def unit_bar(*sections):
    return SectionedBar([section(z, tau) for z, tau in sections])


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
            section(1.0 + min(most, abs(n)) * np.sign(n) * ULP, t) for n, t in zip(steps, transits, strict=False)
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
    rod = Rod([section(1.0, 40.0)], "rock", bit_mass=mass, rock=Rock(stiffness, 0.5))
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


def test_a_blow_can_be_told_to_stop():
    striker = unit_bar((1.0, 1.0), (2.0, math.sqrt(2.0)), (5.0, math.pi), (1.0, 0.01))
    with halting(lambda: True), pytest.raises(Interrupted):
        strike(striker, Wall(), 1.0, until=60.0)


def test_no_window_is_asked_for_and_the_blow_ends_by_itself():
    """On a wall and on an endless rod it is proved to be over, and a longer window says the same."""
    striker = unit_bar((1.0, 1.0), (3.0, 0.7), (0.8, 1.1))
    for target in (Wall(), Rod([section(2.0, None)]), Rod([section(2.0, 3.0)], "free")):
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


# -- the far corners: sections a hundred thousand times thinner or shorter, hard and soft rock, late contacts


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
    for most in (2000, 50_000):
        blow = struck(case, most_pieces=most)
        assert blow.outcome is BlowOutcome.TOO_MANY_PIECES
        assert 0.0 < blow.until < case.until
        assert blow.fineness is Fineness.COARSE
        assert max(blow.energy_error, blow.momentum_error) < 2e-3


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


# -- pieces of waves that are joined -----------------------------------------------------------------------------------


_joined: Any = njit(joined.py_func)  # by itself it can be called by compiled functions only
SERIES = st.lists(st.floats(-1.0, 1.0), min_size=2, max_size=7)
SHARES = st.floats(0.02, 0.98)


def part(whole: np.ndarray, low: float, high: float) -> np.ndarray:
    """A series on a part of [−1, 1], by interpolation."""
    middle, half = 0.5 * (low + high), 0.5 * (high - low)
    return chebyshev.chebinterpolate(lambda x: chebyshev.chebval(middle + half * x, whole), whole.size - 1)


def result(p: np.ndarray, c: np.ndarray, share: float, spent: float = 0.0) -> tuple[np.ndarray | None, float]:
    """What p and c, which are on so much of the interval and on the rest, are joined to, and the error it tells."""
    out, work = np.zeros(WIDTH), np.zeros((3, WIDTH))
    room = [np.pad(one, (0, WIDTH - one.size)) for one in (p, c)]
    degree, error = _joined(room[0], p.size - 1, share, room[1], c.size - 1, 1.0 - share, spent, APART, out, work)
    return (None if degree < 0 else out[: degree + 1], error)


def distance(found: np.ndarray, p: np.ndarray, c: np.ndarray, share: float) -> float:
    """The greatest difference from both, on a fine grid."""
    x = np.linspace(-1.0, 1.0, 201)
    first = chebyshev.chebval(share * (1.0 + x) - 1.0, found) - chebyshev.chebval(x, p)
    second = chebyshev.chebval(share + (1.0 - share) * x, found) - chebyshev.chebval(x, c)
    return float(max(abs(first).max(), abs(second).max()))


@given(series=SERIES, share=SHARES)
def test_two_parts_of_one_polynomial_are_joined_to_it(series: list[float], share: float) -> None:
    whole, cut = np.array(series), 2.0 * share - 1.0
    found, error = result(part(whole, -1.0, cut), part(whole, cut, 1.0), share)
    assert found is not None
    assert found.size <= MOST_JOINED + 1
    difference = np.zeros(max(found.size, whole.size))
    difference[: found.size] = found
    difference[: whole.size] -= whole
    assert abs(difference).sum() < 1e-13
    assert error <= APART


@given(series=SERIES, share=SHARES, bends=st.lists(st.floats(-18.0, -8.0), min_size=1, max_size=4))
def test_what_is_joined_is_within_the_bound_and_tells_its_error(
    series: list[float], share: float, bends: list[float]
) -> None:
    """The second part differs by powers of the time from the first, small or not."""
    whole, cut = np.array(series), 2.0 * share - 1.0
    p, c = part(whole, -1.0, cut), part(whole, cut, 1.0)
    for k, size in enumerate(bends):
        power = chebyshev.chebpow(np.array([0.5, 0.5]), k)  # ((1 + x)/2)^k, flat where it begins
        c = chebyshev.chebadd(c, 10.0**size * power)
    found, error = result(p, c, share)
    if found is None:
        assert error == 0.0
    else:
        apart = distance(found, p, c, share)
        assert apart <= error + 1e-15 * (1.0 + abs(whole).sum())
        assert error <= APART


@given(series=SERIES, share=SHARES)
def test_what_jumps_is_not_joined(series: list[float], share: float) -> None:
    whole, cut = np.array(series), 2.0 * share - 1.0
    c = part(whole, cut, 1.0)
    c[0] += 4.0 * APART
    assert result(part(whole, -1.0, cut), c, share)[0] is None


def test_errors_of_one_piece_add_up_to_the_bound_and_no_further() -> None:
    whole = np.array([0.3, 0.2, 0.1])
    p, c = part(whole, -1.0, 0.0), part(whole, 0.0, 1.0)
    assert result(p, c, 0.5)[0] is not None
    assert result(p, c, 0.5, spent=1.1 * APART)[0] is None


def drilled(bit_mass: float) -> Any:
    """Three sections and two, in sizes of a drifter, for twenty transits of the piston."""
    sizes = ((0.0731, 0.04), (0.2187, 0.05), (0.1493, 0.03478))
    piston = SectionedBar([Section(length, diameter=d, youngs_modulus=206e9) for length, d in sizes])
    rod = [Section(0.4, diameter=0.045), Section(1.1, diameter=0.038)]
    rock = Rock(4e8, unloading_ratio=0.3)
    return strike(piston, Rod(rod, "rock", bit_mass=bit_mass, rock=rock), 10.0, until=20.0 * piston.transit_time)


@pytest.mark.parametrize(("bit_mass", "most"), [(1.5, 130_000), (1e-6, 260_000)])
def test_the_waves_of_a_drifter_have_no_pieces_but_those_that_they_need(bit_mass: float, most: int) -> None:
    """Unjoined, the first has 267 000; the second more than a window may have, unless fast motions are let go."""
    blow = drilled(bit_mass)
    assert blow.outcome is not BlowOutcome.TOO_MANY_PIECES
    assert blow._course.held.waves.pieces.sum() < most
    assert abs(blow.energy_error) < 1e-12
    assert abs(blow.momentum_error) < 1e-12


# -- waves in too many pieces ------------------------------------------------------------------------------------------


@settings(max_examples=6, deadline=None)
@given(seed=st.integers(0, 1000))
def test_less_fine_waves_have_the_energies_of_the_exact_ones(seed: int) -> None:
    """The exact blow, in a window that it is soon through, is the oracle; stresses only where no time is left out."""
    lengths = np.round(np.array([0.11, 0.22, 0.13, 0.4, 1.0]) * np.random.default_rng(seed).uniform(0.8, 1.2, 5), 4)
    piston = SectionedBar([Section(x, diameter=d) for x, d in zip(lengths, (0.038, 0.056, 0.04), strict=False)])
    steel = [Section(lengths[3], diameter=0.045), Section(lengths[4], diameter=0.038)]
    rod = Rod(steel, "rock", rock=Rock(4e8, unloading_ratio=0.3))
    exact, smoothed, coarse = (strike(piston, rod, 10.0, until=2e-3, few_pieces=n) for n in (None, 60_000, 1))
    assert (exact.fineness, smoothed.fineness, coarse.fineness) == tuple(Fineness)
    for blow, near in ((smoothed, 3e-4), (coarse, 2e-3)):
        assert max(blow.energy_error, blow.momentum_error) < near
        assert blow.rock_work == pytest.approx(exact.rock_work, rel=near)
        assert blow.effective_restitution == pytest.approx(exact.effective_restitution, abs=near)
        assert blow.vibration_energy_after == pytest.approx(
            exact.vibration_energy_after, abs=near * exact.energy_before
        )
    for one, other in zip(smoothed.peaks, exact.peaks, strict=True):
        assert max(one.compression, one.tension) == pytest.approx(max(other.compression, other.tension), rel=1e-2)
