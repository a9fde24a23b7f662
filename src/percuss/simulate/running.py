"""`run`: the only public door to the kernels for a single motion."""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from typing import Literal

import numpy as np
import numpy.typing as npt

from percuss.errors import ParameterError
from percuss.model import HeldBody, System
from percuss.model.checks import callback, count, instance, several
from percuss.model.system import rests
from percuss.shown import watched
from percuss.simulate.engine import ENDS, Progress, ending, followed
from percuss.simulate.events import IMPACT
from percuss.simulate.kernels.motion import follow
from percuss.simulate.kernels.motion_records import (
    AT_REST,
    BY_WORK,
    MEMBER,
    PAST,
    RESTING,
    TURN,
    WINDOW,
    Desk,
    Motion,
    Rules,
    Table,
)
from percuss.simulate.kernels.statistics import conclude
from percuss.simulate.simulated_motion import Anchor
from percuss.simulate.spectrum import shifted, state_of
from percuss.simulate.start import Start, Starts
from percuss.simulate.stop import MAX_MODES, MOST_IMPACTS, OUTCOMES, Stop
from percuss.simulate.tables import (
    NO_LOG,
    Snapshot,
    begin,
    begins,
    begun,
    clocks,
    desk_for,
    prepared,
    table_of,
    to_change,
)
from percuss.simulate.trajectory import Ensemble, EnsembleProgress, Trajectory


def run(
    system: System,
    start: Start | None = None,
    *,
    modes: int = 32,
    stop: Stop | None = None,
    progress: Callable[[Progress], object] | None = None,
) -> Trajectory:
    """Follow the bar from a start: every impact, chatter, rest and release (B77 section 5, theory §§3, 8).

    Parameters
    ----------
    system
        What moves; all of it dimensionless.
    start
        The state and the load phase at the beginning; `Start.rigid()` by default, at rest one bar length off the wall.
    modes
        N, the elastic modes kept; 0 is the rigid bar.
    stop
        When to end; see `Stop`. By default after 2000 impacts, or when a periodic motion or rest for good is found.
    progress
        Called now and then with a `Progress`; the motion ends as ``cancelled`` when it returns something true.

    Raises
    ------
    ParameterError
        For a start beyond the wall or with more modes than `modes`.
    ResonanceError
        When a harmonic of the load meets an undamped elastic mode (B77 16).

    Examples
    --------
    >>> from percuss import Load, Start, Stop, System, run
    >>> system = System(s=20.0, d=0.0048, restitution=0.6, load=Load.harmonic(0.9, 1.0))
    >>> motion = run(system, Start.rigid(position=-1.0, time=0.3), modes=8)
    >>> print(motion.label, motion.outcome)
    chatter/1 periodic
    """
    instance("system", system, System)
    start = Start.rigid() if start is None else instance("start", start, Start)
    stop = Stop() if stop is None else instance("stop", stop, Stop)
    callback("progress", progress)
    wanted, body = count("modes", modes, least=0, most=MAX_MODES), system.body
    spectrum, table = prepared(system, body.chosen(wanted) if isinstance(body, HeldBody) else wanted)
    snapshot = begin(spectrum, table, start)
    now, count_ = snapshot.now[0], snapshot.count[0]
    anchor = Anchor(
        float(now["phase"]),
        int(count_["piece"]),
        float(now["gap"]),
        float(now["rigid_rate"]),
        snapshot.z.copy(),
    )
    with watched(progress) as watch:
        stretch = followed(spectrum, table, snapshot, stop, start.time, watch)
    return Trajectory(
        system=system,
        modes=spectrum.modes,
        start=anchor,
        resting=int(count_["mode"]) == RESTING,
        begin_time=start.time,
        **ending(system, stretch, stop, start.time),
    )


# ---- Many motions on all cores: each member by itself, regardless of the number of threads and their order

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


def _kept(systems: System | Sequence[System], modes: int) -> int:
    """How many of so many modes all of the systems have."""
    listed: Sequence[object] = systems if isinstance(systems, list | tuple) else [systems]
    bodies = [system.body for system in listed if isinstance(system, System)]
    return min((body.chosen(modes) for body in bodies if isinstance(body, HeldBody)), default=modes)


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
        self.modes = _kept(systems, count("modes", modes, least=0, most=MAX_MODES))
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
        self.starts = single if isinstance(single, Starts) else Starts.of(list(single), self.modes, self.systems)
        self.members = max(len(self.systems), len(self.starts))
        if {len(self.systems), len(self.starts)} - {1, self.members} or not self.systems:
            given = f"{len(self.systems)} systems and {len(self.starts)} starts"
            raise ParameterError("starts", given, "as many starts as systems, or one of either")
        self._rows()
        self.found = np.zeros(self.members, MEMBER)
        for name in MEMBER.names or ():
            self.found[name] = np.nan if MEMBER[name].kind == "f" else 0
        self.found["ended"], self.found["first"] = -1, -1
        self.tail = np.full((self.members, self.last), np.nan, PAST)
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
        self.gaps, self.times = np.ascontiguousarray(s.gap[rows]), s.time[rows]
        if self.stop.time is None:
            self.ends = np.column_stack([np.full(n, np.inf), np.zeros(n)])
        else:
            self.ends = np.column_stack([*clocks(self.times + self.stop.time)])

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
        self.shared = table_of(self.systems[0], self.modes) if len(self.systems) == 1 else None
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
        table = self.shared if self.shared is not None else table_of(system, self.modes)
        window = slice(first, last)
        periods, phases, pieces = begun(system.load, self.times[window])
        u, v = self.displacement[window], self.velocity[window]
        if isinstance(system.body, HeldBody):
            u, v = state_of(system.body, system.load.at, self.modes, u, v, self.gaps[window])
            u = shifted(system, self.modes, u)
        starts = begins(u, v, self.gaps[window], phases, periods, pieces)
        rules = Rules(
            np.inf, 0.0, self.stop.most_impacts, self.stop.periodic, self.stop.tolerance, self.skip, self.budget
        )
        motion, twin, desk = self._desk(table)
        follow(
            to_change(table), starts, self.ends[window], rules, motion, twin, desk, NO_LOG, NO_LOG,
            self.stopped, self.found[window], self.tail[window],
        )  # fmt: skip
        if isinstance(system.body, HeldBody) and rests(system, self.modes):
            for i in np.flatnonzero(self.found["ended"][window] == AT_REST):
                self._over_rests(system, first + int(i))

    def _over_rests(self, system: System, i: int) -> None:
        """A structure that came to rest, from its start on: whether it leaves the wall again is not for the kernels."""
        if self.stopped[0]:
            return
        start, (spectrum, table) = self.starts[i if len(self.starts) > 1 else 0], prepared(system, self.modes)
        made = followed(
            spectrum, table, begin(spectrum, table, start), self.stop, start.time,
            lambda _: bool(self.stopped[0]), self.skip,
        )  # fmt: skip
        conclude(made.snapshot.motion, _code(made.outcome), self.found[i])
        struck = made.events[made.events.code == IMPACT]
        kept = min(self.last, len(struck))
        if kept:
            row = self.tail[i, self.last - kept :]
            row["phase"], row["speed"], row["period"] = (
                values[-kept:] for values in (struck.phase, struck.impact_velocity, struck.period)
            )

    def _desk(self, table: Table) -> tuple[Motion, Motion, Desk]:
        """What a thread works in: made once for each."""
        k = table.harmonics.gap_re.size
        if getattr(self.local, "harmonics", None) != k:
            self.local.harmonics = k
            self.local.states = [Snapshot.empty(self.modes, self._window()) for _ in range(2)]
            motion, twin = (state.motion for state in self.local.states)
            self.local.desk = (motion, twin, desk_for(table))
        desk: tuple[Motion, Motion, Desk] = self.local.desk
        return desk

    def _window(self) -> int:
        """Last impacts that are kept."""
        return max(WINDOW, 1 << max(self.last - 1, 0).bit_length())

    def _one(self, system: System, i: int) -> None:
        """A whole motion."""
        start = self.starts[i if len(self.starts) > 1 else 0]
        motion = run(system, start, modes=self.modes, stop=self.stop, progress=lambda _: bool(self.stopped[0]))
        self.motions[i] = motion
        state = Snapshot(**{name: np.array(values) for name, values in motion.snapshot.items()})
        conclude(state.motion, _code(motion.outcome), self.found[i])

    # -- the result --

    def result(self) -> Ensemble:
        """The columns."""
        found = self.found
        codes = np.array([OUTCOMES.index(ENDS.get(code, "work")) for code in range(9)] + [_CANCELLED], dtype=np.int8)
        kept = self.last > 0
        return Ensemble(
            modes=self.modes,
            code=codes[found["ended"]],  # −1, not begun, is the last one
            impacts=found["strikes"].copy(),
            end_time=found["end_time"].copy(),
            first=found["first"].copy(),
            cycle_impacts=found["cycle_impacts"].copy(),
            cycle_periods=found["cycle_periods"].copy(),
            cycle_kind=found["cycle_kind"].astype(np.int8),
            wanders=found["wanders"].astype(bool) & self._has_period(),
            blow_rate=found["blow_rate"].copy(),
            main_blow_rate=found["main_blow_rate"].copy(),
            interval_mean=found["interval_mean"].copy(),
            interval_std=found["interval_std"].copy(),
            main_interval_mean=found["main_interval_mean"].copy(),
            main_interval_std=found["main_interval_std"].copy(),
            impact_velocity=found["impact_velocity"].copy(),
            blow_energy=found["blow_energy"].copy(),
            energy_lost_per_period=found["energy_lost_per_period"].copy(),
            last_time=self.tail["period"] * TURN + self.tail["phase"] if kept else None,
            last_phase=self.tail["phase"].copy() if kept else None,
            last_velocity=self.tail["speed"].copy() if kept else None,
            trajectories=tuple(motion for motion in self.motions if motion is not None),
        )

    def _has_period(self) -> npt.NDArray[np.bool_]:
        periodic = np.array([not system.load.is_constant for system in self.systems])
        return np.broadcast_to(periodic, (self.members,))


def _code(outcome: str) -> int:
    """The kernels' number of an outcome; −1 for what they do not know."""
    known = {name: code for code, name in ENDS.items()} | {"work": BY_WORK, "memory": BY_WORK}
    return known.get(outcome, -1)
