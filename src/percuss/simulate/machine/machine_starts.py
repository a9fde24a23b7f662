"""Many starts of one machine at once, as columns."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from percuss.errors import ParameterError
from percuss.model.checks import instance, numbers, several, text
from percuss.shown import Shown
from percuss.simulate.machine.machine_start import MachineStart
from percuss.simulate.starts import Starts

__all__ = ["MachineStarts"]


@dataclass(frozen=True)
class MachineStarts(Shown):
    """Starts of many motions of a machine that switches its own valve: the bars, and the state of the valve of each.

    No orders wait, and the ports whose region is occupied demand at once.

    Parameters
    ----------
    bars
        Displacements and velocities of the bars; a machine has no clock, so that their times only say when a motion
        begins.
    state
        The number of each valve's state, in the order of `states`, shape (starts,); or one for all.
    states
        The names of the states.

    Raises
    ------
    ParameterError
        When an argument is none of these, for another number of states than starts, or a state that there is not.

    Examples
    --------
    >>> from percuss.simulate import MachineStarts, Starts
    >>> starts = MachineStarts(Starts.rigid([-0.2, -0.9]), [0, 1], ("return", "power"))
    >>> [start.state for start in starts]
    ['return', 'power']
    """

    bars: Starts
    state: npt.NDArray[np.int64]
    states: tuple[str, ...]

    def __post_init__(self) -> None:
        names = tuple(text("states", name) for name in several("states", self.states, "the names of the states"))
        given = numbers("state", self.state, "numbers of states")
        shape = (len(instance("bars", self.bars, Starts)),)
        if given.shape not in ((), shape):
            raise ParameterError("state", f"shape {given.shape}", f"one for each of the {shape[0]} starts, or one")
        found = np.array(np.broadcast_to(given, shape), dtype=np.int64)
        if not names or np.any(found != given) or np.any((found < 0) | (found >= len(names))):
            raise ParameterError("state", self.state, f"whole numbers from 0 to {len(names) - 1}")
        found.setflags(write=False)
        object.__setattr__(self, "states", names)
        object.__setattr__(self, "state", found)

    def __len__(self) -> int:
        return len(self.bars)

    def __getitem__(self, i: int) -> MachineStart:
        return MachineStart(self.bars[i], self.states[int(self.state[i])])

    def __iter__(self) -> Iterator[MachineStart]:
        return (self[i] for i in range(len(self)))
