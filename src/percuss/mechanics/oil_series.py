"""A machine whose oil flows, compiled: the power series of a step, the roots of its guards, and its derivatives.

The oil has no closed form: what an orifice takes grows with the square of the speed, gas is polytropic, an accumulator
empties. So every step is a power series of all coordinates and of the pressure, by recurrence, and a guard is a
polynomial of the step, whose first root is isolated by its Bernstein coefficients: nothing is looked for by samples.
Derivatives by the numbers at the start are carried along by collocation of the linearised equations, with a saltation
at each event. `percuss.mechanics.oil` makes the tables, and says what they hold.
"""

from __future__ import annotations

import math

from percuss.compiled import inner, summed
from percuss.mechanics.oil_records import (
    ACCURACY,
    AREA,
    AT_CHARGE,
    AT_CORNER,
    AT_RELIEF,
    AT_ZERO,
    ATMOSPHERE,
    BEND,
    CHAMBERS,
    COLUMN,
    COMPLIANCE,
    CUBE,
    DAMPING,
    DRAG_BACK,
    DRAG_LOSS,
    DRAG_OUT,
    DRAWN,
    DRIVEN,
    END,
    EXPONENT,
    FARTHEST,
    FED,
    FILLED,
    FLOW,
    FORCE,
    GAS,
    GREATEST,
    KAPPA,
    KEPT,
    LEAK,
    LEAK_LOSS,
    LEAKED,
    LEAST,
    LIMITED,
    OMEGA2,
    OPEN,
    OPENED,
    ORIFICES,
    POLY,
    POLYTROPIC,
    POWER,
    PRECHARGE,
    PRESSED,
    PRESSURE,
    PUMPED,
    PUMPED_ENERGY,
    RELIEF,
    RELIEF_LOSS,
    RELIEVED,
    RESTING,
    RETURN_LOSS,
    RISE,
    SIGN,
    SLIP,
    SLOPE,
    SPEED,
    SPIN,
    SQUARE,
    TANK,
    TANKED,
    TIME,
    TURNED,
    UNIT,
    VOLUME,
    WALL,
    A,
    C,
    F,
    N,
    P,
    Q,
    S,
    U,
    V,
    W,
    Y,
    Z,
)

# ---- Series


@summed
def product(a, b, k):
    """Coefficient k of the product of two series."""
    found = 0.0
    for j in range(k + 1):
        found += a[j] * b[k - j]
    return found


@summed
def power(z, y, exponent, k):
    """Coefficient k ≥ 1 of y = z^exponent, from those before."""
    found = 0.0
    for j in range(1, k + 1):
        found += (exponent * j - (k - j)) * z[j] * y[k - j]
    return found / (k * z[0])


@summed
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
def pumped(g, pressure, limited):
    """Flow of the pump at a pressure."""
    return g[POWER] / pressure if limited else g[FLOW] - g[SLIP] * pressure


@inner
def supplied(g, pressure, drawn, limited, opened, filled):
    """C P′ with what the piston draws, C, and its part that is of gas; which of the supply's limits act."""
    rise, gas = pumped(g, pressure, limited) - (drawn + g[LEAK] * pressure), 0.0
    if opened:
        rise -= g[SLOPE] * (pressure - g[RELIEF])
    if filled and g[VOLUME] > 0.0:
        gas = gas_capacity(g) * (pressure + g[ATMOSPHERE]) ** (-1.0 / g[POLYTROPIC] - 1.0)
    return rise, g[COMPLIANCE] + gas, gas


@summed
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
        work.places[0, i], work.rates[0, i] = state.bar[0, i], state.bar[1, i]
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
        u, v, pace = 0.0, 0.0, 0.0 if resting else 1.0 / (k + 1.0)
        place, rate, places, rates = work.places[k], work.rates[k], work.places[k + 1], work.rates[k + 1]
        for i in range(n):
            places[i] = pace * rate[i]
            rates[i] = pace * (modes[DRIVEN, i] * f - modes[OMEGA2, i] * place[i] - modes[DAMPING, i] * rate[i])
            u += modes[DRIVEN, i] * places[i]
            v += modes[DRIVEN, i] * rates[i]
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
            big += abs(work.rates[k, i])
        if big > 0.0:
            h = min(h, (ACCURACY * g[SPEED] / big) ** (1.0 / k))
        pressure = abs(s[P, k])
        if pressure > 0.0:
            h = min(h, (ACCURACY * max(abs(s[P, 0]), 0.01) / pressure) ** (1.0 / k))
    return min(h, 4.0 * g[UNIT])


# ---- What the state is at a time of the step


@summed
def read(row, modes, c, order):
    """The series of what a row reads of those of the modes."""
    for k in range(order + 1):
        found = 0.0
        for i in range(row.size):
            found += row[i] * modes[k, i]
        c[k] = found


@inner
def modes_at(law, work, t, places, rates):
    """Places and rates of the modes at a time of the step."""
    order, n = work.series.shape[1] - 2, law.modes.shape[1]
    for i in range(n):
        places[i], rates[i] = work.places[order, i], work.rates[order, i]
    for k in range(order - 1, -1, -1):
        for i in range(n):
            places[i] = places[i] * t + work.places[k, i]
            rates[i] = rates[i] * t + work.rates[k, i]


@inner
def moved_by(law, state, work, t, counted):
    """The state a time after the beginning of the step, its sums where they are counted; derivatives move before."""
    now, blend = state.now, state.blend
    if counted:
        counted_up(law, state, work, t)
    modes_at(law, work, t, state.bar[0], state.bar[1])
    if counted and law.modes.shape[1] > 1 and now[RESTING] == 0.0:
        state.sums[DRAG_LOSS] -= energy_of(law, state.bar)
    now[PRESSURE] = value(work.series[P], t, work.series.shape[1] - 2)
    for j in range(blend.shape[1]):
        blend[0, j] += blend[1, j] * t
    now[TIME] += t
    now[WALL] = now[TURNED] = now[AT_RELIEF] = now[AT_CHARGE] = now[AT_CORNER] = now[AT_ZERO] = 0.0
    for i in range(state.touched.size):
        state.touched[i] = 0.0


@inner
def counted_up(law, state, work, t):
    """The sums a time after the beginning of the step."""
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
        c = s[P] if quantity == 0 else s[BEND]
        if quantity == 1:
            read(law.modes[END], work.places, c, order)
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
def answer(omega2, damping, t):
    """What a push of 1 at time 0 makes of a mode: its place and its rate."""
    half = 0.5 * damping
    root, fades = omega2 - half * half, math.exp(-half * t)
    w, place, rate = math.sqrt(abs(root)), t, 1.0
    if root > 0.0:
        place, rate = math.sin(w * t) / w, math.cos(w * t)
    elif root < 0.0:
        place, rate = math.sinh(w * t) / w, math.cosh(w * t)
    return fades * place, fades * (rate - half * place)


@inner
def tabulated(law, work, t):
    """For a step: what the driven end does at its nodes by the modes, and by the force at others; how it ends."""
    modes, c, w = law.modes, work.nodes[0], work.nodes[1]
    n = modes.shape[1]
    seen, pulled, turned, answers = work.seen, work.pulled, work.turned, work.answers
    work.span[1] = t
    for m in range(c.size):
        for j in range(c.size):
            pulled[0, m, j] = pulled[1, m, j] = 0.0
        for p in range(c.size):
            place = rate = 0.0
            for i in range(n):
                k, r = answer(modes[OMEGA2, i], modes[DAMPING, i], t * c[m] * (1.0 - c[p]))
                place += modes[DRIVEN, i] ** 2 * k
                rate += modes[DRIVEN, i] ** 2 * r
            for j in range(c.size):
                part = t * c[m] * w[p] * work.parts[m, p, j]
                pulled[0, m, j] += place * part
                pulled[1, m, j] += rate * part
    for i in range(n):
        driven, omega2, damping = modes[DRIVEN, i], modes[OMEGA2, i], modes[DAMPING, i]
        k, r = answer(omega2, damping, t)
        turned[0, i], turned[1, i], turned[2, i], turned[3, i] = r + damping * k, k, -omega2 * k, r
        for m in range(c.size):
            k, r = answer(omega2, damping, t * c[m])
            seen[0, m, i], seen[0, m, n + i] = driven * (r + damping * k), driven * k
            seen[1, m, i], seen[1, m, n + i] = -driven * omega2 * k, driven * r
            k, r = answer(omega2, damping, t * (1.0 - c[m]))
            answers[0, i, m], answers[1, i, m] = driven * t * w[m] * k, driven * t * w[m] * r


@summed
def added(row, share, other):
    """A multiple of another row to a row."""
    for j in range(row.size):
        row[j] += share * other[j]


@summed
def both_added(one, other, a, b, c, d, first, second):
    """Multiples of two rows to each of two others."""
    for j in range(one.size):
        x, y = first[j], second[j]
        one[j] += a * x + b * y
        other[j] += c * x + d * y


@inner
def exchanged(row, other):
    """Two rows, each in place of the other."""
    for j in range(row.size):
        row[j], other[j] = other[j], row[j]


@inner
def solved(matrix, columns, size):
    """Columns behind a square matrix, solved for in place: elimination with a choice of the row."""
    for k in range(size):
        best = k
        for m in range(k + 1, size):
            if abs(matrix[m, k]) > abs(matrix[best, k]):
                best = m
        if best != k:
            exchanged(matrix[k], matrix[best])
            exchanged(columns[k], columns[best])
        for m in range(k + 1, size):
            share = -matrix[m, k] / matrix[k, k]
            added(matrix[m, k:size], share, matrix[k, k:size])
            added(columns[m], share, columns[k])
    for k in range(size - 1, -1, -1):
        row, scale = columns[k], 1.0 / matrix[k, k]
        for j in range(row.size):
            row[j] *= scale
        for m in range(k):
            added(columns[m], -matrix[m, k], row)


@inner
def linearised(law, state, work, t):
    """The derivatives of the state a time after the beginning of the step, all directions.

    The modes answer the derivatives of the force exactly; these, and those of P′, are polynomials through Gauss's
    nodes of the step (collocation), where they are as the linearised equations say.
    """
    order, c = work.series.shape[1] - 2, work.nodes[0]
    g, s, now = law.numbers, work.series, state.now
    blend, bars, blends = state.blend, state.bars, state.blends
    n, count, q, resting = law.modes.shape[1], bars.shape[1], c.size, now[RESTING] > 0.0
    sign = 0.0 if resting else now[SIGN]
    drag = DRAG_OUT if sign > 0.0 else DRAG_BACK
    flows = g[FED] > 0.0 and now[OPEN] != KEPT
    size = 2 * q if flows else q
    if work.span[1] != t:
        tabulated(law, work, t)
    # of the force by place and speed of the driven end and by the pressure, of P′ by that speed and the pressure
    matrix, columns = work.matrix, work.columns
    for m in range(q):
        x = t * c[m]
        a, b = blend[0, AREA] + blend[1, AREA] * x, blend[0, drag] + blend[1, drag] * x
        u, v, pressure = value(s[U], x, order), value(s[V], x, order), value(s[P], x, order)
        gu, gv, pv, pp, capacity = -g[KAPPA], -2.0 * sign * b * v, 0.0, 0.0, 1.0
        if g[GAS] != 0.0:
            gu -= g[EXPONENT] * g[GAS] / g[COLUMN] * (1.0 + u / g[COLUMN]) ** (-g[EXPONENT] - 1.0)
        if resting:
            gu = gv = 0.0
        if flows:
            limited, opened, filled = now[LIMITED] > 0.0, now[OPEN] == OPENED, now[FILLED] > 0.0
            rise, capacity, gas = supplied(g, pressure, a * v, limited, opened, filled)
            bends = (-1.0 / g[POLYTROPIC] - 1.0) * gas / (pressure + g[ATMOSPHERE]) if gas > 0.0 else 0.0
            pp = -g[POWER] / (pressure * pressure) if limited else -g[SLIP]
            pp -= g[LEAK] + (g[SLOPE] if opened else 0.0) + bends * rise / capacity
            pv, pp = -a / capacity, pp / capacity
        push, rises = columns[m], columns[size - q + m]
        for d in range(count):
            wide = blends[0, AREA, d] + blends[1, AREA, d] * x
            rises[d] = pp * bars[2 * n, d] - wide * v / capacity
            push[d] = a * bars[2 * n, d] + wide * pressure
            push[d] += g[TANK] * (blends[0, TANKED, d] + blends[1, TANKED, d] * x)
            push[d] -= sign * (blends[0, drag, d] + blends[1, drag, d] * x) * v * v
        place, rate = work.seen[0, m], work.seen[1, m]
        for i in range(n):
            a0, a1 = gu * place[i] + gv * rate[i], gu * place[n + i] + gv * rate[n + i]
            if flows:
                both_added(push, rises, a0, a1, pv * rate[i], pv * rate[n + i], bars[i], bars[n + i])
            else:
                added(push, a0, bars[i])
                added(push, a1, bars[n + i])
        for j in range(q):
            matrix[m, j] = -gu * work.pulled[0, m, j] - gv * work.pulled[1, m, j]
            if flows:
                matrix[m, q + j], matrix[q + m, j] = -a * x * work.swept[m, j], -pv * work.pulled[1, m, j]
                matrix[q + m, q + j] = -pp * x * work.swept[m, j]
        matrix[m, m] += 1.0
        if flows:
            matrix[q + m, q + m] += 1.0
    solved(matrix, columns, size)
    for i in range(n):
        if resting:
            break
        place, rate = bars[i], bars[n + i]
        for d in range(count):
            p, r = place[d], rate[d]
            place[d] = work.turned[0, i] * p + work.turned[1, i] * r
            rate[d] = work.turned[2, i] * p + work.turned[3, i] * r
        for m in range(0, q, 2):
            k, r = work.answers[0, i], work.answers[1, i]
            both_added(place, rate, k[m], k[m + 1], r[m], r[m + 1], columns[m], columns[m + 1])
    if flows:
        for m in range(q):
            added(bars[2 * n], t * work.nodes[1, m], columns[q + m])
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
        limited, opened, filled = now[LIMITED] > 0.0, now[OPEN] == OPENED, now[FILLED] > 0.0
        rise, capacity, _ = supplied(g, pressure, blend[0, AREA] * v, limited, opened, filled)
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
