"""Fatigue by a blow: the standard's example, pulses of known cycles, Goodman and Miner by hand, sampled waves."""

from __future__ import annotations

import math
import sys
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from percuss.blow import Fatigue, Rod, Steel, Wall, cycles_of, fatigue, strike
from percuss.case import blow_answer, load_case
from percuss.errors import MissingExtraError, ParameterError
from percuss.model import Bar, Section, UniformBar

STEEL = Steel(900e6, 360e6, 6.0)


def ringing(speed: float, steel: Steel = STEEL, **notches: float) -> Fatigue:
    """A striker on a free rod three times as long and of its section: its pulse goes to and fro in the rod, twice."""
    bar = Bar(0.5, 1e-3)
    blow = strike(bar, Rod([Section(1.5, area=1e-3)], "free"), speed, until=4 * 3 * bar.transit_time)
    return fatigue(blow, steel, notches=notches)


def pulse(speed: float) -> float:
    """ρ c v/2 of the steel of a bar."""
    bar = Bar(0.5, 1e-3)
    return 0.5 * math.sqrt(bar.youngs_modulus * bar.density) * speed


def counted(history: list[float]) -> dict[float, float]:
    """How often each range comes."""
    found: dict[float, float] = {}
    for size, _, count in cycles_of(history):
        found[float(size)] = found.get(float(size), 0.0) + float(count)
    return found


def test_rainflow_counts_the_example_of_the_standard() -> None:
    """ASTM E1049-85, 5.4.5: −2, 1, −3, 5, −1, 3, −4, 4, −2, which repeats."""
    history = [-2.0, 1.0, -3.0, 5.0, -1.0, 3.0, -4.0, 4.0, -2.0]
    assert counted(history) == {3.0: 1.0, 4.0: 1.0, 7.0: 1.0, 9.0: 1.0}
    assert counted(history[3:] + history[:3]) == counted(history)  # it has no beginning
    between = [value for a, b in pairwise(history) for value in (a, 0.5 * (a + b), a * 0.4 + b * 0.6)]
    assert counted(between) == counted(history)
    assert counted([3.0, 3.0, 3.0]) == {}


def test_a_pulse_in_an_endless_rod_is_one_cycle_of_compression() -> None:
    bar, rod = Bar(0.5, 1e-3), Rod([Section(None, area=1e-3)])
    own, there = fatigue(strike(bar, rod, 10.0), STEEL).sections
    for one in (own, there):
        assert (one.range, one.mean) == pytest.approx((pulse(10.0), -0.5 * pulse(10.0)), rel=1e-12)
        assert one.factor == pytest.approx(360e6 / (0.5 * pulse(10.0)), rel=1e-12)
        assert (one.damage, one.blows, one.over) == (0.0, None, 0.0)
    # at the free end there is no stress; everywhere else the pulse passes
    assert np.isinf(own.factors[0]) and own.factors[1:-1] == pytest.approx(own.factor)


def test_a_pulse_that_comes_back_from_a_free_end_has_twice_the_range_and_no_mean() -> None:
    """It passes as compression, tension, compression, tension: two cycles of amplitude ρ c v/2 in every blow."""
    found, stress = ringing(20.0), pulse(20.0)
    worst = found.governing
    assert (worst.name, worst.range, worst.over) == ("rod 0", pytest.approx(2.0 * stress, rel=1e-9), 2.0)
    assert worst.mean == pytest.approx(0.0, abs=1e-6 * stress) and worst.factor == pytest.approx(360e6 / stress)
    assert worst.damage == pytest.approx(2.0 / 1e6 * (stress / 360e6) ** 6.0, rel=1e-9)
    assert worst.blows == pytest.approx(1.0 / worst.damage)
    striker = found.sections[0]
    assert striker.range == pytest.approx(stress) and striker.damage == 0.0


def test_damage_grows_as_the_power_of_the_speed_that_the_slope_is() -> None:
    assert ringing(40.0).governing.damage == pytest.approx(2.0**6 * ringing(20.0).governing.damage, rel=1e-9)
    # a notch does as much as so much more speed, mean included; the line to a thousand cycles is steeper
    steep = Steel(1000e6)
    assert steep.slope == pytest.approx(3.0 / math.log10(0.75 / 0.40))
    one, other = ringing(20.0, steep, **{"rod 0": 1.5}).sections[1], ringing(30.0, steep).sections[1]
    assert (one.range, one.damage) == pytest.approx((other.range, other.damage))


def test_goodman_and_miner_by_hand() -> None:
    equivalent = STEEL.equivalent(np.array([300e6, 300e6, 300e6, 1.0]), np.array([0.0, 225e6, -225e6, 900e6]))
    assert equivalent.tolist() == pytest.approx([300e6, 400e6, 300e6, np.inf])  # 300/(1 − 225/900)
    # 2 cycles of 1.2 times the limit, and 10 of half of it, on Haibach's slope 2 · 6 − 1
    mixed = STEEL.damage(np.array([432e6, 180e6]), np.array([2.0, 10.0]))
    assert mixed == pytest.approx((2.0 * 1.2**6 + 10.0 * 0.5**11) / 1e6)
    assert STEEL.damage(np.array([360e6, 180e6]), np.array([2.0, 10.0])) == 0.0  # none exceeds the limit
    assert STEEL.damage(np.array([np.inf]), np.array([0.5])) == np.inf


def test_turning_points_are_those_of_the_waves_sampled_finely() -> None:
    """On rock, where pieces of waves are bent; ranges of rainflow agree, and no sample is outside."""
    blow = blow_answer(load_case("valve-breaker")).blow
    length = blow.target.pieces[0].end
    times = np.linspace(0.0, blow.until, 400_001)
    for share in (0.0, 0.3, 0.731):
        waves = blow.waves_at(share * length)
        sampled = waves.incident.at(times) + waves.reflected.at(times)
        (exact,) = blow.force_turns(1, np.array([share]))
        top = exact.max() - exact.min()
        assert sampled.max() <= exact.max() + 1e-9 * top and sampled.min() >= exact.min() - 1e-9 * top
        one, two = (np.sort(cycles_of(force)[:, 0])[::-1] for force in (exact, sampled))
        assert two[:20] == pytest.approx(one[:20], abs=1e-3 * top)


@pytest.mark.parametrize("case", ["laboratory-striker", "valve-drifter", "dth-4-inch"])
def test_no_place_has_more_range_than_the_exact_peaks_of_its_section(case: str) -> None:
    blow = blow_answer(load_case(case)).blow
    found = fatigue(blow, STEEL)
    for one, peak in zip(found.sections, blow.peaks, strict=True):
        assert one.range <= (peak.compression + peak.tension) * (1.0 + 1e-9)
        assert one.range >= max(peak.compression, peak.tension) * (1.0 - 1e-2)
        assert one.factor == one.factors.min() and one.place in one.places
    finer = fatigue(blow, STEEL, size=100)
    assert finer.governing.factor == pytest.approx(found.governing.factor, rel=0.02)


def test_what_is_refused() -> None:
    blow = strike(Bar(0.5, 1e-3), Wall(), 10.0)
    for wrong, said in (
        ({"fatigue_limit": 900e6}, "fatigue_limit = 900000000.0: expected an amplitude below the tensile strength"),
        ({"slope": 0.0}, "slope = 0.0: expected a number of at least 1"),
        ({"fatigue_limit": 800e6, "slope": None}, "slope = None: expected a slope beside a fatigue limit so near"),
        ({"knee": 1e3}, "knee = 1000.0: expected a number of at least"),
    ):
        with pytest.raises(ParameterError, match=said):
            replace(STEEL, **wrong)
    with pytest.raises(ParameterError, match="notches = 'rod 0': expected sections of striker and rod: striker 0"):
        fatigue(blow, STEEL, notches={"rod 0": 2.0})
    with pytest.raises(ParameterError, match=r"notches = 0\.5: expected a number of at least 1"):
        fatigue(blow, STEEL, notches={"striker 0": 0.5})
    with pytest.raises(ParameterError, match="a dimensionless one has no stresses"):
        fatigue(strike(UniformBar(1.0), Wall(), 1.0), STEEL)
    with pytest.raises(ParameterError, match="0 in an endless section"):
        strike(Bar(0.5, 1e-3), Rod([Section(None, area=1e-3)]), 1.0).force_turns(1, np.array([0.5]))


def test_the_package_that_counts_is_told_where_it_is_not_installed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "rainflow", None)
    with pytest.raises(MissingExtraError, match=r"'rainflow' is needed for this — pip install 'percuss\[io\]'"):
        cycles_of([0.0, 1.0])
