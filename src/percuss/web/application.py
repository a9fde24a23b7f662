"""The application: routes, the guard before them, the files of the page, and what errors become."""

from __future__ import annotations

import gzip
import hashlib
import logging
import posixpath
import re
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import dataclass
from functools import cached_property
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fastapi import FastAPI
from fastapi.exceptions import RequestValidationError
from fastapi.openapi.utils import get_openapi
from starlette.exceptions import HTTPException
from starlette.requests import Request
from starlette.responses import Response

from percuss._version import __version__
from percuss.errors import PercussError
from percuss.web import case_routes, hammer_routes, motion_routes, orbit_routes
from percuss.web.requests import Guard, Refusal, problem, problems_of, refused
from percuss.web.settings import Settings
from percuss.web.shared_by_routes import plain_json
from percuss.web.workers import Admission, Kernels

if TYPE_CHECKING:
    from importlib.resources.abc import Traversable


_log = logging.getLogger("percuss.web")

_SCHEMAS = {
    "Problem": {
        "type": "object",
        "required": ["key", "value", "message", "remedy"],
        "properties": {
            "key": {"type": "string", "description": 'what is wrong, by its dotted key; "" for the request as such'},
            "value": {"description": "what was given, cut short"},
            "message": {"type": "string"},
            "remedy": {"type": "string"},
        },
    },
    "Problems": {
        "type": "object",
        "required": ["problems"],
        "properties": {"problems": {"type": "array", "items": {"$ref": "#/components/schemas/Problem"}}},
    },
}


def create_app(settings: Settings | None = None) -> Any:
    """The workbench as an ASGI application.

    Parameters
    ----------
    settings
        Names, token and limits; by default for this machine alone, without a token.

    Examples
    --------
    >>> from percuss.web import Settings, create_app
    >>> app = create_app(Settings(port=8321))
    """
    settings = Settings() if settings is None else settings
    app = FastAPI(
        title="percuss workbench",
        version=__version__,
        description="Impact motions of a bar driven against a wall. Numbers without a unit are dimensionless.",
        openapi_url="/api/openapi.json",
        docs_url=None,  # its page loads scripts from elsewhere
        redoc_url=None,
        redirect_slashes=False,
        lifespan=_lifespan,
        telemetry={"auto_configure": False},  # of newer versions of FastAPI: nothing is sent anywhere
    )
    app.state.settings = settings
    app.state.gate = Admission(settings.limits)
    app.state.kernels = Kernels()
    app.state.shelf = shelf = Shelf()
    for module in (case_routes, orbit_routes, motion_routes, hammer_routes):
        app.include_router(module.router)

    @app.api_route("/", methods=["GET", "HEAD"], include_in_schema=False)
    async def page(request: Request) -> Response:
        return shelf.answer(request, "index.html")

    @app.api_route("/favicon.ico", methods=["GET", "HEAD"], include_in_schema=False)
    async def icon(request: Request) -> Response:
        return shelf.answer(request, "icon.svg")

    @app.api_route("/static/{name:path}", methods=["GET", "HEAD"], include_in_schema=False)
    async def static(request: Request, name: str) -> Response:
        return shelf.answer(request, name)

    app.add_exception_handler(HTTPException, _refuse)
    app.add_exception_handler(RequestValidationError, _wrong)
    for kind in (PercussError, ArithmeticError, RecursionError, MemoryError):
        app.add_exception_handler(kind, _unanswerable)
    app.add_exception_handler(Exception, _failed)
    app.openapi = lambda: _schema(app)  # type: ignore[method-assign]
    return Guard(app, settings)


@asynccontextmanager
async def _lifespan(app: FastAPI) -> AsyncIterator[None]:
    app.state.kernels.begin(app.state.shelf.compress)
    if app.state.gate.quick.closed:  # begun again after an end
        app.state.gate = Admission(app.state.settings.limits)
    try:
        yield
    finally:
        app.state.gate.close()


# -- what errors become ---------------------------------------------------------------------------------------------


async def _refuse(_: Request, error: Exception) -> Response:
    assert isinstance(error, HTTPException)
    problems = error.problems if isinstance(error, Refusal) else [problem("", None, str(error.detail).lower())]
    answer = plain_json({"problems": problems}, error.status_code)
    answer.headers.update(error.headers or {})
    return answer


async def _wrong(_: Request, error: Exception) -> Response:
    """What pydantic refuses, in our form."""
    assert isinstance(error, RequestValidationError)
    found = [
        problem(".".join(str(step) for step in item["loc"][1:]), _given(item), _said(item["msg"]))
        for item in error.errors()[:32]
    ]
    return plain_json({"problems": found}, 422)


def _given(item: dict[str, Any]) -> Any:
    return None if item["type"] == "missing" else item.get("input")


def _said(message: str) -> str:
    return f"expected{message.removeprefix('Input should be')}" if message.startswith("Input should be") else message


async def _failed(_: Request, error: Exception) -> Response:
    """What nobody foresaw; the guard writes it into the log."""
    return plain_json({"problems": problems_of(error)}, 500)


async def _unanswerable(request: Request, error: Exception) -> Response:
    if not isinstance(error, PercussError):
        _log.warning("%s: %s", request.url.path, type(error).__name__)
    return plain_json({"problems": problems_of(error)}, 422)


def _schema(app: FastAPI) -> dict[str, Any]:
    """The OpenAPI schema, with our form of problems in place of FastAPI's."""
    if app.openapi_schema is None:
        made = get_openapi(title=app.title, version=app.version, description=app.description, routes=app.routes)
        schemas = made.setdefault("components", {}).setdefault("schemas", {})
        for name in ("HTTPValidationError", "ValidationError"):
            schemas.pop(name, None)
        schemas.update(_SCHEMAS)
        app.openapi_schema = made
    return app.openapi_schema


# ---- The files of the page: read once when the server starts, found by name in a list, never by a path

_KINDS = {
    ".html": "text/html; charset=utf-8",
    ".js": "text/javascript; charset=utf-8",
    ".mjs": "text/javascript; charset=utf-8",
    ".css": "text/css; charset=utf-8",
    ".svg": "image/svg+xml",
    ".png": "image/png",
    ".ico": "image/x-icon",
    ".woff2": "font/woff2",
    ".json": "application/json",
    ".webmanifest": "application/manifest+json",
}

_DENSE = (".png", ".ico", ".woff2")


@dataclass(frozen=True)
class _File:
    """One file of the page."""

    data: bytes
    dense: bool
    kind: str
    tag: str

    @cached_property
    def small(self) -> bytes | None:
        """Compressed when first asked for."""
        return None if self.dense else gzip.compress(self.data, 6, mtime=0)

    @classmethod
    def of(cls, data: bytes, suffix: str) -> _File:
        tag = f'"{hashlib.sha256(data).hexdigest()[:32]}"'
        return cls(data, suffix in _DENSE, _KINDS[suffix], tag)


class Shelf:
    """All files that are ever served, by name."""

    def __init__(self) -> None:
        self._files: dict[str, _File] = {}
        page = resources.files("percuss.web").joinpath("page")
        if page.is_dir():
            self._take(page, "")
            self._name_modules()

    def _take(self, folder: Traversable, prefix: str) -> None:
        for entry in folder.iterdir():
            suffix = Path(entry.name).suffix.lower()
            if entry.is_dir() and not entry.name.startswith(("_", ".")):
                self._take(entry, f"{prefix}{entry.name}/")
            elif entry.is_file() and suffix in _KINDS:
                self._files[f"{prefix}{entry.name}"] = _File.of(entry.read_bytes(), suffix)

    def _name_modules(self) -> None:
        """What main.js imports, named in index.html: the browser asks for all of it without reading file by file."""
        named: set[str] = set()
        wanted = ["main.js"]
        while wanted:
            name = wanted.pop()
            if name in self._files and name not in named:
                named.add(name)
                imports = re.findall(r'\bfrom "(\.[^"]+)"', self._files[name].data.decode())
                wanted += [posixpath.normpath(posixpath.join(posixpath.dirname(name), one)) for one in imports]
        links = [f'<link rel="modulepreload" href="/static/{name}">' for name in sorted(named)]
        page = self._files["index.html"].data.replace(b"<!-- modules -->", "\n".join(links).encode())
        self._files["index.html"] = _File.of(page, ".html")

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(sorted(self._files))

    def compress(self) -> None:
        """Have everything compressed before it is asked for; in a thread, beside other work."""
        for file in self._files.values():
            _ = file.small

    def answer(self, request: Request, name: str) -> Response:
        """One file, or that the browser has it already."""
        file = self._files.get(name)
        if file is None:
            raise refused(404, "there is no such page")
        headers = {"etag": file.tag, "cache-control": "no-cache", "vary": "accept-encoding"}
        if file.tag in (tag.strip() for tag in request.headers.get("if-none-match", "").split(",")):
            return Response(status_code=304, headers=headers)
        if "gzip" in request.headers.get("accept-encoding", "") and file.small is not None:
            return Response(file.small, media_type=file.kind, headers={**headers, "content-encoding": "gzip"})
        return Response(file.data, media_type=file.kind, headers=headers)
