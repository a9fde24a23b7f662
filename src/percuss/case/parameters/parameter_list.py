"""What of a case may be varied: every parameter with its words, its unit, its value and a range around it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from percuss.case.answers.json_values import number
from percuss.case.file_format.dotted_keys import value_at
from percuss.case.file_format.load_tables import HistoryForce
from percuss.case.file_format.plain_tables import json_tables
from percuss.case.parameters.case_keys import FREQUENCY, LOAD_SCALE, held, key_of, varied_keys
from percuss.case.parameters.moves import MOVES, can_move
from percuss.case.parameters.quantity_text import parsed_quantity
from percuss.case.parameters.valve_keys import LOAD_PRESSURE, valve_label
from percuss.errors import PercussError
from percuss.explore.parameters import PARAMETERS
from percuss.explore.planes import AXES
from percuss.model.body import HeldBody, Mounted

if TYPE_CHECKING:
    from percuss.case.case import Case
    from percuss.model import System
    from percuss.model.parameter import Parameter

__all__ = ["parameters", "quantity_of"]

_SLIDES = ("restitution", "load_factor", "kappa")
"""What has a slider in every case; the numbers of the bar have one in a dimensionless case."""


def parameters(case: Case) -> list[dict[str, Any]]:
    """What a map of the case may have as an axis, with the unit of the case, the value now, and a range around it.

    A machine that switches itself has the keys of its case alone, its ports named as its pictures name them.
    """
    return _keys(case) if case.is_machine else [*_dimensionless(case), *_keys(case)]


def _dimensionless(case: Case) -> list[dict[str, Any]]:
    system, keys = case.system(), varied_keys(case)
    found = []
    for name, parameter in PARAMETERS.items():
        if _has(parameter, system) and f"bar.{name}" not in keys:
            found.append(_row_of(parameter, case, system))
    square = any(row["name"] == "kappa" for row in found)
    for row in found:
        row["slides"] = row["movable"] and _slides(row["name"], case.is_si, square)
    return found


def _has(parameter: Parameter[System], system: System) -> bool:
    """Whether a map of the system is offered the parameter: of all laws of damping only that of the body."""
    own = system.body.damping.parameter
    if parameter.sets == "damping" and (own is None or own.name != parameter.name):
        return False
    if parameter.name in ("s", "d") and _is_without_waves(system):
        return False
    try:
        parameter.check(system)
    except PercussError:
        return False
    return True


def _is_without_waves(system: System) -> bool:
    """Whether it is a structure told by its modes, or a rigid mass."""
    body = system.body
    return isinstance(body, HeldBody) and (not isinstance(body, Mounted) or body.is_rigid)


def _slides(name: str, si: bool, square: bool) -> bool:
    """In SI the numbers of the bar follow from its sizes; the mean of a square load follows from κ."""
    of_bar = name not in _SLIDES and name not in ("mean", "amplitude")
    return (of_bar and not si) or (name in _SLIDES and not (square and name == "load_factor"))


def _row_of(parameter: Parameter[System], case: Case, system: System) -> dict[str, Any]:
    value = parameter.get(system)
    low, high = parameter.span or _around(value)
    if parameter.name == "load_factor" and value is not None:
        high = max(high, 1.25 * value)
    row = _row(parameter.name, "", value, low, high)
    movable = parameter.name in MOVES and can_move(parameter.name, case, system)
    words = {"label": parameter.label, "meaning": parameter.meaning, "plane": parameter.name in AXES}
    return row | words | {"dimensionless": True, "movable": movable}


def _keys(case: Case) -> list[dict[str, Any]]:
    found = []
    names = varied_keys(case)
    none = {LOAD_SCALE} if case.is_machine and LOAD_PRESSURE in names else set()  # the pressure is the same
    for name in names:
        table, _, key = name.partition(".")
        if name in none or table == "blow" or (table in ("tool", "rock") and not case.is_from_blow):
            continue  # the motion does not depend on it
        about = key_of(name)
        plain = not case.is_si and not case.is_machine
        if plain and (table == "system" or key in PARAMETERS or about.sets in PARAMETERS):
            continue  # a dimensionless parameter is the same
        value, unit = (1.0, "") if name == LOAD_SCALE else quantity_of(case, name)
        if value is None:
            continue
        label = about.label or valve_label(case.tables.load, name)
        row = _row(name, unit, value, *(_span(case, key) or _around(value)))
        kept = name == FREQUENCY and isinstance(case.tables.load, HistoryForce)  # there it says where cycles are cut
        row |= {"label": label, "meaning": about.meaning, "slides": about.slides and not kept}
        row["movable"] = not (kept or (case.is_machine and name == LOAD_SCALE))  # that is no key of its tables
        found.append(row)
    return found


def quantity_of(case: Case, key: str) -> tuple[float | None, str]:
    """The number of a key of the case, and its unit; the frequency of a recording, which may keep its waveform."""
    value, unit = parsed_quantity(held(value_at(json_tables(case), key)))
    if value is None and key == FREQUENCY and isinstance(case.tables.load, HistoryForce):
        return case.system().frequency, "Hz"
    return value, unit


def _span(case: Case, key: str) -> tuple[float, float] | None:
    """The range of a key of a machine that has one of its own, as its dimensionless parameter has it."""
    return PARAMETERS[key].span if case.is_machine and key == "restitution" else None


def _around(value: float | None) -> tuple[float, float]:
    if not value:
        return (0.0, 1.0)
    ends = (0.5 * value, 1.5 * value)
    return min(ends), max(ends)


def _row(name: str, unit: str, value: float | None, low: float, high: float) -> dict[str, Any]:
    return {
        "name": name,
        "label": name,
        "meaning": "",
        "unit": unit,
        "value": number(value),
        "low": number(low),
        "high": number(high),
        "dimensionless": False,
        "plane": False,
        "movable": True,
        "slides": False,
    }
