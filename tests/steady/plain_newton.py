"""Newton's method on the times of the impacts in plain numpy, on all starts at once: what the compiled one is held to.

Roots that are known are made poles: with G = F Π (1 + 1/d_k²), d_k the distance to root k, the step is that of F times
one number (Farrell, Birkisson & Funke, SIAM J. Sci. Comput. 37 (2015) A2026–A2045), so that deflation costs no solve.
"""

from __future__ import annotations

import numpy as np

from percuss.model.checks import Array
from percuss.steady.periodic.compiled_orbits import COALESCED, Ended, Outcome
from percuss.steady.periodic.impact_chain import ImpactChain, Passage, bordered
from percuss.steady.periodic.periodic_orbit import differences

__all__ = ["newton"]

_STEPS = 60
_LONGEST = 0.5  # radians of the load that an impact is moved by in a step
_KEPT = 0.1  # part of a flight that a step leaves of it
_CLOSE = 1e-9  # steps below this are followed by two more, whose errors are rounding
_STEADY = 1e-3  # relative change of a flight by such a step; impacts that coalesce halve it at every step


def newton(chain: ImpactChain, times: Array, known: Array | None = None, turn: float = 2.0 * np.pi) -> Ended:
    """Follow starts of the shape (B, p) to impact times that belong to orbits.

    Parameters
    ----------
    chain
        The equations.
    times
        In order, each row within a period.
    known
        Roots to keep away from, shape (K, p).
    turn
        After how long the load repeats.
    """
    times = np.array(times, dtype=float)
    rebound, outcome = np.zeros(times.shape[0]), np.zeros(times.shape[0], dtype=np.int64)
    settling = np.zeros(times.shape[0], dtype=np.int64)
    if chain.is_neutral:
        rebound = np.array(chain.passage(times).rebound[:, 0])
    active = np.arange(times.shape[0])
    for _ in range(_STEPS):
        if not active.size:
            break
        passage = chain.passage(times[active], rebound[active] if chain.is_neutral else None)
        step = _steps(chain, passage)
        moved = step[:, :-1]
        size = np.abs(moved).max(axis=1)
        share = np.where(settling[active] > 0, 1.0, _lengths(chain, passage, moved, known, turn))
        with np.errstate(invalid="ignore", over="ignore"):
            moved = moved * share[:, None]
            turned = passage.force[:, 0] - chain.system.d * passage.rebound[:, 0]
            times[active] += moved
            rebound[active] = passage.rebound[:, 0] + share * step[:, -1] + turned * moved[:, 0]
        flights = np.diff(times[active], axis=1, append=times[active, :1] + chain.period)
        shrunk = np.abs(flights / passage.flights - 1.0).max(axis=1)
        near = (size <= _CLOSE) & (shrunk <= _STEADY)
        settling[active] = np.where((settling[active] > 0) & (shrunk <= _STEADY) | near, settling[active] + 1, 0)
        lost = ~np.isfinite(size)
        coalesced = ~lost & (flights.min(axis=1) < COALESCED * chain.period)
        root = ~lost & ~coalesced & (settling[active] > 2)
        outcome[active[root]], outcome[active[coalesced]] = Outcome.ROOT, Outcome.COALESCED
        active = active[~(lost | coalesced | root)]
    return Ended(times, rebound, outcome)


def _steps(chain: ImpactChain, passage: Passage) -> Array:
    """Newton's steps of the times and of the rigid velocity at fixed time; shape (B, p + 1)."""
    with np.errstate(invalid="ignore", over="ignore"):
        matrix = bordered(chain, passage, 1.0)
        off = -np.concatenate([passage.gap, passage.closure[:, None]], axis=1)
    usable = np.isfinite(matrix).all(axis=(1, 2)) & np.isfinite(off).all(axis=1)
    found = np.full(off.shape, np.nan)
    try:
        found[usable] = np.linalg.solve(matrix[usable], off[usable][..., None])[..., 0]
    except np.linalg.LinAlgError:  # one of them is singular
        found[usable] = (np.linalg.pinv(matrix[usable]) @ off[usable][..., None])[..., 0]
    return found


def _lengths(chain: ImpactChain, passage: Passage, moved: Array, known: Array | None, turn: float) -> Array:
    """What part of each step is taken; shape (B,)."""
    share = np.ones(moved.shape[0])
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        if known is not None and known.size:
            share = _deflation(differences(passage.times, known, chain.period, turn), moved)
        size = np.abs(moved).max(axis=1) * np.abs(share)
        share = share * np.minimum(1.0, _LONGEST / size)
        shrinking = -share[:, None] * (np.roll(moved, -1, axis=1) - moved)
        room = np.where(shrinking > 0.0, (1.0 - _KEPT) * passage.flights / shrinking, np.inf).min(axis=1)
        return np.asarray(np.where(np.isfinite(share), share, 1.0) * np.minimum(1.0, room))


def _deflation(off: Array, moved: Array) -> Array:
    """By what the steps are multiplied: 1/(1 − ∇ ln Π(1 + 1/d_k²) · δt); shape (B,)."""
    square = (off**2).sum(axis=-1)  # (B, K, shifts)
    nearest = np.argmin(square, axis=-1)[..., None]
    least = np.take_along_axis(square, nearest, axis=-1)[..., 0]
    toward = np.take_along_axis((off * moved[:, None, None, :]).sum(axis=-1), nearest, axis=-1)[..., 0]
    return np.asarray(1.0 / (1.0 + (2.0 * toward / (least * (least + 1.0))).sum(axis=-1)))
