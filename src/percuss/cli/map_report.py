"""The report of `percuss sweep`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from percuss.case.answers.clock_note import clock_in_short, clock_note
from percuss.case.answers.numerals import counted, number, percent
from percuss.case.answers.numerals import counted as _counted
from percuss.case.answers.report_parts import BAD, GOOD, PLAIN, Grid, Report, Section
from percuss.explore.quantities import CELL_OUTCOMES, MACHINE_QUANTITIES, QUANTITIES, needs
from percuss.model import Machine

if TYPE_CHECKING:
    from percuss.explore import Axis, Basins, Boundaries, Experiment, Share, Sweep
    from percuss.explore.sweeps import Range
    from percuss.model import System

_MOST_LABELS = 6
_MOST_ROWS = 40


def sweep_report(
    title: str,
    found: Sweep,
    curves: Boundaries | None = None,
    ranges: Mapping[str, Sequence[Range]] | None = None,
    notes: Sequence[str] = (),
) -> Report:
    """What a map holds, quantity by quantity; along one axis where it is stable, and its values as a table."""
    cells = int(np.prod([len(axis) for axis in found.axes]))
    over = " and ".join(axis.name for axis in found.axes)
    of_case = tuple(("note", note) for note in notes)
    sections: list[Section | Grid] = [Section("Map", (*_map_rows(found, cells), *of_case))]
    sections.append(Section("Quantities", tuple((name, _quantity(found, name)) for name in found.quantities)))
    if ranges:
        (axis,) = found.axes
        told = tuple((name, _ranges(axis, parts)) for name, parts in ranges.items())
        sections.append(Section(f"Along {axis.name}", told))
    if curves is not None:
        sections.append(Section("Boundaries", _curve_rows(curves)))
    if len(found.axes) == 1:
        sections.append(_table(found))
    return Report(title, f"{_counted(cells, 'cell')} over {over}.", PLAIN, tuple(sections))


def _map_rows(found: Sweep, cells: int) -> tuple[tuple[str, str], ...]:
    rows = [(axis.name, _axis(axis)) for axis in found.axes]
    of_machines = bool(found.ask.get("machines"))
    asked = needs(found.ask["quantities"], MACHINE_QUANTITIES if of_machines else QUANTITIES)
    of_orbits = asked & {"orbits", "exact"} and all(axis.name != "m" for axis in found.axes)
    per_impact = f"{_counted(found.ask['periods'], 'load period')} per impact" if of_orbits else ""
    if asked & {"exact", "simulation", "lyapunov"}:
        told = str(found.ask["modes"])
        if "simulated" in found.ask:
            told += f", simulated with {found.ask['simulated']}"
        rows.append(("modes", f"{told}{'; ' if per_impact else ''}{per_impact}"))
    elif "machine" in asked:
        rows.append(("bar", bar_in_words(found.ask["modes"])))
    elif per_impact:
        rows.append(("periods", per_impact))
    codes, counts = np.unique(found["outcome"], return_counts=True)
    words = found.words["outcome"]
    failed = [
        f"{n} {words[code] if code >= 0 else 'not computed'}" for code, n in zip(codes, counts, strict=True) if code
    ]
    if failed:
        rows.append(("cells", f"{cells - int(counts[codes != 0].sum())} ok, {', '.join(failed)}"))
    return tuple(rows)


def bar_in_words(modes: int) -> str:
    """What is kept of the bar."""
    return "rigid" if modes == 0 else _counted(modes, "elastic mode")


def _axis(axis: Axis) -> str:
    unit = f" {axis.unit}" if axis.unit else ""
    n = len(axis)
    return f"{number(axis.values[0])}{unit}" + (f" to {number(axis.values[-1])}{unit}, {n} values" if n > 1 else "")


def _quantity(found: Sweep, name: str) -> str:
    values = found[name]
    if name in found.words:
        values = np.array([*found.words[name], ""])[values]
    if values.dtype.kind == "U":
        return _words(values, *_answered(found))
    if values.dtype == bool:
        answered, whose = _answered(found)
        return f"in {percent(float(values[answered].mean()))} of {whose}" if answered.any() else "nowhere"
    there = values[np.isfinite(values)] if values.dtype.kind == "f" else values[values >= 0]
    at_rest = int(np.isneginf(values).sum()) if name == "lyapunov" else 0
    resting = f"comes to rest (−∞) in {_counted(at_rest, 'cell')}"
    if not there.size:
        return resting if at_rest else "nowhere"
    unit = found.columns[name].unit
    span = f"{number(float(there.min()))} to {number(float(there.max()))}{' ' + unit if unit else ''}"
    if there.size < values.size and values.ndim == len(found.axes):
        span += f", in {_counted(there.size, 'cell')}"
    return f"{span}; {resting}" if at_rest else span


def _answered(found: Sweep) -> tuple[np.ndarray[Any, Any], str]:
    """Which cells have values, and what they are called."""
    outcome = found["outcome"]
    answered = (outcome == 0) | (outcome == 1)
    if answered.all():
        return answered, "the cells"
    without = np.unique(outcome[~answered]).tolist() == [CELL_OUTCOMES.index("no system")]
    n = int(answered.sum())
    one = "has" if n == 1 else "have"
    return answered, f"the {_counted(n, 'cell')} that {one} {'a system' if without else 'an answer'}"


def _words(values: np.ndarray[Any, Any], answered: np.ndarray[Any, Any], whose: str) -> str:
    kinds, counts = np.unique(values[answered & (values != "")], return_counts=True)
    order = np.argsort(-counts, kind="stable")
    told = [f"{kinds[i]} {percent(counts[i] / answered.sum())}" for i in order[:_MOST_LABELS]]
    if len(kinds) > _MOST_LABELS:
        told.append(_counted(len(kinds) - _MOST_LABELS, "other"))
    return (", ".join(told) + ("" if answered.all() else f", of {whose}")) if told else "nowhere"


def _ranges(axis: Axis, parts: Sequence[Range]) -> str:
    """The ranges of an axis where a quantity is true; an end inside the axis is solved for and has more digits."""
    if not parts:
        return "nowhere"
    unit = f" {axis.unit}" if axis.unit else ""
    if len(parts) == 1 and not parts[0].opens and not parts[0].closes:
        return "everywhere"
    return "; ".join(
        f"{number(part.first, 6)} to {number(part.last, 6)}{unit}"
        if part.first != part.last
        else f"at {number(part.first, 6)}{unit}"
        for part in parts
    )


def _table(found: Sweep) -> Grid:
    """A line for each value of the axis, of many for some at even distances."""
    (axis,) = found.axes
    n = len(axis)
    rows = np.unique(np.linspace(0, n - 1, min(n, _MOST_ROWS)).round().astype(int))
    names = [name for name in found.quantities if found[name].ndim == 1]
    failed = bool((found["outcome"] > 1).any())
    units = [axis.unit, *(found.columns[name].unit if name in found.columns else "" for name in names)]
    head = tuple(f"{name} [{unit}]" if unit else name for name, unit in zip([axis.name, *names], units, strict=True))
    cells = [[number(float(value), 6) for value in axis.values[rows]], *(_cells(found, name, rows) for name in names)]
    if failed:
        head, cells = (*head, "outcome"), [*cells, _cells(found, "outcome", rows)]
    some = "" if rows.size == n else f" ({rows.size} of {n}; --csv FILE writes all)"
    return Grid(f"Values{some}", head, tuple(zip(*cells, strict=True)))


def _cells(found: Sweep, name: str, rows: np.ndarray[Any, Any]) -> list[str]:
    values = found[name][rows]
    if name in found.words:
        return [(*found.words[name], "")[value] or "-" for value in values.tolist()]
    if values.dtype == bool:
        return ["yes" if value else "no" for value in values.tolist()]
    if values.dtype.kind == "U":
        return [value or "-" for value in values.tolist()]
    if values.dtype.kind == "f":
        return ["-" if np.isnan(value) else number(value) for value in values.tolist()]
    return ["-" if value < 0 else str(value) for value in values.tolist()]


def _curve_rows(curves: Boundaries) -> tuple[tuple[str, str], ...]:
    rows = []
    for curve in curves.curves:
        there = curve.y[~np.isnan(curve.y)]
        if there.size:
            span = f"{curves.y_name} from {number(float(there.min()))} to {number(float(there.max()))}"
            rows.append((curve.kind, f"{span}, {_counted(int(there.size), 'point')}"))
    return tuple(rows) or (("none", "no boundary crosses the plane"),)


# ---- The reports of `percuss experiment` and `percuss basins`: where starts end


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
