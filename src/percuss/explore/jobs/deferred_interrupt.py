"""A few moments in which Ctrl-C waits."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager

__all__ = ["undisturbed"]


@contextmanager
def undisturbed() -> Iterator[None]:
    """The block runs to its end: Ctrl-C and SIGTERM take effect after it.

    zarr writes in a thread of its own. Were its caller interrupted, that thread would go on, and might put an older
    state of a file in the place of the one that is written at the end. Nor is a process left half started.
    """
    came: list[int] = []
    handlers = {}
    if threading.current_thread() is threading.main_thread():  # no other hears signals
        handlers = {which: signal.getsignal(which) for which in (signal.SIGINT, signal.SIGTERM)}
    handlers = {which: handler for which, handler in handlers.items() if callable(handler)}
    for which in handlers:
        signal.signal(which, lambda sig, _: came.append(sig))
    try:
        yield
    finally:
        for which in reversed(handlers):  # Ctrl-C last: from there on the next line may not be reached
            signal.signal(which, handlers[which])
    for sig in came:
        handler = handlers[signal.Signals(sig)]
        assert callable(handler)
        handler(sig, None)
