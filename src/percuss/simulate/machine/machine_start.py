"""Where a motion of a machine starts: the bar, and its valve."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import numpy.typing as npt

from percuss.errors import ParameterError
from percuss.model import Load, Machine, System
from percuss.model.checks import Array, instance, numbers, several, text
from percuss.model.load.valve import Orders
from percuss.shown import Shown
from percuss.simulate.start import Start, Starts

ON_THE_WALL = Start.rigid(position=0.0)


@dataclass(frozen=True)
class MachineStart(Shown):
    """The start of a motion of a machine.

    Parameters
    ----------
    bar
        Displacement and velocity of the bar: a `Start`, whose time is the time at which the motion begins. At rest on
        the wall by default.
    state
        The state of the valve; that with which the valve starts by default.
    orders
        The last demand, and the orders that wait, by the time that is left to each. None by default: there are no
        orders, the state was the last demand, and ports whose region is occupied demand at once, in their order.
        Where orders are given the ports have demanded before.

    Examples
    --------
    >>> from percuss.simulate import MachineStart, Start
    >>> MachineStart(Start.rigid(-0.3), state="power").state
    'power'
    """

    bar: Start = ON_THE_WALL
    state: str | None = None
    orders: Orders | None = None

    def __post_init__(self) -> None:
        instance("bar", self.bar, Start)
        if self.state is not None:
            text("state", self.state, "the name of a state")
        if self.orders is not None:
            orders = instance("orders", self.orders, Orders)
            times = [time for time, _ in orders.pending]
            if any(time < 0.0 for time in times) or times != sorted(times):
                raise ParameterError("orders", orders, "orders that are due from now on, in order")


def state_and_orders(start: MachineStart, machine: Machine) -> tuple[str, Orders]:
    """The state of the valve, and the orders, of a machine that has these states.

    Raises
    ------
    ParameterError
        When it has not.
    """
    names = [name for name, _ in machine.valve.pairs]
    state = machine.valve.start if start.state is None else start.state
    orders = Orders(state or names[0]) if start.orders is None else start.orders
    for name in (state, orders.last, *(to for _, to in orders.pending)):
        if name not in names:
            raise ParameterError("state", name, f"one of {', '.join(map(repr, names[:6]))}")
    assert state is not None
    return state, orders


def placed(start: MachineStart, machine: Machine, modes: int) -> tuple[Array, Array, float]:
    """B77's u_n and u_n', each of shape (modes+1,), and the gap; see `Start.state`."""
    return start.bar.state(modes, _still(machine))


@lru_cache(maxsize=16)
def _still(machine: Machine) -> System:
    """The bar of a machine under no load: whose modes the amplitudes are."""
    return System(machine.body, Load(np.array([0.0]), at=machine.at), machine.contact)


# ---- Many starts of one machine at once, as columns


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
