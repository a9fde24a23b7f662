"""The compiled kernels, loaded beside the first requests: what the closed form answers does not wait for them."""

from __future__ import annotations

import asyncio
import gc
import logging
import sys
import threading
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from typing import Literal

__all__ = ["Kernels", "Part"]

Part = Literal["multipliers", "motions"]
"""Those of the planes of exact multipliers, and those of the simulator."""

_PATIENCE = 5.0
"""Seconds that loading the kernels from numba's cache does not take."""

_log = logging.getLogger("percuss.web")


class Kernels:
    """Which kernels are there; without a server's `begin` nothing is waited for."""

    def __init__(self) -> None:
        self._loaded: dict[Part, asyncio.Event] = {}

    def begin(self, before: Callable[[], object]) -> None:
        """Load them in a thread of their own; `before` is done there first."""
        loop = asyncio.get_running_loop()
        self._loaded = {"multipliers": asyncio.Event(), "motions": asyncio.Event()}

        def loaded(part: Part) -> None:
            with suppress(RuntimeError):  # the loop may be gone
                loop.call_soon_threadsafe(self._loaded[part].set)

        def work() -> None:
            before()
            with _Patience():
                _load_multipliers()
                loaded("multipliers")
                _load_motions()
            gc.freeze()  # all that was loaded stays: else a look for cycles in it holds up an answer for 0.1 s
            loaded("motions")

        # a daemon: the end of the server does not wait for a compiler
        threading.Thread(target=work, name="percuss-kernels", daemon=True).start()

    def has(self, part: Part) -> bool:
        """Whether these are loaded."""
        return part not in self._loaded or self._loaded[part].is_set()

    async def wait(self, part: Part) -> None:
        """Until these are loaded."""
        if not self.has(part):
            await self._loaded[part].wait()


# Each kernel is used once, so that no question waits for the compiler.


@cache
def _load_multipliers() -> None:
    try:
        from percuss.case import load_case
        from percuss.case.curves import curves_dict

        curves_dict(load_case("mini-breaker"), points=3, branches=3)
    except Exception:
        _log.exception("the kernels of the multipliers could not be loaded")


@cache
def _load_motions() -> None:
    try:
        from percuss.case import load_case, simulation_answer

        simulation_answer(load_case("mini-breaker").changed(simulation={"impacts": 2, "modes": 2}))
    except Exception:
        _log.exception("the kernels of the simulator could not be loaded")


class _Patience:
    """Says that something takes long when it does."""

    def __enter__(self) -> None:
        self._timer = threading.Timer(_PATIENCE, _tell_of_preparing)
        self._timer.daemon = True
        self._timer.start()

    def __exit__(self, *_: object) -> None:
        self._timer.cancel()


def _tell_of_preparing() -> None:
    text = (
        "percuss: compiling the kernels, which takes up to a minute; steady motions are answered already, "
        "simulations wait for it, and later runs take the kernels from a cache"
    )
    print(text, file=sys.stderr, flush=True)
