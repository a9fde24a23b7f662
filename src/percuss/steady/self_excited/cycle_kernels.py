"""The cycles of many rigid pistons under their valves, compiled: what `settled_cycle` and `rigid_cycle` find of one."""

import math

from percuss.compiled import entry, inner
from percuss.steady.self_excited.flight_kernels import DELAY, EDGE, WAY
from percuss.steady.self_excited.leg_kernels import (
    BLOW,
    COUNT,
    DROPPED,
    DUE,
    DURATION,
    FACTOR,
    LAST,
    NOTHING,
    ON_THE_WALL,
    SPEED,
    STATE,
    SWITCHES,
    TOO_MANY,
    UNCOVERED,
    V,
    copied,
    leg,
)
from percuss.steady.self_excited.newton_kernels import (
    ALL,
    END,
    MOST_BLOWS,
    NEXT,
    NOW,
    ONE,
    PRODUCT,
    SINGLE,
    WHOLE,
    alike,
    cycle_near,
)

# as in settled_cycle
FEW, MOST_IN_CYCLE, TRIES, TRIES_IN_CYCLE, LATELY = 4, 8, 12, 3, 12
ALIKE, CHATTER = 0.1, 1e-10
STARTED_BLOWS = 6 * MOST_BLOWS
SQUARINGS, SHRUNK = 6, 0.1
ARRIVED = 1e-9  # of the speed and of the period: it will not leave a cycle that attracts any more

RUNS, STAYS, NO_PORT, BLOWLESS, DOUBLE, OVERTAKEN, IRREGULAR, UNKNOWN = range(8)
"""What a piston does; the last: no answer."""

SETTLED_AT = ((1.0, FEW), (1.0, MOST_BLOWS), (0.5, MOST_BLOWS), (0.25, MOST_BLOWS), (2.0, MOST_BLOWS))


@inner
def fast(forces, ports, law, part, row):
    """A rebound at a part of the speed that the valve could give at most, in the state that pulls most."""
    back, greatest, far, latest = 0, forces[0], 0.0, 0.0
    for k in range(forces.size):
        back = k if forces[k] < forces[back] else back
        greatest = max(greatest, forces[k])
    for j in range(ports.shape[1]):
        far = max(far, ports[EDGE, j]) if ports[WAY, j] != 0.0 else far
        latest = max(latest, ports[DELAY, j])
    difference = greatest - forces[back]
    most = 2.0 * difference * far + (difference * latest) ** 2
    lost = max(0.05, 1.0 - law[FACTOR] * law[FACTOR])
    row[:] = 0.0
    row[V], row[STATE], row[LAST] = -law[FACTOR] * math.sqrt(most / lost) * part, float(back), float(back)


@inner
def followed(forces, ports, law, most, rows, slopes, matrices, tells):
    """Fly from the rebound at `NOW` until nothing follows, or so many legs; their number, and how the last one ends.

    The rebounds are in the first rows, and what the legs tell, too.
    """
    now, greatest, ending, number = rows[NOW], 0.0, BLOW, 0
    while number < most and ending == BLOW:
        ending = leg(forces, ports, law, now, False, rows[number], slopes, matrices[ONE], tells[number])
        copied(rows[number], now)
        number += 1
        greatest = max(greatest, now[V])
        if now[V] < CHATTER * greatest and forces[int(now[STATE])] > 0.0:
            now[V] = 0.0
    return number, ending


@inner
def cycle_at(forces, ports, law, rebounds, rows, slopes, matrices, tells, step):
    """Blows of the cycle that one of the rebounds is near, with few of them rather than many; 0 without one."""
    for i in range(min(rebounds, TRIES)):
        if cycle_near(forces, ports, law, rows[i], 1, rows, slopes, matrices, tells, step):
            return 1
    for blows in range(1, MOST_IN_CYCLE + 1):
        tries = 0
        for i in range(rebounds - 1, max(blows, rebounds - TRIES + 1) - 1, -1):
            now, before = rows[i], rows[i - blows]
            if not alike(now, before) or abs(now[V] - before[V]) > ALIKE * max(now[V], before[V]):
                continue
            tries += 1
            if tries > TRIES_IN_CYCLE:
                break
            if cycle_near(forces, ports, law, now, blows, rows, slopes, matrices, tells, step):
                return blows
    return 0


@inner
def why_none(legs, ending, tells):
    """What the last flights of a piston without a cycle tell of it."""
    if ending == ON_THE_WALL:
        return STAYS
    if ending == NOTHING:
        return BLOWLESS if tells[legs - 1, UNCOVERED] > 0.0 else NO_PORT
    if ending != BLOW:
        return UNKNOWN if ending == TOO_MANY else BLOWLESS
    for i in range(max(0, legs - LATELY), legs):
        if tells[i, SWITCHES] == 0.0:
            return DOUBLE
    return IRREGULAR


@inner
def settled(forces, ports, law, rows, slopes, matrices, tells, step):
    """What a piston does; of one that runs the cycle is at `NEXT`, and told as a whole."""
    why, legs = UNKNOWN, 0
    for part, most in SETTLED_AT:
        fast(forces, ports, law, part, rows[NOW])
        number, ending = followed(forces, ports, law, most, rows, slopes, matrices, tells)
        if ending == TOO_MANY:
            return UNKNOWN
        if legs <= FEW:
            why, legs = why_none(number, ending, tells), number
        rebounds = number if ending == BLOW else number - 1
        blows = cycle_at(forces, ports, law, rebounds, rows, slopes, matrices, tells, step)
        if blows == 1:
            return RUNS
        if blows > 1:
            return OVERTAKEN if tells[WHOLE, DROPPED] > 0.0 else DOUBLE
    return why


@inner
def contracts(size, matrices, speed, period):
    """Whether many returns shrink every disturbance of a cycle, whose derivatives are in `ALL`."""
    power, squared = matrices[ONE], matrices[PRODUCT]
    for i in range(size):
        for k in range(size):
            scale = speed / period if i > 0 and k == 0 else period / speed if i == 0 and k > 0 else 1.0
            power[i, k] = matrices[ALL, i, k] * scale
    for _ in range(SQUARINGS):
        for i in range(size):
            for k in range(size):
                squared[i, k] = 0.0
                for m in range(size):
                    squared[i, k] += power[i, m] * power[m, k]
        for i in range(size):
            for k in range(size):
                power[i, k] = squared[i, k]
    for i in range(size):
        for k in range(size):
            if not abs(power[i, k]) < SHRUNK:
                return False
    return True


@inner
def arrived(now, cycle, period):
    """Whether a rebound is that of a cycle."""
    close = alike(now, cycle) and abs(now[V] - cycle[V]) <= ARRIVED * cycle[V]
    for i in range(int(cycle[COUNT])):
        close = close and abs(now[DUE + i] - cycle[DUE + i]) <= ARRIVED * period
    return close


@inner
def starts(forces, ports, law, first, attracts, rows, slopes, matrices, tells):
    """Whether a piston keeps going that starts at rest on the wall in a state; `attracts`: its cycle, at `NEXT`."""
    now, following, greatest = rows[NOW], rows[END], 0.0
    now[:] = 0.0
    now[STATE], now[LAST] = first, first
    for number in range(STARTED_BLOWS):
        if leg(forces, ports, law, now, number == 0, following, slopes, matrices[ONE], tells[SINGLE]) != BLOW:
            return False
        if attracts and arrived(following, rows[NEXT], tells[WHOLE, DURATION]):
            return True
        copied(following, now)
        greatest = max(greatest, now[V])
        if now[V] < CHATTER * greatest and forces[int(now[STATE])] > 0.0:
            now[V] = 0.0
    return True


@entry
def cycles_of(
    forces, ports, laws, first, starting, rows, slopes, matrices, tells, step, does, told, derivatives, begun
):
    """What each piston does, `does`; of one that runs what its cycle tells, and the derivatives of its return map.

    Parameters
    ----------
    forces, ports, laws, first
        Of each piston: the force of each state at the wall, shape (cells, states); the rows of its ports; stiffness,
        drag and velocity factor; the state at the start.
    starting
        Whether to look if it starts from rest: `begun`.
    rows, slopes, matrices, tells, step
        To work in.
    """
    for i in range(does.size):
        does[i] = settled(forces[i], ports[i], laws[i], rows, slopes, matrices, tells, step)
        if does[i] == RUNS:
            copied(tells[WHOLE], told[i])
            size = 1 + int(rows[NEXT, COUNT])
            for k in range(size):
                for m in range(size):
                    derivatives[i, k, m] = matrices[ALL, k, m]
        if starting and does[i] in (RUNS, DOUBLE, OVERTAKEN):
            attracts = does[i] == RUNS and contracts(
                1 + int(rows[NEXT, COUNT]), matrices, tells[WHOLE, SPEED], tells[WHOLE, DURATION]
            )
            begun[i] = starts(forces[i], ports[i], laws[i], first[i], attracts, rows, slopes, matrices, tells)
