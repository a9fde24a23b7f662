"""A saved motion of either kind: of a system under a clock, or of a machine that switches its own valve."""

from __future__ import annotations

import os

from percuss.simulate.machine.machine_trajectory import MACHINE_FORMAT, MachineTrajectory
from percuss.simulate.machine.machine_trajectory import motion_from as machine_motion_from
from percuss.simulate.motion_files import motion_from, opened
from percuss.simulate.trajectory import Trajectory


def saved_motion(path: str | os.PathLike[str]) -> Trajectory | MachineTrajectory:
    """The motion in a NetCDF file, by what the file says it is.

    Raises
    ------
    PercussError
        When the file cannot be read or holds no motion.
    """
    name, dataset = opened(path)
    if dataset.attrs.get("format") == MACHINE_FORMAT:
        return MachineTrajectory(**machine_motion_from(name, dataset))
    return motion_from(name, dataset, Trajectory)
