"""Newton's method from many starts, led away from roots that are known: `percuss.steady.periodic.newton`, compiled."""

import math

from percuss.compiled import entry, inner
from percuss.steady.periodic.kernels.forced import prepared
from percuss.steady.periodic.kernels.layout import (
    BEST,
    CLOSURE,
    FLIGHT,
    GIVEN,
    OFF,
    REBOUND,
    RETURNING,
    TIME,
)
from percuss.steady.periodic.kernels.linearised import bordered, turning
from percuss.steady.periodic.kernels.passage import passed
from percuss.steady.periodic.kernels.solving import reduced, solved

__all__ = ["search"]

LOST, ROOT, GONE = range(3)  # as `Outcome` of percuss.steady.periodic.newton, and the numbers below
LONGEST, KEPT, CLOSE, STEADY = 0.5, 0.1, 1e-9, 1e-3
COALESCED = 1e-9
FRESH, GIVEN_UP = -1, -2


@entry
def search(system, room, period, turn, neutral, known, most, times, rebound, settling, outcome):
    """Follow starts, the rows of `times`, by so many steps at most, in place.

    Parameters
    ----------
    system, room, period
        As for `passed`; T.
    turn, neutral
        After how long the load repeats, and whether the mean velocity is an unknown of its own.
    known, most
        Roots to keep away from, (0 or more, p); steps.
    times, rebound
        (B, p), and the mean velocity after the first impact (B,).
    settling, outcome
        How many steps were short by now, `FRESH` for a start that has not begun, `GIVEN_UP` for one that is lost;
        how it ended.
    """
    prepared(system, room)
    for row in range(times.shape[0]):
        if outcome[row] != LOST or settling[row] == GIVEN_UP:
            continue
        if settling[row] == FRESH:
            settling[row] = 0
            if neutral:
                passed(room, times[row], period, BEST, 0.0)
                rebound[row] = room.impacts[REBOUND, 0]
        for _ in range(most):
            passed(room, times[row], period, GIVEN if neutral else RETURNING, rebound[row])
            outcome[row], settling[row] = stepped(room, period, turn, known, times[row], rebound, row, settling[row])
            if outcome[row] != LOST or settling[row] == GIVEN_UP:
                break


@inner
def stepped(room, period, turn, known, times, rebound, row, settling):
    """One step; how it ended, and how many steps were close by now, less than 0 for one that is lost."""
    impacts, work, p = room.impacts, room.solving, room.impacts.shape[1]
    bordered(room, 1.0)
    for i in range(p + 1):
        for j in range(p + 1):
            work[i, j] = room.matrix[i, j]
        work[i, p + 1] = -impacts[OFF, i] if i < p else -room.whole[CLOSURE]
    reduced(work, p + 1, p + 2)
    solved(work, p + 1, p + 1)
    size = 0.0
    for i in range(p):
        size = max(size, abs(work[i, p + 1]))
        if not abs(work[i, p + 1]) < math.inf:
            return LOST, GIVEN_UP
    share = 1.0 if settling else length_of(room, known, period, turn, size)
    turned = turning(room)
    rebound[row] = impacts[REBOUND, 0] + share * work[p, p + 1] + turned * share * work[0, p + 1]
    for i in range(p):
        times[i] += share * work[i, p + 1]
    least, shrunk = math.inf, 0.0
    for i in range(p):
        flight = (times[i + 1] if i + 1 < p else times[0] + period) - times[i]
        least, shrunk = min(least, flight), max(shrunk, abs(flight / impacts[FLIGHT, i] - 1.0))
    if (settling and shrunk <= STEADY) or (size <= CLOSE and shrunk <= STEADY):
        settling += 1
    else:
        settling = 0
    if least < COALESCED * period:
        return GONE, settling
    return ROOT if settling > 2 else LOST, settling


@inner
def length_of(room, known, period, turn, size):
    """What part of a step is taken: away from known roots, not too far, and leaving something of each flight."""
    impacts, work, p = room.impacts, room.solving, room.impacts.shape[1]
    share = 1.0
    if known.shape[0]:
        share = away(room, known, period, turn)
        share = share if abs(share) < math.inf else 1.0
    if size * abs(share) > LONGEST:
        share *= LONGEST / (size * abs(share))
    room_left = 1.0
    for i in range(p):
        shrinking = -share * (work[(i + 1) % p, p + 1] - work[i, p + 1])
        if shrinking > 0.0:
            room_left = min(room_left, (1.0 - KEPT) * impacts[FLIGHT, i] / shrinking)
    return share * room_left


@inner
def away(room, known, period, turn):
    """By what a step is multiplied (deflation): 1/(1 − ∇ ln Π(1 + 1/d_k²) · δt)."""
    impacts, work, p = room.impacts, room.solving, room.impacts.shape[1]
    total = 1.0
    for k in range(known.shape[0]):
        least, toward = math.inf, 0.0
        for shift in range(p):
            mean = 0.0
            for i in range(p):
                other = known[k, i + shift] if i + shift < p else known[k, i + shift - p] + period
                mean += impacts[TIME, i] - other
            moved = turn * math.floor(mean / p / turn + 0.5)
            square, along = 0.0, 0.0
            for i in range(p):
                other = known[k, i + shift] if i + shift < p else known[k, i + shift - p] + period
                off = impacts[TIME, i] - other - moved
                square += off * off
                along += off * work[i, p + 1]
            if square < least:
                least, toward = square, along
        total += 2.0 * toward / (least * (least + 1.0))
    return 1.0 / total
