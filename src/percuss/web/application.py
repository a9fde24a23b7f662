"""The application: routes, the guard before them, and what errors become."""

from __future__ import annotations

import logging
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any

from fastapi import FastAPI
from fastapi.exceptions import RequestValidationError
from fastapi.openapi.utils import get_openapi
from starlette.exceptions import HTTPException
from starlette.requests import Request
from starlette.responses import Response

from percuss._version import __version__
from percuss.errors import PercussError
from percuss.web import (
    blow_routes,
    branch_routes,
    case_routes,
    experiment_routes,
    machine_routes,
    motion_routes,
    report_routes,
    steady_routes,
)
from percuss.web.access_checks import Guard
from percuss.web.kernel_loading import Kernels
from percuss.web.lanes import Gate
from percuss.web.page_files import Shelf
from percuss.web.request_bodies import Refusal, problem, problems_of
from percuss.web.settings import Settings
from percuss.web.shared_by_routes import plain_json

_log = logging.getLogger("percuss.web")

_ROUTES = (
    case_routes,
    steady_routes,
    branch_routes,
    motion_routes,
    blow_routes,
    machine_routes,
    experiment_routes,
    report_routes,
)

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

    Raises
    ------
    MissingExtraError
        When a package of the extra ``web`` is not installed.

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
    app.state.gate = Gate(settings.limits)
    app.state.kernels = Kernels()
    app.state.shelf = shelf = Shelf()
    for module in _ROUTES:
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
        app.state.gate = Gate(app.state.settings.limits)
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
