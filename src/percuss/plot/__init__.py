"""Pictures of results: draws result objects, computes nothing; matplotlib is imported when first drawn."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from percuss.plot.blow_picture import best, blow
    from percuss.plot.branch_picture import branch, curves, diagram, rest_branch
    from percuss.plot.canvas import save
    from percuss.plot.machine_picture import machine, machine_motion
    from percuss.plot.map_picture import sweep
    from percuss.plot.starts_picture import basins, experiment
    from percuss.plot.steady_picture import steady
    from percuss.plot.trajectory_picture import trajectory

__all__ = [
    "basins", "best", "blow", "branch", "curves", "diagram", "experiment", "machine", "machine_motion",
    "rest_branch", "save", "steady", "sweep", "trajectory",
]  # fmt: skip


_HOME = {
    "basins": "starts_picture",
    "best": "blow_picture",
    "blow": "blow_picture",
    "branch": "branch_picture",
    "curves": "branch_picture",
    "diagram": "branch_picture",
    "experiment": "starts_picture",
    "machine": "machine_picture",
    "machine_motion": "machine_picture",
    "rest_branch": "branch_picture",
    "save": "canvas",
    "steady": "steady_picture",
    "sweep": "map_picture",
    "trajectory": "trajectory_picture",
}


def __getattr__(name: str) -> object:
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOME[name]}"), name)


def __dir__() -> list[str]:
    return sorted(__all__)
