"""The map that a case asks for, over keys of its tables."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from percuss.case.answers.exploration import stop_when_found
from percuss.case.case import Case, checked_case
from percuss.case.parameters.case_family import CaseFamily
from percuss.explore.family import Axis
from percuss.explore.quantities import checked, known_quantities, needs
from percuss.model.checks import instance, several

if TYPE_CHECKING:
    from percuss.explore.cells import SweepJob


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

    Raises
    ------
    CaseError, ParameterError
        When the case cannot be used, or the question has no answer.
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
