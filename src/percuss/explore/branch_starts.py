"""Starts for a search for orbits: what begins at flips and grazings of the branches of shorter orbits."""

from __future__ import annotations

import numpy as np

from percuss.explore.continuation.branch import Branch
from percuss.explore.continuation.following import follow
from percuss.model import System
from percuss.model.checks import Array, count, instance, unit_interval
from percuss.steady import orbits
from percuss.steady.periodic.search import MOST_IMPACTS, MOST_PERIODS
from percuss.steady.states import MAX_MODES

__all__ = ["SWITCHED", "switched_seeds"]

SWITCHED = "branches of shorter orbits"
"""What the starts are called."""

_MOST_POINTS = 400  # of a branch, each way


def switched_seeds(
    system: System, impacts: int, periods: int = 1, *, modes: int = 32, reach: float = 0.2, tries: int = 100
) -> dict[str, Array]:
    """Where `percuss.steady.orbits` is to start: orbits that begin at a flip or a grazing of a shorter one.

    The orbits with half the impacts in half the periods, and of a rigid bar those with one impact less, are followed
    through the mean load; from their flips and grazings the branches z=p/n are followed, and where one comes by the
    mean load of the system it is a start.

    Parameters
    ----------
    system
        What moves; nothing holds it.
    impacts, periods
        p and n.
    modes
        N.
    reach
        Share of the mean load by which it is changed, 0 to 1.
    tries
        Random starts in the search for the shorter orbits.

    Returns
    -------
    dict
        Rows of p times, by where they come from; for the parameter `near` of `orbits`.

    Raises
    ------
    LoadError, ResonanceError, ParameterError
        As `percuss.steady.orbits`.

    Examples
    --------
    >>> from percuss import Load, System
    >>> system = System(s=5.0, d=0.0, restitution=0.5, load=Load.harmonic(0.64, 1.0))
    >>> rows = switched_seeds(system, 2, 2, modes=0)["branches of shorter orbits"]
    >>> rows.shape
    (1, 2)
    """
    instance("system", system, System)
    p, n = count("impacts", impacts, most=MOST_IMPACTS), count("periods", periods, most=MOST_PERIODS)
    kept, wanted = count("modes", modes, least=0, most=MAX_MODES), count("tries", tries, most=10**7)
    share = unit_interval("reach", reach)
    shorter = [(p // 2, n // 2)] if p % 2 == 0 and n % 2 == 0 else []
    shorter += [(p - 1, n)] if kept == 0 and p > 1 else []
    mean = system.load.mean
    rows: list[Array] = []
    for fewer, within in shorter if system.body.is_free and share > 0.0 else []:
        for orbit in orbits(system, fewer, within, modes=kept, tries=wanted).orbits:
            branch = follow(
                orbit, "mean", (mean * (1.0 - share), mean * (1.0 + share)), switch=1, most=_MOST_POINTS
            )  # fmt: skip
            for one in branch.family():
                if (one.impacts, one.periods) == (p, n):
                    rows += _passing(one, mean)
    return {SWITCHED: np.array(rows).reshape(-1, p)}


def _passing(branch: Branch, value: float) -> list[Array]:
    """The times at which a branch comes by a value of its parameter, between the points walked through."""
    off = branch.values - value
    found = []
    for i in np.flatnonzero((off[:-1] * off[1:] <= 0.0) & (off[:-1] != off[1:])):
        part = off[i] / (off[i] - off[i + 1])
        found.append((1.0 - part) * branch.times[i] + part * branch.times[i + 1])
    return found
