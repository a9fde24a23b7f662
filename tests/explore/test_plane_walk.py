"""Walks along curves in a plane that are known."""

from __future__ import annotations

import math

import numpy as np
import pytest

from percuss.explore import BranchEvent
from percuss.explore.point_curves.plane_walk import PlaneWalk
from percuss.model.checks import Array


class Hyperbola:
    """x y = c, which turns its corner the faster the smaller c is."""

    def __init__(self, c: float) -> None:
        self.c = c

    def number(self, place: Array) -> float:
        return self.c - float(place[0] * place[1])

    def arrived(self, place: Array) -> None: ...


@pytest.mark.parametrize("c", np.geomspace(1e-5, 1e-1, 13).tolist())
def test_a_corner_is_turned_however_sharp(c: float) -> None:
    start = np.array([2.0, 0.5 * c])
    way = np.array([-2.0, 0.5 * c]) / math.hypot(2.0, 0.5 * c)
    walk = PlaneWalk(Hyperbola(c), start, way, math.hypot(2.0, 0.5 * c), np.array([[-2.1, -2.1], [2.1, 2.1]]))
    for _ in range(300):
        if walk.end is None:
            walk.step()
    assert walk.end is BranchEvent.LIMIT
    assert walk.points[-1] == pytest.approx((c / 2.1, 2.1), rel=0, abs=1e-12)
    x, y = np.array(walk.points).T
    assert x * y == pytest.approx(c, rel=0, abs=1e-12)
