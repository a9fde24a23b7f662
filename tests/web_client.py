"""A client of the workbench without a network, and its binary answers read as the page reads them."""

from __future__ import annotations

import asyncio
import json
import struct
from typing import Any

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
