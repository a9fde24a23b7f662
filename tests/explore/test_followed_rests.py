"""Cycles with rest followed, and their ends through two parameters: known onsets, closed forms, simulations."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest

from orbit_cases import Made, after, only
from percuss import Load, Start, System, run
from percuss.case import load_case
from percuss.case.answers.exploring.orbits_answer import curve_dict
from percuss.errors import ParameterError
from percuss.explore import BranchEvent, BranchPoint, PointCurve, SystemFamily, follow, follow_point
from percuss.explore.point_curves.rest_walk import RestWay, Vanishing, rest_condition
from percuss.model import Kept, ModalBody, Reversed, UniformBar
from percuss.model.system import set_at_wall
from percuss.steady import rest_cycles

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
        after = SystemFamily(system).system({"restitution": restitution, "mean": mean - 1e-5})
        assert not rest_cycles(after, modes=2).orbits
        assert run(after, Start(), modes=2).label == "chatter/1"


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


def test_it_stops_when_told(onset: BranchPoint) -> None:
    curve = follow_point(onset, PLANE, ((0.0, 0.9), (0.2, 1.2)), progress=after(2000))
    assert BranchEvent.STOPPED in {end.kind for end in curve.ends}
    assert len(curve.values) > 1
    at_once = follow_point(onset, PLANE, ((0.0, 0.9), (0.2, 1.2)), progress=lambda _: True)
    assert [end.kind for end in at_once.ends] == [BranchEvent.STOPPED] * 2
    assert at_once.values[0] == pytest.approx((0.2, onset.value), rel=0, abs=1e-9)
    assert json.loads(json.dumps(curve_dict(at_once), allow_nan=False))["curve"]["event_phases"][0] is None


def test_what_cannot_be_followed_is_refused(onset: BranchPoint) -> None:
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
