"""What the figures of B77 share: the systems in the limit s → ∞, the values of R, branches as rows."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from percuss.explore.boundary_curves.branches import Line, Stretch, folds_and_stretches
from percuss.explore.boundary_curves.grazing import admissible_on
from percuss.explore.family import SystemFamily
from percuss.model import Load, System
from percuss.model.checks import Array
from percuss.stability.reduced import schur_quotients

__all__ = ["DAMPING", "KAPPAS", "RESTITUTIONS", "STIFF", "TENTHS", "branch_rows", "hydraulic", "pneumatic", "stacked"]

STIFF = 1e7
"""s of the limit s → ∞: σ falls off like 1/(12 s²) or faster and is below rounding there."""

DAMPING = 0.03 / (2.0 * math.pi)
"""d of B77's damped curves, 2πd = 0.03."""

RESTITUTIONS = np.linspace(0.0, 0.99, 100)
"""R of the curves over R."""

KAPPAS = (1.0 + 1e-6, 2.0 - 1e-6)
"""The range of κ in which the square wave pushes."""

TENTHS = tuple(i / 10 for i in range(10))
"""R of the families of curves."""


def pneumatic(s: float = STIFF, d: float = 0.0) -> System:
    """p(t) = p_0 + cos t; R and p_0 are set by what is asked."""
    return System(s=s, d=d, restitution=0.0, load=Load.harmonic(1.0, 1.0))


def hydraulic(s: float = STIFF, d: float = 0.0) -> System:
    """The square wave with q = 1, exact between its jumps; R and κ are set by what is asked."""
    return System(s=s, d=d, restitution=0.0, load=Load.square(1.0, 1.5, 8))


def branch_rows(
    system: System, restitution: float, name: str, low: float, high: float, points: int
) -> dict[str, npt.NDArray[Any]]:
    """All steady motions of one R, m = 1, along a parameter: a row each, up one branch to the fold and down the other.

    Stable by B77's reduced criterion; admissible as the motion of the rigid bar, to which it tends as s → ∞.
    """
    line = Line(SystemFamily(system), {"restitution": restitution}, name, low, high, 1, 0)
    parts = []
    for way, stretch in zip((1, -1), folds_and_stretches(line, 33)[1], strict=True):
        rows = _rows(stretch, points)
        order = np.argsort(way * rows[0])
        parts.append([row[order] for row in rows])
    y, phase, stable, admissible = (np.concatenate(column) for column in zip(*parts, strict=True))
    return {
        "restitution": np.full(y.size, restitution),
        name: y,
        "phase": phase,
        "stable": stable.astype(bool),
        "admissible": admissible.astype(bool),
    }


def _rows(stretch: Stretch, points: int) -> tuple[Array, Array, Array, Array]:
    t = (np.arange(points) + 0.5) / points  # the ends are folds, or the end of the range
    y, phase = stretch.place(t)
    first, second = schur_quotients(*stretch.quadratic(t))
    stable = (first < 1.0) & (second < 1.0)
    return y, phase, stable.astype(float), admissible_on(stretch, t, 7).astype(float)


def stacked(parts: list[dict[str, npt.NDArray[Any]]]) -> dict[str, npt.NDArray[Any]]:
    """The rows of several tables of equal columns, one after the other."""
    return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
