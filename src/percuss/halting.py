"""A computation can be told to stop: long loops check whether the result is still wanted.

Steady motions compute what is asked of them when it is asked, in many places: what stops them is therefore not handed
from call to call but holds for a block, and only for the thread that the block runs in.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from typing import TypeVar

from percuss.errors import Interrupted

Answer = TypeVar("Answer")
Item = TypeVar("Item")

_asked: ContextVar[Callable[[], bool] | None] = ContextVar("percuss_halt", default=None)


@contextmanager
def halting(halt: Callable[[], bool] | None) -> Iterator[None]:
    """A block whose long loops end with `Interrupted` soon after its `halt`, or that of a block around, says true."""
    around = _asked.get()
    both = halt if around is None else around if halt is None else lambda: halt() or around()
    before = _asked.set(both)
    try:
        yield
    finally:
        _asked.reset(before)


def look() -> None:
    """What a long loop does now and then.

    Raises
    ------
    Interrupted
        When the computation was told to stop.
    """
    halt = _asked.get()
    if halt is not None and halt():
        raise Interrupted(0, 1, None)


def on_threads(work: Callable[[Item], Answer], items: Sequence[Item], threads: int) -> list[Answer]:
    """What comes of each item, on so many threads; between them it is looked whether to stop."""
    found = []
    if threads == 1 or len(items) < 2:
        for item in items:
            look()
            found.append(work(item))
        return found
    from concurrent.futures import ThreadPoolExecutor  # most calls do without

    with ThreadPoolExecutor(max_workers=min(threads, len(items)), thread_name_prefix="percuss") as pool:
        try:
            for one in pool.map(work, items):
                look()
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
        look()
    if failed:
        raise failed[0]
    return found[0]
