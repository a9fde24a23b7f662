"""What happens to an orbit, as curves over a plane: each told as soon as it has been followed."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from percuss.case.answers.orbits_answer import branch_answer, value_of
from percuss.case.answers.point_curves_answer import followed_points
from percuss.case.answers.rest_branch_answer import rest_branch_answer
from percuss.case.answers.rest_cycles_answer import is_rest_label
from percuss.case.parameters.case_family import CaseFamily
from percuss.explore import Axis, BranchPoint, follow_point

if TYPE_CHECKING:
    from percuss.case.case import Case
    from percuss.explore import Branch, PointCurve, RestBranch, RestBranchPoint, RestPointCurve
    from percuss.model.checks import Array

__all__ = ["watched_curves"]

_NEAR = 3e-3  # of the plane, within which a point is on a curve that is known

Watched = tuple[float, tuple["PointCurve | RestPointCurve", ...]]


def watched_curves(
    case: Case,
    orbit: str,
    across: str,
    up: str,
    *,
    modes: int | None = None,
    patience: float = 8.0,
    halt: Callable[[], bool] = lambda: False,
) -> Iterator[Watched]:
    """The curves of all that happens to an orbit of a case on the two lines through it, along either parameter.

    Parameters
    ----------
    case, orbit, modes
        As for `percuss.case.branch_answer`, or `percuss.case.rest_branch_answer` for a cycle with rest.
    across, up
        The parameters of the plane, each with its range: ``restitution=0:0.9``.
    patience
        Seconds after which a curve is left as it is.
    halt
        As for `percuss.explore.follow`.

    Yields
    ------
    tuple
        The share that is done, and the curves so far; the last share is 1.

    Raises
    ------
    CaseError, ParameterError
        As `percuss.case.branch_answer`.

    Examples
    --------
    >>> from percuss.case import load_case
    >>> case, plane = load_case("pneumatic-jackleg"), ("restitution=0.149:0.151", "load_factor=0.39:0.45")
    >>> *_, (done, curves) = watched_curves(case, "1/1", *plane, modes=0)
    >>> done, [curve.event.value for curve in curves]
    (1.0, ['fold'])
    """
    axes = {axis.name: axis for axis in map(Axis.spanned, (across, up))}
    family = CaseFamily(case, {name: axis.unit for name, axis in axes.items() if axis.unit})
    here = {name: value_of(case, family, name) for name in axes}
    spans = {name: (float(axis.values[0]), float(axis.values[1])) for name, axis in axes.items()}
    found: list[PointCurve | RestPointCurve] = []
    for line, (along, over) in enumerate(((up, across), (across, up))):
        branch = _followed(case, orbit, along, modes, halt)
        names = tuple(Axis.spanned(text).name for text in (along, over))
        points: Sequence[Any] = followed_points(branch)
        for i, point in enumerate(points):
            if halt():
                return
            place = here | {names[0]: point.value}
            if any(_is_on(curve, point, place, spans) for curve in found):
                continue
            ranges, values = [spans[name] for name in names], [place[name] for name in names]
            late = _late(patience, halt)
            found.append(follow_point(point, names, ranges, family=family, values=values, halt=late))
            yield 0.5 * line + 0.5 * (i + 1) / (len(points) + 1), tuple(found)
    yield 1.0, tuple(found)


def _followed(case: Case, orbit: str, along: str, modes: int | None, halt: Callable[[], bool]) -> Branch | RestBranch:
    if is_rest_label(orbit.partition(":")[0]):
        return rest_branch_answer(case, orbit, along, modes=modes, halt=halt)
    return branch_answer(case, orbit, along, modes=modes, halt=halt)


def _late(seconds: float, halt: Callable[[], bool]) -> Callable[[], bool]:
    """What says so after some time, or when `halt` does."""
    until = time.monotonic() + seconds
    return lambda: halt() or time.monotonic() > until


def _is_on(
    curve: PointCurve | RestPointCurve,
    point: BranchPoint | RestBranchPoint,
    place: dict[str, float],
    spans: dict[str, tuple[float, float]],
) -> bool:
    """Whether a point of a branch lies on a curve of such points."""
    label = point.orbit.label if isinstance(point, BranchPoint) else point.cycle.label
    if (curve.event, curve.label) != (point.kind, label) or len(curve.values) < 2:
        return False
    size = np.array([spans[name][1] - spans[name][0] for name in curve.parameters])
    off = (curve.values - np.array([place[name] for name in curve.parameters])) / size
    return _distance(off) < _NEAR


def _distance(off: Array) -> float:
    """Of a line through points from the origin."""
    steps = np.diff(off, axis=0)
    lengths = np.maximum((steps**2).sum(axis=1), 1e-300)
    shares = np.clip(-(off[:-1] * steps).sum(axis=1) / lengths, 0.0, 1.0)
    return float(np.hypot(*(off[:-1] + shares[:, None] * steps).T).min())
