"""What changes the valve of a machine: its ports as they are crossed, and the orders as they are due."""

from __future__ import annotations

import math

from percuss.compiled import entry, inlined
from percuss.simulate.kernels.bounds import amplitudes
from percuss.simulate.kernels.codes import ENTERS, FLYING, NEVER, NOWHERE, ON_WALL, RESTING, TIRED, VALVE
from percuss.simulate.kernels.valve_cycles import recurrence
from percuss.simulate.kernels.valve_orders import demand, enter, next_order
from percuss.simulate.kernels.valve_sight import EDGE, next_crossing, rigid_place, seen
from percuss.simulate.kernels.valve_wall import lie

SAME_TIME = 4e-12  # within this events are simultaneous; a period is some units of time


@inlined
def change(plant, tolerance, log):
    """The order that is due is carried out: the static shape jumps, so the free part jumps back."""
    table, gear, motion, controls = plant.table, plant.gear, plant.motion, plant.controls
    bar, modes, now, count, valve, z = table.bar, table.modes, motion.now, motion.count, controls.now, motion.z
    old = gear.forces[valve.state]
    if valve.fresh > 0:  # no contact came under the force that ends now
        controls.usual[valve.state] = 0.0
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
def crossings(plant, sight, first, horizon, limit, forever):
    """The next crossing of each port, in `cross` and `kind`; returns the first time, of which port, and NEVER or not.

    Only ports whose state was not the last demanded can do anything. TIRED when one could not be decided.
    """
    gear, motion, controls = plant.gear, plant.motion, plant.controls
    cross, kind, last = controls.cross, controls.kind, controls.now.last
    best, which, answer = math.inf, -1, NEVER
    since = controls.now.time - controls.now.changed
    for port in range(gear.to.shape[0]):
        cross[port], kind[port] = math.inf, NOWHERE
        if gear.side[port] == 0.0 or gear.to[port] == last:
            continue
        until = min(horizon, best) + SAME_TIME
        guess = controls.usual_cross[port] - since
        cross[port], kind[port], steps = next_crossing(plant, sight, port, first, until, limit, forever, guess)
        motion.count.work += steps
        if kind[port] == TIRED:
            return best, which, TIRED
        if kind[port] != NEVER:
            answer = NOWHERE
        if cross[port] < best:
            best, which = cross[port], port
    return best, which, answer


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
