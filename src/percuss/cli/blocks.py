"""What a report is made of: a title, a summary, and sections of labelled lines."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["BAD", "GOOD", "PLAIN", "Report", "Section"]

GOOD, BAD, PLAIN = "good", "bad", ""


@dataclass(frozen=True)
class Section:
    """A heading and its lines: (label, text). `tone` says whether the news is good, bad or neither."""

    heading: str
    rows: tuple[tuple[str, str], ...]
    tone: str = PLAIN
    level: int = 1


@dataclass(frozen=True)
class Report:
    """What `percuss.cli.show` prints."""

    title: str
    summary: str
    tone: str
    sections: tuple[Section, ...]
