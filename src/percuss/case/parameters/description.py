"""What is known of a case before anything is computed: its form in SI and in plain numbers, its scales."""

from __future__ import annotations

import math
from dataclasses import asdict, fields
from typing import TYPE_CHECKING, Any

from percuss.case.answers.facts import json_number as number
from percuss.case.answers.facts import numbers, plain
from percuss.case.answers.heading import body_dict, clock_note, contact_dict, motion_dict, system_dict
from percuss.case.case import fourier_table, json_tables, system_table
from percuss.case.file_format.loads import HistoryLoad
from percuss.case.parameters.case_keys import (
    FREQUENCY,
    LOAD_PRESSURE,
    LOAD_SCALE,
    key_of,
    label_of,
    varied_keys,
)
from percuss.case.parameters.moves import MOVES, can_move, number_held
from percuss.errors import PercussError
from percuss.explore.parameters import AXES, PARAMETERS
from percuss.model import Machine
from percuss.model.body import HeldBody, Mounted

if TYPE_CHECKING:
    from percuss.case.case import Case
    from percuss.model import Load, Oil, SizedBody, Supply, System
    from percuss.model.body import Body
    from percuss.model.parameter import Parameter


# ---- What of a case may be varied: every parameter with its words, its unit, its value and a range around it

_SLIDES = ("restitution", "load_factor", "kappa")
"""What has a slider in every case; the numbers of the bar have one in a dimensionless case."""


def parameters(case: Case) -> list[dict[str, Any]]:
    """What a map of the case may have as an axis: unit, value, range around it; of a machine its keys alone."""
    return _keys(case) if case.is_machine else [*_dimensionless(case), *_keys(case)]


def _dimensionless(case: Case) -> list[dict[str, Any]]:
    system, keys, found = case.system(), varied_keys(case), []
    offered = [own for name, own in PARAMETERS.items() if _has(own, system) and f"bar.{name}" not in keys]
    square = any(own.name == "kappa" for own in offered)
    for own in offered:
        name, value = own.name, own.get(system)
        low, high = own.span or _around(value)
        if name == "load_factor" and value is not None:
            high = max(high, 1.25 * value)
        movable = name in MOVES and can_move(name, case, system)
        if name in _SLIDES:
            slides = not (square and name == "load_factor")  # the mean of a square load follows from κ
        else:
            slides = not case.is_si and name not in ("mean", "amplitude")  # those of the bar follow from its sizes
        row = _row(name, own.label, own.meaning, "", value, low, high, movable, movable and slides)
        found.append(row | {"dimensionless": True, "plane": name in AXES})
    return found


def _has(parameter: Parameter[System], system: System) -> bool:
    """Whether a map of the system is offered the parameter: of all laws of damping only that of the body."""
    body, own = system.body, system.body.damping.parameter
    if parameter.sets == "damping" and (own is None or own.name != parameter.name):
        return False
    has_waves = not isinstance(body, HeldBody) or (isinstance(body, Mounted) and not body.is_rigid)
    if parameter.name in ("s", "d") and not has_waves:
        return False
    try:
        parameter.check(system)
    except PercussError:
        return False
    return True


def _keys(case: Case) -> list[dict[str, Any]]:
    found, names = [], varied_keys(case)
    flows = getattr(case.tables.load, "oil", None) is not None  # then no factor is on its forces
    none = {LOAD_SCALE} if case.is_machine and (flows or LOAD_PRESSURE in names) else set()  # the pressure is the same
    for name in names:
        table, _, key = name.partition(".")
        if name in none or table == "blow" or (table in ("tool", "rock") and not case.is_from_blow):
            continue  # the motion does not depend on it
        about, plain = key_of(name), not case.is_si and not case.is_machine
        if plain and (table == "system" or key in PARAMETERS or about.sets in PARAMETERS):
            continue  # a dimensionless parameter is the same
        value, unit = (1.0, "") if name == LOAD_SCALE else quantity_of(case, name)
        if value is None:
            continue
        span = PARAMETERS[key].span if case.is_machine and key == "restitution" else None
        kept = name == FREQUENCY and isinstance(case.tables.load, HistoryLoad)  # there it says where cycles are cut
        movable = not (kept or (case.is_machine and name == LOAD_SCALE))  # that is no key of its tables
        ends = span or _around(value)
        label, slides = label_of(name, case.tables.load), about.slides and not kept
        found.append(_row(name, label, about.meaning, unit, value, *ends, movable, slides))
    return found


def quantity_of(case: Case, key: str) -> tuple[float | None, str]:
    """The number of a key of the case, and its unit; the frequency of a recording, which may keep its waveform."""
    value, unit = number_held(case, key)
    if value is None and key == FREQUENCY and isinstance(case.tables.load, HistoryLoad):
        return case.system().frequency, "Hz"
    return value, unit


def _around(value: float | None) -> tuple[float, float]:
    if not value:
        return (0.0, 1.0)
    ends = (0.5 * value, 1.5 * value)
    return min(ends), max(ends)


def _row(
    name: str, label: str, meaning: str, unit: str, value: float | None, low: float, high: float, movable: bool,
    slides: bool,
) -> dict[str, Any]:  # fmt: skip
    words = {"name": name, "label": label, "meaning": meaning, "unit": unit}
    numbers = {"value": number(value), "low": number(low), "high": number(high)}
    return words | numbers | {"dimensionless": False, "plane": False, "movable": movable, "slides": slides}


# ---- What is known of a case before anything is computed: its form in SI and in plain numbers, its scales

_MODES = 8  # elastic modes that are told of the body of a machine
_SCALES = {
    "length_m": "length_scale",
    "time_s": "time_scale",
    "speed_m_s": "speed_scale",
    "force_N": "force_scale",
    "energy_J": "energy_scale",
    "power_W": "power_scale",
}


def case_dict(case: Case) -> dict[str, Any]:
    """A checked case as JSON: its tables and text, the system, scales and bar, and what of it a map may vary."""
    hammer = case.hammer
    body, bar, report = hammer.body, hammer.bar, case.history_report
    scales: dict[str, Any] = (
        {name: number(getattr(hammer, key)) for name, key in _SCALES.items()} if hammer.is_si else {}
    )
    sized = bar is not None and bool(bar.pieces)  # of a structure that is held only where a bar is on its spring
    if isinstance(hammer, Machine):
        modes, rate, system = body.modes(_MODES, hammer.at), 0.5 / (math.pi * hammer.time_scale) if sized else 0.0, None
        arrays = {"frequencies": modes.omega, "gamma": modes.gamma, "damping": modes.damping}
        about = {"kind": body.kind, **{name: numbers(array) for name, array in arrays.items()}}
    else:
        rate, system, about = hammer.frequency or 0.0, system_dict(hammer), body_dict(hammer)
        if scales:
            scales["stress_Pa"] = number(hammer.stress_scale) if sized else None
            scales["frequency_Hz"] = number(hammer.frequency)
    return {
        "title": case.title,
        "si": case.is_si,
        "tables": json_tables(case, as_given=True),
        "toml": case.to_toml(),
        "system": system,
        "body": about,
        "motion": motion_dict(hammer),
        "contact": contact_dict(hammer),
        "laws": {"damping": body.damping.words, "contact": hammer.contact.sentence},
        "plain": None if case.tables.body is not None else plain_tables(case),
        "scales": scales or None,
        "bar": None if bar is None or not sized else bar_dict(bar, rate, body),
        "first_mode": number(body.frequencies(1)[0]),
        "history": None if report is None else plain(asdict(report)),
        "notes": list(case.notes),
        "clock": "" if case.is_machine else clock_note(case.load()),
        "parameters": parameters(case),
    }


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


def plain_tables(case: Case) -> dict[str, Any]:
    """The dimensionless form of a case, without start and simulation."""
    title = {} if case.tables.title is None else {"title": case.tables.title}
    if case.is_machine:
        machine = case.machine()
        return {**title, "system": system_table(machine), "load": _plain_valve(case, machine)}
    system = case.system()
    load = _plain_load(case, system.load)
    own = {**system_table(system), **_plain_law(case)}
    return {**title, "system": own, "load": {**load, "at": system.load.at} if system.load.at else load}


def _plain_law(case: Case) -> dict[str, Any]:
    """The law of a blow that needs no tool; the tool of a case in SI has no dimensionless form."""
    given = case.tables.struck
    if given is None or given.law != "b77-tau":
        return {}
    return {key: getattr(given, key) for key in ("law", "advance") if getattr(given, key) is not None}


def _plain_load(case: Case, load: Load) -> dict[str, Any]:
    """A load of the kind that the case has, else by its harmonics."""
    kind = case.load_table.kind
    kept = {"harmonics": load.coefficients.size - 1}
    if kind == "square" and load.values:
        return {"kind": kind, "amplitude": max(load.values), "kappa": getattr(case.load_table, "kappa", 1.0), **kept}
    if kind == "steps":
        return {"kind": kind, "breaks": list(load.breaks), "values": list(load.values), **kept}
    k = [int(k) for k in load.harmonics]
    if kind == "harmonic" and len(k) == 1:
        amplitude = load.coefficients[k[0]]
        if amplitude.imag == 0.0:
            return {"kind": kind, "mean": load.mean, "amplitude": float(amplitude.real), "harmonic": k[0]}
    return {"kind": "fourier", "coefficients": fourier_table(load)["coefficients"]}


def _plain_supply(supply: Supply) -> dict[str, Any]:
    table: dict[str, Any] = {"flow": supply.flow, "accumulator": supply.compliance, "start": supply.start}
    table |= {"quickening": supply.quickening} if supply.quickening else {}
    table |= {"slip": {"flow": supply.slip, "at": 1.0}} if supply.slip else {}
    table |= {} if supply.power is None else {"power": supply.power}
    if supply.gas is not None:
        table |= {"accumulator": asdict(supply.gas)} | ({"line": supply.compliance} if supply.compliance else {})
    if supply.relief is not None:
        pressure, slope = supply.relief.pressure, supply.relief.slope
        table["relief"] = pressure if slope is None else {"opens": pressure, "flow": slope, "over": 1.0}
    return table


def _plain_oil(oil: Oil) -> dict[str, Any]:
    table: dict[str, Any] = {
        "chambers": {one.name: {"area": one.area, "side": one.side} for one in oil.chambers},
        "states": {name: {join.chamber: join.to for join in joins} for name, joins in oil.pairs},
    }  # fmt: skip
    passages = [
        {"chamber": join.chamber, "to": join.to, "state": name,
         "in": {"drop": join.inward, "at": 1.0}, "out": {"drop": join.outward, "at": 1.0}}
        for name, joins in oil.pairs for join in joins if join.inward or join.outward
    ]  # fmt: skip
    table |= {"orifices": passages} if passages else {}
    table |= {"oil": {"tank": oil.tank}} if oil.tank else {}
    return table | {name: value for name in ("spool", "force") if (value := getattr(oil, name))}


def _plain_valve(case: Case, machine: Machine) -> dict[str, Any]:
    valve, gas, room = machine.valve, machine.valve.chamber, case.room()
    ports = [{f.name: v for f in fields(one) if (v := getattr(one, f.name)) != f.default} for one in valve.ports]
    table: dict[str, Any] = {"kind": "valve", "states": dict(valve.pairs), "ports": ports, "start_state": valve.start}
    if gas.exponent is not None:  # of an area of 1
        table["chamber"] = {"force": gas.force, "area": 1.0, "volume": gas.column, "exponent": gas.exponent}
    elif gas.force or gas.stiffness:
        table["chamber"] = {"force": gas.force, "stiffness": gas.stiffness}
    if valve.supply is not None:
        table["supply"] = _plain_supply(valve.supply)
    if valve.oil is not None:
        table |= _plain_oil(valve.oil)
        if valve.oil.leakage:
            table.setdefault("supply", {})["leakage"] = {"flow": valve.oil.leakage, "at": 1.0}
    table |= {} if room is None else {"room": room}
    return table | ({"at": machine.at} if machine.at else {})
