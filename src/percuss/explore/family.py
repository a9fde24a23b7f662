"""Families of systems: one for each set of parameter values, so that maps can be made of any of them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Protocol

from percuss.errors import ParameterError
from percuss.explore.parameters import PARAMETERS, refuse_twice, vary
from percuss.model import System
from percuss.model.checks import having, instance, mapping
from percuss.model.described import describe_system

__all__ = ["Family", "SystemFamily", "family_of"]


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
        """The base with these parameters; see `percuss.explore.PARAMETERS`."""
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
        refuse_twice({name: PARAMETERS[name].thing for name in names})

    def describe(self) -> dict[str, Any]:
        """The system in plain numbers."""
        return {"system": describe_system(self.base)}


def family_of(what: System | Family) -> Family:
    """The family of a system, or the family that is given."""
    if isinstance(what, System):
        return SystemFamily(what)
    having("system", what, ("system", "check", "describe"), "a System, or a family of them such as a CaseFamily")
    return what
