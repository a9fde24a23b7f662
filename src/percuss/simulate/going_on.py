"""A simulated motion followed further, and what the stretch simulated last makes of it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt

from percuss.model import System
from percuss.notebook import watched
from percuss.simulate.engine import Progress, Stretch
from percuss.simulate.events import Events
from percuss.simulate.held_release import followed
from percuss.simulate.restored import restored
from percuss.simulate.simulated_motion import SimulatedMotion, unresolved
from percuss.simulate.stop import Stop
from percuss.simulate.summary import Cycle, label_of
from percuss.simulate.tables import prepared

__all__ = ["ending", "go_on"]

Kind = TypeVar("Kind", bound=SimulatedMotion)

_ARRAYS = ("z", "now", "count", "cycle", "past", "sums")


def go_on(motion: Kind, stop: Stop, progress: Callable[[Progress], object] | None = None) -> Kind:
    """A motion followed further."""
    snapshot = restored(motion)
    with watched(progress) as watch:
        stretch = followed(*prepared(motion.system, motion.modes), snapshot, stop, motion.begin_time, watch)
    whole = Stretch(
        Events.of_all([motion.events, stretch.events]),
        np.concatenate([motion.states, stretch.states]),
        stretch.snapshot,
        stretch.outcome,
        stretch.wanders,
    )
    return replace(motion, **ending(motion.system, whole, stop, motion.begin_time))


def ending(system: System, stretch: Stretch, stop: Stop, begin_time: float) -> dict[str, Any]:
    """What a motion has from its simulation, by the names of its fields: events, states, how it ended, its cycle."""
    state = stretch.snapshot
    cycle = _cycle(state.count)
    wanders = not system.load.is_constant and stretch.wanders
    end = state.time if stretch.outcome != "time" or stop.time is None else begin_time + stop.time
    return {
        "events": stretch.events,
        "states": stretch.states,
        "snapshot": {name: getattr(state, name) for name in _ARRAYS},
        "outcome": stretch.outcome,
        "label": label_of(stretch.outcome, cycle, wanders or unresolved(state.count)),
        "cycle": cycle,
        "stop": stop,
        "end_time": max(end, begin_time),
    }


def _cycle(count: npt.NDArray[Any]) -> Cycle | None:
    """The confirmed cycle that the engine's whole numbers tell of."""
    if count["confirmed"][0] < 2:
        return None
    names = ("found_at", "cycle_impacts", "cycle_periods", "cycle_kind")
    first, impacts, periods, kind = (int(count[name][0]) for name in names)
    return Cycle(first - 1, impacts, periods, kind)
