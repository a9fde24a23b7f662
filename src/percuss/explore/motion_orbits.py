"""The orbit that a simulated motion has settled on: exact, with its multipliers."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from percuss.errors import PercussError
from percuss.model.checks import Array, having
from percuss.stability import orbit_multipliers
from percuss.steady import PeriodicOrbit, orbit_near
from percuss.steady.periodic.search import MOST_IMPACTS, MOST_PERIODS

if TYPE_CHECKING:
    from percuss.simulate import Trajectory

__all__ = ["orbit_of"]

_TURN = 2.0 * math.pi
_SETTLED = 1e-4  # rad, from the last impacts to the orbit that they are on
_NEARLY = 0.05  # rad, to one that they still come nearer to
_RETURN = 0.02  # rad and share of the speed, within which an impact comes back
_CANDIDATES = 4
_MOST_MODES = 256  # an eigensolve with more takes seconds


def orbit_of(motion: Trajectory) -> PeriodicOrbit | None:
    """The periodic orbit that a simulated motion has settled on, solved for by Newton's method.

    A motion that is called ``aperiodic`` or ``undecided`` may be on its way to a long cycle: the lengths up to 64
    impacts after which its last impacts nearly come back are tried, and an orbit is the answer if it is stable and the
    last impacts are near it.

    Parameters
    ----------
    motion
        The motion, of `percuss.simulate.run`.

    Returns
    -------
    PeriodicOrbit or None
        With the modes of the motion; `percuss.stability.orbit_multipliers` tells how fast disturbances die out. None
        for cycles with rest, for motions that settle on none, and for more than 64 impacts, 256 periods or 256 modes.

    Examples
    --------
    >>> from percuss import Load, Start, System, simulate
    >>> system = System(s=5.0, d=0.0, restitution=0.5, load=Load.harmonic(0.665, 1.0))
    >>> motion = simulate.run(system, Start.rigid(velocity=0.5, time=0.4), modes=0)
    >>> motion.label, orbit_of(motion).label
    ('z=2/1', 'z=2/1')
    """
    having("motion", motion, ("events", "label", "cycle", "system", "modes"), "a simulated motion")
    struck = motion.events.of("impact")
    times, speeds = np.asarray(struck.time), np.asarray(struck.impact_velocity)
    if motion.modes > _MOST_MODES:
        return None
    if motion.cycle is not None:
        p, n = motion.cycle.impacts, motion.cycle.periods
        fits = motion.cycle.kind == 0 and p <= min(MOST_IMPACTS, times.size) and n <= MOST_PERIODS
        return _near(motion, times[-p:], n, _SETTLED) if fits else None
    if motion.label not in ("aperiodic", "undecided") or motion.period_unresolved:
        return None
    for p, n in _lengths(times, speeds):
        found = _near(motion, times[-p:], n, _NEARLY)
        if found is not None and orbit_multipliers(found).stable:
            return found
    return None


def _near(motion: Trajectory, times: Array, periods: int, room: float) -> PeriodicOrbit | None:
    """The orbit near impacts of a motion; None where there is none that is possible."""
    moved = times - _TURN * math.floor(times[0] / _TURN)
    try:
        found = orbit_near(motion.system, moved, periods, modes=motion.modes)
        if found is None or not found.admissible or found.resonant_modes:
            return None
    except PercussError:
        return None
    flights = np.diff(moved, append=moved[0] + found.period)
    shifts = [np.abs(np.roll(flights, -shift) - found.flight_times).max() for shift in range(found.impacts)]
    return found if min(shifts) < room else None


def _lengths(times: Array, speeds: Array) -> list[tuple[int, int]]:
    """Impacts and load periods after which the last impacts nearly come back, the shortest first."""
    found = []
    for p in range(1, min(MOST_IMPACTS, (times.size - 1) // 2) + 1):
        gone = times[-p:] - times[-2 * p : -p]
        n = round(float(gone[-1]) / _TURN)
        changed = np.abs(speeds[-p:] - speeds[-2 * p : -p]).max()
        near = np.abs(gone - _TURN * n).max() < _RETURN and changed < _RETURN * np.abs(speeds[-2 * p :]).max()
        if 1 <= n <= MOST_PERIODS and near:
            found.append((p, n))
    return found[:_CANDIDATES]
