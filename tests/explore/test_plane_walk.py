"""Walks along curves in a plane that are known."""

from __future__ import annotations

import numpy as np
import pytest

from percuss.explore import BranchEvent
from percuss.explore.continuation.problem import CurvePoint, Problem
from percuss.explore.continuation.walk import Walk
from percuss.model import System
from percuss.model.checks import Array


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
