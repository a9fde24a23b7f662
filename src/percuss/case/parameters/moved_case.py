"""A case moved to other values of its parameters, in the units that it is written in: what a slider does."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from percuss.case.file_format.dotted_keys import value_at, with_value
from percuss.case.file_format.plain_tables import case_of, json_tables, without_files
from percuss.case.parameters.case_keys import LOAD_SCALE, varied_keys
from percuss.case.parameters.moves import MOVES, RELATIVE, scale_load
from percuss.case.parameters.quantity_text import like
from percuss.errors import ParameterError
from percuss.explore.parameters import PARAMETERS

if TYPE_CHECKING:
    from percuss.case.case import Case
    from percuss.model import System

__all__ = ["placed"]

Tables = dict[str, Any]


def placed(case: Case, values: Mapping[str, float], harmonics: int = 1024) -> Case:
    """The case with these parameters, named as `percuss.case.parameters.parameter_list.parameters` lists them.

    What has a unit keeps it. A load factor or a mean moves the mean of the load (of a square load: κ), an amplitude
    its alternating part; a restitution takes the place of a receiving area; s of a case in SI moves Young's modulus.

    Parameters
    ----------
    values
        By name, in the unit that the case uses.
    harmonics
        See `percuss.case.file_format.plain_tables.case_of`.

    Raises
    ------
    ParameterError
        For a parameter that the case does not have, or cannot be moved to.
    CaseError
        When there is no such hammer.

    Examples
    --------
    >>> from percuss.case import load_case
    >>> moved = placed(load_case("mini-breaker"), {"load_factor": 0.5, "bar.length": 300.0})
    >>> moved.tables.bar.length, round(moved.system().load.load_factor, 12)
    ('300.0 mm', 0.5)
    """
    case = without_files(case)
    tables = json_tables(case)
    keys = [name for name in values if name not in PARAMETERS]
    unknown = sorted(set(keys) - set(varied_keys(case))) if keys else []
    if unknown:
        raise ParameterError(unknown[0], values[unknown[0]], "a parameter of the case; POST /api/case lists them")
    numbers = sorted((name for name in values if name in PARAMETERS), key=lambda name: PARAMETERS[name].turn)
    fixed = [name for name in numbers if name not in MOVES]
    if fixed:
        raise ParameterError(fixed[0], values[fixed[0]], f"one of {', '.join(MOVES)}")
    now, stale = case.system(), False
    for name in [*keys, *numbers]:
        if stale and name in RELATIVE:
            now, stale = case_of(tables).system(), False
        _move(tables, name, values[name], now)
        stale = stale or name != "restitution"
    return case_of(tables, case.file, harmonics)


def _move(tables: Tables, name: str, value: float, now: System) -> None:
    if not math.isfinite(value):
        raise ParameterError(name, value, "a finite number")
    if name in MOVES:
        MOVES[name](tables, value, now)
    elif name == LOAD_SCALE:
        scale_load(tables["load"], name, value)
    else:
        given = value_at(tables, name)
        if given is None:
            raise ParameterError(name, value, "a key that the case has")
        tables.update(with_value(tables, name, like(given, value)))
