"""An experiment that is watched: the shares so far while it goes on, the same numbers at its end."""

from __future__ import annotations

import math
import os
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from percuss.case.answers.json_values import number

if TYPE_CHECKING:
    from percuss.explore import Experiment
    from percuss.explore.attractors.experiments import ExperimentJob
    from percuss.explore.jobs.job import Columns

__all__ = ["Watched", "watched_experiment"]

_LOOK = 0.25
"""Seconds of work between two looks."""

_MOST_SHARES = 16


@dataclass(frozen=True)
class Watched:
    """How far an experiment is.

    Attributes
    ----------
    done, size
        Starts that are followed, of how many.
    rate
        Starts per second.
    shares
        Of the labels found so far, the most frequent first: share and interval of 95 %.
    found
        The experiment as far as it has come: its first `done` starts.
    """

    done: int
    size: int
    rate: float
    shares: tuple[tuple[str, float, float, float], ...]
    found: Experiment

    @property
    def is_done(self) -> bool:
        """Whether all starts have been followed."""
        return self.done == self.size

    def to_json_dict(self) -> dict[str, Any]:
        """In plain values."""
        left = (self.size - self.done) / self.rate if self.rate > 0.0 else math.nan
        return {
            "done": self.done,
            "size": self.size,
            "fraction": self.done / self.size,
            "rate": number(self.rate),
            "seconds_left": number(left),
            "shares": [
                {"label": label, "share": number(share), "low": number(low), "high": number(high)}
                for label, share, low, high in self.shares
            ],
        }


def watched_experiment(job: ExperimentJob, stopped: Callable[[], bool], first: int | None = None) -> Iterator[Watched]:
    """Follow the starts of an experiment portion by portion; the last one yielded has all of them.

    Parameters
    ----------
    job
        The experiment. Its numbers do not depend on the portions nor on the number of threads.
    stopped
        Asked now and then; when it says so nothing more is yielded.
    first
        Follow only so many of the starts, those that come first; None for all. They are the same ones, and come to
        the same, as in the whole experiment.
    """
    from percuss.explore.attractors.experiments import Experiment

    job = replace(job, threads=os.cpu_count() or 1)
    parts: list[Columns] = []
    size = job.size if first is None else min(first, job.size)
    done, portion, spent = 0, min(16, size), 0.0
    while done < size:
        begun = time.perf_counter()
        last = min(done + portion, size)
        columns = job.compute(done, last, stopped)
        if stopped():
            return
        took = time.perf_counter() - begun
        spent += took
        parts.append(columns)
        portion = max(1, min(int((last - done) * _LOOK / max(took, 1e-6)), 8 * portion))
        done = last
        so_far = {name: np.concatenate([part[name] for part in parts]) for name in columns}
        parts = [so_far]
        found = Experiment.of(job, so_far)
        labels = tuple((label, *interval) for label, interval in list(found.labels.items())[:_MOST_SHARES])
        yield Watched(done, size, done / max(spent, 1e-9), labels, found)
