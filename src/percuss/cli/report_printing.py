"""Prints a report: coloured and wrapped for a person at a terminal, plain lines for a pipe or a file."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from percuss.case.answers.facts import Grid, Report, ReportSection
from percuss.short_repr import one_line

if TYPE_CHECKING:
    import argparse

    from matplotlib.figure import Figure

    from percuss.case import BlowAnswer, Case
    from percuss.plot.reports.report_pages import Answer

_COLOURS = {"good": "green", "bad": "red", "": "default"}


def show(report: Report) -> None:
    """Print a report to stdout, in the manner that suits what stdout is."""
    report = _escaped(report)
    if sys.stdout is not None and sys.stdout.isatty():
        _show_rich(report)
    else:
        print(plain_text(report), end="")


def _escaped(report: Report) -> Report:
    sections: list[ReportSection | Grid] = []
    for part in report.sections:
        heading, rows = one_line(part.heading), tuple(tuple(map(one_line, row)) for row in part.rows)
        if isinstance(part, Grid):
            sections.append(replace(part, heading=heading, columns=tuple(map(one_line, part.columns)), rows=rows))
        else:
            sections.append(replace(part, heading=heading, rows=tuple((label, text) for label, text in rows)))
    return replace(report, title=one_line(report.title), summary=one_line(report.summary), sections=tuple(sections))


def plain_text(report: Report) -> str:
    """The report as plain lines, one for each row, never wrapped."""
    lines = [report.title, "=" * len(report.title), report.summary]
    for section in report.sections:
        lines.append("")
        if isinstance(section, Grid):
            lines += [section.heading, *_plain_grid(section)]
            continue
        lines.append(section.heading if section.level == 1 else f"-- {section.heading}")
        width = max([14, *(len(label) for label, _ in section.rows)]) + 2
        lines += [f"  {label:<{width}}{text}" for label, text in section.rows]
    return "\n".join(lines) + "\n"


def _plain_grid(grid: Grid) -> list[str]:
    """Aligned columns: the first to the left, the figures to the right."""
    table = [grid.columns, *grid.rows]
    widths = [max(len(row[i]) for row in table) for i in range(len(grid.columns))]

    def line(row: tuple[str, ...]) -> str:
        first, *rest = row
        return "  " + "  ".join(
            [f"{first:<{widths[0]}}", *(f"{x:>{w}}" for x, w in zip(rest, widths[1:], strict=True))]
        )

    return [line(row) for row in table]


def _show_rich(report: Report) -> None:
    from rich import box
    from rich.console import Console
    from rich.padding import Padding
    from rich.table import Table
    from rich.text import Text

    console = Console(highlight=False)
    console.print(Text(report.title, style="bold"))
    console.print(Text(report.summary, style=f"bold {_COLOURS[report.tone]}"))
    for section in report.sections:
        console.print()
        tone = section.tone if isinstance(section, ReportSection) else ""
        console.print(Text(section.heading, style=f"bold {_COLOURS[tone]}"))
        if isinstance(section, Grid):
            table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
            for i, name in enumerate(section.columns):  # narrow: no figure is cut
                table.add_column(Text(name), justify="right" if i else "left", overflow="fold")
        else:
            table = Table.grid(padding=(0, 2))
            table.add_column(style="dim", no_wrap=True)
            table.add_column()
        for row in section.rows:
            table.add_row(*map(Text, row))
        console.print(Padding(table, (0, 0, 0, 2)))


def filed(
    path: str | None, options: argparse.Namespace, case: Case, answer: Answer, blow: BlowAnswer | None = None
) -> None:
    """Write the report as a file, HTML or PDF by its name, where one is wanted."""
    if path is None:
        return
    from percuss.atomic_write import write_whole

    if path.lower().endswith(".pdf"):
        from percuss.plot.reports.pdf_report import report_pdf

        write_whole(path, report_pdf(case, answer, None, blow, options.paper, options.language))
    else:
        from percuss.plot.reports.html_report import report_html

        write_whole(path, report_html(case, answer, None, blow, options.language))


def answered(
    options: argparse.Namespace,
    data: Callable[[], Any],
    report: Callable[[], Report],
    drawn: Callable[[], Figure] | None = None,
    /,
    *,
    dataset: Callable[[], Any] | None = None,
    indent: int | None = None,
    cut: str = "",
    **files: str | None,
) -> int:
    """Make the files that were asked for, print the answer as JSON or as its report, and name the files."""
    # A `dataset` is what --csv and --netcdf write, --plot draws the picture, and `files` are those that are made
    # already. Returns the exit code: 130 with a line on what Ctrl-C has `cut` off.
    csv, netcdf, picture = (getattr(options, name, None) for name in ("csv", "netcdf", "plot"))
    if dataset is not None and (csv or netcdf):
        from percuss.atomic_write import write_dataset
        from percuss.explore.jobs.archive_export import write_csv

        for path, write in ((csv, write_csv), (netcdf, write_dataset)):
            if path is not None:
                write(dataset(), path)
        files = {**files, **({"table": csv} if csv else {}), "data": netcdf}
    told = data() if options.json else ""
    text = told if isinstance(told, str) else json.dumps(told, indent=indent, allow_nan=False)
    if picture is not None and drawn is not None:
        from percuss.plot import save

        save(drawn(), picture)
    if options.json:
        print(text)
    else:
        show(report())
    for what, path in {**files, "picture": picture}.items():
        if path is not None:
            print(f"{what}: {path}", file=sys.stderr if options.json else sys.stdout)
    if cut:
        print(f"percuss: interrupted: {cut}", file=sys.stderr)
    return 130 if cut else 0
