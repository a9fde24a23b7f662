"""The law of damping in a case: ``damping = {kind = "ratio", value = 1e-3}``, in [bar] or [system]."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, ValidationInfo

from percuss.case.file_format.values import DampingValue, Table
from percuss.errors import ParameterError
from percuss.model.body import DAMPINGS, Damping
from percuss.model.checks import finite
from percuss.units import si

__all__ = ["BarDamping", "DampingTable", "SystemDamping", "damping_law", "damping_table", "drag_in"]

_EXAMPLE = 'a table such as {kind = "ratio", value = 0.001}'

_QUANTITIES = {"kelvin_voigt": "time"}
"""What the value of a law in SI may be written as, other than a plain number."""


class DampingTable(Table):
    """How the bar loses energy between the impacts."""

    kind: Literal["ratio", "kelvin_voigt", "external", "table"]
    """The law, which decides what `value` is."""
    value: DampingValue
    """The number of the law, or its numbers."""


def damping_law(table: DampingTable, units: bool) -> Damping:
    """The law that a table describes; with the time in seconds for a bar in SI, which `units` tells.

    Raises
    ------
    ParameterError
        For a value that is none of the law.
    """
    try:
        return DAMPINGS[table.kind](_value(table, units))  # type: ignore[call-arg]  # each has one field
    except ParameterError as error:
        _, bracket, place = error.name.partition("[")
        value = error.value if bracket else table.value
        raise ParameterError(f"damping.value{bracket}{place}", value, error.accepted, error.remedy) from None


def _value(table: DampingTable, units: bool) -> float | tuple[float, ...]:
    value, quantity = table.value, _QUANTITIES.get(table.kind)
    if table.kind == "table":
        accepted = "a list of numbers, the damping of each mode" + (" in 1/s" if units else "")
        if not isinstance(value, tuple):
            raise ParameterError("value", value, accepted)
        return value
    if not isinstance(value, str):
        return finite("value", value, "one finite number")
    if not units:
        raise ParameterError("value", value, "a number", "only a case in SI takes units")
    if quantity is None:
        raise ParameterError("value", value, "a plain number")
    return si(value, quantity, "value")


def drag_in(table: DampingTable) -> float | None:
    """The drag in N·s/m² of an external damping that is written as one, else None.

    Raises
    ------
    ParameterError
        For text that is none.
    """
    if table.kind != "external" or not isinstance(table.value, str):
        return None
    if not (drag := si(table.value, "damping", "damping.value")) >= 0.0:
        raise ParameterError("damping.value", table.value, "0 or greater")
    return drag


def damping_table(law: Damping) -> dict[str, Any]:
    """The table of a law, as JSON has it; `damping_law` backwards.

    Examples
    --------
    >>> from percuss.model.body import Ratio
    >>> damping_table(Ratio(0.001))
    {'kind': 'ratio', 'value': 0.001}
    """
    (value,) = vars(law).values()
    return {"kind": law.kind, "value": list(value) if isinstance(value, tuple) else value}


# -- what the key once was, or is taken for --


def _no_drag(value: Any, info: ValidationInfo) -> Any:
    if isinstance(value, str):
        raise ParameterError(
            "damping", value, _EXAMPLE, f'a force per velocity and metre is called drag: drag = "{value}"'
        )
    if isinstance(value, int | float) and not isinstance(value, bool):
        remedy = f"a share of the critical damping is called damping_ratio: damping_ratio = {value}"
        raise ParameterError("damping", value, _EXAMPLE, remedy)
    return value


def _no_plain_damping(value: Any, info: ValidationInfo) -> Any:
    if isinstance(value, str | int | float) and not isinstance(value, bool):
        raise ParameterError("damping", value, _EXAMPLE, "the external damping D/(MΩ) is called d")
    return value


BarDamping = Annotated[DampingTable, BeforeValidator(_no_drag)]
"""The table in [bar], where older case files have a quantity, which is told what it is called now."""

SystemDamping = Annotated[DampingTable, BeforeValidator(_no_plain_damping)]
"""The table in [system]."""
