"""A machine whose oil flows, from event to event, compiled; the steps are those of `oil_series`."""

from __future__ import annotations

import math

from percuss.compiled import entry, inner
from percuss.mechanics.oil_records import (
    AT_CHARGE,
    AT_CORNER,
    AT_RELIEF,
    AT_SECTION,
    AT_ZERO,
    BEND,
    BLOWS,
    BY_BLOWS,
    BY_TIME,
    CLOSED,
    CLOSES,
    COMPLIANCE,
    CORNER,
    CORNER_TO,
    COUNT,
    CROWDED,
    DELAY,
    DRIVEN,
    DRY,
    EMPTIES,
    EMPTY_LINE,
    END,
    EVENT,
    FACTOR,
    FED,
    FILLED,
    FILLS,
    FULL_FLOW,
    HOLD,
    IMPACT,
    IMPACT_LOSS,
    KEPT,
    LAST,
    LEAVES,
    LEVEL,
    LIMITED,
    LIMITS,
    LOG_FULL,
    NO_PRESSURE,
    NO_STEP,
    OF_SPEED,
    OMEGA2,
    ON_IMPACT,
    OPEN,
    OPENED,
    OPENS,
    PORT_MET,
    PRECHARGE,
    PRESSURE,
    QUICKENING,
    RELIEF,
    REST,
    RESTING,
    SIDE,
    SIGN,
    SLOPE,
    SPEED,
    SPOOL,
    STATE,
    STEP,
    STEPS_FULL,
    STRAIN,
    STROKE,
    TIME,
    TO,
    TURNED,
    UNIT,
    VALVE,
    VOLUME,
    WALL,
    WAVE,
    F,
    N,
    P,
    V,
)
from percuss.mechanics.oil_series import (
    expanded,
    held_by,
    jumped,
    linearised,
    met,
    modes_at,
    moved_by,
    rates_of,
    read,
    step_length,
    timed,
    value,
)

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
    rates_of(law, state, work.after)
    for d in range(bars.shape[1]):
        for i in range(2 * n + 1):
            bars[i, d] -= work.after[i] * work.times[d]
    now[BLOWS] += 1.0
    speed = push = 0.0
    for i in range(n):
        speed -= law.modes[END, i] * bar[1, i]
    now[WALL] = 1.0 if speed > 0.0 else 2.0
    work.before[2 * n] = work.after[2 * n]  # what a delay that follows the pressure asks for
    for i in range(law.ports.shape[0]):
        if law.ports[i, ON_IMPACT] > 0.0:
            demanded(law, state, work, log, i)
    while now[COUNT] > 0.0 and state.orders[0, 0] <= now[TIME]:
        carried_out(law, state, work, log)
    force = rates_of(law, state, work.after)
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
    now[OPEN] = CLOSED
    if g[FED] > 0.0 and now[PRESSURE] >= g[RELIEF]:
        now[OPEN] = OPENED if g[SLOPE] < math.inf else KEPT
        if g[SLOPE] == math.inf:
            now[PRESSURE] = g[RELIEF]
    pressure = now[PRESSURE]  # what an ideal relief valve leaves of it
    now[FILLED] = 1.0 if g[VOLUME] > 0.0 and pressure > g[PRECHARGE] else 0.0
    now[LIMITED] = 1.0 if g[CORNER] < pressure < g[CORNER_TO] else 0.0


# ---- From event to event

_NOTHING, _WALL, _TURN, _LEAVE, _DRY, _CHARGE, _RELIEF, _CORNER, _CLOSE = range(9)


@inner
def sighted(law, state, work, h):
    """The first event of the step within h: its time as a part of h, and what it is, ports counted from 100 on."""
    order = work.series.shape[1] - 2
    g, now, s = law.numbers, state.now, work.series
    best, what, row = 2.0, _NOTHING, s[BEND]
    if now[RESTING] > 0.0:
        time = met(s[F], 0.0, h, -1.0, 0, work)
        if time < best:
            best, what = time, _LEAVE
    else:
        if now[HOLD] <= now[TIME]:
            read(law.modes[END], work.places, row, order)
            time = met(row, 0.0, h, 1.0, int(now[WALL]), work)
            if time < best:
                best, what = time, _WALL
        for j in range(law.ports.shape[0]):
            if law.ports[j, ON_IMPACT] > 0.0 or law.ports[j, TO] == now[LAST] or now[HOLD] == math.inf:
                continue
            read(law.reads[j], work.rates if law.ports[j, OF_SPEED] > 0.0 else work.places, row, order)
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


_WIDER = 1.25  # steps that might be so much longer


@entry
def followed(law, state, work, log, until, exact, blows, steps, section, since, entering):
    """A motion until a time, so many blows in all, so many steps, or a port is met.

    Where the time is not asked for exactly the motion ends at the beginning of the step that would go beyond it, so
    that it goes on with the same bits. `section` is the number of a port, −1 for none, met after `since` blows and not
    demanded yet; `entering` those of the ports, and of the blow, that demand first. How it ended.
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
        if n > 1 and state.bars.shape[1] > 0:  # equal steps, whose tables stand
            if not work.span[0] <= h <= _WIDER * work.span[0]:
                work.span[0] = h / math.sqrt(_WIDER)
            h = work.span[0]
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
        moved_by(law, state, work, taken, section < 0)
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
    """Of steps, and times after their beginnings: places and rates of the modes, pressure and force, (t, 2 n + 2)."""
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
        modes_at(law, work, times[m], found[m, :n], found[m, n : 2 * n])
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
