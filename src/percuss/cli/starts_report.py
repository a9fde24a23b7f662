"""The reports of `percuss experiment` and `percuss basins`: where starts end."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from percuss.case.answers.clock_note import clock_in_short, clock_note
from percuss.case.answers.numerals import counted, number, percent
from percuss.cli.map_report import bar_in_words
from percuss.cli.report_parts import BAD, GOOD, PLAIN, Grid, Report, Section
from percuss.model import Machine

if TYPE_CHECKING:
    from percuss.explore import Basins, Experiment, Share
    from percuss.model import System

__all__ = ["basins_report", "experiment_report"]


def experiment_report(title: str, found: Experiment) -> Report:
    """The results of random starts."""
    shares, system = found.shares, found.system
    rows = [
        ("starts", f"{len(found)}, {found.distribution}, seed {found.seed}"),
        ("bar", bar_in_words(found.modes)),
        ("ends", f"after at most {counted(found.stop.most_impacts, 'impact')}, or when the motion is found"),
    ]
    if isinstance(system, Machine):
        tone, summary = _of_machine(shares, len(found))
    else:
        tone, summary, note = _under_clock(shares, system)
        rows += [("note", note)] if note else []
    return Report(title, summary, tone, (Section("Experiment", tuple(rows)), _attractors(shares, system)))


def _under_clock(shares: Sequence[Share], system: System) -> tuple[str, str, str]:
    """How good it is, what is said first, and the note on the clock, if any."""
    first, load = shares[0], system.load
    tone = GOOD if first.label.startswith("z=") and len(shares) == 1 else BAD if first.label == "departed" else PLAIN
    summary = f"{first.label} in {percent(first.share)} of the starts"
    summary += "." if len(shares) == 1 else f"; {len(shares)} motions in all."
    if system.is_si:
        load = load.scaled(system.force_scale, frequency=system.frequency)
    return tone, f"{summary} {clock_in_short(load)}".rstrip(), clock_note(load) or ""


def _of_machine(shares: Sequence[Share], starts: int) -> tuple[str, str]:
    """How good it is, and how many starts run and how many stall."""
    run = sum(share.members for share in shares if share.label.startswith("runs"))
    stall = sum(share.members for share in shares if share.label.startswith("stalls"))
    told = f"The machine runs from {percent(run / starts)} of the starts"
    told += f" and stalls from {percent(stall / starts)}." if stall else "."
    if len(shares) > 1:
        told += f" {counted(len(shares), 'motion')} in all."
    return (GOOD if run == starts else PLAIN if run else BAD), told


def basins_report(title: str, found: Basins) -> Report:
    """What a plane of starts leads to."""
    (x, over), (y, up) = found.x, found.y
    rows = [
        (name, f"{number(values[0])} to {number(values[-1])}, {counted(len(values), 'value')}")
        for name, values in (found.x, found.y)
    ]
    words = found.hammer.words
    rows += [(name, words[name][int(value)] if name in words else number(value)) for name, value in found.at]
    rows.append(("bar", bar_in_words(found.modes)))
    shares = found.shares
    summary = f"{counted(len(over) * len(up), 'start')} over {x} and {y}: {counted(len(shares), 'attractor')}."
    return Report(
        title, summary, PLAIN, (Section("Basins", tuple(rows)), _attractors(shares, found.system, sample=False))
    )


def _attractors(shares: Sequence[Share], system: System | Machine, sample: bool = True) -> Grid:
    """A line for each attractor; the interval only where the starts are a sample."""
    speed, unit = (system.speed_scale, " [m/s]") if system.is_si else (1.0, "")
    when = f"period{' [s]' if system.is_si else ''}" if isinstance(system, Machine) else "phases [rad]"
    head = ("motion", "share", *(("95 % interval",) if sample else ()), when, f"striking speeds{unit}")
    rows = tuple(
        (
            share.label,
            percent(share.share),
            *((f"{percent(share.low)} … {percent(share.high)}",) if sample else ()),
            _when(share, system),
            _few(tuple(speed * velocity for velocity in share.impact_velocities)),
        )
        for share in shares
    )
    return Grid("Attractors", head, rows)


def _when(share: Share, system: System | Machine) -> str:
    """The phases of the impacts under a clock, the period of a machine that switches itself."""
    if not isinstance(system, Machine):
        return _few(share.phases)
    period = share.attractor.figures["period"]
    return "" if period is None else f"{period * (system.time_scale if system.is_si else 1.0):.4g}"


def _few(values: tuple[float, ...], most: int = 3) -> str:
    told = ", ".join(f"{value:.4g}" for value in values[:most])
    return told + (", …" if len(values) > most else "")
