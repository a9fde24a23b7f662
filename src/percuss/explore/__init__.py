"""Maps, boundaries, basins and numerical experiments: any function of a system over any parameters.

`sweep` computes quantities over a parameter curve or plane, `boundaries` solves for the curves themselves, `follow`
goes along a branch of orbits, cycles with rest or of machines, round folds and past flips to its ends, `follow_point`
follows a point of a branch through a plane of two parameters, `diagram` shows all branches and what simulations settle
on over one parameter, `experiment` and `basins` count where starts end. What is long is carried out by many workers,
kept chunk by chunk in an archive, and resumed (`carry_out`). The names are imported when first used.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from percuss.lazy_names import lazy_names

if TYPE_CHECKING:
    from percuss.explore.attractors.basin import Basins, basins
    from percuss.explore.attractors.experiments import Experiment, Share, experiment
    from percuss.explore.attractors.shares import Shares, shares
    from percuss.explore.boundary_curves.boundary import Boundaries, boundaries
    from percuss.explore.continuation.branch import Branch, BranchEvent, BranchPoint, Doubling, PlainMotion, PointCurve
    from percuss.explore.continuation.following import Reach, ReachEnd, follow, reach
    from percuss.explore.diagrams.diagram import Diagram, diagram
    from percuss.explore.diagrams.diagram_lines import SettledMotion
    from percuss.explore.family import Axis, Family, SystemFamily
    from percuss.explore.jobs.archive import Archive
    from percuss.explore.jobs.carrying_out import carry_out, estimate
    from percuss.explore.jobs.job import Column, Job
    from percuss.explore.jobs.progress import JobProgress
    from percuss.explore.lyapunov import Lyapunov, lyapunov_exponent, lyapunov_many
    from percuss.explore.orbit_starts import orbit_of, orbit_seeds, switched_seeds
    from percuss.explore.parameters import PARAMETERS, parameters_of, vary
    from percuss.explore.point_curves.following_points import follow_point
    from percuss.explore.quantities import CELL_OUTCOMES, MACHINE_QUANTITIES, QUANTITIES, REASONS, STALLS
    from percuss.explore.sweeps import Sweep, sweep

__all__, __getattr__, __dir__ = lazy_names(__name__, __file__)
