"""How far a machine that switches itself is from what would stop it: the return too late, the gas too stiff."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from percuss.errors import ParameterError
from percuss.mechanics.crossing import farthest
from percuss.mechanics.flow import state_flows
from percuss.model import Chamber, Machine, Valve
from percuss.model.checks import Array, instance, numbers
from percuss.short_repr import ShortRepr
from percuss.steady.oil.oil_cycle import OilFlight, near_oil, slow_oil, starts_oil
from percuss.steady.self_excited import piston_kernels as kn
from percuss.steady.self_excited.piston import Piston, continued
from percuss.steady.self_excited.self_switching import Obstacle, SelfExcited, self_excited_motion
from percuss.steady.self_excited.settling import followed_to, solved, under_pressure
from percuss.steady.self_excited.valve_cycle import Switch, ValveCycle, ValveFlight, flights_at, pressure_multiplier

_STEP = 1.0 / 32.0  # of the period, or of the factor of the chamber
_SUPPLY_STEP = 1.0 / 32.0  # of the logarithm of flow and accumulator
_MOST_STEPS = 256
_CLOSE = 1e-8  # of a step
_LONGER, _NEARLY = 4.0, 1e-4  # the step, and how close, with a supply, whose cycles take longer to find
_BEYOND = 1e-6


@dataclass(frozen=True)
class ValveMargins(ShortRepr):
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
    if not motion.runs or motion.cycle is None:
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
        beyond = self_excited_motion(past, modes=0, room=room).obstacle
        if valve.supply is not None and near_cycle(past, last) is not None:
            beyond = Obstacle.HUNTS
    longest = None if latest is None else _after_blow(_return_of(later(latest), last), last)
    return ValveMargins(return_time, longest, beyond, *_chamber_limits(motion), *_supply_limits(motion))


def _return_of(valve: Valve, cycle: ValveCycle) -> Switch:
    """The change to a lower force that is nearest to the wall."""
    state, falls = cycle.state, []
    for switch in cycle.switches:
        if valve.force(switch.to) < valve.force(state):
            falls.append(switch)
        state = switch.to
    return min(falls, key=lambda switch: switch.behind)


def _after_blow(switch: Switch, cycle: ValveCycle) -> float:
    """The time of a switch after the blow that is nearest in time."""
    return switch.time if 2.0 * switch.time < cycle.period or cycle.rests else switch.time - cycle.period


def _limit(
    motion: SelfExcited, changed: Callable[[float], Valve], start: float, step: float
) -> tuple[float | None, ValveCycle]:
    """The least value from `start` on at which the cycle ends or is no longer stable, and the last cycle before it."""
    cycle = motion.cycle
    assert cycle is not None
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


def _running(motion: SelfExcited, valve: Valve, near: ValveCycle) -> ValveCycle | None:
    """The stable cycle of another valve, near a cycle."""
    cycle = near_cycle(motion.machine.with_valve(valve), near)
    roomy = cycle is not None and (motion.room == math.inf or cycle.stroke <= motion.room)
    return cycle if cycle is not None and cycle.stable and roomy else None


def _chamber_limits(motion: SelfExcited) -> tuple[float | None, float | None]:
    chamber = motion.machine.valve.chamber
    if (chamber.force <= 0.0 and chamber.stiffness == 0.0) or motion.machine.valve.supply is not None:
        return None, None

    def filled(factor: float) -> Valve:
        gas = Chamber(factor * chamber.force, factor * chamber.stiffness, chamber.exponent if factor else None)
        return replace(motion.machine.valve, chamber=gas)

    def starts(factor: float) -> bool:
        if motion.machine.valve.flows:
            return starts_oil(motion.machine.with_valve(filled(factor)))
        piston = Piston(motion.machine.with_valve(filled(factor)))
        first = piston.leg(piston.start, started=True)
        return first.ending == kn.BLOW and bool(first.switches)

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


def _supply_limits(motion: SelfExcited) -> tuple[float | None, float | None]:
    supply = motion.machine.valve.supply
    if supply is None:
        return None, None

    def less(quantity: MachineQuantity, logarithm: float) -> Valve:
        return quantity.at(quantity.value * math.exp(-logarithm)).valve

    fed = [one for one in quantities_of(motion.machine) if one.name in ("flow", "compliance")]
    limits = [_limit(motion, partial(less, one), 0.0, _SUPPLY_STEP)[0] for one in fed]
    flow, compliance = (None if limit is None else math.exp(-limit) for limit in limits)
    return flow, compliance


# ---- How blow energy and rate of a self-excited machine change with pressure, ports, delays and restitution

_DIFFERENCE_STEP = 1e-5  # of the quantity, or of its unit where it is 0


@dataclass(frozen=True)
class Sensitivity(ShortRepr):
    """The derivatives of a cycle by one quantity of its machine.

    Attributes
    ----------
    quantity
        "pressure", a factor on the forces of all states, which is 1 without the chamber's, or in its place "flow" and
        "compliance" of a supply; "behind" or "speed", and "delay", of a port; "restitution".
    value
        Of the quantity.
    energy, rate
        Derivatives of `main_energy` and of 1/`period`; NaN where no cycle is found on either side.
    """

    quantity: str
    port: int | None
    value: float
    energy: float
    rate: float


def sensitivities(motion: SelfExcited) -> tuple[Sensitivity, ...]:
    """The derivatives of blow energy and rate, by differences of cycles that are solved for beside the one there is.

    Differences are central, but one-sided at a delay and a restitution of 0; relative error about 1e-8, and 1e-5.

    Parameters
    ----------
    motion
        The result of `self_excited_motion` for a machine that runs.

    Raises
    ------
    ParameterError
        When the machine does not run.

    Examples
    --------
    >>> from percuss.model import Kept, Machine, Port, UniformBar, Valve
    >>> from percuss.steady import self_excited_motion
    >>> ports = [Port("power", behind=1.0, side="back"), Port("return", on="impact")]
    >>> machine = Machine(UniformBar(20.0), Valve({"return": -0.4, "power": 1.8}, ports), Kept(0.2))
    >>> for one in sensitivities(self_excited_motion(machine, modes=0))[:2]:
    ...     print(one.quantity, f"{one.energy:.6f} {one.rate:.6f}")
    pressure 2.291667 0.158784
    behind 2.291667 -0.158784
    """
    instance("motion", motion, SelfExcited)
    if motion.cycle is None or not motion.runs:
        raise ParameterError("motion", str(motion), "a machine that runs")
    return tuple(_sensitivity(motion, motion.cycle, quantity) for quantity in quantities_of(motion.machine))


class MachineQuantity(NamedTuple):
    """What may change of a machine: as of a `Sensitivity`, and `at` gives the machine with another value."""

    name: str
    port: int | None
    value: float
    at: Callable[[float], Machine]


def quantities_of(machine: Machine) -> Iterator[MachineQuantity]:
    """Pressure, or flow and accumulator of a supply, place and delay of the ports, and restitution."""
    valve, supply = machine.valve, machine.valve.supply

    def part_of(whole: Any, name: str, value: float) -> Any:
        return replace(whole, **{name: value})

    def fed(name: str, value: float) -> Machine:
        other = part_of(supply, name, value)
        if name == "compliance" and supply is not None and supply.gas is not None:  # with the line of the accumulator
            factor = value / supply.capacity(1.0)
            gas = part_of(supply.gas, "volume", supply.gas.volume * factor)
            other = replace(supply, compliance=supply.compliance * factor, gas=gas)
        return machine.with_valve(replace(valve, supply=other))

    def with_port(number: int, name: str, value: float) -> Machine:
        ports = list(valve.ports)
        ports[number] = part_of(ports[number], name, value)
        return machine.with_valve(replace(valve, ports=tuple(ports)))

    def under(pressure: float) -> Machine:
        return machine.with_valve(valve.at_pressure(pressure))

    def rebounding(restitution: float) -> Machine:
        return replace(machine, contact=machine.contact.with_restitution(min(restitution, 1.0)))

    if supply is None:
        yield MachineQuantity("pressure", None, 1.0, under)
    else:
        for name in ("flow", "compliance"):
            value = supply.flow if name == "flow" else supply.capacity(1.0) or supply.compliance
            yield MachineQuantity(name, None, value, partial(fed, name))
    for i, port in enumerate(valve.ports):
        if port.sign != 0.0:
            yield MachineQuantity(port.edge, i, abs(port.level), partial(with_port, i, port.edge))
        yield MachineQuantity("delay", i, port.delay, partial(with_port, i, "delay"))
    yield MachineQuantity("restitution", None, machine.contact.restitution, rebounding)


def _sensitivity(motion: SelfExcited, cycle: ValveCycle, quantity: MachineQuantity) -> Sensitivity:
    name, port, value, changed = quantity
    step = _DIFFERENCE_STEP * (value or (1.0 if name == "restitution" else cycle.period))
    highest = 1.0 if name == "restitution" else value + step
    found = []
    for other in (max(value - step, 0.0), min(value + step, highest)):
        near = near_cycle(changed(other), cycle) if other != value else cycle
        if near is not None:
            found.append((other, near.main_energy, 1.0 / near.period))
    if len(found) < 2:
        return Sensitivity(name, port, value, float("nan"), float("nan"))
    (low, energy, rate), (high, more, faster) = found
    return Sensitivity(name, port, value, (more - energy) / (high - low), (faster - rate) / (high - low))


def near_cycle(machine: Machine, cycle: ValveCycle) -> ValveCycle | None:
    """The cycle of a machine that differs little from that of a cycle."""
    if machine.valve.flows:
        return near_oil(machine, cycle)
    if cycle.modes:
        return self_excited_motion(machine, modes=cycle.modes, near=cycle).cycle
    return (continued if machine.valve.supply is None else followed_to)(machine, cycle)


# ---- The pressure of a supply over a cycle: where it settles, how far it swings, and how a disturbance of it dies out

_PRESSURE_STEP = 1e-4  # of the pressure


@dataclass(frozen=True)
class SlowPressure(ShortRepr):
    """The pressure in a cycle, as a multiple of that for which the forces of the valve's states hold.

    Attributes
    ----------
    at_blow, mean, least, greatest
        Of the pressure.
    multiplier
        What is left of a disturbance of the pressure after a cycle: the multiplier whose direction is that of the
        pressure more than that of the speed. It flips at −1.
    slow_multiplier
        The same for an accumulator so great that the speed follows at once, 1 + (V/(C P)) d ln(T/V)/d ln P; None where
        the machine does not run under the mean pressure, as a constant one.
    """

    at_blow: float
    mean: float
    least: float
    greatest: float
    multiplier: complex
    slow_multiplier: float | None

    @property
    def ripple(self) -> float:
        """Greatest minus least, as a part of the mean."""
        return (self.greatest - self.least) / self.mean

    @property
    def memory(self) -> float:
        """Cycles in which a disturbance of the pressure falls to 1/e; infinite where it does not."""
        left = abs(self.multiplier)
        return math.inf if left >= 1.0 else -1.0 / math.log(left) if left > 0.0 else 0.0


def slow_pressure(cycle: ValveCycle) -> SlowPressure:
    """The pressure of a cycle that a supply feeds.

    Raises
    ------
    ParameterError
        When the cycle is one under a constant pressure.

    Notes
    -----
    Over a cycle P′ = P + (Q T(P) − V)/C, with V what the piston draws: a fast cycle empties the accumulator, and a low
    pressure makes a slow cycle. Without a gas chamber and delays V is constant, T goes with P^(−1/2), and the pressure
    only ever creeps back; with a stiff one, and a return that hardly reaches its port, it overshoots.

    Examples
    --------
    >>> from percuss.model import Kept, Machine, Port, Supply, UniformBar, Valve
    >>> from percuss.steady import self_excited_motion
    >>> ports = [Port("power", behind=1.0, side="back"), Port("return", on="impact")]
    >>> valve = Valve({"return": -0.4, "power": 1.8}, ports, supply=Supply(flow=0.7, compliance=15.0))
    >>> cycle = self_excited_motion(Machine(UniformBar(20.0), valve, Kept(0.2)), modes=0).cycle
    >>> pressure = slow_pressure(cycle)
    >>> print(f"{pressure.mean:.4f} ± {50 * pressure.ripple:.1f} %, multiplier {pressure.multiplier.real:.4f}")
    0.9835 ± 5.2 %, multiplier 0.9292
    """
    checked = _checked(cycle)
    if checked.oil is not None:
        swept = pressure_multiplier(checked.slope, checked.modes)
        oil, before = checked.oil, checked.flights[0].pressure
        return SlowPressure(before, checked.mean_pressure, oil.least, oil.greatest, swept, slow_oil(checked))
    spans = [_pressures(checked, one) for one in checked.flights]
    mean, at_blow = checked.mean_pressure, checked.flights[0].pressure
    least, greatest = min(low for low, _ in spans), max(high for _, high in spans)
    return SlowPressure(
        at_blow,
        mean,
        least,
        greatest,
        pressure_multiplier(checked.slope, checked.modes),
        _slow_multiplier(checked, mean),
    )


def _pressures(cycle: ValveCycle, flight: ValveFlight) -> tuple[float, float]:
    """The least and the greatest pressure of a flight."""
    flow, begin = state_flows(cycle.machine, cycle.modes)[flight.state], flight.pressure
    growth = flow.supplied / flow.compliance
    if flight.ramp == 0.0:  # it rests, or the state draws nothing
        return begin, begin + growth * flight.duration
    row, place = flow.draw / flow.compliance * flow.modes.driven, float(flow.modes.driven @ flight.begin[:, 0])
    begin += flow.draw / flow.compliance * place
    return begin - farthest(flight, -row, growth), begin + farthest(flight, row, -growth)


def pressure_over(cycle: ValveCycle, times: Array) -> Array:
    """The pressure at some times of a cycle that a supply feeds, repeated with its period; the shape of `times`.

    Raises
    ------
    ParameterError
        When the cycle is one under a constant pressure.
    """
    checked = _checked(cycle)
    within = np.mod(numbers("times", times), checked.period)
    flows = state_flows(checked.machine, checked.modes)
    found, which = np.empty(within.shape), flights_at(checked, within)
    for number in np.unique(which).tolist():
        mine, flight = which == number, checked.flights[number]
        if isinstance(flight, OilFlight):
            found[mine] = flight.looked(within[mine] - flight.time)[1]
            continue
        flow, t = flows[flight.state], within[which == number] - flight.time
        drawn = flow.draw * (flow.modes.driven @ flight.moved(t)[0]) if flight.ramp else 0.0
        found[mine] = flight.pressure + (flow.supplied * t - drawn) / flow.compliance
    return found


def _checked(cycle: object) -> ValveCycle:
    found = instance("cycle", cycle, ValveCycle)
    if found.valve.supply is None:
        raise ParameterError("cycle", str(found), "a cycle with a supply", "give the valve a Supply")
    return found


def _slow_multiplier(cycle: ValveCycle, mean: float) -> float | None:
    supply, found = cycle.valve.supply, []
    assert supply is not None
    for pressure in (mean * (1.0 - _PRESSURE_STEP), mean * (1.0 + _PRESSURE_STEP)):
        machine = under_pressure(cycle.machine, pressure)
        other = solved(machine, cycle.modes, cycle.rhythm)
        if other is None:
            return None
        found.append(other.period * pressure / other.work)  # T/V
    slope = math.log(found[1] / found[0]) / math.log((1.0 + _PRESSURE_STEP) / (1.0 - _PRESSURE_STEP))
    return 1.0 + supply.flow * cycle.period / (supply.compliance * mean) * slope
