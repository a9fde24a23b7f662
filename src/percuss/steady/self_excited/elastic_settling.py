"""The cycle in which an elastic machine ends: in the rhythm of its rigid piston, or in the one it is followed to."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from percuss.model import Machine
from percuss.steady.self_excited.elastic_cycle import ElasticCycle
from percuss.steady.self_excited.elastic_following import Following
from percuss.steady.self_excited.elastic_newton import Solved, solved
from percuss.steady.self_excited.elastic_rest import rest_cycle
from percuss.steady.self_excited.rhythm import Rhythm, steps_of
from percuss.steady.self_excited.rigid_cycle import RigidCycle

__all__ = ["Settled", "settled_from"]

_BLOWS = (12, 24, 48)  # after which a cycle is tried, one after the other
_MOST_IN_CYCLE = 4
_SAME = 1e-9  # of the period


@dataclass(frozen=True)
class Settled:
    """The cycle, None for none; what the motion did in the end; and what the first try met."""

    cycle: ElasticCycle | None
    ending: str | None
    first: Solved


def settled_from(machine: Machine, count: int, rhythm: Rhythm, rigid: RigidCycle | None) -> Settled:
    """The cycle near a rhythm where it is stable; else where the motion ends that begins as the rigid one does."""
    first = solved(machine, count, rhythm)
    if first.cycle is not None and first.cycle.stable:
        return Settled(first.cycle, None, first)
    if rigid is None:
        return Settled(first.cycle, None, first)
    modes = machine.modes(count)
    begin = np.zeros((count + 1, 2))
    begin[:, 1] = -rigid.rebound.speed * modes.centre
    motion = Following(machine, count, begin, rigid.rebound.state, rigid.rebound.orders, rigid.period)
    for blows in _BLOWS:
        motion.go_on(blows)
        if (resting := rest_cycle(motion)) is not None:
            return Settled(resting, None, first)
        if motion.ending is not None:
            return Settled(None, motion.ending, first)
        cycle = _cycle_at(machine, count, motion)
        if cycle is not None:
            return Settled(cycle, None, first)
    return Settled(first.cycle, None, first)


def _cycle_at(machine: Machine, count: int, motion: Following) -> ElasticCycle | None:
    for blows in range(1, min(_MOST_IN_CYCLE, motion.blows - 1) + 1):
        rhythm = motion.rhythm(blows)
        if steps_of(machine.valve, rhythm) is not None:
            cycle = solved(machine, count, rhythm).cycle
            if cycle is not None and cycle.stable:
                return _shortest(machine, count, cycle)
    return None


def _shortest(machine: Machine, count: int, cycle: ElasticCycle) -> ElasticCycle:
    """The cycle, or that of fewer blows which it goes through again and again: what settles slowly looks longer."""
    for blows in range(1, cycle.blows):
        if cycle.blows % blows == 0:
            part = solved(machine, count, _part(cycle.rhythm, blows)).cycle
            if part is not None and abs(part.period * (cycle.blows // blows) - cycle.period) <= _SAME * cycle.period:
                return part
    return cycle


def _part(rhythm: Rhythm, blows: int) -> Rhythm:
    """That of the first blows, as if they were a cycle."""
    times = rhythm.blow_times[:blows]
    return replace(rhythm, blow_times=times, passages=tuple(one for one in rhythm.passages if one[0] <= times[-1]))
