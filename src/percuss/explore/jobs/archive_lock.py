"""One writer at a time: a file that tells who writes, and that the system frees when the writer dies."""

from __future__ import annotations

import json
import os
import socket
from contextlib import suppress
from pathlib import Path
from typing import Any

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None  # type: ignore[assignment]

from percuss.errors import ArchiveError

__all__ = ["LOCK", "Lock", "is_locked"]

LOCK = ".percuss-lock"
"""Name of the file inside the folder that it locks."""

_NO_LINK = getattr(os, "O_NOFOLLOW", 0)


class Lock:
    """The right to write into a folder, from now on until `release` or the end of the process, however that comes.

    Parameters
    ----------
    folder
        What is to be written into.
    name
        What messages call it; the folder by default.

    Raises
    ------
    ArchiveError
        When another process, or another part of this one, holds it.
    OSError
        When the folder cannot be written.
    """

    def __init__(self, folder: Path, name: str | None = None) -> None:
        self._file = folder / LOCK
        self._name = name or str(folder)
        self._handle: int | None = self._taken()

    def release(self) -> None:
        """Let others write; does nothing the second time."""
        if self._handle is None:
            return
        with suppress(OSError):
            self._file.unlink()  # first, so that nobody takes a file that is about to go
        os.close(self._handle)
        self._handle = None

    def moved(self, folder: Path) -> None:
        """The folder was given another name; the lock went with it."""
        self._file = folder / LOCK
        self._name = str(folder)

    def _taken(self) -> int:
        while True:
            handle = os.open(self._file, os.O_RDWR | os.O_CREAT | _NO_LINK, 0o666)
            try:
                if not _free(handle, self._file):
                    raise self._busy()
                if not _same(handle, self._file):  # its holder has just let go and taken the file away
                    os.close(handle)
                    continue
                os.ftruncate(handle, 0)
                os.pwrite(handle, json.dumps({"pid": os.getpid(), "host": socket.gethostname()}).encode(), 0)
            except BaseException:
                with suppress(OSError):
                    os.close(handle)
                raise
            return handle

    def _busy(self) -> ArchiveError:
        who = _holder(self._file)
        whose = f"process {who['pid']} on {who['host']}" if who else "another process"
        remedy = f"wait for it, or end it; if it is long dead remove {self._file}"
        return ArchiveError(self._name, f"{whose} is writing it", remedy)


def is_locked(folder: Path) -> bool:
    """Whether somebody writes into the folder now; a lock that a dead process left does not count."""
    file = folder / LOCK
    try:
        handle = os.open(file, os.O_RDWR | _NO_LINK)
    except OSError:
        return file.exists() and _alive(_holder(file))
    try:
        return not _free(handle, file)
    finally:
        os.close(handle)


def _free(handle: int, file: Path) -> bool:
    """Take the system's lock where there is one; else look whether the process that left the file lives."""
    if fcntl is not None:
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
            return True
        except BlockingIOError:
            return False
        except OSError:  # this file system has no locks
            pass
    return not _alive(_holder(file))


def _same(handle: int, file: Path) -> bool:
    try:
        return os.path.samestat(os.fstat(handle), os.stat(file))
    except FileNotFoundError:
        return False


def _holder(file: Path) -> dict[str, Any]:
    try:
        found = json.loads(file.read_text())
        return {"pid": int(found["pid"]), "host": str(found["host"])}
    except (OSError, ValueError, KeyError, TypeError, RecursionError):
        return {}


def _alive(who: dict[str, Any]) -> bool:
    """Nobody can tell of another host, and Windows has no harmless question: they count as alive."""
    if not who:
        return False
    if who["host"] != socket.gethostname() or os.name == "nt":
        return True
    try:
        os.kill(who["pid"], 0)
    except ProcessLookupError:
        return False
    except OSError:
        return True
    return True
