"""Rows of pieces: what leaves an end of a section is written, what arrives at the other end is read."""

from __future__ import annotations

import math

import numpy as np

from percuss.blow.kernels.chebyshev import (
    antiderivative,
    chopped,
    integral,
    left,
    product_integral,
    restricted,
    right,
    value,
)
from percuss.blow.kernels.wave_records import CHOPPED, MOST_DEGREE, MOST_JOINED
from percuss.compiled import entry, inner

# ---- Neighbouring pieces that are one polynomial but for next to nothing, joined
#
# How wrong that makes a blow: a joined piece is nowhere further than `apart` from the pieces that it stands for, so
# that a row of impedance Z is changed by at most `apart` √(Z t) in the norm (Z ∫ w² dt)^½ of the energy until the time
# t. Steps, free and fixed ends and walls keep this norm, masses and the rock take away from it, so that errors are
# passed on but never grow: as long as faces and rock meet and part as before, the error of all waves together is at
# most `apart` Σ √(Z t), the sum over the rows.

MORE = 2  # degrees that a joined piece may have beyond its parts
DROPPED = 2e-16  # coefficients below it end the polynomial; the error that is found has them in it
BEYOND = 1.001  # of half a piece from its middle
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
def joined(p, m, before, c, n, after, spent, apart, out, work):
    """One polynomial in place of p and the c that follows it, of lengths `before` and `after`; its degree and error."""
    # The degree is −1 where none is found that is, with the error `spent` in p before, within `apart` of both. `work`
    # has three rows.
    if _bent(p, m, before, c, n, after, apart):
        return -1, 0.0
    share = before / (before + after)
    degree = chopped(out, _interpolated(p, m, c, n, share, out, work[2]), DROPPED)
    error = _apart(out, degree, 2.0 * share - 1.0, 1.0, c, n, work)
    if spent + error > apart:
        return -1, 0.0
    error = max(error, _apart(out, degree, -1.0, 2.0 * share - 1.0, p, m, work))
    if spent + error > apart:
        return -1, 0.0
    return degree, error


@inner
def _bent(p, m, before, c, n, after, apart):
    """Whether value or slope jump by more than a polynomial can follow: most that cannot be joined are found by it."""
    if abs(left(c, n) - right(p, m)) > apart:
        return True
    slopes, sign = 0.0, 1.0
    for k in range(1, m + 1):
        slopes -= k * k * p[k] / before
    for k in range(1, n + 1):
        slopes += sign * k * k * c[k] / after
        sign = -sign
    return BENDS * abs(slopes) * 2.0 * min(before, after) > apart


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


# ---- Rows of pieces: what leaves an end of a section is written, what arrives at the other end is read


@inner
def has_room(waves, row):
    """Whether a row has room for what one step of a node can write."""
    return waves.pieces[row] + 2 < waves.start.shape[1] and waves.used[0] + 8 * (MOST_DEGREE + 2) < waves.pool.size


@inner
def arriving_until(problem, waves, row, time):
    """Until when the piece that arrives at a time lasts, as far as is known; the row's cursor is set to it."""
    # Breaks within `near` of the time are at that time.
    transit, last = problem.transit[row >> 1], waves.pieces[row] - 1
    k = waves.cursor[row]
    while k < last and waves.start[row, k + 1] + transit <= time + problem.near:
        k += 1
    waves.cursor[row] = k
    return (waves.start[row, k + 1] if k < last else waves.known[row]) + transit


@inner
def read(problem, waves, row, start, end, out, work):
    """What arrives from start to end, within one piece; the degree. `work` has two rows."""
    k = waves.cursor[row]
    n = waves.degree[row, k]
    decay = problem.decay[row >> 1]
    out[0] = decay * waves.first[row, k]
    if n == 0:
        return 0
    rest = waves.rest[row, k]
    for j in range(n):
        out[j + 1] = decay * waves.pool[rest + j]
    transit = problem.transit[row >> 1]
    begins = waves.start[row, k] + transit
    ends = (waves.start[row, k + 1] if k + 1 < waves.pieces[row] else waves.known[row]) + transit
    if abs(start - begins) <= problem.near and abs(end - ends) <= problem.near:
        return n
    span = 2.0 / (ends - begins)
    low, high = span * (start - begins) - 1.0, span * (end - begins) - 1.0
    # where `near` is no rounding, a piece that was not cut exactly is read no further than it goes
    restricted(out, n, -1.0 if low < -BEYOND else low, 1.0 if high > BEYOND else high, out, work)
    return chopped(out, n, CHOPPED)


@inner
def write(waves, row, start, end, c, n, work):
    """What leaves from start to end: a piece more, or a longer one. `work` has six rows."""
    n = chopped(c, n, CHOPPED)
    k = waves.pieces[row]
    waves.known[row] = end
    if k > 0:
        bent = waves.degree[row, k - 1] > 0
        if n == 0 and not bent and abs(waves.first[row, k - 1] - c[0]) <= waves.joined:
            return
        # of what is traced besides the waves, the breaks are where something happens
        is_wave = row < waves.waves
        if n > 0 and bent and is_wave and _lengthened(waves, row, k - 1, start, end, c, n, work):
            return
    waves.start[row, k], waves.spent[row], waves.pieces[row] = start, 0.0, k + 1
    _keep(waves, row, k, waves.used[0], c, n)
    waves.used[0] += n


@inner
def _lengthened(waves, row, k, start, end, c, n, work):
    """Join what leaves to the last piece of the row, where the two are one polynomial; whether they are."""
    p, out, m = work[3], work[4], waves.degree[row, k]
    p[0] = waves.first[row, k]
    for j in range(m):
        p[j + 1] = waves.pool[waves.rest[row, k] + j]
    before, after = float(start - waves.start[row, k]), float(end - start)
    degree, error = joined(p, m, before, c, n, after, waves.spent[row], waves.apart, out, work)
    if degree < 0:
        return False
    waves.spent[row] += error
    if degree <= m:
        _keep(waves, row, k, waves.rest[row, k], out, degree)
    else:
        _keep(waves, row, k, waves.used[0], out, degree)
        waves.used[0] += degree
    return True


@inner
def _keep(waves, row, k, rest, c, n):
    """Put the polynomial of a piece into the pool, from `rest` on."""
    waves.degree[row, k], waves.first[row, k], waves.rest[row, k] = n, c[0], rest
    for j in range(n):
        waves.pool[rest + j] = c[j + 1]


# ---- Integrals and values of rows of pieces


@inner
def piece_at(waves, row, time):
    """The last piece that begins at a time or before, the first one where none does."""
    low, high = 0, waves.pieces[row]
    while high - low > 1:
        middle = (low + high) >> 1
        if waves.start[row, middle] <= time:
            low = middle
        else:
            high = middle
    return low


@inner
def piece_end(waves, row, k):
    """Where a piece ends."""
    return waves.start[row, k + 1] if k + 1 < waves.pieces[row] else waves.known[row]


@inner
def part(waves, row, k, begin, end, out, work):
    """A piece from begin to end, which it covers; its degree."""
    n = waves.degree[row, k]
    out[0] = waves.first[row, k]
    for j in range(n):
        out[j + 1] = waves.pool[waves.rest[row, k] + j]
    start, stop = waves.start[row, k], piece_end(waves, row, k)
    if n > 0 and (begin != start or end != stop):
        span = 2.0 / (stop - start)
        restricted(out, n, span * (begin - start) - 1.0, span * (end - start) - 1.0, out, work)
    return n


@entry
def integrals(waves, row, begin, end, tick, work):
    """∫ p dt, ∫ p² dt and ∫ p (t − begin) dt from begin to end."""
    plain, square, moment = 0.0, 0.0, 0.0
    c, h = work[6], work[7]
    k = piece_at(waves, row, begin)
    while k < waves.pieces[row] and waves.start[row, k] < end:
        low, high = max(begin, waves.start[row, k]), min(end, piece_end(waves, row, k))
        if high > low and waves.degree[row, k] == 0:
            span, level = tick * (high - low), waves.first[row, k]
            plain += span * level
            square += span * level * level
            moment += span * level * (0.5 * span + tick * (low - begin))
        elif high > low:
            n = part(waves, row, k, low, high, c, work)
            half = 0.5 * tick * (high - low)
            here = half * integral(c, n)
            plain += here
            square += half * product_integral(c, n, c, n)
            # ∫ p (t − low) = (high − low) P(high) − ∫ P
            antiderivative(c, n, half, h)
            moment += 2.0 * half * right(h, n + 1) - half * integral(h, n + 1) + here * tick * (low - begin)
        k += 1
    return plain, square, moment


NODES, WEIGHTS = np.polynomial.legendre.leggauss(32)


@entry
def faded_integrals(waves, row, begin, end, rate, tick, work):
    """∫ p e^{−rate (end − t)} dt and ∫ p² e^{−2 rate (end − t)} dt from begin to end: of what has gone since."""
    plain, square, c = 0.0, 0.0, work[6]
    k = piece_at(waves, row, begin)
    while k < waves.pieces[row] and waves.start[row, k] < end:
        low, high = max(begin, waves.start[row, k]), min(end, piece_end(waves, row, k))
        if high > low:
            span, left_of = tick * (high - low), math.exp(-rate * tick * (end - high))
            if waves.degree[row, k] == 0:
                level = left_of * waves.first[row, k]
                plain -= level * math.expm1(-rate * span) / rate
                square -= 0.5 * level * level * math.expm1(-2.0 * rate * span) / rate
            else:
                n = part(waves, row, k, low, high, c, work)
                for j in range(NODES.size):
                    here = left_of * math.exp(-0.5 * rate * span * (1.0 - NODES[j])) * value(c, n, NODES[j])
                    plain += 0.5 * span * WEIGHTS[j] * here
                    square += 0.5 * span * WEIGHTS[j] * here * here
        k += 1
    return plain, square


@entry
def value_before(waves, row, time, near, work):
    """The value just before a time; a break that is near is at that time."""
    k = piece_at(waves, row, time - 4 * near)
    start, stop = waves.start[row, k], piece_end(waves, row, k)
    n = part(waves, row, k, start, stop, work[6], work)
    return value(work[6], n, min(1.0, 2.0 * (time - start) / (stop - start) - 1.0))
