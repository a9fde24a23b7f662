"""The jobs that follow starts of a case: its experiments and its basins."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

from percuss.case.case import Case, checked_case
from percuss.errors import ParameterError
from percuss.explore.axis import Axis
from percuss.model import HeldBody, Machine
from percuss.model.checks import instance, mapping
from percuss.units import si, unit_scale

if TYPE_CHECKING:
    from percuss.explore.attractors.basin import BasinsJob
    from percuss.explore.attractors.experiments import ExperimentJob
    from percuss.model import System
    from percuss.simulate import Stop

__all__ = ["basins_job_of", "experiment_job_of", "stop_when_found"]


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
