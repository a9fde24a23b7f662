"""Newton's method from many starts, led away from known roots, compiled; steps along a branch; K(ξ)."""

from __future__ import annotations

import math

from percuss.compiled import entry, inner
from percuss.steady.periodic.kernels.forced_passage import (
    ALPHA,
    BEST,
    BETA,
    CLOSURE,
    DRAG,
    FADE,
    FLIGHT,
    FORCE,
    FREE,
    GAMMA,
    GIVEN,
    OFF,
    REBOUND,
    RETURNING,
    SPEED,
    SQUARE,
    STAY,
    TIME,
    A,
    B,
    C,
    E,
    U,
    V,
    cycle_of,
    passed,
    prepared,
    returning,
)

# ---- K(ξ) for a real ξ, with the change of the rigid velocity after the first impact as an unknown more


@inner
def bordered(room, xi):
    """K(ξ) into the first p + 1 rows and columns of `matrix`, after `passed`."""
    matrix, impacts, rate = room.matrix, room.impacts, room.rows[0]
    p, beta, impulse = impacts.shape[1], room.numbers[BETA], 1.0 - room.numbers[BETA]
    for i in range(p + 1):
        for j in range(p + 1):
            matrix[i, j] = 0.0
        rate[i] = 0.0
    for n in range(room.modal.shape[1]):
        elastic_rows(room, n, xi)
    if room.numbers[FREE] == 0.0:
        for i in range(p):
            matrix[i, i] += beta * impacts[SPEED, i]
        matrix[p, p] = -1.0
        return
    rate[p] = 1.0
    for i in range(p):
        for j in range(p + 1):
            matrix[i, j] += impacts[FADE, i] * rate[j]
            rate[j] *= beta * impacts[STAY, i]
        to, turned = (i + 1, 1.0) if i + 1 < p else (0, xi)
        rate[to] -= turned * impulse * impacts[FORCE, to]
        matrix[i, i] -= beta * impacts[SPEED, i]
        matrix[i, to] += turned * impacts[SPEED, to]
    for j in range(p + 1):
        matrix[p, j] = rate[j]
    matrix[p, p] -= xi


@inner
def elastic_rows(room, n, xi):
    """What a mode adds: how each flight (row) moves the striking end per shift of an impact (column)."""
    matrix, carried, impacts = room.matrix, room.carried, room.impacts
    alpha, beta, p = room.numbers[ALPHA], room.numbers[BETA], impacts.shape[1]
    gamma, square = room.modal[GAMMA, n], room.modal[SQUARE, n]
    is_free = room.numbers[FREE] != 0.0
    ma, mb, mc, me = cycle_of(carried, n, alpha, beta)
    for j in range(p):
        kick = (alpha - beta) * carried[V, n, j]
        kick_rate = (alpha - beta) * square * carried[U, n, j] - (1.0 - beta) * impacts[FORCE, j]
        if j == 0:  # met at the end of the cycle, ξ times
            u, v = xi * kick, xi * kick_rate
        else:
            u, v = kick, kick_rate
            for i in range(j, p):
                a, b, c, e = carried[A, n, i], carried[B, n, i], carried[C, n, i], carried[E, n, i]
                u, v = alpha * (a * u + b * v), beta * (c * u + e * v)
        u, v, _ = returning(room, n, ma, mb, mc, me, xi, u, v)
        for i in range(p):
            a, b, c, e = carried[A, n, i], carried[B, n, i], carried[C, n, i], carried[E, n, i]
            start = u
            u, v = a * u + b * v, c * u + e * v
            matrix[i, j] += gamma * (u - start if is_free else start)
            u, v = alpha * u, beta * v
            if i + 1 == j:
                u, v = u + kick, v + kick_rate


@inner
def turning(room):
    """By how much the mean velocity just after the first impact grows if the impact is later, its state the same."""
    numbers, impacts = room.numbers, room.impacts
    return numbers[FREE] * (impacts[FORCE, 0] - numbers[DRAG] * impacts[REBOUND, 0])


# ---- Small systems of linear equations, by elimination with row pivots, and determinants

TINY = 2.0**-52


@inner
def reduced(matrix, size, columns):
    """Eliminate below the diagonal, in place; the sign of the permutation."""
    # A pivot that vanishes becomes one less than rounding: the solution is then far away, and shows that there is none.
    sign, greatest = 1.0, 0.0
    for i in range(size):
        for j in range(size):
            greatest = max(greatest, abs(matrix[i, j]))
    for k in range(size):
        best = k
        for i in range(k + 1, size):
            if abs(matrix[i, k]) > abs(matrix[best, k]):
                best = i
        if best != k:
            sign = -sign
            for j in range(columns):
                matrix[k, j], matrix[best, j] = matrix[best, j], matrix[k, j]
        if matrix[k, k] == 0.0:
            matrix[k, k] = TINY * TINY * greatest
        for i in range(k + 1, size):
            factor = matrix[i, k] / matrix[k, k]
            if factor != 0.0:
                for j in range(k + 1, columns):
                    matrix[i, j] -= factor * matrix[k, j]
    return sign


@inner
def solved(matrix, size, column):
    """The solution for one of the columns beside a matrix that is `reduced`, into that column."""
    for i in range(size - 1, -1, -1):
        for j in range(i + 1, size):
            matrix[i, column] -= matrix[i, j] * matrix[j, column]
        matrix[i, column] /= matrix[i, i]


@inner
def determinant(matrix, size):
    """The determinant, each row taken by its length; the matrix is lost."""
    for i in range(size):
        length = 0.0
        for j in range(size):
            length += matrix[i, j] * matrix[i, j]
        length = math.sqrt(length)
        if length == 0.0:
            return 0.0
        for j in range(size):
            matrix[i, j] /= length
    found = reduced(matrix, size, size)
    for i in range(size):
        found *= matrix[i, i]
    return found


# ---- Newton's method from many starts, led away from roots that are known: `percuss.steady.periodic.search`, compiled

LOST, ROOT, GONE = range(3)  # as `Outcome` of percuss.steady.periodic.search, and the numbers below
LONGEST, KEPT, CLOSE, STEADY = 0.5, 0.1, 1e-9, 1e-3
COALESCED = 1e-9
FRESH, GIVEN_UP = -1, -2


@entry
def search(system, room, period, turn, neutral, known, most, times, rebound, settling, outcome):
    """Follow starts, the rows of `times`, so many steps at most, in place, away from `known` roots (any, p)."""
    # `rebound` has the mean velocity after the first impact, an unknown of its own where it is `neutral`; `settling`
    # how many steps were short by now, `FRESH` for a start that has not begun, `GIVEN_UP` for one that is lost;
    # `outcome` how it ended. The load repeats after `turn`.
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


# ---- Whether a number is a multiplier of a motion: det K(ξ) for a real ξ


@entry
def singularity(room, xi):
    """det K(ξ) of the motion whose `passage` is in a room, rows taken by their lengths; leaves K(ξ) in `matrix`."""
    bordered(room, xi)
    size = room.impacts.shape[1] + 1
    for i in range(size):
        for j in range(size):
            room.solving[i, j] = room.matrix[i, j]
    return determinant(room.solving, size)


# ---- The way back to the curve of an orbit over a parameter, and its tangent: Newton's method in a plane, compiled

DIFFERENCE = 1e-6  # of the parameter, relative where that is large
COLUMN = 1e-5  # after a step below this the column of the parameter stays
FOUND, LOST_CURVE, TOO_LONG = range(3)


@entry
def derivatives(system, rate, here, unit, room, period, x, derivative):
    """The equations at a point of the curve and their derivative, into `derivative`, (p + 1, p + 3)."""
    # `rate`: how the numbers of the system change with the parameter, whose value is `here`, in units `unit`. The last
    # column is the equations themselves.
    by_parameter(system, rate, here, unit, room, period, x, derivative)
    prepared(system, room)
    passed(room, x, period, GIVEN, x[room.impacts.shape[1]])
    by_times(room, derivative)


@entry
def corrected(system, rate, base, unit, room, period, x, normal, along, limits, derivative, tangent):
    """The point of the curve in a plane, from `x` on and into it; the system's numbers are even in the parameter."""
    # Those are `system` where the parameter, which is counted in `unit`, is `base`, and change by `rate`. `normal` is
    # that of the plane, `along` which way the tangent points; `limits`: most steps, after how long a step there is
    # none, which step is too long. Into `derivative` (p + 1, p + 3) with the equations last, and `tangent` (p + 2,);
    # how it ended, and the steps.
    p, last = room.impacts.shape[1], math.inf
    most, close, longest = limits
    for step in range(1, most + 1):
        here = x[p + 1] * unit
        for i in range(system.shape[0]):
            room.now[i] = system[i] + (here - base) * rate[i]
        if last > COLUMN:
            by_parameter(room.now, rate, here, unit, room, period, x, derivative)
        prepared(room.now, room)
        passed(room, x, period, GIVEN, x[p])
        by_times(room, derivative)
        last = newton_step(room, derivative, normal, x)
        if not last <= longest:
            return TOO_LONG, step
        if last <= close:
            return tangent_of(room, derivative, along, tangent), step
    return LOST_CURVE, most


@inner
def by_times(room, derivative):
    """The derivative by the times and by the velocity after the first impact, with the equations as the last column."""
    p = room.impacts.shape[1]
    bordered(room, 1.0)
    turned = turning(room)
    for i in range(p + 1):
        for j in range(p + 1):
            derivative[i, j] = room.matrix[i, j]
        derivative[i, 0] -= turned * room.matrix[i, p]
        derivative[i, p + 2] = room.impacts[OFF, i] if i < p else room.whole[CLOSURE]


@inner
def by_parameter(system, rate, here, unit, room, period, x, derivative):
    """The derivative by the parameter, by differences, for numbers of the system that are even in it."""
    p, step = room.impacts.shape[1], DIFFERENCE * max(1.0, abs(here))
    moved = room.moved
    for way in range(2):
        h = step if way == 0 else -step
        for i in range(system.shape[0]):
            moved[i] = system[i] + h * rate[i]
        prepared(moved, room)
        passed(room, x, period, GIVEN, x[p])
        for i in range(p + 1):
            off = room.impacts[OFF, i] if i < p else room.whole[CLOSURE]
            if way == 0:
                derivative[i, p + 1] = off
            else:
                derivative[i, p + 1] = (derivative[i, p + 1] - off) / (2.0 * step) * unit


@inner
def newton_step(room, derivative, normal, x):
    """A step of Newton's method in the plane, taken; its greatest component."""
    work, size = room.solving, x.shape[0]
    for i in range(size - 1):
        for j in range(size):
            work[i, j] = derivative[i, j]
        work[i, size] = -derivative[i, size]
    for j in range(size):
        work[size - 1, j] = normal[j]
    work[size - 1, size] = 0.0
    reduced(work, size, size + 1)
    solved(work, size, size)
    greatest = 0.0
    for i in range(size):
        if not abs(work[i, size]) < math.inf:
            return math.inf
        greatest = max(greatest, abs(work[i, size]))
        x[i] += work[i, size]
    return greatest


@inner
def tangent_of(room, derivative, along, tangent):
    """The unit tangent that goes the same way as `along`."""
    work, size, length = room.solving, tangent.shape[0], 0.0
    for i in range(size):
        for j in range(size):
            work[i, j] = derivative[i, j] if i < size - 1 else along[j]
        work[i, size] = 0.0 if i < size - 1 else 1.0
    reduced(work, size, size + 1)
    solved(work, size, size)
    for i in range(size):
        length += work[i, size] * work[i, size]
    if not 0.0 < length < math.inf:
        return LOST_CURVE
    length = math.sqrt(length)
    for i in range(size):
        tangent[i] = work[i, size] / length
    return FOUND
