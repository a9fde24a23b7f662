"""What strikes: the tables [bar], [system] and [body] of a case, their sections and damping, and the body made of them.

Whatever is refused is a `ParameterError` by the key of its table.
"""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any, Literal, NamedTuple

from pydantic import ValidationInfo

from percuss.case.file_format.values import (
    Advance,
    Area,
    CaseTable,
    DampingValue,
    Density,
    Drag,
    Kind,
    Law,
    Length,
    Mass,
    NumberOrDashpot,
    NumberOrLength,
    NumberOrStiffness,
    Numbers,
    Restitution,
    Strain,
    Stress,
    above_zero,
    given_in,
    keyed,
    list_of,
)
from percuss.errors import ParameterError
from percuss.model import Bar, External, Ratio, SizedBody, SteppedBar, UniformBar
from percuss.model.body import DAMPINGS, Body, Damping, Section, SectionedBar
from percuss.model.body.damping import share_of_critical
from percuss.model.checks import finite, non_negative
from percuss.units import si


class Material(NamedTuple):
    """What a wave is told of a material: E in Pa and the density in kg/m³."""

    youngs_modulus: float
    density: float


MATERIALS = {
    "steel": Material(Bar.STEEL_MODULUS, 7850.0),
    "titanium": Material(114e9, 4430.0),
    "aluminium": Material(70e9, 2700.0),
    "bronze": Material(110e9, 8800.0),
    "tungsten_carbide": Material(620e9, 14900.0),
}
"""Materials by their word, with the usual values."""


class SectionTable(CaseTable):
    """A length of one cross-section and one material."""

    length: Length
    """Length of the section. Allowed: greater than 0."""
    area: Area | None = None
    """Area of the cross-section. Allowed: greater than 0. When left out: `diameter` is needed."""
    diameter: Length | None = None
    """Outer diameter of a round section. Allowed: greater than 0. When left out: `area` is needed."""
    bore: Length | None = None
    """Diameter of a hole along the axis; `area` is that of the material. Allowed: 0 or greater, less than `diameter`.
    When left out: none."""
    material: Literal["steel", "titanium", "aluminium", "bronze", "tungsten_carbide"] | None = None
    """The material, instead of `youngs_modulus` and `density`. When left out: that of `[bar]`."""
    youngs_modulus: Stress | None = None
    """Young's modulus of the material. Allowed: greater than 0. When left out: that of `[bar]`, or steel."""
    density: Density | None = None
    """Density of the material. Allowed: greater than 0. When left out: that of `[bar]`, or steel."""


SectionTables = Annotated[tuple[SectionTable, ...], list_of("sections", '{length = "120 mm", diameter = "52 mm"}')]
"""The sections from the driven end to the striking end."""


# ---- The law of damping in a case: ``damping = {kind = "ratio", value = 1e-3}``, in [bar] or [system]

_EXAMPLE = 'a table such as {kind = "ratio", value = 0.001}'


class DampingTable(CaseTable):
    """How the bar loses energy between the impacts."""

    kind: Literal["ratio", "kelvin_voigt", "external", "table"]
    """The law, which decides what `value` is."""
    value: DampingValue
    """The number of the law, or its numbers."""


# -- what the key once was, or is taken for --


def _no_drag(value: Any, info: ValidationInfo) -> Any:
    if isinstance(value, str):
        raise ParameterError(
            "damping", value, _EXAMPLE, f'a force per velocity and metre is called drag: drag = "{value}"'
        )
    if isinstance(value, int | float) and not isinstance(value, bool):
        remedy = f"a share of the critical damping is called damping_ratio: damping_ratio = {value}"
        raise ParameterError("damping", value, _EXAMPLE, remedy)
    return value


def _no_plain_damping(value: Any, info: ValidationInfo) -> Any:
    if isinstance(value, str | int | float) and not isinstance(value, bool):
        raise ParameterError("damping", value, _EXAMPLE, "the external damping D/(MΩ) is called d")
    return value


BarDamping = Annotated[DampingTable, Kind("table", _no_drag)]
"""The table in [bar], where older case files have a quantity, which is told what it is called now."""

SystemDamping = Annotated[DampingTable, Kind("table", _no_plain_damping)]  # the table in [system]


# ---- The bar, in SI and in plain numbers


class BarTable(CaseTable):
    """The bar of a case in SI, uniform or of sections."""

    length: Length | None = None
    """Length from the driven to the striking end. Allowed: greater than 0. When left out: `sections` are needed."""
    area: Area | None = None
    """Area of the cross-section. Allowed: greater than 0. When left out: `diameter` is needed."""
    diameter: Length | None = None
    """Diameter of a solid round bar. Allowed: greater than 0. When left out: `area` is needed."""
    sections: SectionTables | None = None
    """Sections from the driven to the striking end, instead of `length`, `area` and `diameter`, see below. Allowed: up
    to 200 of them. When left out: the bar is uniform."""
    youngs_modulus: Stress | None = None
    """Young's modulus of the material. Allowed: greater than 0. When left out: steel, `"210 GPa"`."""
    density: Density | None = None
    """Density of the material. Allowed: greater than 0. When left out: steel, `"7850 kg/m^3"`."""
    damping_ratio: float | None = None
    """The damping as a share of the critical damping, the same for every elastic mode; the bar as a whole moves freely.
    Allowed: 0 to 1. When left out: 0.001, unless `damping` or `drag` says otherwise."""
    damping: BarDamping | None = None
    """The damping by another law, `{kind = "…", value = …}`, see below. When left out: `damping_ratio` holds."""
    drag: Drag | None = None
    """The damping as a force per velocity and per metre of bar, which brakes the bar as a whole, too. Allowed: 0 or
    greater. When left out: `damping_ratio` holds."""


class SystemTable(CaseTable):
    """A dimensionless bar and its contact."""

    s: float | None = None
    r"""Wave speed $C/(L\Omega)$. Allowed: greater than 0. When left out: the case needs a table `[body]`."""
    d: float | None = None
    r"""External damping $D/(M\Omega)$, which brakes the bar as a whole, too. Allowed: 0 or greater. When left out:
    `damping` is needed, or `impedances`, beside which it is 0."""
    restitution: Restitution
    """Coefficient of restitution, or `"from the blow"`: that of the blow on the tool, resolved by waves. Allowed: 0 to
    1."""
    damping: SystemDamping | None = None
    """The damping by another law, `{kind = "…", value = …}`, see below; `d` is 0 or left out beside it. When left
    out: `d` holds."""
    impedances: Numbers | None = None
    """Impedances of the sections of a stepped bar from the driven to the striking end, in any one unit. Allowed:
    positive, up to 200 of them. When left out: the bar is uniform."""
    transit_times: Numbers | None = None
    """Times that a wave takes through these sections, in any one unit: together they count as 1/s. Allowed: positive,
    as many as `impedances`. When left out: the bar is uniform."""
    strain: Strain | None = None
    """What the impact does to the strain in the bar: keep it (B77), or turn it over together with the velocity, as the
    waves in a uniform bar do. When left out: `"kept"`."""
    law: Law | None = None
    """What is known of the blow, as in `[contact]`. When left out: `"b77"`."""
    advance: Advance | None = None
    """How far the tool advances from blow to blow, as in `[contact]`. When left out: `"kept"`, but
    `"pushed back"` of a wall."""


# ---- A structure that something holds


class BodyTable(CaseTable):
    """A structure that is held, in place of a free bar."""

    kind: Literal["modes", "mounted"]
    """`"modes"`: a structure told by a table of its modes. `"mounted"`: a bar, or a rigid mass, on a spring and a
    dashpot at its driven end."""
    gap: NumberOrLength | None = None
    """Distance from the contact to the wall without any force; negative where the wall presses. With its unit in SI.
    When left out: no gap."""
    file: str | None = None
    """With `"modes"`: the file of the table, CSV with the columns `omega`, `damping`, `contact` and `drive`, looked for
    in the folder of the case. When left out: the four columns are given here."""
    omega: Numbers | None = None
    r"""With `"modes"`: frequencies $\omega_n$ in rad/s, or per radian of the load. Allowed: positive ones. When left
    out: `file` is needed."""
    damping: Numbers | None = None
    r"""With `"modes"`: $\delta_n = 2\zeta_n\omega_n$ in 1/s, or per radian of the load. Allowed: none of them negative.
    When left out: `file` is needed."""
    contact: Numbers | None = None
    r"""With `"modes"`: $a_n$, each mode where the structure strikes, normalised to the modal mass 1 kg, or 1. When left
    out: `file` is needed."""
    drive: Numbers | None = None
    """With `"modes"`: $b_n$, each mode where the load acts. When left out: `file` is needed."""
    spring: NumberOrStiffness | None = None
    r"""With `"mounted"`: the stiffness $k$ of the spring in N/m, or $k/(M\Omega^2)$. Allowed: greater than 0."""
    dashpot: NumberOrDashpot | None = None
    r"""With `"mounted"`: the force per velocity $c$ of the dashpot in N·s/m, or $c/(M\Omega)$. Allowed: 0 or greater.
    When left out: no dashpot."""
    mass: Mass | None = None
    """With `"mounted"` in SI, without `[bar]`: the rigid mass. When left out: `[bar]` is needed."""


# ---- From these tables to the body that strikes


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
    with by_what_was_given(table.sections):
        bar = SectionedBar(sections)
    law = damping.get("damping")
    if "damping_ratio" in damping:
        law = Ratio(share_of_critical("damping_ratio", damping["damping_ratio"]))
    return replace(bar, damping=law or External(damping["drag"] * bar.length / bar.mass))


def sections_of(tables: Sequence[SectionTable], common: object) -> tuple[Section, ...]:
    """The sections of a list; what `common` says of the material holds where a section says nothing."""
    return tuple(_section(f"sections[{i}].", table, common) for i, table in enumerate(tables))


@contextmanager
def by_what_was_given(tables: Sequence[SectionTable]) -> Iterator[None]:
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
    """The table of a law, as JSON has it; `damping_law` backwards."""
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


def columns_of(table: BodyTable, folder: Path) -> dict[str, Any]:
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
