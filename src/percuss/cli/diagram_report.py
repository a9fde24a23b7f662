"""The report of `percuss diagram`: what simulations settle on, the branches, and what happens on them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from percuss.case.answers.numerals import counted
from percuss.cli.report_parts import PLAIN, Grid, Report, Section

if TYPE_CHECKING:
    from percuss.explore import Diagram, DiagramBranch, DiagramRestBranch

__all__ = ["diagram_report"]

_MOST_LABELS = 12


def diagram_report(title: str, found: Diagram, mode: str = "elastic mode") -> Report:
    """Labels of what was simulated with the ranges in which they were met, and each branch.

    `mode`: what a mode is called.
    """
    low, high = float(found.axis.values.min()), float(found.axis.values.max())
    name, unit = found.axis.name, f" {found.axis.unit}" if found.axis.unit else ""
    summary = f"{name} from {low:.9g} to {high:.9g}{unit}, {counted(found.modes, mode)}; branches: "
    summary += f"{len(found.branches)}."
    if found.rest_branches:
        summary += f" Branches of cycles with rest: {len(found.rest_branches)}."
    if found.done < 1.0:
        summary += f" {int(1000.0 * found.done) / 10.0:g} % of the work was done: the diagram is not whole."
    if found.left_out:
        summary += f" Branches left out, as there are too many: {found.left_out}; ask for a smaller --switch."
    sections: list[Section | Grid] = []
    if found.settled:
        sections.append(_simulated(found))
    every: tuple[DiagramBranch | DiagramRestBranch, ...] = (*found.branches, *found.rest_branches)
    sections += [_branch(number, line) for number, line in enumerate(every, 1)]
    return Report(title, summary, PLAIN, tuple(sections))


def _simulated(found: Diagram) -> Grid:
    rows = []
    for label in found.labels[:_MOST_LABELS]:
        values = sorted({one.value for one in found.settled if one.label == label})
        rows.append((label, str(len(values)), f"{values[0]:.9g}", f"{values[-1]:.9g}"))
    more = len(found.labels) - _MOST_LABELS
    told = "simulated motions" if more <= 0 else f"simulated motions ({more} labels more: --json has all)"
    return Grid(told, ("label", f"values of {len(found.axis)}", "from", "to"), tuple(rows))


def _branch(number: int, line: DiagramBranch | DiagramRestBranch) -> Section:
    rows = tuple((point.kind.value, f"{point.value:.12g}: {point.beyond}") for point in line.points)
    return Section(f"branch {number}: {line.label}, {counted(line.values.size, 'point')}", rows)
