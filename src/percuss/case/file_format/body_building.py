"""From the tables [bar] and [system] of a case to the body that strikes.

Whatever is refused is a `ParameterError` by the key of its table.
"""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any

from percuss.case.file_format.body_tables import (
    MATERIALS,
    BlowTable,
    BodyTable,
    DampingTable,
    Material,
    RockTable,
    SectionTable,
    ToolTable,
)
from percuss.case.file_format.schema import BarTable, ContactTable, PhysicalCase, SystemTable
from percuss.case.file_format.values import above_zero, given_in, keyed, number_of
from percuss.errors import ParameterError
from percuss.model import Bar, External, HeldBody, ModalBody, Mounted, Ratio, SizedBody, SteppedBar, UniformBar
from percuss.model.body import DAMPINGS, Body, Damping, Section, SectionedBar, SizedModes, SizedMounted
from percuss.model.body.damping import share_of_critical
from percuss.model.checks import finite, non_negative, positive
from percuss.units import si

if TYPE_CHECKING:
    from percuss.blow import Rock, Rod, Wall
    from percuss.blow.bodies import End
    from percuss.case.file_format.plain_form import PlainCase, PlainTool

DEFAULT_RATIO = 1e-3
"""The share of critical damping of a bar in SI of which nothing is known: steel, with a joint or two."""


def sized_body(table: BarTable) -> SizedBody:
    """The body that the table [bar] describes."""
    given, damping = given_in(table), _damping(table)
    sizes = [name for name in ("length", "area", "diameter") if name in given]
    if table.sections is None:
        if len(sizes) != 2 or "length" not in sizes:
            raise ParameterError("diameter", table.diameter, "either a diameter or an area")
        material = {name: given[name] for name in ("youngs_modulus", "density") if name in given}
        return Bar(**{name: given[name] for name in sizes}, **material, **damping)
    if sizes:
        raise ParameterError(sizes[0], getattr(table, sizes[0]), f"either sections or a {sizes[0]}, not both")
    sections = sections_of(table.sections, table)
    with _by_what_was_given(table.sections):
        bar = SectionedBar(sections)
    law = damping.get("damping")
    if "damping_ratio" in damping:
        law = Ratio(share_of_critical("damping_ratio", damping["damping_ratio"]))
    return replace(bar, damping=law or External(damping["drag"] * bar.length / bar.mass))


def sections_of(tables: Sequence[SectionTable], common: object) -> tuple[Section, ...]:
    """The sections of a list; what `common` says of the material holds where a section says nothing."""
    return tuple(_section(f"sections[{i}].", table, common) for i, table in enumerate(tables))


@contextmanager
def _by_what_was_given(tables: Sequence[SectionTable]) -> Iterator[None]:
    """The refusal of an area that follows from a diameter, by the key of the diameter."""
    try:
        yield
    except ParameterError as error:
        found = re.fullmatch(r"(sections\[(\d+)\]\.)area", error.name)
        if found is None or tables[int(found[2])].diameter is None:
            raise
        given = tables[int(found[2])].diameter
        raise ParameterError(f"{found[1]}diameter", given, error.accepted, error.remedy) from None


def _section(name: str, table: SectionTable, common: object) -> Section:
    given = given_in(table, name)
    sizes = {key: given[key] for key in ("area", "diameter", "bore") if key in given}
    material = _material(name, table, common)
    with keyed(name):
        try:
            return Section(given.get("length"), **sizes, **material._asdict())
        except ParameterError as error:
            if error.name == "bore" and given["bore"] >= 0.0:
                raise ParameterError("bore", table.bore, f"less than the diameter, {table.diameter}") from None
            raise


def _material(name: str, table: SectionTable, common: object) -> Material:
    own = table.youngs_modulus, table.density
    if table.material is not None:
        if own != (None, None):
            raise ParameterError(f"{name}material", table.material, "a material, or a modulus and a density, not both")
        return MATERIALS[table.material]
    found = {}
    for key in ("youngs_modulus", "density"):
        for where, at in ((table, name), (common, "")):
            if key not in found and (text := getattr(where, key, None)) is not None:
                found[key] = above_zero(at + key, text, "pressure" if key == "youngs_modulus" else key)
    return MATERIALS["steel"]._replace(**found)


def _damping(table: BarTable) -> dict[str, Any]:
    """What a body in SI is told of its damping."""
    given = [name for name in ("damping_ratio", "damping", "drag") if getattr(table, name) is not None]
    if len(given) > 1:
        value = None if given[1] == "damping" else getattr(table, given[1])  # a table is not shown
        raise ParameterError(given[1], value, f"either {given[0]} or {given[1]}, not both")
    if table.drag is not None:
        return {"drag": non_negative("drag", si(table.drag, "damping", "drag"))}
    own = table.damping
    if own is None:
        return {"damping_ratio": DEFAULT_RATIO if table.damping_ratio is None else table.damping_ratio}
    if own.kind == "external" and isinstance(own.value, str):
        return {"drag": non_negative("damping.value", si(own.value, "damping", "damping.value"))}
    return {"damping": damping_law(own, units=True)}


def damping_law(table: DampingTable, units: bool) -> Damping:
    """The law that a table describes; with the time in seconds for a bar in SI, which `units` tells."""
    (own,) = DAMPINGS[table.kind].__match_args__  # type: ignore[attr-defined]  # of a dataclass
    with keyed(keys={own: "damping.value", "value": "damping.value"}):
        return DAMPINGS[table.kind](_value(table, units))  # type: ignore[call-arg]  # each has one field


def _value(table: DampingTable, units: bool) -> float | tuple[float, ...]:
    value = table.value
    if table.kind == "table":
        if not isinstance(value, tuple):
            accepted = "a list of numbers, the damping of each mode" + (" in 1/s" if units else "")
            raise ParameterError("value", value, accepted)
        return value
    if not isinstance(value, str):
        return finite("value", value, "one finite number")
    if not units:
        raise ParameterError("value", value, "a number", "only a case in SI takes units")
    if table.kind != "kelvin_voigt":
        raise ParameterError("value", value, "a plain number")
    return si(value, "time", "value")


def damping_table(law: Damping) -> dict[str, Any]:
    """The table of a law, as JSON has it; `damping_law` backwards.

    Examples
    --------
    >>> damping_table(Ratio(0.001))
    {'kind': 'ratio', 'value': 0.001}
    """
    (value,) = vars(law).values()
    return {"kind": law.kind, "value": list(value) if isinstance(value, tuple) else value}


def plain_body(table: SystemTable) -> Body:
    """The body that the table [system] describes."""
    damping = plain_damping(table)
    assert table.s is not None
    if table.impedances is None and table.transit_times is None:
        return UniformBar(table.s, damping)
    for name in ("impedances", "transit_times"):
        if getattr(table, name) is None:
            raise ParameterError(name, None, "both impedances and transit_times, or neither")
    return SteppedBar(table.s, table.impedances or (), table.transit_times or (), damping)


def plain_damping(table: SystemTable) -> Damping:
    """The law of damping that the table [system] names, or its d."""
    d = None if table.d is None else non_negative("d", table.d)
    if table.damping is None:
        return External(d or 0.0)
    law = damping_law(table.damping, units=False)
    if d and d != law.rigid:
        remedy = f'leave d out: the law "{law.kind}" says it all'
        raise ParameterError("d", table.d, "0 or no d beside another law of damping", remedy)
    return law


# ---- A file with a table of modes: omega, damping, contact and drive, as a finite-element program exports them

COLUMNS = ("omega", "damping", "contact", "drive")
_MOST_BYTES = 10_000_000


def modes_in(path: Path, name: str) -> dict[str, tuple[float, ...]]:
    """The columns of a table of modes; lines that begin with # are remarks."""
    try:
        if path.stat().st_size > _MOST_BYTES:
            raise ParameterError("file", name, f"a table of at most {_MOST_BYTES // 1_000_000} MB")
        text = path.read_text(encoding="utf-8-sig")
    except OSError as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise ParameterError("file", name, f"a file that can be read ({path}: {reason})") from None
    except ValueError:  # not UTF-8, or a null character in the path
        raise ParameterError("file", name, "a text file in UTF-8") from None
    lines = [(i, line) for i, line in enumerate(text.splitlines(), 1) if line.strip() and not line.startswith("#")]
    if len(lines) < 2:
        raise ParameterError("file", name, f"a line of names, {', '.join(COLUMNS)}, and a line for each mode")
    between = max(",;\t", key=lines[0][1].count)
    head = [cell.strip().lower() for cell in next(csv.reader([lines[0][1]], delimiter=between))]
    places = {}
    for column in COLUMNS:
        if head.count(column) != 1:
            raise ParameterError("file", name, f"one column {column} (line {lines[0][0]} names: {', '.join(head)})")
        places[column] = head.index(column)
    found: dict[str, list[float]] = {column: [] for column in COLUMNS}
    for number, line in lines[1:]:
        cells = next(csv.reader([line], delimiter=between))
        for column, place in places.items():
            found[column].append(_cell_number(cells[place] if place < len(cells) else "", name, number, column))
    _check(found, name, [number for number, _ in lines[1:]])
    return {column: tuple(values) for column, values in found.items()}


def _cell_number(cell: str, name: str, line: int, column: str) -> float:
    try:
        value = float(cell)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        shown = cell.strip() or "nothing"
        raise ParameterError("file", name, f"a finite number in line {line}, column {column}, not {shown[:40]!r}")
    return value


def _check(found: dict[str, list[float]], name: str, lines: list[int]) -> None:
    """What the model would refuse by the number of the mode, told by the line."""
    for line, omega, damping in zip(lines, found["omega"], found["damping"], strict=True):
        if omega <= 0.0:
            remedy = "a body that moves as a whole is a free one: describe it by [bar] or [system]"
            raise ParameterError("file", name, f"omega greater than 0 in line {line}, not {omega:g}", remedy)
        if damping < 0.0:
            raise ParameterError("file", name, f"damping of 0 or more in line {line}, not {damping:g}")


# ---- From the table [body] of a case to the structure that it describes

_OF_STRUCTURE = {"gap": "length", "spring": "stiffness", "dashpot": "dashpot"}
_OF_KIND = {"modes": ("file", *COLUMNS), "mounted": ("spring", "dashpot", "mass")}


_MODEL = {"delta": "damping", "stiffness": "spring", "rigid_mass": "mass"}
"""What the model calls the keys of a structure."""


def held_body(table: BodyTable, tables: PlainCase | PhysicalCase, folder: Path) -> HeldBody | SizedBody:
    """The structure of a case."""
    for kind, names in _OF_KIND.items():
        for name in names:
            if kind != table.kind and getattr(table, name) is not None:
                raise ParameterError(name, getattr(table, name), f'nothing: it belongs to kind = "{kind}"')
    si_case = isinstance(tables, PhysicalCase)
    for name in ("gap", "spring", "dashpot"):
        if si_case and isinstance(given := getattr(table, name), float | int):
            accepted = f"text with a number and a unit of {_OF_STRUCTURE[name]} in a case in SI"
            raise ParameterError(name, given, accepted)
    own = {"gap": 0.0, "dashpot": 0.0} | given_in(table)
    if table.kind == "modes":
        columns = _columns(table, folder)
        with keyed(keys=_MODEL):
            return (SizedModes if si_case else ModalBody)(**columns, gap=own["gap"])
    if "spring" not in own:
        raise ParameterError("spring", None, "the spring of a body that is mounted")
    if isinstance(tables, PhysicalCase):
        bar = sized_body(tables.bar) if "bar" in tables.model_fields_set else None
        if bar is not None and not isinstance(bar, Bar):
            raise ParameterError("kind", table.kind, "a bar of one section in [bar]")
        if (bar is None) == (table.mass is None):
            wanted = "either a mass or a table [bar], not both"
            wanted = wanted if bar else 'a mass with its unit, for example "5 kg", or a table [bar]'
            raise ParameterError("mass", table.mass, wanted)
        with keyed(keys=_MODEL):
            return SizedMounted(own["spring"], own["dashpot"], bar, own.get("mass", 1.0), own["gap"])
    if table.mass is not None:
        raise ParameterError("mass", table.mass, "no mass: it is 1 in a dimensionless case")
    s = tables.system.s
    with_s = {} if s is None else {"s": s, "damping": plain_damping(tables.system)}
    with keyed(keys=_MODEL):
        return Mounted(own["spring"], own["dashpot"], gap=own["gap"], **with_s)  # type: ignore[arg-type]


def check_beside(tables: PhysicalCase | PlainCase) -> tuple[str, str, str] | None:
    """The table, key and words of what does not go with [body]; None for nothing."""
    table = tables.body
    assert table is not None
    for name in ("tool", "rock", "blow"):
        if getattr(tables, name, None) is not None:
            return name, "", "no such table beside [body]: its contact is with a rigid wall"
    for key, only in (("law", "b77"), ("strain", "kept")):
        if tables.struck is not None and getattr(tables.struck, key) not in (None, only):
            return tables.struck_name, key, f'only "{only}" beside [body]'
    if tables.load is not None and tables.load.kind == "valve":
        return "load", "kind", "a load that keeps time beside [body]"
    if tables.load is not None and tables.load.at:
        return "load", "at", "0 beside [body]: its table says where the load acts"
    if not isinstance(tables, PhysicalCase):
        unfit = {"s", "d", "damping"} if table.kind == "modes" or tables.system.s is None else set()
        unfit |= {"impedances", "transit_times"}
        for name in sorted(unfit & tables.system.model_fields_set):
            return "system", name, "no such key beside this [body]"
    elif table.kind == "modes" and "bar" in tables.model_fields_set:
        return "bar", "", "no table [bar] beside a table of modes"
    return None


def _columns(table: BodyTable, folder: Path) -> dict[str, Any]:
    """The columns by the names that the model has for them."""
    given = {name: getattr(table, name) for name in COLUMNS if getattr(table, name) is not None}
    if table.file is not None:
        if given:
            raise ParameterError("file", table.file, f"either a file or {', '.join(given)}, not both")
        given = modes_in(folder / table.file, table.file)
    for name in COLUMNS:
        if name not in given:
            raise ParameterError(name, None, 'a list of numbers, or file = "modes.csv" with all columns')
    return {"delta" if name == "damping" else name: values for name, values in given.items()}


# ---- From the tables [tool], [rock] and [blow] of a case to what the bar strikes, and to the blow that is asked for


@dataclass(frozen=True)
class BlowQuestion:
    """One blow as a case asks for it: in SI, or dimensionless as the bar is."""

    striker: SizedBody | Body
    target: Rod | Wall
    velocity: float | tuple[float, ...] | None = None  # None asks for that of the steady motion
    until: float | None = None  # None until the blow is over
    load: tuple[tuple[float, float], ...] = ()  # pairs of a time and the force from then on
    load_at: int = 0


# -- [tool] and [rock] ------------------------------------------------------------------------------------------------


def rock_of(table: RockTable) -> Rock:
    """The rock that the table [rock] describes."""
    from percuss.blow import Rock

    return Rock(**{"unloading_ratio": 1.0, "gap": 0.0} | given_in(table))


def sized_target(tool: ToolTable | None, rock: Rock | None, contact: ContactTable | None, bar: SizedBody) -> Rod | Wall:
    """What a bar in SI strikes; without a table [tool] the rod of `receiving_area`, or a rigid wall."""
    from percuss.blow import Rod, Wall

    if tool is None:
        if contact is None or contact.receiving_area is None:
            return Wall()
        area, last = si(contact.receiving_area, "area", "receiving_area"), bar.pieces[-1]
        return Rod((Section(None, area=area, youngs_modulus=last.youngs_modulus, density=last.density),), "infinite")
    given = {"gap": 0.0, "bit_mass": 0.0} | given_in(tool)
    if tool.kind == "wall":
        for key in ("sections", "end", "bit_mass"):
            if getattr(tool, key) is not None:
                raise ParameterError(key, None, f"no {key} of a wall", 'a rod has kind = "rod"')
        if rock is not None:
            raise ParameterError("kind", "wall", '"rod" beside a table [rock]', "take [rock] away, or describe the rod")
        return Wall(given["gap"])
    if tool.sections is None:
        raise ParameterError("sections", None, 'the sections of the rod, or kind = "wall"', _SECTIONS)
    sections, joints = sections_of(tool.sections, tool), []
    for i, table in enumerate(tool.sections):
        mass = non_negative(f"sections[{i}].joint_mass", given_in(table).get("joint_mass", 0.0))
        if mass > 0.0 and table is tool.sections[-1]:
            name, remedy = f"sections[{i}].joint_mass", "a mass at the end of the rod is bit_mass"
            raise ParameterError(name, table.joint_mass, "a section with another one behind it", remedy)
        joints += [] if table.joint_mass is None or table is tool.sections[-1] else [(i + 1, mass)]
    end = _end(tool, sections, rock)
    with _by_what_was_given(tool.sections):
        return Rod(sections, end, bit_mass=given["bit_mass"], joint_masses=tuple(joints), rock=rock, gap=given["gap"])


NO_BIT = 'describe what is struck in [tool], a bit for example: sections = [{length = "0.2 m", diameter = "90 mm"}]'
"""What to do about a table [rock] without a table [tool]."""

_SECTIONS = 'for example sections = [{length = "1.2 m", diameter = "38 mm"}]'


def _end(tool: ToolTable, sections: tuple[Section, ...], rock: Rock | None) -> End:
    """What is at the end of the rod: as the table says, or as the rest of the case leaves no doubt."""
    if tool.end is None and rock is None and all(section.length is not None for section in sections):
        remedy = 'a last section without a length is endless; a table [rock] describes the rock: end = "rock"'
        raise ParameterError("end", None, '"free", "fixed", "rock" or "infinite"', remedy)
    end: End = tool.end or ("infinite" if rock is None else "rock")
    if end == "rock" and rock is None:
        raise ParameterError("end", end, "a table [rock] beside it", 'for example stiffness = "400 kN/mm" in [rock]')
    if end != "rock" and rock is not None:
        raise ParameterError("end", end, '"rock" beside a table [rock]', 'take [rock] away, or write end = "rock"')
    return end


def plain_target(tool: PlainTool | None, body: Body) -> Rod | Wall:
    """What a dimensionless body strikes; without a table [tool] a rigid wall."""
    from percuss.blow import Rod, Wall

    if tool is None:
        return Wall()
    gap = 0.0 if tool.gap is None else tool.gap
    if tool.kind == "wall":
        if tool.impedance is not None:
            raise ParameterError("impedance", tool.impedance, "no impedance of a wall", 'a rod has kind = "rod"')
        return Wall(gap)
    if tool.impedance is None:
        raise ParameterError("impedance", None, 'the impedance of the endless rod, or kind = "wall"')
    own = float(body.sections.impedance[-1]) if isinstance(body, SteppedBar) else body.s
    return Rod.of_impedance(positive("impedance", tool.impedance) * own, gap=gap)


# -- [blow] -----------------------------------------------------------------------------------------------------------


def blow_question(table: BlowTable | None, striker: SizedBody | Body, target: Rod | Wall) -> BlowQuestion:
    """The blow that the table [blow] asks for; without the table from the steady motion until it is over."""
    if table is None:
        return BlowQuestion(striker, target)
    until = None if table.until is None else above_zero("until", table.until, "time")
    load = tuple((number_of("load", t, "time"), number_of("load", f, "force")) for t, f in table.load or ())
    times = [time for time, _ in load]
    if times and (times[0] < 0.0 or any(later <= earlier for earlier, later in pairwise(times))):
        raise ParameterError("load", [t for t, _ in table.load or ()], "times that increase from 0 or later")
    body = striker.body(1.0 / striker.transit_time) if isinstance(striker, SizedBody) else striker
    with keyed(keys={"at": "load_at"}):
        body.place(table.load_at)
    return BlowQuestion(striker, target, _velocity(table, striker), until, load, table.load_at)


def _velocity(table: BlowTable, striker: SizedBody | Body) -> float | tuple[float, ...] | None:
    given = table.velocity
    if given is None:
        return None
    if not isinstance(given, tuple):
        speed = number_of("velocity", given, "velocity")
        if speed <= 0.0:
            raise ParameterError("velocity", given, "a speed greater than 0, toward the tool")
        return speed
    count = len(striker.pieces) if isinstance(striker, SizedBody) else len(getattr(striker, "impedances", (1.0,)))
    if len(given) != count:
        accepted = f"one speed, or one for each of the {count} sections" if count > 1 else "one speed of a uniform bar"
        raise ParameterError("velocity", list(given), accepted)
    return tuple(number_of("velocity", one, "velocity") for one in given)
