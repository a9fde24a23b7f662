"""The motion of a machine that switches its own valve, from event to event.

Contact, crossings of ports and orders that are due compete. Ports see the motion as a striking end does
(`valve_sight`), so that one search proves which of them comes first; only those are looked at whose state was not the
last demanded. Of simultaneous events the blow comes first, then the ports in their order, then the orders.
"""

from __future__ import annotations

import math

from percuss.compiled import entry, inlined
from percuss.simulate.kernels.bounds import amplitudes
from percuss.simulate.kernels.codes import (
    AT_REST,
    BY_IMPACTS,
    BY_TIME,
    BY_WORK,
    CONTACT,
    DEPARTED,
    ENTERS,
    FLYING,
    FULL,
    GOES_ON,
    GRAZE,
    GRAZED,
    GRAZING,
    IN_CHAMBER,
    NEVER,
    NOTHING,
    NOWHERE,
    ON_PORT,
    ON_WALL,
    PERIODIC,
    RESTING,
    TIRED,
    VALVE,
)
from percuss.simulate.kernels.first_contact import next_contact
from percuss.simulate.kernels.flight import advance
from percuss.simulate.kernels.modes import turn_modes
from percuss.simulate.kernels.smooth import drifted, smooth_at_anchor
from percuss.simulate.kernels.valve_cycles import recurrence, sliding, wandering
from percuss.simulate.kernels.valve_orders import demand, enter, go_by, next_order
from percuss.simulate.kernels.valve_sight import EDGE, held_by_gas, most, next_crossing, rigid_place, seen
from percuss.simulate.kernels.valve_wall import let_loose, lie, set_down, strike, to_rest

SAME_TIME = 4e-12  # within this events are simultaneous; a period is some units of time
MANY_PAUSES = 100_000


@entry
def follow_valve(plant, rules, log):
    """The motion from where it stands on, until a rule holds or the record is full; how it ended.

    Time ends at `rules.end_phase`. The anchor stays at the last event then, so that going on gives the same bits.
    """
    gear, motion, controls = plant.gear, plant.motion, plant.controls
    count, valve = motion.count, controls.now
    room = log.events.shape[0] - gear.to.shape[0] - 8
    while True:
        if count.impacts >= rules.most_impacts:
            return BY_IMPACTS
        if room > 0 and count.events > room:
            return FULL
        if count.work >= rules.budget:
            return BY_WORK
        if valve.waiting > 0 and controls.due[0] <= 0.0:
            change(plant, rules.tolerance, log)
            if sliding(controls):
                return ON_PORT
            if rules.until_cycle and valve.confirmed >= 2:
                return PERIODIC
            continue
        left = (rules.end_phase - valve.time) - valve.time_low
        if count.mode == RESTING:
            if gear.forces[valve.state] < 0.0:
                let_loose(plant, log)
                continue
            if valve.waiting == 0:
                return AT_REST
            if controls.due[0] > left:
                return BY_TIME
            go_by(motion, controls, controls.due[0])
            continue
        code = flown(plant, rules, left, log)
        if code != GOES_ON:
            return code


@entry
def wanders(controls):
    """Whether the last changes of the valve do not come near any of the ones before."""
    return wandering(controls)


@inlined
def change(plant, tolerance, log):
    """The order that is due is carried out: the static shape jumps, so the free part jumps back."""
    table, gear, motion, controls = plant.table, plant.gear, plant.motion, plant.controls
    bar, modes, now, count, valve, z = table.bar, table.modes, motion.now, motion.count, controls.now, motion.z
    old = gear.forces[valve.state]
    valve.state = next_order(controls)
    new = gear.forces[valve.state]
    if count.mode == RESTING:
        lie(table, motion, new)
    else:
        for j in range(modes.omega.shape[0]):
            jump = modes.statics[j] * (old - new)
            z[0, j] += jump
            z[1, j] -= modes.half[j] * jump * modes.inverse[j]
        amplitudes(bar, modes, z, now)
        if now.hold > 0.0 and new > 0.0:  # just released: not out of the wall's reach before the force pushes again
            now.hold = max(min(now.hold, valve.lap), 0.0)
            if now.hold == 0.0 and now.gap >= 0.0:
                now.gap, count.mode = 0.0, ON_WALL
    valve.clear, valve.pauses, valve.fresh, valve.stalled = 0.0, 0, 1, 0
    valve.awaited = controls.usual[valve.state] if now.hold == 0.0 else 0.0
    if new < 0.0:
        valve.pulled = 1
    enter(VALVE, now.gap_rate, 0.0, 0.0, 0, motion, controls, log)
    recurrence(table, motion, controls, tolerance)


@inlined
def crossings(plant, first, horizon, limit, forever):
    """The next crossing of each port, in `cross` and `kind`; returns the first time, of which port, and NEVER or not.

    Only ports whose state was not the last demanded can do anything. TIRED when one could not be decided.
    """
    gear, motion, controls = plant.gear, plant.motion, plant.controls
    cross, kind, last = controls.cross, controls.kind, controls.now.last
    best, which, answer = math.inf, -1, NEVER
    for port in range(gear.to.shape[0]):
        cross[port], kind[port] = math.inf, NOWHERE
        if gear.side[port] == 0.0 or gear.to[port] == last:
            continue
        until = min(horizon, best) + SAME_TIME
        cross[port], kind[port], steps = next_crossing(plant, port, first, until, limit, forever)
        motion.count.work += steps
        if kind[port] == TIRED:
            return best, which, TIRED
        if kind[port] != NEVER:
            answer = NOWHERE
        if cross[port] < best:
            best, which = cross[port], port
    return best, which, answer


@inlined
def flown(plant, rules, left, log):
    """The motion on to its next event, or the proof that there is none; how it ends, or GOES_ON."""
    table, gear, motion, controls = plant.table, plant.gear, plant.motion, plant.controls
    bar, now, count, valve, desk = table.bar, motion.now, motion.count, controls.now, plant.desk
    first = rigid_place(table, gear, motion, gear.forces[valve.state])
    bar.mean = gear.gain * gear.forces[valve.state] - bar.spring * bar.spring * first
    smooth_at_anchor(bar, table.harmonics, now, desk.osc)
    due = controls.due[0] if valve.waiting > 0 else math.inf
    forever = due == math.inf and bar.spring > 0.0
    horizon = math.pi / bar.spring if forever else due
    on_wall, at_once = count.mode == ON_WALL or count.mode == GRAZED, False
    if on_wall and now.hold == 0.0:
        wait = to_rest(plant, due)
        if wait >= 0.0:
            if wait > left:
                return BY_TIME
            set_down(plant, wait, log)
            return GOES_ON
        at_once = wait == -2.0
    limit = rules.budget - count.work
    best, which, answer = math.inf, -1, NEVER
    found, tau, speed, late, slip = NOTHING, math.inf, 0.0, 0.0, 0.0
    if forever and now.since == 0.0 and valve.stalled == 0 and held_by_gas(table, gear, motion, controls):
        valve.stalled = 1
        if rules.until_cycle:
            return IN_CHAMBER
    if at_once:
        found, tau, speed, late = CONTACT, 0.0, now.gap_rate, math.inf
        controls.cross[:] = math.inf
    else:
        best, which, answer = crossings(plant, first, horizon, limit, forever)
        if answer == TIRED:
            return BY_WORK
        need = horizon
        if best < math.inf:
            need = min(need, best + (gear.delay[which] if controls.kind[which] == ENTERS else 0.0))
        if forever and most(bar, now) >= -1e-13 * abs(now.gap):
            answer = NOWHERE
        if valve.clear < need:
            found, tau, speed, steps, late, slip = next_contact(
                table, motion, desk, on_wall, now.hold, valve.awaited, need + SAME_TIME, limit
            )
            count.work += steps
            if found == TIRED:
                return BY_WORK
            if found != CONTACT and found != GRAZE:
                valve.clear, tau = need, math.inf
            elif valve.fresh > 0:
                controls.usual[valve.state] = tau
            valve.awaited = tau if found == CONTACT else 0.0
            valve.fresh = 0
    count.work += 1
    ahead = min(best, horizon)
    if tau < math.inf and tau <= ahead + SAME_TIME:
        if tau > left:
            return BY_TIME
        reach_wall(plant, found, tau, speed, late, slip, log)
        if found == CONTACT:
            fire(plant, tau, True, log)
        elif valve.stalled > 0:
            return IN_CHAMBER
        return GOES_ON
    if forever and answer == NEVER:
        return IN_CHAMBER
    if ahead == math.inf:
        return DEPARTED
    if ahead > left:
        return BY_TIME
    if ahead > 0.0:
        advance(table, motion, desk, ahead)
        amplitudes(bar, table.modes, motion.z, now)
        go_by(motion, controls, ahead)
        count.mode = FLYING
    if best <= horizon + SAME_TIME:
        fire(plant, best, False, log)
    elif forever:
        valve.pauses += 1
        if valve.pauses > MANY_PAUSES:
            return BY_WORK
    return GOES_ON


@inlined
def reach_wall(plant, found, tau, speed, late, slip, log):
    """The anchor moved to a contact, and the blow struck; or to a graze, from which the machine goes on."""
    table, motion, controls, desk = plant.table, plant.motion, plant.controls, plant.desk
    bar, now, count = table.bar, motion.now, motion.count
    if found == GRAZE:
        advance(table, motion, desk, tau)
        amplitudes(bar, table.modes, motion.z, now)
        go_by(motion, controls, tau)
        count.mode, now.hold, now.gap_rate, controls.now.clear = GRAZED, 0.0, 0.0, 0.0
        count.pile = count.pile + 1 if tau < 1e-15 else 0
        if count.pile > 100:
            now.hold, count.pile = 1e-8, 0
        enter(GRAZING, 0.0, 0.0, 0.0, 0, motion, controls, log)
        return
    if tau > 0.0:
        rest = drifted(bar, now, tau)
        turn_modes(bar, table.modes, motion.z, desk, tau, late, slip)
        now.rigid_rate = rest if table.modes.omega.shape[0] else speed
        go_by(motion, controls, tau)
    now.gap_rate, now.hold, count.mode = speed, 0.0, ON_WALL
    strike(plant, speed, log)


@inlined
def fire(plant, at, struck, log):
    """The ports that are crossed at this moment demand, in their order; with a blow, those of the blow besides.

    `at`: the time of the event, from the anchor before it.
    """
    table, gear, motion, controls = plant.table, plant.gear, plant.motion, plant.controls
    force = gear.forces[controls.now.state]
    first = rigid_place(table, gear, motion, force)
    for port in range(gear.to.shape[0]):
        if gear.side[port] == 0.0:
            if struck:
                demand(gear, motion, controls, port, motion.now.gap_rate, log)
            continue
        place, rate = seen(table, gear, motion, force, port, first)
        now_in = controls.kind[port] == ENTERS and controls.cross[port] <= at + SAME_TIME
        if not now_in and not struck and gear.side[port] * rate > 0.0:  # of those whose state was demanded last before
            now_in = abs(place + gear.edge[port]) <= EDGE * (abs(place) + gear.edge[port])
        if now_in:
            controls.just[port] = 1
            demand(gear, motion, controls, port, rate, log)


@entry
def begin_valve(plant, displacement, rate, resting, on_wall, asks, log):
    """The anchor at a start: q_i and q_i', (N+1,), of which the gap is the sum unless it is on the wall.

    `asks`: whether ports whose region is occupied demand at once, in their order.
    """
    table, gear, motion, controls = plant.table, plant.gear, plant.motion, plant.controls
    bar, modes, now, count, z = table.bar, table.modes, motion.now, motion.count, motion.z
    force = gear.forces[controls.now.state]
    gap, speed = displacement[0], rate[0]
    for j in range(modes.omega.shape[0]):
        gap += displacement[j + 1]
        speed += rate[j + 1]
        z[0, j] = displacement[j + 1] - force * modes.statics[j]
        z[1, j] = rate[j + 1]
        if modes.oscillates[j] > 0.0:
            z[1, j] = -modes.inverse[j] * (rate[j + 1] + modes.half[j] * z[0, j])
    now.gap, now.gap_rate, now.rigid_rate = 0.0 if on_wall else gap, speed, rate[0]
    now.last_flight = -1.0
    amplitudes(bar, modes, z, now)
    count.mode = RESTING if resting else (ON_WALL if on_wall else FLYING)
    if not asks:
        return
    first = rigid_place(table, gear, motion, force)
    for port in range(gear.to.shape[0]):
        place, own = seen(table, gear, motion, force, port, first)
        off = gear.side[port] * (place + gear.edge[port])
        if off > EDGE * (abs(place) + gear.edge[port]):
            controls.just[port] = 1
            demand(gear, motion, controls, port, own, log)
