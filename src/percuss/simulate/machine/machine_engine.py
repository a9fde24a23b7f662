"""The loop around the kernels of a machine: calls them stretch by stretch, gathers the events, reports progress."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from percuss.errors import PercussError
from percuss.model.checks import Array
from percuss.model.load.valve import Orders
from percuss.simulate.engine import Progress
from percuss.simulate.kernels.motion_records import (
    AT_REST,
    BY_IMPACTS,
    BY_TIME,
    BY_WORK,
    COUNT,
    CROWDED,
    DEPARTED,
    GRAZED,
    IN_CHAMBER,
    NOW,
    ON_PORT,
    PAST,
    PERIODIC,
    PORT,
    RELEASE,
    RESTING,
    STATE_NUMBERS,
    SUMS,
    TURNING,
    VALVE,
    VALVE_EVENT,
    VALVE_NOW,
    Controls,
    Plant,
    Rules,
    ValveLog,
)
from percuss.simulate.kernels.valve_motion import begin_valve, follow_valve, wanders
from percuss.simulate.machine.machine_events import STALLS, MachineCycle, MachineEvents, machine_label
from percuss.simulate.machine.machine_start import MachineStart, placed, state_and_orders
from percuss.simulate.machine.mechanism import Mechanism
from percuss.simulate.simulated_motion import true, within
from percuss.simulate.stop import Stop
from percuss.simulate.tables import Snapshot, desk_for, to_change

# ---- The memory that the kernels work in: one motion of a machine, and the calls that carry it on

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


# ---- The whole state of a machine's motion between two events, as arrays that are kept, and put back to go on

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


# ---- The loop around the kernels of a machine: calls them stretch by stretch, gathers the events, reports progress

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
        bool(valve["stalled"]) or (not valve["waiting"] and _released_in_vain(events[-1])),
        cycle_of(plant, mechanism),
        bool(wanders(plant.controls)),
        float(valve["time"]) * unit,
        kept(plant),
    )


def ending(stretch: MachineStretch, mechanism: Mechanism, stop: Stop, begin_time: float) -> dict[str, Any]:
    """How a motion ended, by the names of its fields: outcome, label, cycle, the state to go on from, end of time."""
    known, over = stretch.time, stretch.ended in STALLS
    if over and mechanism.spring > 0.0:
        known += 2.0 * math.pi / mechanism.spring  # it goes on for ever
    if stop.time is not None and (stretch.ended == "time" or over):
        known = stop.time
    last = float(stretch.events.time[-1]) if len(stretch.events) else begin_time
    return {
        "outcome": outcome_of(stretch.ended, stretch.stalled),
        "label": machine_label("in the chamber" if stretch.stalled else stretch.ended, stretch.cycle, stretch.wanders),
        "cycle": stretch.cycle,
        "snapshot": stretch.snapshot,
        "end_time": max(begin_time + known, last),
    }


def outcome_of(ended: str, stalled: bool) -> str:
    """The outcome of a motion: a stall that is proved stays one, however far its last blows are followed."""
    return "stalls" if ended in STALLS or (stalled and ended in ("impacts", "time", "work")) else ended


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


def _released_in_vain(events: MachineEvents) -> bool:
    """Whether the valve heard nothing since the last release but one: what begins at rest then repeats itself."""
    releases = np.flatnonzero(events.code == RELEASE)
    return releases.size > 1 and not np.isin(events.code[releases[-2] :], (PORT, VALVE)).any()


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
