"""A flight from one anchor to the next without an impact: under one load, and over its steps."""

from __future__ import annotations

import math

from percuss.compiled import inner
from percuss.simulate.kernels.bounds import amplitudes
from percuss.simulate.kernels.clock import set_phase
from percuss.simulate.kernels.codes import TURN
from percuss.simulate.kernels.modes import elastic, turn_modes
from percuss.simulate.kernels.smooth import drifted, smooth


@inner
def advance(table, motion, desk, tau):
    """The anchor moved to τ under a constant load, without an impact; the clock is turned apart."""
    bar, modes, now, z = table.bar, table.modes, motion.now, motion.z
    ds, vs, _ = smooth(bar, now, desk.osc, tau)
    df, fv, _, slip = elastic(bar, modes, z, now, desk, tau)
    now.rigid_rate = drifted(bar, now, tau)
    turn_modes(bar, modes, z, desk, tau, 0.0, slip)
    now.gap += ds + df
    now.gap_rate = vs + fv


@inner
def step_load(table, motion):
    """On to the next step of a piecewise constant load: the static shape jumps, so the free part jumps back."""
    bar, modes, breaks, values = table.bar, table.modes, table.breaks, table.values
    now, count, z = motion.now, motion.count, motion.z
    piece = count.piece + 1
    if piece == breaks.shape[0]:
        piece = 0
    old, new = bar.mean, values[piece]
    for j in range(modes.omega.shape[0]):
        jump = modes.statics[j] * (old - new)
        z[0, j] += jump
        z[1, j] -= modes.half[j] * jump * modes.inverse[j]
    if breaks[piece] < now.phase:
        count.period += 1
    set_phase(now, breaks[piece])
    count.piece = piece
    bar.mean = new
    amplitudes(bar, modes, z, now)


@inner
def left_for_good(table, now):
    """Whether a bar under a load of steps has left for good; asked each time the first step begins.

    From period to period the mean of the bar moves by less and less when the load's mean does not push and nothing
    drags, or by an amount that tends to a pull from one side: once it has moved away in a period it moves away in all.
    Each step adds at most its static shape to the elastic amplitudes.
    """
    bar, modes, breaks, values = table.bar, table.modes, table.breaks, table.values
    turn, mean, force, jumps = TURN, 0.0, 0.0, 0.0
    for i in range(values.shape[0]):
        length = (breaks[i + 1] if i + 1 < values.shape[0] else breaks[0] + TURN) - breaks[i]
        mean += values[i] * length
        force = max(force, abs(values[i]))
        jumps += abs(values[i] - values[i - 1])
    still, stiff = 0.0, 0.0
    for j in range(modes.omega.shape[0]):
        still += modes.statics[j]
        stiff += abs(modes.statics[j])
    place = now.gap - now.free - bar.mean * still
    before = now.last_place
    now.last_place = place
    if mean > 0.0 or before == 0.0:
        return False
    growth, later = 4.0 * jumps * stiff, 0.0
    if bar.linger > 0.0:
        later = growth / -math.expm1(-bar.linger * turn)
    elif (
        bar.damping > 0.0 and stiff > 0.0
    ):  # what the steps add never dies out, while the mean of the bar comes to rest
        return False
    if place - before + growth >= 0.0:
        if place - before >= 0.0 or bar.linger == 0.0:
            return False
        growth = later
    swing = turn * (max(now.rigid_rate, 0.0) + 2.0 * force * turn)
    return place + swing + now.sup + force * stiff + growth < 0.0
