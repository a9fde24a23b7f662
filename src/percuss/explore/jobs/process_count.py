"""How many processes a job gets: this depends on what is asked, never on how busy the machine is.

Worker processes are started without the script that asks, so that it needs no main guard. Only a job that holds
functions or classes of the script's own main part makes them import it; that is safe where the call stands under
``if __name__ == "__main__":``.
"""

from __future__ import annotations

import ast
import math
import sys
import threading
from types import FrameType, ModuleType

from percuss.errors import PercussError
from percuss.explore.jobs.job import Job
from percuss.explore.jobs.pool import cores, needs_main, packed

__all__ = ["SMALL", "helpers"]

SMALL = 3.0
"""Seconds of work for which no processes are started: they take a second or two themselves."""


def helpers(job: Job, asked: int | None) -> int:
    """Processes for a job: as many as asked for, or by default all cores for a large one and this process otherwise.

    Raises
    ------
    PercussError
        When processes are asked for that cannot import what the job holds.
    """
    if asked == 1 or (asked is None and (cores() == 1 or float(getattr(job, "rough_seconds", math.inf)) <= SMALL)):
        return 1
    try:
        reason = _unreachable() if needs_main(packed(job)) else ""
        if not reason:
            return cores() if asked is None else asked
        remedy = "define functions and classes in a module of their own, or use workers=1"
        raise PercussError(f"worker processes cannot import what this job uses from the main script: {reason}", remedy)
    except PercussError:
        if asked is None:
            return 1
        raise


def _unreachable() -> str:
    """Why worker processes cannot import the main part without running this call again; "" when they can."""
    main = sys.modules["__main__"]
    file = getattr(main, "__file__", None)
    if file is None:
        return "an interactive session has no file"
    line = _line_in(main)
    try:
        with open(file, "rb") as source:
            tree = ast.parse(source.read())
    except (OSError, SyntaxError, ValueError):
        return f"{file} cannot be read"
    for statement in tree.body:
        if statement.lineno <= line <= (statement.end_lineno or statement.lineno) and _is_guard(statement):
            return ""
    return "this call is not under `if __name__ == '__main__':`, which would keep them from running it again"


def _line_in(main: ModuleType) -> int:
    """The line that the main part is at, in the thread that runs it; 0 when it has ended."""
    frame: FrameType | None = sys._current_frames().get(threading.main_thread().ident or 0)
    while frame is not None:
        if frame.f_globals is main.__dict__ and frame.f_code.co_name == "<module>":
            return frame.f_lineno
        frame = frame.f_back
    return 0


def _is_guard(statement: ast.stmt) -> bool:
    """Whether a statement begins with ``if __name__ == "__main__"``, in either order."""
    if not isinstance(statement, ast.If) or not isinstance(statement.test, ast.Compare):
        return False
    sides = [statement.test.left, *statement.test.comparators]
    names = [side.id for side in sides if isinstance(side, ast.Name)]
    texts = [side.value for side in sides if isinstance(side, ast.Constant)]
    return names == ["__name__"] and texts == ["__main__"] and isinstance(statement.test.ops[0], ast.Eq)
