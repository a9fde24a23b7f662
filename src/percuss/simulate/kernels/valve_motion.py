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
    AWAY,
    BY_IMPACTS,
    BY_TIME,
    BY_WORK,
    CONTACT,
    CROWDED,
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
)
from percuss.simulate.kernels.flight import advance
from percuss.simulate.kernels.modes import turn_modes
from percuss.simulate.kernels.smooth import drifted, smooth_at_anchor
from percuss.simulate.kernels.valve_changes import SAME_TIME, change, crossings, fire
from percuss.simulate.kernels.valve_cycles import sliding, wandering
from percuss.simulate.kernels.valve_orders import enter, go_by
from percuss.simulate.kernels.valve_records import Drive, Sight
from percuss.simulate.kernels.valve_sight import held_by_gas, met, most, out_of_reach, rigid_place
from percuss.simulate.kernels.valve_wall import let_loose, set_down, strike, to_rest

MANY_PAUSES = 100_000


@entry
def follow_valve(plant, rules, log):
    """The motion from where it stands on, until a rule holds or the record is full; how it ended.

    Time ends at `rules.end_phase`. The anchor stays at the last event then, so that going on gives the same bits.
    """
    gear, motion, controls = plant.gear, plant.motion, plant.controls
    drive = Drive(plant.table, gear, motion, plant.desk, controls)
    sight = Sight(plant.alone, plant.eye, plant.spot, plant.bench)
    count, valve = motion.count, controls.now
    room = log.events.shape[0] - gear.to.shape[0] - 8
    while True:
        if count.impacts >= rules.most_impacts:
            return BY_IMPACTS
        if room > 0 and count.events > room:
            return FULL
        if count.work >= rules.budget:
            return BY_WORK
        if valve.waiting + gear.to.shape[0] > controls.due.shape[0]:  # each port may demand once before the next look
            return CROWDED
        if valve.waiting > 0 and controls.due[0] <= 0.0:
            change(drive, rules.tolerance, log)
            if sliding(controls):
                return ON_PORT
            if rules.until_cycle and valve.confirmed >= 2:
                return PERIODIC
            continue
        left = (rules.end_phase - valve.time) - valve.time_low
        if count.mode == RESTING:
            if gear.forces[valve.state] < 0.0:
                let_loose(drive, log)
                continue
            if valve.waiting == 0:
                return AT_REST
            if controls.due[0] > left:
                return BY_TIME
            go_by(motion, controls, controls.due[0])
            continue
        code = flown(drive, sight, rules, left, log)
        if code != GOES_ON:
            return code


@entry
def wanders(controls):
    """Whether the last changes of the valve do not come near any of the ones before."""
    return wandering(controls)


@inlined
def flown(plant, sight, rules, left, log):
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
    best, which, answer = math.inf, -1, NEVER
    found, tau, speed, late, slip = NOTHING, math.inf, 0.0, 0.0, 0.0
    if forever and now.since == 0.0 and valve.stalled == 0 and held_by_gas(table, gear, motion, controls):
        valve.stalled = 1
        if rules.until_cycle:
            return IN_CHAMBER
    clear, awaited, fresh, usual = valve.clear, valve.awaited, valve.fresh, controls.usual[valve.state]
    if at_once:
        found, tau, speed, late = CONTACT, 0.0, now.gap_rate, math.inf
        controls.cross[:] = math.inf
    else:
        best, which, answer, found, tau, speed, late, slip = upcoming(
            plant, sight, on_wall, first, horizon, forever, rules.budget - count.work
        )
        if found == TIRED:
            return BY_WORK
    count.work += 1
    ahead = min(best, horizon)
    at_wall = tau < math.inf and tau <= ahead + SAME_TIME
    if not at_wall and forever and answer == NEVER:
        return IN_CHAMBER
    if not at_wall and ahead == math.inf:
        return DEPARTED
    if (tau if at_wall else ahead) > left:
        unsought(controls, clear, awaited, fresh, usual)
        return BY_TIME
    if at_wall:
        reach_wall(plant, found, tau, speed, late, slip, log)
        if found == GRAZE:
            return IN_CHAMBER if valve.stalled > 0 else GOES_ON
    elif best <= ahead:
        controls.usual_cross[which] = (valve.time - valve.changed) + best
    if not at_wall and ahead > 0.0:
        on_by(plant, ahead)
        count.mode = FLYING
    if at_wall or best <= horizon + SAME_TIME:
        fire(plant, tau if at_wall else best, at_wall, log)
    elif forever:
        valve.pauses += 1
    return GOES_ON if valve.pauses < MANY_PAUSES else BY_WORK


@inlined
def upcoming(plant, sight, on_wall, first, horizon, forever, limit):
    """The next crossing of a port, and the next contact if it may come before what that crossing leads to.

    Returns the time of the crossing, of which port, whether one may come at all, and what `sought` does, or TIRED.
    """
    gear, motion, controls = plant.gear, plant.motion, plant.controls
    valve, found, tau, speed, late, slip = controls.now, NOTHING, math.inf, 0.0, 0.0, 0.0
    best, which, answer = crossings(plant, sight, first, horizon, limit, forever)
    if answer == TIRED:
        return best, which, answer, TIRED, tau, speed, late, slip
    need = horizon
    if best < math.inf:
        after = best + (gear.delay[which] if controls.kind[which] == ENTERS else 0.0)
        need = min(need, best if best < valve.awaited < after else after)
    if forever and most(plant.table.bar, motion.now) >= -1e-13 * abs(motion.now.gap):
        answer = NOWHERE
    if valve.clear < need:
        found, tau, speed, late, slip = sought(plant, on_wall, need, limit)
    return best, which, answer, found, tau, speed, late, slip


@inlined
def sought(plant, on_wall, need, limit):
    """The next contact, when there is one before the time `need`; otherwise `clear` says so. As `next_contact`.

    How long after a change of the valve the first contact came is what is tried after the next like change.
    """
    now, controls = plant.motion.now, plant.controls
    valve = controls.now
    if out_of_reach(plant.table.bar, now, need + SAME_TIME):
        valve.clear = need
        return NOTHING, math.inf, 0.0, 0.0, 0.0
    found, tau, speed, steps, late, slip = met(
        plant.table, plant.motion, plant.desk, on_wall, now.hold, valve.awaited, need + SAME_TIME, limit
    )
    plant.motion.count.work += steps
    if found == CONTACT:
        if valve.fresh > 0:
            controls.usual[valve.state] = (valve.time - valve.changed) + tau
        valve.awaited, valve.fresh = tau, 0
    elif found != TIRED:
        if found != GRAZE:
            valve.clear, tau = (math.inf if found == AWAY else need), math.inf
        if found == GRAZE or valve.awaited < need:
            valve.awaited = 0.0
    return found, tau, speed, late, slip


@inlined
def unsought(controls, clear, awaited, fresh, usual):
    """What `sought` has left for the next search as it was: the anchor has not moved, and going on seeks again."""
    valve = controls.now
    valve.clear, valve.awaited, valve.fresh = clear, awaited, fresh
    controls.usual[valve.state] = usual


@inlined
def on_by(plant, tau):
    """The anchor moved on by τ, without an impact."""
    advance(plant.table, plant.motion, plant.desk, tau)
    go_by(plant.motion, plant.controls, tau)
    if not (plant.controls.now.waiting > 0 and plant.controls.due[0] <= 0.0):  # else the change of the valve is next
        amplitudes(plant.table.bar, plant.table.modes, plant.motion.z, plant.motion.now)


@inlined
def reach_wall(plant, found, tau, speed, late, slip, log):
    """The anchor moved to a contact, and the blow struck; or to a graze, from which the machine goes on."""
    table, motion, controls, desk = plant.table, plant.motion, plant.controls, plant.desk
    bar, now, count = table.bar, motion.now, motion.count
    if found == GRAZE:
        on_by(plant, tau)
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
