"""What every request must pass before anything looks at it: host, origin, token; and what every answer carries."""

from __future__ import annotations

import hmac
import json
import logging
from collections.abc import MutableMapping
from http import HTTPStatus
from typing import TYPE_CHECKING, Any
from urllib.parse import urlsplit

from starlette.datastructures import Headers

from percuss.web.request_bodies import problem, refused

if TYPE_CHECKING:
    from starlette.types import ASGIApp, Message, Receive, Scope, Send

    from percuss.web.request_bodies import Refusal
    from percuss.web.settings import Settings

__all__ = ["CONTENT_SECURITY_POLICY", "Guard", "overcrowded", "plain_refusal"]

CONTENT_SECURITY_POLICY = "; ".join(
    [
        "default-src 'none'",
        "script-src 'self'",
        "style-src 'self' 'unsafe-inline'",  # plotly writes style sheets and style attributes
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

_OPEN = ("/api/about",)
"""What is answered without the token: whether one is needed."""

_log = logging.getLogger("percuss.web")


class Guard:
    """ASGI middleware: refuses what does not come from the page itself, and lets no trace of an error out.

    Parameters
    ----------
    app
        What is guarded.
    settings
        Names, and the token.
    """

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
                _add_headers(message, scope["path"])
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


def _add_headers(message: MutableMapping[str, Any], path: str) -> None:
    given = {name.lower() for name, _ in message["headers"]}
    extra = [(name.encode(), value.encode()) for name, value in _HEADERS.items()]
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
