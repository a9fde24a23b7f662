"""The state that a motion goes on from, looked at before it is given to the kernels: they check no bound themselves."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from percuss.errors import PercussError
from percuss.simulate.kernels.codes import GRAZED, LOST_CYCLE, WINDOW
from percuss.simulate.kernels.layout import COUNT, NOW, PAST, SUMS
from percuss.simulate.simulated_motion import SimulatedMotion
from percuss.simulate.soundness import MOST_PERIODS, TURN, numbers, shaped, true, within

if TYPE_CHECKING:
    from percuss.simulate.snapshot import Snapshot

__all__ = ["RECORDS", "restored"]

_MOST_WORK = 2**62

_ENDLESS = ("hold", "last_flight", "since", "pushes")
"""Times among the numbers of the anchor: infinite when nothing bounds them."""

RECORDS = {"now": (NOW, 1), "count": (COUNT, 1), "past": (PAST, WINDOW), "sums": (SUMS, 2)}
"""Type and number of the records of a snapshot."""


def restored(motion: SimulatedMotion) -> Snapshot:
    """The state at the end of a motion, in arrays as the kernels want them.

    Raises
    ------
    PercussError
        When a simulation cannot have left it: it comes from a file that was changed, or made up.
    """
    from percuss.simulate.snapshot import Snapshot  # the compiled room, which nobody needs who only reads a file

    try:
        _check(motion)
    except ValueError as error:
        told = f"the state to continue from is damaged: {error}"
        raise PercussError(told, "use a copy of its file, or simulate again") from None
    names = ("z", "now", "count", "cycle", "past", "sums")
    return Snapshot(**{name: np.ascontiguousarray(motion.snapshot[name]) for name in names})


def _check(motion: SimulatedMotion) -> None:
    snapshot, system, modes = motion.snapshot, motion.system, motion.modes
    for name in ("z", "now", "count", "cycle", "past", "sums"):
        if name not in snapshot:
            raise ValueError(f"there is no engine_{name}")
    for name in ("z", "cycle"):
        numbers(f"engine_{name}", snapshot[name], (2, modes))
    for name, (kind, size) in RECORDS.items():
        shaped(f"engine_{name}", snapshot[name], kind, (size,))
    for name in ("past", "sums"):
        values = snapshot[name].view(np.float64)
        numbers(f"engine_{name}", values, values.shape)
    _now(snapshot["now"])
    _counts(snapshot["count"], max(len(system.load.values), 1), motion.impacts, len(motion.events))
    from percuss.simulate.remembered import remembered

    remembered(motion)


def _now(now: npt.NDArray[Any]) -> None:
    bounded = now.copy()
    for name in _ENDLESS:
        bounded[name] = np.where(np.isposinf(now[name]), 0.0, now[name])
    values = bounded.view(np.float64)
    numbers("engine_now", values, values.shape)
    phase = float(now["phase"][0])
    within("engine_now", phase, 0.0, TURN)
    # else the load that the kernels see is another one than the phase says
    for name, exact in (("cosine", math.cos(phase)), ("sine", math.sin(phase))):
        within("engine_now", now[name], exact - 1e-9, exact + 1e-9)


def _counts(whole: npt.NDArray[Any], pieces: int, impacts: int, events: int) -> None:
    most = dict.fromkeys(COUNT.names or (), _MOST_WORK)
    least = dict.fromkeys(most, 0)
    for name in ("period", "anchor_period", "release_period", "mark_period", "cycle_periods"):
        least[name], most[name] = -MOST_PERIODS, MOST_PERIODS
    least["cycle_periods"] = 0
    most["piece"], most["mode"], most["cycle_kind"] = pieces - 1, GRAZED, 2
    least["impacts"] = most["impacts"] = impacts  # as many as are recorded
    most |= dict.fromkeys(("run", "anchor", "cycle_impacts", "confirmed", "found_at", "mark"), impacts)
    most |= dict.fromkeys(("rests", "chatters", "mark_releases", "mark_chatters"), events)
    most |= dict.fromkeys(("patience", "mark_patience"), 2 * events + 1)  # doubled when so many have gone by
    most["verdict"], most["events"] = LOST_CYCLE, 0
    for name in most:
        true(least[name] <= whole[name][0] <= most[name], f"{name} of engine_count")
