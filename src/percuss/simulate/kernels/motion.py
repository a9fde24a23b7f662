"""The motion from event to event."""

from __future__ import annotations

import math

from percuss.compiled import inlined
from percuss.simulate.kernels.bounds import amplitudes
from percuss.simulate.kernels.clock import set_clock, set_phase, to_break, turn_clock
from percuss.simulate.kernels.codes import (
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
    NOTHING,
    ON_WALL,
    PERIODIC,
    RELEASE,
    RESTING,
    TIRED,
    TO_VERIFY,
    TURN,
)
from percuss.simulate.kernels.cycles import clear, recurrence
from percuss.simulate.kernels.first_contact import like_flight, next_contact
from percuss.simulate.kernels.flight import advance, left_for_good, step_load
from percuss.simulate.kernels.impact import impact, undeformed
from percuss.simulate.kernels.load import first_pull, pull_ahead, pull_lasts, push_left, release_at
from percuss.simulate.kernels.log import record
from percuss.simulate.kernels.modes import elastic, turn_modes
from percuss.simulate.kernels.rest import chatter_left, held, set_down, stays
from percuss.simulate.kernels.smooth import drifted, rigid_rate, smooth, smooth_at_anchor
from percuss.simulate.kernels.statistics import tally

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
    if phase != now.phase or bar.mean >= 0.0 or table.values.shape[0] == 0:
        set_clock(table, now, count, phase)  # else a start at a step of the load might fall before it by rounding
    undeformed(table, motion, desk)
    count.mode, count.run = ON_WALL, 0
    count.work += 1
    if table.modes.omega.shape[0]:
        now.hold = max(pull_lasts(table, now, count), bar.wave)
    else:
        now.hold = first_pull(bar, table.harmonics, now)
    now.last_flight, now.since = -1.0, 0.0
    now.released = release_at(phase, table.releases)
    count.release_period = count.period
    record(RELEASE, 0.0, 0.0, motion, log)
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
    wait = 0.0 if held(table, motion) else chatter_left(table, motion, desk, ahead)
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
        record(GRAZING, 0.0, 0.0, motion, log)
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
    lost = impact(table, motion, desk)
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
    record(IMPACT, speed, lost, motion, log)
    if rules.tolerance > 0.0:
        recurrence(bar, modes, speed, fresh, motion, rules.tolerance)
