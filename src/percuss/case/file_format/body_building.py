"""From the tables [bar] and [system] of a case to the body that strikes.

Whatever is refused is a `ParameterError` by the key of its table.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any

from percuss.case.file_format.body_tables import (
    BlowTable,
    BodyTable,
    PlainTool,
    RockTable,
    ToolSectionTable,
    ToolTable,
    by_what_was_given,
    damping_law,
    drag_in,
    sectioned_bar,
    sections_of,
)
from percuss.case.file_format.schema import BarTable, ContactTable, PhysicalCase, PlainCase, SystemTable
from percuss.errors import ParameterError
from percuss.model import Bar, External, HeldBody, ModalBody, Mounted, Ratio, SizedBody, SteppedBar, UniformBar
from percuss.model.body import Body, Damping, Section, SizedModes, SizedMounted
from percuss.model.body.damping import share_of_critical
from percuss.model.checks import non_negative, positive
from percuss.units import si

if TYPE_CHECKING:
    from percuss.blow import Rock, Rod, Wall
    from percuss.blow.bodies import End

DEFAULT_RATIO = 1e-3
"""The share of critical damping of a bar in SI of which nothing is known: steel, with a joint or two."""


def sized_body(table: BarTable) -> SizedBody:
    """The body that the table [bar] describes."""
    if table.sections is not None:
        return _sectioned(table)
    if (table.area is None) == (table.diameter is None):
        raise ParameterError("diameter", table.diameter, "either a diameter or an area")
    sizes: dict[str, Any] = {
        name: _size(table, name, dimension) for name, dimension in _SIZES.items() if getattr(table, name) is not None
    }
    return Bar(**sizes, **_damping(table))


def _sectioned(table: BarTable) -> SizedBody:
    assert table.sections is not None
    for name in ("length", "area", "diameter"):
        if getattr(table, name) is not None:
            raise ParameterError(name, getattr(table, name), f"either sections or a {name}, not both")
    given = _damping(table)
    ratio, law = given.get("damping_ratio"), given.get("damping")
    if ratio is not None:
        law = Ratio(share_of_critical("damping_ratio", ratio))
    return sectioned_bar(table.sections, table, law, given.get("drag", 0.0))


_SIZES = {
    "length": "length",
    "area": "area",
    "diameter": "length",
    "youngs_modulus": "pressure",
    "density": "density",
}


def _size(table: BarTable, name: str, dimension: str) -> float:
    text = getattr(table, name)
    value = si(text, dimension, name)
    if value <= 0.0:
        raise ParameterError(name, text, f"a {dimension} greater than 0")
    return value


def _damping(table: BarTable) -> dict[str, Any]:
    """What a body in SI is told of its damping."""
    given = [name for name in ("damping_ratio", "damping", "drag") if getattr(table, name) is not None]
    if len(given) > 1:
        value = None if given[1] == "damping" else getattr(table, given[1])  # a table is not shown
        raise ParameterError(given[1], value, f"either {given[0]} or {given[1]}, not both")
    if table.drag is not None:
        return {"drag": non_negative("drag", si(table.drag, "damping", "drag"))}
    if table.damping is not None:
        drag = drag_in(table.damping)
        return {"damping": damping_law(table.damping, units=True)} if drag is None else {"drag": drag}
    return {"damping_ratio": DEFAULT_RATIO if table.damping_ratio is None else table.damping_ratio}


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


def body_table(body: Body) -> dict[str, Any]:
    """What the table [system] says of a body beside s and the damping; `plain_body` backwards."""
    if not isinstance(body, SteppedBar):
        return {}
    return {"impedances": list(body.impedances), "transit_times": list(body.transit_times)}


# ---- A file with a table of modes: omega, damping, contact and drive, as a finite-element program exports them

COLUMNS = ("omega", "damping", "contact", "drive")
_MOST_BYTES = 10_000_000


def modes_in(path: Path, name: str) -> dict[str, tuple[float, ...]]:
    """The columns of a table of modes; lines that begin with # are remarks.

    Parameters
    ----------
    path, name
        The file, and what the case calls it.
    """
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

_OF_KIND = {"modes": ("file", *COLUMNS), "mounted": ("spring", "dashpot", "mass")}


def held_body(table: BodyTable, tables: PlainCase, folder: Path) -> HeldBody:
    """The structure of a dimensionless case."""
    _check_keys(table)
    gap = _number(table, "gap", 0.0)
    if table.kind == "modes":
        with _by_the_case():
            return ModalBody(**_columns(table, folder), gap=gap)
    if table.mass is not None:
        raise ParameterError("mass", table.mass, "no mass: it is 1 in a dimensionless case")
    s = tables.system.s
    stiffness, dashpot = _needed(table, "spring"), _number(table, "dashpot", 0.0)
    with_s = {} if s is None else {"s": s, "damping": plain_damping(tables.system)}
    with _by_the_case():
        return Mounted(stiffness, dashpot, gap=gap, **with_s)  # type: ignore[arg-type]


def sized_structure(table: BodyTable, tables: PhysicalCase, folder: Path) -> SizedBody:
    """The structure of a case in SI."""
    _check_keys(table)
    gap = 0.0 if table.gap is None else _si(table, "gap", "length")
    if table.kind == "modes":
        with _by_the_case():
            return SizedModes(**_columns(table, folder), gap=gap)
    spring = _si(table, "spring", "stiffness") if table.spring is not None else _needed(table, "spring")
    dashpot = 0.0 if table.dashpot is None else _si(table, "dashpot", "dashpot")
    bar = None
    if "bar" in tables.model_fields_set:
        found = sized_body(tables.bar)
        if not isinstance(found, Bar):
            raise ParameterError("kind", table.kind, "a bar of one section in [bar]")
        if table.mass is not None:
            raise ParameterError("mass", table.mass, "either a mass or a table [bar], not both")
        bar = found
    elif table.mass is None:
        raise ParameterError("mass", None, 'a mass with its unit, for example "5 kg", or a table [bar]')
    mass = 1.0 if table.mass is None else si(table.mass, "mass", "mass")
    with _by_the_case():
        return SizedMounted(spring, dashpot, bar, mass, gap)


def check_beside(tables: PhysicalCase | PlainCase) -> tuple[str, str, str] | None:
    """The table, key and words of what does not go with [body]; None for nothing."""
    table = tables.body
    assert table is not None
    for name in ("tool", "rock", "blow"):
        if getattr(tables, name, None) is not None:
            return name, "", "no such table beside [body]: its contact is with a rigid wall"
    struck = tables.system if isinstance(tables, PlainCase) else tables.contact
    if struck is not None and struck.law not in (None, "b77"):
        return "contact" if isinstance(tables, PhysicalCase) else "system", "law", 'only "b77" beside [body]'
    if struck is not None and struck.strain == "reversed":
        return "contact" if isinstance(tables, PhysicalCase) else "system", "strain", 'only "kept" beside [body]'
    if tables.load is not None and tables.load.kind == "valve":
        return "load", "kind", "a load that keeps time beside [body]"
    if tables.load is not None and tables.load.at:
        return "load", "at", "0 beside [body]: its table says where the load acts"
    if isinstance(tables, PlainCase):
        unfit = {"s", "d", "damping"} if table.kind == "modes" or tables.system.s is None else set()
        unfit |= {"impedances", "transit_times"}
        for name in sorted(unfit & tables.system.model_fields_set):
            return "system", name, "no such key beside this [body]"
    elif table.kind == "modes" and "bar" in tables.model_fields_set:
        return "bar", "", "no table [bar] beside a table of modes"
    return None


def _check_keys(table: BodyTable) -> None:
    for kind, names in _OF_KIND.items():
        for name in names:
            if kind != table.kind and getattr(table, name) is not None:
                raise ParameterError(name, getattr(table, name), f'nothing: it belongs to kind = "{kind}"')


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


@contextmanager
def _by_the_case() -> Iterator[None]:
    """A refusal of the model told in the words of the case."""
    try:
        yield
    except ParameterError as error:
        name, bracket, place = error.name.partition("[")
        key = {"delta": "damping", "stiffness": "spring", "rigid_mass": "mass"}.get(name, name)
        raise ParameterError(f"{key}{bracket}{place}", error.value, error.accepted, error.remedy) from None


def _number(table: BodyTable, name: str, default: float) -> float:
    value = getattr(table, name)
    if isinstance(value, str):
        raise ParameterError(name, value, "a plain number in a dimensionless case", "only a case in SI takes units")
    return default if value is None else float(value)


def _needed(table: BodyTable, name: str) -> float:
    if getattr(table, name) is None:
        raise ParameterError(name, None, f"the {name} of a body that is mounted")
    return _number(table, name, math.nan)


def _si(table: BodyTable, name: str, dimension: str) -> float:
    value = getattr(table, name)
    if not isinstance(value, str):
        raise ParameterError(name, value, f"text with a number and a unit of {dimension} in a case in SI")
    return si(value, dimension, name)


# ---- From the tables [tool], [rock] and [blow] of a case to what the bar strikes, and to the blow that is asked for


@dataclass(frozen=True)
class BlowQuestion:
    """One blow as a case asks for it: in SI, or dimensionless as the bar is.

    Attributes
    ----------
    striker
        What strikes: the bar in SI, or the dimensionless body.
    target
        What it strikes.
    velocity
        Speed toward the target, one number or one for each section; None asks for that of the steady motion.
    until
        End of the window; None until the blow is over.
    load
        The force on the bar: pairs of a time and the force from then on.
    load_at
        The step at which it acts; 0 is the driven end.
    """

    striker: SizedBody | Body
    target: Rod | Wall
    velocity: float | tuple[float, ...] | None = None
    until: float | None = None
    load: tuple[tuple[float, float], ...] = ()
    load_at: int = 0


# -- [tool] and [rock] ------------------------------------------------------------------------------------------------


def rock_of(table: RockTable) -> Rock:
    """The rock that the table [rock] describes."""
    from percuss.blow import Rock

    ratio = 1.0 if table.unloading_ratio is None else table.unloading_ratio
    return Rock(_tool_si(table, "stiffness", "stiffness"), ratio, _tool_si(table, "gap", "length"))


def sized_target(tool: ToolTable | None, rock: Rock | None, contact: ContactTable | None, bar: SizedBody) -> Rod | Wall:
    """What a bar in SI strikes; without a table [tool] the rod of `receiving_area`, or a rigid wall."""
    from percuss.blow import Rod, Wall

    if tool is None:
        return _without_tool(contact, bar)
    gap = _tool_si(tool, "gap", "length")
    if tool.kind == "wall":
        for key in ("sections", "end", "bit_mass"):
            if getattr(tool, key) is not None:
                raise ParameterError(key, None, f"no {key} of a wall", 'a rod has kind = "rod"')
        if rock is not None:
            raise ParameterError("kind", "wall", '"rod" beside a table [rock]', "take [rock] away, or describe the rod")
        return Wall(gap)
    if tool.sections is None:
        raise ParameterError("sections", None, 'the sections of the rod, or kind = "wall"', _SECTIONS)
    sections = sections_of("sections", tool.sections, tool)
    end = _end(tool, sections, rock)
    bit_mass = _tool_si(tool, "bit_mass", "mass")
    joints = _joint_masses(tool.sections)
    try:
        return Rod(sections, end, bit_mass=bit_mass, joint_masses=joints, rock=rock, gap=gap)
    except ParameterError as error:
        raise by_what_was_given(error, tool.sections) from None


def _joint_masses(tables: tuple[ToolSectionTable, ...]) -> tuple[tuple[int, float], ...]:
    """The masses at the steps: of each section but the last, which has none."""
    found = []
    for i, table in enumerate(tables):
        if table.joint_mass is not None:
            name = f"sections[{i}].joint_mass"
            mass = non_negative(name, si(table.joint_mass, "mass", name))
            if i + 1 < len(tables):
                found.append((i + 1, mass))
            elif mass > 0.0:
                remedy = "a mass at the end of the rod is bit_mass"
                raise ParameterError(name, table.joint_mass, "a section with another one behind it", remedy)
    return tuple(found)


NO_BIT = 'describe what is struck in [tool], a bit for example: sections = [{length = "0.2 m", diameter = "90 mm"}]'
"""What to do about a table [rock] without a table [tool]."""

_SECTIONS = 'for example sections = [{length = "1.2 m", diameter = "38 mm"}]'


def _without_tool(contact: ContactTable | None, bar: SizedBody) -> Rod | Wall:
    from percuss.blow import Rod, Wall

    if contact is None or contact.receiving_area is None:
        return Wall()
    area, last = si(contact.receiving_area, "area", "receiving_area"), bar.pieces[-1]
    rod = Section(None, area=area, youngs_modulus=last.youngs_modulus, density=last.density)
    return Rod((rod,), "infinite")


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


def _tool_si(table: ToolTable | RockTable, key: str, dimension: str) -> float:
    """The quantity of a key in SI; 0 when left out."""
    text = getattr(table, key)
    return 0.0 if text is None else si(text, dimension, key)


# -- [blow] -----------------------------------------------------------------------------------------------------------


def blow_question(table: BlowTable | None, striker: SizedBody | Body, target: Rod | Wall) -> BlowQuestion:
    """The blow that the table [blow] asks for; without the table from the steady motion until it is over."""
    if table is None:
        return BlowQuestion(striker, target)
    until = None if table.until is None else _tool_number(table.until, "time", "until")
    if until is not None and until <= 0.0:
        raise ParameterError("until", table.until, "a time greater than 0")
    load = tuple((_tool_number(t, "time", "load"), _tool_number(f, "force", "load")) for t, f in table.load or ())
    _check_load(table, load)
    body = striker.body(1.0 / striker.transit_time) if isinstance(striker, SizedBody) else striker
    try:
        body.place(table.load_at)
    except ParameterError as error:
        raise ParameterError("load_at", table.load_at, error.accepted, error.remedy) from None
    return BlowQuestion(striker, target, _velocity(table, striker), until, load, table.load_at)


def _check_load(table: BlowTable, load: tuple[tuple[float, float], ...]) -> None:
    times = [time for time, _ in load]
    if times and (times[0] < 0.0 or any(later <= earlier for earlier, later in pairwise(times))):
        raise ParameterError("load", [t for t, _ in table.load or ()], "times that increase from 0 or later")


def _velocity(table: BlowTable, striker: SizedBody | Body) -> float | tuple[float, ...] | None:
    given = table.velocity
    if given is None:
        return None
    if not isinstance(given, tuple):
        speed = _tool_number(given, "velocity", "velocity")
        if speed <= 0.0:
            raise ParameterError("velocity", given, "a speed greater than 0, toward the tool")
        return speed
    count = len(striker.pieces) if isinstance(striker, SizedBody) else len(getattr(striker, "impedances", (1.0,)))
    if len(given) != count:
        accepted = f"one speed, or one for each of the {count} sections" if count > 1 else "one speed of a uniform bar"
        raise ParameterError("velocity", list(given), accepted)
    return tuple(_tool_number(one, "velocity", "velocity") for one in given)


def _tool_number(value: Any, dimension: str, name: str) -> float:
    """A quantity with its unit in SI, or a plain number as it is."""
    return si(value, dimension, name) if isinstance(value, str) else float(value)
