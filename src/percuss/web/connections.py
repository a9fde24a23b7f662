"""HTTP as uvicorn reads it, with a bound on what a client may cost before and after its request is worked on.

The head of a request is bounded in size and time, so is the silence between two requests, and so is the time in which a
client does not read what it asked for. There is room for so many connections. And every request under way learns that
its client has left, which uvicorn tells the last one on a connection alone.
"""

from __future__ import annotations

import asyncio
import ipaddress
from collections import defaultdict
from typing import TYPE_CHECKING, Any, ClassVar, Protocol

from uvicorn.protocols.http.httptools_impl import HttpToolsProtocol

from percuss.web.requests import overcrowded, plain_refusal

if TYPE_CHECKING:
    from percuss.web.settings import Limits


# ---- Who is connected: room for so many, for so many of one address, and the one that dawdles longest makes room


class RemoteClient(Protocol):
    """A connection as the crowd sees it."""

    def dawdles_since(self) -> float | None:
        """Since when the server has waited for this client, in seconds; None while the server is at work for it."""

    def dismiss(self) -> None:
        """Close it at once."""


class Crowd:
    """The connections of one worker: without room, the silent one that kept it waiting longest is closed."""

    def __init__(self, limits: Limits) -> None:
        self._most, self._most_of_one = limits.connections, limits.connections_per_address
        self._guests: dict[RemoteClient, str] = {}
        self._of: defaultdict[str, set[RemoteClient]] = defaultdict(set)

    def enter(self, guest: RemoteClient, address: str) -> bool:
        """Count a connection; whether there is room for it, if need be in place of another."""
        home = neighbourhood(address)
        room = len(self._of[home]) < self._most_of_one or self._make_room(self._of[home])
        room = room and (len(self._guests) < self._most or self._make_room(self._guests))
        self._guests[guest] = home
        self._of[home].add(guest)
        return room

    def leave(self, guest: RemoteClient) -> None:
        """Forget a connection; once is enough."""
        home = self._guests.pop(guest, None)
        if home is not None:
            self._of[home].discard(guest)
            if not self._of[home]:
                del self._of[home]

    def _make_room(self, among: set[RemoteClient] | dict[RemoteClient, str]) -> bool:
        """Whether one of them could be sent away."""
        waits = [(since, guest) for guest in among if (since := guest.dawdles_since()) is not None]
        if not waits:
            return False
        guest = min(waits, key=lambda wait: wait[0])[1]
        self.leave(guest)
        guest.dismiss()
        return True


def neighbourhood(address: str) -> str:
    """What counts as one address: of IPv6 the network of 64 bits, which one client has all to itself."""
    try:
        found = ipaddress.ip_address(address.partition("%")[0])
    except ValueError:
        return address
    if isinstance(found, ipaddress.IPv4Address):
        return str(found)
    if found.ipv4_mapped is not None:
        return str(found.ipv4_mapped)
    return str(ipaddress.IPv6Address(int(found) >> 64 << 64))


# ---- HTTP as uvicorn reads it, with a bound on what a client may cost before and after its request is worked on

_PROGRESS = 65_536  # bytes that a client must take within `Limits.write_seconds`, unless it takes all there are


class BoundedConnection(HttpToolsProtocol):
    """A connection that keeps within the limits; each server makes a class of its own, with what all of them share."""

    limits: ClassVar[Limits]
    crowd: ClassVar[Crowd]
    look: ClassVar[float]
    """Seconds between two looks at the clock."""

    _looks: asyncio.TimerHandle | None = None  # at the clock, as long as the connection lasts
    _until = 0.0  # when it ends, unless a request is under way by then
    _since = 0.0  # when the server began to wait for the client
    _in_head = False
    _welcome = True  # there is room for it
    _backlog = 0  # bytes that wait to be taken by the client ...
    _taken = 0.0  # ... and when it last took some
    _heads = 0  # that have begun
    _size = 0  # bytes of this message less twice those of its body
    _asked: tuple[Any, ...] = ()  # requests that are not answered yet: more than one when they come in a row

    # -- from begin to end --

    def connection_made(self, transport: Any) -> None:
        super().connection_made(transport)
        self._welcome = self.crowd.enter(self, self.client[0] if self.client else "")
        self._taken = self.loop.time()
        self._wait(self.limits.head_seconds)
        self._looks = self.loop.call_later(self.look, self._look)

    def connection_lost(self, exc: Exception | None) -> None:
        self.crowd.leave(self)
        if self._looks is not None:
            self._looks.cancel()
        self._unset_keepalive_if_required()
        super().connection_lost(exc)
        for cycle in self._asked:
            if not cycle.response_complete:
                cycle.disconnected = True
                cycle.message_event.set()

    def _look(self) -> None:
        """At the clock; a timer for each request would cost more."""
        self._looks = self.loop.call_later(self.look, self._look)
        now, backlog = self.loop.time(), self.transport.get_write_buffer_size()
        if backlog == 0 or self._backlog == 0 or backlog <= self._backlog - _PROGRESS:
            self._backlog, self._taken = backlog, now
        elif now > self._taken + self.limits.write_seconds:
            self.transport.abort()  # close() would wait for the client to read
        self._backlog = max(backlog, self._backlog)
        busy = self.cycle is not None and not self.cycle.response_complete  # the head has come, the answer not gone
        if not busy and now > self._until and not self.transport.is_closing():
            self.transport.close()

    # -- what the crowd asks --

    def dawdles_since(self) -> float | None:
        """Since when the server has waited for this client: for a request, or for it to read the answer."""
        if self.flow.write_paused:
            return self._taken
        under_way = next((cycle for cycle in self._asked if not cycle.response_complete), None)
        return self._since if under_way is None or under_way.more_body else None

    def dismiss(self) -> None:
        """Close it, whatever it has not read."""
        self.transport.abort()

    def resume_writing(self) -> None:
        super().resume_writing()
        self._taken = self.loop.time()

    # -- requests --

    def _wait(self, seconds: float) -> None:
        self._since = self.loop.time()
        self._until = self._since + seconds

    def data_received(self, data: bytes) -> None:
        head = self._heads
        super().data_received(data)
        if self._heads == head:  # what begins within `data` is bounded by its size
            self._size += len(data)
        if self._size > self.limits.head_bytes and not self.transport.is_closing():
            if self._in_head:
                self.send_400_response("The head of the request is too large.")
            else:
                self.transport.close()

    def on_message_begin(self) -> None:
        super().on_message_begin()
        self._heads += 1
        self._size = 0
        self._in_head = True
        self._wait(self.limits.head_seconds)

    def on_header(self, name: bytes, value: bytes) -> None:
        if self._in_head:  # else it is a trailer, which nobody looks at
            super().on_header(name, value)

    def on_headers_complete(self) -> None:
        self._in_head = False
        self._since = self.loop.time()
        if not self._welcome:
            self.app = overcrowded
        super().on_headers_complete()
        self._asked = (*(cycle for cycle in self._asked if not cycle.response_complete), self.cycle)

    def on_body(self, body: bytes) -> None:
        self._size -= 2 * len(body)
        super().on_body(body)

    def on_response_complete(self) -> None:
        super().on_response_complete()
        self._unset_keepalive_if_required()  # any byte would cancel it; `_look` knows the time
        self._wait(self.limits.head_seconds if self._in_head else self.limits.idle_seconds)

    def send_400_response(self, msg: str) -> None:
        if not self.transport.is_closing():
            self.transport.write(plain_refusal(400, msg))
            self.transport.close()

    def _unsupported_upgrade_warning(self) -> None:
        """Nothing: there are no web sockets here, and none are missing."""


def protocol(limits: Limits) -> type[asyncio.Protocol]:
    """The class of connections of one server, which keep within the limits."""
    # uvicorn bounds none of this: a header without an end would fill the memory, and silent connections would take all
    # places before anything looks at a token; one byte between two requests puts off its time for the next one for
    # good, and a client that does not read holds its connection as long as it likes. `head_bytes` also bounds what is
    # sent around a body and is not of it, as trailers are. Bodies have their bounds in `percuss.web.requests`.
    look = min(1.0, limits.head_seconds / 4.0, limits.idle_seconds / 4.0, limits.write_seconds / 4.0)
    return type("BoundedConnection", (BoundedConnection,), {"limits": limits, "crowd": Crowd(limits), "look": look})
