"""Orbits followed through a parameter: figures of other programs, known boundaries, the ladder, the reach."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from orbit_cases import ENTRIES, Made, after, numbers, of_kind, only, periods_of, system_of
from percuss import Load, Start, System, Timed, run, steady_states, timed_states
from percuss.case import load_case
from percuss.case.answers.exploring.orbits_answer import curve_dict
from percuss.errors import ParameterError
from percuss.explore import (
    Axis,
    Branch,
    BranchEvent,
    BranchPoint,
    PointCurve,
    SystemFamily,
    boundaries,
    follow,
    follow_point,
    reach,
)
from percuss.explore.point_curves.rest_walk import RestWay, Vanishing, rest_condition
from percuss.model import Kept, ModalBody, Reversed, UniformBar
from percuss.model.system import set_at_wall
from percuss.steady import PeriodicOrbit, orbit_near, orbits, rest_cycles, time_rates

TURN = 2.0 * math.pi
HAMMER = System(s=5.0, d=0.0, restitution=0.5, load=Load.harmonic(0.62, 1.0))
PARTNERS = {
    "elastic_branch_21": "impact 2 would strike backwards; z=1/1 ends at 0.401237846 (a touch), not here",
    "elastic_branch_31": "z=2/1 ends at 0.531019248 (a touch), not here",
}
RANGES = {
    "cascade": (0.6, 1.0),
    "elastic_ns_41": (0.6, 0.63),
    "elastic_branch_31": (0.5, 0.64),
    "elastic_branch_21": (0.3, 0.7),
}

INNER = ("fold", "flip", "neimark_sacker", "branch_point", "corner", "nonsmooth_fold")  # beyond which a branch goes on


def with_one_impact(system: System, modes: int = 0, which: int = -1) -> PeriodicOrbit:
    """A steady motion as an orbit."""
    return orbits(system, 1, 1, modes=modes).orbits[which]


def point_at(branch: Branch, kind: str, value: float) -> BranchPoint:
    """The point of a kind that is nearest to a value."""
    return min(branch.at(BranchEvent(kind)), key=lambda point: abs(point.value - value))


# -- figures ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", of_kind("branch_points"))
def test_points_of_the_figures(name: str) -> None:
    entry = ENTRIES[name]
    periods = 1 if name == "cascade" else periods_of(entry)
    start = orbit_near(system_of(entry), entry["start"]["phases"], periods, modes=entry["system"]["modes"])
    assert start is not None
    branch = follow(start, "mean", RANGES.get(name, (0.3, 0.8)))
    for point in entry["points"]:
        if point.get("label", branch.label) == branch.label:
            check_point(point_at(branch, point["type"], float(point["value"])), point)
    if name in PARTNERS:  # of an elastic bar the two ends are in two places
        assert PARTNERS[name] in " ".join(point.beyond for point in branch.points)
    assert not any(point.kind.value in INNER for point in branch.ends)
    assert all(point.kind.value in INNER for point in branch.points[1:-1])


def check_point(found: BranchPoint, expected: dict[str, Any]) -> None:
    assert found.value == pytest.approx(float(expected["value"]), rel=0, abs=1e-12)
    assert found.orbit.from_first.phases == pytest.approx(numbers(expected, "phase"), rel=0, abs=1e-11)
    assert found.orbit.from_first.speeds == pytest.approx(numbers(expected, "speed"), rel=0, abs=1e-11)
    if "touch_phase" in expected:
        assert found.touch_phase == pytest.approx(float(expected["touch_phase"]), rel=0, abs=1e-10)
    if "multipliers" in expected:
        values = np.array([complex(*pair) for pair in expected["multipliers"]])
        assert found.multipliers is not None
        for value in values:
            assert np.abs(found.multipliers - value).min() < 1e-6  # they meet at a fold: the root of rounding


def test_the_cascade_of_the_figures() -> None:
    """Every doubled branch begins at the flip of the one before, with no amplitude chosen."""
    entry = ENTRIES["cascade"]
    start = orbit_near(system_of(entry), entry["start"]["phases"], modes=0)
    assert start is not None
    branch = follow(start, "mean", (0.58, 0.92), switch=3)
    rows = branch.cascade
    assert [row.label for row in rows] == [point["label"] for point in entry["points"]]
    assert [row.value for row in rows] == pytest.approx([float(p["value"]) for p in entry["points"]], rel=0, abs=1e-11)
    assert [rows[0].ratio, rows[-1].ratio] == [None, None]
    assert [row.ratio for row in rows[1:-1]] == pytest.approx([5.26, 4.73], abs=5e-3)
    doubled = next(one for one in branch.switched if one.label == "z=2/2")
    check_point(point_at(doubled, "flip", 0.6), entry["points"][1])
    assert doubled.points[0].kind is BranchEvent.HALVING
    assert doubled.points[0].orbit.label == "z=1/1"
    flip = branch.at(BranchEvent.FLIP)[0]
    assert flip.beyond == "z=2/2 begins towards smaller mean, stable"
    assert (flip.side, flip.criticality) == ("smaller", "supercritical")


def test_a_rigid_bar_touches_where_an_impact_more_begins() -> None:
    """z=1/1 → 2/1 → 3/1: the first rungs of the ladder, climbed by switching at touches."""
    saddle = with_one_impact(HAMMER.with_load_factor(0.45), which=0)
    branch = follow(saddle, "mean", (0.35, 0.7), switch=2)
    assert {one.label for one in branch.family()} >= {"z=1/1", "z=2/1", "z=3/1"}
    second = next(one for one in branch.switched if one.label == "z=2/1")
    third = next(one for one in second.switched if one.label == "z=3/1")
    for shorter, longer, figure in ((branch, second, 0.3993131887184041), (second, third, 0.5279096824923904)):
        touch, death = point_at(shorter, "grazing_touch", figure), longer.points[0]
        assert death.kind is BranchEvent.DEATH
        assert [touch.value, death.value] == pytest.approx([figure] * 2, rel=0, abs=1e-12)
        assert death.impact is not None
        assert death.orbit.phases[death.impact - 1] == pytest.approx(touch.touch_phase, abs=1e-11)
        assert f"{longer.label} begins here" in touch.beyond


# -- known boundaries -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("modes", [0, 6])
def test_one_impact_has_the_known_folds_and_flips(modes: int) -> None:
    system = System(s=5.0, d=0.05, restitution=0.6, load=Load.fourier([0.7, 1.0, 0.3 + 0.2j]))
    edges = boundaries(
        system, Axis("restitution", np.array([0.6])), ("load_factor", 0.3, 1.2), criterion="exact", modes=modes,
        kinds=("fold", "flip"),
    )  # fmt: skip
    branch = follow(with_one_impact(system, modes), "load_factor", (0.3, 1.2))
    for kind in ("fold", "flip"):
        known = np.concatenate([curve.y[np.isfinite(curve.y)] for curve in edges.of(kind)])
        found = [point.value for point in branch.at(BranchEvent(kind))]
        assert found
        for value in found:
            assert np.abs(known - value).min() < 1e-9


def test_a_fold_at_a_step_of_the_load() -> None:
    """Square load, R = 0.5: where the impact meets the step K jumps through 0, and nothing is singular beside it."""
    system = System(s=5.0, d=0.0, restitution=0.5, load=Load.square(1.0, 1.65))
    branch = follow(with_one_impact(system), "kappa", (1.6, 1.8))
    corner = branch.at(BranchEvent.NONSMOOTH_FOLD)[0]
    assert corner.orbit.phases[0] == pytest.approx(corner.value * math.pi, abs=1e-12)
    assert corner.value == pytest.approx(branch.values.max(), abs=1e-12)
    sides = [corner.orbit.linearised(1.0, side)[0, 0] for side in ("left", "right")]
    assert sides[0] * sides[1] < 0.0
    beyond = steady_states(System(s=5.0, d=0.0, restitution=0.5, load=Load.square(1.0, corner.value + 1e-9)))
    before = steady_states(System(s=5.0, d=0.0, restitution=0.5, load=Load.square(1.0, corner.value - 1e-9)))
    assert (len(before.orbits), len(beyond.orbits)) == (2, 0)


# -- ends -------------------------------------------------------------------------------------------------------------


def test_the_range_ends_it() -> None:
    branch = follow(with_one_impact(HAMMER.with_load_factor(0.8)), "mean", (0.7, 0.85))
    assert [point.kind for point in branch.points] == [BranchEvent.LIMIT] * 2
    assert branch.values[[0, -1]].tolist() == [0.7, 0.85]
    assert branch.stable.all()


@pytest.mark.parametrize("most", [1e3, 1e300])
def test_a_range_however_wide_hides_no_fold(most: float) -> None:
    branch = follow(with_one_impact(HAMMER.with_load_factor(0.8)), "mean", (0.7, most))
    (fold,) = (point for point in branch.points if point.kind is BranchEvent.FOLD)
    assert fold.value == pytest.approx(0.954929658551, abs=1e-11)


@pytest.mark.parametrize(
    ("name", "kind", "value"), [("restitution", "parameter_end", 1.0), ("mean", "load_stops_pushing", 0.0)]
)
def test_where_the_parameter_ends(name: str, kind: str, value: float) -> None:
    """Of no load only the mean that is left, of no restitution R = 1, which is reached."""
    branch = follow(with_one_impact(HAMMER.with_load_factor(0.8)), name)
    assert branch.points[0].kind.value == kind
    assert branch.points[0].value == pytest.approx(value, abs=1e-12)


def test_it_begins_where_the_parameter_ends() -> None:
    """The drag cannot be less than 0; by a fold the branch comes back to it."""
    branch = follow(with_one_impact(HAMMER.with_load_factor(0.8)), "d", (-1.0, 0.1))
    assert [point.kind for point in branch.points] == [BranchEvent.NO_SYSTEM, BranchEvent.FOLD, BranchEvent.NO_SYSTEM]
    assert [point.value for point in branch.ends] == [0.0, 0.0]


def test_it_stops_when_told() -> None:
    between = (0.05, 1.2)
    branch = follow(with_one_impact(HAMMER.with_load_factor(0.8)), "mean", between, progress=after(40), switch=3)
    assert branch.ends[0].kind is BranchEvent.STOPPED
    assert branch.values.size > 2
    assert follow(with_one_impact(HAMMER.with_load_factor(0.8)), "mean", most=3).values.size <= 5
    seconds: list[float] = []
    follow(with_one_impact(HAMMER), "mean=0.6:0.64", progress=lambda now: seconds.append(now.seconds))
    assert len(seconds) > 3 and seconds == sorted(seconds)


def test_a_range_is_told_as_the_command_takes_it() -> None:
    orbit = with_one_impact(HAMMER)
    told, given = follow(orbit, "mean=0.6:0.64"), follow(orbit, "mean", (0.6, 0.64))
    assert told.as_json() == given.as_json() and orbit.follow("mean = 0.6:0.64:3").as_json() == told.as_json()
    for along, between in (("mean=0.6", None), ("mean=0.6:0.64", (0.6, 0.64)), ("mean=0.6 N:0.64 N", None)):
        with pytest.raises(ParameterError):
            follow(orbit, along, between)


def test_motions_whose_blows_take_time_are_not_followed() -> None:
    (one, *_) = timed_states(HAMMER, Timed.of_uniform_bar(HAMMER.s, HAMMER.restitution)).orbits
    with pytest.raises(ParameterError, match="timed_states"):
        one.follow("mean")


@pytest.mark.parametrize(
    ("change", "word"),
    [
        ({"between": (0.9, 1.2)}, "between"), ({"between": (0.8,)}, "between"), ({"along": "kappa"}, "kappa"),
        ({"along": "nothing"}, "parameter"), ({"value": 0.7}, "orbit"), ({"switch": 17}, "switch"),
        ({"family": SystemFamily(HAMMER.with_restitution(0.3))}, "orbit"), ({"orbit": None}, "orbit"),
    ],
)  # fmt: skip
def test_what_cannot_be_followed_is_refused(change: dict[str, Any], word: str) -> None:
    given = {"orbit": with_one_impact(HAMMER.with_load_factor(0.8)), "along": "mean"} | change
    with pytest.raises(ParameterError, match=word):
        follow(**given)


def test_an_impossible_orbit_is_refused() -> None:
    root = orbits(HAMMER.with_restitution(1.0).with_load_factor(0.3), 2, modes=0, tries=100).impossible[0]
    with pytest.raises(ParameterError, match="admissible"):
        follow(root, "mean")


def test_the_tangent_is_that_of_the_rates() -> None:
    """Between two near points of the walk the impacts move as `time_rates` says."""
    start = orbit_near(HAMMER, [0.39, 2.32], modes=0)
    assert start is not None
    branch = follow(start, "mean", (0.6199999, 0.6200001))
    family = SystemFamily(HAMMER)
    rates = time_rates(start, lambda mean: family.system({"mean": mean}), 0.62)
    slope = (branch.times[-1] - branch.times[0]) / (branch.values[-1] - branch.values[0])
    assert slope == pytest.approx(rates, rel=1e-6)


# -- the ladder z=1/1, 2/1, 3/1 … of a rigid bar: each touches the wall where the next begins, up to chatter ----------


RUNGS = (0.399313, 0.527910, 0.581287, 0.605194, 0.616224, 0.621385, 0.623820, 0.624975, 0.625527)
WINDOWS = {
    2: (0.659282, 0.673754), 3: (0.631808, 0.635221), 4: (0.625261, 0.626612), 5: (0.624230, 0.624883),
    6: (0.624539, 0.624883), 9: (0.625678, 0.625737),
}  # fmt: skip
ONSET = 0.626037331650


def rungs() -> Iterator[Branch]:
    """z=1/1 … 9/1 over the mean load, each from a point of the branch that begins at the touch of the one before."""
    family, orbit, value = SystemFamily(HAMMER), with_one_impact(HAMMER.with_load_factor(0.45), which=0), 0.45
    for impacts in range(1, 10):
        branch = follow(orbit, "mean", (0.35, 0.7), family=family, value=value, switch=1)
        assert branch.label == f"z={impacts}/1"
        yield branch
        (longer,) = [one for one in branch.switched if one.label == f"z={impacts + 1}/1"]
        inside = longer.values.size // 2
        value = float(longer.values[inside])
        times = tuple(longer.times[inside].tolist())
        orbit = PeriodicOrbit(family.system({"mean": value}), 1, times, 0).from_first


def number(branch: Branch, kind: str) -> float:
    """The value of the only point of a kind."""
    (value,) = [point.value for point in branch.points if point.kind.value == kind]
    return value


@pytest.mark.slow
def test_it_is_climbed_to_nine_impacts() -> None:
    begins = None
    touches = []
    for impacts, branch in enumerate(rungs(), 1):
        touches.append(number(branch, "grazing_touch"))
        if begins is not None:
            assert number(branch, "grazing_impact_dies") == pytest.approx(begins, rel=0, abs=1e-11)
        if impacts in WINDOWS:
            flip, fold = number(branch, "flip"), number(branch, "fold")
            assert (flip, fold) == pytest.approx(WINDOWS[impacts], rel=0, abs=1e-6)
            stable = branch.values[branch.stable]
            assert stable.size and flip - 1e-9 <= stable.min() <= stable.max() <= fold + 1e-9
        begins = touches[-1]
    assert touches == pytest.approx(RUNGS, rel=0, abs=1e-6)
    left = ONSET - np.array(touches)
    assert np.all(left > 0.0)
    assert np.all(left[5:] < 0.5 * left[4:-1])  # they pile up at the onset of chatter


# -- how far a parameter may move before a motion is lost: the cascade, the fold, simulations beside them -------------


def rigid(mean: float, restitution: float = 0.5) -> System:
    return System(s=5.0, d=0.0, restitution=restitution, load=Load.harmonic(mean, 1.0))


def stable(system: System) -> PeriodicOrbit | None:
    """The stable motion with one impact in one period, if there is one."""
    every = [PeriodicOrbit(system, 1, (one.phase,), 0) for one in steady_states(system, modes=0).orbits]
    return next((one for one in every if one.admissible and one.multipliers().stable), None)


@settings(max_examples=3, deadline=None)
@given(st.floats(0.05, 0.9), st.floats(0.3, 0.99))
def test_the_mean_load_reaches_from_the_flip_to_the_fold(restitution: float, share: float) -> None:
    """Closed forms: the fold where p_0 π(1−R)/(1+R) is the amplitude; before it motions that keep striking are lost."""
    fold = (1.0 + restitution) / (math.pi * (1.0 - restitution))
    system = rigid(share * fold, restitution)
    orbit = stable(system)
    assume(orbit is not None)
    assert orbit is not None
    found = reach(orbit, "mean", (0.0, 2.0 * fold))
    assert found.below.value < system.load.mean < found.above.value
    if found.above.kind is BranchEvent.FOLD:
        assert found.above.value == pytest.approx(fold, rel=1e-9)
    for end, way in ((found.below, -1), (found.above, 1)):
        inside = rigid(end.value - way * 1e-3 * (found.above.value - found.below.value), restitution)
        assert stable(inside) is not None, end


def test_what_comes_then_is_what_a_simulation_does() -> None:
    orbit = stable(rigid(0.8))
    assert orbit is not None
    found = reach(orbit, "mean", (0.3, 1.2))
    for end, factor in ((found.below, 0.99), (found.above, 1.01)):
        beyond = run(rigid(factor * end.value), Start.orbit(end.orbit), modes=0)
        assert end.then == beyond.label
        assert not end.is_open
    assert found.below.then == "z=2/2"


def test_a_range_that_ends_before_the_motion_is_open() -> None:
    orbit = stable(rigid(0.8))
    assert orbit is not None
    found = reach(orbit, "mean", (0.75, 0.85))
    assert (found.below.value, found.above.value) == (0.75, 0.85)
    assert found.below.is_open
    assert found.above.then is None
    assert found.value == 0.8


def test_an_unstable_motion_has_no_reach() -> None:
    orbit = orbit_near(rigid(0.6), [2.43], modes=0)
    assert orbit is not None
    with pytest.raises(ParameterError, match="stable"):
        reach(orbit, "mean", (0.5, 0.7))


# -- cycles with rest --------------------------------------------------------------------------------------------------


PLANE = ("restitution", "mean")


def harmonic(restitution: float, mean: float) -> System:
    return System(s=5.0, d=0.0, restitution=restitution, load=Load.harmonic(mean, 1.0))


SQUARES = Made(lambda kappa, restitution=0.2: System(5.0, 0.0, restitution, Load.square(1.0, kappa)))


@pytest.fixture(scope="module")
def onset() -> BranchPoint:
    return follow(only(harmonic(0.2, 0.46)), "mean", (0.45, 0.47), points=3).points[0]


@pytest.fixture(scope="module")
def curve(onset: BranchPoint) -> PointCurve:
    return follow_point(onset, PLANE, ((0.0, 0.3), (0.2, 1.0)))


# -- onsets -----------------------------------------------------------------------------------------------------------


def test_onsets_of_a_rigid_bar(curve: PointCurve) -> None:
    """At R = 0.3 the figure of another program; at R = 0 the one impact is a load period after the release."""
    low, high = sorted(curve.ends, key=lambda end: end.values[0])
    assert (low.kind, high.kind) == (BranchEvent.LIMIT, BranchEvent.LIMIT)
    assert high.values == pytest.approx((0.3, 0.513626912256), rel=0, abs=1e-11)
    assert low.values == pytest.approx((0.0, 1.0 / math.hypot(1.0, math.pi)), rel=0, abs=1e-12)
    assert curve.is_orbit.all()
    assert str(curve).startswith("onset of chatter/1: ")
    assert curve.release_phases == pytest.approx(np.arccos(-curve.values[:, 1]), rel=0, abs=1e-12)
    assert curve.event_phases == pytest.approx(curve.release_phases, rel=0, abs=1e-9)


def test_it_is_met_from_a_bar_that_does_not_rebound() -> None:
    start = follow(only(harmonic(0.0, 0.32)), "mean", (0.28, 0.4), points=3).points[0]
    curve = follow_point(start, PLANE, ((0.0, 0.05), (0.2, 1.0)))
    edge = next(end for end in curve.ends if end.values[0] == 0.0)
    assert edge.kind is BranchEvent.LIMIT
    restitution, mean = curve.values[np.argmax(curve.values[:, 0])]
    branch = follow(only(harmonic(restitution, mean + 0.01)), "mean", (mean - 0.01, mean + 0.02), points=3)
    assert branch.points[0].value == pytest.approx(mean, rel=0, abs=5e-11)


def test_simulated_motions_chatter_on_one_side_of_it_alone(curve: PointCurve) -> None:
    for i in np.linspace(2, len(curve.values) - 3, 5).astype(int):
        restitution, mean = curve.values[i]
        inside, outside = (run(harmonic(restitution, mean + off), Start(), modes=0).label for off in (2e-4, -2e-4))
        assert inside == "chatter/1"
        assert outside != "chatter/1"


def test_the_branch_at_another_restitution_ends_on_it(curve: PointCurve) -> None:
    restitution, mean = curve.values[len(curve.values) // 2]
    branch = follow(only(harmonic(restitution, mean + 0.01)), "mean", (mean - 0.01, mean + 0.02), points=3)
    assert branch.points[0].kind is BranchEvent.ONSET
    assert branch.points[0].value == pytest.approx(mean, rel=0, abs=5e-11)


def test_the_onset_under_a_square_load_is_closed() -> None:
    system = SQUARES.system({"kappa": 1.75, "restitution": 0.2})
    branch = follow(only(system), "kappa", (1.5, 1.8), family=SQUARES, value=1.75, points=3)
    plane, box = ("restitution", "kappa"), ((0.0, 0.6), (1.0, 1.95))
    values = (0.2, branch.points[0].value)
    curve = follow_point(branch.points[0], plane, box, family=SQUARES, values=values, most=9)
    r, kappa = curve.values.T
    whole = 1.0 + math.sqrt(2.0) + 2.0 * math.sqrt(2.0) * r / (1.0 - r)
    assert kappa == pytest.approx(2.0 * whole / (1.0 + whole), rel=0, abs=1e-11)
    assert curve.is_orbit.all()


def test_impacts_that_pile_up_are_met_again_after_a_long_step() -> None:
    """With a greater restitution q comes near its limit several impacts later; the number looks on until it does."""
    system = harmonic(0.8, 0.817348052778)
    (chain,) = only(harmonic(0.8, 0.8174)).chains
    early = Vanishing(RestWay(0, chain.release, chain.impacts[:2], 1)).renewed(system)
    late = Vanishing(RestWay(0, chain.release, chain.impacts[:7], 1)).renewed(system)
    assert len(early.way.impacts) == len(late.way.impacts) == 6
    assert early.number(system) == late.number(system) == pytest.approx(0.0, abs=1e-9)


def test_a_first_impact_may_fall_before_the_push() -> None:
    """A held structure that is pulled as it strikes first; its chatter piles up as the push vanishes all the same."""
    body = ModalBody((3.3,), (0.3,), (1.0,), (1.0,), gap=0.0826019930)
    system = System(body=body, contact=Kept(0.4), load=Load.harmonic(0.0, 1.0))
    condition, side = rest_condition(BranchPoint(BranchEvent.ONSET, (body.gap,), only(system, 1), ""))
    assert isinstance(condition, Vanishing)
    assert side * condition.number(set_at_wall(system, 1)) == pytest.approx(0.0, abs=1e-8)


def test_where_the_impacts_of_a_ringing_bar_have_no_order_it_says_so() -> None:
    ringing = SystemFamily(load_case("laboratory-striker").system()).system({"load_factor": 0.548})
    onset = BranchPoint(BranchEvent.ONSET, (0.548,), only(ringing, 32), "")
    with pytest.raises(ParameterError, match="irregular impacts"):
        follow_point(onset, ("restitution", "load_factor"), ((0.3, 0.4), (0.3, 1.0)))


@pytest.mark.slow
def test_a_law_that_turns_the_strain_over_holds_the_bar_a_little_before() -> None:
    system = System(body=UniformBar(200.0), contact=Reversed(0.35), load=Load.harmonic(0.6, 1.0))
    start = follow(only(system), "mean", (0.5, 0.6), points=3).points[0]
    curve = follow_point(start, ("d", "mean"), ((0.0, 0.1), (0.3, 1.0)), most=6)
    damping, mean = curve.values[np.argmax(curve.values[:, 0])]
    assert damping > 1e-3
    beside = SystemFamily(system).system({"d": damping, "mean": mean + 0.01})
    point = follow(only(beside), "mean", (mean - 0.01, mean + 0.02), points=3).points[0]
    assert (point.kind, point.value) == (BranchEvent.ONSET, pytest.approx(mean, rel=0, abs=1e-11))


@pytest.mark.slow
def test_an_elastic_bar_is_laid_down_late_under_its_strain() -> None:
    system = System(s=5.0, d=0.05, restitution=0.2, load=Load.harmonic(0.45, 1.0))
    start = follow(only(system, 2), "mean", (0.42, 0.46), points=3).points[0]
    curve = follow_point(start, PLANE, ((0.15, 0.25), (0.4, 0.5)), most=3)
    for restitution, mean in curve.values[[0, -1]]:
        beside = SystemFamily(system).system({"restitution": restitution, "mean": mean + 1e-3})
        point = follow(only(beside, 2), "mean", (mean - 1e-3, mean + 2e-3), points=3).points[0]
        assert (point.kind, point.value) == (BranchEvent.ONSET, pytest.approx(mean, rel=0, abs=1e-10))
        for off, held in ((1e-5, True), (-1e-5, False)):  # beyond it ringing lays it down under a pull, and lets go
            other = SystemFamily(system).system({"restitution": restitution, "mean": mean + off})
            (cycle,) = rest_cycles(other, modes=2).orbits
            assert (cycle.label, not cycle.remembered) == ("chatter/1", held)
            assert run(other, Start(), modes=2).label == "chatter/1"


# -- other ends -------------------------------------------------------------------------------------------------------


def test_a_touch_is_where_an_impact_dies_from_the_other_side() -> None:
    """Of a rigid bar an impact without speed changes nothing, so that both branches end at the same place."""
    load = Load.fourier([0.65, 1.0, 1.52 + 0.81j])
    one, two = (only(System(s=5.0, d=0.0, restitution=0.0, load=load.with_mean(mean))) for mean in (0.609, 0.711))
    touch = follow(one, "mean", (0.609, 0.711), points=3).points[1]
    death = follow(two, "mean", (0.609, 0.711), points=3).points[0]
    assert (touch.kind, touch.impact, death.kind, death.impact) == (BranchEvent.TOUCH, 1, BranchEvent.DEATH, 1)
    assert touch.value == pytest.approx(death.value, rel=0, abs=1e-10)
    assert touch.touch_phase == pytest.approx(death.touch_phase, rel=0, abs=1e-5)
    assert death.cycle.speeds[0] < 1e-5
    assert death.cycle.speeds[1] == pytest.approx(touch.cycle.speeds[0], rel=0, abs=1e-5)
    plane, box = ("d", "mean"), ((0.0, 0.2), (0.4, 1.0))
    first, second = (follow_point(point, plane, box, most=3) for point in (touch, death))
    assert (first.event, second.event) == (BranchEvent.TOUCH, BranchEvent.DEATH)
    ends = [np.array(sorted(end.values for end in curve.ends)) for curve in (first, second)]
    assert ends[0] == pytest.approx(ends[1], rel=0, abs=1e-7)
    damping, mean = first.values[np.argmax(first.values[:, 0])]
    beside = System(s=5.0, d=damping, restitution=0.0, load=load.with_mean(mean - 0.01))
    again = follow(only(beside), "mean", (mean - 0.02, mean + 0.01), points=3).points[1]
    assert (again.kind, again.value) == (BranchEvent.TOUCH, pytest.approx(mean, rel=0, abs=1e-10))


def test_the_last_release_asks_for_the_load_alone() -> None:
    last = follow(only(harmonic(0.2, 0.98)), "mean", (0.97, 1.1), points=3).points[1]
    curve = follow_point(last, PLANE, ((0.1, 0.3), (0.5, 1.5)), most=4)
    assert curve.event is BranchEvent.RELEASE_LOST
    assert curve.values[:, 1] == pytest.approx(1.0, rel=0, abs=1e-12)
    assert curve.event_phases == pytest.approx(math.pi, rel=0, abs=1e-6)


# -- ends and refusals ------------------------------------------------------------------------------------------------


def test_a_curve_of_onsets_stops_when_told(onset: BranchPoint) -> None:
    curve = follow_point(onset, PLANE, ((0.0, 0.9), (0.2, 1.2)), progress=after(2000))
    assert BranchEvent.STOPPED in {end.kind for end in curve.ends}
    assert len(curve.values) > 1
    at_once = follow_point(onset, PLANE, ((0.0, 0.9), (0.2, 1.2)), progress=lambda _: True)
    assert [end.kind for end in at_once.ends] == [BranchEvent.STOPPED] * 2
    assert at_once.values[0] == pytest.approx((0.2, onset.value), rel=0, abs=1e-9)
    assert json.loads(json.dumps(curve_dict(at_once), allow_nan=False))["curve"]["event_phases"][0] is None


def test_curves_of_cycles_that_cannot_be_followed_are_refused(onset: BranchPoint) -> None:
    branch = follow(only(harmonic(0.2, 0.6)), "mean", (0.59, 0.61), points=3)
    with pytest.raises(ParameterError, match="one of the kinds onset"):
        follow_point(branch.points[0], PLANE, ((0.1, 0.3), (0.3, 1.0)))
    with pytest.raises(ParameterError, match="a point of the systems with"):
        follow_point(onset, PLANE, ((0.1, 0.3), (0.3, 1.0)), values=(0.2, 0.5))


def test_without_a_range_a_curve_goes_to_the_last_restitution() -> None:
    start = follow(only(harmonic(0.05, 0.4)), "mean", (0.3, 0.42), points=3).points[0]
    curve = follow_point(start, ("mean", "restitution"), ((0.25, 0.37), None))
    assert {end.kind: end.values[i] for i, end in zip((0, 1), curve.ends, strict=True)} == {
        BranchEvent.LIMIT: 0.37,
        BranchEvent.NO_SYSTEM: 0.0,
    }


# -- along a branch ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("restitution", "onset"), [(0.2, 0.457825216970), pytest.param(0.5, 0.626037331650, marks=pytest.mark.slow)]
)
def test_chatter_begins_at_an_onset_and_ends_where_nothing_is_let_go(restitution: float, onset: float) -> None:
    system = harmonic(restitution, 0.8)
    cycle = only(system)
    branch = follow(cycle, "mean", (0.4, 1.1), points=5)
    first, last = branch.points
    free = follow(cycle, "mean", points=5).points
    assert [(end.kind, end.value) for end in free] == [
        (end.kind, pytest.approx(end.value, abs=1e-10)) for end in (first, last)
    ]
    assert (branch.label, first.kind, last.kind) == ("chatter/1", BranchEvent.ONSET, BranchEvent.RELEASE_LOST)
    assert first.value == pytest.approx(onset, rel=0, abs=1e-10)
    assert last.value == pytest.approx(1.0, rel=0, abs=1e-10)
    assert "z=p/1" in first.beyond
    assert branch.rest_times[0] < 1e-3 and branch.rest_times.min() == branch.rest_times[0]


@pytest.mark.parametrize("restitution", [0.0, 0.2])
def test_the_onset_of_a_branch_under_a_square_load_is_closed(restitution: float) -> None:
    whole = 1.0 + math.sqrt(2.0) + 2.0 * math.sqrt(2.0) * restitution / (1.0 - restitution)
    system = System(s=5.0, d=0.0, restitution=restitution, load=Load.square(1.0, 1.75))

    squares = Made(lambda kappa: system.with_load(Load.square(1.0, kappa)))
    branch = follow(only(system), "kappa", (1.2, 1.9), family=squares, value=1.75, points=9)
    assert (branch.points[0].kind, branch.points[1].kind) == (BranchEvent.ONSET, BranchEvent.LIMIT)
    assert branch.points[0].value == pytest.approx(2.0 * whole / (1.0 + whole), rel=0, abs=1e-10)


def test_one_rest_more_begins_where_an_impact_meets_the_zero_of_the_load() -> None:
    """R = 0: an impact while the load pulls is followed by flight, one while it pushes by rest until the release."""
    system = System(s=5.0, d=0.0, restitution=0.0, load=Load.fourier([0.67, 1.0, 0.55 - 0.06j]))
    branch = follow(only(system), "mean", (0.665, 0.685), points=3)
    end = branch.points[1]
    assert (branch.points[0].kind, end.kind) == (BranchEvent.LIMIT, BranchEvent.ONSET)
    assert end.beyond.startswith("the bar comes to rest once more")
    load = system.load.with_mean(end.value)
    assert float(load.value(end.cycle.phases[0])) == pytest.approx(0.0, rel=0, abs=1e-10)
    beyond = only(system.with_load(load.with_mean(end.value + 1e-3)))
    assert (end.cycle.rest_phases.size, beyond.rest_phases.size) == (1, 2)


def test_a_rigid_bar_rests_whatever_its_length() -> None:
    cycle = only(harmonic(0.2, 0.6))
    first, last = follow(cycle, "s", points=3).points
    assert (first.kind, last.kind) == (BranchEvent.NO_SYSTEM, BranchEvent.LIMIT)
    assert first.value == pytest.approx(1e-4) and last.value == pytest.approx(5e6, rel=1e-5)


def test_a_range_without_the_cycle_or_an_unknown_parameter_is_refused() -> None:
    cycle = only(harmonic(0.5, 0.8))
    for wrong in ((0.9, 1.0), (1.0, 0.3)):
        with pytest.raises(ParameterError):
            follow(cycle, "mean", wrong)
    with pytest.raises(ParameterError):
        follow(cycle, "nonsense", (0.3, 1.0))


def test_what_has_been_followed_is_kept_when_it_is_stopped() -> None:
    cycle = only(harmonic(0.5, 0.8))
    branch = follow(cycle, "mean", (0.4, 1.1), progress=after(400))
    assert {point.kind for point in branch.points} == {BranchEvent.STOPPED}
    assert branch.values.size > 1 and 0.8 in branch.values
    assert (branch.points[0].value, branch.points[1].value) == (branch.values[0], branch.values[-1])
    at_once = follow(cycle, "mean", (0.4, 1.1), progress=lambda _: True)
    assert at_once.values.tolist() == [0.8]


def test_what_is_lost_or_won_with_the_rebound() -> None:
    """A bar that chatters rests at once without rebound, and one that rests chatters with however little of it."""
    told = {}
    for restitution in (0.0, 0.1):
        system = harmonic(restitution, 0.6)
        cycle = only(system)
        branch = follow(cycle, "restitution", (0.0, 0.2), points=3)
        told[cycle.label] = [(one.value, one.beyond) for one in branch.points if one.kind is BranchEvent.CHANGE]
    ((at, beyond),) = told["rest/1"]
    assert (at, beyond.endswith("chatters to its rest: chatter/1")) == (0.0, True)
    ((at, beyond),) = told["chatter/1"]
    assert (at < 1e-11, beyond.endswith("first impact under a push: rest/1")) == (True, True)
