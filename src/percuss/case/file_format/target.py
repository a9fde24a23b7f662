"""What is struck: the tables [tool], [rock] and [blow] of a case, and the blow that is asked for."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Annotated, Literal

from percuss.case.file_format.bodies import SectionTable, by_what_was_given, sections_of
from percuss.case.file_format.values import (
    CaseTable,
    Length,
    Mass,
    Steps,
    Stiffness,
    Time,
    Velocities,
    above_zero,
    given_in,
    keyed,
    list_of,
    number_of,
)
from percuss.errors import ParameterError
from percuss.model import SizedBody
from percuss.model.body import Body, Section
from percuss.model.checks import non_negative
from percuss.units import si

if TYPE_CHECKING:
    from percuss.blow import Rock, Rod, Wall
    from percuss.blow.bodies import End


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


# ---- From these tables to what the bar strikes, and to the blow that is asked for


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


def sized_target(tool: ToolTable | None, rock: Rock | None, receiving_area: str | None, bar: SizedBody) -> Rod | Wall:
    """What a bar in SI strikes; without a table [tool] the rod of `receiving_area`, or a rigid wall."""
    from percuss.blow import Rod, Wall

    if tool is None:
        if receiving_area is None:
            return Wall()
        area, last = si(receiving_area, "area", "receiving_area"), bar.pieces[-1]
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
    with by_what_was_given(tool.sections):
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
