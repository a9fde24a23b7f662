"""The orbit of a label that is near the phases of its impacts, whatever load periods these fall into."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import combinations, islice

import numpy as np

from percuss.errors import ParameterError
from percuss.model import System
from percuss.model.checks import Array
from percuss.steady import PeriodicOrbit, orbit_near

__all__ = ["orbit_at_phases"]

_TURN = 2.0 * math.pi
_NEAR = 0.5  # rad, by which each phase may be off
_MOST = 500  # ways in which the impacts may fall into the load periods


def orbit_at_phases(
    system: System, asked: str, phases: list[float], label: tuple[int, int], modes: int
) -> PeriodicOrbit:
    """The nearest orbit whose phases are near those given, in order of time.

    Parameters
    ----------
    system, modes
        What moves, with N modes.
    asked
        What was asked, for errors.
    phases
        Of the impacts, in rad; any number of turns more or less says the same.
    label
        p and n.

    Raises
    ------
    ParameterError
        When there is none near.
    """
    given = np.array(phases)
    if not np.all(np.abs(given) < 1e6):
        raise ParameterError("orbit", asked, "phases in rad")
    given = np.mod(given, _TURN)
    best, least, nearest = None, math.inf, None
    for times in islice(_unwrapped(given, label[1]), _MOST):
        found = orbit_near(system, times, label[1], modes=modes)
        if found is None:
            continue
        off = _off(found.phases, given)
        if off < least:
            nearest, least = found, off
        if off < _NEAR and (best is None or (found.admissible, -off) > (best.admissible, -_off(best.phases, given))):
            best = found
    if best is None:
        told = "" if nearest is None else f"the nearest has {', '.join(f'{phase:.6g}' for phase in nearest.phases[:4])}"
        raise ParameterError("orbit", asked, "phases near those of an orbit, in order of time", told)
    return best


def _unwrapped(phases: Array, periods: int) -> Iterator[Array]:
    """Times with these phases in order, within so many load periods: the turns that are left go to any flights."""
    flights = np.mod(np.diff(phases, append=phases[:1]), _TURN)
    flights = np.where(flights > 0.0, flights, _TURN if phases.size == 1 else 0.0)
    spare = periods - round(float(flights.sum()) / _TURN)
    if spare < 0:
        return
    p = phases.size
    for bars in combinations(range(spare + p - 1), p - 1):
        places = (-1, *bars, spare + p - 1)
        turns = np.diff(places) - 1
        longer = flights + _TURN * turns
        if np.all(longer > 0.0):
            yield phases[0] + np.append(0.0, np.cumsum(longer)[:-1])


def _off(phases: Array, given: Array) -> float:
    """How far phases are off, at most, whichever impact is the first."""
    shifts = [np.abs(np.mod(np.roll(phases, -k) - given + math.pi, _TURN) - math.pi).max() for k in range(phases.size)]
    return float(min(shifts))
