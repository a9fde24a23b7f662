"""A recording read in a process of its own, with little memory and time: a reader that fails on a file dies alone.

The readers of HDF5 and MATLAB are large libraries in C, written for files that can be trusted. What they found comes
back as JSON, and nothing else does.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

from percuss.errors import CaseError, Interrupted, MissingExtraError

__all__ = ["read_apart"]

_MEMORY = 2 * 2**30
_SECONDS = 20
_MOST_ANSWER = 4_000_000
"""Characters: a thousand harmonics take 50 000."""

_DIED = "it could not be read within the memory and the time allowed for an upload"


def read_apart(path: Path, options: dict[str, Any], halt: Callable[[], bool] | None = None) -> dict[str, Any]:
    """What `percuss.case.uploads.uploaded_file.read_here` finds, found by another process.

    Raises
    ------
    CaseError, MissingExtraError
        As there; CaseError also when the process died.
    Interrupted
        When `halt` returned true.
    """
    environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1"}
    command = [sys.executable, "-P", "-m", "percuss.case.uploads.separate_process"]
    with subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, env=environment
    ) as process:
        try:
            asked = json.dumps({"path": str(path), "options": options}).encode()
            told = _answer(process, asked, halt)
        finally:
            process.kill()
    try:
        found = json.loads(told[:_MOST_ANSWER])
        kind = found.pop("kind")
    except (ValueError, KeyError, AttributeError):
        raise CaseError("upload", "load.file", None, _DIED, "save it as CSV") from None
    if kind == "missing":
        raise MissingExtraError(found["package"], found["extra"])
    if kind == "problem":
        raise CaseError("upload", found["key"], found["value"], found["accepted"], found["remedy"])
    return dict(found)


def _answer(process: subprocess.Popen[bytes], asked: bytes, halt: Callable[[], bool] | None) -> bytes:
    until = time.monotonic() + _SECONDS
    given: bytes | None = asked
    while time.monotonic() < until:
        try:
            return process.communicate(given, timeout=0.1)[0]
        except subprocess.TimeoutExpired:
            given = None
        if halt is not None and halt():
            raise Interrupted(0, 1, None)
    return b""


def _main() -> None:
    asked = json.load(sys.stdin)
    _bound()
    from percuss.case.uploads.uploaded_file import read_here

    try:
        found: dict[str, Any] = {"kind": "found", **read_here(Path(asked["path"]), asked["options"])}
    except CaseError as error:
        value = error.value if isinstance(error.value, str | int | float | None) else str(error.value)
        found = {"kind": "problem", "key": error.key, "value": value}
        found |= {"accepted": error.accepted, "remedy": error.remedy}
    except MissingExtraError as error:
        found = {"kind": "missing", "package": error.package, "extra": error.extra}
    print(json.dumps(found))


def _bound() -> None:
    """Limit this process, as far as the operating system can: memory, processor time, no files, no core dump."""
    with suppress(ImportError):  # of Windows
        import resource

        for what, most in (("AS", _MEMORY), ("CPU", _SECONDS), ("FSIZE", 0), ("CORE", 0)):
            kind = getattr(resource, f"RLIMIT_{what}", None)
            if kind is not None:
                with suppress(OSError, ValueError):  # less was allowed before
                    resource.setrlimit(kind, (most, most))


if __name__ == "__main__":
    _main()
