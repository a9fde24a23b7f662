"""The compiled kernels, loaded beside the first requests: what the closed form answers does not wait for them."""

from __future__ import annotations

import asyncio
import gc
import logging
import sys
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from typing import Literal, Self

Part = Literal["multipliers", "motions", "blows", "machines", "orbits"]
"""Those of the planes of exact multipliers, those of the simulator and what is made with it, those of blows, those of
machines that switch themselves: their maps and their motions, and those of orbits and their branches."""

_PATIENCE = 5.0
"""Seconds that loading the kernels from numba's cache does not take."""

_log = logging.getLogger("percuss.web")


class Kernels:
    """Which kernels are there; without a server's `begin` nothing is waited for."""

    def __init__(self) -> None:
        self._settled: dict[Part, asyncio.Event] = {}
        self._failed: set[Part] = set()

    def begin(self, before: Callable[[], object]) -> None:
        """Load them in a thread of their own; `before` is done there first."""
        loop = asyncio.get_running_loop()
        events: dict[Part, asyncio.Event] = {part: asyncio.Event() for part in _USES}
        failed: set[Part] = set()
        self._settled, self._failed = events, failed

        def settle(part: Part, good: bool) -> None:
            if not good:
                failed.add(part)
            with suppress(RuntimeError):  # the loop may be gone
                loop.call_soon_threadsafe(events[part].set)

        def work() -> None:
            _tried(before, "what is done before the kernels failed")
            with _Patience() as patience:
                for part in _USES:
                    good = _loaded(part)
                    patience.done(part)
                    if part == "orbits":
                        gc.freeze()  # all that was loaded stays: a look for cycles in it holds up an answer for 0.1 s
                    settle(part, good)

        # a daemon: the end of the server does not wait for a compiler
        threading.Thread(target=work, name="percuss-kernels", daemon=True).start()

    def settled(self, part: Part) -> bool:
        """Whether these are loaded, or cannot be: nobody need wait any more."""
        return part not in self._settled or self._settled[part].is_set()

    def preparing(self) -> list[Part]:
        """Those that are not settled, in the order in which they will be: the first is under way."""
        return [part for part in _USES if not self.settled(part)]

    def work(self, part: Part) -> bool:
        """Whether these can be used at once."""
        return self.settled(part) and part not in self._failed

    def failed(self, part: Part) -> bool:
        """Whether these cannot be had; the log says why."""
        return part in self._failed

    async def wait(self, part: Part, seconds: float) -> bool:
        """Wait so long for them to be settled; whether they are."""
        event = self._settled.get(part)  # of this loop: another one may begin meanwhile
        if event is None:
            return True
        if not event.is_set():
            with suppress(TimeoutError):
                await asyncio.wait_for(event.wait(), seconds)
        return event.is_set()


def load() -> bool:
    """Load all kernels from numba's cache, or compile them into it; whether that went well, else the log says why."""
    return all([_loaded(part) for part in _USES])


# -- each kernel is used once, so that no question waits for the compiler ---------------------------------------------


def _use_multipliers() -> None:
    from percuss.case import load_case
    from percuss.case.answers.quick_answer import curves_dict

    curves_dict(load_case("mini-breaker"), points=3, branches=3)


def _use_motions() -> None:
    from percuss.case import experiment_job_of, load_case, simulation_answer
    from percuss.explore.lyapunov import lyapunov_exponent

    case = load_case("mini-breaker").changed(simulation={"impacts": 2, "modes": 2})
    simulation_answer(case)
    experiment_job_of(case, 2, impacts=2).compute(0, 2, lambda *_: False)
    lyapunov_exponent(case.system(), modes=2, impacts=20, discard=2)


def _use_blows() -> None:
    from percuss.case import load_case, waves_answer
    from percuss.case.answers.blow_frames import blow_frames

    case = load_case("laboratory-striker")
    blow_frames(case, frames=2, cells=2)
    waves_answer(case.changed(simulation={"impacts": 2, "modes": 0, "time": 1.0}), cells=16)


def _use_machines() -> None:
    from percuss.case import load_case, machine_motion, sweep_job_of
    from percuss.explore.family import Axis

    case = load_case("valve-drifter")
    machine_motion(case.changed(simulation={"impacts": 2, "modes": 2}))
    sweep_job_of(case, [Axis.linear("load.scale", 0.9, 1.1, 2)], ["stall"], modes=0).compute(0, 2, lambda: False)


def _use_orbits() -> None:
    from percuss import Load, System
    from percuss.explore import follow
    from percuss.steady import orbit_near

    system = System(s=5.0, d=0.0, restitution=0.5, load=Load.harmonic(0.62, 1.0))
    orbit = orbit_near(system, [0.39, 2.32], modes=1)
    if orbit is not None:
        follow(orbit, "mean", (0.61, 0.63), most=2)


_USES: dict[Part, Callable[[], None]] = {
    "multipliers": _use_multipliers,
    "motions": _use_motions,
    "blows": _use_blows,
    "machines": _use_machines,
    "orbits": _use_orbits,
}


@cache
def _loaded(part: Part) -> bool:
    return _tried(_USES[part], f"the kernels of the {part} could not be loaded")


def _tried(work: Callable[[], object], else_: str) -> bool:
    """Do something; whether it went well."""
    try:
        work()
    except Exception:
        _log.exception(else_)
        return False
    return True


class _Patience:
    """Says that something takes long when it does, and how far it is."""

    def __enter__(self) -> Self:
        self._begun = time.monotonic()
        self._told = False
        self._timer = threading.Timer(_PATIENCE, self._tell)
        self._timer.daemon = True
        self._timer.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._timer.cancel()

    def _tell(self) -> None:
        self._told = True
        text = (
            "percuss: compiling the kernels, once on this computer, for a minute or for several where it is busy; "
            "steady motions are answered already, simulations wait for it, and later runs take the kernels from a cache"
        )
        print(text, file=sys.stderr, flush=True)

    def done(self, part: Part) -> None:
        """A part has been loaded, or cannot be."""
        if self._told:
            place, seconds = list(_USES).index(part) + 1, time.monotonic() - self._begun
            text = f"percuss: kernels of {part}: done, {place} of {len(_USES)} parts in {seconds:.0f} s"
            print(text, file=sys.stderr, flush=True)
