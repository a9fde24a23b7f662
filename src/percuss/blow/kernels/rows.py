"""Rows of pieces: what leaves an end of a section is written, what arrives at the other end is read."""

from __future__ import annotations

from percuss.blow.kernels.chebyshev import chopped, restricted
from percuss.blow.kernels.layout import CHOPPED, JOINED, MOST_DEGREE
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
def write(waves, row, start, end, c, n):
    """What leaves from start to end."""
    n = chopped(c, n, CHOPPED)
    k = waves.pieces[row]
    waves.known[row] = end
    if n == 0 and k > 0 and waves.degree[row, k - 1] == 0 and abs(waves.first[row, k - 1] - c[0]) <= JOINED:
        return
    waves.start[row, k], waves.degree[row, k], waves.first[row, k] = start, n, c[0]
    waves.rest[row, k] = waves.used[0]
    for j in range(n):
        waves.pool[waves.used[0] + j] = c[j + 1]
    waves.used[0] += n
    waves.pieces[row] = k + 1
