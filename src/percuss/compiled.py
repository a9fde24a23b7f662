"""How functions are compiled, and what their cache on disk is valid for.

Four decorators. `entry`: called from Python; its machine code, with that of all it calls, is kept in numba's cache.
`inner`: called from compiled functions only, so that it needs neither a wrapper for Python nor a cache of its own.
`inlined`: an `inner` that is copied into its callers, as a record of many arrays takes long to hand over.
`summed`: an `inner` whose sums may be reordered; NaN and infinity keep their meaning.

All of them work in arrays that the caller owns and make none. So numba is told not to count references to arrays: the
counting, atomic because of threads, took three quarters of the time of an impact. A function without a wrapper cannot
be called from Python: that would end the process. A test compiles it once more for itself, `njit(function.py_func)`.
"""

from __future__ import annotations

import hashlib
import sys
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from numba import njit

__all__ = ["copied", "entry", "inlined", "inner", "sources_digest", "summed"]


def _spare_blas() -> None:
    """Have numba's array functions loaded without scipy's BLAS, which takes longer than all else that is loaded here.

    They look whether it is there when they are loaded; what uses it looks again. Without numba's inner names, as they
    are now, it is loaded as ever.
    """
    if "numba.np.arraymath" in sys.modules:
        return

    def absent() -> None:
        raise ImportError

    with suppress(ImportError, AttributeError):
        linalg: Any = import_module("numba.np.linalg")
        looks, linalg.ensure_blas = linalg.ensure_blas, absent
        try:
            arraymath: Any = import_module("numba.np.arraymath")
        finally:
            linalg.ensure_blas = looks
        arraymath.ensure_blas, arraymath._HAVE_BLAS = looks, find_spec("scipy") is not None


_spare_blas()

_compile: Callable[..., Any] = njit  # with options that its types do not know
_COMMON: dict[str, Any] = {"nogil": True, "error_model": "numpy", "_nrt": False}
# where nothing is said of fastmath, numba takes it from the caller that happens to be compiled first
_INNER: dict[str, Any] = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True, "fastmath": False, **_COMMON}
_SUMS = {"reassoc", "contract", "nsz"}

inner: Callable[[Any], Any] = _compile(**_INNER)
"""Compile a function that only compiled functions call."""

inlined: Callable[[Any], Any] = _compile(forceinline=True, **_INNER)
"""Compile a function that is copied into those that call it: records of arrays are costly to pass."""

copied: Callable[[Any], Any] = _compile(inline="always", **_COMMON)
"""Write a function into the only one that calls it, before anything is compiled."""

summed: Callable[[Any], Any] = _compile(**(_INNER | {"fastmath": _SUMS}))
"""Compile a function that only compiled functions call, and whose sums may be reordered."""


def entry(function: Callable[..., Any]) -> Any:
    """Compile a function that Python calls, cached for as long as none of its sources changes.

    By itself numba looks at the date of the function's own file, and would go on using machine code that has an older
    version of a function of another file in it.
    """
    dispatcher = _compile(cache=True, no_cfunc_wrapper=True, **_COMMON)(function)
    file, digest = dispatcher._cache._cache_file, sources_digest(Path(function.__code__.co_filename))
    file._source_stamp = digest
    # The version is all that is read of an index before its types are: those of other sources may be gone.
    file._version = f"{file._version} {digest}"
    return dispatcher


_ROOM = "kernels"
"""Name of a folder of compiled functions."""


@cache
def sources_digest(own: Path) -> str:
    """SHA-256 of the sources that a compiled function may consist of.

    Of one in a room of kernels: the files of that room. Of another: its own file, `*_kernels.py` beside it, and the
    room of the simulation. And this file, for all.
    """
    here = Path(__file__)
    if own.parent.name == _ROOM:
        sources = [*own.parent.glob("*.py")]
    else:
        sources = [own, *own.parent.glob("*_kernels.py"), *(here.parent / "simulate" / _ROOM).glob("*.py")]
    files = {path.resolve() for path in (here, *sources)}
    found = hashlib.sha256()
    for path in sorted(files):
        found.update(path.name.encode() + b"\0" + path.read_bytes() + b"\0")
    return found.hexdigest()
