"""What a report is made of: a title, a summary, sections of labelled lines, and grids of figures."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["BAD", "GOOD", "PLAIN", "Grid", "Report", "Section"]

GOOD, BAD, PLAIN = "good", "bad", ""


@dataclass(frozen=True)
class Section:
    """A heading and its lines: (label, text). `tone` says whether the news is good, bad or neither."""

    heading: str
    rows: tuple[tuple[str, str], ...]
    tone: str = PLAIN
    level: int = 1


@dataclass(frozen=True)
class Grid:
    """A heading and a table: the names of its columns, and its rows; all but the first column are figures."""

    heading: str
    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]


@dataclass(frozen=True)
class Report:
    """What `percuss.cli.report_printing` prints."""

    title: str
    summary: str
    tone: str
    sections: tuple[Section | Grid, ...]
