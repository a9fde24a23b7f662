"""The whole state of a simulation between two events, as the records that the kernels change."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from percuss.model.checks import Array
from percuss.simulate.held import shifted
from percuss.simulate.kernels.calls import EVENT, Log, Starts
from percuss.simulate.kernels.codes import TURN, TURN_LOW, WINDOW
from percuss.simulate.kernels.layout import COUNT, NOW, PAST, SUMS, Desk, Motion, Table
from percuss.simulate.kernels.place import place
from percuss.simulate.spectrum import Spectrum
from percuss.simulate.start import Start
from percuss.simulate.tables import to_change

__all__ = ["NO_LOG", "Snapshot", "begin", "begins", "clock", "clocks", "desk_for"]

Records = npt.NDArray[Any]


@dataclass(frozen=True)
class Snapshot:
    """Everything that the next event depends on; the records are described in `percuss.simulate.kernels.layout`.

    Attributes
    ----------
    z
        Amplitudes of the free motion, shape (2, N).
    now, count
        Numbers and whole numbers of the anchor: one NOW and one COUNT, each of shape (1,).
    cycle
        Amplitudes of the state that later ones are compared with, shape (2, N).
    past
        The last impacts, PASTs.
    sums
        The running statistics, two SUMS.
    """

    z: Array
    now: Records
    count: Records
    cycle: Array
    past: Records
    sums: Records

    @classmethod
    def empty(cls, modes: int, window: int = WINDOW) -> Snapshot:
        """All numbers 0, with room for the last `window` impacts, a power of 2."""
        z, past = np.zeros((2, modes)), np.zeros(window, PAST)
        return cls(z, np.zeros(1, NOW), np.zeros(1, COUNT), z.copy(), past, np.zeros(2, SUMS))

    def copy(self) -> Snapshot:
        """Arrays of its own, to be changed."""
        return Snapshot(*map(_copied, (self.z, self.now, self.count, self.cycle, self.past, self.sums)))

    @property
    def motion(self) -> Motion:
        """What the kernels change: the same memory."""
        return Motion(
            self.z, self.now[0], self.count[0], self.cycle, self.past, self.sums,
            self.now.view(np.float64), self.count.view(np.int64), self.sums.view(np.float64).reshape(2, -1),
        )  # fmt: skip

    @property
    def impacts(self) -> int:
        """Impacts from the start."""
        return int(self.count["impacts"][0])

    @property
    def time(self) -> float:
        """Of the anchor, in radians."""
        return float(self.count["period"][0]) * TURN + float(self.now["phase"][0])


def _copied(values: Records) -> Records:
    """A copy in one piece: NumPy copies records field by field, which takes longer than an impact."""
    return values.view(np.uint8).copy().view(values.dtype) if values.dtype.names else values.copy()


NO_LOG = Log(np.empty(0, EVENT), np.empty((0, 0)))
"""For motions of which nothing is recorded."""


def begins(
    displacement: Array,
    velocity: Array,
    gap: Array,
    phase: Array,
    period: npt.NDArray[np.int64],
    piece: npt.NDArray[np.int64],
) -> Starts:
    """The starts of motions for the kernels; read-only, as numba would compile all once more for other arrays."""
    columns = Starts(displacement, velocity, gap, phase, period, piece)
    found = [np.ascontiguousarray(values).view() for values in columns]
    for values in found:
        values.setflags(write=False)
    return Starts(*found)  # type: ignore[arg-type]  # of the types that they had


def desk_for(table: Table) -> Desk:
    """Room to work in."""
    n = table.modes.omega.size
    return Desk(np.zeros((2, table.harmonics.gap_re.size)), *(np.zeros(n) for _ in range(5)))


def clocks(time: npt.ArrayLike) -> tuple[npt.NDArray[np.int64], Array]:
    """Load periods gone by at some times, and the phases in [0, 2π)."""
    times = np.asarray(time, dtype=float)
    turns = np.floor(times / TURN)
    phase = np.maximum((times - turns * TURN) - turns * TURN_LOW, 0.0)
    over = phase >= TURN
    return np.asarray(turns + over, dtype=np.int64), np.where(over, 0.0, phase)


def clock(time: float) -> tuple[int, float]:
    """The same at one time, to the last bit, in a twentieth of the time."""
    turns = math.floor(time / TURN)
    phase = max((time - turns * TURN) - turns * TURN_LOW, 0.0)
    return (turns, phase) if phase < TURN else (turns + 1, 0.0)


def begin(spectrum: Spectrum, table: Table, start: Start) -> Snapshot:
    """The state at the start."""
    u, v, gap = start.state(spectrum.modes, spectrum.system)
    state = Snapshot.empty(spectrum.modes)
    period, phase = clock(start.time)
    load = spectrum.system.load
    piece = int(load.piece(phase)) if load.is_piecewise else 0
    if not spectrum.system.body.is_free and gap == 0.0 and not u[1:].any() and not v.any():
        gap = -np.finfo(float).tiny  # else the kernels would take it for a bar at rest on the wall
    starts = begins(
        shifted(spectrum.system, spectrum.modes, u[None]),
        v[None],
        np.array([gap]),
        np.array([phase]),
        np.array([period]),
        np.array([piece]),
    )
    place(to_change(table), state.motion, desk_for(table), starts)
    return state
