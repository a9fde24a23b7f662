"""The workbench: a page on this machine, and the HTTP interface behind it; every number comes from the floors below.

`create_app` makes the ASGI application for any server, `serve` runs it with uvicorn as ``percuss serve`` does. Needs
the extra ``web``.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from percuss.web.application import create_app as create_app
    from percuss.web.serving import serve as serve
    from percuss.web.settings import Limits as Limits
    from percuss.web.settings import Settings as Settings

_HOME = {"Limits": "settings", "Settings": "settings", "create_app": "application", "serve": "serving"}

__all__ = sorted(_HOME)


def __getattr__(name: str) -> object:
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOME[name]}"), name)


def __dir__() -> list[str]:
    return sorted(__all__)
