"""Where random starts end, as a section of the report."""

from __future__ import annotations

from typing import TYPE_CHECKING

from percuss.case.answers.ends_in_words import does, power
from percuss.case.answers.numerals import counted
from percuss.cli.files import as_typed
from percuss.cli.report_parts import Section

if TYPE_CHECKING:
    from percuss.case.answers.ends import End, Ends
    from percuss.model import System

__all__ = ["ends_section"]


def ends_section(ends: Ends, name: str, system: System) -> Section:
    """What the starts were, and a line for each end."""
    if not ends.followed:
        return Section("Random starts", (("starts", f"not followed: {ends.note}"),))
    modes = counted(ends.modes, "elastic mode") if ends.modes else "a rigid bar"
    begun = f"{ends.followed} on the wall, leaving it with a random speed at a random phase; {modes}, up to "
    begun += f"{counted(ends.impacts, 'impact')}"
    rows = [("starts", f"{begun}; 'percuss experiment {as_typed(name)}' follows more")]
    rows += [(end.label, _line(end, ends.followed, system)) for end in ends.ends]
    if ends.note:
        rows.append(("note", ends.note))
    return Section("Random starts", tuple(rows))


def _line(end: End, followed: int, system: System) -> str:
    text = f"{end.starts} of {followed} {does(end.label, end.starts)}"
    delivered = power(end, system)
    return f"{text}: {delivered}" if delivered else text
