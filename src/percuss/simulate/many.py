"""Many motions on all cores: each member by itself, regardless of the number of threads and their order."""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from typing import Literal

import numpy as np
import numpy.typing as npt

from percuss.errors import ParameterError
from percuss.model import System
from percuss.model.checks import callback, count, instance, several
from percuss.notebook import watched
from percuss.simulate import kernels as kn
from percuss.simulate.engine import ENDS
from percuss.simulate.ensemble import Ensemble, EnsembleProgress
from percuss.simulate.running import run
from percuss.simulate.snapshot import clocks
from percuss.simulate.start import Start
from percuss.simulate.starts import Starts
from percuss.simulate.stop import MAX_MODES, MOST_IMPACTS, OUTCOMES, Stop
from percuss.simulate.tables import Tables, tables_of
from percuss.simulate.trajectory import Trajectory

__all__ = ["cores", "simulate_many"]

Keep = int | Literal["statistics", "everything"]

_BUDGET = 1 << 30  # modes times evaluations of one member, besides those for its impacts
_SYSTEMS = "a System, or a list of them"
_CANCELLED = OUTCOMES.index("cancelled")


def simulate_many(
    systems: System | Sequence[System],
    starts: Start | Starts | Sequence[Start],
    *,
    modes: int = 32,
    stop: Stop | None = None,
    keep: Keep = "statistics",
    discard: int | None = None,
    threads: int | None = None,
    work: int | None = None,
    progress: Callable[[EnsembleProgress], object] | None = None,
) -> Ensemble:
    """Follow many motions, on all cores.

    Every member is computed by itself: the results are the same, bit for bit, for any number of threads and in any
    order. What goes wrong in a member is its outcome, never an exception; Ctrl-C ends all within a moment.

    Parameters
    ----------
    systems, starts
        One of them for all members, or as many as members.
    modes
        N, the elastic modes kept; 0 is the rigid bar.
    stop
        When a member ends; see `Stop`.
    keep
        What is kept of each member: ``"statistics"``; a number n, the last n impacts besides; or ``"everything"``.
    discard
        Impacts that the statistics leave out when no periodic motion is found: half of the stop rule's by default.
    threads
        How many; by default as many as cores.
    work
        Evaluations of its motion after which a member ends as ``work``, whatever the computer; by default more than any
        motion needs but that of a bar that hovers before the wall. Does not go with ``keep="everything"``.
    progress
        Called now and then with an `EnsembleProgress`; when it returns something true the members not yet done end as
        ``cancelled``.

    Raises
    ------
    ParameterError
        For numbers of systems and starts that do not go together.
    ResonanceError
        When a harmonic of a load meets an undamped elastic mode.

    Examples
    --------
    >>> from percuss import Load, Starts, Stop, System, simulate_many
    >>> system = System(s=20.0, d=0.0048, restitution=0.6, load=Load.harmonic(0.9, 1.0))
    >>> many = simulate_many(system, Starts.random(system, 100, seed=1), modes=4, stop=Stop(impacts=500))
    >>> max(many.shares, key=many.shares.get)
    'chatter/1'
    """
    callback("progress", progress)
    job = _Job(systems, starts, modes, Stop() if stop is None else instance("stop", stop, Stop), keep, discard, work)
    workers = cores() if threads is None else count("threads", threads, least=1, most=1024)
    with watched(progress) as watch:
        job.work_off(workers, watch)
    return job.result()


def cores() -> int:
    """Cores that this process may use."""
    try:
        return len(os.sched_getaffinity(0))
    except AttributeError:  # not on every system
        return os.cpu_count() or 1


class _Job:
    """The members of one call, their results, and the work that is left."""

    def __init__(
        self,
        systems: System | Sequence[System],
        starts: Start | Starts | Sequence[Start],
        modes: int,
        stop: Stop,
        keep: Keep,
        discard: int | None,
        work: int | None,
    ) -> None:
        self.modes = count("modes", modes, least=0, most=MAX_MODES)
        self.stop, self.whole = stop, keep == "everything"
        self.last = 0 if isinstance(keep, str) else count("keep", keep, least=0, most=10**7)
        if isinstance(keep, str) and keep not in ("statistics", "everything"):
            raise ParameterError("keep", keep, 'a number of impacts, "statistics" or "everything"')
        self.skip = stop.most_impacts // 2 if discard is None else count("discard", discard, least=0, most=MOST_IMPACTS)
        if work is not None and self.whole:
            raise ParameterError("work", work, "None: whole motions end by their stop rule")
        ample = _BUDGET // (self.modes + 30) + 1000 * min(stop.most_impacts, 10**7)
        self.budget = ample if work is None else count("work", work, least=1, most=10**12)
        listed_systems = (systems,) if isinstance(systems, System) else several("systems", systems, _SYSTEMS)
        self.systems = list(listed_systems)
        for system in self.systems:
            instance("systems", system, System)
        single = [starts] if isinstance(starts, Start) else starts
        listed = isinstance(single, Sequence) and all(isinstance(start, Start) for start in single)
        if not isinstance(single, Starts) and not listed:
            raise ParameterError("starts", starts, "a Start, Starts, or a list of Start")
        self.starts = single if isinstance(single, Starts) else Starts.of(list(single), self.modes)
        self.members = max(len(self.systems), len(self.starts))
        if {len(self.systems), len(self.starts)} - {1, self.members} or not self.systems:
            given = f"{len(self.systems)} systems and {len(self.starts)} starts"
            raise ParameterError("starts", given, "as many starts as systems, or one of either")
        self._rows()
        self.wholes = np.zeros((self.members, kn.MEMBER_COUNTS), dtype=np.int64)
        self.wholes[:, kn.ENDED], self.wholes[:, kn.FIRST] = -1, -1
        self.numbers = np.full((self.members, kn.MEMBER_NUMBERS), np.nan)
        self.tail = np.full((self.members, 3, self.last), np.nan)
        self.motions: list[Trajectory | None] = [None] * (self.members if self.whole else 0)
        self.stopped = np.zeros(1, dtype=np.int64)
        self.local = threading.local()

    def _rows(self) -> None:
        """The starts as the kernels take them, one row for each member."""
        s, n = self.starts, self.members
        rows = np.arange(n) if len(s) == n else np.zeros(n, dtype=np.int64)
        self.displacement, self.velocity = (
            np.ascontiguousarray(a if len(a) == n else a[rows]) for a in (s.displacement, s.velocity)
        )
        self.gaps, time = np.ascontiguousarray(s.gap[rows]), s.time[rows]
        self.periods, self.phases = clocks(time)
        if self.stop.time is None:
            self.ends, self.end_phases = np.full(n, np.inf), np.zeros(n)
        else:
            turns, self.end_phases = clocks(time + self.stop.time)
            self.ends = turns.astype(float)

    # -- the work --

    def chunks(self, workers: int) -> list[tuple[int, int]]:
        """First and last member of every portion of work."""
        if self.whole:
            return [(i, i + 1) for i in range(self.members)]
        most = 64 if len(self.systems) > 1 else 4096
        size = int(np.clip(self.members // (16 * workers), 1, most))
        return [(i, min(i + size, self.members)) for i in range(0, self.members, size)]

    def work_off(self, workers: int, progress: Callable[[EnsembleProgress], object] | None) -> None:
        """All portions on the threads; results go into the arrays, so that no order can show."""
        chunks = self.chunks(workers)
        self.shared = tables_of(self.systems[0], self.modes) if len(self.systems) == 1 else None
        done, following = 0, iter(chunks)
        with ThreadPoolExecutor(max_workers=min(workers, len(chunks)), thread_name_prefix="percuss") as pool:
            running: dict[Future[None], int] = {}
            try:
                while True:
                    while len(running) < 4 * workers and (chunk := next(following, None)) is not None:
                        running[pool.submit(self._portion, *chunk)] = chunk[1] - chunk[0]
                    if not running:
                        break
                    finished, _ = wait(running, return_when=FIRST_COMPLETED)
                    for future in finished:
                        done += running.pop(future)
                        future.result()
                    if progress is not None and progress(EnsembleProgress(done, self.members)):
                        self.stopped[0] = 1
                        following = iter(())
            except BaseException:
                self.stopped[0] = 1
                for future in running:
                    future.cancel()
                raise

    def _portion(self, first: int, last: int) -> None:
        """Members of one system together, of several one by one."""
        single = len(self.systems) == 1
        for i in (first,) if single and not self.whole else range(first, last):
            if self.stopped[0]:
                return
            system = self.systems[0 if single else i]
            if self.whole:
                self._one(system, i)
            else:
                self._members(system, i, last if single else i + 1)

    def _members(self, system: System, first: int, last: int) -> None:
        """Members of one system."""
        tables = self.shared if self.shared is not None else tables_of(system, self.modes)
        load = system.load
        pieces = load.piece(self.phases[first:last]) if load.is_piecewise else np.zeros(last - first)
        desk = self._desk(tables)
        window = slice(first, last)
        kn.fly_many(  # type: ignore[call-arg]  # numba's dispatchers take whatever the function takes
            tables.par.copy(), tables.mode, tables.har, tables.coupling, tables.breaks, tables.values, tables.releases,
            tables.over, self.displacement[window], self.velocity[window], self.gaps[window], self.periods[window],
            self.phases[window], pieces.astype(np.int64), self.ends[window], self.end_phases[window],
            self.stop.most_impacts, self.stop.periodic, self.stop.tolerance, self.skip, self.budget, 0, last - first,
            self.stopped, *desk, self.numbers[window], self.wholes[window], self.tail[window],
        )  # fmt: skip

    def _desk(self, tables: Tables) -> tuple[npt.NDArray[np.generic], ...]:
        """The arrays that a thread works in: made once for each."""
        n, k = self.modes, tables.har.shape[1]
        if getattr(self.local, "harmonics", None) != k:
            self.local.harmonics = k
            state: tuple[npt.NDArray[np.generic], ...] = (
                np.zeros((2, n)),
                np.zeros(kn.NUMBERS),
                np.zeros(kn.COUNTS, dtype=np.int64),
                np.zeros(3 + 2 * n),
                np.zeros((3, max(kn.WINDOW, 1 << max(self.last - 1, 0).bit_length()))),
                np.zeros(kn.SUMS_KEPT),
            )
            self.local.desk = (
                *state,
                np.zeros((2, k)),
                np.zeros((kn.WORK_ROWS, n)),
                np.zeros((0, kn.EVENT_NUMBERS)),
                np.zeros((0, kn.EVENT_COUNTS), dtype=np.int64),
                *(np.zeros_like(array) for array in state),
            )
        desk: tuple[npt.NDArray[np.generic], ...] = self.local.desk
        return desk

    def _one(self, system: System, i: int) -> None:
        """A whole motion."""
        start = self.starts[i if len(self.starts) > 1 else 0]
        motion = run(system, start, modes=self.modes, stop=self.stop, progress=lambda _: bool(self.stopped[0]))
        self.motions[i] = motion
        past, count_, sums = (np.array(motion.snapshot[name]) for name in ("past", "count", "sums"))
        kn.conclude(motion.snapshot["now"], count_, past, sums, 0, self.numbers[i], self.wholes[i])
        self.wholes[i, kn.ENDED] = _code(motion.outcome)

    # -- the result --

    def result(self) -> Ensemble:
        """The columns."""
        w, x = self.wholes, self.numbers
        codes = np.array([OUTCOMES.index(ENDS.get(code, "work")) for code in range(9)] + [_CANCELLED], dtype=np.int8)
        kept = self.last > 0
        return Ensemble(
            modes=self.modes,
            code=codes[w[:, kn.ENDED]],  # −1, not begun, is the last one
            impacts=w[:, kn.STRIKES].copy(),
            end_time=x[:, kn.ENDED_AT].copy(),
            first=w[:, kn.FIRST].copy(),
            cycle_impacts=w[:, kn.PER_CYCLE].copy(),
            cycle_periods=w[:, kn.PERIODS].copy(),
            cycle_kind=w[:, kn.SORT].astype(np.int8),
            wanders=w[:, kn.WANDERING].astype(bool) & self._has_period(),
            blow_rate=x[:, kn.RATE_OF].copy(),
            main_blow_rate=x[:, kn.MAIN_RATE].copy(),
            interval_mean=x[:, kn.MEAN_INTERVAL].copy(),
            interval_std=x[:, kn.STD_INTERVAL].copy(),
            main_interval_mean=x[:, kn.MEAN_MAIN].copy(),
            main_interval_std=x[:, kn.STD_MAIN].copy(),
            impact_velocity=x[:, kn.MEAN_SPEED].copy(),
            blow_energy=x[:, kn.MEAN_BLOW].copy(),
            energy_lost_per_period=x[:, kn.LOST_RATE].copy(),
            last_time=self.tail[:, 2] * kn.TURN + self.tail[:, 0] if kept else None,
            last_phase=self.tail[:, 0].copy() if kept else None,
            last_velocity=self.tail[:, 1].copy() if kept else None,
            trajectories=tuple(motion for motion in self.motions if motion is not None),
        )

    def _has_period(self) -> npt.NDArray[np.bool_]:
        periodic = np.array([not system.load.is_constant for system in self.systems])
        return np.broadcast_to(periodic, (self.members,))


def _code(outcome: str) -> int:
    """The kernels' number of an outcome; −1 for what they do not know."""
    known = {name: code for code, name in ENDS.items()} | {"work": kn.BY_WORK, "memory": kn.BY_WORK}
    return known.get(outcome, -1)
