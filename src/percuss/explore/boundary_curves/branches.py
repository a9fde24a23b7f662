"""The branches of steady motions along one parameter: curves of (y, phase) that are followed without folds in the way.

On an arc of the circle on which v_f is monotone there is at most one steady motion for every level (B77 14). Where the
parameter y moves only the level, or only the size of v_f, it is an explicit function of the phase, and the arc is
followed by its phase. Any other parameter moves the arcs themselves: then a branch is followed by y, between the folds
that end it.
"""

from __future__ import annotations

from percuss.explore.boundary_curves.lines import Fold, Line, Stretch, orbit_on
from percuss.explore.boundary_curves.parameter_branches import by_parameter
from percuss.explore.boundary_curves.phase_branches import by_phase, heights_of

__all__ = ["Fold", "Line", "Stretch", "folds_and_stretches", "orbit_on"]


def folds_and_stretches(line: Line, samples: int, folds_alone: bool = False) -> tuple[list[Fold], list[Stretch]]:
    """All folds on a line, and all branches between them unless only folds are wanted."""
    heights = heights_of(line)
    return by_phase(line, heights) if heights is not None else by_parameter(line, samples, folds_alone)
