"""Points of branches followed through two parameters: figures of other programs, known boundaries, and both ways."""

from __future__ import annotations

import math
from functools import partial
from typing import Any

import numpy as np
import pytest

from orbit_cases import ENTRIES, Made, after, numbers, system_of
from percuss import Load, System
from percuss.errors import ParameterError
from percuss.explore import Branch, BranchEvent, BranchPoint, PointCurve, SystemFamily, boundaries, follow, follow_point
from percuss.explore.continuation.walk import CurvePoint, Problem, Walk
from percuss.explore.diagrams.diagram_job import running_pass
from percuss.model import Kept, ModalBody
from percuss.model.checks import Array
from percuss.simulate import Stop
from percuss.steady import PeriodicOrbit, orbit_near, orbits

CURVES = ENTRIES["curves_21"]
KINDS = ("fold", "flip", "grazing_touch", "grazing_impact_dies")
PLANE = ("restitution", "mean")


def two_impacts(restitution: float, mean: float, near: tuple[float, float]) -> PeriodicOrbit:
    system = System(s=5.0, d=0.0, restitution=restitution, load=Load.harmonic(mean, 1.0))
    found = orbit_near(system, near, modes=0)
    assert found is not None
    return found


@pytest.fixture(scope="module")
def branch() -> Branch:
    start = orbit_near(system_of(CURVES), [0.39, 2.32], modes=0)
    assert start is not None
    return follow(start, "mean", (0.39, 1.0))


def the(branch: Branch, kind: str) -> BranchPoint:
    return branch.at(BranchEvent(kind))[0]


# -- figures ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", KINDS)
def test_curves_of_the_figures(branch: Branch, kind: str) -> None:
    """From R = 0.5 to the ends of the range, R = 0.4 and 0.6."""
    curve = follow_point(the(branch, kind), PLANE, ((0.4, 0.6), (0.2, 1.2)))
    assert curve.event.value == kind
    assert curve.is_orbit.all()
    rows = {row["restitution"]: row[kind] for row in CURVES["rows"]}
    for end in curve.ends:
        assert end.kind is BranchEvent.LIMIT
        restitution, mean = end.values
        figure = rows[restitution]
        assert mean == pytest.approx(float(figure["value"]), rel=0, abs=1e-11)
        assert end.orbit.from_first.phases == pytest.approx(numbers(figure, "phase"), rel=0, abs=1e-10)
        assert end.orbit.from_first.speeds == pytest.approx(numbers(figure, "speed"), rel=0, abs=1e-10)


def test_a_pair_stays_on_the_unit_circle() -> None:
    entry = ENTRIES["elastic_ns_41"]
    start = orbit_near(system_of(entry), entry["start"]["phases"], modes=8)
    assert start is not None
    point = the(follow(start, "mean", (0.6199, 0.6208)), "neimark_sacker")
    curve = follow_point(point, PLANE, ((0.49, 0.51), (0.6, 0.64)), most=3)
    values = curve.ends[1].orbit.multipliers().values
    off = np.abs(np.abs(values) - 1.0)
    assert off.min() < 1e-9
    assert abs(np.angle(values[np.argmin(off)])) == pytest.approx(curve.angles[-1], abs=1e-8)
    assert abs(curve.values[-1, 0] - 0.5) > 1e-4


# -- known boundaries -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("modes", [0, 4])
def test_of_one_impact_they_are_the_boundaries_of_maps(modes: int) -> None:
    system = System(s=5.0, d=0.05, restitution=0.6, load=Load.fourier([0.7, 1.0, 0.3 + 0.2j]))
    start = orbits(system, 1, 1, modes=modes).orbits[-1]
    branch = follow(start, "load_factor", (0.35, 1.2))
    for kind in ("fold", "flip"):
        curve = follow_point(the(branch, kind), ("restitution", "load_factor"), ((0.58, 0.61), (0.3, 1.2)))
        rows = curve.values[[0, -1]]
        known = boundaries(
            system, ("restitution", np.sort(rows[:, 0])), ("load_factor", 0.35, 1.3), criterion="exact", modes=modes,
            kinds=(kind,),
        )  # fmt: skip
        for restitution, factor in rows:
            here = np.concatenate([one.y[np.isclose(one.x, restitution, rtol=0, atol=1e-15)] for one in known.curves])
            assert np.nanmin(np.abs(here - factor)) < 1e-8


def test_a_fold_at_a_step_of_the_load_stays_there() -> None:
    system = System(s=5.0, d=0.0, restitution=0.5, load=Load.square(1.0, 1.65))
    start = orbits(system, 1, 1, modes=0).orbits[-1]
    corner = the(follow(start, "kappa", (1.64, 1.8)), "nonsmooth_fold")
    curve = follow_point(corner, ("restitution", "kappa"), ((0.47, 0.52), (1.5, 1.9)))
    assert curve.event is BranchEvent.CORNER
    assert curve.times[:, 0] == pytest.approx(curve.values[:, 1] * math.pi, abs=1e-11)
    restitution, kappa = curve.ends[0].values
    beside = System(s=5.0, d=0.0, restitution=restitution, load=Load.square(1.0, kappa - 0.01))
    again = follow(orbits(beside, 1, 1, modes=0).orbits[-1], "kappa", (kappa - 0.02, kappa + 0.02))
    assert the(again, "nonsmooth_fold").value == pytest.approx(kappa, rel=0, abs=1e-11)


# -- closed curves ----------------------------------------------------------------------------------------------------


def round_(turns: int, u: float = 0.0, v: float = 0.0) -> System:
    """The mean load is a function of u² + v², and the load is turned with (u, v) or not."""
    load = Load.fourier([0.5 + u**2 + v**2, np.exp(1j * turns * math.atan2(v, u))])
    return System(s=5.0, d=0.0, restitution=0.5, load=load)


@pytest.mark.parametrize(("kind", "turns"), [("fold", 0), ("flip", 1), ("grazing_touch", 0)])
def test_a_circle_closes(branch: Branch, kind: str, turns: int) -> None:
    family, located = Made(partial(round_, turns)), the(branch, kind)
    radius, side = math.sqrt(located.value - 0.5), 1.001 if kind == "grazing_touch" else 0.999
    start = orbit_near(family.system({"u": side * radius}), located.orbit.times, modes=0)
    assert start is not None
    point = the(follow(start, "u", (0.995 * radius, 1.005 * radius), family=family, value=side * radius), kind)
    plane = (-4.0, 4.0), (-4.0, 4.0)
    curve = follow_point(point, ("u", "v"), plane, family=family, values=(point.value, 0.0), most=200)
    assert [one.kind for one in curve.ends] == [BranchEvent.CLOSED] * 2
    assert np.hypot(*curve.values.T) == pytest.approx(radius, rel=0, abs=1e-11)
    angles = np.unwrap(np.arctan2(*curve.values.T[::-1]))
    assert abs(angles[-1] - angles[0]) == pytest.approx(2.0 * math.pi, abs=1e-9)


# -- points of codimension two ----------------------------------------------------------------------------------------


def test_a_fold_and_a_touch_meet_where_either_curve_says() -> None:
    start = two_impacts(0.09, 0.385, (1.208, 2.009))
    branch = follow(start, "mean", (0.37, 0.6))
    plane = (0.07, 0.095), (0.3, 0.6)
    fold = follow_point(the(branch, "fold"), PLANE, plane)
    touch = follow_point(the(branch, "grazing_touch"), PLANE, plane)
    first, second = fold.at(BranchEvent.WITH_TOUCH)[0], touch.at(BranchEvent.WITH_FOLD)[0]
    assert first.values == pytest.approx(second.values, rel=0, abs=1e-9)
    assert first.orbit.times == pytest.approx(second.orbit.times, abs=1e-7)
    assert fold.is_orbit.any()
    assert not fold.is_orbit.all()
    changes = np.flatnonzero(np.diff(fold.is_orbit.astype(int)))
    assert changes.size == 1
    assert fold.values[changes[0], 0] == pytest.approx(first.values[0], abs=1e-2)


def test_the_same_curve_is_met_from_every_place(branch: Branch) -> None:
    curve = follow_point(the(branch, "flip"), PLANE, ((0.48, 0.52), (0.2, 1.2)))
    middle = len(curve.values) // 3
    restitution, mean = curve.values[middle]
    system = SystemFamily(system_of(CURVES)).system({"restitution": restitution, "mean": mean})
    beside = orbit_near(SystemFamily(system).system({"mean": mean + 1e-3}), curve.times[middle], modes=0)
    assert beside is not None
    again = the(follow(beside, "mean", (mean - 0.01, mean + 0.01)), "flip")
    assert again.value == pytest.approx(mean, rel=0, abs=1e-11)
    other = follow_point(again, PLANE, ((0.48, 0.52), (0.2, 1.2)))
    ends = sorted(end.values for end in curve.ends)
    assert np.array(sorted(end.values for end in other.ends)) == pytest.approx(np.array(ends), rel=0, abs=1e-11)


# -- ends and refusals ------------------------------------------------------------------------------------------------


def test_it_ends_where_the_parameter_does(branch: Branch) -> None:
    curve = follow_point(the(branch, "grazing_impact_dies"), PLANE, ((0.49, 1.5), (0.2, 1.2)))
    assert {end.kind for end in curve.ends} == {BranchEvent.LIMIT, BranchEvent.NO_SYSTEM}
    assert curve.values[:, 0].max() == pytest.approx(1.0, abs=1e-8)


def test_it_stops_when_told(branch: Branch) -> None:
    curve = follow_point(the(branch, "flip"), PLANE, ((0.1, 0.9), (0.2, 1.2)), progress=after(20))
    assert curve.ends[0].kind is BranchEvent.STOPPED
    assert len(curve.values) > 2


@pytest.mark.parametrize(
    ("change", "word"),
    [
        ({"along": ("mean",)}, "along"), ({"along": ("mean", "mean")}, "along"),
        ({"along": ("mean", "kappa")}, "kappa"),
        ({"between": ((0.6, 0.7), (0.3, 1.0))}, "between"), ({"between": (0.3, 1.0)}, "between"),
        ({"values": (0.5, 0.6)}, "point"), ({"along": ("mean", "load_factor")}, "load_factor"),
    ],
)  # fmt: skip
def test_what_cannot_be_followed_is_refused(branch: Branch, change: dict[str, Any], word: str) -> None:
    given = {"point": the(branch, "flip"), "along": PLANE, "between": ((0.4, 0.6), (0.3, 1.0))} | change
    with pytest.raises(ParameterError, match=word):
        follow_point(**given)


def test_points_are_asked_for_by_their_words(branch: Branch) -> None:
    curve = follow_point(the(branch, "flip"), PLANE, ((0.49, 0.51), (0.2, 1.2)))
    assert branch.at("flip") == branch.at(BranchEvent.FLIP) != ()
    assert curve.at("limit") == curve.at(BranchEvent.LIMIT) != ()
    assert branch.at("flip") and not branch.at("corner")
    for ask in (branch.at, curve.at):
        for unknown in ("nonsense", "FLIP", None, 3, BranchEvent):
            with pytest.raises(ParameterError, match="'impacts_coalesce'"):
                ask(unknown)  # type: ignore[operator]


def test_an_end_of_the_range_has_no_curve() -> None:
    branch = follow(two_impacts(0.5, 0.62, (0.39, 2.32)), "mean", (0.61, 0.63))
    with pytest.raises(ParameterError, match="one of the kinds"):
        follow_point(branch.points[0], PLANE, ((0.4, 0.6), (0.3, 1.0)))


def test_it_says_what_it_is(branch: Branch) -> None:
    curve = follow_point(the(branch, "flip"), PLANE, ((0.49, 0.51), (0.2, 1.2)))
    assert isinstance(curve, PointCurve)
    assert str(curve).startswith("flip of z=2/1: ")
    assert curve.angles.tolist() == [math.pi] * len(curve.values)


def test_without_ranges_it_goes_to_where_the_systems_end(branch: Branch) -> None:
    flip = the(branch, "flip")
    curve = follow_point(flip, PLANE)
    assert [end.kind for end in curve.ends].count(BranchEvent.NO_SYSTEM) >= 1
    assert curve.values[:, 0].max() == pytest.approx(1.0, abs=1e-8)
    once = follow_point(flip, PLANE, most=5)
    assert "after 5 points" in str(once)
    assert (len(once.values), once.ends[0].kind) == (9, BranchEvent.STOPPED)


@pytest.mark.parametrize("kind", KINDS)
def test_it_ends_on_the_edge_of_its_range(branch: Branch, kind: str) -> None:
    curve = follow_point(the(branch, kind), ("d", "mean"), ((0.0, 0.2), (0.2, 1.2)))
    assert [end.kind for end in curve.ends] == [BranchEvent.LIMIT] * 2
    assert sorted(end.values[0] for end in curve.ends) == [0.0, 0.2]
    assert min(end.orbit.system.d for end in curve.ends) == 0.0


def test_the_dying_impact_is_told_of_orbits_that_begin_in_any_load_period() -> None:
    system = System(s=6.0, d=0.0, restitution=0.5705, load=Load.fourier([0.3967, 1.0, -0.18 + 0.15j]))
    known = orbit_near(system, [0.346621, 3.059476, 6.631423], 2, modes=0)
    assert known is not None
    for first in (0, 1):
        times = np.array([*known.times[first:], *(time + known.period for time in known.times[:first])])
        told = PeriodicOrbit(system, 2, tuple((times + 2.0 * math.pi).tolist()), 0)
        branch = follow(told, "mean", (0.39, 0.41))
        point = the(branch, "grazing_impact_dies")
        assert point.impact == 1 + np.argmin(np.abs(point.orbit.speeds))
        curve = follow_point(point, PLANE, most=2)
        assert len(curve.values) == 3
        assert_numbered_once(told, branch)
        for one in curve.points:
            assert one.orbit.times in [tuple(times) for times in curve.times.tolist()]
            assert abs(one.orbit.speeds[point.impact - 1]) < 1e-9


def assert_numbered_once(start: PeriodicOrbit, branch: Branch) -> None:
    """The impacts of a branch and of the orbits at its points are those of the orbit it was followed from."""
    assert np.abs(branch.times - start.times).max(axis=1).min() < 1e-9
    for point in branch.points:
        row = branch.times.tolist().index(list(point.orbit.times))
        assert branch.values[row] == point.value
        assert branch.speeds[row] == pytest.approx(point.orbit.speeds, rel=0, abs=1e-12)


@pytest.mark.parametrize("first", [0, 1])
def test_impacts_keep_their_number_where_the_first_of_a_load_period_changes(first: int) -> None:
    """An impact comes to phase 0 on the way, so that the one with the least phase is another one beyond."""
    system = System(s=5.0, d=0.0, restitution=0.5, load=Load.fourier([0.62, np.exp(0.36j)]))
    known = orbits(system, 2, 1, modes=0).orbits[0]
    times = np.array([*known.times[first:], *(time + known.period for time in known.times[:first])])
    start = PeriodicOrbit(system, 1, tuple(times.tolist()), 0)
    branch = follow(start, "mean", (0.3, 1.2))
    assert np.ptp(np.argmin(branch.phases, axis=1)) == 1
    assert_numbered_once(start, branch)
    (death,) = branch.at("grazing_impact_dies")
    assert death.impact == 1 + np.argmin(np.abs(branch.speeds[branch.values == death.value][0]))


def test_it_goes_to_the_end_of_the_parameter_under_a_load_with_steps() -> None:
    system = System(s=5.0, d=0.0, restitution=0.5, load=Load.square(1.0, 1.65))
    start = orbits(system, 1, 1, modes=0).orbits[-1]
    corner = the(follow(start, "kappa", (1.64, 1.8)), "nonsmooth_fold")
    curve = follow_point(corner, ("restitution", "kappa"), most=150)
    assert [end.kind for end in curve.ends] == [BranchEvent.NO_SYSTEM] * 2
    touch = follow(start, "kappa", (1.2, 1.66)).at(BranchEvent.TOUCH)
    for point in touch:
        ends = follow_point(point, ("d", "kappa"), most=60).ends
        assert BranchEvent.NO_SYSTEM in {end.kind for end in ends}


# -- walks along curves in a plane that are known ---------------------------------------------------------------------


class Hyperbola(Problem):
    """x y = c, which turns its corner the faster the smaller c is."""

    impacts, periods, places, units, names = 0, 1, (0, 1), (1.0, 1.0), ("x", "y")

    def __init__(self, c: float) -> None:
        self.c = c

    def residual(self, x: Array) -> Array:
        return np.array([self.c - float(x[0] * x[1])])

    def system(self, *values: float) -> System:
        return None  # type: ignore[return-value]


@pytest.mark.parametrize("c", np.geomspace(1e-5, 1e-1, 13).tolist())
def test_a_corner_is_turned_however_sharp(c: float) -> None:
    way = np.array([-2.0, 0.5 * c])
    start = CurvePoint(np.array([2.0, 0.5 * c]), way / np.linalg.norm(way), 0)
    walk = Walk(Hyperbola(c), start, ((-2.1, 2.1), (-2.1, 2.1))).walked(300)
    assert walk.happened[-1].kind is BranchEvent.LIMIT
    points = np.array([point.x for point in walk.points])
    assert points[-1] == pytest.approx((c / 2.1, 2.1), rel=0, abs=1e-12)
    assert points.prod(axis=1) == pytest.approx(c, rel=0, abs=1e-12)


@pytest.mark.parametrize(
    ("place", "which", "value"), [((1.0, 0.4), 0, 0.5), ((0.8, 1.6), 1, 0.5), ((0.4, -2.0), 1, -1.0)]
)
def test_of_two_ranges_that_a_step_leaves_the_first_one_counts(
    place: tuple[float, float], which: int, value: float
) -> None:
    limit = Hyperbola(0.1).limit(np.zeros(2), np.array(place), ((-0.5, 0.5), (-1.0, 0.3 if which == 0 else 0.5)))
    assert limit is not None
    assert (limit.unknown, limit.value, limit.kind) == (which, value, BranchEvent.LIMIT)


# -- structures that are held: Budd & Dux's oscillator (Phil. Trans. R. Soc. A 347 (1994) 365–389) --------------------


OMEGA = 2.8


def oscillator(restitution: float, gap: float) -> System:
    body = ModalBody((1.0 / OMEGA,), (0.0,), (1.0,), (1.0,), gap)
    return System(body, Load.harmonic(0.0, 1.0 / OMEGA**2), Kept(restitution))


def flip(restitution: float):
    branch = follow(orbits(oscillator(restitution, -0.1), 1, 1).orbits[0], "gap", (-0.2, 0.0))
    (found,) = branch.at(BranchEvent.FLIP)
    return found


def test_the_curve_of_flips_goes_through_those_of_other_restitutions():
    curve = follow_point(flip(0.8), ("gap", "restitution"), ((-0.2, 0.0), (0.72, 0.84)))
    assert [one.kind for one in curve.ends] == [BranchEvent.LIMIT] * 2
    assert [one.values[1] for one in curve.ends] == pytest.approx([0.72, 0.84])
    assert curve.is_orbit.all()
    for gap, restitution in (curve.values[0], curve.values[3]):
        assert gap == pytest.approx(flip(restitution).value, abs=1e-10)


def test_a_death_keeps_its_gap_whatever_the_restitution():
    """An impact without speed turns nothing over: the motion there is the free one, which knows no restitution."""
    branch = follow(orbits(oscillator(0.8, -0.1), 1, 1).orbits[0], "gap", (-0.2, 0.3))
    (death,) = branch.at(BranchEvent.DEATH)
    swing = 1.0 / (OMEGA**2 - 1.0)
    assert death.value == pytest.approx(swing, abs=1e-11)
    curve = follow_point(death, ("gap", "restitution"), ((-0.2, 0.3), (0.72, 0.84)))
    assert curve.values[:, 0] == pytest.approx(swing, abs=1e-10)
    assert sorted(one.values[1] for one in curve.ends) == pytest.approx([0.72, 0.84])


def test_a_motion_taken_along_meets_the_wall_of_each_gap():
    """Its cycles are orbits of the system of their own gap, not of the one it began with."""
    systems = [oscillator(0.8, gap) for gap in (-0.1, -0.095, -0.09)]
    taken = running_pass(systems, 1, Stop(impacts=3000), 0, 0.0, 0, lambda: False)
    for row, system in enumerate(systems):
        p, n = int(taken["cycle_impacts"][row]), int(taken["cycle_periods"][row])
        assert 1 <= p <= 3 and n <= 3
        phases = np.sort(taken["phases"][row][:p])
        known = [np.sort(orbit.phases) for orbit in orbits(system, p, n, tries=100).orbits]
        assert min(float(np.abs(phases - other).max()) for other in known) < 1e-5
