"""A cycle through given times, compiled: its closure, Newton's method for its times, a step along a curve of cycles.

Theory and names are those of `percuss.mechanics.cycle`. What is carried through the flights and events of a cycle are
columns, of displacement and velocity of every coordinate and of the pressure: unit disturbances, of which the map of
the cycle consists; the motion that the forces make of the state 0; what the times of the events change.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from percuss.compiled import entry, inner, twin
from percuss.mechanics import flow

response = twin(flow.response)

OMEGA, DAMPING, DRIVEN = range(3)
HELD, DRAW, SUPPLIED, SOFT, QUICKENING = range(5)
KIND, SOURCE, WAITS, DUE, GUARD, BLOW, DELAYED = range(7)
STRIKES = 1


class ClosureRoom(NamedTuple):
    """The numbers of a cycle of E events, P of them guarded, n coordinates, K kinds of flight, and room to work in.

    All before `order` are parts of `numbers`. `modal`: ω, damping and what the driven place moves by, (K, 3, n).
    `forces`: of a flow, and 1/c in place of the compliance, (K, 5). `rows`: of the guards, and last of the wall, for
    the state after the blow, (E + 1, n, 2). `levels`, `later`: (E,). `law`: α, β. `turned`: from the coordinates of a
    flight to those of the next, (E, n, n), and (0, n, n) without a supply, whose coordinates are the same throughout.
    `order`: of each event the kind of its flight, its source, how many cycles before that is, the first of its
    numbers among the orders that wait at the blow, one for each of these cycles, its number among the guarded, −1 for
    none, whether it is a blow, 2 for one that lays the bar down, and its number among the Q whose delays may depend on
    the pressure, (E, 7).

    `times`, `spans`: of the guarded events, of the flights. `responses`: of the coordinates in them, (E, 4, n).
    `columns`: (n, 2, C), the last one of a motion; `seen`: as they were before each event. `states`: before each event,
    and last the start, (E + 1, n, 2). `charges`, `pressures`, `loads`: of the columns, before each event, of the
    states. `rates`: on both sides of an event, (2, n, 2). `matrix`: to solve with a supply, `solving`: for the times.
    `delays`: (E,), with `by_delays`, the derivatives of the error, (P, Q), and `delaying`, to solve for them. `felt`:
    what disturbances make of the pressure at time 0 and where guards are met, (P + 1, C).
    """

    numbers: Any
    modal: Any
    forces: Any
    rows: Any
    levels: Any
    later: Any
    law: Any
    turned: Any
    order: Any
    times: Any
    spans: Any
    responses: Any
    columns: Any
    charges: Any
    seen: Any
    pressures: Any
    states: Any
    loads: Any
    rates: Any
    shifts: Any
    matrix: Any
    right: Any
    error: Any
    slope: Any
    solving: Any
    delays: Any
    by_delays: Any
    delaying: Any
    felt: Any


def room_for(numbers: Any, order: Any, kinds: int, size: int, supplied: bool) -> ClosureRoom:
    """The room of a cycle, and its numbers in it."""
    E, n, now, at, parts = len(order), size, np.array(numbers), 0, []
    turned = (E if supplied else 0, n, n)
    for shape in ((kinds, 3, n), (kinds, 5), (E + 1, n, 2), (E,), (E,), (2,), turned):
        length = math.prod(shape)
        parts.append(now[at : at + length].reshape(shape))
        at += length
    P, W, Q = int((order[:, GUARD] >= 0).sum()), int(order[:, WAITS].sum()), int((order[:, DELAYED] >= 0).sum())
    whole = 2 * n + supplied
    C = max((whole if supplied else 2) + 1 + P + Q, whole + W) + 1
    square = whole if supplied else 0
    empty = np.empty
    return ClosureRoom._make([
        now, *parts, order, empty(P), empty(E), empty((E, 4, n)), empty((n, 2, C)), empty(C), empty((E, n, 2, C)),
        empty((E, C)), empty((E + 1, n, 2)), empty(E + 1), empty((2, n, 2)), empty((P + 1, C)),
        empty((square, square + 1)), empty(whole), empty(P), empty((P, P)), empty((P + 2, P + 3)),
        empty(E), empty((P, Q)), empty((Q, Q + P + 2)), empty((P + 1, C)),
    ])  # fmt: skip


# ---- Columns through flights and events


@inner
def timed(room, x):
    """How long the flights are, and what the coordinates do in them; `x` begins with the unknown times."""
    order, modal, last, period = room.order, room.modal, 0.0, x[room.error.shape[0] - 1]
    for i in range(order.shape[0]):
        time, k = room.delays[i] - order[i, WAITS] * period, order[i, KIND]
        if order[i, SOURCE] >= 0:
            time += x[order[i, SOURCE]]
        room.spans[i], last = time - last, time
        for m in range(modal.shape[2]):
            square = modal[k, OMEGA, m] * modal[k, OMEGA, m]
            ds, s, q, w = response(room.spans[i], square, modal[k, DAMPING, m])
            room.responses[i, 0, m], room.responses[i, 1, m] = ds, s
            room.responses[i, 2, m], room.responses[i, 3, m] = q, w


@inner
def driven(room, k, part, c):
    """What a column moves the driven place by, or its velocity."""
    total = 0.0
    for m in range(room.modal.shape[2]):
        total += room.modal[k, DRIVEN, m] * room.columns[m, part, c]
    return total


@inner
def flown(room, i, first, stop, forced):
    """Columns through a flight; of these the number `forced` is a motion, under all forces."""
    k, columns, responses = room.order[i, KIND], room.columns, room.responses
    draw, supplied, soft = room.forces[k, DRAW], room.forces[k, SUPPLIED], room.forces[k, SOFT]
    for c in range(first, stop):
        force, ramp = 0.0, 0.0
        if draw * soft != 0.0:
            place = driven(room, k, 0, c)
            force = draw * room.charges[c] + draw * draw * soft * place
            room.charges[c] += draw * soft * place
        if c == forced:
            force, ramp = force + room.forces[k, HELD], draw * supplied * soft
        for m in range(columns.shape[0]):
            omega, pushed = room.modal[k, OMEGA, m], room.modal[k, DRIVEN, m]
            s, u, v = responses[i, 1, m], columns[m, 0, c], columns[m, 1, c]
            pull = pushed * force - omega * omega * u
            columns[m, 0, c] = u + s * v + responses[i, 2, m] * pull + responses[i, 3, m] * ramp * pushed
            columns[m, 1, c] = responses[i, 0, m] * v + s * pull + responses[i, 2, m] * ramp * pushed
        if draw * soft != 0.0:
            room.charges[c] -= draw * soft * driven(room, k, 0, c)
        if c == forced:
            room.charges[c] += supplied * soft * room.spans[i]


@inner
def kept(room, i, first, stop):
    """Columns as they are before an event."""
    for c in range(first, stop):
        room.pressures[i, c] = room.charges[c]
        for m in range(room.columns.shape[0]):
            room.seen[i, m, 0, c], room.seen[i, m, 1, c] = room.columns[m, 0, c], room.columns[m, 1, c]


@inner
def after(room, i):
    """The number of the flight after an event."""
    return i + 1 if i + 1 < room.order.shape[0] else 0


@inner
def turned(room, i, first, stop):
    """Columns through an event: the coordinates of another state of the valve, and the law of a blow."""
    columns, order, n = room.columns, room.order, room.columns.shape[0]
    if room.turned.shape[0] > 0 and order[after(room, i), KIND] != order[i, KIND]:
        for c in range(first, stop):
            for part in range(2):
                for m in range(n):
                    room.right[m] = 0.0
                    for other in range(n):
                        room.right[m] += room.turned[i, m, other] * columns[other, part, c]
                for m in range(n):
                    columns[m, part, c] = room.right[m]
    if order[i, BLOW] != 0:
        left = 1.0 if order[i, BLOW] == STRIKES else 0.0
        for c in range(first, stop):
            for m in range(n):
                columns[m, 0, c] *= left * room.law[0]
                columns[m, 1, c] *= left * room.law[1]


@inner
def rates_of(room, k, side):
    """Of the motion in the last column: those of its coordinates into `rates`, and of its pressure."""
    columns, c = room.columns, room.columns.shape[2] - 1
    draw, supplied, soft = room.forces[k, DRAW], room.forces[k, SUPPLIED], room.forces[k, SOFT]
    force, rise = room.forces[k, HELD], supplied * soft
    if draw * soft != 0.0:
        force += draw * room.charges[c] + draw * draw * soft * driven(room, k, 0, c)
        rise -= draw * soft * driven(room, k, 1, c)
    for m in range(columns.shape[0]):
        omega, v = room.modal[k, OMEGA, m], columns[m, 1, c]
        pull = force * room.modal[k, DRIVEN, m] - omega * omega * columns[m, 0, c]
        room.rates[side, m, 0], room.rates[side, m, 1] = v, pull - room.modal[k, DAMPING, m] * v
    return rise


@inner
def rates_at(room, i):
    """On both sides of an event, of the motion whose states are known; those of the pressure."""
    last = room.columns.shape[2] - 1
    for m in range(room.columns.shape[0]):
        room.columns[m, 0, last], room.columns[m, 1, last] = room.states[i, m, 0], room.states[i, m, 1]
    room.charges[last] = room.loads[i]
    before = rates_of(room, room.order[i, KIND], 0)
    turned(room, i, last, last + 1)
    return before, rates_of(room, room.order[after(room, i), KIND], 1)


@inner
def moved(room, side, rise, c, by):
    """A column a time later, by the rates on one side of an event."""
    for m in range(room.columns.shape[0]):
        room.columns[m, 0, c] += room.rates[side, m, 0] * by
        room.columns[m, 1, c] += room.rates[side, m, 1] * by
    room.charges[c] += rise * by


@inner
def emptied(room, first, stop):
    for c in range(first, stop):
        room.charges[c] = 0.0
        for m in range(room.columns.shape[0]):
            room.columns[m, 0, c] = room.columns[m, 1, c] = 0.0


# ---- Small systems of linear equations, by elimination with row pivots


@inner
def reduced(matrix, size, columns):
    """Eliminate below the diagonal, in place, where the multipliers stay, with the pivots in the last column."""
    # Returns whether there is a pivot in every column.
    pivots = matrix.shape[1] - 1
    for k in range(size):
        best = k
        for i in range(k + 1, size):
            if abs(matrix[i, k]) > abs(matrix[best, k]):
                best = i
        if not abs(matrix[best, k]) > 0.0:
            return False
        if best != k:
            for j in range(columns):
                matrix[k, j], matrix[best, j] = matrix[best, j], matrix[k, j]
        matrix[k, pivots] = best
        for i in range(k + 1, size):
            factor = matrix[i, k] / matrix[k, k]
            matrix[i, k] = factor
            if factor != 0.0:
                for j in range(k + 1, columns):
                    matrix[i, j] -= factor * matrix[k, j]
    return True


@inner
def back(matrix, size, column):
    """The solution for a column beside a matrix that was `reduced` with it, into that column."""
    for i in range(size - 1, -1, -1):
        for j in range(i + 1, size):
            matrix[i, column] -= matrix[i, j] * matrix[j, column]
        matrix[i, column] /= matrix[i, i]


# ---- The motion through given times


@inner
def closing(room, unit):
    """What is solved for a start: the unit columns, which have gone through the whole cycle, from 1."""
    if room.turned.shape[0] == 0:
        return True
    matrix, size, n = room.matrix, unit, room.columns.shape[0]
    for j in range(size):
        for m in range(n):
            matrix[2 * m, j], matrix[2 * m + 1, j] = -room.columns[m, 0, j], -room.columns[m, 1, j]
        matrix[size - 1, j] = -room.charges[j]
        matrix[j, j] += 1.0
    for m in range(n):  # in place of the first line: it begins at the wall
        matrix[0, 2 * m], matrix[0, 2 * m + 1] = room.rows[room.rows.shape[0] - 1, m, 0], 0.0
    matrix[0, size - 1] = 0.0
    return reduced(matrix, size, size)


@inner
def apart(room, c):
    """The start to which a column belongs, in its place, where every coordinate goes through the cycle by itself."""
    columns, wall, last = room.columns, 0.0, room.rows.shape[0] - 1
    for m in range(1, columns.shape[0]):
        a, b = 1.0 - columns[m, 0, 0], -columns[m, 0, 1]
        d, e = -columns[m, 1, 0], 1.0 - columns[m, 1, 1]
        u, v, whole = columns[m, 0, c], columns[m, 1, c], a * e - b * d
        columns[m, 0, c], columns[m, 1, c] = (e * u - b * v) / whole, (a * v - d * u) / whole
        wall += room.rows[last, m, 0] * columns[m, 0, c]
    columns[0, 0, c] = -wall / room.rows[last, 0, 0]
    columns[0, 1, c] = (columns[0, 1, c] + columns[0, 1, 0] * columns[0, 0, c]) / (1.0 - columns[0, 1, 1])


@inner
def together(room, size, c):
    """The same where the pressure couples all: `closing` has reduced the matrix."""
    matrix, right, columns = room.matrix, room.right, room.columns
    for m in range(columns.shape[0]):
        right[2 * m], right[2 * m + 1] = columns[m, 0, c], columns[m, 1, c]
    right[0], right[size - 1] = 0.0, room.charges[c]
    for k in range(size):
        best = int(matrix[k, size])
        right[k], right[best] = right[best], right[k]
    for i in range(size):
        for j in range(i):
            right[i] -= matrix[i, j] * right[j]
    for i in range(size - 1, -1, -1):
        for j in range(i + 1, size):
            right[i] -= matrix[i, j] * right[j]
        right[i] /= matrix[i, i]
    for m in range(columns.shape[0]):
        columns[m, 0, c], columns[m, 1, c] = right[2 * m], right[2 * m + 1]
    room.charges[c] = right[size - 1]


@inner
def started(room, unit, c):
    """The start to which a column at the end of the cycle belongs, in its place."""
    if room.turned.shape[0] > 0:
        together(room, unit, c)
    else:
        apart(room, c)


@inner
def place_at(room, i, unit, m, part, c):
    """What a start, in a column, is before an event, in a number of a coordinate; the unit columns tell."""
    if room.turned.shape[0] == 0:
        return room.seen[i, m, part, 0] * room.columns[m, 0, c] + room.seen[i, m, part, 1] * room.columns[m, 1, c]
    total = room.seen[i, m, part, unit - 1] * room.charges[c]
    for other in range(room.columns.shape[0]):
        total += room.seen[i, m, part, 2 * other] * room.columns[other, 0, c]
        total += room.seen[i, m, part, 2 * other + 1] * room.columns[other, 1, c]
    return total


@inner
def load_at(room, i, unit, c):
    """The same of the pressure."""
    if room.turned.shape[0] == 0:
        return 1.0
    total = room.pressures[i, unit - 1] * room.charges[c]
    for other in range(room.columns.shape[0]):
        total += room.pressures[i, 2 * other] * room.columns[other, 0, c]
        total += room.pressures[i, 2 * other + 1] * room.columns[other, 1, c]
    return total


DELAYINGS = 12
SETTLED, NEARLY_SETTLED = 1e-14, 1e-10  # of the period


@inner
def closed(room, x):
    """The motion with given times that begins at the wall and closes: its states, what is left, and its slope."""
    # Delays that depend on the pressure are those of this motion, by Newton's method. Whether there is one.
    Q = room.by_delays.shape[1] if room.forces[0, QUICKENING] != 0.0 else 0
    for i in range(room.order.shape[0]):
        room.delays[i] = room.later[i]
    if Q == 0:
        return closed_at(room, x, 0)
    before = math.inf
    for _ in range(DELAYINGS):
        if not closed_at(room, x, Q) or not delayed(room, Q):
            return False
        size = 0.0
        for q in range(Q):
            size = max(size, abs(room.delaying[q, room.delaying.shape[1] - 2]))
        size /= x[room.error.shape[0] - 1]
        if size <= SETTLED or (before <= NEARLY_SETTLED and size >= 0.5 * before):
            followed(room, Q)
            return True
        before = size
        for i in range(room.order.shape[0]):
            if room.order[i, DELAYED] >= 0:
                room.delays[i] += room.delaying[room.order[i, DELAYED], room.delaying.shape[1] - 2]
    return False


@inner
def given_at(room, i):
    """The event at which the order was given that event i carries out; −1 for the blow at time 0."""
    for other in range(room.order.shape[0]):
        if room.order[other, GUARD] >= 0 and room.order[other, GUARD] == room.order[i, SOURCE]:
            return other
    return -1


@inner
def delayed(room, Q):
    """Into `delaying`: by the unknown times the delays with the sign turned, and last by how much they change."""
    # Their equations: a delay is what it is at the pressure 1, divided by 1 + χ(π − 1); not the product of these two,
    # by which Newton's method goes astray where the pressure is high. Whether they can be solved.
    E, P, found, quickening = room.order.shape[0], room.error.shape[0], room.delaying, room.forces[0, QUICKENING]
    unit = 2 * room.columns.shape[0] + 1
    for i in range(E):
        q = room.order[i, DELAYED]
        if q < 0:
            continue
        source, late = given_at(room, i), room.delays[i]
        rate = 1.0 + quickening * (room.loads[E if source < 0 else source] - 1.0)
        for p in range(P + Q):
            change = room.charges[unit + 1 + p]
            if source >= 0:
                change = load_at(room, source, unit, unit + 1 + p) + room.pressures[source, unit + 1 + p]
            found[q, Q + p if p < P else p - P] = room.later[i] / rate * quickening * change
        found[q, q] += rate
        found[q, Q + P] = room.later[i] - late * rate
    if not reduced(found, Q, Q + P + 1):
        return False
    for c in range(Q, Q + P + 1):
        back(found, Q, c)
    return True


@inner
def followed(room, Q):
    """The slope at fixed delays becomes that with the delays that follow."""
    P = room.error.shape[0]
    for g in range(P):
        for p in range(P):
            for q in range(Q):
                room.slope[g, p] -= room.by_delays[g, q] * room.delaying[q, Q + p]


@inner
def closed_at(room, x, Q):
    """The motion with given times and delays, of which Q may change."""
    E, n, P = room.order.shape[0], room.columns.shape[0], room.error.shape[0] + Q
    unit = 2 if room.turned.shape[0] == 0 else 2 * n + 1
    timed(room, x)
    emptied(room, 0, unit + 1 + P)
    for m in range(n):
        room.columns[m, 0, 0 if unit == 2 else 2 * m] = 1.0
        room.columns[m, 1, 1 if unit == 2 else 2 * m + 1] = 1.0
    if unit > 2:
        room.charges[unit - 1] = 1.0
    for i in range(E):
        flown(room, i, 0, unit + 1, unit)
        kept(room, i, 0, unit + 1)
        turned(room, i, 0, unit + 1)
    if not closing(room, unit):
        return False
    started(room, unit, unit)
    for m in range(n):
        room.states[E, m, 0], room.states[E, m, 1] = room.columns[m, 0, unit], room.columns[m, 1, unit]
    room.loads[E] = room.charges[unit] if unit > 2 else 1.0
    for i in range(E):
        room.loads[i] = load_at(room, i, unit, unit) + (room.pressures[i, unit] if unit > 2 else 0.0)
        for m in range(n):
            for part in range(2):
                room.states[i, m, part] = place_at(room, i, unit, m, part, unit) + room.seen[i, m, part, unit]
    for i in range(E):
        flown(room, i, unit + 1, unit + 1 + P, -1)
        rise, fall = rates_at(room, i)
        for p in range(P):
            by = 1.0 if room.order[i, DELAYED] == p - P + Q else 0.0
            if p < P - Q:
                by = (1.0 if room.order[i, SOURCE] == p else 0.0) - (room.order[i, WAITS] if p == P - Q - 1 else 0.0)
            room.shifts[0, p] = by
            if by != 0.0:
                moved(room, 0, rise, unit + 1 + p, by)
        kept(room, i, unit + 1, unit + 1 + P)
        turned(room, i, unit + 1, unit + 1 + P)
        for p in range(P if i < E - 1 else 0):
            if room.shifts[0, p] != 0.0:
                moved(room, 1, fall, unit + 1 + p, -room.shifts[0, p])
    for c in range(unit + 1, unit + 1 + P):
        started(room, unit, c)
    for i in range(E):
        g = room.order[i, GUARD]
        if g >= 0:
            room.error[g] = -room.levels[i]
            for p in range(P - Q):
                room.slope[g, p] = 0.0
            for q in range(Q):
                room.by_delays[g, q] = 0.0
            for m in range(n):
                for part in range(2):
                    weight = room.rows[i, m, part]
                    if weight != 0.0:
                        room.error[g] += weight * room.states[i, m, part]
                        for c in range(unit + 1, unit + 1 + P):
                            change = place_at(room, i, unit, m, part, c) + room.seen[i, m, part, c]
                            if c <= unit + P - Q:
                                room.slope[g, c - unit - 1] += weight * change
                            else:
                                room.by_delays[g, c - unit - 1 - P + Q] += weight * change
    return True


@inner
def mapped(room, found):
    """The map of disturbances from blow to blow, of a motion that is `closed`; times of wrapped events last."""
    # On the blow as a section the shift in time is no disturbance.
    E, n, P = room.order.shape[0], room.columns.shape[0], room.error.shape[0]
    size, whole = 2 * n + (1 if room.turned.shape[0] > 0 else 0), found.shape[0]
    emptied(room, 0, whole)
    for c in range(whole):
        room.shifts[0, c] = 0.0
        room.felt[0, c] = 1.0 if c == 2 * n and size > c else 0.0
    for m in range(n):
        room.columns[m, 0, 2 * m] = room.columns[m, 1, 2 * m + 1] = 1.0
    if size > 2 * n:
        room.charges[2 * n] = 1.0
    for i in range(E):
        flown(room, i, 0, whole, -1)
        rise, fall = rates_at(room, i)
        g, due, rate = room.order[i, GUARD], room.order[i, DUE], 0.0
        for m in range(n):
            rate += room.rows[i, m, 0] * room.rates[0, m, 0] + room.rows[i, m, 1] * room.rates[0, m, 1]
        for c in range(whole):
            by = due_later(room, i, c)
            if g >= 0:
                by = 0.0
                for m in range(n):
                    by -= room.rows[i, m, 0] * room.columns[m, 0, c] / rate
                    by -= room.rows[i, m, 1] * room.columns[m, 1, c] / rate
                room.shifts[g + 1, c] = by
            elif due >= 0:
                by = 1.0 if c == size + due + room.order[i, WAITS] - 1 else 0.0
            room.pressures[i, c] = by
            moved(room, 0, rise, c, by)
            if g >= 0:
                room.felt[g + 1, c] = room.charges[c]
        turned(room, i, 0, whole)
        for c in range(whole if i < E - 1 else 0):
            moved(room, 1, fall, c, -room.pressures[i, c])
    for c in range(whole):
        for m in range(n):
            found[2 * m, c], found[2 * m + 1, c] = room.columns[m, 0, c], room.columns[m, 1, c]
        if size > 2 * n:
            found[2 * n, c] = room.charges[c]
        for i in range(E):
            due = room.order[i, DUE]
            for k in range(room.order[i, WAITS]):
                before = due_later(room, i, c) if k == 0 else 1.0 if c == size + due + k - 1 else 0.0
                found[size + due + k, c] = before - room.shifts[P, c]


@inner
def due_later(room, i, c):
    """How much later a disturbance makes an event that another one fixes: as that one, and by its delay."""
    source = room.order[i, SOURCE] + 1
    by, quickening = room.shifts[source, c], room.forces[0, QUICKENING]
    if quickening != 0.0 and room.order[i, DELAYED] >= 0:
        by -= quickening * room.delays[i] * room.delays[i] / room.later[i] * room.felt[source, c]
    return by


# ---- Newton's method: for the times of one cycle, and back to a curve of cycles

HALVINGS = 5
CLOSED = 2e-14  # of the period
NEARLY, NEARLY_SUPPLIED = 1e-11, 1e-7  # … where rounding lets no step be smaller, as where a pressure settles slowly
OUT_OF_ORDER = 0.02  # of the period, on the way to the solution


@inner
def time_of(room, x, share, i):
    """When an event is, a share of a step further."""
    P, source = room.error.shape[0], room.order[i, SOURCE]
    time = room.delays[i] - room.order[i, WAITS] * (x[P - 1] + share * room.solving[P - 1, P])
    if source >= 0:
        time += x[source] + share * room.solving[source, P]
    return time


@inner
def in_order(room, x, share):
    """Whether the events keep their order, nearly, a share of a step further."""
    P, before = room.error.shape[0], time_of(room, x, share, 0)
    period = x[P - 1] + share * room.solving[P - 1, P]
    for i in range(1, room.order.shape[0]):
        time = time_of(room, x, share, i)
        if not time - before > -OUT_OF_ORDER * period:
            return False
        before = time
    return period > 0.0


@entry
def solved(room, x, most, map_found):
    """The motion whose times are `x`, or with so many steps at most those near at which everything closes, into `x`."""
    # With room for it, its map of disturbances. Whether there is such a motion.
    if not (closed(room, x) if most == 0 else root(room, x, most)):
        return False
    if map_found.size > 0:
        mapped(room, map_found)
    return True


@inner
def root(room, x, most):
    """Newton's method, by steps that keep the order of events and after which the next one is shorter."""
    # by the derivatives at hand (Deuflhard, Newton Methods for Nonlinear Problems, 2004, § 3.3)
    P, work, smallest = room.error.shape[0], room.solving, math.inf
    nearly = NEARLY if room.turned.shape[0] == 0 else NEARLY_SUPPLIED
    good = closed(room, x)
    for _ in range(most):
        for i in range(P):
            for j in range(P):
                work[i, j] = room.slope[i, j]
            work[i, P] = -room.error[i]
        if not good or not reduced(work, P, P + 1):
            return False
        back(work, P, P)
        longest, share, kept_order = 0.0, 1.0, False
        for i in range(P):
            if not abs(work[i, P]) < math.inf:
                return False
            longest = max(longest, abs(work[i, P]))
        size = longest / x[P - 1]
        done = size <= CLOSED or (smallest <= nearly and size >= 0.5 * smallest)
        smallest = min(smallest, size)
        for halving in range(1 if done else HALVINGS):
            kept_order = done or in_order(room, x, share)
            if kept_order:
                for i in range(P):
                    x[i] += share * work[i, P]
                good = closed(room, x)
                shorter = size <= nearly or (good and following(room) <= (1.0 - 0.25 * share) * longest)
                if done or shorter or halving == HALVINGS - 1:
                    break
                for i in range(P):
                    x[i] -= share * work[i, P]
            share *= 0.5
        if done:
            return good
        if not kept_order:
            return False
    return False


@inner
def following(room):
    """The greatest part of the step that follows one, by the derivatives of that."""
    P, work, greatest = room.error.shape[0], room.solving, 0.0
    for i in range(P):
        work[i, P + 1] = -room.error[i]
    for k in range(P):
        best = int(work[k, P + 2])
        work[k, P + 1], work[best, P + 1] = work[best, P + 1], work[k, P + 1]
    for i in range(P):
        for j in range(i):
            work[i, P + 1] -= work[i, j] * work[j, P + 1]
    back(work, P, P + 1)
    for i in range(P):
        greatest = max(greatest, abs(work[i, P + 1]))
    return greatest


DIFFERENCE = 1e-5  # of the unit of the parameter
FOUND, LOST, TOO_LONG = range(3)


@entry
def corrected(numbers, rate, base, unit, tick, room, x, normal, along, limits, derivative, tangent):
    """The point of the curve in a plane, from `x` on and into it; the machine's numbers are even in the parameter."""
    # Those are `numbers` where the parameter, which is counted in `unit`, is `base`, and change by `rate`; times are
    # counted in `tick`. `normal` is that of the plane, `along` which way the tangent points; `limits`: most steps,
    # after how long a step one is the last, which step is too long. Into `derivative` (P, P + 1), and `tangent` (P +
    # 1,); how it ended, and the steps.
    P, work, last = room.error.shape[0], room.solving, math.inf
    most, close, longest = limits
    for step in range(1, most + 1):
        ends = last <= close
        if (step == 1 or ends) and not by_parameter(numbers, rate, base, unit, tick, room, x, derivative):
            return LOST, step
        if not placed(numbers, rate, base, x[P] * unit, tick, room, x):
            return LOST, step
        for i in range(P):
            for j in range(P):
                derivative[i, j] = room.slope[i, j] * tick
            for j in range(P + 1):
                work[i, j] = derivative[i, j]
            work[i, P + 1] = -room.error[i]
        for j in range(P + 1):
            work[P, j] = normal[j]
        work[P, P + 1] = 0.0
        if not reduced(work, P + 1, P + 2):
            return LOST, step
        back(work, P + 1, P + 1)
        last = 0.0
        for i in range(P + 1):
            if not abs(work[i, P + 1]) <= longest:
                return TOO_LONG, step
            last = max(last, abs(work[i, P + 1]))
        for i in range(P + 1):
            if normal[i] != 1.0:
                x[i] += work[i, P + 1]
        if ends:
            return tangent_of(room, derivative, along, tangent), step
    return LOST, most


@inner
def placed(numbers, rate, base, here, tick, room, x):
    """The motion at a point of a curve, by the numbers that belong to a value of the parameter."""
    for i in range(numbers.shape[0]):
        room.numbers[i] = numbers[i] + (here - base) * rate[i]
    for i in range(room.error.shape[0]):
        room.times[i] = x[i] * tick
    return closed(room, room.times)


@inner
def by_parameter(numbers, rate, base, unit, tick, room, x, derivative):
    """The derivative by the parameter at given times, by differences."""
    P, h = room.error.shape[0], DIFFERENCE * unit
    for way in range(2):
        if not placed(numbers, rate, base, x[P] * unit + (h if way == 0 else -h), tick, room, x):
            return False
        for i in range(P):
            if way == 0:
                derivative[i, P] = room.error[i]
            else:
                derivative[i, P] = (derivative[i, P] - room.error[i]) / (2.0 * DIFFERENCE)
    return True


@inner
def tangent_of(room, derivative, along, tangent):
    """The unit tangent that goes the same way as `along`."""
    work, size, length = room.solving, tangent.shape[0], 0.0
    for i in range(size):
        for j in range(size):
            work[i, j] = derivative[i, j] if i < size - 1 else along[j]
        work[i, size] = 0.0 if i < size - 1 else 1.0
    if not reduced(work, size, size + 1):
        return LOST
    back(work, size, size)
    for i in range(size):
        length += work[i, size] * work[i, size]
    if not 0.0 < length < math.inf:
        return LOST
    length = math.sqrt(length)
    for i in range(size):
        tangent[i] = work[i, size] / length
    return FOUND
