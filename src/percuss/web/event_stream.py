"""Long computations told while they go on: server-sent events from a thread, until the last or the client leaves."""

from __future__ import annotations

import asyncio
import json
import logging
from collections.abc import AsyncIterator, Awaitable, Callable, Iterator
from concurrent.futures import Future
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from starlette.requests import Request
from starlette.responses import StreamingResponse

from percuss.errors import PercussError
from percuss.web.problem_json import problem, problems_of
from percuss.web.shared_by_routes import PROBLEMS

if TYPE_CHECKING:
    from starlette.types import Receive, Scope, Send

    from percuss.web.lanes import Halt, Lane

__all__ = ["STREAM", "Tell", "failures_told", "streamed"]

Tell = Callable[[str, Any], None]
"""Sends an event: its name, and what it says."""

_PING = 1.0
"""Seconds of silence after which a comment is sent: writing is how a closed connection shows."""

_LOOK = 0.1
"""Seconds between two looks at whether the client is still there, and the server not ending."""

_log = logging.getLogger("percuss.web")

STREAM: dict[int | str, dict[str, Any]] = {
    200: {"description": "server-sent events", "content": {"text/event-stream": {"schema": {"type": "string"}}}},
    **PROBLEMS,
}


async def streamed(request: Request, lane: Lane, seconds: float, work: Callable[[Halt, Tell], object]) -> _Stream:
    """The events that a piece of work tells, the last of them ``done`` or ``error``; it stops when the client leaves.

    Raises
    ------
    Refusal
        As `percuss.web.lanes.Lane.place`, before the stream begins.
    """
    place = lane.place(seconds)
    halt = await place.__aenter__()  # a refusal must come before the stream begins
    events: asyncio.Queue[tuple[str, Any]] = asyncio.Queue()
    loop = asyncio.get_running_loop()

    def tell(kind: str, what: Any) -> None:
        if not halt():
            loop.call_soon_threadsafe(events.put_nowait, (kind, what))

    running = lane.submit(lambda: work(halt, tell))

    async def end() -> None:
        halt.stop()
        lane.hold(running)
        await place.__aexit__(None, None, None)

    return _Stream(_told(request, events, running, halt), end)


@contextmanager
def failures_told(tell: Tell, what: str) -> Iterator[None]:
    """What goes wrong in the block is the event ``error``; what nobody foresaw is logged besides."""
    try:
        yield
    except Exception as error:
        tell("error", {"problems": problems_of(error)})
        if not isinstance(error, PercussError):
            _log.exception("%s failed", what)


class _Stream(StreamingResponse):
    """Events, and what must be done when they have ended, even when the client left before the first."""

    def __init__(self, events: AsyncIterator[bytes], end: Callable[[], Awaitable[None]]) -> None:
        headers = {"cache-control": "no-store", "x-accel-buffering": "no"}
        super().__init__(events, media_type="text/event-stream", headers=headers)
        self._end = end

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        try:
            await super().__call__(scope, receive, send)
        finally:
            await self._end()


async def _told(
    request: Request, events: asyncio.Queue[tuple[str, Any]], running: Future[Any], halt: Halt
) -> AsyncIterator[bytes]:
    """The events as text, until the last one or until the client leaves."""
    yield b": begun\n\n"
    silent = 0.0
    while True:
        try:
            kind, what = await asyncio.wait_for(events.get(), _LOOK)
        except TimeoutError:
            silent += _LOOK
            if await request.is_disconnected():
                return
            if halt():
                late = problem("", None, "it took too long" if halt.late else "the server is stopping", "take fewer")
                yield _event("error", {"problems": [late]})
                return
            if running.done() and events.empty():
                return
            if silent >= _PING:
                silent = 0.0
                yield b": still here\n\n"
            continue
        silent = 0.0
        yield _event(kind, what)
        if kind in ("done", "error"):
            return


def _event(kind: str, what: Any) -> bytes:
    return f"event: {kind}\ndata: {json.dumps(what, allow_nan=False)}\n\n".encode()
