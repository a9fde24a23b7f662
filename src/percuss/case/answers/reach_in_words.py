"""How far a parameter of a case may move, as a value, as a sentence in the units of the case, and as JSON."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from percuss.case.answers.json_values import number as plain_number
from percuss.case.answers.numerals import number
from percuss.explore.continuation.kinds import BranchEvent
from percuss.shown import Shown

if TYPE_CHECKING:  # most answers tell no reach, and need not wait for all of the continuation
    from percuss.explore.continuation.reaching import Reach, ReachEnd

__all__ = ["CaseReach", "ends_in_words", "reach_dict", "reach_in_words"]


@dataclass(frozen=True)
class CaseReach(Shown):
    """How far one parameter of a case may move.

    Parameters
    ----------
    name, label, unit
        Of the parameter.
    value
        That of the case, in the unit.
    found
        How far it may move; None where it cannot be told.
    refusal
        Why not.
    """

    name: str
    label: str
    unit: str
    value: float
    found: Reach | None
    refusal: str = ""

    def __str__(self) -> str:
        return reach_in_words(self)


_WHERE = {
    BranchEvent.FOLD: "where the motion ceases to exist",
    BranchEvent.NONSMOOTH_FOLD: "where the blow meets a step of the load and the motion ceases to exist",
    BranchEvent.FLIP: "where the period doubles",
    BranchEvent.NEIMARK_SACKER: "where the motion begins to waver, by a pair of multipliers",
    BranchEvent.CROSSING: "where another motion takes over, as a multiplier passes 1",
    BranchEvent.CORNER: "where the blow meets a step of the load and is no longer stable",
    BranchEvent.TOUCH: "where the bar touches the wall between two blows",
    BranchEvent.DEATH: "where the blow has no speed left",
    BranchEvent.STICKING: "where the bar would rest on the wall after a blow",
    BranchEvent.NO_PUSH: "where the load stops pushing",
    BranchEvent.NO_SYSTEM: "beyond which there is no such hammer",
    BranchEvent.RESONANCE: "where an elastic mode resonates",
    BranchEvent.COALESCENCE: "where two blows fall together",
    BranchEvent.LOST: "beyond which the motion could not be followed",
}

_OF_STRUCTURES = {"the bar": "the structure", "blow": "impact", "hammer": "structure", "an elastic mode": "a mode"}
"""The words for a structure that is held."""


def reach_in_words(row: CaseReach) -> str:
    """One sentence of a parameter."""
    return f"{row.label} = {ends_in_words(row)}"


def ends_in_words(row: CaseReach) -> str:
    """The sentence behind the name of the parameter."""
    unit = f" {row.unit}" if row.unit else ""
    head = f"{number(row.value)}{unit}"
    if row.found is None:
        return f"{head}: {row.refusal}"
    below, above = (_end(one, unit) for one in (row.found.below, row.found.above))
    return f"{head}: down to {below}; up to {above}"


def _end(end: ReachEnd, unit: str) -> str:
    then = "" if end.then is None else f" (then {end.then})"
    if end.is_open:
        return f"{number(end.value)}{unit} and further"
    where = _WHERE.get(end.kind, end.kind.words)
    if not end.orbit.system.body.is_free:
        for word, other in _OF_STRUCTURES.items():
            where = where.replace(word, other)
    return f"{number(end.value)}{unit}, {where}{then}"


def reach_dict(rows: Sequence[CaseReach]) -> list[dict[str, Any]]:
    """The same in plain values."""
    return [
        {
            "parameter": row.name,
            "label": row.label,
            "unit": row.unit,
            "value": row.value,
            "below": None if row.found is None else _end_dict(row.found.below),
            "above": None if row.found is None else _end_dict(row.found.above),
            "text": reach_in_words(row),
        }
        for row in rows
    ]


def _end_dict(end: ReachEnd) -> dict[str, Any]:
    return {
        "type": end.kind.value,
        "value": plain_number(end.value),
        "phase": plain_number(end.orbit.phase),
        "beyond": end.beyond,
        "then": end.then,
    }
