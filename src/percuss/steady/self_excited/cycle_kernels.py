"""The cycles of many rigid pistons under their valves, compiled: what `settled_cycle` and `rigid_cycle` find of one."""

from __future__ import annotations

import math

from percuss.compiled import entry, inner

# ---- The flight of a rigid piston, compiled: plain functions of numbers, as
# `percuss.steady.self_excited.piston_flight`
#
# `push`, `stiffness`, `drag`, `x`, `v` are those of a `Flight`.

# rows of the ports: the place of each, its direction (0: the blow demands), its state, and its delay
EDGE, WAY, DEMANDED, DELAY = range(4)

SMALL, TERMS, PIECES = 0.5, 18, 3  # as in piston_flight
STEPS = 200
EPS = 2.0**-52


@inner
def response(t, stiffness, drag):
    """s′, s and q at the time t."""
    if stiffness == 0.0 and drag == 0.0:
        return 1.0, t, 0.5 * t * t
    doublings = 0
    while stiffness * t * t > SMALL or drag * t > SMALL:
        t *= 0.5
        doublings += 1
    z, b = stiffness * t * t, drag * t
    before, now = 0.0, 1.0
    ds, s, q = 1.0, 1.0, 0.5
    for n in range(1, TERMS):
        before, now = now, -(b * n * now + z * before) / (n * (n + 1))
        ds += (n + 1) * now
        s += now
        q += now / (n + 2)
    s, q = s * t, q * t * t
    for _ in range(doublings):
        ds, s, q = ds * ds - stiffness * s * s, s * (1.0 - stiffness * q + ds), 2.0 * q + s * s - stiffness * q * q
    return ds, s, q


@inner
def at(push, stiffness, drag, x, v, t):
    """Distance and velocity at a time."""
    ds, s, q = response(t, stiffness, drag)
    force = push - stiffness * x
    return x + v * s + force * q, v * ds + force * s


@inner
def speed_at(push, stiffness, x, v, place, way):
    """Velocity at a place that is passed this way without drag."""
    return way * math.sqrt(max(0.0, v * v + (place - x) * (2.0 * push - stiffness * (place + x))))


@inner
def turning_time(push, stiffness, drag, x, v):
    """When the velocity first is 0 after the start; infinite when it never is."""
    force, square = push - stiffness * x, stiffness - 0.25 * drag * drag
    below = 0.5 * v * drag - force
    if square > 0.0:
        rate = math.sqrt(square)
        if v == 0.0:
            return math.pi / rate if force != 0.0 else math.inf
        return math.atan2(abs(v) * rate, below if v > 0.0 else -below) / rate  # no π is added: it would cancel
    if v == 0.0 or below == 0.0 or v / below < 0.0:
        return math.inf
    ratio, rate = v / below, math.sqrt(-square)
    if rate == 0.0:
        return ratio
    return math.atanh(rate * ratio) / rate if rate * ratio < 1.0 else math.inf


@inner
def turning_step(stiffness, drag):
    """The time between two turning points."""
    square = stiffness - 0.25 * drag * drag
    return math.pi / math.sqrt(square) if square > 0.0 else math.inf


@inner
def last_place(push, stiffness, drag, x, v):
    """Where it goes to in the end, when it does not oscillate for ever."""
    if stiffness > 0.0:
        return push / stiffness
    if push != 0.0:
        return math.copysign(math.inf, push)
    if drag > 0.0:
        return x + v / drag
    return x if v == 0.0 else math.copysign(math.inf, v)


@inner
def farthest(push, stiffness, drag, x, v, duration):
    """The greatest distance from the wall before the end of a flight."""
    found, time, step = x, turning_time(push, stiffness, drag, x, v), turning_step(stiffness, drag)
    for _ in range(PIECES):
        if not time < duration:
            break
        found = max(found, at(push, stiffness, drag, x, v, time)[0])
        time += step
    return found


@inner
def nearest_place(ports, here, last, way):
    """The first of the wall and the ports on the way to a place, NaN when there is none."""
    found, least = math.nan, way * (last - here)
    if way < 0 and 0.0 < here < least:
        found, least = 0.0, here
    for j in range(ports.shape[1]):
        if ports[WAY, j] == way:
            ahead = way * (ports[EDGE, j] - here)
            if 0.0 < ahead < least:
                found, least = ports[EDGE, j], ahead
    return found


@inner
def first_crossing(push, stiffness, drag, x, v, ports, until):
    """Time, place and direction of the first passage of the wall or of a port; direction 0 when there is none."""
    start, end = 0.0, turning_time(push, stiffness, drag, x, v)
    step, here = turning_step(stiffness, drag), x
    for number in range(PIECES):
        stop = min(end, until)
        last = at(push, stiffness, drag, x, v, stop)[0] if stop < math.inf else last_place(push, stiffness, drag, x, v)
        way = 1 if last > here else -1
        place = nearest_place(ports, here, last, way)
        if not math.isnan(place):
            return time_at(push, stiffness, drag, x, v, place, way, number, start, stop), place, way
        if end >= until:
            break
        start, end, here = end, end + step, last
    return 0.0, 0.0, 0


@inner
def time_at(push, stiffness, drag, x, v, place, way, number, start, stop):
    """When a place is passed between two turning points."""
    if stiffness == 0.0 and drag == 0.0:
        speed = way * math.sqrt(max(0.0, v * v + 2.0 * push * (place - x)))
        return 2.0 * (place - x) / (v + speed) if number == 0 else (speed - v) / push
    if stop == math.inf:
        begins, going = at(push, stiffness, drag, x, v, start)
        far, force = abs(place - begins), abs(push - stiffness * begins)
        step = min(far / abs(going) if going != 0.0 else math.inf, math.sqrt(far / force) if force else math.inf)
        stop = start + step
        while way * (at(push, stiffness, drag, x, v, stop)[0] - place) <= 0.0:
            step *= 2.0
            stop = start + step
    if way * (at(push, stiffness, drag, x, v, stop)[0] - place) <= 0.0:
        return stop
    low, high, t = start, stop, 0.5 * (start + stop)
    for _ in range(STEPS):
        now, speed = at(push, stiffness, drag, x, v, t)
        beyond = way * (now - place)
        if beyond == 0.0:
            return t
        if beyond < 0.0:
            low = t
        else:
            high = t
        following = t - beyond / (way * speed) if way * speed > 0.0 else low
        if not low < following < high:
            following = 0.5 * (low + high)
        if abs(following - t) <= 2.0 * EPS * t or not low < following < high:
            return following
        t = following
    return t


# ---- A rigid piston under its valve from blow to blow, compiled, as `percuss.steady.self_excited.piston_legs`
#
# A piston on its way is one row: velocity away from the wall, state, last demand, number of pending orders, distance
# from the wall, time, and of each order when it is due and to which state. Just after a blow place and time are 0.

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


# ---- Newton's method for the cycle of a rigid piston under its valve, compiled: what `rigid_cycle` does

MOST_BLOWS = 80  # that are followed, as in settled_cycle

# rows of rebounds: those of the legs that were followed, then what Newton's method works with, and the cycle's
NOW, NEXT, TRIAL, END = range(MOST_BLOWS, MOST_BLOWS + 4)
ROWS = MOST_BLOWS + 4
# matrices: derivatives of a leg, of all, a product, and the equations
ONE, ALL, PRODUCT, EQUATIONS = range(4)
MATRICES = 4
# rows of what legs tell: those that were followed, one leg, and all of a cycle
SINGLE, WHOLE = range(MOST_BLOWS, MOST_BLOWS + 2)
TELLING = MOST_BLOWS + 2

NEWTON_STEPS, SHRINKING, NEWTON_SHRUNK, HALVINGS, CLOSED, MEETS = 40, 16, 0.9, 6, 1e-13, 1e-9  # as in rigid_cycle
TOUCHES = 1e-12


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
    """The size of the next step of Newton's method, as a part of speed or period; infinite when there is none."""
    size, equations, end = 1 + int(begin[COUNT]), matrices[EQUATIONS], rows[END]
    apart = 0.0
    for i in range(size):
        place = V if i == 0 else DUE + i - 1
        apart = max(apart, abs(end[place] - begin[place]) / tells[WHOLE, SPEED if i == 0 else DURATION])
        for k in range(size):
            equations[i, k] = (1.0 if i == k else 0.0) - matrices[ALL, i, k]
        equations[i, size] = end[place] - begin[place]
    if not solved(equations, size, step):
        return math.inf
    greatest = 0.0
    for i in range(size):
        greatest = max(greatest, abs(step[i]) / tells[WHOLE, SPEED if i == 0 else DURATION])
    return greatest if greatest > CLOSED or apart <= MEETS else math.inf


@inner
def is_idle(begin, tells):
    """Whether no demand was accepted, or the wall is only touched.

    A slower rebound passes some of the same ports, so that it changes nothing either: Newton's method leads to rest.
    """
    if not tells[WHOLE, SPEED] > 0.0:
        return True
    return begin[COUNT] == 0.0 and tells[WHOLE, SWITCHES] == 0.0 and tells[WHOLE, DROPPED] == 0.0


@inner
def strikes(forces, whole):
    """Whether it does more than touch the wall, so that rounding makes a blow of a swing that ends there."""
    force = 0.0
    for k in range(forces.size):
        force = max(force, abs(forces[k]))
    return whole[SPEED] * whole[SPEED] > TOUCHES * force * whole[FARTHEST]


@inner
def cycle_near(forces, ports, law, begin, blows, rows, slopes, matrices, tells, step):
    """Whether Newton's method leads from a rebound to a cycle with a switch: at `NEXT`, and told as a whole."""
    now, trial = rows[NEXT], rows[TRIAL]
    copied(begin, now)
    size = 1 + int(begin[COUNT])
    if not legs_of_cycle(forces, ports, law, now, blows, rows, slopes, matrices, tells):
        return False
    before = math.inf
    for number in range(NEWTON_STEPS):
        if is_idle(now, tells):
            return False
        far = newton_step(now, rows, matrices, tells, step)
        if far <= CLOSED:
            return strikes(forces, tells[WHOLE])
        if far == math.inf or (number >= SHRINKING and far > NEWTON_SHRUNK * before):
            return False
        before = far
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


# ---- The cycles of many rigid pistons under their valves, compiled: what `settled_cycle` and `rigid_cycle` find of one

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
