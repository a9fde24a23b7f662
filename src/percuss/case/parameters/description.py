"""What is known of a case before anything is computed: its form in SI and in plain numbers, its scales."""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from percuss.case.answers.clock_note import clock_note
from percuss.case.answers.json_values import body_dict, contact_dict, number, plain, system_dict
from percuss.case.file_format.plain_tables import fourier_table, json_tables, system_table
from percuss.case.file_format.schema import PhysicalCase
from percuss.case.parameters.machine_description import bar_dict, laws_dict, machine_case_dict
from percuss.case.parameters.parameter_list import parameters

if TYPE_CHECKING:
    from percuss.case.case import Case
    from percuss.model import Load, System

__all__ = ["case_dict", "plain_tables"]


def case_dict(case: Case) -> dict[str, Any]:
    """A checked case as JSON: its tables and text, the system, scales and bar, and what of it a map may vary.

    A machine that switches itself has the same keys, and no system; a structure that is held has no form in plain
    numbers.

    Raises
    ------
    CaseError
        When its recording cannot be used, or its parts make no system and no machine.
    """
    if case.is_machine:
        return machine_case_dict(case)
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
        "laws": laws_dict(system),
        "plain": None if case.tables.body is not None else plain_tables(case),
        "scales": _scales(system),
        "bar": _bar(system),
        "first_mode": number(system.body.frequencies(1)[0]),
        "history": None if report is None else plain(asdict(report)),
        "notes": list(case.notes),
        "clock": clock_note(case.load()),
        "parameters": parameters(case),
    }


def _bar(system: System) -> dict[str, Any] | None:
    """The bar with its sizes; of a structure that is held only where a bar is on its spring."""
    if system.bar is None or not system.bar.pieces:
        return None
    return bar_dict(system.bar, system.frequency or 0.0, system.body)


def plain_tables(case: Case) -> dict[str, Any]:
    """The dimensionless form of a case, without start and simulation."""
    system = case.system()
    title = {} if case.tables.title is None else {"title": case.tables.title}
    load = _plain_load(case, system.load)
    own = {**system_table(system), **_plain_law(case)}
    return {**title, "system": own, "load": {**load, "at": system.load.at} if system.load.at else load}


def _plain_law(case: Case) -> dict[str, Any]:
    """The law of a blow that needs no tool; the tool of a case in SI has no dimensionless form."""
    given = case.tables.contact if isinstance(case.tables, PhysicalCase) else case.tables.system
    if given is None or given.law != "b77-tau":
        return {}
    return {key: getattr(given, key) for key in ("law", "advance") if getattr(given, key) is not None}


def _plain_load(case: Case, load: Load) -> dict[str, Any]:
    """A load of the kind that the case has, else by its harmonics."""
    kind = case.load_table.kind
    if kind == "square" and load.values:
        pushes = max(load.values)
        return {
            "kind": kind,
            "amplitude": pushes,
            "kappa": getattr(case.load_table, "kappa", 1.0),
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
        "stress_Pa": number(system.stress_scale) if system.bar is not None and system.bar.pieces else None,
        "frequency_Hz": number(system.frequency),
    }
