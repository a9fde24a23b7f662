"""The loop around the kernels of a machine: calls them stretch by stretch, gathers the events, reports progress."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from percuss.model.checks import Array
from percuss.simulate.engine import Progress
from percuss.simulate.kernels.calls import STATE_NUMBERS, Rules
from percuss.simulate.kernels.codes import (
    AT_REST,
    BY_IMPACTS,
    BY_TIME,
    BY_WORK,
    CROWDED,
    DEPARTED,
    IN_CHAMBER,
    ON_PORT,
    PERIODIC,
    PORT,
)
from percuss.simulate.kernels.valve_motion import follow_valve, wanders
from percuss.simulate.kernels.valve_records import VALVE_EVENT, Plant, ValveLog
from percuss.simulate.machine.machine_events import MachineEvents
from percuss.simulate.machine.machine_snapshot import kept
from percuss.simulate.machine.machine_summary import STALLS, MachineCycle, machine_label
from percuss.simulate.machine.mechanism import Mechanism
from percuss.simulate.machine.plant import NO_VALVE_LOG, roomier
from percuss.simulate.stop import Stop

__all__ = ["ENDS", "MachineStretch", "Room", "carried_on", "cycle_of", "ending", "followed", "room_for"]

_STRIDE = 1 << 24  # modes times evaluations between two looks at the outside
_MOST_MEMORY = 1 << 30  # bytes of recorded events and states
_MANY_STRIDES = 4096  # … of a motion that is not recorded
_MOST_NUMBERS, _MOST_ROWS = 1 << 23, 1 << 15  # of the states of a stretch
_EVENTS = 6  # of a blow: itself, two ports, two changes of the valve, and one more
_TOO_MANY = 16  # such strides without an event end a simulation
ENDS = {
    BY_IMPACTS: "impacts",
    BY_TIME: "time",
    PERIODIC: "periodic",
    AT_REST: "on the tool",
    IN_CHAMBER: "in the chamber",
    ON_PORT: "on a port",
    DEPARTED: "leaves",
}
"""What the kernels' ends are called; of a stall, where."""


@dataclass(frozen=True)
class Room:
    """Where a motion is recorded: the kernel's log, and `states`, that of the start and after it those of the log."""

    log: ValveLog
    states: Array


@dataclass(frozen=True)
class MachineStretch:
    """What a simulation gave: its events, why it ended, and what its last changes look like.

    `states`: at the start and after each event. `stalled`: whether it has been proved that only ever weaker blows can
    follow. `snapshot`: what goes on from there.
    """

    events: MachineEvents
    states: Array
    ended: str
    stalled: bool
    cycle: MachineCycle | None
    wanders: bool
    time: float
    snapshot: dict[str, npt.NDArray[Any]]


def followed(
    plant: Plant,
    mechanism: Mechanism,
    stop: Stop,
    room: Room,
    begin_time: float,
    progress: Callable[[Progress], object] | None = None,
) -> MachineStretch:
    """The motion of a plant on until the stop rule holds; the log may have events of its start in it."""
    count, valve, unit = plant.motion.count, plant.controls.now, mechanism.unit
    time = np.inf if stop.time is None else stop.time / unit
    stride, log = _STRIDE // (mechanism.modes + 30), room.log
    events: list[MachineEvents] = []
    states: list[Array] = []
    ended, idle, recorded, first = "", 0, 0, 0
    while not ended:
        budget = (int(count["work"]) // stride + 1) * stride
        rules = Rules(np.inf, time, stop.most_impacts, stop.periodic, stop.tolerance, 0, budget)
        code, plant = _went_on(plant, rules, log)
        n = int(count["events"])
        ended, recorded = ENDS.get(code, ""), recorded + n * (log.events.itemsize + 8 * log.states.shape[1])
        idle = idle + 1 if code == BY_WORK and not n else 0
        if recorded > _MOST_MEMORY and not ended:
            ended = "memory"
        if idle > _TOO_MANY or (code == BY_WORK and not ended and int(count["work"]) < budget):
            ended = "work"
        events.append(_events(log.events[:n], mechanism, begin_time))
        states.append(room.states[first : 1 + n])
        count["events"] = 0
        if progress is not None and not ended:
            gone = float(valve["time"]) * unit
            fraction = int(count["impacts"]) / max(stop.most_impacts, 1)
            if stop.time is not None:
                fraction = max(fraction, gone / stop.time)
            if progress(Progress(int(count["impacts"]), gone, min(fraction, 1.0))):
                ended = "cancelled"
        if not ended:  # else what was recorded last stays where it is
            states[-1], first = states[-1].copy(), 1
    record = states[0] if len(states) == 1 else np.concatenate(states)
    return MachineStretch(
        MachineEvents.of_all(events),
        record.copy() if 4 * record.size < room.states.size else record,
        ended,
        bool(valve["stalled"]),
        cycle_of(plant, mechanism),
        bool(wanders(plant.controls)),
        float(valve["time"]) * unit,
        kept(plant),
    )


def ending(stretch: MachineStretch, mechanism: Mechanism, stop: Stop, begin_time: float) -> dict[str, Any]:
    """How a motion ended, by the names of its fields: outcome, label, cycle, the state to go on from, end of time."""
    known, stalls = stretch.time, stretch.ended in STALLS
    if stalls and mechanism.spring > 0.0:
        known += 2.0 * math.pi / mechanism.spring  # it goes on for ever
    if stop.time is not None and (stretch.ended == "time" or stalls):
        known = stop.time
    last = float(stretch.events.time[-1]) if len(stretch.events) else begin_time
    return {
        "outcome": "stalls" if stalls else stretch.ended,
        "label": machine_label("in the chamber" if stretch.stalled else stretch.ended, stretch.cycle, stretch.wanders),
        "cycle": stretch.cycle,
        "snapshot": stretch.snapshot,
        "end_time": max(begin_time + known, last),
    }


def carried_on(plant: Plant, mechanism: Mechanism, stop: Stop, stopped: Callable[[], bool]) -> tuple[str, bool]:
    """A motion of which nothing is recorded, to its end: how it ended, and whether its last changes wander."""
    count, stride = plant.motion.count, _STRIDE // (mechanism.modes + 30)
    time = np.inf if stop.time is None else stop.time / mechanism.unit
    for tries in range(1, _MANY_STRIDES + 1):
        rules = Rules(np.inf, time, stop.most_impacts, stop.periodic, stop.tolerance, 0, tries * stride)
        code, plant = _went_on(plant, rules, NO_VALVE_LOG)
        ended = ENDS.get(code, "")
        if ended or int(count["work"]) < tries * stride or stopped():
            return ended or ("cancelled" if stopped() else "work"), bool(wanders(plant.controls))
    return "work", bool(wanders(plant.controls))


def _went_on(plant: Plant, rules: Rules, log: ValveLog) -> tuple[int, Plant]:
    """The motion on, with room for all orders that come to wait: how it ended, and the plant with that room."""
    code = follow_valve(plant, rules, log)
    while code == CROWDED:
        plant = roomier(plant)
        code = follow_valve(plant, rules, log)
    return code, plant


def room_for(mechanism: Mechanism, stop: Stop) -> Room:
    """Room for the record of a whole motion, or of a stretch: memory that nothing is written into costs nothing."""
    width, ports = 2 * mechanism.modes + STATE_NUMBERS, mechanism.gear.to.size
    rows = max(64, min(_MOST_NUMBERS // width, _MOST_ROWS, _EVENTS * (stop.most_impacts + 16))) + 2 * ports
    states = np.empty((1 + rows, width))
    return Room(ValveLog(np.empty(rows, VALVE_EVENT), states[1:]), states)


def cycle_of(plant: Plant, mechanism: Mechanism) -> MachineCycle | None:
    """The cycle that was found, in the machine's unit of time."""
    valve, unit = plant.controls.now, mechanism.unit
    if valve["confirmed"] < 2:
        return None
    return MachineCycle(
        first=int(valve["found_at"]),
        blows=int(valve["cycle_blows"]),
        valve_cycles=int(valve["cycle_turns"]),
        kind=int(valve["cycle_kind"]),
        period=float(valve["period"]) * unit,
        energy_lost=float(valve["cycle_taken"]) / unit**2,
        blow_speed=float(valve["cycle_speed"]) / unit,
    )


def _events(log: np.ndarray[tuple[int], np.dtype[np.void]], mechanism: Mechanism, begin_time: float) -> MachineEvents:
    unit = mechanism.unit
    ports = log["kind"] == PORT
    return MachineEvents(
        code=log["kind"].astype(np.int8),
        time=begin_time + log["time"] * unit,
        velocity=log["before"] / unit,
        rebound_velocity=log["after"] / unit,
        energy_lost=log["lost"] / unit**2,
        kinetic_energy=log["kinetic"] / unit**2,
        state=log["state"].copy(),
        port=np.where(ports, log["detail"], -1),
        resolved=np.where(ports, 0, log["detail"]),
        states=tuple(mechanism.states()),
    )
