"""The verdict on an orbit: stable or not, why, and by what margin."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TypeVar

import numpy as np

from percuss.model import System
from percuss.model.body import need_free
from percuss.model.checks import Array, instance
from percuss.model.contact import Contact, Result
from percuss.model.load import Side
from percuss.short_repr import ShortRepr
from percuss.steady import Orbit, Reason, TimedOrbit
from percuss.steady.forced import forced_response
from percuss.steady.multipliers import NEUTRAL, TURNING, Multipliers, Repeating, reason_of
from percuss.steady.trigonometric import harmonic_sums

# ---- The waveform criterion for designers (theory §11): only the force at the moment of impact matters


@dataclass(frozen=True)
class Waveform(ShortRepr):
    """Stable when lower < p(φ)/p_0 < upper, for a rigid bar without damping and any periodic load.

    Parameters
    ----------
    ratio
        p(φ)/p_0; the value farther outside the bounds when the load jumps at the impact.
    lower
        −[(1 − R)/(1 + R)]², where the motion flips (period doubling).
    upper
        1, where two motions meet in a fold.
    mean
        p_0, dimensionless.
    restitution_needed
        The restitution below which this force at the impact would be stable; None when none would do.
    """

    ratio: float
    lower: float
    upper: float
    mean: float
    restitution_needed: float | None

    @property
    def stable(self) -> bool:
        """Whether the force at the impact lies between the bounds."""
        return self.lower < self.ratio < self.upper

    @property
    def force(self) -> float:
        """p(φ), dimensionless; times `system.force_scale` in N."""
        return self.ratio * self.mean

    @property
    def force_lower(self) -> float:
        """Least force at the impact for a stable blow, dimensionless."""
        return self.lower * self.mean

    @property
    def force_upper(self) -> float:
        """Greatest force at the impact for a stable blow, dimensionless."""
        return self.upper * self.mean


def waveform_bounds(contact: Contact) -> tuple[float, float]:
    """Between which p(φ)/p_0 a blow is stable: −[(1 − R)/(1 + R)]² and 1 (B77 36)."""
    contact.need(Result.WAVEFORM)
    return -(contact.impedance_ratio**2), 1.0


def waveform_criterion(orbit: Orbit) -> Waveform:
    """The criterion −[(1 − R)/(1 + R)]² < p(φ)/p_0 < 1 for an orbit.

    Raises
    ------
    ParameterError
        For a contact law that it does not hold for.
    """
    need_free(instance("orbit", orbit, Orbit).system.body, "the criterion of the waveform")
    load, contact = orbit.system.load, orbit.system.contact
    lower, upper = waveform_bounds(contact)
    sides = [float(load.value(orbit.phase, side)) / load.mean for side in load.sides]
    middle = 0.5 * (lower + upper)
    ratio = max(sides, key=lambda side: abs(side - middle))
    root = math.sqrt(max(-ratio, 0.0))
    needed = float(contact.restitutions_of(root)) if ratio < upper and root < 1.0 else None
    return Waveform(ratio, lower, upper, load.mean, needed)


# ---- B77's reduced stability criterion (29)–(32): valid for s ≫ 1/π
#
# For s → ∞ it is the criterion of the rigid bar and holds for every contact law. What it adds for a finite s, the
# feedback σ of the elastic modes, holds for the law that keeps the strain; for others σ = 0.

X = TypeVar("X", float, Array)


@dataclass(frozen=True)
class Reduced(ShortRepr):
    """The reduced criterion for one orbit, all numbers dimensionless.

    Parameters
    ----------
    sigma
        σ, the feedback of the elastic modes; 0 for a contact law that it does not hold for.
    a
        a_0, a_1, a_2 of a_2 ξ² + a_1 ξ + a_0 = 0.
    schur
        |a_0/a_2| and |a_1/(a_0 + a_2)|; stable when both are less than 1.
    moduli
        Moduli of the two roots ξ, largest first.
    other_side
        The same with the load's value on the other side of a jump at the impact phase, or None.
    """

    sigma: float
    a: tuple[float, float, float]
    schur: tuple[float, float]
    moduli: tuple[float, float]
    other_side: Reduced | None = None

    @property
    def stable(self) -> bool:
        """Whether both Schur quotients are less than 1, on both sides of a jump."""
        here = max(self.schur) < 1.0
        return here and (self.other_side is None or self.other_side.stable)


def elastic_feedback(orbit: Orbit) -> float:
    """σ = (1/(p_0 T)) Σ_k Re[g_k(1) p_k ik exp(ikφ)] with the body's receptance g_k, the sum over all modes."""
    # For B77's bar g_k(1) = 2 Σ_{n≥1} (−1)ⁿ H_nk. That is the forced elastic velocity of the striking end at the
    # impact, in units of p_0 T. A piecewise load enters with the harmonics that it keeps: the sum over all k does not
    # converge without damping. ParameterError for a contact law that changes the strain: the multipliers do not depend
    # on σ then.
    orbit.system.contact.need(Result.FEEDBACK)
    return orbit.response.by_harmonics.end_velocity(orbit.phase) / (orbit.system.load.mean * orbit.period)


def quadratic_coefficients(d: float, velocity_factor: X, period: float, sigma: X, slope: X) -> tuple[X, X, X]:
    """a_0, a_1, a_2 of B77 (29)–(31), β = −R of the contact law; `slope` is v_f'(φ)/p_0. Numbers, or arrays of them."""
    decay, gain = math.exp(-d * period), -math.expm1(-d * period) / (d * period) if d * period else 1.0
    beta, impulse = velocity_factor, 1.0 - velocity_factor
    fed = impulse * sigma
    a_2 = 1.0 + fed
    a_1 = -1.0 - beta**2 * decay - gain * impulse**2 * slope - (1.0 + beta * decay) * fed
    a_0 = beta * decay * (beta + fed)
    return a_0, a_1, a_2


def coefficients_at(
    system: System, period: float, phase: Array, mean: Array, velocity_factor: Array, slope: Array | None
) -> tuple[Array, Array, tuple[Array, Array, Array]]:
    """v_f'(φ)/p_0, σ and a_0, a_1, a_2 at phases; `mean` over the alternating load's; `slope`: v_f' of steps."""
    elastic = forced_response(system).by_harmonics
    k, end = elastic.k, elastic.end_shape()
    ringing, smooth = harmonic_sums(phase, k, 1j * k * elastic.p * end, 1j * k * elastic.rigid_factor)
    slope = (smooth if slope is None else slope) / mean
    sigma = ringing / (mean * period) if system.contact.holds(Result.FEEDBACK) else np.zeros_like(phase)
    return slope, sigma, quadratic_coefficients(system.d, velocity_factor, period, sigma, slope)


def schur_quotients(a_0: Array, a_1: Array, a_2: Array) -> tuple[Array, Array]:
    """|a_0/a_2| and |a_1/(a_0 + a_2)| (B77 32); inf where a denominator vanishes."""
    with np.errstate(divide="ignore", invalid="ignore"):
        first, second = np.abs(a_0 / a_2), np.abs(a_1 / (a_0 + a_2))
    return np.where(np.isnan(first), np.inf, first), np.where(np.isnan(second), np.inf, second)


def reduced_criterion(orbit: Orbit) -> Reduced:
    """B77's criterion for an orbit, with both one-sided values where the load jumps at the impact.

    For a contact law that turns the strain over it is that of the rigid bar, σ = 0; the multipliers of an elastic one
    differ from it at first order in 1/s there.

    References
    ----------
    U. Björkenstam, Int. J. Mech. Sci. 19 (1977) 471–481, equations (29)–(32).
    """
    need_free(instance("orbit", orbit, Orbit).system.body, "B77's reduced criterion")
    load = orbit.system.load
    *left, right = (float(load.value(orbit.phase, side)) for side in load.sides)
    other = _with_force(orbit, left[0], None) if left and left[0] != right else None
    return _with_force(orbit, right, other)


def _with_force(orbit: Orbit, force: float, other: Reduced | None) -> Reduced:
    system = orbit.system
    v_phi = float(orbit.response.rigid_velocity(np.array([orbit.phase]))[0])
    slope = (force - system.load.mean - system.d * v_phi) / system.load.mean  # v_f' = p − p_0 − d v_f
    sigma = elastic_feedback(orbit) if system.contact.holds(Result.FEEDBACK) else 0.0
    a = quadratic_coefficients(system.d, system.contact.velocity_factor, orbit.period, sigma, slope)
    rows = [np.asarray(x) for x in a]
    (first, second), (largest, least) = (tuple(map(float, found(*rows))) for found in (schur_quotients, moduli_of))
    return Reduced(sigma, a, (first, second), (largest, least), other)


def moduli_of(a_0: Array, a_1: Array, a_2: Array) -> tuple[Array, Array]:
    """Moduli of the roots of a_2 ξ² + a_1 ξ + a_0, largest first, without cancellation; inf where a_2 vanishes."""
    with np.errstate(divide="ignore", invalid="ignore"):
        inside, pair = a_1 * a_1 - 4.0 * a_2 * a_0, np.sqrt(np.abs(a_0 / a_2))
        big = -0.5 * (a_1 + np.copysign(np.sqrt(np.maximum(inside, 0.0)), a_1))
        one, other = np.where(a_2 == 0.0, np.inf, np.abs(big / a_2)), np.where(big == 0.0, 0.0, np.abs(a_0 / big))
    turning = inside < 0.0
    return np.where(turning, pair, np.maximum(one, other)), np.where(turning, pair, np.minimum(one, other))


# ---- The verdict on an orbit: stable or not, why, and by what margin


def floquet_multipliers(orbit: Repeating, modes: int | None = None, *, side: Side = "right") -> Multipliers:
    """All multipliers of an orbit over its cycle, exact for the bar with modes 0 … `modes`.

    Parameters
    ----------
    modes
        N, 0 to 16384, of a motion of `steady_states`; by default those that it was asked for, or 32. Other orbits have
        the modes that they were found with.
    side
        Which value of the load counts when it jumps at an impact.

    Raises
    ------
    ParameterError
        For N out of range, or other than that of the orbit; for an orbit of several impacts with more than 512 modes,
        or with one of no speed, beside which multipliers grow without bound.
    ConvergenceError
        When the roots fail the check by the trace of the map.

    Examples
    --------
    >>> from percuss import Load, System
    >>> from percuss.steady import orbit_near
    >>> system = System(s=5.0, d=0.0, restitution=0.5, load=Load.harmonic(0.665, 1.0))
    >>> print(floquet_multipliers(orbit_near(system, [0.33, 2.07], modes=0)))
    z=2/1: stable, largest modulus 0.34302, 0 modes
    """
    return instance("orbit", orbit, Repeating).multipliers(modes, side=side)


@dataclass(frozen=True)
class Stability(ShortRepr):
    """Whether small disturbances of an orbit die out.

    Parameters
    ----------
    stable
        By the exact multipliers.
    kind
        What decides, one of `percuss.steady.Reason`.
    reason
        In words: what grows, or what dies out last.
    margin
        1 minus the largest modulus: positive when stable. Per impact, dimensionless. The lesser of `margin_rhythm` and
        `margin_ringing`.
    criteria
        `reduced` and `waveform`, B77's criterion and the designer's; None of a body that is held.
    disagreement
        Where B77's criterion says otherwise, in words; else None.
    """

    stable: bool
    kind: Reason
    reason: str
    margin: float
    criteria: tuple[Reduced, Waveform] | None = field(repr=False)
    multipliers: Multipliers
    disagreement: str | None = None

    @property
    def reduced(self) -> Reduced:
        """B77's criterion; ParameterError of a body that is held."""
        return self._of_a_free_body("B77's reduced criterion")[0]

    @property
    def waveform(self) -> Waveform:
        """The criterion of the waveform; ParameterError of a body that is held."""
        return self._of_a_free_body("the criterion of the waveform")[1]

    def _of_a_free_body(self, what: str) -> tuple[Reduced, Waveform]:
        need_free(self.multipliers.system.body, what)
        assert self.criteria is not None
        return self.criteria

    @property
    def margin_rhythm(self) -> float:
        """1 minus the largest modulus of the rigid motion's multipliers: how fast the blows find their rhythm again."""
        return 1.0 - self.multipliers.rhythm

    @property
    def margin_ringing(self) -> float | None:
        """1 minus the largest modulus of all others: how fast the elastic modes ring down; None without modes."""
        ringing = self.multipliers.ringing
        return None if ringing is None else 1.0 - ringing

    def __str__(self) -> str:
        first = "stable" if self.stable else "unstable"
        also = f"; {self.disagreement}" if self.disagreement else ""
        return f"Stability: {first}, margin {self.margin:.4g} ({self.reason}){also}"


def stability_of(orbit: Repeating, *, modes: int | None = None) -> Stability:
    """Judge an orbit by its exact multipliers, beside B77's reduced criterion and the waveform criterion.

    The multipliers are exact for the contact law of the system. Under the law that keeps the strain (B77) an elastic
    mode may grow where the rigid motion is stable; that is a property of the law, not of bars, as the reason says then.
    The two criteria are those of motions of `steady_states`, which strike once in a cycle.

    Parameters
    ----------
    orbit
        Any periodic motion: of `steady_states` or `orbits`, a cycle with rest, the cycle of a machine.
    modes
        Elastic modes of the exact multipliers, as `floquet_multipliers` takes them.

    Examples
    --------
    >>> from percuss import Load, System, stability_of, steady_states
    >>> system = System(s=20.0, d=0.0048, restitution=0.6, load=Load.harmonic(0.9, 1.0))
    >>> for orbit in steady_states(system).orbits:
    ...     print(stability_of(orbit).reason)
    unstable, beyond the fold: multiplier 3.180
    stable: elastic mode 3 dies out slowest, by a factor of 0.9848 per impact
    """
    multipliers = instance("orbit", orbit, Repeating).judged(modes)
    of_one = orbit if isinstance(orbit, Orbit) else None
    margin, n, disagreement, criteria = 1.0 - multipliers.largest, multipliers.modes, None, None
    if of_one is not None and of_one.system.body.is_free:
        criteria = (reduced_criterion(of_one), waveform_criterion(of_one))
    unseen = criteria is not None and criteria[0].stable and margin < -NEUTRAL and multipliers.dominant_mode != 0
    kind = reason_of(complex(multipliers.values[0]), margin, of_one is not None and of_one.fold, unseen)
    stable = kind is Reason.STABLE
    if criteria is not None and stable != criteria[0].stable and abs(margin) > NEUTRAL:
        words = {True: "stable", False: "unstable"}
        disagreement = (
            f"B77's reduced criterion says {words[not stable]} (largest modulus {max(criteria[0].moduli):.6f}), the "
            f"exact multipliers (modes up to {n}) say {words[stable]} (largest modulus {multipliers.largest:.6f})"
        )
    return Stability(stable, kind, _sentence(kind, orbit, multipliers), margin, criteria, multipliers, disagreement)


def _sentence(kind: Reason, orbit: Repeating, multipliers: Multipliers) -> str:
    if orbit.rests:
        return "stable: a rest on the wall in every cycle erases all disturbances"
    first = complex(multipliers.values[0])
    modulus, mode, free = multipliers.largest, multipliers.dominant_mode, orbit.system.body.is_free
    what = "the rigid motion" if mode == 0 else f"elastic mode {mode}" if free else f"mode {mode}"
    if not isinstance(orbit, Orbit):
        return _in_short(kind, first, what, "cycle", orbit)
    load = orbit.system.load
    if orbit.continuum is not None:
        start, stop = orbit.continuum
        grows = f", and besides {what} grows by a factor of {modulus:.4f} per impact"
        also = "" if modulus <= 1.0 + NEUTRAL else grows
        return (
            f"one of a continuum: every impact phase from {start:.6g} to {stop:.6g} rad is steady (multiplier 1){also}"
        )
    if orbit.fold and load.value(orbit.phase, "left") != load.value(orbit.phase):
        before, after = (orbit.multipliers(multipliers.modes, side=side).largest for side in load.sides)
        return (
            "two motions meet here at a jump of the load, and neither need have the multiplier 1: the largest modulus "
            f"is {before:.4g} just before the jump and {after:.4g} just after it"
        )
    if orbit.fold:
        return "fold: two motions meet here, the multiplier is 1"
    return _in_short(kind, first, what, "impact", orbit)


def _in_short(kind: Reason, first: complex, what: str, per: str, orbit: Repeating) -> str:
    modulus = abs(first)
    if kind is Reason.STABLE:
        return f"stable: {what} dies out slowest, by a factor of {modulus:.4f} per {per}"
    if kind is Reason.NEUTRAL:
        return f"neutral: {what} neither grows nor dies out (largest modulus 1)"
    if kind is Reason.ELASTIC:
        note = orbit.system.contact.elastic_growth
        flips = abs(first.imag) <= TURNING * modulus and first.real < 0.0
        how = "turns over and grows" if flips else "grows"
        return f"{what} {how} by a factor of {modulus:.6f} per {per}{'; ' if note else ''}{note}"
    free = isinstance(orbit, Orbit) and orbit.system.body.is_free
    return _unstable(kind, first, "the rigid motion" if free else what, per)


def _unstable(kind: Reason, first: complex, what: str, blow: str) -> str:
    if kind is Reason.SPIRAL:
        turn = abs(math.atan2(first.imag, first.real))
        return f"unstable, a spiral: {what} grows by a factor of {abs(first):.4f} per {blow}, turning {turn:.3f} rad"
    if kind is Reason.FOLD:
        return f"unstable, beyond the fold: multiplier {first.real:.3f}"
    return f"flip (period doubling): multiplier {first.real:.3f}"


# ---- The verdict on a steady motion whose blows take time: the two multipliers of its rhythm


@dataclass(frozen=True)
class TimedStability(ShortRepr):
    """Whether small disturbances of the rhythm of a motion die out when its blows take time.

    Parameters
    ----------
    stable
        Whether both multipliers lie inside the unit circle; of a load that jumps during the contact, for each value
        that it has then.
    kind
        What decides, one of `percuss.steady.Reason`; None where the law cannot judge, as the load jumps just where the
        blow is.
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
    first, second = map(complex, orbit.judged().values)
    kind, modulus = orbit.verdict, abs(first)
    if kind is None:
        reason = "not judged: the load jumps while the blow acts, and how it shares the two values decides"
    elif orbit.fold:
        reason = "fold: two motions meet here"
    elif kind is Reason.STABLE:
        reason = f"stable: an error in the time or the speed of a blow shrinks to {modulus:.4f} with every blow"
    elif kind is Reason.NEUTRAL:
        reason = "neutral: an error in the time of a blow neither grows nor dies out"
    else:
        reason = _unstable(kind, first, "an error", "blow")
    return TimedStability(kind is Reason.STABLE, kind, reason, 1.0 - modulus, (first, second))
