"""What ports see of the motion: each sees its own distance from its edge as the gap of a striking end.

So the proven search for the next contact finds the next crossing as well, of a port that reads any place on the bar.
"""

from __future__ import annotations

import math

from percuss.compiled import apart, inlined, inner, summed
from percuss.simulate.kernels.bounds import amplitudes, smooth_at_anchor
from percuss.simulate.kernels.first_contact import next_contact
from percuss.simulate.kernels.motion_records import (
    CONTACT,
    ENTERS,
    GRAZE,
    LEAVES,
    NEVER,
    NOTHING,
    NOWHERE,
    PORT,
    TIRED,
)
from percuss.simulate.kernels.statistics import record

EDGE = 1e-13  # how near to a port, of the distances, the bar is at its edge


@summed
def rigid_place(table, motion, force):
    """q_0, what is left of the gap without the elastic modes."""
    modes, ramp, z, total = table.modes, table.bar.ramp, motion.z, 0.0
    for j in range(modes.omega.shape[0]):
        total += z[0, j] + force * modes.statics[j]
    if ramp != 0.0:
        for j in range(modes.omega.shape[0]):
            total -= ramp * modes.statics[j] * modes.damping[j] / (modes.omega[j] * modes.omega[j])
    return motion.now.gap - total


@summed
def seen(table, gear, motion, force, port, first):
    """Place, and its rate, of what a port reads; `first` is q_0."""
    modes, z, ratio = table.modes, motion.z, gear.ratio
    place, rate = ratio[port, 0] * first, ratio[port, 0] * motion.now.rigid_rate
    if gear.rigid[port] == 0:
        for j in range(modes.omega.shape[0]):
            own = -modes.lam[j] * z[1, j] - modes.half[j] * z[0, j] + (1.0 - modes.oscillates[j]) * z[1, j]
            place += ratio[port, j + 1] * (z[0, j] + force * modes.statics[j])
            rate += ratio[port, j + 1] * own
        ramp = table.bar.ramp
        if ramp != 0.0:
            for j in range(modes.omega.shape[0]):
                own = ratio[port, j + 1] * ramp * modes.statics[j]
                place -= own * modes.damping[j] / (modes.omega[j] * modes.omega[j])
                rate += own
    return place, rate


@inlined
def rising(bar):
    """Whether the line about which a motion swings, on a spring, rises in the end."""
    line = bar.lift / (bar.spring * bar.spring)
    return line + bar.climb > 1e-13 * (abs(line) + abs(bar.climb))


@inlined
def aim(gear, motion, eye, port, sign, gap, rate):
    """The motion as a port sees it, `gap` from its edge: below 0 on this side, for the given sign."""
    z, own, now = motion.z, eye.z, eye.now
    for j in range(own.shape[1]):
        scale = sign * gear.ratio[port, j + 1]
        own[0, j], own[1, j] = scale * z[0, j], scale * z[1, j]
    now.gap, now.gap_rate, now.rigid_rate = gap, rate, sign * gear.ratio[port, 0] * motion.now.rigid_rate
    now.hold = 0.0


@inlined
def most(bar, now):
    """What the gap of a motion in the chamber never exceeds: the drift keeps within its circle, the modes in theirs.

    The circle moves as an accumulator is filled; so this is asked where it is not `rising`.
    """
    square = bar.spring * bar.spring
    line = bar.lift / square
    place, rate = -(bar.mean - bar.damping * line) / square, (now.drift - line) / bar.spring
    return now.gap - place - now.free + math.sqrt(place * place + rate * rate) + now.sup


@summed
def swing(table, motion):
    """Twice the energy about the place where the bar would be still on the gas of its chamber, under this force."""
    bar, modes, now, z = table.bar, table.modes, motion.now, motion.z
    place = bar.mean / bar.spring
    total = bar.whole * (now.rigid_rate * now.rigid_rate + place * place)
    for j in range(modes.omega.shape[0]):
        w = modes.omega[j] * z[0, j]
        rate = -modes.lam[j] * z[1, j] - modes.half[j] * z[0, j] + (1.0 - modes.oscillates[j]) * z[1, j]
        total += 2.0 * modes.inertia[j] * (rate * rate + w * w)
    return total


@inlined
def held_by_gas(table, gear, motion, controls):
    """Whether no port whose demand counts can ever be reached, whatever blows may come: they take energy, and no more.

    Asked while no order waits. A place is never farther from where it would be still than √(Σ w_i²/ω_i²) times the root
    of twice the energy about there, which falls in flight, and at a blow that keeps the strain.
    """
    valve, modes = controls.now, table.modes
    if (table.bar.strain != 1.0 and modes.omega.shape[0] > 0) or table.bar.ramp != 0.0:
        return False
    force, root = valve.force, math.sqrt(swing(table, motion))
    for port in range(gear.to.shape[0]):
        if gear.to[port] == valve.last:
            continue
        if gear.side[port] == 0.0:
            return False
        off = gear.side[port] * (force * gear.still[port] + gear.edge[port])
        if not off + gear.sway[port] * root < -EDGE * gear.edge[port]:
            return False
    return True


@apart
def met(table, motion, desk, at_edge, begin, guess, horizon, limit):
    """`next_contact`, once for all that a machine may meet."""
    return next_contact(table, motion, desk, at_edge, begin, guess, horizon, limit)


@inlined
def out_of_reach(bar, now, horizon):
    """Whether the gap surely stays open until then: the free part by its bound, and the rest by a parabola."""
    pull = bar.mean - bar.damping * now.drift
    up = max(pull, 0.0)
    if bar.spring > 0.0:
        up = abs(pull) + bar.spring * abs(now.drift) + abs(bar.lift) / bar.spring
    top, rise = now.gap - now.free + now.sup, now.smooth_rate + 0.5 * up * horizon
    sizes = abs(now.gap) + now.sup + (abs(now.smooth_rate) + up * horizon) * horizon
    return top + max(rise, 0.0) * horizon < -1e-12 * sizes


@inlined
def looked_for(table, eye, desk, push, at_edge, rate, horizon, limit, forever, guess):
    """The next crossing that an eye sees: what was found, its time, and the evaluations.

    `push`: `mean`, `lift` and `climb` as it sees them. `forever`: whether nothing else ends the motion in a chamber, so
    that a crossing may be proved never to come. `guess` > 0: a time worth trying.
    """
    bar, now = table.bar, eye.now
    before = (bar.mean, bar.lift, bar.climb)
    bar.mean, bar.lift, bar.climb = push
    smooth_at_anchor(bar, table.harmonics, now, desk.osc)
    found, tau, steps = NOTHING, horizon, 1
    if at_edge and rate == 0.0 and now.acceleration > 0.0:
        found, tau = CONTACT, 0.0
    elif forever and not rising(bar) and most(bar, now) < 1e-13 * abs(now.gap):
        found = NEVER
    elif not out_of_reach(bar, now, horizon):
        found, tau, _, steps, _, _ = met(table, eye, desk, at_edge, 0.0, guess, horizon, limit)
    bar.mean, bar.lift, bar.climb = before
    return found, tau, steps


@inlined
def next_crossing(plant, sight, port, first, horizon, limit, forever, guess):
    """When a port is next entered, or left so that it may be entered again; NOWHERE when not before the horizon.

    The pressure of a supply falls to 0 where p u comes to the charge: this is a port whose edge draws back at q/|p|.
    Returns the time, what it is, and the evaluations. A graze is a time to look anew.
    """
    table, gear, motion, controls = plant.table, plant.gear, plant.motion, plant.controls
    place, rate = seen(table, gear, motion, controls.now.force, port, first)
    empties = port == gear.to.shape[0]
    side, edge, creep = 1.0, 0.0, 0.0
    if empties:
        side, edge, creep = math.copysign(1.0, gear.draw), -controls.now.charge / gear.draw, -gear.flow / abs(gear.draw)
    else:
        side, edge = gear.side[port], gear.edge[port]
    off, rate = side * (place + edge), side * rate + creep
    at_edge = abs(off) <= EDGE * (abs(place) + abs(edge))
    inside = off > 0.0
    if empties and inside and not at_edge:
        return 0.0, ENTERS, 1
    if at_edge:
        inside = not empties and controls.just[port] > 0 and rate >= 0.0
        if rate > 0.0 and not inside:
            return 0.0, ENTERS, 1
    sign = -side if inside else side
    gap = 0.0 if at_edge else -abs(off)
    toward = -rate if inside else rate
    found, tau, steps = NOTHING, horizon, 1
    bar, scale = table.bar, sign * gear.ratio[port, 0]
    push = (scale * bar.mean, scale * bar.lift, sign * gear.bend[port] * bar.ramp + creep)
    if gear.rigid[port]:
        aim(gear, motion, sight.spot, port, sign, gap, toward)
        found, tau, steps = looked_for(
            sight.alone, sight.spot, sight.bench, push, at_edge, toward, horizon, limit, forever, guess
        )
    else:
        aim(gear, motion, sight.eye, port, sign, gap, toward)
        amplitudes(table.bar, table.modes, sight.eye.z, sight.eye.now)
        found, tau, steps = looked_for(
            table, sight.eye, plant.desk, push, at_edge, toward, horizon, limit, forever, guess
        )
    if found == NEVER:
        return math.inf, NEVER, steps
    if found == TIRED:
        return math.inf, TIRED, steps
    if found in (CONTACT, GRAZE):
        return tau, (ENTERS if found == CONTACT and not inside else LEAVES), steps
    return math.inf, NOWHERE, steps


# ---- Demands and orders of the valve, its record, and the time that goes by


@inner
def enter(kind, before, lost, port, motion, controls, log):
    """One event with the state after it."""
    record(kind, before, lost, port, motion, controls.now, log)


@inner
def demand(gear, motion, controls, port, rate, log):
    """A port demands its state: ignored when it was demanded last; a later demand replaces what would come after it.

    `rate`: of what the port reads.
    """
    valve, due, order, to = controls.now, controls.due, controls.order, gear.to[port]
    if to == valve.last:
        return
    valve.last = to
    while valve.waiting > 0 and due[valve.waiting - 1] >= gear.delay[port]:
        valve.waiting -= 1
    due[valve.waiting], order[valve.waiting] = gear.delay[port], to  # there is room: see `CROWDED`
    valve.waiting += 1
    enter(PORT, rate, 0.0, port, motion, controls, log)


@inner
def next_order(controls):
    """The state of the order that is due first, which waits no longer."""
    valve, due, order = controls.now, controls.due, controls.order
    to = order[0]
    valve.waiting -= 1
    for i in range(valve.waiting):
        due[i], order[i] = due[i + 1], order[i + 1]
    return to


@inlined
def go_by(gear, motion, controls, tau):
    """The time τ has gone by: the clock, exact to twice the digits, the supply, and all that counts down."""
    now, valve = motion.now, controls.now
    total = valve.time + tau
    back = total - valve.time
    valve.time_low += (valve.time - (total - back)) + (tau - back)
    valve.time = total
    if gear.flow > 0.0:
        recharge(gear, valve, gear.flow * tau)
    for i in range(valve.waiting):
        controls.due[i] -= tau
    for j in range(controls.just.shape[0]):
        controls.just[j] = 0
    now.since += tau
    valve.clear -= tau
    valve.lap -= tau
    valve.awaited = valve.awaited - tau if valve.awaited > tau else 0.0
    now.hold = now.hold - tau if now.hold > tau else 0.0


@inlined
def recharge(gear, valve, by):
    """More charge of the supply, and the force with it."""
    valve.charge += by
    valve.force = gear.forces[valve.state] + gear.slope * valve.charge


# ---- The search for a cycle of a machine: among the changes of its valve, by the state of all that moves and waits

MANY = 1000  # changes of state that are too many …
SHORT = 1e-6  # … within this time
SAME = 32  # last changes looked at
SHIFTS = 16  # longest cycle that makes a motion not irregular
LOOSE = 1e-3


@inlined
def remember(motion, controls):
    """The state just after a change of the valve, to be compared with later ones."""
    now, count, valve = motion.now, motion.count, controls.now
    z, memo = motion.z, controls.memo
    valve.memo_gap, valve.memo_rate, valve.memo_rigid = now.gap, now.gap_rate, now.rigid_rate
    valve.memo_time, valve.memo_state, valve.memo_last = valve.time, valve.state, valve.last
    valve.memo_waiting, valve.memo_changes, valve.memo_blows = valve.waiting, valve.changes, valve.blows
    valve.memo_rests, valve.memo_chatters, valve.memo_impacts = valve.rests, valve.chatters, count.impacts
    valve.memo_taken, valve.memo_charge, valve.strongest = valve.taken, valve.charge, 0.0
    for j in range(z.shape[1]):
        memo[0, j], memo[1, j] = z[0, j], z[1, j]
    for i in range(valve.waiting):
        controls.memo_due[i] = controls.due[i]


@inlined
def returned(table, motion, controls, tolerance, scale):
    """Whether the state is the remembered one, each number to `tolerance` of its scale."""
    now, valve, z, memo = motion.now, controls.now, motion.z, controls.memo
    if valve.state != valve.memo_state or valve.last != valve.memo_last or valve.waiting != valve.memo_waiting:
        return False
    bound = tolerance * scale
    if abs(valve.charge - valve.memo_charge) > tolerance * abs(valve.charge):
        return False
    far = max(abs(now.gap - valve.memo_gap), abs(now.gap_rate - valve.memo_rate))
    far = max(far, abs(now.rigid_rate - valve.memo_rigid))
    if far > bound:
        return False
    for i in range(valve.waiting):
        if abs(controls.due[i] - controls.memo_due[i]) > tolerance:
            return False
    most = 0.0
    for j in range(z.shape[1]):
        off = max(abs(z[0, j] - memo[0, j]), abs(z[1, j] - memo[1, j]))
        most = max(most, off * (1.0 + table.modes.lam[j]))
    return most <= bound


@inner
def farthest(past, shift, first, last, scale):
    """Greatest distance of the changes number `first` … `last` − 1 from those `shift` before."""
    most, ring = 0.0, past.shape[0] - 1
    for i in range(first, last):
        a, b = past[i & ring], past[(i - shift) & ring]
        if a.state != b.state:
            return 1e9
        most = max(most, abs(a.interval - b.interval), abs(a.gap - b.gap) / scale, abs(a.rate - b.rate) / scale)
    return most


@inlined
def shortest(past, changes, seen, scale, tolerance):
    """The cycle of so many changes or, when a part of it comes back as well, that; 0 when that is still open.

    A motion that settles with a negative multiplier comes back after two cycles before it does after one: the distance
    of a part that still shrinks, by more than 1e-4 of itself in a cycle, is waited for.
    """
    for part in range(1, changes // 2 + 1):
        if changes % part or 2 * changes + part > min(seen, past.shape[0]):
            continue
        off = farthest(past, part, seen - changes, seen, scale)
        if off <= tolerance:
            return part
        if off < 1.0 and abs(off - farthest(past, part, seen - 2 * changes, seen - changes, scale)) > 1e-4 * off:
            return 0
    return changes


@inlined
def recurrence(table, motion, controls, tolerance):
    """The search for a cycle, after each change of the valve: Brent's; two returns with the same cycle confirm it."""
    now, valve, past = motion.now, controls.now, controls.past
    valve.changes += 1
    ring = past.shape[0] - 1
    last = past[(valve.changes - 1) & ring]
    last.interval, last.gap, last.rate, last.state = valve.time - valve.changed, now.gap, now.gap_rate, valve.state
    valve.changed = valve.time
    scale = table.bar.force + abs(now.gap_rate)
    since = valve.changes - valve.memo_changes
    if valve.memo_changes > 0 and returned(table, motion, controls, tolerance, scale):
        cycle = shortest(past, since, valve.changes, scale, tolerance)
        if cycle == 0:
            valve.confirmed, valve.cycle_changes = 0, 0
        else:
            turns = 0
            for i in range(valve.changes - cycle, valve.changes):
                turns += 1 if past[i & ring].state == valve.state else 0
            blows = (valve.blows - valve.memo_blows) * cycle // since
            if cycle == valve.cycle_changes and blows == valve.cycle_blows:
                valve.confirmed += 1
            else:
                valve.confirmed, valve.found_at = 1, valve.memo_impacts
            valve.cycle_changes, valve.cycle_blows, valve.cycle_turns = cycle, blows, turns
            valve.period = (valve.time - valve.memo_time) * cycle / since
            valve.cycle_taken = (valve.taken - valve.memo_taken) * cycle / since
            valve.cycle_speed = valve.strongest
            valve.cycle_kind = 1 if valve.rests > valve.memo_rests else 0
            if valve.chatters > valve.memo_chatters:
                valve.cycle_kind = 2
        remember(motion, controls)
    else:
        if valve.confirmed > 0 and since > valve.cycle_changes:
            valve.confirmed, valve.cycle_changes = 0, 0
        if valve.memo_changes == 0 or since >= valve.patience:
            valve.patience = max(2 * valve.patience, 1)
            remember(motion, controls)


@inner
def sliding(controls):
    """Whether the valve has changed `MANY` times within a `SHORT` time: it will not end at a port."""
    valve = controls.now
    valve.recent += 1
    if valve.recent < MANY:
        return False
    swift = valve.time - valve.window < SHORT
    valve.recent, valve.window = 0, valve.time
    return swift


@inner
def wandering(controls):
    """Whether no shift by up to `SHIFTS` brings the last changes of the valve back to `LOOSE`ly the same."""
    valve, past = controls.now, controls.past
    if valve.changes < SAME + SHIFTS:
        return 0
    top = 1e-300
    for i in range(valve.changes - SAME, valve.changes):
        one = past[i & (past.shape[0] - 1)]
        top = max(top, abs(one.rate), abs(one.gap))
    for shift in range(1, SHIFTS + 1):
        if farthest(past, shift, valve.changes - SAME, valve.changes, top) < LOOSE:
            return 0
    return 1
