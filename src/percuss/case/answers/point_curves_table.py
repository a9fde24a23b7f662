"""Curves of points over two parameters as a table of text, and read again from JSON to be laid over a map."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from percuss.errors import ParameterError
from percuss.explore import PointCurve, RestPointCurve

if TYPE_CHECKING:
    from percuss.model.checks import Array

__all__ = ["LaidCurve", "laid_curves", "point_curves_table"]

_WHAT = "curves as 'percuss follow … --curve … --json' prints them"


class LaidCurve(NamedTuple):
    """A curve as a map takes it: its kind, the names of the parameters, their units, and both along it, (m, 2).

    Where the motion is no orbit both are NaN; see `percuss.explore.PointCurve.real`.
    """

    kind: str
    parameters: tuple[str, str]
    units: tuple[str, str]
    real: Array


def point_curves_table(curves: Sequence[PointCurve | RestPointCurve]) -> str:
    """Curves over the same two parameters as CSV: a line for each impact of a point, or for a point with rest.

    Examples
    --------
    >>> point_curves_table([])
    'curve,type,label,point,is_orbit,impact,phase\\n'
    """
    names = "".join(f"{name}," for name in curves[0].parameters) if curves else ""
    resting = [one for one in curves if isinstance(one, RestPointCurve)]
    if resting:
        return _rest_table(resting, names)
    lines = [f"curve,type,label,point,{names}is_orbit,impact,phase"]
    for number, one in enumerate((one for one in curves if isinstance(one, PointCurve)), 1):
        rows = zip(one.values.tolist(), one.phases.tolist(), one.is_orbit.tolist(), strict=True)
        for point, ((first, second), phases, real) in enumerate(rows, 1):
            head = f"{number},{one.event.value},{one.label},{point},{first!r},{second!r},{int(real)}"
            lines += [f"{head},{impact},{phase!r}" for impact, phase in enumerate(phases, 1)]
    return "\n".join([*lines, ""])


def _rest_table(curves: Sequence[RestPointCurve], names: str) -> str:
    lines = [f"curve,type,label,point,{names}is_orbit,release_phase,event_phase"]
    for number, one in enumerate(curves, 1):
        phases = zip(one.release_phases.tolist(), one.event_phases.tolist(), strict=True)
        rows = zip(one.values.tolist(), one.is_orbit.tolist(), phases, strict=True)
        for point, ((first, second), real, (release, event)) in enumerate(rows, 1):
            head = f"{number},{one.event.value},{one.label},{point},{first!r},{second!r},{int(real)}"
            lines.append(f"{head},{release!r},{event!r}")
    return "\n".join([*lines, ""])


def laid_curves(name: str, content: bytes) -> tuple[LaidCurve, ...]:
    """The curves in a file with the answer of ``percuss follow … --curve … --json``.

    Raises
    ------
    ParameterError
        When it is none.
    """
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
