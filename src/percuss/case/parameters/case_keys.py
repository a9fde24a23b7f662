"""The keys of a case that hold one number and may be varied: their words, and what else they set."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from percuss.case.file_format.load_tables import HistoryForce
from percuss.case.file_format.schema import PhysicalCase, PlainCase, keys_of, table_fields
from percuss.case.file_format.section_tables import SectionTable
from percuss.case.file_format.valve_tables import ValveForce, ValveLoad
from percuss.case.parameters.valve_keys import valve_keys

if TYPE_CHECKING:
    from percuss.case.case import Case

__all__ = [
    "FREQUENCY",
    "KEYS",
    "LOAD_AREA",
    "LOAD_SCALE",
    "Key",
    "held",
    "key_of",
    "varied_keys",
    "with_generic_places",
    "with_held",
]

LOAD_SCALE, FREQUENCY, LOAD_AREA = "load.scale", "load.frequency", "load.area"

_TABLES = ("system", "bar", "body", "contact", "load")
_STRUCK = ("tool", "rock", "blow")
_NO_NUMBERS = {"kind", "file", "column", "unit", "time_column", "coefficients", "title", "strain", "at"}
_NO_NUMBERS |= {"breaks", "values", "sections", "impedances", "transit_times", "law", "advance", "end", "load_at"}
_NO_NUMBERS |= {"omega", "contact", "drive"}


@dataclass(frozen=True)
class Key:
    """One key of a case.

    Attributes
    ----------
    label
        What stands on an axis or beside a slider, in a few words that begin small; empty for the key itself.
    meaning
        What it is, where the label does not say it.
    sets
        The word of what it sets, when a dimensionless parameter or another key sets the same; see
        `percuss.model.parameter.Parameter`.
    instead_of
        The keys that it takes the place of.
    whole
        Whether it holds whole numbers only.
    slides
        Whether the page has a slider for it.
    """

    label: str = ""
    meaning: str = ""
    sets: str = ""
    instead_of: tuple[str, ...] = ()
    whole: bool = False
    slides: bool = False


_DAMPINGS = ("bar.drag", "bar.damping", "bar.damping_ratio")

KEYS: dict[str, Key] = {
    "system.s": Key(sets="s"),
    "system.d": Key(sets="damping", instead_of=("system.damping",)),
    "system.damping": Key(sets="damping", instead_of=("system.d",)),
    "system.restitution": Key(sets="restitution"),
    "bar.length": Key("bar length", slides=True),
    "bar.area": Key("bar area", instead_of=("bar.diameter",)),
    "bar.diameter": Key("bar diameter", sets="bar.area", instead_of=("bar.area",)),
    "bar.youngs_modulus": Key("Young's modulus"),
    "bar.density": Key("density"),
    "bar.drag": Key("drag", "force per velocity and per metre of bar", "damping", _DAMPINGS, slides=True),
    "bar.damping": Key("damping", "", "damping", _DAMPINGS, slides=True),
    "bar.damping_ratio": Key("damping ratio", "of the elastic modes", "damping", _DAMPINGS, slides=True),
    "body.gap": Key("gap", "from the contact to the wall without any force", "gap"),
    "body.spring": Key("stiffness of the spring", sets="stiffness"),
    "body.dashpot": Key("dashpot", "its force per velocity", "dashpot"),
    "body.mass": Key("mass"),
    "contact.restitution": Key("restitution R", sets="restitution", instead_of=("contact.receiving_area",)),
    "contact.receiving_area": Key("area of the struck rod", "", "restitution", ("contact.restitution",)),
    "load.mean": Key("mean load", sets="mean"),
    "load.amplitude": Key("load amplitude", sets="amplitude", slides=True),
    "load.frequency": Key("load frequency", slides=True),
    "load.kappa": Key("load κ", sets="kappa"),
    "load.harmonics": Key("harmonics kept", whole=True),
    "load.harmonic": Key("harmonic of the load", whole=True),
    "load.area": Key("area of the load"),
    "load.pressure": Key("supply pressure", sets=LOAD_SCALE),
    "load.chamber.force": Key("force of the chamber", "of the gas on the bar at the wall"),
    "load.chamber.stiffness": Key("stiffness of the chamber"),
    "load.supply.flow": Key("flow of the pump"),
    "load.supply.accumulator": Key("accumulator", "volume that it gives up per pressure"),
    "tool.bit_mass": Key("mass of the bit"),
    "tool.impedance": Key("impedance of the tool", "of an endless rod, divided by that of the bar's last section"),
    "tool.gap": Key("gap in front of the tool"),
    "rock.stiffness": Key("stiffness of the rock"),
    "rock.unloading_ratio": Key("unloading ratio γ", "share of the penetration that the rock gives back"),
    "rock.gap": Key("gap in front of the rock"),
    "blow.velocity": Key("speed of the blow"),
    "blow.until": Key("end of the blow"),
    LOAD_SCALE: Key("load, as a multiple", "a factor on the whole load"),
}
"""What is known of the keys; one that a case has and this table does not is a number like any other."""

_PLAIN = Key()


def key_of(name: str) -> Key:
    """What is known of a dotted key."""
    return KEYS.get(name, _PLAIN)


def varied_keys(case: Case) -> list[str]:
    """The dotted keys that the case may hold as one number, and the factor on its load."""
    table = case.tables.load
    fields = table_fields(type(case.tables), None if table is None else table.kind)
    none = {"harmonics", "sample_rate", "from", "to"} if isinstance(table, HistoryForce) else set()
    if isinstance(table, HistoryForce):  # with one face the area is a scale of the force, with two it is not
        none |= {"opposing_column", "opposing_area"} | ({"area"} if table.opposing_column is not None else set())
    none |= _NO_NUMBERS
    if isinstance(table, ValveForce | ValveLoad):
        none |= {*fields["load"], "room"}
    tables = [*_TABLES, *(name for name in _STRUCK if getattr(case.tables, name, None) is not None)]
    tables = [name for name in tables if name not in _unvaried(case)]
    keys = [f"{table}.{name}" for table in tables for name in fields.get(table, ()) if name not in none]
    none = {"blow.load"} | (
        {"blow.velocity"} if isinstance(getattr(case.tables.blow, "velocity", None), tuple) else set()
    )
    if isinstance(case.tables, PhysicalCase) and case.tables.bar.sections is not None:
        none |= _OF_UNIFORM_BARS
    in_lists = _keys_in_lists(case.tables)
    if isinstance(table, ValveForce | ValveLoad):
        in_lists += valve_keys(table)
    return [*(key for key in keys if key not in none), *in_lists, *([] if table is None else [LOAD_SCALE])]


def _unvaried(case: Case) -> set[str]:
    """Tables that hold no number of this case."""
    body = case.tables.body
    if body is None:
        return {"body"}
    return {"bar"} if body.kind == "modes" or "bar" not in case.tables.model_fields_set else set()


_OF_UNIFORM_BARS = {"bar.length", "bar.area", "bar.diameter"}


def _keys_in_lists(tables: PhysicalCase | PlainCase) -> list[str]:
    """The keys of the sections of a stepped bar and of the tool, counted from 0 at the driven end, or at the face."""
    if isinstance(tables, PhysicalCase):
        lists = {"bar": tables.bar.sections or (), "tool": () if tables.tool is None else tables.tool.sections or ()}
        sections = [(f"{name}.sections[{i}]", own) for name, those in lists.items() for i, own in enumerate(those)]
        return [f"{place}.{name}" for place, section in sections for name in _numbers_of(section)]
    numbers = {name: getattr(tables.system, name) or () for name in ("impedances", "transit_times")}
    return [f"system.{name}[{i}]" for name, values in numbers.items() for i in range(len(values))]


def _numbers_of(section: SectionTable) -> list[str]:
    """The keys of a section that may hold one number beside those that it has."""
    none = {"material", "area" if section.area is None else "diameter"}
    none |= set() if section.material is None else {"youngs_modulus", "density"}
    none |= {"length"} if section.length is None else set()  # an endless one
    return [name for name in keys_of(SectionTable) if name not in none]


def with_generic_places(keys: Iterable[str]) -> list[str]:
    """The keys with those that differ only by a place in a list told once.

    Examples
    --------
    >>> with_generic_places(["bar.density", "bar.sections[0].length", "bar.sections[1].length"])
    ['bar.density', 'bar.sections[i].length']
    """
    return list(dict.fromkeys(re.sub(r"\[\d+\]", "[i]", key) for key in keys))


def held(given: Any) -> Any:
    """The number with its unit that a key holds: of a table such as {kind = "ratio", value = 1e-3} its value."""
    return given.get("value") if isinstance(given, dict) else given


def with_held(given: Any, value: Any) -> Any:
    """What the key holds with another number in it."""
    return {**given, "value": value} if isinstance(given, dict) else value
