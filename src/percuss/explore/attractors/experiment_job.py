"""What an experiment carries out: each start followed by itself, the same in any process."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

from percuss.errors import ParameterError
from percuss.explore.attractors.cycles import COLUMNS, followed
from percuss.explore.attractors.motion_columns import fingerprint, some, start_columns, start_values
from percuss.explore.attractors.start_distributions import DISTRIBUTIONS, drawn, named, own
from percuss.explore.jobs.job import ASK_FORMAT, Column, Columns
from percuss.explore.rough_time import seconds_of_start
from percuss.model import System
from percuss.model.checks import count, instance
from percuss.model.described import describe_system

if TYPE_CHECKING:
    from percuss.simulate import Starts, Stop

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
        Of `simulate_many` for one portion; the numbers do not depend on it.
    """

    system: System
    number: int
    distribution: str
    seed: int
    modes: int
    stop: Stop
    rows: Starts | None = None
    threads: int | None = 1

    def starts(self, first: int, last: int) -> Starts:
        """The starts `first` … `last` − 1, drawn where they are needed."""
        if self.rows is None:
            return named(self.system, self.distribution, last - first, self.seed, first)
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
        return self.size * seconds_of_start(self.modes)

    @property
    def columns(self) -> Mapping[str, Column]:
        """`COLUMNS`, and the starts."""
        shape = (1, 1) if self.rows is None else (self.rows.displacement.shape[1], self.rows.velocity.shape[1])
        return {**start_columns(*shape), **COLUMNS}

    @property
    def ask(self) -> dict[str, Any]:
        """What the numbers depend on."""
        asked = {
            "kind": "experiment",
            "percuss": ASK_FORMAT,
            "system": describe_system(self.system),
            "starts": self.number,
            "distribution": self.distribution,
            "seed": self.seed,
            "modes": self.modes,
            "stop": asdict(self.stop),
        }
        return asked if self.rows is None else {**asked, "rows": fingerprint(self.rows)}

    def compute(self, first: int, last: int, stopped: Callable[[], bool]) -> Columns:
        """The motions from starts `first` … `last` − 1."""
        part = self.starts(first, last)
        return {**start_values(part), **followed(self.system, part, self.modes, self.stop, self.threads, stopped)}


def experiment_job(
    system: System,
    starts: int | None = None,
    distribution: str | os.PathLike[str] | Starts | Callable[[int], Starts] = "wall",
    seed: int = 0,
    *,
    modes: int = 0,
    stop: Stop | None = None,
    threads: int | None = 1,
) -> ExperimentJob:
    """What `experiment` carries out."""
    from percuss.simulate import Starts, Stop
    from percuss.simulate.spectrum import Spectrum

    instance("system", system, System)
    kept = count("modes", modes, least=0, most=4096)
    stop = Stop() if stop is None else instance("stop", stop, Stop)
    count("impacts", stop.impacts)
    Spectrum(system, kept)  # a resonance is an error here, not in a worker
    seed = count("seed", seed, least=0)
    number = None if starts is None else count("starts", starts, most=_MOST_STARTS)
    if isinstance(distribution, str) and distribution in DISTRIBUTIONS:
        job = ExperimentJob(system, number or DEFAULT_STARTS, distribution, seed, kept, stop, None, threads)
        named(system, distribution, 1, seed)  # refuses what cannot be drawn now, not in a worker
        return job
    rows = own(system, distribution, seed)
    if rows.displacement[:, kept + 1 :].any() or rows.velocity[:, kept + 1 :].any():
        most = max(rows.displacement.shape[1], rows.velocity.shape[1]) - 1
        raise ParameterError("distribution", f"amplitudes of {most} modes", f"at most {kept}", "use more modes")
    if isinstance(distribution, Starts):
        name = "starts"
    elif callable(distribution):
        name = str(getattr(distribution, "__qualname__", type(distribution).__name__))
    else:
        name = os.path.basename(os.fspath(distribution))
    return ExperimentJob(system, number or len(rows), name, seed, kept, stop, rows, threads)
