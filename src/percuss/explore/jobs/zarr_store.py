"""zarr's folder, written so that what it says is there is on the disk: also after a power cut."""

from __future__ import annotations

import asyncio
import os
from functools import lru_cache
from pathlib import Path
from typing import Any

from percuss.errors import ArchiveError, MissingExtraError
from percuss.whole_file import replaced, synced

__all__ = ["all_synced", "links_in", "store_of", "zarr_package"]


def zarr_package() -> Any:
    """zarr, imported when an archive is first used."""
    try:
        import zarr
        import zarr.codecs
        import zarr.storage
    except ImportError:
        raise MissingExtraError("zarr", "io") from None
    return zarr


def store_of(folder: Path, read_only: bool = False) -> Any:
    """A folder as zarr's store; every file in it is whole, and on the disk, before the next one is begun."""
    return _kind()(folder, read_only=read_only)


def all_synced(folder: Path) -> None:
    """Bring everything in a folder to the disk, when all of it was made."""
    for here, _, files in os.walk(folder):
        for name in files:
            synced(os.path.join(here, name))
        synced(here)


def links_in(folder: Path) -> None:
    """Refuse a folder in which something is kept elsewhere: an archive has no links, and would write through them.

    Raises
    ------
    ArchiveError
        Which names the link.
    """
    for here, folders, _ in os.walk(folder):
        for name in folders:
            if os.path.islink(os.path.join(here, name)):
                remedy = "an archive is one folder; put what the link names in its place"
                raise ArchiveError(str(folder), f"{os.path.join(here, name)} is a link", remedy)


@lru_cache(maxsize=1)
def _kind() -> Any:
    package = zarr_package()

    class DurableStore(package.storage.LocalStore):  # type: ignore[misc, name-defined]  # zarr is imported late
        """zarr's folder store, made durable: files of zarr's own may be empty after a power cut."""

        async def set(self, key: str, value: Any) -> None:
            if not self._is_open:
                await self._open()
            await asyncio.to_thread(self.set_sync, key, value)

        async def set_if_not_exists(self, key: str, value: Any) -> None:
            if not (self.root / key).exists():
                await self.set(key, value)

        def set_sync(self, key: str, value: Any) -> None:
            self._check_writable()
            path = self.root / key
            _made(path.parent)
            with replaced(path, follow=False) as part, open(part, "wb") as file:
                file.write(value.to_bytes())

    return DurableStore


def _made(folder: Path) -> None:
    """A folder, and its name on the disk."""
    if not folder.is_dir():
        _made(folder.parent)
        folder.mkdir(exist_ok=True)
        synced(folder.parent)
