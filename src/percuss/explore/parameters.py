"""The table of parameters: every dimensionless number of a hammer that maps, curves and sliders may vary."""

from __future__ import annotations

import cmath
import math
import re
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import lru_cache
from typing import Any, TypeVar

from percuss.errors import ParameterError
from percuss.model import Load, Machine, System
from percuss.model.body import BODIES, DAMPINGS, Body
from percuss.model.checks import finite, mapping
from percuss.model.parameter import Parameter

PERIODS = "m"  # the axis of the load periods per impact: a parameter of the question, not of the hammer

AXES = ("restitution", "load_factor", PERIODS)  # what may vary where arrays answer

Driven = TypeVar("Driven", System, Machine)  # what has a body

_SHAPE, _SIZE, _ONE, _MEAN, _FACTOR, _CONTACT, _PRESSURE, _BODY = range(8)
"""Turns: the shape of the load before its size, both before one harmonic or step, the amplitude before the mean that is
measured by it; the pressure multiplies the forces as they then are."""

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


def _load_parameter(name: str) -> Parameter[System] | None:
    """The parameter of a harmonic or of a step; None for a name that is none of them."""
    found = _NAME.fullmatch(name)
    if found is None:
        return None
    word, number = found[1], int(found[2])
    has, value, changed, needed = _OF[word]

    def check(system: System) -> None:
        if not has(system.load, number):
            raise ParameterError(name, str(system.load), f"a load of {needed}, {number} or more")

    def put(system: System, new: float) -> System:
        check(system)
        return replace(system, load=changed(system.load, number, new))

    return Parameter(
        name,
        _LABELS[word].format(number),
        LOAD_PARAMETERS[word].replace("K", str(number)),
        lambda system: value(system.load, number) if has(system.load, number) else None,
        put,
        check,
        turn=_ONE,
    )


def _has_harmonic(load: Load, number: int) -> bool:
    return not load.is_piecewise and number < load.coefficients.size


def _with_harmonic(load: Load, number: int, value: complex) -> Load:
    coefficients = load.coefficients.copy()
    coefficients[number] = value
    return replace(load, coefficients=coefficients)


def _with_amplitude_of(load: Load, number: int, value: float) -> Load:
    """An amplitude below 0 is that of the opposite phase, so that a branch goes through 0."""
    one = complex(load.coefficients[number])
    return _with_harmonic(load, number, value * (one / abs(one) if one else 1.0))


def _with_step(load: Load, number: int, value: float) -> Load:
    values = (*load.values[: number - 1], value, *load.values[number:])
    return replace(Load.steps(load.breaks, values, load.coefficients.size - 1, frequency=load.frequency), at=load.at)


def _with_break(load: Load, number: int, value: float) -> Load:
    """A break stays between its neighbours."""
    low, high = (0.0, *load.breaks)[number - 1], (*load.breaks, 2.0 * math.pi)[number]
    if not low <= value < high or (number > 1 and value == low):
        raise ParameterError(f"break{number}", value, f"a phase between {low:.9g} and {high:.9g}")
    breaks = (*load.breaks[: number - 1], value, *load.breaks[number:])
    return replace(Load.steps(breaks, load.values, load.coefficients.size - 1, frequency=load.frequency), at=load.at)


_Has = Callable[[Load, int], bool]
_Get = Callable[[Load, int], float]
_Put = Callable[[Load, int, float], Load]
_OF: dict[str, tuple[_Has, _Get, _Put, str]] = {
    "amplitude": (_has_harmonic, lambda load, k: abs(complex(load.coefficients[k])), _with_amplitude_of, "harmonics"),
    "phase": (
        lambda load, k: _has_harmonic(load, k) and load.coefficients[k] != 0.0,
        lambda load, k: cmath.phase(complex(load.coefficients[k])),
        lambda load, k, phase: _with_harmonic(load, k, cmath.rect(abs(complex(load.coefficients[k])), phase)),
        "harmonics",
    ),
    "step": (lambda load, k: k <= len(load.values), lambda load, k: float(load.values[k - 1]), _with_step, "steps"),
    "break": (lambda load, k: k <= len(load.values), lambda load, k: float(load.breaks[k - 1]), _with_break, "steps"),
}


# ---- Of the load as a whole


def _alternates(system: System) -> None:
    if system.load.is_constant:
        raise ParameterError("load", str(system.load), "a load with an alternating part")


def _first(system: System) -> float:
    """Amplitude of the first harmonic of the load."""
    return abs(complex(system.load.coefficients[system.load.harmonics[0]]))


def _with_amplitude(system: System, amplitude: float) -> System:
    """The alternating part scaled so that its first harmonic has this amplitude."""
    _alternates(system)
    load = system.load
    return replace(system, load=load.with_mean(0.0).scaled(amplitude / _first(system)).with_mean(load.mean))


def _is_square(system: System) -> None:
    values = system.load.values
    if len(values) != 2 or values[0] != -values[1] or system.load.breaks[0] != 0.0:
        raise ParameterError("kappa", str(system.load), "a square load, +q for 0 < t < kappa pi and −q after it")


def _with_kappa(system: System, kappa: float) -> System:
    _is_square(system)
    q = system.load.values[0]
    load = replace(Load.square(abs(q), kappa, system.load.coefficients.size - 1), at=system.load.at)
    return replace(system, load=load if q > 0.0 else load.scaled(-1.0))


# ---- Of the body, its damping and the contact, whatever drives it


def _with_body(driven: Driven, body: Body) -> Driven:
    if isinstance(driven, Machine):
        return Machine(body, driven.valve, driven.contact, at=driven.at)
    return System(body, driven.load, driven.contact)


def _of_bodies(name: str) -> Parameter[Any]:
    """The parameter of this name that some kinds of bodies have."""
    having = {kind: own for kind, body in BODIES.items() for own in body.parameters if own.name == name}
    first = next(iter(having.values()))

    def own(driven: System | Machine) -> Parameter[Any]:
        found = next((p for p in driven.body.parameters if p.name == name), None)
        if found is None:
            raise ParameterError(name, f"a {driven.body.kind} body", f"a body that has it: {' or '.join(having)}")
        return found

    def get(driven: System | Machine) -> float | None:
        return own(driven).get(driven.body) if any(p.name == name for p in driven.body.parameters) else None

    def put(driven: Driven, value: float) -> Driven:
        return _with_body(driven, own(driven).put(driven.body, value))

    return replace(first, get=get, put=put, check=lambda driven: own(driven).check(driven.body), turn=_BODY)


def _of_dampings(kind: str) -> Parameter[Any]:
    """The number of a law of damping; a body without any damping takes every law."""
    law = DAMPINGS[kind]
    assert law.parameter is not None
    own: Parameter[Any] = law.parameter

    def check(driven: System | Machine) -> None:
        damping = driven.body.damping
        if not (isinstance(damping, law) or damping.is_zero):
            raise ParameterError(
                own.name, f"a bar with {damping}", f'a bar without damping, or with damping of the kind "{kind}"'
            )

    def get(driven: System | Machine) -> float | None:
        damping = driven.body.damping
        return own.get(damping) if isinstance(damping, law) else 0.0 if damping.is_zero else None

    def put(driven: Driven, value: float) -> Driven:
        check(driven)
        damping = driven.body.damping
        changed = own.put(damping if isinstance(damping, law) else law(), value)
        return _with_body(driven, replace(driven.body, damping=changed))  # type: ignore[type-var]

    return replace(own, get=get, put=put, check=check, sets="damping", turn=_BODY)


def _of_all_bodies() -> dict[str, Parameter[Any]]:
    bodies = dict.fromkeys(own.name for body in BODIES.values() for own in body.parameters)
    found = (
        *(_of_bodies(name) for name in bodies),
        *(_of_dampings(kind) for kind, law in DAMPINGS.items() if law.parameter is not None),
    )
    return {parameter.name: parameter for parameter in found}


_OF_ANY: dict[str, Parameter[Any]] = {
    "restitution": Parameter(
        "restitution", "restitution R", "coefficient of restitution R: 0, the bar does not rebound, to 1, it rebounds "
        "at full speed", lambda driven: driven.contact.restitution,
        lambda driven, value: replace(driven, contact=driven.contact.with_restitution(value)), span=(0.0, 0.9),
        turn=_CONTACT,
    ),
    **_of_all_bodies(),
}  # fmt: skip

# ---- Of systems, whose load keeps time by itself

_OF_LOADS: tuple[Parameter[System], ...] = (
    Parameter(
        "load_factor", "load factor p₀/p₁", "p_0/p_1, the mean load over the amplitude of its first harmonic",
        lambda system: None if system.load.is_constant else system.load.load_factor, System.with_load_factor,
        _alternates, span=(0.02, 1.2), sets="mean", turn=_FACTOR,
    ),
    Parameter(
        "kappa", "load κ", "κ of a square load: it pushes for κπ of 2π",
        lambda system: system.load.breaks[1] / math.pi if len(system.load.values) == 2 else None, _with_kappa,
        _is_square, span=(0.1, 1.9), turn=_SHAPE,
    ),
    Parameter(
        "mean", "mean load p₀", "mean load p_0", lambda system: system.load.mean,
        lambda system, mean: replace(system, load=system.load.with_mean(mean)), turn=_MEAN,
    ),
    Parameter(
        "amplitude", "load amplitude p₁", "amplitude of the load's first harmonic",
        lambda system: None if system.load.is_constant else _first(system), _with_amplitude, _alternates, turn=_SIZE,
    ),
)  # fmt: skip


class _Table(dict[str, Parameter[System]]):
    """The parameters by name; those of one harmonic or step of the load are made when they are asked for."""

    def __missing__(self, name: str) -> Parameter[System]:
        made = _load_parameter(name)
        if made is None:
            raise KeyError(name)
        return made

    def __contains__(self, name: object) -> bool:
        return super().__contains__(name) or (isinstance(name, str) and _load_parameter(name) is not None)


_BY_NAME: dict[str, Parameter[Any]] = _OF_ANY | {parameter.name: parameter for parameter in _OF_LOADS}
_FIRST = ("restitution", "load_factor", "kappa")

PARAMETERS: dict[str, Parameter[System]] = _Table({name: _BY_NAME[name] for name in (*_FIRST, *_BY_NAME)})
"""The dimensionless parameters of systems; `Parameter.check` tells whether a system has one.

Besides those listed each harmonic of a load has its `amplitude2` and `phase2`, each step its `step1` and `break1`.
"""

# ---- Of machines that switch their own valve

PRESSURE = "pressure"  # the parameter of all forces of the valve at once


@lru_cache(maxsize=32)
def _of_valves(states: tuple[str, ...], edges: tuple[str, ...], supply: bool) -> dict[str, Parameter[Machine]]:
    """The parameters of machines with these states, ports that read these or blows, and perhaps a pump."""
    under = Parameter(
        PRESSURE, "pressure, as a multiple", "a factor on the forces of all states", lambda _: 1.0, _under,
        span=(0.5, 1.5), sets="load.scale", turn=_PRESSURE,
    )  # fmt: skip
    pump = (
        _at("supply.flow", "flow of the pump", "power of the pump at the pressure 1", "supply", "flow"),
        _at("supply.compliance", "accumulator", "twice the energy stored at the pressure 1", "supply", "compliance"),
        _at("supply.quickening", "quickening", "of the spool under a higher pressure", "supply", "quickening"),
    )
    found: list[Parameter[Any]] = [*(pump if supply else (under,))]
    for i, name in enumerate(states):
        meaning = "force of the state without that of the chamber"
        found.append(_at(f"states.{name}", f"force, {name}", meaning, "states", i, 1))
    for field, label, meaning in (
        ("force", "force of the chamber", "force of the gas chamber with the bar at the wall"),
        ("stiffness", "stiffness of the chamber", "how much that force grows with the distance behind it"),
    ):
        found.append(_at(f"chamber.{field}", label, meaning, "chamber", field))
    for field, label, meaning in (
        ("behind", "place of port", "distance behind the wall"),
        ("speed", "speed of port", "at which it is passed"),
        ("delay", "delay of port", "from the demand to the change of the state"),
    ):
        for i, edge in enumerate(edges):
            if field in (edge, "delay"):
                found.append(_at(f"ports[{i}].{field}", f"{label} {i}", meaning, "ports", i, field))
    return {parameter.name: parameter for parameter in (*found, *_OF_ANY.values())}


def _under(machine: Machine, factor: float) -> Machine:
    if not factor > 0.0:
        raise ParameterError(PRESSURE, factor, "a factor greater than 0")
    pressure = None if machine.pressure is None else factor * machine.pressure
    return replace(machine, valve=machine.valve.at_pressure(factor), pressure=pressure)


def _at(name: str, label: str, meaning: str, *path: str | int) -> Parameter[Machine]:
    """The parameter that is a number in the valve: at fields by their names, at items of tuples by their numbers."""

    def get(machine: Machine) -> float:
        found: Any = machine.valve
        for step in path:
            found = found[step] if isinstance(step, int) else found.pairs if step == "states" else getattr(found, step)
        return float(found)

    def changed(thing: Any, way: tuple[str | int, ...], value: float) -> Any:
        if not way:
            return value
        step, *rest = way
        if isinstance(step, int):
            return (*thing[:step], changed(thing[step], tuple(rest), value), *thing[step + 1 :])
        inner = thing.pairs if step == "states" else getattr(thing, step)
        return replace(thing, **{step: changed(inner, tuple(rest), value)})

    def put(machine: Machine, value: float) -> Machine:
        return replace(machine, valve=changed(machine.valve, path, value))

    return Parameter(name, label, meaning, get, put, turn=_CONTACT)


# ---- Of any hammer


def parameters_of(hammer: System | Machine) -> Mapping[str, Parameter[Any]]:
    """The dimensionless parameters of a hammer, by name: `PARAMETERS` of a system.

    Of a machine that switches its own valve: ``pressure``, a factor on the forces of all states, or with a supply
    ``supply.flow``, ``supply.compliance`` and ``supply.quickening``; ``states.NAME``, the force of one;
    ``chamber.force`` and ``chamber.stiffness``; ``ports[i].behind`` or ``ports[i].speed``, and ``ports[i].delay``,
    counted from 0; ``restitution``; and the numbers of the body and its damping, such as ``s`` and ``d``.

    Examples
    --------
    >>> from percuss.model import Kept, Port, UniformBar, Valve
    >>> ports = [Port("power", behind=1.0, side="back"), Port("return", on="impact")]
    >>> machine = Machine(UniformBar(20.0), Valve({"return": -0.4, "power": 1.8}, ports), Kept(0.2))
    >>> [name for name in parameters_of(machine) if name.startswith("ports")]
    ['ports[0].behind', 'ports[0].delay', 'ports[1].delay']
    """
    if isinstance(hammer, System):
        return PARAMETERS
    if not isinstance(hammer, Machine):
        raise ParameterError("hammer", hammer, "a System, or a Machine that switches its own valve")
    valve = hammer.valve
    edges = tuple(port.on if port.on == "impact" else port.edge for port in valve.ports)
    return _of_valves(tuple(name for name, _ in valve.pairs), edges, valve.supply is not None)


def vary(hammer: Driven, values: Mapping[str, float]) -> Driven:
    """A system or a machine with other dimensionless parameters, whatever the order in which they are named.

    Examples
    --------
    >>> from percuss.model import Kept, Port, UniformBar, Valve
    >>> ports = [Port("power", behind=1.0, side="back"), Port("return", on="impact")]
    >>> machine = Machine(UniformBar(20.0), Valve({"return": -0.4, "power": 1.8}, ports), Kept(0.2))
    >>> vary(machine, {"pressure": 2.0, "ports[0].behind": 0.5}).valve.force("power")
    3.6
    """
    known: Mapping[str, Parameter[Any]] = parameters_of(hammer)
    given = mapping("values", values, "values of parameters by name, such as {'restitution': 0.5}")
    unknown = [name for name in given if name not in known]
    if unknown:
        more: list[str] = [f"{word}K" for word in LOAD_PARAMETERS] if known is PARAMETERS else []
        raise ParameterError("parameter", sorted(unknown)[0], f"one of {', '.join([*known, *more])}")
    for parameter in sorted((known[name] for name in values), key=lambda parameter: parameter.turn):
        hammer = parameter.put(hammer, finite(parameter.name, values[parameter.name]))
    return hammer


def refuse_twice(sets: Mapping[str, str]) -> None:
    """ParameterError when two parameters set the same thing, so that one of them would do nothing."""
    by_thing: dict[str, str] = {}
    for name, thing in sets.items():
        other = by_thing.setdefault(thing, name)
        if other != name:
            raise ParameterError(name, "on an axis", f"another parameter than {other}, which sets the same")


def label_of(name: str) -> str:
    """What stands on an axis of a parameter; the name itself when the table does not have it."""
    if name == PERIODS:
        return "load periods m"
    return PARAMETERS[name].label if name in PARAMETERS else name
