"""The search for orbits: what it finds, what it drops and why, and that it finds each orbit once."""

from __future__ import annotations

import math
from fractions import Fraction

import mpmath
import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from orbit_cases import ENTRIES, numbers, system_of, times_of
from percuss import Load, System, steady_states
from percuss.errors import Interrupted, LoadError, ParameterError, ResonanceError
from percuss.halting import halting
from percuss.model import Body, External, KelvinVoigt, Kept, Mounted, Ratio, Reversed, UniformBar
from percuss.model.checks import Array
from percuss.steady import Drop, FoundOrbits, PeriodicOrbit, Reason, orbits
from percuss.steady.flight import flight_check
from percuss.steady.oscillator import PI
from percuss.steady.periodic import search as search_module
from percuss.steady.periodic.impact_chain import ImpactChain
from percuss.steady.periodic.pair_proof import Ball, PairEquations, exactly
from percuss.steady.periodic.periodic_orbit import canonical, differences, load_turn, repeats
from percuss.steady.periodic.search import Outcome, newton
from random_hammers import random_hammer

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


# -- many starts and the proof by samples, over all systems that there are ---------------------------------------------


DAMPINGS = (
    lambda size: External(size),
    lambda size: Ratio(min(size / 20.0, 1.0)),
    lambda size: KelvinVoigt(0.01 * size),
)


@st.composite
def systems(draw: st.DrawFn) -> System:
    """Bars, free and held, loads of harmonics and of steps, dampings from none to overdamped, R from 0 to 1."""
    size = draw(st.just(0.0) | st.floats(1e-4, 30.0))
    body: Body = UniformBar(draw(st.floats(0.1, 30.0)), draw(st.sampled_from(DAMPINGS))(size))
    held = draw(st.booleans())
    if held:
        body = Mounted(
            draw(st.floats(0.1, 20.0)), size, draw(st.floats(0.1, 30.0)), body.damping, draw(st.floats(-1.0, 1.0))
        )
    mean, parts = draw(st.floats(0.05, 1.5)), st.floats(-1.0, 1.0)
    kind = draw(st.sampled_from(["one", "several", "steps"]))
    if kind == "one":
        load = Load.harmonic(mean, 1.0)
    elif kind == "several":
        pairs = draw(st.lists(st.tuples(parts, parts), min_size=2, max_size=6))
        load = Load.fourier([mean, 1.0, *(complex(*pair) for pair in pairs)])
    else:
        breaks = np.sort(np.array(draw(st.lists(st.floats(0.0, 6.28), min_size=2, max_size=5))))
        assume(np.all(np.diff(breaks) > 1e-3))
        values = draw(st.lists(st.floats(-1.0, 2.0), min_size=breaks.size, max_size=breaks.size, unique=True))
        load = Load.steps(breaks, values)
    restitution = draw(st.sampled_from([0.0, 1.0]) | st.floats(0.0, 1.0))
    return System(body, load, draw(st.sampled_from([Kept] if held else [Kept, Reversed]))(restitution))


@st.composite
def chains(draw: st.DrawFn) -> tuple[ImpactChain, Array]:
    """Impacts in load periods, of bars with few and many modes, and times in order."""
    p, n, system = draw(st.integers(1, 8)), draw(st.integers(1, 4)), draw(systems())
    chain = ImpactChain(
        system, p, n, draw(st.sampled_from([0, 1, 2, 7, 16, 64] if system.body.is_free else [1, 2, 7, 16]))
    )
    share = np.sort(np.array(draw(st.lists(st.floats(0.0, 1.0), min_size=p, max_size=p))))
    assume(p == 1 or (np.diff(share).min() > 1e-6 and np.ptp(share) < 1.0 - 1e-6))
    return chain, draw(st.floats(-10.0, 10.0)) + chain.period * share


@given(case=chains())
def test_many_starts_end_as_each_alone(case: tuple[ImpactChain, Array]) -> None:
    chain, times = case
    starts = np.stack([times, times + 0.1, times - 0.2])
    try:
        together = newton(chain, starts)
    except ResonanceError:
        assume(False)
    for row, start in enumerate(starts):
        alone = newton(chain, start[None])
        assert alone.outcome[0] == together.outcome[row]
        assert np.array_equal(alone.times[0], together.times[row], equal_nan=True)


@given(
    system=systems(),
    p=st.integers(1, 3),
    n=st.integers(1, 2),
    modes=st.sampled_from([1, 2, 7]),
    seed=st.integers(0, 99),
)
def test_samples_prove_what_bounds_prove(system: System, p: int, n: int, modes: int, seed: int) -> None:
    """The proof by samples never says what that by bounds denies; the greatest maximum is that of a scan."""
    chain = ImpactChain(system, p, n, modes)
    starts = np.sort(np.random.default_rng(seed).uniform(0.0, chain.period, (40, p)), axis=1)
    try:
        ended = newton(chain, starts)
    except ResonanceError:
        return
    for row in np.flatnonzero(ended.outcome == Outcome.ROOT)[:2].tolist():
        rebound = float(ended.rebound[row]) if chain.is_neutral else None
        check_samples(PeriodicOrbit(system, n, tuple(ended.times[row].tolist()), modes, rebound))


@pytest.mark.parametrize("seed", [*range(40), 259])  # the last: a part whose middle is far from the wall, its end near
def test_parts_that_are_left_out_hold_no_greater_maximum(seed: int) -> None:
    """Of many modes, where most of a flight is not sampled: off the wall, and back to it with its waves ringing."""
    random = np.random.default_rng(seed)
    mean, s = random.uniform(0.1, 1.2), random.uniform(3.0, 30.0)
    load = (
        Load.square(mean, random.uniform(1.1, 1.6)) if seed % 4 == 3 else Load.harmonic(mean, random.uniform(0.2, 2.0))
    )
    system = System(s=s, d=10.0 ** random.uniform(-5.0, -1.0), restitution=random.uniform(0.0, 0.9), load=load)
    for modes in (16, 48):
        for orbit in steady_states(system, modes=modes).orbits:
            check_samples(PeriodicOrbit(system, 1, (orbit.phase,), modes))
        for flight in random.uniform(0.2, 6.0, 3):
            check_samples(PeriodicOrbit(system, 1, (0.1, 0.1 + float(flight)), modes), steps=True)


def check_samples(orbit: PeriodicOrbit, steps: bool = False) -> None:
    if orbit.resonant_modes:
        return
    seen = orbit.sampled
    if seen.proven:
        assert np.all(orbit.speeds > 0.0)
        assert all(flight_check(flight).violation is None for flight in orbit.flights)
    heights, size = [-np.inf], 1.0
    for flight in orbit.flights:
        fastest = max(1.0, float(orbit.system.load.harmonics[-1]), float(flight.state.omega.max()))
        number = max(8, int(max(96.0, 8.0 * fastest * flight.period / (2.0 * np.pi))))
        y, rate = flight.end_motion(flight.period / number * np.arange(number + 1), orbit.modes)
        size = max(size, float(np.abs(y).max()), float(np.abs(rate).max()))
        here = np.flatnonzero((rate[:-1] > 1e-6 * size) & (rate[1:] < -1e-6 * size))
        heights += np.maximum(y[here], y[here + 1]).tolist()
    if seen.height > -np.inf:
        flight = orbit.flights[seen.flight]
        place = flight.end_motion(np.array([seen.time + orbit.times[0] - flight.phase]), orbit.modes)[0]
        assert place[0] == pytest.approx(seen.height, rel=0, abs=1e-9 * size)
    if steps or not orbit.system.load.is_piecewise:  # else the samples begin anew at each step
        assert seen.height >= max(heights) - 1e-9 * size


# -- all pairs of impacts of a rigid bar -------------------------------------------------------------------------------


mp = mpmath.mp.clone()
mp.dps = 40
COSINE = Load.harmonic(0.62, 1.0)
LOADS = [
    COSINE,
    Load.fourier([0.4, 1.0, 0.3j, -0.2]),
    Load.square(1.0, 1.3),
    Load.steps([0.2, 1, 3], [1.5, -0.3, -0.4]),
]


# -- the arithmetic ---------------------------------------------------------------------------------------------------

plain = st.floats(-1e6, 1e6).filter(lambda x: x == 0.0 or abs(x) > 1e-60)
inside = st.floats(-1.0, 1.0)


@given(plain, st.floats(0.0, 10.0), plain, st.floats(0.0, 10.0), inside, inside)
def test_a_ball_holds_whatever_its_parts_may_give(a: float, r: float, b: float, s: float, x: float, y: float) -> None:
    one, other = Ball(np.array(a), np.array(r)), Ball(np.array(b), np.array(s))
    p, q = Fraction(a) + Fraction(r) * Fraction(x), Fraction(b) + Fraction(s) * Fraction(y)
    exact = {"+": p + q, "-": p - q, "*": p * q}
    found = {"+": one + other, "-": one - other, "*": one * other}
    if abs(b) > s * 1.01:
        exact["/"], found["/"] = p / q, one.over(other)
    for sign, value in exact.items():
        ball = found[sign]
        assert abs(value - Fraction(float(ball.mid))) <= Fraction(float(ball.rad))
        assert abs(value) <= Fraction(float(ball.most))
        if value == 0:
            assert ball.may_vanish


def test_what_cannot_be_divided_says_nothing() -> None:
    assert exactly(1.0).over(Ball(np.array(1.0), np.array(1.0))).rad == math.inf


# -- the equations, in forty digits -----------------------------------------------------------------------------------


def forced(system: System, t) -> tuple:
    """U_f and v_f of a rigid bar: sums, or by quadrature of each step from the state that comes back."""
    load, d = system.load, mp.mpf(system.d)
    if not load.is_piecewise:
        waves = [(k, mp.mpc(load.coefficients[k])) for k in load.harmonics.tolist()]
        v = sum(p / (d + 1j * k) * mp.expj(k * t) for k, p in waves)
        return sum(p / (d + 1j * k) / (1j * k) * mp.expj(k * t) for k, p in waves).real, v.real
    turn = mp.mpf(TURN)
    breaks = [mp.mpf(b) for b in load.breaks]
    lengths = [after - before for before, after in zip(breaks, [*breaks[1:], breaks[0] + turn], strict=True)]
    mean = sum(mp.mpf(v) * h for v, h in zip(load.values, lengths, strict=True)) / turn
    forces = [mp.mpf(v) - mean for v in load.values]

    def moved(u, v, force, h):
        if d == 0:
            return u + v * h + force * h**2 / 2, v + force * h
        fade = -mp.expm1(-d * h) / d
        return u + v * fade + force * (h - fade) / d, v * mp.exp(-d * h) + force * fade

    u = v = mp.mpf(0)
    for force, h in zip(forces, lengths, strict=True):
        u, v = moved(u, v, force, h)
    # without drag v is any; with it v comes back: v(1 - e^{-d turn}) = what a turn from rest gives
    start = v / -mp.expm1(-d * turn) if d else mp.mpf(0)
    if not d:
        u = v = mp.mpf(0)
        area = mp.mpf(0)
        for force, h in zip(forces, lengths, strict=True):
            area += v * h + force * h**2 / 2
            v += force * h
        start = -area / turn
    u, v, since = mp.mpf(0), start, mp.fmod(t - breaks[0], turn)
    if since < 0:
        since += turn
    for force, h in zip(forces, lengths, strict=True):
        if since <= h:
            return moved(u, v, force, since)
        u, v = moved(u, v, force, h)
        since -= h
    return u, v


def equations(system: System, periods: int, t, h) -> tuple:
    """F_1 and F_2, by the motion itself: two flights, two impacts, and a velocity that comes back."""
    d, r = mp.mpf(system.d), mp.mpf(system.restitution)
    t, h = mp.mpf(t), mp.mpf(h)
    rest = mp.mpf(TURN) * periods - h
    mean = mp.mpf(system.load.mean)
    (u, v), (u_2, v_2) = forced(system, t), forced(system, t + h)

    def flight(velocity, begin, end, force_free, length):
        fade = -mp.expm1(-d * length) / d if d else length
        twice = (length - fade) / d if d else length**2 / 2
        advance = (velocity - begin[1]) * fade + mean * twice + end[0] - begin[0]
        return advance, (velocity - begin[1]) * mp.exp(-d * length) + end[1] + mean * fade

    def cycle(velocity):
        first, before = flight(velocity, (u, v), (u_2, v_2), None, h)
        second, again = flight(-r * before, (u_2, v_2), (u, v), None, rest)
        return first, second, -r * again

    none, one = cycle(mp.mpf(0))[2], cycle(mp.mpf(1))[2]
    first, second, back = cycle(none / (1 - (one - none)))
    assert abs(back - none / (1 - (one - none))) < 1e-30
    return first, second


@st.composite
def boxes(draw: st.DrawFn):
    """A system, n, a box of times, and a place in it."""
    d = draw(st.sampled_from([0.0, 1e-9, 0.003, 0.4, 5.0]))
    system = System(s=5.0, d=d, restitution=draw(st.sampled_from([0.0, 0.3, 0.9])), load=draw(st.sampled_from(LOADS)))
    n = draw(st.integers(1, 2))
    t, h = draw(st.floats(0.0, TURN)), draw(st.floats(0.02, TURN * n - 0.02))
    size = draw(st.sampled_from([0.0, 1e-6, 1e-3, 0.1, 0.5]))
    rads = size * draw(st.floats(0.1, 1.0)), min(size * draw(st.floats(0.1, 1.0)), h, TURN * n - h)
    place = t + 0.999 * rads[0] * draw(inside), h + 0.999 * rads[1] * draw(inside)
    return system, n, (t, h), rads, place


@settings(max_examples=30, deadline=None)
@given(boxes())
def test_the_equations_are_enclosed_over_boxes(drawn) -> None:
    system, n, (t, h), rads, place = drawn
    found = PairEquations(system, n).over(
        *(Ball(np.array([x]), np.array([r])) for x, r in zip((t, h), rads, strict=True))
    )
    exact = equations(system, n, *place)
    room = 1e-13 * (1.0 + (TURN * n) ** 2)  # the mean load of steps is a double
    for ball, value in zip(found[:2], exact, strict=True):
        assert abs(float(value - mp.mpf(float(ball.mid[0])))) <= float(ball.rad[0]) + room
    at = np.array(system.load.breaks) if system.load.is_piecewise else np.empty(0)
    near = [np.abs(np.mod(time - at + 0.5, TURN) - 0.5).min(initial=1.0) for time in (place[0], sum(place))]
    if min(near) < 1e-6:
        return
    step = mp.mpf(10) ** -10
    for balls, move in ((found.by_t, (step, 0)), (found.by_h, (0, step))):
        ends = [equations(system, n, place[0] + sign * move[0], place[1] + sign * move[1]) for sign in (1, -1)]
        for i, ball in enumerate(balls):
            slope = (ends[0][i] - ends[1][i]) / (2 * step)
            assert abs(float(slope - mp.mpf(float(ball.mid[0])))) <= float(ball.rad[0]) + room
    r = mp.mpf(system.restitution)
    per_flight = exact[0] / (
        -mp.expm1(-mp.mpf(system.d) * place[1]) / mp.mpf(system.d) if system.d else mp.mpf(place[1])
    )
    per_flight = per_flight if r else per_flight / place[1]
    ball = found.per_flight
    assert abs(float(per_flight - mp.mpf(float(ball.mid[0])))) <= float(ball.rad[0]) + room / place[1]


# -- the list ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(0, 24, 3))
def test_nothing_that_a_search_finds_is_missing(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    system = random_hammer(seed).system
    proved = [orbits(system, 2, n, modes=0) for n in (1, 2)]
    monkeypatch.setattr(search_module, "proved_pairs", lambda *_: None)
    for one in proved:
        assert one.complete is not (system.restitution == 1.0 and system.d < 1e-4)
        searched = orbits(system, 2, one.periods, modes=0, tries=60)
        for name in ("orbits", "impossible"):
            listed = np.array([orbit.times for orbit in getattr(one, name)]).reshape(-1, 2)
            for orbit in getattr(searched, name):
                assert np.abs(listed - orbit.times).max(axis=1).min() < 1e-9


def test_a_complete_list_has_no_tries() -> None:
    found = orbits(System(s=5.0, d=0.0, restitution=0.5, load=COSINE), 2, 2, modes=0)
    assert found.complete
    assert (found.tries, found.unseen) == (0, 0.0)
    assert str(found).startswith("z=2/2: 1 orbit with 0 modes, complete (proved)")
    assert {reason.value: number for reason, number in found.dropped.items()} == {"repeats a shorter orbit": 2}


def test_a_fold_is_not_proved() -> None:
    """Two orbits within rounding of each other are no roots that a box could tell apart."""
    entry = ENTRIES["branch_21"]
    fold = next(float(point["value"]) for point in entry["points"] if point["type"] == "fold")
    assert not orbits(system_of(entry, fold), 2, modes=0, tries=10).complete
    assert orbits(system_of(entry, fold - 1e-5), 2, modes=0).complete
    beyond = orbits(system_of(entry, fold + 1e-5), 2, modes=0)
    assert beyond.complete
    assert not beyond.orbits
