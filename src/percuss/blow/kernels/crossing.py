"""Where a polynomial rises above 0 for the first time, with proof that it did not before."""

from __future__ import annotations

from percuss.blow.kernels.chebyshev import left, restricted, right, value
from percuss.compiled import inner

NEVER = 2.0
FINEST = 1e-13  # of the interval: below it two crossings are one


@inner
def first_above(c, n, least, work):
    """Where p, below `least` at first, last crossed 0 before it exceeds `least`: in [−1, 1], or NEVER.

    Each part of the interval is either shown to have p ≤ least by the sum of its coefficients, or to be monotonic by
    that of the derivative's, |T_k'| ≤ k², or halved. `work` has three rows.
    """
    if n == 0:
        return -1.0 if c[0] > least else NEVER
    if left(c, n) > least:
        return -1.0
    low, width, r = -1.0, 2.0, work[2]
    while low < 1.0:
        high = min(1.0, low + width)
        restricted(c, n, low, high, r, work)
        total, slopes = 0.0, 0.0
        for k in range(1, n + 1):
            total += abs(r[k])
            slopes += k * k * abs(r[k])
        steep = 2.0 * abs(r[1]) > slopes  # the first one is in both
        rises = steep and r[1] > 0.0
        if rises and right(r, n) > least:
            return low + 0.5 * (high - low) * (1.0 + _zero(r, n))
        if steep or r[0] + total <= least:
            low, width = high, 2.0 * width
            if high < 1.0 and 1.0 - high < FINEST:
                break
        elif high - low < FINEST:
            if right(r, n) > least:
                return low
            low, width = high, 2.0 * width
        else:
            width = 0.5 * (high - low)
    return NEVER


@inner
def _zero(r, n):
    """The zero of a polynomial that rises from −1 to 1, where it is positive; −1 where it begins positive."""
    low, high, below, above = -1.0, 1.0, left(r, n), right(r, n)
    if below >= 0.0:
        return -1.0
    side = 0
    for _ in range(100):
        x = (low * above - high * below) / (above - below)
        if not low < x < high:  # to rounding it is one of the ends
            return min(max(x, low), high)
        y = value(r, n, x)
        if y == 0.0:
            return x
        if y < 0.0:  # Illinois: the end that stays counts half the next time
            low, below = x, y
            above *= 0.5 if side < 0 else 1.0
            side = -1
        else:
            high, above = x, y
            below *= 0.5 if side > 0 else 1.0
            side = 1
        if high - low < 4e-16:
            break
    return high
