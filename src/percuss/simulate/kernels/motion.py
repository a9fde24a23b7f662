"""The motion from event to event."""

from __future__ import annotations

import math

from percuss.compiled import entry, inlined, inner
from percuss.simulate.kernels.bounds import amplitudes, drifted, rigid_rate, smooth, smooth_at_anchor
from percuss.simulate.kernels.clock import (
    first_pull,
    pull_ahead,
    pull_lasts,
    push_left,
    release_at,
    set_clock,
    set_phase,
    to_break,
    turn_clock,
)
from percuss.simulate.kernels.first_contact import like_flight, next_contact
from percuss.simulate.kernels.modes import elastic, forced_modes, turn_modes
from percuss.simulate.kernels.motion_records import (
    ASKED,
    AT_REST,
    AWAY,
    BY_IMPACTS,
    BY_TIME,
    BY_WORK,
    CONTACT,
    DEPARTED,
    EPS,
    FLYING,
    FULL,
    GOES_ON,
    GRAZE,
    GRAZED,
    GRAZING,
    IMPACT,
    LOOSE,
    LOST_CYCLE,
    NO_PORT,
    NOTHING,
    ON_WALL,
    PERIODIC,
    RELEASE,
    RESTING,
    SLICE,
    TIRED,
    TO_VERIFY,
    TURN,
    TWIN,
    UNRESOLVED,
    Rules,
)
from percuss.simulate.kernels.statistics import (
    clear,
    concluded,
    forget_marked,
    mark,
    record,
    recurrence,
    sure,
    tally,
    wanders,
)
from percuss.simulate.kernels.wall import all_energy, chatter_left, held, impact, set_down, stays, undeformed

# ---- A flight from one anchor to the next without an impact: under one load, and over its steps


@inner
def advance(table, motion, desk, tau):
    """The anchor moved to τ under a constant load, without an impact; the clock is turned apart."""
    bar, modes, now, z = table.bar, table.modes, motion.now, motion.z
    ds, vs, _ = smooth(bar, now, desk.osc, tau)
    df, fv, _, slip = elastic(bar, modes, z, now, desk, tau)
    now.rigid_rate = drifted(bar, now, tau)
    turn_modes(bar, modes, z, desk, tau, 0.0, slip)
    now.gap += ds + df
    now.gap_rate = vs + fv


@inlined
def jump_back(table, motion, old, new):
    """The force on the modes jumps, and with it the places about which they swing; so the free part jumps back."""
    modes, z = table.modes, motion.z
    for j in range(modes.omega.shape[0]):
        jump = modes.statics[j] * (old - new)
        z[0, j] += jump
        z[1, j] -= modes.half[j] * jump * modes.inverse[j]
    amplitudes(table.bar, modes, z, motion.now)


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
    jump_back(table, motion, bar.mean, values[piece])
    bar.mean = values[piece]


@inner
def left_for_good(table, now):
    """Whether a bar under a load of steps has left for good; asked each time the first step begins.

    From period to period the mean of the bar moves by less and less when the load's mean does not push and nothing
    drags, or by an amount that tends to a pull from one side: once it has moved away in a period it moves away in all.
    Each step adds at most its static shape to the elastic amplitudes.
    """
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
    if mean > 0.0 or before == 0.0:
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


@inlined
def fly(table, motion, desk, rules, log):
    """The motion from the anchor on, event after event, until a stop rule holds or the record is full.

    The anchor stays at the last event (or break of the load) when time ends, so that going on gives the same bits.
    """
    now, count = motion.now, motion.count
    room = log.events.shape[0] - 4
    while True:
        if count.impacts >= rules.most_impacts:
            return BY_IMPACTS
        if room > 0 and count.events > room:
            return FULL
        if count.work >= rules.budget:
            return BY_WORK
        left = (rules.end_period - count.period) * TURN + (rules.end_phase - now.phase)
        if count.mode == RESTING:
            code = released(table, motion, desk, left, log)
            if code != GOES_ON:
                return code
            continue
        ahead = to_break(now, count, table.breaks)
        smooth_at_anchor(table.bar, table.harmonics, now, desk.osc)
        code, found, speed = GOES_ON, NOTHING, now.gap_rate
        if (count.mode == ON_WALL or count.mode == GRAZED) and now.hold == 0.0:
            code, found = at_wall(table, motion, desk, left, ahead, log)
        if code == GOES_ON and found == NOTHING:
            code, found, speed = flown(table, motion, desk, rules, left, ahead, log)
        if code == AT_REST or (code == GOES_ON and found != CONTACT):
            continue
        if code != GOES_ON:
            return code
        count.mode, now.hold, now.last_place, now.gap_rate = ON_WALL, 0.0, 0.0, speed
        if count.run == 1 and now.since < table.bar.pushing:
            now.pushes = push_left(table, now)
        strike(table, motion, desk, rules, log)
        if count.verdict == ASKED:
            return TO_VERIFY
        if rules.until_cycle and count.confirmed >= 2:
            return PERIODIC


@inlined
def released(table, motion, desk, left, log):
    """A bar that rests let go when the load begins to pull; or how its motion ends before."""
    bar, now, count = table.bar, motion.now, motion.count
    wait, phase = pull_ahead(table, now)
    if wait < 0.0:
        return AT_REST
    if wait >= left:
        return BY_TIME
    set_clock(table, now, count, phase)
    undeformed(table, motion, desk, bar.mean)
    count.mode, count.run = ON_WALL, 0
    count.work += 1
    if table.modes.omega.shape[0]:
        now.hold = max(pull_lasts(table, now, count), bar.wave)
    else:
        now.hold = first_pull(bar, table.harmonics, now)
    now.last_flight, now.since = -1.0, 0.0
    now.released = release_at(phase, table.releases)
    count.release_period = count.period
    record(RELEASE, 0.0, 0.0, NO_PORT, motion, None, log)
    return GOES_ON


@inlined
def at_wall(table, motion, desk, left, ahead, log):
    """What a bar on the wall does: CONTACT when it strikes at once, or NOTHING when it flies; AT_REST, laid down."""
    now, count = motion.now, motion.count
    slow = NO_SPEED * (abs(now.drift) + table.bar.rate + now.sup1)
    if now.gap_rate > slow:
        return GOES_ON, CONTACT
    if now.gap_rate >= -slow:
        if stays(table, now, count) or count.pile > 100:
            set_down(table, motion, desk, 0.0, log)
            return AT_REST, NOTHING
        now.gap_rate = 0.0
        return GOES_ON, NOTHING
    most = held(table, motion)
    wait = 0.0
    if most < 0.0 or all_energy(table, motion, desk, table.bar.mean) > most:
        wait = chatter_left(table, motion, desk, ahead)
    if wait >= left:
        return BY_TIME, NOTHING
    if wait >= 0.0:
        set_down(table, motion, desk, wait, log)
        return AT_REST, NOTHING
    return GOES_ON, NOTHING


@inlined
def flown(table, motion, desk, rules, left, ahead, log):
    """A flight to what ends it: a CONTACT, with the speed; a GRAZE or a step of the load, from which the bar flies on.

    `left`, `ahead`: time to the end and to the load's next step. Returns besides how the motion ends, or GOES_ON.
    """
    now, count, over = motion.now, motion.count, BY_TIME if left < math.inf else DEPARTED
    if left <= 0.0:
        return BY_TIME, NOTHING, 0.0
    on_wall, guess = count.mode == ON_WALL or count.mode == GRAZED, 0.0
    if count.mode == ON_WALL and now.last_flight > 0.0 and now.hold == 0.0:
        guess = like_flight(motion)
    found, tau, speed, steps, late, slip = next_contact(
        table, motion, desk, on_wall, now.hold, guess, min(left, ahead), rules.budget - count.work
    )
    if found == NOTHING and left <= ahead:
        return over, NOTHING, 0.0  # nothing moved, so that going on gives the same bits
    count.work += steps + 1
    if found == TIRED:
        now.hold = tau
        return BY_WORK, NOTHING, 0.0
    if found == AWAY and (table.breaks.shape[0] == 0 or left <= ahead):
        return over, NOTHING, 0.0
    if found != CONTACT and found != GRAZE:  # until the load's next step
        over_step(table, motion, desk, ahead)
        return (over if count.piece == 0 and left_for_good(table, now) else GOES_ON), NOTHING, 0.0
    arrive(table, motion, desk, found, tau, speed, late, slip, ahead)
    if found == GRAZE:
        amplitudes(table.bar, table.modes, motion.z, now)
        count.mode, now.hold, now.last_place, now.gap_rate = GRAZED, 0.0, 0.0, 0.0
        count.pile = count.pile + 1 if tau < 4.0 * EPS else 0
        if count.pile > 100:
            now.hold, count.pile = 1e-8, 0
        record(GRAZING, 0.0, 0.0, NO_PORT, motion, None, log)
    return GOES_ON, found, speed


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
def arrive(table, motion, desk, found, tau, speed, late, slip, ahead):
    """The anchor moved to a contact or a graze at τ."""
    bar, modes, breaks, now, count, z = table.bar, table.modes, table.breaks, motion.now, motion.count, motion.z
    if found == GRAZE:  # the bar goes on from where it is, not from the wall
        ds, _, _ = smooth(bar, now, desk.osc, tau)
        df, _, _, _ = elastic(bar, modes, z, now, desk, tau)
        now.gap += ds + df
    if modes.omega.shape[0] or found == GRAZE:
        rest = drifted(bar, now, tau)
        turn_modes(bar, modes, z, desk, tau, late, slip)
        turn_clock(now, count, tau)
        now.rigid_rate = rigid_rate(bar, table.harmonics, rest, now.cosine, now.sine)
    else:
        turn_clock(now, count, tau)
        now.rigid_rate = speed
    if breaks.shape[0] and to_break(now, count, breaks) > ahead:
        set_phase(now, breaks[(count.piece + 1) % breaks.shape[0]])  # rounded past the step
    now.since += tau


@inlined
def strike(table, motion, desk, rules, log):
    """One impact with all that is kept of it."""
    bar, modes, now, count, past = table.bar, table.modes, motion.now, motion.count, motion.past
    speed = now.gap_rate
    lost = impact(table, motion, desk, bar.mean)
    fresh = now.last_flight < 0.0
    if fresh:
        count.run, now.last_flight = 1, math.inf
    else:
        if now.since < now.last_flight and now.since < bar.pushing:
            now.pushes -= now.since
            unfelt = (
                modes.omega.shape[0] > 0 and now.since < bar.wave
            )  # a pull during the flight is not yet at the wall
            count.run = count.run + 1 if now.pushes >= 0.0 or unfelt else 1
        else:
            count.run = 1
        now.last_flight = now.since
    count.pile = count.pile + 1 if now.since < 4.0 * EPS else 0
    now.since = 0.0
    count.impacts += 1
    tally(speed, lost, motion)
    if count.impacts == rules.skip and count.confirmed == 0:
        if count.mark == 0:
            clear(motion)
        for j in range(motion.totals.shape[1]):
            motion.totals[1, j] = -motion.totals[0, j]  # those of the cycle that may have begun are kept
    i = (count.impacts - 1) & (past.shape[0] - 1)
    past[i].phase, past[i].speed, past[i].period = now.phase, speed, count.period
    record(IMPACT, speed, lost, NO_PORT, motion, None, log)
    if rules.tolerance > 0.0:
        recurrence(bar, modes, speed, fresh, motion, rules.tolerance)


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
        bar.mean = table.values[starts.piece[i]]
    count.period, count.piece = starts.period[i], starts.piece[i]
    set_phase(now, starts.phase[i])
    still = v[0] == 0.0 and starts.gap[i] == 0.0
    rate = v[0]
    for j in range(modes.omega.shape[0]):
        z[0, j] = modes.unit[j] * u[j + 1] if j + 1 < u.shape[0] else 0.0
        z[1, j] = modes.unit[j] * v[j + 1] if j + 1 < v.shape[0] else 0.0
        still = still and z[0, j] == 0.0 and z[1, j] == 0.0
        rate += z[1, j]
    forced_modes(table, desk, now.cosine, now.sine, 0)
    for j in range(modes.omega.shape[0]):
        z[0, j] -= desk.forced[j] + bar.mean * modes.statics[j]
    forced_modes(table, desk, now.cosine, now.sine, 1)
    for j in range(modes.omega.shape[0]):
        z[1, j] -= desk.forced[j]
        if modes.oscillates[j] > 0.0:
            z[1, j] = -modes.inverse[j] * (z[1, j] + modes.half[j] * z[0, j])
    now.gap, now.gap_rate, now.rigid_rate, now.last_flight = starts.gap[i], rate, v[0], -1.0
    now.released = -1.0
    amplitudes(bar, modes, z, now)
    # undeformed, at rest and on the wall: released at once when the load pulls
    count.mode = RESTING if still else (ON_WALL if starts.gap[i] == 0.0 else FLYING)


@entry
def place(table, motion, desk, starts):
    """The anchor at the only start there is."""
    put(table, motion, desk, starts, starts.gap.shape[0] - 1)  # a 0 would have a type of its own


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
    """Whether the cycle between two equal releases is sure: its twin, with R and d changed by `NUDGE`, is the same.

    The twin begins with the same release; it must take as many load periods, and be laid down at the same phases to
    `LOOSE`. An error that grows by less than `LOOSE`/`NUDGE` from release to rest leaves of rounding a thousandth of
    that. `code`: how the twin ended. Returns how the motion ends with it: `PERIODIC`, `UNRESOLVED`, or `BY_WORK` when
    it is to go on.
    """
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
        whole = (bar.damping, bar.half, bar.restitution, bar.mean)
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
            code = fly(table, who, desk, its if checked else own, none if checked else log)
            if checked:
                checked = False
                bar.damping, bar.half, bar.restitution, bar.mean = whole
                code = judged(motion, twin, code, rules.until_cycle)
            elif code == TO_VERIFY:
                checked = True
                whole = (bar.damping, bar.half, bar.restitution, bar.mean)
                released_as(table, motion, twin)
                continue
            if alone or code != BY_WORK or count.work >= rules.budget or stopped[0]:
                break
        if alone:
            members[i].ended, members[i].wanders = code, wanders(past, count.impacts)
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
