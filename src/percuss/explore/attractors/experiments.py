"""Random starts and where they end: shares of the attractors, the same for any number of workers."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from percuss.explore.attractors.experiment_job import ExperimentJob, experiment_job
from percuss.explore.attractors.grouping import DISTANCE
from percuss.explore.attractors.hammer import Hammer
from percuss.explore.attractors.hammers import hammer_from, hammer_of
from percuss.explore.attractors.motion_columns import done
from percuss.explore.attractors.motion_dataset import dataset_of
from percuss.explore.attractors.shares import Share, share_of, wilson
from percuss.explore.jobs.job import Columns
from percuss.model import Machine, System
from percuss.model.checks import non_negative
from percuss.shown import Shown

if TYPE_CHECKING:
    import xarray

    from percuss.explore.attractors.hammer import AnyAttractor, AnyStarts
    from percuss.simulate import Stop

__all__ = ["Experiment", "ExperimentJob", "experiment", "experiment_job"]


@dataclass(frozen=True, eq=False)
class Experiment(Shown):
    """The results of random starts; made by `experiment`.

    Parameters
    ----------
    system, modes, stop
        What was followed.
    distribution, seed
        What the starts were drawn from, and with.
    columns
        One row for each start: the start, how it ended and the numbers of its motion; see `dataset`.
    distance
        What tells attractors of one label apart; see `percuss.explore.attractors.grouping.matched`.
    """

    system: System | Machine
    modes: int
    stop: Stop
    distribution: str
    seed: int
    columns: Columns = field(repr=False)
    distance: float = DISTANCE

    @classmethod
    def of(cls, job: ExperimentJob, columns: Columns, distance: float = DISTANCE) -> Experiment:
        """The result of a job."""
        return cls(job.system, job.modes, job.stop, job.distribution, job.seed, columns, distance)

    @classmethod
    def from_archive(cls, archive: Any) -> Experiment:
        """The experiment that an archive holds, of those starts that are done."""
        from percuss.simulate import Stop

        ask, columns = archive.ask, archive.read()
        whole = done(columns)
        kept = {name: np.asarray(values)[whole] for name, values in columns.items()}
        system, stop = hammer_from(ask), Stop(**ask["stop"])
        return cls(system, int(ask["modes"]), stop, ask["distribution"], int(ask["seed"]), kept)

    def __len__(self) -> int:
        return int(self.columns["code"].size)

    @cached_property
    def hammer(self) -> Hammer:
        """What was followed, as it is asked."""
        return hammer_of(self.system)

    @property
    def starts(self) -> AnyStarts:
        """All starts."""
        return self.hammer.starts_from(self.columns)

    @cached_property
    def attractor(self) -> npt.NDArray[np.int64]:
        """The number of the attractor of each start, 0 for the most frequent; shape (starts,)."""
        return self.hammer.matched(self.columns, self.distance)

    @cached_property
    def label(self) -> npt.NDArray[np.str_]:
        """What motion each start ends in, as `Trajectory.label` or `MachineTrajectory.label`; shape (starts,)."""
        return self.hammer.labels(self.columns)

    @cached_property
    def attractors(self) -> tuple[AnyAttractor, ...]:
        """The attractors, the most frequent first."""
        return self.hammer.attractors(self.columns, self.attractor, self.starts, self.modes, self.stop)

    @cached_property
    def shares(self) -> tuple[Share, ...]:
        """The share of the starts that ends in each attractor, with 95 % intervals; the most frequent first."""
        return tuple(share_of(attractor, len(self)) for attractor in self.attractors)

    @cached_property
    def labels(self) -> dict[str, tuple[float, float, float]]:
        """Share, lower and upper end of its interval for each label, the most frequent first."""
        found: Counter[str] = Counter()
        for attractor in self.attractors:
            found[attractor.label] += attractor.members
        return {name: (k / len(self), *wilson(k, len(self))) for name, k in found.most_common()}

    @cached_property
    def dataset(self) -> xarray.Dataset:
        """All columns over the dimension ``start``, and the attractors over ``attractor``, with units and meanings."""
        return dataset_of(
            self.columns,
            ("start",),
            self.attractor,
            self.shares,
            self.hammer,
            {
                "title": f"percuss experiment: {len(self)} starts, {self.distribution}, seed {self.seed}",
                "distribution": self.distribution,
                "seed": self.seed,
                "modes": self.modes,
                self.hammer.kind: str(self.system),
            },
        )

    def to_json_dict(self) -> dict[str, Any]:
        """What ``percuss experiment --json`` prints: plain numbers, the most frequent attractor first."""
        return {
            "starts": len(self),
            "seed": self.seed,
            "distribution": self.distribution,
            "modes": self.modes,
            "shares": [
                {
                    "label": share.label,
                    "share": share.share,
                    "low": share.low,
                    "high": share.high,
                    **share.attractor.figures,
                }
                for share in self.shares
            ],
        }

    def __str__(self) -> str:
        head = f"Experiment: {len(self)} starts, {self.distribution}, seed {self.seed}, {self.modes} modes"
        return "\n".join([head, *(f"  {share}" for share in self.shares)])


def experiment(
    system: System | Machine,
    starts: int | None = None,
    distribution: str | os.PathLike[str] | AnyStarts | Callable[[int], AnyStarts] = "wall",
    seed: int = 0,
    *,
    modes: int = 0,
    stop: Stop | None = None,
    distance: float = DISTANCE,
    threads: int | None = 1,
    **running: Any,
) -> Experiment:
    """Follow random starts to what they settle on; the shares of the attractors, with intervals.

    The same seed gives the same numbers to the last bit, whatever the number of workers.

    Parameters
    ----------
    system
        What moves, dimensionless: a system whose load keeps time, or a machine that switches its own valve.
    starts
        How many; 100 000 by default, or as many as one's own distribution has rows.
    distribution
        ``wall``, ``field`` or ``gentle`` (see `percuss.explore.attractors.start_distributions.named`, and
        `percuss.explore.attractors.machine_draws.drawn_machines` for machines), a file of starts, `Starts` or
        `MachineStarts`, or a function that makes them from the seed. More starts than there are rows are drawn from
        them by chance.
    seed
        0 or greater.
    modes
        N, the elastic modes kept; 0 is the rigid bar.
    stop
        When a motion ends; by default after 2000 impacts or when a periodic motion is found. See
        `percuss.simulate.Stop` for its tolerance.
    distance
        How far apart motions of one label are different attractors (radians, relative periods and speeds).
    threads
        Threads of each process; processes are what `workers` counts.
    running
        ``workers``, ``archive``, ``resume``, ``chunk``, ``pool``, ``progress`` as `percuss.explore.carry_out` has them.

    Returns
    -------
    Experiment
        With `shares`, the columns of all starts as `dataset`, and `to_json_dict`.

    Raises
    ------
    ParameterError
        For numbers out of range, an unknown distribution or a file that holds no starts.
    ResonanceError
        When a harmonic of the load meets an undamped elastic mode.

    Examples
    --------
    >>> from percuss import Load, System
    >>> system = System(s=20.0, d=0.0, restitution=0.6, load=Load.harmonic(0.7, 1.0))
    >>> found = experiment(system, 500, "wall", seed=1, workers=1)
    >>> [share.label for share in found.shares]
    ['chatter/1', 'z=2/2']
    """
    job = experiment_job(system, starts, distribution, seed, modes=modes, stop=stop, threads=threads)
    apart = non_negative("distance", distance)
    from percuss.explore.jobs.carrying_out import carry_out

    return Experiment.of(job, carry_out(job, **running), apart)
