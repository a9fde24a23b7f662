"""How each dimensionless parameter is moved in the tables of a case, which keep their units."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from percuss.case.file_format.plain_tables import case_of, json_tables, without_files
from percuss.case.file_format.reading import value_at, with_value
from percuss.case.parameters.case_keys import LOAD_SCALE, varied_keys
from percuss.errors import ParameterError
from percuss.explore.parameters import PARAMETERS
from percuss.model import Bar, Load

if TYPE_CHECKING:
    from percuss.case.case import Case
    from percuss.model import System


# ---- Numbers with their units, as a case has them, taken apart and put together again

_QUANTITY = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*(.*?)\s*", re.ASCII)


def parsed_quantity(given: Any) -> tuple[float | None, str]:
    """Number and unit of a value of a case; None where there is no number.

    Examples
    --------
    >>> parsed_quantity("341 mm"), parsed_quantity(0.2)
    ((341.0, 'mm'), (0.2, ''))
    """
    if isinstance(given, int | float) and not isinstance(given, bool):
        return float(given), ""
    match = _QUANTITY.fullmatch(given) if isinstance(given, str) else None
    return (float(match[1]), match[2]) if match else (None, "")


def like(given: Any, value: float) -> Any:
    """The value as it would stand in place of what is given: with its unit, or as a plain number.

    Examples
    --------
    >>> like("341 mm", 300.0), like(0.2, 0.3), like({"kind": "ratio", "value": 0.001}, 0.002)
    ('300.0 mm', 0.3, {'kind': 'ratio', 'value': 0.002})
    """
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


_PARTS = {"harmonic": ("mean", "amplitude"), "square": ("amplitude",), "steps": ("values",)}


def scale_load(load: Tables, name: str, factor: float, keys: tuple[str, ...] | None = None) -> None:
    """The numbers of a load times a factor: all of them, or those of some keys."""
    for key in keys or _PARTS.get(load["kind"], ("coefficients",)):
        given = load.get(key)
        if key == "values" and given is not None:
            load[key] = [factor * x for x in given]
            continue
        if key == "coefficients" and given is not None:
            load[key] = [[factor * re, factor * im] for re, im in given]
            continue
        number, _ = parsed_quantity(given)
        if number is None:
            raise ParameterError(name, given, "a load that is given in numbers")
        load[key] = like(given, factor * number)


def _restitution(tables: Tables, value: float, now: System) -> None:
    table = tables["system" if "system" in tables else "contact"]
    table.pop("receiving_area", None)
    if table.get("law") == "b77-blow":  # it takes the restitution from the blow
        for key in ("law", "advance"):
            table.pop(key, None)
    table["restitution"] = value


def _load_factor(tables: Tables, value: float, now: System) -> None:
    load = tables["load"]
    if load["kind"] == "square":
        load["kappa"] = _kappa_of(value)
    elif load["kind"] == "fourier":
        pairs = load["coefficients"]
        first = next((math.hypot(*pair) for pair in pairs[1:] if any(pair)), 0.0)
        load["coefficients"] = [[value * first, 0.0], *pairs[1:]]
    elif load["kind"] == "steps":
        steps = _steps(load)
        _shift(load, value * abs(complex(steps.coefficients[int(steps.harmonics[0])])))
    elif now.load.mean != 0.0:
        scale_load(load, "load_factor", value / now.load.load_factor, ("mean",))
    else:
        number, _ = parsed_quantity(load["amplitude"])
        load["mean"] = like(load["amplitude"], value * abs(number or 0.0))


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


def _mean(tables: Tables, value: float, now: System) -> None:
    load = tables["load"]
    if load["kind"] == "square" or now.load.mean == 0.0:
        raise ParameterError("mean", value, "a load with a mean of its own", "move the load factor")
    ratio = value / now.load.mean
    if load["kind"] == "fourier":
        load["coefficients"] = [[ratio * load["coefficients"][0][0], 0.0], *load["coefficients"][1:]]
    elif load["kind"] == "steps":
        _shift(load, ratio * _steps(load).mean)
    else:
        scale_load(load, "mean", ratio, ("mean",))


def _amplitude(tables: Tables, value: float, now: System) -> None:
    load = tables["load"]
    present = PARAMETERS["amplitude"].get(now)
    if present is None:
        raise ParameterError("amplitude", value, "a load with an alternating part")
    ratio = value / present
    if load["kind"] == "fourier":
        rest = [[ratio * re, ratio * im] for re, im in load["coefficients"][1:]]
        load["coefficients"] = [load["coefficients"][0], *rest]
    elif load["kind"] == "steps":
        mean = _steps(load).mean
        load["values"] = [mean + ratio * (x - mean) for x in load["values"]]
    else:
        scale_load(load, "amplitude", ratio, ("amplitude",))


def _steps(load: Tables) -> Load:
    """A load of steps, in the unit of its values."""
    return Load.steps(load["breaks"], load["values"], load.get("harmonics", 64))


def _shift(load: Tables, mean: float) -> None:
    """The same steps about another mean."""
    load["values"] = list(_steps(load).with_mean(mean).values)


def _kappa(tables: Tables, value: float, now: System) -> None:
    if tables["load"]["kind"] != "square":
        raise ParameterError("kappa", value, "a square load")
    tables["load"]["kappa"] = value


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
    "load_factor": _load_factor,
    "kappa": _kappa,
    "mean": _mean,
    "amplitude": _amplitude,
    "s": _s,
    "d": _damping("d"),
    "damping_ratio": _damping("damping_ratio"),
    "eta": _damping("eta"),
    **{name: _of_body(key) for name, key in _OF_BODY.items()},
}
"""How each dimensionless parameter is moved: in tables, to a value, from the system that they make now."""

RELATIVE = ("amplitude", "mean", "load_factor", "s", "d", "damping_ratio", "eta")
"""What is moved by its ratio to the value now."""


# ---- A case moved to other values of its parameters, in the units that it is written in: what a slider does


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
