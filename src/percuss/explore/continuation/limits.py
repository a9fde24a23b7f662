"""How far the parameter of a branch may go: to the end of its range, or to where there is no system any more."""

from __future__ import annotations

from typing import NamedTuple

from percuss.errors import LoadError, ParameterError, PercussError
from percuss.explore.continuation.kinds import BranchEvent
from percuss.explore.continuation.solution_curve import SolutionCurve

__all__ = ["Limit", "in_words", "limit_before", "refused"]

_ROUNDING, _EVEN = 1e-15, 1e-12  # of a limit of the parameter


class Limit(NamedTuple):
    """The last value of the parameter, what ends the branch there, and why it goes no further."""

    value: float
    kind: BranchEvent
    refusal: PercussError | None


def limit_before(curve: SolutionCurve, here: float, value: float, bounds: tuple[float, float]) -> Limit | None:
    """The limit of the parameter between a value that it has and another one; None where there is none."""
    found = None
    if not bounds[0] <= value <= bounds[1]:
        value = min(max(value, bounds[0]), bounds[1])
        found = Limit(value, BranchEvent.LIMIT, None)
    refusal = curve.refusal(value)
    return found if refusal is None else Limit(_last_value(curve, here, value), refused(refusal), refusal)


def in_words(refusal: PercussError | None) -> str:
    """What a refusal expects, without the value beyond the end that was tried; empty for none."""
    if isinstance(refusal, ParameterError):
        return f"{refusal.name}: expected {refusal.accepted}"
    return str(refusal or "")


def refused(refusal: PercussError) -> BranchEvent:
    """What ends a branch where there is no system, or its load does not push."""
    return BranchEvent.NO_PUSH if isinstance(refusal, LoadError) else BranchEvent.NO_SYSTEM


def _last_value(curve: SolutionCurve, good: float, bad: float) -> float:
    """The last value of the parameter, on the way to one, at which there is a system whose load pushes."""
    while abs(good - bad) > _ROUNDING * max(abs(good), abs(bad), curve.unit):
        middle = 0.5 * (good + bad)
        if curve.refusal(middle) is None:
            good = middle
        else:
            bad = middle
    even = round(good, 12)  # the limit itself, where that is allowed
    return even if curve.refusal(even) is None and abs(even - good) < _EVEN else good
