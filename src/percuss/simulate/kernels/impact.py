"""The impact: the velocities turned over, and what that takes (B77 10)."""

from __future__ import annotations

from percuss.compiled import inlined, inner, summed
from percuss.simulate.kernels.bounds import amplitudes
from percuss.simulate.kernels.modes import forced_modes


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


@summed
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
def turn_strain(bar, modes, z, work):
    """The elastic displacements times `bar.strain`, with the forced ones in `work`; returns the energy that it takes.

    u_0 moves so that the striking end stays where it is; nothing else depends on it.
    """
    total = 0.0
    for j in range(modes.omega.shape[0]):
        q = z[0, j] + work.forced[j] + bar.mean * modes.statics[j]
        step = (bar.strain - 1.0) * q
        z[0, j] += step
        z[1, j] -= modes.half[j] * modes.inverse[j] * step
        total += modes.inertia[j] * modes.omega[j] * modes.omega[j] * q * q
    return (1.0 - bar.strain * bar.strain) * total


@inlined
def impact(table, motion, desk):
    """The velocity field turned over, u_t → −R u_t (B77 10), and the strain kept or turned over; the gap is set to 0.

    Returns the energy that it takes; `now.kinetic_energy` is the kinetic energy before it.
    """
    bar, modes, now, z = table.bar, table.modes, motion.now, motion.z
    taken = 0.0
    if modes.omega.shape[0]:
        forced_modes(table.coupling, desk, now.cosine, now.sine, 1)
        now.kinetic_energy = turn_over(bar, modes, z, now, desk)
        if bar.strain != 1.0:
            forced_modes(table.coupling, desk, now.cosine, now.sine, 0)
            taken = turn_strain(bar, modes, z, desk)
        amplitudes(bar, modes, z, now)
    else:
        now.kinetic_energy = 0.5 * bar.whole * now.rigid_rate * now.rigid_rate
    now.rigid_rate *= -bar.restitution
    now.gap_rate *= -bar.restitution
    now.gap = 0.0
    return (1.0 - bar.restitution * bar.restitution) * now.kinetic_energy + taken


@inner
def all_energy(table, motion, desk):
    """Kinetic and elastic energy of the bar at the anchor: ½ ∫ u_t² dx + ½ s² ∫ u_x² dx."""
    bar, modes, now, z = table.bar, table.modes, motion.now, motion.z
    forced_modes(table.coupling, desk, now.cosine, now.sine, 1)
    total = kinetic_energy(bar, modes, z, now, desk)
    forced_modes(table.coupling, desk, now.cosine, now.sine, 0)
    for j in range(modes.omega.shape[0]):
        q = modes.omega[j] * (z[0, j] + desk.forced[j] + bar.mean * modes.statics[j])
        total += modes.inertia[j] * q * q
    return total


@inner
def undeformed(table, motion, desk):
    """The bar at rest on the wall: all displacements and velocities 0, so that the free part is less the forced one."""
    bar, modes, now, z = table.bar, table.modes, motion.now, motion.z
    forced_modes(table.coupling, desk, now.cosine, now.sine, 0)
    for j in range(modes.omega.shape[0]):
        z[0, j] = -desk.forced[j] - bar.mean * modes.statics[j]
    forced_modes(table.coupling, desk, now.cosine, now.sine, 1)
    for j in range(modes.omega.shape[0]):
        if modes.oscillates[j] > 0.0:
            z[1, j] = (desk.forced[j] - modes.half[j] * z[0, j]) * modes.inverse[j]
        else:
            z[1, j] = -desk.forced[j]
    amplitudes(bar, modes, z, now)
    now.gap, now.gap_rate, now.rigid_rate = 0.0, 0.0, 0.0
