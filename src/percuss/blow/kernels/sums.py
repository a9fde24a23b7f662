"""Integrals and values of rows of pieces."""

from __future__ import annotations

from percuss.blow.kernels.chebyshev import antiderivative, integral, product_integral, restricted, right, value
from percuss.compiled import entry, inner


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


@entry
def value_before(waves, row, time, near, work):
    """The value just before a time; a break that is near is at that time."""
    k = piece_at(waves, row, time - 4 * near)
    start, stop = waves.start[row, k], piece_end(waves, row, k)
    n = part(waves, row, k, start, stop, work[6], work)
    return value(work[6], n, min(1.0, 2.0 * (time - start) / (stop - start) - 1.0))
