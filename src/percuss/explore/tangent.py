"""The tangent vector of a simulated motion, compiled: how it grows from impact to impact.

The load does not depend on the state, so a small difference at fixed times moves freely between two impacts, whatever
the load does, and at an impact goes through the saltation matrix (theory §5; `percuss.stability.linear_map`). All in
q_n, what mode n adds at the striking end.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from percuss.compiled import entry, inner
from percuss.simulate.kernels.modes import drift, free_motion
from percuss.simulate.kernels.motion_records import IMPACT, TURN

LATE = 1e-9  # an event this little after a step of the load was at it, before it

Floats = npt.NDArray[np.float64]


class ImpactFactors(NamedTuple):
    """α and β of the contact law: what it multiplies q_n by, and q_n'."""

    strain: float
    velocity: float


class EventRows(NamedTuple):
    """The events of a motion, rows: the first is an impact, all others impacts or grazes.

    `gone`: time since the one before. `speed`: of the striking end before an impact; `force`: of the load.
    """

    code: npt.NDArray[np.int8]
    gone: Floats
    phase: Floats
    piece: npt.NDArray[np.int64]
    speed: Floats
    force: Floats


class ElasticRows(NamedTuple):
    """q_n of the free motion after each event and its rate, and those of the forced one; each of shape (events, N)."""

    value: Floats
    slope: Floats
    shape: Floats
    rate: Floats


@inner
def flown(modes, tau, values, rates):
    """Free motions for a time τ, in place: q_n and q_n' of the motion and of the difference, each of shape (2, N)."""
    for n in range(modes.omega.shape[0]):
        square = modes.omega[n] * modes.omega[n]
        left, h, h_rate = free_motion(modes.damping[n], modes.signed[n], modes.omega[n], tau)
        for row in range(2):
            q, w = values[row, n], rates[row, n]
            values[row, n] = q * left + w * h
            rates[row, n] = w * h_rate - q * (square * h)


@inner
def flown_on(table, events, i, values, rates):
    """From event i − 1 to event i, over the steps of the load between them."""
    modes, breaks, steps = table.modes, table.breaks, table.values
    left, at, step = events.gone[i], events.phase[i - 1], events.piece[i - 1]
    while breaks.shape[0]:
        following = step + 1 if step + 1 < breaks.shape[0] else 0
        ahead = breaks[following] - at
        if following == 0 and ahead < 0.0:
            ahead += TURN
        ahead = max(ahead, 0.0)
        if step == events.piece[i] and ahead >= left - LATE:
            break
        flown(modes, ahead, values, rates)
        for n in range(modes.omega.shape[0]):  # the static shape jumps, so the free part jumps back
            values[0, n] += modes.statics[n] * (steps[step] - steps[following])
        left, at, step = left - ahead, breaks[following], following
    flown(modes, left, values, rates)


@inner
def struck(modes, law, events, elastic, i, moved, drifting, values, rates):
    """The difference just after impact number i: the saltation matrix of a law that multiplies q_n by α, q_n' by β.

    `moved`, `drifting`: of the rigid motion and its rate. Returns them after the impact, and the size of all of it.
    """
    alpha, beta, apart, impulse = law.strain, law.velocity, law.strain - law.velocity, 1.0 - law.velocity
    total, rigid = moved, events.speed[i]
    for n in range(modes.omega.shape[0]):
        total += values[1, n]
        rigid -= rates[0, n] + elastic.rate[i, n]
    late = -total / events.speed[i]  # by how much the difference strikes later
    moved += impulse * rigid * late
    drifting = beta * drifting - impulse * events.force[i] * late
    size = drifting * drifting
    for n in range(modes.omega.shape[0]):
        square = modes.omega[n] * modes.omega[n]
        before, place = rates[0, n] + elastic.rate[i, n], values[0, n] + elastic.shape[i, n]
        pushed = impulse * (square * modes.statics[n]) * events.force[i]
        u = alpha * values[1, n] + apart * before * late
        v = beta * rates[1, n] + (apart * square * place - pushed) * late
        moved += (1.0 - alpha) * (values[1, n] + before * late)  # the striking end stays where it is
        values[1, n], rates[1, n] = u, v
        size += square * u * u + v * v
    return moved, drifting, math.sqrt(size + moved * moved)


@entry
def log_growths(table, law, events, elastic, values, rates, growth):
    """Logarithm of the growth of a small difference over each flight and impact, into `growth`; returns how many.

    `values`, `rates`: room for two rows of N numbers, the motion and the difference.
    """
    modes, impacts, count = table.modes, 0, table.modes.omega.shape[0]
    moved, drifting = 1.0, 1.0  # of the rigid motion
    for n in range(count):
        values[1, n], rates[1, n] = 1.0 / (n + 2.0), (modes.omega[n] - 0.5 * modes.damping[n]) / (n + 2.0)
    for i in range(1, events.code.shape[0]):
        for n in range(count):
            values[0, n], rates[0, n] = elastic.value[i - 1, n], elastic.slope[i - 1, n]
        ahead, _ = drift(table.bar.damping, events.gone[i])
        moved += ahead * drifting
        drifting *= 1.0 - table.bar.damping * ahead
        flown_on(table, events, i, values, rates)
        if events.code[i] != IMPACT:
            continue
        moved, drifting, size = struck(modes, law, events, elastic, i, moved, drifting, values, rates)
        growth[impacts] = math.log(size) if size > 0.0 else -math.inf
        impacts += 1
        if not 0.0 < size < math.inf:
            return impacts
        moved /= size
        drifting /= size
        for n in range(count):
            values[1, n] /= size
            rates[1, n] /= size
    return impacts
