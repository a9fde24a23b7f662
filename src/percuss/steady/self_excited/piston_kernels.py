"""A rigid piston under its valve from blow to blow, Newton's method for its cycle, and the cycle in which it settles.

Functions are plain, over tables of numbers: interpreted for one piston, for which no compiler need be loaded, with a
supply and a log of what happens; and compiled for many (`cycle_kernels`), without both.

A leg carries, besides place, velocity and time of the piston, their derivatives by the speed just after the blow at
which it began, by the times of the orders that were pending there, and by the pressure of a supply there (theory, "The
machine that switches itself").
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple, Protocol

from percuss.mechanics.flow import response
from percuss.steady.self_excited.piston_flight import (
    DELAY,
    DEMANDED,
    EDGE,
    WAY,
    Flight,
    Rows,
    farthest,
    first_crossing,
    last_place,
    ramped_crossing,
    speed_at,
)

# ---- From a blow to the next one
#
# A piston on its way is one row: velocity away from the wall, state, last demand, number of pending orders, distance
# from the wall, time, pressure of a supply, and of each order when it is due and to which state. Just after a blow
# place and time are 0.

V, STATE, LAST, COUNT, X, TIME, PRESSURE, DUE = range(8)
TO = DUE + 1

# rows of the derivatives by the numbers of the rebound at which the leg began, then one for each pending order
BY_X, BY_V, BY_TIME, BY_PRESSURE, BY_ORDER = range(5)

# what a leg tells: how long it lasts, the speed before the blow, the greatest distance, the work of its switches, their
# number, when the force last rose (−1: never), whether a demand replaced an order, whether a port demanded
DURATION, SPEED, FARTHEST, WORK, SWITCHES, RISE, DROPPED, UNCOVERED = range(8)
TOLD = 8

STIFFNESS, DRAG, FACTOR = range(3)
BLOW, ON_THE_WALL, NOTHING, NO_BLOW, NO_PRESSURE, TOO_MANY = range(6)
"""How a leg ends; the last: more pending orders than the row has room for."""

SEGMENT, SWITCH, UNCOVERING = range(3)
"""What is logged."""

TOGETHER = 1e-12  # of a flight: an event this little after an order is due comes before it
MOST_EVENTS = 400  # of a leg
STILL = 1e-150  # a speed whose square, and so the height of its flight from the wall, is hardly a number

Log = list[tuple[Any, ...]] | None


class Supplied(Protocol):
    """What the functions ask of a supply."""

    flow: float
    compliance: float
    drawing: list[float]

    def flight(self, state: int, x: float, v: float, pressure: float) -> Flight:
        """The flight that begins in a state."""

    def lowest(self, flight: Flight, duration: float, pressure: float, state: int) -> float:
        """The least pressure in a flight."""


Supply = Supplied | None


def copied(source: Rows, target: Rows) -> None:
    """Number for number, as numba would make an array of its own to copy a slice."""
    for i in range(len(target)):
        target[i] = source[i]


def size_of(row: Rows, supply: Supply) -> int:
    """How many numbers a rebound has: the speed, the times of the pending orders, and the pressure of a supply."""
    return 1 + int(row[COUNT]) if supply is None else 2 + int(row[COUNT])


def place_of(i: int, row: Rows) -> int:
    """Where the numbers of a rebound are."""
    return V if i == 0 else DUE + 2 * (i - 1) if i <= row[COUNT] else PRESSURE


def flight_of(forces: Rows, law: Rows, now: Rows, supply: Supply) -> Flight:
    """What begins here."""
    if supply is not None:
        return supply.flight(int(now[STATE]), now[X], now[V], now[PRESSURE])
    return Flight(-forces[int(now[STATE])], law[STIFFNESS], law[DRAG], now[X], now[V], 0.0)


def carry_out(forces: Rows, now: Rows, slopes: Rows, columns: int, told: Rows, supply: Supply, log: Log) -> None:
    """Change the state by the orders that are due."""
    while now[COUNT] > 0.0 and now[DUE] <= now[TIME]:
        to = now[TO]
        work = (forces[int(to)] - forces[int(now[STATE])]) * now[X]
        if supply is not None:
            work *= now[PRESSURE]
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
            for k in range(columns):
                slopes[BY_ORDER + i][k] = slopes[BY_ORDER + i + 1][k]


def demand(
    forces: Rows, ports: Rows, j: int, now: Rows, slopes: Rows, columns: int, told: Rows, supply: Supply, log: Log
) -> bool:
    """A port demands its state; False when too many orders are pending."""
    to = ports[DEMANDED][j]
    if to == now[LAST]:
        return True
    due, before, kept = now[TIME] + ports[DELAY][j], int(now[COUNT]), 0
    for i in range(before):
        if now[DUE + 2 * i] < due:
            now[DUE + 2 * kept], now[TO + 2 * kept] = now[DUE + 2 * i], now[TO + 2 * i]
            for k in range(columns):
                slopes[BY_ORDER + kept][k] = slopes[BY_ORDER + i][k]
            kept += 1
    if kept < before:
        told[DROPPED] = 1.0
    if DUE + 2 * kept == len(now):
        return False
    now[DUE + 2 * kept], now[TO + 2 * kept], now[LAST], now[COUNT] = due, to, to, kept + 1.0
    for k in range(columns):
        slopes[BY_ORDER + kept][k] = slopes[BY_TIME][k]
    if ports[WAY][j] != 0.0:
        told[UNCOVERED] = 1.0
        if log is not None:
            log.append((UNCOVERING, now[TIME], j, now[V]))
    carry_out(forces, now, slopes, columns, told, supply, log)
    return True


def is_asked(ports: Rows, j: int, now: Rows, outwards: bool, started: bool) -> bool:
    """Whether a port demands at the begin of a leg: by the blow, or, where the piston is started, as it is occupied."""
    way, edge = ports[WAY][j], ports[EDGE][j]
    if not started or way == 0.0:
        return not started and way == 0.0
    inside = now[X] > edge or (now[X] == edge and outwards)
    return bool(inside == (way > 0.0))


def rest(
    forces: Rows, law: Rows, now: Rows, slopes: Rows, columns: int, lifted: float, supply: Supply, log: Log
) -> None:
    """Lie on the wall until the next order is due or a growing pressure lifts it, and forget what was before."""
    until = now[DUE] - now[TIME] if now[COUNT] > 0.0 else math.inf
    duration = min(until, lifted)
    if log is not None:
        log.append(
            (
                SEGMENT,
                now[TIME],
                duration,
                Flight(0.0, 0.0, law[DRAG], 0.0, now[V]),
                now[STATE],
                0.0,
                0.0,
                now[PRESSURE],
            )
        )
    now[TIME] = now[DUE] if until <= lifted else now[TIME] + duration
    if supply is not None:
        growth = supply.flow / supply.compliance
        now[PRESSURE] += growth * duration
        for k in range(columns):
            if until <= lifted:
                slopes[BY_PRESSURE][k] += growth * (slopes[BY_ORDER][k] - slopes[BY_TIME][k])
            else:
                slopes[BY_TIME][k] -= slopes[BY_PRESSURE][k] / growth
                slopes[BY_PRESSURE][k] = 0.0
        if until > lifted:  # the pressure at which nothing pushes to the wall any more, or just above it by rounding
            while flight_of(forces, law, now, supply).push < 0.0:
                now[PRESSURE] = math.nextafter(now[PRESSURE], math.inf)
    for k in range(columns):
        if until <= lifted:
            slopes[BY_TIME][k] = slopes[BY_ORDER][k]
        slopes[BY_X][k], slopes[BY_V][k] = 0.0, 0.0


def fly(
    flight: Flight,
    law: Rows,
    now: Rows,
    slopes: Rows,
    columns: int,
    told: Rows,
    duration: float,
    place: float,
    way: int,
    supply: Supply,
    log: Log,
) -> None:
    """To the place, or, with the direction 0, to when the next order is due."""
    stiffness, drag, gas = flight.stiffness, flight.drag, law[STIFFNESS]
    ds, s, q, w = response(duration, stiffness, drag)
    force, began = flight.push - stiffness * flight.x, now[TIME]
    x = flight.x + flight.v * s + force * q + flight.ramp * w
    v = flight.v * ds + force * s + flight.ramp * q
    if way == 0:
        now[TIME] = now[DUE]
    else:
        now[TIME] += duration
        x = place
        if drag == 0.0 and supply is None:
            v = speed_at(flight, place, way)
    acceleration = flight.push + flight.ramp * duration - stiffness * x - drag * v
    if supply is not None:
        drawing, c = supply.drawing[int(now[STATE])], supply.compliance
        if log is not None:
            began = now[TIME] - duration
    for k in range(columns):
        old, by_v = slopes[BY_X][k], slopes[BY_V][k]
        by_x, by_v = (1.0 - gas * q) * old + s * by_v, -gas * s * old + ds * by_v
        if supply is not None:
            by_x -= drawing * q * slopes[BY_PRESSURE][k]
            by_v -= drawing * s * slopes[BY_PRESSURE][k]
        longer = slopes[BY_ORDER][k] - slopes[BY_TIME][k] if way == 0 else -by_x / v if v != 0.0 else 0.0
        if supply is not None:
            slopes[BY_PRESSURE][k] += (by_x - old) * drawing / c + (supply.flow + drawing * v) / c * longer
        slopes[BY_X][k], slopes[BY_V][k] = by_x + v * longer, by_v + acceleration * longer
        slopes[BY_TIME][k] += longer
    if log is not None:
        log.append((SEGMENT, began, duration, flight, now[STATE], x, v, now[PRESSURE]))
    if supply is not None:
        now[PRESSURE] += (supply.flow * duration + drawing * (x - flight.x)) / c
    now[X], now[V] = x, v
    told[FARTHEST] = max(told[FARTHEST], x, flight.x)


def leg(
    forces: Rows,
    ports: Rows,
    law: Rows,
    begin: Rows,
    started: bool,
    now: Rows,
    slopes: Rows,
    slope: Rows,
    told: Rows,
    supply: Supply,
    log: Log,
) -> int:
    """From a rebound to the next one, or from a start; returns how it ends.

    Writes the rebound, the derivatives of its numbers by those of the first, and what the leg tells.
    """
    columns = size_of(begin, supply)
    copied(begin, now)
    for i in range(TOLD):
        told[i] = 0.0
    told[RISE] = -1.0
    for i in range(len(slopes)):
        for k in range(columns):
            slopes[i][k] = 0.0
    slopes[BY_V][0] = 1.0
    for i in range(int(begin[COUNT])):
        slopes[BY_ORDER + i][1 + i] = 1.0
    if supply is not None:
        slopes[BY_PRESSURE][columns - 1] = 1.0
    flight = flight_of(forces, law, now, supply)
    outwards = now[V] > 0.0 or (now[V] == 0.0 and flight.push - flight.stiffness * now[X] > 0.0)
    for j in range(len(ports[WAY])):
        asked = is_asked(ports, j, now, outwards, started)
        if asked and not demand(forces, ports, j, now, slopes, columns, told, supply, log):
            return TOO_MANY
    for _ in range(MOST_EVENTS):
        carry_out(forces, now, slopes, columns, told, supply, log)
        until = now[DUE] - now[TIME] if now[COUNT] > 0.0 else math.inf
        flight, lifted, pressure = flight_of(forces, law, now, supply), math.inf, now[PRESSURE]
        if now[X] == 0.0 and 0.0 <= now[V] <= STILL and flight.push <= 0.0:
            if supply is not None:  # a growing pressure may lift it
                lifted = -flight.push / flight.ramp if flight.ramp > 0.0 else math.inf
            if until == math.inf and lifted == math.inf:
                return ON_THE_WALL
            if lifted > 0.0:
                rest(forces, law, now, slopes, columns, lifted, supply, log)
                continue
        soon = until * (1.0 + TOGETHER)
        time, place, way = 0.0, 0.0, 0
        if supply is not None:
            find = ramped_crossing if flight.ramp != 0.0 else first_crossing
            time, place, way = find(flight, ports, soon)
        else:
            time, place, way = first_crossing(flight, ports, soon)
        duration = until if way == 0 else time
        if duration == math.inf:
            if log is not None:
                log.append((SEGMENT, now[TIME], math.inf, flight, now[STATE], last_place(flight), 0.0, now[PRESSURE]))
            return NOTHING
        if supply is None:
            told[FARTHEST] = max(told[FARTHEST], farthest(flight, duration))
        fly(flight, law, now, slopes, columns, told, duration, place, way, supply, log)
        if supply is not None:
            state = int(now[STATE])
            if supply.lowest(flight, duration, pressure, state) < 0.0:
                return NO_PRESSURE
        if way < 0 and place == 0.0:
            struck(law[FACTOR], now, slopes, columns, slope, told, supply)
            return BLOW
        for j in range(len(ports[WAY])):
            passed = way != 0 and ports[WAY][j] == way and ports[EDGE][j] == place
            if passed and not demand(forces, ports, j, now, slopes, columns, told, supply, log):
                return TOO_MANY
    return NO_BLOW


def struck(factor: float, now: Rows, slopes: Rows, columns: int, slope: Rows, told: Rows, supply: Supply) -> None:
    """The rebound of a blow, and its derivatives."""
    count = int(now[COUNT])
    told[DURATION], told[SPEED] = now[TIME], -now[V]
    for k in range(columns):
        slope[0][k] = factor * slopes[BY_V][k]
        for i in range(count):
            slope[1 + i][k] = slopes[BY_ORDER + i][k] - slopes[BY_TIME][k]
        if supply is not None:
            slope[1 + count][k] = slopes[BY_PRESSURE][k]
    for i in range(count):
        now[DUE + 2 * i] -= now[TIME]
    now[V], now[X], now[TIME] = factor * now[V], 0.0, 0.0


# ---- Newton's method for the cycle

# rows of rebounds: what Newton's method works with, and the cycle's, then those of legs that were followed
NOW, NEXT, TRIAL, END, FIRST = range(5)
# matrices: derivatives of a leg, of all, a product, and the equations
ONE, ALL, PRODUCT, EQUATIONS = range(4)
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


class Tables(NamedTuple):
    """A piston, and what to work in.

    Parameters
    ----------
    forces, ports, law
        Of the piston: the force of each state at the wall; the rows of its ports; stiffness, drag and velocity factor.
    rows, slopes, matrices, tells, step
        To work in.
    """

    forces: Rows
    ports: Rows
    law: Rows
    rows: Rows
    slopes: Rows
    matrices: Rows
    tells: Rows
    step: Rows


def next_leg(now: Rows, started: bool, following: Rows, told: Rows, work: Tables, supply: Supply) -> int:
    """As `leg`, its derivatives at `ONE`."""
    slope = work.matrices[ONE]
    return leg(work.forces, work.ports, work.law, now, started, following, work.slopes, slope, told, supply, None)


def legs_of_cycle(begin: Rows, blows: int, work: Tables, supply: Supply) -> bool:
    """The flights of so many blows, when they lead to a rebound of the same kind: at `END`, and what they tell."""
    whole, single, now, following = work.tells[WHOLE], work.tells[SINGLE], work.rows[NOW], work.rows[END]
    columns, one, done, product = size_of(begin, supply), work.matrices[ONE], work.matrices[ALL], work.matrices[PRODUCT]
    copied(begin, now)
    for i in range(TOLD):
        whole[i] = 0.0
    whole[RISE] = -1.0
    for i in range(columns):
        for k in range(columns):
            done[i][k] = 1.0 if i == k else 0.0
    for _ in range(blows):
        if next_leg(now, False, following, single, work, supply) != BLOW:
            return False
        size, before = size_of(following, supply), size_of(now, supply)
        for i in range(size):
            for k in range(columns):
                product[i][k] = 0.0
                for m in range(before):
                    product[i][k] += one[i][m] * done[m][k]
        for i in range(size):
            for k in range(columns):
                done[i][k] = product[i][k]
        for name in (DURATION, WORK, SWITCHES, DROPPED):
            whole[name] += single[name]
        for name in (SPEED, FARTHEST, RISE):
            whole[name] = max(whole[name], single[name])
        copied(following, now)
    return alike(begin, following)


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


def newton_step(begin: Rows, work: Tables, supply: Supply) -> float:
    """The size of the next step of Newton's method, as a part of speed or period; infinite when there is none."""
    size, equations, end, whole = size_of(begin, supply), work.matrices[EQUATIONS], work.rows[END], work.tells[WHOLE]
    apart, greatest = 0.0, 0.0
    for i in range(size):
        place = place_of(i, begin)
        apart = max(apart, abs(end[place] - begin[place]) / scale_of(i, begin, whole))
        for k in range(size):
            equations[i][k] = (1.0 if i == k else 0.0) - work.matrices[ALL][i][k]
        equations[i][size] = end[place] - begin[place]
    if not solved(equations, size, work.step):
        return math.inf
    for i in range(size):
        greatest = max(greatest, abs(work.step[i]) / scale_of(i, begin, whole))
    return greatest if greatest > CLOSED or apart <= MEETS else math.inf


def scale_of(i: int, begin: Rows, whole: Rows) -> float:
    """What a number of a rebound is measured by: the speed, the period, or the pressure itself."""
    scale: float = whole[SPEED] if i == 0 else whole[DURATION] if i <= begin[COUNT] else begin[PRESSURE]
    return scale


def is_idle(begin: Rows, whole: Rows) -> bool:
    """Whether no demand was accepted, or the wall is only touched.

    A slower rebound passes some of the same ports, so that it changes nothing either: Newton's method leads to rest.
    """
    return not whole[SPEED] > 0.0 or (begin[COUNT] == 0.0 and whole[SWITCHES] == 0.0 and whole[DROPPED] == 0.0)


def strikes(forces: Rows, whole: Rows) -> bool:
    """Whether it does more than touch the wall, so that rounding makes a blow of a swing that ends there."""
    force = 0.0
    for k in range(len(forces)):
        force = max(force, abs(forces[k]))
    return bool(whole[SPEED] * whole[SPEED] > TOUCHES * force * whole[FARTHEST])


def cycle_near(begin: Rows, blows: int, shrinking: int, work: Tables, supply: Supply) -> bool:
    """Whether Newton's method leads from a rebound to a cycle: at `NEXT`, and told as a whole.

    After `shrinking` steps each must be shorter than the one before.
    """
    now, trial = work.rows[NEXT], work.rows[TRIAL]
    copied(begin, now)
    size = size_of(begin, supply)
    if not legs_of_cycle(now, blows, work, supply):
        return False
    before = math.inf
    for number in range(NEWTON_STEPS):
        if is_idle(now, work.tells[WHOLE]):
            return False
        far = newton_step(now, work, supply)
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
                place = place_of(i, now)
                trial[place] += part * work.step[i]
                allowed = allowed and trial[place] >= 0.0
            there = allowed and legs_of_cycle(trial, blows, work, supply)
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
    back, greatest, far, latest = 0, forces[0], 0.0, 0.0
    for k in range(len(forces)):
        back = k if forces[k] < forces[back] else back
        greatest = max(greatest, forces[k])
    for j in range(len(ports[WAY])):
        far = max(far, ports[EDGE][j]) if ports[WAY][j] != 0.0 else far
        latest = max(latest, ports[DELAY][j])
    difference = greatest - forces[back]
    most = 2.0 * difference * far + (difference * latest) * (difference * latest)
    lost = max(0.05, 1.0 - law[FACTOR] * law[FACTOR])
    for i in range(len(row)):
        row[i] = 0.0
    row[V], row[STATE], row[LAST] = -law[FACTOR] * math.sqrt(most / lost) * part, float(back), float(back)


def settle(forces: Rows, law: Rows, now: Rows, greatest: float, supply: Supply) -> float:
    """Lay down a rebound that is too slow, at a wall to which the valve pushes; the greatest speed."""
    greatest, speed = max(greatest, now[V]), now[V]
    if speed < CHATTER * greatest:
        now[V] = 0.0
        if not flight_of(forces, law, now, supply).push < 0.0:
            now[V] = speed
    return greatest


def followed(most: int, work: Tables, supply: Supply) -> tuple[int, int]:
    """Fly from the rebound at `NOW` until nothing follows, or so many legs; their number, and how the last one ends.

    The rebounds are in the rows from `FIRST` on, and what the legs tell, too.
    """
    now, greatest, ending, number = work.rows[NOW], 0.0, BLOW, 0
    while number < most and ending == BLOW:
        row = work.rows[FIRST + number]
        ending = next_leg(now, False, row, work.tells[FIRST + number], work, supply)
        copied(row, now)
        number += 1
        greatest = settle(work.forces, work.law, now, greatest, supply)
    return number, ending


def cycle_at(tried: int, rebounds: int, work: Tables, supply: Supply) -> int:
    """Blows of the cycle that one of the rebounds is near, with few of them rather than many; 0 without one.

    The first ones were tried before.
    """
    rows, whole = work.rows, work.tells[WHOLE]
    for i in range(tried, min(rebounds, TRIES)):
        if cycle_near(rows[FIRST + i], 1, SHRINKING, work, supply) and whole[SWITCHES] > 0.0:
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
            if cycle_near(now, blows, SHRINKING, work, supply) and whole[SWITCHES] > 0.0:
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


def settled(work: Tables, supply: Supply) -> tuple[int, int, float]:
    """What a piston does; blows in its cycle, 0 for none, which is then at `NEXT`; the part of the start that told."""
    why, legs, first = UNKNOWN, 0, 1.0
    for part, most, tried in SETTLED_AT:
        fast(work.forces, work.ports, work.law, part, work.rows[NOW])
        number, ending = followed(most, work, supply)
        if ending == TOO_MANY:
            return UNKNOWN, 0, part
        if legs <= FEW:
            why, legs, first = why_none(number, ending, work.tells), number, part
        rebounds = number if ending == BLOW else number - 1
        blows = cycle_at(tried, rebounds, work, supply)
        if blows == 1:
            return RUNS, 1, part
        if blows > 1:
            return OVERTAKEN if work.tells[WHOLE][DROPPED] > 0.0 else DOUBLE, blows, part
    return why, 0, first


def contracts(size: int, work: Tables) -> bool:
    """Whether many returns shrink every disturbance of a cycle, whose derivatives are in `ALL`."""
    power, squared, whole = work.matrices[ONE], work.matrices[PRODUCT], work.tells[WHOLE]
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


def starts(first: float, attracts: bool, work: Tables) -> bool:
    """Whether a piston keeps going that starts at rest on the wall in a state; `attracts`: its cycle, at `NEXT`."""
    now, following, greatest = work.rows[NOW], work.rows[END], 0.0
    for i in range(len(now)):
        now[i] = 0.0
    now[STATE], now[LAST] = first, first
    for number in range(STARTED_BLOWS):
        if next_leg(now, number == 0, following, work.tells[SINGLE], work, None) != BLOW:
            return False
        if attracts and arrived(following, work.rows[NEXT], work.tells[WHOLE][DURATION]):
            return True
        copied(following, now)
        greatest = settle(work.forces, work.law, now, greatest, None)
    return True
