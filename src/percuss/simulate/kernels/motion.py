"""The motion from event to event, under a clock or with a valve of its own.

One loop follows both: `valve` is None under a clock, and numba leaves out what stands behind `if valve is not None`.
Of a machine, contact, crossings of ports and orders that are due compete (`valve_motion`); of simultaneous events the
blow comes first, then the ports in their order, then the orders.
"""

from __future__ import annotations

import math

from percuss.compiled import entry, inlined, inner
from percuss.simulate.kernels.bounds import (
    advance,
    amplitudes_apart,
    drifted,
    jump_back,
    rigid_rate,
    smooth,
    smooth_at_anchor,
)
from percuss.simulate.kernels.clock import (
    first_pull,
    pull_ahead,
    pull_lasts,
    push_left,
    release_at,
    set_clock,
    set_load,
    set_phase,
    to_break,
    turn_clock,
)
from percuss.simulate.kernels.first_contact import like_flight, next_contact
from percuss.simulate.kernels.modes import elastic_apart, forced_modes, turn_modes
from percuss.simulate.kernels.motion_records import (
    ASKED,
    AT_REST,
    AWAY,
    BY_IMPACTS,
    BY_TIME,
    BY_WORK,
    CHATTER,
    CONTACT,
    CROWDED,
    DEPARTED,
    EPS,
    FLYING,
    FULL,
    GOES_ON,
    GRAZE,
    GRAZED,
    GRAZING,
    HANDED,
    IMPACT,
    IN_CHAMBER,
    LOOSE,
    LOST_CYCLE,
    NO_PORT,
    NOTHING,
    ON_PORT,
    ON_WALL,
    PERIODIC,
    RELEASE,
    REST,
    RESTING,
    SLICE,
    STRIDE,
    TIRED,
    TO_VERIFY,
    TURN,
    TWIN,
    UNRESOLVED,
    MotionTable,
    PortView,
    Rules,
    ValveArguments,
)
from percuss.simulate.kernels.statistics import (
    clear,
    concluded,
    concluded_of_valve,
    forget_marked,
    forget_run,
    mark,
    record,
    recurrence,
    sure,
    tally,
    wandering,
)
from percuss.simulate.kernels.valve_motion import (
    change,
    contested,
    fire,
    gear_in,
    handed,
    modes_in,
    occupied,
    put_valve,
    sliding,
)
from percuss.simulate.kernels.valve_sight import (
    demand,
    first_due,
    go_by,
    next_order,
    oil_moved,
    pace,
    push_on_rigid_motion,
    recharge,
    rigid_place,
)
from percuss.simulate.kernels.wall import (
    at_rest,
    chatter_left,
    energy_at_rest_lost,
    force_on_modes,
    held,
    impact,
    keep_shape,
    stays,
)

# ---- The steps of a load


@inner
def step_load(table, motion):
    """On to the next step of a piecewise constant load."""
    bar, breaks, values, now, count = table.bar, table.breaks, table.values, motion.now, motion.count
    piece = count.piece + 1
    if piece == breaks.shape[0]:
        piece = 0
    if breaks[piece] < now.phase:
        count.period += 1
    set_phase(now, breaks[piece])
    count.piece = piece
    jump_back(table, motion, bar.load, values[piece])
    set_load(bar, values[piece])


@inner
def left_for_good(table, now):
    """Whether a bar under a load of steps has left for good; asked each time the first step begins."""
    # From period to period the mean of the bar moves by less and less when the load's mean does not push and nothing
    # drags, or by an amount that tends to a pull from one side: once it has moved away in a period it moves away in
    # all. Each step adds at most its static shape to the elastic amplitudes.
    bar, modes, breaks, values = table.bar, table.modes, table.breaks, table.values
    turn, mean, force, jumps = TURN, 0.0, 0.0, 0.0
    for i in range(values.shape[0]):
        length = (breaks[i + 1] if i + 1 < values.shape[0] else breaks[0] + TURN) - breaks[i]
        mean += values[i] * length
        force = max(force, abs(values[i]))
        jumps += abs(values[i] - values[i - 1])
    still, stiff = 0.0, 0.0
    for j in range(modes.omega.shape[0]):
        still += modes.statics[j]
        stiff += abs(modes.statics[j])
    place = now.gap - now.free - bar.mean * still
    before = now.last_place
    now.last_place = place
    if mean > 0.0 or before == 0.0 or bar.held > 0.0:
        return False
    growth, later = 4.0 * jumps * stiff, 0.0
    if bar.linger > 0.0:
        later = growth / -math.expm1(-bar.linger * turn)
    elif (
        bar.damping > 0.0 and stiff > 0.0
    ):  # what the steps add never dies out, while the mean of the bar comes to rest
        return False
    if place - before + growth >= 0.0:
        if place - before >= 0.0 or bar.linger == 0.0:
            return False
        growth = later
    swing = turn * (max(now.rigid_rate, 0.0) + 2.0 * force * turn)
    return place + swing + now.sup + force * stiff + growth < 0.0


# ---- The motion from event to event

NO_SPEED = 1e-13  # a rebound slower than this, of the speeds that occur, is no rebound
QUARTER = 0.3  # of the time in which a chamber turns a released machine round, in radians of its frequency


@inlined
def fly(table, motion, desk, rules, log, valve, sight):
    """The motion from the anchor on, event after event, until a stop rule holds or the record is full."""
    # The anchor stays at the last event (or break of the load) when time ends, so that going on gives the same bits.
    bar, now, count = table.bar, motion.now, motion.count
    room = log.events.shape[0] - 4
    if valve is not None:
        room -= valve.gear.to.shape[0] + 4
    while True:
        if count.impacts >= rules.most_impacts:
            return BY_IMPACTS
        if room > 0 and count.events > room:
            return FULL
        if count.work >= rules.budget:
            return BY_WORK
        if valve is None:
            left = (rules.end_period - count.period) * TURN + (rules.end_phase - now.phase)
        else:
            own, ports = valve.controls.now, valve.gear.to.shape[0]
            if own.waiting + ports > valve.controls.due.shape[0]:  # each port may demand once before the next look
                return CROWDED
            if own.handed == 0 and first_due(valve) <= 0.0:
                own.before, own.handed = own.state, 1
                own.state = next_order(valve.controls)
                if valve.gear.flow > 0.0:  # the modes are others in another state
                    return HANDED
            if own.handed > 0:
                change(table, motion, desk, rules.tolerance, log, valve)
                if sliding(valve.controls):
                    return ON_PORT
                if rules.until_cycle and own.confirmed >= 2:
                    return PERIODIC
                continue
            left = (rules.end_phase - own.time) - own.time_low
        if count.mode == RESTING:
            code = released(table, motion, desk, left, log, valve)
            if code != GOES_ON:
                return code
            continue
        if valve is None:
            ahead, first = to_break(now, count, table.breaks), 0.0
        else:
            ahead, first = first_due(valve), rigid_place(table, motion, valve.controls.now.force)
            bar.mean = push_on_rigid_motion(bar, valve, first)
        smooth_at_anchor(bar, table.harmonics, now, desk.osc)
        code, found, tau, speed, late, slip = GOES_ON, NOTHING, 0.0, now.gap_rate, 0.0, 0.0
        if (count.mode == ON_WALL or count.mode == GRAZED) and now.hold == 0.0:
            code, found = at_wall(table, motion, desk, left, ahead, log, valve)
        if code == AT_REST:
            continue
        if code == GOES_ON and found == NOTHING:
            if valve is None:
                code, found, tau, speed, late, slip = flown(table, motion, desk, rules, left, ahead)
            else:
                code, found, tau, speed, late, slip = contested(
                    table, motion, desk, rules, left, ahead, first, log, valve, sight
                )
            if code == GOES_ON and found != NOTHING:
                arrive(table, motion, desk, found, tau, speed, late, slip, ahead, valve)
        if code != GOES_ON:
            return code
        if found == NOTHING:
            continue
        if found == GRAZE:
            grazed(table, motion, tau, log, valve)
            if valve is not None and valve.controls.now.stalled > 0 and table.modes.omega.shape[0] == 0:
                return IN_CHAMBER
            continue
        count.mode, now.hold, now.last_place, now.gap_rate = ON_WALL, 0.0, 0.0, speed
        strike(table, motion, desk, rules, log, valve)
        if valve is not None:
            fire(table, motion, tau, True, log, valve)
        if count.verdict == ASKED:
            return TO_VERIFY
        if rules.until_cycle and count.confirmed >= 2:
            return PERIODIC


@inlined
def released(table, motion, desk, left, log, valve):
    """A bar that rests let go as it begins to be pulled, or on to the next order; or how its motion ends before."""
    # The end of a machine's bar only moves away until the force pushes again or, in a chamber, until the spring turns
    # it round, and until that has run through the bar as a wave.
    bar, now, count = table.bar, motion.now, motion.count
    if valve is None:
        if bar.held > 0.0 and table.modes.omega.shape[0] > 1:  # the others would move on, while the wall holds its end
            return AT_REST
        wait, phase = pull_ahead(table, now)
        if wait < 0.0:
            return AT_REST
        if wait >= left:
            return BY_TIME
        if bar.held > 0.0:
            keep_shape(table, motion, desk, bar.load)
        set_clock(table, now, count, phase)
        now.released = -1.0 if bar.held > 0.0 else release_at(phase, table.releases)
        count.release_period = count.period
    else:
        own, due = valve.controls.now, first_due(valve)
        lifted = own.force / -bar.ramp if bar.ramp < 0.0 else math.inf
        if own.force >= 0.0 and lifted != 0.0:
            wait = min(due, lifted)
            if wait == math.inf:
                return AT_REST
            if wait > left:
                return BY_TIME
            go_by(motion, wait, valve)
            if lifted < due:
                own.force = 0.0
            return GOES_ON
        own.lap, own.pulled, own.clear, own.awaited = bar.wave, 1, 0.0, 0.0
        count.pile = 0
    at_rest(table, motion, desk, force_on_modes(bar, valve))
    count.mode, count.run = ON_WALL, 0
    count.work += 1
    if valve is not None:
        now.hold = math.inf if bar.spring == 0.0 else max(bar.wave, QUARTER / bar.spring)
        if bar.ramp > 0.0:  # the force pushes again
            now.hold = min(now.hold, -valve.controls.now.force / bar.ramp)
    elif bar.held > 0.0:
        now.hold = min(pull_lasts(table, now, count), bar.wave)
    elif table.modes.omega.shape[0]:
        now.hold = max(pull_lasts(table, now, count), bar.wave)
    else:
        now.hold = first_pull(bar, table.harmonics, now)
    now.last_flight, now.since = -1.0, 0.0
    record(RELEASE, 0.0, 0.0, NO_PORT, motion, valve, log)
    return GOES_ON


@inlined
def at_wall(table, motion, desk, left, ahead, log, valve):
    """What a bar on the wall does: CONTACT when it strikes at once, or NOTHING when it flies; AT_REST, laid down."""
    # `ahead`: time to the load's next step, or the valve's next order.
    now, count = motion.now, motion.count
    slow = NO_SPEED * (abs(now.drift) + table.bar.rate + now.sup1)
    if now.gap_rate > slow:
        if valve is not None:
            valve.controls.cross[:] = math.inf
        return GOES_ON, CONTACT
    if now.gap_rate >= -slow:
        if stays(table, motion, valve) or count.pile > 100:
            set_down(table, motion, desk, 0.0, log, valve)
            return AT_REST, NOTHING
        now.gap_rate = 0.0
        return GOES_ON, NOTHING
    most = held(table, motion)
    wait = 0.0
    if most < 0.0 or energy_at_rest_lost(table, motion, desk, force_on_modes(table.bar, valve)) > most:
        wait = chatter_left(table, motion, desk, ahead)
    if wait >= left:
        return BY_TIME, NOTHING
    if wait >= 0.0:
        set_down(table, motion, desk, wait, log, valve)
        return AT_REST, NOTHING
    return GOES_ON, NOTHING


@inlined
def flown(table, motion, desk, rules, left, ahead):
    """A flight under a clock to the CONTACT or GRAZE that ends it, or over a step of the load."""
    # `left`, `ahead`: time to the end and to the load's next step. Returns how the motion ends, or GOES_ON; what was
    # found, its time, the speed, and what `arrive` needs. Nothing has moved where time ends, so that going on gives the
    # same bits.
    now, count, over = motion.now, motion.count, BY_TIME if left < math.inf else DEPARTED
    if left <= 0.0:
        return BY_TIME, NOTHING, 0.0, 0.0, 0.0, 0.0
    on_wall, guess = count.mode == ON_WALL or count.mode == GRAZED, 0.0
    if count.mode == ON_WALL and now.last_flight > 0.0 and now.hold == 0.0:
        guess = like_flight(motion)
        if guess == 0.0 and count.run > 1:  # of a chatter
            guess = table.bar.restitution * now.last_flight
            if now.acceleration > 0.0 and now.sup3 * guess < now.acceleration:
                guess = -2.0 * now.gap_rate / now.acceleration
    found, tau, speed, steps, late, slip = next_contact(
        table, motion, desk, on_wall, now.hold, guess, min(left, ahead), rules.budget - count.work
    )
    code = GOES_ON
    if found == NOTHING and left <= ahead:
        return over, NOTHING, tau, speed, late, slip
    count.work += steps + 1
    if found == TIRED:
        now.hold, code = tau, BY_WORK
    elif found == AWAY and (table.breaks.shape[0] == 0 or left <= ahead):
        code = over
    elif found != CONTACT and found != GRAZE:  # until the load's next step
        over_step(table, motion, desk, ahead)
        found = NOTHING
        if count.piece == 0 and left_for_good(table, now):
            code = over
    return code, found, tau, speed, late, slip


@inlined
def over_step(table, motion, desk, ahead):
    """On to the load's next step, which comes after a time `ahead` without a contact."""
    now, count = motion.now, motion.count
    advance(table, motion, desk, ahead)
    step_load(table, motion)
    now.since += ahead
    count.mode = FLYING
    if now.hold > 0.0:  # just released: not out of the wall's reach before the load pushes again
        now.hold = now.hold - ahead if now.hold - ahead > 1e-12 else 0.0
        if now.hold == 0.0 and now.gap >= 0.0:
            now.gap, count.mode = 0.0, ON_WALL


@inlined
def arrive(table, motion, desk, found, tau, speed, late, slip, ahead, valve):
    """The anchor moved to a contact or a graze at τ."""
    bar, modes, breaks, now, count, z = table.bar, table.modes, table.breaks, motion.now, motion.count, motion.z
    if found == GRAZE:  # the bar goes on from where it is, not from the wall
        ds, _, _ = smooth(bar, now, desk.osc, tau)
        df, _, _, _ = elastic_apart(bar, modes, z, now, desk, tau)
        now.gap += ds + df
    moves, rest = modes.omega.shape[0] > 0 or found == GRAZE, speed
    if moves:
        rest = drifted(bar, now, tau)
        turn_modes(bar, modes, z, desk, tau, late, slip)
    if valve is None:
        turn_clock(now, count, tau)
        now.rigid_rate = rigid_rate(bar, table.harmonics, rest, now.cosine, now.sine) if moves else speed
        if breaks.shape[0] and to_break(now, count, breaks) > ahead:
            set_phase(now, breaks[(count.piece + 1) % breaks.shape[0]])  # rounded past the step
        now.since += tau
    elif tau > 0.0:
        go_by(motion, tau, valve)
        now.rigid_rate = rest


@inlined
def grazed(table, motion, tau, log, valve):
    """A touch that rounding does not tell from a miss, from which the bar flies on."""
    now, count = motion.now, motion.count
    amplitudes_apart(table.bar, table.modes, motion.z, now)
    count.mode, now.hold, now.last_place, now.gap_rate = GRAZED, 0.0, 0.0, 0.0
    count.pile = count.pile + 1 if tau < 4.0 * EPS else 0
    if count.pile > 100:
        now.hold, count.pile = 1e-8, 0
    if valve is not None:
        valve.controls.now.clear = 0.0
    record(GRAZING, 0.0, 0.0, NO_PORT, motion, valve, log)


@inlined
def strike(table, motion, desk, rules, log, valve):
    """One impact with all that is kept of it."""
    bar, now, count, past = table.bar, motion.now, motion.count, motion.past
    speed, fresh = now.gap_rate, now.last_flight < 0.0
    if valve is None:
        if count.run == 1 and now.since < bar.pushing:
            now.pushes = push_left(table, now)
        lost = impact(table, motion, desk, bar.load)
    else:
        lost = impact_on_oil(table, motion, desk, valve)
    count.run = count.run + 1 if now.since < now.last_flight and still_pushed(table, motion, valve) else 1
    now.last_flight = math.inf if fresh else now.since
    count.pile = count.pile + 1 if now.since < 4.0 * EPS else 0
    now.since = 0.0
    count.impacts += 1
    if valve is None:
        tally(speed, lost, motion)
        if count.impacts == rules.skip and count.confirmed == 0:
            if count.mark == 0:
                clear(motion)
            for j in range(motion.totals.shape[1]):
                motion.totals[1, j] = -motion.totals[0, j]  # those of the cycle that may have begun are kept
        i = (count.impacts - 1) & (past.shape[0] - 1)
        past[i].phase, past[i].speed, past[i].period = now.phase, speed, count.period
    else:
        own = valve.controls.now
        own.pulled, own.clear, own.awaited, own.fresh = 1 if own.force < 0.0 else 0, 0.0, 0.0, 0
        own.blows += 1
        own.taken += lost
        own.strongest = max(own.strongest, speed)
    record(IMPACT, speed, lost, NO_PORT, motion, valve, log)
    if valve is None and rules.tolerance > 0.0:
        recurrence(bar, table.modes, speed, fresh, motion, rules.tolerance)


@inlined
def impact_on_oil(table, motion, desk, valve):
    """The impact of a machine, whose oil moves where the strain is turned over; returns the energy that it takes."""
    now, own, force, kept = motion.now, valve.controls.now, valve.controls.now.force, 0.0
    now.gap = 0.0
    if force < 0.0:
        own.pulled = 1
    if table.bar.strain != 1.0 and table.modes.omega.shape[0] > 0:
        kept = oil_moved(table, motion, table.bar.strain, valve)
    lost = impact(table, motion, desk, force) - kept
    if own.force != force:
        jump_back(table, motion, force, own.force)
    return lost


@inlined
def still_pushed(table, motion, valve):
    """Whether the bar was pushed all the time since an impact that came ever sooner after the one before."""
    now = motion.now
    if valve is not None:
        return valve.controls.now.pulled == 0
    if table.bar.held > 0.0:
        return True
    if not now.since < table.bar.pushing:
        return False
    now.pushes -= now.since
    # a pull during the flight is not yet at the wall
    return now.pushes >= 0.0 or (table.modes.omega.shape[0] > 0 and now.since < table.bar.wave)


@inner
def set_down(table, motion, desk, wait, log, valve):
    """The body comes to rest on the wall, after `wait` when chatter ends then: motion, and strain of a bar, is lost."""
    bar, now, count = table.bar, motion.now, motion.count
    lost = energy_at_rest_lost(table, motion, desk, force_on_modes(bar, valve))
    # without restitution there are finitely many impacts
    chatter = bar.restitution > 0.0 and (count.run > 1 or wait > 0.0)
    if valve is None:
        if bar.held > 0.0:
            keep_shape(table, motion, desk, bar.load)
        if wait > 0.0:
            turn_clock(now, count, wait)
        motion.sums[0].taken += lost
        now.laid += now.phase
        count.rests += 1
        if chatter:
            now.chattered = 1.0
            forget_run(motion)
            count.chatters += 1
            count.mark_chatters += 1
    else:
        own = valve.controls.now
        lost -= oil_moved(table, motion, 0.0, valve)
        own.taken += lost
        go_by(motion, wait, valve)
        own.clear = 0.0
        own.rests += 1
        if chatter:
            own.chatters += 1
            own.blows -= count.run - 1
    at_rest(table, motion, desk, force_on_modes(bar, valve))
    count.mode = RESTING
    if chatter:
        record(CHATTER, 0.0, lost, NO_PORT, motion, valve, log)
        lost = 0.0
    record(REST, 0.0, lost, NO_PORT, motion, valve, log)
    if valve is not None and chatter:  # the last of its blows
        fast = pace(table, motion, 0.0, valve)
        for port in range(valve.gear.to.shape[0]):
            if valve.gear.side[port] == 0.0:
                demand(motion, port, 0.0, fast, log, valve)


# ---- A motion put where it begins


@inner
def put(table, motion, desk, starts, i):
    """The anchor at start number i: q_n and q_n' (those left out are 0), the gap, the clock; all else is set to 0."""
    bar, modes, now, count, z = table.bar, table.modes, motion.now, motion.count, motion.z
    u, v = starts.displacement[i], starts.velocity[i]
    motion.numbers[:] = 0.0
    motion.wholes[:] = 0
    motion.anchor[:] = 0.0
    motion.totals[:] = 0.0
    if table.values.shape[0]:
        set_load(bar, table.values[starts.piece[i]])
    count.period, count.piece = starts.period[i], starts.piece[i]
    set_phase(now, starts.phase[i])
    still = v[0] == 0.0 and starts.gap[i] == 0.0 and bar.held == 0.0
    rate = v[0]
    for j in range(modes.omega.shape[0]):
        z[0, j] = modes.unit[j] * u[j + 1] if j + 1 < u.shape[0] else 0.0
        z[1, j] = modes.unit[j] * v[j + 1] if j + 1 < v.shape[0] else 0.0
        still = still and z[0, j] == 0.0 and z[1, j] == 0.0
        rate += z[1, j]
    forced_modes(table, desk, now.cosine, now.sine, 0)
    for j in range(modes.omega.shape[0]):
        z[0, j] -= desk.forced[j] + bar.load * modes.statics[j]
    forced_modes(table, desk, now.cosine, now.sine, 1)
    for j in range(modes.omega.shape[0]):
        z[1, j] -= desk.forced[j]
        if modes.oscillates[j] > 0.0:
            z[1, j] = -modes.inverse[j] * (z[1, j] + modes.half[j] * z[0, j])
    now.gap, now.gap_rate, now.rigid_rate, now.last_flight = starts.gap[i], rate, v[0], -1.0
    now.released = -1.0
    amplitudes_apart(bar, modes, z, now)
    # at_rest, at rest and on the wall: released at once when the load pulls
    count.mode = RESTING if still else (ON_WALL if starts.gap[i] == 0.0 else FLYING)


@entry
def put_first(table, motion, desk, starts):
    """A motion at the first of the starts."""
    put(table, motion, desk, starts, 0)


# ---- One motion or many, to their ends

NUDGE = 1e-12  # change of R and d under which a cycle from release to release must stay the same to be stated


@inner
def released_as(table, motion, twin):
    """The twin of a motion set to the release that later ones are compared with, and d and R a little changed."""
    bar = table.bar
    bar.damping += NUDGE  # all three slow the bar down
    bar.half += 0.5 * NUDGE
    bar.restitution *= 1.0 - NUDGE
    twin.numbers[:] = 0.0
    twin.wholes[:] = 0
    twin.anchor[:] = 0.0
    twin.totals[:] = 0.0
    set_clock(table, twin.now, twin.count, motion.now.marked)
    twin.now.last_flight, twin.count.mode, twin.count.verdict = -1.0, RESTING, TWIN


@inner
def judged(motion, twin, code, until_cycle):
    """Whether the cycle between two equal releases is sure: its twin, with R and d changed by `NUDGE`, is the same."""
    # The twin begins with the same release; it must take as many load periods, and be laid down at the same phases to
    # `LOOSE`. An error that grows by less than `LOOSE`/`NUDGE` from release to rest leaves of rounding a thousandth of
    # that. `code`: how the twin ended. Returns how the motion ends with it: `PERIODIC`, `UNRESOLVED`, or `BY_WORK` when
    # it is to go on.
    count = motion.count
    off = abs(twin.now.laid - motion.now.laid)
    off = min(off % TURN, TURN - off % TURN)
    same = twin.count.cycle_periods == count.cycle_periods and twin.count.cycle_kind == count.cycle_kind
    if code == TO_VERIFY and same and off < LOOSE:
        sure(motion)
        return PERIODIC if until_cycle and count.confirmed >= 2 else BY_WORK
    count.verdict, count.cycle_impacts, count.cycle_periods = LOST_CYCLE, 0, 0
    if until_cycle:  # the means are those between the two releases
        forget_marked(motion)
    mark(motion)
    return UNRESOLVED if until_cycle else BY_WORK


@entry
def follow(table, starts, ends, rules, motion, twin, desk, log, none, stopped, members, tail):
    """Motions from all starts, one after the other; or one, from where it stands, where there are no starts.

    Everything is in this one function, with a single place that `fly` is called from: each function that calls another
    one is compiled with all of it again.

    Parameters
    ----------
    table, desk
        The system, and room to work in.
    starts, ends
        Where the motions begin, and load periods and phases at which they end, shape (starts, 2); `ends` has one row
        where there are no starts.
    rules
        When all of them end, besides.
    motion, twin
        The motion, and room for another one that tells whether a cycle between two releases is sure.
    log, none
        The record, which is full before it is too small, and an empty one.
    stopped
        Looked at between two motions, and from time to time: not 0 when there is to be an end.
    members, tail
        What is kept of each motion, and its last impacts. Of a motion without a start only
        `ended` and `wanders`.
    """
    bar, count, past = table.bar, motion.count, motion.past
    alone = starts.gap.shape[0] == 0
    for i in range(members.shape[0]):
        if stopped[0]:
            return i
        if not alone:
            put(table, motion, desk, starts, i)
        whole = (bar.damping, bar.half, bar.restitution, bar.load)
        checked, code = False, BY_WORK
        while True:
            budget = rules.budget if alone else min(count.work + SLICE, rules.budget)
            own = Rules(
                ends[i, 0], ends[i, 1], rules.most_impacts, rules.until_cycle, rules.tolerance, rules.skip, budget
            )
            its = Rules(
                math.inf,
                0.0,
                2 * count.cycle_impacts + 256,
                rules.until_cycle and not checked,
                rules.tolerance,
                0,
                2 * count.work + SLICE,
            )
            who = twin if checked else motion
            code = fly(table, who, desk, its if checked else own, none if checked else log, None, None)
            if checked:
                checked = False
                bar.damping, bar.half, bar.restitution, load = whole
                set_load(bar, load)
                code = judged(motion, twin, code, rules.until_cycle)
            elif code == TO_VERIFY:
                checked = True
                whole = (bar.damping, bar.half, bar.restitution, bar.load)
                released_as(table, motion, twin)
                continue
            if alone or code != BY_WORK or count.work >= rules.budget or stopped[0]:
                break
        if alone:
            members[i].ended, members[i].wanders = code, wandering(past, count.impacts)
            continue
        if stopped[0] and code == BY_WORK:
            return i
        concluded(motion, code, members[i])
        kept = tail.shape[1]
        for j in range(min(kept, count.impacts)):
            last = past[(count.impacts - 1 - j) & (past.shape[0] - 1)]
            row = tail[i, kept - 1 - j]
            row.phase, row.speed, row.period = last.phase, last.speed, last.period
    return members.shape[0]


@entry
def follow_valve(plant, starts, rules, log, first, goes_on, stopped, members):
    """As `follow`, of a machine: from start number `first` on or, where it `goes_on`, from where that motion stands.

    Returns how many have ended. The next one has not, when there was an end, or its orders are CROWDED.
    """
    motion, controls, count, own = plant.motion, plant.controls, plant.motion.count, plant.controls.now
    parts, single, stride = plant.table, plant.alone, STRIDE // (motion.z.shape[1] + 30)
    waves, none, goes_alone = parts.harmonics, parts.values, starts.rows.shape[0] == 0
    for i in range(first, members.shape[0]):
        if stopped[0]:
            return i
        fresh = i > first or not goes_on
        if fresh:
            put_valve(motion, controls, plant.words, starts, i)
        while True:
            k = min(own.state, parts.bar.shape[0] - 1)
            table = MotionTable(parts.bar[k], modes_in(parts.modes, k), waves, parts.coupling, none, none, none)
            alone = MotionTable(single.bar[k], modes_in(single.modes, k), waves, single.coupling, none, none, none)
            valve = ValveArguments(gear_in(plant.gear, k), controls)
            if fresh:
                fresh = False
                recharge(valve, 0.0)
                amplitudes_apart(table.bar, table.modes, motion.z, motion.now)
                if starts.rows[i].asked > 0:
                    occupied(table, motion, log, valve)
            budget = rules.budget if goes_alone else min((count.work // stride + 1) * stride, rules.budget)
            its = Rules(
                rules.end_period, rules.end_phase, rules.most_impacts, rules.until_cycle, rules.tolerance, 0, budget
            )
            code = fly(table, motion, plant.desk, its, log, valve, PortView(alone, plant.eye, plant.spot, plant.bench))
            if code == HANDED:
                handed(plant)
            elif code != BY_WORK or goes_alone or count.work < budget or count.work >= rules.budget or stopped[0]:
                break
        if code == CROWDED or (stopped[0] and code == BY_WORK):
            return i
        concluded_of_valve(motion, controls, code, members[i])
    return members.shape[0]
