"""How a cell of a page runs, in the documentation and in its tests: Python, and lines ``!percuss …``.

As an IPython extension it lets ``!percuss …`` run in the kernel itself: the output is plain, as in a pipe, and a
command that fails is an error of the page, where IPython would go on.
"""

from __future__ import annotations

import contextlib
import io
import re
import shlex
import sys
from pathlib import Path

__all__ = ["CommandError", "command", "load_ipython_extension", "python_of", "reset_style"]

_COMMAND = re.compile(r"^!(percuss\b.*)$", re.MULTILINE)


class CommandError(Exception):
    """A command of a page that did not succeed."""


def command(line: str) -> None:
    """Run ``percuss …``; what it prints goes to standard output, or with ``> FILE`` at its end into the file.

    Raises
    ------
    CommandError
        For an exit code other than 0, with what the command says on standard error.
    """
    from percuss.cli import main

    arguments = shlex.split(line, comments=True)[1:]
    target = None
    if len(arguments) > 1 and arguments[-2] == ">":
        target = arguments[-1]
        del arguments[-2:]
    printed, said = io.StringIO(), io.StringIO()
    with contextlib.redirect_stderr(said), contextlib.redirect_stdout(printed if target else sys.stdout):
        code = main(arguments)
    if code != 0:
        raise CommandError(f"exit code {code}\n{said.getvalue().rstrip()}")
    if target:
        Path(target).write_text(printed.getvalue(), encoding="utf-8")


def python_of(cell: str) -> str:
    """The cell with its lines ``!percuss …`` as calls of `command`.

    Raises
    ------
    ValueError
        For other things that only a notebook understands: ``!ls``, ``%time``, ``%%bash``.
    """
    made = _COMMAND.sub(lambda found: f"__import__('cells').command({found[1]!r})", cell)
    other = re.search(r"^[!%].*$", made, re.MULTILINE)
    if other:
        raise ValueError(f"{other[0]}: cells hold Python and lines '!percuss …', nothing else")
    return made


def load_ipython_extension(shell: object) -> None:
    """What IPython calls when it starts: see ``docs/conf.py``."""
    shell.input_transformers_cleanup.append(lambda lines: python_of("".join(lines)).splitlines(keepends=True))
    shell.run_line_magic("xmode", "Minimal")  # the error, not the way through this machine's files to it


def reset_style(_settings: object, _script: str) -> None:
    """The style of the documentation's figures, before and after each script of the gallery."""
    import matplotlib

    matplotlib.rc_file(Path(__file__).parent.parent / "matplotlibrc")
