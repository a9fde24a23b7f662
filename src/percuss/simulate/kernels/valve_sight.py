"""What ports see of the motion: each sees its own distance from its edge as the gap of a striking end.

So the proven search for the next contact finds the next crossing as well, of a port that reads any place on the bar.
"""

from __future__ import annotations

import math

from percuss.compiled import inlined, inner, summed
from percuss.simulate.kernels.bounds import amplitudes_apart, smooth_at_anchor
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
    RESTING,
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


@inlined
def push_on_rigid_motion(bar, valve, first):
    """Acceleration of the rigid motion, without drag, where it is at q_0 = `first` on the gas of a chamber."""
    return valve.gear.gain * valve.controls.now.force - bar.spring * bar.spring * first


@summed
def seen(table, motion, port, first, valve):
    """What a port reads, a place or a speed, and its rate; `first` is q_0."""
    modes, z, gear, force = table.modes, motion.z, valve.gear, valve.controls.now.force
    ratio = gear.ratio
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
    if gear.speeds[port]:
        return rate, acceleration(table, motion, port, first, valve)
    return place, rate


@summed
def acceleration(table, motion, port, first, valve):
    """Of what a port reads."""
    bar, modes, z, ratio = table.bar, table.modes, motion.z, valve.gear.ratio
    total = ratio[port, 0] * (push_on_rigid_motion(bar, valve, first) - bar.damping * motion.now.rigid_rate)
    for j in range(modes.omega.shape[0]):
        own = -modes.lam[j] * z[1, j] - modes.half[j] * z[0, j] + (1.0 - modes.oscillates[j]) * z[1, j]
        total -= ratio[port, j + 1] * (modes.omega[j] * modes.omega[j] * z[0, j] + modes.damping[j] * own)
    return total


@inlined
def rising(bar):
    """Whether the line about which a motion swings, on a spring, rises in the end."""
    line = bar.lift / (bar.spring * bar.spring)
    return line + bar.climb > 1e-13 * (abs(line) + abs(bar.climb))


@inlined
def aim(gear, table, motion, eye, port, sign, gap, rate):
    """The motion as a port sees it, `gap` from its edge: below 0 on this side, for the given sign."""
    # Velocities move as places do, by the same law; z' = (iλ − d/2) z of what oscillates.
    bar, modes, z, own, now, rigid_rate = table.bar, table.modes, motion.z, eye.z, eye.now, motion.now.rigid_rate
    if gear.speeds[port]:
        rigid_rate = bar.mean - bar.damping * rigid_rate
    for j in range(own.shape[1]):
        scale, one, other = sign * gear.ratio[port, j + 1], z[0, j], z[1, j]
        if gear.speeds[port]:
            one, other = -modes.lam[j] * z[1, j] - modes.half[j] * z[0, j], modes.lam[j] * one - modes.half[j] * other
            if modes.oscillates[j] == 0.0:
                one, other = z[1, j], -modes.omega[j] * modes.omega[j] * z[0, j] - modes.damping[j] * z[1, j]
        own[0, j], own[1, j] = scale * one, scale * other
    now.gap, now.gap_rate, now.rigid_rate = gap, rate, sign * gear.ratio[port, 0] * rigid_rate
    now.hold = 0.0


@inlined
def most(bar, now):
    """What the gap of a motion in the chamber never exceeds: the drift keeps within its circle, the modes in theirs."""
    # The circle moves as an accumulator is filled; so this is asked where it is not `rising`.
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
def held_by_gas(table, motion, valve):
    """Whether no port whose demand counts can ever be reached, whatever blows come: they take energy alone."""
    # Asked while no order waits. A place is never farther from where it would be still than √(Σ w_i²/ω_i²) times the
    # root of twice the energy about there, which falls in flight, and at a blow that keeps the strain.
    gear, own, modes = valve.gear, valve.controls.now, table.modes
    if (table.bar.strain != 1.0 and modes.omega.shape[0] > 0) or table.bar.ramp != 0.0:
        return False
    force, root = own.force, math.sqrt(swing(table, motion))
    for port in range(gear.to.shape[0]):
        if gear.to[port] == own.last:
            continue
        if gear.side[port] == 0.0:
            return False
        off = gear.side[port] * (force * gear.still[port] + gear.edge[port])
        if not off + gear.sway[port] * root < -EDGE * abs(gear.edge[port]):
            return False
    return True


@inner
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
    """The next crossing that an eye sees: what was found, its time, and the evaluations."""
    # `push`: `mean`, `lift` and `climb` as it sees them. `forever`: whether nothing else ends the motion in a chamber,
    # so that a crossing may be proved never to come. `guess` > 0: a time worth trying.
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
def next_crossing(table, motion, desk, port, first, horizon, limit, forever, guess, valve, sight):
    """When a port is next entered, or left so that it may be entered again; NOWHERE when not before the horizon."""
    # The pressure of a supply falls to 0 where p u comes to the charge: this is a port whose edge draws back at q/|p|.
    # Returns the time, what it is, and the evaluations. A graze is a time to look anew.
    gear, controls = valve.gear, valve.controls
    place, rate = seen(table, motion, port, first, valve)
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
    if gear.speeds[port]:
        push = (scale * (bar.lift - bar.spring * bar.spring * motion.now.rigid_rate), 0.0, 0.0)
    if gear.rigid[port]:
        aim(gear, table, motion, sight.spot, port, sign, gap, toward)
        found, tau, steps = looked_for(
            sight.alone, sight.spot, sight.bench, push, at_edge, toward, horizon, limit, forever, guess
        )
    else:
        aim(gear, table, motion, sight.eye, port, sign, gap, toward)
        amplitudes_apart(table.bar, table.modes, sight.eye.z, sight.eye.now)
        found, tau, steps = looked_for(table, sight.eye, desk, push, at_edge, toward, horizon, limit, forever, guess)
    if found == NEVER:
        return math.inf, NEVER, steps
    if found == TIRED:
        return math.inf, TIRED, steps
    if found in (CONTACT, GRAZE):
        return tau, (ENTERS if found == CONTACT and not inside else LEAVES), steps
    return math.inf, NOWHERE, steps


# ---- Demands and orders of the valve, and the time that goes by


@inner
def pace(table, motion, first, valve):
    """How fast the spool travels that is set off now; `first` is q_0. A bar at rest is undeformed."""
    gear, place = valve.gear, 0.0
    if gear.quickening == 0.0:
        return 1.0
    if gear.draw != 0.0 and motion.count.mode != RESTING:
        place, _ = seen(table, motion, gear.to.shape[0], first, valve)
    return 1.0 + gear.quickening * ((valve.controls.now.charge - gear.draw * place) * gear.soft - 1.0)


@inner
def demand(motion, port, rate, pace, log, valve):
    """A port demands its state: ignored when it was demanded last; a later demand replaces what would come after it."""
    # `rate`: velocity of what the port reads.
    gear, own, due, order = valve.gear, valve.controls.now, valve.controls.due, valve.controls.order
    to = gear.to[port]
    if to == own.last:
        return
    own.last = to
    delay = gear.delay[port] / pace
    while own.waiting > 0 and due[own.waiting - 1] >= delay:
        own.waiting -= 1
    due[own.waiting], order[own.waiting] = delay, to  # there is room: see `CROWDED`
    own.waiting += 1
    record(PORT, rate, 0.0, port, motion, valve, log)


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
def first_due(valve):
    """Time to the order that is due first; inf when none waits."""
    return valve.controls.due[0] if valve.controls.now.waiting > 0 else math.inf


@inlined
def go_by(motion, tau, valve):
    """The time τ has gone by: the clock, exact to twice the digits, the supply, and all that counts down."""
    now, own, controls = motion.now, valve.controls.now, valve.controls
    total = own.time + tau
    back = total - own.time
    own.time_low += (own.time - (total - back)) + (tau - back)
    own.time = total
    if valve.gear.flow > 0.0:
        recharge(valve, valve.gear.flow * tau)
    for i in range(own.waiting):
        controls.due[i] -= tau
    for j in range(controls.just.shape[0]):
        controls.just[j] = 0
    now.since += tau
    own.clear -= tau
    own.lap -= tau
    own.awaited = own.awaited - tau if own.awaited > tau else 0.0
    now.hold = now.hold - tau if now.hold > tau else 0.0


@inlined
def recharge(valve, by):
    """More charge of the supply, and the force with it."""
    own = valve.controls.now
    own.charge += by
    own.force = valve.gear.forces[own.state] + valve.gear.slope * own.charge


@inlined
def oil_moved(table, motion, factor, valve):
    """What is left where the driven end of a machine with a supply jumps to `factor` times its place: the pressure."""
    # The spring of the modes is that of the oil as well; returns what this seems to lose, and does not.
    gear = valve.gear
    if gear.draw == 0.0:
        return 0.0
    first = rigid_place(table, motion, valve.controls.now.force)
    place, _ = seen(table, motion, gear.to.shape[0], first, valve)
    recharge(valve, gear.draw * (factor - 1.0) * place)
    return 0.5 * gear.draw * gear.slope * (1.0 - factor * factor) * place * place
