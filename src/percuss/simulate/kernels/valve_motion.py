"""The motion of a machine that switches its own valve, from event to event.

Contact, crossings of ports and orders that are due compete. Ports see the motion as a striking end does
(`valve_sight`), so that one search proves which of them comes first; only those are looked at whose state was not the
last demanded. Of simultaneous events the blow comes first, then the ports in their order, then the orders.
"""

from __future__ import annotations

import math

from percuss.compiled import entry, inlined, inner
from percuss.simulate.kernels.bounds import amplitudes, drifted, smooth_at_anchor
from percuss.simulate.kernels.modes import turn_modes
from percuss.simulate.kernels.motion import NO_SPEED, advance, jump_back
from percuss.simulate.kernels.motion_records import (
    AT_REST,
    AWAY,
    BY_IMPACTS,
    BY_TIME,
    BY_WORK,
    CHATTER,
    CONTACT,
    CROWDED,
    DEPARTED,
    EMPTY,
    ENTERS,
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
    NEVER,
    NO_PORT,
    NOTHING,
    NOWHERE,
    ON_PORT,
    ON_WALL,
    PERIODIC,
    RELEASE,
    REST,
    RESTING,
    TIRED,
    VALVE,
    Drive,
    Sight,
)
from percuss.simulate.kernels.valve_sight import (
    EDGE,
    demand,
    enter,
    go_by,
    held_by_gas,
    met,
    most,
    next_crossing,
    next_order,
    out_of_reach,
    recharge,
    recurrence,
    rigid_place,
    rising,
    seen,
    sliding,
    wandering,
)
from percuss.simulate.kernels.wall import CHATTER_ERROR, all_energy, chatter_left, held, impact, undeformed

# ---- What happens to a machine at the wall: the blow, rest at the end of chatter, and release

QUARTER = 0.3  # of the time in which a chamber turns a released machine round, in radians of its frequency


@inlined
def oil_moved(plant, factor):
    """What is left where the driven end of a machine with a supply jumps to `factor` times its place: the pressure.

    The spring of the modes is that of the oil as well; returns what this seems to lose, and does not.
    """
    gear, motion, valve = plant.gear, plant.motion, plant.controls.now
    if gear.draw == 0.0:
        return 0.0
    first = rigid_place(plant.table, motion, valve.force)
    place, _ = seen(plant.table, gear, motion, valve.force, gear.to.shape[0], first)
    recharge(gear, valve, gear.draw * (factor - 1.0) * place)
    return 0.5 * gear.draw * gear.slope * (1.0 - factor * factor) * place * place


@inlined
def strike(plant, speed, log):
    """One blow: the velocities turned over, and the strain where the law does; u_t → −R u_t (B77 10)."""
    table, motion, desk, controls = plant.table, plant.motion, plant.desk, plant.controls
    now, count, valve, force = motion.now, motion.count, controls.now, controls.now.force
    now.gap, kept = 0.0, 0.0
    if force < 0.0:
        valve.pulled = 1
    if table.bar.strain != 1.0 and table.modes.omega.shape[0] > 0:
        kept = oil_moved(plant, table.bar.strain)
    lost = impact(table, motion, desk, force) - kept
    if valve.force != force:
        jump_back(table, motion, force, valve.force)
        force = valve.force
    brief = now.since < now.last_flight and valve.pulled == 0
    count.run = count.run + 1 if brief and now.last_flight > 0.0 else 1
    count.pile = count.pile + 1 if now.since < 4.0 * EPS else 0
    now.last_flight = math.inf if now.last_flight < 0.0 else now.since
    now.since, valve.pulled, valve.clear = 0.0, 1 if force < 0.0 else 0, 0.0
    valve.awaited, valve.fresh = 0.0, 0
    count.impacts += 1
    valve.blows += 1
    valve.taken += lost
    valve.strongest = max(valve.strongest, speed)
    enter(IMPACT, speed, lost, NO_PORT, motion, controls, log)


@inner
def set_down(plant, wait, log):
    """The bar comes to rest, after `wait` when chatter ends then: what motion and strain it has is lost."""
    table, gear, motion, controls = plant.table, plant.gear, plant.motion, plant.controls
    count, valve = motion.count, controls.now
    lost = all_energy(table, motion, plant.desk, valve.force)
    lost -= oil_moved(plant, 0.0)
    chatter = table.bar.restitution > 0.0 and (count.run > 1 or wait > 0.0)
    valve.taken += lost
    go_by(gear, motion, controls, wait)
    undeformed(table, motion, plant.desk, valve.force)
    count.mode, valve.clear = RESTING, 0.0
    valve.rests += 1
    if chatter:
        valve.chatters += 1
        valve.blows -= count.run - 1
        enter(CHATTER, 0.0, lost, NO_PORT, motion, controls, log)
        lost = 0.0
    enter(REST, 0.0, lost, NO_PORT, motion, controls, log)
    if chatter:  # the last of its blows
        for port in range(gear.to.shape[0]):
            if gear.side[port] == 0.0:
                demand(gear, motion, controls, port, 0.0, log)


@inner
def let_loose(plant, log):
    """A resting bar released, undeformed, as the force pulls.

    Its end only moves away until the force pushes again or, in a chamber, until the spring turns it round, and until
    that has run through the bar as a wave.
    """
    bar, motion, controls = plant.table.bar, plant.motion, plant.controls
    now, count, valve = motion.now, motion.count, controls.now
    undeformed(plant.table, motion, plant.desk, valve.force)
    count.mode, count.run, count.pile = ON_WALL, 0, 0
    valve.lap, valve.pulled, valve.clear, valve.awaited = bar.wave, 1, 0.0, 0.0
    now.hold = math.inf if bar.spring == 0.0 else max(bar.wave, QUARTER / bar.spring)
    if bar.ramp > 0.0:  # the force pushes again
        now.hold = min(now.hold, -valve.force / bar.ramp)
    now.last_flight, now.since = -1.0, 0.0
    enter(RELEASE, 0.0, 0.0, NO_PORT, motion, controls, log)


@inlined
def to_rest(plant, ahead):
    """Whether a bar on the wall comes to rest, and after what time; −1 when it flies, −2 when it strikes at once.

    `ahead`: time to the next order.
    """
    table, motion = plant.table, plant.motion
    bar, now, count = table.bar, motion.now, motion.count
    forgets = bar.strain == 0.0 and table.modes.omega.shape[0] > 0  # undeformed, it leaves as from rest
    slow = NO_SPEED * (abs(now.drift) + now.sup1)
    if now.gap_rate > slow:
        return -2.0
    if now.gap_rate >= -slow:
        pushed = plant.controls.now.force > 0.0
        struck = count.mode == ON_WALL and bar.restitution == 0.0 and (pushed or forgets)
        if struck or now.acceleration >= 0.0 or count.pile > 100:
            return 0.0
        now.gap_rate = 0.0
        return -1.0
    most = held(table, motion)
    if most >= 0.0 and all_energy(table, motion, plant.desk, plant.controls.now.force) <= most:
        return 0.0
    left = chatter_left(table, motion, plant.desk, ahead)
    sprung = bar.spring * left
    return left if sprung * sprung * left <= CHATTER_ERROR else -1.0


# ---- What changes the valve of a machine: its ports as they are crossed, and the orders as they are due

SAME_TIME = 4e-12  # within this events are simultaneous; a period is some units of time


@inlined
def change(plant, tolerance, log):
    """The order that was due is carried out: the static shape jumps, so the free part jumps back."""
    table, gear, motion, controls = plant.table, plant.gear, plant.motion, plant.controls
    now, count, valve = motion.now, motion.count, controls.now
    before, after, old = valve.before, valve.state, valve.force
    valve.handed = 0
    recharge(gear, valve, 0.0)
    new = valve.force
    if valve.fresh > 0:  # no contact came under the force that ends now
        controls.usual[before] = 0.0
    if count.mode == RESTING:
        undeformed(table, motion, plant.desk, new)
    else:
        jump_back(table, motion, old, new)
        if now.hold > 0.0 and new > 0.0:  # just released: not out of the wall's reach before the force pushes again
            now.hold = max(min(now.hold, valve.lap), 0.0)
            if now.hold == 0.0 and now.gap >= 0.0:
                now.gap, count.mode = 0.0, ON_WALL
    valve.clear, valve.pauses, valve.fresh, valve.stalled = 0.0, 0, 1, 0
    valve.awaited = controls.usual[valve.state] if now.hold == 0.0 else 0.0
    if new < 0.0:
        valve.pulled = 1
    if after != before:  # else it came in place of an order that would have changed the state
        enter(VALVE, now.gap_rate, 0.0, NO_PORT, motion, controls, log)
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
    for port in range(gear.ratio.shape[0]):
        cross[port], kind[port] = math.inf, NOWHERE
        if port == gear.to.shape[0]:
            if gear.draw == 0.0:
                continue
        elif gear.side[port] == 0.0 or gear.to[port] == last:
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
    force = controls.now.force
    first = rigid_place(table, motion, force)
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
def begin_valve(plant, asks, log):
    """What follows from a start; `asks`: whether ports whose region is occupied demand at once, in their order."""
    table, gear, motion, controls = plant.table, plant.gear, plant.motion, plant.controls
    force = controls.now.force
    amplitudes(table.bar, table.modes, motion.z, motion.now)
    if not asks:
        return
    first = rigid_place(table, motion, force)
    for port in range(gear.to.shape[0]):
        place, own = seen(table, gear, motion, force, port, first)
        off = gear.side[port] * (place + gear.edge[port])
        if off > EDGE * (abs(place) + gear.edge[port]):
            controls.just[port] = 1
            demand(gear, motion, controls, port, own, log)


# ---- The motion of a machine that switches its own valve, from event to event

MANY_PAUSES = 100_000
IN_VAIN = 64  # half swings of a stalled machine without a blow, after which it is followed only to a time asked for


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
        if valve.handed == 0 and valve.waiting > 0 and controls.due[0] <= 0.0:
            valve.before, valve.handed = valve.state, 1
            valve.state = next_order(controls)
            if gear.flow > 0.0:  # the modes are others in another state
                return HANDED
        if valve.handed > 0:
            change(drive, rules.tolerance, log)
            if sliding(controls):
                return ON_PORT
            if rules.until_cycle and valve.confirmed >= 2:
                return PERIODIC
            continue
        left = (rules.end_phase - valve.time) - valve.time_low
        if count.mode == RESTING:
            growth = drive.table.bar.ramp
            due = controls.due[0] if valve.waiting > 0 else math.inf
            lifted = valve.force / -growth if growth < 0.0 else math.inf
            if valve.force < 0.0 or lifted == 0.0:
                let_loose(drive, log)
                continue
            if min(due, lifted) == math.inf:
                return AT_REST
            if min(due, lifted) > left:
                return BY_TIME
            go_by(gear, motion, controls, min(due, lifted))
            if lifted < due:
                valve.force = 0.0
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
    first = rigid_place(table, motion, valve.force)
    bar.mean = gear.gain * valve.force - bar.spring * bar.spring * first
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
    if valve.stalled > 0 and rules.end_phase == math.inf and now.since > IN_VAIN * horizon:
        return BY_WORK
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
        return DEPARTED if bar.lift < 0.0 else IN_CHAMBER
    if not at_wall and ahead == math.inf:
        return DEPARTED
    if (tau if at_wall else ahead) > left:
        unsought(controls, clear, awaited, fresh, usual)
        return BY_TIME
    if at_wall:
        reach_wall(plant, found, tau, speed, late, slip, log)
        if found == GRAZE:
            return IN_CHAMBER if valve.stalled > 0 and table.modes.omega.shape[0] == 0 else GOES_ON
    elif best <= ahead:
        controls.usual_cross[which] = (valve.time - valve.changed) + best
    if not at_wall and ahead > 0.0:
        on_by(plant, ahead)
        count.mode = FLYING
    if not at_wall and which == gear.to.shape[0] and best <= ahead:
        return EMPTY
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
    best, which, answer = math.inf, -1, NEVER
    if valve.stalled > 0:
        controls.cross[:] = math.inf
    else:
        best, which, answer = crossings(plant, sight, first, horizon, limit, forever)
    if answer == TIRED:
        return best, which, answer, TIRED, tau, speed, late, slip
    need = horizon
    if best < math.inf:
        later = which < gear.to.shape[0] and controls.kind[which] == ENTERS
        after = best + (gear.delay[which] if later else 0.0)
        need = min(need, best if best < valve.awaited < after else after)
    bar = plant.table.bar
    if forever and (rising(bar) or most(bar, motion.now) >= -1e-13 * abs(motion.now.gap)):
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
    go_by(plant.gear, plant.motion, plant.controls, tau)
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
        enter(GRAZING, 0.0, 0.0, NO_PORT, motion, controls, log)
        return
    if tau > 0.0:
        rest = drifted(bar, now, tau)
        turn_modes(bar, table.modes, motion.z, desk, tau, late, slip)
        now.rigid_rate = rest if table.modes.omega.shape[0] else speed
        go_by(plant.gear, motion, controls, tau)
    now.gap_rate, now.hold, count.mode = speed, 0.0, ON_WALL
    strike(plant, speed, log)
