"""What a place of a body meets in a flight, compiled: `percuss.mechanics.crossing` says what and by which bounds.

A flight is a table of ω, damping, what the driven place moves by, displacement and velocity at its start of every
coordinate, (5, n). Edges are rows of what each coordinate moves a place by, with the level and the drift behind them,
(k, n + 2).
"""

from __future__ import annotations

import math

from percuss.compiled import entry, inner, twin
from percuss.mechanics import flow

response = twin(flow.response)

OMEGA, DAMPING, DRIVEN, PLACE, SPEED = range(5)
MOVED, RATE, BEND, TURNED = range(4)
OFF, BOUNCE, LAST, LEAST = range(4)
VAGUE, FIRST, TOLD = 1, 4, 5
ABOVE, BELOW, TURNS = 1.0, -1.0, 2.0

EPS = 2.0**-52
CELLS = 32
NARROWEST = 1e-13  # of the flight: narrower cells are not split
MOST_WORK = 20_000_000  # coordinates × times
BENT = 0.1  # of the acceleration: what the third derivative adds to it until a short rebound turns
TOUCH = 1e-11  # of the levels: an edge met this nearly at the end of the flight is met there
MOST_HALVINGS = 200  # each leaves at most half, or Newton's method converges


@inner
def sighted(table, force, ramp, t, sight):
    """How far the coordinates have moved, and two derivatives."""
    for m in range(table.shape[1]):
        omega, drag, driven, u, v = (
            table[OMEGA, m],
            table[DAMPING, m],
            table[DRIVEN, m],
            table[PLACE, m],
            table[SPEED, m],
        )
        square, climb = omega * omega, ramp * driven
        ds, s, q, w = response(t, square, drag)
        pull = driven * force - square * u
        moved, rate = v * s + pull * q + climb * w, v * ds + pull * s + climb * q
        bend = driven * (force + ramp * t) - square * (u + moved) - drag * rate
        sight[m, MOVED], sight[m, RATE], sight[m, BEND] = moved, rate, bend


@inner
def bounded(table, ramp, h, sight):
    """A bound of the third derivative within h of where the coordinates are sighted."""
    for m in range(table.shape[1]):
        omega, rate, bend = table[OMEGA, m], sight[m, RATE], sight[m, BEND]
        turned = abs(omega * omega * rate + table[DAMPING, m] * bend - ramp * table[DRIVEN, m])
        sight[m, TURNED] = turned + omega * min(omega * h, 1.0) * abs(bend)


@inner
def seen(edges, k, sight, part):
    """What an edge sees of the coordinates; of the bounds the sum."""
    total = 0.0
    for m in range(sight.shape[0]):
        total += abs(edges[k, m]) * sight[m, part] if part == TURNED else edges[k, m] * sight[m, part]
    return total


@inner
def distance(table, force, ramp, edges, off, k, t, sight):
    """r of an edge, beyond which it is entered, and its rate."""
    n = table.shape[1]
    sighted(table, force, ramp, t, sight)
    drift = edges[k, n + 1]
    return off + seen(edges, k, sight, MOVED) - drift * t, seen(edges, k, sight, RATE) - drift


@inner
def root(table, force, ramp, edges, off, k, start, stop, sight):
    """Where r rises through 0 between two times: Newton's method, halving where it would leave them."""
    t = 0.5 * (start + stop)
    for _ in range(MOST_HALVINGS):
        r, rate = distance(table, force, ramp, edges, off, k, t, sight)
        if r < 0.0:
            start = t
        else:
            stop = t
        step = t - r / rate if rate > 0.0 else start
        if abs(step - t) <= 4.0 * EPS * stop or stop - start <= 4.0 * EPS * stop:
            return t
        t = step if start < step < stop else 0.5 * (start + stop)
    return t


@inner
def bounced(table, force, ramp, edges, off, k, span, sight):
    """When what leaves an edge is back there, where the parabola from the start decides that; else infinite."""
    sighted(table, force, ramp, 0.0, sight)
    first, second = seen(edges, k, sight, RATE) - edges[k, table.shape[1] + 1], seen(edges, k, sight, BEND)
    if off != 0.0 or not first < 0.0 or not second > 0.0:
        return math.inf
    turned = -first / second
    bounded(table, ramp, 3.0 * turned, sight)
    if 3.0 * turned > span or seen(edges, k, sight, TURNED) * turned > BENT * second:
        return math.inf
    return root(table, force, ramp, edges, off, k, 1.5 * turned, 3.0 * turned, sight)


@inner
def offs(table, edges, touch, known):
    """r of every edge at the start: 0 of one that is left there."""
    n = table.shape[1]
    for k in range(edges.shape[0]):
        off, rate = -edges[k, n], 0.0
        for m in range(n):
            off += edges[k, m] * table[PLACE, m]
            rate += edges[k, m] * table[SPEED, m]
        known[k, OFF] = 0.0 if abs(off) <= touch and rate < edges[k, n + 1] else off


@entry
def entered(table, force, ramp, span, scale, edges, known, sight):
    """The first time at which an edge is passed, infinite for none, which one, and whether this is proved."""
    # `known` (k, 6) and `sight` (n, 4) are room to work in. Cells of time are looked at from the earliest on; one of
    # which nothing is proved is halved, and where that was not needed the next one is twice as wide.
    n, size, best, which, work, proven = table.shape[1], edges.shape[0], math.inf, -1, 0, True
    touch = TOUCH * scale
    slow = touch / span
    offs(table, edges, touch, known)
    for k in range(size):
        known[k, BOUNCE] = bounced(table, force, ramp, edges, known[k, OFF], k, span, sight)
        if known[k, BOUNCE] < best:
            best, which = known[k, BOUNCE], k
    left, h = 0.0, span / CELLS
    while span - left > 0.5 * NARROWEST * span and left < best:
        h, is_open, halved = min(h, span - left), False, False
        sighted(table, force, ramp, left, sight)
        while True:
            work += n
            bounded(table, ramp, h, sight)
            is_open = False
            for k in range(size):
                known[k, LAST] = math.nan
                if known[k, BOUNCE] < math.inf:
                    continue
                drift = edges[k, n + 1]
                r = known[k, OFF] + seen(edges, k, sight, MOVED) - drift * left
                first, second = seen(edges, k, sight, RATE) - drift, seen(edges, k, sight, BEND)
                third = seen(edges, k, sight, TURNED)
                if left == 0.0 and abs(r) <= touch and first >= -slow and second - third * h > 0.0:
                    return 0.0, k, True
                bend, more = 0.5 * h * h, third * (h * h * h / 6.0)
                falls = first + max(second, 0.0) * h + third * bend < 0.0
                below = r + max(first, 0.0) * h + max(second, 0.0) * bend + more < 0.0
                above = -r + max(-first, 0.0) * h + max(-second, 0.0) * bend + more < 0.0
                from_rest = r <= touch and first <= slow and second + third * h < 0.0
                if falls or below or above or from_rest:
                    continue
                if not -first + max(-second, 0.0) * h + third * bend < 0.0:
                    is_open = True
                    continue
                known[k, LAST] = r  # it only rises
            if not is_open or h < NARROWEST * span or work > MOST_WORK:
                break
            h, halved = 0.5 * h, True
        proven = proven and not is_open and work <= MOST_WORK
        if work > MOST_WORK:
            break
        stop = min(left + h, span)
        over = touch if stop >= span * (1.0 - 1e-12) else 0.0
        for k in range(size):
            if known[k, LAST] < 0.0 and left < best:
                r, _ = distance(table, force, ramp, edges, known[k, OFF], k, stop, sight)
                time = root(table, force, ramp, edges, known[k, OFF], k, left, stop, sight) if r > over else best
                if time < best:
                    best, which = time, k
        left += h
        h = h if halved else 2.0 * h
    return best, which, proven


TURN_STEPS = 4  # of Newton's method to where a place turns


@inner
def turned_at(table, force, ramp, edges, k, low, high, share, sight):
    """Where r turns between two times: a share of the way from the first, then Newton's method."""
    t, drift = low + (high - low) * share, edges[k, table.shape[1] + 1]
    for _ in range(TURN_STEPS):
        sighted(table, force, ramp, t, sight)
        t -= (seen(edges, k, sight, RATE) - drift) / seen(edges, k, sight, BEND)
        t = min(max(t, low), high)
    return t


@inner
def rose(known, k, r):
    """Notes that r has come to a turn or an end; False where how low it was before is not known well enough."""
    # Of a rise what it is from passing 0, if that is the least: max(low, −high).
    low = known[k, LAST]
    if known[k, VAGUE] != 0.0 and r > 0.0 and low > -r:
        return False
    if r > low:
        known[k, LEAST] = min(known[k, LEAST], max(low, -r))
    known[k, LAST], known[k, VAGUE] = r, 0.0
    return True


@inner
def sampled(table, force, ramp, span, edges, met, known, sight):
    """What the least of each edge is no greater than, by evenly spaced looks."""
    for k in range(edges.shape[0]):
        known[k, LAST], known[k, FIRST], known[k, LEAST] = math.inf, known[k, OFF], math.inf
    for j in range(1, CELLS + 2):
        t = max(span, 0.0) * min(j, CELLS) / CELLS
        sighted(table, force, ramp, t, sight)
        for k in range(edges.shape[0]):
            if k == met and j >= CELLS:
                continue
            here = known[k, FIRST]
            r = known[k, OFF] + seen(edges, k, sight, MOVED) - edges[k, table.shape[1] + 1] * t
            rise = r - here if j <= CELLS else -math.inf
            if (here - known[k, LAST]) * rise < 0.0 and here * rise >= 0.0:
                known[k, LEAST] = min(known[k, LEAST], abs(here))
            known[k, LAST], known[k, FIRST] = here, r


@inner
def turned_in(table, force, ramp, span, edges, met, known, sight, dropping):
    """All turns of r that may lessen the least of an edge; False where `dropping` the others left too little known."""
    n, size, left, h, work = table.shape[1], edges.shape[0], 0.0, span / CELLS, 0
    for k in range(size):
        known[k, LAST], known[k, VAGUE] = known[k, OFF], 0.0
    while span - left > 0.5 * NARROWEST * span:
        h, halved = min(h, span - left), False
        sighted(table, force, ramp, left, sight)
        while True:
            work += n
            bounded(table, ramp, h, sight)
            is_open = False
            for k in range(size):
                drift = edges[k, n + 1]
                r = known[k, OFF] + seen(edges, k, sight, MOVED) - drift * left
                first, second = seen(edges, k, sight, RATE) - drift, seen(edges, k, sight, BEND)
                third = seen(edges, k, sight, TURNED)
                bend, more, most = 0.5 * h * h, third * (h * h * h / 6.0), (abs(second) + third * h) * h
                known[k, FIRST], known[k, TOLD] = first, 0.0
                falls = first + max(second, 0.0) * h + third * bend < 0.0
                rises = -first + max(-second, 0.0) * h + third * bend < 0.0
                if falls or rises or (abs(first) + most) * h <= EPS * abs(r):  # it only rises or falls, or is still
                    continue
                if dropping:
                    least, last = max(known[k, LEAST], 0.0), known[k, LAST]
                    low = r + min(first, 0.0) * h + min(second, 0.0) * bend - more
                    high = r + max(first, 0.0) * h + max(second, 0.0) * bend + more
                    if low >= least and (last >= 0.0 or (known[k, VAGUE] == 0.0 and low >= -last)):
                        known[k, FIRST], known[k, TOLD] = r, ABOVE
                        continue
                    if -high >= least:
                        known[k, FIRST], known[k, TOLD] = high, BELOW
                        continue
                known[k, TOLD] = TURNS
                is_open = is_open or abs(second) < third * h
            if not is_open or h <= NARROWEST * span or work > MOST_WORK:
                break
            h, halved = 0.5 * h, True
        for k in range(size):
            first, told = known[k, FIRST], known[k, TOLD]
            if told == ABOVE:
                rose(known, k, first)
                known[k, LAST] = math.inf
            elif told == BELOW:
                known[k, LAST], known[k, VAGUE] = first, 1.0
            elif told == TURNS:
                _, rate = distance(table, force, ramp, edges, known[k, OFF], k, left + h, sight)
                if first * rate < 0.0:
                    t = turned_at(table, force, ramp, edges, k, left, left + h, first / (first - rate), sight)
                    r, _ = distance(table, force, ramp, edges, known[k, OFF], k, t, sight)
                    if not rose(known, k, r):
                        return False
        left += h
        h = h if halved else 2.0 * h
    for k in range(size):
        r, _ = distance(table, force, ramp, edges, known[k, OFF], k, span, sight)
        if k != met and not rose(known, k, r):
            return False
    return True


@entry
def cleared(table, force, ramp, span, edges, met, known, sight):
    """How far each edge is from being passed in a flight, into its column `LEAST`; that of the number `met` ends it."""
    # Room to work in, and cells, as of `entered`, down to those in which r turns at most once. Cells in which no turn
    # is nearer to 0 than the nearest known are dropped: but for how low a rise begins that passes 0 none is needed.
    offs(table, edges, -1.0, known)
    sampled(table, force, ramp, span, edges, met, known, sight)
    if not turned_in(table, force, ramp, span, edges, met, known, sight, True):
        turned_in(table, force, ramp, span, edges, met, known, sight, False)


@entry
def highest(table, force, ramp, span, edges, sight):
    """The greatest r of the first edge in a flight: cells that cannot hold it are dropped."""
    n, off = table.shape[1], -edges[0, table.shape[1]]
    for m in range(n):
        off += edges[0, m] * table[PLACE, m]
    best = max(off, distance(table, force, ramp, edges, off, 0, span, sight)[0])
    left, h = 0.0, span / CELLS
    while span - left > 0.5 * NARROWEST * span:
        h, halved = min(h, span - left), False
        sighted(table, force, ramp, left, sight)
        r = off + seen(edges, 0, sight, MOVED) - edges[0, n + 1] * left
        first, second = seen(edges, 0, sight, RATE) - edges[0, n + 1], seen(edges, 0, sight, BEND)
        best = max(best, r)  # the edges of cells are looked at
        while True:
            bounded(table, ramp, h, sight)
            third, bend = seen(edges, 0, sight, TURNED), 0.5 * h * h
            most = r + max(first, 0.0) * h + max(second, 0.0) * bend + third * (h * h * h / 6.0)
            falls = first + max(second, 0.0) * h + third * bend < 0.0
            rises = -first + max(-second, 0.0) * h + third * bend < 0.0
            if falls or rises or not most > best + 1e-14 * abs(best):
                break
            if second + third * h < 0.0:
                best = max(best, top(table, force, ramp, edges, off, left, min(left + h, span), sight))
                break
            if h <= NARROWEST * span:
                break
            h, halved = 0.5 * h, True
        left += h
        h = h if halved else 2.0 * h
    return best


@inner
def top(table, force, ramp, edges, off, low, high, sight):
    """The greatest r between two times between which it is bent down: Newton's method for the rate, or halving."""
    t, best = low, distance(table, force, ramp, edges, off, 0, high, sight)[0]
    for _ in range(MOST_HALVINGS):
        _, rate = distance(table, force, ramp, edges, off, 0, t, sight)
        if rate > 0.0:
            low = t
        else:
            high = t
        step = t - rate / seen(edges, 0, sight, BEND)
        following = step if low < step < high else 0.5 * (low + high)
        if abs(following - t) <= 4.0 * EPS * high:
            break
        t = following
    return max(best, distance(table, force, ramp, edges, off, 0, t, sight)[0])
