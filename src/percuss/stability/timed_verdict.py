"""The verdict on a steady motion whose blows take time: the two multipliers of its rhythm.

With t the time of the force's centroid and W the mean velocity that the bar would reach there, a blow and the flight
after it map (t, W) to (t', W'). J = (1 + R)(1 + δ)(W − e p) leaves W − J; the drag and the load make W' of that until
t'; and the bar moves by A J + t_J [(W' − p' t_J) − (W − p t_J)], as both contacts begin t_J earlier, where it meets the
impact plane. The map is linearised here; without duration and advance it is B77's for a rigid bar. What is of second
order in the duration is kept as this map has it, not as the waves have it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from percuss.model.checks import Array, instance
from percuss.shown import Shown
from percuss.stability.multipliers import NEUTRAL, TURNING
from percuss.steady import Reason, TimedOrbit
from percuss.steady.oscillator import phi1

__all__ = ["TimedStability", "timed_stability"]


@dataclass(frozen=True)
class TimedStability(Shown):
    """Whether small disturbances of the rhythm of a motion die out when its blows take time.

    Parameters
    ----------
    stable
        Whether both multipliers lie inside the unit circle; of a load that jumps during the contact, for each value
        that it has then.
    kind
        What decides, one of `percuss.steady.Reason`; None where the law cannot judge, as the load jumps just where the
        blow is.
    reason
        In words.
    margin
        1 minus the largest modulus, per blow: to be compared with `Stability.margin_rhythm` of B77's motion.
    multipliers
        Both, the greater modulus first, of the value of the load that is worst.
    """

    stable: bool
    kind: Reason | None
    reason: str
    margin: float
    multipliers: tuple[complex, complex]

    def __str__(self) -> str:
        return f"TimedStability: {'stable' if self.stable else 'unstable'}, margin {self.margin:.4g} ({self.reason})"


def timed_stability(orbit: TimedOrbit) -> TimedStability:
    """Judge a motion of `timed_states` by the two multipliers of the time and the speed of its blows.

    Elastic modes have no multipliers here, as the law takes their ringing to die out between blows.

    Examples
    --------
    >>> from percuss import Load, System, Timed, timed_states
    >>> system = System(s=20.0, d=0.0048, restitution=0.6, load=Load.harmonic(0.9, 1.0))
    >>> for orbit in timed_states(system, Timed.of_uniform_bar(20.0, 0.6)).orbits:
    ...     print(timed_stability(orbit).reason)
    unstable, beyond the fold: multiplier 3.261
    stable: an error in the time or the speed of a blow shrinks to 0.5909 with every blow
    """
    instance("orbit", orbit, TimedOrbit)
    pairs = [_multipliers(orbit, force) for force in orbit.forces]
    worst = max(pairs, key=lambda pair: abs(pair[0]))
    margin = 1.0 - abs(worst[0])
    kind = _kind(orbit, worst, margin)
    return TimedStability(kind is Reason.STABLE, kind, _in_words(orbit, kind, worst), margin, worst)


def _linear_map(orbit: TimedOrbit, force: float) -> Array:
    """(dt, dW) before a blow to (dt', dW') before the next one; shape (2, 2)."""
    law, d, period = orbit.law, orbit.system.d, orbit.period
    slope = 0.0 if orbit.system.load.is_piecewise else float(orbit.system.load.derivative(orbit.phase))
    before, after, centroid = orbit.rigid_velocity, orbit.rebound_velocity, law.force_centroid
    kept, moved = math.exp(-d * period), period * float(phi1(d * period))
    push_before, push_after = force - d * before, force - d * after  # accelerations of the mean
    columns = []
    for dt, dw in ((1.0, 0.0), (0.0, 1.0)):
        dj = law.impulse(dw, slope * dt, d)
        left = dw - dj
        lag = (law.advance_per_impulse * dj + (centroid * kept - moved) * left - centroid * dw) + dt * (
            after + push_after * (moved - centroid * kept) + centroid**2 * slope
        )
        later = lag / (before - centroid * push_before + centroid**2 * slope)
        columns.append((later, kept * (left - push_after * dt) + push_before * later))
    return np.array(columns).T


def _multipliers(orbit: TimedOrbit, force: float) -> tuple[complex, complex]:
    values = np.linalg.eigvals(_linear_map(orbit, force)).astype(complex)
    first, second = sorted(values.tolist(), key=lambda x: (-round(abs(x), 13), -x.real, -x.imag))
    return first, second


def _kind(orbit: TimedOrbit, pair: tuple[complex, complex], margin: float) -> Reason | None:
    if orbit.straddles:
        return None
    if orbit.fold:
        return Reason.FOLD
    if abs(margin) <= NEUTRAL:
        return Reason.NEUTRAL
    if margin > 0.0:
        return Reason.STABLE
    if abs(pair[0].imag) > TURNING * abs(pair[0]):
        return Reason.SPIRAL
    return Reason.FOLD if pair[0].real > 0.0 else Reason.FLIP


def _in_words(orbit: TimedOrbit, kind: Reason | None, pair: tuple[complex, complex]) -> str:
    first, modulus = pair[0], abs(pair[0])
    if kind is None:
        return "not judged: the load jumps while the blow acts, and how it shares the two values decides"
    if orbit.fold:
        return "fold: two motions meet here"
    if kind is Reason.STABLE:
        return f"stable: an error in the time or the speed of a blow shrinks to {modulus:.4f} with every blow"
    if kind is Reason.NEUTRAL:
        return "neutral: an error in the time of a blow neither grows nor dies out"
    if kind is Reason.SPIRAL:
        turn = abs(math.atan2(first.imag, first.real))
        return f"unstable, a spiral: an error grows by a factor of {modulus:.4f} per blow, turning {turn:.3f} rad"
    if kind is Reason.FOLD:
        return f"unstable, beyond the fold: multiplier {first.real:.3f}"
    return f"flip (period doubling): multiplier {first.real:.3f}"
