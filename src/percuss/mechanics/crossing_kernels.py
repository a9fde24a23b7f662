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

EPS = 2.0**-52
CELLS = 32
NARROWEST = 1e-13  # of the flight: narrower cells are not split
MOST_WORK = 20_000_000  # coordinates × times
BENT = 0.1  # of the acceleration: what the third derivative adds to it until a short rebound turns
TOUCH = 1e-11  # of the levels: an edge met this nearly at the end of the flight is met there
MOST_HALVINGS = 200  # each leaves at most half, or Newton's method converges


@inner
def sighted(table, force, ramp, t, h, sight):
    """How far the coordinates have moved, two derivatives, and a bound of the third within h."""
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
        turned = abs(square * rate + drag * bend - climb)
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
    sighted(table, force, ramp, t, 0.0, sight)
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
    sighted(table, force, ramp, 0.0, 0.0, sight)
    first, second = seen(edges, k, sight, RATE) - edges[k, table.shape[1] + 1], seen(edges, k, sight, BEND)
    if off != 0.0 or not first < 0.0 or not second > 0.0:
        return math.inf
    turned = -first / second
    sighted(table, force, ramp, 0.0, 3.0 * turned, sight)
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
def entered(table, force, ramp, span, scale, edges, known, sight, waiting):
    """The first time at which an edge is passed, infinite for none, which one, and whether this is proved."""
    # `known` (k, 4), `sight` (n, 4) and `waiting` (100, 2) are room to work in. Cells of time are looked at from the
    # earliest on, and halved where nothing is proved of them.
    n, size, best, which, work, proven = table.shape[1], edges.shape[0], math.inf, -1, 0, True
    touch = TOUCH * scale
    slow = touch / span
    offs(table, edges, touch, known)
    for k in range(size):
        known[k, LAST] = math.nan
        known[k, BOUNCE] = bounced(table, force, ramp, edges, known[k, OFF], k, span, sight)
        if known[k, BOUNCE] < best:
            best, which = known[k, BOUNCE], k
    for number in range(CELLS):
        waiting[0, 0], waiting[0, 1], depth = span / CELLS * number, span / CELLS, 1
        while depth > 0:
            depth -= 1
            left, h = waiting[depth, 0], waiting[depth, 1]
            if left >= best:
                continue
            work += n
            if h < NARROWEST * span or work > MOST_WORK:
                proven = False
                continue
            sighted(table, force, ramp, left, h, sight)
            is_open = False
            for k in range(size):
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
            for k in range(size):
                if known[k, BOUNCE] < math.inf or math.isnan(known[k, LAST]):
                    continue
                r, known[k, LAST] = known[k, LAST], math.nan
                stop = min(left + h, span)
                over = touch if stop >= span * (1.0 - 1e-12) else 0.0
                if r < 0.0 and left < best:
                    r, _ = distance(table, force, ramp, edges, known[k, OFF], k, stop, sight)
                    time = root(table, force, ramp, edges, known[k, OFF], k, left, stop, sight) if r > over else best
                    if time < best:
                        best, which = time, k
            if is_open:
                waiting[depth, 0], waiting[depth, 1] = left + 0.5 * h, 0.5 * h
                waiting[depth + 1, 0], waiting[depth + 1, 1] = left, 0.5 * h
                depth += 2
    return best, which, proven


TURN_STEPS = 4  # of Newton's method to where a place turns


@inner
def turned_at(table, force, ramp, edges, k, low, high, share, sight):
    """Where r turns between two times: a share of the way from the first, then Newton's method."""
    t, drift = low + (high - low) * share, edges[k, table.shape[1] + 1]
    for _ in range(TURN_STEPS):
        sighted(table, force, ramp, t, 0.0, sight)
        t -= (seen(edges, k, sight, RATE) - drift) / seen(edges, k, sight, BEND)
        t = min(max(t, low), high)
    return t


@inner
def rose(known, k, low, high):
    """Of a stretch on which r only rises or falls: how far it is from passing 0 on it, if that is the least."""
    if high > low:
        known[k, LEAST] = min(known[k, LEAST], max(low, -high))


@entry
def cleared(table, force, ramp, span, edges, met, known, sight, waiting):
    """How far each edge is from being passed in a flight, into its last column; that of the number `met` ends it."""
    # Room to work in as of `entered`. Cells are halved until r turns at most once in each.
    n = table.shape[1]
    for k in range(edges.shape[0]):
        drift, off = edges[k, n + 1], -edges[k, n]
        for m in range(n):
            off += edges[k, m] * table[PLACE, m]
        known[k, LEAST], known[k, LAST], work = math.inf, off, 0
        for number in range(CELLS):
            waiting[0, 0], waiting[0, 1], depth = span / CELLS * number, span / CELLS, 1
            while depth > 0:
                depth -= 1
                left, h = waiting[depth, 0], waiting[depth, 1]
                sighted(table, force, ramp, left, h, sight)
                first, second = seen(edges, k, sight, RATE) - drift, seen(edges, k, sight, BEND)
                third = seen(edges, k, sight, TURNED)
                r, most = off + seen(edges, k, sight, MOVED) - drift * left, (abs(second) + third * h) * h
                if abs(first) > most or (abs(first) + most) * h <= EPS * abs(r):  # it only rises or falls, or is still
                    continue
                work += n
                if abs(second) < third * h and h > NARROWEST * span and work <= MOST_WORK:
                    waiting[depth, 0], waiting[depth, 1] = left + 0.5 * h, 0.5 * h
                    waiting[depth + 1, 0], waiting[depth + 1, 1] = left, 0.5 * h
                    depth += 2
                    continue
                _, rate = distance(table, force, ramp, edges, off, k, left + h, sight)
                if first * rate < 0.0:
                    t = turned_at(table, force, ramp, edges, k, left, left + h, first / (first - rate), sight)
                    r, _ = distance(table, force, ramp, edges, off, k, t, sight)
                    rose(known, k, known[k, LAST], r)
                    known[k, LAST] = r
        r, _ = distance(table, force, ramp, edges, off, k, span, sight)
        if k != met:
            rose(known, k, known[k, LAST], r)


@entry
def highest(table, force, ramp, span, edges, sight, waiting):
    """The greatest r of the first edge in a flight: cells that cannot hold it are dropped."""
    n, off = table.shape[1], -edges[0, table.shape[1]]
    for m in range(n):
        off += edges[0, m] * table[PLACE, m]
    best = max(off, distance(table, force, ramp, edges, off, 0, span, sight)[0])
    for number in range(CELLS):
        waiting[0, 0], waiting[0, 1], depth = span / CELLS * number, span / CELLS, 1
        while depth > 0:
            depth -= 1
            left, h = waiting[depth, 0], waiting[depth, 1]
            sighted(table, force, ramp, left, h, sight)
            r = off + seen(edges, 0, sight, MOVED) - edges[0, n + 1] * left
            first, second = seen(edges, 0, sight, RATE) - edges[0, n + 1], seen(edges, 0, sight, BEND)
            third, bend = seen(edges, 0, sight, TURNED), 0.5 * h * h
            best = max(best, r)
            most = r + max(first, 0.0) * h + max(second, 0.0) * bend + third * (h * h * h / 6.0)
            falls = first + max(second, 0.0) * h + third * bend < 0.0
            rises = -first + max(-second, 0.0) * h + third * bend < 0.0
            if falls or rises or not most > best + 1e-14 * abs(best):  # the edges of cells are looked at
                continue
            if second + third * h < 0.0:
                best = max(best, top(table, force, ramp, edges, off, left, min(left + h, span), sight))
            elif h > NARROWEST * span:
                waiting[depth, 0], waiting[depth, 1] = left + 0.5 * h, 0.5 * h
                waiting[depth + 1, 0], waiting[depth + 1, 1] = left, 0.5 * h
                depth += 2
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
