"""Numbers of a machine that switches itself, in its unit of length and time, told with units."""

from __future__ import annotations

from typing import TYPE_CHECKING

from percuss.case.answers.numerals import number, quantity

if TYPE_CHECKING:
    from percuss.model import Machine

__all__ = ["in_units"]


def in_units(machine: Machine, value: float, kind: str) -> str:
    """A dimensionless value with its unit, where the machine has scales: a "length", "time", "force", "speed" or ""."""
    if not machine.is_si or not kind:
        return number(value)
    units = {"length": "m", "time": "s", "force": "N", "speed": "m/s"}
    scale: float = getattr(machine, f"{kind}_scale")
    return f"{number(value * scale)} m/s" if kind == "speed" else quantity(value * scale, units[kind])
