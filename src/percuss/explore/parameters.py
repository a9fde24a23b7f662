"""The table of parameters: every dimensionless number of a system that maps, curves and sliders may vary."""

from __future__ import annotations

import cmath
import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from typing import Any, TypeVar, cast

from percuss.errors import ParameterError
from percuss.model import Chamber, Load, Machine, Supply, System
from percuss.model.body import BODIES, DAMPINGS, Body
from percuss.model.checks import finite, instance, mapping
from percuss.model.parameter import Parameter

# ---- Parameters that a load has one of for each harmonic or step: amplitude2, phase2, step1, break2 …

_NAME = re.compile(r"(amplitude|phase|step|break)([1-9]\d{0,3})", re.ASCII)

LOAD_PARAMETERS = {
    "amplitude": "amplitude of harmonic K of the load",
    "phase": "phase of harmonic K of the load in rad: it is amplitude·cos(Kt + phase)",
    "step": "value of the load's step K, counted from phase 0 on",
    "break": "phase in rad at which the load's step K begins",
}
"""What they are, by the word before the number K."""

_LABELS = {"amplitude": "amplitude |p{0}|", "phase": "phase of harmonic {0}", "step": "step {0}", "break": "break {0}"}


def load_parameter(name: str, turn: int) -> Parameter[System] | None:
    """The parameter of a harmonic or of a step; None for a name that is none of them.

    Parameters
    ----------
    name
        A word and a number.
    turn
        See `percuss.model.parameter.Parameter`.
    """
    found = _NAME.fullmatch(name)
    if found is None:
        return None
    word, number = found[1], int(found[2])
    has, value, changed, needed = _OF[word]

    def get(system: System) -> float | None:
        return value(system.load, number) if has(system.load, number) else None

    def check(system: System) -> None:
        if not has(system.load, number):
            raise ParameterError(name, str(system.load), f"a load of {needed}, {number} or more")

    def put(system: System, new: float) -> System:
        check(system)
        return replace(system, load=changed(system.load, number, new))

    meaning = LOAD_PARAMETERS[word].replace("K", str(number))
    return Parameter(name, _LABELS[word].format(number), meaning, get, put, check, turn=turn)


def _has_harmonic(load: Load, number: int) -> bool:
    return not load.is_piecewise and number < load.coefficients.size


def _has_phase(load: Load, number: int) -> bool:
    return _has_harmonic(load, number) and load.coefficients[number] != 0.0


def _has_step(load: Load, number: int) -> bool:
    return number <= len(load.values)


def _harmonic_amplitude(load: Load, number: int) -> float:
    return abs(complex(load.coefficients[number]))


def _with_harmonic_amplitude(load: Load, number: int, value: float) -> Load:
    """An amplitude below 0 is that of the opposite phase, so that a branch goes through 0."""
    one = complex(load.coefficients[number])
    return _with_harmonic(load, number, value * (one / abs(one) if one else 1.0))


def _phase(load: Load, number: int) -> float:
    return cmath.phase(complex(load.coefficients[number]))


def _with_phase(load: Load, number: int, value: float) -> Load:
    return _with_harmonic(load, number, cmath.rect(_harmonic_amplitude(load, number), value))


def _with_harmonic(load: Load, number: int, value: complex) -> Load:
    coefficients = load.coefficients.copy()
    coefficients[number] = value
    return replace(load, coefficients=coefficients)


def _step(load: Load, number: int) -> float:
    return float(load.values[number - 1])


def _with_step(load: Load, number: int, value: float) -> Load:
    values = (*load.values[: number - 1], value, *load.values[number:])
    return _with_steps(load, load.breaks, values)


def _break(load: Load, number: int) -> float:
    return float(load.breaks[number - 1])


def _with_break(load: Load, number: int, value: float) -> Load:
    """A break stays between its neighbours."""
    low, high = (0.0, *load.breaks)[number - 1], (*load.breaks, 2.0 * math.pi)[number]
    if not low <= value < high or (number > 1 and value == low):
        raise ParameterError(f"break{number}", value, f"a phase between {low:.9g} and {high:.9g}")
    return _with_steps(load, (*load.breaks[: number - 1], value, *load.breaks[number:]), load.values)


def _with_steps(load: Load, breaks: Sequence[float], values: Sequence[float]) -> Load:
    made = Load.steps(breaks, values, load.coefficients.size - 1, frequency=load.frequency)
    return replace(made, at=load.at)


_OF = {
    "amplitude": (_has_harmonic, _harmonic_amplitude, _with_harmonic_amplitude, "harmonics"),
    "phase": (_has_phase, _phase, _with_phase, "harmonics"),
    "step": (_has_step, _step, _with_step, "steps"),
    "break": (_has_step, _break, _with_break, "steps"),
}


# ---- The table of parameters: every dimensionless number of a system that maps, curves and sliders may vary

PERIODS = "m"
"""The axis of the load periods per impact: a parameter of the question, not of the system."""


# -- of the load ------------------------------------------------------------------------------------------------------


def _alternates(system: System) -> None:
    if system.load.is_constant:
        raise ParameterError("load", str(system.load), "a load with an alternating part")


def _first(system: System) -> float:
    """Amplitude of the first harmonic of the load."""
    return abs(complex(system.load.coefficients[system.load.harmonics[0]]))


def _load_factor(system: System) -> float | None:
    return None if system.load.is_constant else system.load.load_factor


def _amplitude(system: System) -> float | None:
    return None if system.load.is_constant else _first(system)


def _with_amplitude(system: System, amplitude: float) -> System:
    """The alternating part scaled so that its first harmonic has this amplitude."""
    _alternates(system)
    load = system.load
    return replace(system, load=load.with_mean(0.0).scaled(amplitude / _first(system)).with_mean(load.mean))


def _with_mean(system: System, mean: float) -> System:
    return replace(system, load=system.load.with_mean(mean))


def _is_square(system: System) -> None:
    values = system.load.values
    if len(values) != 2 or values[0] != -values[1] or system.load.breaks[0] != 0.0:
        raise ParameterError("kappa", str(system.load), "a square load, +q for 0 < t < kappa pi and −q after it")


def _kappa(system: System) -> float | None:
    return system.load.breaks[1] / math.pi if len(system.load.values) == 2 else None


def _with_kappa(system: System, kappa: float) -> System:
    _is_square(system)
    q = system.load.values[0]
    load = replace(Load.square(abs(q), kappa, system.load.coefficients.size - 1), at=system.load.at)
    return replace(system, load=load if q > 0.0 else load.scaled(-1.0))


# -- of the body and its damping --------------------------------------------------------------------------------------


Driven = TypeVar("Driven", System, Machine)
"""What has a body."""


def _with_body(driven: Driven, body: Body) -> Driven:
    """The same load and contact on a body of other numbers, without the scales to SI of the old one."""
    if isinstance(driven, Machine):
        return Machine(body, driven.valve, driven.contact, at=driven.at)
    return System(body, driven.load, driven.contact)


def _of_bodies(name: str) -> Parameter[Any]:
    """The parameter of this name that some kinds of bodies have."""
    having = {kind: own for kind, body in BODIES.items() for own in body.parameters if own.name == name}
    first = next(iter(having.values()))

    def own(system: System | Machine) -> Parameter[Any]:
        found = next((p for p in system.body.parameters if p.name == name), None)
        if found is None:
            raise ParameterError(name, f"a {system.body.kind} body", f"a body that has it: {' or '.join(having)}")
        return found

    def get(system: System | Machine) -> float | None:
        return own(system).get(system.body) if any(p.name == name for p in system.body.parameters) else None

    def put(system: Driven, value: float) -> Driven:
        return _with_body(system, own(system).put(system.body, value))

    return replace(first, get=get, put=put, check=lambda system: own(system).check(system.body), turn=_BODY)


def _of_dampings(kind: str) -> Parameter[Any]:
    """The number of a law of damping; a body without any damping takes every law."""
    law = DAMPINGS[kind]
    assert law.parameter is not None
    own: Parameter[Any] = law.parameter

    def check(system: System | Machine) -> None:
        damping = system.body.damping
        if not (isinstance(damping, law) or damping.is_zero):
            raise ParameterError(
                own.name, f"a bar with {damping}", f'a bar without damping, or with damping of the kind "{kind}"'
            )

    def get(system: System | Machine) -> float | None:
        damping = system.body.damping
        return own.get(damping) if isinstance(damping, law) else 0.0 if damping.is_zero else None

    def put(system: Driven, value: float) -> Driven:
        check(system)
        damping = system.body.damping
        changed = own.put(damping if isinstance(damping, law) else law(), value)
        return _with_body(system, replace(system.body, damping=changed))  # type: ignore[type-var]

    return replace(own, get=get, put=put, check=check, sets="damping", turn=_BODY)


_SHAPE, _SIZE, _ONE, _MEAN, _FACTOR, _CONTACT, _BODY = range(7)
"""Turns: the shape of the load before its size, both before one harmonic or step, the amplitude before the mean that is
measured by it."""


def _of_all_bodies() -> dict[str, Parameter[Any]]:
    bodies = dict.fromkeys(own.name for body in BODIES.values() for own in body.parameters)
    found = (
        *(_of_bodies(name) for name in bodies),
        *(_of_dampings(kind) for kind, law in DAMPINGS.items() if law.parameter is not None),
    )
    return {parameter.name: parameter for parameter in found}


BODY_PARAMETERS: dict[str, Parameter[Any]] = _of_all_bodies()
"""The parameters of bodies and of their damping, of a system as of a machine."""


def _table() -> dict[str, Parameter[System]]:
    found = (
        Parameter(
            "restitution", "restitution R", "coefficient of restitution R: 0, the bar does not rebound, to 1, it "
            "rebounds at full speed", lambda system: system.restitution, System.with_restitution, span=(0.0, 0.9),
            turn=_CONTACT,
        ),
        Parameter(
            "load_factor", "load factor p₀/p₁", "p_0/p_1, the mean load over the amplitude of its first harmonic",
            _load_factor, System.with_load_factor, _alternates, span=(0.02, 1.2), sets="mean", turn=_FACTOR,
        ),
        Parameter(
            "kappa", "load κ", "κ of a square load: it pushes for κπ of 2π", _kappa, _with_kappa, _is_square,
            span=(0.1, 1.9), turn=_SHAPE,
        ),
        *BODY_PARAMETERS.values(),
        Parameter("mean", "mean load p₀", "mean load p_0", lambda system: system.load.mean, _with_mean, turn=_MEAN),
        Parameter(
            "amplitude", "load amplitude p₁", "amplitude of the load's first harmonic", _amplitude, _with_amplitude,
            _alternates, turn=_SIZE,
        ),
    )  # fmt: skip
    return {parameter.name: parameter for parameter in found}


class _Table(dict[str, Parameter[System]]):
    """The parameters by name; those of one harmonic or step of the load are made when they are asked for."""

    def __missing__(self, name: str) -> Parameter[System]:
        made = load_parameter(name, _ONE)
        if made is None:
            raise KeyError(name)
        return made

    def __contains__(self, name: object) -> bool:
        return super().__contains__(name) or (isinstance(name, str) and load_parameter(name, _ONE) is not None)


PARAMETERS: dict[str, Parameter[System]] = _Table(_table())
"""The dimensionless parameters of systems; `Parameter.check` tells whether a system has one.

Besides those listed each harmonic of a load has its `amplitude2` and `phase2`, each step its `step1` and `break1`.
"""

_VALUES = "values of parameters by name, such as {'restitution': 0.5}"


def vary(system: System, values: Mapping[str, float]) -> System:
    """A system with other dimensionless parameters, whatever the order in which they are named.

    Raises
    ------
    ParameterError
        For a parameter that is unknown, out of range, or that the system does not have.
    """
    instance("system", system, System)
    unknown = [name for name in mapping("values", values, _VALUES) if name not in PARAMETERS]
    if unknown:
        told = ", ".join(f"{word}K" for word in LOAD_PARAMETERS)
        raise ParameterError("parameter", sorted(unknown)[0], f"one of {', '.join(PARAMETERS)}, {told}")
    for parameter in sorted((PARAMETERS[name] for name in values), key=lambda parameter: parameter.turn):
        system = parameter.put(system, finite(parameter.name, values[parameter.name]))
    return system


def refuse_twice(sets: Mapping[str, str]) -> None:
    """ParameterError when two parameters set the same thing, so that one of them would do nothing.

    Parameters
    ----------
    sets
        What each parameter sets, by name.
    """
    by_thing: dict[str, str] = {}
    for name, thing in sets.items():
        other = by_thing.setdefault(thing, name)
        if other != name:
            raise ParameterError(name, "on an axis", f"another parameter than {other}, which sets the same")


def label_of(name: str) -> str:
    """What stands on an axis of a parameter; the name itself when the table does not have it.

    Examples
    --------
    >>> label_of("restitution"), label_of("m"), label_of("bar.length")
    ('restitution R', 'load periods m', 'bar.length')
    """
    if name == PERIODS:
        return "load periods m"
    return PARAMETERS[name].label if name in PARAMETERS else name


# ---- The parameters of machines that switch their own valve: every number that maps may vary

PRESSURE = "pressure"
"""The parameter of all forces of the valve at once."""

_MACHINE_BODY, _VALVE, _PRESSURE = range(3)
"""Turns: a new body has no scales to SI any more, the pressure multiplies the forces as they then are."""


def machine_parameters(machine: Machine) -> dict[str, Parameter[Machine]]:
    """The dimensionless parameters of a machine, by name.

    ``pressure``, a factor on the forces of all states, or with a supply ``supply.flow`` and ``supply.compliance``;
    ``states.NAME``, the force of one; ``chamber.force`` and
    ``chamber.stiffness``; ``ports[i].behind`` and ``ports[i].delay``, counted from 0; ``restitution``; and the numbers
    of the body and its damping, such as ``s`` and ``d``.

    Examples
    --------
    >>> from percuss.model import Kept, Port, UniformBar, Valve
    >>> ports = [Port("power", behind=1.0, side="back"), Port("return", on="impact")]
    >>> machine = Machine(UniformBar(20.0), Valve({"return": -0.4, "power": 1.8}, ports), Kept(0.2))
    >>> [name for name in machine_parameters(machine) if name.startswith("ports")]
    ['ports[0].behind', 'ports[0].delay', 'ports[1].delay']
    """
    instance("machine", machine, Machine)
    entered = tuple(port.behind is not None for port in machine.valve.ports)
    return _machine_table(tuple(name for name, _ in machine.valve.pairs), entered, machine.valve.supply is not None)


def vary_machine(machine: Machine, values: Mapping[str, float]) -> Machine:
    """A machine with other dimensionless parameters, whatever the order in which they are named.

    Raises
    ------
    ParameterError
        For a parameter that is unknown, out of range, or that the machine does not have.

    Examples
    --------
    >>> from percuss.model import Kept, Port, UniformBar, Valve
    >>> ports = [Port("power", behind=1.0, side="back"), Port("return", on="impact")]
    >>> machine = Machine(UniformBar(20.0), Valve({"return": -0.4, "power": 1.8}, ports), Kept(0.2))
    >>> vary_machine(machine, {"pressure": 2.0, "ports[0].behind": 0.5}).valve.force("power")
    3.6
    """
    known = machine_parameters(machine)
    unknown = mapping("values", values, "values of parameters by name, such as {'pressure': 1.2}").keys() - known.keys()
    if unknown:
        raise ParameterError("parameter", sorted(unknown)[0], f"one of {', '.join(known)}")
    for parameter in sorted((known[name] for name in values), key=lambda parameter: parameter.turn):
        machine = parameter.put(machine, finite(parameter.name, values[parameter.name]))
    return machine


@lru_cache(maxsize=32)
def _machine_table(states: tuple[str, ...], entered: tuple[bool, ...], fed: bool) -> dict[str, Parameter[Machine]]:
    of_systems: Parameter[Any] = PARAMETERS["restitution"]
    restitution = replace(
        of_systems, get=lambda machine: machine.contact.restitution, put=_with_restitution, turn=_VALVE
    )
    found: list[Parameter[Any]] = [
        Parameter(
            PRESSURE, "pressure, as a multiple", "a factor on the forces of all states", lambda _: 1.0, _under,
            span=(0.5, 1.5), sets="load.scale", turn=_PRESSURE,
        ),
        *([_of_supply("flow", "flow of the pump"), _of_supply("compliance", "accumulator")] if fed else []),
        *(_of_state(name) for name in states),
        _of_chamber("force", "force of the chamber", "force of the gas chamber with the bar at the wall"),
        _of_chamber("stiffness", "stiffness of the chamber", "how much that force grows with the distance behind it"),
        *(_of_port(i, "behind", "place of port") for i, is_port in enumerate(entered) if is_port),
        *(_of_port(i, "delay", "delay of port") for i in range(len(entered))),
        restitution,
        *(replace(parameter, turn=_MACHINE_BODY) for parameter in BODY_PARAMETERS.values()),
    ]  # fmt: skip
    return {parameter.name: parameter for parameter in found if not (fed and parameter.name == PRESSURE)}


def _with_restitution(machine: Machine, value: float) -> Machine:
    return replace(machine, contact=machine.contact.with_restitution(value))


def _under(machine: Machine, factor: float) -> Machine:
    if not factor > 0.0:
        raise ParameterError(PRESSURE, factor, "a factor greater than 0")
    states = tuple((name, factor * force) for name, force in machine.valve.pairs)
    pressure = None if machine.pressure is None else factor * machine.pressure
    return replace(machine, valve=replace(machine.valve, states=states), pressure=pressure)


def _of_state(state: str) -> Parameter[Machine]:
    def get(machine: Machine) -> float:
        return dict(machine.valve.pairs)[state]

    def put(machine: Machine, force: float) -> Machine:
        states = tuple((name, force if name == state else own) for name, own in machine.valve.pairs)
        return machine.with_valve(replace(machine.valve, states=states))

    label = f"force, {state}"
    return Parameter(f"states.{state}", label, "force of the state without that of the chamber", get, put, turn=_VALVE)


def _of_supply(field: str, label: str) -> Parameter[Machine]:
    def get(machine: Machine) -> float | None:
        supply = machine.valve.supply
        return None if supply is None else float(getattr(supply, field))

    def put(machine: Machine, value: float) -> Machine:
        changed: dict[str, Any] = {field: value}
        supply: Supply = replace(cast("Supply", machine.valve.supply), **changed)
        return machine.with_valve(replace(machine.valve, supply=supply))

    meaning = {"flow": "power of the pump at the pressure 1", "compliance": "twice the energy stored at the pressure 1"}
    return Parameter(f"supply.{field}", label, meaning[field], get, put, turn=_VALVE)


def _of_chamber(field: str, label: str, meaning: str) -> Parameter[Machine]:
    def get(machine: Machine) -> float:
        return float(getattr(machine.valve.chamber, field))

    def put(machine: Machine, value: float) -> Machine:
        chamber: Chamber = replace(machine.valve.chamber, **{field: value})
        return machine.with_valve(replace(machine.valve, chamber=chamber))

    return Parameter(f"chamber.{field}", label, meaning, get, put, turn=_VALVE)


def _of_port(number: int, field: str, label: str) -> Parameter[Machine]:
    def get(machine: Machine) -> float | None:
        value: float | None = getattr(machine.valve.ports[number], field)
        return value

    def put(machine: Machine, value: float) -> Machine:
        ports = list(machine.valve.ports)
        changed: dict[str, Any] = {field: value}
        ports[number] = replace(ports[number], **changed)
        return machine.with_valve(replace(machine.valve, ports=tuple(ports)))

    meaning = {"behind": "distance behind the wall", "delay": "from the demand to the change of the state"}[field]
    return Parameter(f"ports[{number}].{field}", f"{label} {number}", meaning, get, put, turn=_VALVE)
