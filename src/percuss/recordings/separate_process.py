"""A file read in a process of its own, with little memory and time: a reader that fails on a file dies alone.

The readers of HDF5 and MATLAB are large libraries in C, written for files that can be trusted: a few damaged bytes can
keep one busy for ever, where no signal reaches it. What was found comes back as JSON and plain numbers, nothing else.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from percuss.errors import HistoryError, Interrupted, MissingExtraError, PercussError
from percuss.halting import check_interrupted
from percuss.recordings.untrusted_files import Damaged

Found = tuple[dict[str, Any], dict[str, npt.NDArray[Any]]]  # what a reader answers: plain values, and arrays by name

_MEMORY, _SECONDS = 2 * 2**30, 20.0
_ERRORS = import_module("percuss.errors")  # by its name: the package imports what imports this
_START = "from percuss.recordings.separate_process import serve; serve()"
_COPIES = 12  # times its size that a file may take in memory: as it is, unpacked, and on its way

inside = False  # whether this is such a process: what it reads, it reads itself


class Died(HistoryError):
    """A file of which its reader died, or did not come to an end."""


@dataclass(frozen=True)
class ReaderBounds:
    """What a reader may take: bytes of memory, seconds, bytes of its answer."""

    memory: int = _MEMORY
    seconds: float = _SECONDS
    answer: int = _MEMORY


def bounds_of(path: Path) -> ReaderBounds:
    """What a file of one's own may take, which can be large."""
    size = path.stat().st_size
    return ReaderBounds(_MEMORY + _COPIES * size, _SECONDS + size / 2**22, _MEMORY + _COPIES * size)


def need(package: str) -> None:
    """Refuse, before a process is started, what cannot be read without a package that is not installed."""
    if find_spec(package) is None:
        raise MissingExtraError(package, "io")


def read_apart(
    reader: str, path: Path, options: Mapping[str, Any], bounds: ReaderBounds, halt: Callable[[], bool] | None = None
) -> Found:
    """What ``module:function`` finds in a file within `bounds`, in another process; Ctrl-C, or `halt`, ends it."""
    if inside:
        return _called(reader, path, options)
    asked = {"reader": reader, "path": str(path), "options": dict(options), "memory": bounds.memory}
    command = [sys.executable, "-P", "-c", _START]
    # a session of its own, so that Ctrl-C at a terminal is heard here alone
    with subprocess.Popen(
        command,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        env={**os.environ, "OPENBLAS_NUM_THREADS": "1"},
        start_new_session=True,
        creationflags=getattr(subprocess, "CREATE_NEW_PROCESS_GROUP", 0),
    ) as process:
        try:
            answer = _answer(process, json.dumps(asked | {"seconds": bounds.seconds}).encode(), bounds, halt)
        finally:
            process.kill()
            process.wait()
    if answer is None:
        raise Died(
            f"reading it did not end within {bounds.seconds:.0f} s: it is damaged", "use a copy of it", str(path)
        )
    try:
        if len(answer) > bounds.answer:
            raise ValueError
        found = _unpacked(answer)
    except (ValueError, LookupError, TypeError, AttributeError):
        what = f"its reader died of it, or needs more than {bounds.memory / 2**30:.3g} GB: it is damaged"
        raise Died(what, "use a copy of it", str(path)) from None
    if isinstance(found, PercussError):
        raise found
    return found


def _answer(
    process: subprocess.Popen[bytes], asked: bytes, bounds: ReaderBounds, halt: Callable[[], bool] | None
) -> bytes | None:
    """All that the process writes; None when it takes too long."""
    until = time.monotonic() + bounds.seconds
    given: bytes | None = asked
    while time.monotonic() < until:
        try:
            return process.communicate(given, timeout=0.1)[0]
        except subprocess.TimeoutExpired:
            given = None
        check_interrupted()
        if halt is not None and halt():
            raise Interrupted(0, 1, None)
    return None


def _unpacked(answer: bytes) -> Found | PercussError:
    """The answer: a line of JSON, and the numbers of the arrays that it names, one after another."""
    at = answer.index(b"\n") + 1
    head = json.loads(answer[:at])
    if "error" in head:
        kind = Damaged if head["error"] == Damaged.__name__ else getattr(_ERRORS, head["error"])
        error: PercussError = kind.__new__(kind)
        error.args = (head["state"]["message"],)
        error.__dict__.update(head["state"])
        return error
    arrays = {}
    for name, kind, shape in head["arrays"]:
        size = int(np.prod(shape, dtype=np.int64))
        arrays[name] = (
            np.frombuffer(answer, np.dtype(kind), size, at).reshape(shape).copy() if size else np.empty(shape, kind)
        )
        at += arrays[name].nbytes
    return head["told"], arrays


def serve() -> None:
    """Read what standard input asks for, and write what was found to standard output."""
    global inside
    asked = json.load(sys.stdin)
    inside = True
    _bound(asked["memory"], asked["seconds"])
    try:
        told, arrays = _called(asked["reader"], Path(asked["path"]), asked["options"])
    except PercussError as error:
        known = (*_ERRORS.__all__, Damaged.__name__)
        kind = next(kind.__name__ for kind in type(error).__mro__ if kind.__name__ in known)
        head: dict[str, Any] = {"error": kind, "state": error.__dict__}
        arrays = {}
    else:
        sent = {name: np.ascontiguousarray(array) for name, array in arrays.items()}
        head = {"told": told, "arrays": [(name, array.dtype.str, arrays[name].shape) for name, array in sent.items()]}
        arrays = sent
    out = sys.stdout.buffer
    out.write(json.dumps(head, default=str).encode() + b"\n")
    for array in arrays.values():
        out.write(array.tobytes())
    out.flush()


def _called(reader: str, path: Path, options: Mapping[str, Any]) -> Found:
    module, _, function = reader.partition(":")
    found: Found = getattr(import_module(module), function)(path, options)
    return found


def _bound(memory: int, seconds: float) -> None:
    """Limit this process, as far as the operating system can: memory, processor time, no files, no core dump."""
    with suppress(ImportError):  # of Windows
        import resource

        for what, most in (("AS", memory), ("CPU", int(seconds) + 1), ("FSIZE", 0), ("CORE", 0)):
            kind = getattr(resource, f"RLIMIT_{what}", None)
            if kind is not None:
                with suppress(OSError, ValueError):  # less was allowed before
                    resource.setrlimit(kind, (most, most))
