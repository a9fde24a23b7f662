"""The jobs that follow starts of a case: its experiments and its basins."""

from __future__ import annotations

import math
import os
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from percuss.case.answers.facts import (
    BAD,
    GOOD,
    PLAIN,
    Grid,
    Report,
    ReportSection,
    counted,
    json_number,
    number,
    percent,
    scales_of,
)
from percuss.case.answers.heading import clock_in_short, clock_note
from percuss.case.case import Case, checked_case
from percuss.case.parameters.case_family import CaseFamily
from percuss.errors import ParameterError
from percuss.explore.family import Axis
from percuss.explore.quantities import CELL_OUTCOMES, MACHINE_QUANTITIES, QUANTITIES, checked, known_quantities, needs
from percuss.model import Machine
from percuss.model.checks import count, instance, mapping, several
from percuss.units import si, unit_scale

if TYPE_CHECKING:
    from percuss.explore import Axis, Basins, Boundaries, Experiment, Share, Sweep
    from percuss.explore.attractors.basin import BasinsJob
    from percuss.explore.attractors.experiments import ExperimentJob
    from percuss.explore.cells import SweepJob
    from percuss.explore.jobs.job import Columns
    from percuss.explore.sweeps import Range
    from percuss.model import System
    from percuss.simulate import Stop


def sweep_job_of(
    case: Case,
    axes: Sequence[Axis],
    quantities: Sequence[str] | None = None,
    *,
    periods: int = 1,
    modes: int | None = None,
    impacts: int | None = None,
) -> SweepJob:
    """The map of a case over keys of its tables or dimensionless parameters, with the start that its tables describe.

    Parameters
    ----------
    axes
        Their units are those of the keys.
    quantities, periods
        See `percuss.explore.sweep`; a piston that switches its load has no load periods.
    modes
        Of every quantity. None: the steady motions are those of the continuous bar with multipliers of 32 modes, as
        `steady_answer` has them, and simulations take the modes of the table [simulation].
    impacts
        Instead of those of the table [simulation].
    """
    from percuss.explore.sweeps import sweep_job

    checked_case(case)
    axes = several("axes", axes, "a list of Axis")
    for axis in axes:
        instance("axes", axis, Axis)
    family = CaseFamily(case, {axis.name: axis.unit for axis in axes if axis.unit})
    asked: dict[str, Any] = {"quantities": quantities, "periods": periods, "modes": modes}
    known = known_quantities(family)
    alone = quantities is not None and needs(checked(quantities, known), known) == {"blow"}
    if not alone and not case.is_machine:  # else the case need not have a motion, or none is simulated
        simulation = case.simulation()
        asked |= {"simulated": simulation.modes, "stop": stop_when_found(simulation.stop, impacts)}
    return sweep_job(family, *axes, **asked)


def experiment_job_of(
    case: Case,
    starts: int | None = None,
    distribution: str | os.PathLike[str] | None = None,
    seed: int = 0,
    *,
    modes: int | None = None,
    impacts: int | None = None,
) -> ExperimentJob:
    """The experiment of a case: random starts, followed until their motions are found.

    Parameters
    ----------
    starts, distribution, seed
        See `percuss.explore.experiment`; None for ``wall``, and for ``field`` of a structure that is held.
    modes, impacts
        Instead of those of the table [simulation].

    Raises
    ------
    CaseError, ParameterError, ResonanceError
        When the case cannot be used, or the starts cannot be drawn.
    """
    from percuss.explore.attractors.experiments import experiment_job

    checked_case(case)
    simulation = case.simulation()
    kept = simulation.modes if modes is None else modes
    stop = stop_when_found(simulation.stop, impacts)
    hammer = case.hammer
    if distribution is None:
        distribution = "wall" if hammer.body.is_free else "field"
    kept = hammer.body.chosen(count("modes", kept, least=0))
    return experiment_job(hammer, starts, distribution, seed, modes=kept, stop=stop)


def basins_job_of(
    case: Case,
    x: Axis,
    y: Axis,
    *,
    at: Mapping[str, float | str] | None = None,
    modes: int | None = None,
    impacts: int | None = None,
) -> BasinsJob:
    """The basins of a case over a plane of starts; the axes of the result are dimensionless.

    Parameters
    ----------
    x, y, at
        See `percuss.explore.basins`. For a case in SI position, velocity and time may also have units, in `at` as text
        (``"-30 mm"``). Of a machine `at` may name the state of the valve, ``{"state": "power"}``.
    modes, impacts
        Instead of those of the table [simulation].
    """
    from percuss.explore.attractors.basin import basins_job

    checked_case(case)
    instance("x", x, Axis), instance("y", y, Axis)
    simulation, system = case.simulation(), case.hammer
    kept = simulation.modes if modes is None else modes
    x, y = (Axis(a.name, a.values / _scale(system, a.name, a.unit)) if a.unit else a for a in (x, y))
    held = {} if at is None else mapping("at", at, "what all starts have in common, by name")
    fixed = {name: _plain(system, name, value) for name, value in held.items()}
    kept = system.body.chosen(count("modes", kept, least=0))
    return basins_job(system, x, y, at=fixed, modes=kept, stop=stop_when_found(simulation.stop, impacts))


_START_SCALES = {
    "position": ("length", "length_scale"),
    "velocity": ("velocity", "speed_scale"),
    "time": ("time", "time_scale"),
}


def _plain(system: System | Machine, name: str, value: float | str) -> float | str:
    """A number of a start without its unit, dimensionless; the name of a state as it is."""
    if not isinstance(value, str) or (name == "state" and isinstance(system, Machine)):
        return value
    if name not in _START_SCALES or not system.is_si:
        _scale(system, name, value)
    dimension, scale = _START_SCALES[name]
    return si(value, dimension, name) / float(getattr(system, scale))


def _scale(system: System | Machine, name: str, unit: str) -> float:
    """What a number of a start in some unit is divided by to be dimensionless."""
    plain = "a plain number: it is dimensionless"
    if name not in _START_SCALES:
        raise ParameterError(name, unit, plain, f"only {', '.join(_START_SCALES)} have units")
    if not system.is_si:
        raise ParameterError(name, unit, plain, "units need a case in SI")
    dimension, scale = _START_SCALES[name]
    return float(getattr(system, scale)) / unit_scale(unit, (dimension,), name)[0]


def stop_when_found(stop: Stop, impacts: int | None) -> Stop:
    """The stop rule of [simulation], which for maps and experiments always ends when the motion is found."""
    return replace(stop, periodic=True, impacts=stop.impacts if impacts is None else impacts)


# ---- Maps and experiments as JSON objects


def sweep_dict(case: Case, found: Sweep, curves: Boundaries | None = None) -> dict[str, Any]:
    """A map, and the boundaries in its plane, in plain values: nested lists, the last axis innermost."""
    quantities: dict[str, Any] = {}
    for name in ("outcome", *found.quantities):
        values = found[name]
        if name in found.words:
            words = np.array([*found.words[name], ""])
            values = words[values]
        elif name != "outcome":
            values = _known(found, values)
        column = found.columns.get(name)
        quantities[name] = {"unit": column.unit if column else "", "values": _nested(values)}
    answer: dict[str, Any] = {
        "case": case.file,
        "title": case.title,
        "notes": list(case.notes),
        "axes": [axis.to_json_dict() for axis in found.axes],
        "periods": found.ask.get("periods"),
        "modes": found.ask["modes"],
        "quantities": quantities,
    }
    if curves is not None:
        answer["curves"] = [
            {"kind": c.kind, "branch": c.branch, "x": _nested(c.x), "y": _nested(c.y), "phase": _nested(c.phase)}
            for c in curves.curves
        ]
    return answer


def experiment_dict(case: Case, found: Experiment) -> dict[str, Any]:
    """An experiment as a tree of dict, list, str, int, finite float and None."""
    return {
        "case": case.file,
        "title": case.title,
        "notes": list(case.notes),
        **found.to_json_dict(),
        "si": _scales(found.system),
    }


def basins_dict(case: Case, found: Basins) -> dict[str, Any]:
    """Basins in JSON's types: `image` has numbers of attractors, row by row from the first y on, −1: not known."""
    (x, over), (y, up) = found.x, found.y
    return {
        "case": case.file,
        "title": case.title,
        "axes": [{"name": x, "values": list(over)}, {"name": y, "values": list(up)}],
        "at": dict(found.at),
        "modes": found.modes,
        "si": _scales(found.system),
        "image": found.image.tolist(),
        "attractors": [
            {"label": share.label, "share": share.share, **share.attractor.figures} for share in found.shares
        ],
    }


def _known(found: Sweep, values: np.ndarray[Any, Any]) -> np.ndarray[Any, Any]:
    """The values, None in cells that have none: those without a system, or not computed."""
    if values.dtype.kind == "f" or values.dtype.kind == "U":
        return values
    shown = values.astype(object)
    outcome = found["outcome"]
    nothing = (outcome < 0) | (outcome > 1) & (outcome < len(found.words["outcome"]) - 1)
    shown[nothing] = None
    return shown


def _scales(system: System | Machine) -> dict[str, Any] | None:
    """What the dimensionless numbers are multiplied by for SI, and the frequency of a clock; None without scales."""
    scales = scales_of(system, "length_m speed_m_s time_s energy_J")
    return scales if scales is None or isinstance(system, Machine) else scales | {"frequency_Hz": system.frequency}


def _nested(values: np.ndarray[Any, Any]) -> Any:
    if values.ndim > 1:
        return [_nested(row) for row in values]
    if values.dtype.kind in "bUO":
        return values.tolist()
    return [_number(value) for value in values.tolist()]


def _number(value: float | int) -> float | int | str | None:
    """A number as JSON can hold it; −∞, the Lyapunov exponent of a motion that comes to rest, becomes a word."""
    return "-inf" if value == -np.inf else json_number(value)


# ---- An experiment that is watched: the shares so far while it goes on, the same numbers at its end

_LOOK = 0.25  # seconds of work between two looks

_MOST_SHARES = 16


@dataclass(frozen=True)
class Watched:
    """How far an experiment is: starts done, of how many, per second; shares with intervals of 95 %; what was found."""

    done: int
    size: int
    rate: float
    shares: tuple[tuple[str, float, float, float], ...]
    found: Experiment

    def to_json_dict(self) -> dict[str, Any]:
        """In plain values."""
        left = (self.size - self.done) / self.rate if self.rate > 0.0 else math.nan
        return {
            "done": self.done,
            "size": self.size,
            "fraction": self.done / self.size,
            "rate": json_number(self.rate),
            "seconds_left": json_number(left),
            "shares": [
                {"label": label, "share": json_number(share), "low": json_number(low), "high": json_number(high)}
                for label, share, low, high in self.shares
            ],
        }


def experiment_progress(job: ExperimentJob, stopped: Callable[[], bool], first: int | None = None) -> Iterator[Watched]:
    """Starts by portions, on which no number depends; the last has all, or the `first`; none once `stopped`."""
    from percuss.explore.attractors.experiments import Experiment

    job = replace(job, threads=os.cpu_count() or 1)
    parts: list[Columns] = []
    size = job.size if first is None else min(first, job.size)
    done, portion, spent = 0, min(16, size), 0.0
    while done < size:
        begun = time.perf_counter()
        last = min(done + portion, size)
        columns = job.compute(done, last, stopped)
        if stopped():
            return
        took = time.perf_counter() - begun
        spent += took
        parts.append(columns)
        portion = max(1, min(int((last - done) * _LOOK / max(took, 1e-6)), 8 * portion))
        done = last
        so_far = {name: np.concatenate([part[name] for part in parts]) for name in columns}
        parts = [so_far]
        found = Experiment.of(job, so_far)
        labels = tuple((label, *interval) for label, interval in list(found.labels.items())[:_MOST_SHARES])
        yield Watched(done, size, done / max(spent, 1e-9), labels, found)


# ---- The report of `percuss sweep`


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
    sections: list[ReportSection | Grid] = [ReportSection("Map", (*_map_rows(found, cells), *of_case))]
    sections.append(ReportSection("Quantities", tuple((name, _quantity(found, name)) for name in found.quantities)))
    if ranges:
        (axis,) = found.axes
        told = tuple((name, _ranges(axis, parts)) for name, parts in ranges.items())
        sections.append(ReportSection(f"Along {axis.name}", told))
    if curves is not None:
        sections.append(ReportSection("Boundaries", _curve_rows(curves)))
    if len(found.axes) == 1:
        sections.append(_table(found))
    return Report(title, f"{counted(cells, 'cell')} over {over}.", PLAIN, tuple(sections))


def _map_rows(found: Sweep, cells: int) -> tuple[tuple[str, str], ...]:
    rows = [(axis.name, _axis(axis)) for axis in found.axes]
    of_machines = bool(found.ask.get("machines"))
    asked = needs(found.ask["quantities"], MACHINE_QUANTITIES if of_machines else QUANTITIES)
    of_orbits = asked & {"orbits", "exact"} and all(axis.name != "m" for axis in found.axes)
    per_impact = f"{counted(found.ask['periods'], 'load period')} per impact" if of_orbits else ""
    if asked & {"exact", "simulation", "lyapunov"}:
        told = str(found.ask["modes"])
        if "simulated" in found.ask:
            told += f", simulated with {found.ask['simulated']}"
        rows.append(("modes", f"{told}{'; ' if per_impact else ''}{per_impact}"))
    elif "machine" in asked:
        rows.append(("bar", bar_sentence(found.ask["modes"])))
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


def bar_sentence(modes: int) -> str:
    """What is kept of the bar."""
    return "rigid" if modes == 0 else counted(modes, "elastic mode")


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
    resting = f"comes to rest (−∞) in {counted(at_rest, 'cell')}"
    if not there.size:
        return resting if at_rest else "nowhere"
    unit = found.columns[name].unit
    span = f"{number(float(there.min()))} to {number(float(there.max()))}{' ' + unit if unit else ''}"
    if there.size < values.size and values.ndim == len(found.axes):
        span += f", in {counted(there.size, 'cell')}"
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
    return answered, f"the {counted(n, 'cell')} that {one} {'a system' if without else 'an answer'}"


def _words(values: np.ndarray[Any, Any], answered: np.ndarray[Any, Any], whose: str) -> str:
    kinds, counts = np.unique(values[answered & (values != "")], return_counts=True)
    order = np.argsort(-counts, kind="stable")
    told = [f"{kinds[i]} {percent(counts[i] / answered.sum())}" for i in order[:_MOST_LABELS]]
    if len(kinds) > _MOST_LABELS:
        told.append(counted(len(kinds) - _MOST_LABELS, "other"))
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
            rows.append((curve.kind, f"{span}, {counted(int(there.size), 'point')}"))
    return tuple(rows) or (("none", "no boundary crosses the plane"),)


# ---- The reports of `percuss experiment` and `percuss basins`: where starts end


def experiment_report(title: str, found: Experiment) -> Report:
    shares, system = found.shares, found.system
    rows = [
        ("starts", f"{len(found)}, {found.distribution}, seed {found.seed}"),
        ("bar", bar_sentence(found.modes)),
        ("ends", f"after at most {counted(found.stop.most_impacts, 'impact')}, or when the motion is found"),
    ]
    if isinstance(system, Machine):
        tone, summary = _of_machine(shares, len(found))
    else:
        tone, summary, note = _under_clock(shares, system)
        rows += [("note", note)] if note else []
    return Report(title, summary, tone, (ReportSection("Experiment", tuple(rows)), _attractors(shares, system)))


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
    (x, over), (y, up) = found.x, found.y
    rows = [
        (name, f"{number(values[0])} to {number(values[-1])}, {counted(len(values), 'value')}")
        for name, values in (found.x, found.y)
    ]
    words = found.hammer.words
    rows += [(name, words[name][int(value)] if name in words else number(value)) for name, value in found.at]
    rows.append(("bar", bar_sentence(found.modes)))
    shares = found.shares
    summary = f"{counted(len(over) * len(up), 'start')} over {x} and {y}: {counted(len(shares), 'attractor')}."
    return Report(
        title, summary, PLAIN, (ReportSection("Basins", tuple(rows)), _attractors(shares, found.system, sample=False))
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
