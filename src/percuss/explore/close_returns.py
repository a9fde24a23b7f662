"""Starts for a search for orbits: close returns of simulated motions."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from percuss.model import System
from percuss.model.checks import Array, callback, count, instance
from percuss.steady.periodic.search import MOST_IMPACTS, MOST_PERIODS

__all__ = ["SIMULATED", "orbit_seeds"]

SIMULATED = "simulated motions"
"""What the starts are called."""

_IMPACTS = 600  # of each motion, at most
_KEPT = 64  # last impacts that are looked at, besides a cycle
_CLOSE = 0.5  # rad, by which an impact may miss the time a cycle after itself
_EACH = 2  # starts of one motion
_MOST = 10**5  # motions
_NEW = 1e-4  # rad, by which two starts must differ


def orbit_seeds(
    system: System,
    impacts: int,
    periods: int = 1,
    *,
    modes: int = 32,
    motions: int = 64,
    seed: int = 0,
    halt: Callable[[], bool] | None = None,
) -> dict[str, Array]:
    """Where `percuss.steady.orbits` is to start: impacts of simulated motions that come back nearly after a cycle.

    Stable orbits are found in this way where few random starts lead to them; and an aperiodic motion comes near the
    unstable ones again and again (Auerbach et al., Phys. Rev. Lett. 58 (1987) 2387–2389).

    Parameters
    ----------
    system
        What moves.
    impacts, periods
        p and n.
    modes
        N.
    motions
        How many are simulated, from random starts.
    seed
        Of the random starts.
    halt
        Once it returns true no more motions are followed.

    Returns
    -------
    dict
        Rows of p times, by where they come from; for the parameter `near` of `orbits`.

    Raises
    ------
    ParameterError
        For numbers out of range.
    ResonanceError
        When an undamped bar is driven exactly at one of its own frequencies.

    Examples
    --------
    >>> from percuss import Load, System
    >>> from percuss.steady import orbits
    >>> system = System(s=5.0, d=0.0, restitution=0.5, load=Load.harmonic(0.665, 1.0))
    >>> seeds = orbit_seeds(system, 3, 1, modes=0)
    >>> orbits(system, 3, 1, modes=0, tries=100, near=seeds).sources.keys()
    dict_keys(['simulated motions', 'random times'])
    """
    from percuss.simulate import Starts, Stop, simulate_many  # loads the compiler

    instance("system", system, System)
    p, n = count("impacts", impacts, most=MOST_IMPACTS), count("periods", periods, most=MOST_PERIODS)
    start = count("seed", seed, least=0, most=2**63 - 1)
    starts = Starts.random(system, count("motions", motions, most=_MOST), seed=start)
    callback("halt", halt)
    ensemble = simulate_many(
        system, starts, modes=modes, stop=Stop(_IMPACTS + 2 * p), keep=_KEPT + p,
        progress=None if halt is None else lambda _: halt(),
    )  # fmt: skip
    found = [row for times in np.asarray(ensemble.last_time) for row in _returns(times[np.isfinite(times)], p, n)]
    return {SIMULATED: _different(np.array(found).reshape(-1, p))}


def _returns(times: Array, impacts: int, periods: int) -> Array:
    """The closest returns among the impacts of a motion; shape (K, p)."""
    cycle = 2.0 * math.pi * periods
    if times.size <= impacts:
        return np.empty((0, impacts))
    windows = np.lib.stride_tricks.sliding_window_view(times, impacts + 1)
    off = np.abs(windows[:, -1] - windows[:, 0] - cycle)
    usable = (windows[:, -2] - windows[:, 0] < cycle) & np.all(np.diff(windows) > 0.0, axis=1) & (off < _CLOSE)
    best = np.flatnonzero(usable)[np.argsort(off[usable], kind="stable")][:_EACH]
    return np.asarray(windows[best, :-1])


def _different(rows: Array) -> Array:
    """Those that are not the same but for whole load periods."""
    kept: list[Array] = []
    for row in rows:
        first = np.mod(row[0], 2.0 * math.pi)
        moved = row - row[0] + first
        if all(np.abs(moved - other).max() > _NEW for other in kept):
            kept.append(moved)
    return np.array(kept).reshape(-1, rows.shape[1])
