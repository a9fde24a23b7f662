"""The tables of what strikes and of what is struck: sections, damping, [body], [tool], [rock] and [blow]."""

from __future__ import annotations

from typing import Annotated, Any, Literal, NamedTuple

from pydantic import ValidationInfo

from percuss.case.file_format.values import (
    Area,
    CaseTable,
    DampingValue,
    Density,
    Kind,
    Length,
    Mass,
    NumberOrDashpot,
    NumberOrLength,
    NumberOrStiffness,
    Numbers,
    Steps,
    Stiffness,
    Stress,
    Time,
    Velocities,
    list_of,
)
from percuss.errors import ParameterError
from percuss.model import Bar


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

SystemDamping = Annotated[DampingTable, Kind("table", _no_plain_damping)]
"""The table in [system]."""


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


# ---- What the bar strikes: the tables [tool], [rock] and [blow]


class ToolSectionTable(SectionTable):
    """A section of the tool; the last one may have no end."""

    length: Length | None = None  # type: ignore[assignment]  # a section of the bar has one
    """Length of the section. Allowed: greater than 0. When left out: the last section is endless; the others need
    it."""
    joint_mass: Mass | None = None
    """A mass at the step to the next section, such as a coupling too short to be a section. Allowed: 0 or greater; the
    last section has no step. When left out: none."""


ToolSections = Annotated[tuple[ToolSectionTable, ...], list_of("sections", '{length = "1.2 m", diameter = "38 mm"}')]
"""The sections of the tool from the struck face on."""


class ToolTable(CaseTable):
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


class RockTable(CaseTable):
    """The rock, or the soil, at the end of the tool: loaded along one line, unloaded along a steeper one."""

    stiffness: Stiffness
    """Force per penetration while the force grows, $K_1$. Allowed: greater than 0."""
    unloading_ratio: float | None = None
    r"""γ: the force is taken off along $K_1/\gamma$, and $(1-\gamma)$ of the greatest penetration stays. Allowed:
    greater than 0, at most 1. When left out: 1, a rock that gives everything back."""
    gap: Length | None = None
    """Distance between the bit and the rock when the blow begins. Allowed: 0 or greater. When left out: none."""


class BlowTable(CaseTable):
    """One blow, as `percuss blow` follows it."""

    velocity: Velocities | None = None
    """Speed of the bar toward the tool just before the blow, or a list with one for each section. When left out: that
    of the steady motion, or of the cycle of a machine that switches its own valve."""
    until: Time | None = None
    """Time from the start of the blow at which it is left. Allowed: greater than 0. When left out: the end of the blow,
    where that can be proved."""
    load: Steps | None = None
    """The force on the bar during the blow, positive toward the tool: pairs of a time and the force from then on. When
    left out: none."""
    load_at: int = 0
    """Where this force acts: 0, the driven end, or the number of a step of the bar, counted from there. Allowed: 0 or
    greater."""
