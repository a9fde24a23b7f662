"""The files of the page: read once when the server starts, found by name in a list, never by a path."""

from __future__ import annotations

import gzip
import hashlib
from dataclasses import dataclass
from functools import cached_property
from importlib import resources
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

from starlette.requests import Request
from starlette.responses import Response

from percuss.errors import MissingExtraError
from percuss.web.request_bodies import refused

if TYPE_CHECKING:
    from importlib.resources.abc import Traversable

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
        """Compressed when first asked for, which takes a while for plotly."""
        return None if self.dense else gzip.compress(self.data, 6, mtime=0)

    @classmethod
    def of(cls, data: bytes, suffix: str) -> _File:
        tag = f'"{hashlib.sha256(data).hexdigest()[:32]}"'
        return cls(data, suffix in _DENSE, _KINDS[suffix], tag)


class Shelf:
    """All files that are ever served, by name.

    Raises
    ------
    MissingExtraError
        When plotly, whose script draws the diagrams, is not installed.
    """

    def __init__(self) -> None:
        self._files: dict[str, _File] = {}
        page = resources.files("percuss.web").joinpath("page")
        if page.is_dir():
            self._take(page, "")
            self._name_modules()
        self._files["plotly.min.js"] = _File.of(_plotly().read_bytes(), ".js")

    def _take(self, folder: Traversable, prefix: str) -> None:
        for entry in folder.iterdir():
            suffix = Path(entry.name).suffix.lower()
            if entry.is_dir() and not entry.name.startswith(("_", ".")):
                self._take(entry, f"{prefix}{entry.name}/")
            elif entry.is_file() and suffix in _KINDS:
                self._files[f"{prefix}{entry.name}"] = _File.of(entry.read_bytes(), suffix)

    def _name_modules(self) -> None:
        """Every module named in index.html: the browser asks for all of them without reading one after the other."""
        links = [f'<link rel="modulepreload" href="/static/{name}">' for name in self.names if name.endswith(".js")]
        page = self._files["index.html"].data.replace(b"<!-- modules -->", "\n".join(links).encode())
        self._files["index.html"] = _File.of(page, ".html")

    @property
    def names(self) -> tuple[str, ...]:
        """What there is."""
        return tuple(sorted(self._files))

    def compress(self) -> None:
        """Have everything compressed before it is asked for; in a thread, beside other work."""
        for file in self._files.values():
            _ = file.small

    def answer(self, request: Request, name: str) -> Response:
        """One file, or that the browser has it already.

        Raises
        ------
        Refusal
            404 for a name that is not on the shelf.
        """
        file = self._files.get(name)
        if file is None:
            raise refused(404, "there is no such page")
        headers = {"etag": file.tag, "cache-control": "no-cache", "vary": "accept-encoding"}
        if file.tag in (tag.strip() for tag in request.headers.get("if-none-match", "").split(",")):
            return Response(status_code=304, headers=headers)
        if "gzip" in request.headers.get("accept-encoding", "") and file.small is not None:
            return Response(file.small, media_type=file.kind, headers={**headers, "content-encoding": "gzip"})
        return Response(file.data, media_type=file.kind, headers=headers)


def _plotly() -> Path:
    found = find_spec("plotly")
    if found is None or found.origin is None:
        raise MissingExtraError("plotly", "web")
    return Path(found.origin).parent / "package_data" / "plotly.min.js"
