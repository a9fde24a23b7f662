"""Points of codimension two: closed forms, multipliers from matrices, and curves of two kinds that meet in them."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial

import numpy as np
import pytest

from orbit_cases import ENTRIES, Made, system_of
from percuss import Load, System
from percuss.explore import BranchEvent, BranchPoint, Family, PointCurve, SystemFamily, follow, follow_point
from percuss.explore.continuation.branch_events import Partner, doubled
from percuss.explore.continuation.orbit_curve import SolutionCurve
from percuss.explore.continuation.walk import CurvePoint
from percuss.model import Kept, ModalBody
from percuss.steady import PeriodicOrbit, orbit_near, orbits

PLANE = ("restitution", "mean")


def near(system: System, times: list[float], periods: int, modes: int) -> PeriodicOrbit:
    found = orbit_near(system, times, periods, modes=modes)
    assert found is not None
    return found


def the(orbit: PeriodicOrbit, kind: str, between: tuple[float, float], number: int = 0) -> BranchPoint:
    return follow(orbit, "mean", between).at(BranchEvent(kind))[number]


def distance(curve: PointCurve, kind: BranchEvent, xi: complex) -> float:
    """How near the two multipliers nearest to ξ are to it, at the first point of a kind: matrices tell."""
    values = curve.at(kind)[0].orbit.multipliers().values
    return float(np.sort(np.abs(values - xi))[1])


def two_waves(second: float = 0.75, mean: float = 0.603) -> System:
    """A rigid bar under cos t + a cos(2t + 1.4), over a and the mean load."""
    return System(5.0, 0.0, 0.5, Load.fourier([mean, 1.0, second * np.exp(1.4j)]))


def stopped(omega: float, A: float) -> System:
    """x″ + 0.04 x′ + x = A cos ωt with a stop at 1, R = 0.9: z=1/2 grazes resonantly near ω = 4/5 and 1."""
    body = ModalBody((1.0 / omega,), (0.04 / omega,), (1.0,), (1.0 / omega**2,), 1.0)
    return System(body, Load.harmonic(0.0, A), Kept(0.9))


def flip_at(omega: float) -> tuple[Made, BranchPoint]:
    """The flip of z=1/2 of a stopped oscillator over A."""
    family, amplitude = Made(partial(stopped, omega)), 1.05 * math.hypot(1.0 - omega**2, 0.04 * omega)
    orbit = orbits(stopped(omega, amplitude), 1, 2).orbits[0]
    (found,) = follow(orbit, "A", (0.1, 2.0), family=family, value=amplitude).at(BranchEvent.FLIP)
    return family, found


def doubled_from(orbit: PeriodicOrbit, family: Family, name: str, value: float) -> Partner:
    curve = SolutionCurve(family, name, orbit.impacts, orbit.periods, orbit.modes, 1.0)
    x = curve.unknowns(orbit, value)
    partner = doubled(curve, CurvePoint(x, x, 0))
    assert partner is not None
    return partner


def away(partner: Partner, size: float) -> float:
    """How far the parameter is from that of the flip where the doubled orbit is so far from its parent."""
    curve, start = partner
    return float(curve.corrected(start.x + size * start.tangent, start.tangent).x[-1] - start.x[-1])


def a_fold_and_a_flip() -> tuple[PointCurve, str]:
    load = Load.fourier([1.15, 1.0, -0.2296 - 0.1027j])
    start = near(System(s=2.15, d=0.0277, restitution=0.8236, load=load), [0.851, 2.3926, 5.5998], 1, 2)
    return follow_point(the(start, "flip", (1.0, 1.3)), ("d", "mean"), ((0.02, 0.2), (0.9, 1.4))), "d"


def resonant_grazings() -> tuple[PointCurve, str]:
    _, first = flip_at(0.81)
    plane = (0.79, 1.01), (0.001, 2.0)
    return follow_point(first, ("omega", "A"), plane, family=Made(stopped), values=(0.81, first.value)), "omega"


@pytest.mark.parametrize(
    ("followed", "beside", "count"),
    [(a_fold_and_a_flip, BranchEvent.WITH_FOLD, (1, 1)), (resonant_grazings, BranchEvent.RESONANT_GRAZING, (2, 2))],
)
def test_at_a_generalized_flip_twice_the_amplitude_is_sixteen_times_as_far(
    followed: Callable[[], tuple[PointCurve, str]], beside: BranchEvent, count: tuple[int, int]
) -> None:
    """Its coefficient has poles at folds and at resonant grazings, whose change of sign is none."""
    curve, name = followed()

    def ratio(orbit: PeriodicOrbit, values: tuple[float, float]) -> float:
        second = curve.parameters[1]
        family = Made(partial(stopped, values[0])) if name == "omega" else SystemFamily(orbit.system)
        partner = doubled_from(orbit, family, second, values[1])
        return away(partner, 0.01) / away(partner, 0.005)

    found = curve.at(BranchEvent.GENERALIZED_FLIP)
    assert (len(found), len(curve.at(beside))) == count
    for point in found:
        assert ratio(point.orbit, point.values) == pytest.approx(16.0, rel=0.05)


@pytest.mark.parametrize("omega", [0.8005, 0.8002, 0.8, 0.7999, 0.81])
def test_the_doubled_orbit_beside_a_resonant_grazing_is_told_as_it_is(omega: float) -> None:
    """Its multipliers where its speeds differ by a hundredth; further away, by 0.01 rad, one of them is up to -1300."""
    family, flip = flip_at(omega)
    partner = doubled_from(flip.orbit, family, "A", flip.value)
    size = 0.01 * float(flip.orbit.speeds[0])
    curve, start = partner
    orbit = curve.motion(curve.corrected(start.x + size * start.tangent, start.tangent).x)
    values = orbit.multipliers().values
    assert np.all(np.abs(values) < 1.0)
    assert away(partner, size) < 0.0
    assert away(partner, 2.0 * size) / away(partner, size) == pytest.approx(4.0, rel=0.01)  # no generalized flip
    assert flip.beyond == "z=2/4 begins towards smaller A, stable"


def test_a_cusp_is_where_three_steady_motions_are_one() -> None:
    """v_f' = v_f'' = 0 there, and v_f = p_0 T (1 − R)/(2(1 + R)); phase and amplitude by Newton's method."""
    phase, second = 2.07, 0.65
    for _ in range(50):
        c, s = math.cos(2.0 * phase + 1.4), math.sin(2.0 * phase + 1.4)
        off = np.array([math.cos(phase) + second * c, -math.sin(phase) - 2.0 * second * s])
        slopes = [[off[1], c], [-math.cos(phase) - 4.0 * second * c, -2.0 * s]]
        phase, second = np.array([phase, second]) - np.linalg.solve(slopes, off)
    mean = 2.0 * 1.5 / (2.0 * math.pi * 0.5) * (math.sin(phase) + 0.5 * second * math.sin(2.0 * phase + 1.4))
    family = Made(two_waves)
    start = next(one for one in orbits(two_waves(), 1, 1, modes=0).orbits if 1.0 < one.phase < 2.0)
    branch = follow(start, "mean", (0.55, 0.65), family=family, value=0.603)
    for fold in branch.at(BranchEvent.FOLD):
        plane = (0.6, 0.8), (0.1, 2.0)
        curve = follow_point(fold, ("second", "mean"), plane, family=family, values=(0.75, fold.value))
        (cusp,) = curve.at(BranchEvent.CUSP)
        assert cusp.values == pytest.approx((second, mean), rel=0, abs=1e-11)
        assert cusp.orbit.phase == pytest.approx(phase, rel=0, abs=1e-8)


def test_a_fold_and_a_flip_meet_where_either_curve_says() -> None:
    load = Load.fourier([1.15, 1.0, -0.2296 - 0.1027j])
    start = near(System(s=2.15, d=0.0277, restitution=0.8236, load=load), [0.851, 2.3926, 5.5998], 1, 2)
    plane = (0.02, 0.2), (0.9, 1.4)
    fold = follow_point(the(start, "fold", (1.0, 1.3)), ("d", "mean"), plane)
    flip = follow_point(the(start, "flip", (1.0, 1.3)), ("d", "mean"), plane)
    (met,), (again,) = fold.at(BranchEvent.WITH_FLIP), flip.at(BranchEvent.WITH_FOLD)
    assert met.values == pytest.approx(again.values, rel=0, abs=1e-9)
    values = met.orbit.multipliers().values
    assert max(np.abs(values - 1.0).min(), np.abs(values + 1.0).min()) < 1e-8


def test_strong_resonances_are_what_matrices_say() -> None:
    load = Load.fourier([0.68759, 1.0, 0.41571 + 0.42892j, -0.19553 - 0.96514j])
    start = near(System(s=5.799, d=0.017547, restitution=0.42711, load=load), [0.4102, 3.1778, 6.9383], 2, 2)
    pair = the(start, "neimark_sacker", (0.66, 0.71))
    curve = follow_point(pair, PLANE, ((0.3, 0.6), (0.4, 0.9)))
    assert [end.kind for end in curve.ends] == [BranchEvent.RESONANCE_2] * 2
    assert distance(curve, BranchEvent.RESONANCE_2, -1.0) < 1e-5  # a double one
    for third in curve.at(BranchEvent.RESONANCE_3):
        values = third.orbit.multipliers().values
        assert np.abs(values - np.exp(2j * math.pi / 3.0)).min() < 1e-9


@pytest.mark.slow
def test_a_pair_comes_to_one_at_both_ends_of_its_curve() -> None:
    entry = ENTRIES["elastic_ns_41"]
    start = orbit_near(system_of(entry), entry["start"]["phases"], modes=8)
    assert start is not None
    curve = follow_point(the(start, "neimark_sacker", (0.6199, 0.6208)), PLANE, ((0.48, 0.52), (0.61, 0.63)))
    assert [end.kind for end in curve.ends] == [BranchEvent.RESONANCE_1] * 2
    assert len(curve.points) == 2
    for end in curve.ends:
        assert np.sort(np.abs(end.orbit.multipliers().values - 1.0))[1] < 1e-5  # a double one
        assert end.orbit.residual < 1e-9


def test_a_resonant_grazing_is_met_by_three_curves() -> None:
    """Where the greatest multiplier times the speed goes through 0 folds begin; K(ξ) is singular there for every ξ."""
    load = Load.fourier([0.31, 1.0, 0.2782 + 2.5365j])
    system = System(s=5.0, d=0.0, restitution=0.6427, load=load)
    start = near(system, [0.4, 10.47, 12.03], 2, 0)
    kinds, points = ("grazing_impact_dies", "fold"), []
    for kind in kinds:
        curve = follow_point(the(start, kind, (0.3, 0.34)), PLANE, ((0.45, 0.66), (0.28, 0.34)))
        points.append(curve.at(BranchEvent.RESONANT_GRAZING)[0])
    assert points[0].values == pytest.approx(points[1].values, rel=0, abs=1e-9)
    orbit = points[0].orbit
    sizes = [abs(np.linalg.det(orbit.linearised(xi))) for xi in (1.0, -1.0, 0.3, 2.0)]
    assert max(sizes) < 1e-8


@pytest.mark.slow
def test_folds_of_the_doubled_orbit_end_where_flips_turn() -> None:
    """A generalized flip: where the fold of the doubled orbit is when its halves, δ apart, are one: λ(δ²) at 0."""
    load = Load.fourier([1.0816, 1.0, 0.8211 - 0.3072j])
    system = System(s=3.1036, d=0.039544, restitution=0.67602, load=load)
    doubled = the(near(system, [1.889, 8.189], 2, 2), "fold", (1.0, 1.2), number=1)
    curve = follow_point(doubled, PLANE, ((0.6, 0.8), (1.0, 1.2)))
    (end,) = curve.at(BranchEvent.HALVING)
    flip = the(near(system, [1.9], 1, 2), "flip", (1.0, 1.2))
    (turn,) = follow_point(flip, PLANE, ((0.6, 0.8), (1.0, 1.2))).at(BranchEvent.GENERALIZED_FLIP)
    assert end.values == pytest.approx(turn.values, rel=0, abs=1e-9)
    apart = np.abs(np.diff(curve.times, axis=1)[:, 0] - 2.0 * math.pi)
    close = (apart > 1e-3) & (apart < 4e-3)
    assert close.sum() >= 3
    line = np.polyfit(apart[close] ** 2, curve.values[close, 0], 2)
    assert line[-1] == pytest.approx(end.values[0], rel=0, abs=1e-6)


@pytest.mark.slow
def test_a_loop_of_touches_goes_round_its_corners_and_closes() -> None:
    system = System(s=4.132, d=0.0401, restitution=0.2991, load=Load.square(1.0, 1.33))
    (start,) = [one for one in orbits(system, 1, 2, modes=1).orbits if 4.0 < one.phase < 4.1]
    touch = follow(start, "kappa", (1.3, 1.35)).at(BranchEvent.TOUCH)[-1]
    curve = follow_point(touch, ("restitution", "kappa"), ((0.0, 0.9), (1.1, 1.9)), most=150)
    assert [end.kind for end in curve.ends] == [BranchEvent.CLOSED] * 2
    assert len(curve.at(BranchEvent.WITH_CORNER)) == 2
    for corner in curve.at(BranchEvent.WITH_CORNER):
        assert corner.orbit.phase == pytest.approx(corner.values[1] * math.pi, rel=0, abs=1e-9)
    family = SystemFamily(system)
    for i in range(0, len(curve.values), 9):
        beside = family.system(dict(zip(curve.parameters, curve.values[i].tolist(), strict=True)))
        orbit = PeriodicOrbit(beside, 2, tuple(curve.times[i].tolist()), 1)
        assert orbit.residual < 1e-9
        y = orbit.motion(np.linspace(0.0, orbit.period, 40001)[:-1])
        tops = y[1:-1][(y[1:-1] >= y[:-2]) & (y[1:-1] > y[2:])]
        assert np.abs(tops).min() < 1e-6  # the samples are 3e-4 apart
