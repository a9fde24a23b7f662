"""The loop around the kernels: calls them stretch by stretch, gathers the events, reports progress."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from percuss.model.checks import Array
from percuss.simulate.events import Events
from percuss.simulate.kernels.calls import EVENT, MEMBER, STATE_NUMBERS, Log, Rules
from percuss.simulate.kernels.codes import AT_REST, BY_IMPACTS, BY_TIME, BY_WORK, DEPARTED, PERIODIC, UNRESOLVED
from percuss.simulate.kernels.layout import PAST, Table
from percuss.simulate.kernels.many import follow as follow_compiled
from percuss.simulate.snapshot import NO_LOG, Snapshot, begins, clock, desk_for
from percuss.simulate.stop import Stop
from percuss.simulate.tables import to_change

__all__ = ["ENDS", "Progress", "Stretch", "follow"]

_STRIDE = 1 << 24  # modes times evaluations between two looks at the outside
_MOST_MEMORY = 1 << 30  # bytes of recorded events and states
_TOO_MANY = 64  # such strides without an impact end a simulation
ENDS = {
    BY_IMPACTS: "impacts",
    BY_TIME: "time",
    AT_REST: "rest",
    PERIODIC: "periodic",
    DEPARTED: "departed",
    UNRESOLVED: "unresolved",
}
"""What the kernels' ends are called."""

# of a motion that goes on by itself
_NOWHERE = begins(*np.empty((2, 0, 1)), *np.empty((2, 0)), *np.empty((2, 0), dtype=np.int64))
_GOES_ON, _NO_TAIL = np.zeros(1, dtype=np.int64), np.empty((1, 0), PAST)


@dataclass(frozen=True)
class Progress:
    """How far a simulation has come.

    Attributes
    ----------
    impacts
        From the start.
    time
        From the start, in radians.
    fraction
        0 to 1: of the impacts or the time asked for, whichever is nearer.
    """

    impacts: int
    time: float
    fraction: float


@dataclass(frozen=True)
class Stretch:
    """What a stretch of simulation gave: its events, the states after them, where it stands, and why it ended.

    `wanders`: whether its last impacts do not come near any of the ones before.
    """

    events: Events
    states: Array
    snapshot: Snapshot
    outcome: str
    wanders: bool


def follow(
    table: Table,
    snapshot: Snapshot,
    stop: Stop,
    begin_time: float,
    progress: Callable[[Progress], object] | None = None,
    skip: int = 0,
) -> Stretch:
    """The motion from a snapshot on until the stop rule holds; the snapshot itself is left alone.

    `skip`: impacts that the running sums leave out.
    """
    state, modes = snapshot.copy(), table.modes.omega.size
    room = max(64, min((1 << 20) // (2 * modes + 2), stop.most_impacts - state.impacts + 16, 4096))
    log = Log(np.empty(room, EVENT), np.empty((room, STATE_NUMBERS + 2 * modes)))
    own = to_change(table)
    motion, twin, desk, count = state.motion, state.copy().motion, desk_for(table), state.count[0]
    if table.values.size:
        own.bar["mean"] = table.values[count["piece"]]
    found = np.zeros(1, MEMBER)
    ends = np.array([[math.inf, 0.0] if stop.time is None else clock(begin_time + stop.time)])
    stride, row = _STRIDE // (modes + 30), EVENT.itemsize + log.states.itemsize * log.states.shape[1]
    events: list[Events] = []
    after: list[Array] = []
    tired, tired_at, outcome, recorded = 0, -1, "", 0
    while not outcome:
        count["events"] = 0
        budget = (int(count["work"]) // stride + 1) * stride
        rules = Rules(np.inf, 0.0, stop.most_impacts, stop.periodic, stop.tolerance, skip, budget)
        follow_compiled(own, _NOWHERE, ends, rules, motion, twin, desk, log, NO_LOG, _GOES_ON, found, _NO_TAIL)
        code = int(found["ended"][0])
        n = int(count["events"])
        outcome, recorded = ENDS.get(code, ""), recorded + n * row
        if recorded > _MOST_MEMORY and not outcome:
            outcome = "memory"
        if code == BY_WORK:
            tired = tired + 1 if state.impacts == tired_at else 1
            tired_at = state.impacts
            if tired > _TOO_MANY:
                outcome = "work"
        if progress is not None and progress(_progress(state, stop, begin_time)) and not outcome:
            outcome = "cancelled"
        events.append(_events(log.events[:n]))
        after.append(log.states[:n] if outcome else log.states[:n].copy())
    count["events"] = 0
    return Stretch(
        Events.of_all(events),
        after[0] if len(after) == 1 else np.concatenate(after),
        state,
        outcome,
        bool(found["wanders"][0]),
    )


def _progress(state: Snapshot, stop: Stop, begin_time: float) -> Progress:
    gone = state.time - begin_time
    fraction = state.impacts / max(stop.most_impacts, 1)
    if stop.time is not None:
        fraction = max(fraction, gone / stop.time)
    return Progress(state.impacts, gone, min(fraction, 1.0))


def _events(log: npt.NDArray[Any]) -> Events:
    return Events(
        code=log["kind"].astype(np.int8),
        period=log["period"].copy(),
        phase=log["phase"].copy(),
        impact_velocity=log["before"].copy(),
        rebound_velocity=log["after"].copy(),
        energy_lost=log["lost"].copy(),
        kinetic_energy=log["kinetic"].copy(),
        resolved=log["resolved"].copy(),
        piece=log["piece"].copy(),
    )
