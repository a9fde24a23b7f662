"""What a server is told when it starts: where it listens, who may ask, and how much one request may cost."""

from __future__ import annotations

import ipaddress
import socket
from dataclasses import asdict, dataclass, field
from typing import Any


@dataclass(frozen=True)
class Limits:
    """The most that one request may ask for; beyond is refused and not computed.

    What no server changes, such as the frames of a motion, is bounded by the questions themselves.

    Attributes
    ----------
    json_bytes, upload_bytes, depth
        Of a request: size of a JSON body, of an uploaded history, and how deep JSON may nest.
    values, keys, text
        Of a JSON body: values and keys in it, and characters of a text within a case; more is no question, and would
        take seconds to look through.
    held_bytes
        Of all bodies that come in at once, together.
    head_bytes, head_seconds
        Of what comes before a body: its size, and after how long a connection that does not send one is closed.
    idle_seconds, write_seconds
        After which a connection without a request is closed, and one whose client does not read.
    connections, connections_per_address
        At once in one worker, and of one address.
    simulation_modes, harmonics
        Elastic modes of a simulation; the highest harmonic of a load.
    steady_work
        Harmonics × (modes + 1) × load periods of a steady answer, all its numbers of periods together.
    impacts
        Of a simulation.
    cells, slow_cells, boundary_points
        Of a map by arrays and cell by cell; values of x along which boundaries are solved for.
    starts, start_work
        Of an experiment, and starts × impacts × (modes + 1).
    pieces
        Of the waves of a blow, after which it is followed no further.
    seconds, experiment_seconds, body_seconds
        After which a computation, an experiment, a body that still comes in is given up.
    quick, heavy, experiments, quick_waiting, heavy_waiting
        How many computations of each kind run at once in one worker, and how many may wait for their turn.
    """

    json_bytes: int = 1_000_000
    upload_bytes: int = 10_000_000
    depth: int = 32
    values: int = 50_000
    keys: int = 1_000
    text: int = 10_000
    held_bytes: int = 100_000_000
    head_bytes: int = 65_536
    head_seconds: float = 15.0
    idle_seconds: float = 30.0
    write_seconds: float = 15.0
    connections: int = 512
    connections_per_address: int = 128
    simulation_modes: int = 256
    harmonics: int = 1024
    steady_work: float = 2e6
    impacts: int = 20_000
    cells: int = 40_000
    slow_cells: int = 2_500
    boundary_points: int = 200
    starts: int = 100_000
    start_work: float = 2e9
    pieces: int = 400_000
    seconds: float = 30.0
    experiment_seconds: float = 600.0
    body_seconds: float = 30.0
    quick: int = 2
    heavy: int = 2
    experiments: int = 2
    quick_waiting: int = 128
    heavy_waiting: int = 16

    def to_json_dict(self) -> dict[str, Any]:
        """For the page."""
        return asdict(self)


@dataclass(frozen=True)
class Settings:
    """Where a server listens and who may ask.

    Attributes
    ----------
    token
        What every request to ``/api/`` must carry; "" for none, which only a loopback address may have.
    names
        Other names by which the page is reached, for example behind a reverse proxy.
    case
        TOML text of the case that the page opens with; "" for none.
    embed
        Origins of other pages that may show this one within a frame, such as ``https://school.example``.
    """

    host: str = "127.0.0.1"
    port: int = 8321
    token: str = field(default="", repr=False)
    names: tuple[str, ...] = ()
    case: str = field(default="", repr=False)
    embed: tuple[str, ...] = ()
    limits: Limits = Limits()

    def allows(self, name: str) -> bool:
        """Whether a Host header may name this host (without its port).

        A page elsewhere that makes its own name point here (DNS rebinding) sends that name: only names that are known,
        and addresses, which nobody else can take, are answered.
        """
        wanted = name.lower().rstrip(".")
        if wanted in (known.lower() for known in (*self.names, self.host)):
            return True
        if is_loopback(wanted):
            return True
        if is_loopback(self.host):
            return False
        return _is_address(wanted) or wanted == socket.gethostname().lower()


def is_loopback(host: str) -> bool:
    """Whether only this machine can reach a host.

    Examples
    --------
    >>> is_loopback("127.0.0.1"), is_loopback("localhost"), is_loopback("0.0.0.0")
    (True, True, False)
    """
    if host.lower() == "localhost":
        return True
    try:
        return ipaddress.ip_address(host.strip("[]")).is_loopback
    except ValueError:
        return False


def _is_address(name: str) -> bool:
    try:
        ipaddress.ip_address(name.strip("[]"))
    except ValueError:
        return False
    return True
