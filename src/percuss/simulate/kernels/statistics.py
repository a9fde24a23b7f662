"""The search for a cycle, running sums over the impacts of a motion, what is concluded from them, and the record."""

from __future__ import annotations

import math

from percuss.compiled import entry, inlined, inner
from percuss.simulate.kernels.motion_records import (
    ASKED,
    CHATTER,
    IMPACT,
    LOOSE,
    LOST_CYCLE,
    STATE_NUMBERS,
    SURE,
    TURN,
    TWIN,
    UNSEEN,
)

# ---- The search for a cycle: among impacts by their states, among releases by their phases

SAME = 64  # last impacts looked at, of a machine half as many changes of its valve
SHIFTS = 32  # longest cycle that makes a motion "not aperiodic", of a machine half of that
ELSEWHERE = 1e9  # distance of two states of a valve
SETTLING = 100.0  # tolerances within which a state after a rest is still on its way to the one after the rest before
FEW = 4  # main blows of a cycle too few for errors to grow


@inlined
def remember(speed, motion):
    """The state just after an impact, to be compared with later ones."""
    now, count, z, anchor = motion.now, motion.count, motion.z, motion.anchor
    now.anchor_phase, now.anchor_speed, now.anchor_rigid_rate = now.phase, speed, now.rigid_rate
    for j in range(z.shape[1]):
        anchor[0, j] = z[0, j]
        anchor[1, j] = z[1, j]
    count.anchor, count.anchor_period = count.impacts, count.period
    count.rests, count.chatters = 0, 0


@inlined
def returned(bar, modes, speed, motion, tolerance):
    """Whether the state is the remembered one, each number to `tolerance` of its scale."""
    now = motion.now
    turn = abs(now.phase - now.anchor_phase)
    if min(turn, TURN - turn) > tolerance:
        return False
    bound = tolerance * (bar.force + abs(speed))
    if abs(speed - now.anchor_speed) > bound or abs(now.rigid_rate - now.anchor_rigid_rate) > bound:
        return False
    return amplitudes_off(modes, motion.z, motion.anchor) <= bound


@inner
def impacts_apart(one, other, scale):
    """How far one of the last impacts is from another."""
    turn = abs(one.phase - other.phase)
    return max(min(turn, TURN - turn), abs(one.speed - other.speed) / scale)


@inner
def changes_apart(one, other, scale):
    """The same of the last changes of a valve."""
    if one.state != other.state:
        return ELSEWHERE
    off = max(abs(one.gap - other.gap), abs(one.rate - other.rate)) / scale
    return max(abs(one.interval - other.interval), off)


@inner
def farthest(past, shift, first, last, scale, apart):
    """Greatest distance of those number `first` … `last` − 1 from those `shift` before."""
    most, ring = 0.0, past.shape[0] - 1
    for i in range(first, last):
        most = max(most, apart(past[i & ring], past[(i - shift) & ring], scale))
    return most


@inlined
def shortest(past, cycle, periods, seen, scale, tolerance, apart, near):
    """The cycle of so many impacts or changes or, when a part of it comes back too, that; 0 when that is still open."""
    # A motion that settles with a negative multiplier comes back after two cycles before it does after one: the
    # distance of a part that still shrinks, by more than 1e-4 of itself in a cycle, is waited for where it is less than
    # `near`.
    for part in range(1, cycle // 2 + 1):
        if cycle % part or (periods * part) % cycle or 2 * cycle + part > min(seen, past.shape[0]):
            continue
        off = farthest(past, part, seen - cycle, seen, scale, apart)
        if off <= tolerance:
            return part
        if off < near and abs(off - farthest(past, part, seen - 2 * cycle, seen - cycle, scale, apart)) > 1e-4 * off:
            return 0
    return cycle


@inlined
def returns(past, seen, same, shifts, top, apart):
    """Whether some shift brings the last impacts, or changes of a valve, back to `LOOSE`ly the same."""
    # `past`: the last ones, in a ring; `seen`: how many there were; `top`: what they are measured by.
    ring = past.shape[0] - 1
    for shift in range(1, shifts + 1):
        near = True
        for i in range(seen - same, seen):
            if apart(past[i & ring], past[(i - shift) & ring], top) > LOOSE:
                near = False
                break
        if near:
            return True
    return False


@inner
def wandering(past, seen):
    """Whether no shift by up to `SHIFTS` impacts brings the last ones back."""
    if seen < SAME + SHIFTS:
        return False
    top, ring = 1e-300, past.shape[0] - 1
    for i in range(seen - SAME, seen):
        top = max(top, abs(past[i & ring].speed))
    return not returns(past, seen, SAME, SHIFTS, top, impacts_apart)


@inner
def valve_wandering(past, seen):
    """The same of the last changes of a valve."""
    if seen < SAME // 2 + SHIFTS // 2:
        return False
    top, ring = 1e-300, past.shape[0] - 1
    for i in range(seen - SAME // 2, seen):
        top = max(top, abs(past[i & ring].rate), abs(past[i & ring].gap))
    return not returns(past, seen, SAME // 2, SHIFTS // 2, top, changes_apart)


@inlined
def amplitudes_off(modes, z, kept):
    """How far amplitudes are from kept ones, displacements and velocities."""
    most = 0.0
    for j in range(z.shape[1]):
        off = max(abs(z[0, j] - kept[0, j]), abs(z[1, j] - kept[1, j]))
        most = max(most, off * (1.0 + modes.lam[j]))
    return most


@inner
def clear(motion):
    """The sums begun anew, now: at the first return of a cycle, and when the impacts to be discarded are over."""
    for i in range(motion.totals.shape[1]):
        motion.totals[0, i] = motion.totals[1, i] = 0.0


@inner
def forget_marked(motion):
    """The sums before the release that later ones are compared with are not those of the cycle."""
    for i in range(motion.totals.shape[1]):
        motion.totals[1, i] = 0.0


@inner
def mark(motion):
    """The last release remembered, to be compared with later ones; at the first impact after it."""
    now, count, totals = motion.now, motion.count, motion.totals
    now.marked, now.laid = now.released, 0.0
    count.mark, count.mark_period = count.impacts, count.release_period
    count.mark_releases, count.mark_chatters = 0, 0
    if count.verdict != SURE:
        for i in range(totals.shape[1]):
            totals[1, i] += totals[0, i]
            totals[0, i] = 0.0


@inner
def sure(motion):
    """The cycle between two equal releases is one: the sums are those over it."""
    motion.count.verdict, motion.count.confirmed = SURE, 2
    forget_marked(motion)
    mark(motion)


@inner
def released_again(motion):
    """The search for a cycle among the releases, at the first impact after each: Brent's, as `recurrence`."""
    # A bar at rest leaves the wall undeformed and without speed, at a phase that is a number of the load: two releases
    # at one phase are the same state, and the motion between them is a cycle. How many load periods it takes is known
    # when rounding has not had a say in it: `verify` decides, unless the main blows are too few for errors to grow.
    now, count = motion.now, motion.count
    count.mark_releases += 1
    if count.mark > 0 and now.released == now.marked:
        periods = count.release_period - count.mark_period
        if count.verdict <= TWIN:
            few = count.verdict == UNSEEN and motion.sums[0].struck <= FEW
            count.verdict, count.confirmed, count.found_at = ASKED, 0, count.mark
            count.cycle_impacts, count.cycle_periods = count.impacts - count.mark, periods
            count.cycle_kind = 2 if count.mark_chatters else 1
            if few:
                sure(motion)
            return
        if count.verdict == SURE:
            if periods == count.cycle_periods:
                count.confirmed += 1
            else:
                count.verdict, count.confirmed, count.cycle_impacts = LOST_CYCLE, 0, 0
        mark(motion)
    elif count.mark == 0 or (count.mark_releases >= count.mark_patience and count.verdict <= TWIN):
        count.mark_patience = max(2 * count.mark_patience, 1)
        mark(motion)


@inlined
def recurrence(bar, modes, speed, fresh, motion, tolerance):
    """The search for a cycle, after each impact: Brent's, with the remembered state renewed at ever longer times."""
    # Each state is compared with the remembered one; a return gives a cycle of p impacts in n load periods, and is
    # compared again from there on. Two returns with the same p and n confirm it. Where the bar rests, only the first
    # impacts after a release (`fresh`) are compared: the last ones of a chatter are too much alike. A release at one of
    # the phases where the load begins to pull is compared by that phase alone, see `released_again`.
    now, count = motion.now, motion.count
    since = count.impacts - count.anchor
    if fresh and now.released >= 0.0:
        released_again(motion)
        if count.verdict > TWIN:
            remember(speed, motion)
        return
    if count.rests > 0 and not fresh and since < 4 * count.patience:
        return
    periods = count.period - count.anchor_period
    if count.anchor > 0 and (fresh or count.rests == 0) and returned(bar, modes, speed, motion, tolerance):
        ahead = now.phase - now.anchor_phase
        if ahead < -math.pi:
            periods -= 1
        elif ahead > math.pi:
            periods += 1
        if periods > 0:
            cycle = since
            if count.rests == 0:
                scale = bar.force + abs(speed)
                cycle = shortest(motion.past, since, periods, count.impacts, scale, tolerance, impacts_apart, math.inf)
            if cycle == 0:
                count.confirmed, count.cycle_impacts = 0, 0
            else:
                periods = periods * cycle // since
                if cycle == count.cycle_impacts and periods == count.cycle_periods:
                    count.confirmed += 1
                else:
                    count.cycle_impacts, count.cycle_periods, count.confirmed = cycle, periods, 1
                    count.found_at = count.anchor
                    clear(motion)
            count.cycle_kind = 2 if count.chatters else (1 if count.rests else 0)
            remember(speed, motion)
            return
    if fresh and count.rests == 1 and returned(bar, modes, speed, motion, SETTLING * tolerance):
        # nearly as one rest before: what settles from both sides in turn comes back after two rests before it does now
        count.confirmed, count.cycle_impacts = 0, 0
        remember(speed, motion)
        return
    if count.confirmed and since > count.cycle_impacts:
        count.confirmed, count.cycle_impacts = 0, 0
    if count.anchor == 0 or since >= count.patience:
        count.patience = max(2 * count.patience, 1)
        remember(speed, motion)


# ---- … of a machine among the changes of its valve, by the state of all that moves and waits


@inlined
def remember_change(motion, controls):
    """The state just after a change of the valve, to be compared with later ones."""
    now, count, own = motion.now, motion.count, controls.now
    z, memo = motion.z, controls.memo
    own.memo_gap, own.memo_rate, own.memo_rigid = now.gap, now.gap_rate, now.rigid_rate
    own.memo_time, own.memo_state, own.memo_last = own.time, own.state, own.last
    own.memo_waiting, own.memo_changes, own.memo_blows = own.waiting, own.changes, own.blows
    own.memo_rests, own.memo_chatters, own.memo_impacts = own.rests, own.chatters, count.impacts
    own.memo_taken, own.memo_charge, own.strongest = own.taken, own.charge, 0.0
    for j in range(z.shape[1]):
        memo[0, j], memo[1, j] = z[0, j], z[1, j]
    for i in range(own.waiting):
        controls.memo_due[i] = controls.due[i]


@inlined
def changed_back(modes, motion, controls, tolerance, scale):
    """Whether the state is the remembered one, each number to `tolerance` of its scale."""
    now, own, bound = motion.now, controls.now, tolerance * scale
    if own.state != own.memo_state or own.last != own.memo_last or own.waiting != own.memo_waiting:
        return False
    if abs(own.charge - own.memo_charge) > tolerance * abs(own.charge):
        return False
    far = max(abs(now.gap - own.memo_gap), abs(now.gap_rate - own.memo_rate))
    if max(far, abs(now.rigid_rate - own.memo_rigid)) > bound:
        return False
    for i in range(own.waiting):
        if abs(controls.due[i] - controls.memo_due[i]) > tolerance:
            return False
    return amplitudes_off(modes, motion.z, controls.memo) <= bound


@inlined
def recurrence_of_valve(table, motion, controls, tolerance):
    """The search for a cycle, after each change of the valve, as `recurrence`."""
    now, own, past = motion.now, controls.now, controls.past
    own.changes += 1
    ring = past.shape[0] - 1
    last = past[(own.changes - 1) & ring]
    last.interval, last.gap, last.rate, last.state = own.time - own.changed, now.gap, now.gap_rate, own.state
    own.changed = own.time
    scale = table.bar.force + abs(now.gap_rate)
    since = own.changes - own.memo_changes
    if own.memo_changes > 0 and changed_back(table.modes, motion, controls, tolerance, scale):
        cycle = shortest(past, since, since, own.changes, scale, tolerance, changes_apart, 1.0)
        if cycle == 0:
            own.confirmed, own.cycle_changes = 0, 0
        else:
            turns = 0  # orders to the state that most of them are to
            for state in range(controls.usual.shape[0]):
                orders = 0
                for i in range(own.changes - cycle, own.changes):
                    orders += 1 if past[i & ring].state == state else 0
                turns = max(turns, orders)
            blows = (own.blows - own.memo_blows) * cycle // since
            if cycle == own.cycle_changes and blows == own.cycle_blows:
                own.confirmed += 1
            else:
                own.confirmed, own.found_at = 1, own.memo_impacts
            own.cycle_changes, own.cycle_blows, own.cycle_turns = cycle, blows, turns
            own.period = (own.time - own.memo_time) * cycle / since
            own.cycle_taken = (own.taken - own.memo_taken) * cycle / since
            own.cycle_speed = own.strongest
            own.cycle_kind = 1 if own.rests > own.memo_rests else 0
            if own.chatters > own.memo_chatters:
                own.cycle_kind = 2
        remember_change(motion, controls)
    else:
        if own.confirmed > 0 and since > own.cycle_changes:
            own.confirmed, own.cycle_changes = 0, 0
        if own.memo_changes == 0 or since >= own.patience:
            own.patience = max(2 * own.patience, 1)
            remember_change(motion, controls)


# ---- Running sums over the impacts of a motion, and what is concluded from them


@inlined
def tally(speed, lost, motion):
    """An impact entered into the sums."""
    now, count, sums = motion.now, motion.count, motion.sums[0]
    sums.taken += lost
    begun = now.begun > 0.0
    since = (count.period - now.struck_period) * TURN + (now.phase - now.struck_phase)
    if begun:
        sums.all += 1.0
        sums.all_time += since
        sums.all_squares += since * since
    if begun and count.run > 1:
        sums.open += 1.0
        sums.open_time += since
        sums.open_squares += since * since
        sums.open_speeds += speed
        sums.open_blows += now.kinetic_energy
    else:
        if begun:
            close_run(motion)
            if now.chattered > 0.0:
                since = (count.period - now.blow_period) * TURN + (now.phase - now.blow_phase)
            sums.main += 1.0
            sums.main_time += since
            sums.main_squares += since * since
        now.blow_period, now.blow_phase, now.chattered = count.period, now.phase, 0.0
        sums.speeds += speed
        sums.blows += now.kinetic_energy
        sums.struck += 1.0
    now.struck_period, now.struck_phase, now.begun = count.period, now.phase, 1.0


@inner
def close_run(motion):
    """The open sequence was no chatter: its impacts are main blows."""
    sums = motion.sums[0]
    sums.main += sums.open
    sums.main_time += sums.open_time
    sums.main_squares += sums.open_squares
    sums.speeds += sums.open_speeds
    sums.blows += sums.open_blows
    sums.struck += sums.open
    forget_run(motion)


@inner
def forget_run(motion):
    """No sequence is open any more."""
    sums = motion.sums[0]
    sums.open, sums.open_time, sums.open_squares, sums.open_speeds, sums.open_blows = 0.0, 0.0, 0.0, 0.0, 0.0


@inner
def spread(n, total, squares):
    """Mean and standard deviation from sums; NaN without any."""
    if n == 0.0:
        return math.nan, math.nan
    mean = total / n
    return mean, math.sqrt(max(squares / n - mean * mean, 0.0))


@inner
def concluded(motion, code, member):
    """What is kept of a member: how it ended, its cycle, and its means."""
    now, count, sums, totals = motion.now, motion.count, motion.sums[0], motion.totals
    settled = count.confirmed >= 2
    if not (settled and count.cycle_kind == 2) and now.chattered == 0.0:
        close_run(motion)
    for i in range(totals.shape[1]):
        totals[0, i] += totals[1, i]
    mean, std = spread(sums.all, sums.all_time, sums.all_squares)
    main, main_std = spread(sums.main, sums.main_time, sums.main_squares)
    member.end_time = count.period * TURN + now.phase
    member.interval_mean, member.interval_std = mean, std
    member.main_interval_mean, member.main_interval_std = main, main_std
    member.blow_rate, member.main_blow_rate = TURN / mean, TURN / main
    member.impact_velocity, _ = spread(sums.struck, sums.speeds, 0.0)
    member.blow_energy, _ = spread(sums.struck, sums.blows, 0.0)
    member.energy_lost_per_period = TURN * sums.taken / sums.all_time if sums.all > 0.0 else math.nan
    member.ended, member.strikes, member.first = code, count.impacts, count.found_at - 1 if settled else -1
    member.cycle_impacts = count.cycle_impacts if settled else 0
    member.cycle_periods = count.cycle_periods if settled else 0
    member.cycle_kind = count.cycle_kind if settled or count.verdict == LOST_CYCLE else 0
    member.wanders = 1 if wandering(motion.past, count.impacts) else 0


@inner
def concluded_of_valve(motion, controls, code, member):
    """The same of a machine, in its unit of time."""
    own = controls.now
    settled = own.confirmed >= 2
    member.ended, member.strikes, member.end_time, member.stalled = code, motion.count.impacts, own.time, own.stalled
    member.wanders = 1 if valve_wandering(controls.past, own.changes) else 0
    member.first, member.cycle_kind = own.found_at if settled else -1, own.cycle_kind if settled else 0
    member.cycle_impacts = own.cycle_blows if settled else 0
    member.cycle_periods = own.cycle_turns if settled else 0
    member.period = own.period if settled else math.nan
    member.energy_lost_per_period = own.cycle_taken if settled else math.nan
    member.blow_speed = own.cycle_speed if settled else math.nan


@entry
def conclude(motion, code, member):
    """What is kept of a motion that was followed by itself."""
    concluded(motion, code, member)


# ---- The record of what happens


@inlined
def record(kind, before, lost, port, motion, valve, log):
    """One event with the state after it, unless the record has no rows; `valve` is None under a clock."""
    if log.events.shape[0] == 0:
        return
    now, count, z, states = motion.now, motion.count, motion.z, log.states
    i = count.events
    count.events += 1
    event = log.events[i]
    if valve is None:
        event.phase, event.period, event.piece = now.phase, count.period, count.piece
    else:
        own = valve.controls.now
        event.phase, event.period, event.piece = own.time + own.time_low, 0, own.state
    event.before, event.after, event.lost, event.kind, event.port = before, now.gap_rate, lost, kind, port
    event.kinetic = now.kinetic_energy if kind == IMPACT else 0.0
    event.resolved = count.run if kind == CHATTER else 0
    if states.shape[0]:
        n = z.shape[1]
        states[i, 0], states[i, 1] = now.gap, now.rigid_rate
        for j in range(n):
            states[i, STATE_NUMBERS + j] = z[0, j]
            states[i, STATE_NUMBERS + n + j] = z[1, j]
        if valve is not None and states.shape[1] > STATE_NUMBERS + 2 * n:
            states[i, STATE_NUMBERS + 2 * n] = valve.controls.now.charge
