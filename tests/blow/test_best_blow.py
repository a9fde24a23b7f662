"""The search for the best blow: known optima, the bound that no wave of its length passes, limits, seeds, refusals."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from percuss.blow import Rock, Rod, strike
from percuss.blow.best import OBJECTIVES, best_blow
from percuss.blow.closed_forms import BEST_BETA, best_efficiency, matched_efficiency
from percuss.blow.figures import FIGURES
from percuss.errors import Interrupted, ParameterError
from percuss.model import Bar, Section, SectionedBar

AREA, STIFFNESS, RATIO = 1.1e-3, 8e8, 0.3
STEEL = Bar(1.0, AREA)
MODULUS, SPEED = STEEL.youngs_modulus, math.sqrt(STEEL.youngs_modulus / STEEL.density)
BEST_LENGTH = BEST_BETA * AREA * MODULUS / (2.0 * STIFFNESS)
"""Lundberg's β = 2 K L/(AE) of a matched hammer."""


def rod():
    """Its reflected waves come back to the rock after the window."""
    return Rod([Section(2.0, area=AREA)], "rock", rock=Rock(STIFFNESS, RATIO))


def matched(values, velocity=10.0):
    return strike(Bar(values[0], AREA), rod(), velocity, until=5.0 / SPEED)


def test_lundbergs_hammer_is_found():
    found = best_blow(matched, [(0.02, 0.6)], "efficiency", most=200)
    assert found.allowed and found.values[0] == pytest.approx(BEST_LENGTH, rel=1e-4)
    assert found.value == pytest.approx(matched_efficiency(BEST_BETA, RATIO), rel=1e-7)
    assert found.value == pytest.approx(0.8145287552 * (1.0 - RATIO), rel=1e-7)


@pytest.mark.parametrize("seed", [0, 3])
def test_no_sections_pass_the_best_wave_of_their_length(seed):
    """The exponential wave is the best of its duration (Lundberg & Collet 2010); sections can only come near it."""

    def struck(values):
        sections = [Section(length, area=area * AREA) for length, area in zip(values[:2], values[2:], strict=True)]
        return strike(SectionedBar(sections), rod(), 10.0, until=5.0 / SPEED)

    found = best_blow(struck, [(0.05, 0.3), (0.05, 0.3), (0.2, 1.0), (0.2, 1.0)], "efficiency", most=250, seed=seed)
    pulse = found.blow.first_pulse
    assert pulse is not None
    wave = FIGURES["incident_energy"].value(found.blow)
    beta = STIFFNESS * pulse.length / found.blow.target.end_impedance
    assert found.blow.rock_work <= wave * best_efficiency(beta, RATIO) * (1.0 + 1e-9)
    assert found.value > 0.9 * matched_efficiency(BEST_BETA, RATIO)


def test_the_limit_of_stress_is_kept_and_reached():
    """A matched hammer of speed v: stress E v/(2 c), and 0 beyond what the rock sends back; the fastest is the best."""

    def struck(values):
        return matched((0.2,), velocity=values[0])

    unlimited = best_blow(struck, [(2.0, 20.0)], "rock-energy", most=120)
    assert unlimited.values[0] == pytest.approx(20.0, rel=1e-5)
    limit = 0.5 * FIGURES["peak_stress"].value(unlimited.blow)
    found = best_blow(struck, [(2.0, 20.0)], "rock-energy", below=limit, most=120)
    assert FIGURES["peak_stress"].value(found.blow) <= limit
    assert found.allowed and found.values[0] == pytest.approx(10.0, rel=1e-4)


def test_a_limit_that_nothing_keeps_is_said():
    found = best_blow(lambda values: matched((0.2,), values[0]), [(5.0, 10.0)], below=1e6, most=60)
    assert not found.allowed and found.values[0] == pytest.approx(5.0, rel=1e-3)


def test_the_least_stress():
    found = best_blow(lambda values: matched((0.2,), values[0]), [(5.0, 10.0)], "peak-stress", most=60)
    assert found.values[0] == pytest.approx(5.0, rel=1e-4)


def test_the_seed_repeats_a_search_and_the_first_place_is_never_lost():
    first, again = (best_blow(matched, [(0.02, 0.6)], most=40, seed=7) for _ in range(2))
    assert first.values == again.values and first.blows == again.blows
    found = best_blow(matched, [(0.02, 0.6)], "efficiency", first=[BEST_LENGTH], most=20)
    assert found.value >= matched((BEST_LENGTH,)).efficiency


@settings(max_examples=5)
@given(low=st.tuples(*[st.floats(0.05, 0.2)] * 2), wide=st.tuples(*[st.floats(0.01, 0.3)] * 2), seed=st.integers(0, 99))
def test_every_blow_is_inside_the_ranges_and_none_is_better(low, wide, seed):
    """Of all that were tried, the best one is what is found; it is about as good as the best of a coarse grid.

    There are ridges where waves meet, and 150 blows are few.
    """
    ranges = [(a, a + b) for a, b in zip(low, wide, strict=True)]
    tried = []

    def struck(values):
        sections = [Section(values[0], area=AREA), Section(values[1], area=0.6 * AREA)]
        blow = strike(SectionedBar(sections), rod(), 10.0, until=5.0 / SPEED)
        tried.append((values, blow.rock_work))
        return blow

    found = best_blow(struck, ranges, most=150, seed=seed)
    assert found.complete and found.blows == len(tried)
    assert (found.values, found.value) in tried and found.value == max(value for _, value in tried)
    assert all(a <= x <= b for values, _ in tried for x, (a, b) in zip(values, ranges, strict=True))
    grid = [struck((x, y)).rock_work for x in np.linspace(*ranges[0], 9) for y in np.linspace(*ranges[1], 9)]
    assert found.value >= 0.98 * max(grid)


@pytest.mark.parametrize("after", [1, 7, 35])
def test_what_is_ended_keeps_the_best_so_far(after):
    tried = []

    def struck(values):
        tried.append(matched(values))
        return tried[-1]

    found = best_blow(struck, [(0.02, 0.6)], most=40, progress=lambda now: now.tried >= after)
    assert not found.complete and found.blows == after == len(tried)
    assert found.value == max(blow.rock_work for blow in tried)


def test_what_is_ended_before_it_began_is_interrupted():
    with pytest.raises(Interrupted, match="nothing has been found yet"):
        best_blow(matched, [(0.1, 0.2)], most=40, progress=lambda now: True)


def endless(values):
    """Sections that have no common measure, on rock: ever more pieces, of which few are allowed."""
    sections = [Section(values[0], area=AREA), Section(0.0877, area=2 * AREA), Section(0.1313, area=0.5 * AREA)]
    return strike(SectionedBar(sections), rod(), 10.0, until=50.0 / SPEED, most_pieces=1000)


def test_refusals_and_the_end():
    for ranges in ([], [(1.0, 1.0)], [(2.0, 1.0)], [(0.1, math.inf)]):
        with pytest.raises(ParameterError):
            best_blow(matched, ranges)
    with pytest.raises(ParameterError, match="rock-energy"):
        best_blow(matched, [(0.1, 0.2)], "beauty")
    with pytest.raises(ParameterError, match="the last refusal"):
        best_blow(lambda values: matched((-values[0],)), [(0.1, 0.2)], most=20)
    with pytest.raises(ParameterError, match="too many pieces"):
        best_blow(endless, [(0.1, 0.2)], most=20)
    assert {figure for figure, _ in OBJECTIVES.values()} <= set(FIGURES)
