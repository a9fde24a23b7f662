"""Polynomials as Chebyshev coefficients on [−1, 1]: arrays whose first n + 1 numbers count, n the degree."""

from __future__ import annotations

import numpy as np

from percuss.blow.kernels.wave_records import WIDTH
from percuss.compiled import inner

HALVES = np.array([0.0 if k % 2 else 1.0 / (1.0 - k * k) for k in range(2 * WIDTH)])  # ∫ T_k over [−1, 1], halved


@inner
def value(c, n, x):
    """p(x) by Clenshaw's recurrence."""
    one, two = 0.0, 0.0
    for k in range(n, 0, -1):
        one, two = c[k] + 2.0 * x * one - two, one
    return c[0] + x * one - two


@inner
def left(c, n):
    """p(−1)."""
    total, sign = 0.0, 1.0
    for k in range(n + 1):
        total += sign * c[k]
        sign = -sign
    return total


@inner
def right(c, n):
    """p(1)."""
    total = 0.0
    for k in range(n, -1, -1):
        total += c[k]
    return total


@inner
def restricted(c, n, low, high, out, work):
    """p on [low, high], stretched to [−1, 1]: Clenshaw's recurrence with polynomials in place of numbers."""
    # `out` may be `c`. `work` has two rows.
    if n == 0:
        out[0] = c[0]
        return
    a, b = 0.5 * (high - low), 0.5 * (high + low)
    one, two = work[0], work[1]
    for j in range(n + 3):
        one[j] = two[j] = 0.0
    one[0] = c[n]
    for k in range(n - 1, 0, -1):
        two[0] = c[k] + 2.0 * b * one[0] + a * one[1] - two[0]
        two[1] = 2.0 * b * one[1] + a * (2.0 * one[0] + one[2]) - two[1]
        for j in range(2, n - k + 1):
            two[j] = 2.0 * b * one[j] + a * (one[j - 1] + one[j + 1]) - two[j]
        one, two = two, one
    out[0] = c[0] + b * one[0] + 0.5 * a * one[1] - two[0]
    out[1] = b * one[1] + a * (one[0] + 0.5 * one[2]) - two[1]
    for j in range(2, n + 1):
        out[j] = b * one[j] + 0.5 * a * (one[j - 1] + one[j + 1]) - two[j]


@inner
def chopped(c, n, least):
    """The degree without the last coefficients that are at most `least`."""
    while n > 0 and abs(c[n]) <= least:
        n -= 1
    return n


@inner
def greatest(c, n):
    """The greatest coefficient, without its sign."""
    most = 0.0
    for k in range(n + 1):
        most = max(most, abs(c[k]))
    return most


@inner
def derivative(c, n, out):
    """p', of degree n − 1."""
    for k in range(n, 0, -1):
        out[k - 1] = 2.0 * k * c[k] + (out[k + 1] if k + 1 < n else 0.0)
    if n > 0:
        out[0] *= 0.5


@inner
def antiderivative(c, n, half, out):
    """The integral from −1 on, times `half`, half the length of the interval; its degree is n + 1."""
    total, sign = 0.0, 1.0
    for k in range(1, n + 2):
        before = 2.0 * c[0] if k == 1 else c[k - 1]
        after = c[k + 1] if k + 1 <= n else 0.0
        out[k] = half * (before - after) / (2.0 * k)
        total += sign * out[k]
        sign = -sign
    out[0] = total


@inner
def combined(a, p, n, b, q, m, out):
    """a p + b q, of degrees n and m; `out` may be either of them. The degree."""
    most = max(n, m)
    for k in range(most + 1):
        one = p[k] if k <= n else 0.0
        other = q[k] if k <= m else 0.0
        out[k] = a * one + b * other
    return most


@inner
def integral(c, n):
    """∫ p over [−1, 1]."""
    total = 0.0
    for k in range(0, n + 1, 2):
        total += 2.0 * c[k] * HALVES[k]
    return total


@inner
def product_integral(c, n, d, m):
    """∫ p q over [−1, 1], from T_i T_j = (T_{i+j} + T_{|i−j|})/2."""
    total = 0.0
    for i in range(n + 1):
        part = 0.0
        for j in range(i % 2, m + 1, 2):
            part += d[j] * (HALVES[i + j] + HALVES[abs(i - j)])
        total += c[i] * part
    return total


# ---- Where a polynomial rises above 0 for the first time, with proof that it did not before

NEVER = 2.0
FINEST = 1e-13  # of the interval: below it two crossings are one


@inner
def first_above(c, n, least, work):
    """Where p, below `least` at first, last crossed 0 before it exceeds `least`: in [−1, 1], or NEVER."""
    # Each part of the interval is either shown to have p ≤ least by the sum of its coefficients, or to be monotonic by
    # that of the derivative's, |T_k'| ≤ k², or halved. `work` has three rows.
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
