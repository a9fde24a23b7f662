"""A cycle with rest of a case followed through a parameter: the branch, and it as JSON and as a table."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

from percuss.case.answers.orbits_answer import followed, value_of
from percuss.case.answers.orbits_json import rest_curve_dict
from percuss.case.answers.rest_cycles_answer import is_rest_label, rest_cycle_dict, rest_cycles_answer
from percuss.case.case import Case, checked_case
from percuss.errors import ParameterError
from percuss.explore import RestEvent, follow_rest_cycle
from percuss.model.checks import text

if TYPE_CHECKING:
    from percuss.explore import RestBranch, RestBranchPoint, RestPointCurve
    from percuss.steady import RestCycle

__all__ = ["rest_branch_answer", "rest_branch_dict", "rest_branch_table"]

_CHOICE = "chatter/N:NUMBER or rest/N:NUMBER"


def rest_branch_answer(
    case: Case, orbit: str, along: str, *, modes: int | None = None, halt: Callable[[], bool] | None = None
) -> RestBranch:
    """A cycle with rest of a case followed through a parameter; see `percuss.explore.follow_rest_cycle`.

    Parameters
    ----------
    case
        A hammer whose load keeps time.
    orbit
        ``chatter/1:2`` or ``rest/1:2`` for number 2 of the cycles of a label; ``chatter/1`` for the first.
    along
        A parameter and its range, ``load_factor=0.3:1.2`` or ``frequency=40 Hz:80 Hz``; a key of the case in its unit.
        Without a range, ``load_factor``, the branch is followed to its ends.
    modes
        N, in the forced motion, too; None for the case's, or 32.
    halt
        As for `percuss.explore.follow_rest_cycle`.

    Raises
    ------
    CaseError, ResonanceError, ParameterError
        When there is no such cycle or parameter.

    Examples
    --------
    >>> from percuss.case import load_case
    >>> branch = rest_branch_answer(load_case("laboratory-striker"), "chatter/1", "load_factor=0.6:0.61", modes=0)
    >>> branch.label, [point.kind.value for point in branch.points]
    ('chatter/1', ['limit', 'limit'])
    """
    checked_case(case)
    name, family, ends = followed(case, along)
    value = value_of(case, family, name, ends)
    start = _chosen(case, orbit, modes)
    return follow_rest_cycle(start, name, ends, family=family, value=value, halt=halt)


def _chosen(case: Case, orbit: str, modes: int | None) -> RestCycle:
    """The cycle that a text names."""
    label, _, which = text("orbit", orbit, _CHOICE).partition(":")
    number = re.fullmatch(r"\s*(\d{1,4})\s*", which or "1", re.ASCII)
    if not is_rest_label(label) or number is None or int(number[1]) < 1:
        raise ParameterError("orbit", orbit, _CHOICE)
    found = rest_cycles_answer(case, modes=modes)
    cycles = found.labelled(re.sub(r"\s", "", label))
    if int(number[1]) > len(cycles):
        others = ", ".join(cycle.label for cycle in found.cycles) or "none"
        told = f"one of the {len(cycles)} cycles {label.strip()} of this case"
        raise ParameterError("orbit", orbit, told, f"all its cycles with rest: {others}")
    return cycles[int(number[1]) - 1]


def rest_branch_dict(branch: RestBranch, curves: Sequence[RestPointCurve] = ()) -> dict[str, Any]:
    """A branch of cycles with rest and curves of its ends, in the form of the answers of an orbit that is followed."""
    return {
        "parameter": branch.parameter,
        "modes": branch.modes,
        "label": branch.label,
        "points": [_point(point) for point in branch.points],
        "branch": {
            "value": branch.values.tolist(),
            "phases": [cycle.phases.tolist() for cycle in branch.cycles],
            "times": [list(cycle.times) for cycle in branch.cycles],
            "speeds": [cycle.speeds.tolist() for cycle in branch.cycles],
            "stable": [cycle.stable for cycle in branch.cycles],
            "impacts": [[len(chain.impacts) for chain in cycle.chains] for cycle in branch.cycles],
            "release_phases": [cycle.release_phases.tolist() for cycle in branch.cycles],
            "rest_phases": [cycle.rest_phases.tolist() for cycle in branch.cycles],
        },
        "switched": [],
        "cascade": [],
        "curves": [rest_curve_dict(curve) for curve in curves],
    }


def _point(point: RestBranchPoint) -> dict[str, Any]:
    dies = point.kind is RestEvent.DEATH
    return {
        "type": point.kind.value,
        "value": point.value,
        "orbit": rest_cycle_dict(point.cycle),
        "beyond": point.beyond,
        "impact": point.impact if dies else None,
        "touch_phase": None if dies else point.touch_phase,
    }


def rest_branch_table(branch: RestBranch) -> str:
    """The branch as CSV: a line for each impact of each cycle, of a chatter those that were followed one by one.

    Examples
    --------
    >>> from percuss.case import load_case
    >>> branch = rest_branch_answer(load_case("laboratory-striker"), "chatter/1", "load_factor=0.6:0.61", modes=0)
    >>> rest_branch_table(branch).splitlines()[0]
    'branch,label,point,load_factor,stable,impact,phase,speed,release_phase,rest_phase'
    """
    lines = [f"branch,label,point,{branch.parameter},stable,impact,phase,speed,release_phase,rest_phase"]
    for point, (value, cycle) in enumerate(zip(branch.values.tolist(), branch.cycles, strict=True), 1):
        head = f"1,{cycle.label},{point},{value!r},{int(cycle.stable)}"
        impact = 0
        for release, rest, chain in zip(cycle.release_phases, cycle.rest_phases, cycle.chains, strict=True):
            for _ in chain.impacts:
                told = f"{float(cycle.phases[impact])!r},{float(cycle.speeds[impact])!r}"
                impact += 1
                lines.append(f"{head},{impact},{told},{float(release)!r},{float(rest)!r}")
    return "\n".join([*lines, ""])
