"""The whole state of a machine's motion between two events, as arrays that are kept, and put back to go on."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from percuss.errors import PercussError
from percuss.simulate.kernels.codes import GRAZED
from percuss.simulate.kernels.layout import COUNT, NOW, PAST, SUMS
from percuss.simulate.kernels.valve_records import TURNING, VALVE_NOW, Plant
from percuss.simulate.machine.mechanism import Mechanism
from percuss.simulate.machine.plant import plant_of, roomier
from percuss.simulate.soundness import true, within

__all__ = ["KINDS", "kept", "put_back"]

KINDS = {"now": NOW, "count": COUNT, "past": PAST, "sums": SUMS, "valve_now": VALVE_NOW, "valve_past": TURNING}
"""The types of those arrays that hold records."""

_OF_MOTION = ("z", "now", "count", "anchor", "past", "sums")
_OF_VALVE = ("now", "usual", "usual_cross", "due", "order", "cross", "kind", "just", "memo", "memo_due", "past")

Kept = dict[str, npt.NDArray[Any]]


def kept(plant: Plant) -> Kept:
    """All that the next event depends on, by name; copies."""
    found = {name: np.array(getattr(plant.motion, name), ndmin=1) for name in _OF_MOTION}
    return found | {f"valve_{name}": np.array(getattr(plant.controls, name), ndmin=1) for name in _OF_VALVE}


def put_back(snapshot: Kept, mechanism: Mechanism) -> Plant:
    """A machine whose motion stands where a snapshot was taken.

    Raises
    ------
    PercussError
        When a simulation cannot have left it: it comes from a file that was changed, or made up.
    """
    plant = plant_of(mechanism)
    while plant.controls.due.size < np.size(snapshot.get("valve_due", ())):
        plant = roomier(plant)
    try:
        for name, room in kept(plant).items():
            given = snapshot.get(name)
            true(given is not None, f"that there is no engine_{name}")
            assert given is not None
            true(given.dtype == room.dtype and given.shape == room.shape, f"the type or shape of engine_{name}")
            whose = plant.controls if name.startswith("valve_") else plant.motion
            _fill(getattr(whose, name.removeprefix("valve_")), given)
        _check(plant, len(mechanism.states()))
    except ValueError as error:
        told = f"the state to continue from is damaged: {error}"
        raise PercussError(told, "use a copy of its file, or simulate again") from None
    return plant


def _fill(into: Any, values: npt.NDArray[Any]) -> None:
    """The same memory with other numbers: the views of it stay."""
    if isinstance(into, np.void):
        for field in values.dtype.names or ():
            into[field] = values[0][field]
    else:
        into[...] = values


def _check(plant: Plant, states: int) -> None:
    """Whole numbers that the kernels use as places in arrays are places in them."""
    valve, controls, count = plant.controls.now, plant.controls, plant.motion.count
    for name in ("state", "last", "memo_state", "memo_last"):
        within(name, valve[name], 0, states - 1)
    for name in ("waiting", "memo_waiting"):
        within(name, valve[name], 0, controls.due.size)
    within("order", controls.order, 0, states - 1)
    within("mode", count["mode"], 0, GRAZED)
    true(count["events"] == 0, "a number of events")
    within("changes", valve["changes"], 0, 2**62)
    true(bool(np.isfinite(plant.motion.z).all()) and np.isfinite(plant.motion.now["gap"]), "a number of the state")
