"""What the cycle of a machine that switches itself means in SI."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from percuss.case.answers.numerals import json_number as json_values_number
from percuss.case.answers.numerals import number, quantity
from percuss.case.answers.numerals import number as spelled
from percuss.model import Cushion
from percuss.shown import Shown
from percuss.steady import blank_blow, self_excited_motion, slow_pressure
from percuss.steady.self_excited import RigidCycle, pressure_over

if TYPE_CHECKING:
    from percuss.model import Machine
    from percuss.model.checks import Array
    from percuss.simulate import Trajectory
    from percuss.steady import BlankBlow
    from percuss.steady.self_excited import SelfExcited, ValveCycle


@dataclass(frozen=True)
class MachineFigures:
    """A cycle in SI; with several blows in it, energy and speed are those of the strongest.

    Attributes
    ----------
    delivered_energy_J
        What the blows of a cycle take from the bar, for the tool and what it strikes.
    input_power_kW
        What the valve puts in: pressure times oil flow.
    delivered_power_kW
        The part of it that the blows take; damping, drag and lying down take the rest.
    efficiency
        Delivered over input power; the energy of the rebound comes back and is in neither. None without an input.
    oil_per_cycle_cm3, oil_flow_l_per_min
        From the supply, without leakage; None when its pressure is not known.
    blank_energy_J, blank_distance_m
        When the tool is not there: what the piston brings to where the blow would be, and how far the force that then
        acts would let it go; None when nothing stops it.
    contact_time_us
        How long a uniform bar of this length is in contact, one round trip of its waves; the model lets the blow take
        no time.
    """

    blow_energy_J: float
    impact_velocity_m_s: float
    blow_rate_Hz: float
    blow_rate_per_min: float
    stroke_m: float
    delivered_energy_J: float
    input_power_kW: float
    delivered_power_kW: float
    efficiency: float | None
    oil_per_cycle_cm3: float | None
    oil_flow_l_per_min: float | None
    blank_energy_J: float
    blank_distance_m: float | None
    contact_time_us: float


def machine_figures(machine: Machine, cycle: ValveCycle) -> MachineFigures:
    """The figures of a cycle of a machine in SI.

    Raises
    ------
    ParameterError
        When the machine is dimensionless.
    """
    energy, period = machine.energy_scale, cycle.period * machine.time_scale
    rate, work, taken = cycle.blows / period, cycle.work * energy, cycle.taken * energy
    oil = None if machine.pressure is None else cycle.drawn * energy / machine.pressure
    distance = _blank_distance(machine, cycle)
    assert machine.bar is not None
    return MachineFigures(
        blow_energy_J=cycle.blow_energy * energy,
        impact_velocity_m_s=cycle.blow_speed * machine.speed_scale,
        blow_rate_Hz=rate,
        blow_rate_per_min=60.0 * rate,
        stroke_m=cycle.stroke * machine.length_scale,
        delivered_energy_J=taken,
        input_power_kW=work / period / 1e3,
        delivered_power_kW=taken / period / 1e3,
        efficiency=taken / work if work > 0.0 else None,
        oil_per_cycle_cm3=None if oil is None else 1e6 * oil,
        oil_flow_l_per_min=None if oil is None else 6e4 * oil / period,
        blank_energy_J=cycle.blow_energy * energy,
        blank_distance_m=None if distance is None else distance * machine.length_scale,
        contact_time_us=1e6 * machine.bar.contact_duration,
    )


def _blank_distance(machine: Machine, cycle: ValveCycle) -> float | None:
    """How far beyond the wall a piston goes that strikes nothing, E = f x + κ x²/2, when a front port turns it back."""
    valve = machine.valve
    pull, back = max((-valve.force(name), name) for name, _ in valve.pairs)
    if not any(port.to == back and port.side == "front" for port in valve.ports):
        return None
    energy = cycle.blow_energy
    reached: float = pull + (pull * pull + 2.0 * valve.chamber.stiffness * energy) ** 0.5
    return 2.0 * energy / reached if reached > 0.0 else None


# ---- Numbers of a machine that switches itself, in its unit of length and time, told with units


def in_units(machine: Machine, value: float, kind: str) -> str:
    """A dimensionless value with its unit, where the machine has scales: a "length", "time", "force", "speed" or ""."""
    if not machine.is_si or not kind:
        return number(value)
    units = {"length": "m", "time": "s", "force": "N", "speed": "m/s"}
    scale: float = getattr(machine, f"{kind}_scale")
    return f"{number(value * scale)} m/s" if kind == "speed" else quantity(value * scale, units[kind])


# ---- How the energy and the rate of a machine that switches itself follow its pressure, ports, delays and restitution

_STEP = 0.1
"""Of a parameter: what a sensitivity is told for."""

_CURVE = tuple(round(0.5 + 0.05 * i, 2) for i in range(21))
"""Pressures of the curve, as multiples of that of the case."""


@dataclass(frozen=True)
class Sensitivity:
    """How energy and rate follow one parameter.

    Attributes
    ----------
    parameter
        "pressure", or "flow" and "accumulator" of a supply, "restitution", or a key of a port such as
        "ports[0].behind".
    energy, rate
        Relative change of the blow energy and of the blow rate for +10 % of the parameter: half the difference between
        +10 % and −10 %, or the difference to the one at which the machine runs; None when it runs at neither.
    stops
        What the machine does at −10 % and at +10 % when it does not run there, in words; None where it runs.
    """

    parameter: str
    energy: float | None
    rate: float | None
    stops: tuple[str | None, str | None]


@dataclass(frozen=True)
class Running:
    """A machine at another pressure: the factor, and relative to the case the blow energy and rate; None: stopped.

    With a supply the factor is that of the flow of its pump.
    """

    pressure: float
    energy: float | None
    rate: float | None


def sensitivities(motion: SelfExcited) -> tuple[Sensitivity, ...]:
    """Those of a machine that runs, of every parameter that is not 0; with the modes of its cycle."""
    if not motion.runs:
        return ()
    return tuple(_sensitivity(motion, name, changed) for name, changed in _parameters(motion.machine))


def pressure_curve(motion: SelfExcited) -> tuple[Running, ...]:
    """Energy and rate of a machine that runs at other pressures, up to where it stops, the gas being the same.

    With a supply, at other flows of the pump.
    """
    if not motion.runs:
        return ()
    below = [factor for factor in reversed(_CURVE) if factor < 1.0]
    found = {1.0: Running(1.0, 0.0, 0.0)}
    for way in (below, [factor for factor in _CURVE if factor > 1.0]):
        running = True
        for factor in way:
            other = _at(motion, _under(motion.machine, factor)) if running else None
            running = other is not None and other.runs
            energy, rate = _figures(motion, other) if running and other is not None else (None, None)
            found[factor] = Running(factor, energy, rate)
    return tuple(found[factor] for factor in sorted(found))


def _parameters(machine: Machine) -> Iterator[tuple[str, Callable[[float], Machine]]]:
    """The parameters, each with the machine at a multiple of it."""
    if machine.valve.supply is None:
        yield "pressure", partial(_under, machine)
    else:
        yield "flow", partial(_fed, machine, "flow")
        yield "accumulator", partial(_fed, machine, "compliance")
    for i, port in enumerate(machine.valve.ports):
        for key in ("behind", "delay"):
            if getattr(port, key):
                yield f"ports[{i}].{key}", partial(_with_port, machine, i, key)
    if machine.contact.rebounds:
        yield "restitution", partial(_rebounding, machine)


def _rebounding(machine: Machine, factor: float) -> Machine:
    """The machine with a multiple of its restitution, 1 at most."""
    contact = machine.contact
    return replace(machine, contact=contact.with_restitution(min(_times(contact.restitution, factor), 1.0)))


def _times(value: float, factor: float) -> float:
    return factor * value


def _under(machine: Machine, factor: float) -> Machine:
    """The machine under a multiple of its pressure, or of its pump's flow."""
    if machine.valve.supply is not None:
        return _fed(machine, "flow", factor)
    states = tuple((name, factor * force) for name, force in machine.valve.pairs)
    return machine.with_valve(replace(machine.valve, states=states))


def _fed(machine: Machine, name: str, factor: float) -> Machine:
    supply = machine.valve.supply
    assert supply is not None
    changed: dict[str, float] = {name: factor * getattr(supply, name)}
    return machine.with_valve(replace(machine.valve, supply=replace(supply, **changed)))


def _with_port(machine: Machine, number: int, key: str, factor: float) -> Machine:
    ports = list(machine.valve.ports)
    ports[number] = replace(ports[number], **{key: factor * getattr(ports[number], key)})
    return machine.with_valve(replace(machine.valve, ports=tuple(ports)))


def _sensitivity(motion: SelfExcited, name: str, changed: Callable[[float], Machine]) -> Sensitivity:
    less, more = (_at(motion, changed(1.0 + step)) for step in (-_STEP, _STEP))
    slopes = [
        tuple(sign * change for change in _figures(motion, other))
        for other, sign in ((less, -1.0), (more, 1.0))
        if other.runs
    ]
    energy, rate = (sum(column) / len(slopes) for column in zip(*slopes, strict=True)) if slopes else (None, None)
    stops = tuple(None if other.obstacle is None else other.obstacle.words for other in (less, more))
    return Sensitivity(name, energy, rate, (stops[0], stops[1]))


def _at(motion: SelfExcited, machine: Machine) -> SelfExcited:
    room = motion.room if math.isfinite(motion.room) else None
    return self_excited_motion(machine, modes=motion.modes, room=room)


def _figures(motion: SelfExcited, other: SelfExcited) -> tuple[float, float]:
    """By how much the energy and the rate of another cycle differ, relative to that of the case."""
    now, then = motion.cycle, other.cycle
    assert now is not None and then is not None
    return then.blow_energy / now.blow_energy - 1.0, (then.blows / then.period) / (now.blows / now.period) - 1.0


# ---- The course of a cycle of a machine that switches itself: where the bar is, and what acts on it, at any times


@dataclass(frozen=True)
class Course:
    """A cycle over time, in the units of the machine.

    Attributes
    ----------
    times
        Increasing, from 0 to the period; each change of the state stands there twice.
    striking_end, centre
        Displacement, 0 at the wall and negative behind it.
    force
        On the bar, with that of the chamber, positive toward the wall.
    states
        The state of the valve at each time.
    pressure
        Of a supply that follows the piston, as a multiple of the one for which the forces of the states hold; None
        where it is constant.
    """

    times: Array
    striking_end: Array
    centre: Array
    force: Array
    states: tuple[str, ...]
    pressure: Array | None = None


def course_of(machine: Machine, cycle: ValveCycle, points: int = 800) -> Course:
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
    pressure = pressure_over(cycle, times) if valve.supply is not None and isinstance(cycle, RigidCycle) else None
    oil = np.array([dict(valve.pairs)[state] for state in states]) * (1.0 if pressure is None else pressure)
    force = oil + valve.chamber.force - valve.chamber.stiffness * cycle.position(times, 0.0)
    end, centre = cycle.position(times, 1.0) + 0.0, cycle.position(times, "centre") + 0.0
    return Course(times, end, centre, force, tuple(states), pressure)


def course_from_start(motion: Trajectory, blows: int, points: int = 800) -> Course:
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
    return Course(begun, motion.gap(times) + 0.0, motion.centre(times) + 0.0, motion.force(times), states)


def cycle_table(machine: Machine, cycle: ValveCycle) -> str:
    """The course as a table in CSV: in SI where the machine has scales."""
    course, names = course_of(machine, cycle), ("times", "striking_end", "centre", "force")
    units, scales = ("",) * 4, (1.0,) * 4
    if machine.is_si:
        units = ("_s", "_m", "_m", "_N")
        scales = (machine.time_scale, machine.length_scale, machine.length_scale, machine.force_scale)
    heads = [name.removesuffix("s") + unit for name, unit in zip(names, units, strict=True)]
    columns = [scale * getattr(course, name) for name, scale in zip(names, scales, strict=True)]
    if course.pressure is not None:
        heads.append("pressure_Pa" if machine.pressure is not None else "pressure")
        columns.append(course.pressure * (1.0 if machine.pressure is None else machine.pressure))
    rows = zip(*(column.tolist() for column in columns), course.states, strict=True)
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow([*heads, "state"])
    writer.writerows(rows)
    return text.getvalue()


# ---- What a machine does that finds no tool, with the cushion that was assumed where the case describes none

_ASSUMPTION = (
    "the case describes none; assumed is one that begins at the place of the blow, pushes with a constant force, stops "
    "the piston within 20 mm and gives nothing back"
)
_ASSUMED = 0.02  # m: in which the cushion stops the piston that a case without one is told with


@dataclass(frozen=True)
class ToldBlank(Shown):
    """What a machine does that finds no tool.

    Attributes
    ----------
    machine
        The machine.
    found
        The blank blow of its rigid piston.
    assumed
        Whether the cushion is one that was assumed.
    """

    machine: Machine
    found: BlankBlow
    assumed: bool

    @property
    def peak_pressure(self) -> float | None:
        """Of the oil in the cushion (Pa), at first; None without the area on which it presses."""
        return self._pressure(self.found.peak_force)

    def _pressure(self, force: float) -> float | None:
        cushion = self.found.cushion
        if cushion is None or cushion.area is None or not self.machine.is_si:
            return None
        return force * self.machine.force_scale / cushion.area

    @property
    def rows(self) -> tuple[tuple[str, str], ...]:
        """What a report tells."""
        found, machine = self.found, self.machine
        rows = []
        if self.assumed:
            rows.append(("cushion", _ASSUMPTION))
        rows.append(("speed", f"{in_units(machine, found.speed, 'speed')} past the place of the blow{self._brought}"))
        if 0.0 < found.depth < math.inf:
            where = "" if found.cushion is None or not found.cushion.beyond else self._reach
            rows.append(("depth", f"{in_units(machine, found.depth, 'length')} into the cushion{where}"))
            rows.append(("peak force", self._force(found.peak_force)))
            rows.append(("taken", f"{self._energy(found.taken)} by the cushion in the first pass"))
        if found.worst_pass > 1 and found.worst_depth > 0.0:
            deep = f"{in_units(machine, found.worst_depth, 'length')} into the cushion"
            rows.append(("worst pass", f"number {found.worst_pass}: {deep}, {self._force(found.worst_force)}"))
        if machine.valve.supply is not None:
            under = (
                spelled(found.pressure) if machine.pressure is None else self._bar(found.pressure * machine.pressure)
            )
            rows.append(("pressure", f"{under}, the mean of the cycle"))
        rows.append(("then", self._then))
        return tuple(rows)

    @property
    def _brought(self) -> str:
        return f", with {self._energy(self.found.energy)}"

    @property
    def _reach(self) -> str:
        return f", {in_units(self.machine, self.found.reach, 'length')} beyond the place of the blow"

    def _force(self, force: float) -> str:
        pressure = self._pressure(force)
        return in_units(self.machine, force, "force") + ("" if pressure is None else f", {self._bar(pressure)}")

    def _bar(self, pressure: float) -> str:
        return f"{spelled(pressure / 1e5)} bar"

    def _energy(self, value: float) -> str:
        return quantity(value * self.machine.energy_scale, "J") if self.machine.is_si else spelled(value)

    @property
    def _then(self) -> str:
        found, machine = self.found, self.machine
        if found.ending == "strikes the front end":
            return f"it strikes the front end of the housing with {in_units(machine, found.front_speed, 'speed')}"
        if found.ending == "leaves":
            return "nothing holds the piston back: the cushion pushes less than the valve"
        if found.period is not None and found.again is not None:
            again, period = in_units(machine, found.again, "speed"), in_units(machine, found.period, "time")
            return f"the machine goes on without blows: the piston comes again every {period}, with {again}"
        if found.ending == "goes on":
            return f"the machine goes on without blows, and has not repeated itself after {found.passes} passes"
        where = "in the cushion" if found.ending == "stops in the cushion" else "where it reaches no port"
        after = "at once" if found.passes == 1 else f"after {found.passes} passes"
        return f"the machine stops {after}: the piston stays {where}"

    def to_json_dict(self) -> dict[str, Any]:
        """In plain values, dimensionless, and in SI under `si`."""
        found, machine = self.found, self.machine
        told: dict[str, Any] = {
            "cushion": _cushion(found.cushion),
            "assumed": self.assumed,
            "ending": found.ending,
            "passes": found.passes,
            "speed": json_values_number(found.speed),
            "reach": json_values_number(found.reach),
            "depth": json_values_number(found.depth),
            "peak_force": json_values_number(found.peak_force),
            "taken": json_values_number(found.taken),
            "worst_pass": found.worst_pass,
            "worst_depth": json_values_number(found.worst_depth),
            "worst_force": json_values_number(found.worst_force),
            "pressure": json_values_number(found.pressure),
            "front_speed": json_values_number(found.front_speed),
            "period": json_values_number(found.period),
            "again": json_values_number(found.again),
            "si": None,
        }
        if machine.is_si:
            told["si"] = {
                "energy_J": json_values_number(found.energy * machine.energy_scale),
                "depth_m": json_values_number(found.depth * machine.length_scale),
                "reach_m": json_values_number(found.reach * machine.length_scale),
                "peak_force_N": json_values_number(found.peak_force * machine.force_scale),
                "peak_pressure_Pa": json_values_number(self.peak_pressure),
                "worst_depth_m": json_values_number(found.worst_depth * machine.length_scale),
                "worst_force_N": json_values_number(found.worst_force * machine.force_scale),
                "worst_pressure_Pa": json_values_number(self._pressure(found.worst_force)),
                "taken_J": json_values_number(found.taken * machine.energy_scale),
                "front_speed_m_s": json_values_number(found.front_speed * machine.speed_scale),
                "period_s": None if found.period is None else json_values_number(found.period * machine.time_scale),
                "again_m_s": None if found.again is None else json_values_number(found.again * machine.speed_scale),
            }
        return told


def told_blank(rigid: SelfExcited) -> ToldBlank | None:
    """The blank blow of a machine; None without a cycle, or with neither a cushion nor sizes to assume one by."""
    machine, cycle = rigid.machine, rigid.cycle
    if not isinstance(cycle, RigidCycle):
        return None
    if machine.valve.cushion is not None:
        return ToldBlank(machine, blank_blow(rigid), False)
    if not machine.is_si:
        return None
    depth = _ASSUMED / machine.length_scale
    valve = machine.valve if machine.valve.supply is None else machine.valve.at_pressure(slow_pressure(cycle).mean)
    pushed = max(0.0, *(valve.force(name) for name, _ in valve.pairs))
    assumed = Cushion(force=cycle.blow_energy / depth + pushed)
    return ToldBlank(machine, blank_blow(rigid, cushion=assumed), True)


def _cushion(cushion: Cushion | None) -> dict[str, float | None] | None:
    names = ("beyond", "force", "stiffness", "length", "returned", "area")
    return None if cushion is None else {name: json_values_number(getattr(cushion, name)) for name in names}
