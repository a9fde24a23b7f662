"""Points of a branch of a case, followed through two parameters: which ones a text names, and their curves."""

from __future__ import annotations

import json
import re
import time
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from percuss.case.answers.exploring.orbits_answer import branch_answer, followed, value_of
from percuss.case.answers.facts import table_text
from percuss.case.case import Case, checked_case
from percuss.case.parameters.case_family import CaseFamily
from percuss.errors import ParameterError
from percuss.explore import Axis, BranchEvent, BranchPoint, PointCurve, follow_point
from percuss.explore.point_curves.following_points import FOLLOWED
from percuss.explore.point_curves.machine_points import FOLLOWED_OF_MACHINES, FOLLOWED_OF_SEVERAL
from percuss.explore.point_curves.rest_walk import REST_FOLLOWED
from percuss.halting import Elapsed, asked
from percuss.model.checks import callback, having, text

if TYPE_CHECKING:
    from percuss.explore import Branch
    from percuss.model.checks import Array


_SHORT = {"touch": BranchEvent.TOUCH, "death": BranchEvent.DEATH}
_NAMES = {**{kind.value: kind for kind in FOLLOWED}, **_SHORT, "pair": BranchEvent.NEIMARK_SACKER}
_MACHINE_NAMES = {**{kind.value: kind for kind in FOLLOWED_OF_MACHINES}, **_SHORT, "pair": BranchEvent.NEIMARK_SACKER}
_REST_NAMES = {**{kind.value: kind for kind in REST_FOLLOWED}, **_SHORT}
_SEVERAL_NAMES = {**{kind.value: kind for kind in FOLLOWED_OF_SEVERAL}, "pair": BranchEvent.NEIMARK_SACKER}


def point_curves_answer(
    case: Case,
    branch: Branch,
    which: str,
    along: str,
    over: str,
    *,
    progress: Callable[[Elapsed], object] | None = None,
) -> tuple[PointCurve, ...]:
    """Points of a branch followed through its parameter and a second one; see `percuss.explore.follow_point`.

    Parameters
    ----------
    branch
        As `branch_answer` gives it; the points of the branches switched to count, too, after its own.
    which
        ``flip`` for the first flip, ``flip:2`` for the second, several with commas between them, or ``all``.
    along, over
        The parameter of the branch and the second one, each with its range: ``mean=0.3:1.2``, ``restitution=0:0.9``;
        without a range, ``restitution``, curves are followed to their ends.

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
    (first, unit, here), (other, its_unit, there) = (_parameter(case, given) for given in (along, over))
    family = CaseFamily(case, {name: of for name, of in ((first, unit), (other, its_unit)) if of})
    second = value_of(case, family, other, there)
    found: list[Any] = []
    callback("progress", progress)
    halt = asked(progress)
    for point in _chosen(branch, which):
        values = (point.value, second)
        found.append(follow_point(point, (first, other), (here, there), family=family, values=values, progress=halt))
        if halt is not None and halt():
            break
    return tuple(found)


def _parameter(case: Case, given: str) -> tuple[str, str, tuple[float, float] | None]:
    name, family, ends = followed(case, given)
    return name, family.units.get(name, ""), ends


def _chosen(branch: Branch, which: str) -> list[BranchPoint]:
    every: list[Any] = followed_points(branch)
    names = _REST_NAMES if branch.has_rest else _MACHINE_NAMES if branch.is_machine else _NAMES
    names = _SEVERAL_NAMES if _is_several(branch) else names
    there = Counter(point.kind.value for point in every or branch.points)
    known = ", ".join(f"{kind} ({number})" if number > 1 else kind for kind, number in there.items())
    if text("curve", which, "all").strip() != "all":
        return [_one(every, names, word.strip(), which, known) for word in which.split(",")]
    if not every:
        told = f"points of which there are curves: {', '.join(names)}"
        if branch.is_machine and which.strip() == "all":  # a branch on which nothing happens has no curves
            return []
        raise ParameterError("curve", which, told, f"on this branch there are only: {known}")
    return every


def followed_points(branch: Branch) -> list[BranchPoint]:
    """All points that can be followed, each once: a branch that was switched to begins at one of them."""
    several = _is_several(branch)
    if branch.has_rest and not several:
        return [point for point in branch.points if point.kind in REST_FOLLOWED]
    known = FOLLOWED_OF_SEVERAL if several else FOLLOWED_OF_MACHINES if branch.is_machine else FOLLOWED
    kept = [point for point in branch.points if point.kind in known]
    return kept + [
        point
        for other in branch.family()
        if other is not branch
        for point in other.points[1:]
        if point.kind in known and point.kind is not BranchEvent.HALVING
    ]


def _is_several(branch: Branch) -> bool:
    return any(cycle.is_several for cycle in branch.cycles[:1])


def _one(every: Sequence[Any], names: Mapping[str, BranchEvent], word: str, given: str, known: str) -> Any:
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


# ---- Curves of points over two parameters as a table of text, and read again from JSON to be laid over a map

_WHAT = "curves as 'percuss follow … --curve … --json' prints them"


class LaidCurve(NamedTuple):
    """A curve as a map takes it: `real` has both parameters along it, (m, 2), NaN where the motion is no orbit."""

    kind: str
    parameters: tuple[str, str]
    units: tuple[str, str]
    real: Array


def point_curves_table(curves: Sequence[PointCurve]) -> str:
    """Curves over the same two parameters as CSV: a line for each impact of a point, or for a point with rest."""
    head = ("curve", "type", "label", "point", *(curves[0].parameters if curves else ()), "is_orbit")
    rows: list[tuple[object, ...]] = []
    resting = False
    for number, one in enumerate(curves, 1):
        resting = one.has_rest
        for point, (values, real) in enumerate(zip(one.values.tolist(), one.is_orbit.tolist(), strict=True)):
            place = (number, one.event.value, one.label, point + 1, *values, int(real))
            if resting:
                when = float(one.event_phases[point]) if one.event_phases.size else ""
                rows.append((*place, float(np.ravel(one.release_phases[point])[0]), when))
            else:
                rows += [(*place, impact, phase) for impact, phase in enumerate(one.phases[point].tolist(), 1)]
    return table_text((*head, *(("release_phase", "event_phase") if resting else ("impact", "phase"))), rows)


def laid_curves(name: str, content: bytes) -> tuple[LaidCurve, ...]:
    """The curves in a file of ``percuss follow … --curve … --json``; ParameterError when it is none."""
    try:
        answer = json.loads(content)
        return tuple(_laid(one) for one in answer["curves"])
    except (ValueError, KeyError, TypeError, IndexError, RecursionError):
        raise ParameterError("overlay", name, _WHAT) from None


def _laid(one: dict[str, Any]) -> LaidCurve:
    values = np.array(one["curve"]["values"], dtype=float).reshape(-1, 2)
    real = np.array(one["curve"]["is_orbit"], dtype=bool)
    (first, second), (unit, other) = one["parameters"], one["units"]
    named = all(isinstance(word, str) for word in (one["type"], first, second, unit, other))
    if not named or real.shape != values.shape[:1]:
        raise ValueError
    return LaidCurve(one["type"], (first, second), (unit, other), np.where(real[:, None], values, np.nan))


# ---- What happens to an orbit, as curves over a plane: each told as soon as it has been followed

_NEAR = 3e-3  # of the plane, within which a point is on a curve that is known

Watched = tuple[float, tuple["PointCurve", ...]]


def curves_progress(
    case: Case,
    orbit: str,
    across: str,
    up: str,
    *,
    modes: int | None = None,
    patience: float = 8.0,
    halt: Callable[[], bool] = lambda: False,
) -> Iterator[Watched]:
    """What happens to an orbit on both lines through it: share done, curves so far; `patience`: work for each, in s."""
    axes = {axis.name: axis for axis in map(Axis.spanned, (across, up))}
    family = CaseFamily(case, {name: axis.unit for name, axis in axes.items() if axis.unit})
    here = {name: value_of(case, family, name) for name in axes}
    spans = {name: (float(axis.values[0]), float(axis.values[1])) for name, axis in axes.items()}
    found: list[PointCurve] = []
    for line, (along, over) in enumerate(((up, across), (across, up))):
        branch = branch_answer(case, orbit, along, modes=modes, progress=lambda _: halt())
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
            found.append(follow_point(point, names, ranges, family=family, values=values, progress=late))
            yield 0.5 * line + 0.5 * (i + 1) / (len(points) + 1), tuple(found)
    yield 1.0, tuple(found)


def _late(seconds: float, halt: Callable[[], bool]) -> Callable[[Elapsed], bool]:
    """What says so after some time worked by this thread, however busy the machine is, or when `halt` does."""
    until = time.thread_time() + seconds
    return lambda _: halt() or time.thread_time() > until


def _is_on(
    curve: PointCurve, point: BranchPoint, place: dict[str, float], spans: dict[str, tuple[float, float]]
) -> bool:
    assert point.motion is not None
    if (curve.event, curve.label) != (point.kind, point.motion.label) or len(curve.values) < 2:
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
