"""Where the load lets go of a bar that rests on the wall, and for how long it pulls (theory, Rest and release)."""

from __future__ import annotations

import math

import numpy as np

from percuss.model import Load
from percuss.model.checks import Array
from percuss.steady.trigonometric import TURN, on_circle, trigonometric_roots

__all__ = ["pull_lasts", "release_phases", "time_to_release"]

_SAME = 1e-9  # phases nearer than this are one


def release_phases(load: Load) -> Array:
    """The phases in [0, 2π) at which the load begins to pull, increasing; empty where it never pulls, or always.

    Of steps those breaks at which the force jumps below 0. A load that touches 0 from above does not pull.
    """
    if load.is_piecewise:
        values, breaks = np.asarray(load.values), np.asarray(load.breaks)
        return np.asarray(np.sort(on_circle(breaks[(values < 0.0) & (np.roll(values, 1) >= 0.0)])))
    roots, pulls = _zeros(load)
    if not roots.size:
        return np.empty(0)
    return np.asarray(roots[pulls & ~np.roll(pulls, 1)])


def _zeros(load: Load) -> tuple[Array, np.typing.NDArray[np.bool_]]:
    """The zeros of a smooth load, and whether it pulls after each, up to the next."""
    k = np.append(0.0, load.harmonics.astype(float))
    roots = trigonometric_roots(k, np.append(complex(load.mean), load.coefficients[load.harmonics]))
    if not roots.size:
        return roots, np.empty(0, dtype=bool)
    middles = 0.5 * (roots + np.append(roots[1:], roots[0] + TURN))
    return roots, np.asarray(load.value(middles) < 0.0)


def pull_lasts(load: Load, phase: float) -> float:
    """How long the load pulls, or is 0, from a phase on at which it begins to; inf when it never pushes again."""
    if load.is_piecewise:
        values, breaks = np.asarray(load.values), np.asarray(load.breaks)
        pushes = np.sort(np.mod(breaks[values > 0.0] - phase, TURN))
        return float(pushes[pushes > 0.0].min(initial=math.inf))
    roots, pulls = _zeros(load)
    ahead = np.mod(roots[~pulls] - phase, TURN)
    return float(ahead[ahead > _SAME].min(initial=math.inf))


def time_to_release(load: Load, phases: Array, time: float) -> tuple[float, int]:
    """How long the load holds a bar that lies on the wall at a time, and the number of the release phase then.

    A bar that the load pulls already is let go at once; its number is −1 unless that is a release phase.

    Parameters
    ----------
    load, phases
        The load, and its release phases: at least one.
    time
        When the bar comes to rest.
    """
    ahead = np.mod(phases - time, TURN)
    ahead = np.where(TURN - ahead <= 4.0 * np.spacing(max(abs(time), TURN)), 0.0, ahead)
    nearest = int(np.argmin(ahead))
    if ahead[nearest] == 0.0 or float(load.value(time)) >= 0.0:
        return float(ahead[nearest]), nearest
    return 0.0, -1
