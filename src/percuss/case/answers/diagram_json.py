"""Diagrams as JSON, and as a table of text."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from percuss.case.answers.json_values import number

if TYPE_CHECKING:
    from percuss.case.case import Case
    from percuss.explore import Diagram, DiagramBranch, DiagramPoint, DiagramRestBranch, SettledMotion

__all__ = ["diagram_dict"]


def diagram_dict(case: Case, found: Diagram) -> dict[str, Any]:
    """A diagram as a tree of dict, list, str, bool, int, finite float and None."""
    return {
        "case": case.file,
        "title": case.title,
        "notes": list(case.notes),
        "parameter": found.axis.name,
        "unit": found.axis.unit,
        "values": found.axis.values.tolist(),
        "modes": found.modes,
        "done": found.done,
        "left_out": found.left_out,
        "settled": [_settled(one) for one in found.settled],
        "branches": [_branch(line) for line in found.branches],
        "rest_branches": [_rest_branch(line) for line in found.rest_branches],
        "impossible": [_branch(line) for line in found.impossible],
    }


def _settled(one: SettledMotion) -> dict[str, Any]:
    speed, energy = one.scales or (math.nan, math.nan)
    return {
        "value": one.value,
        "label": one.label,
        "members": one.members,
        "phases": one.phases.tolist(),
        "speeds": one.speeds.tolist(),
        "energy": number(one.energy),
        "speeds_m_s": None if one.scales is None else (one.speeds * speed).tolist(),
        "energy_J": number(one.energy * energy),
    }


def _branch(line: DiagramBranch) -> dict[str, Any]:
    scales = line.scales
    return {
        "label": line.label,
        "points": [_point(point) for point in line.points],
        "branch": {
            "value": line.values.tolist(),
            "phases": line.phases.tolist(),
            "times": line.times.tolist(),
            "speeds": line.speeds.tolist(),
            "energy": [number(energy) for energy in line.energies.tolist()],
            "stable": line.stable.tolist(),
            "speeds_m_s": None if scales is None else _finite(line.speeds * scales[:, :1]),
            "energy_J": None if scales is None else _finite(line.energies * scales[:, 1]),
        },
    }


def _rest_branch(line: DiagramRestBranch) -> dict[str, Any]:
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
            "energy": _finite(line.energies),
            "stable": line.stable.tolist(),
            "impacts": known.sum(axis=-1).tolist(),
            "release_phases": line.release_phases.tolist(),
            "rest_phases": line.rest_phases.tolist(),
            "speeds_m_s": None if scales is None else listed(line.speeds * scales[:, :1, None]),
            "energy_J": None if scales is None else _finite(line.energies * scales[:, 1]),
        },
    }


def _point(point: DiagramPoint) -> dict[str, Any]:
    return {
        "type": point.kind.value,
        "value": point.value,
        "label": point.label,
        "phases": point.phases.tolist(),
        "speeds": point.speeds.tolist(),
        "energy": number(point.energy),
        "beyond": point.beyond,
        "impact": point.impact,
        "touch_phase": point.touch_phase,
    }


def _finite(values: np.ndarray) -> Any:
    """Numbers as lists, None for those that are not known."""
    if values.ndim > 1:
        return [_finite(row) for row in values]
    return [number(value) for value in values.tolist()]
