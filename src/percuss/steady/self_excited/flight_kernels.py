"""The flight of a rigid piston, compiled: plain functions of numbers, as `percuss.steady.self_excited.piston_flight`.

`push`, `stiffness`, `drag`, `x`, `v` are those of a `Flight`.
"""

import math

from percuss.compiled import inner

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
