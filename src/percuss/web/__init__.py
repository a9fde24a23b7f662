"""The workbench: a page on this machine, and the HTTP interface behind it; every number comes from the floors below.

`create_app` makes the ASGI application for any server, `serve` runs it with uvicorn as ``percuss serve`` does. Needs
the extra ``web``.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from percuss.lazy_names import lazy_names

if TYPE_CHECKING:
    from percuss.web.application import create_app
    from percuss.web.serving import serve
    from percuss.web.settings import Limits, Settings

__all__, __getattr__, __dir__ = lazy_names(__name__, __file__)
