"""Computations off the event loop, so many at once, each with a way to be stopped; and the kernels they wait for."""

from __future__ import annotations

import asyncio
import gc
import logging
import sys
import threading
import time
from collections.abc import AsyncIterator, Callable
from concurrent.futures import CancelledError, Future, ThreadPoolExecutor
from contextlib import asynccontextmanager, suppress
from functools import cache
from typing import TYPE_CHECKING, Literal, Self, TypeVar

from percuss.errors import Interrupted
from percuss.web.requests import refused

if TYPE_CHECKING:
    from starlette.requests import Request

    from percuss.web.settings import Limits


T = TypeVar("T")

_LOOK = 0.1  # seconds between two looks at whether the client is still there
_GIVEN = 0.05  # seconds for which a long computation lets quick answers go first, before it goes on for as long


class Halt:
    """Tells a computation that nobody waits for it any more; call it as its progress callback.

    While `first` is not set, which is while quick answers are under way, the call waits: they need Python's lock, and
    a computation that held it for its share would double their time.
    """

    def __init__(self, seconds: float, first: threading.Event | None = None) -> None:
        self._event = threading.Event()
        self._until = time.monotonic() + seconds
        self._first, self._works_until = first, 0.0

    def stop(self) -> None:
        """From now on the answer is yes."""
        self._event.set()

    @property
    def late(self) -> bool:
        """Whether the time is up."""
        return time.monotonic() > self._until

    @property
    def over(self) -> bool:
        """Whether it was told to stop, or the time is up."""
        return self._event.is_set() or self.late

    def __call__(self, *_: object) -> bool:
        if self._first is not None and not self._first.is_set() and (begun := time.monotonic()) > self._works_until:
            self._first.wait(_GIVEN)
            self._works_until = 2.0 * time.monotonic() - begun
        return self.over


class Lane:
    """Computations of one kind: so many at once, a few more in line, and the rest is told to come again.

    Those of a lane with another one `before` it wait, though not for long, while anything is under way there.
    """

    def __init__(self, name: str, at_once: int, waiting: int, before: Lane | None = None) -> None:
        self._pool = ThreadPoolExecutor(max_workers=at_once, thread_name_prefix=f"percuss-{name}")
        self._most = at_once + waiting
        self._taken, self._counting = 0, threading.Lock()
        self._halts: set[Halt] = set()
        self._before, self.idle = before, threading.Event()
        self.idle.set()
        self.closed = False

    @asynccontextmanager
    async def place(self, seconds: float) -> AsyncIterator[Halt]:
        """A place in the lane for the length of the block."""
        if self.closed:
            raise refused(503, "the server is stopping")
        if self._taken >= self._most:
            raise refused(429, "too many computations at once", "try again in a second")
        halt = Halt(seconds, None if self._before is None else self._before.idle)
        self._take(1)
        self._halts.add(halt)
        try:
            yield halt
        finally:
            halt.stop()
            self._take(-1)
            self._halts.discard(halt)

    def submit(self, work: Callable[[], T]) -> Future[T]:
        """Begin the work when a thread is free."""
        return self._pool.submit(work)

    async def run(self, request: Request, seconds: float, work: Callable[[Halt], T]) -> T:
        """The result of a piece of work, stopped when the client leaves or the time is up."""
        async with self.place(seconds) as halt:
            running = self.submit(lambda: work(halt))
            ended = told_when_done(running)
            try:
                while not await _within(ended, _LOOK):
                    if self.closed:
                        raise refused(503, "the server is stopping")
                    if halt.late:
                        raise refused(503, "it took too long", "ask for less")
                    if await request.is_disconnected():
                        raise refused(503, "the client no longer waits for the answer")
            finally:
                self.hold(running)
            try:
                return running.result()
            except CancelledError:  # it was in line when the lane was closed
                raise refused(503, "the server is stopping") from None
            except Interrupted:  # it looked at the clock before we did
                raise refused(503, "it took too long", "ask for less") from None

    def hold(self, running: Future[T]) -> None:
        """Keep a place taken while work that was given up goes on, so that no more than is allowed ever runs."""
        if running.done() or running.cancel():
            return
        self._take(1)
        running.add_done_callback(lambda _: self._take(-1))  # in its thread: the loop may be gone by then

    def _take(self, places: int) -> None:
        with self._counting:
            self._taken += places
            (self.idle.clear if self._taken else self.idle.set)()

    def close(self) -> None:
        """Stop everything; nothing new begins."""
        self.closed = True
        for halt in list(self._halts):
            halt.stop()
        self._pool.shutdown(wait=False, cancel_futures=True)


def told_when_done(running: Future[T]) -> asyncio.Event:
    """An event of the running loop that is set when the work has ended, well or badly."""
    # `asyncio.wrap_future` would complain of what the work raised when nobody waits any more.
    loop, ended = asyncio.get_running_loop(), asyncio.Event()

    def tell(_: Future[T]) -> None:
        with suppress(RuntimeError):  # the loop may be gone
            loop.call_soon_threadsafe(ended.set)

    running.add_done_callback(tell)
    return ended


async def _within(event: asyncio.Event, seconds: float) -> bool:
    """Whether an event is set within some time."""
    try:
        async with asyncio.timeout(seconds):
            await event.wait()
    except TimeoutError:
        return False
    return True


class Admission:
    """The lanes of one worker: quick answers never wait for long computations."""

    def __init__(self, limits: Limits) -> None:
        self.quick = Lane("quick", limits.quick, limits.quick_waiting)
        self.heavy = Lane("heavy", limits.heavy, limits.heavy_waiting, self.quick)
        self.experiments = Lane("experiment", limits.experiments, 0, self.quick)
        self.closed = False
        self.intake = Intake(limits.held_bytes)
        self._waits: set[asyncio.Timeout] = set()

    @asynccontextmanager
    async def waiting(self, seconds: float | None = None) -> AsyncIterator[asyncio.Timeout]:
        """A block that waits for others: for some seconds, and not beyond the end of the server."""
        if self.closed:
            raise refused(503, "the server is stopping")
        try:
            async with asyncio.timeout(seconds) as limit:
                self._waits.add(limit)
                try:
                    yield limit
                finally:
                    self._waits.discard(limit)
                    self.intake.drop(limit)
        except TimeoutError:
            if self.closed:
                raise refused(503, "the server is stopping") from None
            raise refused(408, "the request did not come in time", close=True) from None

    def close(self) -> None:
        """Stop everything; once is enough."""
        if self.closed:
            return
        self.closed = True
        for lane in (self.quick, self.heavy, self.experiments):
            lane.close()
        for limit in list(self._waits):
            _expire(limit)


class Intake:
    """Bodies that come in, bounded together; when they are too much, the one that began first is given up."""

    def __init__(self, most: int) -> None:
        self._most = most
        self._held: dict[asyncio.Timeout, int] = {}

    def add(self, limit: asyncio.Timeout, size: int) -> None:
        """So many more bytes have come within this wait."""
        self._held[limit] = self._held.get(limit, 0) + size
        while sum(self._held.values()) > self._most:
            first = next(iter(self._held))
            self.drop(first)
            _expire(first)

    def drop(self, limit: asyncio.Timeout) -> None:
        """This wait has ended."""
        self._held.pop(limit, None)


def _expire(limit: asyncio.Timeout) -> None:
    if not limit.expired():  # else it ends by itself, and could not be told again
        limit.reschedule(0.0)


# ---- The compiled kernels, loaded beside the first requests: what the closed form answers does not wait for them

Part = Literal["multipliers", "motions", "blows", "machines", "orbits"]
"""Those of the planes of exact multipliers, those of the simulator and what is made with it, those of blows, those of
machines that switch themselves: their maps and their motions, and those of orbits and their branches."""

_PATIENCE = 5.0  # seconds that loading the kernels from numba's cache does not take

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
    from percuss.case.answers.exploring.quick_answer import curves_dict

    curves_dict(load_case("mini-breaker"), points=3, branches=3)


def _use_motions() -> None:
    from percuss.case import experiment_job_of, load_case, simulation_answer
    from percuss.explore.lyapunov import lyapunov_exponent

    case = load_case("mini-breaker").changed(simulation={"impacts": 2, "modes": 2})
    simulation_answer(case)
    experiment_job_of(case, 2, impacts=2).compute(0, 2, lambda *_: False)
    lyapunov_exponent(case.system(), modes=2, impacts=200, discard=20)


def _use_blows() -> None:
    from percuss.case import load_case, waves_answer
    from percuss.case.answers.exploring.playback import blow_playback

    case = load_case("laboratory-striker")
    blow_playback(case, frames=2, cells=2)
    waves_answer(case.changed(simulation={"impacts": 2, "modes": 0, "time": 1.0}), cells=16)


def _use_machines() -> None:
    from percuss.case import load_case, simulation_answer, sweep_job_of
    from percuss.case.answers.exploring.playback import machine_playback
    from percuss.explore import follow
    from percuss.explore.family import Axis
    from percuss.steady import self_excited_motion

    case = load_case("valve-drifter")
    cycle = self_excited_motion(case.machine(), modes=1).cycle
    if cycle is not None:
        follow(cycle, "restitution", (0.0, 0.6), most=2)
    few = {"impacts": 2, "modes": 2}
    simulation_answer(case.changed(simulation=few))
    sweep_job_of(case, [Axis.linear("load.scale", 0.9, 1.1, 2)], ["stall"], modes=0).compute(0, 2, lambda: False)
    oil = load_case("oil-drifter")
    simulation_answer(oil.changed(simulation=few))
    machine_playback(oil, modes=1, points=2, whole=False)


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
        self._say(text)

    def _say(self, text: str) -> None:
        print(f"{text}\n", end="", file=sys.stderr, flush=True)  # in one piece: other workers say the same

    def done(self, part: Part) -> None:
        """A part has been loaded, or cannot be."""
        if self._told:
            place, seconds = list(_USES).index(part) + 1, time.monotonic() - self._begun
            self._say(f"percuss: kernels of {part}: done, {place} of {len(_USES)} parts in {seconds:.0f} s")
