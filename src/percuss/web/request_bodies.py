"""Bodies of requests, read with a bound on their size and time, and JSON that holds only what JSON has."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Coroutine, Mapping, Sequence
from typing import Any, NoReturn

from fastapi.routing import APIRoute
from starlette.exceptions import HTTPException
from starlette.requests import ClientDisconnect, Request
from starlette.responses import Response

from percuss.errors import CaseError, HistoryError, MissingExtraError, ParameterError, PercussError
from percuss.web.settings import Limits

# ---- What goes wrong, as one form of JSON: a list of problems with key, value, message and remedy

_MOST_TEXT = 200
"""Characters of a value or a message that are sent back."""


class Refusal(HTTPException):
    """A request that is not answered: a status and its problems."""

    def __init__(
        self, status: int, problems: Sequence[dict[str, Any]], headers: Mapping[str, str] | None = None
    ) -> None:
        super().__init__(status, "refused", dict(headers) if headers else None)
        self.problems = list(problems)


def refused(
    status: int, message: str, remedy: str = "", key: str = "", value: object = None, *, close: bool = False
) -> Refusal:
    """A `Refusal` with one problem; `close` ends the connection, on which the rest of a body would still come."""
    headers = {429: {"Retry-After": "1"}, 401: {"WWW-Authenticate": "Bearer"}, 503: {"Retry-After": "5"}}.get(
        status, {}
    )
    ending = {"Connection": "close"} if close else {}
    return Refusal(status, [problem(key, value, message, remedy)], {**headers, **ending})


def problem(key: str, value: object, message: str, remedy: str = "") -> dict[str, Any]:
    """One problem, of JSON's types and of bounded size."""
    return {
        "key": key[:_MOST_TEXT],
        "value": _shown(value),
        "message": _cut(message, 1000),
        "remedy": _cut(remedy, 1000),
    }


def problems_of(error: Exception) -> list[dict[str, Any]]:
    """The problems behind an error of the floors below.

    The names of files of this machine, which an error may know, are left out.
    """
    if isinstance(error, CaseError):
        found = getattr(error, "problems", (error,))
        return [problem(e.key, e.value, e.accepted, e.remedy) for e in found]
    if isinstance(error, ParameterError):
        return [problem(error.name, error.value, f"expected {error.accepted}", error.remedy)]
    if isinstance(error, HistoryError):
        message = error.message.removeprefix(f"{error.file}: ") if error.file else error.message
        return [problem("load.file", None, message, error.remedy)]
    if isinstance(error, MissingExtraError):
        return [problem("", None, error.message, error.remedy)]
    if isinstance(error, PercussError):
        return [problem("", None, error.message, error.remedy)]
    if isinstance(error, ArithmeticError):
        return [problem("", None, "sizes so large or small that numbers overflow", "check the units")]
    if isinstance(error, RecursionError):
        return [problem("", None, "nested too deeply", "")]
    if isinstance(error, MemoryError):
        return [problem("", None, "not enough memory for this computation", "ask for less")]
    return [problem("", None, "the server failed on this request; its log has more", "please report it with the case")]


def _shown(value: object) -> Any:
    """A value as JSON has it; what is long or not JSON as the beginning of its text."""
    if value is None or isinstance(value, bool):
        return value
    if isinstance(value, int):
        return value if abs(value) < 2**53 else _cut(f"{value:.3e}" if abs(value) < 10**300 else "a huge number")
    if isinstance(value, float):
        return value if math.isfinite(value) else str(value)
    if isinstance(value, str):
        return _cut(value)
    try:
        return _cut(json.dumps(value, ensure_ascii=False, default=str))
    except (TypeError, ValueError, RecursionError):
        return _cut(type(value).__name__)


def _cut(text: str, most: int = _MOST_TEXT) -> str:
    found = text if len(text) <= most else f"{text[: most - 1]}…"
    return found.encode("utf-8", "replace").decode("utf-8")  # half of a surrogate pair cannot be sent


# ---- Bodies of requests, read with a bound on their size and time, and JSON that holds only what JSON has


async def bounded_body(request: Request, most: int, seconds: float) -> bytes:
    """The body of a request.

    Raises
    ------
    Refusal
        413 when it is larger than `most` bytes, 408 when it does not come in time, 415 when it is packed.
    """
    if request.headers.get("content-encoding", "identity").strip().lower() != "identity":
        raise refused(415, "the body must not be compressed", "send it without Content-Encoding", close=True)
    told = request.headers.get("content-length", "")
    if told.isascii() and told.isdigit() and int(told[:20]) > most:
        raise _too_large(most)
    parts, size, gate = [], 0, request.app.state.gate
    try:
        async with gate.waiting(seconds) as limit:
            async for part in request.stream():
                size += len(part)
                if size > most:
                    raise _too_large(most)
                parts.append(part)
                gate.intake.add(limit, len(part))
    except ClientDisconnect:
        raise refused(400, "the request ended before its body") from None
    return b"".join(parts)


def _too_large(most: int) -> Exception:
    # the connection goes on: who still sends would otherwise not see the answer
    return refused(413, f"larger than {most / 1e6:g} MB", "send less")


def strict_json(body: bytes, limits: Limits) -> Any:
    """The value in a JSON text.

    Raises
    ------
    Refusal
        400 for what is not JSON, NaN and infinities, numbers out of range, keys given twice, and deep nesting; 422 for
        more values or keys than a question has, and for text that is none.
    """
    # before it is read, and at no cost; commas in strings count too, but are far fewer
    if body.count(b",") >= limits.values:
        raise refused(422, f"more than {limits.values} values", "send less")
    keys = _Keys(limits.keys, limits.text)
    try:
        value = json.loads(body, parse_constant=_no_constant, object_pairs_hook=keys.once)
        for field in value.values() if type(value) is dict else [value]:
            # a text that is a field itself has a bound of its own: that of a case file is high
            _check(field, limits.depth - 1, limits.json_bytes if type(field) is str else limits.text)
    except (RecursionError, _TooDeep):
        raise refused(400, f"JSON nested deeper than {limits.depth} levels") from None
    except _TooLong:
        raise refused(422, f"text of more than {limits.text} characters", "send less") from None
    except _TooManyKeys:
        raise refused(422, f"more than {limits.keys} keys", "send less") from None
    except UnicodeEncodeError:
        raise refused(422, "text with half of a surrogate pair, which stands for no character") from None
    except ValueError as error:  # also of text that is not UTF-8, and of numbers of thousands of digits
        raise refused(400, f"not JSON: {error}", "send a JSON object") from None
    return value


class _TooDeep(Exception):
    pass


def _no_constant(name: str) -> NoReturn:
    raise ValueError(f"{name} is not a JSON number")


class _TooManyKeys(Exception):
    pass


class _TooLong(Exception):
    pass


class _Keys:
    """The keys of a text: so many in all, and in each object each once, as in a case file.

    Of two values the one that was meant cannot be told; and every unknown key is a problem to be reported.
    """

    def __init__(self, most: int, text: int) -> None:
        self._left, self._text = most, text

    def once(self, pairs: list[tuple[str, Any]]) -> dict[str, Any]:
        """The object with these keys."""
        self._left -= len(pairs)
        if self._left < 0:
            raise _TooManyKeys
        found = dict(pairs)
        if len(found) < len(pairs):
            raise ValueError("a key is given twice")
        for key in found:
            _check_text(key, self._text)
        return found


def _check_text(text: str, most: int) -> None:
    """Refuse half a surrogate pair, which can be neither sent nor written, and long text, which problems repeat."""
    if len(text) > most:
        raise _TooLong
    if not text.isascii():
        text.encode()


def _check(value: Any, depth: int, text: int) -> None:
    """Refuse what arithmetic or files would trip over: whole numbers beyond 64 bits, 1e999, and text that is none."""
    kind = type(value)
    if kind is str:
        _check_text(value, text)
    elif kind is float:
        if not math.isfinite(value):
            raise ValueError("a number out of range")
    elif kind is int:
        if not -(2**63) <= value < 2**63:
            raise ValueError("a whole number out of range")
    elif kind is dict or kind is list:
        if depth <= 0:
            raise _TooDeep
        for item in value.values() if kind is dict else value:
            _check(item, depth - 1, text)


class _StrictRequest(Request):
    """A request whose JSON is read by `strict_json`."""

    limits = Limits()

    async def body(self) -> bytes:
        if not hasattr(self, "_body"):
            self._body = await bounded_body(self, self.limits.json_bytes, self.limits.body_seconds)
        return self._body

    async def json(self) -> Any:
        if not hasattr(self, "_json"):
            self._json = strict_json(await self.body(), self.limits)
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
