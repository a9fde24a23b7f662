"""When a place of a body first enters a region in a flight, or the proof that it does not: bounds, not a scan.

In a cell of time of the width h, r, r′ and r″ are known at its left edge, and |r‴| is bounded from the free motion of
the derivatives: the acceleration a of a coordinate obeys a″ + d a′ + ω² a = 0, so that in every regime of damping
|a′| ≤ |a′₀| + ω² min(h, 1/ω)|a₀|. A cell is done with when Taylor's theorem proves that r keeps its sign there, or only
falls, or only rises; others are halved.

A place that leaves an edge is measured from there by how far it has moved, and not by where it is: the way back after a
slow rebound is far less than the rounding error of a place. A rebound too short for the cells is a parabola.
"""

from __future__ import annotations

from functools import cache
from typing import Any, NamedTuple

import numpy as np

from percuss.mechanics.flow import ModalFlight
from percuss.mechanics.kernel_cache import ensure_cache
from percuss.model.checks import Array


class Regions(NamedTuple):
    """Entered where r = rows · displacements − levels − drifts · time rises through 0; small: against `scale`."""

    rows: Array
    levels: Array
    scale: float
    drifts: Array


class Entering(NamedTuple):
    """The first time at which a region is entered, infinite for none, which one, and whether this is proved."""

    time: float
    which: int
    proven: bool


@cache
def _kernels() -> Any:
    """The compiled functions, from numba's cache if they are there; else each is compiled when it is first called."""
    ensure_cache()
    from percuss.mechanics import crossing_kernels

    return crossing_kernels


def _told(flight: ModalFlight, regions: Regions) -> tuple[Array, tuple[float, float, float], Array, tuple[Array, ...]]:
    """What compiled functions take for a flight and for regions, and room for them."""
    modes, (u, v) = flight.modes, flight.begin.T
    numbers = float(flight.force), float(flight.ramp), float(flight.duration)
    edges = np.column_stack([regions.rows, regions.levels, regions.drifts])
    room = np.empty((len(edges), 6)), np.empty((len(u), 4))
    return np.array([modes.omega, modes.damping, modes.driven, u, v]), numbers, edges, room


def first_entering(flight: ModalFlight, regions: Regions) -> Entering:
    """The first region that is entered before the end of the flight; one whose edge is met at its end is not."""
    if flight.duration <= 0.0 or not len(regions.rows):
        return Entering(np.inf, -1, True)
    table, numbers, edges, room = _told(flight, regions)
    return Entering(*_kernels().entered(table, *numbers, float(regions.scale), edges, *room))


def clearances(flight: ModalFlight, regions: Regions, met: int) -> Array:
    """How far each region is from being entered in a flight that ends where the one with the number `met` is."""
    # Between two turns r rises from a least to a greatest value; it enters where these have different signs, and is
    # about to where one of them is 0: max(least, −greatest), the least of all rises. Infinite where r never rises.
    table, numbers, edges, room = _told(flight, regions)
    _kernels().cleared(table, *numbers, edges, met, *room)
    return np.asarray(room[0][:, _kernels().LEAST])


def farthest(flight: ModalFlight, row: Array, drift: float = 0.0) -> float:
    """The greatest of −row · displacements − drift · time in a flight."""
    regions = Regions(-row[None, :], np.zeros(1), 1.0, np.array([drift]))
    table, numbers, edges, room = _told(flight, regions)
    return float(_kernels().highest(table, *numbers, edges, *room[1:]))
