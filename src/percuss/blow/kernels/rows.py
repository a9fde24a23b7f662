"""Rows of pieces: what leaves an end of a section is written, what arrives at the other end is read."""

from __future__ import annotations

from percuss.blow.kernels.chebyshev import chopped, restricted
from percuss.blow.kernels.joining import joined
from percuss.blow.kernels.layout import CHOPPED, JOINED, MOST_DEGREE, TRACED
from percuss.compiled import inner


@inner
def has_room(waves, row):
    """Whether a row has room for what one step of a node can write."""
    return waves.pieces[row] + 2 < waves.start.shape[1] and waves.used[0] + 8 * (MOST_DEGREE + 2) < waves.pool.size


@inner
def arriving_until(problem, waves, row, time):
    """Until when the piece that arrives at a time lasts, as far as is known; the row's cursor is set to it.

    Breaks within `near` of the time are at that time.
    """
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
    out[0] = waves.first[row, k]
    if n == 0:
        return 0
    rest = waves.rest[row, k]
    for j in range(n):
        out[j + 1] = waves.pool[rest + j]
    transit = problem.transit[row >> 1]
    begins = waves.start[row, k] + transit
    ends = (waves.start[row, k + 1] if k + 1 < waves.pieces[row] else waves.known[row]) + transit
    if abs(start - begins) <= problem.near and abs(end - ends) <= problem.near:
        return n
    span = 2.0 / (ends - begins)
    restricted(out, n, span * (start - begins) - 1.0, span * (end - begins) - 1.0, out, work)
    return chopped(out, n, CHOPPED)


@inner
def write(waves, row, start, end, c, n, work):
    """What leaves from start to end: a piece more, or a longer one. `work` has six rows."""
    n = chopped(c, n, CHOPPED)
    k = waves.pieces[row]
    waves.known[row] = end
    if k > 0:
        bent = waves.degree[row, k - 1] > 0
        if n == 0 and not bent and abs(waves.first[row, k - 1] - c[0]) <= JOINED:
            return
        # of what is traced besides the waves, the breaks are where something happens
        is_wave = row < waves.start.shape[0] - TRACED
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
    degree, error = joined(p, m, before, c, n, after, waves.spent[row], out, work)
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
