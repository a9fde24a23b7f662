"""Where a recorded force switches: its edges, the levels between them, and how it grows with the distance behind.

An edge is where the mean force after a moment differs most from that before it. Its time is that of the step with the
same momentum: ringing, noise and a gradual rise do not move it. The levels and the slope against the distance, which is
the stiffness of a gas chamber, are those of least squares of the force between the edges.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from percuss.model.checks import Array
from percuss.steady.recorded.implied import Implied

__all__ = ["WINDOW", "Levels", "changes", "edge_times", "levels_between", "rough_edges"]

WINDOW = 1.0 / 32.0
"""Of the period: over how long the force is averaged before and after an edge."""

_LEAST = 0.2  # of the range of the force, of a jump
_SAME = 0.12  # of the range, between levels of one state
_ROUNDS = 6


@dataclass(frozen=True)
class Levels:
    """What a force that switches is between its edges.

    Parameters
    ----------
    at_wall
        Of each stretch between two edges the force at the wall, beginning after the first edge.
    stiffness
        What the force grows by per distance behind the wall, the same in all stretches.
    error
        Standard error of the stiffness.
    scatter
        Root mean square of the force about these.
    """

    at_wall: Array
    stiffness: float
    error: float
    scatter: float

    @property
    def states(self) -> tuple[list[int], list[float]]:
        """To which state each stretch belongs, and the forces of the states at the wall, in rising order."""
        order = np.argsort(self.at_wall)
        groups: list[list[int]] = [[int(order[0])]]
        least = _SAME * float(np.ptp(self.at_wall))
        for i in order[1:].tolist():
            if self.at_wall[i] - self.at_wall[groups[-1][-1]] > least:
                groups.append([])
            groups[-1].append(i)
        number = {i: n for n, group in enumerate(groups) for i in group}
        return [number[i] for i in range(self.at_wall.size)], [float(self.at_wall[group].mean()) for group in groups]


def changes(force: Array) -> Array:
    """By how much the mean force after each moment of one period at even distances is above that before it."""
    n, w = force.size, _samples(force)
    sums = np.concatenate([[0.0], np.cumsum(np.concatenate([force, force, force]))])
    i = np.arange(n, 2 * n)
    return np.asarray((sums[i + w] - 2.0 * sums[i] + sums[i - w]) / w)


def rough_edges(force: Array) -> npt.NDArray[np.intp]:
    """The edges of one period of a force at even distances, as indices of its samples, increasing."""
    w, change = _samples(force), changes(force)
    least = _LEAST * float(np.subtract(*np.percentile(force, [98.0, 2.0])))
    around = np.lib.stride_tricks.sliding_window_view(np.concatenate([change[-w:], change, change[:w]]), 2 * w + 1)
    size = np.abs(change)
    return np.flatnonzero((size >= np.abs(around).max(axis=1)) & (size > least))


def levels_between(motion: Implied, edges: Array, period: float, told: float, sloped: bool = True) -> Levels:
    """The levels of the stretches after each edge, and the slope against the distance.

    Parameters
    ----------
    motion
        From blow to blow.
    edges
        Their times in a period, increasing, and after a blow.
    told
        How many independent numbers of a period are known: twice the harmonics.
    sloped
        Whether the force may grow with the distance; else the slope is 0.
    """
    since = np.searchsorted(motion.blows, motion.time, side="right") - 1
    t = motion.time - motion.blows[np.clip(since, 0, motion.blows.size - 2)]
    stretch = (np.searchsorted(edges, t, side="right") - 1) % edges.size
    away = np.abs((t[:, None] - edges + 0.5 * period) % period - 0.5 * period).min(axis=1)
    kept = away > 0.5 * WINDOW * period
    size = edges.size
    rows = np.zeros((int(kept.sum()), size + 1))
    rows[np.arange(rows.shape[0]), stretch[kept]] = 1.0
    x, p = motion.behind[kept], motion.force[kept]
    scale = float(np.abs(x).max()) or 1.0
    rows[:, size] = x / scale if sloped else 0.0
    found, *_ = np.linalg.lstsq(rows, p, rcond=None)
    rest = p - rows @ found
    scatter = float(np.sqrt(np.mean(rest**2)))
    share = float(np.sqrt(np.linalg.pinv(rows.T @ rows)[size, size] * max(1.0, t.size / told)))
    return Levels(found[:size], float(found[size]) / scale, scatter * share / scale, scatter)


def edge_times(time: Array, force: Array, rough: Array, levels: tuple[Array, Array], window: float) -> Array:
    """The times of the steps that have the momentum of the force about each rough edge; NaN outside the samples.

    Parameters
    ----------
    time, force
        Samples of the force, without what it grows by with the distance.
    rough
        Near the edges.
    levels
        Before and after each edge.
    window
        How long before and after each edge it is looked at.
    """
    momentum = np.concatenate([[0.0], np.cumsum(0.5 * np.diff(time) * (force[1:] + force[:-1]))])
    before, after = levels
    now = rough.astype(float)
    for _ in range(_ROUNDS):
        a, b = now - window, now + window
        gained = np.interp(b, time, momentum) - np.interp(a, time, momentum)
        step = (before * (now - a) + after * (b - now) - gained) / (after - before)
        now = now + np.clip(step, -0.5 * window, 0.5 * window)
    now[(now - window < time[0]) | (now + window > time[-1])] = np.nan
    return now


def _samples(force: Array) -> int:
    return max(2, round(WINDOW * force.size))
