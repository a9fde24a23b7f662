"""Pictures of results: draws result objects, computes nothing; matplotlib is imported when first drawn."""

from __future__ import annotations

from typing import TYPE_CHECKING

from percuss.lazy_names import lazy_names

if TYPE_CHECKING:
    from percuss.plot.blow_picture import best, blow, by_waves, repeated
    from percuss.plot.branch_picture import branch, curves, diagram
    from percuss.plot.canvas import save
    from percuss.plot.machine_picture import machine, machine_motion
    from percuss.plot.map_picture import basins, experiment, sweep
    from percuss.plot.steady_picture import steady
    from percuss.plot.trajectory_picture import trajectory
    from percuss.plot.whole_hammer_pictures import comparison, design_plane, identify, tolerance

__all__, __getattr__, __dir__ = lazy_names(__name__, __file__)
