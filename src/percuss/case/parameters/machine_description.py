"""What is known of a case whose load the piston switches before its cycle is computed; see `description`."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from percuss.case.answers.json_values import contact_dict, number, numbers
from percuss.case.file_format.body_building import body_table
from percuss.case.file_format.damping_table import damping_table
from percuss.case.file_format.plain_tables import json_tables
from percuss.case.parameters.parameter_list import parameters
from percuss.model import External, Kept

if TYPE_CHECKING:
    from percuss.case.case import Case
    from percuss.model import Machine, Port, SizedBody, System
    from percuss.model.body import Body

__all__ = ["bar_dict", "laws_dict", "machine_case_dict"]

_MODES = 8
"""Elastic modes that are told of the body."""


def machine_case_dict(case: Case) -> dict[str, Any]:
    """A checked case as JSON, with the keys of `percuss.case.parameters.description.case_dict`; it has no system.

    Raises
    ------
    CaseError
        When its parts make no machine.
    """
    machine = case.machine()
    body, bar = machine.body, machine.bar
    modes = body.modes(_MODES, machine.at)
    described = {name: numbers(getattr(modes, key)) for name, key in _OF_MODES.items()}
    return {
        "title": case.title,
        "si": case.is_si,
        "tables": json_tables(case),
        "toml": case.to_toml(),
        "system": None,
        "body": {"kind": body.kind, **described},
        "contact": contact_dict(machine),
        "laws": laws_dict(machine),
        "plain": _plain_tables(case, machine),
        "scales": _scales(machine) if machine.is_si else None,
        "bar": None if bar is None else bar_dict(bar, 0.5 / (math.pi * machine.time_scale), body),
        "first_mode": number(body.frequencies(1)[0]),
        "history": None,
        "notes": list(case.notes),
        "clock": "",
        "parameters": parameters(case),
    }


_OF_MODES = {"frequencies": "omega", "gamma": "gamma", "damping": "damping"}


def laws_dict(system: System | Machine) -> dict[str, str]:
    """The laws of damping and contact in words."""
    return {"damping": system.body.damping.words, "contact": system.contact.sentence}


def bar_dict(bar: SizedBody, rate: float, body: Body) -> dict[str, Any]:
    """A bar in SI; `rate` is 1 radian per unit of time of its dimensionless body, in Hz."""
    first = body.frequencies(1)[0] * rate
    return {
        "length_m": number(bar.length),
        "area_m2": number(bar.pieces[-1].area),
        "mass_kg": number(bar.mass),
        "wave_speed_m_s": number(bar.wave_speed),
        "youngs_modulus_Pa": number(bar.pieces[-1].youngs_modulus),
        "density_kg_m3": number(bar.pieces[-1].density),
        "first_mode_Hz": number(first),
        "contact_time_us": number(1e6 * bar.contact_duration),
        "sections": [
            {
                "length_m": number(piece.end - piece.start),
                "area_m2": number(piece.area),
                "diameter_m": number(piece.diameter),
                "bore_m": number(piece.bore),
            }
            for piece in bar.pieces
        ],
    }


def _scales(machine: Machine) -> dict[str, Any]:
    return {
        "length_m": number(machine.length_scale),
        "time_s": number(machine.time_scale),
        "speed_m_s": number(machine.speed_scale),
        "force_N": number(machine.force_scale),
        "energy_J": number(machine.energy_scale),
        "power_W": number(machine.power_scale),
    }


def _plain_tables(case: Case, machine: Machine) -> dict[str, Any]:
    """The dimensionless form of a case, without start and simulation; a second is the unit of time of one in SI."""
    body, law, contact = machine.body, machine.body.damping, machine.contact
    system: dict[str, Any] = {"s": body.s, "restitution": contact.restitution, **body_table(body)}
    system |= {"d": law.rigid} if isinstance(law, External) else {"damping": damping_table(law)}
    system |= {} if isinstance(contact, Kept) else {"strain": contact.kind}
    title = {} if case.tables.title is None else {"title": case.tables.title}
    return {**title, "system": system, "load": _plain_load(case, machine)}


def _plain_load(case: Case, machine: Machine) -> dict[str, Any]:
    valve, room = machine.valve, case.room()
    gas = valve.chamber
    table: dict[str, Any] = {"kind": "valve", "states": dict(valve.pairs), "ports": [_port(one) for one in valve.ports]}
    table |= {"start_state": valve.start}
    table |= {"chamber": {"force": gas.force, "stiffness": gas.stiffness}} if gas.force or gas.stiffness else {}
    if valve.supply is not None:
        supply = valve.supply
        table["supply"] = {"flow": supply.flow, "accumulator": supply.compliance, "start": supply.start}
    table |= {} if room is None else {"room": room}
    return table | ({"at": machine.at} if machine.at else {})


def _port(port: Port) -> dict[str, Any]:
    place = {"on": "impact"} if port.on == "impact" else {"behind": port.behind, "side": port.side}
    reads = {} if port.reads == "centre" else {"reads": port.reads}
    return {"to": port.to, **place, **({"delay": port.delay} if port.delay else {}), **reads}
