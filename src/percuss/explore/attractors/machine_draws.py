"""Where the motions of machines in an experiment start: the named distributions, and one's own table."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from percuss.errors import ParameterError
from percuss.explore.attractors.own_starts import table_of, table_starts
from percuss.explore.attractors.start_distributions import (
    FIELD_DEPTH,
    FIELD_SPEED,
    GENTLE_SPEED,
    blocks,
    checked_name,
)
from percuss.model.checks import Array

if TYPE_CHECKING:
    from percuss.model import Machine
    from percuss.simulate import MachineStarts

__all__ = ["GENTLE_SHARE", "drawn_machines", "farthest_port", "own_machines", "speed_scale"]

GENTLE_SHARE = 0.05
"""The greatest speed of ``gentle`` starts, over the machine's scale of speeds."""

_TURN = 2.0 * np.pi


def farthest_port(machine: Machine) -> float:
    """Distance of the farthest port behind the wall; one bar length where every port is the blow."""
    return max((port.behind for port in machine.valve.ports if port.behind is not None), default=1.0)


def speed_scale(machine: Machine) -> float:
    """√(2 Δp S): what the difference of the valve's forces makes of rest on the way from the farthest port.

    By the work of the switches it is the speed of the blow without delay, drag and restitution; 0 for one force alone.
    """
    forces = [force for _, force in machine.valve.pairs]
    return math.sqrt(2.0 * (max(forces) - min(forces)) * farthest_port(machine))


def drawn_machines(machine: Machine, distribution: str, number: int, seed: int, first: int = 0) -> MachineStarts:
    """Starts of a machine drawn from a named distribution; which they are does not depend on how many are drawn.

    With S the distance of the farthest port and V = √(2 Δp S), see `speed_scale`, all with a state of the valve that is
    one of its states at random:

    ``wall``
        On the wall, leaving with the speed \\|N(0, 1)\\|·V.
    ``field``
        Position uniform in [−2S, 0], velocity V·N(0, 1).
    ``gentle``
        On the wall, leaving with a speed uniform in (0, V/20).

    All are rigid, with the elastic modes at rest; no orders wait, and ports whose region is occupied demand at once.

    Raises
    ------
    ParameterError
        For an unknown name, or starts on the wall of a machine whose states all push alike: they have no scale.

    Examples
    --------
    >>> from percuss.model import Kept, Machine, Port, UniformBar, Valve
    >>> ports = [Port("power", behind=1.0, side="back"), Port("return", on="impact")]
    >>> machine = Machine(UniformBar(20.0), Valve({"return": -0.4, "power": 1.6}, ports), Kept(0.2))
    >>> starts = drawn_machines(machine, "field", 1000, seed=1)
    >>> len(starts), bool((starts.bars.gap >= -2.0).all()), sorted(set(starts.state.tolist()))
    (1000, True, [0, 1])
    """
    from percuss.simulate import MachineStarts, Starts

    checked_name(distribution)
    position, velocity, turn = blocks(distribution, number, seed, first)
    speed, names = speed_scale(machine), tuple(name for name, _ in machine.valve.pairs)
    if speed == 0.0 and distribution != "field":
        accepted = "a valve whose states have different forces"
        raise ParameterError("distribution", distribution, accepted, "use 'field', or a file of starts")
    unit = {"wall": 1.0, "field": 1.0 / FIELD_SPEED, "gentle": GENTLE_SHARE / GENTLE_SPEED}[distribution]
    state = np.minimum(turn / _TURN * len(names), len(names) - 1).astype(np.int64)
    place = 2.0 * farthest_port(machine) / FIELD_DEPTH * position
    return MachineStarts(Starts.rigid(place, speed * unit * velocity), state, names)


def own_machines(machine: Machine, source: Any, seed: int) -> MachineStarts:
    """The rows of one's own distribution; as `percuss.explore.attractors.start_distributions.own`.

    Instead of a load phase a table has the column ``state``: the name of the valve's state or its number from 0.
    Without it all start with the valve's own starting state. `Starts` and `MachineStarts` are taken as they are.

    Raises
    ------
    ParameterError
        For a file that cannot be read or has unknown columns, a state that the valve does not have, and for a function
        that gives no starts.
    """
    from percuss.simulate import MachineStarts, Starts

    names = tuple(name for name, _ in machine.valve.pairs)
    if callable(source) and not isinstance(source, Starts | MachineStarts):
        source = source(seed)
        if not isinstance(source, Starts | MachineStarts):
            raise ParameterError("what the distribution gives", source, "a Starts or a MachineStarts")
    usual = names.index(machine.valve.start or names[0])
    if isinstance(source, Starts):
        return MachineStarts(source, np.array(usual), names)
    if isinstance(source, MachineStarts):
        if source.states != names:
            raise ParameterError("distribution", f"starts with states {', '.join(source.states)}", _one_of(names))
        return source
    file, columns = table_of(source, names)
    if "time" in columns:
        remedy = f"no clock drives it: remove the column; 'state' is one of {', '.join(names)}"
        raise ParameterError(file, "column 'time'", "starts of a machine that switches its own valve", remedy)
    given = columns.pop("state", None)
    bars = table_starts(machine.body, machine.at, file, columns, "state")
    state = np.full(len(bars), float(usual)) if given is None else given
    return MachineStarts(bars, _numbers(file, state, len(bars), names), names)


def _numbers(file: str, state: Array, rows: int, names: tuple[str, ...]) -> npt.NDArray[np.int64]:
    """Numbers of states, of a column of a file."""
    if state.size != rows:
        raise ParameterError(file, f"{state.size} states of {rows} starts", "columns of one length")
    wrong = np.flatnonzero(~np.isin(state, np.arange(len(names))))
    if wrong.size:
        raise ParameterError(file, f"state in row {wrong[0] + 1}", f"{_one_of(names)}, or its number from 0")
    return state.astype(np.int64)


def _one_of(names: tuple[str, ...]) -> str:
    return f"one of {', '.join(map(repr, names[:6]))}"
