"""From the tables [tool], [rock] and [blow] of a case to what the bar strikes, and to the blow that is asked for."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Any

from percuss.case.file_format.schema import ContactTable
from percuss.case.file_format.section_tables import by_what_was_given, sections_of
from percuss.case.file_format.tool_tables import BlowTable, PlainTool, RockTable, ToolTable
from percuss.errors import ParameterError
from percuss.model.body import Body, Section, SizedBody, SteppedBar
from percuss.model.checks import positive
from percuss.units import si

if TYPE_CHECKING:
    from percuss.blow import Rock, Rod, Wall
    from percuss.blow.target import End

__all__ = ["NO_BIT", "BlowQuestion", "blow_question", "plain_target", "rock_of", "sized_target"]


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
    """The rock that the table [rock] describes.

    Raises
    ------
    ParameterError
        By the key of the table.
    """
    from percuss.blow import Rock

    ratio = 1.0 if table.unloading_ratio is None else table.unloading_ratio
    return Rock(_si(table, "stiffness", "stiffness"), ratio, _si(table, "gap", "length"))


def sized_target(tool: ToolTable | None, rock: Rock | None, contact: ContactTable | None, bar: SizedBody) -> Rod | Wall:
    """What a bar in SI strikes; without a table [tool] the rod of `receiving_area`, or a rigid wall.

    Raises
    ------
    ParameterError
        By the key of the table [tool].
    """
    from percuss.blow import Rod, Wall

    if tool is None:
        return _without_tool(contact, bar)
    gap = _si(tool, "gap", "length")
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
    bit_mass = _si(tool, "bit_mass", "mass")
    try:
        return Rod(sections, end, bit_mass=bit_mass, rock=rock, gap=gap)
    except ParameterError as error:
        raise by_what_was_given(error, tool.sections) from None


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
    """What a dimensionless body strikes; without a table [tool] a rigid wall.

    Raises
    ------
    ParameterError
        By the key of the table.
    """
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


def _si(table: ToolTable | RockTable, key: str, dimension: str) -> float:
    """The quantity of a key in SI; 0 when left out."""
    text = getattr(table, key)
    return 0.0 if text is None else si(text, dimension, key)


# -- [blow] -----------------------------------------------------------------------------------------------------------


def blow_question(table: BlowTable | None, striker: SizedBody | Body, target: Rod | Wall) -> BlowQuestion:
    """The blow that the table [blow] asks for; without the table from the steady motion until it is over.

    Raises
    ------
    ParameterError
        By the key of the table.
    """
    if table is None:
        return BlowQuestion(striker, target)
    until = None if table.until is None else _number(table.until, "time", "until")
    if until is not None and until <= 0.0:
        raise ParameterError("until", table.until, "a time greater than 0")
    load = tuple((_number(t, "time", "load"), _number(f, "force", "load")) for t, f in table.load or ())
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
        speed = _number(given, "velocity", "velocity")
        if speed <= 0.0:
            raise ParameterError("velocity", given, "a speed greater than 0, toward the tool")
        return speed
    count = len(striker.pieces) if isinstance(striker, SizedBody) else len(getattr(striker, "impedances", (1.0,)))
    if len(given) != count:
        accepted = f"one speed, or one for each of the {count} sections" if count > 1 else "one speed of a uniform bar"
        raise ParameterError("velocity", list(given), accepted)
    return tuple(_number(one, "velocity", "velocity") for one in given)


def _number(value: Any, dimension: str, name: str) -> float:
    """A quantity with its unit in SI, or a plain number as it is."""
    return si(value, dimension, name) if isinstance(value, str) else float(value)
