"""The sections of a stepped bar in a case: ``sections = [{length = "120 mm", diameter = "52 mm"}, …]`` in [bar]."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Annotated, Any, Literal, NamedTuple

from pydantic import BeforeValidator

from percuss.case.file_format.values import Area, Density, Length, Stress, Table
from percuss.errors import ParameterError
from percuss.model.body import Bar, Damping, External, Section, SectionedBar
from percuss.model.checks import non_negative, positive
from percuss.units import si

__all__ = ["MATERIALS", "SectionTable", "SectionTables", "sectioned_bar", "sections_of"]


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


class SectionTable(Table):
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


def _several(value: Any) -> Any:
    if not isinstance(value, list | tuple) or not value:
        raise ValueError('a list of sections, for example [{length = "120 mm", diameter = "52 mm"}]')
    return tuple(value)


SectionTables = Annotated[tuple[SectionTable, ...], BeforeValidator(_several)]
"""The sections from the driven end to the striking end."""


def sectioned_bar(tables: tuple[SectionTable, ...], common: Any, damping: Damping | None, drag: float) -> SectionedBar:
    """The bar of sections; `common` is the table [bar], whose material they share.

    Parameters
    ----------
    damping, drag
        The law of damping, or without one the force per velocity and per metre of bar in N·s/m²: spread over the bar
        as its mass is.

    Raises
    ------
    ParameterError
        By the key of the table.
    """
    sections = sections_of("sections", tables, common)
    try:
        bar = SectionedBar(sections)
    except ParameterError as error:
        raise by_what_was_given(error, tables) from None
    return replace(bar, damping=damping or External(drag * bar.length / bar.mass))


def sections_of(name: str, tables: Sequence[SectionTable], common: Any) -> tuple[Section, ...]:
    """The sections of a list under a key; what `common` says of the material holds where a section says nothing.

    Raises
    ------
    ParameterError
        By the key and the number of the section.
    """
    return tuple(_section(f"{name}[{i}].", table, common) for i, table in enumerate(tables))


def by_what_was_given(error: ParameterError, tables: Sequence[SectionTable]) -> ParameterError:
    """The refusal of an area that follows from a diameter, by the key of the diameter."""
    for i, table in enumerate(tables):
        if error.name == f"sections[{i}].area" and table.diameter is not None:
            return ParameterError(f"sections[{i}].diameter", table.diameter, error.accepted, error.remedy)
    return error


def _section(name: str, table: SectionTable, common: Any) -> Section:
    sizes: dict[str, Any] = {"length": None}
    for key, dimension in (("length", "length"), ("area", "area"), ("diameter", "length")):
        if (text := getattr(table, key)) is not None:
            sizes[key] = _size(name + key, text, dimension)
    bore = 0.0 if table.bore is None else non_negative(f"{name}bore", si(table.bore, "length", f"{name}bore"))
    material = _material(name, table, common)
    try:
        return Section(**sizes, bore=bore, **material._asdict())
    except ParameterError as error:
        accepted = f"less than the diameter, {table.diameter}" if error.name == "bore" else error.accepted
        raise ParameterError(name + error.name, error.value, accepted, error.remedy) from None


def _material(name: str, table: SectionTable, common: Any) -> Material:
    own = table.youngs_modulus, table.density
    if table.material is not None:
        if own != (None, None):
            raise ParameterError(f"{name}material", table.material, "a material, or a modulus and a density, not both")
        return MATERIALS[table.material]
    steel, found = MATERIALS["steel"], {}
    for key, dimension in (("youngs_modulus", "pressure"), ("density", "density")):
        for where, at in ((table, name), (common, "")):
            if key not in found and (text := getattr(where, key, None)) is not None:
                found[key] = _size(at + key, text, dimension)
    return steel._replace(**found)


def _size(name: str, text: str, dimension: str) -> float:
    try:
        return positive(name, si(text, dimension, name))
    except ParameterError:
        raise ParameterError(name, text, f"a {dimension} greater than 0") from None
