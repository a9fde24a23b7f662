"""The memory that the kernels work in: one motion of a machine, and the calls that carry it on."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from percuss.model.load.valve import Orders
from percuss.simulate.kernels.codes import RESTING
from percuss.simulate.kernels.valve_changes import begin_valve
from percuss.simulate.kernels.valve_records import TURNING, VALVE_EVENT, VALVE_NOW, Controls, Plant, ValveLog
from percuss.simulate.machine.machine_start import MachineStart, placed, state_and_orders
from percuss.simulate.machine.mechanism import Mechanism
from percuss.simulate.snapshot import Snapshot, desk_for
from percuss.simulate.tables import to_change

__all__ = ["NO_VALVE_LOG", "begun", "plant_of", "roomier", "row_of"]

_QUEUE = 256  # orders that wait for which there is room at first
_WINDOW = 64  # last changes of the valve that are kept
NO_VALVE_LOG = ValveLog(np.empty(0, VALVE_EVENT), np.empty((0, 0)))
"""For motions of which nothing is recorded."""


def plant_of(mechanism: Mechanism, start: MachineStart | None = None) -> Plant:
    """A machine, and room for a motion of it, with the orders that wait at a start: nothing of it is shared."""
    table, alone = map(to_change, mechanism.tables)
    gear = mechanism.gear
    ports, n = gear.to.size, mechanism.modes
    waiting = 0 if start is None or start.orders is None else len(start.orders.pending)
    queue = _QUEUE
    while queue < waiting + ports:
        queue *= 2
    controls = Controls(
        np.zeros(1, VALVE_NOW)[0],
        np.zeros(gear.forces.size),
        np.zeros(ports),
        np.zeros(queue),
        np.zeros(queue, dtype=np.int64),
        np.zeros(ports),
        np.zeros(ports, dtype=np.int64),
        np.zeros(ports, dtype=np.int64),
        np.zeros((2, n)),
        np.zeros(queue),
        np.zeros(_WINDOW, TURNING),
    )
    motion, eye, spot = (Snapshot.empty(size, 1).motion for size in (n, n, 0))
    return Plant(table, alone, gear, motion, eye, spot, desk_for(table), desk_for(alone), controls)


def roomier(plant: Plant) -> Plant:
    """The same plant with room for twice as many orders that wait; all else is shared."""
    controls = plant.controls

    def grown(row: npt.NDArray[Any]) -> npt.NDArray[Any]:
        return np.concatenate([row, np.zeros_like(row)])

    return plant._replace(
        controls=controls._replace(
            due=grown(controls.due), order=grown(controls.order), memo_due=grown(controls.memo_due)
        )
    )


def begun(plant: Plant, mechanism: Mechanism, start: MachineStart, log: ValveLog) -> bool:
    """The motion of a plant put at a start; whether it rests on the wall there.

    Raises
    ------
    ParameterError
        For a state that the valve does not have, a start beyond the wall, or one with more modes.
    """
    machine, unit = mechanism.machine, mechanism.unit
    state, orders = state_and_orders(start, machine)
    u, v, gap = placed(start, machine, mechanism.modes)
    names, valve = mechanism.states(), plant.controls.now
    valve["state"], valve["last"] = names.index(state), names.index(orders.last)
    _wait(plant, orders, names, unit)
    resting = gap == 0.0 and not v.any() and not u.any()
    displacement, rate = mechanism.ends(u), mechanism.ends(v) * unit
    begin_valve(plant, displacement, rate, resting, gap == 0.0, start.orders is None, log)
    return bool(plant.motion.count["mode"] == RESTING)


def _wait(plant: Plant, orders: Orders, names: list[str], unit: float) -> None:
    controls, pending = plant.controls, orders.pending
    controls.now["waiting"] = len(pending)
    for i, (time, to) in enumerate(pending):
        controls.due[i], controls.order[i] = time / unit, names.index(to)


def row_of(plant: Plant) -> npt.NDArray[np.float64]:
    """The state at the anchor, as the record has it."""
    now = plant.motion.now
    return np.concatenate([[now["gap"], now["rigid_rate"]], plant.motion.z.reshape(-1)])
