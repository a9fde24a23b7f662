"""What the cycle of a machine that switches itself means in SI."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from percuss.case.answers.facts import (
    Fact,
    Teller,
    json_number,
    json_of,
    number,
    percent,
    rows_of,
    said,
    si_of,
    table_text,
)
from percuss.model import Cushion
from percuss.short_repr import ShortRepr
from percuss.steady import blank_blow, self_excited_motion, slow_pressure
from percuss.steady.oil.oil_cycle import OilFlight
from percuss.steady.oil.oil_figures import (
    ChamberPressure,
    Lift,
    chamber_pressures,
    duty_of,
    lift_of,
    oil_checks,
    path_losses,
    precharge_margin,
    relief_margin,
)
from percuss.steady.self_excited.margins import MachineQuantity, pressure_over, quantities_of
from percuss.steady.self_excited.valve_cycle import flights_at

if TYPE_CHECKING:
    from percuss.mechanics.oil import OilBalance
    from percuss.model import Machine
    from percuss.model.checks import Array
    from percuss.simulate import Trajectory
    from percuss.steady import BlankBlow
    from percuss.steady.self_excited.self_switching import SelfExcited
    from percuss.steady.self_excited.valve_cycle import ValveCycle


class Running(NamedTuple):
    """A machine and its cycle; with several blows in it, energy and speed are those of the strongest."""

    machine: Machine
    cycle: ValveCycle

    @property
    def rate(self) -> float:
        """Blows per unit of time."""
        return self.cycle.blows / self.cycle.period

    @property
    def contact_time(self) -> float:
        """One round trip of the waves."""
        return 2.0 * self.machine.body.transit_time

    @property
    def oil(self) -> float | None:
        """What the supply gives in a cycle, without leakage; None when its pressure is not known."""
        return None if self.machine.pressure is None else self.cycle.drawn

    @property
    def flow(self) -> float | None:
        """The same per unit of time."""
        return None if self.oil is None else self.oil / self.cycle.period

    @property
    def input(self) -> float:
        """Power that the valve puts in."""
        return self.cycle.work / self.cycle.period

    @property
    def delivered(self) -> float:
        """Power that the blows take."""
        return self.cycle.taken / self.cycle.period

    @property
    def efficiency(self) -> float | None:
        """None without an input."""
        return self.cycle.taken / self.cycle.work if self.cycle.work > 0.0 else None


CYCLE: tuple[Fact[Running], ...] = (
    Fact("blow_energy_J", "blow energy", "of the strongest blow of the cycle", "energy",
         "cycle.main_energy"),
    Fact("impact_velocity_m_s", "speed", "of the same blow", "speed", "cycle.blow_speed"),
    Fact("blow_rate_Hz blow_rate_per_min", "blow rate", "blows per second and per minute", "rate", "rate",
         "{rate:Hz}, {rate:per_min}"),
    Fact("period", "period", "of the cycle, which is not the load's", "time", "cycle.period"),
    Fact("stroke stroke_m", "stroke", "how far the piston goes back", "length", "cycle.stroke"),
    Fact("duty", "duty", "part of the cycle that is pushed toward the wall before the blow", "",
         "cycle.duty", "{cycle.duty:percent} of the cycle pushed toward the wall before the blow"),
    Fact("contact_time_us", "contact",
         "how long a uniform bar of this length is in contact, one round trip of its waves; the model lets the blow "
         "take no time", "time", "contact_time",
         "{contact_time:us}, one round trip of the waves, taken as no time"),
)  # fmt: skip
"""What a cycle is."""

POWER: tuple[Fact[Running], ...] = (
    Fact("oil_flow_l_per_min", "oil flow",
         "from the supply, of oil that flows with its leakage; null when its pressure is not known", "flow", "flow",
         lambda one, tell: said("{flow:l_per_min}, {oil:cm3} a cycle, "
                                + ("without" if one.cycle.oil is None else "with") + " leakage", one, tell)),
    Fact("oil_per_cycle_cm3", "", "the same", "volume", "oil"),
    Fact("input_power_kW", "input power", "what the valve puts in: pressure times oil flow", "power",
         "input", "{input:kW}: pressure times oil flow"),
    Fact("delivered_power_kW", "delivered", "the part of it that the blows take; damping and drag take the rest",
         "power", "delivered", "{delivered:kW}, {cycle.taken:energy} a cycle"),
    Fact("delivered_energy_J", "", "what the blows of a cycle take from it", "energy", "cycle.taken"),
    Fact("si.efficiency", "efficiency",
         "delivered over input; the energy of the rebound comes back and is in neither", "",
         "efficiency", lambda one, tell: None if one.cycle.oil is not None else said(
             "{efficiency:percent} of the input is delivered, drag and damping take the rest; the energy of the "
             "rebound comes back and is in neither. The oil is lossless here: passages, leaks and the tank line take "
             "a third to a half of the input of a real hammer, and need their keys (oil-drifter has them)", one, tell)),
    Fact("blank_energy_J", "", "when the tool is not there: what the piston brings to where the blow would be",
         "energy", "cycle.main_energy"),
    Fact("blank_distance_m", "", "how far the force that then acts would let it go; null when nothing stops it",
         "length", lambda one: _blank_distance(*one)),
    Fact("work_per_cycle", "", "what the valve puts into a cycle", "energy", "cycle.work"),
)  # fmt: skip
"""What a cycle takes and gives."""


@dataclass(frozen=True)
class OilReport(ShortRepr):
    """Where the energy of oil that flows goes, over a cycle."""

    machine: Machine
    cycle: ValveCycle

    @property
    def oil(self) -> OilBalance:
        """Its balance."""
        assert self.cycle.oil is not None
        return self.cycle.oil

    @property
    def shares(self) -> dict[str, float]:
        """Parts of the input, by name."""
        return {name: loss / self.oil.input for name, loss in path_losses(self.cycle).items()}

    @property
    def efficiency(self) -> float:
        """Delivered over input, never above 1."""
        return self.oil.impact / self.oil.input

    @property
    def of_the_blow(self) -> float:
        """Blow energy over input, as data sheets have it."""
        return float(self.cycle.blow_energies.sum()) / self.oil.input

    @property
    def blow_power(self) -> float:
        """Blow energies per unit of time."""
        return float(self.cycle.blow_energies.sum()) / self.cycle.period

    @property
    def input_power(self) -> float:
        """Per unit of time."""
        return self.oil.input / self.cycle.period

    @property
    def pump_flow(self) -> float:
        """Mean flow of the pump, or from the supply."""
        return self.oil.pumped / self.cycle.period

    @cached_property
    def chambers(self) -> tuple[ChamberPressure, ...]:
        """Their pressures."""
        return chamber_pressures(self.cycle)

    @property
    def lift(self) -> Lift | None:
        """What lifts the piston off the wall."""
        return lift_of(self.machine)

    @property
    def cavitates(self) -> tuple[str, ...]:
        """The chambers whose pressure falls to that of a vacuum; of machines without scales nobody knows."""
        unit = self.machine.pressure
        return () if unit is None else tuple(c.chamber for c in self.chambers if c.least * unit <= -_ATMOSPHERE)

    @property
    def greatest_loss(self) -> tuple[str, float]:
        """The loss that takes most, by name, but for the blow."""
        shares = {name: share for name, share in self.shares.items() if name != "impact"}
        return max(shares.items(), key=lambda one: one[1])

    @property
    def sentence(self) -> str:
        """The share that is delivered, and what takes most of the rest."""
        name, share = self.greatest_loss
        text = f"{percent(self.efficiency)} of the input reaches the steel"
        text += f"; most is lost {_LOST.get(name) or in_passage(name)}, {percent(share)}" if share > 0.005 else ""
        empty = f" The pressure of the chamber {self.cavitates[0]} falls to that of a vacuum: it cavitates." \
            if self.cavitates else ""  # fmt: skip
        return f"{text}.{empty}"


_ATMOSPHERE = 101325.0  # Pa
_LOST = {
    "leakage": "by leakage", "relief": "through the relief valve", "return_line": "in the line to the tank",
    "drag": "by drag", "impact": "in the blow",
}  # fmt: skip


def in_passage(name: str) -> str:
    """Where the loss of an orifice is."""
    return f"in the passages of the {name.removeprefix('orifice_')} chamber"


def _shares_text(one: OilReport, _: Teller) -> str:
    told = {"impact": "into the steel", **{name: text for name, text in _LOST.items() if name != "impact"}}
    found = sorted(one.shares.items(), key=lambda pair: -pair[1])
    return ", ".join(f"{percent(share)} {told.get(name) or in_passage(name)}" for name, share in found if share >= 5e-4)


def _chambers_text(one: OilReport, tell: Teller) -> str | None:
    return "; ".join(f"{c.chamber} {_press(tell, c.least)} to {_press(tell, c.greatest)}" for c in one.chambers) or None


def _press(tell: Teller, value: float) -> str:
    return f"{number(value * tell.scale('pressure') / 1e5)} bar" if tell.is_si else number(value)


def _limits_text(one: OilReport, _: Teller) -> str | None:
    relief, charge, told = relief_margin(one.cycle), precharge_margin(one.cycle), []
    if relief is not None:
        above = f"its peak is {percent(relief)} below the relief valve"
        told.append(above if relief > 0.0 else "the relief valve opens in every cycle: what it lets through is lost")
    if charge is not None:
        least = f"its least is {percent(charge)} above the precharge"
        told.append(least if charge > 0.0 else "the accumulator empties in every cycle")
    return "; ".join(told) or None


def _scaled(one: OilReport, *pressures: float) -> list[float | None]:
    scale = Teller.of(one.machine).scale("pressure")
    return [pressure * scale if math.isfinite(pressure) else None for pressure in pressures]


def _assumed_text(one: OilReport, _: Teller) -> str:
    weighty = [name for name, share in one.shares.items() if name != "impact" and share >= 0.02]
    named = [_LOST.get(name) or in_passage(name) for name in weighty]
    return (
        f"of what is assumed or measured, that {', '.join(named)} carries these figures" if named else "little is lost"
    )


OIL: tuple[Fact[OilReport], ...] = (
    Fact("efficiency", "efficiency", "delivered over input: what the blows take; never above 1", "", "efficiency",
         "{efficiency:percent} of the input is delivered to what is struck"),
    Fact("efficiency_of_the_blow", "as data sheets have it",
         "blow energy times rate over the input, which counts the energy of the rebound as well", "", "of_the_blow",
         "{of_the_blow:percent}: blow energy times rate over the input, with the energy that the rebound brings back"),
    Fact("losses", "where it goes", "parts of the input by name, which add up to 1", "", "shares", _shares_text),
    Fact("input_power si.input_power_W", "input", "of the pump, or from a constant supply", "power", "input_power",
         "{input_power:kW}, {pump_flow:l_per_min}"),
    Fact("blow_power si.blow_power_W", "blows", "blow energy times rate", "power", "blow_power", "{blow_power:kW}"),
    Fact("input_energy input_energy_J", "", "of the pump, or from a constant supply, in a cycle", "energy",
         "oil.input"),
    Fact("loss_energies", "", "what each loss takes in a cycle, by name (J)", "",
         lambda one: {name: loss * Teller.of(one.machine).scale("energy")
                      for name, loss in path_losses(one.cycle).items()}),
    Fact("energy_residual", "", "what the losses do not account for, as a part of the input", "",
         lambda one: 1.0 - math.fsum(one.shares.values())),
    Fact("pump_flow si.pump_flow_m3_s", "", "mean flow of the pump", "flow", "pump_flow"),
    Fact("pumped_volume si.pumped_volume_m3", "", "of the pump in a cycle", "volume", "oil.pumped"),
    Fact("drawn_volume si.drawn_volume_m3", "", "by the chambers in a cycle, net", "volume", "oil.drawn"),
    Fact("leaked_volume si.leaked_volume_m3", "", "by leakage in a cycle", "volume", "oil.leaked"),
    Fact("relief_volume si.relief_volume_m3", "", "through the relief valve in a cycle", "volume", "oil.relieved"),
    Fact("mean_pressure si.mean_pressure_Pa", "", "of the supply over time", "pressure", "cycle.mean_pressure"),
    Fact("pressure_min si.pressure_min_Pa", "", "of the supply", "pressure", "oil.least"),
    Fact("pressure_max si.pressure_max_Pa", "pressure", "of the supply", "pressure", "oil.greatest", _limits_text),
    Fact("pressure_at_blow si.pressure_at_blow_Pa", "", "of the supply", "pressure",
         lambda one: 1.0 if one.cycle.rebound.pressure is None else one.cycle.rebound.pressure),
    Fact("relief_margin", "", "how far the greatest pressure is below the relief valve, as a part of it; or null", "",
         lambda one: relief_margin(one.cycle)),
    Fact("precharge_margin", "", "how far the least pressure is above the precharge, as a part of it; or null", "",
         lambda one: precharge_margin(one.cycle)),
    Fact("chambers", "chambers", "least and greatest pressure of each, by name (Pa, or multiples)", "",
         lambda one: {c.chamber: [x * Teller.of(one.machine).scale("pressure") for x in c[1:]] for c in one.chambers},
         _chambers_text),
    Fact("cavitates", "", "names of the chambers whose pressure falls to that of a vacuum", "", "cavitates"),
    Fact("power_duty", "", "part of the period from the change to the power state to the one that follows", "",
         lambda one: duty_of(one.cycle)),
    Fact("checks", "checks", "numbers of the cycle, and what closed forms give: name, found, expected", "",
         lambda one: [list(check) for check in oil_checks(one.cycle)],
         lambda one, _: "; ".join(f"{check.name} to {check.off:.0e}" for check in oil_checks(one.cycle)) or None),
    Fact("lift", "lifts off",
         "the pressure that lifts the piston off the wall, the one that the supply comes to while it lies there, and "
         "what limits that; or null", "",
         lambda one: None if one.lift is None else [*_scaled(one, one.lift.needed, one.lift.reached),
                                                    one.lift.limited_by],
         lambda one, tell: None if one.lift is None else
         f"above {_press(tell, one.lift.needed)}; at rest the supply comes to {_press(tell, one.lift.reached)}, by "
         f"{one.lift.limited_by}"),
    Fact("", "rests on", "which losses carry the figures", "", "efficiency", _assumed_text),
)  # fmt: skip
"""Where the energy of oil that flows goes."""


def figures_in_si(machine: Machine, cycle: ValveCycle | None) -> dict[str, Any] | None:
    """The figures of a cycle by their keys; None without a cycle, or scales."""
    running = None if cycle is None else Running(machine, cycle)
    return si_of(running, (*CYCLE, *POWER), Teller.of(machine))


def _blank_distance(machine: Machine, cycle: ValveCycle) -> float | None:
    """How far beyond the wall a piston goes that strikes nothing, E = f x + κ x²/2, when a front port turns it back."""
    valve = machine.valve
    pull, back = max((-valve.force(name), name) for name, _ in valve.pairs)
    if not any(port.to == back and port.side == "front" for port in valve.ports):
        return None
    energy = cycle.main_energy
    reached: float = pull + (pull * pull + 2.0 * valve.chamber.stiffness * energy) ** 0.5
    return 2.0 * energy / reached if reached > 0.0 else None


# ---- How the energy and the rate of a machine that switches itself follow its pressure, ports, delays and restitution

_STEP = 0.1  # of a parameter: what a sensitivity is told for

_CURVE = tuple(round(0.5 + 0.05 * i, 2) for i in range(21))  # pressures of the curve, as multiples of that of the case


@dataclass(frozen=True)
class MachineSensitivity:
    """How energy and rate follow one parameter, such as "pressure", "flow", "restitution" or "ports[0].behind".

    Relative changes of the blow energy and the blow rate for +10 %: half the difference between +10 % and −10 %, or the
    difference to the one at which the machine runs; None when it runs at neither. `stops`: what it does at −10 % and at
    +10 % when it does not run there; None where it runs.
    """

    parameter: str
    energy: float | None
    rate: float | None
    stops: tuple[str | None, str | None]


@dataclass(frozen=True)
class AtPressure:
    """A machine at another pressure, or flow of its pump: factor, relative energy and rate; None: stopped."""

    pressure: float
    energy: float | None
    rate: float | None


def sensitivities(motion: SelfExcited) -> tuple[MachineSensitivity, ...]:
    """Those of a machine that runs, of every parameter that is not 0; with the modes of its cycle."""
    if not motion.runs:
        return ()
    return tuple(_sensitivity(motion, name, changed) for name, changed in _parameters(motion.machine))


def pressure_curve(motion: SelfExcited) -> tuple[AtPressure, ...]:
    """Energy and rate of a machine at other pressures, or flows of its pump, up to where it stops; same gas."""
    if not motion.runs:
        return ()
    below = [factor for factor in reversed(_CURVE) if factor < 1.0]
    found = {1.0: AtPressure(1.0, 0.0, 0.0)}
    for way in (below, [factor for factor in _CURVE if factor > 1.0]):
        running = True
        for factor in way:
            other = _at(motion, _under(motion.machine, factor)) if running else None
            running = other is not None and other.runs
            energy, rate = _figures(motion, other) if running and other is not None else (None, None)
            found[factor] = AtPressure(factor, energy, rate)
    return tuple(found[factor] for factor in sorted(found))


def _parameters(machine: Machine) -> Iterator[tuple[str, Callable[[float], Machine]]]:
    """The parameters that are not 0, each with the machine at a multiple of it."""
    for quantity in quantities_of(machine):
        name = "accumulator" if quantity.name == "compliance" else quantity.name
        if quantity.value:
            yield name if quantity.port is None else f"ports[{quantity.port}].{name}", partial(_multiplied, quantity)


def _multiplied(quantity: MachineQuantity, factor: float) -> Machine:
    return quantity.at(factor * quantity.value)


def _under(machine: Machine, factor: float) -> Machine:
    """The machine under a multiple of its pressure, or of its pump's flow."""
    return _multiplied(next(quantities_of(machine)), factor)


def _sensitivity(motion: SelfExcited, name: str, changed: Callable[[float], Machine]) -> MachineSensitivity:
    less, more = (_at(motion, changed(1.0 + step)) for step in (-_STEP, _STEP))
    slopes = [
        tuple(sign * change for change in _figures(motion, other))
        for other, sign in ((less, -1.0), (more, 1.0))
        if other.runs
    ]
    energy, rate = (sum(column) / len(slopes) for column in zip(*slopes, strict=True)) if slopes else (None, None)
    stops = tuple(None if other.obstacle is None else other.obstacle.words for other in (less, more))
    return MachineSensitivity(name, energy, rate, (stops[0], stops[1]))


def _at(motion: SelfExcited, machine: Machine) -> SelfExcited:
    room = motion.room if math.isfinite(motion.room) else None
    near = motion.cycle if machine.valve.flows else None
    return self_excited_motion(machine, modes=motion.modes, room=room, near=near)


def _figures(motion: SelfExcited, other: SelfExcited) -> tuple[float, float]:
    """By how much the energy and the rate of another cycle differ, relative to that of the case."""
    now, then = motion.cycle, other.cycle
    assert now is not None and then is not None
    return then.main_energy / now.main_energy - 1.0, (then.blows / then.period) / (now.blows / now.period) - 1.0


# ---- The course of a cycle of a machine that switches itself: where the bar is, and what acts on it, at any times


@dataclass(frozen=True)
class CycleCurve:
    """A cycle over time in the machine's units, each change of state twice; places behind the wall are negative."""

    times: Array
    striking_end: Array
    centre: Array
    force: Array
    states: tuple[str, ...]
    pressure: Array | None = None


def course_of(machine: Machine, cycle: ValveCycle, points: int = 800) -> CycleCurve:
    """The course of a cycle at so many times and at every change of the state."""
    changes = [switch.time for switch in cycle.switches]
    times = np.sort(np.concatenate([np.linspace(0.0, cycle.period, points), changes, changes]))
    states, at = [], cycle.switches[-1].to if cycle.switches else str(machine.valve.start)
    waiting = list(cycle.switches)
    passed = 0
    for time in times.tolist():
        while waiting and (time > waiting[0].time or (time == waiting[0].time and passed)):
            at, passed = waiting.pop(0).to, 0
        passed += bool(waiting) and time == waiting[0].time
        states.append(at)
    valve = machine.valve
    pressure = None if valve.supply is None else pressure_over(cycle, times)
    if cycle.oil is not None:
        return _oil_course(cycle, times, tuple(states), pressure)
    oil = np.array([dict(valve.pairs)[state] for state in states]) * (1.0 if pressure is None else pressure)
    force = oil + valve.chamber.force - valve.chamber.stiffness * cycle.position(times, 0.0)
    end, centre = cycle.position(times, 1.0) + 0.0, cycle.position(times, "centre") + 0.0
    return CycleCurve(times, end, centre, force, tuple(states), pressure)


def _oil_course(cycle: ValveCycle, times: Array, states: tuple[str, ...], pressure: Array | None) -> CycleCurve:
    force, which = np.empty(times.size), flights_at(cycle, np.mod(times, cycle.period))
    for number_of in np.unique(which).tolist():
        mine, flight = which == number_of, cycle.flights[number_of]
        assert isinstance(flight, OilFlight)
        force[mine] = flight.looked(np.mod(times[mine], cycle.period) - flight.time)[2]
    end, centre = cycle.position(times, 1.0) + 0.0, cycle.position(times, "centre") + 0.0
    return CycleCurve(times, end, centre, force, states, pressure)


def course_from_start(motion: Trajectory, blows: int, points: int = 800) -> CycleCurve:
    """The course of a simulated motion up to so many blows, or to its end; changes of the state stand there twice."""
    struck = motion.blow_times
    end = float(struck[blows - 1]) if 0 < blows <= struck.size else motion.end_time
    changes = motion.events.of("valve").time
    changes = changes[changes <= end]
    even = np.linspace(motion.begin_time, end, points)
    before = np.maximum(np.nextafter(changes, -np.inf), motion.begin_time)
    times = np.sort(np.concatenate([even, before, changes, struck[struck <= end]]))
    names = [name for name, _ in motion.machine.valve.pairs]
    states = tuple(names[number] for number in motion.state(times).tolist())
    begun = times - motion.begin_time
    return CycleCurve(begun, motion.gap(times) + 0.0, motion.centre(times) + 0.0, motion.force(times), states)


def cycle_table(machine: Machine, cycle: ValveCycle) -> str:
    """The course as a table in CSV: in SI where the machine has scales."""
    course, scale = course_of(machine, cycle), Teller.of(machine).scale
    units = ("_s", "_m", "_m", "_N") if machine.is_si else ("",) * 4
    heads = [name + unit for name, unit in zip(("time", "striking_end", "centre", "force"), units, strict=True)]
    places = (scale("length") * course.striking_end, scale("length") * course.centre)
    columns = [scale("time") * course.times, *places, scale("force") * course.force]
    if course.pressure is not None:
        heads.append("pressure_Pa" if machine.pressure is not None else "pressure")
        columns.append(course.pressure * (1.0 if machine.pressure is None else machine.pressure))
    rows = zip(*(column.tolist() for column in columns), course.states, strict=True)
    return table_text([*heads, "state"], rows)


# ---- What a machine does that finds no tool, with the cushion that was assumed where the case describes none

_ASSUMPTION = (
    "the case describes none; assumed is one that begins at the place of the blow, pushes with a constant force, stops "
    "the piston within 20 mm and gives nothing back"
)
_ASSUMED = 0.02  # m: in which the cushion stops the piston that a case without one is told with


@dataclass(frozen=True)
class BlankBlowReport(ShortRepr):
    """What a machine does that finds no tool, from its rigid piston; in the cushion of its case, or an assumed one."""

    machine: Machine
    found: BlankBlow
    assumed: bool

    @property
    def peak_pressure(self) -> float | None:
        """Of the oil in the cushion (Pa), at first; None without the area on which it presses."""
        return self.pressure(self.found.peak_force)

    def pressure(self, force: float) -> float | None:
        """Of the oil in the cushion (Pa) under a force."""
        cushion = self.found.cushion
        if cushion is None or cushion.area is None or not self.machine.is_si:
            return None
        return force * self.machine.force_scale / cushion.area

    @property
    def rows(self) -> tuple[tuple[str, str], ...]:
        """What a report tells."""
        return tuple(rows_of(self, BLANK, Teller.of(self.machine)))

    def to_json_dict(self) -> dict[str, Any]:
        """In plain values, dimensionless, and in SI under `si`."""
        return json_of(self, BLANK, Teller.of(self.machine))


def _cushioned(one: BlankBlowReport) -> bool:
    return 0.0 < one.found.depth < math.inf


def _depth(one: BlankBlowReport, tell: Teller) -> str | None:
    if not _cushioned(one):
        return None
    beyond = one.found.cushion is not None and bool(one.found.cushion.beyond)
    reach = f", {tell(one.found.reach, 'length')} beyond the place of the blow" if beyond else ""
    return f"{tell(one.found.depth, 'length')} into the cushion{reach}"


def _pressed(one: BlankBlowReport, tell: Teller, force: float) -> str:
    pressure = one.pressure(force)
    return tell(force, "force") + ("" if pressure is None else f", {number(pressure / 1e5)} bar")


def _worst(one: BlankBlowReport, tell: Teller) -> str | None:
    found = one.found
    if not (found.worst_pass > 1 and found.worst_depth > 0.0):
        return None
    deep = f"{tell(found.worst_depth, 'length')} into the cushion"
    return f"number {found.worst_pass}: {deep}, {_pressed(one, tell, found.worst_force)}"


def _mean_pressure(one: BlankBlowReport, _: Teller) -> str | None:
    if one.machine.valve.supply is None:
        return None
    pressure, unit = one.found.pressure, one.machine.pressure
    under = number(pressure) if unit is None else f"{number(pressure * unit / 1e5)} bar"
    return f"{under}, the mean of the cycle"


def _then(one: BlankBlowReport, tell: Teller) -> str:
    found = one.found
    if found.ending == "strikes the front end":
        return f"it strikes the front end of the housing with {tell(found.front_speed, 'speed')}"
    if found.ending == "leaves":
        return "nothing holds the piston back: the cushion pushes less than the valve"
    if found.period is not None and found.again is not None:
        again, period = tell(found.again, "speed"), tell(found.period, "time")
        return f"the machine goes on without blows: the piston comes again every {period}, with {again}"
    if found.ending == "goes on":
        return f"the machine goes on without blows, and has not repeated itself after {found.passes} passes"
    where = "in the cushion" if found.ending == "stops in the cushion" else "where it reaches no port"
    after = "at once" if found.passes == 1 else f"after {found.passes} passes"
    return f"the machine stops {after}: the piston stays {where}"


def _cushion(one: BlankBlowReport) -> dict[str, float | None] | None:
    names, cushion = ("beyond", "force", "stiffness", "length", "returned", "area"), one.found.cushion
    return None if cushion is None else {name: json_number(getattr(cushion, name)) for name in names}


BLANK: tuple[Fact[BlankBlowReport], ...] = (
    Fact("cushion", "cushion", "null, or that of the case, see below", "", _cushion,
         lambda one, _: _ASSUMPTION if one.assumed else None),
    Fact("assumed", "", "whether the case describes none, and this one was assumed: it begins at the place "
         "of the blow and stops the piston within 20 mm", "", "assumed"),
    Fact("ending", "",
         '`"stops in the cushion"`, `"stops"` (where no port is reached), `"strikes the front end"`, `"leaves"` '
         '(nothing holds it back), `"cycles without a blow"`, `"goes on"` (without repeating)', "",
         "found.ending"),
    Fact("passes", "", "of the place of the blow, until it stops or repeats", "", "found.passes"),
    Fact("speed", "speed", "past the place of the blow, at first", "speed", "found.speed",
         lambda one, tell: f"{tell(one.found.speed, 'speed')} past the place of the blow, with "
         f"{tell(one.found.energy, 'energy')}"),
    Fact("energy_J", "", "brought to the place of the blow", "energy", "found.energy"),
    Fact("reach reach_m", "", "how far it goes beyond the wall, at first", "length", "found.reach"),
    Fact("depth depth_m", "depth", "how far it goes into the cushion, at first", "length",
         "found.depth", _depth),
    Fact("peak_force peak_force_N", "peak force", "the greatest force of the cushion, at first", "force",
         "found.peak_force",
         lambda one, tell: _pressed(one, tell, one.found.peak_force) if _cushioned(one) else None),
    Fact("si.peak_pressure_Pa", "", "of the oil in the cushion at this force; null without its area", "",
         "peak_pressure"),
    Fact("taken taken_J", "taken", "the energy that the cushion keeps, at first", "energy", "found.taken",
         lambda one, tell: f"{tell(one.found.taken, 'energy')} by the cushion in the first pass"
         if _cushioned(one) else None),
    Fact("worst_pass", "worst pass", "the pass, from 1 on, in which it goes deepest into the cushion", "",
         "found.worst_pass", _worst),
    Fact("worst_depth worst_depth_m", "", "how deep it then goes", "length", "found.worst_depth"),
    Fact("worst_force worst_force_N", "", "the greatest force there", "force", "found.worst_force"),
    Fact("si.worst_pressure_Pa", "", "of the oil in the cushion at this force", "",
         lambda one: one.pressure(one.found.worst_force)),
    Fact("pressure", "pressure",
         "with a pump the mean pressure of the cycle, under which this is told, as a multiple of that of "
         "the forces; else 1", "", "found.pressure", _mean_pressure),
    Fact("front_speed front_speed_m_s", "then", "at which it strikes the front end, or 0", "speed",
         "found.front_speed", _then),
    Fact("period period_s", "", "of a machine that cycles without a blow: the time between passes; else null", "time",
         "found.period"),
    Fact("again again_m_s", "", "likewise the speed of a pass", "speed", "found.again"),
)  # fmt: skip
"""What a blank blow is."""


def blank_blow_report(rigid: SelfExcited) -> BlankBlowReport | None:
    """The blank blow of a machine; None without a cycle, or with neither a cushion nor sizes to assume one by."""
    machine, cycle = rigid.machine, rigid.cycle
    if cycle is None or cycle.modes or cycle.oil is not None:
        return None
    if machine.valve.cushion is not None:
        return BlankBlowReport(machine, blank_blow(rigid), False)
    if not machine.is_si:
        return None
    depth = _ASSUMED / machine.length_scale
    valve = machine.valve if machine.valve.supply is None else machine.valve.at_pressure(slow_pressure(cycle).mean)
    pushed = max(0.0, *(valve.force(name) for name, _ in valve.pairs))
    assumed = Cushion(force=cycle.main_energy / depth + pushed)
    return BlankBlowReport(machine, blank_blow(rigid, cushion=assumed), True)
