"""The question of a sweep: its job, and which questions have no answer."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np

from percuss.errors import ParameterError, PercussError
from percuss.explore.axis import Axis
from percuss.explore.blow_cells import StrikingFamily
from percuss.explore.family import Family, drives_itself, family_of
from percuss.explore.machine_quantities import DEFAULT_MACHINE_QUANTITIES, known_quantities
from percuss.explore.own_quantities import SystemFunction, checked_functions
from percuss.explore.parameters import PERIODS
from percuss.explore.quantities import DEFAULT_QUANTITIES, OF_FREE_BARS, checked
from percuss.explore.sweep_job import SweepJob
from percuss.model import Body, HeldBody, Machine, ModalBody, System
from percuss.model.checks import Array, count, instance
from percuss.stability.verdict import DEFAULT_MODES
from percuss.steady.states import MAX_MODES, MAX_PERIODS

if TYPE_CHECKING:
    from percuss.simulate import Start, Stop

__all__ = ["sweep_job"]

_MOST_IMPACTS = 10**7


def sweep_job(
    what: System | Machine | Family,
    *axes: Axis | str,
    quantities: Sequence[str] | None = None,
    periods: int = 1,
    modes: int | None = None,
    simulated: int = DEFAULT_MODES,
    start: Start | None = None,
    stop: Stop | None = None,
    impacts: int = 2000,
    discard: int = 500,
    functions: Mapping[str, SystemFunction] | None = None,
) -> SweepJob:
    """The job of a sweep, checked; see `sweep`.

    Parameters
    ----------
    simulated
        Elastic modes of the simulations, when `modes` does not say it.
    """
    from percuss.simulate import Start, Stop

    family = family_of(what)
    own, by_default = checked_functions({} if functions is None else functions), quantities is None
    if quantities is None:
        quantities = DEFAULT_MACHINE_QUANTITIES if drives_itself(family) else DEFAULT_QUANTITIES
    names = checked(quantities, known_quantities(family)) if quantities or not own else ()
    spans = tuple(axis if isinstance(axis, Axis) else Axis.parsed(axis) for axis in axes)
    _check_axes(family, spans)
    _check_blows(family, names, spans)
    number = None if modes is None else count("modes", modes, least=0, most=MAX_MODES)
    job = SweepJob(
        family=family,
        axes=spans,
        quantities=names,
        periods=count("periods", periods, most=MAX_PERIODS),
        modes=number,
        simulated=count("modes", simulated, least=0, most=MAX_MODES) if number is None else number,
        start=None if start is None else instance("start", start, Start),
        stop=Stop() if stop is None else instance("stop", stop, Stop),
        impacts=count("impacts", impacts, least=10, most=_MOST_IMPACTS),
        discard=count("discard", discard, least=0, most=_MOST_IMPACTS),
        functions=own,
    )
    made = _check_some(job)
    return job if made is None or made.body.is_free else _of_held(job, made.body, by_default)


def _check_blows(family: Family, names: Sequence[str], axes: Sequence[Axis]) -> None:
    """Refuse what no blow depends on, and systems that do not know what they strike."""
    name = next((name for name in names if known_quantities(family)[name].group == "blow"), None)
    if name is None:
        return
    if not isinstance(family, StrikingFamily):
        remedy = "only a case says what is struck: percuss.case.CaseFamily, or percuss sweep"
        raise ParameterError("quantities", name, "quantities of the motion", remedy)
    if any(axis.name == PERIODS for axis in axes):
        raise ParameterError(PERIODS, "on an axis", "quantities of the motion only", "a blow has no load periods")


def _of_held(job: SweepJob, body: Body, by_default: bool) -> SweepJob:
    """The job for a structure that is held: without what only free bars have, which is refused if it was asked for."""
    unfit = [name for name in job.quantities if name in OF_FREE_BARS]
    if unfit and not by_default:
        raise ParameterError("quantities", unfit[0], "quantities of a structure that is held", OF_FREE_BARS[unfit[0]])
    if "stress" in job.quantities and isinstance(body, ModalBody):
        raise ParameterError("quantities", "stress", "what a table of modes knows", "ask for blow_energy")
    names = tuple(name for name in job.quantities if name not in unfit)
    if not isinstance(body, HeldBody):
        return replace(job, quantities=names)
    kept = None if job.modes is None else body.chosen(job.modes)
    return replace(job, quantities=names, modes=kept, simulated=body.chosen(job.simulated))


def _check_some(job: SweepJob) -> System | Machine | None:
    """What is made of a cell; the refusal of the first, when none of several over the map has an answer."""
    family = job.family
    made: System | Machine | None = None
    if job.asks_systems:
        made = _check_makes(job, family.machine if drives_itself(family) else family.system)
        if "flow" in job.quantities and isinstance(made, Machine) and made.is_si and made.pressure is None:
            remedy = "give pressure, that of the supply, in [load]"
            raise ParameterError("quantities", "flow", "what needs no pressure: this machine has none", remedy)
    if isinstance(family, StrikingFamily) and "blow" in job.groups:
        _check_makes(job, family.blow)
    return made


def _check_makes(job: SweepJob, made: Callable[[Mapping[str, float]], object]) -> Any:
    refused: list[Exception] = []
    some = np.unique([[0, n // 3, n // 2, 2 * n // 3, n - 1] for n in job.shape], axis=1)
    for place in product(*some.tolist()):
        cell = job.cell(int(np.ravel_multi_index(place, job.shape)))
        try:
            return made(job.system_values(cell))
        except (PercussError, ArithmeticError) as error:
            refused.append(error)
    raise refused[0]


def _check_axes(family: Family, axes: tuple[Axis, ...]) -> None:
    if not axes:
        raise ParameterError("axes", None, "one or more axes, such as restitution=0:0.9:200")
    names = [axis.name for axis in axes]
    twice = [name for name in names if names.count(name) > 1]
    if twice:
        raise ParameterError("axes", twice[0], "each parameter on one axis only")
    for axis in axes:
        if axis.name == PERIODS and drives_itself(family):
            raise ParameterError(PERIODS, "on an axis", "a load that keeps time", "a piston that switches it has none")
        if axis.name == PERIODS and (axis.unit or np.any(axis.values % 1.0) or not _whole(axis.values)):
            raise ParameterError(PERIODS, axis.values, f"whole numbers from 1 to {MAX_PERIODS}")
    family.check({axis.name: axis.unit for axis in axes if axis.name != PERIODS})


def _whole(values: Array) -> bool:
    return bool(values.min() >= 1 and values.max() <= MAX_PERIODS)
