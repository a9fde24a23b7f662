"""Starts as columns."""

from __future__ import annotations

import hashlib
from typing import TYPE_CHECKING, TypeVar, cast

import numpy as np
import numpy.typing as npt

from percuss.explore.jobs.job import Column, Columns

if TYPE_CHECKING:
    from percuss.simulate import MachineStarts, Starts

__all__ = ["bars_of", "done", "fingerprint", "some", "start_columns", "start_values", "starts_from"]

Own = TypeVar("Own", bound="Starts | MachineStarts")

_RIGID: dict[str, Column] = {
    "position": Column(unit="bar lengths", meaning="where the bar starts; the wall is at 0"),
    "velocity": Column(unit="bar lengths/rad", meaning="of the bar at its start, positive toward the wall"),
    "time": Column(unit="rad", meaning="load phase of the start"),
}


def start_columns(displacements: int, velocities: int) -> dict[str, Column]:
    """The columns of starts with so many modal amplitudes."""
    if displacements == velocities == 1:
        return dict(_RIGID)
    return {
        "position": Column(unit="bar lengths", meaning="of the striking end at the start; the wall is at 0"),
        "start_displacement": Column(shape=(displacements,), meaning="u_n at the start"),
        "start_velocity": Column(shape=(velocities,), meaning="u_n' at the start"),
        "time": _RIGID["time"],
    }


def start_values(starts: Starts) -> Columns:
    """The starts as columns."""
    found: Columns = {"position": starts.gap.copy(), "time": starts.time.copy()}
    if starts.displacement.shape[1] == starts.velocity.shape[1] == 1:
        return {**found, "velocity": starts.velocity[:, 0].copy()}
    return {**found, "start_displacement": starts.displacement.copy(), "start_velocity": starts.velocity.copy()}


def starts_from(columns: Columns) -> Starts:
    """The starts that columns hold."""
    from percuss.simulate import Starts

    if "velocity" in columns:
        return Starts.rigid(columns["position"], columns["velocity"], columns["time"])
    return Starts(columns["start_displacement"], columns["start_velocity"], columns["position"], columns["time"])


def bars_of(starts: Starts | MachineStarts) -> Starts:
    """The bars at the starts."""
    from percuss.simulate import MachineStarts

    return starts.bars if isinstance(starts, MachineStarts) else starts


def some(starts: Own, rows: npt.NDArray[np.int64] | npt.NDArray[np.intp] | slice) -> Own:
    """Some of the starts."""
    from percuss.simulate import MachineStarts, Starts

    bars = bars_of(starts)
    part = Starts(bars.displacement[rows], bars.velocity[rows], bars.gap[rows], bars.time[rows])
    if isinstance(starts, MachineStarts):
        return cast("Own", MachineStarts(part, starts.state[rows], starts.states))
    return cast("Own", part)


def fingerprint(starts: Starts | MachineStarts) -> str:
    """SHA-256 of starts."""
    from percuss.simulate import MachineStarts

    found, bars = hashlib.sha256(), bars_of(starts)
    states = (starts.state.astype(float),) if isinstance(starts, MachineStarts) else ()
    for values in (bars.displacement, bars.velocity, bars.gap, bars.time, *states):
        found.update(str(values.shape).encode() + np.ascontiguousarray(values, dtype="<f8").tobytes())
    return found.hexdigest()


def done(columns: Columns) -> npt.NDArray[np.bool_]:
    """Which motions are known: of an archive that is not whole, not all are."""
    return np.asarray(columns["code"] >= 0)
