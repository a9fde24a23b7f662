"""Who is connected: room for so many, for so many of one address, and the one that dawdles longest makes room."""

from __future__ import annotations

import ipaddress
from collections import defaultdict
from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from percuss.web.settings import Limits

__all__ = ["Crowd", "Guest", "neighbourhood"]


class Guest(Protocol):
    """A connection as the crowd sees it."""

    def dawdles_since(self) -> float | None:
        """Since when the server has waited for this client, in seconds; None while the server is at work for it."""

    def dismiss(self) -> None:
        """Close it at once."""


class Crowd:
    """The connections of one worker.

    Connections are cheap to hold open, so silent ones must never keep others out: when there is no room, the server
    closes the connection that has kept it waiting longest. One that is being answered is never closed for another.

    Parameters
    ----------
    limits
        `connections` and `connections_per_address`.
    """

    def __init__(self, limits: Limits) -> None:
        self._most, self._most_of_one = limits.connections, limits.connections_per_address
        self._guests: dict[Guest, str] = {}
        self._of: defaultdict[str, set[Guest]] = defaultdict(set)

    def enter(self, guest: Guest, address: str) -> bool:
        """Count a connection; whether there is room for it, if need be in place of another."""
        home = neighbourhood(address)
        room = len(self._of[home]) < self._most_of_one or self._make_room(self._of[home])
        room = room and (len(self._guests) < self._most or self._make_room(self._guests))
        self._guests[guest] = home
        self._of[home].add(guest)
        return room

    def leave(self, guest: Guest) -> None:
        """Forget a connection; once is enough."""
        home = self._guests.pop(guest, None)
        if home is not None:
            self._of[home].discard(guest)
            if not self._of[home]:
                del self._of[home]

    def _make_room(self, among: set[Guest] | dict[Guest, str]) -> bool:
        """Whether one of them could be sent away."""
        waits = [(since, guest) for guest in among if (since := guest.dawdles_since()) is not None]
        if not waits:
            return False
        guest = min(waits, key=lambda wait: wait[0])[1]
        self.leave(guest)
        guest.dismiss()
        return True


def neighbourhood(address: str) -> str:
    """What counts as one address: of IPv6 the network of 64 bits, which one client has all to itself.

    Examples
    --------
    >>> neighbourhood("192.168.0.7"), neighbourhood("2001:db8::7")
    ('192.168.0.7', '2001:db8::')
    """
    try:
        found = ipaddress.ip_address(address.partition("%")[0])
    except ValueError:
        return address
    if isinstance(found, ipaddress.IPv4Address):
        return str(found)
    if found.ipv4_mapped is not None:
        return str(found.ipv4_mapped)
    return str(ipaddress.IPv6Address(int(found) >> 64 << 64))
