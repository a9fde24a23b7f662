"""The jobs that follow starts of a case: its experiments and its basins."""

from __future__ import annotations

import math
import os
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from percuss.case.answers.numerals import json_number as number
from percuss.case.case import Case, checked_case
from percuss.errors import ParameterError
from percuss.explore.family import Axis
from percuss.model import HeldBody, Machine
from percuss.model.checks import instance, mapping
from percuss.units import si, unit_scale

if TYPE_CHECKING:
    from percuss.explore import Basins, Boundaries, Experiment, Sweep
    from percuss.explore.attractors.basin import BasinsJob
    from percuss.explore.attractors.experiments import ExperimentJob
    from percuss.explore.jobs.job import Columns
    from percuss.model import System
    from percuss.simulate import Stop


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
    hammer = _hammer(case)
    if distribution is None:
        distribution = "wall" if _held(hammer) is None else "field"
    return experiment_job(hammer, starts, distribution, seed, modes=_had(hammer, kept), stop=stop)


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

    Raises
    ------
    CaseError, ParameterError
        When the case cannot be used, there are no such starts, or a unit is none of the quantity.
    """
    from percuss.explore.attractors.basin import basins_job

    checked_case(case)
    instance("x", x, Axis), instance("y", y, Axis)
    simulation, system = case.simulation(), _hammer(case)
    kept = simulation.modes if modes is None else modes
    x, y = (Axis(a.name, a.values / _scale(system, a.name, a.unit)) if a.unit else a for a in (x, y))
    held = {} if at is None else mapping("at", at, "what all starts have in common, by name")
    fixed = {name: _plain(system, name, value) for name, value in held.items()}
    return basins_job(system, x, y, at=fixed, modes=_had(system, kept), stop=stop_when_found(simulation.stop, impacts))


def _hammer(case: Case) -> System | Machine:
    """What the starts of a case are starts of."""
    return case.machine() if case.is_machine else case.system()


def _held(hammer: System | Machine) -> HeldBody | None:
    return hammer.body if not isinstance(hammer, Machine) and isinstance(hammer.body, HeldBody) else None


def _had(hammer: System | Machine, modes: int) -> int:
    """As many of so many modes as a structure has."""
    body = _held(hammer)
    return modes if body is None or not isinstance(modes, int) or modes < 1 else body.chosen(modes)


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
    """Basins as a tree of dict, list, str, int, finite float and None: `image` holds numbers of attractors, row by row
    from the first value of y on, −1 where nothing is known."""
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
            {
                "label": share.label,
                "share": share.share,
                **share.attractor.figures,
            }
            for share in found.shares
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


def _scales(system: System | Machine) -> dict[str, float | None] | None:
    """What the dimensionless numbers are multiplied by for SI, and the frequency of a clock; None without scales."""
    if not system.is_si:
        return None
    return {
        "length_m": system.length_scale,
        "speed_m_s": system.speed_scale,
        "time_s": system.time_scale,
        "energy_J": system.energy_scale,
        **({} if isinstance(system, Machine) else {"frequency_Hz": system.frequency}),
    }


def _nested(values: np.ndarray[Any, Any]) -> Any:
    if values.ndim > 1:
        return [_nested(row) for row in values]
    if values.dtype.kind in "bUO":
        return values.tolist()
    return [_number(value) for value in values.tolist()]


def _number(value: float | int) -> float | int | str | None:
    """A number as JSON can hold it; −∞, the Lyapunov exponent of a motion that comes to rest, becomes a word."""
    return "-inf" if value == -np.inf else number(value)


# ---- An experiment that is watched: the shares so far while it goes on, the same numbers at its end

_LOOK = 0.25
"""Seconds of work between two looks."""

_MOST_SHARES = 16


@dataclass(frozen=True)
class Watched:
    """How far an experiment is.

    Attributes
    ----------
    done, size
        Starts that are followed, of how many.
    rate
        Starts per second.
    shares
        Of the labels found so far, the most frequent first: share and interval of 95 %.
    found
        The experiment as far as it has come: its first `done` starts.
    """

    done: int
    size: int
    rate: float
    shares: tuple[tuple[str, float, float, float], ...]
    found: Experiment

    @property
    def is_done(self) -> bool:
        """Whether all starts have been followed."""
        return self.done == self.size

    def to_json_dict(self) -> dict[str, Any]:
        """In plain values."""
        left = (self.size - self.done) / self.rate if self.rate > 0.0 else math.nan
        return {
            "done": self.done,
            "size": self.size,
            "fraction": self.done / self.size,
            "rate": number(self.rate),
            "seconds_left": number(left),
            "shares": [
                {"label": label, "share": number(share), "low": number(low), "high": number(high)}
                for label, share, low, high in self.shares
            ],
        }


def watched_experiment(job: ExperimentJob, stopped: Callable[[], bool], first: int | None = None) -> Iterator[Watched]:
    """Follow the starts of an experiment portion by portion; the last one yielded has all of them, or the `first`.

    The numbers depend neither on the portions nor on the number of threads. Once `stopped` says so nothing is yielded.
    """
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
