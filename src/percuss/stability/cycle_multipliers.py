"""Floquet multipliers of orbits with p impacts in n load periods, and their characteristic polynomial without a matrix.

The linearised motion over a cycle is W = S_p Φ_p … S_1 Φ_1, flights and saltation matrices S = D − s hᵀ/(h·ẋ⁻) of the
states of all modes, as in `linear_map` for one impact. The p × p matrix K(ξ) of the shifts of the impacts says the
same,

    det(ξ − W) = det K(ξ) (Πβ E_i − ξ) Π_n det(ξ − M_n) / Π_i (−h·ẋ⁻_i),

with M_n the map of mode n through the cycle with the times held; the eigenvalue that belongs to a shift of the whole
bar along its path has dropped out of K.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from percuss.errors import ParameterError
from percuss.mechanics.cycle import CycleStep, guarded, linearised
from percuss.model.checks import Array, ComplexArray, choice, finite, instance
from percuss.model.load import Side
from percuss.shown import Shown
from percuss.stability.multipliers import NEUTRAL, blocks
from percuss.steady import PeriodicOrbit

MOST_MODES = 512
"""An eigensolve with more modes takes minutes."""


@dataclass(frozen=True)
class OrbitMultipliers(Shown):
    """The Floquet multipliers of an orbit over its whole cycle.

    Parameters
    ----------
    orbit
        The orbit.
    values
        All 2N + 2 multipliers, of a body that is held 2N, largest modulus first; complex, dimensionless.
    """

    orbit: PeriodicOrbit = field(repr=False)
    values: ComplexArray

    @property
    def moduli(self) -> Array:
        """Moduli, largest first."""
        return np.asarray(np.abs(self.values))

    @property
    def largest(self) -> float:
        """Largest modulus."""
        return float(self.moduli.max())

    @property
    def stable(self) -> bool:
        """Whether small disturbances die out: the largest modulus is less than 1 by more than rounding."""
        return self.largest < 1.0 - NEUTRAL

    def __str__(self) -> str:
        word = "stable" if self.stable else "unstable" if self.largest > 1.0 + NEUTRAL else "neutral"
        return f"{self.orbit.label}: {word}, largest modulus {self.largest:.6g}"


def orbit_multipliers(orbit: PeriodicOrbit, *, side: Side = "right") -> OrbitMultipliers:
    """All multipliers of an orbit over its cycle of p impacts, exact for the bar with modes 0 … N.

    Parameters
    ----------
    orbit
        The orbit, with at most 512 modes.
    side
        Which value of the load counts where it jumps at an impact.

    Raises
    ------
    ParameterError
        For an orbit with more modes, or with an impact of no speed, beside which multipliers grow without bound.

    Examples
    --------
    >>> from percuss import Load, System
    >>> from percuss.steady import orbit_near
    >>> system = System(s=5.0, d=0.0, restitution=0.5, load=Load.harmonic(0.665, 1.0))
    >>> print(orbit_multipliers(orbit_near(system, [0.33, 2.07], modes=0)))
    z=2/1: stable, largest modulus 0.34302
    """
    values = np.linalg.eigvals(orbit_map(orbit, side=side)).astype(complex)
    order = np.lexsort((values.imag, -values.real, -np.round(np.abs(values), 13)))
    return OrbitMultipliers(orbit, values[order])


def orbit_map(orbit: PeriodicOrbit, *, side: Side = "right") -> Array:
    """W, the linearised motion over a cycle, from just after the first impact.

    Parameters
    ----------
    orbit, side
        As for `orbit_multipliers`.

    Returns
    -------
    numpy.ndarray
        Shape (2N + 2, 2N + 2); the states are ordered u_0, u_0', u_1, u_1', …, at fixed times. Those of a body that is
        held begin with u_1.

    Raises
    ------
    ParameterError
        As `orbit_multipliers`.
    """
    instance("orbit", orbit, PeriodicOrbit)
    choice("side", side, "left", "right")
    if orbit.modes > MOST_MODES:
        raise ParameterError("modes", orbit.modes, f"an orbit with at most {MOST_MODES} modes")
    if not np.all(orbit.speeds != 0.0):
        raise ParameterError("orbit", str(orbit), "impacts with a speed", "see `linearised`, which stays finite there")
    events, end = _events(orbit, side)
    size = 2 * end.size
    row = np.stack([end, 0.0 * end], axis=1)
    whole, _ = linearised(events, np.eye(size).reshape(-1, 2, size), lambda _, now, rate: guarded(row, now, rate))
    return whole.reshape(size, size)


def characteristic(orbit: PeriodicOrbit, xi: complex, *, side: Side = "right") -> complex:
    """det(ξ − W), whose zeros are the multipliers, in O(p²N) from K(ξ).

    Its sign at 1 and at −1 tells which folds and flips an orbit has gone through. It may overflow with thousands of
    modes, and grows without bound where the speed of an impact goes to 0; det `orbit.linearised(ξ)` does neither.

    Parameters
    ----------
    orbit
        The orbit.
    xi
        ξ, real or complex.
    side
        Which value of the load counts where it jumps at an impact.

    Examples
    --------
    >>> from percuss import Load, System
    >>> from percuss.steady import orbit_near
    >>> system = System(s=5.0, d=0.0, restitution=0.5, load=Load.harmonic(0.665, 1.0))
    >>> orbit = orbit_near(system, [0.33, 2.07], modes=0)
    >>> product, total = characteristic(orbit, 0.0).real, np.trace(orbit_map(orbit))
    >>> abs(product - 0.5**4) < 1e-12, abs(characteristic(orbit, 1.0) - (1.0 - total + product)) < 1e-12
    (True, True)
    """
    instance("orbit", orbit, PeriodicOrbit)
    choice("side", side, "left", "right")
    whole = complex(np.linalg.det(orbit.bordered(xi, side)))
    is_free = orbit.system.body.is_free
    scale = float(np.prod(-orbit.speeds)) if is_free else -float(np.prod(orbit.speeds))  # −1 stands below K(ξ) there
    return whole * complex(np.prod(orbit.modal_determinants(xi))) / scale


def _events(orbit: PeriodicOrbit, side: Side) -> tuple[list[CycleStep], Array]:
    """The flights and impacts of an orbit, and what each coordinate moves the striking end by."""
    system, first = orbit.system, int(not orbit.system.body.is_free)
    flights = [blocks(system.body, system.load.at, flight, orbit.modes) for flight in orbit.flight_times.tolist()]
    damping, omega = flights[0].damping, flights[0].omega
    turn = np.array([system.contact.strain_factor, system.contact.velocity_factor])
    forces = system.load.value(orbit.times, side)

    def rate(state: Array, force: float) -> Array:
        return np.stack([state[:, 1], force - damping * state[:, 1] - omega**2 * state[:, 0]], axis=1)

    events = []
    for i, flight in enumerate(flights):
        to, flow = (i + 1) % orbit.impacts, np.stack(flight[:4], axis=-1)
        place, velocity = orbit.states[to].displacement, orbit.states[to].velocity
        state = np.stack([np.append(0.0, place), np.append(orbit.rigid_velocities[to], velocity)], axis=1)[first:]
        force = float(forces[to])
        events.append(CycleStep(flow.reshape(-1, 2, 2), rate(state, force), rate(turn * state, force), np.diag(turn)))
    return events, flights[0].gamma


# ---- How many multipliers are outside the unit circle, from the p equations for the impact times: no matrix of all
# modes
#
# Outside the circle det K(ξ) has no poles, since with the times held no mode grows. It grows as ξ² there (as ξ⁰ of a
# body that is held), so that by the argument principle the number of its zeros outside is 2, or 0, less the number of
# turns that it makes about 0 as ξ goes once round the circle.

_STEP = 0.7  # rad, by which det K(ξ) may turn between two places
_NODES = 48  # places at first, of half the circle, besides those nearest to the poles
_DEPTH, _FEW = 0.01, 2  # distance from the circle of a pole of a mode that is hardly damped; so many may be there
_FINEST, _MOST = 1e-13, 1 << 14  # distance of places; more are not looked at


def outside_number(orbit: PeriodicOrbit, beyond: float = 0.0) -> int | None:
    """The number of multipliers with a modulus greater than 1 + `beyond`, which is from 0 to 1.

    None where a multiplier is so near to that circle that rounding decides, or so many modes are hardly damped that
    several may be near it side by side, where det K(ξ) turns about 0 unseen.

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
    size, poles = np.abs(numbers.blocks.poles), np.abs(np.angle(numbers.blocks.poles))
    if np.count_nonzero(size > 1.0 - _DEPTH) > _FEW:
        return None
    depth = np.clip(1.0 - size, 1e-9, 0.2)
    beside = np.concatenate([poles, poles - depth, poles + depth])  # there det K(ξ) turns fast
    angles = np.unique(np.append(np.linspace(0.0, np.pi, _NODES), beside[(beside > 0.0) & (beside < np.pi)]))
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
