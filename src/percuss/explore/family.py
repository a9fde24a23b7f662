"""Families of systems: one for each set of parameter values, so that maps can be made of any of them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Protocol, TypeGuard

from percuss.errors import ParameterError
from percuss.explore.parameters import PARAMETERS, refuse_twice, vary
from percuss.explore.valve_parameters import machine_parameters, vary_machine
from percuss.model import Machine, System
from percuss.model.checks import having, instance, mapping, positive
from percuss.model.described import describe_machine, describe_system
from percuss.model.parameter import Parameter

__all__ = ["Family", "MachineFamily", "SwitchingFamily", "SystemFamily", "drives_itself", "family_of"]


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


class SwitchingFamily(Family, Protocol):
    """Machines over parameters whose pistons switch their own valves; where `is_machine` is true it has no systems."""

    @property
    def is_machine(self) -> bool:
        """Whether it has machines in place of systems."""
        ...

    def machine(self, values: Mapping[str, float]) -> Machine:
        """The machine at these values; PercussError where there is none."""
        ...

    def room(self, machine: Machine) -> float | None:
        """How far behind the wall the piston of one of its machines can go, in bar lengths; None without a limit."""
        ...


def drives_itself(family: Family) -> TypeGuard[SwitchingFamily]:
    """Whether the machines of a family switch their own valves."""
    return bool(getattr(family, "is_machine", False))


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
        _check_plain(names, PARAMETERS, self.base)

    def describe(self) -> dict[str, Any]:
        """The system in plain numbers."""
        return {"system": describe_system(self.base)}


@dataclass(frozen=True)
class MachineFamily:
    """The machines that differ from one in dimensionless parameters.

    Parameters
    ----------
    base
        The machine that the others are made from.
    limit
        Distance behind the wall that its piston can go, in bar lengths; without limit by default.

    Raises
    ------
    ParameterError
        When an argument is none of these.

    Examples
    --------
    >>> from percuss.model import Kept, Port, UniformBar, Valve
    >>> ports = [Port("power", behind=1.0, side="back"), Port("return", on="impact")]
    >>> family = MachineFamily(Machine(UniformBar(20.0), Valve({"return": -0.4, "power": 1.8}, ports), Kept(0.2)))
    >>> family.machine({"ports[0].behind": 0.7}).valve.ports[0].behind
    0.7
    """

    base: Machine
    limit: float | None = None

    def __post_init__(self) -> None:
        instance("base", self.base, Machine)
        if self.limit is not None:
            object.__setattr__(self, "limit", positive("limit", self.limit))

    @property
    def is_machine(self) -> bool:
        """True: it has no systems."""
        return True

    def machine(self, values: Mapping[str, float]) -> Machine:
        """The base with these parameters; see `percuss.explore.machine_parameters`."""
        return vary_machine(self.base, values)

    def room(self, machine: Machine) -> float | None:
        """`limit`, of every machine."""
        instance("machine", machine, Machine)
        return self.limit

    def system(self, values: Mapping[str, float]) -> System:
        """Refused: a load that the piston switches makes no system."""
        raise ParameterError("system", str(self.base), "a system, whose load keeps time by itself")

    def check(self, names: Mapping[str, str]) -> None:
        """ParameterError for a parameter that the machine does not have."""
        _check_plain(names, machine_parameters(self.base), self.base)

    def describe(self) -> dict[str, Any]:
        """The machine in plain numbers."""
        return {"machine": describe_machine(self.base), "room": self.limit}


def _check_plain(names: Mapping[str, str], known: Mapping[str, Parameter[Any]], base: System | Machine) -> None:
    """Refuse a parameter that is not among the dimensionless ones of a system or a machine."""
    for name, unit in mapping("names", names, "parameters and their units").items():
        if name not in known:
            told = ", ".join(known)
            raise ParameterError("parameter", name, f"one of {told}", "quantities with units need a case in SI")
        if unit:
            raise ParameterError(name, unit, "plain numbers: the parameter is dimensionless")
        known[name].check(base)
    refuse_twice({name: known[name].thing for name in names})


def family_of(what: System | Machine | Family) -> Family:
    """The family of a system or of a machine, or the family that is given."""
    if isinstance(what, System):
        return SystemFamily(what)
    if isinstance(what, Machine):
        return MachineFamily(what)
    having(
        "system", what, ("system", "check", "describe"), "a System, a Machine, or a family of them such as a CaseFamily"
    )
    return what
