"""Maps, boundaries, basins and numerical experiments: any function of a system over any parameters.

`sweep` computes quantities over a parameter curve or plane, `boundaries` solves for the curves themselves, `follow`
goes along a branch of orbits round folds and past flips to its ends, `follow_rest_cycle` along one of cycles with rest,
`follow_point` follows a point of a branch through a plane of two parameters, `diagram` shows all branches and what
simulations settle on over one parameter, `experiment` and `basins` count where starts end.
What is long is carried out by many workers, kept chunk by chunk in an archive, and resumed (`carry_out`). The names are
imported when first used.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from percuss.explore.attractors.basin import Basins as Basins
    from percuss.explore.attractors.basin import basins as basins
    from percuss.explore.attractors.experiments import Experiment as Experiment
    from percuss.explore.attractors.experiments import Share as Share
    from percuss.explore.attractors.experiments import experiment as experiment
    from percuss.explore.boundary_curves.boundary import Boundaries as Boundaries
    from percuss.explore.boundary_curves.boundary import boundaries as boundaries
    from percuss.explore.continuation.branch import Branch as Branch
    from percuss.explore.continuation.branch import BranchEvent as BranchEvent
    from percuss.explore.continuation.branch import BranchPoint as BranchPoint
    from percuss.explore.continuation.branch import Doubling as Doubling
    from percuss.explore.continuation.branch import PlainMotion as PlainMotion
    from percuss.explore.continuation.branch import PointCurve as PointCurve
    from percuss.explore.continuation.following import follow as follow
    from percuss.explore.continuation.reaching import Reach as Reach
    from percuss.explore.continuation.reaching import ReachEnd as ReachEnd
    from percuss.explore.continuation.reaching import reach as reach
    from percuss.explore.continuation.rest_following import follow_rest_cycle as follow_rest_cycle
    from percuss.explore.diagrams.diagram import Diagram as Diagram
    from percuss.explore.diagrams.diagram import SettledMotion as SettledMotion
    from percuss.explore.diagrams.diagram import diagram as diagram
    from percuss.explore.diagrams.diagram_lines import DiagramBranch as DiagramBranch
    from percuss.explore.family import Axis as Axis
    from percuss.explore.family import Family as Family
    from percuss.explore.family import SystemFamily as SystemFamily
    from percuss.explore.jobs.archive import Archive as Archive
    from percuss.explore.jobs.carrying_out import carry_out as carry_out
    from percuss.explore.jobs.carrying_out import estimate as estimate
    from percuss.explore.jobs.job import Column as Column
    from percuss.explore.jobs.job import Job as Job
    from percuss.explore.jobs.progress import JobProgress as JobProgress
    from percuss.explore.lyapunov import Lyapunov as Lyapunov
    from percuss.explore.lyapunov import lyapunov_exponent as lyapunov_exponent
    from percuss.explore.lyapunov import lyapunov_many as lyapunov_many
    from percuss.explore.orbit_starts import orbit_of as orbit_of
    from percuss.explore.orbit_starts import orbit_seeds as orbit_seeds
    from percuss.explore.orbit_starts import switched_seeds as switched_seeds
    from percuss.explore.parameters import PARAMETERS as PARAMETERS
    from percuss.explore.parameters import parameters_of as parameters_of
    from percuss.explore.parameters import vary as vary
    from percuss.explore.point_curves.following_points import follow_point as follow_point
    from percuss.explore.quantities import CELL_OUTCOMES as CELL_OUTCOMES
    from percuss.explore.quantities import MACHINE_QUANTITIES as MACHINE_QUANTITIES
    from percuss.explore.quantities import QUANTITIES as QUANTITIES
    from percuss.explore.quantities import REASONS as REASONS
    from percuss.explore.quantities import STALLS as STALLS
    from percuss.explore.sweeps import Sweep as Sweep
    from percuss.explore.sweeps import sweep as sweep

_HOME = {
    "Archive": "jobs.archive",
    "Axis": "family",
    "Basins": "attractors.basin",
    "Boundaries": "boundary_curves.boundary",
    "Branch": "continuation.branch",
    "BranchEvent": "continuation.branch",
    "BranchPoint": "continuation.branch",
    "CELL_OUTCOMES": "quantities",
    "Column": "jobs.job",
    "Diagram": "diagrams.diagram",
    "DiagramBranch": "diagrams.diagram_lines",
    "Doubling": "continuation.branch",
    "Experiment": "attractors.experiments",
    "Family": "family",
    "Job": "jobs.job",
    "JobProgress": "jobs.progress",
    "Lyapunov": "lyapunov",
    "MACHINE_QUANTITIES": "quantities",
    "PARAMETERS": "parameters",
    "PlainMotion": "continuation.branch",
    "PointCurve": "continuation.branch",
    "QUANTITIES": "quantities",
    "REASONS": "quantities",
    "Reach": "continuation.reaching",
    "ReachEnd": "continuation.reaching",
    "STALLS": "quantities",
    "SettledMotion": "diagrams.diagram",
    "Share": "attractors.experiments",
    "Sweep": "sweeps",
    "SystemFamily": "family",
    "basins": "attractors.basin",
    "boundaries": "boundary_curves.boundary",
    "carry_out": "jobs.carrying_out",
    "diagram": "diagrams.diagram",
    "estimate": "jobs.carrying_out",
    "experiment": "attractors.experiments",
    "follow": "continuation.following",
    "follow_point": "point_curves.following_points",
    "follow_rest_cycle": "continuation.rest_following",
    "lyapunov_exponent": "lyapunov",
    "lyapunov_many": "lyapunov",
    "orbit_of": "orbit_starts",
    "orbit_seeds": "orbit_starts",
    "switched_seeds": "orbit_starts",
    "parameters_of": "parameters",
    "reach": "continuation.reaching",
    "sweep": "sweeps",
    "vary": "parameters",
}

__all__ = sorted(_HOME)


def __getattr__(name: str) -> object:
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOME[name]}"), name)


def __dir__() -> list[str]:
    return sorted(__all__)
