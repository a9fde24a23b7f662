"""The keys of a case that hold one number and may be varied: their words, and what else they set."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from percuss.case.case import json_tables
from percuss.case.file_format.bodies import SectionTable
from percuss.case.file_format.loads import HistoryLoad, ValveLoad
from percuss.case.file_format.schema import PhysicalCase, table_fields
from percuss.case.file_format.values import keys_of
from percuss.errors import ParameterError, did_you_mean
from percuss.explore.parameters import PRESSURE
from percuss.model import External, Ratio
from percuss.model.body import Table
from percuss.units import si

if TYPE_CHECKING:
    from percuss.case.case import Case
    from percuss.case.file_format.plain_form import PlainCase


# ---- The keys of a valve: which a case may be varied by, and what they are in the scales of its machine

LOAD_PRESSURE = "load.pressure"

_SCALE = "load.scale"
_NAME = re.compile(r"[^\W\d][\w-]*")  # a state whose name can stand in a dotted key
_OF_MACHINE = re.compile(
    r"load\.(?:scale|pressure|chamber\.(?:force|stiffness)|ports\[\d+\]\.(?:behind|speed|delay)|states\.[^.]+)"
)
_DIMENSIONS = {"behind": "length", "speed": "velocity", "delay": "time", "stiffness": "stiffness", "force": "force"}


def valve_keys(table: ValveLoad) -> list[str]:
    """The dotted keys of a valve that hold one number, or may; a state by areas has one for each of them."""
    given_pressure = table.pressure is not None and table.supply is None
    keys = [LOAD_PRESSURE] if given_pressure else []
    for name, given in table.states.items():
        if _NAME.fullmatch(name) and not isinstance(given, dict):
            areas = [side for side in ("front", "rear") if getattr(given, side, None) is not None]
            keys += [f"load.states.{name}.{side}" for side in areas] or [f"load.states.{name}"]
    gas = table.chamber is not None and table.chamber.volume is not None
    keys += ["load.chamber.force", "load.chamber.volume" if gas else "load.chamber.stiffness", *_oil_keys(table)]
    for i, port in enumerate(table.ports):
        edge = [] if port.on is not None else ["behind" if port.speed is None else "speed"]
        keys += [f"load.ports[{i}].{name}" for name in (*edge, "delay")]
    return keys


def _oil_keys(table: ValveLoad) -> list[str]:
    """Those of the pump, and of oil that flows: numbers that the case has."""
    keys, supply = (
        [f"load.chambers.{name}.area" for name in table.chambers or () if _NAME.fullmatch(name)],
        table.supply,
    )
    for i, own in enumerate(table.orifices or ()):
        keys += [f"load.orifices[{i}].{name}" for name in ("area", "drop") if getattr(own, name) is not None]
    keys += ["load.oil.tank"] if table.oil is not None and table.oil.tank is not None else []
    keys += [f"load.{name}" for name in ("spool", "force") if getattr(table, name) is not None]
    if supply is None:
        return keys
    for name in ("leakage", "slip"):
        keys += [f"load.supply.{name}.flow"] if getattr(supply, name) is not None else []
    if supply.flow is None:
        return keys
    keys += ["load.supply.flow", "load.supply.quickening"]
    for name, inside in (("accumulator", ("precharge", "volume")), ("relief", ("opens",))):
        given = getattr(supply, name)
        if given is not None:
            plain = isinstance(given, str | float | int)
            keys += [f"load.supply.{name}"] if plain else [f"load.supply.{name}.{own}" for own in inside]
    return keys + [f"load.supply.{name}" for name in ("power", "line") if getattr(supply, name) is not None]


def label_of(key: str, table: object) -> str:
    """A key of a case with this load in a few words, its ports and sections counted from 1."""
    if label := key_of(key).label:
        return label
    parts = key.replace("[", ".").replace("]", "").split(".")
    what = {"behind": "place"}.get(parts[-1], parts[-1].replace("_", " "))
    match parts:
        case [("bar" | "tool") as body, "sections", number, _]:
            return f"section {'of the tool ' * (body == 'tool')}{int(number) + 1}: {what}"
        case ["load", "ports", number, _] if isinstance(table, ValveLoad):
            port = table.ports[int(number)]
            of = "blow" if port.on == "impact" else f"port {int(number) + 1}"
            return f"{of} → {port.to}: {what}"
        case ["load", "orifices", number, _] if isinstance(table, ValveLoad) and table.orifices:
            passage = table.orifices[int(number)]
            return f"passage {passage.chamber} – {passage.to}: {what}"
        case ["load", "chambers", name, _]:
            return f"chamber {name}: {what}"
        case ["load", "states", state, side]:
            return f"{state}: {side} area"
        case ["load", "states", state]:
            return f"{state}: force"
    return key


def is_of_machine(key: str, table: object) -> bool:
    """Whether a key is put on the machine, which is quicker than another case: all of the load but its areas."""
    gas = isinstance(table, ValveLoad) and table.chamber is not None and table.chamber.volume is not None
    return _OF_MACHINE.fullmatch(key) is not None and not (gas and key.startswith("load.chamber."))


def of_machine(case: Case, keys: Mapping[str, tuple[float, str]]) -> dict[str, float]:
    """The dimensionless parameters of the machine that keys of its case stand for; the pressure is a multiple."""
    found, machine = {}, case.machine()
    for key, (value, unit) in keys.items():
        if unit and not case.is_si:
            raise ParameterError(key, f"{value:g} {unit}", "a plain number: it is dimensionless")
        name = PRESSURE if key in (_SCALE, LOAD_PRESSURE) else key.partition(".")[2]
        found[name] = value
        if case.is_si and key != _SCALE:
            dimension = "pressure" if key == LOAD_PRESSURE else _DIMENSIONS.get(key.rpartition(".")[2], "force")
            found[name] = si(f"{value!r} {unit}".rstrip(), dimension, key)
            if dimension == "pressure":
                assert machine.pressure is not None  # else there is no such key
                found[name] /= machine.pressure
            elif dimension == "stiffness":
                found[name] /= machine.force_scale / machine.length_scale
            else:
                found[name] /= float(getattr(machine, f"{'speed' if dimension == 'velocity' else dimension}_scale"))
    return found


# ---- The keys of a case that hold one number and may be varied: their words, and what else they set

LOAD_SCALE, FREQUENCY, LOAD_AREA = "load.scale", "load.frequency", "load.area"

_TABLES = ("system", "bar", "body", "contact", "load")
_STRUCK = ("tool", "feed", "rock", "blow", "drilling")
_NO_NUMBERS = {"kind", "file", "column", "unit", "time_column", "coefficients", "title", "strain", "at"}
_NO_NUMBERS |= {"breaks", "values", "sections", "impedances", "transit_times", "law", "advance", "end", "load_at"}
_NO_NUMBERS |= {"omega", "contact", "drive", "joints", "of", "crater", "blows_per_crater", "number", "between"}


@dataclass(frozen=True)
class Key:
    """One key of a case.

    `label` stands on an axis or beside a slider, in a few words that begin small ("" for the key itself); `meaning`
    says what the label does not. `sets` is the word of what it sets, when a dimensionless parameter or another key sets
    the same (`percuss.model.parameter.Parameter`); `instead_of` are the keys it takes the place of. `whole`: it holds
    whole numbers only; `slides`: the page has a slider for it.
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
    "load.chamber.volume": Key("volume of the chamber"),
    "load.supply.flow": Key("flow of the pump"),
    "load.supply.line": Key("volume of the supply line"),
    "load.supply.power": Key("power of the pump"),
    "load.supply.accumulator": Key("accumulator", "volume that it gives up per pressure"),
    "load.supply.quickening": Key("quickening", "of the spool under a higher pressure"),
    "load.supply.leakage.flow": Key("leakage", "from the supply to the tank"),
    "load.supply.relief.opens": Key("relief pressure"),
    "load.supply.accumulator.precharge": Key("precharge", "of the accumulator"),
    "load.supply.accumulator.volume": Key("volume of the accumulator"),
    "load.oil.tank": Key("pressure of the tank line"),
    "load.spool": Key("time of the spool", "from one state to the next"),
    "tool.bit_mass": Key("mass of the bit"),
    "tool.impedance": Key("impedance of the tool", "of an endless rod, divided by that of the bar's last section"),
    "tool.gap": Key("gap in front of the tool"),
    "rock.stiffness": Key("stiffness of the rock"),
    "rock.unloading_ratio": Key("unloading ratio γ", "share of the penetration that the rock gives back"),
    "rock.gap": Key("gap in front of the rock"),
    "feed.force": Key("feed force"),
    "feed.stiffness": Key("stiffness of the recoil damper"),
    "feed.damping": Key("recoil damper", "its force per velocity"),
    "drilling.bit_diameter": Key("diameter of the bit"),
    "drilling.crater_factor": Key("crater factor", "advance over residual penetration"),
    "drilling.specific_energy": Key("specific energy of the rock"),
    "blow.rate": Key("rate of the blows"),
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
    none = {"harmonics", "sample_rate", "from", "to"} if isinstance(table, HistoryLoad) else set()
    if isinstance(table, HistoryLoad):  # with one face the area is a scale of the force, with two it is not
        none |= {"opposing_column", "opposing_area", "passage", "opposing_passage"}
        none |= set() if table.opposing_column is None else {"area"}
    none |= _NO_NUMBERS
    if isinstance(table, ValveLoad):
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
    if isinstance(table, ValveLoad):
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
        ends = {id(those[-1]) for those in lists.values() if those}
        return [f"{place}.{name}" for place, own in sections for name in _numbers_of(own, id(own) in ends)]
    numbers = {name: getattr(tables.system, name) or () for name in ("impedances", "transit_times")}
    return [f"system.{name}[{i}]" for name, values in numbers.items() for i in range(len(values))]


def _numbers_of(section: SectionTable, last: bool) -> list[str]:
    """The keys of a section that may hold one number beside those that it has."""
    none = {"material", "area" if section.area is None else "diameter"}
    none |= set() if section.material is None else {"youngs_modulus", "density"}
    none |= {"length"} if section.length is None else set()  # an endless one
    none |= {"joint_mass"} if last else set()
    return [name for name in keys_of(type(section)) if name not in none]


def with_generic_places(keys: Iterable[str]) -> list[str]:
    """The keys with those that differ only by a place in a list told once."""
    return list(dict.fromkeys(re.sub(r"\[\d+\]", "[i]", key) for key in keys))


def held(given: Any) -> Any:
    """The number with its unit that a key holds: of a table such as {kind = "ratio", value = 1e-3} its value."""
    return given.get("value") if isinstance(given, dict) else given


def with_held(given: Any, value: Any) -> Any:
    """What the key holds with another number in it."""
    return {**given, "value": value} if isinstance(given, dict) else value


# ---- Which keys of damping a case may be varied by: those of the law that it names

DAMPING = "damping"  # the word of what the keys of damping set, and the key that names its law
_LAWS = {"damping_ratio": Ratio, "drag": External, "d": External}
"""The other keys of damping, and the laws whose number they are."""


def check_same_law(case: Case, name: str, key: str) -> None:
    """Refuse a key of damping as an axis where its law would take the place of the one that the case names."""
    table, _, word = key.partition(".")
    tables, law = json_tables(case)[table], case.hammer.body.damping
    held = [f"{table}.{other}" for other in (DAMPING, *_LAWS) if other in tables]
    if isinstance(law, Table):
        remedy = "a table of dampings has no single number to vary"
    else:
        remedy = f"vary {held[0]}" if held else "vary bar.damping_ratio or bar.drag"
    if word == DAMPING:
        if key not in held:
            raise ParameterError(name, "on an axis", 'a case with damping = {kind = "…", value = …}', remedy)
        if isinstance(law, Table):
            raise ParameterError(name, f"{law}", "a law of damping with one number")
    elif held and not (law.is_zero or isinstance(law, _LAWS[word])):
        own = _LAWS[word].kind
        wanted = f'a bar without damping, or with damping of the kind "{own}"'
        raise ParameterError(name, f"a bar with {law}", wanted, remedy)


# ---- The refusal of a parameter that a case does not have, with those that it has


def unknown_parameter(name: str, keys: Sequence[str], plain: Sequence[str]) -> ParameterError:
    """The refusal; a size of the bar has its places in a bar of sections."""
    last = name.rpartition(".")[2].partition("[")[0]
    in_lists = [
        key for key in keys if "[" in key and not key.startswith("load.") and last in re.split(r"[.\[\]]+", key)[1:]
    ]
    struck = name.startswith("tool.")
    in_list = next((key for key in in_lists if key.startswith("tool.") == struck), None)
    if in_list:
        whose, where = ("tool", "struck face") if struck else ("bar", "driven end")
        hint = f"the {whose} has sections, counted from 0 at the {where}: {in_list}"
    else:
        hint = did_you_mean(name, [*plain, *keys, *(key.partition(".")[2] for key in keys)])
    words = with_generic_places([*plain, *keys])
    return ParameterError("parameter", name, f"one of {', '.join(words)}", hint)
