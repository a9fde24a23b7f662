"""Computations off the event loop: only so many at once, each with a way to be stopped."""

from __future__ import annotations

import asyncio
import threading
import time
from collections.abc import AsyncIterator, Callable
from concurrent.futures import CancelledError, Future, ThreadPoolExecutor
from contextlib import asynccontextmanager, suppress
from typing import TYPE_CHECKING, TypeVar

from percuss.errors import Interrupted
from percuss.web.request_bodies import refused

if TYPE_CHECKING:
    from starlette.requests import Request

    from percuss.web.settings import Limits

T = TypeVar("T")

_LOOK = 0.1
"""Seconds between two looks at whether the client is still there."""


class Halt:
    """Tells a computation that nobody waits for it any more; call it as its progress callback.

    Parameters
    ----------
    seconds
        After which it says so by itself.
    """

    def __init__(self, seconds: float) -> None:
        self._event = threading.Event()
        self._until = time.monotonic() + seconds

    def stop(self) -> None:
        """From now on the answer is yes."""
        self._event.set()

    @property
    def late(self) -> bool:
        """Whether the time is up."""
        return time.monotonic() > self._until

    def __call__(self, *_: object) -> bool:
        return self._event.is_set() or self.late


class Lane:
    """Computations of one kind: so many at once, a few more in line, and the rest is told to come again.

    Parameters
    ----------
    name
        Of the threads.
    at_once, waiting
        How many are computed, and how many may wait.
    """

    def __init__(self, name: str, at_once: int, waiting: int) -> None:
        self._pool = ThreadPoolExecutor(max_workers=at_once, thread_name_prefix=f"percuss-{name}")
        self._most = at_once + waiting
        self._taken = 0
        self._halts: set[Halt] = set()
        self.closed = False

    @asynccontextmanager
    async def place(self, seconds: float) -> AsyncIterator[Halt]:
        """A place in the lane for the length of the block.

        Raises
        ------
        Refusal
            429 when there is none, 503 when the server stops.
        """
        if self.closed:
            raise refused(503, "the server is stopping")
        if self._taken >= self._most:
            raise refused(429, "too many computations at once", "try again in a second")
        halt = Halt(seconds)
        self._taken += 1
        self._halts.add(halt)
        try:
            yield halt
        finally:
            halt.stop()
            self._taken -= 1
            self._halts.discard(halt)

    def submit(self, work: Callable[[], T]) -> Future[T]:
        """Begin the work when a thread is free."""
        return self._pool.submit(work)

    async def run(self, request: Request, seconds: float, work: Callable[[Halt], T]) -> T:
        """The result of a piece of work, stopped when the client leaves or the time is up.

        Raises
        ------
        Refusal
            429, 503; see `place`. 503 also when it took too long.
        """
        async with self.place(seconds) as halt:
            running = self.submit(lambda: work(halt))
            ended = _told_when_done(running)
            try:
                while not await _within(ended, _LOOK):
                    if self.closed:
                        raise refused(503, "the server is stopping")
                    if halt.late:
                        raise refused(503, "it took too long", "ask for less")
                    if await request.is_disconnected():
                        raise refused(503, "the client no longer waits for the answer")
            finally:
                self.hold(running)
            try:
                return running.result()
            except CancelledError:  # it was in line when the lane was closed
                raise refused(503, "the server is stopping") from None
            except Interrupted:  # it looked at the clock before we did
                raise refused(503, "it took too long", "ask for less") from None

    def hold(self, running: Future[T]) -> None:
        """Keep a place taken while work that was given up goes on, so that no more than is allowed ever runs."""
        if running.done() or running.cancel():
            return
        self._taken += 1
        loop = asyncio.get_running_loop()

        def ended(_: Future[T]) -> None:
            try:
                loop.call_soon_threadsafe(self._leave)
            except RuntimeError:  # the loop is gone, and nobody else counts
                self._leave()

        running.add_done_callback(ended)

    def _leave(self) -> None:
        self._taken -= 1

    def close(self) -> None:
        """Stop everything; nothing new begins."""
        self.closed = True
        for halt in list(self._halts):
            halt.stop()
        self._pool.shutdown(wait=False, cancel_futures=True)


def _told_when_done(running: Future[T]) -> asyncio.Event:
    """An event of the running loop that is set when the work has ended, well or badly.

    Not `asyncio.wrap_future`: what the work raised when nobody waits for it any more would be found by the loop at the
    end, and complained of.
    """
    loop, ended = asyncio.get_running_loop(), asyncio.Event()

    def tell(_: Future[T]) -> None:
        with suppress(RuntimeError):  # the loop may be gone
            loop.call_soon_threadsafe(ended.set)

    running.add_done_callback(tell)
    return ended


async def _within(event: asyncio.Event, seconds: float) -> bool:
    """Whether an event is set within some time."""
    try:
        async with asyncio.timeout(seconds):
            await event.wait()
    except TimeoutError:
        return False
    return True


class Gate:
    """The lanes of one worker: quick answers never wait for long computations."""

    def __init__(self, limits: Limits) -> None:
        self.quick = Lane("quick", limits.quick, limits.quick_waiting)
        self.heavy = Lane("heavy", limits.heavy, limits.heavy_waiting)
        self.experiments = Lane("experiment", limits.experiments, 0)
        self.closed = False
        self.intake = Intake(limits.held_bytes)
        self._waits: set[asyncio.Timeout] = set()

    @asynccontextmanager
    async def waiting(self, seconds: float | None = None) -> AsyncIterator[asyncio.Timeout]:
        """A block that waits for others: for some seconds, and not beyond the end of the server.

        Raises
        ------
        Refusal
            408 when the time is up, 503 when the server stops.
        """
        if self.closed:
            raise refused(503, "the server is stopping")
        try:
            async with asyncio.timeout(seconds) as limit:
                self._waits.add(limit)
                try:
                    yield limit
                finally:
                    self._waits.discard(limit)
                    self.intake.drop(limit)
        except TimeoutError:
            if self.closed:
                raise refused(503, "the server is stopping") from None
            raise refused(408, "the request did not come in time", close=True) from None

    def close(self) -> None:
        """Stop everything; once is enough."""
        if self.closed:
            return
        self.closed = True
        for lane in (self.quick, self.heavy, self.experiments):
            lane.close()
        for limit in list(self._waits):
            _expire(limit)


class Intake:
    """Bodies that come in, bounded all together: when they are too much, the one that began first is given up.

    It is the one that has taken longest; those that come in at the pace of a network are gone before it is their turn.

    Parameters
    ----------
    most
        Bytes.
    """

    def __init__(self, most: int) -> None:
        self._most = most
        self._held: dict[asyncio.Timeout, int] = {}

    def add(self, limit: asyncio.Timeout, size: int) -> None:
        """So many more bytes have come within this wait."""
        self._held[limit] = self._held.get(limit, 0) + size
        while sum(self._held.values()) > self._most:
            first = next(iter(self._held))
            self.drop(first)
            _expire(first)

    def drop(self, limit: asyncio.Timeout) -> None:
        """This wait has ended."""
        self._held.pop(limit, None)


def _expire(limit: asyncio.Timeout) -> None:
    if not limit.expired():  # else it ends by itself, and could not be told again
        limit.reschedule(0.0)
