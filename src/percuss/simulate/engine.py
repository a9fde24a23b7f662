"""The loop around the kernels: calls them stretch by stretch, gathers the events, reports progress."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, fields

import numpy as np
import numpy.typing as npt

from percuss.model.checks import Array
from percuss.simulate import kernels as kn
from percuss.simulate.events import Events
from percuss.simulate.snapshot import Snapshot, clock
from percuss.simulate.stop import Stop
from percuss.simulate.tables import Tables

__all__ = ["ENDS", "Progress", "Stretch", "follow"]

_STRIDE = 1 << 24  # modes times evaluations between two looks at the outside
_MOST_MEMORY = 1 << 30  # bytes of recorded events and states
_TOO_MANY = 64  # such strides without an impact end a simulation
ENDS = {
    kn.BY_IMPACTS: "impacts",
    kn.BY_TIME: "time",
    kn.AT_REST: "rest",
    kn.PERIODIC: "periodic",
    kn.DEPARTED: "departed",
    kn.UNRESOLVED: "unresolved",
}
"""What the kernels' ends are called."""


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
    """What a stretch of simulation gave: its events, the states after them, where it stands, and why it ended."""

    events: Events
    states: Array
    snapshot: Snapshot
    outcome: str


def follow(
    tables: Tables,
    snapshot: Snapshot,
    stop: Stop,
    begin_time: float,
    progress: Callable[[Progress], object] | None = None,
) -> Stretch:
    """The motion from a snapshot on until the stop rule holds; the snapshot itself is left alone."""
    state, modes = snapshot.copy(), tables.mode.shape[1]
    room = int(np.clip(min((1 << 20) // (2 * modes + 2), stop.most_impacts - state.impacts + 16), 64, 4096))
    numbers, wholes = np.empty((room, kn.EVENT_NUMBERS)), np.empty((room, kn.EVENT_COUNTS), dtype=np.int64)
    states = np.empty((room, kn.STATE_NUMBERS + 2 * modes))
    par, osc, work = tables.par.copy(), np.zeros((2, tables.har.shape[1])), np.zeros((kn.WORK_ROWS, modes))
    twin, none = state.copy(), (np.empty((0, kn.EVENT_NUMBERS)), np.empty((0, kn.EVENT_COUNTS), dtype=np.int64))
    if tables.values.size:
        par[kn.MEAN] = tables.values[state.count[kn.PIECE]]
    end_period, end_phase = (math.inf, 0.0) if stop.time is None else clock(begin_time + stop.time)
    stride, row = _STRIDE // (modes + 30), states.itemsize * (states.shape[1] + kn.EVENT_NUMBERS + kn.EVENT_COUNTS)
    events: list[Events] = []
    after: list[Array] = []
    tired, tired_at, outcome, recorded = 0, -1, "", 0
    while not outcome:
        state.count[kn.EVENTS] = 0
        budget = (int(state.count[kn.WORK]) // stride + 1) * stride
        code = kn.fly(
            par, tables.mode, tables.har, tables.coupling, tables.breaks, tables.values, tables.releases, tables.over,
            state.z, state.now, state.count, state.cycle, state.past, state.sums,
            float(end_period), end_phase, stop.most_impacts, stop.periodic, stop.tolerance, 0, budget,
            numbers, wholes, states, osc, work,
        )  # fmt: skip
        if code == kn.TO_VERIFY:
            code = kn.verify(  # type: ignore[call-arg]  # numba's dispatchers take whatever the function takes
                par, tables.mode, tables.har, tables.coupling, tables.breaks, tables.values, tables.releases,
                tables.over, state.now, state.count, state.sums, stop.periodic, stop.tolerance,
                *(getattr(twin, field.name) for field in fields(twin)), osc, work, *none,
            )  # fmt: skip
        n = int(state.count[kn.EVENTS])
        outcome, recorded = ENDS.get(code, ""), recorded + n * row
        if recorded > _MOST_MEMORY and not outcome:
            outcome = "memory"
        if code == kn.BY_WORK:
            tired = tired + 1 if state.impacts == tired_at else 1
            tired_at = state.impacts
            if tired > _TOO_MANY:
                outcome = "work"
        if progress is not None and progress(_progress(state, stop, begin_time)) and not outcome:
            outcome = "cancelled"
        events.append(_events(numbers[:n], wholes[:n]))
        after.append(states[:n] if outcome else states[:n].copy())
    state.count[kn.EVENTS] = 0
    return Stretch(Events.of_all(events), after[0] if len(after) == 1 else np.concatenate(after), state, outcome)


def _progress(state: Snapshot, stop: Stop, begin_time: float) -> Progress:
    gone = state.time - begin_time
    fraction = state.impacts / max(stop.most_impacts, 1)
    if stop.time is not None:
        fraction = max(fraction, gone / stop.time)
    return Progress(state.impacts, gone, min(fraction, 1.0))


def _events(numbers: Array, wholes: npt.NDArray[np.int64]) -> Events:
    return Events(
        code=wholes[:, kn.KIND].astype(np.int8),
        period=wholes[:, kn.AT_PERIOD].copy(),
        phase=numbers[:, kn.AT_PHASE].copy(),
        impact_velocity=numbers[:, kn.BEFORE].copy(),
        rebound_velocity=numbers[:, kn.AFTER].copy(),
        energy_lost=numbers[:, kn.LOST].copy(),
        kinetic_energy=numbers[:, kn.KINETIC].copy(),
        resolved=wholes[:, kn.RESOLVED].copy(),
        piece=wholes[:, kn.IN_PIECE].copy(),
    )
