"""What changes the valve of a machine, and which comes first: the contact, a port that is crossed, or an order due.

Ports see the motion as a striking end does (`valve_sight`), so that one search proves which of them comes first; only
those are looked at whose state was not the last demanded.
"""

from __future__ import annotations

import math

from percuss.compiled import inlined, inner
from percuss.simulate.kernels.bounds import advance, amplitudes, jump_back
from percuss.simulate.kernels.motion_records import (
    AWAY,
    BY_TIME,
    BY_WORK,
    CONTACT,
    DEPARTED,
    EMPTY,
    ENTERS,
    FLYING,
    GOES_ON,
    GRAZE,
    GRAZED,
    IN_CHAMBER,
    NEVER,
    NO_PORT,
    NOTHING,
    NOWHERE,
    ON_WALL,
    RESTING,
    TIRED,
    VALVE,
    Gear,
    ModeTable,
    ValveArguments,
)
from percuss.simulate.kernels.statistics import record, recurrence_of_valve
from percuss.simulate.kernels.valve_sight import (
    EDGE,
    demand,
    go_by,
    held_by_gas,
    met,
    most,
    next_crossing,
    out_of_reach,
    pace,
    recharge,
    rigid_place,
    rising,
    seen,
)
from percuss.simulate.kernels.wall import at_rest

SAME_TIME = 4e-12  # within this events are simultaneous; a period is some units of time
MANY_PAUSES = 100_000
IN_VAIN = 64  # half swings of a stalled machine without a blow, after which it is followed only to a time asked for
MANY = 1000  # changes of state that are too many …
SHORT = 1e-6  # … within this time


# ---- What changes the valve: orders as they are due, and ports as they are crossed


@inlined
def change(table, motion, desk, tolerance, log, valve):
    """The order that was due is carried out: the static shape jumps, so the free part jumps back."""
    now, count, own, usual = motion.now, motion.count, valve.controls.now, valve.controls.usual
    before, old = own.before, own.force
    own.handed = 0
    recharge(valve, 0.0)
    new = own.force
    if own.fresh > 0:  # no contact came under the force that ends now
        usual[before] = 0.0
    if count.mode == RESTING:
        at_rest(table, motion, desk, new)
    else:
        jump_back(table, motion, old, new)
        if now.hold > 0.0 and new > 0.0:  # just released: not out of the wall's reach before the force pushes again
            now.hold = max(min(now.hold, own.lap), 0.0)
            if now.hold == 0.0 and now.gap >= 0.0:
                now.gap, count.mode = 0.0, ON_WALL
    own.clear, own.pauses, own.fresh, own.stalled = 0.0, 0, 1, 0
    own.awaited = usual[own.state] if now.hold == 0.0 else 0.0
    if new < 0.0:
        own.pulled = 1
    if own.state != before:  # else it came in place of an order that would have changed the state
        record(VALVE, now.gap_rate, 0.0, NO_PORT, motion, valve, log)
    recurrence_of_valve(table, motion, valve.controls, tolerance)


@inner
def sliding(controls):
    """Whether the valve has changed `MANY` times within a `SHORT` time: it will not end at a port."""
    own = controls.now
    own.recent += 1
    if own.recent < MANY:
        return False
    swift = own.time - own.window < SHORT
    own.recent, own.window = 0, own.time
    return swift


@inlined
def crossings(table, motion, desk, first, horizon, limit, forever, valve, sight):
    """The next crossing of each port, in `cross` and `kind`; the first time, of which port, and NEVER or not."""
    # Only ports whose state was not the last demanded can do anything. TIRED when one could not be decided.
    gear, controls = valve.gear, valve.controls
    cross, kind, last = controls.cross, controls.kind, controls.now.last
    best, which, answer = math.inf, -1, NEVER
    since = controls.now.time - controls.now.changed
    for port in range(gear.ratio.shape[0]):
        cross[port], kind[port] = math.inf, NOWHERE
        if port == gear.to.shape[0]:
            if gear.draw == 0.0:
                continue
        elif gear.side[port] == 0.0 or gear.to[port] == last:
            continue
        until = min(horizon, best) + SAME_TIME
        guess = controls.usual_cross[port] - since
        cross[port], kind[port], steps = next_crossing(
            table, motion, desk, port, first, until, limit, forever, guess, valve, sight
        )
        motion.count.work += steps
        if kind[port] == TIRED:
            return best, which, TIRED
        if kind[port] != NEVER:
            answer = NOWHERE
        if cross[port] < best:
            best, which = cross[port], port
    return best, which, answer


@inlined
def fire(table, motion, at, struck, log, valve):
    """The ports that are crossed at this moment demand, in their order; with a blow, those of the blow besides."""
    # `at`: the time of the event, from the anchor before it.
    gear, controls = valve.gear, valve.controls
    first = rigid_place(table, motion, controls.now.force)
    fast = pace(table, motion, first, valve)
    for port in range(gear.to.shape[0]):
        if gear.side[port] == 0.0:
            if struck:
                demand(motion, port, motion.now.gap_rate, fast, log, valve)
            continue
        place, rate = seen(table, motion, port, first, valve)
        now_in = controls.kind[port] == ENTERS and controls.cross[port] <= at + SAME_TIME
        if not now_in and not struck and gear.side[port] * rate > 0.0:  # of those whose state was demanded last before
            now_in = abs(place + gear.edge[port]) <= EDGE * (abs(place) + abs(gear.edge[port]))
        if now_in:
            controls.just[port] = 1
            demand(motion, port, place if gear.speeds[port] else rate, fast, log, valve)


@inlined
def occupied(table, motion, log, valve):
    """The ports whose region is occupied at a start demand, in their order."""
    gear, controls = valve.gear, valve.controls
    first = rigid_place(table, motion, controls.now.force)
    fast = pace(table, motion, first, valve)
    for port in range(gear.to.shape[0]):
        place, rate = seen(table, motion, port, first, valve)
        off = gear.side[port] * (place + gear.edge[port])
        if off > EDGE * (abs(place) + abs(gear.edge[port])):
            controls.just[port] = 1
            demand(motion, port, place if gear.speeds[port] else rate, fast, log, valve)


# ---- A machine put at a start, and in a state of its valve, which has modes of its own where oil is in their spring


@inlined
def put_valve(motion, controls, words, starts, i):
    """A machine at start number i; all else is set to 0."""
    start, now, own, z = starts.rows[i], motion.now, controls.now, motion.z
    motion.numbers[:] = 0.0
    motion.wholes[:] = 0
    words[:] = 0
    controls.usual[:] = 0.0
    controls.usual_cross[:] = 0.0
    controls.cross[:] = 0.0
    controls.kind[:] = 0
    controls.just[:] = 0
    for j in range(z.shape[1]):
        z[0, j], z[1, j] = starts.z[i, 0, j], starts.z[i, 1, j]
    now.gap, now.gap_rate, now.rigid_rate, now.last_flight = start.gap, start.gap_rate, start.rigid_rate, -1.0
    motion.count.mode = start.mode
    own.charge, own.state, own.last, own.waiting = start.charge, start.state, start.last, start.waiting
    for j in range(start.waiting):
        controls.due[j], controls.order[j] = starts.due[i, j], starts.order[i, j]


@inlined
def modes_in(modes, i):
    """The modes of a state, or of all."""
    creeps = 0
    for j in range(modes.creeping.shape[1]):
        creeps += 1 if modes.creeping[i, j] >= 0 else 0
    return ModeTable(
        modes.omega[i], modes.lam[i], modes.inverse[i], modes.square[i], modes.signed[i], modes.damping[i],
        modes.half[i], modes.delta[i], modes.oscillates[i], modes.statics[i], modes.unit[i], modes.inertia[i],
        modes.creeping[i, :creeps],
    )  # fmt: skip


@inlined
def gear_in(gear, i):
    """The same of the valve."""
    return Gear(
        gear.forces[i], gear.to[i], gear.edge[i], gear.side[i], gear.delay[i], gear.ratio[i], gear.rigid[i],
        gear.gain[i], gear.still[i], gear.sway[i], gear.bend[i], gear.speeds[i], gear.flow[i], gear.draw[i],
        gear.slope[i], gear.soft[i], gear.quickening[i],
    )  # fmt: skip


@inner
def handed(plant):
    """The modes of the state that the valve now has in place of the last one's: pressure and place stay."""
    motion, controls, own, bars = plant.motion, plant.controls, plant.controls.now, plant.table.bar
    if own.before == own.state:
        return
    old = ValveArguments(gear_in(plant.gear, own.before), controls)
    new = ValveArguments(gear_in(plant.gear, own.state), controls)
    now, z, q, rate = motion.now, motion.z, plant.desk.aside_re, plant.desk.aside_im
    last, turn, still = old.gear.to.shape[0], plant.turns[own.before, own.state], motion.count.mode == RESTING
    recharge(old, 0.0)
    first, speed, place = now.gap, now.rigid_rate, 0.0
    ramp, modes = bars[own.before].ramp, modes_in(plant.table.modes, own.before)
    for j in range(z.shape[1]):
        late = modes.damping[j] / (modes.omega[j] * modes.omega[j])
        q[j] = z[0, j] + modes.statics[j] * (own.force - ramp * late)
        rate[j] = (1.0 - modes.oscillates[j]) * z[1, j] - modes.lam[j] * z[1, j] - modes.half[j] * z[0, j]
        rate[j] += modes.statics[j] * ramp
        if still:  # undeformed, whatever was kept when it came to rest
            q[j] = rate[j] = 0.0
        first -= q[j]
        place += old.gear.ratio[last, j + 1] * q[j]
    if still:
        first = speed = 0.0
    recharge(new, (new.gear.draw - old.gear.draw) * (place + old.gear.ratio[last, 0] * first))
    ramp, modes = bars[own.state].ramp, modes_in(plant.table.modes, own.state)
    for i in range(z.shape[1] + 1):
        at, moved = turn[i, 0] * first, turn[i, 0] * speed
        for j in range(z.shape[1]):
            at += turn[i, j + 1] * q[j]
            moved += turn[i, j + 1] * rate[j]
        if i == 0:
            now.rigid_rate = moved
            continue
        j = i - 1
        late = modes.damping[j] / (modes.omega[j] * modes.omega[j])
        z[0, j] = at - modes.statics[j] * (own.force - ramp * late)
        z[1, j] = moved - modes.statics[j] * ramp
        if modes.oscillates[j] > 0.0:
            z[1, j] = -modes.inverse[j] * (z[1, j] + modes.half[j] * z[0, j])


# ---- Which comes first


@inlined
def contested(table, motion, desk, rules, left, due, first, log, valve, sight):
    """A machine's flight to the contact that ends it or, before one, on to a port that is crossed or an order due."""
    # `due`: time to the order; `first`: q_0. Returns what `motion.flown` does.
    gear, controls, own, now, count = valve.gear, valve.controls, valve.controls.now, motion.now, motion.count
    bar = table.bar
    forever = due == math.inf and bar.spring > 0.0
    horizon = math.pi / bar.spring if forever else due
    if forever and now.since == 0.0 and own.stalled == 0 and held_by_gas(table, motion, valve):
        own.stalled = 1
    if own.stalled > 0 and rules.end_phase == math.inf and now.since > IN_VAIN * horizon:
        return BY_WORK, NOTHING, 0.0, 0.0, 0.0, 0.0
    clear, awaited, fresh, usual = own.clear, own.awaited, own.fresh, controls.usual[own.state]
    best, which, answer, found, tau, speed, late, slip = upcoming(
        table, motion, desk, first, horizon, forever, rules.budget - count.work, valve, sight
    )
    if found == TIRED:
        return BY_WORK, NOTHING, tau, speed, late, slip
    count.work += 1
    ahead, code = min(best, horizon), GOES_ON
    at_wall = tau < math.inf and tau <= ahead + SAME_TIME
    if not at_wall and forever and answer == NEVER:
        return (DEPARTED if bar.lift < 0.0 else IN_CHAMBER), NOTHING, tau, speed, late, slip
    if not at_wall and ahead == math.inf:
        return DEPARTED, NOTHING, tau, speed, late, slip
    if (tau if at_wall else ahead) > left:  # what was found is forgotten: going on seeks again, from the same anchor
        own.clear, own.awaited, own.fresh = clear, awaited, fresh
        controls.usual[own.state] = usual
        return BY_TIME, NOTHING, tau, speed, late, slip
    if at_wall:
        return code, found, tau, speed, late, slip
    if best <= ahead:
        controls.usual_cross[which] = (own.time - own.changed) + best
    if ahead > 0.0:
        advance(table, motion, desk, ahead)
        go_by(motion, ahead, valve)
        if not (own.waiting > 0 and controls.due[0] <= 0.0):  # else the change of the valve is next
            amplitudes(bar, table.modes, motion.z, now)
        count.mode = FLYING
    if which == gear.to.shape[0] and best <= ahead:
        code = EMPTY
    elif best <= horizon + SAME_TIME:
        fire(table, motion, best, False, log, valve)
    elif forever:
        own.pauses += 1
        if own.pauses >= MANY_PAUSES:
            code = BY_WORK
    return code, NOTHING, tau, speed, late, slip


@inlined
def upcoming(table, motion, desk, first, horizon, forever, limit, valve, sight):
    """The next crossing of a port, and the next contact if it may come before what that crossing leads to."""
    # Returns the time of the crossing, of which port, whether one may come at all, and what `sought` does, or TIRED.
    gear, controls = valve.gear, valve.controls
    own, found, tau, speed, late, slip = controls.now, NOTHING, math.inf, 0.0, 0.0, 0.0
    best, which, answer = math.inf, -1, NEVER
    if own.stalled > 0:
        controls.cross[:] = math.inf
    else:
        best, which, answer = crossings(table, motion, desk, first, horizon, limit, forever, valve, sight)
    if answer == TIRED:
        return best, which, answer, TIRED, tau, speed, late, slip
    need = horizon
    if best < math.inf:
        later = which < gear.to.shape[0] and controls.kind[which] == ENTERS
        after = best + (gear.delay[which] if later else 0.0)
        need = min(need, best if best < own.awaited < after else after)
    bar = table.bar
    if forever and (rising(bar) or most(bar, motion.now) >= -1e-13 * abs(motion.now.gap)):
        answer = NOWHERE
    if own.clear < need:
        found, tau, speed, late, slip = sought(table, motion, desk, need, limit, controls)
    return best, which, answer, found, tau, speed, late, slip


@inlined
def sought(table, motion, desk, need, limit, controls):
    """The next contact, when there is one before the time `need`; otherwise `clear` says so. As `next_contact`."""
    # How long after a change of the valve the first contact came is what is tried after the next like change.
    now, count, own = motion.now, motion.count, controls.now
    if out_of_reach(table.bar, now, need + SAME_TIME):
        own.clear = need
        return NOTHING, math.inf, 0.0, 0.0, 0.0
    on_wall = count.mode == ON_WALL or count.mode == GRAZED
    found, tau, speed, steps, late, slip = met(
        table, motion, desk, on_wall, now.hold, own.awaited, need + SAME_TIME, limit
    )
    count.work += steps
    if found == CONTACT:
        if own.fresh > 0:
            controls.usual[own.state] = (own.time - own.changed) + tau
        own.awaited, own.fresh = tau, 0
    elif found != TIRED:
        if found != GRAZE:
            own.clear, tau = (math.inf if found == AWAY else need), math.inf
        if found == GRAZE or own.awaited < need:
            own.awaited = 0.0
    return found, tau, speed, late, slip
