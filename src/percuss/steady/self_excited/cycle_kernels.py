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
    FARTHEST,
    LAST,
    NOTHING,
    NUMBERS,
    ON_THE_WALL,
    RISE,
    SPEED,
    STATE,
    SWITCHES,
    TO,
    TOO_MANY,
    UNCOVERED,
    WORK,
    V,
    copied,
    leg,
)

# as in settled_cycle and rigid_cycle
FEW, MOST_BLOWS, MOST_IN_CYCLE, TRIES, LATELY = 4, 80, 8, 12, 12
ALIKE, CHATTER, CLOSED = 0.1, 1e-10, 1e-13
STEPS, HALVINGS = 40, 6
STARTED_BLOWS = 6 * MOST_BLOWS
SQUARINGS, SHRUNK = 6, 0.1
ARRIVED = 1e-9  # of the speed and of the period: it will not leave a cycle that attracts any more

# rows of rebounds: those of the legs that were followed, then what Newton's method works with, and the cycle's
NOW, NEXT, TRIAL, END = range(MOST_BLOWS, MOST_BLOWS + 4)
ROWS = MOST_BLOWS + 4
# matrices: derivatives of a leg, of all, a product, and the equations
ONE, ALL, PRODUCT, EQUATIONS = range(4)
MATRICES = 4
# rows of what legs tell: those that were followed, one leg, and all of a cycle
SINGLE, WHOLE = range(MOST_BLOWS, MOST_BLOWS + 2)
TELLING = MOST_BLOWS + 2

RUNS, STAYS, NO_PORT, BLOWLESS, DOUBLE, OVERTAKEN, IRREGULAR, UNKNOWN = range(8)
"""What a piston does; the last: no answer."""

SETTLED_AT = ((1.0, FEW), (1.0, MOST_BLOWS), (0.5, MOST_BLOWS), (0.25, MOST_BLOWS), (2.0, MOST_BLOWS))


@inner
def legs_of_cycle(forces, ports, law, begin, blows, rows, slopes, matrices, tells):
    """The flights of so many blows, when they lead to a rebound of the same kind: at `END`, and what they tell."""
    whole, single, now, following = tells[WHOLE], tells[SINGLE], rows[NOW], rows[END]
    size, one, done, product = 1 + int(begin[COUNT]), matrices[ONE], matrices[ALL], matrices[PRODUCT]
    copied(begin, now)
    whole[:], whole[RISE] = 0.0, -1.0
    for i in range(NUMBERS):
        for k in range(NUMBERS):
            done[i, k] = 1.0 if i == k else 0.0
    for _ in range(blows):
        if leg(forces, ports, law, now, False, following, slopes, one, single) != BLOW:
            return False
        for i in range(1 + int(following[COUNT])):
            for k in range(size):
                product[i, k] = 0.0
                for m in range(1 + int(now[COUNT])):
                    product[i, k] += one[i, m] * done[m, k]
        for i in range(NUMBERS):
            copied(product[i], done[i])
        for name in (DURATION, WORK, SWITCHES, DROPPED):
            whole[name] += single[name]
        for name in (SPEED, FARTHEST, RISE):
            whole[name] = max(whole[name], single[name])
        copied(following, now)
    return alike(begin, following)


@inner
def alike(one, other):
    """Whether two rebounds differ by their numbers only."""
    same = one[STATE] == other[STATE] and one[LAST] == other[LAST] and one[COUNT] == other[COUNT]
    for i in range(int(one[COUNT])):
        same = same and one[TO + i] == other[TO + i]
    return same


@inner
def solved(equations, size, step):
    """Solve for the step, which is the last column, by elimination; False where that is not possible."""
    for i in range(size):
        pivot = i
        for k in range(i + 1, size):
            if abs(equations[k, i]) > abs(equations[pivot, i]):
                pivot = k
        if equations[pivot, i] == 0.0 or not math.isfinite(equations[pivot, i]):
            return False
        for k in range(size + 1):
            equations[i, k], equations[pivot, k] = equations[pivot, k], equations[i, k]
        for k in range(i + 1, size):
            ratio = equations[k, i] / equations[i, i]
            for m in range(i, size + 1):
                equations[k, m] -= ratio * equations[i, m]
    for i in range(size - 1, -1, -1):
        value = equations[i, size]
        for k in range(i + 1, size):
            value -= equations[i, k] * step[k]
        step[i] = value / equations[i, i]
        if not math.isfinite(step[i]):
            return False
    return True


@inner
def newton_step(begin, rows, matrices, tells, step):
    """The next step of Newton's method: 0 when there is none, 2 when it is nothing, else 1."""
    size, equations, end = 1 + int(begin[COUNT]), matrices[EQUATIONS], rows[END]
    for i in range(size):
        place = V if i == 0 else DUE + i - 1
        for k in range(size):
            equations[i, k] = (1.0 if i == k else 0.0) - matrices[ALL, i, k]
        equations[i, size] = end[place] - begin[place]
    if not solved(equations, size, step):
        return 0
    for i in range(size):
        if not abs(step[i]) <= CLOSED * tells[WHOLE, SPEED if i == 0 else DURATION]:
            return 1
    return 2


@inner
def is_idle(begin, tells):
    """Whether no demand was accepted.

    A slower rebound passes some of the same ports, so that it changes nothing either: Newton's method leads to rest.
    """
    return begin[COUNT] == 0.0 and tells[WHOLE, SWITCHES] == 0.0 and tells[WHOLE, DROPPED] == 0.0


@inner
def cycle_near(forces, ports, law, begin, blows, rows, slopes, matrices, tells, step):
    """Whether Newton's method leads from a rebound to a cycle with a switch: at `NEXT`, and told as a whole."""
    now, trial = rows[NEXT], rows[TRIAL]
    copied(begin, now)
    size = 1 + int(begin[COUNT])
    if not legs_of_cycle(forces, ports, law, now, blows, rows, slopes, matrices, tells):
        return False
    for _ in range(STEPS):
        if is_idle(now, tells):
            return False
        found = newton_step(now, rows, matrices, tells, step)
        if found != 1:
            return found == 2
        part, there = 1.0, False
        for _ in range(HALVINGS):
            copied(now, trial)
            allowed = True
            for i in range(size):
                place = V if i == 0 else DUE + i - 1
                trial[place] += part * step[i]
                allowed = allowed and trial[place] >= 0.0
            there = allowed and legs_of_cycle(forces, ports, law, trial, blows, rows, slopes, matrices, tells)
            if there:
                break
            part *= 0.5
        if not there:
            return False
        copied(trial, now)
    return False


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
        for i in range(rebounds - 1, max(blows, rebounds - TRIES + 1) - 1, -1):
            now, before = rows[i], rows[i - blows]
            if not alike(now, before) or abs(now[V] - before[V]) > ALIKE * max(now[V], before[V]):
                continue
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
