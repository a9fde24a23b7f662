"""The cycle of an elastic machine that rests on the wall: what follows a release, until the next one.

A bar at rest on the wall has forgotten everything, and leaves undeformed when the valve pulls: all multipliers are 0.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from percuss.steady.self_excited.elastic_chain import place_row
from percuss.steady.self_excited.elastic_cycle import ElasticCycle
from percuss.steady.self_excited.elastic_following import Following
from percuss.steady.self_excited.elastic_newton import blow_of, switch_of
from percuss.steady.self_excited.piston_records import Uncovering

__all__ = ["rest_cycle"]

_SAME = 1e-9  # of the period: what the last blows before a rest, which are left out, may move


def rest_cycle(motion: Following) -> ElasticCycle | None:
    """The cycle between the last two rests of a motion; None when the two before them are not as far apart."""
    (first, begun), (last, over) = motion.rests[-2:]
    start, end = motion.flights[first].time, motion.flights[last].time
    before = start - motion.flights[motion.rests[-3][0]].time if len(motion.rests) > 2 else end - start
    if abs(before - (end - start)) > _SAME * (end - start):
        return None
    machine, modes = motion.machine, motion.modes
    rows = np.array([modes.omega, modes.end, modes.driven])
    struck, changed, passed = [], [], []
    state = motion.flights[first].state
    for (time, kind, detail), now in list(zip(motion.events, motion.states, strict=True))[begun:over]:
        if kind == "impact":
            struck.append(blow_of(machine, rows, time - start, now))
        elif kind == "valve":
            changed.append(switch_of(machine, modes.driven, time - start, (state, str(detail)), now))
            state = str(detail)
        elif isinstance(detail, int) and (reads := machine.valve.ports[detail]).on == "entering":
            passed.append(Uncovering(detail, time - start, -float(place_row(machine, modes, reads.reads) @ now[:, 1])))
    flights = tuple(replace(flight, time=flight.time - start) for flight in motion.flights[first:last])
    made = tuple(struck), tuple(changed), tuple(passed), np.zeros(1, dtype=complex), motion.rhythm(len(struck)), True
    return ElasticCycle(machine, modes.size, flights, *made)
