"""While a person waits for a simulation: a progress bar, and a Ctrl-C that keeps what is done."""

from __future__ import annotations

import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from percuss.cli.waiting import sign

if TYPE_CHECKING:
    from percuss.simulate import Progress

PATIENCE = 0.5
"""Seconds before a progress bar is shown."""


class Watch:
    """The progress callback of a simulation: draws the bar, and asks for the end after an interruption."""

    def __init__(self, seen: bool) -> None:
        self.interrupted = False
        self._seen, self._begun = seen, False
        self._since = time.monotonic()
        self._bar: Any = None
        self._task: Any = None

    def __call__(self, progress: Progress) -> bool:
        self._begun = True
        if self._bar is None and self._seen and time.monotonic() - self._since > PATIENCE:
            self._bar, self._task = _new_bar()
        if self._bar is not None:
            sign()
            self._bar.update(self._task, completed=progress.fraction, impacts=f"{progress.impacts} impacts")
        return self.interrupted

    def interrupt(self, *_: object) -> None:
        """The handler of Ctrl-C: the first ends a simulation that has begun in order, the second at once."""
        if self.interrupted or not self._begun:
            raise KeyboardInterrupt
        self.interrupted = True

    def close(self) -> None:
        """Take the bar away."""
        if self._bar is not None:
            self._bar.stop()
            self._bar = None


def law_ready() -> None:
    """Load the kernels of simulations by a contact law."""
    from percuss.model import Load, System
    from percuss.simulate import Stop, run

    run(System(s=1.0, d=0.0, restitution=0.0, load=Load.harmonic(1.0, 0.0)), modes=0, stop=Stop(impacts=0))


@contextmanager
def watched(ready: Callable[[], object] = law_ready) -> Iterator[Watch]:
    """A `Watch` with the kernels made `ready`, in charge of Ctrl-C until the end of the block."""
    seen = sys.stderr is not None and sys.stderr.isatty()
    ready()  # Ctrl-C ends this at once
    watch = Watch(seen)
    # only the main thread may handle signals
    mine = threading.current_thread() is threading.main_thread()
    before = signal.signal(signal.SIGINT, watch.interrupt) if mine else None
    try:
        yield watch
    finally:
        if mine:
            signal.signal(signal.SIGINT, before or signal.SIG_DFL)
        watch.close()


def machine_ready() -> None:
    """Load the kernels of simulations of machines that switch their own valves."""
    from percuss.model import Kept, Machine, Port, UniformBar, Valve
    from percuss.simulate import Stop, run_machine

    valve = Valve({"return": -1.0, "power": 1.0}, (Port("return", on="impact"),))
    run_machine(Machine(UniformBar(1.0), valve, Kept(0.0)), modes=0, stop=Stop(impacts=0))


def orbits_ready() -> None:
    """Load the kernels of orbits with several impacts."""
    from percuss.model import Load, System
    from percuss.steady import orbit_near

    system = System(s=5.0, d=0.0, restitution=0.5, load=Load.harmonic(0.62, 1.0))
    orbit = orbit_near(system, [0.39, 2.32], modes=0)
    assert orbit is not None and orbit.admissible


def waves_ready() -> None:
    """Load the kernels of simulations by waves, and those of the law beside them."""
    from percuss.blow import Wall
    from percuss.blow.periods import run_by_waves
    from percuss.model import Load, System
    from percuss.simulate import Stop

    law_ready()
    system = System(s=1.0, d=0.0, restitution=0.0, load=Load.harmonic(1.0, 0.0))
    run_by_waves(system, Wall(), stop=Stop(time=1.0), cells=16)


def _new_bar() -> tuple[Any, Any]:
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

    columns = (TextColumn("simulating"), BarColumn(), TextColumn("{task.fields[impacts]}"), TimeRemainingColumn())
    bar = Progress(*columns, console=Console(stderr=True), transient=True)
    bar.start()
    return bar, bar.add_task("", total=1.0, impacts="")
