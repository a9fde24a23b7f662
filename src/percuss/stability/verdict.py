"""The verdict on an orbit: stable or not, why, and by what margin."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from percuss.model.body import need_free
from percuss.model.checks import instance
from percuss.shown import Shown
from percuss.stability.multipliers import NEUTRAL, TURNING, Multipliers, floquet_multipliers
from percuss.stability.reduced import Reduced, reduced_criterion
from percuss.stability.waveform import Waveform, waveform_criterion
from percuss.steady import Orbit, Reason

__all__ = ["DEFAULT_MODES", "Stability", "stability_of"]

DEFAULT_MODES = 32


@dataclass(frozen=True)
class Stability(Shown):
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
    multipliers
        The exact ones.
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
        if self.criteria is None:
            need_free(self.multipliers.system.body, "B77's reduced criterion")
        assert self.criteria is not None
        return self.criteria[0]

    @property
    def waveform(self) -> Waveform:
        """The criterion of the waveform; ParameterError of a body that is held."""
        if self.criteria is None:
            need_free(self.multipliers.system.body, "the criterion of the waveform")
        assert self.criteria is not None
        return self.criteria[1]

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


def stability_of(orbit: Orbit, *, modes: int | None = None) -> Stability:
    """Judge an orbit by its exact multipliers, beside B77's reduced criterion and the waveform criterion.

    The multipliers are exact for the contact law of the system. Under the law that keeps the strain (B77) an elastic
    mode may grow where the rigid motion is stable; that is a property of the law, not of bars, as the reason says then.

    Parameters
    ----------
    orbit
        An orbit of `steady_states`.
    modes
        Elastic modes of the exact multipliers; by default those that the orbit was asked for, or 32.

    Examples
    --------
    >>> from percuss import Load, System, stability_of, steady_states
    >>> system = System(s=20.0, d=0.0048, restitution=0.6, load=Load.harmonic(0.9, 1.0))
    >>> for orbit in steady_states(system).orbits:
    ...     print(stability_of(orbit).reason)
    unstable, beyond the fold: multiplier 3.180
    stable: elastic mode 3 dies out slowest, by a factor of 0.9848 per impact
    """
    instance("orbit", orbit, Orbit)
    n = modes if modes is not None else DEFAULT_MODES if orbit.requested_modes is None else orbit.requested_modes
    if not orbit.system.body.is_free:
        return _of_structure(orbit, n)
    reduced = reduced_criterion(orbit)
    multipliers = floquet_multipliers(orbit, n)
    if reduced.other_side is not None:  # the load jumps at the impact: the worse side decides
        multipliers = max(multipliers, floquet_multipliers(orbit, n, side="left"), key=lambda m: m.largest)
    margin = 1.0 - multipliers.largest
    stable = margin > NEUTRAL and not orbit.fold
    disagreement = None
    if stable != reduced.stable and abs(margin) > NEUTRAL:
        words = {True: "stable", False: "unstable"}
        disagreement = (
            f"B77's reduced criterion says {words[reduced.stable]} (largest modulus {max(reduced.moduli):.6f}), the "
            f"exact multipliers (modes up to {n}) say {words[stable]} (largest modulus {multipliers.largest:.6f})"
        )
    kind = _kind(orbit, multipliers, reduced, stable)
    reason = _in_words(kind, orbit, multipliers, reduced)
    criteria = reduced, waveform_criterion(orbit)
    return Stability(stable, kind, reason, margin, criteria, multipliers, disagreement)


def _of_structure(orbit: Orbit, modes: int) -> Stability:
    """The verdict on a motion of a body that is held: by its multipliers alone."""
    sides = [floquet_multipliers(orbit, modes, side=side) for side in orbit.system.load.sides]
    multipliers = max(sides, key=lambda found: found.largest)
    first, margin = complex(multipliers.values[0]), 1.0 - multipliers.largest
    modulus, mode = multipliers.largest, multipliers.dominant_mode
    if orbit.fold:
        kind, reason = Reason.FOLD, "fold: two motions meet here, the multiplier is 1"
    elif margin > NEUTRAL:
        kind = Reason.STABLE
        reason = f"stable: mode {mode} dies out slowest, by a factor of {modulus:.4f} per impact"
    elif margin >= -NEUTRAL:
        kind, reason = Reason.NEUTRAL, f"neutral: mode {mode} neither grows nor dies out (largest modulus 1)"
    elif abs(first.imag) > TURNING * modulus:
        kind, reason = Reason.SPIRAL, f"unstable, a spiral: mode {mode} grows by a factor of {modulus:.4f} per impact"
    elif first.real > 0.0:
        kind, reason = Reason.FOLD, f"unstable, beyond the fold: multiplier {first.real:.3f}"
    else:
        kind, reason = Reason.FLIP, f"flip (period doubling): multiplier {first.real:.3f}"
    return Stability(kind is Reason.STABLE, kind, reason, margin, None, multipliers)


def _kind(orbit: Orbit, multipliers: Multipliers, reduced: Reduced, stable: bool) -> Reason:
    first = complex(multipliers.values[0])
    if orbit.fold:
        return Reason.FOLD
    if stable:
        return Reason.STABLE
    if abs(1.0 - multipliers.largest) <= NEUTRAL:
        return Reason.NEUTRAL
    if multipliers.dominant_mode != 0 and reduced.stable:  # what B77's criterion cannot see
        return Reason.ELASTIC
    if abs(first.imag) > TURNING * multipliers.largest:
        return Reason.SPIRAL
    return Reason.FOLD if first.real > 0.0 else Reason.FLIP


def _in_words(kind: Reason, orbit: Orbit, multipliers: Multipliers, reduced: Reduced) -> str:
    first = complex(multipliers.values[0])
    modulus, mode = multipliers.largest, multipliers.dominant_mode
    what = "the rigid motion" if mode == 0 else f"elastic mode {mode}"
    if orbit.continuum is not None:
        start, stop = orbit.continuum
        grows = f", and besides {what} grows by a factor of {modulus:.4f} per impact"
        also = "" if modulus <= 1.0 + NEUTRAL else grows
        return (
            f"one of a continuum: every impact phase from {start:.6g} to {stop:.6g} rad is steady (multiplier 1){also}"
        )
    if orbit.fold and reduced.other_side is not None:
        before, after = (floquet_multipliers(orbit, multipliers.modes, side=side).largest for side in ("left", "right"))
        return (
            "two motions meet here at a jump of the load, and neither need have the multiplier 1: the largest modulus "
            f"is {before:.4g} just before the jump and {after:.4g} just after it"
        )
    if orbit.fold:
        return "fold: two motions meet here, the multiplier is 1"
    if kind is Reason.STABLE:
        return f"stable: {what} dies out slowest, by a factor of {modulus:.4f} per impact"
    if kind is Reason.NEUTRAL:
        return f"neutral: {what} neither grows nor dies out (largest modulus 1)"
    if kind is Reason.ELASTIC:  # what B77's criterion cannot see
        note = orbit.system.contact.elastic_growth
        flips = abs(first.imag) <= TURNING * modulus and first.real < 0.0
        how = "turns over and grows" if flips else "grows"
        return f"elastic mode {mode} {how} by a factor of {modulus:.6f} per impact{'; ' if note else ''}{note}"
    if kind is Reason.SPIRAL:
        turn = abs(float(np.angle(first)))
        grows = f"the rigid motion grows by a factor of {modulus:.4f} per impact, turning {turn:.3f} rad"
        return f"unstable, a spiral: {grows}"
    if kind is Reason.FOLD:
        return f"unstable, beyond the fold: multiplier {first.real:.3f}"
    return f"flip (period doubling): multiplier {first.real:.3f}"
