"""A rigid piston under its valve from blow to blow, Newton's method for its cycle, and the cycle in which it settles.

Functions are plain, over tables of numbers: interpreted for one piston, for which no compiler need be loaded, with a
log of what happens; and compiled for many (`cycle_kernels`), without it.

Legs may carry, besides place, velocity and time of the piston, their derivatives by the speed just after the blow at
which the first of them began, and by the times of the orders that were pending there (theory, "The machine that
switches itself").
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from percuss.mechanics.flow import response
from percuss.steady.self_excited.piston_flight import (
    DELAY,
    DEMANDED,
    DRAG,
    EDGE,
    FACTOR,
    READS,
    STIFFNESS,
    WAY,
    PistonFlight,
    Rows,
    extremes,
    first_crossing,
    last_place,
    speed_at,
)

# ---- From a blow to the next one
#
# A piston on its way is one row: velocity away from the wall, state, last demand, number of pending orders, distance
# from the wall, time, and of each order when it is due and to which state. Just after a blow place and time are 0.

V, STATE, LAST, COUNT, X, TIME, DUE = range(7)
TO = DUE + 1

# rows of the derivatives by the numbers of the rebound at which the first leg began, then one for each pending order
BY_X, BY_V, BY_TIME, BY_ORDER = range(4)

# what a leg tells: how long it lasts, the speed before the blow, the greatest distance, the work of its switches, their
# number, when the force last rose (−1: never), whether a demand replaced an order, whether a port demanded
DURATION, SPEED, FARTHEST, WORK, SWITCHES, RISE, DROPPED, UNCOVERED = range(8)
TOLD = 8

BLOW, ON_THE_WALL, NOTHING, NO_BLOW, TOO_MANY = range(5)
"""How a leg ends; the last: more pending orders than the row has room for."""

SEGMENT, SWITCH, UNCOVERING = range(3)  # what is logged
TOGETHER = 1e-12  # of a flight: an event this little after an order is due comes before it
MOST_EVENTS = 400  # of a leg
STILL = 1e-150  # a speed whose square, and so the height of its flight from the wall, is hardly a number

Log = list[tuple[Any, ...]] | None


class PistonTables(NamedTuple):
    """A piston, and what to work in: the force of each state, its ports and its law; and the rest."""

    forces: Rows
    ports: Rows
    law: Rows
    rows: Rows
    slopes: Rows
    matrices: Rows
    tells: Rows
    step: Rows


class PistonState(NamedTuple):
    """A piston on its way: its forces, ports and law; its row, its derivatives by `columns` numbers, what it tells."""

    forces: Rows
    ports: Rows
    law: Rows
    now: Rows
    slopes: Rows
    columns: int
    told: Rows


def copied(source: Rows, target: Rows) -> None:
    """Number for number, as numba would make an array of its own to copy a slice."""
    for i in range(len(target)):
        target[i] = source[i]


def size_of(row: Rows) -> int:
    """How many numbers a rebound has: the speed, and the times of the pending orders."""
    return 1 + int(row[COUNT])


def place_of(i: int) -> int:
    """Where the numbers of a rebound are."""
    return V if i == 0 else DUE + 2 * (i - 1)


def slope_of(i: int) -> int:
    """In which row their derivatives are."""
    return BY_V if i == 0 else BY_ORDER + i - 1


def flight_of(forces: Rows, law: Rows, now: Rows) -> PistonFlight:
    """What begins here."""
    return PistonFlight(-forces[int(now[STATE])], law[STIFFNESS], law[DRAG], now[X], now[V])


def carry_out(way: PistonState, log: Log) -> None:
    """Change the state by the orders that are due."""
    forces, now, slopes, told = way.forces, way.now, way.slopes, way.told
    while now[COUNT] > 0.0 and now[DUE] <= now[TIME]:
        to = now[TO]
        work = (forces[int(to)] - forces[int(now[STATE])]) * now[X]
        told[SWITCHES] += 1.0
        told[WORK] += work
        if work > 0.0:
            told[RISE] = now[TIME]
        if log is not None:
            log.append((SWITCH, now[TIME], to, now[X], now[V], work))
        now[STATE] = to
        now[COUNT] -= 1.0
        for i in range(int(now[COUNT])):
            now[DUE + 2 * i], now[TO + 2 * i] = now[DUE + 2 * i + 2], now[TO + 2 * i + 2]
            for k in range(way.columns):
                slopes[BY_ORDER + i][k] = slopes[BY_ORDER + i + 1][k]


def demand(way: PistonState, j: int, log: Log) -> bool:
    """A port demands its state; False when too many orders are pending."""
    ports, now, slopes, told = way.ports, way.now, way.slopes, way.told
    to = ports[DEMANDED][j]
    if to == now[LAST]:
        return True
    due, before, kept = now[TIME] + ports[DELAY][j], int(now[COUNT]), 0
    for i in range(before):
        if now[DUE + 2 * i] < due:
            now[DUE + 2 * kept], now[TO + 2 * kept] = now[DUE + 2 * i], now[TO + 2 * i]
            for k in range(way.columns):
                slopes[BY_ORDER + kept][k] = slopes[BY_ORDER + i][k]
            kept += 1
    if kept < before:
        told[DROPPED] = 1.0
    if DUE + 2 * kept == len(now):
        return False
    now[DUE + 2 * kept], now[TO + 2 * kept], now[LAST], now[COUNT] = due, to, to, kept + 1.0
    for k in range(way.columns):
        slopes[BY_ORDER + kept][k] = slopes[BY_TIME][k]
    if ports[WAY][j] != 0.0:
        told[UNCOVERED] = 1.0
        if log is not None:
            log.append((UNCOVERING, now[TIME], j, now[V]))
    carry_out(way, log)
    return True


def is_asked(way: PistonState, j: int, outwards: bool, started: bool) -> bool:
    """Whether a port demands at the begin of a leg: by the blow, or, where the piston is started, as it is occupied."""
    ports, now = way.ports, way.now
    side, edge, here = ports[WAY][j], ports[EDGE][j], now[V] if ports[READS][j] != 0.0 else now[X]
    if not started or side == 0.0:
        return not started and side == 0.0
    inside = here > edge or (here == edge and outwards)
    return bool(inside == (side > 0.0))


def rest(way: PistonState, log: Log) -> None:
    """Lie on the wall until the next order is due, and forget what was before."""
    now, slopes = way.now, way.slopes
    if log is not None:
        still = PistonFlight(0.0, 0.0, way.law[DRAG], 0.0, 0.0)
        log.append((SEGMENT, now[TIME], now[DUE] - now[TIME], still, now[STATE], now[LAST]))
    now[TIME] = now[DUE]
    for k in range(way.columns):
        slopes[BY_TIME][k] = slopes[BY_ORDER][k]
        slopes[BY_X][k], slopes[BY_V][k] = 0.0, 0.0


def fly(way: PistonState, flight: PistonFlight, duration: float, place: float, to: int, reads: int, log: Log) -> None:
    """To the place, or the speed that is read, or, with the direction 0, to when the next order is due."""
    now, slopes, told = way.now, way.slopes, way.told
    stiffness, drag = flight.stiffness, flight.drag
    ds, s, q, _ = response(duration, stiffness, drag)
    pull = flight.push - stiffness * flight.x
    x, v = flight.x + flight.v * s + pull * q, flight.v * ds + pull * s
    if log is not None:
        log.append((SEGMENT, now[TIME], duration, flight, now[STATE], now[LAST]))
    told[FARTHEST] = max(told[FARTHEST], extremes(flight, duration)[1])
    if to == 0:
        now[TIME] = now[DUE]
    else:
        now[TIME] += duration
        if reads != 0:
            v = place
        else:
            x = place
            if drag == 0.0:
                v = speed_at(flight, place, to)
    acceleration = flight.push - stiffness * x - drag * v
    for k in range(way.columns):
        by_x, by_v = slopes[BY_X][k], slopes[BY_V][k]
        by_x, by_v = (1.0 - stiffness * q) * by_x + s * by_v, -stiffness * s * by_x + ds * by_v
        met, rate = (by_v, acceleration) if reads != 0 else (by_x, v)
        longer = slopes[BY_ORDER][k] - slopes[BY_TIME][k] if to == 0 else -met / rate if rate != 0.0 else 0.0
        slopes[BY_X][k], slopes[BY_V][k] = by_x + v * longer, by_v + acceleration * longer
        slopes[BY_TIME][k] += longer
    now[X], now[V] = x, v
    told[FARTHEST] = max(told[FARTHEST], x)


def leg(
    work: PistonTables, begin: Rows, started: bool, now: Rows, told: Rows, columns: int = 0, log: Log = None
) -> int:
    """From a rebound, or a start, to the next one; how it ends, with the rebound and what it tells written."""
    # The slopes are carried on, of so many columns.
    ports = work.ports
    way = PistonState(work.forces, ports, work.law, now, work.slopes, columns, told)
    copied(begin, now)
    for i in range(TOLD):
        told[i] = 0.0
    told[RISE] = -1.0
    flight = flight_of(way.forces, way.law, now)
    outwards = now[V] > 0.0 or (now[V] == 0.0 and flight.push - flight.stiffness * now[X] > 0.0)
    for j in range(len(ports[WAY])):
        asked = is_asked(way, j, outwards, started)
        if asked and not demand(way, j, log):
            return TOO_MANY
    for _ in range(MOST_EVENTS):
        carry_out(way, log)
        until = now[DUE] - now[TIME] if now[COUNT] > 0.0 else math.inf
        flight = flight_of(way.forces, way.law, now)
        if now[X] == 0.0 and 0.0 <= now[V] <= STILL and flight.push <= 0.0:
            if until == math.inf:
                return ON_THE_WALL
            rest(way, log)
            continue
        time, place, to, reads = first_crossing(flight, ports, until * (1.0 + TOGETHER))
        duration = until if to == 0 else time
        if duration == math.inf:
            if log is not None:
                told[FARTHEST] = max(told[FARTHEST], extremes(flight, math.inf)[1], last_place(flight))
                log.append((SEGMENT, now[TIME], math.inf, flight, now[STATE], now[LAST]))
            return NOTHING
        fly(way, flight, duration, place, to, reads, log)
        if to < 0 and place == 0.0 and reads == 0:
            struck(way)
            return BLOW
        for j in range(len(ports[WAY])):
            passed = to != 0 and ports[WAY][j] == to and ports[EDGE][j] == place and ports[READS][j] == reads
            if passed and not demand(way, j, log):
                return TOO_MANY
    return NO_BLOW


def struck(way: PistonState) -> None:
    """The rebound of a blow, and its derivatives."""
    now, slopes, told, factor = way.now, way.slopes, way.told, way.law[FACTOR]
    told[DURATION], told[SPEED] = now[TIME], -now[V]
    for i in range(int(now[COUNT])):
        now[DUE + 2 * i] -= now[TIME]
        for k in range(way.columns):
            slopes[BY_ORDER + i][k] -= slopes[BY_TIME][k]
    for k in range(way.columns):
        slopes[BY_X][k], slopes[BY_TIME][k] = 0.0, 0.0
        slopes[BY_V][k] *= factor
    now[V], now[X], now[TIME] = factor * now[V], 0.0, 0.0


# ---- Newton's method for the cycle

# rows of rebounds: what Newton's method works with, and the cycle's, then those of legs that were followed
NOW, NEXT, TRIAL, END, FIRST = range(5)
# matrices: derivatives of the cycle's map, the equations, and two to work with
ALL, EQUATIONS, POWER, SQUARED = range(4)
MATRICES = 4
# rows of what legs tell: one leg, all of a cycle, and those that were followed from FIRST on
SINGLE, WHOLE = range(2)

NEWTON_STEPS = 40
SHRINKING = 16  # steps after which each is shorter than the one before, or there is no cycle near
CLOSELY = 3  # the same for a start close to the cycle
NEWTON_SHRUNK = 0.9  # of the step before: at a fold it is 0.5
CLOSED = 1e-13  # of the speed and of the period
MEETS = 1e-9  # … of the rebound and the one that follows: at a grazing the slope is so great that no step is long
HALVINGS = 6
TOUCHES = 1e-12  # of the energy under way: a weaker blow is rounding


def legs_of_cycle(begin: Rows, blows: int, work: PistonTables) -> bool:
    """The flights of so many blows, when they lead to a rebound of the same kind: at `END`, and what they tell."""
    whole, single, now, following = work.tells[WHOLE], work.tells[SINGLE], work.rows[NOW], work.rows[END]
    size, slopes = size_of(begin), work.slopes
    copied(begin, now)
    for i in range(TOLD):
        whole[i] = 0.0
    whole[RISE] = -1.0
    for i in range(len(slopes)):
        for k in range(size):
            slopes[i][k] = 0.0
    for i in range(size):
        slopes[slope_of(i)][i] = 1.0
    for _ in range(blows):
        if leg(work, now, False, following, single, size) != BLOW:
            return False
        for name in (DURATION, WORK, SWITCHES, DROPPED):
            whole[name] += single[name]
        for name in (SPEED, FARTHEST, RISE):
            whole[name] = max(whole[name], single[name])
        copied(following, now)
    if not alike(begin, following):
        return False
    for i in range(size):
        for k in range(size):
            work.matrices[ALL][i][k] = slopes[slope_of(i)][k]
    return True


def alike(one: Rows, other: Rows) -> bool:
    """Whether two rebounds differ by their numbers only."""
    same: bool = one[STATE] == other[STATE] and one[LAST] == other[LAST] and one[COUNT] == other[COUNT]
    for i in range(int(one[COUNT])):
        same = same and one[TO + 2 * i] == other[TO + 2 * i]
    return same


def solved(equations: Rows, size: int, step: Rows) -> bool:
    """Solve for the step, which is the last column, by elimination; False where that is not possible."""
    for i in range(size):
        pivot = i
        for k in range(i + 1, size):
            if abs(equations[k][i]) > abs(equations[pivot][i]):
                pivot = k
        if equations[pivot][i] == 0.0 or not math.isfinite(equations[pivot][i]):
            return False
        for k in range(size + 1):
            equations[i][k], equations[pivot][k] = equations[pivot][k], equations[i][k]
        for k in range(i + 1, size):
            ratio = equations[k][i] / equations[i][i]
            for m in range(i, size + 1):
                equations[k][m] -= ratio * equations[i][m]
    for i in range(size - 1, -1, -1):
        value = equations[i][size]
        for k in range(i + 1, size):
            value -= equations[i][k] * step[k]
        step[i] = value / equations[i][i]
        if not math.isfinite(step[i]):
            return False
    return True


def newton_step(begin: Rows, work: PistonTables) -> float:
    """The size of the next step of Newton's method, as a part of speed or period; infinite when there is none."""
    size, equations, end, whole = size_of(begin), work.matrices[EQUATIONS], work.rows[END], work.tells[WHOLE]
    apart, greatest = 0.0, 0.0
    for i in range(size):
        place = place_of(i)
        apart = max(apart, abs(end[place] - begin[place]) / scale_of(i, whole))
        for k in range(size):
            equations[i][k] = (1.0 if i == k else 0.0) - work.matrices[ALL][i][k]
        equations[i][size] = end[place] - begin[place]
    if not solved(equations, size, work.step):
        return math.inf
    for i in range(size):
        greatest = max(greatest, abs(work.step[i]) / scale_of(i, whole))
    return greatest if greatest > CLOSED or apart <= MEETS else math.inf


def scale_of(i: int, whole: Rows) -> float:
    """What a number of a rebound is measured by: the speed, or the period."""
    scale: float = whole[SPEED] if i == 0 else whole[DURATION]
    return scale


def is_idle(begin: Rows, whole: Rows) -> bool:
    """Whether no demand was accepted, or the wall is only touched."""
    # A slower rebound passes some of the same ports, so that it changes nothing either: Newton's method leads to rest.
    return not whole[SPEED] > 0.0 or (begin[COUNT] == 0.0 and whole[SWITCHES] == 0.0 and whole[DROPPED] == 0.0)


def strikes(forces: Rows, whole: Rows) -> bool:
    """Whether it does more than touch the wall, so that rounding makes a blow of a swing that ends there."""
    force = 0.0
    for k in range(len(forces)):
        force = max(force, abs(forces[k]))
    return bool(whole[SPEED] * whole[SPEED] > TOUCHES * force * whole[FARTHEST])


def cycle_near(begin: Rows, blows: int, shrinking: int, work: PistonTables) -> bool:
    """Whether Newton's method leads from a rebound to a cycle: at `NEXT`, and told as a whole."""
    # After `shrinking` steps each must be shorter than the one before.
    now, trial = work.rows[NEXT], work.rows[TRIAL]
    copied(begin, now)
    size = size_of(begin)
    if not legs_of_cycle(now, blows, work):
        return False
    before = math.inf
    for number in range(NEWTON_STEPS):
        if is_idle(now, work.tells[WHOLE]):
            return False
        far = newton_step(now, work)
        if far <= CLOSED:
            return strikes(work.forces, work.tells[WHOLE])
        if far == math.inf or (number >= shrinking and far > NEWTON_SHRUNK * before):
            return False
        before = far
        part, there = 1.0, False
        for _ in range(HALVINGS):
            copied(now, trial)
            allowed = True
            for i in range(size):
                place = place_of(i)
                trial[place] += part * work.step[i]
                allowed = allowed and trial[place] >= 0.0
            there = allowed and legs_of_cycle(trial, blows, work)
            if there:
                break
            part *= 0.5
        if not there:
            return False
        copied(trial, now)
    return False


# ---- The cycle in which a machine ends: some blows from a fast start, then Newton's method

FEW = 4
MOST_BLOWS = 80  # in which a machine settles, or is given up
MOST_IN_CYCLE = 8
TRIES = 12
TRIES_IN_CYCLE = 3  # for each number of blows in a cycle
LATELY = 12  # flights that tell what a machine without a cycle does
ALIKE = 0.1  # speeds so near each other, as a part, are worth a try with several blows in a cycle
CHATTER = 1e-10  # of the greatest speed: a slower rebound at a wall to which the valve pushes is at rest
STARTED_BLOWS = 6 * MOST_BLOWS
SQUARINGS, SHRUNK = 6, 0.1
ARRIVED = 1e-9  # of the speed and of the period: it will not leave a cycle that attracts any more

RUNS, STAYS, NO_PORT, BLOWLESS, DOUBLE, OVERTAKEN, IRREGULAR, UNKNOWN = range(8)
"""What a piston does; the last: no answer."""

SETTLED_AT = ((1.0, FEW, 0), (1.0, MOST_BLOWS, FEW), (0.5, MOST_BLOWS, 0), (0.25, MOST_BLOWS, 0), (2.0, MOST_BLOWS, 0))
"""Part of the greatest speed, legs that are followed, and how many of the first ones were tried before."""


def fast(forces: Rows, ports: Rows, law: Rows, part: float, row: Rows) -> None:
    """A rebound at a part of the speed that the valve could give at most, in the state that pulls most."""
    back, greatest, far, latest, swift = 0, forces[0], 0.0, 0.0, 0.0
    for k in range(len(forces)):
        back = k if forces[k] < forces[back] else back
        greatest = max(greatest, forces[k])
    for j in range(len(ports[WAY])):
        if ports[READS][j] != 0.0:
            swift = max(swift, abs(ports[EDGE][j]))
        elif ports[WAY][j] != 0.0:
            far = max(far, ports[EDGE][j])
        latest = max(latest, ports[DELAY][j])
    difference = greatest - forces[back]
    most = 2.0 * difference * far + (difference * latest) * (difference * latest) + swift * swift
    lost = max(0.05, 1.0 - law[FACTOR] * law[FACTOR])
    for i in range(len(row)):
        row[i] = 0.0
    row[V], row[STATE], row[LAST] = -law[FACTOR] * math.sqrt(most / lost) * part, float(back), float(back)


def settle(forces: Rows, law: Rows, now: Rows, greatest: float) -> float:
    """Lay down a rebound that is too slow, at a wall to which the valve pushes; the greatest speed."""
    greatest, speed = max(greatest, now[V]), now[V]
    if speed < CHATTER * greatest:
        now[V] = 0.0
        if not flight_of(forces, law, now).push < 0.0:
            now[V] = speed
    return greatest


def followed(most: int, work: PistonTables) -> tuple[int, int]:
    """Fly from the rebound at `NOW` until nothing follows, or so many legs; their number, and how the last one ends."""
    # The rebounds are in the rows from `FIRST` on, and what the legs tell, too.
    now, greatest, ending, number = work.rows[NOW], 0.0, BLOW, 0
    while number < most and ending == BLOW:
        row = work.rows[FIRST + number]
        ending = leg(work, now, False, row, work.tells[FIRST + number])
        copied(row, now)
        number += 1
        greatest = settle(work.forces, work.law, now, greatest)
    return number, ending


def cycle_at(tried: int, rebounds: int, work: PistonTables) -> int:
    """Blows of the cycle that one of the rebounds is near, with few of them rather than many; 0 without one."""
    # The first ones were tried before.
    rows, whole = work.rows, work.tells[WHOLE]
    for i in range(tried, min(rebounds, TRIES)):
        if cycle_near(rows[FIRST + i], 1, SHRINKING, work) and whole[SWITCHES] > 0.0:
            return 1
    for blows in range(1, MOST_IN_CYCLE + 1):
        tries = 0
        for i in range(rebounds - 1, max(blows, rebounds - TRIES + 1) - 1, -1):
            now, before = rows[FIRST + i], rows[FIRST + i - blows]
            if not alike(now, before) or abs(now[V] - before[V]) > ALIKE * max(now[V], before[V]):
                continue
            tries += 1
            if tries > TRIES_IN_CYCLE:
                break
            if cycle_near(now, blows, SHRINKING, work) and whole[SWITCHES] > 0.0:
                return blows
    return 0


def why_none(legs: int, ending: int, tells: Rows) -> int:
    """What the last flights of a piston without a cycle tell of it."""
    if ending == ON_THE_WALL:
        return STAYS
    if ending == NOTHING:
        return BLOWLESS if tells[FIRST + legs - 1][UNCOVERED] > 0.0 else NO_PORT
    if ending != BLOW:
        return UNKNOWN if ending == TOO_MANY else BLOWLESS
    for i in range(max(0, legs - LATELY), legs):
        if tells[FIRST + i][SWITCHES] == 0.0:
            return DOUBLE
    return IRREGULAR


def settled(work: PistonTables) -> tuple[int, int, float]:
    """What a piston does; blows in its cycle, 0 for none, which is then at `NEXT`; the part of the start that told."""
    why, legs, first = UNKNOWN, 0, 1.0
    for part, most, tried in SETTLED_AT:
        fast(work.forces, work.ports, work.law, part, work.rows[NOW])
        number, ending = followed(most, work)
        if ending == TOO_MANY:
            return UNKNOWN, 0, part
        if legs <= FEW:
            why, legs, first = why_none(number, ending, work.tells), number, part
        rebounds = number if ending == BLOW else number - 1
        blows = cycle_at(tried, rebounds, work)
        if blows == 1:
            return RUNS, 1, part
        if blows > 1:
            return OVERTAKEN if work.tells[WHOLE][DROPPED] > 0.0 else DOUBLE, blows, part
    return why, 0, first


def contracts(size: int, work: PistonTables) -> bool:
    """Whether many returns shrink every disturbance of a cycle, whose derivatives are in `ALL`."""
    power, squared, whole = work.matrices[POWER], work.matrices[SQUARED], work.tells[WHOLE]
    speed, period = whole[SPEED], whole[DURATION]
    for i in range(size):
        for k in range(size):
            scale = speed / period if i > 0 and k == 0 else period / speed if i == 0 and k > 0 else 1.0
            power[i][k] = work.matrices[ALL][i][k] * scale
    for _ in range(SQUARINGS):
        for i in range(size):
            for k in range(size):
                squared[i][k] = 0.0
                for m in range(size):
                    squared[i][k] += power[i][m] * power[m][k]
        for i in range(size):
            for k in range(size):
                power[i][k] = squared[i][k]
    for i in range(size):
        for k in range(size):
            if not abs(power[i][k]) < SHRUNK:
                return False
    return True


def arrived(now: Rows, cycle: Rows, period: float) -> bool:
    """Whether a rebound is that of a cycle."""
    close = alike(now, cycle) and abs(now[V] - cycle[V]) <= ARRIVED * cycle[V]
    for i in range(int(cycle[COUNT])):
        close = close and abs(now[DUE + 2 * i] - cycle[DUE + 2 * i]) <= ARRIVED * period
    return close


def starts(first: float, attracts: bool, work: PistonTables) -> bool:
    """Whether a piston keeps going that starts at rest on the wall in a state; `attracts`: its cycle, at `NEXT`."""
    now, following, greatest = work.rows[NOW], work.rows[END], 0.0
    for i in range(len(now)):
        now[i] = 0.0
    now[STATE], now[LAST] = first, first
    for number in range(STARTED_BLOWS):
        if leg(work, now, number == 0, following, work.tells[SINGLE]) != BLOW:
            return False
        if attracts and arrived(following, work.rows[NEXT], work.tells[WHOLE][DURATION]):
            return True
        copied(following, now)
        greatest = settle(work.forces, work.law, now, greatest)
    return True
