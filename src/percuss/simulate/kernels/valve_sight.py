"""What ports see of the motion: each sees its own distance from its edge as the gap of a striking end.

So the proven search for the next contact finds the next crossing as well, of a port that reads any place on the bar.
"""

from __future__ import annotations

import math

from percuss.compiled import apart, inlined, summed
from percuss.simulate.kernels.bounds import amplitudes
from percuss.simulate.kernels.codes import CONTACT, ENTERS, GRAZE, LEAVES, NEVER, NOTHING, NOWHERE, TIRED
from percuss.simulate.kernels.first_contact import next_contact
from percuss.simulate.kernels.smooth import smooth_at_anchor

EDGE = 1e-13  # how near to a port, of the distances, the bar is at its edge


@summed
def rigid_place(table, gear, motion, force):
    """q_0, what is left of the gap without the elastic modes."""
    modes, z, total = table.modes, motion.z, 0.0
    for j in range(modes.omega.shape[0]):
        total += z[0, j] + force * modes.statics[j]
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
    return place, rate


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
    """What the gap of a motion in the chamber never exceeds: the drift keeps within its circle, the modes in theirs."""
    square = bar.spring * bar.spring
    place, rate = -bar.mean / square, now.drift / bar.spring
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
    if table.bar.strain != 1.0 and modes.omega.shape[0] > 0:
        return False
    force, root = gear.forces[valve.state], math.sqrt(swing(table, motion))
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
    up = abs(pull) + bar.spring * abs(now.drift) if bar.spring > 0.0 else max(pull, 0.0)
    top, rise = now.gap - now.free + now.sup, now.smooth_rate + 0.5 * up * horizon
    sizes = abs(now.gap) + now.sup + (abs(now.smooth_rate) + up * horizon) * horizon
    return top + max(rise, 0.0) * horizon < -1e-12 * sizes


@inlined
def looked_for(table, eye, desk, sign, scale, mean, at_edge, rate, horizon, limit, forever, guess):
    """The next crossing that an eye sees: what was found, its time, and the evaluations.

    `forever`: whether nothing else ends the motion in a chamber, so that a crossing may be proved never to come.
    `guess` > 0: a time worth trying.
    """
    bar, now = table.bar, eye.now
    before = bar.mean
    bar.mean = sign * scale * mean
    smooth_at_anchor(bar, table.harmonics, now, desk.osc)
    found, tau, steps = NOTHING, horizon, 1
    if at_edge and rate == 0.0 and now.acceleration > 0.0:
        found, tau = CONTACT, 0.0
    elif forever and most(bar, now) < 1e-13 * abs(now.gap):
        found = NEVER
    elif not out_of_reach(bar, now, horizon):
        found, tau, _, steps, _, _ = met(table, eye, desk, at_edge, 0.0, guess, horizon, limit)
    bar.mean = before
    return found, tau, steps


@inlined
def next_crossing(plant, sight, port, first, horizon, limit, forever, guess):
    """When a port is next entered, or left so that it may be entered again; NOWHERE when not before the horizon.

    Returns the time, what it is, and the evaluations. A graze is a time to look anew.
    """
    table, gear, motion, controls = plant.table, plant.gear, plant.motion, plant.controls
    force = gear.forces[controls.now.state]
    place, rate = seen(table, gear, motion, force, port, first)
    side = gear.side[port]
    off, rate = side * (place + gear.edge[port]), side * rate
    at_edge = abs(off) <= EDGE * (abs(place) + gear.edge[port])
    inside = off > 0.0
    if at_edge:
        inside = controls.just[port] > 0 and rate >= 0.0
        if rate > 0.0 and not inside:
            return 0.0, ENTERS, 1
    sign = -side if inside else side
    gap = 0.0 if at_edge else -abs(off)
    toward = -rate if inside else rate
    found, tau, steps = NOTHING, horizon, 1
    mean, scale = table.bar.mean, gear.ratio[port, 0]
    if gear.rigid[port]:
        aim(gear, motion, sight.spot, port, sign, gap, toward)
        found, tau, steps = looked_for(
            sight.alone, sight.spot, sight.bench, sign, scale, mean, at_edge, toward, horizon, limit, forever, guess
        )
    else:
        aim(gear, motion, sight.eye, port, sign, gap, toward)
        amplitudes(table.bar, table.modes, sight.eye.z, sight.eye.now)
        found, tau, steps = looked_for(
            table, sight.eye, plant.desk, sign, scale, mean, at_edge, toward, horizon, limit, forever, guess
        )
    if found == NEVER:
        return math.inf, NEVER, steps
    if found == TIRED:
        return math.inf, TIRED, steps
    if found in (CONTACT, GRAZE):
        return tau, (ENTERS if found == CONTACT and not inside else LEAVES), steps
    return math.inf, NOWHERE, steps
