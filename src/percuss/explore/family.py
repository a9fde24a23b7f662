"""Families of systems: one for each set of parameter values, so that maps can be made of any of them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any, Protocol

from percuss.errors import ParameterError
from percuss.model import Load, System
from percuss.model.checks import finite, having, instance, mapping
from percuss.model.described import describe_system

__all__ = ["PARAMETERS", "Family", "SystemFamily", "family_of", "vary"]


class Family(Protocol):
    """Systems over parameters. Travels to other processes, so it must be picklable."""

    def system(self, values: Mapping[str, float]) -> System:
        """The system at these values; PercussError where there is none."""
        ...

    def check(self, names: Mapping[str, str]) -> None:
        """ParameterError when a parameter is unknown or cannot have its unit; `names` maps names to units."""
        ...

    def describe(self) -> dict[str, Any]:
        """All that the systems depend on, of JSON's types."""
        ...


@dataclass(frozen=True)
class SystemFamily:
    """The systems that differ from one in dimensionless parameters.

    Parameters
    ----------
    base
        The system that the others are made from.

    Examples
    --------
    >>> from percuss import Load, System
    >>> family = SystemFamily(System(s=20.0, d=0.0, restitution=0.6, load=Load.harmonic(0.9, 1.0)))
    >>> print(family.system({"restitution": 0.5, "load_factor": 0.7}))
    System: s = 20, d = 0, R = 0.5; mean 0.7, 1 harmonic, load factor 0.7
    """

    base: System

    def __post_init__(self) -> None:
        instance("base", self.base, System)

    def system(self, values: Mapping[str, float]) -> System:
        """The base with these parameters; see `PARAMETERS`."""
        return vary(self.base, values)

    def check(self, names: Mapping[str, str]) -> None:
        """ParameterError for a parameter that a dimensionless system does not have."""
        for name, unit in mapping("names", names, "parameters and their units").items():
            if name not in PARAMETERS:
                known = ", ".join(PARAMETERS)
                raise ParameterError("parameter", name, f"one of {known}", "quantities with units need a case in SI")
            if unit:
                raise ParameterError(name, unit, "plain numbers: the parameter is dimensionless")
            PARAMETERS[name].check(self.base)
        refuse_twice({name: name for name in names})

    def describe(self) -> dict[str, Any]:
        """The system in plain numbers."""
        return {"system": describe_system(self.base)}


def family_of(what: System | Family) -> Family:
    """The family of a system, or the family that is given."""
    if isinstance(what, System):
        return SystemFamily(what)
    having("system", what, ("system", "check", "describe"), "a System, or a family of them such as a CaseFamily")
    return what


def refuse_twice(sets: Mapping[str, str]) -> None:
    """ParameterError when two parameters set the same thing, so that one of them would do nothing.

    Parameters
    ----------
    sets
        What each parameter sets, by name; the load factor sets the mean.
    """
    by_thing: dict[str, str] = {}
    for name, thing in sets.items():
        other = by_thing.setdefault(_SETS.get(thing, thing), name)
        if other != name:
            raise ParameterError(name, "on an axis", f"another parameter than {other}, which sets the same")


_SETS = {"load_factor": "mean"}
_VALUES = "values of parameters by name, such as {'restitution': 0.5}"


@dataclass(frozen=True)
class Parameter:
    """A dimensionless parameter: what it is, how a system gets it, and which systems have it."""

    meaning: str
    put: Callable[[System, float], System]
    check: Callable[[System], None] = lambda system: None


def _alternates(system: System) -> None:
    if system.load.is_constant:
        raise ParameterError("load", str(system.load), "a load with an alternating part")


def _is_square(system: System) -> None:
    values = system.load.values
    if len(values) != 2 or values[0] != -values[1] or system.load.breaks[0] != 0.0:
        raise ParameterError("kappa", str(system.load), "a square load, +q for 0 < t < kappa pi and −q after it")


def _with_kappa(system: System, kappa: float) -> System:
    _is_square(system)
    q = system.load.values[0]
    load = Load.square(abs(q), kappa, system.load.coefficients.size - 1)
    return replace(system, load=load if q > 0.0 else load.scaled(-1.0))


def _with_amplitude(system: System, amplitude: float) -> System:
    """The alternating part scaled so that its first harmonic has this amplitude."""
    _alternates(system)
    load = system.load
    present = abs(complex(load.coefficients[load.harmonics[0]]))
    return replace(system, load=load.with_mean(0.0).scaled(amplitude / present).with_mean(load.mean))


PARAMETERS: dict[str, Parameter] = {
    "restitution": Parameter("coefficient of restitution R", System.with_restitution),
    "load_factor": Parameter(
        "p_0/p_1, the mean load over the amplitude of its first harmonic", System.with_load_factor, _alternates
    ),
    "kappa": Parameter("κ of a square load: it pushes for κπ of 2π", _with_kappa, _is_square),
    "s": Parameter("wave speed s = C/(LΩ)", lambda system, s: system.uniform(s=s)),
    "d": Parameter("damping d = D/(MΩ)", lambda system, d: system.uniform(d=d)),
    "mean": Parameter(
        "mean load p_0", lambda system, mean: replace(system, load=system.load.with_mean(finite("mean", mean)))
    ),
    "amplitude": Parameter("amplitude of the load's first harmonic", _with_amplitude, _alternates),
}
"""The dimensionless parameters that any system has."""


def vary(system: System, values: Mapping[str, float]) -> System:
    """A system with other dimensionless parameters, whatever the order in which they are named.

    Raises
    ------
    ParameterError
        For a parameter that is unknown, out of range, or that the system does not have.
    """
    instance("system", system, System)
    unknown = mapping("values", values, _VALUES).keys() - PARAMETERS.keys()
    if unknown:
        raise ParameterError("parameter", sorted(unknown)[0], f"one of {', '.join(PARAMETERS)}")
    for name in _ORDER:
        if name in values:
            system = PARAMETERS[name].put(system, finite(name, values[name]))
    return system


# The shape of the load before its size, the amplitude before the mean that is measured by it
_ORDER = ("kappa", "amplitude", "mean", "load_factor", "restitution", "s", "d")
