"""A machine whose oil flows, from event to event, compiled: Taylor steps of its equations with events as first roots.

The oil has no closed form: what an orifice takes grows with the square of the speed, gas is polytropic, an accumulator
empties. So every step is a power series of all coordinates and of the pressure, by recurrence, and a guard is a
polynomial of the step, whose first root is isolated by its Bernstein coefficients: nothing is looked for by samples.
Derivatives by the numbers at the start are carried along by the same series of the linearised equations, with a
saltation at each event. `percuss.mechanics.oil` makes the tables, and says what they hold.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from percuss.compiled import entry, inner

ORDER, ELASTIC_ORDER = 24, 40  # of the series, of a rigid piston, and with modes, which ask for short steps
ACCURACY = 1e-17  # what the last two terms may add, of the scales
ROOM = 48  # of the series that bound a step

# numbers of the law; the tables of the states hold a, t, b for v > 0, b for v < 0, then each chamber's part of the b's
FORCE, KAPPA, GAS, COLUMN, EXPONENT, FLOW, SLIP, POWER, LEAK, RELIEF, SLOPE, COMPLIANCE, VOLUME, PRECHARGE = range(14)
ATMOSPHERE, POLYTROPIC, TANK, SPOOL, FACTOR, STRAIN, FED, QUICKENING, SPEED, UNIT, CORNER, CORNER_TO = range(14, 26)
WAVE, LAW = 26, 27
AREA, TANKED, DRAG_OUT, DRAG_BACK, CHAMBERS = range(5)
OMEGA2, DAMPING, DRIVEN, END = range(4)
TO, LEVEL, SIDE, DELAY, OF_SPEED, ON_IMPACT, PORT = range(7)
BY_PLACE, BY_RATE, BY_PRESSURE = range(3)
# of the state of a motion
TIME, PRESSURE, SIGN, OPEN, FILLED, LIMITED, RESTING, LAST, COUNT, STROKE, STATE, BLOWS, HELD, WALL, TURNED = range(15)
AT_RELIEF, AT_CHARGE, AT_CORNER, AT_ZERO, ENDED, HOLD, NOW = range(15, 22)
CLOSED, OPENED, KEPT = 0.0, 1.0, 2.0
# of the sums
(PUMPED_ENERGY, LEAK_LOSS, RELIEF_LOSS, RETURN_LOSS, DRAG_LOSS, IMPACT_LOSS, PUMPED, LEAKED, RELIEVED, DRAWN, PRESSED,
 LEAST, GREATEST, FARTHEST, ORIFICES) = range(15)  # fmt: skip
# events, and how a call ends
IMPACT, PORT_MET, VALVE, REST, LEAVES, OPENS, CLOSES, EMPTIES, FILLS, LIMITS, FULL_FLOW, DRY = range(1, 13)
BY_TIME, BY_BLOWS, AT_SECTION, NO_PRESSURE, LOG_FULL, STEPS_FULL, AT_REST, NO_STEP, CROWDED, EMPTY_LINE = range(1, 11)
EVENT = 5  # time, kind, detail, pressure, number of the step that begins there; then the bar
STEP = 8  # time, length, pressure, sign, open, filled, limited, resting; then the blend and the bar

# rows of the series of a step
(U, V, P, F, W, A, Y, Z, C, S, N, Q, RISE, SPIN, POLY, BEND, GU, GV, PV, PP, DC, DF, DG, SOURCE, CUBE, SQUARE,
 ROWS) = range(27)  # fmt: skip


class OilLaw(NamedTuple):
    """What does not change: numbers, modes (4, n), what ports read (p, n), joins of the states and ports."""

    numbers: Any
    modes: Any
    reads: Any
    joins: Any
    ports: Any


class OilState(NamedTuple):
    """A motion on its way: numbers, bar (2, n), blend of the joins and its slope, orders (q, 2), port flags, sums.

    `bars`, (2 n + 1, D), `dues`, (q, D), `blends`, (2, 4, D), and `shift`, (D,) are its derivatives in D directions.
    """

    now: Any
    bar: Any
    blend: Any
    orders: Any
    touched: Any
    sums: Any
    bars: Any
    dues: Any
    blends: Any
    shift: Any


class OilWork(NamedTuple):
    """Room: series (ROWS, K + 2), of modes and rates (n, K + 2) each, polynomials, rates before and after an event.

    Of the derivatives: of the modes (K + 2, n, D) each, of the driven end and of the pressure (3, K + 2, D).
    """

    series: Any
    places: Any
    rates: Any
    stack: Any
    ends: Any
    before: Any
    after: Any
    times: Any
    moved: Any
    spun: Any
    turned: Any
    pushed: Any
    drawn: Any


class OilLog(NamedTuple):
    """Events, (m, EVENT + 2 n), steps, (k, STEP + 2 w + 2 n), and how many of each there are."""

    events: Any
    steps: Any
    filled: Any


# ---- Series


@inner
def product(a, b, k):
    """Coefficient k of the product of two series."""
    found = 0.0
    for j in range(k + 1):
        found += a[j] * b[k - j]
    return found


@inner
def power(z, y, exponent, k):
    """Coefficient k ≥ 1 of y = z^exponent, from those before."""
    found = 0.0
    for j in range(1, k + 1):
        found += (exponent * j - (k - j)) * z[j] * y[k - j]
    return found / (k * z[0])


@inner
def quotient(top, y, bottom, k):
    """Coefficient k of y = numerator/bottom, with coefficient `top` of the numerator."""
    found = top
    for j in range(1, k + 1):
        found -= bottom[j] * y[k - j]
    return found / bottom[0]


@inner
def value(c, t, order):
    """A polynomial at t."""
    found = c[order]
    for k in range(order - 1, -1, -1):
        found = found * t + c[k]
    return found


@inner
def integral(c, t, order):
    """∫ of a polynomial from 0 to t."""
    found = c[order] / (order + 1.0)
    for k in range(order - 1, -1, -1):
        found = found * t + c[k] / (k + 1.0)
    return found * t


@inner
def moment(c, t, order):
    """∫ of t times a polynomial from 0 to t."""
    found = c[order] / (order + 2.0)
    for k in range(order - 1, -1, -1):
        found = found * t + c[k] / (k + 2.0)
    return found * t * t


# ---- The first root of a polynomial on (0, 1]


@inner
def first_root(a, order, way, stack, ends):
    """The first root at which a polynomial rises (`way` 1), falls (−1) or does either (0); 2 where there is none."""
    rest = 0.0
    for j in range(1, order + 1):
        rest += abs(a[j])
    if abs(a[0]) > rest * (1.0 + 1e-12):
        return 2.0
    for i in range(order + 1):  # Bernstein coefficients Σ_j C(i, j)/C(order, j) a_j
        found, weight = 0.0, 1.0
        for j in range(i + 1):
            found += weight * a[j]
            weight *= (i - j) / (order - j) if j < order else 0.0
        stack[0, i] = found
    ends[0, 0], ends[0, 1] = 0.0, 1.0
    depth = 0
    while depth >= 0:
        lo, hi = ends[depth, 0], ends[depth, 1]
        row = stack[depth]
        changes, last = 0, 0.0
        for i in range(order + 1):
            if row[i] != 0.0:
                if row[i] * last < 0.0:
                    changes += 1
                last = row[i]
        if changes == 0 and not (row[order] == 0.0 and last != 0.0):
            depth -= 1
            continue
        if row[order] == 0.0 and changes == 0:
            if last * way <= 0.0 and lo < hi:
                return hi
            depth -= 1
            continue
        if (changes == 1 and row[0] * row[order] < 0.0) or hi - lo < 1e-13:
            depth -= 1
            if row[0] * row[order] >= 0.0 or row[0] * way > 0.0:
                continue
            return polished(a, order, lo, hi, row[0])
        if depth + 1 >= stack.shape[0]:
            depth -= 1
            continue
        middle = 0.5 * (lo + hi)
        upper = stack[depth + 1]  # the left half, looked at first
        for i in range(order + 1):
            upper[i] = row[0]
            for j in range(order - i):
                row[j] = 0.5 * (row[j] + row[j + 1])
        # `row` now holds the right half from its end on
        ends[depth, 0], ends[depth, 1] = middle, hi
        ends[depth + 1, 0], ends[depth + 1, 1] = lo, middle
        depth += 1
    return 2.0


@inner
def polished(a, order, lo, hi, low):
    """The root between two places of different signs: Newton's method within the bracket, else halving."""
    x = 0.5 * (lo + hi)
    for _ in range(200):
        y, slope = a[order], 0.0
        for k in range(order - 1, -1, -1):
            slope = slope * x + y
            y = y * x + a[k]
        if y == 0.0:
            return x
        if y * low > 0.0:
            lo = x
        else:
            hi = x
        new = x - y / slope if slope != 0.0 else lo
        if not lo < new < hi:
            new = 0.5 * (lo + hi)
        if new == x or hi - lo <= 2e-16 * hi:
            return new
        x = new
    return x


@inner
def met(c, level, h, way, dropped, work):
    """When a series of the step meets a level in a way, over h; the first `dropped` coefficients are 0."""
    poly, scale, order = work.series[POLY], 1.0, work.series.shape[1] - 2 - dropped
    for _ in range(dropped):
        scale *= h
    for k in range(order + 1):
        poly[k] = c[k + dropped] * scale
        scale *= h
    if dropped == 0:
        poly[0] -= level
    return first_root(poly, order, way, work.stack, work.ends)


# ---- The series of a step, and how long it may be


@inner
def of_gas(law, u):
    """Force of the gas behind the piston."""
    if law[GAS] == 0.0:
        return 0.0
    return law[GAS] * (1.0 + u / law[COLUMN]) ** (-law[EXPONENT])


@inner
def held_by(law, u):
    """What gas and constant force hold of energy at a place of the driven end."""
    found = 0.5 * law[KAPPA] * u * u - law[FORCE] * u
    if law[GAS] == 0.0:
        return found
    e, z = 1.0 - law[EXPONENT], 1.0 + u / law[COLUMN]
    return found - law[GAS] * law[COLUMN] * (math.log(z) if e == 0.0 else math.expm1(e * math.log(z)) / e)


@inner
def gas_capacity(law):
    """C − C_l of the accumulator's gas is this times (P + p_a)^(−1/n − 1)."""
    n = law[POLYTROPIC]
    return law[VOLUME] / n * (law[PRECHARGE] + law[ATMOSPHERE]) ** (1.0 / n)


@inner
def expanded(law, state, work):
    """All series of a step from the present state."""
    order = work.series.shape[1] - 2
    g, s, now = law.numbers, work.series, state.now
    modes, blend = law.modes, state.blend
    sign, resting = now[SIGN], now[RESTING] > 0.0
    a0, a1 = blend[0, AREA], blend[1, AREA]
    drag = DRAG_OUT if sign > 0.0 else DRAG_BACK
    b0, b1 = blend[0, drag], blend[1, drag]
    gas, kept = g[GAS] != 0.0, now[OPEN] == KEPT
    fed, filled = g[FED] > 0.0, now[FILLED] > 0.0 and g[VOLUME] > 0.0
    limited = now[LIMITED] > 0.0
    n = modes.shape[1]
    u = v = 0.0
    for i in range(n):
        work.places[i, 0], work.rates[i, 0] = state.bar[0, i], state.bar[1, i]
        u += modes[DRIVEN, i] * state.bar[0, i]
        v += modes[DRIVEN, i] * state.bar[1, i]
    s[U, 0], s[V, 0], s[P, 0] = u, v, now[PRESSURE]
    slope = g[SLOPE] if now[OPEN] == OPENED else 0.0
    capacity = gas_capacity(g) if filled else 0.0
    for k in range(order + 1):
        s[W, k] = product(s[V], s[V], k)
        s[A, k] = a0 * s[P, k] + (a1 * s[P, k - 1] if k else 0.0)
        f = s[A, k] - sign * (b0 * s[W, k] + (b1 * s[W, k - 1] if k else 0.0)) - g[KAPPA] * s[U, k]
        if k == 0:
            f += g[FORCE] + g[TANK] * blend[0, TANKED]
        elif k == 1:
            f += g[TANK] * blend[1, TANKED]
        if gas:
            s[Z, k] = s[U, k] / g[COLUMN] + (1.0 if k == 0 else 0.0)
            s[Y, k] = power(s[Z], s[Y], -g[EXPONENT], k) if k else s[Z, 0] ** (-g[EXPONENT])
            f += g[GAS] * s[Y, k]
        s[F, k] = f
        u = v = 0.0
        for i in range(n):
            if resting:
                work.places[i, k + 1] = work.rates[i, k + 1] = 0.0
                continue
            pull = modes[DRIVEN, i] * f - modes[OMEGA2, i] * work.places[i, k] - modes[DAMPING, i] * work.rates[i, k]
            work.places[i, k + 1] = work.rates[i, k] / (k + 1.0)
            work.rates[i, k + 1] = pull / (k + 1.0)
            u += modes[DRIVEN, i] * work.places[i, k + 1]
            v += modes[DRIVEN, i] * work.rates[i, k + 1]
        s[U, k + 1], s[V, k + 1] = u, v
        if not fed:
            s[P, k + 1] = s[N, k] = s[Q, k] = 0.0
            continue
        if limited:
            s[Q, k] = quotient(g[POWER] if k == 0 else 0.0, s[Q], s[P], k)
        else:
            s[Q, k] = -g[SLIP] * s[P, k] + (g[FLOW] if k == 0 else 0.0)
        drawn = a0 * s[V, k] + (a1 * s[V, k - 1] if k else 0.0)
        s[N, k] = s[Q, k] - drawn - g[LEAK] * s[P, k] - slope * (s[P, k] - (g[RELIEF] if k == 0 else 0.0))
        if slope == 0.0 and k == 0:
            s[N, k] = s[Q, k] - drawn - g[LEAK] * s[P, k]
        if kept:
            s[P, k + 1] = 0.0
            continue
        if filled:
            s[S, k] = s[P, k] + (g[ATMOSPHERE] if k == 0 else 0.0)
            e = -1.0 / g[POLYTROPIC] - 1.0
            s[SPIN, k] = power(s[S], s[SPIN], e, k) if k else s[S, 0] ** e
            s[C, k] = capacity * s[SPIN, k] + (g[COMPLIANCE] if k == 0 else 0.0)
            s[RISE, k] = quotient(s[N, k], s[RISE], s[C], k)
        else:
            s[C, k] = g[COMPLIANCE] if k == 0 else 0.0
            s[RISE, k] = s[N, k] / g[COMPLIANCE]
        s[P, k + 1] = s[RISE, k] / (k + 1.0)


@inner
def step_length(law, state, work):
    """For which the last terms of the series are nothing."""
    order = work.series.shape[1] - 2
    g, s = law.numbers, work.series
    h = math.inf
    for k in (order - 1, order):
        big = 0.0
        for i in range(law.modes.shape[1]):
            big += abs(work.rates[i, k])
        if big > 0.0:
            h = min(h, (ACCURACY * g[SPEED] / big) ** (1.0 / k))
        pressure = abs(s[P, k])
        if pressure > 0.0:
            h = min(h, (ACCURACY * max(abs(s[P, 0]), 0.01) / pressure) ** (1.0 / k))
    return min(h, 4.0 * g[UNIT])


# ---- What the state is at a time of the step


@inner
def moved_by(law, state, work, t):
    """The state a time after the beginning of the step, with its sums; derivatives are moved before."""
    order = work.series.shape[1] - 2
    g, s, now, sums = law.numbers, work.series, state.now, state.sums
    blend = state.blend
    n, width = law.modes.shape[1], blend.shape[1]
    sign = now[SIGN]
    if now[RESTING] == 0.0:
        for k in range(order + 1):
            s[CUBE, k] = product(s[V], s[W], k)
        cube, later = sign * integral(s[CUBE], t, order), sign * moment(s[CUBE], t, order)
        for i in range((width - CHAMBERS) // 2):
            j = CHAMBERS + 2 * i + (0 if sign > 0.0 else 1)
            sums[ORIFICES + i] += blend[0, j] * cube + blend[1, j] * later
        way, swept = value(s[U], t, order) - s[U, 0], moment(s[V], t, order)
        sums[RETURN_LOSS] -= g[TANK] * (blend[0, TANKED] * way + blend[1, TANKED] * swept)
        sums[DRAWN] += blend[0, AREA] * way + blend[1, AREA] * swept
        if n == 1 and law.modes[DAMPING, 0] > 0.0:
            sums[DRAG_LOSS] += law.modes[DAMPING, 0] * integral(s[W], t, order)
        elif n > 1:  # of many modes what the force has put into them, less what they have
            for k in range(order + 1):
                s[BEND, k] = product(s[F], s[V], k)
            sums[DRAG_LOSS] += integral(s[BEND], t, order) + energy_of(law, state.bar)
    pressed = integral(s[P], t, order)
    sums[PRESSED] += pressed
    if g[FED] > 0.0:
        for k in range(order + 1):
            s[SQUARE, k] = product(s[P], s[P], k)
        square = integral(s[SQUARE], t, order)
        volume = integral(s[Q], t, order)
        sums[PUMPED] += volume
        sums[PUMPED_ENERGY] += g[POWER] * t if now[LIMITED] > 0.0 else g[FLOW] * pressed - g[SLIP] * square
        sums[LEAK_LOSS] += g[LEAK] * square
        sums[LEAKED] += g[LEAK] * pressed
        if now[OPEN] == OPENED:
            sums[RELIEVED] += g[SLOPE] * (pressed - g[RELIEF] * t)
            sums[RELIEF_LOSS] += g[SLOPE] * (square - g[RELIEF] * pressed)
        elif now[OPEN] == KEPT:
            gone = integral(s[N], t, order)
            sums[RELIEVED] += gone
            sums[RELIEF_LOSS] += g[RELIEF] * gone
    else:
        sums[LEAK_LOSS] += g[LEAK] * s[P, 0] * s[P, 0] * t
        sums[LEAKED] += g[LEAK] * s[P, 0] * t
    extremes(law, state, work, t)
    for i in range(n):
        state.bar[0, i], state.bar[1, i] = value(work.places[i], t, order), value(work.rates[i], t, order)
    if n > 1 and now[RESTING] == 0.0:
        sums[DRAG_LOSS] -= energy_of(law, state.bar)
    now[PRESSURE] = value(s[P], t, order)
    for j in range(width):
        blend[0, j] += blend[1, j] * t
    now[TIME] += t
    now[WALL] = now[TURNED] = now[AT_RELIEF] = now[AT_CHARGE] = now[AT_CORNER] = now[AT_ZERO] = 0.0
    for i in range(state.touched.size):
        state.touched[i] = 0.0


@inner
def energy_of(law, bar):
    """Kinetic and elastic energy of the modes."""
    found = 0.0
    for i in range(law.modes.shape[1]):
        found += 0.5 * (bar[1, i] ** 2 + law.modes[OMEGA2, i] * bar[0, i] ** 2)
    return found


@inner
def extremes(law, state, work, t):
    """Least and greatest pressure, and the farthest place of the striking end, within the step."""
    order = work.series.shape[1] - 2
    s, sums = work.series, state.sums
    poly = s[POLY]
    for quantity in range(2):
        c = s[BEND]
        for k in range(order + 1):
            if quantity == 0:
                c[k] = s[P, k]
            else:
                c[k] = 0.0
                for i in range(law.modes.shape[1]):
                    c[k] += law.modes[END, i] * work.places[i, k]
        scale = 1.0
        for k in range(order):
            poly[k] = (k + 1.0) * c[k + 1] * scale
            scale *= t
        at = t * min(first_root(poly, order - 1, 0.0, work.stack, work.ends), 1.0)
        for time in (at, t):
            found = value(c, time, order)
            if quantity == 0:
                sums[LEAST], sums[GREATEST] = min(sums[LEAST], found), max(sums[GREATEST], found)
            else:
                sums[FARTHEST] = max(sums[FARTHEST], -found)


# ---- Derivatives by the numbers at the start


@inner
def linearised(law, state, work, t):
    """The derivatives of the state a time after the beginning of the step, all directions."""
    order = work.series.shape[1] - 2
    g, s, now = law.numbers, work.series, state.now
    modes, blend, bars = law.modes, state.blend, state.bars
    n, sign = modes.shape[1], now[SIGN]
    if now[RESTING] > 0.0:
        sign = 0.0
    drag = DRAG_OUT if sign > 0.0 else DRAG_BACK
    flows = g[FED] > 0.0 and now[OPEN] != KEPT
    filled, limited = now[FILLED] > 0.0 and g[VOLUME] > 0.0, now[LIMITED] > 0.0
    slope = g[SLOPE] if now[OPEN] == OPENED else 0.0
    # gu and gv: of the force by place and speed of the driven end; pv and pp: of P′ by that speed and by the pressure
    for k in range(order + 1):
        s[GU, k] = -g[KAPPA] if k == 0 else 0.0
        if g[GAS] != 0.0:
            e = -g[EXPONENT] - 1.0
            s[DF, k] = power(s[Z], s[DF], e, k) if k else s[Z, 0] ** e
            s[GU, k] -= g[EXPONENT] * g[GAS] / g[COLUMN] * s[DF, k]
        s[GV, k] = -2.0 * sign * (blend[0, drag] * s[V, k] + (blend[1, drag] * s[V, k - 1] if k else 0.0))
        if not flows:
            continue
        top = -blend[0, AREA] if k == 0 else -blend[1, AREA] if k == 1 else 0.0
        s[PV, k] = quotient(top, s[PV], s[C], k)
        if limited:
            s[DC, k] = quotient(-s[Q, k], s[DC], s[P], k)
            held = s[DC, k] - (g[LEAK] + slope if k == 0 else 0.0)
        else:
            held = -(g[SLIP] + g[LEAK] + slope) if k == 0 else 0.0
        s[SOURCE, k] = held
        if filled:
            e = -1.0 / g[POLYTROPIC] - 2.0
            s[DG, k] = power(s[S], s[DG], e, k) if k else s[S, 0] ** e
            s[SOURCE, k] -= gas_capacity(g) * (e + 1.0) * product(s[DG], s[RISE], k)
            s[PP, k] = quotient(s[SOURCE, k], s[PP], s[C], k)
        else:
            s[PP, k] = s[SOURCE, k] / g[COMPLIANCE]
    count, blends = bars.shape[1], state.blends
    for i in range(n):
        for d in range(count):
            work.moved[0, i, d], work.spun[0, i, d] = bars[i, d], bars[n + i, d]
    for d in range(count):
        work.turned[BY_PRESSURE, 0, d] = bars[2 * n, d]
    for k in range(order + 1):
        place, rate, rise, push = work.turned[BY_PLACE, k], work.turned[BY_RATE, k], work.turned[BY_PRESSURE], work.pushed
        for d in range(count):
            place[d] = rate[d] = 0.0
        for i in range(n):
            driven = modes[DRIVEN, i]
            for d in range(count):
                place[d] += driven * work.moved[k, i, d]
                rate[d] += driven * work.spun[k, i, d]
        for d in range(count):
            push[d] = blend[0, AREA] * rise[k, d]
        if k > 0 and blend[1, AREA] != 0.0:
            for d in range(count):
                push[d] += blend[1, AREA] * rise[k - 1, d]
        for j in range(k + 1):
            gu, gv = s[GU, k - j], s[GV, k - j]
            for d in range(count):
                push[d] += gu * work.turned[BY_PLACE, j, d] + gv * work.turned[BY_RATE, j, d]
        for d in range(count):
            rise[k + 1, d] = 0.0
        if flows:
            for j in range(k + 1):
                pv, pp = s[PV, k - j], s[PP, k - j]
                for d in range(count):
                    rise[k + 1, d] += pv * work.turned[BY_RATE, j, d] + pp * rise[j, d]
        for d in range(count):
            if blends[0, AREA, d] == 0.0 and blends[0, drag, d] == 0.0 and blends[1, AREA, d] == 0.0 \
                    and blends[1, drag, d] == 0.0 and blends[0, TANKED, d] == 0.0 and blends[1, TANKED, d] == 0.0:
                continue  # fmt: skip
            push[d] += blends[0, AREA, d] * s[P, k] + (blends[1, AREA, d] * s[P, k - 1] if k else 0.0)
            push[d] -= sign * (blends[0, drag, d] * s[W, k] + (blends[1, drag, d] * s[W, k - 1] if k else 0.0))
            if k < 2:
                push[d] += g[TANK] * blends[k, TANKED, d]
            if flows:  # −δa v/C by its own recurrence, as C is the same of all directions
                drawn = blends[0, AREA, d] * s[V, k] + (blends[1, AREA, d] * s[V, k - 1] if k else 0.0)
                drawn += product(s[C, 1:], work.drawn[d], k - 1) if k else 0.0
                work.drawn[d, k] = -drawn / s[C, 0]
                rise[k + 1, d] += work.drawn[d, k]
        for d in range(count):
            rise[k + 1, d] /= k + 1.0
        pace = 1.0 / (k + 1.0)
        for i in range(n):
            driven, omega2, damping = modes[DRIVEN, i], modes[OMEGA2, i], modes[DAMPING, i]
            if now[RESTING] > 0.0:
                driven = omega2 = damping = 0.0
            for d in range(count):
                pull = driven * push[d] - omega2 * work.moved[k, i, d] - damping * work.spun[k, i, d]
                work.moved[k + 1, i, d] = pace * work.spun[k, i, d]
                work.spun[k + 1, i, d] = pace * pull
    for i in range(n):
        for d in range(count):
            bars[i, d], bars[n + i, d] = work.moved[order, i, d], work.spun[order, i, d]
    for d in range(count):
        bars[2 * n, d] = work.turned[BY_PRESSURE, order, d]
    for k in range(order - 1, -1, -1):
        for i in range(n):
            for d in range(count):
                bars[i, d] = bars[i, d] * t + work.moved[k, i, d]
                bars[n + i, d] = bars[n + i, d] * t + work.spun[k, i, d]
        for d in range(count):
            bars[2 * n, d] = bars[2 * n, d] * t + work.turned[BY_PRESSURE, k, d]
    for d in range(count):
        for j in range(4):
            blends[0, j, d] += blends[1, j, d] * t


@inner
def rates_of(law, state, rates):
    """The rates of the bar's displacements and velocities and of the pressure, (2 n + 1,); returns the force."""
    g, now, modes, bar, blend = law.numbers, state.now, law.modes, state.bar, state.blend
    n, u, v = modes.shape[1], 0.0, 0.0
    for i in range(n):
        u += modes[DRIVEN, i] * bar[0, i]
        v += modes[DRIVEN, i] * bar[1, i]
    drag = blend[0, DRAG_OUT] if v > 0.0 else -blend[0, DRAG_BACK]
    pressure = now[PRESSURE]
    force = g[FORCE] + g[TANK] * blend[0, TANKED] + blend[0, AREA] * pressure - drag * v * v - g[KAPPA] * u
    force += of_gas(g, u)
    for i in range(n):
        rates[i] = bar[1, i]
        rates[n + i] = modes[DRIVEN, i] * force - modes[OMEGA2, i] * bar[0, i] - modes[DAMPING, i] * bar[1, i]
        if now[RESTING] > 0.0:
            rates[n + i] = 0.0
    rates[2 * n] = 0.0
    if g[FED] > 0.0 and now[OPEN] != KEPT:
        rise = g[POWER] / pressure if now[LIMITED] > 0.0 else g[FLOW] - g[SLIP] * pressure
        rise -= blend[0, AREA] * v + g[LEAK] * pressure
        if now[OPEN] == OPENED:
            rise -= g[SLOPE] * (pressure - g[RELIEF])
        capacity = g[COMPLIANCE]
        if now[FILLED] > 0.0 and g[VOLUME] > 0.0:
            capacity += gas_capacity(g) * (pressure + g[ATMOSPHERE]) ** (-1.0 / g[POLYTROPIC] - 1.0)
        rates[2 * n] = rise / capacity
    return force


@inner
def jumped(state, work):
    """Derivatives of the state behind an event whose time moves by `times`, between rates before and after it."""
    bars = state.bars
    for d in range(bars.shape[1]):
        for i in range(bars.shape[0]):
            bars[i, d] += (work.before[i] - work.after[i]) * work.times[d]


@inner
def timed(law, state, work, row, of_speed):
    """By how much the time moves at which a row of the bar meets its level."""
    n, bars = law.modes.shape[1], state.bars
    first, rate = (n if of_speed else 0), 0.0
    for i in range(n):
        rate += row[i] * work.before[first + i]
    for d in range(bars.shape[1]):
        found = 0.0
        for i in range(n):
            found += row[i] * bars[first + i, d]
        work.times[d] = -found / rate


# ---- Events


@inner
def logged(law, state, log, kind, detail):
    """One more event in the log."""
    m, n = int(log.filled[0]), law.modes.shape[1]
    row = log.events[m]
    row[0], row[1], row[2], row[3] = state.now[TIME], kind, detail, state.now[PRESSURE]
    row[4] = log.filled[1]
    for i in range(n):
        row[EVENT + i], row[EVENT + n + i] = state.bar[0, i], state.bar[1, i]
    log.filled[0] = m + 1


@inner
def faced(law, state, work):
    """The sign of the driven end's speed after an event, else of what begins to move it."""
    speed, push = 0.0, 0.0
    rates_of(law, state, work.after)
    n = law.modes.shape[1]
    for i in range(n):
        speed += law.modes[DRIVEN, i] * state.bar[1, i]
        push += law.modes[DRIVEN, i] * work.after[n + i]
    state.now[TURNED] = 0.0
    if abs(speed) <= 1e-14 * law.numbers[SPEED]:
        state.now[TURNED] = 1.0
        speed = push
    state.now[SIGN] = 1.0 if speed > 0.0 else -1.0


@inner
def demanded(law, state, work, log, number):
    """A port, or the blow, demands a state: a later demand replaces what would be carried out after it."""
    port, now, orders = law.ports[number], state.now, state.orders
    if port[TO] == now[LAST]:
        return
    logged(law, state, log, PORT_MET, float(number))
    pace = 1.0 + law.numbers[QUICKENING] * (now[PRESSURE] - 1.0)
    delay = port[DELAY] / pace
    due, count = now[TIME] + delay, int(now[COUNT])
    while count > 0 and orders[count - 1, 0] >= due:
        count -= 1
    orders[count, 0], orders[count, 1] = due, port[TO]
    n = law.modes.shape[1]
    for d in range(state.bars.shape[1]):
        state.dues[count, d] = work.times[d]
        if law.numbers[QUICKENING] > 0.0:
            pressure = state.bars[2 * n, d] + work.before[2 * n] * work.times[d]
            state.dues[count, d] -= delay * law.numbers[QUICKENING] * pressure / pace
    now[COUNT], now[LAST] = count + 1.0, port[TO]


@inner
def carried_out(law, state, work, log):
    """The order that is due: the state begins, at once or over the stroke of the spool."""
    now, blend, blends, orders = state.now, state.blend, state.blends, state.orders
    to, stroke = int(orders[0, 1]), law.numbers[SPOOL]
    rates_of(law, state, work.before)
    for d in range(state.bars.shape[1]):
        work.times[d] = state.dues[0, d]
    logged(law, state, log, VALVE, float(to))
    count = int(now[COUNT])
    for i in range(1, count):
        orders[i - 1, 0], orders[i - 1, 1] = orders[i, 0], orders[i, 1]
        for d in range(state.bars.shape[1]):
            state.dues[i - 1, d] = state.dues[i, d]
    now[COUNT], now[STATE] = count - 1.0, float(to)
    aim = law.joins[to]
    for d in range(state.bars.shape[1]):
        for j in range(4):
            if stroke > 0.0:  # c + (aim − c) (t − due)/stroke, with c what an earlier stroke has come to
                come = blends[0, j, d] + blend[1, j] * work.times[d]
                pace = (aim[j] - blend[0, j]) / stroke
                blends[0, j, d] = come - pace * work.times[d]
                blends[1, j, d] = -come / stroke
            else:
                blends[0, j, d] = blends[1, j, d] = 0.0
        state.shift[d] = work.times[d]
    for j in range(blend.shape[1]):
        if stroke > 0.0:
            blend[1, j] = (aim[j] - blend[0, j]) / stroke
        else:
            blend[0, j], blend[1, j] = aim[j], 0.0
    now[STROKE] = now[TIME] + stroke if stroke > 0.0 else math.inf
    if stroke == 0.0:
        rates_of(law, state, work.after)
        jumped(state, work)
    if now[RESTING] == 0.0 and now[TURNED] > 0.0:
        faced(law, state, work)


@inner
def stroke_ended(law, state):
    """The spool has come to the end of its stroke."""
    now, blend = state.now, state.blend
    aim = law.joins[int(now[STATE])]
    for j in range(blend.shape[1]):
        blend[0, j], blend[1, j] = aim[j], 0.0
    for d in range(state.bars.shape[1]):
        for j in range(4):
            state.blends[0, j, d] = state.blends[1, j, d] = 0.0
    now[STROKE] = math.inf


@inner
def struck(law, state, work, log):
    """A blow: the law of the contact, its demands, and whether the bar then lies on the wall."""
    g, now, bar, bars = law.numbers, state.now, state.bar, state.bars
    n, factor, strain = law.modes.shape[1], g[FACTOR], g[STRAIN]
    logged(law, state, log, IMPACT, 0.0)
    rates_of(law, state, work.before)
    timed(law, state, work, law.modes[END], False)
    kinetic = ringing = place = 0.0
    for i in range(n):
        kinetic += 0.5 * bar[1, i] ** 2
        ringing += 0.5 * law.modes[OMEGA2, i] * bar[0, i] ** 2
        place += law.modes[DRIVEN, i] * bar[0, i]
    state.sums[IMPACT_LOSS] += (1.0 - factor * factor) * kinetic + (1.0 - strain * strain) * ringing
    if n > 1:  # a law that turns the strain over moves the driven end in no time
        state.sums[IMPACT_LOSS] += held_by(g, place) - held_by(g, strain * place)
    for d in range(bars.shape[1]):  # z⁺ = D (z⁻ + f⁻ δt) − f⁺ δt
        for i in range(n):
            bars[i, d] = strain * (bars[i, d] + work.before[i] * work.times[d])
            bars[n + i, d] = factor * (bars[n + i, d] + work.before[n + i] * work.times[d])
        bars[2 * n, d] += work.before[2 * n] * work.times[d]
    for i in range(n):
        bar[0, i], bar[1, i] = strain * bar[0, i], factor * bar[1, i]
    if n == 1:
        bar[0, 0] = 0.0
    force = rates_of(law, state, work.after)
    for d in range(bars.shape[1]):
        for i in range(2 * n + 1):
            bars[i, d] -= work.after[i] * work.times[d]
    now[BLOWS] += 1.0
    speed, push = 0.0, 0.0
    for i in range(n):
        speed -= law.modes[END, i] * bar[1, i]
        push += law.modes[END, i] * work.after[n + i]
    now[WALL] = 1.0 if speed > 0.0 else 2.0
    work.before[2 * n] = work.after[2 * n]  # what a delay that follows the pressure asks for
    for i in range(law.ports.shape[0]):
        if law.ports[i, ON_IMPACT] > 0.0:
            demanded(law, state, work, log, i)
    while now[COUNT] > 0.0 and state.orders[0, 0] <= now[TIME]:
        carried_out(law, state, work, log)
    force = rates_of(law, state, work.after)
    push = 0.0
    for i in range(n):
        push += law.modes[END, i] * work.after[n + i]
    # what is left of a chatter by a constant push: it is completed when so little of it is left
    left = -2.0 * speed * factor / ((1.0 + factor) * push) if push > 0.0 and factor > -1.0 else math.inf
    lies = speed == 0.0 and (push > 0.0 or force > 0.0)
    if lies or (push > 0.0 and force > 0.0 and factor < 0.0 and left <= 1e-5 * g[UNIT]):
        laid(law, state, log)
        return
    faced(law, state, work)


@inner
def laid(law, state, log):
    """The bar lies on the wall, undeformed."""
    n, place = law.modes.shape[1], 0.0
    for i in range(n):
        place += law.modes[DRIVEN, i] * state.bar[0, i]
    state.sums[IMPACT_LOSS] += held_by(law.numbers, place)
    for i in range(n):
        state.sums[IMPACT_LOSS] += 0.5 * state.bar[1, i] ** 2 + 0.5 * law.modes[OMEGA2, i] * state.bar[0, i] ** 2
        state.bar[0, i] = state.bar[1, i] = 0.0
        for d in range(state.bars.shape[1]):
            state.bars[i, d] = state.bars[n + i, d] = 0.0
    state.now[RESTING] = 1.0
    logged(law, state, log, REST, 0.0)


@inner
def released(law, state, work, log, still):
    """The bar leaves the wall at rest; `still`: the force is 0 there, and falls."""
    now = state.now
    logged(law, state, log, LEAVES, 0.0)
    now[RESTING] = 0.0
    now[SIGN] = -1.0
    now[WALL], now[TURNED] = (3.0, 2.0) if still else (2.0, 1.0)
    if law.modes.shape[1] > 1:
        now[HOLD] = now[TIME] + law.numbers[WAVE]


@inner
def limits_of(law, state):
    """What the pressure tells of accumulator, relief and pump at a start."""
    g, now = law.numbers, state.now
    pressure = now[PRESSURE]
    now[FILLED] = 1.0 if g[VOLUME] > 0.0 and pressure > g[PRECHARGE] else 0.0
    now[OPEN] = CLOSED
    if g[FED] > 0.0 and pressure >= g[RELIEF]:
        now[OPEN] = OPENED if g[SLOPE] < math.inf else KEPT
        if g[SLOPE] == math.inf:
            now[PRESSURE] = g[RELIEF]
    now[LIMITED] = 1.0 if g[CORNER] < pressure < g[CORNER_TO] else 0.0


# ---- From event to event

_NOTHING, _WALL, _PORTS, _TURN, _LEAVE, _DRY, _CHARGE, _RELIEF, _CORNER, _CLOSE = range(10)


@inner
def sighted(law, state, work, h):
    """The first event of the step within h: its time as a part of h, and what it is, ports counted from 100 on."""
    order = work.series.shape[1] - 2
    g, now, s = law.numbers, state.now, work.series
    n, best, what = law.modes.shape[1], 2.0, _NOTHING
    row = s[BEND]
    if now[RESTING] > 0.0:
        time = met(s[F], 0.0, h, -1.0, 0, work)
        if time < best:
            best, what = time, _LEAVE
    else:
        if now[HOLD] <= now[TIME]:
            for k in range(order + 1):
                row[k] = 0.0
                for i in range(n):
                    row[k] += law.modes[END, i] * work.places[i, k]
            time = met(row, 0.0, h, 1.0, int(now[WALL]), work)
            if time < best:
                best, what = time, _WALL
        for j in range(law.ports.shape[0]):
            if law.ports[j, ON_IMPACT] > 0.0 or law.ports[j, TO] == now[LAST] or now[HOLD] == math.inf:
                continue
            for k in range(order + 1):
                row[k] = 0.0
                for i in range(n):
                    row[k] += law.reads[j, i] * (work.rates[i, k] if law.ports[j, OF_SPEED] > 0.0 else work.places[i, k])
            time = met(row, law.ports[j, LEVEL], h, law.ports[j, SIDE], int(state.touched[j]), work)
            if time < best:
                best, what = time, 100 + j
        time = met(s[V], 0.0, h, -now[SIGN], int(now[TURNED]), work)
        if time < best:
            best, what = time, _TURN
    if g[FED] == 0.0:
        return best, what
    if now[OPEN] == KEPT:
        time = met(s[N], 0.0, h, -1.0, 0, work)
        if time < best:
            best, what = time, _CLOSE
        return best, what
    time = met(s[P], 0.0, h, -1.0, int(now[AT_ZERO]), work)
    if time < best:
        best, what = time, _DRY
    if g[VOLUME] > 0.0:
        time = met(s[P], g[PRECHARGE], h, -1.0 if now[FILLED] > 0.0 else 1.0, int(now[AT_CHARGE]), work)
        if time < best:
            best, what = time, _CHARGE
    if g[RELIEF] < math.inf:
        time = met(s[P], g[RELIEF], h, -1.0 if now[OPEN] == OPENED else 1.0, int(now[AT_RELIEF]), work)
        if time < best:
            best, what = time, _RELIEF
    if g[CORNER] < math.inf:
        for edge in (g[CORNER], g[CORNER_TO]):
            time = met(s[P], edge, h, 0.0, int(now[AT_CORNER]) if now[AT_CORNER] * edge == now[PRESSURE] else 0, work)
            if time < best:
                best, what = time, _CORNER
    return best, what


@inner
def pressure_event(law, state, work, log, what):
    """What the pressure meets: precharge, relief, the corner of the pump."""
    g, now, n = law.numbers, state.now, law.modes.shape[1]
    rates_of(law, state, work.before)
    rise = work.before[2 * n]
    for d in range(state.bars.shape[1]):
        work.times[d] = -state.bars[2 * n, d] / rise if rise != 0.0 else 0.0
    if what == _CHARGE:
        now[PRESSURE], now[AT_CHARGE] = g[PRECHARGE], 1.0
        now[FILLED] = 1.0 - now[FILLED]
        logged(law, state, log, FILLS if now[FILLED] > 0.0 else EMPTIES, 0.0)
    elif what == _RELIEF:
        now[PRESSURE], now[AT_RELIEF] = g[RELIEF], 1.0
        now[OPEN] = CLOSED if now[OPEN] == OPENED else OPENED if g[SLOPE] < math.inf else KEPT
        logged(law, state, log, CLOSES if now[OPEN] == CLOSED else OPENS, 0.0)
    elif what == _CORNER:
        low = abs(now[PRESSURE] - g[CORNER]) <= abs(now[PRESSURE] - g[CORNER_TO])
        now[PRESSURE], now[AT_CORNER] = (g[CORNER] if low else g[CORNER_TO]), 1.0
        now[LIMITED] = 1.0 - now[LIMITED]
        logged(law, state, log, LIMITS if now[LIMITED] > 0.0 else FULL_FLOW, 0.0)
    else:  # the relief closes: what held the pressure has become nothing
        now[OPEN], now[AT_RELIEF] = CLOSED, 2.0
        logged(law, state, log, CLOSES, 0.0)
        return
    rates_of(law, state, work.after)
    jumped(state, work)


@entry
def followed(law, state, work, log, until, exact, blows, steps, section, since, entering):
    """A motion until a time, so many blows in all, so many steps, or a port is met.

    Where the time is not asked for exactly the motion ends at the beginning of the step that would go beyond it, so that
    it goes on with the same bits.
    `section` is the number of a port, −1 for none, met after `since` blows and not demanded yet; `entering` those of the
    ports, and of the blow, that demand first. How it ended.
    """
    now, log_events, n = state.now, log.events.shape[0], law.modes.shape[1]
    for j in entering:
        rates_of(law, state, work.before)
        for d in range(state.bars.shape[1]):
            work.times[d] = 0.0
        if law.ports[j, ON_IMPACT] == 0.0 and j == section:
            state.touched[j] = 1.0
        demanded(law, state, work, log, j)
    for _ in range(steps):
        while now[COUNT] > 0.0 and state.orders[0, 0] <= now[TIME]:
            carried_out(law, state, work, log)
        if now[STROKE] <= now[TIME]:
            stroke_ended(law, state)
        if now[COUNT] + 2.0 + law.ports.shape[0] >= state.orders.shape[0]:
            return CROWDED
        if log.filled[0] + law.ports.shape[0] + 4 + state.orders.shape[0] >= log_events:
            return LOG_FULL
        if now[RESTING] > 0.0 and rates_of(law, state, work.after) < 0.0:
            released(law, state, work, log, False)
        if now[TIME] >= until:
            return BY_TIME
        if now[BLOWS] >= blows:
            return BY_BLOWS
        if now[FILLED] == 0.0 and law.numbers[VOLUME] > 0.0 and law.numbers[COMPLIANCE] == 0.0:
            return EMPTY_LINE
        expanded(law, state, work)
        h, ends = step_length(law, state, work), until if exact else math.inf
        if now[COUNT] > 0.0:
            ends = min(ends, state.orders[0, 0])
        ends = min(ends, now[STROKE])
        if now[HOLD] > now[TIME]:
            ends = min(ends, now[HOLD])
        whole = ends - now[TIME] <= h
        if whole:
            h = ends - now[TIME]
        if not h > 0.0:
            return NO_STEP
        part, what = sighted(law, state, work, h)
        taken = h * part if part <= 1.0 else h
        beyond = not exact and now[TIME] + taken > until
        if log.steps.shape[0] > 0:
            if log.filled[1] >= log.steps.shape[0]:
                return STEPS_FULL
            kept_step(law, state, log, taken)
        if beyond:
            return BY_TIME
        if state.bars.shape[1] > 0:
            linearised(law, state, work, taken)
        moved_by(law, state, work, taken)
        if part > 1.0:
            if whole:
                now[TIME] = ends
            continue
        if what == _WALL:
            struck(law, state, work, log)
        elif what >= 100:
            j = what - 100
            if j == section and now[BLOWS] >= since:
                return AT_SECTION
            rates_of(law, state, work.before)
            timed(law, state, work, law.reads[j], law.ports[j, OF_SPEED] > 0.0)
            state.touched[j] = 1.0
            demanded(law, state, work, log, j)
        elif what == _TURN:
            if n == 1:
                state.bar[1, 0] = 0.0
            now[SIGN] = -now[SIGN]
            now[TURNED] = 1.0
        elif what == _LEAVE:
            released(law, state, work, log, True)
        elif what == _DRY:
            logged(law, state, log, DRY, 0.0)
            return NO_PRESSURE
        else:
            pressure_event(law, state, work, log, what)
    return STEPS_FULL


@inner
def kept_step(law, state, log, taken):
    """A step from the present state, as `at_times` takes it up again."""
    row, n, width = log.steps[int(log.filled[1])], law.modes.shape[1], state.blend.shape[1]
    now = state.now
    row[0], row[1], row[2], row[3] = now[TIME], taken, now[PRESSURE], now[SIGN]
    row[4], row[5], row[6], row[7] = now[OPEN], now[FILLED], now[LIMITED], now[RESTING]
    for j in range(width):
        row[STEP + j], row[STEP + width + j] = state.blend[0, j], state.blend[1, j]
    for i in range(n):
        row[STEP + 2 * width + i], row[STEP + 2 * width + n + i] = state.bar[0, i], state.bar[1, i]
    log.filled[1] += 1


@entry
def at_times(law, state, work, steps, times, numbers, found):
    """Of steps, and of times after their beginnings: places and rates of the modes, pressure and force, (t, 2 n + 2)."""
    order = work.series.shape[1] - 2
    now, n, width = state.now, law.modes.shape[1], state.blend.shape[1]
    before = -1
    for m in range(times.size):
        if numbers[m] != before:
            before = numbers[m]
            row = steps[before]
            now[TIME], now[PRESSURE], now[SIGN] = row[0], row[2], row[3]
            now[OPEN], now[FILLED], now[LIMITED], now[RESTING] = row[4], row[5], row[6], row[7]
            for j in range(width):
                state.blend[0, j], state.blend[1, j] = row[STEP + j], row[STEP + width + j]
            for i in range(n):
                state.bar[0, i], state.bar[1, i] = row[STEP + 2 * width + i], row[STEP + 2 * width + n + i]
            expanded(law, state, work)
        for i in range(n):
            found[m, i] = value(work.places[i], times[m], order)
            found[m, n + i] = value(work.rates[i], times[m], order)
        found[m, 2 * n] = value(work.series[P], times[m], order)
        found[m, 2 * n + 1] = value(work.series[F], times[m], order)


@entry
def rates_at(law, state, rates):
    """The rates of a state, for a section; and its force."""
    return rates_of(law, state, rates)


@entry
def begun(law, state, work):
    """What follows from pressure, bar and state at a start."""
    limits_of(law, state)
    if state.now[RESTING] == 0.0:
        faced(law, state, work)
