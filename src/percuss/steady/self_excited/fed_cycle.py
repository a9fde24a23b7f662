"""The cycle of a machine that a pump and an accumulator feed: first the pressure that results, then Newton's method.

Under a constant pressure a cycle draws a volume in its time; the pressure that results is the one at which the pump
gives just that. It is the cycle's for an accumulator without end, which is then made smaller step by step.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

from percuss.steady.self_excited.piston_records import Leg, Piston, Rebound
from percuss.steady.self_excited.rigid_cycle import RigidCycle, cycle_near
from percuss.steady.self_excited.settled_cycle import continued, cycle_at, followed_from, settled

__all__ = ["fed", "under_pressure"]

_TRIED = (1.0, 2.0, 0.5, 4.0)
"""Pressures at which a machine may run."""
_STEP = 0.25  # of the logarithm of the pressure
_MOST_STEPS = 40
_NEAR = 1e-6
_SMALL_SWING = 0.05  # of the pressure in a cycle: where the steps of the accumulator begin
_MOST_HALVINGS = 40
_MOST_BLOWS = 120


def under_pressure(piston: Piston, pressure: float) -> Piston:
    """The piston under a constant pressure."""
    return replace(piston, valve=piston.valve.at_pressure(pressure))


def fed(piston: Piston) -> tuple[RigidCycle | None, list[Leg]]:
    """The cycle of a piston with a supply, and the flights of a start near it when there is none with one blow."""
    balance = _balanced(piston)
    rebound = None if balance is None else _with_pressure(piston, *balance)
    cycle = None if rebound is None or balance is None else _with_less_oil(piston, rebound, *balance)
    if cycle is not None:
        return cycle, []
    legs = followed_from(piston, rebound or _start(piston), _MOST_BLOWS)
    return cycle_at(piston, [leg.rebound for leg in legs if leg.rebound is not None]), legs


def _start(piston: Piston) -> Rebound:
    """The piston on the wall, as the machine starts."""
    valve, supply = piston.valve, piston.valve.supply
    assert supply is not None
    return Rebound(0.0, valve.orders.last, valve.orders, supply.start)


def _with_pressure(piston: Piston, cycle: RigidCycle, pressure: float) -> Rebound:
    return replace(cycle.rebound, pressure=pressure)


def _balanced(piston: Piston) -> tuple[RigidCycle, float] | None:
    """The cycle under the constant pressure at which it draws what the pump gives, and that pressure."""
    low = high = None
    for pressure in _TRIED:
        cycle, _ = settled(under_pressure(piston, pressure))
        if cycle is not None and cycle.blows == 1 and cycle.work > 0.0:
            break
    else:
        return None
    for _ in range(_MOST_STEPS):
        surplus = _surplus(piston, cycle, pressure)
        if surplus > 0.0:
            low = cycle, pressure
        else:
            high = cycle, pressure
        if low is not None and high is not None:
            return _between(piston, low, high)
        pressure *= math.exp(math.copysign(_STEP, surplus))
        following = continued(under_pressure(piston, pressure), cycle)
        if following is None:
            break
        cycle = following
    return low or high


def _surplus(piston: Piston, cycle: RigidCycle, pressure: float) -> float:
    """The logarithm of what the pump gives in a cycle over what the piston draws under a constant pressure."""
    supply = piston.valve.supply
    assert supply is not None
    return math.log(supply.flow * cycle.period * pressure / cycle.work)


def _between(piston: Piston, low: tuple[RigidCycle, float], high: tuple[RigidCycle, float]) -> tuple[RigidCycle, float]:
    """The pressure of balance between two at which the piston runs."""
    while high[1] - low[1] > _NEAR * low[1]:
        pressure = math.sqrt(low[1] * high[1])
        cycle = continued(under_pressure(piston, pressure), low[0])
        if cycle is None:
            break
        if _surplus(piston, cycle, pressure) > 0.0:
            low = cycle, pressure
        else:
            high = cycle, pressure
    return low


def _with_less_oil(piston: Piston, rebound: Rebound, cycle: RigidCycle, pressure: float) -> RigidCycle | None:
    """The cycle with the accumulator there is, from one with which the pressure hardly swings."""
    found = None
    for compliance in _compliances(piston, cycle.work / (_SMALL_SWING * pressure**2)):
        supply = piston.valve.supply
        assert supply is not None
        other = replace(piston, valve=replace(piston.valve, supply=replace(supply, compliance=compliance)))
        found = cycle_near(other, rebound, 1)
        if found is None or not found.switches:
            return None
        rebound = found.rebound
    return found


def _compliances(piston: Piston, most: float) -> Iterator[float]:
    supply = piston.valve.supply
    assert supply is not None
    halvings = min(max(math.ceil(math.log2(most / supply.compliance)), 0), _MOST_HALVINGS)
    for halving in range(halvings, -1, -1):
        yield supply.compliance * 2.0**halving
