"""The jobs that a case asks for: its maps, its experiments and its basins."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from percuss.case.case import Case
from percuss.case.family import CaseFamily
from percuss.explore.axis import Axis
from percuss.explore.quantities import DEFAULT_QUANTITIES

if TYPE_CHECKING:
    from percuss.explore.ends.basin import BasinsJob
    from percuss.explore.ends.experiments import ExperimentJob
    from percuss.explore.sweep_job import SweepJob
    from percuss.simulate import Stop

__all__ = ["basins_job_of", "experiment_job_of", "sweep_job_of"]


def sweep_job_of(
    case: Case,
    axes: Sequence[Axis],
    quantities: Sequence[str] = DEFAULT_QUANTITIES,
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
        See `percuss.explore.sweep`.
    modes, impacts
        Instead of those of the table [simulation].

    Raises
    ------
    CaseError, ParameterError
        When the case cannot be used, or the question has no answer.
    """
    from percuss.explore.sweep_job import sweep_job

    family = CaseFamily(case, {axis.name: axis.unit for axis in axes if axis.unit})
    simulation = case.simulation()
    return sweep_job(
        family,
        *axes,
        quantities=quantities,
        periods=periods,
        modes=simulation.modes if modes is None else modes,
        stop=_stop(simulation.stop, impacts),
    )


def experiment_job_of(
    case: Case,
    starts: int | None = None,
    distribution: str | os.PathLike[str] = "wall",
    seed: int = 0,
    *,
    modes: int | None = None,
    impacts: int | None = None,
) -> ExperimentJob:
    """The experiment of a case: random starts, followed until their motions are found.

    Parameters
    ----------
    starts, distribution, seed
        See `percuss.explore.experiment`.
    modes, impacts
        Instead of those of the table [simulation].

    Raises
    ------
    CaseError, ParameterError, ResonanceError
        When the case cannot be used, or the starts cannot be drawn.
    """
    from percuss.explore.ends.experiments import experiment_job

    simulation = case.simulation()
    kept = simulation.modes if modes is None else modes
    stop = _stop(simulation.stop, impacts)
    return experiment_job(case.system(), starts, distribution, seed, modes=kept, stop=stop)


def basins_job_of(
    case: Case,
    x: Axis,
    y: Axis,
    *,
    at: Mapping[str, float] | None = None,
    modes: int | None = None,
    impacts: int | None = None,
) -> BasinsJob:
    """The basins of a case over a plane of starts, in dimensionless numbers.

    Parameters
    ----------
    x, y, at
        See `percuss.explore.basins`.
    modes, impacts
        Instead of those of the table [simulation].

    Raises
    ------
    CaseError, ParameterError
        When the case cannot be used, or there are no such starts.
    """
    from percuss.explore.ends.basin import basins_job

    simulation = case.simulation()
    kept = simulation.modes if modes is None else modes
    return basins_job(case.system(), x, y, at=at, modes=kept, stop=_stop(simulation.stop, impacts))


def _stop(stop: Stop, impacts: int | None) -> Stop:
    """The stop rule of [simulation], which for maps and experiments always ends when the motion is found."""
    return replace(stop, periodic=True, impacts=stop.impacts if impacts is None else impacts)
