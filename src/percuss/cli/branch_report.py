"""The report of `percuss follow`: what happens on each branch, and the cascade."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from percuss.case.answers.numerals import counted
from percuss.case.answers.orbits_answer import rest_cycles_dict
from percuss.case.answers.report_parts import PLAIN, Grid, Report, Section
from percuss.stability import orbit_multipliers

if TYPE_CHECKING:
    from percuss.explore import Branch, Diagram, DiagramBranch, PointCurve
    from percuss.steady import FoundRestCycles, PeriodicOrbit

_MOST = 4
"""Impacts of which a line tells."""


def orbit_row(name: str, orbit: PeriodicOrbit) -> tuple[str, ...]:
    """An orbit as a line of a table."""
    found = orbit_multipliers(orbit)
    return name, _few(orbit.phases.tolist()), _few(orbit.speeds.tolist()), f"{found.largest:.6g}", _word(found.stable)


def _word(stable: bool) -> str:
    return "yes" if stable else "no"


def _few(values: list[float]) -> str:
    told = ", ".join(f"{value:.6f}" for value in values[:_MOST])
    return told + (", …" if len(values) > _MOST else "")


def branch_report(title: str, branch: Branch, curves: Sequence[PointCurve] = ()) -> Report:
    """What happens on a branch and on those that were switched to from it, and on curves of its points."""
    every = list(branch.family())
    sections: list[Section | Grid] = [_branch(one) for one in every]
    if len(branch.cascade) > 1:
        rows = tuple(
            (row.label, f"{row.value:.12g}", "" if row.ratio is None else f"{row.ratio:.4f}") for row in branch.cascade
        )
        sections.append(Grid("Cascade", ("label", branch.parameter, "ratio"), rows))
    sections += [curve_section(one) for one in curves]
    low, high = float(branch.values.min()), float(branch.values.max())
    summary = f"{branch.label} over {branch.parameter}, {low:.9g} to {high:.9g}; branches: {len(every)}."
    return Report(title, summary, PLAIN, tuple(sections))


def _branch(branch: Branch) -> Section:
    rows = tuple((point.kind.value, f"{point.value:.12g}: {point.beyond}") for point in branch.points)
    return Section(f"{branch.label}, {counted(branch.values.size, 'point')}", rows)


def curve_section(curve: PointCurve) -> Section:
    """What happens on a curve of points."""
    head = f"{curve.event.value} of {curve.label} over {' and '.join(curve.parameters)}"
    rows = tuple(
        (point.kind.value, f"{point.values[0]:.12g}, {point.values[1]:.12g}: {point.beyond}") for point in curve.points
    )
    return Section(f"{head}, {counted(len(curve.values), 'point')}", rows)


# ---- The reports of `percuss orbits` and `percuss follow` on cycles with rest

_COLUMNS = ("number", "release [rad]", "phases [rad]", "speeds", "rest from [rad]")


def rest_report(title: str, found: FoundRestCycles, label: str) -> Report:
    """The cycles of a label, and where the other releases lead."""
    told = rest_cycles_dict(found, label)["label"]
    cycles = found.labelled(told)
    mode = "elastic mode" if found.system.body.is_free else "mode"
    summary = f"{counted(len(cycles), 'cycle')} {told}, {counted(found.modes, mode)}."
    return Report(title, summary, PLAIN, rest_sections(found, told))


def rest_sections(found: FoundRestCycles, label: str) -> tuple[Section | Grid, ...]:
    """The parts of a report on the cycles of a label."""
    cycles = found.labelled(label)
    sections: list[Section | Grid] = []
    if cycles:
        rows = tuple(
            (
                str(number),
                f"{cycle.release_phase:.9f}",
                _few(cycle.phases.tolist()),
                _few(cycle.speeds.tolist()),
                f"{cycle.rest_phase:.9f}",
            )
            for number, cycle in enumerate(cycles, 1)
        )
        sections.append(Grid(label, _COLUMNS, rows))
    lines = [("complete", "yes: one motion from each phase at which the load lets go"), ("multipliers", "all 0")]
    for release, number in zip(found.releases, found.leads_to, strict=True):
        end = (
            found.cycles[number].label
            if number >= 0
            else f"no return within {found.most} load periods, or rounding decides when"
        )
        lines.append((f"released at {release:.6f} rad", end))
    if not found.releases:
        lines.append(("release", "the load never turns from push to pull"))
    sections.append(Section(f"{label}: from the releases", tuple(lines)))
    return tuple(sections)


def rest_branch_report(title: str, branch: Branch, curves: Sequence[PointCurve] = ()) -> Report:
    """Where a branch of cycles with rest ends, how long the bar rests there, and what happens on curves of its ends."""
    rows = tuple((point.kind.value, f"{point.value:.12g}: {point.beyond}") for point in branch.points)
    rests = branch.rest_times
    lines = (
        ("multipliers", "all 0: stable all along"),
        ("shortest rest", f"{rests.min():.6g} to {rests.max():.6g} rad of the load"),
    )
    sections = (
        Section(f"{branch.label}, {counted(branch.values.size, 'point')}", rows),
        Section(f"{branch.label}: on the way", lines),
        *(curve_section(one) for one in curves),
    )
    low, high = float(branch.values[0]), float(branch.values[-1])
    return Report(title, f"{branch.label} over {branch.parameter}, {low:.9g} to {high:.9g}.", PLAIN, sections)


# ---- The report of `percuss diagram`: what simulations settle on, the branches, and what happens on them

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
    every: tuple[DiagramBranch, ...] = (*found.branches, *found.rest_branches)
    sections += [_diagram_branch(number, line) for number, line in enumerate(every, 1)]
    return Report(title, summary, PLAIN, tuple(sections))


def _simulated(found: Diagram) -> Grid:
    rows = []
    for label in found.labels[:_MOST_LABELS]:
        values = sorted({one.value for one in found.settled if one.label == label})
        rows.append((label, str(len(values)), f"{values[0]:.9g}", f"{values[-1]:.9g}"))
    more = len(found.labels) - _MOST_LABELS
    told = "simulated motions" if more <= 0 else f"simulated motions ({more} labels more: --json has all)"
    return Grid(told, ("label", f"values of {len(found.axis)}", "from", "to"), tuple(rows))


def _diagram_branch(number: int, line: DiagramBranch) -> Section:
    rows = tuple((point.kind.value, f"{point.value:.12g}: {point.beyond}") for point in line.points)
    return Section(f"branch {number}: {line.label}, {counted(line.values.size, 'point')}", rows)
