"""The way back to the curve of an orbit over a parameter, and its tangent: Newton's method in a plane, compiled."""

import math

from percuss.compiled import entry, inner
from percuss.steady.periodic.kernels.forced import prepared
from percuss.steady.periodic.kernels.layout import CLOSURE, GIVEN, OFF
from percuss.steady.periodic.kernels.linearised import bordered, turning
from percuss.steady.periodic.kernels.passage import passed
from percuss.steady.periodic.kernels.solving import reduced, solved

__all__ = ["corrected", "derivatives"]

DIFFERENCE = 1e-6  # of the parameter, relative where that is large
COLUMN = 1e-5  # after a step below this the column of the parameter stays
FOUND, LOST, TOO_LONG = range(3)


@entry
def derivatives(system, rate, here, unit, room, period, x, derivative):
    """The equations at a point of the curve, and their derivative by the unknowns, into `derivative`, (p + 1, p + 3).

    `rate`: how the numbers of the system change with the parameter, whose value is `here`, in units `unit`. The last
    column is the equations themselves.
    """
    by_parameter(system, rate, here, unit, room, period, x, derivative)
    prepared(system, room)
    passed(room, x, period, GIVEN, x[room.impacts.shape[1]])
    by_times(room, derivative)


@entry
def corrected(system, rate, base, unit, room, period, x, normal, along, limits, column, derivative, tangent):
    """The point of the curve in a plane, from `x` on and into it, by a system whose numbers are even in the parameter.

    Parameters
    ----------
    system, rate, base
        Its numbers where the parameter is `base`, and how they change with it.
    unit, period
        Of the parameter; T.
    normal, along
        Of the plane; which way the tangent points.
    limits
        Most steps, after how long a step there is none, which step is too long.
    column
        Whether the column of the parameter that is in `derivative` stays.
    derivative, tangent
        (p + 1, p + 3) with the equations last, and (p + 2,).

    Returns
    -------
    tuple
        How it ended, and the steps.
    """
    p, last, known = room.impacts.shape[1], math.inf, column
    most, close, longest = limits
    for step in range(1, most + 1):
        here = x[p + 1] * unit
        for i in range(system.shape[0]):
            room.now[i] = system[i] + (here - base) * rate[i]
        if not known or (not column and last > COLUMN):
            by_parameter(room.now, rate, here, unit, room, period, x, derivative)
            known = True
        prepared(room.now, room)
        passed(room, x, period, GIVEN, x[p])
        by_times(room, derivative)
        last = newton_step(room, derivative, normal, x)
        if not last <= longest:
            return TOO_LONG, step
        if last <= close:
            return tangent_of(room, derivative, along, tangent), step
    return LOST, most


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
        return LOST
    length = math.sqrt(length)
    for i in range(size):
        tangent[i] = work[i, size] / length
    return FOUND
