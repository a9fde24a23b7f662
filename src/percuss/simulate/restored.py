"""The state that a motion goes on from, looked at before it is given to the kernels: they check no bound themselves."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from percuss.errors import PercussError
from percuss.simulate import kernels as kn
from percuss.simulate.remembered import remembered
from percuss.simulate.snapshot import Snapshot
from percuss.simulate.soundness import MOST_PERIODS, TURN, numbers, shaped, true, within
from percuss.simulate.trajectory import Trajectory

__all__ = ["restored"]

_MOST_WORK = 2**62

_ENDLESS = (kn.HOLD, kn.LAST_FLIGHT, kn.SINCE, kn.PUSHES)
"""Times among the numbers of the anchor: infinite when nothing bounds them."""


def restored(motion: Trajectory) -> Snapshot:
    """The state at the end of a motion, in arrays as the kernels want them.

    Raises
    ------
    PercussError
        When a simulation cannot have left it: it comes from a file that was changed, or made up.
    """
    try:
        _check(motion)
    except ValueError as error:
        told = f"the state to continue from is damaged: {error}"
        raise PercussError(told, "use a copy of its file, or simulate again") from None
    names = ("z", "now", "count", "cycle", "past", "sums")
    return Snapshot(**{name: np.ascontiguousarray(motion.snapshot[name]) for name in names})


def _check(motion: Trajectory) -> None:
    snapshot, system, modes = motion.snapshot, motion.system, motion.modes
    for name in ("z", "now", "count", "cycle", "past", "sums"):
        if name not in snapshot:
            raise ValueError(f"there is no engine_{name}")
    numbers("engine_z", snapshot["z"], (2, modes))
    numbers("engine_cycle", snapshot["cycle"], (3 + 2 * modes,))
    numbers("engine_past", snapshot["past"], (3, kn.WINDOW))
    numbers("engine_sums", snapshot["sums"], (kn.SUMS_KEPT,))
    _now(snapshot["now"])
    _counts(snapshot["count"], max(len(system.load.values), 1), motion.impacts, len(motion.events))
    remembered(motion)


def _now(now: npt.NDArray[Any]) -> None:
    shaped("engine_now", now, np.float64, (kn.NUMBERS,))
    bounded = now.copy()
    bounded[list(_ENDLESS)] = np.where(np.isposinf(now[list(_ENDLESS)]), 0.0, now[list(_ENDLESS)])
    numbers("engine_now", bounded, (kn.NUMBERS,))
    phase = float(now[kn.PHASE])
    within("engine_now", phase, 0.0, TURN)
    # else the load that the kernels see is another one than the phase says
    for row, exact in ((kn.COSINE, math.cos(phase)), (kn.SINE, math.sin(phase))):
        within("engine_now", now[row], exact - 1e-9, exact + 1e-9)


def _counts(whole: npt.NDArray[Any], pieces: int, impacts: int, events: int) -> None:
    shaped("engine_count", whole, np.int64, (kn.COUNTS,))
    low, high = np.zeros(kn.COUNTS), np.full(kn.COUNTS, _MOST_WORK, dtype=np.int64)
    periods = [kn.PERIOD, kn.ANCHOR_PERIOD, kn.RELEASE_PERIOD, kn.MARK_PERIOD]
    low[periods] = -MOST_PERIODS
    high[[*periods, kn.CYCLE_PERIODS]] = MOST_PERIODS
    high[kn.PIECE], high[kn.MODE], high[kn.CYCLE_KIND] = pieces - 1, kn.GRAZED, 2
    low[kn.IMPACTS] = high[kn.IMPACTS] = impacts  # as many as are recorded
    high[[kn.RUN, kn.ANCHOR, kn.CYCLE_IMPACTS, kn.CONFIRMED, kn.FOUND_AT, kn.MARK]] = impacts
    high[[kn.RESTS, kn.CHATTERS, kn.MARK_RELEASES, kn.MARK_CHATTERS]] = events
    high[[kn.PATIENCE, kn.MARK_PATIENCE]] = 2 * events + 1  # doubled when so many have gone by
    high[kn.VERDICT] = kn.LOST_CYCLE
    high[kn.EVENTS] = 0
    bad = np.flatnonzero((whole < low) | (whole > high))
    true(not bad.size, f"number {bad[:1]} of engine_count")
