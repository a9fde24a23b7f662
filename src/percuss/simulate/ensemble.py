"""Many motions on all cores, each by itself; the results, one row each, with their labels and shares."""

from __future__ import annotations

import threading
from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Callable, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from dataclasses import dataclass, field, fields
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
import numpy.typing as npt

from percuss.errors import ParameterError
from percuss.model import HeldBody, Machine, System
from percuss.model.checks import DEFAULT_MODES, Array, at_once, callback, count, instance, several
from percuss.model.system import rests
from percuss.short_repr import ShortRepr, watched
from percuss.simulate.engine import (
    ENDS,
    NO_LOG,
    Clocked,
    Snapshot,
    begins,
    begun,
    clocks,
    desk_for,
    table_of,
    to_change,
)
from percuss.simulate.events import STALLS, MotionCycle, label_of, machine_label
from percuss.simulate.kernels.motion import follow
from percuss.simulate.kernels.motion_records import (
    AT_REST,
    BY_WORK,
    MEMBER,
    PAST,
    TURN,
    WINDOW,
    KernelState,
    MotionTable,
    Rules,
    Workspace,
)
from percuss.simulate.kernels.statistics import conclude
from percuss.simulate.spectrum import state_of
from percuss.simulate.start import Start, Starts
from percuss.simulate.stop import MAX_MODES, MOST_IMPACTS, OUTCOMES, Stop
from percuss.simulate.trajectory import Trajectory, run

if TYPE_CHECKING:
    import xarray

_MOST_TOLD = 5


@dataclass(frozen=True)
class EnsembleProgress:
    """How far an ensemble has come: members done, of how many."""

    done: int
    members: int

    @property
    def fraction(self) -> float:
        """0 to 1."""
        return self.done / self.members


@dataclass(frozen=True)
class Ensemble(ShortRepr):
    """The results of many motions; one row each, in the order in which they were given. All dimensionless.

    Of machines p is the number of blows in a period and n that of valve cycles, and `energy_lost_per_period` is that of
    the periodic motion; means that a clock's period is in are NaN.

    Attributes
    ----------
    code
        How each ended: its number in `OUTCOMES`; see `outcome`.
    impacts
        From the start.
    end_time
        Load time (rad) of the last event.
    first, cycle_impacts, cycle_periods, cycle_kind
        The periodic motion of each: the impact (from 0) it begins at, p impacts, n load periods, and without rest (0),
        with rest (1) or with chatter (2); −1, 0, 0, 0 when none was found, and −1, 0, 0 and its kind when the number of
        its load periods hangs on rounding.
    wanders
        Whether the last impacts come near none of the ones before; see `Trajectory.label`.
    blow_rate, main_blow_rate, interval_mean, interval_std, main_interval_mean, main_interval_std
        As in `Summary`; over one cycle when a periodic motion was found, else after `discarded` impacts; NaN with
        fewer than two.
    impact_velocity, blow_energy
        Means over the main blows among the same impacts.
    energy_lost_per_period
        Taken by impacts, chatter and rest in the same time, per load period.
    last_time, last_phase, last_velocity
        Load time, phase and striking speed of the last impacts, shape (members, asked for), ascending, with NaN in
        front where there were fewer; None unless asked for.
    stall
        Of machines: where each stalls, by its number in `percuss.simulate.STALLS`; −1 for those that do not.
    period, blow_speed
        Of machines: of the periodic motion of each, as of `MotionCycle`; NaN when none was found.
    trajectories
        The whole motions; empty unless asked for.
    """

    modes: int
    code: npt.NDArray[np.int8]
    impacts: npt.NDArray[np.int64]
    end_time: Array
    first: npt.NDArray[np.int64]
    cycle_impacts: npt.NDArray[np.int64]
    cycle_periods: npt.NDArray[np.int64]
    cycle_kind: npt.NDArray[np.int8]
    wanders: npt.NDArray[np.bool_]
    blow_rate: Array
    main_blow_rate: Array
    interval_mean: Array
    interval_std: Array
    main_interval_mean: Array
    main_interval_std: Array
    impact_velocity: Array
    blow_energy: Array
    energy_lost_per_period: Array
    last_time: Array | None = None
    last_phase: Array | None = None
    last_velocity: Array | None = None
    stall: npt.NDArray[np.int64] | None = None
    period: Array | None = None
    blow_speed: Array | None = None
    trajectories: tuple[Trajectory, ...] = field(default=(), repr=False)

    def __str__(self) -> str:
        shares = list(self.shares.items())
        told = ", ".join(f"{name} {share:.3g}" for name, share in shares[:_MOST_TOLD])
        more = f", and {len(shares) - _MOST_TOLD} more labels" if len(shares) > _MOST_TOLD else ""
        return f"Ensemble: {len(self)} motions with {self.modes} modes; shares {told}{more}"

    def __len__(self) -> int:
        return int(self.code.size)

    @property
    def outcome(self) -> npt.NDArray[np.str_]:
        """How each ended, in words; shape (members,)."""
        return np.array(OUTCOMES)[self.code]

    @cached_property
    def label(self) -> npt.NDArray[np.str_]:
        """What motion each is at its end, as `Trajectory.label`; shape (members,)."""
        columns = self.code, self.cycle_impacts, self.cycle_periods, self.cycle_kind, self.wanders
        return labels_of(*columns) if self.stall is None else labels_of(*columns, self.stall)

    @property
    def runs(self) -> npt.NDArray[np.bool_]:
        """Which members strike again and again in a periodic motion; shape (members,)."""
        return np.asarray(self.cycle_impacts > 0)

    @property
    def shares(self) -> dict[str, float]:
        """The share of the members that ends in each motion, the most frequent first."""
        found = Counter(self.label.tolist())
        return {name: number / len(self) for name, number in found.most_common()}

    def to_xarray(self) -> xarray.Dataset:
        """All columns, over the dimensions ``member`` and ``last``."""
        from percuss.simulate.motion_files import ensemble_dataset

        columns = {field.name: getattr(self, field.name) for field in fields(self)}
        arrays = {name: values for name, values in columns.items() if isinstance(values, np.ndarray)}
        return ensemble_dataset(self.modes, {"label": self.label, "outcome": self.outcome, **arrays})


def labels_of(*columns: npt.NDArray[Any]) -> npt.NDArray[np.str_]:
    """The labels that code, p, n, kind and wandering give to motions, and of machines the number of their stall."""
    kinds, which = np.unique(np.stack([c.astype(np.int64) for c in columns], axis=1), axis=0, return_inverse=True)
    return np.array([_label(*kind) for kind in kinds.tolist()], dtype=str)[which.reshape(-1)]


def _label(code: int, p: int, n: int, kind: int, wanders: int, stall: int | None = None) -> str:
    cycle = MotionCycle(0, p, n, kind) if n else None
    if stall is None:
        return label_of(OUTCOMES[code], cycle, bool(wanders), kind)
    return machine_label(STALLS[stall] if stall >= 0 else "", cycle, bool(wanders))


# ---- Many motions on all cores: each member by itself, regardless of the number of threads and their order

Keep = int | Literal["statistics", "everything"]

_BUDGET = 1 << 30  # modes times evaluations of one member, besides those for its impacts
_SYSTEMS = "a System or a Machine, or a list of one of them"
_INTERRUPTED = OUTCOMES.index("interrupted")


def simulate_many(
    systems: System | Machine | Sequence[System] | Sequence[Machine],
    starts: Start | Starts | Sequence[Start],
    *,
    modes: int = DEFAULT_MODES,
    stop: Stop | None = None,
    keep: Keep = "statistics",
    discard: int | None = None,
    workers: int | None = None,
    work: int | None = None,
    progress: Callable[[EnsembleProgress], object] | None = None,
) -> Ensemble:
    """Follow many motions, on all cores.

    Every member is computed by itself: the results are the same, bit for bit, for any number of threads and in any
    order. What goes wrong in a member is its outcome, never an exception; Ctrl-C ends all within a moment.

    Parameters
    ----------
    systems, starts
        One of them for all members, or as many as members; systems, or machines.
    modes
        N, the elastic modes kept; 0 is the rigid bar.
    keep
        What is kept of each member: ``"statistics"``; a number n, the last n impacts besides; or ``"everything"``. Of
        machines statistics, and nothing of which the next two are said.
    discard
        Impacts that the statistics leave out when no periodic motion is found: half of the stop rule's by default.
    work
        Evaluations of its motion after which a member ends as ``work``, whatever the computer; by default more than any
        motion needs but that of a bar that hovers before the wall. Does not go with ``keep="everything"``.
    progress
        Called now and then with an `EnsembleProgress`; when it returns something true the members not yet done end as
        ``interrupted``.

    Raises
    ------
    ParameterError
        For numbers of systems and starts that do not go together.
    ResonanceError
        When a harmonic of a load meets an undamped elastic mode.

    Examples
    --------
    >>> from percuss import Load, Start, Starts, Stop, System, simulate_many
    >>> system = System(s=20.0, d=0.0048, restitution=0.6, load=Load.harmonic(0.9, 1.0))
    >>> many = simulate_many(system, Starts.random(system, 100, seed=1), modes=4, stop=Stop(impacts=500))
    >>> max(many.shares, key=many.shares.get)
    'chatter/1'
    >>> from percuss.model import Kept, Machine, Port, UniformBar, Valve
    >>> ports = [Port("power", behind=1.0, side="back"), Port("return", on="impact")]
    >>> machine = Machine(UniformBar(20.0), Valve({"return": -0.4, "power": 1.8}, ports), Kept(0.2))
    >>> simulate_many(machine, [Start.rigid(-0.2), Start.rigid(-0.9)], modes=0).shares
    {'runs 1/1': 1.0}
    """
    callback("progress", progress)
    stop = Stop() if stop is None else instance("stop", stop, Stop)
    hammers = (systems,) if isinstance(systems, System | Machine) else several("systems", systems, _SYSTEMS)
    job: _Job
    if hammers and isinstance(hammers[0], Machine):
        if (keep, discard, work) != ("statistics", None, None):
            raise ParameterError("keep", keep, 'for machines "statistics", without discard and work')
        job = _Machines(hammers, starts, modes, stop, Machine)
    else:
        job = _Systems(hammers, starts, modes, stop, keep, discard, work)
    with watched(progress) as watch:
        job.work_off(at_once(workers), watch)
    return job.result()


class _Job(ABC):
    """The members of one call, and the work that is left."""

    def __init__(
        self, hammers: Sequence[Any], starts: Any, modes: int, stop: Stop, kind: type[System] | type[Machine]
    ) -> None:
        for hammer in hammers:
            instance("systems", hammer, kind)
        self.hammers, self.stop, modes = hammers, stop, count("modes", modes, least=0, most=MAX_MODES)
        self.modes = min((h.body.chosen(modes) for h in hammers), default=modes)
        self.starts = self._given(starts)
        self.members = max(len(hammers), len(self.starts))
        if {len(hammers), len(self.starts)} - {1, self.members} or not hammers or not len(self.starts):
            given = f"{len(hammers)} systems and {len(self.starts)} starts"
            raise ParameterError("starts", given, "as many starts as systems, or one of either")
        self.stopped, self.local = np.zeros(1, dtype=np.int64), threading.local()
        self.found = np.zeros(self.members, MEMBER)
        for name in MEMBER.names or ():
            self.found[name] = np.nan if MEMBER[name].kind == "f" else 0
        self.found["ended"], self.found["first"] = -1, -1

    def _given(self, starts: Any) -> Starts | list[Start]:
        single = [starts] if isinstance(starts, Start) else starts
        if isinstance(single, Starts):
            return single
        if not isinstance(single, Sequence) or not all(isinstance(start, Start) for start in single):
            raise ParameterError("starts", starts, "a Start, Starts, or a list of Start")
        return list(single)

    def chunks(self, workers: int) -> list[tuple[int, int]]:
        """First and last member of every portion of work."""
        most = 64 if len(self.hammers) > 1 else 4096
        size = int(np.clip(self.members // (16 * workers), 1, most))
        return [(i, min(i + size, self.members)) for i in range(0, self.members, size)]

    def portion(self, first: int, last: int) -> None:
        """Members of one hammer together, of several one by one."""
        single = len(self.hammers) == 1
        for i in (first,) if single else range(first, last):
            if self.stopped[0]:
                return
            self.follow(self.hammers[0 if single else i], i, last if single else i + 1)

    @abstractmethod
    def follow(self, hammer: Any, first: int, last: int) -> None:
        """Some members of a hammer."""

    @abstractmethod
    def columns_besides(self) -> dict[str, Any]:
        """The columns that systems and machines have otherwise."""

    def result(self) -> Ensemble:
        """The columns."""
        found, told = self.found, {field.name for field in fields(Ensemble)}
        columns: dict[str, Any] = {name: found[name].copy() for name in told.intersection(MEMBER.names or ())}
        columns |= {"impacts": found["strikes"].copy(), "cycle_kind": found["cycle_kind"].astype(np.int8)}
        return Ensemble(modes=self.modes, **(columns | self.columns_besides()))

    def work_off(self, workers: int, progress: Callable[[EnsembleProgress], object] | None) -> None:
        """All portions on the threads; results go into the arrays, so that no order can show."""
        chunks = self.chunks(workers)
        done, following = 0, iter(chunks)
        with ThreadPoolExecutor(max_workers=min(workers, len(chunks)), thread_name_prefix="percuss") as pool:
            running: dict[Future[None], int] = {}
            try:
                while True:
                    while len(running) < 4 * workers and (chunk := next(following, None)) is not None:
                        running[pool.submit(self.portion, *chunk)] = chunk[1] - chunk[0]
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


class _Systems(_Job):
    """Motions of systems under a clock."""

    def __init__(
        self, systems: Any, starts: Any, modes: int, stop: Stop, keep: Keep, discard: int | None, work: int | None
    ) -> None:
        super().__init__(systems, starts, modes, stop, System)
        self.whole = keep == "everything"
        self.last = 0 if isinstance(keep, str) else count("keep", keep, least=0, most=10**7)
        if isinstance(keep, str) and keep not in ("statistics", "everything"):
            raise ParameterError("keep", keep, 'a number of impacts, "statistics" or "everything"')
        self.skip = stop.most_impacts // 2 if discard is None else count("discard", discard, least=0, most=MOST_IMPACTS)
        if work is not None and self.whole:
            raise ParameterError("work", work, "None: whole motions end by their stop rule")
        ample = _BUDGET // (self.modes + 30) + 1000 * min(stop.most_impacts, 10**7)
        self.budget = ample if work is None else count("work", work, least=1, most=10**12)
        given = self.starts
        self.columns = given if isinstance(given, Starts) else Starts.of(given, self.modes, self.hammers)
        self._rows()
        self.tail = np.full((self.members, self.last), np.nan, PAST)
        self.motions: list[Trajectory | None] = [None] * (self.members if self.whole else 0)
        self.shared = table_of(self.hammers[0], self.modes) if len(self.hammers) == 1 else None

    def _rows(self) -> None:
        s, n = self.columns, self.members
        rows = np.arange(n) if len(s) == n else np.zeros(n, dtype=np.int64)
        self.displacement, self.velocity = (
            np.ascontiguousarray(a if len(a) == n else a[rows]) for a in (s.displacement, s.velocity)
        )
        self.gaps, self.times = np.ascontiguousarray(s.gap[rows]), s.time[rows]
        self.periods, self.phases = clocks(self.times)
        if self.stop.time is None:
            self.ends = np.column_stack([np.full(n, np.inf), np.zeros(n)])
        else:
            self.ends = np.column_stack([*clocks(self.times + self.stop.time)])

    def chunks(self, workers: int) -> list[tuple[int, int]]:
        return [(i, i + 1) for i in range(self.members)] if self.whole else super().chunks(workers)

    def follow(self, system: System, first: int, last: int) -> None:
        if self.whole:
            self._one(system, first)
            return
        table = self.shared if self.shared is not None else table_of(system, self.modes)
        window = slice(first, last)
        periods, phases, pieces = self.periods[window], self.phases[window], np.zeros(last - first, dtype=np.int64)
        if system.load.is_piecewise:
            periods, phases, pieces = begun(system.load, self.times[window])
        u, v = self.displacement[window], self.velocity[window]
        if isinstance(system.body, HeldBody):
            u, v = state_of(system.body, system.load.at, self.modes, u, v, self.gaps[window])
        starts = begins(u, v, self.gaps[window], phases, periods, pieces)
        rules = Rules(
            np.inf, 0.0, self.stop.most_impacts, self.stop.periodic, self.stop.tolerance, self.skip, self.budget
        )
        motion, twin, desk = self._desk(table)
        follow(
            to_change(table), starts, self.ends[window], rules, motion, twin, desk, NO_LOG, NO_LOG,
            self.stopped, self.found[window], self.tail[window],
        )  # fmt: skip
        if not rests(system, self.modes):
            for i in first + np.flatnonzero(self.found["ended"][window] == AT_REST):
                self._over_rests(system, int(i))

    def _over_rests(self, system: System, i: int) -> None:
        """A structure of several modes that came to rest, from its start on: when it leaves is not for the kernels."""
        start = self.columns[i if len(self.columns) > 1 else 0]
        moved, *_ = Clocked.begun(system, self.modes, start)
        made = moved.followed(self.stop, start.time, lambda _: bool(self.stopped[0]), self.skip)
        state, struck = Snapshot(**made["snapshot"]), made["events"].of("impact")
        conclude(state.motion, _code(made["outcome"]), self.found[i])
        kept = min(self.last, len(struck))
        if kept:
            row = self.tail[i, self.last - kept :]
            row["phase"], row["speed"], row["period"] = (
                values[-kept:] for values in (struck.phase, struck.impact_velocity, struck.period)
            )

    def _desk(self, table: MotionTable) -> tuple[KernelState, KernelState, Workspace]:
        """What a thread works in: made once for each."""
        k = table.harmonics.gap_re.size
        if getattr(self.local, "harmonics", None) != k:
            self.local.harmonics = k
            self.local.states = [Snapshot.empty(self.modes, self._window()) for _ in range(2)]
            motion, twin = (state.motion for state in self.local.states)
            self.local.desk = (motion, twin, desk_for(table))
        desk: tuple[KernelState, KernelState, Workspace] = self.local.desk
        return desk

    def _window(self) -> int:
        return max(WINDOW, 1 << max(self.last - 1, 0).bit_length())

    def _one(self, system: System, i: int) -> None:
        start = self.columns[i if len(self.columns) > 1 else 0]
        motion = run(system, start, modes=self.modes, stop=self.stop, progress=lambda _: bool(self.stopped[0]))
        self.motions[i] = motion
        state = Snapshot(**{name: np.array(values) for name, values in motion.snapshot.items()})
        conclude(state.motion, _code(motion.outcome), self.found[i])

    # -- the result --

    def columns_besides(self) -> dict[str, Any]:
        codes = np.array([OUTCOMES.index(ENDS.get(code, "work")) for code in range(9)] + [_INTERRUPTED], dtype=np.int8)
        kept = self.last > 0
        return {
            "code": codes[self.found["ended"]],  # −1, not begun, is the last one
            "wanders": self.found["wanders"].astype(bool) & self._has_period(),
            "last_time": self.tail["period"] * TURN + self.tail["phase"] if kept else None,
            "last_phase": self.tail["phase"].copy() if kept else None,
            "last_velocity": self.tail["speed"].copy() if kept else None,
            "trajectories": tuple(motion for motion in self.motions if motion is not None),
            "period": None,
            "blow_speed": None,
        }

    def _has_period(self) -> npt.NDArray[np.bool_]:
        periodic = np.array([not system.load.is_constant for system in self.hammers])
        return np.broadcast_to(periodic, (self.members,))


class _Machines(_Job):
    """Motions of machines that switch their own valves."""

    def follow(self, machine: Machine, first: int, last: int) -> None:
        from percuss.simulate.valve import SelfSwitching, machine_starts, mechanism, most_work  # more kernels

        starts, found = self.starts[first:last] if len(self.starts) > 1 else self.starts, self.found[first:last]
        if machine.valve.flows:
            for start, row in zip(starts, found, strict=True):
                self._flowing(machine, start, row)
            return
        numbers = mechanism(machine, self.modes)
        begun, unit = machine_starts(numbers, starts), numbers.unit
        moved = SelfSwitching.ready(numbers, begun, getattr(self.local, "plant", None))
        moved.follow(begun, self.stop, found, most_work(self.modes), self.stopped)
        self.local.plant = moved.plant
        for name, of in (("end_time", unit), ("period", unit), ("blow_speed", 1.0 / unit)):
            found[name] *= of
        found["energy_lost_per_period"] /= unit**2

    def _flowing(self, machine: Machine, start: Start, row: np.void) -> None:
        from percuss.simulate.oil import FlowingOil

        if self.stopped[0]:
            return
        moved = FlowingOil.begun(machine, self.modes, start)[0]
        ended, row["wanders"] = moved.carried_on(self.stop, lambda: bool(self.stopped[0]))
        if ended != "interrupted":
            row["ended"] = {name: code for code, name in self._ends.items()}[ended]
        row["strikes"], row["end_time"], cycle = moved.motion.blows, moved.motion.time, moved.cycle
        if cycle is not None:
            row["first"], row["cycle_impacts"], row["cycle_periods"] = cycle.first, cycle.impacts, cycle.periods
            row["cycle_kind"], row["period"], row["blow_speed"] = cycle.kind, cycle.period, cycle.blow_speed
            row["energy_lost_per_period"] = cycle.energy_lost

    @cached_property
    def _ends(self) -> dict[int, str]:
        from percuss.simulate.valve import ENDS

        return ENDS | {BY_WORK: "work", -1: "interrupted"}

    def columns_besides(self) -> dict[str, Any]:
        from percuss.simulate.valve import outcome_of

        ended = [self._ends[code] for code in self.found["ended"].tolist()]
        places = ["in the chamber" if s else e for s, e in zip(self.found["stalled"].tolist(), ended, strict=True)]
        stall = np.array([STALLS.index(place) if place in STALLS else -1 for place in places])
        outcomes = [outcome_of(end, at >= 0) for end, at in zip(ended, stall.tolist(), strict=True)]
        code = np.array([OUTCOMES.index(outcome) for outcome in outcomes], dtype=np.int8)
        return {"code": code, "stall": stall, "wanders": self.found["wanders"].astype(bool)}


def _code(outcome: str) -> int:
    """The kernels' number of an outcome; −1 for what they do not know."""
    known = {name: code for code, name in ENDS.items()} | {"work": BY_WORK, "memory": BY_WORK}
    return known.get(outcome, -1)
