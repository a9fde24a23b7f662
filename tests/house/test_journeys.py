"""How many files of the package a command runs through: what its reader may have to open. They are to grow fewer."""

from __future__ import annotations

import contextlib
import inspect
import io
import sys
from pathlib import Path
from types import FrameType
from typing import Any

import pytest

import percuss
from percuss.cli.app import run

HOUSE = str(Path(percuss.__file__).parent)


@pytest.mark.parametrize(
    ("command", "most"),
    [("steady hydraulic-drifter", 79), ("simulate hydraulic-drifter", 66), ("machine valve-breaker", 63)],
)
def test_a_command_runs_through_no_more_files(command: str, most: int) -> None:
    files: set[str] = set()

    def seen(frame: FrameType, event: str, _: Any) -> None:
        code = frame.f_code
        in_function = code.co_flags & inspect.CO_OPTIMIZED  # and in no module or class that is being imported
        if event == "call" and code.co_filename.startswith(HOUSE) and in_function:
            files.add(code.co_filename)

    before = sys.getprofile()
    sys.setprofile(seen)
    try:
        with contextlib.redirect_stdout(io.StringIO()):
            assert run(command.split()) == 0
    finally:
        sys.setprofile(before)
    assert 20 < len(files) <= most
