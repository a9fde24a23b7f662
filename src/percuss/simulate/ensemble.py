"""The results of many motions: one row each, with their labels and shares."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field, fields
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from percuss.model.checks import Array
from percuss.shown import Shown
from percuss.simulate.stop import OUTCOMES
from percuss.simulate.summary import Cycle, label_of
from percuss.simulate.trajectory import Trajectory

if TYPE_CHECKING:
    import xarray

__all__ = ["Ensemble", "EnsembleProgress"]

_MOST_TOLD = 5


@dataclass(frozen=True)
class EnsembleProgress:
    """How far an ensemble has come: members done, of how many."""

    done: int
    members: int

    @property
    def fraction(self) -> float:
        """0 to 1."""
        return self.done / self.members


@dataclass(frozen=True)
class Ensemble(Shown):
    """The results of many motions; one row each, in the order in which they were given. All dimensionless.

    Attributes
    ----------
    modes
        N, the elastic modes of all.
    code
        How each ended: its number in `OUTCOMES`; see `outcome`.
    impacts
        From the start.
    end_time
        Load time (rad) of the last event.
    first, cycle_impacts, cycle_periods, cycle_kind
        The periodic motion of each: the impact (from 0) it begins at, p impacts, n load periods, and without rest (0),
        with rest (1) or with chatter (2); −1, 0, 0, 0 when none was found.
    wanders
        Whether the last impacts come near none of the ones before, or the period hangs on rounding; see
        `Trajectory.label`.
    blow_rate, main_blow_rate, interval_mean, interval_std, main_interval_mean, main_interval_std
        As in `Summary`; over one cycle when a periodic motion was found, else after `discarded` impacts; NaN with
        fewer than two.
    impact_velocity, blow_energy
        Means over the main blows among the same impacts.
    energy_lost_per_period
        Taken by impacts, chatter and rest in the same time, per load period.
    last_time, last_phase, last_velocity
        Load time, phase and striking speed of the last impacts, shape (members, asked for), ascending, with NaN in
        front where there were fewer; None unless asked for.
    trajectories
        The whole motions; empty unless asked for.
    """

    modes: int
    code: npt.NDArray[np.int8]
    impacts: npt.NDArray[np.int64]
    end_time: Array
    first: npt.NDArray[np.int64]
    cycle_impacts: npt.NDArray[np.int64]
    cycle_periods: npt.NDArray[np.int64]
    cycle_kind: npt.NDArray[np.int8]
    wanders: npt.NDArray[np.bool_]
    blow_rate: Array
    main_blow_rate: Array
    interval_mean: Array
    interval_std: Array
    main_interval_mean: Array
    main_interval_std: Array
    impact_velocity: Array
    blow_energy: Array
    energy_lost_per_period: Array
    last_time: Array | None = None
    last_phase: Array | None = None
    last_velocity: Array | None = None
    trajectories: tuple[Trajectory, ...] = field(default=(), repr=False)

    def __str__(self) -> str:
        shares = list(self.shares.items())
        told = ", ".join(f"{name} {share:.3g}" for name, share in shares[:_MOST_TOLD])
        more = f", and {len(shares) - _MOST_TOLD} more labels" if len(shares) > _MOST_TOLD else ""
        return f"Ensemble: {len(self)} motions with {self.modes} modes; shares {told}{more}"

    def __len__(self) -> int:
        return int(self.code.size)

    @property
    def outcome(self) -> npt.NDArray[np.str_]:
        """How each ended, in words; shape (members,)."""
        return np.array(OUTCOMES)[self.code]

    @cached_property
    def label(self) -> npt.NDArray[np.str_]:
        """What motion each is at its end, as `Trajectory.label`; shape (members,)."""
        keys = np.stack(
            [self.code, self.cycle_impacts, self.cycle_periods, self.cycle_kind, self.wanders.astype(np.int64)], axis=1
        )
        kinds, which = np.unique(keys, axis=0, return_inverse=True)
        names = [
            label_of(OUTCOMES[code], Cycle(0, int(p), int(n), int(kind)) if n else None, bool(wanders))
            for code, p, n, kind, wanders in kinds.tolist()
        ]
        return np.array(names, dtype=str)[which.reshape(-1)]

    @property
    def shares(self) -> dict[str, float]:
        """The share of the members that ends in each motion, the most frequent first."""
        found = Counter(self.label.tolist())
        return {name: number / len(self) for name, number in found.most_common()}

    def to_xarray(self) -> xarray.Dataset:
        """All columns, over the dimensions ``member`` and ``last``."""
        from percuss.simulate.netcdf import ensemble_dataset

        columns = {field.name: getattr(self, field.name) for field in fields(self)}
        arrays = {name: values for name, values in columns.items() if isinstance(values, np.ndarray)}
        return ensemble_dataset(self.modes, {"label": self.label, "outcome": self.outcome, **arrays})
