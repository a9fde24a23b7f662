"""Bodies of requests, read with a bound on their size and time, and JSON that holds only what JSON has."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Coroutine
from typing import Any, NoReturn

from fastapi.routing import APIRoute
from starlette.requests import ClientDisconnect, Request
from starlette.responses import Response

from percuss.web.problems import refused
from percuss.web.settings import Limits

__all__ = ["StrictRoute", "bounded_body", "strict_json"]


async def bounded_body(request: Request, most: int, seconds: float) -> bytes:
    """The body of a request.

    Raises
    ------
    Refusal
        413 when it is larger than `most` bytes, 408 when it does not come in time, 415 when it is packed.
    """
    if request.headers.get("content-encoding", "identity").strip().lower() != "identity":
        raise refused(415, "the body must not be packed", "send it without Content-Encoding", close=True)
    told = request.headers.get("content-length", "")
    if told.isascii() and told.isdigit() and int(told[:20]) > most:
        raise _too_large(most)
    parts, size = [], 0
    try:
        async with request.app.state.gate.waiting(seconds):
            async for part in request.stream():
                size += len(part)
                if size > most:
                    raise _too_large(most)
                parts.append(part)
    except ClientDisconnect:
        raise refused(400, "the request ended before its body") from None
    return b"".join(parts)


def _too_large(most: int) -> Exception:
    # the connection goes on: who still sends would otherwise not see the answer
    return refused(413, f"larger than {most / 1e6:g} MB", "send less")


def strict_json(body: bytes, depth: int) -> Any:
    """The value in a JSON text.

    Raises
    ------
    Refusal
        400 for what is not JSON, NaN and infinities, numbers out of range, keys given twice, and deep nesting.
    """
    try:
        value = json.loads(body, parse_constant=_no_constant, object_pairs_hook=_once)
        _check(value, depth)
    except (RecursionError, _TooDeep):
        raise refused(400, f"JSON nested deeper than {depth} levels") from None
    except ValueError as error:  # also of text that is not UTF-8, and of numbers of thousands of digits
        raise refused(400, f"not JSON: {error}", "send a JSON object") from None
    return value


class _TooDeep(Exception):
    pass


def _no_constant(name: str) -> NoReturn:
    raise ValueError(f"{name} is no number of JSON")


def _once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """Each key once, as in a case file: of two values the one that was meant cannot be told."""
    found = dict(pairs)
    if len(found) < len(pairs):
        raise ValueError("a key is given twice")
    return found


def _check(value: Any, depth: int) -> None:
    """Refuse what arithmetic would trip over: whole numbers beyond 64 bits, and 1e999."""
    kind = type(value)
    if kind is float:
        if not math.isfinite(value):
            raise ValueError("a number out of range")
    elif kind is int:
        if not -(2**63) <= value < 2**63:
            raise ValueError("a whole number out of range")
    elif kind is dict or kind is list:
        if depth <= 0:
            raise _TooDeep
        for item in value.values() if kind is dict else value:
            _check(item, depth - 1)


class _StrictRequest(Request):
    """A request whose JSON is read by `strict_json`."""

    limits = Limits()

    async def body(self) -> bytes:
        if not hasattr(self, "_body"):
            self._body = await bounded_body(self, self.limits.json_bytes, self.limits.body_seconds)
        return self._body

    async def json(self) -> Any:
        if not hasattr(self, "_json"):
            self._json = strict_json(await self.body(), self.limits.depth)
        return self._json


class StrictRoute(APIRoute):
    """A route that takes JSON only when it is said to be JSON (other pages can send the rest without asking)."""

    def get_route_handler(self) -> Callable[[Request], Coroutine[Any, Any, Response]]:
        """The handler, behind the check."""
        answered = super().get_route_handler()
        takes_json = self.body_field is not None

        async def handler(request: Request) -> Response:
            if not takes_json:
                return await answered(request)
            kind = request.headers.get("content-type", "").partition(";")[0].strip().lower()
            if kind != "application/json":
                raise refused(415, "the body must be JSON", "send Content-Type: application/json")
            strict = _StrictRequest(request.scope, request.receive)
            strict.limits = request.app.state.settings.limits
            await strict.body()  # a bad one is refused at once
            return await answered(strict)

        return handler
