"""The cycle in which a machine that switches itself ends: some blows from a fast start, then Newton's method."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import islice

from percuss.steady.self_excited.piston_legs import leg_after, leg_from
from percuss.steady.self_excited.piston_records import Leg, Piston, Rebound
from percuss.steady.self_excited.rigid_cycle import RigidCycle, cycle_near

__all__ = ["continued", "cycle_at", "followed_from", "followed_legs", "settled"]

_FEW = 4
_MOST_BLOWS = 80  # in which a machine settles, or is given up
_MOST_IN_CYCLE = 8
_ALIKE = 0.1  # speeds so near each other, as a part, are worth a try with several blows in a cycle
_CHATTER = 1e-10  # of the greatest speed: a slower rebound at a wall to which the valve pushes is at rest
_TRIES = 12
_TRIES_IN_CYCLE = 3  # for each number of blows in a cycle
_LAST = 5  # rebounds + 1


def followed_legs(piston: Piston, behind: float = 0.0, velocity: float = 0.0, most: int = 6 * _MOST_BLOWS) -> list[Leg]:
    """The flights from a start, blow by blow, until nothing follows; the valve begins in its starting state."""
    return _followed(piston, leg_from(piston, behind, velocity), most)


def _followed(piston: Piston, first: Leg, most: int) -> list[Leg]:
    legs, greatest = [first], 0.0
    while len(legs) < most and (rebound := legs[-1].rebound) is not None:
        greatest = max(greatest, rebound.speed)
        if rebound.speed < _CHATTER * greatest and piston.after(replace(rebound, speed=0.0)).push < 0.0:
            rebound = replace(rebound, speed=0.0)
        legs.append(leg_after(piston, rebound))
    return legs


def followed_from(piston: Piston, rebound: Rebound, most: int) -> list[Leg]:
    """The flights from a rebound on, blow by blow, until nothing follows."""
    return _followed(piston, leg_after(piston, rebound), most)


def settled(piston: Piston) -> tuple[RigidCycle | None, list[Leg]]:
    """The cycle in which a fast start ends, and the flights of the fastest start."""
    first: list[Leg] = []
    starts = (
        (1.0, _FEW, 0),
        (1.0, _MOST_BLOWS, _FEW),
        (0.5, _MOST_BLOWS, 0),
        (0.25, _MOST_BLOWS, 0),
        (2.0, _MOST_BLOWS, 0),
    )
    for part, most, tried in starts:
        legs = _followed(piston, leg_after(piston, _fast(piston, part)), most)
        first = first if len(first) > _FEW else legs
        cycle = cycle_at(piston, [leg.rebound for leg in legs if leg.rebound is not None], tried)
        if cycle is not None:
            return cycle, legs
    return None, first


def continued(piston: Piston, cycle: RigidCycle) -> RigidCycle | None:
    """The cycle with one blow of a machine that differs little from the one that has the given cycle."""
    found = cycle_near(piston, cycle.rebound, 1, close=True)
    if found is not None:
        return found
    legs = _followed(piston, leg_after(piston, cycle.rebound), _FEW)
    rebounds = [leg.rebound for leg in legs if leg.rebound is not None]
    tried = (cycle_near(piston, rebound, 1, close=True) for rebound in rebounds[:-_LAST:-1])
    return next((one for one in tried if one is not None and one.switches), None)


def _fast(piston: Piston, part: float) -> Rebound:
    """A rebound at a part of the speed that the valve could give at most, in the state that pulls most."""
    valve = piston.valve
    forces = {name: force for name, force in valve.pairs}
    difference = max(forces.values()) - min(forces.values())
    farthest = max((port.behind for port in valve.ports if port.behind is not None), default=0.0)
    latest = max(port.delay for port in valve.ports)
    most = 2.0 * difference * farthest + (difference * latest) ** 2
    lost = max(0.05, piston.contact.energy_taken(1.0, 0.0))
    back = min(forces, key=lambda name: forces[name])
    speed = -piston.contact.velocity_factor * math.sqrt(most / lost) * part
    return Rebound(speed, back, replace(valve.orders, last=back))


def cycle_at(piston: Piston, rebounds: list[Rebound], tried: int = 0) -> RigidCycle | None:
    """The cycle that one of the rebounds is near, with few blows rather than many; the first ones were tried before."""
    for rebound in rebounds[tried:_TRIES]:
        cycle = cycle_near(piston, rebound, 1)
        if cycle is not None and cycle.switches:
            return cycle
    for blows in range(1, _MOST_IN_CYCLE + 1):
        pairs = zip(rebounds[:-_TRIES:-1], rebounds[-1 - blows : -_TRIES - blows : -1], strict=False)
        for now in islice((now for now, before in pairs if _alike(now, before)), _TRIES_IN_CYCLE):
            cycle = cycle_near(piston, now, blows)
            if cycle is not None and cycle.switches:
                return cycle
    return None


def _alike(now: Rebound, before: Rebound) -> bool:
    return now.label == before.label and abs(now.speed - before.speed) <= _ALIKE * max(now.speed, before.speed)
