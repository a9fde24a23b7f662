"""The reports of `percuss orbits` and `percuss follow` on cycles with rest."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from percuss.case.answers.numerals import counted
from percuss.case.answers.rest_cycles_answer import rest_cycles_dict
from percuss.cli.branch_report import curve_section
from percuss.cli.report_parts import PLAIN, Grid, Report, Section

if TYPE_CHECKING:
    from percuss.explore import RestBranch, RestPointCurve
    from percuss.steady import FoundRestCycles

__all__ = ["rest_branch_report", "rest_report", "rest_sections"]

_COLUMNS = ("number", "release [rad]", "phases [rad]", "speeds", "rest from [rad]")
_MOST = 4
"""Impacts of which a line tells."""


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


def rest_branch_report(title: str, branch: RestBranch, curves: Sequence[RestPointCurve] = ()) -> Report:
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


def _few(values: list[float]) -> str:
    told = ", ".join(f"{value:.6f}" for value in values[:_MOST])
    return told + (", …" if len(values) > _MOST else "")
