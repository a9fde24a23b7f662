"""Cycles with rest followed through a parameter: onsets with known values, closed forms, both directions."""

from __future__ import annotations

import math

import pytest

from orbit_cases import Made, after, only
from percuss import Load, System
from percuss.errors import ParameterError
from percuss.explore import BranchEvent, follow_rest_cycle


@pytest.mark.parametrize(
    ("restitution", "onset"), [(0.2, 0.457825216970), pytest.param(0.5, 0.626037331650, marks=pytest.mark.slow)]
)
def test_chatter_begins_at_an_onset_and_ends_where_nothing_is_let_go(restitution: float, onset: float) -> None:
    system = System(s=5.0, d=0.0, restitution=restitution, load=Load.harmonic(0.8, 1.0))
    cycle = only(system)
    branch = follow_rest_cycle(cycle, "mean", (0.4, 1.1), points=5)
    first, last = branch.points
    free = follow_rest_cycle(cycle, "mean", points=5).points
    assert [(end.kind, end.value) for end in free] == [
        (end.kind, pytest.approx(end.value, abs=1e-10)) for end in (first, last)
    ]
    assert (branch.label, first.kind, last.kind) == ("chatter/1", BranchEvent.ONSET, BranchEvent.RELEASE_LOST)
    assert first.value == pytest.approx(onset, rel=0, abs=1e-10)
    assert last.value == pytest.approx(1.0, rel=0, abs=1e-10)
    assert "z=p/1" in first.beyond
    assert branch.rest_times[0] < 1e-3 and branch.rest_times.min() == branch.rest_times[0]


@pytest.mark.parametrize("restitution", [0.0, 0.2])
def test_the_onset_under_a_square_load_is_closed(restitution: float) -> None:
    whole = 1.0 + math.sqrt(2.0) + 2.0 * math.sqrt(2.0) * restitution / (1.0 - restitution)
    system = System(s=5.0, d=0.0, restitution=restitution, load=Load.square(1.0, 1.75))

    squares = Made(lambda kappa: system.with_load(Load.square(1.0, kappa)))
    branch = follow_rest_cycle(only(system), "kappa", (1.2, 1.9), family=squares, value=1.75, points=9)
    assert (branch.points[0].kind, branch.points[1].kind) == (BranchEvent.ONSET, BranchEvent.LIMIT)
    assert branch.points[0].value == pytest.approx(2.0 * whole / (1.0 + whole), rel=0, abs=1e-10)


def test_one_rest_more_begins_where_an_impact_meets_the_zero_of_the_load() -> None:
    """R = 0: an impact while the load pulls is followed by flight, one while it pushes by rest until the release."""
    system = System(s=5.0, d=0.0, restitution=0.0, load=Load.fourier([0.67, 1.0, 0.55 - 0.06j]))
    branch = follow_rest_cycle(only(system), "mean", (0.665, 0.685), points=3)
    end = branch.points[1]
    assert (branch.points[0].kind, end.kind) == (BranchEvent.LIMIT, BranchEvent.ONSET)
    assert end.beyond.startswith("the bar comes to rest once more")
    load = system.load.with_mean(end.value)
    assert float(load.value(end.cycle.phases[0])) == pytest.approx(0.0, rel=0, abs=1e-10)
    beyond = only(system.with_load(load.with_mean(end.value + 1e-3)))
    assert (end.cycle.rest_phases.size, beyond.rest_phases.size) == (1, 2)


def test_a_touch_is_where_an_impact_dies_from_the_other_side() -> None:
    """Of a rigid bar an impact without speed changes nothing, so that both branches end at the same place."""
    load = Load.fourier([0.65, 1.0, 1.52 + 0.81j])
    one, two = (only(System(s=5.0, d=0.0, restitution=0.0, load=load.with_mean(mean))) for mean in (0.609, 0.711))
    touch = follow_rest_cycle(one, "mean", (0.609, 0.711), points=3).points[1]
    death = follow_rest_cycle(two, "mean", (0.609, 0.711), points=3).points[0]
    assert (touch.kind, death.kind) == (BranchEvent.TOUCH, BranchEvent.DEATH)
    assert touch.value == pytest.approx(death.value, rel=0, abs=1e-10)
    assert touch.touch_phase == pytest.approx(death.touch_phase, rel=0, abs=1e-5)
    assert death.cycle.speeds[0] < 1e-5
    assert death.cycle.speeds[1] == pytest.approx(touch.cycle.speeds[0], rel=0, abs=1e-5)


def test_a_rigid_bar_rests_whatever_its_length() -> None:
    cycle = only(System(s=5.0, d=0.0, restitution=0.2, load=Load.harmonic(0.6, 1.0)))
    first, last = follow_rest_cycle(cycle, "s", points=3).points
    assert (first.kind, last.kind) == (BranchEvent.NO_SYSTEM, BranchEvent.LIMIT)
    assert first.value == pytest.approx(1e-4) and last.value == pytest.approx(5e6, rel=1e-5)


def test_bad_input() -> None:
    cycle = only(System(s=5.0, d=0.0, restitution=0.5, load=Load.harmonic(0.8, 1.0)))
    for wrong in ((0.9, 1.0), (1.0, 0.3)):
        with pytest.raises(ParameterError):
            follow_rest_cycle(cycle, "mean", wrong)
    with pytest.raises(ParameterError):
        follow_rest_cycle(cycle, "nonsense", (0.3, 1.0))


def test_what_has_been_followed_is_kept_when_it_is_stopped() -> None:
    cycle = only(System(s=5.0, d=0.0, restitution=0.5, load=Load.harmonic(0.8, 1.0)))
    branch = follow_rest_cycle(cycle, "mean", (0.4, 1.1), halt=after(400))
    assert {point.kind for point in branch.points} == {BranchEvent.STOPPED}
    assert branch.values.size > 1 and 0.8 in branch.values
    assert (branch.points[0].value, branch.points[1].value) == (branch.values[0], branch.values[-1])
    at_once = follow_rest_cycle(cycle, "mean", (0.4, 1.1), halt=lambda: True)
    assert at_once.values.tolist() == [0.8]


def test_what_is_lost_or_won_with_the_rebound() -> None:
    """A bar that chatters rests at once without rebound, and one that rests chatters with however little of it."""
    told = {}
    for restitution in (0.0, 0.1):
        system = System(s=5.0, d=0.0, restitution=restitution, load=Load.harmonic(0.6, 1.0))
        cycle = only(system)
        branch = follow_rest_cycle(cycle, "restitution", (0.0, 0.2), points=3)
        told[cycle.label] = [(one.value, one.beyond) for one in branch.points if one.kind is BranchEvent.CHANGE]
    ((at, beyond),) = told["rest/1"]
    assert (at, beyond.endswith("chatters to its rest: chatter/1")) == (0.0, True)
    ((at, beyond),) = told["chatter/1"]
    assert (at < 1e-11, beyond.endswith("first impact under a push: rest/1")) == (True, True)
