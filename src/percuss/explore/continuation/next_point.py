"""What makes the end of a step along a curve the next point of that curve, and not a point of another one."""

from __future__ import annotations

import math

import numpy as np

from percuss.model.checks import Array

__all__ = ["FIRST", "LONGEST", "SHORTEST", "Strayed", "check_next", "unit_tangent"]

FIRST, LONGEST, SHORTEST = 0.02, 0.1, 1e-9
"""Steps along a curve, of each impact in rad."""

_TURN = math.cos(math.radians(25.0))  # of the tangent in a step
_ASIDE = 0.5  # of a step, by which its end may be beside the tangent
_FLIGHT = 0.5  # share of a flight by which it may change in a step


class Strayed(Exception):
    """Newton's method found no point of the curve, or not the one that was meant."""


def unit_tangent(matrix: Array, along: Array) -> Array:
    """The unit tangent that goes the same way as `along`; Strayed where it is at right angles to it."""
    try:
        found = np.linalg.solve(np.vstack([matrix, along]), np.append(np.zeros(along.size - 1), 1.0))
    except np.linalg.LinAlgError:
        raise Strayed("no tangent") from None
    return np.asarray(found / np.linalg.norm(found))


def check_next(
    before: tuple[Array, Array], after: tuple[Array, Array], place: Array, size: float, impacts: int, periods: int
) -> Array:
    """The times of the flights after a step; Strayed where its end is not the next point.

    Parameters
    ----------
    before, after
        Unknowns, the impact times first, and unit tangent at either end; shape (m,) each.
    place, size
        Where the step led along the tangent, and its length.
    impacts, periods
        p and n.
    """
    p, period = impacts, 2.0 * math.pi * periods
    (x, tangent), (x_after, tangent_after) = before, after
    flights, flights_after = (np.append(one[1:p], one[0] + period) - one[:p] for one in (x, x_after))
    if float(tangent_after @ tangent) < _TURN:
        raise Strayed("a bend")
    if float(np.linalg.norm(x_after - place)) > _ASIDE * size:
        raise Strayed("beside the tangent")
    if not np.all(np.abs(flights_after / flights - 1.0) < _FLIGHT):
        raise Strayed("a flight changes too much")
    return np.asarray(flights_after)
