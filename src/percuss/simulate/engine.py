"""The loop around the kernels: calls them stretch by stretch, gathers the events, reports progress."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np
import numpy.typing as npt

from percuss.model import HeldBody, Load, System
from percuss.model.checks import Array
from percuss.model.system import half_swing, rests, wall_load
from percuss.simulate.events import CHATTER, IMPACT, RELEASE, Cycle, Events, joined, label_of, unresolved
from percuss.simulate.kernels.bounds import bounded
from percuss.simulate.kernels.motion import follow as follow_compiled
from percuss.simulate.kernels.motion import place
from percuss.simulate.kernels.motion_records import (
    AT_REST,
    BY_IMPACTS,
    BY_TIME,
    BY_WORK,
    DEPARTED,
    EVENT,
    MEMBER,
    ON_WALL,
    PAST,
    PERIODIC,
    RESTING,
    STATE_NUMBERS,
    TURN,
    UNRESOLVED,
    Log,
    Rules,
    Table,
)
from percuss.simulate.spectrum import Anchor, Spectrum, shifted
from percuss.simulate.start import Start
from percuss.simulate.stop import Stop
from percuss.simulate.tables import (
    NO_LOG,
    Snapshot,
    begin,
    begins,
    begun,
    clock,
    desk_for,
    prepared,
    to_change,
    turns_to_pull,
)

STRIDE = 1 << 24  # modes times evaluations between two looks at the outside
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


def gathered(
    log: Log,
    count: Any,
    step: Callable[[], tuple[str, bool]],
    gone: Callable[[], tuple[int, float]],
    stop: Stop,
    progress: Callable[[Progress], object] | None,
    idle: tuple[int, bool],
) -> tuple[Events, Array, str]:
    """Calls the kernels stretch by stretch until a motion ends: its events, the states after them, and how it ended.

    Parameters
    ----------
    log, count
        The kernels' record, and their whole numbers.
    step, gone
        A stretch: how the motion ended, or nothing, and whether its work is done; impacts and time so far.
    idle
        Stretches of work without an impact that end a motion or, where the flag is set, without any event.
    """
    events, states, ended, still, taken, impacts = [], [], "", 0, 0, -1
    row = log.events.itemsize + log.states.itemsize * log.states.shape[1]
    while not ended:
        ended, worked = step()
        n = int(count["events"])
        count["events"], taken = 0, taken + n * row
        struck, time = gone()
        if taken > _MOST_MEMORY and not ended:
            ended = "memory"
        if worked:
            same = not n if idle[1] else struck == impacts
            still, impacts = still + 1 if same else 0, struck
            if still >= idle[0]:
                ended = "work"
        elif idle[1]:
            still = 0
        fraction = struck / max(stop.most_impacts, 1)
        if stop.time is not None:
            fraction = max(fraction, time / stop.time)
        if progress is not None and progress(Progress(struck, time, min(fraction, 1.0))) and not ended:
            ended = "cancelled"
        events.append(events_of(log.events[:n]))
        states.append(log.states[:n] if ended else log.states[:n].copy())
    return joined(events), states[0] if len(states) == 1 else np.concatenate(states), ended


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
    found, stride = np.zeros(1, MEMBER), STRIDE // (modes + 30)
    ends = np.array([[math.inf, 0.0] if stop.time is None else clock(begin_time + stop.time)])

    def step() -> tuple[str, bool]:
        budget = (int(count["work"]) // stride + 1) * stride
        rules = Rules(np.inf, 0.0, stop.most_impacts, stop.periodic, stop.tolerance, skip, budget)
        follow_compiled(own, _NOWHERE, ends, rules, motion, twin, desk, log, NO_LOG, _GOES_ON, found, _NO_TAIL)
        code = int(found["ended"][0])
        return ENDS.get(code, ""), code == BY_WORK

    def gone() -> tuple[int, float]:
        return state.impacts, state.time - begin_time

    events, states, outcome = gathered(log, count, step, gone, stop, progress, (_TOO_MANY, False))
    return Stretch(events, states, state, outcome, bool(found["wanders"][0]))


def events_of(log: npt.NDArray[Any]) -> Events:
    """The kernels' events as columns, in the kernels' units."""
    columns: dict[str, Any] = {name: log[name].copy() for name in ("period", "phase", "resolved", "piece", "port")}
    return Events(
        code=log["kind"].astype(np.int8),
        impact_velocity=log["before"].copy(),
        rebound_velocity=log["after"].copy(),
        energy_lost=log["lost"].copy(),
        kinetic_energy=log["kinetic"].copy(),
        **columns,
    )


# ---- How a structure lies on the wall: its velocities gone, its shape that of the last impact
#
# Infinitely many impacts, or one without rebound, take every velocity and leave the shape as it is. The kernels know
# the rest of a bar, which is undeformed.


def laid_down(spectrum: Spectrum, table: Table, before: Snapshot, stretch: Stretch) -> Stretch:
    """The end of a stretch of simulation, with the shape and the energies of a structure; that of a bar as it is.

    `before`: where the stretch began. Without rebound there is no chatter, whatever the kernels say (`held_table`).
    """
    system = spectrum.system
    if system.body.is_free or stretch.outcome != "rest":
        return stretch
    snapshot = stretch.snapshot.copy()
    events, states, lost = stretch.events, stretch.states, stretch.events.energy_lost.copy()
    struck = np.flatnonzero(events.code == IMPACT)
    last, left = (int(struck[-1]), 0.0) if struck.size else (-1, 0.0)
    if struck.size:
        left = system.contact.velocity_factor**2 * float(events.kinetic_energy[last])
    shape = _shape(spectrum, before, stretch, last)
    taken, states = float(lost[last + 1 :].sum()), states.copy()
    for i in range(last + 1, len(events)):
        mean = spectrum.mean(int(events.piece[i]))
        states[i, :2] = 0.0
        states[i, 2:] = spectrum.amplitudes(shape, np.zeros_like(shape), float(events.phase[i]), mean).reshape(-1)
        lost[i] = left if i == last + 1 else 0.0
    if last + 1 < len(events):
        snapshot.z[:] = states[-1, 2:].reshape(2, -1)
        bounded(table.bar, table.modes, snapshot.z, snapshot.now[0])
    snapshot.sums["taken"][0] += float(lost[last + 1 :].sum()) - taken
    events = replace(events, energy_lost=lost)
    if not system.contact.rebounds:
        kept = events.code != CHATTER
        events, states = events[kept], states[kept]
        snapshot.count["chatters"] = snapshot.count["mark_chatters"] = 0
    return replace(stretch, events=events, states=states, snapshot=snapshot)


def _shape(spectrum: Spectrum, before: Snapshot, stretch: Stretch, last: int) -> Array:
    """u_n in which the structure lies: of one mode told by the gap, of several as it was struck last."""
    body = spectrum.system.body
    if spectrum.modes == 1:
        return np.array([-body.gap, body.gap / float(spectrum.unit[0])])
    if last >= 0:
        z, phase, piece = stretch.states[last, 2:], stretch.events.phase[last], stretch.events.piece[last]
    else:
        z, phase, piece = before.z, before.now["phase"][0], before.count["piece"][0]
    shape, _ = spectrum.modal(z.reshape(2, -1), 0.0, 0.0, float(phase), spectrum.mean(int(piece)))
    return np.asarray(shape)


# ---- Rest and release of a structure of one mode: what the kernels, which end its motion at rest, leave to be told
#
# The wall holds its contact, so that nothing moves, until the force that it feels (`wall_load`) turns into a pull. The
# structure then leaves from y = 0 and y' = 0, and is away for certain as long as it is pulled, half a period of its own
# at most.

_IN_VAIN = 64  # releases without an impact after which a motion is given up
_FLIGHT = (
    "gap", "gap_rate", "rigid_rate", "phase", "cosine", "sine", "free", "free_oscillating", "free_curve",
    "sup", "sup1", "sup2", "sup3",
)  # fmt: skip


def followed(
    spectrum: Spectrum,
    table: Table,
    snapshot: Snapshot,
    stop: Stop,
    begin_time: float,
    progress: Callable[[Progress], object] | None = None,
    skip: int = 0,
) -> Stretch:
    """The motion from a snapshot on until the stop rule holds, as `engine.follow`, over every rest of a structure."""
    system, modes = spectrum.system, spectrum.modes
    if system.body.is_free or not rests(system, modes):
        return laid_down(spectrum, table, snapshot, follow(table, snapshot, stop, begin_time, progress, skip))
    parts: list[Stretch] = []
    state, in_vain = snapshot, 0
    pulls = _pulls(system)
    while True:
        part = laid_down(spectrum, table, state, follow(table, state, stop, begin_time, progress, skip))
        parts.append(part)
        in_vain = 0 if part.snapshot.impacts > state.impacts else in_vain + 1
        if part.outcome != "rest":
            break
        state = part.snapshot.copy()
        let_go = _let_go(spectrum, table, pulls, state, stop, begin_time)
        if isinstance(let_go, str) or in_vain > _IN_VAIN:
            parts[-1] = replace(part, outcome=let_go if isinstance(let_go, str) else "work")
            break
        parts.append(replace(part, events=let_go[0], states=let_go[1]))
    last = parts[-1]
    return replace(
        last, events=joined([part.events for part in parts]), states=np.concatenate([p.states for p in parts])
    )


@dataclass(frozen=True)
class _Pulls:
    """The force that the wall feels from a structure at rest: where it begins to pull, and to push; phases."""

    load: Load
    begin: Array
    end: Array

    def ahead(self, phase: float) -> float:
        """Time from a phase until the wall lets go, 0 if it is pulled there; inf if it never does."""
        wait = np.mod(self.begin - phase, TURN)
        wait = np.where(TURN - wait <= 4.0 * np.spacing(TURN), 0.0, wait)
        if not wait.size:
            return np.inf if float(self.load.value(phase)) >= 0.0 else 0.0
        held = float(wait.min()) == 0.0 or float(self.load.value(phase)) >= 0.0
        return float(wait.min()) if held else 0.0

    def lasts(self, phase: float) -> float:
        """How long it pulls from there on."""
        left = np.mod(self.end - phase, TURN)
        return float(left[left > 1e-9].min(initial=np.inf))


@lru_cache(maxsize=64)
def _pulls(system: System) -> _Pulls:
    load = wall_load(system, 1)
    if load.is_piecewise:
        values, breaks = np.array(load.values), np.array(load.breaks)
        begin = breaks[(values < 0.0) & (np.roll(values, 1) >= 0.0)]
        return _Pulls(load, begin, breaks[values > 0.0])
    begin, end = (turns_to_pull(system.body, force) for force in (load, load.scaled(-1.0)))
    return _Pulls(load, begin, end)


def _let_go(
    spectrum: Spectrum, table: Table, pulls: _Pulls, state: Snapshot, stop: Stop, begin_time: float
) -> tuple[Events, Array] | str:
    """The release of a structure at rest, into the state; or how its motion ends before: at rest, or by time."""
    now, count = state.now[0], state.count[0]
    period, phase = int(count["period"]), float(now["phase"])
    wait = pulls.ahead(phase)
    if wait == np.inf:
        return "rest"
    if wait > 0.0:
        new = float(pulls.begin[int(np.argmin(np.mod(pulls.begin - phase, TURN)))])
        period, phase = period + (new < phase), new
    if stop.time is not None:
        ends = clock(begin_time + stop.time)
        if (ends[0] - period) * TURN + (ends[1] - phase) <= 0.0:
            return "time"
    turns, phases, piece = begun(spectrum.system.load, np.array([phase]))
    period, phase = period + int(turns[0]), float(phases[0])
    _set_off(spectrum, table, state, period, phase, int(piece[0]))
    now["hold"] = min(pulls.lasts(phase), half_swing(spectrum.elastic))
    row = np.concatenate([[0.0, 0.0], state.z.reshape(-1)])[None, :]
    none = np.zeros(1)
    return Events(
        code=np.array([RELEASE], dtype=np.int8), period=np.array([period]), phase=np.array([phase]),
        impact_velocity=none, rebound_velocity=none, energy_lost=none, kinetic_energy=none,
        resolved=np.zeros(1, dtype=np.int64), piece=np.array([int(count["piece"])]), port=np.array([-1]),
    ), row  # fmt: skip


def _set_off(spectrum: Spectrum, table: Table, state: Snapshot, period: int, phase: float, piece: int) -> None:
    """The structure at its wall and without speed, about to leave; what is kept of its impacts stays."""
    system, now, count = spectrum.system, state.now[0], state.count[0]
    gap = system.body.gap if isinstance(system.body, HeldBody) else 0.0
    shape = np.array([[-gap, gap / float(spectrum.unit[0])]])
    fresh = Snapshot.empty(1)
    start = begins(
        shifted(system, 1, shape), np.zeros((1, 2)), np.zeros(1), np.array([phase]), np.array([period]),
        np.array([piece]),
    )  # fmt: skip
    place(to_change(table), fresh.motion, desk_for(table), start)
    state.z[:] = fresh.z
    for name in _FLIGHT:
        now[name] = fresh.now[name][0]
    count["period"], count["piece"], count["mode"], count["run"] = period, piece, ON_WALL, 0
    count["release_period"], count["work"] = period, count["work"] + 1
    now["last_flight"], now["since"], now["released"], now["last_place"] = -1.0, 0.0, -1.0, 0.0


# ---- A motion on its way, and what the stretch simulated last makes of it

_ARRAYS = ("z", "now", "count", "cycle", "past", "sums")


@dataclass(frozen=True)
class Clocked:
    """A motion of a system on its way."""

    spectrum: Spectrum
    table: Table
    snapshot: Snapshot

    @property
    def modes(self) -> int:
        """N."""
        return self.spectrum.modes

    @classmethod
    def begun(cls, system: System, modes: int, start: Start) -> tuple[Clocked, Anchor, bool]:
        """A motion put at a start, the state there, and whether it rests on the wall."""
        body = system.body
        spectrum, table = prepared(system, body.chosen(modes) if isinstance(body, HeldBody) else modes)
        snapshot = begin(spectrum, table, start)
        now, count = snapshot.now[0], snapshot.count[0]
        row = np.concatenate([[now["gap"], now["rigid_rate"]], snapshot.z.reshape(-1)])
        anchor = Anchor(float(now["phase"]), int(count["piece"]), row)
        return cls(spectrum, table, snapshot), anchor, int(count["mode"]) == RESTING

    def followed(
        self, stop: Stop, begin_time: float, progress: Callable[[Progress], object] | None = None
    ) -> dict[str, Any]:
        """The motion on until the stop rule holds; what a `Trajectory` has of it, by the names of its fields."""
        stretch = followed(self.spectrum, self.table, self.snapshot, stop, begin_time, progress)
        state = stretch.snapshot
        cycle = _cycle(state.count)
        wanders = not self.spectrum.system.load.is_constant and stretch.wanders
        end = state.time if stretch.outcome != "time" or stop.time is None else begin_time + stop.time
        return {
            "events": stretch.events,
            "states": stretch.states,
            "snapshot": {name: getattr(state, name) for name in _ARRAYS},
            "outcome": stretch.outcome,
            "label": label_of(stretch.outcome, cycle, wanders, unresolved(state.count)),
            "cycle": cycle,
            "end_time": max(end, begin_time),
        }


def _cycle(count: npt.NDArray[Any]) -> Cycle | None:
    """The confirmed cycle that the engine's whole numbers tell of."""
    if count["confirmed"][0] < 2:
        return None
    names = ("found_at", "cycle_impacts", "cycle_periods", "cycle_kind")
    first, impacts, periods, kind = (int(count[name][0]) for name in names)
    return Cycle(first - 1, impacts, periods, kind)
