"""Benchmarks of carrying jobs out: what the archive costs, and what a second worker brings."""

from __future__ import annotations

import tempfile
import time
from pathlib import Path
from resource import RUSAGE_CHILDREN, RUSAGE_SELF, getrusage

import numpy as np

from percuss import Load, System
from percuss.explore import carry_out
from percuss.explore.sweeps import SweepJob, sweep_job

Row = tuple[str, str, str, str]

ROUNDS = 3


def labels(side: int) -> SweepJob:
    """A label map by simulation, as a user asks for: the items are very unlike."""
    system = System(s=20.0, d=0.0048, restitution=0.6, load=Load.harmonic(0.7, 1.0))
    axes = (f"restitution=0:0.9:{side}", f"load_factor=0.1:1:{side}")
    return sweep_job(system, *axes, quantities=["label", "blow_rate", "blow_scatter"], modes=0)


def processor_time() -> float:
    """Seconds of this process and of those that it has seen end."""
    return sum(used.ru_utime + used.ru_stime for used in (getrusage(RUSAGE_SELF), getrusage(RUSAGE_CHILDREN)))


def archive_cost(job: SweepJob) -> tuple[float, float]:
    """Seconds of processor without the archive, and what it adds; of one worker, so that nothing is hidden."""
    plain, kept = [], []
    for _ in range(ROUNDS):
        for times, archived in ((plain, False), (kept, True)):
            with tempfile.TemporaryDirectory() as folder:
                begin = processor_time()
                carry_out(job, workers=1, archive=Path(folder) / "a.zarr" if archived else None)
                times.append(processor_time() - begin)
    return float(np.median(plain)), float(np.median(kept) - np.median(plain))


def speedup(job: SweepJob) -> tuple[float, float]:
    """Wall time of one worker over that of two, each with an archive; and the seconds of one."""
    one, two = [], []
    for _ in range(ROUNDS - 1):
        for times, workers in ((one, 1), (two, 2)):
            with tempfile.TemporaryDirectory() as folder:
                begin = time.perf_counter()
                carry_out(job, workers=workers, archive=Path(folder) / "a.zarr")
                times.append(time.perf_counter() - begin)
    return float(np.median(one) / np.median(two)), float(np.median(one))


def explore_running() -> list[Row]:
    """All rows of the runner and the archive."""
    carry_out(labels(8), workers=1)  # the kernels
    plain, added = archive_cost(labels(120))
    ratio, seconds = speedup(labels(200))
    told = f"of {plain:.1f} s of processor time, label map of 120 × 120"
    return [
        ("archive, what it adds to a job", f"{100 * added / plain:.1f} %", "5 %", told),
        (
            "two workers beside one",
            f"{ratio:.2f} ×",
            "1.8 ×",
            f"{seconds:.1f} s of one, label map of 200 × 200, with the archive",
        ),
    ]


if __name__ == "__main__":
    for row in explore_running():
        print(*row, sep=" | ")
