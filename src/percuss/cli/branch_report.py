"""The report of `percuss follow`: what happens on each branch, and the cascade."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from percuss.case.answers.numerals import counted
from percuss.cli.report_parts import PLAIN, Grid, Report, Section
from percuss.stability import orbit_multipliers

if TYPE_CHECKING:
    from percuss.explore import Branch, PointCurve, RestPointCurve
    from percuss.steady import PeriodicOrbit

__all__ = ["branch_report", "curve_section", "orbit_row"]

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


def curve_section(curve: PointCurve | RestPointCurve) -> Section:
    """What happens on a curve of points."""
    head = f"{curve.event.value} of {curve.label} over {' and '.join(curve.parameters)}"
    rows = tuple(
        (point.kind.value, f"{point.values[0]:.12g}, {point.values[1]:.12g}: {point.beyond}") for point in curve.points
    )
    return Section(f"{head}, {counted(len(curve.values), 'point')}", rows)
