"""A rigid piston under its valve from blow to blow, compiled, as `percuss.steady.self_excited.piston_legs`.

A piston on its way is one row: velocity away from the wall, state, last demand, number of pending orders, distance from
the wall, time, and of each order when it is due and to which state. Just after a blow place and time are 0.
"""

import math

from percuss.compiled import inner
from percuss.steady.self_excited.flight_kernels import (
    DELAY,
    DEMANDED,
    EDGE,
    WAY,
    farthest,
    first_crossing,
    response,
    speed_at,
)

MOST = 8
"""The most pending orders; with more of them the compiled functions give no answer."""

V, STATE, LAST, COUNT, X, TIME, DUE = range(7)
TO = DUE + MOST
ROW = TO + MOST

# rows of the derivatives by the numbers of the rebound at which the leg began, then one for each pending order
BY_X, BY_V, BY_TIME, BY_ORDER = range(4)
SLOPES = BY_ORDER + MOST
NUMBERS = 1 + MOST

# what a leg tells: how long it lasts, the speed before the blow, the greatest distance, the work of its switches, their
# number, when the force last rose (−1: never), whether a demand replaced an order, whether a port demanded
DURATION, SPEED, FARTHEST, WORK, SWITCHES, RISE, DROPPED, UNCOVERED = range(8)
TOLD = 8

STIFFNESS, DRAG, FACTOR = range(3)
BLOW, ON_THE_WALL, NOTHING, NO_BLOW, TOO_MANY = range(5)
"""How a leg ends; the last: too many pending orders."""

TOGETHER, STILL = 1e-12, 1e-150  # as in piston_legs
MOST_EVENTS = 400


@inner
def copied(source, target):
    """Row for row, as numba would make an array of its own to copy a slice."""
    for i in range(target.size):
        target[i] = source[i]


@inner
def drop_first(now, slopes, columns):
    """The first order is no longer pending."""
    now[COUNT] -= 1.0
    for i in range(int(now[COUNT])):
        now[DUE + i], now[TO + i] = now[DUE + i + 1], now[TO + i + 1]
        for k in range(columns):
            slopes[BY_ORDER + i, k] = slopes[BY_ORDER + i + 1, k]


@inner
def carry_out(forces, now, slopes, columns, told):
    """Change the state by the orders that are due."""
    while now[COUNT] > 0.0 and now[DUE] <= now[TIME]:
        to = now[TO]
        work = (forces[int(to)] - forces[int(now[STATE])]) * now[X]
        told[SWITCHES] += 1.0
        told[WORK] += work
        if work > 0.0:
            told[RISE] = now[TIME]
        now[STATE] = to
        drop_first(now, slopes, columns)


@inner
def demand(forces, ports, j, now, slopes, columns, told):
    """A port demands its state; False when too many orders are pending."""
    to = ports[DEMANDED, j]
    if to == now[LAST]:
        return True
    due, before, kept = now[TIME] + ports[DELAY, j], int(now[COUNT]), 0
    for i in range(before):
        if now[DUE + i] < due:
            now[DUE + kept], now[TO + kept] = now[DUE + i], now[TO + i]
            for k in range(columns):
                slopes[BY_ORDER + kept, k] = slopes[BY_ORDER + i, k]
            kept += 1
    if kept < before:
        told[DROPPED] = 1.0
    if kept == MOST:
        return False
    now[DUE + kept], now[TO + kept], now[LAST], now[COUNT] = due, to, to, kept + 1.0
    for k in range(columns):
        slopes[BY_ORDER + kept, k] = slopes[BY_TIME, k]
    if ports[WAY, j] != 0.0:
        told[UNCOVERED] = 1.0
    carry_out(forces, now, slopes, columns, told)
    return True


@inner
def first_demands(forces, law, ports, now, slopes, columns, told, started):
    """What the blow demands, or, where the machine is started, the ports that are occupied; False: too many orders."""
    outwards = now[V] > 0.0 or (now[V] == 0.0 and -forces[int(now[STATE])] - law[STIFFNESS] * now[X] > 0.0)
    for j in range(ports.shape[1]):
        way, edge = ports[WAY, j], ports[EDGE, j]
        if started and way != 0.0:
            inside = now[X] > edge or (now[X] == edge and outwards)
            asked = inside == (way > 0.0)
        else:
            asked = not started and way == 0.0
        if asked and not demand(forces, ports, j, now, slopes, columns, told):
            return False
    return True


@inner
def rest(now, slopes, columns):
    """Lie on the wall until the next order is due, and forget what was before."""
    now[TIME] = now[DUE]
    for k in range(columns):
        slopes[BY_TIME, k], slopes[BY_X, k], slopes[BY_V, k] = slopes[BY_ORDER, k], 0.0, 0.0


@inner
def fly(push, law, now, slopes, columns, told, duration, place, way):
    """To the place, or, with the direction 0, to when the next order is due."""
    stiffness, drag = law[STIFFNESS], law[DRAG]
    told[FARTHEST] = max(told[FARTHEST], farthest(push, stiffness, drag, now[X], now[V], duration))
    ds, s, q = response(duration, stiffness, drag)
    force = push - stiffness * now[X]
    x, v = now[X] + now[V] * s + force * q, now[V] * ds + force * s
    if way == 0:
        now[TIME] = now[DUE]
    else:
        now[TIME] += duration
        x = place
        if drag == 0.0:
            v = speed_at(push, stiffness, now[X], now[V], place, way)
    acceleration = push - stiffness * x - drag * v
    for k in range(columns):
        by_x, by_v = slopes[BY_X, k], slopes[BY_V, k]
        by_x, by_v = (1.0 - stiffness * q) * by_x + s * by_v, -stiffness * s * by_x + ds * by_v
        longer = slopes[BY_ORDER, k] - slopes[BY_TIME, k] if way == 0 else -by_x / v if v != 0.0 else 0.0
        slopes[BY_X, k], slopes[BY_V, k] = by_x + v * longer, by_v + acceleration * longer
        slopes[BY_TIME, k] += longer
    now[X], now[V] = x, v
    told[FARTHEST] = max(told[FARTHEST], x)


@inner
def leg(forces, ports, law, begin, started, now, slopes, slope, told):
    """From a rebound to the next one, or from a start; returns how it ends.

    Writes the rebound, the derivatives of its numbers by those of the first, and what the leg tells.
    """
    copied(begin, now)
    told[:], slopes[:, :] = 0.0, 0.0
    told[RISE] = -1.0
    columns = 1 + int(begin[COUNT])
    slopes[BY_V, 0] = 1.0
    for i in range(columns - 1):
        slopes[BY_ORDER + i, 1 + i] = 1.0
    if not first_demands(forces, law, ports, now, slopes, columns, told, started):
        return TOO_MANY
    for _ in range(MOST_EVENTS):
        carry_out(forces, now, slopes, columns, told)
        until = now[DUE] - now[TIME] if now[COUNT] > 0.0 else math.inf
        push = -forces[int(now[STATE])]
        if now[X] == 0.0 and 0.0 <= now[V] <= STILL and push <= 0.0:
            if until == math.inf:
                return ON_THE_WALL
            rest(now, slopes, columns)
            continue
        time, place, way = first_crossing(
            push, law[STIFFNESS], law[DRAG], now[X], now[V], ports, until * (1.0 + TOGETHER)
        )
        if way == 0 and until == math.inf:
            return NOTHING
        fly(push, law, now, slopes, columns, told, until if way == 0 else time, place, way)
        if way < 0 and place == 0.0:
            struck(law[FACTOR], now, slopes, columns, slope, told)
            return BLOW
        for j in range(ports.shape[1]):
            passed = way != 0 and ports[WAY, j] == way and ports[EDGE, j] == place
            if passed and not demand(forces, ports, j, now, slopes, columns, told):
                return TOO_MANY
    return NO_BLOW


@inner
def struck(factor, now, slopes, columns, slope, told):
    """The rebound of a blow, and its derivatives."""
    told[DURATION], told[SPEED] = now[TIME], -now[V]
    for k in range(columns):
        slope[0, k] = factor * slopes[BY_V, k]
        for i in range(int(now[COUNT])):
            slope[1 + i, k] = slopes[BY_ORDER + i, k] - slopes[BY_TIME, k]
    for i in range(int(now[COUNT])):
        now[DUE + i] -= now[TIME]
    now[V], now[X], now[TIME] = factor * now[V], 0.0, 0.0
