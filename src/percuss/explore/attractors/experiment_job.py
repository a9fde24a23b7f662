"""What an experiment carries out: each start followed by itself, the same in any process."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

from percuss.errors import ParameterError
from percuss.explore.attractors.hammer import Hammer
from percuss.explore.attractors.hammers import hammer_of
from percuss.explore.attractors.motion_columns import bars_of, fingerprint, some
from percuss.explore.attractors.start_distributions import DISTRIBUTIONS, drawn
from percuss.explore.jobs.job import ASK_FORMAT, Column, Columns
from percuss.model import Machine, System
from percuss.model.checks import count, instance

if TYPE_CHECKING:
    from percuss.explore.attractors.hammer import AnyStarts
    from percuss.simulate import Stop

__all__ = ["DEFAULT_STARTS", "ExperimentJob", "experiment_job"]

DEFAULT_STARTS = 100_000
_MOST_STARTS = 10**12


@dataclass(frozen=True, eq=False)
class ExperimentJob:
    """The starts of one experiment, each followed by itself; see `experiment`.

    Parameters
    ----------
    system, modes, stop
        What is followed, with how many elastic modes, and until when.
    number, seed
        How many starts, and what they are drawn with.
    distribution
        A name of `percuss.explore.DISTRIBUTIONS`, or what one's own starts are called.
    rows
        One's own starts, or None for a named distribution.
    threads
        Of one portion; the numbers do not depend on it.
    """

    system: System | Machine
    number: int
    distribution: str
    seed: int
    modes: int
    stop: Stop
    rows: AnyStarts | None = None
    threads: int | None = 1

    @cached_property
    def hammer(self) -> Hammer:
        """What is followed, as it is asked."""
        return hammer_of(self.system)

    def starts(self, first: int, last: int) -> AnyStarts:
        """The starts `first` … `last` − 1, drawn where they are needed."""
        if self.rows is None:
            return self.hammer.named(self.distribution, last - first, self.seed, first)
        if self.number > len(self.rows):
            return drawn(self.rows, last - first, self.seed, first)
        return some(self.rows, slice(first, last))

    @property
    def size(self) -> int:
        """Number of starts."""
        return self.number

    @property
    def rough_seconds(self) -> float:
        """What all starts take, by rule of thumb."""
        return self.size * self.hammer.rough_seconds(self.modes)

    @property
    def columns(self) -> Mapping[str, Column]:
        """The numbers of the motions, and the starts."""
        bars = None if self.rows is None else bars_of(self.rows)
        shape = (1, 1) if bars is None else (bars.displacement.shape[1], bars.velocity.shape[1])
        return {**self.hammer.start_columns(*shape), **self.hammer.columns}

    @property
    def ask(self) -> dict[str, Any]:
        """What the numbers depend on."""
        asked = {
            "kind": "experiment",
            "percuss": ASK_FORMAT,
            **self.hammer.described,
            "starts": self.number,
            "distribution": self.distribution,
            "seed": self.seed,
            "modes": self.modes,
            "stop": asdict(self.stop),
        }
        return asked if self.rows is None else {**asked, "rows": fingerprint(self.rows)}

    def compute(self, first: int, last: int, stopped: Callable[[], bool]) -> Columns:
        """The motions from starts `first` … `last` − 1."""
        part, hammer = self.starts(first, last), self.hammer
        return {**hammer.start_values(part), **hammer.followed(part, self.modes, self.stop, self.threads, stopped)}


def experiment_job(
    system: System | Machine,
    starts: int | None = None,
    distribution: str | os.PathLike[str] | AnyStarts | Callable[[int], AnyStarts] = "wall",
    seed: int = 0,
    *,
    modes: int = 0,
    stop: Stop | None = None,
    threads: int | None = 1,
) -> ExperimentJob:
    """What `experiment` carries out."""
    from percuss.simulate import MachineStarts, Starts, Stop

    hammer = hammer_of(system)
    kept = count("modes", modes, least=0, most=4096)
    stop = Stop() if stop is None else instance("stop", stop, Stop)
    count("impacts", stop.impacts)
    hammer.check(kept)  # a resonance is an error here, not in a worker
    seed = count("seed", seed, least=0)
    number = None if starts is None else count("starts", starts, most=_MOST_STARTS)
    if isinstance(distribution, str) and distribution in DISTRIBUTIONS:
        job = ExperimentJob(system, number or DEFAULT_STARTS, distribution, seed, kept, stop, None, threads)
        hammer.named(distribution, 1, seed)  # refuses what cannot be drawn now, not in a worker
        return job
    rows = hammer.own(distribution, seed)
    bars = bars_of(rows)
    if bars.displacement[:, kept + 1 :].any() or bars.velocity[:, kept + 1 :].any():
        most = max(bars.displacement.shape[1], bars.velocity.shape[1]) - 1
        raise ParameterError("distribution", f"amplitudes of {most} modes", f"at most {kept}", "use more modes")
    if isinstance(distribution, Starts | MachineStarts):
        name = "starts"
    elif callable(distribution):
        name = str(getattr(distribution, "__qualname__", type(distribution).__name__))
    else:
        name = os.path.basename(os.fspath(distribution))
    return ExperimentJob(system, number or len(rows), name, seed, kept, stop, rows, threads)
