"""What every request must pass before it is looked at: host, origin, token, the size of its body; and its refusals."""

from __future__ import annotations

import hmac
import json
import logging
import math
from collections.abc import Callable, Coroutine, Mapping, MutableMapping, Sequence
from http import HTTPStatus
from typing import TYPE_CHECKING, Any, NoReturn
from urllib.parse import urlsplit

from fastapi.routing import APIRoute
from starlette.datastructures import Headers
from starlette.exceptions import HTTPException
from starlette.requests import ClientDisconnect, Request
from starlette.responses import Response

from percuss.errors import CaseError, HistoryError, ParameterError, PercussError
from percuss.web.settings import Limits

if TYPE_CHECKING:
    from starlette.types import ASGIApp, Message, Receive, Scope, Send

    from percuss.web.settings import Settings


# ---- What goes wrong, as one form of JSON: a list of problems with key, value, message and remedy

_MOST_TEXT = 200  # characters of a value or a message that are sent back


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
    """The problems behind an error of the floors below, without the names of files that it may know."""
    if isinstance(error, CaseError):
        found = getattr(error, "problems", (error,))
        return [problem(e.key, e.value, e.accepted, e.remedy) for e in found]
    if isinstance(error, ParameterError):
        return [problem(error.name, error.value, f"expected {error.accepted}", error.remedy)]
    if isinstance(error, HistoryError):
        message = error.message.removeprefix(f"{error.file}: ") if error.file else error.message
        return [problem("load.file", None, message, error.remedy)]
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
    """The body of a request."""
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
    """The value in a JSON text."""
    # before it is read, and at no cost; commas in strings count too, but are far fewer
    if body.count(b",") >= limits.values:
        raise refused(422, f"more than {limits.values} values", "send less")
    keys = _Keys(limits.keys, limits.text)
    try:
        value = json.loads(body, parse_constant=_no_constant, object_pairs_hook=keys.once)
        for field in value.values() if type(value) is dict else [value]:
            # a text that is a field itself has a bound of its own: that of a case file is high
            _check(field, limits.depth - 1, limits.json_bytes if type(field) is str else limits.text)
    except RecursionError:
        raise refused(400, f"JSON nested deeper than {limits.depth} levels") from None
    except UnicodeEncodeError:
        raise refused(422, "text with half of a surrogate pair, which stands for no character") from None
    except ValueError as error:  # also of text that is not UTF-8, and of numbers of thousands of digits
        raise refused(400, f"not JSON: {error}", "send a JSON object") from None
    return value


def _no_constant(name: str) -> NoReturn:
    raise ValueError(f"{name} is not a JSON number")


class _Keys:
    """The keys of a text: so many in all, and in each object each once, as in a case file."""

    def __init__(self, most: int, text: int) -> None:
        self._most, self._left, self._text = most, most, text

    def once(self, pairs: list[tuple[str, Any]]) -> dict[str, Any]:
        """The object with these keys."""
        self._left -= len(pairs)
        if self._left < 0:
            raise refused(422, f"more than {self._most} keys", "send less")
        found = dict(pairs)
        if len(found) < len(pairs):
            raise ValueError("a key is given twice")
        for key in found:
            _check_text(key, self._text)
        return found


def _check_text(text: str, most: int) -> None:
    """Refuse half a surrogate pair, which can be neither sent nor written, and long text, which problems repeat."""
    if len(text) > most:
        raise refused(422, f"text of more than {most} characters", "send less")
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
            raise RecursionError
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


# ---- What every request must pass before anything looks at it: host, origin, token; and what every answer carries

CONTENT_SECURITY_POLICY = "; ".join(
    [
        "default-src 'none'",
        "script-src 'self'",
        "style-src 'self'",
        "img-src 'self' data: blob:",
        "font-src 'self' data:",
        "connect-src 'self'",
        "media-src 'self' blob:",
        "manifest-src 'self'",
        "worker-src 'self' blob:",
        "base-uri 'none'",
        "form-action 'none'",
        "frame-ancestors 'none'",
    ]
)

_HEADERS = {
    "content-security-policy": CONTENT_SECURITY_POLICY,
    "x-content-type-options": "nosniff",
    "x-frame-options": "DENY",
    "referrer-policy": "no-referrer",
    "cross-origin-opener-policy": "same-origin",
    "cross-origin-resource-policy": "same-origin",
    "permissions-policy": "camera=(), geolocation=(), microphone=(), payment=(), usb=()",
}

_OPEN = ("/api/about",)  # what is answered without the token: whether one is needed

_log = logging.getLogger("percuss.web")


class Guard:
    """ASGI middleware: refuses what does not come from the page itself, and lets no trace of an error out."""

    def __init__(self, app: ASGIApp, settings: Settings) -> None:
        self.app = app
        self.settings = settings

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] == "lifespan":
            await self.app(scope, receive, send)
            return
        if scope["type"] != "http":  # there are no web sockets here
            await send({"type": "websocket.close", "code": 1008})
            return
        begun = False

        async def sending(message: Message) -> None:
            nonlocal begun
            if message["type"] == "http.response.start":
                begun = True
                _add_headers(message, scope["path"], self.settings.embed)
            await send(message)

        refusal = self._refusal(scope)
        if refusal is not None:
            await _answer(refusal, sending)
            return
        try:
            await self.app(scope, receive, sending)
        except Exception:
            _log.exception("%s %s failed", scope["method"], scope["path"])
            if not begun:
                failure = "the server failed on this request; its log has more"
                await _answer(refused(500, failure, "please report it with the case"), sending)

    def _refusal(self, scope: Scope) -> Refusal | None:
        headers = Headers(scope=scope)
        host = headers.get("host", "")
        if len(headers.getlist("host")) != 1 or not self.settings.allows(_name_of(host)):
            remedy = "use the address that 'percuss serve' printed; --name adds other names"
            return refused(403, "this server is not known by that name", remedy, "Host", host)
        path = scope["path"]
        origin = headers.get("origin")
        if origin is not None and _place_of(origin) != host.lower():
            return refused(403, "requests from other pages are not answered", "", "Origin", origin)
        if path.startswith("/api/"):
            if headers.get("sec-fetch-site", "none") not in ("same-origin", "none"):
                return refused(403, "requests from other pages are not answered", "", "Sec-Fetch-Site")
            referer = headers.get("referer")
            if referer is not None and _place_of(referer) != host.lower():
                return refused(403, "requests from other pages are not answered", "", "Referer", referer)
            if self.settings.token and path not in _OPEN and not self._knows(headers.get("authorization", "")):
                return refused(401, "this server needs its token", "open the address that 'percuss serve' printed")
        return None

    def _knows(self, authorization: str) -> bool:
        kind, _, given = authorization.partition(" ")
        right = hmac.compare_digest(given.strip().encode(), self.settings.token.encode())
        return right and kind.lower() == "bearer"


def _place_of(origin: str) -> str:
    """Name and port in an Origin or Referer header; "" for one that makes no sense."""
    try:
        return urlsplit(origin).netloc.lower()
    except ValueError:
        return ""


def _name_of(host: str) -> str:
    """The name in a Host header; "" for none that makes sense."""
    try:
        found = urlsplit(f"//{host}")
        _ = found.port
    except ValueError:
        return ""
    return "" if found.path or found.username is not None else found.hostname or ""


def _add_headers(message: MutableMapping[str, Any], path: str, embed: tuple[str, ...] = ()) -> None:
    given = {name.lower() for name, _ in message["headers"]}
    headers = dict(_HEADERS)
    if embed:
        policy = CONTENT_SECURITY_POLICY.replace("frame-ancestors 'none'", f"frame-ancestors 'self' {' '.join(embed)}")
        headers["content-security-policy"] = policy
        del headers["x-frame-options"]  # which knows no list
    extra = [(name.encode(), value.encode()) for name, value in headers.items()]
    if path.startswith("/api/") and b"cache-control" not in given:
        extra.append((b"cache-control", b"no-store"))
    message["headers"] = [*message["headers"], *(pair for pair in extra if pair[0] not in given)]


async def overcrowded(scope: Scope, receive: Receive, send: Send) -> None:
    """The answer on a connection for which there is no room."""

    async def sending(message: Message) -> None:
        if message["type"] == "http.response.start":
            _add_headers(message, scope["path"])
        await send(message)

    await _answer(refused(503, "too many connections", "try again in a few seconds", close=True), sending)


def plain_refusal(status: int, message: str) -> bytes:
    """A refusal as it goes over the wire, where no request could be read; the connection ends with it."""
    start, body = _messages(refused(status, message, close=True))
    _add_headers(start, "/api/")
    lines = [b"HTTP/1.1 %d %s" % (status, HTTPStatus(status).phrase.encode())]
    lines += [name + b": " + value for name, value in start["headers"]]
    return b"\r\n".join([*lines, b"", body["body"]])


async def _answer(refusal: Refusal, send: Send) -> None:
    for message in _messages(refusal):
        await send(message)


def _messages(refusal: Refusal) -> tuple[dict[str, Any], dict[str, Any]]:
    """The two messages of ASGI that answer with a refusal."""
    body = json.dumps({"problems": refusal.problems or [problem("", None, "refused")]}).encode()
    headers = {"content-type": "application/json", "content-length": str(len(body)), **(refusal.headers or {})}
    pairs = [(name.lower().encode(), value.encode()) for name, value in headers.items()]
    start = {"type": "http.response.start", "status": refusal.status_code, "headers": pairs}
    return start, {"type": "http.response.body", "body": body}
