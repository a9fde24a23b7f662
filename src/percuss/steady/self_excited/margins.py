"""How far a machine that switches itself is from what would stop it: the return too late, the gas too stiff."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

from percuss.errors import ParameterError
from percuss.model import Chamber, Valve
from percuss.model.checks import instance
from percuss.shown import Shown
from percuss.steady.self_excited.obstacle import Obstacle, why_none
from percuss.steady.self_excited.piston_legs import leg_from
from percuss.steady.self_excited.piston_records import Piston, Switch
from percuss.steady.self_excited.rigid_cycle import RigidCycle
from percuss.steady.self_excited.self_switching import SelfExcited, piston_of, self_excited_motion
from percuss.steady.self_excited.settled_cycle import continued, followed_from

__all__ = ["ValveMargins", "valve_margins"]

_STEP = 1.0 / 32.0  # of the period, or of the factor of the chamber
_SUPPLY_STEP = 1.0 / 32.0  # of the logarithm of flow and accumulator
_MOST_STEPS = 256
_CLOSE = 1e-8  # of a step
_LONGER, _NEARLY = 4.0, 1e-4  # the step, and how close, with a supply, whose cycles take longer to find
_BEYOND = 1e-6
_BLOWS_BEYOND = 60


@dataclass(frozen=True)
class ValveMargins(Shown):
    """How far a running machine is from what would stop it.

    Parameters
    ----------
    return_time
        When the state changes that sends the piston back: time after the blow, negative before it.
    latest_return
        The greatest `return_time` with which the machine still runs, when the delay of the return grows; None when no
        limit was found within eight periods, as with R = 0, where a late return merely makes the piston rest.
    beyond
        What happens beyond it: "double blow", "flip", or another obstacle.
    chamber_to_run, chamber_to_start
        The factors by which the force and the stiffness of the chamber may be multiplied until the machine no longer
        runs, and until it no longer starts from rest on the wall; None without a chamber, with a
        supply, whose pressure follows the gas, and where no limit was found.
    flow_to_run, accumulator_to_run
        The factors by which the flow of the pump, and the compliance of the accumulator, may be multiplied until the
        machine no longer runs, or not stably; None with a constant pressure, and where no limit was found.
    """

    return_time: float
    latest_return: float | None
    beyond: Obstacle | None
    chamber_to_run: float | None
    chamber_to_start: float | None
    flow_to_run: float | None = None
    accumulator_to_run: float | None = None


def valve_margins(motion: SelfExcited) -> ValveMargins:
    """The margins of a machine that runs.

    Every limit is that of the cycle of the rigid piston, which is followed while the delay of the return, or the
    chamber, grows.

    Parameters
    ----------
    motion
        The result of `self_excited_motion` for a machine that runs.

    Raises
    ------
    ParameterError
        When the machine does not run with a rigid piston.

    Examples
    --------
    >>> from percuss.model import Kept, Machine, Port, UniformBar, Valve
    >>> from percuss.steady import self_excited_motion
    >>> ports = [Port("power", behind=1.0, side="back"), Port("return", on="impact")]
    >>> machine = Machine(UniformBar(20.0), Valve({"return": -0.4, "power": 1.8}, ports), Kept(0.2))
    >>> margins = valve_margins(self_excited_motion(machine, modes=0))
    >>> print(f"{margins.latest_return:.4f}, then {margins.beyond.value}")
    0.3324, then double blow
    """
    instance("motion", motion, SelfExcited)
    if motion.modes:
        room = motion.room if math.isfinite(motion.room) else None
        motion = self_excited_motion(motion.machine, modes=0, room=room)
    if not motion.runs or not isinstance(motion.cycle, RigidCycle):
        why = "" if motion.obstacle is None else motion.obstacle.remedy
        raise ParameterError("motion", str(motion), "a machine that runs", why)
    valve = motion.machine.valve
    switch = _return_of(valve, motion.cycle)

    def later(extra: float) -> Valve:
        ports = tuple(
            replace(port, delay=port.delay + extra) if port.to == switch.to else port
            for port in motion.machine.valve.ports
        )
        return replace(motion.machine.valve, ports=ports)

    latest, last = _limit(motion, later, 0.0, _STEP * motion.cycle.period)
    return_time, beyond = _after_blow(switch, motion.cycle), None
    room = motion.room if math.isfinite(motion.room) else None
    if latest is not None:
        far = _BEYOND if valve.supply is None else _STEP * _LONGER * _NEARLY
        past = motion.machine.with_valve(later(latest + far * motion.cycle.period))
        beyond = (
            self_excited_motion(past, modes=0, room=room).obstacle
            if valve.supply is None
            else _beyond(piston_of(past), last)
        )
    longest = None if latest is None else _after_blow(_return_of(later(latest), last), last)
    return ValveMargins(return_time, longest, beyond, *_chamber_limits(motion), *_supply_limits(motion))


def _return_of(valve: Valve, cycle: RigidCycle) -> Switch:
    """The change to a lower force that is nearest to the wall."""
    state, falls = cycle.rebound.state, []
    for switch in cycle.switches:
        if valve.force(switch.to) < valve.force(state):
            falls.append(switch)
        state = switch.to
    return min(falls, key=lambda switch: switch.behind)


def _after_blow(switch: Switch, cycle: RigidCycle) -> float:
    """The time of a switch after the blow that is nearest in time."""
    return switch.time if 2.0 * switch.time < cycle.period or cycle.rests else switch.time - cycle.period


def _limit(
    motion: SelfExcited, changed: Callable[[float], Valve], start: float, step: float
) -> tuple[float | None, RigidCycle]:
    """The least value from `start` on at which the cycle ends or is no longer stable, and the last cycle before it."""
    cycle = motion.cycle
    assert isinstance(cycle, RigidCycle)
    value = start
    if motion.machine.valve.supply is not None:
        step *= _LONGER
    for _ in range(_MOST_STEPS):
        found = _running(motion, changed(value + step), cycle)
        if found is None:
            break
        value, cycle = value + step, found
    else:
        return None, cycle
    low, high = value, value + step
    close = _CLOSE if motion.machine.valve.supply is None else _NEARLY
    while high - low > close * step:
        middle = 0.5 * (low + high)
        found = _running(motion, changed(middle), cycle)
        if found is None:
            high = middle
        else:
            low, cycle = middle, found
    return low, cycle


def _running(motion: SelfExcited, valve: Valve, near: RigidCycle) -> RigidCycle | None:
    """The stable cycle of another valve, near a cycle."""
    cycle = continued(piston_of(motion.machine.with_valve(valve)), near)
    return cycle if cycle is not None and cycle.stable and cycle.stroke <= motion.room else None


def _chamber_limits(motion: SelfExcited) -> tuple[float | None, float | None]:
    chamber = motion.machine.valve.chamber
    if (chamber.force <= 0.0 and chamber.stiffness == 0.0) or motion.machine.valve.supply is not None:
        return None, None

    def filled(factor: float) -> Valve:
        return replace(motion.machine.valve, chamber=Chamber(factor * chamber.force, factor * chamber.stiffness))

    def starts(factor: float) -> bool:
        first = leg_from(piston_of(motion.machine.with_valve(filled(factor))), 0.0, 0.0)
        return first.ending == "blow" and bool(first.switches)

    run, _ = _limit(motion, filled, 1.0, _STEP)
    low, high = 0.0, 1.0 + _STEP * _MOST_STEPS if run is None else run
    if not starts(low):
        return run, 0.0
    if starts(high):
        return run, None if run is None else high
    while high - low > _CLOSE:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if starts(middle) else (low, middle)
    return run, low


def _beyond(piston: Piston, last: RigidCycle) -> Obstacle | None:
    """What a machine with a supply does whose cycle has just been lost."""
    cycle = continued(piston, last)
    if cycle is not None:
        return Obstacle.HUNTS
    return why_none(piston, followed_from(piston, last.rebound, _BLOWS_BEYOND)).get("obstacle")


def _supply_limits(motion: SelfExcited) -> tuple[float | None, float | None]:
    supply = motion.machine.valve.supply
    if supply is None:
        return None, None

    def less(name: str, logarithm: float) -> Valve:
        changed = getattr(supply, name) * math.exp(-logarithm)
        return replace(motion.machine.valve, supply=replace(supply, **{name: changed}))

    limits = [_limit(motion, partial(less, name), 0.0, _SUPPLY_STEP)[0] for name in ("flow", "compliance")]
    flow, compliance = (None if limit is None else math.exp(-limit) for limit in limits)
    return flow, compliance
