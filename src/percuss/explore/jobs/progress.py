"""How far a job has come, how fast it runs, and whether its answer is still wanted."""

from __future__ import annotations

import math
import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass

_LOOK = 0.1  # seconds between two calls of whoever watches

_MEMORY = 30.0  # seconds over which the rate is taken

_APART = 0.05  # seconds between two parts of an item that the rate remembers


@dataclass(frozen=True)
class JobProgress:
    """How far a job has come.

    Attributes
    ----------
    done, size
        Items done, also those of an earlier session, and all of them.
    rate
        Items per second; NaN while it is being measured.
    seconds_left
        Until all are done, at this rate; NaN while it is being measured.
    bytes
        That the results take, in memory and, before they are compressed, on disk.
    damaged
        Chunks of an earlier session that were lost or changed on the disk, and are computed again.
    part
        How much of the item under way is done, 0 to 1, where that is known; the rate and what is left count it.
    """

    done: int
    size: int
    rate: float
    seconds_left: float
    bytes: int
    damaged: int = 0
    part: float = 0.0

    @property
    def fraction(self) -> float:
        """0 to 1."""
        return (self.done + self.part) / self.size if self.size else 1.0


class Meter:
    """Counts what is done and tells whoever watches; remembers that they asked for the end."""

    def __init__(self, size: int, bytes_: int, watcher: Callable[[JobProgress], object] | None) -> None:
        self.size = size
        self.done = 0
        self.part = 0.0
        self.expected = math.nan  # items per second, until some are counted
        self.stopped = False
        self.damaged = 0
        self._bytes = bytes_
        self._watcher = watcher
        self._looked = -math.inf
        self._past: deque[tuple[float, float]] = deque()

    def start(self, done: int, expected: float = math.nan) -> None:
        """The rate counts from here; `done` were done before."""
        self.done, self.expected = done, expected
        self._past = deque([(time.monotonic(), done)])

    def add(self, items: int) -> None:
        """So many more are done."""
        self.done += items
        self.part = 0.0
        self._remember(time.monotonic())

    def within(self, part: float) -> None:
        """So much of the item under way is done, 0 to 1; never less than before."""
        self.part = max(self.part, part)
        now = time.monotonic()
        if self._past and now - self._past[-1][0] >= _APART:
            self._remember(now)

    def _remember(self, now: float) -> None:
        self._past.append((now, self.done + self.part))
        while len(self._past) > 2 and self._past[1][0] < now - _MEMORY:
            self._past.popleft()

    @property
    def rate(self) -> float:
        """Items per second, lately."""
        if len(self._past) < 2:
            return self.expected
        (since, before), (now, after) = self._past[0], self._past[-1]
        return (after - before) / (now - since) if now > since else self.expected

    def progress(self) -> JobProgress:
        rate, left = self.rate, self.size - self.done - self.part
        seconds = 0.0 if not left else left / rate if rate > 0.0 else math.nan
        return JobProgress(self.done, self.size, rate, seconds, self._bytes, self.damaged, self.part)

    def tell(self) -> bool:
        """Call the watcher now; returns whether the job is no longer wanted."""
        self._looked = time.monotonic()
        if self._watcher is not None and self._watcher(self.progress()):
            self.stopped = True
        return self.stopped

    def __call__(self) -> bool:
        """Whether the job is to stop, asked by jobs while they compute: calls `tell`, but not too often."""
        if not self.stopped and time.monotonic() - self._looked >= _LOOK:
            self.tell()
        return self.stopped
