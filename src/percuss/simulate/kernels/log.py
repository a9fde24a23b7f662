"""The record of what happens."""

from __future__ import annotations

from percuss.compiled import inlined
from percuss.simulate.kernels.calls import STATE_NUMBERS
from percuss.simulate.kernels.codes import CHATTER, IMPACT


@inlined
def record(kind, before, lost, motion, log):
    """One event with the state after it, unless the record has no rows."""
    if log.events.shape[0] == 0:
        return
    now, count, z, states = motion.now, motion.count, motion.z, log.states
    i = count.events
    count.events += 1
    event = log.events[i]
    event.phase, event.period, event.piece, event.kind = now.phase, count.period, count.piece, kind
    event.before, event.after, event.lost = before, now.gap_rate, lost
    event.kinetic = now.kinetic_energy if kind == IMPACT else 0.0
    event.resolved = count.run if kind == CHATTER else 0
    if states.shape[0]:
        n = z.shape[1]
        states[i, 0], states[i, 1] = now.gap, now.rigid_rate
        for j in range(n):
            states[i, STATE_NUMBERS + j] = z[0, j]
            states[i, STATE_NUMBERS + n + j] = z[1, j]
