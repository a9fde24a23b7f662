"""Rest and release of a structure of one mode: what the kernels, which end its motion at rest, leave to be told.

The wall holds its contact, so that nothing moves, until the force that it feels (`wall_load`) turns into a pull. The
structure then leaves from y = 0 and y' = 0, and is away for certain as long as it is pulled, half a period of its own
at most.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from percuss.model import HeldBody, Load, System
from percuss.model.checks import Array
from percuss.model.set_at_wall import half_swing, rests, wall_load
from percuss.simulate.engine import Progress, Stretch, follow
from percuss.simulate.events import RELEASE, Events
from percuss.simulate.held import shifted
from percuss.simulate.held_rest import laid_down
from percuss.simulate.kernels.codes import ON_WALL, TURN
from percuss.simulate.kernels.layout import Table
from percuss.simulate.kernels.place import place
from percuss.simulate.snapshot import Snapshot, begins, clock, desk_for
from percuss.simulate.spectrum import Spectrum
from percuss.simulate.stop import Stop
from percuss.simulate.tables import to_change, turns_to_pull

__all__ = ["followed"]

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
        last, events=Events.of_all([part.events for part in parts]), states=np.concatenate([p.states for p in parts])
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
    _set_off(spectrum, table, state, period, phase)
    now["hold"] = min(pulls.lasts(phase), half_swing(spectrum.elastic))
    row = np.concatenate([[0.0, 0.0], state.z.reshape(-1)])[None, :]
    none = np.zeros(1)
    return Events(
        code=np.array([RELEASE], dtype=np.int8), period=np.array([period]), phase=np.array([phase]),
        impact_velocity=none, rebound_velocity=none, energy_lost=none, kinetic_energy=none,
        resolved=np.zeros(1, dtype=np.int64), piece=np.array([int(count["piece"])]),
    ), row  # fmt: skip


def _set_off(spectrum: Spectrum, table: Table, state: Snapshot, period: int, phase: float) -> None:
    """The structure at its wall and without speed, about to leave; what is kept of its impacts stays."""
    system, now, count = spectrum.system, state.now[0], state.count[0]
    piece = int(system.load.piece(phase)) if system.load.is_piecewise else 0
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
