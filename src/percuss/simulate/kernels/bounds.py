"""Bounds of the free motion of the elastic modes."""

from __future__ import annotations

from percuss.compiled import entry, summed
from percuss.simulate.kernels.codes import POWERS
from percuss.simulate.kernels.creeping import most_of


@summed
def amplitudes(bar, modes, z, now):
    """f and f'' at the anchor, and bounds of |f|, |f'|, |f''|, |f‴| ever after."""
    f, curve = 0.0, 0.0
    if bar.law == POWERS:
        rate, d = 0.0, 2.0 * bar.half
        for j in range(modes.omega.shape[0]):
            zr = z[0, j] * modes.oscillates[j]
            f += zr
            rate += modes.lam[j] * z[1, j]
            curve += modes.square[j] * zr
        curve = 0.25 * d * d * f + d * rate - curve
    else:
        for j in range(modes.omega.shape[0]):
            zr, half = z[0, j] * modes.oscillates[j], modes.half[j]
            f += zr
            curve += (half * half - modes.square[j]) * zr + 2.0 * half * modes.lam[j] * z[1, j]
    sup, sup1, sup2, sup3 = ringing(modes, z)
    now.free_oscillating = f
    for i in range(modes.creeping.shape[0]):
        j = modes.creeping[i]
        q, q1, d = z[0, j], z[1, j], modes.damping[j]
        f += q
        curve -= d * q1 + modes.omega[j] * modes.omega[j] * q
        most, most1, most2, most3 = most_of(d, modes.signed[j], modes.omega[j], q, q1, 0.0, q, q1)
        sup += most
        sup1 += most1
        sup2 += most2
        sup3 += most3
    now.free, now.free_curve = f, curve
    grown = 1.0 + 1e-12  # the sums' own rounding
    now.sup, now.sup1, now.sup2, now.sup3 = sup * grown, sup1 * grown, sup2 * grown, sup3 * grown


@summed
def ringing(modes, z):
    """Σ|z|, Σω|z|, Σω²|z|, Σω³|z| of the oscillating modes: bounds of their free part and its derivatives."""
    sup, sup1, sup2, sup3 = 0.0, 0.0, 0.0, 0.0
    for j in range(modes.omega.shape[0]):
        one, other, w = abs(z[0, j]), abs(z[1, j]), modes.omega[j]
        # ≥ √(zr² + zi²), by 8 % at most
        size = modes.oscillates[j] * (max(one, other) + 0.4142135623730951 * min(one, other))
        sup += size
        size *= w
        sup1 += size
        size *= w
        sup2 += size
        sup3 += size * w
    return sup, sup1, sup2, sup3


@summed
def ringing_left(modes, z, work):
    """The same at the time of the phasors in `work`, which have the damping of each mode in them."""
    sup, sup1, sup2, sup3 = 0.0, 0.0, 0.0, 0.0
    for j in range(modes.omega.shape[0]):
        er, ei, w = 1.0 + work.re[j], work.im[j], modes.omega[j]
        one, other = abs(z[0, j] * er - z[1, j] * ei), abs(z[0, j] * ei + z[1, j] * er)
        size = modes.oscillates[j] * (max(one, other) + 0.4142135623730951 * min(one, other))
        sup += size
        size *= w
        sup1 += size
        size *= w
        sup2 += size
        sup3 += size * w
    return sup, sup1, sup2, sup3


@entry
def bounded(bar, modes, z, now):
    """The bounds of a flight that stand in a saved state, computed again to see whether they are true."""
    amplitudes(bar, modes, z, now)
