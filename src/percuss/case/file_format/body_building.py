"""From the tables [bar] and [system] of a case to the body that strikes, and to the law of its contact."""

from __future__ import annotations

from typing import Any

from percuss.case.file_format.damping_table import damping_law, drag_in
from percuss.case.file_format.schema import BarTable, ContactTable, SystemTable
from percuss.case.file_format.section_tables import sectioned_bar
from percuss.case.file_format.values import FROM_THE_BLOW
from percuss.errors import ParameterError
from percuss.model import Bar, Contact, External, Kept, Ratio, Reversed, SizedBody, SteppedBar, UniformBar
from percuss.model.body import Body, Damping
from percuss.model.body.damping import share_of_critical
from percuss.model.checks import non_negative
from percuss.model.contact import LAWS
from percuss.units import si

__all__ = ["body_table", "contact_of", "plain_body", "plain_contact", "sized_body"]

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
        raise ParameterError(given[1], getattr(table, given[1]), f"either {given[0]} or {given[1]}, not both")
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
    damping = _plain_damping(table)
    if table.impedances is None and table.transit_times is None:
        return UniformBar(table.s, damping)
    for name in ("impedances", "transit_times"):
        if getattr(table, name) is None:
            raise ParameterError(name, None, "both impedances and transit_times, or neither")
    return SteppedBar(table.s, table.impedances or (), table.transit_times or (), damping)


def _plain_damping(table: SystemTable) -> Damping:
    d = None if table.d is None else non_negative("d", table.d)
    if table.damping is None:
        assert d is not None  # one of the two is there when the table is looked at
        return External(d)
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


# -- the contact --


def contact_of(table: ContactTable, bar: SizedBody | None, tool: bool) -> Contact | None:
    """The law of the table [contact]; None where it depends on a bar that could not be made, or on the blow.

    Parameters
    ----------
    tool
        Whether the case says what the bar strikes.

    Raises
    ------
    ParameterError
        By the key of the table.
    """
    rod = table.receiving_area is not None
    if rod and table.restitution is not None:
        raise ParameterError("receiving_area", table.receiving_area, "either restitution or receiving_area, not both")
    check_law(table, None if bar is None else bar.kind, tool or rod)
    if table.law == "b77-blow" or table.restitution == FROM_THE_BLOW:
        return None
    if not rod and table.restitution is None:
        raise ParameterError(
            "restitution", None, "a restitution from 0 to 1, or a receiving_area", _OF_BLOW if tool else ""
        )
    law = si_law(table, bar)
    if table.receiving_area is None:
        return law(_number(table.restitution))
    receiving = si(table.receiving_area, "area", "receiving_area")
    return None if bar is None else law(receiving_area=receiving, area=bar.pieces[-1].area)


_OF_BLOW = f'that of the blow on the tool is restitution = "{FROM_THE_BLOW}"'


def si_law(table: ContactTable, bar: SizedBody | None) -> type[Contact]:
    """The law that the table names; else what the waves in a uniform bar do, and B77's for others."""
    if table.strain is not None:
        return LAWS[table.strain]
    return Reversed if bar is None or bar.kind == UniformBar.kind else Kept


def plain_contact(table: SystemTable, body: Body | None, tool: bool) -> Contact | None:
    """The law of the table [system]; None where its restitution is that of the blow.

    Raises
    ------
    ParameterError
        By the key of the table.
    """
    check_law(table, None if body is None else body.kind, tool)
    return None if table.restitution == FROM_THE_BLOW else plain_law(table)(_number(table.restitution))


def _number(restitution: float | str | None) -> float:
    assert isinstance(restitution, int | float)  # the word for that of the blow was looked at before
    return restitution


def plain_law(table: SystemTable) -> type[Contact]:
    """The law that the table names, else B77's."""
    return Kept if table.strain is None else LAWS[table.strain]


def check_law(table: ContactTable | SystemTable, body: str | None, target: bool) -> None:
    """Refuse a law of the blow that lacks what it is made of.

    Parameters
    ----------
    body
        The kind of the body, None where it could not be made.
    target
        Whether the case says what is struck.
    """
    given = table.restitution
    if table.advance is not None and table.law in (None, "b77"):
        remedy = 'take it away, or write law = "b77-tau" or "b77-blow"'
        raise ParameterError("advance", table.advance, "a law that knows the duration of the blow beside it", remedy)
    if table.law == "b77-tau" and body not in (None, UniformBar.kind):
        remedy = 'take law = "b77-blow", which holds for any bar'
        raise ParameterError("law", table.law, "a uniform bar for the law b77-tau", remedy)
    if table.law == "b77-blow" and given is not None and given != FROM_THE_BLOW:
        remedy = f'write restitution = "{FROM_THE_BLOW}", or take law = "b77" for a number'
        raise ParameterError(
            "restitution", given, "no number beside the law b77-blow, which takes it from the blow", remedy
        )
    key = "law" if table.law == "b77-blow" else "restitution"
    if not target and (table.law == "b77-blow" or given == FROM_THE_BLOW):
        remedy = 'a rigid wall is kind = "wall" in [tool]'
        raise ParameterError(key, getattr(table, key), "a table [tool] that says what the bar strikes", remedy)
