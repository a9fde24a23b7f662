"""The compiled kernels, loaded beside the first requests: the page is there at once, its numbers wait for them."""

from __future__ import annotations

import asyncio
import gc
import logging
import sys
import threading
from collections.abc import Callable
from contextlib import suppress
from functools import cache

__all__ = ["Kernels"]

_PATIENCE = 5.0
"""Seconds that loading the kernels from numba's cache does not take."""

_log = logging.getLogger("percuss.web")


class Kernels:
    """Whether the kernels are there; without a server's `begin` nothing is waited for."""

    def __init__(self) -> None:
        self._loaded: asyncio.Event | None = None

    def begin(self, before: Callable[[], object]) -> None:
        """Load them in a thread of their own; `before` is done there first."""
        loop, loaded = asyncio.get_running_loop(), asyncio.Event()
        self._loaded = loaded

        def work() -> None:
            before()
            _load()
            gc.freeze()  # all that was loaded stays: else a look for cycles in it holds up an answer for 0.1 s
            with suppress(RuntimeError):  # the loop may be gone
                loop.call_soon_threadsafe(loaded.set)

        # a daemon: the end of the server does not wait for a compiler
        threading.Thread(target=work, name="percuss-kernels", daemon=True).start()

    async def wait(self) -> None:
        """Until they are loaded."""
        if self._loaded is not None and not self._loaded.is_set():
            await self._loaded.wait()


@cache
def _load() -> None:
    """Use each kernel once, so that no question waits for the compiler."""
    patience = threading.Timer(_PATIENCE, _tell_of_preparing)
    patience.daemon = True
    patience.start()
    try:
        from percuss.case import load_case, simulation_answer
        from percuss.case.curves import curves_dict

        case = load_case("mini-breaker")
        curves_dict(case, points=3, branches=3)
        simulation_answer(case.changed(simulation={"impacts": 2, "modes": 2}))
    except Exception:
        _log.exception("the kernels could not be loaded")
    finally:
        patience.cancel()


def _tell_of_preparing() -> None:
    text = "percuss: preparing; when kernels must be compiled about half a minute, later runs take them from a cache"
    print(text, file=sys.stderr, flush=True)
