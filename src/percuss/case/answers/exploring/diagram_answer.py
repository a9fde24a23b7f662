"""The diagram of a case over one of its parameters."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from percuss.case.answers.exploring.exploration import stop_when_found
from percuss.case.answers.exploring.orbits_answer import branch_section, parsed_label
from percuss.case.answers.facts import PLAIN, Grid, Report, ReportSection, counted, json_number, picked, plain_value
from percuss.case.case import Case, checked_case
from percuss.case.parameters.case_family import CaseFamily
from percuss.explore.diagrams.diagram import carried_diagram, diagram_axis
from percuss.explore.diagrams.diagram_job import DEFAULT_RUNS, diagram_job

if TYPE_CHECKING:
    from percuss.explore import Branch, BranchPoint, Diagram, SettledMotion
    from percuss.explore.diagrams.diagram_job import DiagramJob


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
    """What `diagram_answer` carries out; its parameters are described there."""
    checked_case(case)
    axis = diagram_axis(along)
    family = CaseFamily(case, {axis.name: axis.unit} if axis.unit else {})
    return diagram_job(
        family, axis, up_to=None if up_to is None else parsed_label(up_to), searched=searched, switch=switch,
        tries=tries, starts=starts, runs=runs, modes=case.simulation().modes if modes is None else modes,
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
        When the case cannot be used, or there is no such parameter.
    Interrupted
        After Ctrl-C; its `partial` is the diagram of what was done.

    Examples
    --------
    >>> from percuss.case import load_case
    >>> case = load_case("pneumatic-jackleg")
    >>> found = diagram_answer(case, "load_factor=0.35:0.45:4", up_to="1/1", searched=1, switch=0, runs=0, modes=0)
    >>> found.labels[:2], [branch.label for branch in found.branches]
    (('z=1/1', 'chatter/1'), ['z=1/1', 'z=2/1', 'z=2/2', 'z=4/2'])
    """
    job = diagram_job_of(
        case, along, up_to=up_to, searched=searched, switch=switch, tries=tries, starts=starts, runs=runs,
        modes=modes, impacts=impacts, seed=seed,
    )  # fmt: skip
    return carried_diagram(job, **running)


# ---- Diagrams as JSON, and as a table of text


def diagram_dict(case: Case, found: Diagram) -> dict[str, Any]:
    """A diagram as a tree of dict, list, str, bool, int, finite float and None."""
    return {
        "case": case.file,
        **picked(case, "title notes"),
        "parameter": found.axis.name,
        **picked(found.axis, "unit values"),
        **picked(found, "modes done left_out"),
        "settled": [_settled(one) for one in found.settled],
        "branches": [_branch(line) for line in found.branches],
        "rest_branches": [_rest_branch(line) for line in found.rest_branches],
        "impossible": [_branch(line) for line in found.impossible],
    }


def _settled(one: SettledMotion) -> dict[str, Any]:
    speed, energy = one.scales or (math.nan, math.nan)
    return {
        **picked(one, "value label members phases speeds energy"),
        "speeds_m_s": None if one.scales is None else (one.speeds * speed).tolist(),
        "energy_J": json_number(one.energy * energy),
    }


def _branch(line: Branch) -> dict[str, Any]:
    scales = line.scales
    return {
        "label": line.label,
        "points": [_point(point) for point in line.points],
        "branch": {
            "value": line.values.tolist(),
            **picked(line, "phases times speeds stable"),
            **(picked(line, "cycle_times") if line.is_machine else {}),
            "energy": plain_value(line.energies),
            "speeds_m_s": None if scales is None else plain_value(line.speeds * scales[:, :1]),
            "energy_J": None if scales is None else plain_value(line.energies * scales[:, 1]),
        },
    }


def _rest_branch(line: Branch) -> dict[str, Any]:
    """Its impacts in the form of a cycle with rest that is followed: those of all its rests in one list."""
    known, scales = np.isfinite(line.times), line.scales

    def listed(values: np.ndarray) -> list[list[float]]:
        return [row[there].tolist() for row, there in zip(values, known, strict=True)]

    return {
        "label": line.label,
        "points": [_point(point) for point in line.points],
        "branch": {
            "value": line.values.tolist(),
            "phases": listed(line.phases),
            "times": listed(line.times),
            "speeds": listed(line.speeds),
            "energy": plain_value(line.energies),
            "stable": line.stable.tolist(),
            "impacts": known.sum(axis=-1).tolist(),
            **picked(line, "release_phases rest_phases"),
            "speeds_m_s": None if scales is None else listed(line.speeds * scales[:, :1, None]),
            "energy_J": None if scales is None else plain_value(line.energies * scales[:, 1]),
        },
    }


def _point(point: BranchPoint) -> dict[str, Any]:
    return {
        "type": point.kind.value,
        "value": point.value,
        **picked(point.plain, "label phases speeds energy"),
        **picked(point, "beyond impact touch_phase"),
    }


# ---- A diagram that is watched: what is settled on so far while it goes on, the same numbers at its end


def diagram_progress(job: DiagramJob, stopped: Callable[[], bool]) -> Iterator[Diagram]:
    """Carry out a diagram item by item, until `stopped` says so; the last one yielded is whole."""
    from percuss.explore import Diagram

    columns = {
        name: np.full((job.size, *column.shape), column.empty, dtype=column.dtype)
        for name, column in job.columns.items()
    }
    columns["branch_bytes"][...] = -1  # not done
    for i in range(job.size):
        row = job.compute(i, i + 1, stopped)
        if stopped():
            return
        for name, values in row.items():
            columns[name][i] = values[0]
        yield Diagram.of(job, columns)


# ---- The report of `percuss diagram`: what simulations settle on, the branches, and what happens on them

_MOST_LABELS = 12


def diagram_report(title: str, found: Diagram, mode: str = "elastic mode") -> Report:
    """Labels of what was simulated, where they were met, and each branch; `mode`: what a mode is called."""
    low, high = float(found.axis.values.min()), float(found.axis.values.max())
    name, unit = found.axis.name, f" {found.axis.unit}" if found.axis.unit else ""
    summary = f"{name} from {low:.9g} to {high:.9g}{unit}, {counted(found.modes, mode)}; branches: "
    summary += f"{len(found.branches)}."
    if found.rest_branches:
        summary += f" Branches of cycles with rest: {len(found.rest_branches)}."
    if found.done < 1.0:
        summary += f" {int(1000.0 * found.done) / 10.0:g} % of the work was done: the diagram is not whole."
    if found.left_out:
        summary += f" Branches left out, as there are too many: {found.left_out}; ask for a smaller --switch."
    sections: list[ReportSection | Grid] = []
    if found.settled:
        sections.append(_simulated(found))
    every: tuple[Branch, ...] = (*found.branches, *found.rest_branches)
    sections += [branch_section(f"branch {number}: {line.label}", line) for number, line in enumerate(every, 1)]
    return Report(title, summary, PLAIN, tuple(sections))


def _simulated(found: Diagram) -> Grid:
    rows = []
    for label in found.labels[:_MOST_LABELS]:
        values = sorted({one.value for one in found.settled if one.label == label})
        rows.append((label, str(len(values)), f"{values[0]:.9g}", f"{values[-1]:.9g}"))
    more = len(found.labels) - _MOST_LABELS
    told = "simulated motions" if more <= 0 else f"simulated motions ({more} labels more: --json has all)"
    return Grid(told, ("label", f"values of {len(found.axis)}", "from", "to"), tuple(rows))
