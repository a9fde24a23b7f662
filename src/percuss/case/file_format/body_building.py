"""From the tables [bar] and [system] of a case to the body that strikes."""

from __future__ import annotations

from typing import Any

from percuss.case.file_format.damping_table import damping_law, drag_in
from percuss.case.file_format.schema import BarTable, SystemTable
from percuss.case.file_format.section_tables import sectioned_bar
from percuss.errors import ParameterError
from percuss.model import Bar, External, Ratio, SizedBody, SteppedBar, UniformBar
from percuss.model.body import Body, Damping
from percuss.model.body.damping import share_of_critical
from percuss.model.checks import non_negative
from percuss.units import si

__all__ = ["body_table", "plain_body", "plain_damping", "sized_body"]

DEFAULT_RATIO = 1e-3
"""The share of critical damping of a bar in SI of which nothing is known: steel, with a joint or two."""


def sized_body(table: BarTable) -> SizedBody:
    """The body that the table [bar] describes.

    Raises
    ------
    ParameterError
        By the key of the table.
    """
    if table.sections is not None:
        return _sectioned(table)
    if (table.area is None) == (table.diameter is None):
        raise ParameterError("diameter", table.diameter, "either a diameter or an area")
    sizes: dict[str, Any] = {
        name: _size(table, name, dimension) for name, dimension in _SIZES.items() if getattr(table, name) is not None
    }
    return Bar(**sizes, **_damping(table))


def _sectioned(table: BarTable) -> SizedBody:
    assert table.sections is not None
    for name in ("length", "area", "diameter"):
        if getattr(table, name) is not None:
            raise ParameterError(name, getattr(table, name), f"either sections or a {name}, not both")
    given = _damping(table)
    ratio, law = given.get("damping_ratio"), given.get("damping")
    if ratio is not None:
        law = Ratio(share_of_critical("damping_ratio", ratio))
    return sectioned_bar(table.sections, table, law, given.get("drag", 0.0))


_SIZES = {
    "length": "length",
    "area": "area",
    "diameter": "length",
    "youngs_modulus": "pressure",
    "density": "density",
}


def _size(table: BarTable, name: str, dimension: str) -> float:
    text = getattr(table, name)
    value = si(text, dimension, name)
    if value <= 0.0:
        raise ParameterError(name, text, f"a {dimension} greater than 0")
    return value


def _damping(table: BarTable) -> dict[str, Any]:
    """What a body in SI is told of its damping."""
    given = [name for name in ("damping_ratio", "damping", "drag") if getattr(table, name) is not None]
    if len(given) > 1:
        value = None if given[1] == "damping" else getattr(table, given[1])  # a table is not shown
        raise ParameterError(given[1], value, f"either {given[0]} or {given[1]}, not both")
    if table.drag is not None:
        return {"drag": non_negative("drag", si(table.drag, "damping", "drag"))}
    if table.damping is not None:
        drag = drag_in(table.damping)
        return {"damping": damping_law(table.damping, units=True)} if drag is None else {"drag": drag}
    return {"damping_ratio": DEFAULT_RATIO if table.damping_ratio is None else table.damping_ratio}


def plain_body(table: SystemTable) -> Body:
    """The body that the table [system] describes.

    Raises
    ------
    ParameterError
        By the key of the table.
    """
    damping = plain_damping(table)
    assert table.s is not None
    if table.impedances is None and table.transit_times is None:
        return UniformBar(table.s, damping)
    for name in ("impedances", "transit_times"):
        if getattr(table, name) is None:
            raise ParameterError(name, None, "both impedances and transit_times, or neither")
    return SteppedBar(table.s, table.impedances or (), table.transit_times or (), damping)


def plain_damping(table: SystemTable) -> Damping:
    """The law of damping that the table [system] names, or its d."""
    d = None if table.d is None else non_negative("d", table.d)
    if table.damping is None:
        return External(d or 0.0)
    law = damping_law(table.damping, units=False)
    if d and d != law.rigid:
        remedy = f'leave d out: the law "{law.kind}" says it all'
        raise ParameterError("d", table.d, "0 or no d beside another law of damping", remedy)
    return law


def body_table(body: Body) -> dict[str, Any]:
    """What the table [system] says of a body beside s and the damping; `plain_body` backwards."""
    if not isinstance(body, SteppedBar):
        return {}
    return {"impedances": list(body.impedances), "transit_times": list(body.transit_times)}
