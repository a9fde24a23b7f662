"""Neighbouring pieces that are one polynomial but for next to nothing, joined.

How wrong that makes a blow: a joined piece is nowhere further than APART from the pieces that it stands for, so a row
of impedance Z is changed by at most APART √(Z t) in the norm (Z ∫ w² dt)^½ of the energy until the time t. Steps, free
and fixed ends and walls keep this norm, masses and the rock take away from it, so that errors are passed on but never
grow: as long as faces and rock meet and part as before, the error of all waves together is at most APART Σ √(Z t), the
sum over the rows.
"""

from __future__ import annotations

import math

import numpy as np

from percuss.blow.kernels.chebyshev import chopped, left, restricted, right, value
from percuss.blow.kernels.layout import APART, MOST_JOINED
from percuss.compiled import inner

MORE = 2  # degrees that a joined piece may have beyond its parts
DROPPED = 2e-16  # coefficients below it end the polynomial; the error that is found has them in it
BENDS = 0.01  # no polynomial of these degrees is nearer to a bend than this share of its slopes' difference × length
_SIZE = MOST_JOINED + 1
_DEGREES = range(1, _SIZE)

PLACES = np.zeros((_SIZE, _SIZE))
"""Where a polynomial of degree n is interpolated, both ends included: cos(π j/n), shape (n, j)."""

COSINES = np.zeros((_SIZE, _SIZE, _SIZE))
"""Its coefficients from the values there, shape (n, k, j); at the ends of both sums a term counts half."""

for _n in _DEGREES:
    _j = np.arange(_n + 1)
    _half = np.where(_j % _n == 0, 0.5, 1.0)
    PLACES[_n, : _n + 1] = [math.cos(j / _n * math.pi) for j in _j]
    COSINES[_n, : _n + 1, : _n + 1] = 2.0 / _n * np.cos(np.outer(_j, _j) * (np.pi / _n)) * np.outer(_half, _half)


@inner
def joined(p, m, before, c, n, after, spent, out, work):
    """One polynomial in place of p and the c that follows it, of lengths `before` and `after`; its degree and error.

    The degree is −1 where none is found that is, with the error `spent` in p before, within APART of both. `work` has
    three rows.
    """
    if _bent(p, m, before, c, n, after):
        return -1, 0.0
    share = before / (before + after)
    degree = chopped(out, _interpolated(p, m, c, n, share, out, work[2]), DROPPED)
    error = _apart(out, degree, 2.0 * share - 1.0, 1.0, c, n, work)
    if spent + error > APART:
        return -1, 0.0
    error = max(error, _apart(out, degree, -1.0, 2.0 * share - 1.0, p, m, work))
    if spent + error > APART:
        return -1, 0.0
    return degree, error


@inner
def _bent(p, m, before, c, n, after):
    """Whether value or slope jump by more than a polynomial can follow: most that cannot be joined are found by it."""
    if abs(left(c, n) - right(p, m)) > APART:
        return True
    slopes, sign = 0.0, 1.0
    for k in range(1, m + 1):
        slopes -= k * k * p[k] / before
    for k in range(1, n + 1):
        slopes += sign * k * k * c[k] / after
        sign = -sign
    return BENDS * abs(slopes) * 2.0 * min(before, after) > APART


@inner
def _interpolated(p, m, c, n, share, out, values):
    """The polynomial of a few degrees more through p and c, p on that share of the interval; its degree."""
    top = min(max(m, n) + MORE, MOST_JOINED)
    for j in range(top + 1):
        x = 0.5 * (1.0 + PLACES[top, j])
        if x <= share:
            values[j] = value(p, m, min(1.0, 2.0 * x / share - 1.0))
        else:
            values[j] = value(c, n, max(-1.0, 2.0 * (x - share) / (1.0 - share) - 1.0))
    for k in range(top + 1):
        total = 0.0
        for j in range(top + 1):
            total += COSINES[top, k, j] * values[j]
        out[k] = total
    return top


@inner
def _apart(whole, n, low, high, c, m, work):
    """What the difference of a polynomial on [low, high] and c does not exceed: |T_k| ≤ 1."""
    part, total = work[2], 0.0
    for k in range(n + 1):
        part[k] = whole[k]
    restricted(part, n, low, high, part, work)
    for k in range(max(n, m) + 1):
        total += abs((part[k] if k <= n else 0.0) - (c[k] if k <= m else 0.0))
    return total
