"""How functions are compiled, and what their cache on disk is valid for.

Five decorators. `entry`: called from Python; its machine code, with that of all it calls, is kept in numba's cache.
`inner`: called from compiled functions only, so that it needs neither a wrapper for Python, nor a cache of its own, nor
machine code (`percuss.machine_code`).
`inlined`: an `inner` that is copied into its callers, as a record of many arrays takes long to hand over.
`apart`: an `inner` that is made once, however many places call it. Of other ones numba makes copies where the function
that was the first to call them is copied: it hands that down.
`summed`: an `inner` whose sums may be reordered; NaN and infinity keep their meaning.

All of them work in arrays that the caller owns and make none. So numba is told not to count references to arrays: the
counting, atomic because of threads, took three quarters of the time of an impact. A function without a wrapper cannot
be called from Python: that would end the process. A test compiles it once more for itself, `njit(function.py_func)`.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from functools import cache, partial
from pathlib import Path
from typing import Any

from numba import njit

from percuss.machine_code import pipelines

__all__ = ["apart", "entry", "inlined", "inner", "sources_digest", "summed"]

_compile: Callable[..., Any] = njit  # with options that its types do not know
_PART, _WHOLE = pipelines()
_COMMON: dict[str, Any] = {"nogil": True, "error_model": "numpy", "_nrt": False}
# where nothing is said of fastmath, numba takes it from the caller that happens to be compiled first
_INNER: dict[str, Any] = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True, "fastmath": False, **_COMMON, **_PART}
_SUMS = {"reassoc", "contract", "nsz"}

inner: Callable[[Any], Any] = _compile(**_INNER)
"""Compile a function that only compiled functions call."""

apart: Callable[[Any], Any] = _compile(**(_INNER | {"forceinline": False}))
"""Compile a function that only compiled functions call, once for all of them, where `inner` would be copied."""

inlined: Callable[[Any], Any] = _compile(forceinline=True, **_INNER)
"""Compile a function that is copied into those that call it: records of arrays are costly to pass."""

summed: Callable[[Any], Any] = _compile(**(_INNER | {"fastmath": _SUMS}))
"""Compile a function that only compiled functions call, and whose sums may be reordered."""


def entry(function: Callable[..., Any]) -> Any:
    """Compile a function that Python calls, cached for as long as none of its sources changes.

    By itself numba looks at the date of the function's own file, and would go on using machine code that has an older
    version of a function of another file in it.
    """
    dispatcher = _compile(cache=True, no_cfunc_wrapper=True, **_COMMON, **_WHOLE)(function)
    file, digest = dispatcher._cache._cache_file, sources_digest(Path(function.__code__.co_filename))
    file._source_stamp = digest
    # The version is all that is read of an index before its types are: those of other sources may be gone.
    file._version = f"{file._version} {digest}"
    if hasattr(dispatcher._cache, "_load_overload"):
        dispatcher._cache.load_overload = partial(_loaded, dispatcher._cache)
    return dispatcher


def _loaded(kept: Any, signature: Any, target: Any) -> Any:
    """What is kept in the cache for a signature, or None.

    numba itself gets ready to compile before it looks: that takes longer than all else of loading.
    """
    with kept._guard_against_spurious_io_errors():
        return kept._load_overload(signature, target)


_ROOM = "kernels"
"""Name of a folder of compiled functions."""


@cache
def sources_digest(own: Path) -> str:
    """SHA-256 of the sources that a compiled function may consist of.

    Of one in a room of kernels: the files of that room. Of another: its own file, `*_kernels.py` beside it, and the
    room of the simulation. And this file and `machine_code`, for all.
    """
    here = Path(__file__)
    if own.parent.name == _ROOM:
        sources = [*own.parent.glob("*.py")]
    else:
        sources = [own, *own.parent.glob("*_kernels.py"), *(here.parent / "simulate" / _ROOM).glob("*.py")]
    files = {path.resolve() for path in (here, here.with_name("machine_code.py"), *sources)}
    found = hashlib.sha256()
    for path in sorted(files):
        found.update(path.name.encode() + b"\0" + path.read_bytes() + b"\0")
    return found.hexdigest()
