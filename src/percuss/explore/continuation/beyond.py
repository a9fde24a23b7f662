"""What lies beyond a point of a branch, in a sentence."""

from __future__ import annotations

import math

import numpy as np

from percuss.explore.continuation.happenings import Happening
from percuss.explore.continuation.indicators import multipliers, outside
from percuss.explore.continuation.kinds import BranchEvent
from percuss.explore.continuation.next_point import Strayed
from percuss.explore.continuation.partners import Partner, doubled, grazing_partner, is_joined, other_end
from percuss.explore.continuation.solution_curve import CurvePoint, SolutionCurve
from percuss.stability.multipliers import TURNING

__all__ = ["sentence"]

_LEVEL = 1e-3  # of a tangent, its part along the parameter where a branch turns back
_INTO = 0.01  # rad, how far into a branch that begins it is looked which way it leads


def sentence(curve: SolutionCurve, one: Happening, impact: int | None, refusal: str) -> str:
    """What lies beyond.

    Parameters
    ----------
    curve, one
        The curve, and what happens.
    impact
        Number of the impact that it happens to, as it is told; or None.
    refusal
        Why the parameter goes no further.
    """
    kind, name = one.kind, curve.name
    if kind is BranchEvent.FOLD:
        return f"the branch turns back; beyond {name} = {_number(curve, one.point)} neither of its two orbits exists"
    if kind is BranchEvent.FLIP:
        return _flip(curve, one.point)
    if kind is BranchEvent.NEIMARK_SACKER:
        return _pair(curve, one.point)
    if kind is BranchEvent.CROSSING:
        over = "another branch crosses this one"
        if abs(one.point.tangent[-1]) < _LEVEL:
            return f"{over}, which turns back and goes on as its own image, backwards in time or some periods later"
        return f"{over}, and stability may pass from one to the other"
    if kind in (BranchEvent.TOUCH, BranchEvent.DEATH):
        return _grazing(curve, one, impact)
    if kind is BranchEvent.CORNER:
        return f"impact {impact} falls on the other side of a step of the load, and the branch goes on"
    if kind is BranchEvent.NONSMOOTH_FOLD:
        return f"impact {impact} falls on the other side of a step of the load, and the branch turns back"
    if kind is BranchEvent.NO_SYSTEM:
        return f"there is no such system: {refusal}" if refusal else kind.words
    if kind is BranchEvent.STICKING:
        if curve.motion(one.point.x).system.body.is_free:
            return "the bar comes to rest on the wall and waits until the load pulls: a cycle with rest"
        return "the structure comes to rest on the wall, which is beyond the law of its impacts"
    return _PLAIN.get(kind, kind.words)


_PLAIN = {
    BranchEvent.HALVING: "the branch would go back over itself, half its period later",
    BranchEvent.COALESCENCE: "two impacts are one, so the label changes",
    BranchEvent.NO_PUSH: "the mean load does not push, so no motion keeps striking",
    BranchEvent.LIMIT: "the branch goes on",
    BranchEvent.CLOSED: "the branch is a closed loop, all of which is here",
    BranchEvent.RESONANCE: "an elastic mode would grow without bound from cycle to cycle",
    BranchEvent.STOPPED: "the branch goes on",
    BranchEvent.LOST: "Newton's method finds no further point, however short the step",
}


def _number(curve: SolutionCurve, point: CurvePoint) -> str:
    return f"{curve.value(point.x):.9g}"


def _label(curve: SolutionCurve) -> str:
    return f"z={curve.impacts}/{curve.periods}"


def _into(partner: Partner) -> tuple[str, str]:
    """Towards which values a branch begins, and whether it is stable there; empty where that is not found."""
    curve, start = partner
    try:
        found = curve.corrected(start.x + _INTO * start.tangent, start.tangent)
    except Strayed:
        return "", ""
    word = "greater" if found.x[-1] > start.x[-1] else "smaller"
    beyond = outside(multipliers(curve.motion(found.x)))
    return f" towards {word} {curve.name}", ", stable" if beyond == 0 else ", unstable"


def _flip(curve: SolutionCurve, point: CurvePoint) -> str:
    partner = doubled(curve, point)
    if partner is None:
        return "an orbit of twice the period begins, longer than orbits are followed here"
    towards, stable = _into(partner)
    return f"{_label(partner[0])} begins{towards}{stable}"


def _pair(curve: SolutionCurve, point: CurvePoint) -> str:
    values = multipliers(curve.motion(point.x))
    if values is None:
        return "motions on a torus may begin"
    turning = values[values.imag > TURNING * np.abs(values)]
    pair = turning[np.argmin(np.abs(np.abs(turning) - 1.0))]
    return f"motions on a torus may begin, which turn by {math.degrees(float(np.angle(pair))):.4g}° in a cycle"


def _grazing(curve: SolutionCurve, one: Happening, impact: int | None) -> str:
    touch = one.kind is BranchEvent.TOUCH
    is_free = curve.motion(one.point.x).system.body.is_free
    what = "bar" if is_free else "structure"
    here = f"the {what} would pass through the wall" if touch else f"impact {impact} would strike backwards"
    label = f"z={curve.impacts + 1 if touch else curve.impacts - 1}/{curve.periods}"
    if curve.impacts == 1 and not touch:
        return here
    if is_joined(curve):
        partner = grazing_partner(curve, one.point, one.kind, one.which)
        return here if partner is None else f"{here}; {label} begins here{''.join(_into(partner))}"
    found = other_end(curve, one.point, one.kind, one.which)
    if found is None:
        return f"{here}; no end of {label} was found near"
    event = "an impact without speed" if touch else "a touch"
    why = "the bar is elastic" if is_free else "the structure has several modes"
    return f"{here}; {label} ends at {found[0].value(found[1]):.9g} ({event}), not here: {why}"
