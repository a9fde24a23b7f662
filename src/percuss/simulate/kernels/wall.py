"""The impact: the velocities turned over, and what that takes (B77 10)."""

from __future__ import annotations

from percuss.compiled import inlined, inlined_sums, inner, summed
from percuss.simulate.kernels.bounds import amplitudes, amplitudes_apart, smooth
from percuss.simulate.kernels.clock import load_at
from percuss.simulate.kernels.modes import forced_modes
from percuss.simulate.kernels.motion_records import ON_WALL, POWERS


@summed
def kinetic_energy(bar, modes, z, now, work):
    """½ ∫ u_t² dx, with the forced velocities in `work`."""
    total = 0.0
    for j in range(modes.omega.shape[0]):
        rate = work.forced[j] - modes.lam[j] * z[1, j] - modes.half[j] * z[0, j]
        total += modes.inertia[j] * rate * rate * modes.oscillates[j]
    for i in range(modes.creeping.shape[0]):
        j = modes.creeping[i]
        rate = work.forced[j] + z[1, j]
        total += modes.inertia[j] * rate * rate
    return 0.5 * bar.whole * now.rigid_rate * now.rigid_rate + total


@inlined_sums
def turn_over(bar, modes, z, now, work):
    """The modal velocities times −R, with the forced ones in `work`; returns ½ ∫ u_t² dx before it."""
    r, total = bar.restitution, 0.0
    for i in range(modes.creeping.shape[0]):
        j = modes.creeping[i]
        rate = work.forced[j] + z[1, j]
        total += modes.inertia[j] * rate * rate
        work.aside_im[j] = -r * z[1, j] - (1.0 + r) * work.forced[j]
    for j in range(modes.omega.shape[0]):
        zr, zi, forced, half = z[0, j], z[1, j], work.forced[j], modes.half[j]
        rate = forced - modes.lam[j] * zi - half * zr
        total += modes.inertia[j] * rate * rate * modes.oscillates[j]
        z[1, j] = -r * zi - (1.0 + r) * modes.inverse[j] * (half * zr - forced)
    for i in range(modes.creeping.shape[0]):
        j = modes.creeping[i]
        z[1, j] = work.aside_im[j]
    return 0.5 * bar.whole * now.rigid_rate * now.rigid_rate + total


@summed
def turn_strain(bar, modes, z, work, force):
    """The elastic displacements times `bar.strain`, the forced ones in `work`; the energy that it takes."""
    # `force`: the constant part of that on the modes. u_0 moves so that the striking end stays where it is: on the wall
    # the place on the gas of a chamber turns alike, and nothing else depends on it.
    total = 0.0
    if bar.spring > 0.0:
        first = 0.0
        for j in range(modes.omega.shape[0]):
            first += z[0, j] + work.forced[j] + force * modes.statics[j]
        total = 0.5 * bar.whole * bar.spring * bar.spring * first * first
    for j in range(modes.omega.shape[0]):
        q = z[0, j] + work.forced[j] + force * modes.statics[j]
        step = (bar.strain - 1.0) * q
        z[0, j] += step
        z[1, j] -= modes.half[j] * modes.inverse[j] * step
        total += modes.inertia[j] * modes.omega[j] * modes.omega[j] * q * q
    return (1.0 - bar.strain * bar.strain) * total


@inlined
def impact(table, motion, desk, force):
    """The velocity field turned over, u_t → −R u_t (B77 10), and the strain kept or not; the gap is set to 0."""
    # Returns the energy that it takes; `now.kinetic_energy` is the kinetic energy before it.
    bar, modes, now, z = table.bar, table.modes, motion.now, motion.z
    taken = 0.0
    if modes.omega.shape[0]:
        forced_modes(table, desk, now.cosine, now.sine, 1)
        now.kinetic_energy = turn_over(bar, modes, z, now, desk)
        if bar.strain != 1.0:
            forced_modes(table, desk, now.cosine, now.sine, 0)
            taken = turn_strain(bar, modes, z, desk, force)
        amplitudes(bar, modes, z, now)
    else:
        now.kinetic_energy = 0.5 * bar.whole * now.rigid_rate * now.rigid_rate
    now.rigid_rate *= -bar.restitution
    now.gap_rate *= -bar.restitution
    now.gap = 0.0
    return (1.0 - bar.restitution * bar.restitution) * now.kinetic_energy + taken


@inner
def energy_at_rest_lost(table, motion, desk, force):
    """Kinetic and elastic energy of the bar at the anchor, ½ ∫ u_t² dx + ½ s² ∫ u_x² dx, and that of a chamber."""
    # A structure, which keeps its shape, loses its kinetic energy only.
    bar, modes, now, z = table.bar, table.modes, motion.now, motion.z
    forced_modes(table, desk, now.cosine, now.sine, 1)
    total = kinetic_energy(bar, modes, z, now, desk)
    if bar.held > 0.0:
        return total
    forced_modes(table, desk, now.cosine, now.sine, 0)
    for j in range(modes.omega.shape[0]):
        q = modes.omega[j] * (z[0, j] + desk.forced[j] + force * modes.statics[j])
        total += modes.inertia[j] * q * q
    if bar.spring > 0.0:
        first = now.gap
        for j in range(modes.omega.shape[0]):
            first -= z[0, j] + desk.forced[j] + force * modes.statics[j]
        total += 0.5 * bar.whole * bar.spring * bar.spring * first * first
    return total


@inner
def keep_shape(table, motion, desk, force):
    """The displacements of a structure put by, as `at_rest` takes them: it lies in the shape that it has."""
    modes, now, z = table.modes, motion.now, motion.z
    forced_modes(table, desk, now.cosine, now.sine, 0)
    for j in range(modes.omega.shape[0]):
        desk.aside_re[j] = z[0, j] + desk.forced[j] + force * modes.statics[j]


@inner
def at_rest(table, motion, desk, force):
    """The body still on the wall, a bar undeformed: its free part is its shape less the forced one."""
    bar, modes, now, z = table.bar, table.modes, motion.now, motion.z
    forced_modes(table, desk, now.cosine, now.sine, 0)
    for j in range(modes.omega.shape[0]):
        shape = desk.aside_re[j] if bar.held > 0.0 else 0.0
        z[0, j] = shape - desk.forced[j] - force * modes.statics[j]
    forced_modes(table, desk, now.cosine, now.sine, 1)
    for j in range(modes.omega.shape[0]):
        if modes.oscillates[j] > 0.0:
            z[1, j] = (desk.forced[j] - modes.half[j] * z[0, j]) * modes.inverse[j]
        else:
            z[1, j] = -desk.forced[j]
    amplitudes_apart(bar, modes, z, now)
    now.gap, now.gap_rate, now.rigid_rate = 0.0, 0.0, 0.0


@inlined
def force_on_modes(bar, valve):
    """The constant part of the force on the modes."""
    if valve is None:
        return bar.load
    return valve.controls.now.force


# ---- The end of chatter, and the bar at rest on the wall

CHATTER_TIME = 1e-5  # a chatter is completed when at most this time of it is left …
CHATTER_ERROR = 1e-13  # … and its end is known to this


@inlined
def chatter_left(table, motion, desk, horizon):
    """Time until the impacts have piled up, theory §8.2, when that is certain and known to `CHATTER_ERROR`; else −1."""
    # Rebound speed w, acceleration P without damping, and its rate j: the flights 2w/P, 2Rw/P, … add up to T_0 = 2w/((1
    # − R)P), and to first order in j and d to T_0 (1 − d T_0/6 − j T_0/(3P)). Modes damped otherwise than the rigid
    # motion are part of what is not known.
    bar, now, osc = table.bar, motion.now, desk.osc
    r, d, w = bar.restitution, bar.damping, -now.gap_rate
    push = now.acceleration - d * w
    if r >= 1.0 or r == 0.0 or push <= 0.0:  # without restitution the next impact is the last
        return -1.0
    left = 2.0 * w / ((1.0 - r) * push)
    if left > CHATTER_TIME or 2.0 * left > horizon:
        return -1.0
    drag = abs(bar.mean - d * now.drift)
    known = (bar.jerk + d * (bar.curve + drag)) * left / push + d * left
    known += abs(bar.lift) * left / push
    unknown = now.sup3 * left / push
    if bar.law != POWERS:
        unknown += otherwise_damped(table, motion, desk) / push
    if known + unknown > 0.1 or (known * known + unknown) * left > CHATTER_ERROR:
        return -1.0
    _, _, curve = smooth(bar, now, osc, 0.0)
    rate = d * curve - d * (bar.mean - d * now.drift)  # third derivative of S plus d times the second: no drift left
    rate += bar.lift
    for k in range(osc.shape[1]):
        n = k + 1.0
        rate += n * n * n * osc[1, k]
    return left * (1.0 - d * left / 6.0 - rate * left / (3.0 * push))


@inner
def otherwise_damped(table, motion, desk):
    """Σ|d_n − d_0||q_n'|: by how much the damping force differs from that of one damping for all modes."""
    bar, modes, now, z = table.bar, table.modes, motion.now, motion.z
    forced_modes(table, desk, now.cosine, now.sine, 1)
    total = 0.0
    for j in range(modes.omega.shape[0]):
        free = -modes.lam[j] * z[1, j] - modes.half[j] * z[0, j] if modes.oscillates[j] > 0.0 else z[1, j]
        total += abs((modes.damping[j] - bar.damping) * (free + desk.forced[j]))
    return total


@inlined
def held(table, motion):
    """The most energy with which the load holds a bar that has just struck, where the law turns the strain."""
    # −1 where the bar flies. That law is the sum of one contact, of the time 2/s in which a wave runs to and fro. A
    # rebound whose mean the load turns round within that time is none: the contact has not ended before the next one
    # begins. Bounces that are longer go on: where R is great, they may be fed by the law itself, as the mean of the bar
    # steps back under the load. What is given up is no more than twice the energy of a bar that the load turns just so.
    bar, now = table.bar, motion.now
    if bar.strain == 1.0 or not 0.0 < bar.restitution < 1.0:
        return -1.0
    p, _ = load_at(table.harmonics, bar.mean, now.cosine, now.sine)
    fastest = 0.5 * p * bar.contact
    if 0.0 < now.last_flight < bar.contact and 0.0 <= -now.rigid_rate <= fastest:
        return bar.whole * fastest * fastest
    return -1.0


@inner
def stays(table, motion, valve):
    """Whether a bar without rebound stays on the wall: pushed by the load or, bouncing in no time, by its own shape."""
    bar, now = table.bar, motion.now
    if valve is None:
        p, _ = load_at(table.harmonics, bar.wall, now.cosine, now.sine)
        pushed = p > 0.0
    else:  # undeformed, it leaves as from rest
        pushed = valve.controls.now.force > 0.0 or (bar.strain == 0.0 and table.modes.omega.shape[0] > 0)
    return (motion.count.mode == ON_WALL and bar.restitution == 0.0 and pushed) or now.acceleration >= 0.0
