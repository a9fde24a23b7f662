"""HTTP as uvicorn reads it, with a bound on the head of a request: on its size, and on the time it takes to come.

And every request under way learns that its client has left, which uvicorn tells the last one on a connection alone.
"""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, Any

from uvicorn.protocols.http.httptools_impl import HttpToolsProtocol

if TYPE_CHECKING:
    from percuss.web.settings import Limits

__all__ = ["protocol"]


def protocol(limits: Limits) -> type[asyncio.Protocol]:
    """The class of connections whose heads keep within `head_bytes` and `head_seconds`.

    uvicorn bounds neither: a header without an end would fill the memory, and silent connections would take all places
    of `limit_concurrency`, before anything looks at a token. `head_bytes` also bounds what is sent around a body and is
    not of it, as trailers are. Bodies have their bounds in `percuss.web.bodies`.
    """

    class BoundedHead(HttpToolsProtocol):
        _timer: asyncio.TimerHandle | None = None  # runs while a head is waited for
        _heads = 0  # that have begun
        _size = 0  # bytes of this message less twice those of its body
        _asked: tuple[Any, ...] = ()  # requests that are not answered yet: more than one when they come in a row

        def connection_made(self, transport: Any) -> None:
            super().connection_made(transport)
            self._wait()

        def connection_lost(self, exc: Exception | None) -> None:
            self._waited()
            super().connection_lost(exc)
            for cycle in self._asked:
                if not cycle.response_complete:
                    cycle.disconnected = True
                    cycle.message_event.set()

        def data_received(self, data: bytes) -> None:
            head = self._heads
            super().data_received(data)
            if self._heads == head:  # what begins within `data` is bounded by its size
                self._size += len(data)
            if self._size > limits.head_bytes and not self.transport.is_closing():
                if self._timer is None:
                    self.transport.close()
                else:
                    self.send_400_response("The head of the request is too large.")

        def on_message_begin(self) -> None:
            super().on_message_begin()
            self._heads += 1
            self._size = 0
            self._wait()

        def on_header(self, name: bytes, value: bytes) -> None:
            if self._timer is not None:  # else it is a trailer, which nobody looks at
                super().on_header(name, value)

        def on_headers_complete(self) -> None:
            self._waited()
            super().on_headers_complete()
            self._asked = (*(cycle for cycle in self._asked if not cycle.response_complete), self.cycle)

        def on_body(self, body: bytes) -> None:
            self._size -= 2 * len(body)
            super().on_body(body)

        def _unsupported_upgrade_warning(self) -> None:
            """Nothing: there are no web sockets here, and none are missing."""

        def _wait(self) -> None:
            if self._timer is None:
                self._timer = self.loop.call_later(limits.head_seconds, self.transport.close)

        def _waited(self) -> None:
            if self._timer is not None:
                self._timer.cancel()
                self._timer = None

    return BoundedHead
