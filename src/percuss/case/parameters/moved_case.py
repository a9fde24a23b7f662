"""A case moved to other values of its parameters, in the units that it is written in: what a slider does."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from percuss.case.file_format.plain_tables import case_of, json_tables, without_recording
from percuss.case.parameters.case_family import CaseFamily
from percuss.case.parameters.description import parsed_quantity
from percuss.errors import ParameterError
from percuss.explore.family import PARAMETERS
from percuss.model import Bar, Load

if TYPE_CHECKING:
    from percuss.case.case import Case
    from percuss.model import System

__all__ = ["MOVABLE", "placed"]

Tables = dict[str, Any]


def placed(case: Case, values: Mapping[str, float], harmonics: int = 1024) -> Case:
    """The case with these parameters, named as `percuss.case.parameters.description.parameters` lists them.

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
    case = without_recording(case)
    tables = json_tables(case)
    family = CaseFamily(case, {})
    for name in values:
        if name not in PARAMETERS and name not in family._keys:
            raise ParameterError(name, values[name], "a parameter of the case; POST /api/case lists them")
    keys = [name for name in values if name not in PARAMETERS]
    now, stale = case.system(), False
    for name in [*keys, *(name for name in MOVABLE if name in values)]:
        if stale and name in _RELATIVE:
            now, stale = case_of(tables).system(), False
        _move(tables, name, values[name], now)
        stale = stale or name != "restitution"
    fixed = [name for name in values if name in PARAMETERS and name not in MOVABLE]
    if fixed:
        raise ParameterError(fixed[0], values[fixed[0]], f"one of {', '.join(MOVABLE)}")
    return case_of(tables, case.file, harmonics)


def _move(tables: Tables, name: str, value: float, now: System) -> None:
    if not math.isfinite(value):
        raise ParameterError(name, value, "a finite number")
    if name in MOVABLE:
        MOVABLE[name](tables, value, now)
    elif name == "load.scale":
        _scale(tables["load"], name, lambda number: number * value, _parts(tables["load"]))
    else:
        table, _, key = name.partition(".")
        if key not in tables.get(table, {}):
            raise ParameterError(name, value, "a key that the case has")
        tables[table][key] = _like(tables[table][key], value)


def _like(given: Any, value: float) -> Any:
    """The value as it would stand in place of what is given: with its unit, or as a plain number."""
    if isinstance(given, str):
        return f"{value!r} {parsed_quantity(given)[1]}"
    return int(value) if isinstance(given, int) and value == int(value) else value


def _parts(load: Tables) -> tuple[str, ...]:
    return {"harmonic": ("mean", "amplitude"), "square": ("amplitude",)}.get(load["kind"], ("coefficients",))


def _scale(load: Tables, name: str, change: Callable[[float], float], keys: tuple[str, ...]) -> None:
    for key in keys:
        given = load[key]
        if key == "coefficients":
            load[key] = [[change(re), change(im)] for re, im in given]
            continue
        number, _ = parsed_quantity(given)
        if number is None:
            raise ParameterError(name, given, "a load that is given in numbers")
        load[key] = _like(given, change(number))


# -- dimensionless parameters ---------------------------------------------------------------------------------------


def _restitution(tables: Tables, value: float, now: System) -> None:
    if "system" in tables:
        tables["system"]["restitution"] = value
        return
    tables["contact"] = {"restitution": value}


def _load_factor(tables: Tables, value: float, now: System) -> None:
    load = tables["load"]
    if load["kind"] == "square":
        load["kappa"] = _kappa_of(value)
    elif load["kind"] == "fourier":
        pairs = load["coefficients"]
        first = next((math.hypot(*pair) for pair in pairs[1:] if any(pair)), 0.0)
        load["coefficients"] = [[value * first, 0.0], *pairs[1:]]
    elif now.load.mean != 0.0:
        _scale(load, "load_factor", lambda number: number * (value / now.load.load_factor), ("mean",))
    else:
        number, _ = parsed_quantity(load["amplitude"])
        load["mean"] = _like(load["amplitude"], value * abs(number or 0.0))


def _mean(tables: Tables, value: float, now: System) -> None:
    load = tables["load"]
    if load["kind"] == "square" or now.load.mean == 0.0:
        raise ParameterError("mean", value, "a load with a mean of its own", "move the load factor")
    ratio = value / now.load.mean
    if load["kind"] == "fourier":
        load["coefficients"] = [[ratio * load["coefficients"][0][0], 0.0], *load["coefficients"][1:]]
    else:
        _scale(load, "mean", lambda number: number * ratio, ("mean",))


def _amplitude(tables: Tables, value: float, now: System) -> None:
    load = tables["load"]
    if now.load.is_constant:
        raise ParameterError("amplitude", value, "a load with an alternating part")
    ratio = value / abs(complex(now.load.coefficients[int(now.load.harmonics[0])]))
    if load["kind"] == "fourier":
        rest = [[ratio * re, ratio * im] for re, im in load["coefficients"][1:]]
        load["coefficients"] = [load["coefficients"][0], *rest]
    else:
        _scale(load, "amplitude", lambda number: number * ratio, ("amplitude",))


def _kappa(tables: Tables, value: float, now: System) -> None:
    if tables["load"]["kind"] != "square":
        raise ParameterError("kappa", value, "a square load")
    tables["load"]["kappa"] = value


def _kappa_of(load_factor: float) -> float:
    """κ of the square load with this load factor, which grows with κ."""
    low, high = 1e-9, 2.0 - 1e-9
    for _ in range(60):
        middle = 0.5 * (low + high)
        if Load.square(1.0, middle, 1).load_factor < load_factor:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


def _s(tables: Tables, value: float, now: System) -> None:
    """In SI by Young's modulus, the only size on which nothing but s = C/(LΩ) depends; the damping D stays."""
    if "system" in tables:
        tables["system"]["s"] = value
        return
    if not value > 0.0:
        raise ParameterError("s", value, "a number greater than 0")
    bar, ratio = tables["bar"], value / now.s
    given = bar.get("youngs_modulus", f"{Bar.STEEL_MODULUS / 1e9!r} GPa")
    bar["youngs_modulus"] = _like(given, (parsed_quantity(given)[0] or 0.0) * ratio**2)
    if "damping_ratio" in bar:
        bar["damping_ratio"] = _like(bar["damping_ratio"], (parsed_quantity(bar["damping_ratio"])[0] or 0.0) / ratio)


def _d(tables: Tables, value: float, now: System) -> None:
    if "system" in tables:
        tables["system"]["d"] = value
        return
    bar = tables["bar"]
    key = "damping" if "damping" in bar else "damping_ratio"
    if key not in bar or now.d == 0.0:
        raise ParameterError("d", value, "a bar with some damping", "give it a damping_ratio")
    number, _ = parsed_quantity(bar[key])
    bar[key] = _like(bar[key], (number or 0.0) * (value / now.d))


MOVABLE: dict[str, Callable[[Tables, float, System], None]] = {
    "kappa": _kappa,
    "amplitude": _amplitude,
    "mean": _mean,
    "load_factor": _load_factor,
    "restitution": _restitution,
    "s": _s,
    "d": _d,
}
"""How each dimensionless parameter is moved; the shape of the load before its size, as in `percuss.explore`."""

_RELATIVE = ("amplitude", "mean", "load_factor", "s", "d")
"""What is moved by its ratio to the value now."""
