"""The command line: arguments to a case, an answer to text, problems to exit codes.

Nothing numerical is imported before a command needs it, so that ``percuss --help`` answers at once.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence

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
        0: answered (also "there is none"); 1: the output could not be written; 2: bad input; 130: interrupted.

    Examples
    --------
    >>> main(["--version"])
    percuss ...
    0
    """
    try:
        if (
            argv is None
        ):  # our own process: its matrices are small, and waiting BLAS threads cost up to 2 s on busy cores
            os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
        from percuss.cli.app import run

        return run(sys.argv[1:] if argv is None else argv)
    except KeyboardInterrupt:
        print("\npercuss: interrupted", file=sys.stderr)
        return 130
