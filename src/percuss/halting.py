"""A computation can be told to stop: long loops check whether the result is still wanted.

Steady motions compute what is asked of them when it is asked, in many places: what stops them is therefore not handed
from call to call but holds for a block, and only for the thread that the block runs in.
"""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from typing import TypeVar

from percuss.errors import Interrupted

Answer = TypeVar("Answer")
Item = TypeVar("Item")

_halt: ContextVar[Callable[[], bool] | None] = ContextVar("percuss_halt", default=None)


@dataclass(frozen=True)
class Elapsed:
    """How far what has no known length has come: `seconds` since it began; its `fraction` is NaN."""

    seconds: float
    fraction: float = math.nan


class Asked:
    """A progress callback in the form in which long loops ask it whether they are to end."""

    def __init__(self, progress: Callable[[Elapsed], object]) -> None:
        self._progress = progress
        self._begun = time.monotonic()

    def __call__(self, *_: object) -> bool:
        return bool(self._progress(Elapsed(time.monotonic() - self._begun)))


def asked(progress: Callable[[Elapsed], object] | None) -> Asked | None:
    """A progress callback as `halting` takes it; one that is asked already stays, with its seconds."""
    return progress if progress is None or isinstance(progress, Asked) else Asked(progress)


@contextmanager
def halting(halt: Callable[[], bool] | None) -> Iterator[None]:
    """A block whose long loops end with `Interrupted` soon after its `halt`, or that of a block around, says true."""
    around = _halt.get()
    both = halt if around is None else around if halt is None else lambda: halt() or around()
    before = _halt.set(both)
    try:
        yield
    finally:
        _halt.reset(before)


def check_interrupted() -> None:
    """What a long loop does now and then.

    Raises
    ------
    Interrupted
        When the computation was told to stop.
    """
    halt = _halt.get()
    if halt is not None and halt():
        raise Interrupted(0, 1, None)


def on_threads(work: Callable[[Item], Answer], items: Sequence[Item], threads: int) -> list[Answer]:
    """What comes of each item, on so many threads; between them it is looked whether to stop."""
    found = []
    if threads == 1 or len(items) < 2:
        for item in items:
            check_interrupted()
            found.append(work(item))
        return found
    from concurrent.futures import ThreadPoolExecutor  # most calls do without

    with ThreadPoolExecutor(max_workers=min(threads, len(items)), thread_name_prefix="percuss") as pool:
        try:
            for one in pool.map(work, items):
                check_interrupted()
                found.append(one)
        except BaseException:
            pool.shutdown(wait=True, cancel_futures=True)
            raise
    return found


def interruptible(work: Callable[[], Answer]) -> Answer:
    """What a long call into a library answers, left to itself once nobody waits; Interrupted when told to stop."""
    found: list[Answer] = []
    failed: list[BaseException] = []

    def called() -> None:
        try:
            found.append(work())
        except BaseException as error:  # whatever it is, it belongs to who asked
            failed.append(error)

    thread = threading.Thread(target=called, daemon=True)
    thread.start()
    while thread.is_alive():
        thread.join(0.05)
        check_interrupted()
    if failed:
        raise failed[0]
    return found[0]
