"""Clients of the workbench, without a network and for load; its binary answers, read as the page reads them."""

from __future__ import annotations

import asyncio
import itertools
import json
import re
import struct
import time
from collections.abc import Sequence
from typing import Any, NamedTuple

import httpx
import numpy as np

from percuss.web import Settings, create_app

BASE = "http://127.0.0.1:8321"


class Client:
    """Requests to an application of its own, one event loop each."""

    def __init__(self, settings: Settings | None = None) -> None:
        self.app: Any = create_app(settings or Settings())

    def request(self, method: str, path: str, **options: Any) -> httpx.Response:
        return asyncio.run(self.arequest(method, path, **options))

    async def arequest(self, method: str, path: str, **options: Any) -> httpx.Response:
        transport = httpx.ASGITransport(app=self.app, raise_app_exceptions=False)
        async with httpx.AsyncClient(transport=transport, base_url=BASE, timeout=60.0) as client:
            return await client.request(method, path, **options)

    def get(self, path: str, **options: Any) -> httpx.Response:
        return self.request("GET", path, **options)

    def post(self, path: str, asked: Any = None, **options: Any) -> httpx.Response:
        return self.request("POST", path, **({"json": asked} if asked is not None else {}), **options)

    def answer(self, path: str, asked: Any) -> Any:
        """The JSON of an answer that there must be."""
        found = self.post(path, asked)
        assert found.status_code == 200, found.text
        return found.json()

    def arrays(self, path: str, asked: Any) -> tuple[dict[str, Any], dict[str, Any]]:
        """Header and arrays of a binary answer that there must be."""
        found = self.post(path, asked)
        assert found.status_code == 200, found.text
        return unpacked(found.content)

    def problems(self, path: str, asked: Any, status: int = 422) -> list[dict[str, Any]]:
        """The problems of an answer that must be refused."""
        found = self.post(path, asked)
        assert found.status_code == status, found.text
        problems: list[dict[str, Any]] = found.json()["problems"]
        assert problems and all(set(p) == {"key", "value", "message", "remedy"} for p in problems)
        return problems


def unpacked(data: bytes) -> tuple[dict[str, Any], dict[str, Any]]:
    (length,) = struct.unpack("<I", data[:4])
    assert (4 + length) % 8 == 0
    header = json.loads(data[4 : 4 + length])
    kinds = {"f4": "<f4", "u1": "|u1", "i2": "<i2"}
    arrays = {}
    for about in header["arrays"]:
        begin = 4 + length + about["offset"]
        assert begin % 8 == 0
        raw = data[begin : begin + about["bytes"]]
        arrays[about["name"]] = np.frombuffer(raw, kinds[about["dtype"]]).reshape(about["shape"])
    return header, arrays


def events(text: str) -> list[tuple[str, Any]]:
    """Server-sent events as (name, data)."""
    found = []
    for block in text.split("\n\n"):
        lines = [line for line in block.splitlines() if not line.startswith(":")]
        if lines:
            told = dict(line.split(": ", 1) for line in lines)
            found.append((told["event"], json.loads(told["data"])))
    return found


# -- over a socket, sparing with the processor ----------------------------------------------------------------------


def posted(path: str, asked: Any, host: str = "127.0.0.1") -> bytes:
    """A whole request, ready to be sent."""
    body = json.dumps(asked).encode()
    head = (
        f"POST {path} HTTP/1.1\r\nHost: {host}\r\nContent-Type: application/json\r\nContent-Length: {len(body)}\r\n\r\n"
    )
    return head.encode() + body


async def answered(reader: asyncio.StreamReader) -> tuple[int, bytes]:
    """Status and body of the next answer on a connection."""
    head = await reader.readuntil(b"\r\n\r\n")
    length = re.search(rb"(?i)content-length: (\d+)", head)
    return int(head[9:12]), await reader.readexactly(int(length[1])) if length else b""


class Offered(NamedTuple):
    """What came of requests that were offered at a rate."""

    codes: list[int]
    seconds: float
    """From the first request to the last answer."""


async def offered(port: int, requests: Sequence[bytes], rate: float, streams: int = 48) -> Offered:
    """Send requests at a rate over persistent connections; each waits for its answer before it takes the next one.

    A request costs this process some 0.1 ms, so that it is the server that is measured.
    """
    codes: list[int] = []
    order = itertools.count()
    begun = time.perf_counter()

    async def stream() -> None:
        reader, writer = await asyncio.open_connection("127.0.0.1", port)
        while (i := next(order)) < len(requests):
            if (early := begun + i / rate - time.perf_counter()) > 0.0:
                await asyncio.sleep(early)
            writer.write(requests[i])
            codes.append((await answered(reader))[0])
        writer.close()

    await asyncio.gather(*(stream() for _ in range(streams)))
    return Offered(codes, time.perf_counter() - begun)
