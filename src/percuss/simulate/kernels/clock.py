"""The clock of the load."""

from __future__ import annotations

import math

from percuss.compiled import inlined, inner
from percuss.simulate.kernels.codes import TURN, TURN_LOW
from percuss.simulate.kernels.elementary import sine_cosine


@inlined
def turn_clock(now, count, tau):
    """The load phase after τ, in [0, 2π), and the load periods gone by."""
    phase = now.phase + tau
    if phase >= TURN:
        turns = math.floor(phase / TURN)
        phase = (phase - turns * TURN) - turns * TURN_LOW
        if phase < 0.0:
            phase = 0.0
        elif phase >= TURN:
            phase -= TURN
            turns += 1.0
        count.period += int(turns)
    now.phase = phase
    now.sine, now.cosine = sine_cosine(phase)


@inner
def set_phase(now, phase):
    """The phase put where it is known to be."""
    now.phase = phase
    now.sine, now.cosine = sine_cosine(phase)


@inlined
def to_break(now, count, breaks):
    """Time to the next step of the load."""
    if breaks.shape[0] == 0:
        return math.inf
    piece = count.piece + 1
    if piece == breaks.shape[0]:
        ahead = breaks[0] - now.phase
        return ahead if ahead >= 0.0 else ahead + TURN
    return max(breaks[piece] - now.phase, 0.0)


@inner
def set_clock(table, now, count, phase):
    """The clock of a resting bar put to the next time of a load phase, with the step of the load that holds then.

    The phase is set as it is, so that each release at it is the same one to the last bit.
    """
    bar, breaks, values = table.bar, table.breaks, table.values
    if phase < now.phase:
        count.period += 1
    set_phase(now, phase)
    if values.shape[0]:
        piece = values.shape[0] - 1
        for i in range(values.shape[0]):
            if breaks[i] <= phase:
                piece = i
        count.piece = piece
        bar.mean = values[piece]
