"""A motion of a machine followed further, with the same bits as if it had never been interrupted."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from percuss.model.checks import Array
from percuss.notebook import watched
from percuss.simulate.engine import Progress
from percuss.simulate.machine.machine_engine import ending, followed, room_for
from percuss.simulate.machine.machine_events import MachineEvents
from percuss.simulate.machine.machine_snapshot import put_back
from percuss.simulate.machine.mechanism import Mechanism
from percuss.simulate.stop import Stop

__all__ = ["ended_later"]


class _Motion(Protocol):
    """What is asked of a motion; a `MachineTrajectory` has it."""

    @property
    def mechanism(self) -> Mechanism: ...
    @property
    def events(self) -> MachineEvents: ...
    @property
    def states(self) -> Array: ...
    @property
    def begin_time(self) -> float: ...
    @property
    def snapshot(self) -> dict[str, npt.NDArray[Any]]: ...


def ended_later(motion: _Motion, stop: Stop, progress: Callable[[Progress], object] | None = None) -> dict[str, Any]:
    """What `MachineTrajectory.continued` has otherwise than the motion it goes on from, by the names of fields."""
    numbers = motion.mechanism
    plant, room = put_back(motion.snapshot, numbers), room_for(numbers, stop)
    room.states[0] = motion.states[-1]
    with watched(progress) as watch:
        stretch = followed(plant, numbers, stop, room, motion.begin_time, watch)
    return {
        "events": MachineEvents.of_all([motion.events, stretch.events]),
        "states": np.concatenate([motion.states, stretch.states[1:]]),
        "stop": stop,
        **ending(stretch, numbers, stop, motion.begin_time),
    }
