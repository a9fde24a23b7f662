"""How far a parameter of a case may move, as a value, as a sentence in the units of the case, and as JSON."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from percuss.case.answers.numerals import json_number as plain_number
from percuss.case.answers.numerals import number
from percuss.explore.continuation.branch import BranchEvent
from percuss.shown import Shown

if TYPE_CHECKING:  # most answers tell no reach, and need not wait for all of the continuation
    from percuss.explore.continuation.reaching import Reach, ReachEnd


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
    BranchEvent.NONSMOOTH_FOLD: "where the {blow} meets a step of the load and the motion ceases to exist",
    BranchEvent.FLIP: "where the period doubles",
    BranchEvent.NEIMARK_SACKER: "where the motion begins to waver, by a pair of multipliers",
    BranchEvent.CROSSING: "where another motion takes over, as a multiplier passes 1",
    BranchEvent.CORNER: "where the {blow} meets a step of the load and is no longer stable",
    BranchEvent.TOUCH: "where the {bar} touches the wall between two {blow}s",
    BranchEvent.DEATH: "where the {blow} has no speed left",
    BranchEvent.STICKING: "where the {bar} would rest on the wall after {blow_}",
    BranchEvent.NO_PUSH: "where the load stops pushing",
    BranchEvent.NO_SYSTEM: "beyond which there is no such {system}",
    BranchEvent.RESONANCE: "where {mode_} resonates",
    BranchEvent.COALESCENCE: "where two {blow}s fall together",
    BranchEvent.LOST: "beyond which the motion could not be followed",
}
_HAMMER = {"bar": "bar", "blow": "blow", "blow_": "a blow", "system": "hammer", "mode_": "an elastic mode"}
_STRUCTURE = {"bar": "structure", "blow": "impact", "blow_": "an impact", "system": "structure", "mode_": "a mode"}
_LAST = {"restitution": (0.0, 1.0), "kappa": (0.0, 2.0)} | dict.fromkeys(
    ("d", "damping", "damping_ratio", "drag", "eta", "dashpot"), (0.0,)
)  # values beyond which there are none


def reach_in_words(row: CaseReach) -> str:
    """One sentence of a parameter."""
    return f"{row.label} = {ends_in_words(row)}"


def ends_in_words(row: CaseReach) -> str:
    """The sentence behind the name of the parameter."""
    unit = f" {row.unit}" if row.unit else ""
    head = f"{number(row.value)}{unit}"
    if row.found is None:
        return f"{head}: {row.refusal}"
    below, above = (_end(one, unit, row.name.rpartition(".")[2]) for one in (row.found.below, row.found.above))
    return f"{head}: down to {below}; up to {above}"


def _end(end: ReachEnd, unit: str, name: str) -> str:
    then = "" if end.then is None else f" (then {end.then})"
    if end.is_open:
        return f"{number(end.value)}{unit}{'' if end.value in _LAST.get(name, ()) else ' and further'}"
    names = _HAMMER if end.orbit.system.body.is_free else _STRUCTURE
    return f"{number(end.value)}{unit}, {_WHERE.get(end.kind, end.kind.words).format(**names)}{then}"


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
