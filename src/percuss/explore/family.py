"""Families of systems: one for each set of parameter values, so that maps can be made of any of them."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Protocol, TypeGuard

import numpy as np
import numpy.typing as npt

from percuss.errors import ParameterError
from percuss.explore.parameters import parameters_of, refuse_twice, vary
from percuss.model import Machine, System
from percuss.model.checks import Array, count, finite, having, instance, mapping, numbers, positive
from percuss.model.checks import text as checked_text
from percuss.model.described import describe_machine, describe_system
from percuss.short_repr import ShortRepr


class Family(Protocol):
    """Systems over parameters. Travels to other processes, so it must be picklable."""

    def system(self, values: Mapping[str, float]) -> System:
        """The system at these values; PercussError where there is none."""

    def check(self, names: Mapping[str, str]) -> None:
        """ParameterError when a parameter is unknown or cannot have its unit; `names` maps names to units."""

    def describe(self) -> dict[str, Any]:
        """All that the systems depend on, of JSON's types."""


class SwitchingFamily(Family, Protocol):
    """Machines over parameters whose pistons switch their own valves; where `is_machine` is true it has no systems."""

    @property
    def is_machine(self) -> bool:
        """Whether it has machines in place of systems."""

    def machine(self, values: Mapping[str, float]) -> Machine:
        """The machine at these values; PercussError where there is none."""

    def room(self, machine: Machine) -> float | None:
        """How far behind the wall the piston of one of its machines can go, in bar lengths; None without a limit."""


def drives_itself(family: Family) -> TypeGuard[SwitchingFamily]:
    """Whether the machines of a family switch their own valves."""
    return bool(getattr(family, "is_machine", False))


@dataclass(frozen=True)
class SystemFamily:
    """The systems, or the machines that switch their own valves, that differ from one in dimensionless parameters.

    Parameters
    ----------
    base
        The system or the machine that the others are made from.
    limit
        Distance behind the wall that the piston of a machine can go, in bar lengths; without limit by default.

    Examples
    --------
    >>> from percuss import Load, System
    >>> family = SystemFamily(System(s=20.0, d=0.0, restitution=0.6, load=Load.harmonic(0.9, 1.0)))
    >>> print(family.system({"restitution": 0.5, "load_factor": 0.7}))
    System: s = 20, d = 0, R = 0.5; mean 0.7, 1 harmonic, load factor 0.7
    """

    base: System | Machine
    limit: float | None = None

    def __post_init__(self) -> None:
        if not isinstance(self.base, System | Machine):
            raise ParameterError("base", self.base, "a System, or a Machine that switches its own valve")
        if self.limit is not None:
            object.__setattr__(self, "limit", positive("limit", self.limit))

    @property
    def is_machine(self) -> bool:
        """Whether it has machines in place of systems."""
        return isinstance(self.base, Machine)

    def system(self, values: Mapping[str, float]) -> System:
        """The base with these parameters; see `percuss.explore.PARAMETERS`."""
        if isinstance(self.base, Machine):
            raise ParameterError("system", str(self.base), "a system, whose load keeps time by itself")
        return vary(self.base, values)

    def machine(self, values: Mapping[str, float]) -> Machine:
        """The base with these parameters; see `percuss.explore.parameters_of`."""
        return vary(instance("base", self.base, Machine), values)

    def room(self, machine: Machine) -> float | None:
        """`limit`, of every machine."""
        instance("machine", machine, Machine)
        return self.limit

    def check(self, names: Mapping[str, str]) -> None:
        """ParameterError for a parameter that a dimensionless hammer does not have."""
        known = parameters_of(self.base)
        for name, unit in mapping("names", names, "parameters and their units").items():
            if name not in known:
                told = ", ".join(known)
                raise ParameterError("parameter", name, f"one of {told}", "quantities with units need a case in SI")
            if unit:
                raise ParameterError(name, unit, "plain numbers: the parameter is dimensionless")
            known[name].check(self.base)
        refuse_twice({name: known[name].thing for name in names})

    def describe(self) -> dict[str, Any]:
        """The hammer in plain numbers."""
        if isinstance(self.base, Machine):
            return {"machine": describe_machine(self.base), "room": self.limit}
        return {"system": describe_system(self.base)}


def family_of(what: System | Machine | Family) -> Family:
    """The family of a system or of a machine, or the family that is given."""
    if isinstance(what, System | Machine):
        return SystemFamily(what)
    having(
        "system", what, ("system", "check", "describe"), "a System, a Machine, or a family of them such as a CaseFamily"
    )
    return what


# ---- One axis of a map: a parameter and the values it takes

MAX_VALUES = 10**7  # the most values of one axis
_NUMBER = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*(.*?)\s*", re.ASCII)
_FORM = "FROM:TO:NUMBER, FROM:TO:NUMBER:log or a list A,B,C, with or without a unit"


@dataclass(frozen=True, eq=False)
class Axis(ShortRepr):
    """A parameter and its values.

    Parameters
    ----------
    name
        Of the parameter; see `percuss.explore.SystemFamily` and `percuss.case.CaseFamily`.
    values
        Shape (n,), finite and all different, ascending or descending; in `unit`.
    unit
        As in a case file, for example ``Hz`` or ``mm``; empty for a plain number.

    Examples
    --------
    >>> Axis.linear("restitution", 0.0, 0.9, 4).values
    array([0. , 0.3, 0.6, 0.9])
    >>> axis = Axis.parsed("frequency=20 Hz:80 Hz:3")
    >>> axis.name, axis.values, axis.unit
    ('frequency', array([20., 50., 80.]), 'Hz')
    """

    name: str
    values: Array
    unit: str = ""

    def __post_init__(self) -> None:
        checked_text("name", self.name, "the name of a parameter")
        checked_text("unit", self.unit, "a unit such as Hz, or an empty text")
        values = np.array(numbers(self.name, self.values, "finite numbers", nan=True))
        if values.ndim != 1 or not 1 <= values.size <= MAX_VALUES:
            raise ParameterError(self.name, f"{values.shape} values", f"a list of 1 to {MAX_VALUES} values")
        if not np.all(np.isfinite(values)):
            raise ParameterError(self.name, values[~np.isfinite(values)][0], "finite numbers")
        steps = np.diff(values)
        if not (np.all(steps > 0.0) or np.all(steps < 0.0)):
            raise ParameterError(self.name, values, "values in ascending or descending order, each once")
        values.setflags(write=False)
        object.__setattr__(self, "values", values)

    @classmethod
    def linear(cls, name: str, first: float, last: float, number: int, unit: str = "") -> Axis:
        """`number` values from `first` to `last`, both included, at equal distances."""
        n, first, last = _number(name, number, first, last)
        return cls(name, np.linspace(first, last, n), unit)

    @classmethod
    def logarithmic(cls, name: str, first: float, last: float, number: int, unit: str = "") -> Axis:
        """`number` values from `first` to `last`, both included, at equal ratios."""
        n, first, last = _number(name, number, first, last)
        if not (first > 0.0 and last > 0.0):
            raise ParameterError(name, f"{first:g}:{last:g}:{n}:log", "ends greater than 0 for equal ratios")
        return cls(name, np.geomspace(first, last, n), unit)

    @classmethod
    def parsed(cls, text: str) -> Axis:
        """From ``NAME=FROM:TO:NUMBER``, ``NAME=FROM:TO:NUMBER:log`` or ``NAME=A,B,C``, numbers with a unit or none."""
        name, equal, rest = checked_text("axis", text, f"NAME={_FORM}").partition("=")
        name = name.strip()
        if not (name and equal and rest.strip()):
            raise ParameterError("axis", text, f"NAME={_FORM}", "for example restitution=0:0.9:200")
        if ":" not in rest:
            numbers, unit = _with_unit(name, rest.split(","))
            return cls(name, np.array(numbers), unit)
        parts = [part.strip() for part in rest.split(":")]
        if not 3 <= len(parts) <= 4 or not parts[2].isdecimal() or parts[3:] not in ([], ["log"]):
            raise ParameterError(name, rest, _FORM, f"for example {name}=0.1:0.9:200")
        (low, high), unit = _with_unit(name, parts[:2])
        make = cls.logarithmic if parts[3:] else cls.linear
        return make(name, low, high, int(parts[2]), unit)

    @classmethod
    def spanned(cls, text: str) -> Axis:
        """The two ends of a range, from ``NAME=FROM:TO``, numbers with or without a unit.

        Examples
        --------
        >>> Axis.spanned("frequency=20 Hz:80 Hz")
        Axis(name='frequency', values=[20, 80], unit='Hz')
        """
        name, equal, rest = checked_text("range", text, "NAME=FROM:TO").partition("=")
        if not (name.strip() and equal and rest.count(":") == 1):
            raise ParameterError(
                "range", text, "NAME=FROM:TO, with or without a unit", "for example load_factor=0.3:1.2"
            )
        (low, high), unit = _with_unit(name.strip(), [end.strip() for end in rest.split(":")])
        if low == high and math.isfinite(low):
            raise ParameterError(name.strip(), rest, "two different ends")
        return cls.linear(name.strip(), low, high, 2, unit)

    @classmethod
    def of(cls, axis: Axis | str | tuple[Any, ...], name: str = "axis") -> Axis:
        """An axis that is given as it is, as text, as (name, values) or as (name, first, last, number).

        `name`: what an error calls it.

        Examples
        --------
        >>> Axis.of(("restitution", [0.0, 0.3])), Axis.of("restitution=0,0.3")
        (Axis(name='restitution', values=[0, 0.3], unit=''), Axis(name='restitution', values=[0, 0.3], unit=''))
        """
        checked_text("name", name)
        if isinstance(axis, str):
            return cls.parsed(axis)
        if isinstance(axis, tuple | list) and len(axis) in (2, 4) and isinstance(axis[0], str):
            return cls.linear(*axis) if len(axis) == 4 else cls(axis[0], np.atleast_1d(numbers(*axis)))
        if isinstance(axis, Axis):
            return axis
        raise ParameterError(name, axis, "text (time=0:6.2:32), (name, first, last, number), (name, values) or an Axis")

    @classmethod
    def range_of(cls, axis: Axis | str | tuple[Any, ...], name: str = "range") -> Axis:
        """The two ends of a range: of text, with or without a number, of (name, lowest, highest), or of an axis.

        `name`: what an error calls it.

        Examples
        --------
        >>> Axis.range_of("load_factor=0.3:1.2"), Axis.range_of("load_factor=0.3:1.2:90").values
        (Axis(name='load_factor', values=[0.3, 1.2], unit=''), array([0.3, 1.2]))
        """
        checked_text("name", name)
        if isinstance(axis, str) and axis.count(":") == 1 and "," not in axis:
            return cls.spanned(axis)
        if isinstance(axis, tuple | list) and len(axis) == 3 and isinstance(axis[0], str):
            axis = cls.linear(*axis, 2)
        elif not isinstance(axis, Axis | str):
            raise ParameterError(name, axis, "text (load_factor=0.3:1.2), (name, lowest, highest) or an Axis")
        whole = cls.of(axis)
        low, high = float(whole.values.min()), float(whole.values.max())
        if low == high:
            raise ParameterError(whole.name, low, "two different ends")
        return cls.linear(whole.name, low, high, 2, whole.unit)

    def __len__(self) -> int:
        return int(self.values.size)

    def to_json_dict(self) -> dict[str, object]:
        """Name, unit and values in plain types."""
        return {"name": self.name, "unit": self.unit, "values": self.values.tolist()}

    def coordinate(self) -> tuple[str, npt.NDArray[np.float64], dict[str, str]]:
        """The axis in the form in which xarray takes a coordinate: dimension, values, attributes."""
        return self.name, self.values, {"units": self.unit or "1"}


def _number(name: str, number: int, first: float, last: float) -> tuple[int, float, float]:
    """How many values, and the two ends, looked at."""
    checked_text("name", name, "the name of a parameter")
    n = count(name, number, least=1, most=MAX_VALUES)
    first, last = finite(name, first, "finite ends"), finite(name, last, "finite ends")
    if first > last:
        raise ParameterError(name, f"{first:g}:{last:g}", "a range with the smaller end first", "swap the two ends")
    if first == last and n > 1:
        raise ParameterError(
            name, f"{first:g}:{last:g}:{n}", "two different ends", f"or the one value: {name}={first:g}"
        )
    return n, first, last


def _with_unit(name: str, texts: list[str]) -> tuple[list[float], str]:
    """The numbers and the unit that they share; a number without one takes that of the others."""
    numbers, units = [], []
    for text in texts:
        found = _NUMBER.fullmatch(text)
        if found is None:
            raise ParameterError(name, text.strip(), "a number with or without a unit")
        numbers.append(float(found[1]))
        units.append(found[2])
    different = sorted({unit for unit in units if unit})
    if len(different) > 1:
        raise ParameterError(name, ", ".join(texts), f"one unit for all, not {' and '.join(different)}")
    return numbers, different[0] if different else ""
