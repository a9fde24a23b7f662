"""The command line: arguments to a case, an answer to text, problems to exit codes.

Nothing numerical is imported before a command needs it, so that ``percuss --help`` answers at once.
"""

from __future__ import annotations

import gc
import os
import signal
import sys
from collections.abc import Sequence
from types import FrameType

__all__ = ["main"]


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command ``percuss`` and return its exit code.

    Parameters
    ----------
    argv
        The arguments without the program's name; by default those of the process.

    Returns
    -------
    int
        0: answered (also "there is none"); 1: the output could not be written; 2: bad input; 130: interrupted, by
        Ctrl-C or SIGTERM.

    Examples
    --------
    >>> main(["--version"])
    percuss ...
    0
    """
    heard: list[int] = []
    try:
        if argv is None:  # our own process
            # its matrices are small, and waiting BLAS threads cost up to 2 s on busy cores
            os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
            # pydantic would look through all that is installed for plugins, of which a case needs none
            os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "1")
            signal.signal(signal.SIGTERM, _as_interrupt)
            _remember_interrupts(heard)
        from percuss.cli.app import run

        return run(sys.argv[1:] if argv is None else argv)
    except KeyboardInterrupt:
        print("\npercuss: interrupted", file=sys.stderr)
        return 130
    except Exception:
        if not heard:
            raise
        print("\npercuss: interrupted", file=sys.stderr)  # a library that was being loaded made another error of it
        return 130
    finally:
        if argv is None:
            # Python keeps in mind that an interrupt came out of code made from text, as named tuples are, and would
            # change the exit code at its end; until such code runs without one.
            exec("")
            # The answer is out: a Ctrl-C from here on, while Python takes itself down, would turn the exit code of a
            # finished command into "killed by SIGINT".
            signal.signal(signal.SIGINT, signal.SIG_IGN)
            signal.signal(signal.SIGTERM, signal.SIG_DFL)
            gc.freeze()  # all that is alive stays so to the end: Python's last look for cycles took up to 0.3 s


def _remember_interrupts(heard: list[int]) -> None:
    """Ctrl-C interrupts as ever, and is noted."""

    def interrupt(which: int, frame: FrameType | None) -> None:
        heard.append(which)
        signal.default_int_handler(which, frame)

    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:  # not where it is ignored, as under nohup
        signal.signal(signal.SIGINT, interrupt)


def _as_interrupt(_: int, frame: FrameType | None) -> None:
    """SIGTERM, as a batch system or a shutdown sends it, ends a command as Ctrl-C does: in order."""
    handler = signal.getsignal(signal.SIGINT)
    if not callable(handler):  # Ctrl-C is ignored, as under nohup
        raise KeyboardInterrupt
    handler(signal.SIGINT, frame)
