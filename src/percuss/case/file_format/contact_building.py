"""From the tables [contact] and [system] of a case to the law of the contact, as far as no blow is resolved for it."""

from __future__ import annotations

from percuss.case.file_format.schema import ContactTable, SystemTable
from percuss.case.file_format.values import FROM_THE_BLOW
from percuss.errors import ParameterError
from percuss.model import Contact, Kept, Reversed, SizedBody, UniformBar
from percuss.model.body import Body
from percuss.model.contact import LAWS
from percuss.units import si

__all__ = ["check_body", "contact_of", "plain_contact", "plain_law", "si_law"]


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
    _check_law(table, tool or rod)
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


def plain_contact(table: SystemTable, tool: bool) -> Contact | None:
    """The law of the table [system]; None where its restitution is that of the blow.

    Raises
    ------
    ParameterError
        By the key of the table.
    """
    _check_law(table, tool)
    return None if table.restitution == FROM_THE_BLOW else plain_law(table)(_number(table.restitution))


def _number(restitution: float | str | None) -> float:
    assert isinstance(restitution, int | float)  # the word for that of the blow was looked at before
    return restitution


def plain_law(table: SystemTable) -> type[Contact]:
    """The law that the table names, else B77's."""
    return Kept if table.strain is None else LAWS[table.strain]


def check_body(table: ContactTable | SystemTable, law: type[Contact], body: Body) -> None:
    """Refuse a body that the laws of the table do not hold for.

    Raises
    ------
    ParameterError
        By the key of the table.
    """
    law(0.0).check(body)
    if table.law == "b77-tau" and not body.is_harmonic:
        remedy = 'take law = "b77-blow", which holds for any bar'
        raise ParameterError("law", table.law, "a uniform bar for the law b77-tau", remedy)


def _check_law(table: ContactTable | SystemTable, target: bool) -> None:
    """Refuse a law of the blow that lacks what it is made of; `target` tells whether the case says what is struck."""
    given = table.restitution
    if table.advance is not None and table.law in (None, "b77"):
        remedy = 'take it away, or write law = "b77-tau" or "b77-blow"'
        raise ParameterError("advance", table.advance, "a law that knows the duration of the blow beside it", remedy)
    if table.law == "b77-blow" and given not in (None, FROM_THE_BLOW):
        accepted = "no number beside the law b77-blow, which takes it from the blow"
        remedy = f'write restitution = "{FROM_THE_BLOW}", or take law = "b77" for a number'
        raise ParameterError("restitution", given, accepted, remedy)
    if not target and (table.law == "b77-blow" or given == FROM_THE_BLOW):
        key, remedy = ("law" if table.law == "b77-blow" else "restitution"), 'a rigid wall is kind = "wall" in [tool]'
        raise ParameterError(key, getattr(table, key), "a table [tool] that says what the bar strikes", remedy)
