"""What a report is made of: a title, a summary, sections of labelled lines, and grids of figures."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from percuss.case.answers.numerals import counted, number, ordinal, percent, quantity
from percuss.case.answers.sentences import law_in_words

if TYPE_CHECKING:
    from percuss.model import SizedBody, System, Timed
    from percuss.recordings.history import HistoryReport

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


# ---- What was understood of a hammer, the first section of its reports

_FEW = 8
"""Sections of a bar that are told one by one."""


def system_section(name: str, system: System, notes: tuple[str, ...], law: Timed | None = None) -> Section:
    """What was understood of the hammer: bar, dimensionless numbers, load, recording."""
    rows: list[tuple[str, str]] = [("case", name)]
    bar, history = system.bar, system.load.report
    if not system.body.is_free:
        rows += [*_structure_rows(system), ("load", _load_text(system)), *(("note", note) for note in notes)]
        return Section("Structure", tuple(rows))
    if bar is not None:
        first = float(bar.natural_frequencies(1)[0])
        rows.append(
            (
                "bar",
                f"{quantity(bar.length, 'm')} long, {_areas(bar)}, {number(bar.mass)} kg, "
                f"wave speed {number(bar.wave_speed)} m/s, first mode {quantity(first, 'Hz')}",
            )
        )
    rows.append(
        (
            "dimensionless",
            f"s = {number(system.s, 6)}, d = {number(system.d, 6)}, restitution R = {number(system.restitution)}",
        )
    )
    rows.append(("damping", _damping_text(system)))
    rows.append(("contact", system.contact.sentence))
    if law is not None:
        rows.append(("blow", law_in_words(law, system)))
    rows.append(("load", _load_text(system)))
    if history is not None:
        rows.append(("history", _history_text(history)))
        rows += [("warning", warning) for warning in history.warnings]
    rows += [("note", note) for note in notes]
    return Section("Hammer", tuple(rows))


def _structure_rows(system: System) -> list[tuple[str, str]]:
    """What was understood of the structure."""
    body, bar = system.body, system.bar
    rows = [("structure", str(body) if bar is None else str(bar))]
    known = body.modes(body.kept(4), system.load.at)
    told = ", ".join(number(omega, 6) for omega in known.omega)
    rows.append(("modes", f"ω = {told} per radian of the load, damped by {', '.join(map(number, known.damping))}"))
    if bar is not None and system.frequency is not None:
        rows.append(("frequencies", ", ".join(quantity(f, "Hz") for f in bar.natural_frequencies(known.size).tolist())))
    gap = number(body.gap) if bar is None else quantity(body.gap * system.length_scale, "m")
    rows.append(("gap", f"{gap}, restitution R = {number(system.restitution)}"))
    return rows


def _areas(bar: SizedBody) -> str:
    """The cross-section of a bar, or those of its sections from the driven end on."""
    areas = [number(1e4 * piece.area) for piece in bar.pieces]
    if len(areas) == 1:
        return f"{areas[0]} cm²"
    told = areas if len(areas) <= _FEW else [*areas[: _FEW - 1], "…", areas[-1]]
    return f"{len(areas)} sections of {', '.join(told)} cm²"


def _damping_text(system: System) -> str:
    """The law of damping in words; in SI with the drag of one that brakes the bar as a whole."""
    words = system.body.damping.words
    if system.bar is None or not system.bar.rigid_drag:
        return words
    return f"{words}; c = {number(system.bar.rigid_drag)} N·s/m"


def _load_text(system: System) -> str:
    load = system.load
    size, last = load.harmonics.size, int(load.harmonics.max(initial=0))
    shape = counted(size, "harmonic")
    shape += f" up to the {ordinal(last)}" if last > size else ""
    if load.is_piecewise:
        shape = f"{len(load.values)} exact steps (and {shape})"
    factor = f"mean / first harmonic = {number(load.load_factor)}"
    if not system.is_si or system.frequency is None:
        return f"mean {number(load.mean)}, {shape}, {factor}"
    return f"mean {quantity(load.mean * system.force_scale, 'N')}, {shape}, {factor}, {number(system.frequency)} Hz"


def _history_text(report: HistoryReport) -> str:
    found = "given" if report.frequency_given else "found"
    return (
        f"{counted(report.cycles, 'cycle')}, {report.samples} samples at {quantity(report.sample_rate, 'Hz')}; "
        f"{number(report.frequency, 5)} Hz ({found}), period varies by {percent(report.jitter)}; cycles scatter "
        f"{percent(report.scatter)} about their mean, drift {percent(report.drift)}; the harmonics "
        f"do not capture {percent(report.residual)}"
    )
