"""The cycle of an elastic machine that rests on the wall: what follows a release, until the next one.

A bar at rest on the wall has forgotten everything, and leaves undeformed when the valve pulls: all multipliers are 0.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from percuss.steady.self_excited.elastic_chain import place_row
from percuss.steady.self_excited.elastic_cycle import ElasticCycle
from percuss.steady.self_excited.elastic_following import Following, Laid
from percuss.steady.self_excited.elastic_newton import blow_of, switch_of
from percuss.steady.self_excited.piston_records import Uncovering

__all__ = ["rest_cycle"]

_MOST_RESTS = 4  # in a cycle
_SAME = 1e-9  # of the period: what the last blows before a rest, which are left out, may move


def rest_cycle(motion: Following) -> ElasticCycle | None:
    """The cycle of one or a few rests with which a motion has been repeating itself; None for none."""
    times = [rest.time for rest in motion.rests]
    for count in range(1, _MOST_RESTS + 1):
        if len(times) > 2 * count:
            now, before = times[-1] - times[-1 - count], times[-1 - count] - times[-1 - 2 * count]
            if abs(now - before) <= _SAME * now:
                return _between(motion, motion.rests[-1 - count], motion.rests[-1])
    return None


def _between(motion: Following, first: Laid, last: Laid) -> ElasticCycle:
    start = first.time
    machine, modes = motion.machine, motion.modes
    struck, changed, passed = [], [], []
    state = motion.flights[first.flights].state
    for (time, kind, detail), now in list(zip(motion.events, motion.states, strict=True))[first.events : last.events]:
        if kind == "impact":
            struck.append(blow_of(modes, time - start, now))
        elif kind == "valve":
            changed.append(switch_of(machine, modes.driven, time - start, (state, str(detail)), now))
            state = str(detail)
        elif isinstance(detail, int) and (reads := machine.valve.ports[detail]).on == "entering":
            passed.append(Uncovering(detail, time - start, -float(place_row(machine, modes, reads.reads) @ now[:, 1])))
    flights = tuple(
        replace(flight, time=flight.time - start) for flight in motion.flights[first.flights : last.flights]
    )
    forgotten = np.zeros((2 * modes.omega.size, 2 * modes.omega.size))
    made = tuple(struck), tuple(changed), tuple(passed), forgotten, motion.rhythm(len(struck)), True
    given_up = math.fsum(motion.losses[first.losses : last.losses])
    return ElasticCycle(machine, modes.size, flights, *made, given_up)
