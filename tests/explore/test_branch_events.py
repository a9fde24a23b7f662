"""What happens on branches and is rare: twice within a step, closed loops, ends that orbits seldom come to."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given

from orbit_cases import Made, both_ways, motions
from percuss import Load, System
from percuss.errors import PercussError
from percuss.explore import Branch, BranchEvent, SystemFamily, follow
from percuss.explore.continuation.branch_events import outside, unstable
from percuss.explore.continuation.following import OrbitWalk
from percuss.explore.continuation.missed_events import dying_impact
from percuss.explore.continuation.orbit_curve import SolutionCurve
from percuss.explore.continuation.walk import CurvePoint
from percuss.explore.parameters import PARAMETERS
from percuss.model import External, Kept, Reversed, UniformBar
from percuss.steady import PeriodicOrbit, orbit_near, orbits
from random_hammers import random_hammer

HAMMER = System(s=5.0, d=0.0, restitution=0.5, load=Load.harmonic(0.62, 1.0))


def bent_from(least: float) -> Made:
    """Systems whose mean load has a least value where the parameter is 0."""
    return Made(lambda bent: SystemFamily(HAMMER).system({"mean": least + bent**2}))


@pytest.fixture(scope="module")
def straight() -> Branch:
    """z=2/1 over the mean load: an impact dies, flip, fold, touch."""
    start = orbit_near(HAMMER, [0.39, 2.32], modes=0)
    assert start is not None
    return follow(start, "mean", (0.3, 1.0))


def bent(straight: Branch, kind: str, depth: float, value: float, upper: bool) -> tuple[Branch, float]:
    """The branch through a parameter that goes past a point of a kind by `depth` and comes back, and where it does."""
    point = straight.at(BranchEvent(kind))[0]
    family, mean = bent_from(point.value - depth), point.value - depth + value**2
    crossed = np.flatnonzero(np.diff(np.sign(straight.values - mean)))
    near = straight.times[crossed[-1 if upper else 0]]
    start = orbit_near(SystemFamily(HAMMER).system({"mean": mean}), near, modes=0)
    assert start is not None
    return follow(start, "bent", (-0.4, 0.4), family=family, value=value), math.sqrt(depth)


# -- twice within a step ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("depth", [1e-2, 1e-4, 1e-6, 1e-8])
@pytest.mark.parametrize(
    ("kind", "value", "upper"),
    [("flip", 0.1, False), ("grazing_impact_dies", 0.3, False), ("grazing_touch", 0.3, True), ("fold", 0.0, False)],
)
def test_what_happens_twice_is_met_twice(straight: Branch, kind: str, depth: float, value: float, upper: bool) -> None:
    """However near to each other: at ±√depth of a parameter whose square the mean load follows."""
    branch, place = loop(straight, depth) if kind == "fold" else bent(straight, kind, depth, value, upper)
    found = [point.value for point in branch.at(BranchEvent(kind)) if abs(point.value) < 2.0 * place]
    if kind.startswith("grazing"):
        assert np.abs(found) == pytest.approx([place] * len(found), abs=1e-9)
        assert branch.ends[0].kind.value == kind
    else:
        assert sorted(found) == pytest.approx([-place, place], abs=1e-9)


def loop(straight: Branch, depth: float) -> tuple[Branch, float]:
    """A closed branch between two folds."""
    fold = straight.at(BranchEvent.FOLD)[0]
    family = bent_from(fold.value - depth)
    index = int(np.argmax(straight.values))
    near = straight.times[index - 1]
    start = orbit_near(family.system({"bent": 0.0}), near, modes=0)
    assert start is not None
    return follow(start, "bent", (-0.4, 0.4), family=family, value=0.0), math.sqrt(depth)


def test_a_closed_branch_ends_at_its_start(straight: Branch) -> None:
    branch, place = bent(straight, "flip", 1e-2, 0.1, False)
    assert [end.kind for end in branch.ends] == [BranchEvent.CLOSED] * 2
    assert branch.ends[0].value == branch.ends[1].value == pytest.approx(0.1, abs=2e-3)  # which is a flip itself
    assert branch.phases[-1] == pytest.approx(branch.phases[0], abs=1e-12)
    kinds = [point.kind.value for point in branch.points[1:-1]]
    assert sorted(kinds) == ["flip", "flip", "fold", "fold"]
    assert place == pytest.approx(0.1)


# -- ends -------------------------------------------------------------------------------------------------------------


def test_without_restitution_it_ends_where_the_bar_would_stay_on_the_wall() -> None:
    system = HAMMER.with_restitution(0.0).with_load_factor(0.25)
    branch = follow(orbits(system, 1, 1, modes=0).orbits[0], "mean", (0.05, 1.0))
    end = branch.ends[1]
    assert end.kind is BranchEvent.STICKING
    assert end.impact == 1
    assert float(end.orbit.system.load.value(end.orbit.phase)) == pytest.approx(0.0, abs=1e-10)  # it begins to push


def stalled(curve: SolutionCurve, x: np.ndarray) -> BranchEvent:
    """What a walk says that can take no further step."""
    walk = OrbitWalk(curve, CurvePoint(x, np.eye(x.size)[-1], 0), (-math.inf, math.inf))
    walk.keep(walk.here, 0)
    walk.size = 1e-9
    walk.shorten()
    assert walk.ended
    return walk.happened[-1].kind


def test_it_says_that_a_mode_comes_back_by_itself() -> None:
    """ω_1 = 2 without damping: after a load period the first mode is where it was, whatever its amplitude."""
    system = System(s=2.0 / math.pi * (1.0 + 1e-9), d=0.0, restitution=0.5, load=Load.harmonic(0.8, 1.0))
    orbit = orbits(HAMMER.with_load_factor(0.8), 1, 1, modes=0).orbits[-1]
    curve = SolutionCurve(SystemFamily(system), "s", 1, 1, 1, 1.0)
    x = np.array([*orbit.times, orbit.rigid_rebounds[0], system.s])
    assert stalled(curve, x) is BranchEvent.RESONANCE


def test_it_says_that_impacts_fall_together() -> None:
    curve = SolutionCurve(SystemFamily(HAMMER), "mean", 2, 1, 0, 1.0)
    assert stalled(curve, np.array([1.0, 1.0 + 1e-7, -1.0, 0.62])) is BranchEvent.COALESCENCE


def test_it_says_that_the_halves_fall_together() -> None:
    """Not at a flip, past which steps lead, but where the orbit of half the period has a corner."""
    orbit = orbits(HAMMER.with_load_factor(0.8), 1, 1, modes=0).orbits[-1]
    curve = SolutionCurve(SystemFamily(orbit.system), "mean", 2, 2, 0, 1.0)
    x = np.array([orbit.phase, orbit.phase + 2.0 * math.pi, *orbit.rigid_rebounds, orbit.system.load.mean])
    assert stalled(curve, x) is BranchEvent.HALVING
    assert stalled(curve, x + 1e-3 * np.eye(4)[1]) is BranchEvent.LOST


def test_a_load_that_only_pulls_ends_it() -> None:
    """Through the amplitude of a load factor: the mean load vanishes, and with it every motion that keeps striking."""
    start = orbits(HAMMER.with_load_factor(0.8), 1, 1, modes=0).orbits[-1]
    branch = follow(start, "load_factor")
    assert branch.points[0].kind is BranchEvent.NO_PUSH
    assert branch.points[0].value == pytest.approx(0.0, abs=1e-12)


# -- multipliers outside the circle -----------------------------------------------------------------------------------


@given(motions())
def test_the_number_outside_is_that_of_the_multipliers(orbit: PeriodicOrbit) -> None:
    if np.abs(orbit.speeds).min() < 1e-6 * np.abs(orbit.speeds).max():
        return
    moduli = orbit.multipliers().moduli
    beyond = 1e-7
    counted = orbit.outside(beyond)
    near = counted is None or np.abs(moduli / (1.0 + beyond) - 1.0).min() < 1e-8
    assert near or counted == np.count_nonzero(moduli > 1.0 + beyond)


def test_pairs_side_by_side_within_the_circle_are_not_counted() -> None:
    """Between two places that are looked at det K(ξ) turns about 0 for each, and seems not to turn at all for two."""
    system = SystemFamily(random_hammer(47).system).system({"mean": 1.1178})
    orbit = orbit_near(system, [0.5218135, 5.5194895, 10.2425223], 2, modes=32)
    assert orbit is not None
    assert orbit.outside(1e-7) is None
    assert unstable(orbit) == outside(orbit.multipliers().values) == 3


def test_a_dying_impact_has_no_number() -> None:
    start = orbit_near(HAMMER, [0.39, 2.32], modes=0)
    assert start is not None
    death = follow(start, "mean", (0.3, 0.65)).at(BranchEvent.DEATH)[0]
    assert unstable(death.orbit) == outside(None) == -1


# -- both ways --------------------------------------------------------------------------------------------------------


def drawn(seed: int, modes: int) -> tuple[PeriodicOrbit, str, float] | None:
    """An orbit of some system, a parameter and its value; None where none is found."""
    random = np.random.default_rng(seed)
    load = [Load.harmonic(0.6, 1.0), Load.fourier([0.4, 1.0, 0.3j, -0.2]), Load.square(1.0, 1.3)][seed % 3]
    law = [Kept, Reversed][random.integers(2)](random.uniform(0.1, 0.9))
    body = UniformBar(random.uniform(1.0, 8.0), External(random.uniform(0.01, 0.5)))
    p, n = int(random.integers(1, 3)), int(random.integers(1, 3))
    try:
        found = orbits(System(body, load, law), p, n, modes=modes, tries=40, seed=seed).orbits
    except PercussError:
        return None
    name = str(random.choice(["mean", "restitution"]))
    if not found:
        return None
    orbit = found[random.integers(len(found))]
    return orbit, name, orbit.system.load.mean if name == "mean" else float(orbit.system.restitution)


def one_impact(seed: int) -> tuple[PeriodicOrbit, str, float] | None:
    """A steady motion of some bar under some load, a parameter and its value; None where there is no motion."""
    random = np.random.default_rng(seed)
    load = [
        Load.harmonic(0.6, 1.0), Load.fourier([0.4, 1.0, 0.3j, -0.2]), Load.square(1.0, 1.3),
        Load.steps([0.2, 1.0, 3.0], [1.5, -0.3, 0.1]),
    ][seed % 4]  # fmt: skip
    contact = [Kept, Reversed][random.integers(2)](random.uniform(0.05, 0.9))
    system = System(UniformBar(random.uniform(1.0, 8.0), External(random.uniform(0.01, 0.5))), load, contact)
    found = orbits(system, 1, 1, modes=int(random.choice([0, 3]))).orbits
    name = str(random.choice(["restitution", "load_factor", "s", "d"]))
    value = PARAMETERS[name].get(system)
    return (found[random.integers(len(found))], name, value) if found and value is not None else None


@pytest.mark.parametrize("seed", [1, 2, 8, 79])
def test_a_branch_with_one_impact_is_the_same_from_every_place(seed: int) -> None:
    start = one_impact(seed)
    assert start is not None
    orbit, name, value = start
    both_ways(orbit, name, (0.9 * value, 1.05 * value))


def met_both_ways(seed: int, modes: int) -> bool:
    """Whether a branch was met; that it is the same both ways is asserted."""
    start = drawn(seed, modes)
    if start is not None:
        orbit, name, value = start
        both_ways(orbit, name, (0.93 * value, min(1.04 * value, 1.0 if name == "restitution" else math.inf)))
    return start is not None


@pytest.mark.parametrize("kappa", [1.45, 1.71])
def test_a_step_that_the_parameter_moves_is_met_at_the_same_place_from_anywhere(kappa: float) -> None:
    """The one-impact motion under the square load meets its step at κπ, from whichever side, and turns back there."""
    system = System(s=5.0, d=0.0, restitution=0.5, load=Load.square(1.0, kappa))
    for orbit in orbits(system, 1, modes=0).orbits:
        branch = follow(orbit, "kappa", (0.0, 2.0))
        assert {point.kind.value for point in branch.points} == {
            "grazing_touch",
            "nonsmooth_fold",
            "load_stops_pushing",
        }
        (corner,) = branch.at(BranchEvent.NONSMOOTH_FOLD)
        assert corner.orbit.phase == pytest.approx(math.pi * corner.value, rel=0, abs=1e-12)
        assert corner.value == pytest.approx(1.720759220056126, rel=0, abs=1e-12)


def test_a_pair_that_crosses_the_circle_slowly_is_located() -> None:
    """Its modulus is clearly greater than 1 only a good deal further than where it is 1."""
    start = orbits(random_hammer(106).system, 1, modes=8).orbits[1]
    (pair,) = follow(start, "mean", (1.2, 2.3)).at(BranchEvent.NEIMARK_SACKER)
    assert pair.value == pytest.approx(2.1300633, abs=1e-6)
    moduli = pair.orbit.multipliers().moduli
    assert moduli[:2] == pytest.approx([1.0, 1.0], rel=0, abs=1e-11)


def test_without_losses_a_pair_leaves_the_circle_where_it_meets_another() -> None:
    hammer = random_hammer(316)
    system = hammer.system
    assert system.contact.is_lossless
    assert system.d == 0.0
    start = next(iter(orbits(system, 2, 1, modes=hammer.modes, tries=8).orbits))
    value = float(PARAMETERS["load_factor"].get(system) or 0.0)
    (pair,) = follow(start, "load_factor", (2.8409, value)).at(BranchEvent.NEIMARK_SACKER)
    assert pair.value == pytest.approx(2.8410005203, rel=0, abs=1e-9)
    assert pair.multipliers is not None
    near = pair.multipliers[np.abs(pair.multipliers - np.exp(0.8677474j)) < 1e-4]
    assert near.size == 2
    assert float(abs(near[0] - near[1])) < 1e-6


def test_pairs_that_hardly_leave_the_circle_are_told_in_their_order() -> None:
    """With next to no losses several do within a step, each by so little that it is hard to tell them apart."""
    hammer = random_hammer(47)
    system = SystemFamily(hammer.system).system({"mean": 1.1171})
    branch = follow(orbit_near(system, [0.5209, 5.51942, 10.24276], 2, modes=hammer.modes), "mean", (1.1165, 1.1195))
    assert not branch.at(BranchEvent.FOLD)
    assert np.all(np.diff(branch.values) >= 0.0)
    pairs = branch.at(BranchEvent.NEIMARK_SACKER)
    assert pairs
    for pair in pairs:
        assert pair.multipliers is not None
        off = np.abs(np.abs(pair.multipliers[np.abs(pair.multipliers.imag) > 1e-6]) - 1.0)
        assert float(off.min()) < 2e-7


@pytest.mark.parametrize("modes", [0, 8])
def test_the_same_events_are_met_both_ways(modes: int) -> None:
    assert any([met_both_ways(seed, modes) for seed in (3, 4)])


@pytest.mark.slow
@pytest.mark.parametrize("modes", [0, 8, 32])
def test_the_same_events_are_met_both_ways_on_many(modes: int) -> None:
    assert sum(met_both_ways(seed, modes) for seed in range(100, 112 if modes < 32 else 104)) > 2


def test_a_branch_that_another_one_crosses_goes_on() -> None:
    """Without losses, under a load that is the same backwards in time, ξ = 1 is met at other points than folds."""
    system = System(s=5.0, d=0.0, restitution=1.0, load=Load.harmonic(0.4, 1.0))
    starts = orbits(system, 2, 2, modes=0, tries=12).orbits
    branches = [follow(start, "mean", (0.3, 0.7)) for start in starts]
    turned = []
    for branch in branches:
        (point,) = branch.at(BranchEvent.CROSSING)
        assert point.value == pytest.approx(0.51946266217, abs=1e-10)
        assert point.multipliers is not None
        assert float(np.abs(point.multipliers - 1.0).min()) < 1e-4
        turned.append(branch.values.max() == point.value)
        assert "turns back" in point.beyond if turned[-1] else branch.values.max() == 0.7
        assert not branch.at(BranchEvent.FOLD)
    assert set(turned) == {False, True}  # the branch that is the same backwards in time, and those that are not


def test_it_begins_at_the_last_value_of_the_parameter() -> None:
    """Rounding is not to lead past R = 1, where there is no system."""
    system = System(s=5.0, d=0.0, restitution=1.0, load=Load.harmonic(0.5, 1.0))
    for start in orbits(system, 2, 2, modes=0, tries=12).orbits:
        branch = follow(start, "restitution", (0.79, 1.0))
        assert BranchEvent.LOST not in {point.kind for point in branch.points}
        assert (BranchEvent.LIMIT, 1.0) in {(end.kind, end.value) for end in branch.ends}


def test_it_stays_within_its_range(straight: Branch) -> None:
    """Though a step ends beyond it whose tangent leads to a place before it, as the branch bends."""
    start = orbit_near(HAMMER, [0.39, 2.32], modes=0)
    assert start is not None
    beyond_fold = straight.values[np.argmax(straight.values) + 2 :]
    for low in beyond_fold[np.abs(beyond_fold - 0.59) < 0.03] + 1e-6:
        branch = follow(start, "mean", (float(low), 1.0))
        assert branch.values.min() == low
        assert [end.kind for end in branch.ends] == [BranchEvent.LIMIT] * 2


def test_the_death_of_an_impact_is_told_from_the_points_before_it() -> None:
    """Where several die at once the equations are singular, and no step leads past the place."""
    death = follow(orbit_near(HAMMER, [0.39, 2.32], modes=0), "mean", (0.3, 0.7)).ends[0]
    curve = SolutionCurve(SystemFamily(HAMMER), "mean", 2, 1, 0, 0.25)
    end = curve.corrected(curve.unknowns(death.orbit, death.value), curve.level)
    into = end.tangent if min(curve.motion(end.x + 1e-6 * end.tangent).speeds) > 0.0 else -end.tangent
    points = [curve.corrected(end.x + aside * into, into) for aside in (4e-8, 2e-8)]

    def speeds(point: CurvePoint) -> np.ndarray:
        return curve.motion(point.x).speeds

    found = dying_impact(points, speeds)
    assert found is not None
    assert found.kind is BranchEvent.DEATH
    assert curve.value(found.point.x) == pytest.approx(death.value, abs=1e-11)
    assert dying_impact(points[::-1], speeds) is None
    assert dying_impact(points[:1], speeds) is None


def test_a_branch_that_a_mode_turns_to_and_fro_in_the_middle_of_a_step_has_both_folds() -> None:
    """Beside R = 0.7583 the first mode comes back after a cycle almost by itself, and the branch is an S of 4e-4."""
    hammer = random_hammer(40)
    start = next(iter(orbits(hammer.system, 2, 1, modes=hammer.modes, tries=8).orbits))
    folds = [point.value for point in follow(start, "restitution", (0.64, 0.85)).at(BranchEvent.FOLD)]
    assert folds == pytest.approx([0.6523163463, 0.6450948815, 0.7586010759, 0.7581810885], abs=1e-9)


def middle_of(branch: Branch, system: System) -> PeriodicOrbit:
    """The orbit half way along a branch over the mean load."""
    middle = branch.values.size // 2
    there = SystemFamily(system).system({"mean": float(branch.values[middle])})
    return PeriodicOrbit(there, branch.periods, tuple(branch.times[middle].tolist()), branch.modes).from_first


def test_a_doubled_branch_ends_at_the_flip_and_has_no_fold_there() -> None:
    """Without losses both multipliers of z=1/1 are −1 where the load only just pulls, at mean = 1."""
    system = System(s=5.0, d=0.0, restitution=1.0, load=Load.harmonic(0.9, 1.0))
    one = next(orbit for orbit in orbits(system, 1, modes=0).orbits if orbit.phase > 3.0)
    branch = follow(one, "mean", (0.8, 1.1), switch=1)
    (flip,) = branch.at(BranchEvent.FLIP)
    assert flip.value == pytest.approx(1.0, rel=0, abs=1e-12)
    (doubled,) = branch.switched
    again = follow(middle_of(doubled, system), "mean", (0.8, 1.1))
    for found in (doubled, again):
        halving = found.at(BranchEvent.HALVING)[0]
        assert halving.value == pytest.approx(1.0, rel=0, abs=1e-12)
        assert {point.kind.value for point in found.points} == {"period_halving", "flip", "limit"}


@pytest.mark.parametrize("restitution", [0.571, 0.5712, 0.57123, 0.57124, 0.571243])
def test_a_fold_beside_a_flip_is_met_both_ways(restitution: float) -> None:
    """Near the restitution at which the flip changes its side: from the flip on, and from the doubled orbit to it."""
    load = Load.fourier([0.8, 1.0, 0.4 * np.exp(0.325j)])
    system = System(s=5.0, d=0.0, restitution=restitution, load=load)
    one = orbits(system, 1, 1, modes=0).orbits[-1]
    doubled = next(one for one in follow(one, "mean", (0.53, 0.9), switch=1).switched if one.label == "z=2/2")
    ways, folds = np.sign(np.diff(doubled.values)), doubled.at(BranchEvent.FOLD)
    assert len(folds) == np.count_nonzero(ways[1:] != ways[:-1]) == 2  # values turn only at folds
    assert 0.0 < abs(folds[0].value - doubled.points[0].value) < 1e-6
    for fold in folds:
        assert np.abs(fold.orbit.multipliers().values - 1.0).min() < 1e-4
    again = follow(middle_of(doubled, system), "mean", (0.53, 0.9))
    expected, found = (sorted((point.kind.value, point.value) for point in one.points) for one in (doubled, again))
    assert [kind for kind, _ in expected] == [kind for kind, _ in found] == ["fold", "fold", "limit", "period_halving"]
    assert [at for _, at in found] == pytest.approx([at for _, at in expected], rel=0, abs=1e-11)


def test_it_may_begin_at_a_fold_or_flip(straight: Branch) -> None:
    for kind in (BranchEvent.FOLD, BranchEvent.FLIP):
        point = straight.at(kind)[0]
        system = SystemFamily(HAMMER).system({"mean": point.value})
        assert point.orbit.system == system
        again = follow(point.orbit, "mean", (0.3, 1.0))
        expected, found = ({point.kind.value: point.value for point in one.points} for one in (straight, again))
        assert found == pytest.approx(expected, rel=0, abs=1e-10)
        assert len(again.points) == len(straight.points)
