"""Prints a report: coloured and wrapped for a person at a terminal, plain lines for a pipe or a file."""

from __future__ import annotations

import sys

from percuss.cli.blocks import Report

__all__ = ["plain_text", "show"]

_COLOURS = {"good": "green", "bad": "red", "": "default"}


def show(report: Report) -> None:
    """Print a report to stdout, in the manner that suits what stdout is."""
    if sys.stdout is not None and sys.stdout.isatty():
        _show_rich(report)
    else:
        print(plain_text(report), end="")


def plain_text(report: Report) -> str:
    """The report as plain lines, one for each row, never wrapped."""
    lines = [report.title, "=" * len(report.title), report.summary]
    for section in report.sections:
        lines += ["", section.heading if section.level == 1 else f"-- {section.heading}"]
        lines += [f"  {label:<16}{text}" for label, text in section.rows]
    return "\n".join(lines) + "\n"


def _show_rich(report: Report) -> None:
    from rich.console import Console
    from rich.padding import Padding
    from rich.table import Table
    from rich.text import Text

    console = Console(highlight=False)
    console.print(Text(report.title, style="bold"))
    console.print(Text(report.summary, style=f"bold {_COLOURS[report.tone]}"))
    for section in report.sections:
        console.print()
        console.print(Text(section.heading, style=f"bold {_COLOURS[section.tone]}"))
        table = Table.grid(padding=(0, 2))
        table.add_column(style="dim", no_wrap=True)
        table.add_column()
        for label, text in section.rows:
            table.add_row(Text(label), Text(text))
        console.print(Padding(table, (0, 0, 0, 2)))
