"""What the bar strikes, in a case: the tables [tool], [rock] and [blow].

The text below a key is what the reference prints.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BeforeValidator

from percuss.case.file_format.section_tables import SectionTable
from percuss.case.file_format.values import (
    Length,
    Mass,
    PlainNumber,
    PlainSteps,
    PlainVelocities,
    Steps,
    Stiffness,
    Table,
    Time,
    Velocities,
)

__all__ = [
    "BlowTable",
    "PlainBlow",
    "PlainTool",
    "RockTable",
    "ToolSectionTable",
    "ToolSections",
    "ToolTable",
]


class ToolSectionTable(SectionTable):
    """A section of the tool; the last one may have no end."""

    length: Length | None = None  # type: ignore[assignment]  # a section of the bar has one
    """Length of the section. Allowed: greater than 0. When left out: the last section is endless; the others need
    it."""


def _several(value: Any) -> Any:
    if not isinstance(value, list | tuple) or not value:
        raise ValueError('a list of sections, for example [{length = "1.2 m", diameter = "38 mm"}]')
    return tuple(value)


ToolSections = Annotated[tuple[ToolSectionTable, ...], BeforeValidator(_several)]
"""The sections of the tool from the struck face on."""


class ToolTable(Table):
    """What the bar strikes: a wall, or a rod of sections with something at its end."""

    kind: Literal["rod", "wall"] | None = None
    """A rod of `sections`, or a rigid wall, which takes no other key but `gap`. When left out: `"rod"`."""
    sections: ToolSections | None = None
    """Sections of the rod from the struck face on, see below. Allowed: up to 200 of them. When left out: only a wall
    has none."""
    end: Literal["infinite", "free", "fixed", "rock"] | None = None
    """What is at the end of the rod: nothing (`"free"`), a rigid support, the rock of `[rock]`; an infinite rod goes on
    for ever and sends nothing back. When left out: `"rock"`, with a table `[rock]`; `"infinite"`, when the last
    section has no length."""
    bit_mass: Mass | None = None
    """A mass at the end of the rod, such as a bit too short to be a section. Allowed: 0 or greater. When left out:
    none."""
    gap: Length | None = None
    """Distance between the striking end and the struck face when the blow begins. Allowed: 0 or greater. When left out:
    none."""


class PlainTool(Table):
    """What the bar of a dimensionless case strikes: a wall, or an endless rod known by its impedance alone."""

    kind: Literal["rod", "wall"] | None = None
    """A rod, or a rigid wall. When left out: `"rod"`."""
    impedance: PlainNumber | None = None
    """Impedance of the endless rod, divided by that of the bar's last section. Allowed: greater than 0. When left out:
    only a wall has none."""
    gap: PlainNumber | None = None
    """Distance between the striking end and the struck face when the blow begins, in bar lengths. Allowed: 0 or
    greater. When left out: 0."""


class RockTable(Table):
    """The rock, or the soil, at the end of the tool: loaded along one line, unloaded along a steeper one."""

    stiffness: Stiffness
    """Force per penetration while the force grows, $K_1$. Allowed: greater than 0."""
    unloading_ratio: float | None = None
    r"""γ: the force is taken off along $K_1/\gamma$, and $(1-\gamma)$ of the greatest penetration stays. Allowed:
    greater than 0, at most 1. When left out: 1, a rock that gives everything back."""
    gap: Length | None = None
    """Distance between the bit and the rock when the blow begins. Allowed: 0 or greater. When left out: none."""


class BlowTable(Table):
    """One blow, as `percuss blow` follows it."""

    velocity: Velocities | None = None
    """Speed of the bar toward the tool just before the blow, or a list with one for each section. When left out: that
    of the steady motion."""
    until: Time | None = None
    """Time from the start of the blow at which it is left. Allowed: greater than 0. When left out: the end of the blow,
    where that can be proved."""
    load: Steps | None = None
    """The force on the bar during the blow, positive toward the tool: pairs of a time and the force from then on. When
    left out: none."""
    load_at: int = 0
    """Where this force acts: 0, the driven end, or the number of a step of the bar, counted from there. Allowed: 0 or
    greater."""


class PlainBlow(BlowTable):
    """One blow of a dimensionless case: the keys of `BlowTable` without units."""

    velocity: PlainVelocities | None = None  # type: ignore[assignment]  # plain numbers in place of text
    until: PlainNumber | None = None  # type: ignore[assignment]
    load: PlainSteps | None = None  # type: ignore[assignment]
