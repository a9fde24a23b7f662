"""The table of parameters: every dimensionless number of a system that maps, curves and sliders may vary."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any, TypeVar

from percuss.errors import ParameterError
from percuss.explore.load_parameters import LOAD_PARAMETERS, load_parameter
from percuss.model import Load, Machine, System
from percuss.model.body import BODIES, DAMPINGS, Body
from percuss.model.checks import finite, instance, mapping
from percuss.model.parameter import Parameter

__all__ = ["BODY_PARAMETERS", "PARAMETERS", "PERIODS", "label_of", "refuse_twice", "vary"]

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
