"""What is known of a case before anything is computed: its form in SI and in plain numbers, its scales."""

from __future__ import annotations

import math
import re
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from percuss.case.answers.clock_note import clock_note
from percuss.case.answers.json_values import body_dict, contact_dict, number, plain, system_dict
from percuss.case.file_format.plain_tables import fourier_table, json_tables, system_table
from percuss.case.file_format.schema import PhysicalCase
from percuss.case.parameters.case_family import CaseFamily
from percuss.errors import PercussError
from percuss.explore.family import PARAMETERS

if TYPE_CHECKING:
    from percuss.case.case import Case
    from percuss.model import Load, System

__all__ = ["case_dict", "parameters", "parsed_quantity", "plain_tables"]

_QUANTITY = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*(.*?)\s*", re.ASCII)


def case_dict(case: Case) -> dict[str, Any]:
    """A checked case as JSON: its tables and text, the system, scales and bar, and what of it a map may vary.

    Raises
    ------
    CaseError
        When its recording cannot be used, or its parts make no system.
    """
    system = case.system()
    report = case.history_report
    return {
        "title": case.title,
        "si": case.is_si,
        "tables": json_tables(case),
        "toml": case.to_toml(),
        "system": system_dict(system),
        "body": body_dict(system),
        "contact": contact_dict(system),
        "plain": plain_tables(case),
        "scales": _scales(system),
        "bar": _bar(system),
        "first_mode": number(math.pi * system.s),
        "history": None if report is None else plain(asdict(report)),
        "notes": list(case.notes),
        "clock": clock_note(case.load()),
        "parameters": parameters(case),
    }


def plain_tables(case: Case) -> dict[str, Any]:
    """The dimensionless form of a case, without start and simulation."""
    system = case.system()
    title = {} if case.tables.title is None else {"title": case.tables.title}
    load = _plain_load(case, system.load)
    return {**title, "system": system_table(system), "load": {**load, "at": system.load.at} if system.load.at else load}


def _plain_load(case: Case, load: Load) -> dict[str, Any]:
    """A load of the kind that the case has, else by its harmonics."""
    kind = case.tables.load.kind
    if kind == "square" and load.values:
        pushes = max(load.values)
        return {
            "kind": kind,
            "amplitude": pushes,
            "kappa": getattr(case.tables.load, "kappa", 1.0),
            "harmonics": load.coefficients.size - 1,
        }
    if kind == "steps":
        return {"kind": kind, "breaks": list(load.breaks), "values": list(load.values)} | {
            "harmonics": load.coefficients.size - 1
        }
    k = [int(k) for k in load.harmonics]
    if kind == "harmonic" and len(k) == 1:
        amplitude = load.coefficients[k[0]]
        if amplitude.imag == 0.0:
            return {"kind": kind, "mean": load.mean, "amplitude": float(amplitude.real), "harmonic": k[0]}
    found = fourier_table(load)
    return {"kind": "fourier", "coefficients": found["coefficients"]}


def _scales(system: System) -> dict[str, Any] | None:
    if not system.is_si:
        return None
    return {
        "length_m": number(system.length_scale),
        "time_s": number(system.time_scale),
        "speed_m_s": number(system.speed_scale),
        "force_N": number(system.force_scale),
        "energy_J": number(system.energy_scale),
        "power_W": number(system.power_scale),
        "stress_Pa": number(system.stress_scale),
        "frequency_Hz": number(system.frequency),
    }


def _bar(system: System) -> dict[str, Any] | None:
    bar = system.bar
    if bar is None:
        return None
    return {
        "length_m": number(bar.length),
        "area_m2": number(bar.pieces[-1].area),
        "mass_kg": number(bar.mass),
        "wave_speed_m_s": number(bar.wave_speed),
        "youngs_modulus_Pa": number(bar.pieces[-1].youngs_modulus),
        "density_kg_m3": number(bar.pieces[-1].density),
        "first_mode_Hz": number(bar.wave_speed / (2.0 * bar.length)),
        "contact_time_us": number(1e6 * bar.contact_duration),
    }


# -- what may be varied ---------------------------------------------------------------------------------------------


def parameters(case: Case) -> list[dict[str, Any]]:
    """What a map of the case may have as an axis, with the unit of the case, the value now, and a range around it."""
    return [*_plain_parameters(case), *_keys(case)]


def _plain_parameters(case: Case) -> list[dict[str, Any]]:
    system = case.system()
    now = _values_now(system)
    found = []
    for name, parameter in PARAMETERS.items():
        try:
            parameter.check(system)
        except PercussError:
            continue
        value = now.get(name)
        low, high = _RANGES.get(name) or _around(value)
        if name == "load_factor" and value is not None:
            high = max(high, 1.25 * value)
        movable = True
        if name == "d" and case.is_si:
            movable = bool(value)
        if name == "mean":
            movable = bool(value) and case.tables.load.kind != "square"
        found.append(_parameter(name, "", value, low, high, parameter.meaning) | {"movable": movable})
    return found


_RANGES = {"restitution": (0.0, 0.9), "load_factor": (0.02, 1.2), "kappa": (0.1, 1.9), "d": (0.0, 0.1)}


def _values_now(system: System) -> dict[str, float]:
    load = system.load
    now = {"restitution": system.restitution, "s": system.s, "d": system.d, "mean": load.mean}
    if not load.is_constant:
        now["load_factor"] = load.load_factor
        now["amplitude"] = abs(complex(load.coefficients[int(load.harmonics[0])]))
    if len(load.values) == 2:
        now["kappa"] = load.breaks[1] / math.pi
    return now


def _keys(case: Case) -> list[dict[str, Any]]:
    family = CaseFamily(case, {})
    tables = json_tables(case)
    found = []
    for key in family._keys:
        table, _, name = key.partition(".")
        if key == "load.scale":
            found.append(_parameter(key, "", 1.0, 0.5, 1.5, "a factor on the whole load"))
            continue
        given = tables.get(table, {}).get(name)
        if given is None or (name in PARAMETERS and not isinstance(case.tables, PhysicalCase)):
            continue
        value, unit = parsed_quantity(given)
        if value is None:
            continue
        low, high = _around(value)
        found.append(_parameter(key, unit, value, low, high, ""))
    return found


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


def _around(value: float | None) -> tuple[float, float]:
    if not value:
        return (0.0, 1.0)
    ends = (0.5 * value, 1.5 * value)
    return min(ends), max(ends)


def _parameter(name: str, unit: str, value: float | None, low: float, high: float, meaning: str) -> dict[str, Any]:
    return {
        "name": name,
        "unit": unit,
        "value": number(value),
        "low": number(low),
        "high": number(high),
        "dimensionless": name in PARAMETERS,
        "movable": True,
        "meaning": meaning,
    }
