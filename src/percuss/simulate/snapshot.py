"""The whole state of a simulation between two events, as the arrays that the kernels change."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np
import numpy.typing as npt

from percuss.model.checks import Array
from percuss.simulate import kernels as kn
from percuss.simulate.spectrum import Spectrum
from percuss.simulate.start import Start
from percuss.simulate.tables import Tables

__all__ = ["Snapshot", "begin", "clock", "clocks"]


@dataclass(frozen=True)
class Snapshot:
    """Everything that the next event depends on; the names of the numbers stand in `percuss.simulate.kernels`.

    Attributes
    ----------
    z
        Amplitudes of the free motion, shape (2, N).
    now, count
        Numbers and whole numbers of the anchor.
    cycle, past, sums
        The state that later ones are compared with, the last impacts, and the running statistics.
    """

    z: Array
    now: Array
    count: npt.NDArray[np.int64]
    cycle: Array
    past: Array
    sums: Array

    def copy(self) -> Snapshot:
        """Arrays of its own, to be changed."""
        return Snapshot(*(getattr(self, field.name).copy() for field in fields(self)))

    @property
    def impacts(self) -> int:
        """Impacts from the start."""
        return int(self.count[kn.IMPACTS])

    @property
    def time(self) -> float:
        """Of the anchor, in radians."""
        return float(self.count[kn.PERIOD]) * kn.TURN + float(self.now[kn.PHASE])


def clocks(time: npt.ArrayLike) -> tuple[npt.NDArray[np.int64], Array]:
    """Load periods gone by at some times, and the phases in [0, 2π)."""
    times = np.asarray(time, dtype=float)
    turns = np.floor(times / kn.TURN)
    phase = np.maximum((times - turns * kn.TURN) - turns * kn.TURN_LOW, 0.0)
    over = phase >= kn.TURN
    return np.asarray(turns + over, dtype=np.int64), np.where(over, 0.0, phase)


def clock(time: float) -> tuple[int, float]:
    """The same at one time."""
    turns, phase = clocks(time)
    return int(turns), float(phase)


def begin(spectrum: Spectrum, tables: Tables, start: Start) -> Snapshot:
    """The state at the start."""
    displacement, velocity, gap = start.state(spectrum.modes)
    n = spectrum.modes
    state = Snapshot(
        np.zeros((2, n)),
        np.zeros(kn.NUMBERS),
        np.zeros(kn.COUNTS, dtype=np.int64),
        np.zeros(3 + 2 * n),
        np.zeros((3, kn.WINDOW)),
        np.zeros(kn.SUMS_KEPT),
    )
    period, phase = clock(start.time)
    load = spectrum.system.load
    piece = int(load.piece(phase)) if load.is_piecewise else 0
    kn.place(
        tables.par.copy(), tables.mode, tables.coupling, tables.values, state.z, state.now, state.count,
        np.zeros((kn.WORK_ROWS, n)), tables.over, displacement, velocity, gap, phase, period, piece,
    )  # fmt: skip
    return state
