"""Rest: the bar lying on the wall for all time, a steady state of its own (theory §4)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from percuss.model import System
from percuss.model.body import need_free
from percuss.model.checks import ComplexArray, instance
from percuss.shown import Shown
from percuss.steady.near_resonance import step_harmonics
from percuss.steady.resonance import held_resonance
from percuss.steady.step_waves import least_contact_force
from percuss.steady.trigonometric import on_circle, trigonometric_roots

__all__ = ["Rest", "rest_on_wall"]

_SMOOTHED, _PLACES = 1024, 1 << 16  # harmonics of steps, and phases looked at, where their waves are not followed
_EPS = np.finfo(float).eps


@dataclass(frozen=True)
class Rest(Shown):
    """The bar at rest on the wall.

    Parameters
    ----------
    possible
        The verdict, by the contact force with the waves in the bar: whether it never pulls.
    least_contact_force
        Its least value over the load period, dimensionless; −inf when the resting bar is driven in resonance.
    phase
        Load phase of the least contact force, or None.
    quasi_static
        The least value of p(t) itself, the contact force without waves: the limit s → ∞ under a smooth load.
    """

    possible: bool
    least_contact_force: float
    phase: float | None
    quasi_static: float

    @property
    def lifted_by_waves(self) -> bool:
        """Whether waves alone lift the end off, for moments of a wave's way through the bar: the load never pulls."""
        return not self.possible and self.quasi_static >= 0.0

    @property
    def held_by_waves(self) -> bool:
        """Whether waves alone hold the end at the wall while the load pulls: a simulation, without them, lets go."""
        return self.possible and self.quasi_static < 0.0

    def __str__(self) -> str:
        word = "possible" if self.possible else "not possible"
        return (
            f"Rest: {word}, least contact force {self.least_contact_force:.6g} (quasi-static {self.quasi_static:.6g})"
        )


def rest_on_wall(system: System) -> Rest:
    """Is u(1, t) ≡ 0 a steady state, and how hard does the bar press?

    The verdict goes by the contact force with every wave resolved: of a uniform bar driven at its end
    f = p_0 + Re Σ p_k exp(ikt)/cos q_k, of any body the receptance from the load to the striking end over that of the
    striking end itself in place of 1/cos q_k. A jump of the load doubles in it and comes back with every echo, so that
    steps can lift off a bar that the load itself never pulls: `quasi_static` tells. A simulation takes the load itself
    as the contact force of a bar at rest.

    On a uniform bar with external damping, driven at its end, steps are taken exactly, whatever harmonics are kept
    beside them (theory §4); where hardly anything damps them the force may be told a jump or two too low, never a
    resonance overlooked. For other bodies, places and dampings the first 1024 harmonics of the steps are summed with
    Fejér's weights, a mean over about 1/1000 of the period that overshoots nowhere: shorter pulls are not seen.

    Examples
    --------
    >>> from percuss import Load, System
    >>> rest_on_wall(System(s=20.0, d=0.0, restitution=0.5, load=Load.harmonic(1.5, 1.0))).possible
    True
    >>> print(rest_on_wall(System(50.0, 0.02, 0.3, Load.steps([0.0, 3.14], [1.0, 0.3]))))
    Rest: not possible, least contact force -1.91723 (quasi-static 0.3)
    """
    load = instance("system", system, System).load
    need_free(system.body, "rest on the wall")
    if load.is_piecewise:
        return _under_steps(system)
    k = load.harmonics.astype(float)
    p: ComplexArray = load.coefficients[load.harmonics]
    quasi_static, _ = _least(k, p, load.mean)
    transfer = system.body.held_transfer(k, load.at)
    if not np.all(np.isfinite(transfer)):
        return Rest(False, -math.inf, None, quasi_static)
    least, phase = _least(k, p * transfer, load.mean)
    return Rest(least >= 0.0, least, phase, quasi_static)


def _under_steps(system: System) -> Rest:
    load, body, quasi_static = system.load, system.body, min(system.load.values)
    if not load.jumps:
        return Rest(quasi_static >= 0.0, quasi_static, None, quasi_static)
    if not (body.is_harmonic and body.damping.is_even and load.at == 0):
        least, phase = _smoothed(system)
    elif system.d == 0.0 and held_resonance(load, body.frequency_floor(1)):
        least, phase = -math.inf, None
    else:
        least, phase = least_contact_force(load, system.s, system.d)
    return Rest(least >= 0.0, least, phase, quasi_static)


def _smoothed(system: System) -> tuple[float, float | None]:
    """The least contact force by the first harmonics of steps, summed with Fejér's weights, and its phase."""
    jumps, k = system.load.jumps, np.arange(1.0, _SMOOTHED + 1.0)
    places, sizes = np.array([jump.phase for jump in jumps]), np.array([jump.after - jump.before for jump in jumps])
    p, transfer = step_harmonics(places, sizes, k), system.body.held_transfer(k, system.load.at)
    if np.any(~np.isfinite(transfer) & (p != 0.0)):
        return -math.inf, None
    spectrum = np.zeros(_PLACES // 2 + 1, dtype=complex)
    felt = p != 0.0
    weights = (1.0 - k / (_SMOOTHED + 1.0))[felt]
    spectrum[1 : _SMOOTHED + 1][felt] = 0.5 * _PLACES * weights * p[felt] * transfer[felt]
    force = np.fft.irfft(spectrum, _PLACES) + system.load.mean
    best = int(np.argmin(force))
    return float(force[best]), 2.0 * math.pi * best / _PLACES


def _least(k: np.typing.NDArray[np.float64], p: ComplexArray, mean: float) -> tuple[float, float | None]:
    """Least value of mean + Re Σ p_k exp(ikt) and where it is taken."""
    felt = np.abs(p) > _EPS * max(abs(mean), float(np.abs(p).max(initial=0.0)))
    k, p = k[felt], p[felt]  # strong damping swallows the others before they reach the wall
    if not k.size:
        return mean, None
    if k.size == 1:
        return mean - float(np.abs(p[0])), float(on_circle((np.pi - np.angle(p[0])) / k[0]))
    phases = trigonometric_roots(k, 1j * k * p)
    values = mean + (np.exp(1j * np.outer(phases, k)) @ p).real
    best = int(np.argmin(values))
    return float(values[best]), float(phases[best])
