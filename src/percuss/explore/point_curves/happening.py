"""What happens between two points of a curve in two parameters, and what of it is one thing."""

from __future__ import annotations

from typing import NamedTuple

from percuss.explore.point_curves.conditions import Condition, Death, Touch
from percuss.explore.point_curves.extended_curve import ExtendedPoint
from percuss.explore.point_curves.kinds import CurveEvent

__all__ = ["CurveHappening", "without_what_follows"]

_ALIKE = 1e-6  # of a step, within which two things happen at one place
_FOLLOW = {CurveEvent.WITH_FOLD, CurveEvent.WITH_FLIP, CurveEvent.RESONANCE_1, CurveEvent.RESONANCE_2}


class CurveHappening(NamedTuple):
    """What happens at a share of the way between two points."""

    kind: CurveEvent
    share: float
    point: ExtendedPoint


def without_what_follows(found: list[CurveHappening], condition: Condition) -> list[CurveHappening]:
    """What happens, a resonant grazing as one thing, and corners without what jumps there.

    At a resonant grazing K(ξ) is singular for every ξ, and so for 1 and −1, which says no more. On a curve of folds or
    flips it is seen as an impact without speed.
    """
    grazing = isinstance(condition, Death | Touch)
    sign = CurveEvent.RESONANT_GRAZING if grazing else CurveEvent.WITH_DEATH
    for one in [one for one in found if one.kind is sign]:
        here = [other for other in found if other.kind in _FOLLOW and _is_near(other.share, [one.share])]
        if here:
            found = [other for other in found if not any(other is gone for gone in (one, *here))]
            found.append(one._replace(kind=CurveEvent.RESONANT_GRAZING))
    corners = [one.share for one in found if one.kind is CurveEvent.WITH_CORNER]  # where K(ξ) jumps
    return [one for one in found if one.kind not in _FOLLOW or not _is_near(one.share, corners)]


def _is_near(share: float, others: list[float]) -> bool:
    return any(abs(share - other) < _ALIKE for other in others)
