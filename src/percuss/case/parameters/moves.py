"""How each dimensionless parameter is moved in the tables of a case, which keep their units."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from percuss.case.case import case_of, json_tables, without_files
from percuss.case.file_format.reading import value_at, with_value
from percuss.case.parameters.case_keys import LOAD_SCALE, held, varied_keys
from percuss.errors import ParameterError
from percuss.explore.parameters import PARAMETERS
from percuss.model import Bar, Load

if TYPE_CHECKING:
    from percuss.case.case import Case
    from percuss.model import System


# ---- Numbers with their units, as a case has them, taken apart and put together again

_QUANTITY = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*(.*?)\s*", re.ASCII)


def parsed_quantity(given: Any) -> tuple[float | None, str]:
    """Number and unit of a value of a case; None where there is no number."""
    if isinstance(given, int | float) and not isinstance(given, bool):
        return float(given), ""
    match = _QUANTITY.fullmatch(given) if isinstance(given, str) else None
    return (float(match[1]), match[2]) if match else (None, "")


def number_held(case: Case, key: str) -> tuple[float | None, str]:
    """The number that a case holds under a key, and its unit; None where it has none."""
    return parsed_quantity(held(value_at(json_tables(case), key)))


def like(given: Any, value: float) -> Any:
    """The value as it would stand in place of what is given: with its unit, or as a plain number."""
    if isinstance(given, dict):
        return {**given, "value": like(given.get("value"), value)}
    if isinstance(given, str):
        return f"{value!r} {parsed_quantity(given)[1]}"
    return int(value) if isinstance(given, int) and value == int(value) else value


# ---- How each dimensionless parameter is moved in the tables of a case, which keep their units

Tables = dict[str, Any]

_LOADS = ("harmonic", "square", "steps", "fourier", "history")  # a recording is moved as its harmonics
_OF_BODY = {"gap": "gap", "stiffness": "spring", "dashpot": "dashpot"}  # what a structure calls them
_OF_LOAD = ("kappa", "amplitude", "mean", "load_factor")


def can_move(name: str, case: Case, system: System) -> bool:
    """Whether the case has a key by which this parameter is moved."""
    value, kind = PARAMETERS[name].get(system), case.load_table.kind
    if name in _OF_LOAD and kind not in _LOADS:
        return False
    if name in _OF_BODY:
        return not case.is_si
    if name == "mean":
        return bool(value) and kind != "square"
    if not case.is_si or name in (*_OF_LOAD, "restitution"):
        return True
    return isinstance(system.bar, Bar) if name == "s" else bool(value)


def _restitution(tables: Tables, value: float, now: System) -> None:
    table = tables["system" if "system" in tables else "contact"]
    table.pop("receiving_area", None)
    if table.get("law") == "b77-blow":  # it takes the restitution from the blow
        for key in ("law", "advance"):
            table.pop(key, None)
    table["restitution"] = value


def _of_load(name: str) -> Callable[[Tables, float, System], None]:
    """By what the parameter makes of the load; of a square load the load factor moves κ."""

    def move(tables: Tables, value: float, now: System) -> None:
        load, square = tables["load"], tables["load"]["kind"] == "square"
        if name == "mean" and (square or now.load.mean == 0.0):
            raise ParameterError(name, value, "a load with a mean of its own", "move the load factor")
        if name == "kappa" and not square:
            raise ParameterError(name, value, "a square load")
        if name == "amplitude" and now.load.is_constant:
            raise ParameterError(name, value, "a load with an alternating part")
        if square and name in ("kappa", "load_factor"):
            load["kappa"] = value if name == "kappa" else _kappa_of(value)
        else:
            put_load(load, now.load, PARAMETERS[name].put(now, value).load, name)

    return move


def put_load(table: Tables, old: Load, new: Load, name: str) -> None:
    """Write another load into a table that described an old one, in the units of the table; `name`: what is moved."""
    if table["kind"] == "steps":
        unit = max(map(abs, table["values"])) / (max(map(abs, old.values)) or 1.0)
        table["values"] = [unit * value for value in new.values]
    elif table["kind"] == "fourier":
        pairs, was, found = table["coefficients"], old.coefficients.tolist(), new.coefficients.tolist()
        unit = max(math.hypot(*pair) for pair in pairs) / (max(map(abs, was)) or 1.0)
        for k, (before, now) in enumerate(zip(was, found, strict=True)):
            if now != before:
                ratio = (now / before).real if before else 0.0
                pairs[k] = [ratio * one for one in pairs[k]] if before else [unit * now.real, unit * now.imag]
    else:
        first, now_first = (float(np.abs(load.coefficients[1:]).max(initial=0.0)) for load in (old, new))
        for key, before, now in (("amplitude", first, now_first), ("mean", old.mean, new.mean)):
            if now != before:
                of = key if before else "amplitude"
                number, _ = parsed_quantity(table.get(of))
                if number is None:
                    raise ParameterError(name, table.get(of), "a load that is given in numbers")
                table[key] = like(table[of], number * (now / before) if before else abs(number) * now / first)


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
    """In SI by Young's modulus, the only size on which nothing but s = C/(LΩ) depends; a drag stays as it is."""
    if "system" in tables:
        tables["system"]["s"] = value
        return
    if not value > 0.0:
        raise ParameterError("s", value, "a number greater than 0")
    bar, ratio = tables["bar"], value / now.s
    given = bar.get("youngs_modulus", f"{Bar.STEEL_MODULUS / 1e9!r} GPa")
    bar["youngs_modulus"] = like(given, (parsed_quantity(given)[0] or 0.0) * ratio**2)
    if "damping_ratio" in bar and now.d:  # a drag that is told as a share of what is critical, which grows with s
        bar["damping_ratio"] = like(bar["damping_ratio"], (parsed_quantity(bar["damping_ratio"])[0] or 0.0) / ratio)


_DAMPING_KEYS = ("drag", "damping", "damping_ratio")


def _damping(name: str) -> Callable[[Tables, float, System], None]:
    """In SI whatever says how strong the damping is, by its ratio to the value now."""

    def move(tables: Tables, value: float, now: System) -> None:
        system = tables.get("system")
        if system is not None and name == "d":
            system["d"] = value
            return
        table = tables["bar"] if system is None else system
        key = next((key for key in _DAMPING_KEYS if key in table), None)
        present = PARAMETERS[name].get(now)
        if system is not None and isinstance(table.get("damping"), dict):
            table["damping"] = like(table["damping"], value)
        elif key is None or not present:
            raise ParameterError(name, value, "a bar with some damping of this kind", "give it a damping_ratio")
        else:
            held = table[key].get("value") if isinstance(table[key], dict) else table[key]
            table[key] = like(table[key], (parsed_quantity(held)[0] or 0.0) * (value / present))

    return move


def _of_body(key: str) -> Callable[[Tables, float, System], None]:
    def move(tables: Tables, value: float, now: System) -> None:
        tables["body"][key] = value

    return move


MOVES: dict[str, Callable[[Tables, float, System], None]] = {
    "restitution": _restitution,
    **{name: _of_load(name) for name in _OF_LOAD},
    "s": _s,
    "d": _damping("d"),
    "damping_ratio": _damping("damping_ratio"),
    "eta": _damping("eta"),
    **{name: _of_body(key) for name, key in _OF_BODY.items()},
}
"""How each dimensionless parameter is moved: in tables, to a value, from the system that they make now."""

RELATIVE = (*_OF_LOAD, "s", "d", "damping_ratio", "eta")  # what is moved by its ratio to the value now


# ---- A case moved to other values of its parameters, in the units that it is written in: what a slider does


def placed(case: Case, values: Mapping[str, float], harmonics: int = 1024) -> Case:
    """The case with these parameters, named as `percuss.case.parameters.description.parameters` lists them."""
    # A load factor or a mean moves the mean of the load (square: κ), an amplitude its alternating part; a restitution
    # replaces a receiving area; s of a case in SI moves Young's modulus.
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
        if stale and name in (*RELATIVE, LOAD_SCALE):
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
        put_load(tables["load"], now.load, now.load.scaled(value), name)
    else:
        given = value_at(tables, name)
        if given is None:
            raise ParameterError(name, value, "a key that the case has")
        tables.update(with_value(tables, name, like(given, value)))
