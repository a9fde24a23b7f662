"""Points of a branch of a case, followed through two parameters: which ones a text names, and their curves."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, overload

from percuss.case.answers.orbits_answer import value_of
from percuss.case.case import Case, checked_case
from percuss.case.parameters.case_family import CaseFamily
from percuss.errors import ParameterError
from percuss.explore import Axis, BranchEvent, RestBranch, RestEvent, follow_point
from percuss.explore.point_curves.following_points import FOLLOWED
from percuss.explore.point_curves.rest_start import REST_FOLLOWED
from percuss.model.checks import having, text

if TYPE_CHECKING:
    from percuss.explore import Branch, BranchPoint, PointCurve, RestBranchPoint, RestPointCurve

__all__ = ["followed_points", "point_curves_answer"]

_SHORT = {"touch": BranchEvent.TOUCH, "death": BranchEvent.DEATH, "pair": BranchEvent.NEIMARK_SACKER}
_NAMES: dict[str, BranchEvent | RestEvent] = {**{kind.value: kind for kind in FOLLOWED}, **_SHORT}
_REST_SHORT = {"touch": RestEvent.TOUCH, "death": RestEvent.DEATH}
_REST_NAMES: dict[str, BranchEvent | RestEvent] = {**{kind.value: kind for kind in REST_FOLLOWED}, **_REST_SHORT}


@overload
def point_curves_answer(
    case: Case, branch: Branch, which: str, along: str, over: str, *, halt: Callable[[], bool] | None = None
) -> tuple[PointCurve, ...]: ...


@overload
def point_curves_answer(
    case: Case, branch: RestBranch, which: str, along: str, over: str, *, halt: Callable[[], bool] | None = None
) -> tuple[RestPointCurve, ...]: ...


def point_curves_answer(
    case: Case,
    branch: Branch | RestBranch,
    which: str,
    along: str,
    over: str,
    *,
    halt: Callable[[], bool] | None = None,
) -> tuple[PointCurve, ...] | tuple[RestPointCurve, ...]:
    """Points of a branch followed through its parameter and a second one; see `percuss.explore.follow_point`.

    Parameters
    ----------
    case
        The case of the branch.
    branch
        As `branch_answer` gives it, or `rest_branch_answer` for a cycle with rest; the points of the branches switched
        to count, too, after its own.
    which
        ``flip`` for the first flip, ``flip:2`` for the second, several with commas between them, or ``all``.
    along, over
        The parameter of the branch and the second one, each with its range: ``mean=0.3:1.2``, ``restitution=0:0.9``.
    halt
        As for `percuss.explore.follow`.

    Raises
    ------
    CaseError, ParameterError
        When there is no such point or parameter.

    Examples
    --------
    >>> from percuss.case import branch_answer, load_case
    >>> case, along = load_case("pneumatic-jackleg"), "load_factor=0.36:0.45"
    >>> branch = branch_answer(case, "1/1:2", along, modes=0)
    >>> curve, = point_curves_answer(case, branch, "fold", along, "restitution=0.149:0.151")
    >>> curve.event.value, curve.parameters
    ('fold', ('load_factor', 'restitution'))
    """
    checked_case(case)
    having("branch", branch, ("points", "parameter"), "a branch, as percuss.case.branch_answer gives it")
    axes = [Axis.spanned(text(name, given, "NAME=FROM:TO")) for name, given in (("along", along), ("over", over))]
    family = CaseFamily(case, {axis.name: axis.unit for axis in axes if axis.unit})
    ranges = [(float(axis.values[0]), float(axis.values[1])) for axis in axes]
    second = value_of(case, family, axes[1].name, ranges[1])
    found: list[Any] = []
    for point in _chosen(branch, which):
        names, values = [axis.name for axis in axes], (point.value, second)
        found.append(follow_point(point, names, ranges, family=family, values=values, halt=halt))
        if halt is not None and halt():
            break
    return tuple(found)


def _chosen(branch: Branch | RestBranch, which: str) -> list[BranchPoint] | list[RestBranchPoint]:
    """The points that a text names."""
    every: list[Any] = followed_points(branch)
    names = _REST_NAMES if isinstance(branch, RestBranch) else _NAMES
    there = Counter(point.kind.value for point in every or branch.points)
    known = ", ".join(f"{kind} ({number})" if number > 1 else kind for kind, number in there.items())
    if text("curve", which, "all").strip() != "all":
        return [_one(every, names, word.strip(), which, known) for word in which.split(",")]
    if not every:
        told = f"points of which there are curves: {', '.join(names)}"
        raise ParameterError("curve", which, told, f"on this branch there are only: {known}")
    return every


def followed_points(branch: Branch | RestBranch) -> list[BranchPoint] | list[RestBranchPoint]:
    """All points that can be followed, each once: a branch that was switched to begins at one of them."""
    if isinstance(branch, RestBranch):
        return [point for point in branch.points if point.kind in REST_FOLLOWED]
    kept = [point for point in branch.points if point.kind in FOLLOWED]
    return kept + [
        point
        for other in branch.family()
        if other is not branch
        for point in other.points[1:]
        if point.kind in FOLLOWED and point.kind is not BranchEvent.HALVING
    ]


def _one(every: Sequence[Any], names: Mapping[str, BranchEvent | RestEvent], word: str, given: str, known: str) -> Any:
    """The point that a word names."""
    found = re.fullmatch(r"([a-z_]+)(?::(\d{1,4}))?", word, re.ASCII)
    if found is None or found[1] not in names:
        told = f"all, or one of {', '.join(names)}, with :NUMBER for another than the first"
        raise ParameterError("curve", given, told, f"on this branch there are: {known}")
    kind, number = names[found[1]], int(found[2] or 1)
    those = [point for point in every if point.kind is kind]
    if not those:
        raise ParameterError("curve", given, f"a point that there is: this branch has no {kind.value}, but {known}")
    if not 1 <= number <= len(those):
        numbers = f"a number from 1 to {len(those)}" if len(those) > 1 else "the only one, number 1"
        raise ParameterError("curve", given, f"{numbers}, of its points {kind.value}", f"there are: {known}")
    return those[number - 1]
