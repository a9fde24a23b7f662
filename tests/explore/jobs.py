"""Jobs without physics, importable by worker processes: what they compute depends on the number of the item alone."""

from __future__ import annotations

import os
import signal
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from percuss.explore.jobs.job import Column, Columns

COLUMNS = {
    "sine": Column(unit="rad", meaning="sine of the number"),
    "powers": Column(shape=(3,)),
    "remainder": Column("int16", meaning="of a division by 7"),
    "even": Column("bool"),
}


@dataclass(frozen=True)
class Sines:
    """Each item sleeps, or keeps a core busy, for so many seconds."""

    size: int = 100
    sleep: float = 0.0
    burn: float = 0.0
    kind: str = "sines"

    @property
    def columns(self) -> dict[str, Column]:
        return COLUMNS

    @property
    def ask(self) -> dict[str, Any]:
        return {"kind": self.kind, "size": self.size, "seed": 3}

    def compute(self, first: int, last: int, stopped: Callable[[], bool]) -> Columns:
        for i in range(first, last):
            self.one(i)
            self.wait(stopped)
        items = np.arange(first, last)
        x = np.sin(items * 1.37)
        x[items % 11 == 3] = np.nan
        return {"sine": x, "powers": x[:, None] ** np.arange(1, 4), "remainder": items % 7, "even": items % 2 == 0}

    def one(self, i: int) -> None:
        """For those that fail."""

    def wait(self, stopped: Callable[[], bool]) -> None:
        if self.sleep:
            until = time.monotonic() + self.sleep
            while time.monotonic() < until and not stopped():
                time.sleep(min(0.02, self.sleep))
        if self.burn:
            until = time.process_time() + self.burn
            while time.process_time() < until and not stopped():
                np.sin(np.arange(1000.0)).sum()


@dataclass(frozen=True)
class Grid(Sines):
    """A plane of a sweep."""

    size: int = 12
    kind: str = "sweep"

    @property
    def ask(self) -> dict[str, Any]:
        axes = [
            {"name": "restitution", "unit": "", "values": [0.0, 0.3, 0.6]},
            {"name": "frequency", "unit": "Hz", "values": [10.0, 20.0, 30.0, 40.0]},
        ]
        return {"kind": "sweep", "percuss": 1, "axes": axes, "system": {"s": float("inf")}}


@dataclass(frozen=True)
class Raises(Sines):
    """One item raises, which it must not."""

    bad: int = 50

    def one(self, i: int) -> None:
        if i == self.bad:
            raise ZeroDivisionError(f"item {i}")


@dataclass(frozen=True)
class Kills(Sines):
    """One item kills its process; only the first time when there is a file for it to remember by."""

    bad: int = 50
    memory: str = ""

    def one(self, i: int) -> None:
        if i == self.bad:
            if self.memory:
                try:
                    Path(self.memory).touch(exist_ok=False)
                except FileExistsError:
                    return
            os.kill(os.getpid(), signal.SIGKILL)


@dataclass(frozen=True)
class Marks(Sines):
    """Leaves the number of the process behind, for tests that look whether it has ended."""

    folder: str = ""

    def one(self, i: int) -> None:
        (Path(self.folder) / str(os.getpid())).touch()


def whole(job: Sines) -> Columns:
    """What the job computes, without waiting."""
    return Sines(job.size).compute(0, job.size, lambda: False)


def same(one: Columns, other: Columns) -> bool:
    """Bit for bit."""
    return one.keys() == other.keys() and all(
        np.asarray(one[name], dtype=COLUMNS[name].dtype).tobytes()
        == np.asarray(other[name], dtype=COLUMNS[name].dtype).tobytes()
        for name in one
    )


if __name__ == "__main__":  # jobs.py ARCHIVE SIZE SLEEP CHUNK WORKERS: carry one out, going on where it was left
    from percuss.explore.jobs.carrying_out import carry_out

    path, size, sleep, chunk, workers = sys.argv[1:]
    carry_out(
        Sines(int(size), sleep=float(sleep)), archive=path, resume=True, workers=int(workers), chunk=int(chunk) or None
    )
    print("complete")
