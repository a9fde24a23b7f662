"""What happens to a machine at the wall: the blow, rest at the end of chatter, and release."""

from __future__ import annotations

import math

from percuss.compiled import inlined, inner, summed
from percuss.simulate.kernels.bounds import amplitudes
from percuss.simulate.kernels.codes import CHATTER, EPS, IMPACT, ON_WALL, RELEASE, REST, RESTING
from percuss.simulate.kernels.impact import kinetic_energy, turn_over, turn_strain
from percuss.simulate.kernels.modes import forced_modes
from percuss.simulate.kernels.rest import CHATTER_ERROR, chatter_left, held
from percuss.simulate.kernels.valve_orders import demand, enter, go_by
from percuss.simulate.kernels.valve_sight import rigid_place

NO_SPEED = 1e-13  # a rebound slower than this, of the speeds that occur, is no rebound
QUARTER = 0.3  # of the time in which a chamber turns a released machine round, in radians of its frequency


@summed
def potential(table, gear, motion, force):
    """Elastic energy of the bar and of the chamber at the anchor."""
    bar, modes, z = table.bar, table.modes, motion.z
    total, first = 0.0, bar.spring * rigid_place(table, gear, motion, force)
    for j in range(modes.omega.shape[0]):
        q = modes.omega[j] * (z[0, j] + force * modes.statics[j])
        total += modes.inertia[j] * q * q
    return total + 0.5 * bar.whole * first * first


@inlined
def strike(plant, speed, log):
    """One blow: the velocities turned over, and the strain where the law does; u_t → −R u_t (B77 10)."""
    table, motion, desk, controls = plant.table, plant.motion, plant.desk, plant.controls
    bar, modes, now, count, valve, z = table.bar, table.modes, motion.now, motion.count, controls.now, motion.z
    force, taken = plant.gear.forces[valve.state], 0.0
    now.gap = 0.0
    forced_modes(table.coupling, desk, 1.0, 0.0, 1)
    now.kinetic_energy = turn_over(bar, modes, z, now, desk)
    now.rigid_rate *= -bar.restitution
    now.gap_rate *= -bar.restitution
    if bar.strain != 1.0 and modes.omega.shape[0]:  # with the end on the wall all displacements turn alike
        taken = (1.0 - bar.strain * bar.strain) * potential(table, plant.gear, motion, force)
        bar.mean = force
        turn_strain(bar, modes, z, desk)
    amplitudes(bar, modes, z, now)
    brief = now.since < now.last_flight and valve.pulled == 0
    count.run = count.run + 1 if brief and now.last_flight > 0.0 else 1
    count.pile = count.pile + 1 if now.since < 4.0 * EPS else 0
    now.last_flight = math.inf if now.last_flight < 0.0 else now.since
    now.since, valve.pulled, valve.clear = 0.0, 1 if force < 0.0 else 0, 0.0
    valve.awaited, valve.fresh = 0.0, 0
    count.impacts += 1
    valve.blows += 1
    lost = (1.0 - bar.restitution * bar.restitution) * now.kinetic_energy + taken
    valve.taken += lost
    valve.strongest = max(valve.strongest, speed)
    enter(IMPACT, speed, lost, now.kinetic_energy, 0, motion, controls, log)


@inner
def lie(table, motion, force):
    """The bar undeformed and at rest on the wall: the free part is less the static one."""
    modes, now, z = table.modes, motion.now, motion.z
    for j in range(modes.omega.shape[0]):
        z[0, j] = -force * modes.statics[j]
        z[1, j] = -modes.half[j] * z[0, j] * modes.inverse[j]
    amplitudes(table.bar, modes, z, now)
    now.gap, now.gap_rate, now.rigid_rate = 0.0, 0.0, 0.0


@inner
def set_down(plant, wait, log):
    """The bar comes to rest, after `wait` when chatter ends then: what motion and strain it has is lost."""
    table, gear, motion, controls = plant.table, plant.gear, plant.motion, plant.controls
    count, valve = motion.count, controls.now
    force = gear.forces[valve.state]
    forced_modes(table.coupling, plant.desk, 1.0, 0.0, 1)
    lost = kinetic_energy(table.bar, table.modes, motion.z, motion.now, plant.desk)
    lost += potential(table, gear, motion, force)
    chatter = table.bar.restitution > 0.0 and (count.run > 1 or wait > 0.0)
    valve.taken += lost
    go_by(motion, controls, wait)
    lie(table, motion, force)
    count.mode, valve.clear = RESTING, 0.0
    valve.rests += 1
    if chatter:
        valve.chatters += 1
        valve.blows -= count.run - 1
        enter(CHATTER, 0.0, lost, 0.0, count.run, motion, controls, log)
        lost = 0.0
    enter(REST, 0.0, lost, 0.0, 0, motion, controls, log)
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
    lie(plant.table, motion, plant.gear.forces[valve.state])
    count.mode, count.run, count.pile = ON_WALL, 0, 0
    valve.lap, valve.pulled, valve.clear, valve.awaited = bar.wave, 1, 0.0, 0.0
    now.hold = math.inf if bar.spring == 0.0 else max(bar.wave, QUARTER / bar.spring)
    now.last_flight, now.since = -1.0, 0.0
    enter(RELEASE, 0.0, 0.0, 0.0, 0, motion, controls, log)


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
        pushed = plant.gear.forces[plant.controls.now.state] > 0.0
        struck = count.mode == ON_WALL and bar.restitution == 0.0 and (pushed or forgets)
        if struck or now.acceleration >= 0.0 or count.pile > 100:
            return 0.0
        now.gap_rate = 0.0
        return -1.0
    if held(table, motion):
        return 0.0
    left = chatter_left(table, motion, plant.desk, ahead)
    sprung = bar.spring * left
    return left if sprung * sprung * left <= CHATTER_ERROR else -1.0
