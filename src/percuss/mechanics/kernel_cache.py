"""Where numba keeps compiled kernels when neither the package's folder nor the user's cache can be written.

Without any such place numba refuses to compile at all. A read-only installation used by somebody without a home, as in
a container or a service, gets a folder of its own among the temporary files.
"""

from __future__ import annotations

import os
import stat
import sys
import tempfile
from functools import cache
from pathlib import Path

from percuss.errors import PercussError

_KERNELS = (
    "blow/kernels",
    "mechanics",
    "simulate/kernels",
    "stability",
    "steady/periodic/kernels",
    "steady/self_excited",
    "explore",
)
"""Rooms with compiled functions."""


@cache
def ensure_cache() -> None:
    """See that numba can keep what it compiles; tells in one line when that is a temporary place.

    Looked at once in a process: every answer that needs a kernel asks.

    Raises
    ------
    PercussError
        When nothing can be written anywhere.
    """
    if os.environ.get("NUMBA_CACHE_DIR"):
        return
    rooms = [Path(__file__).resolve().parents[1] / room / "__pycache__" for room in _KERNELS]
    if all(map(_writable, rooms)) or _writable(_users()):
        return
    folder = _temporary()
    os.environ["NUMBA_CACHE_DIR"] = folder  # worker processes inherit it
    if "numba" in sys.modules:
        sys.modules["numba"].config.CACHE_DIR = folder
    if sys.stderr is not None:
        told = f"compiled kernels are kept in {folder}; NUMBA_CACHE_DIR=FOLDER names a lasting place"
        print(f"percuss: note: {told}", file=sys.stderr)


def _users() -> Path:
    """The folder of the user's cache, as numba has it."""
    home = Path(os.path.expanduser("~"))
    if sys.platform == "win32":
        return Path(os.environ.get("LOCALAPPDATA", home)) / "numba"
    if sys.platform == "darwin":
        return home / "Library" / "Caches" / "numba"
    return Path(os.environ.get("XDG_CACHE_HOME") or home / ".cache") / "numba"


def _writable(folder: Path) -> bool:
    """Whether files can be made there, found out as numba finds it out."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return True
    except OSError:
        return False


def _temporary() -> str:
    """A folder that nobody else can have put anything into: what lies there is run. The next process finds it again."""
    try:
        if not hasattr(os, "getuid"):
            return tempfile.mkdtemp(prefix="percuss-kernels-")
        folder = Path(tempfile.gettempdir()) / f"percuss-kernels-{os.getuid()}"
        try:
            folder.mkdir(mode=0o700)
        except FileExistsError:
            found = folder.lstat()
            if not stat.S_ISDIR(found.st_mode) or found.st_uid != os.getuid() or found.st_mode & 0o077:
                return tempfile.mkdtemp(prefix="percuss-kernels-")
        return str(folder)
    except OSError as error:
        told = f"there is no place to keep compiled kernels in: {error.strerror or error}"
        raise PercussError(told, "set NUMBA_CACHE_DIR to a folder that can be written") from None
