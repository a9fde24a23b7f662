"""A motion put where it begins."""

from __future__ import annotations

from percuss.compiled import entry, inner
from percuss.simulate.kernels.bounds import amplitudes
from percuss.simulate.kernels.clock import set_phase
from percuss.simulate.kernels.codes import FLYING, ON_WALL, RESTING
from percuss.simulate.kernels.modes import forced_modes


@inner
def put(table, motion, desk, starts, i):
    """The anchor at start number i: q_n and q_n' (those left out are 0), the gap, the clock; all else is set to 0."""
    bar, modes, now, count, z = table.bar, table.modes, motion.now, motion.count, motion.z
    u, v = starts.displacement[i], starts.velocity[i]
    motion.numbers[:] = 0.0
    motion.wholes[:] = 0
    motion.anchor[:] = 0.0
    motion.totals[:] = 0.0
    if table.values.shape[0]:
        bar.mean = table.values[starts.piece[i]]
    count.period, count.piece = starts.period[i], starts.piece[i]
    set_phase(now, starts.phase[i])
    still = v[0] == 0.0 and starts.gap[i] == 0.0
    rate = v[0]
    for j in range(modes.omega.shape[0]):
        z[0, j] = modes.unit[j] * u[j + 1] if j + 1 < u.shape[0] else 0.0
        z[1, j] = modes.unit[j] * v[j + 1] if j + 1 < v.shape[0] else 0.0
        still = still and z[0, j] == 0.0 and z[1, j] == 0.0
        rate += z[1, j]
    forced_modes(table.coupling, desk, now.cosine, now.sine, 0)
    for j in range(modes.omega.shape[0]):
        z[0, j] -= desk.forced[j] + bar.mean * modes.statics[j]
    forced_modes(table.coupling, desk, now.cosine, now.sine, 1)
    for j in range(modes.omega.shape[0]):
        z[1, j] -= desk.forced[j]
        if modes.oscillates[j] > 0.0:
            z[1, j] = -modes.inverse[j] * (z[1, j] + modes.half[j] * z[0, j])
    now.gap, now.gap_rate, now.rigid_rate, now.last_flight = starts.gap[i], rate, v[0], -1.0
    now.released = -1.0
    amplitudes(bar, modes, z, now)
    # undeformed, at rest and on the wall: released at once when the load pulls
    count.mode = RESTING if still else (ON_WALL if starts.gap[i] == 0.0 else FLYING)


@entry
def place(table, motion, desk, starts):
    """The anchor at the only start there is."""
    put(table, motion, desk, starts, starts.gap.shape[0] - 1)  # a 0 would have a type of its own
