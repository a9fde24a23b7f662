"""How many multipliers are outside the unit circle, from the p equations for the impact times: no matrix of all modes.

Outside the circle det K(ξ) has no poles, since with the times held no mode grows. It grows as ξ² there (as ξ⁰ of a body
that is held), so that by the argument principle the number of its zeros outside is 2, or 0, less the number of turns
that it makes about 0 as ξ goes once round the circle.
"""

from __future__ import annotations

import numpy as np

from percuss.model.checks import Array, finite, instance
from percuss.steady import PeriodicOrbit
from percuss.steady.periodic.many_numbers import ManyNumbers

__all__ = ["outside_number"]

_STEP = 0.7  # rad, by which det K(ξ) may turn between two places
_NODES = 48  # places at first, of half the circle, besides those nearest to the poles
_DEPTH, _FEW = 0.01, 2  # distance from the circle of a pole of a mode that is hardly damped; so many may be there
_FINEST, _MOST = 1e-13, 1 << 14  # distance of places; more are not looked at


def outside_number(orbit: PeriodicOrbit, beyond: float = 0.0) -> int | None:
    """The number of multipliers with a modulus greater than 1 + `beyond`.

    Parameters
    ----------
    orbit
        The orbit.
    beyond
        Between 0 and 1: how far outside they must be.

    Returns
    -------
    int or None
        The number; None where a multiplier is so near to that circle that rounding decides, or so many modes are hardly
        damped that several may be near it side by side, where det K(ξ) turns about 0 unseen.

    Examples
    --------
    >>> from percuss import Load, System
    >>> from percuss.steady import orbit_near
    >>> system = System(s=5.0, d=0.0, restitution=0.5, load=Load.harmonic(0.62, 1.0))
    >>> outside_number(orbit_near(system, [0.39, 2.32], modes=0))
    1
    """
    instance("orbit", orbit, PeriodicOrbit)
    radius = 1.0 + finite("beyond", beyond)
    numbers = orbit.many_numbers()
    if np.count_nonzero(np.abs(numbers.poles) > 1.0 - _DEPTH) > _FEW:
        return None
    angles = _nodes(numbers)
    signs = numbers.directions(radius * np.exp(1j * angles))
    while True:
        turns = np.angle(signs[1:] / signs[:-1])
        wide = np.flatnonzero(~(np.abs(turns) <= _STEP))
        if not wide.size:
            break
        middle = 0.5 * (angles[wide] + angles[wide + 1])
        if np.min(angles[wide + 1] - angles[wide]) < _FINEST or angles.size > _MOST:
            return None
        angles = np.insert(angles, wide + 1, middle)
        signs = np.insert(signs, wide + 1, numbers.directions(radius * np.exp(1j * middle)))
    growth = 2 if orbit.system.body.is_free else 0
    return growth - round(float(turns.sum()) / np.pi)  # of both halves, which mirror each other


def _nodes(numbers: ManyNumbers) -> Array:
    """Places on half the circle: evenly, and at and beside the angles of the poles, where det K(ξ) turns fast."""
    poles = numbers.poles
    angles, depth = np.abs(np.angle(poles)), np.clip(1.0 - np.abs(poles), 1e-9, 0.2)
    beside = np.concatenate([angles, angles - depth, angles + depth])
    even = np.linspace(0.0, np.pi, _NODES)
    return np.unique(np.concatenate([even, beside[(beside > 0.0) & (beside < np.pi)]]))
