"""The whole state of a simulation between two events, as the arrays that the kernels change."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields

import numpy as np
import numpy.typing as npt

from percuss.model.checks import Array
from percuss.simulate import kernels as kn
from percuss.simulate.spectrum import Spectrum
from percuss.simulate.start import Start
from percuss.simulate.tables import Tables

__all__ = ["Snapshot", "begin", "clock"]


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


def clock(time: float) -> tuple[int, float]:
    """Load periods gone by, and the phase in [0, 2π)."""
    periods = math.floor(time / kn.TURN)
    phase = (time - periods * kn.TURN) - periods * kn.TURN_LOW
    if phase < 0.0:
        phase = 0.0
    return (periods + 1, 0.0) if phase >= kn.TURN else (periods, phase)


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
