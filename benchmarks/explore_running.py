"""Benchmarks of carrying jobs out: what the archive costs, and what a second worker brings."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from percuss import Load, System
from percuss.explore import Archive, carry_out
from percuss.explore.cells import SweepJob
from percuss.explore.sweeps import sweep_job

Row = tuple[str, str, str, str]

ROUNDS = 2


def labels(side: int) -> SweepJob:
    """A label map by simulation, as a user asks for: the items are very unlike."""
    system = System(s=20.0, d=0.0048, restitution=0.6, load=Load.harmonic(0.7, 1.0))
    axes = (f"restitution=0:0.9:{side}", f"load_factor=0.1:1:{side}")
    return sweep_job(system, *axes, quantities=["label", "blow_rate", "blow_scatter"], modes=0)


def archive_cost(job: SweepJob) -> tuple[float, float]:
    """Seconds of processor of a job, and those that its archive took of them.

    The difference of two runs would be lost in their noise, which is several parts in a hundred.
    """
    begin = time.process_time()
    import zarr  # noqa: F401  # a part of the price

    spent = [time.process_time() - begin]

    def counted(method: Callable[..., Any]) -> Callable[..., Any]:
        def call(*arguments: Any, **options: Any) -> Any:
            begin = time.process_time()
            found = method(*arguments, **options)
            spent.append(time.process_time() - begin)
            return found

        return call

    create, write, keep = Archive.__dict__["create"], Archive.write, Archive.keep
    Archive.create = classmethod(counted(create.__func__))  # type: ignore[assignment]
    Archive.write, Archive.keep = counted(write), counted(keep)  # type: ignore[method-assign]
    try:
        with tempfile.TemporaryDirectory() as folder:
            begin = time.process_time()
            carry_out(job, workers=1, archive=Path(folder) / "a.zarr")
            return time.process_time() - begin + spent[0], sum(spent)
    finally:
        Archive.create, Archive.write, Archive.keep = create, write, keep  # type: ignore[method-assign]


def speedup(job: SweepJob) -> tuple[float, float]:
    """Wall time of one worker over that of two, each with an archive; and the seconds of one."""
    one, two = [], []
    for _ in range(ROUNDS):
        for times, workers in ((one, 1), (two, 2)):
            with tempfile.TemporaryDirectory() as folder:
                begin = time.perf_counter()
                carry_out(job, workers=workers, archive=Path(folder) / "a.zarr")
                times.append(time.perf_counter() - begin)
    return float(np.median(one) / np.median(two)), float(np.median(one))


def explore_running() -> list[Row]:
    """All rows of the runner and the archive."""
    carry_out(labels(8), workers=1)  # the kernels
    whole, added = archive_cost(labels(200))
    ratio, seconds = speedup(labels(200))
    told = f"of {whole:.1f} s of processor time, label map of 200 × 200"
    return [
        ("archive, what it adds to a job", f"{100 * added / whole:.1f} %", "5 %", told),
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
