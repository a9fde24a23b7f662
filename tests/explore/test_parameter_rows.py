"""Systems over a parameter as rows of numbers, and the way back to a branch with them, beside the plain form."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from orbit_cases import Made
from percuss import Load, System
from percuss.errors import ParameterError, PercussError
from percuss.explore.continuation.orbit_curve import ParameterRows, SolutionCurve, turning
from percuss.explore.continuation.walk import CorrectorFailed
from percuss.explore.family import SystemFamily
from percuss.model import KelvinVoigt, Kept, Mounted, Ratio, SteppedBar, UniformBar
from percuss.model.checks import Array
from percuss.steady import orbit_near, orbits, parameter_column
from percuss.steady.periodic.impact_chain import numbers_of

HAMMER = System(s=5.0, d=0.0048, restitution=0.5, load=Load.harmonic(0.62, 1.0))
SQUARE = System(s=5.0, d=0.0048, restitution=0.5, load=Load.square(1.0, 1.55, harmonics=15))
MOUNTED = System(Mounted(stiffness=0.15, dashpot=0.05, gap=0.2), Load.harmonic(0.1, 0.5), Kept(0.6))


def turned(value: float) -> System:
    """A load whose harmonics turn with the parameter: no even change."""
    return System(s=5.0, d=0.0048, restitution=0.5, load=Load.fourier([0.62, np.exp(1j * value), 0.1]))


def plain_matrix(curve: SolutionCurve, x: Array) -> Array:
    motion, matrix = curve.motion(x), np.empty((x.size - 1, x.size))
    matrix[:, :-1] = motion.bordered().real
    matrix[:, 0] -= turning(motion) * matrix[:, -2]
    matrix[:, -1] = parameter_column(motion, curve.system, curve.value(x)) * curve.unit
    return matrix


def plainly(curve: SolutionCurve, x: Array, normal: Array) -> tuple[Array, Array]:
    """Newton's method in a plane with the plain equations, and the tangent."""
    for _ in range(12):
        matrix = plain_matrix(curve, x)
        x = x - np.linalg.solve(np.vstack([matrix, normal]), np.append(curve.motion(x).residuals, 0.0))
    tangent = np.linalg.solve(np.vstack([matrix, normal]), np.append(np.zeros(x.size - 1), 1.0))
    return x, tangent / np.linalg.norm(tangent)


@pytest.mark.parametrize(
    ("system", "times", "modes", "name", "value"),
    [
        (HAMMER, [0.39, 2.32], 0, "mean", 0.62),
        (HAMMER, [0.39, 2.32], 0, "load_factor", 0.62),
        (HAMMER, [0.39, 2.32], 8, "amplitude", 1.0),
        (HAMMER, [0.39, 2.32], 8, "s", 5.0),
        (HAMMER, [0.39, 2.32], 8, "d", 0.0048),
        (HAMMER, [0.39, 2.32], 64, "restitution", 0.5),
        (SQUARE, None, 0, "kappa", 1.55),
        (SQUARE, None, 4, "mean", SQUARE.load.mean),
        (MOUNTED, None, 1, "stiffness", 0.15),
        (MOUNTED, None, 1, "gap", 0.2),
    ],
)
def test_points_of_a_branch_are_those_of_the_plain_equations(
    system: System, times: list[float] | None, modes: int, name: str, value: float
) -> None:
    orbit = orbits(system, 1, modes=modes).orbits[0] if times is None else orbit_near(system, times, modes=modes)
    assert orbit is not None
    check_points(SolutionCurve(SystemFamily(system), name, orbit.impacts, 1, modes, 0.25), orbit, value)


def test_numbers_that_change_unevenly_are_followed_as_well() -> None:
    orbit = orbits(turned(0.0), 1, modes=3).orbits[0]
    curve = SolutionCurve(Made(lambda angle: turned(angle)), "angle", 1, 1, 3, 1.0)
    check_points(curve, orbit, 0.0)
    assert curve.rows.near(0.3)[0] == 0.3  # the row is that of the value itself


def check_points(curve: SolutionCurve, orbit: object, value: float) -> None:
    here = curve.corrected(curve.unknowns(orbit, value), curve.level)
    for size in (1e-3, 0.02):
        start = here.x + size * here.tangent
        found = curve.corrected(start, here.tangent)
        x, tangent = plainly(curve, start, here.tangent)
        assert found.x == pytest.approx(x, rel=0, abs=2e-12)
        assert found.tangent == pytest.approx(
            tangent, rel=0, abs=1e-5
        )  # the column of the parameter is that of a step before
        matrix, off = curve.linearised(found.x)
        motion = curve.motion(found.x)
        assert off == pytest.approx(motion.residuals, rel=0, abs=1e-12)
        plain = plain_matrix(curve, found.x)
        assert matrix == pytest.approx(plain, rel=1e-7, abs=1e-8 * float(np.abs(plain).max()))


@pytest.mark.parametrize(("name", "value"), [("restitution", 1.0), ("restitution", 0.0), ("d", 0.0)])
def test_rates_at_the_end_of_a_range_are_taken_from_inside(name: str, value: float) -> None:
    rows = ParameterRows(lambda at: numbers_of(SystemFamily(HAMMER).system({name: at}), 4), 0.25)
    rate = rows.rate(value)
    inside = 0.01 if value == 0.0 else 0.99
    far = numbers_of(SystemFamily(HAMMER).system({name: inside}), 4).row
    assert rows.at(value).row + (inside - value) * rate == pytest.approx(far, rel=1e-12, abs=1e-14)
    assert rows.near(inside)[0] == value  # even numbers: one row tells all
    with pytest.raises(PercussError):
        rows.at(value + 0.1 if value else -0.1)


def test_a_system_that_is_none_is_an_error_of_the_family() -> None:
    curve = SolutionCurve(SystemFamily(HAMMER), "restitution", 1, 1, 0, 0.25)
    with pytest.raises(ParameterError):
        curve.rows.at(1.5)
    with pytest.raises(CorrectorFailed):
        curve.corrected(np.array([2.3, -1.0, 6.0]), curve.level)


@given(
    values=st.lists(st.floats(0.3, 1.2), min_size=2, max_size=2, unique=True),
    modes=st.sampled_from([0, 3, 16]),
    name=st.sampled_from(["mean", "s", "restitution", "eta"]),
)
def test_rows_of_straight_lines_are_those_of_the_systems(values: list[float], modes: int, name: str) -> None:
    """From one value to the other by the rate, and the row itself, agree wherever it is said that they do."""
    base, value = values
    family = SystemFamily(HAMMER)
    if name == "eta":
        family = SystemFamily(System(UniformBar(5.0, KelvinVoigt(1e-3)), HAMMER.load, HAMMER.contact))
    if name == "restitution":
        base, value = base / 1.2, value / 1.2
    rows = ParameterRows(lambda at: numbers_of(family.system({name: at}), modes), 0.25)
    rate, row = rows.rate(base), rows.at(base).row
    here = numbers_of(family.system({name: value}), modes).row
    if rows.fits(base, rate, value):
        assert here == pytest.approx(row + (value - base) * rate, rel=1e-13, abs=1e-13)
    else:
        assert not np.allclose(here, row + (value - base) * rate, rtol=1e-15, atol=0.0)


def test_modes_that_are_searched_for_are_followed_too() -> None:
    """A stepped bar, whose frequencies do not change evenly with its wave speed."""
    body = SteppedBar(5.0, impedances=(2.0, 1.0), transit_times=(1.0, 2.0), damping=Ratio(1e-3))
    orbit = orbits(System(body, HAMMER.load, HAMMER.contact), 1, modes=3).orbits[0]
    check_points(SolutionCurve(SystemFamily(orbit.system), "s", 1, 1, 3, 1.0), orbit, 5.0)
