"""The search for orbits: what it finds, what it drops and why, and that it finds each orbit once."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from orbit_cases import ENTRIES, numbers, system_of, times_of
from percuss import Load, System, steady_states
from percuss.errors import Interrupted, LoadError, ParameterError, ResonanceError
from percuss.halting import halting
from percuss.steady import Drop, FoundOrbits, Reason, orbits
from percuss.steady.oscillator import PI
from percuss.steady.periodic.impact_chain import ImpactChain
from percuss.steady.periodic.periodic_orbit import canonical, differences, load_turn, repeats

TURN = 2.0 * math.pi
HAMMER = System(s=5.0, d=0.0, restitution=0.5, load=Load.harmonic(0.62, 1.0))


def check(found) -> None:
    """What holds of every search."""
    assert found.tries == (0 if found.complete else len(found.orbits) + sum(found.dropped.values()))
    assert all(orbit.admissible and orbit.residual < 1e-11 for orbit in found.orbits)
    assert all(not orbit.admissible or orbit.resonant_modes for orbit in found.impossible)
    assert all(0.0 <= orbit.times[0] < TURN for orbit in found.orbits)
    assert all(repeats(np.array(orbit.times), orbit.period, TURN) == 1 for orbit in found.orbits)


@pytest.mark.parametrize("label", list(ENTRIES["count"]["counts"]))
def test_as_many_as_the_figures_say(label: str) -> None:
    p, n = (int(part) for part in label[2:].split("/"))
    found = orbits(system_of(ENTRIES["count"]), p, n, modes=0, tries=200)
    assert len(found.orbits) == ENTRIES["count"]["counts"][label]
    assert found.label == label
    assert found.unseen == 0.0
    if p > 1:
        check(found)


@pytest.mark.parametrize("name", ["elastic_22", "three_in_two", "three_steps", "square_elastic", "four_per_period"])
def test_orbits_of_the_figures_are_found_without_a_guess(name: str) -> None:
    entry = ENTRIES[name]
    p, n = (int(part) for part in entry["label"][2:].split("/"))
    found = orbits(system_of(entry), p, n, modes=entry["system"]["modes"], tries=300)
    check(found)
    met = [orbit for orbit in found.orbits if np.allclose(orbit.times, times_of(entry), rtol=0.0, atol=1e-11)]
    assert len(met) == 1
    assert met[0].speeds == pytest.approx(numbers(entry, "speed"), rel=0, abs=1e-11)


def test_one_impact_is_found_exactly_and_completely() -> None:
    system = System(s=5.0, d=0.01, restitution=0.6, load=Load.fourier([0.3, 1.0, 0.8j, -0.6]))
    found = orbits(system, 1, 1, modes=8)
    motions = steady_states(system, 1, modes=8).orbits
    assert found.complete
    assert (found.tries, found.unseen) == (0, 0.0)
    assert [orbit.phase for orbit in found.orbits] == [motion.phase for motion in motions if motion.admissible]
    assert [orbit.phase for orbit in found.impossible] == [motion.phase for motion in motions if not motion.admissible]
    assert sum(found.dropped.values()) == len(found.impossible) > 0


def test_seeds_do_not_matter_where_all_is_found() -> None:
    lists = [orbits(HAMMER, 3, modes=0, tries=200, seed=seed).orbits for seed in (1, 2)]
    assert [len(one) for one in lists] == [2, 2]
    for one, other in zip(*lists, strict=True):
        assert one.times == pytest.approx(other.times, abs=1e-11)
    again = orbits(HAMMER, 3, modes=0, tries=200, seed=1).orbits
    assert [one.times for one in again] == [one.times for one in lists[0]]


def test_repeats_of_shorter_orbits_are_dropped() -> None:
    """Before its first flip z=1/1 has no double; behind it z=2/2 is another orbit."""
    flip = float(ENTRIES["cascade"]["points"][0]["value"])
    before = orbits(HAMMER.with_load_factor(flip + 1e-3), 2, 2, modes=0, tries=200)
    behind = orbits(HAMMER.with_load_factor(flip - 1e-3), 2, 2, modes=0, tries=200)
    assert before.dropped[Drop.REPEAT] > 0
    assert behind.dropped[Drop.REPEAT] > 0
    assert len(behind.orbits) == len(before.orbits) + 1
    double = min(behind.orbits, key=lambda orbit: abs(np.ptp(orbit.phases)))
    assert double.phases == pytest.approx([2.386] * 2, abs=0.1)
    check(before)
    check(behind)


def test_what_passes_the_wall_or_strikes_backwards_is_told_of() -> None:
    system = System(s=5.0, d=0.0, restitution=1.0, load=Load.harmonic(0.3, 1.0))
    found = orbits(system, 2, modes=0, tries=100)
    check(found)
    assert {orbit.obstacle for orbit in found.impossible} == {Reason.NO_BLOW, Reason.THROUGH_WALL}
    assert {Drop.NO_BLOW, Drop.THROUGH_WALL, Drop.COALESCED} <= set(found.dropped)
    assert found.unseen is None
    assert str(found).startswith("z=2/1: 0 orbits with 0 modes in 100 tries")


def test_a_share_that_few_tries_did_not_see_has_its_exact_bound() -> None:
    """Where 0 of n were met once, (1 − bound)ⁿ is 5 %; else as many or fewer have (Clopper and Pearson 1934)."""
    for ended, once in ((1, 0), (2, 0), (7, 0), (400, 0), (2, 1), (9, 4), (400, 37), (30, 30)):
        bound = FoundOrbits(HAMMER, 2, 1, 0, (), (), ended, {}, once / ended, False, ended=ended).unseen_bound
        assert bound is not None
        if once == ended:
            assert bound == 1.0
            continue
        share = Fraction(bound)
        below = sum(math.comb(ended, j) * share**j * (1 - share) ** (ended - j) for j in range(once + 1))
        assert float(below) == pytest.approx(0.05, rel=1e-9)
    told = str(FoundOrbits(HAMMER, 2, 1, 0, (), (), 2, {}, 0.0, False, ended=2))
    assert "unseen share 0, at most 0.78 (with 95 %, by 2 tries that ended at an orbit)" in told
    assert FoundOrbits(HAMMER, 1, 1, 0, (), (), 0, {}, 0.0, True).unseen_bound == 0.0


def test_an_odd_number_of_full_rebounds_leaves_every_mode_in_resonance() -> None:
    """R = 1, d = 0: a mode's cycle is a reflection then, which keeps one of its states."""
    system = System(s=5.0, d=0.0, restitution=1.0, load=Load.harmonic(0.3, 1.0))
    found = orbits(system, 3, modes=2, tries=60)
    assert not found.orbits
    assert found.dropped[Drop.RESONANT] > 0
    assert all(orbit.resonant_modes == (1, 2) for orbit in found.impossible)


@pytest.mark.parametrize("load", [Load.harmonic(0.62, 1.0), Load.fourier([0.5, 1.0, 0.3j])])
@pytest.mark.parametrize("off", [1e-3, -1e-5, 1e-7, 1e-8, -1e-9, 1e-10, -1e-12, 1e-13])
@pytest.mark.parametrize(("m", "r"), [(1, 0.5), (2, 0.9), (3, 0.99)])
def test_near_resonance_the_orbits_with_one_impact_are_the_steady_motions(load: Load, off: float, m: int, r: float):
    """Speeds by hand: an undamped mode strikes with 2f'/(1 − R), f' = Re Σ ik p_k e^{ikφ}/(ω² − k²)."""
    system = System(s=(1.0 + off) / math.pi, d=0.0, restitution=r, load=load)
    found, modes = orbits(system, 1, m, modes=6), np.arange(1, 7)
    assert not found.resonant_modes and "free amplitude" not in str(found)
    assert found.dropped.get(Drop.RESONANT) is None
    steady = {orbit.phase: orbit for orbit in steady_states(system, m, modes=6).orbits}
    assert steady
    for orbit in (*found.orbits, *found.impossible):
        beside = steady.pop(orbit.phase)
        forced = [
            sum(
                (1j * k * load.coefficients[k] * np.exp(1j * k * orbit.phase)).real
                / float((Fraction(system.s) * PI * int(n)) ** 2 - int(k) ** 2)
                for k in load.harmonics
            )
            for n in modes
        ]
        by_hand = orbit.rigid_velocity + 2.0 / (1.0 - r) * float(2.0 * (-1.0) ** modes @ np.array(forced))
        assert orbit.speeds[0] == pytest.approx(by_hand, rel=1e-12 + 2e-15 / abs(off) * m / (1.0 - r))
        assert orbit.speeds[0] == pytest.approx(beside.impact_velocity, rel=1e-12 + 2e-15 / abs(off) * m / (1.0 - r))
        assert orbit.admissible == beside.admissible
    assert not steady


@pytest.mark.parametrize("r", [0.5, 1.0 - 1e-8])
def test_impacts_half_turns_apart_but_for_little_come_back_as_the_exact_map_says(r: float) -> None:
    """det(I − M) = ½(1 − R)²(1 − cos(θ_1 + θ_2)) + ½(1 + R)²(1 − cos(θ_1 − θ_2)) of two impacts without damping."""
    for off in (1e-4, 1e-7, 1e-9, 1e-11):
        system = System(s=(1.0 + off) / math.pi, d=0.0, restitution=r, load=Load.fourier([0.5, 0.0, 0.0, 1.0]))
        for late in (0.0, 1.3e-7, 0.4):
            chain = ImpactChain(system, 2, 1, 3)
            divisor = chain.passage(np.array([0.0, math.pi + late]), -1.0).blocks.away(1.0)[2]
            angles = chain.known.omega[:, None] * np.array([math.pi + late, math.pi - late])
            turned = np.sin(0.5 * np.stack([angles.sum(axis=1), angles[:, 0] - angles[:, 1]])) ** 2
            exact = (1.0 - r) ** 2 * turned[0] + (1.0 + r) ** 2 * turned[1]
            assert divisor == pytest.approx(exact, rel=0, abs=3e-14 * float(np.abs(np.sin(angles)).max()) + 1e-27)


def test_a_load_that_repeats_sooner_has_fewer_orbits() -> None:
    """Under its second harmonic alone the orbits from either half of the period are one."""
    system = System(s=5.0, d=0.0, restitution=0.5, load=Load.fourier([0.62 * 4.0, 0.0, 4.0]))
    found = orbits(system, 2, modes=0, tries=200)  # the hammer's z=2/2 twice as fast
    slow = orbits(HAMMER, 2, 2, modes=0, tries=200)
    assert [orbit.times for orbit in found.orbits] == [
        pytest.approx(np.array(orbit.times) / 2.0, abs=1e-11) for orbit in slow.orbits
    ]


@pytest.mark.parametrize(
    "load",
    [Load.harmonic(0.62, 1.0), Load.fourier([0.5, 1.0, 0.4j, -0.2]), Load.steps([0.1, 1.5, 3.5], [1.4, 0.5, -0.9])],
)
@pytest.mark.parametrize("modes", [0, 3])
def test_a_load_that_comes_later_has_the_same_orbits_later(load: Load, modes: int) -> None:
    system = System(s=5.0, d=0.01, restitution=0.5, load=load)
    later = System(s=5.0, d=0.01, restitution=0.5, load=load.shifted(1.0))
    for p, n in ((1, 1), (2, 1)):
        found = orbits(system, p, n, modes=modes, tries=16).orbits
        moved = [np.array(orbit.times) + 1.0 for orbit in orbits(later, p, n, modes=modes, tries=16).orbits]
        rows = np.array(moved).reshape(-1, p)
        assert len(found) == len(moved)
        for orbit in found:
            off = np.abs(differences(np.array(orbit.times), rows, orbit.period, TURN)).max(axis=-1).min()
            assert off < 1e-9


@pytest.mark.parametrize(
    ("load", "turn"),
    [
        (Load.harmonic(0.5, 1.0), TURN),
        (Load.fourier([0.5, 0.0, 1.0, 0.0, 0.3]), TURN / 2.0),
        (Load.fourier([0.5, 0.0, 1.0, 0.2]), TURN),
        (Load.steps([0.1, 0.1 + math.pi / 2, 0.1 + math.pi, 0.1 + 1.5 * math.pi], [2.0, -1.0, 2.0, -1.0]), TURN / 2.0),
        (Load.steps([0.1, 1.0, 0.1 + math.pi, 5.0], [2.0, -1.0, 2.0, -1.0]), TURN),
        (Load.square(1.0, 1.2), TURN),
    ],
)
def test_after_how_long_a_load_repeats(load: Load, turn: float) -> None:
    assert load_turn(load) == pytest.approx(turn)


@given(st.lists(st.floats(0.0, 1.0), min_size=2, max_size=5), st.integers(0, 4), st.integers(-3, 3), st.integers(1, 3))
def test_shifted_times_are_the_same_orbit(shares: list[float], first: int, moved: int, periods: int) -> None:
    period = TURN * periods
    flights = 0.05 + np.array(shares)
    flights *= period / flights.sum()
    times = 0.7 + np.append(0.0, np.cumsum(flights)[:-1])
    first %= times.size
    shifted = np.concatenate([times[first:], times[:first] + period]) + TURN * moved
    assert np.abs(differences(shifted, times[None], period, TURN)).max(axis=-1).min() < 1e-12
    plain, turned = canonical(times, period, TURN)[0], canonical(shifted, period, TURN)[0]
    off = np.abs(differences(plain, turned[None], period, TURN)).max(axis=-1).min()
    assert off < 1e-12
    assert 0.0 <= plain[0] < TURN
    assert np.all(np.diff(plain) > 0.0)
    double = np.concatenate([times, times + period])
    assert repeats(double, 2.0 * period, TURN) % 2 == 0


def test_starts_that_are_given_come_first_and_are_counted() -> None:
    """An orbit to which hardly any random start leads is found from a start beside it."""
    entry = ENTRIES["three_in_two"]
    p, n = (int(part) for part in entry["label"][2:].split("/"))
    rows = [times_of(entry) + 1e-3, times_of(entry) - 1e-3]
    found = orbits(system_of(entry), p, n, modes=entry["system"]["modes"], tries=1, near={"a guess": rows, "none": []})
    check(found)
    assert found.sources["a guess"] == (2, 1)
    assert found.sources["none"] == (0, 0)
    assert list(found.sources) == ["a guess", "none", "random times"]
    assert any(np.allclose(orbit.times, times_of(entry), rtol=0.0, atol=1e-11) for orbit in found.orbits)


@pytest.mark.parametrize(
    "near",
    [
        {"a guess": [[0.0, 1.0]]},
        {"a guess": [0.0, 1.0, 2.0]},
        {"a guess": [[0.0, 2.0, 1.0]]},
        {"a guess": [[0.0, 1.0, TURN]]},
        {"a guess": [[0.0, 1.0, math.nan]]},
        {"a guess": "here"},
        {"random times": [[0.0, 1.0, 2.0]]},
    ],
)
def test_starts_that_are_none_are_refused(near) -> None:
    with pytest.raises(ParameterError, match="near"):
        orbits(HAMMER, 3, modes=0, tries=1, near=near)


def test_what_cannot_be_searched_is_refused() -> None:
    for arguments in ({"impacts": 65}, {"impacts": 0}, {"impacts": 2, "periods": 257}, {"impacts": 2, "tries": 0}):
        with pytest.raises(ParameterError):
            orbits(HAMMER, **arguments)
    with pytest.raises(LoadError):
        orbits(HAMMER.with_load_factor(-0.1), 2)
    with pytest.raises(ResonanceError):
        orbits(System(s=1.0 / math.pi, d=0.0, restitution=0.5, load=Load.harmonic(0.6, 1.0)), 2)
    with pytest.raises(Interrupted), halting(lambda: True):
        orbits(HAMMER, 2, modes=0)
