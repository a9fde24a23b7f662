"""The multipliers of a cycle of an elastic machine: its linearised map from blow to blow, event by event.

Each column is a disturbance: of the state at the event, which comes earlier or later by it, of the time of that event,
and of the times at which the pending orders are due. At a port and at a blow the time follows from the place that is
met, at an order it is that of the event that demanded it. On the blow as a section the shift in time is no disturbance.
"""

from __future__ import annotations

import numpy as np

from percuss.model.checks import Array
from percuss.steady.self_excited.elastic_chain import Chain, Closed
from percuss.steady.self_excited.modal_flight import propagated, rates

__all__ = ["cycle_map"]


def cycle_map(chain: Chain, unknowns: Array, motion: Closed) -> Array:
    """The map of (displacements and velocities, times of the pending orders) after the blow, one cycle on."""
    modes, times = chain.modes, np.concatenate([[0.0], chain.times(unknowns)])
    ways = chain.ways(times)
    wrapped = [i for i, step in enumerate(chain.steps) if step.wrapped]
    size = modes.omega.size
    columns = 2 * size + len(wrapped)
    now, when = np.zeros((size, 2, columns)), np.zeros(columns)
    now.reshape(2 * size, columns)[:, : 2 * size] = np.eye(2 * size)
    dues = {i: np.eye(columns)[2 * size + j] for j, i in enumerate(wrapped)}
    shifts = {-1: when}
    number = 0
    for i, step in enumerate(chain.steps):
        moved = propagated(modes, now, 0.0, ways[i])
        rate = rates(modes, motion.states[i], chain.forces[i])
        if step.kind == "due":
            shift = dues[i] if step.wrapped else shifts[step.source]
        else:
            row = chain.rows[i]
            shift = when - row @ moved[:, 0] / (row @ rate[:, 0])
            shifts[number] = shift
            number += 1
        now, when = moved + rate[:, :, None] * (shift - when), shift
        if step.kind == "blow":
            now = chain.turn[:, None] * now
    after = [shifts[chain.steps[i].source] - when for i in wrapped]
    return np.vstack([now.reshape(2 * size, columns), *after])
