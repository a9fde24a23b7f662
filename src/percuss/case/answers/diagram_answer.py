"""The diagram of a case over one of its parameters."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from percuss.case.answers.exploration_jobs import stop_when_found
from percuss.case.answers.orbits_answer import parsed_label
from percuss.case.case import Case, checked_case
from percuss.case.parameters.case_family import CaseFamily
from percuss.errors import ParameterError
from percuss.explore.axis import Axis
from percuss.explore.diagrams.diagram import carried_diagram
from percuss.explore.diagrams.diagram_job import DEFAULT_RUNS, DEFAULT_VALUES, diagram_job
from percuss.model.checks import text

if TYPE_CHECKING:
    from percuss.explore import Diagram
    from percuss.explore.diagrams.diagram_job import DiagramJob

__all__ = ["DEFAULT_MODES", "diagram_answer", "diagram_job_of"]

DEFAULT_MODES = 8
"""Elastic modes of a diagram, where neither the question nor the case names a number."""


def diagram_job_of(
    case: Case,
    along: str,
    *,
    up_to: str | None = "3/3",
    searched: int = 5,
    switch: int = 2,
    tries: int = 100,
    starts: int = 8,
    runs: int = DEFAULT_RUNS,
    modes: int | None = None,
    impacts: int | None = None,
    seed: int = 0,
) -> DiagramJob:
    """What `diagram_answer` carries out; its parameters are described there.

    Raises
    ------
    CaseError, ParameterError
        When the case cannot be used, the piston switches its load, or there is no such parameter.
    """
    checked_case(case)
    if case.is_machine:
        raise ParameterError(
            "diagram", case.file, "a hammer whose load keeps time by itself",
            "'percuss sweep' maps what such a machine does over a parameter",
        )  # fmt: skip
    axis = _axis(along)
    family = CaseFamily(case, {axis.name: axis.unit} if axis.unit else {})
    return diagram_job(
        family, axis, up_to=None if up_to is None else parsed_label(up_to), searched=searched, switch=switch,
        tries=tries, starts=starts, runs=runs, modes=_modes(case) if modes is None else modes,
        stop=stop_when_found(case.simulation().stop, impacts), seed=seed,
    )  # fmt: skip


def diagram_answer(
    case: Case,
    along: str,
    *,
    up_to: str | None = "3/3",
    searched: int = 5,
    switch: int = 2,
    tries: int = 100,
    starts: int = 8,
    runs: int = DEFAULT_RUNS,
    modes: int | None = None,
    impacts: int | None = None,
    seed: int = 0,
    **running: Any,
) -> Diagram:
    """The motions of a case over one parameter; see `percuss.explore.diagram`.

    Parameters
    ----------
    case
        A hammer whose load keeps time.
    along
        A parameter and its range, ``load_factor=0.3:1.2``, or a key of the case in its unit, ``frequency=40 Hz:80 Hz``;
        with the number of values to simulate behind it, ``load_factor=0.3:1.2:200``, if not 120.
    up_to
        The greatest label whose orbits are searched for; None for no branches.
    searched, switch, tries, starts, runs, seed
        As for `percuss.explore.diagram`.
    modes
        N; None for those that the table [simulation] names, or 8.
    impacts
        Of a simulation at most, instead of those of the table.
    running
        ``workers``, ``archive``, ``resume``, ``pool``, ``chunk``, ``progress`` as `percuss.explore.carry_out` has them.

    Raises
    ------
    CaseError, ParameterError
        When the case cannot be used, the piston switches its load, or there is no such parameter.
    Interrupted
        After Ctrl-C; its `partial` is the diagram of what was done.

    Examples
    --------
    >>> from percuss.case import load_case
    >>> case = load_case("pneumatic-jackleg")
    >>> found = diagram_answer(case, "load_factor=0.35:0.45:4", up_to="1/1", searched=1, switch=0, runs=0, modes=0)
    >>> found.labels[:2], [branch.label for branch in found.branches]
    (('z=1/1', 'chatter/1'), ['z=1/1', 'z=2/1'])
    """
    job = diagram_job_of(
        case, along, up_to=up_to, searched=searched, switch=switch, tries=tries, starts=starts, runs=runs,
        modes=modes, impacts=impacts, seed=seed,
    )  # fmt: skip
    return carried_diagram(job, **running)


def _axis(along: str) -> Axis:
    told = text("along", along, "NAME=FROM:TO or NAME=FROM:TO:NUMBER")
    return Axis.parsed(f"{told}:{DEFAULT_VALUES}" if told.count(":") == 1 else told)


def _modes(case: Case) -> int:
    """Of the table [simulation], where it names them."""
    table = case.tables.simulation
    named = table is not None and "modes" in table.model_fields_set
    return case.simulation().modes if named else DEFAULT_MODES
