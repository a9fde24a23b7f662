"""What is printed cannot steer the terminal: titles, keys and commands come from files that anybody may have written.

All that a command prints goes through the streams that `neutral_streams` puts in place (`percuss.neutral`).
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from percuss.neutral import neutral

__all__ = ["neutral_streams", "raw"]


def raw(stream: Any) -> Any:
    """The stream behind a neutral one, for what this program draws itself."""
    return getattr(stream, "rich_proxied_file", stream)


@contextmanager
def neutral_streams() -> Iterator[None]:
    """For the time of the block standard output and standard error are neutral; rich draws past them."""
    before = sys.stdout, sys.stderr
    if sys.stdout is not None:
        sys.stdout = _Neutral(sys.stdout)
    if sys.stderr is not None:
        sys.stderr = _Neutral(sys.stderr)
    try:
        yield
    finally:
        sys.stdout, sys.stderr = before


class _Neutral:
    """A stream whose text steers nothing. rich looks for the attribute, and writes its own colours there."""

    def __init__(self, stream: Any) -> None:
        self.rich_proxied_file = raw(stream)

    def write(self, text: str) -> int:
        self.rich_proxied_file.write(neutral(text))
        return len(text)

    def writelines(self, lines: Any) -> None:
        for line in lines:
            self.write(line)

    def __getattr__(self, name: str) -> Any:
        return getattr(self.rich_proxied_file, name)
