"""Motions followed to the cycles that they settle on, and the numbers by which cycles are told apart."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from functools import reduce
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from percuss.explore.attractors.motion_columns import some
from percuss.explore.jobs.job import Column, Columns
from percuss.model.checks import Array

if TYPE_CHECKING:
    from percuss.model import System
    from percuss.simulate import Ensemble, Starts, Stop

__all__ = ["COLUMNS", "INVARIANTS", "cycles_of", "followed", "invariants_of"]

INVARIANTS = 8
_BLOCK = 2048  # members at once: the impacts kept of them take some MB
_PORTION = 1_000_000  # impacts between two looks at whether the answer is still wanted
_WINDOW = 256  # last impacts kept; the engine classifies by as many
_LONGEST = 1 << 16  # impacts of the longest cycle whose impacts are looked at
_KEPT = 1 << 20  # impacts kept at once, some tens of MB

COLUMNS: dict[str, Column] = {
    "code": Column("int8", meaning="how the simulation ended, its number in percuss.simulate.OUTCOMES"),
    "impacts": Column("int64", meaning="impacts from the start"),
    "first": Column("int64", fill=-2, meaning="impact, from 0, at which the periodic motion begins; -1: none found"),
    "cycle_impacts": Column("int64", meaning="impacts of the periodic motion; 0: none found"),
    "cycle_periods": Column("int64", unit="load periods", meaning="length of the periodic motion; 0: none found"),
    "cycle_kind": Column("int8", meaning="periodic motion without rest (0), with rest (1), with chatter and rest (2)"),
    "wanders": Column("bool", meaning="whether the last impacts do not come near any earlier ones"),
    "phase": Column(unit="rad", meaning="load phase of the fastest impact of the periodic motion"),
    "striking_speed": Column(meaning="speed of the fastest impact of the periodic motion"),
    "invariants": Column(shape=(INVARIANTS,), meaning="of the set of impacts of the periodic motion"),
    "blow_rate": Column(unit="1/load period", meaning="impacts per load period"),
    "main_blow_rate": Column(unit="1/load period", meaning="impacts per load period, each chatter counted once"),
    "interval_mean": Column(unit="rad", meaning="mean time between impacts"),
    "interval_std": Column(unit="rad", meaning="standard deviation of the time between impacts"),
    "main_interval_mean": Column(unit="rad", meaning="mean time between main blows"),
    "main_interval_std": Column(unit="rad", meaning="standard deviation of the time between main blows"),
    "impact_velocity": Column(meaning="mean striking speed of the main blows"),
    "blow_energy": Column(meaning="mean kinetic energy just before a main blow"),
}
"""What is kept of every motion."""


def followed(
    system: System, starts: Starts, modes: int, stop: Stop, threads: int | None, stopped: Callable[[], bool]
) -> Columns:
    """`COLUMNS` of the motions from all starts, each by itself."""
    from percuss.simulate import simulate_many

    parts: list[Columns] = []
    # simulate_many looks up 16 times for each thread: long motions in small blocks, so that it soon sees `stopped`
    size = int(np.clip(16 * _PORTION // max(stop.most_impacts, 1), 16, _BLOCK))
    for i in range(0, len(starts), size):
        block = some(starts, slice(i, i + size))
        many = simulate_many(
            system, block, modes=modes, stop=stop, keep=_WINDOW, threads=threads, progress=lambda _: stopped()
        )
        parts.append(_columns(many, system.load.harmonics))
        if stopped():
            break
    found = {name: np.concatenate([part[name] for part in parts]) for name in COLUMNS}
    for rows, keep in _long(found["cycle_impacts"]):
        if stopped():
            break
        again = simulate_many(system, some(starts, rows), modes=modes, stop=stop, keep=keep, threads=threads)
        more = _columns(again, system.load.harmonics)
        for name in ("phase", "striking_speed", "invariants"):
            found[name][rows] = more[name]
    return found


def _long(impacts: npt.NDArray[np.int64]) -> Iterator[tuple[npt.NDArray[np.intp], int]]:
    """Members whose cycle is longer than what is kept of all, in portions, and how many impacts to keep of them.

    That number is the power of 2 that their own cycle asks for, so that nothing depends on the company of a member: the
    engine looks for cycles in as many impacts as are kept.
    """
    keep = _WINDOW
    while keep < _LONGEST:
        keep *= 2
        rows = np.flatnonzero((impacts > keep // 2) & (impacts <= keep))
        at_once = max(_KEPT // keep, 1)
        for i in range(0, rows.size, at_once):
            yield rows[i : i + at_once], keep


def _columns(many: Ensemble, harmonics: npt.NDArray[np.int64]) -> Columns:
    assert many.last_phase is not None and many.last_velocity is not None
    kept = many.last_phase.shape[1]
    impacts = np.where(many.cycle_impacts <= kept, many.cycle_impacts, 0)
    invariants, phase, speed = invariants_of(
        many.last_phase, many.last_velocity, impacts, many.cycle_periods, harmonics
    )
    made: Columns = {"phase": phase, "striking_speed": speed, "invariants": invariants}
    for name, column in COLUMNS.items():
        if name not in made:
            made[name] = np.asarray(getattr(many, name)).astype(column.dtype)
    return made


def invariants_of(
    phases: Array, speeds: Array, impacts: npt.NDArray[np.int64], periods: npt.NDArray[np.int64], harmonics: Any
) -> tuple[Array, Array, Array]:
    """Invariants of the last `impacts` impacts of each row, and phase and speed of the fastest of them.

    Sums over the impacts of a cycle do not depend on which of them comes first, and cosine and sine know no seam at
    2π; weights v² and v³ leave the smallest impacts of a chatter, of which there may be one more or less, without
    weight. Phases count modulo the true period of the load, 2π over the greatest common divisor of its harmonics.
    """
    turn = float(reduce(math.gcd, (int(k) for k in harmonics), 0) or 1)
    rows, most = impacts.size, int(impacts.max(initial=0))
    sums = np.zeros((INVARIANTS, rows))
    top, at = np.full(rows, -1.0), np.full(rows, np.nan)  # speeds of impacts are not below 0
    for j in range(most):  # one impact of all rows after the other: the same sums, to the bit, whatever the other rows
        here = impacts > j
        phi = np.where(here, phases[:, phases.shape[1] - 1 - j], 0.0)
        v = np.where(here, speeds[:, phases.shape[1] - 1 - j], 0.0)
        square = v * v
        cube = square * v
        c, s = np.cos(turn * phi), np.sin(turn * phi)
        for k, term in enumerate((square, cube, square * c, square * s, cube * c, cube * s)):
            sums[k] += term
        sums[6] += square * (c - s) * (c + s)  # cos 2φ and sin 2φ
        sums[7] += square * (2.0 * c * s)
        # the fastest; of several equally fast ones that of the least phase
        better = here & np.where(np.abs(v - top) <= 1e-7 * v, phi < at, v > top)
        top, at = np.where(better, v, top), np.where(better, phi, at)
    none = impacts == 0
    with np.errstate(divide="ignore", invalid="ignore"):
        square, cube = sums[0].copy(), sums[1].copy()
        sums[0], sums[1] = cube / square, square / periods
        sums[2:4] /= square
        sums[4:6] /= cube
        sums[6:8] /= square
    sums[:, none] = np.nan
    return np.ascontiguousarray(sums.T), np.where(none, np.nan, at), np.where(none, np.nan, top)


Impacts = tuple[tuple[float, ...], tuple[float, ...]]


def cycles_of(
    columns: Columns, which: npt.NDArray[np.intp], system: System, starts: Starts, modes: int, stop: Stop
) -> list[Impacts]:
    """Phases and striking speeds of one cycle of some of the motions, in order of time from the fastest impact on."""
    from percuss.simulate import simulate_many

    found: list[Impacts] = [((), ())] * which.size
    settled = columns["cycle_impacts"][which]
    short = np.flatnonzero((settled > 0) & (settled <= _WINDOW))
    for rows, keep in [*([(short, _WINDOW)] if short.size else []), *_long(settled)]:
        many = simulate_many(system, some(starts, which[rows]), modes=modes, stop=stop, keep=keep, threads=1)
        assert many.last_phase is not None and many.last_velocity is not None
        for i, row in enumerate(rows.tolist()):
            p = int(many.cycle_impacts[i])
            if 0 < p <= keep:
                found[row] = _from_fastest(many.last_phase[i, keep - p :], many.last_velocity[i, keep - p :])
    return found


def _from_fastest(phases: Array, speeds: Array) -> Impacts:
    fast = np.flatnonzero(speeds >= (1.0 - 1e-7) * speeds.max())
    begin = int(fast[np.argmin(phases[fast])])
    return tuple(np.roll(phases, -begin).tolist()), tuple(np.roll(speeds, -begin).tolist())
