"""Polynomials as Chebyshev coefficients on [−1, 1]: arrays whose first n + 1 numbers count, n the degree."""

from __future__ import annotations

import numpy as np

from percuss.blow.kernels.layout import WIDTH
from percuss.compiled import inner

HALVES = np.array([0.0 if k % 2 else 1.0 / (1.0 - k * k) for k in range(2 * WIDTH)])
"""∫ T_k over [−1, 1], halved."""


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
    """p on [low, high], stretched to [−1, 1]: Clenshaw's recurrence with polynomials in place of numbers.

    `out` may be `c`. `work` has two rows.
    """
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
