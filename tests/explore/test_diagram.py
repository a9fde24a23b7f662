"""Diagrams: every branch once, and simulated motions on them."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from percuss import Load, System
from percuss.errors import ParameterError, PercussError
from percuss.explore import Axis, Diagram, diagram, follow
from percuss.explore.continuation.branch import Branch, BranchEvent
from percuss.explore.diagrams.diagram_job import diagram_job
from percuss.explore.diagrams.diagram_lines import line_of, lines_from, packed, with_new
from percuss.explore.diagrams.tracing import labels_up_to
from percuss.model import Kept, ModalBody
from percuss.steady import PeriodicOrbit, orbit_near, orbits

RIGID = System(s=5.0, d=0.0, restitution=0.5, load=Load.harmonic(0.7, 1.0))
SMALL: dict[str, Any] = {"searched": 2, "switch": 1, "tries": 40, "starts": 3, "runs": 1, "modes": 0, "workers": 1}


@pytest.fixture(scope="module")
def found() -> Diagram:
    return diagram(RIGID, "mean=0.5:1:12", up_to=(2, 1), **SMALL)


def test_every_branch_is_there_once(found: Diagram) -> None:
    """z=1/1 is met at both values, z=2/2 by switching; z=2/1 has two orbits, on one branch."""
    labels = [branch.label for branch in found.branches]
    assert labels.count("z=1/1") == 1
    assert labels.count("z=2/2") == 1
    assert labels.count("z=2/1") == 1
    assert found.left_out == 0
    assert found.done == 1.0


def test_its_events_are_those_of_the_cascade(found: Diagram) -> None:
    """The flip, and the fold at 3/π: B77 (14) with R = 0.5."""
    branch = next(one for one in found.branches if one.label == "z=1/1")
    events = {point.kind: point.value for point in branch.points}
    assert events[BranchEvent.FLIP] == pytest.approx(0.654954465051, abs=1e-10)
    assert events[BranchEvent.FOLD] == pytest.approx(3.0 / np.pi, abs=1e-10)
    assert np.all(np.diff(branch.stable[branch.energies > 0.0].astype(int)) <= 1)


def test_the_energy_of_a_rigid_bar_is_half_the_square_of_its_speed(found: Diagram) -> None:
    for branch in found.branches:
        assert branch.energies == pytest.approx(0.5 * (branch.speeds**2).mean(axis=1), rel=1e-12)
        assert branch.scales is None
    assert not found.is_si


def test_what_simulations_settle_on_lies_on_stable_parts(found: Diagram) -> None:
    """Of the labels that have a branch, within what a line between two points of it is off."""
    looked = 0
    for one in found.settled:
        branches = [branch for branch in found.branches if branch.label == one.label]
        if not branches:
            continue
        looked += 1
        near = [
            np.abs(np.sort(np.mod(times, 2.0 * np.pi)) - np.sort(one.phases)).max()
            for branch in branches
            for times in branch.times_at(one.value)
        ]
        assert min(near) < 0.02
    assert looked >= 5


def test_each_simulation_is_counted_once(found: Diagram) -> None:
    for value in found.axis.values.tolist():
        assert sum(one.members for one in found.settled if one.value == value) == 3 + 1


def test_a_motion_taken_along_is_lost_where_its_branch_ends() -> None:
    """z=1/1 is stable from its flip at 0.654954 to its fold at 3/π, chatter/1 above its onset at 0.626037."""
    both = diagram(RIGID, "mean=0.6:1.1:25", up_to=None, starts=0, runs=2, modes=0, workers=1)
    assert not both.branches
    for value in both.axis.values.tolist():
        labels = {one.label for one in both.settled if one.value == value}
        if 0.66 < value < 0.95:
            assert labels == {"z=1/1", "chatter/1"}
        elif 0.96 < value < 1.0:
            assert labels == {"chatter/1"}
        elif value < 0.62:
            assert not labels & {"chatter/1", "z=1/1"}


def test_the_dataset_has_a_row_for_each_impact(found: Diagram) -> None:
    dataset = found.to_xarray()
    simulated = sum(one.phases.size for one in found.settled)
    followed = [*found.branches, *found.rest_branches]
    assert dataset.sizes["row"] == simulated + sum(np.isfinite(branch.speeds).sum() for branch in followed)
    assert dataset.sizes["event"] == sum(len(branch.points) for branch in followed)
    assert set(dataset["source"].values.tolist()) == {"simulated", "branch"}


def test_beyond_an_end_there_are_roots_and_no_motions(found: Diagram) -> None:
    """They begin at grazings; the bar strikes backwards there, or passes the wall."""
    ends = {
        point.value
        for branch in found.branches
        for point in branch.points
        if point.kind in (BranchEvent.TOUCH, BranchEvent.DEATH)
    }
    assert found.impossible
    for line in found.impossible:
        assert not line.possible
        assert not line.points
        assert min(abs(line.values[0] - end) for end in ends) < 1e-9
        row = line.values.size // 2
        system = System(s=5.0, d=0.0, restitution=0.5, load=Load.harmonic(float(line.values[row]), 1.0))
        orbit = PeriodicOrbit(system, line.periods, tuple(line.times[row].tolist()), 0)
        assert orbit.residual < 1e-9
        assert not orbit.admissible


# -- in bytes --


@pytest.fixture(scope="module")
def line() -> Branch:
    branch = follow(orbit_near(RIGID, [2.3], modes=0), "mean", (0.6, 0.9))
    return line_of(branch, lambda mean: System(s=5.0, d=0.0, restitution=0.5, load=Load.harmonic(mean, 1.0)))


def test_bytes_give_the_branches_back_to_the_bit(line: Branch) -> None:
    data, kept = packed([line, line], 1 << 20)
    first, second = lines_from(data)
    assert kept == 2
    assert packed([first, second], 1 << 20)[0] == data
    assert first.times.tobytes() == line.times.tobytes()
    assert [str(point) for point in second.points] == [str(point) for point in line.points]


def test_what_does_not_fit_is_left_out_and_counted(line: Branch) -> None:
    one, _ = packed([line], 1 << 20)
    data, kept = packed([line] * 9 + [line], len(one))
    assert kept < 10
    assert len(data) <= len(one)
    assert packed([line], 20) == packed([], 20)


def test_a_branch_told_from_another_impact_or_period_is_the_same(line: Branch) -> None:
    columns = ("values", "times", "speeds", "energies", "unstable", "points")
    back = replace(line, **{name: getattr(line, name)[::-1] for name in columns})
    shifted = replace(back, times=back.times + 2.0 * np.pi)
    moved = tuple(replace(point, motion=point.plain._replace(phases=point.plain.phases + 0.1)) for point in line.points)
    aside = replace(line, times=line.times + 0.1, points=moved)
    assert len(with_new([line], [shifted])) == 1
    assert len(with_new([line], [aside])) == 2


def test_long_steps_of_another_walk_make_no_other_branch() -> None:
    """Beside a halving the impacts move as the root of the distance: far from the straight line of two points."""
    body = ModalBody((1.0 / 2.8,), (0.0,), (1.0,), (1.0 / 2.8**2,), -0.068)
    system = System(body, Load.harmonic(0.0, 1.0), Kept(0.8))
    (orbit,) = orbits(system, 1, 1).orbits
    doubled = follow(orbit, "gap", (-0.07, -0.03), switch=1).switched[0]
    fine = line_of(doubled, lambda gap: replace(system, body=replace(body, gap=gap)))
    rows = [0, fine.values.size - 1]
    columns = ("values", "times", "speeds", "energies", "unstable")
    coarse = replace(fine, **{name: getattr(fine, name)[rows] for name in columns})
    assert fine.values.size > 8
    assert len(with_new([coarse], [fine])) == len(with_new([fine], [coarse])) == 1
    assert len(with_new([coarse], [replace(fine, points=())])) == 2  # by its rows alone it is another one


# -- what is asked --


@given(st.integers(1, 16), st.integers(1, 16))
def test_all_labels_up_to_one(p: int, n: int) -> None:
    every = list(labels_up_to((p, n)))
    assert len(set(every)) == len(every) == p * n
    assert every[0] == (1, 1)
    assert every[-1] == (p, n)


@settings(max_examples=20, deadline=None)
@given(st.floats(-0.5, 3.0), st.floats(0.01, 2.0), st.integers(2, 6), st.floats(0.0, 1.0))
def test_any_range_has_an_answer_or_a_reason(low: float, width: float, number: int, restitution: float) -> None:
    """Loads that pull, too, and bars that keep all their speed."""
    system = System(s=5.0, d=0.0, restitution=restitution, load=Load.harmonic(0.7, 1.0))
    axis = Axis.linear("mean", low, low + width, number)
    made = diagram(system, axis, up_to=None, starts=2, runs=1, modes=0, workers=1)
    assert {one.value for one in made.settled} == set(axis.values.tolist())
    assert all(0.0 <= phase < 2.0 * np.pi for one in made.settled for phase in one.phases.tolist())


@pytest.mark.parametrize(
    ("asked", "told"),
    [
        ({"up_to": (0, 1)}, "up_to"),
        ({"up_to": 3}, "up_to"),
        ({"up_to": (64, 256)}, "labels"),
        ({"searched": 0}, "searched"),
        ({"switch": -1}, "switch"),
        ({"up_to": None, "starts": 0, "runs": 0}, "starts"),
    ],
)
def test_what_cannot_be_asked_is_refused(asked: dict[str, Any], told: str) -> None:
    with pytest.raises(ParameterError, match=told):
        diagram_job(RIGID, Axis.linear("mean", 0.5, 1.0, 3), **asked)


def test_one_value_or_an_unknown_parameter_is_refused() -> None:
    with pytest.raises(ParameterError, match="two values"):
        diagram_job(RIGID, Axis("mean", np.array([0.5])), modes=0)
    with pytest.raises(PercussError, match="restitution"):
        diagram_job(RIGID, Axis.linear("nothing", 0.0, 1.0, 3), modes=0)


@pytest.mark.parametrize(("up_to", "modes"), [((1, 1), 0), ((2, 2), 0), ((1, 1), 1)])
def test_what_is_settled_on_is_drawn(up_to: tuple[int, int], modes: int) -> None:
    """Every cycle without rest that simulations settle on is on a branch, however narrow its window is."""
    system = System(s=5.0, d=0.05, restitution=0.6, load=Load.harmonic(0.5, 1.0))
    found = diagram(
        system, "mean=0.36:0.52:33", up_to=up_to, searched=1, switch=0, tries=4, starts=4, runs=3, modes=modes
    )
    cycles = [one for one in found.settled if one.label.startswith("z=")]
    assert len({one.label for one in cycles}) >= 3
    for one in cycles:
        periods = int(one.label.split("/")[1])
        on = [
            np.abs(np.exp(1j * np.sort(np.mod(times, 2.0 * np.pi))) - np.exp(1j * np.sort(one.phases))).max()
            for line in found.branches
            if (line.impacts, line.periods) == (one.phases.size, periods)
            for times in line.times_at(one.value)
        ]
        assert min(on, default=np.inf) < 0.02, one
