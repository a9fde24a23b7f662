"""`run_machine`: the only public door to the kernels for a single motion of a machine."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from percuss.errors import ParameterError
from percuss.model import Machine
from percuss.model.checks import Array, callback, count, instance, several
from percuss.shown import Shown, watched
from percuss.simulate.engine import Progress
from percuss.simulate.machine.machine_engine import (
    NO_VALVE_LOG,
    begun,
    carried_on,
    cycle_of,
    ending,
    followed,
    outcome_of,
    plant_of,
    room_for,
    row_of,
)
from percuss.simulate.machine.machine_events import STALLS, machine_label
from percuss.simulate.machine.machine_start import MachineStart, MachineStarts
from percuss.simulate.machine.machine_trajectory import MachineTrajectory
from percuss.simulate.machine.mechanism import Mechanism, mechanism
from percuss.simulate.running import cores
from percuss.simulate.start import Start
from percuss.simulate.stop import MAX_MODES, Stop
from percuss.simulate.trajectory import EnsembleProgress


def run_machine(
    machine: Machine,
    start: MachineStart | Start | None = None,
    *,
    modes: int = 32,
    stop: Stop | None = None,
    progress: Callable[[Progress], object] | None = None,
) -> MachineTrajectory:
    """Follow a machine from a start: every blow, port and change of the valve, chatter, rest and release.

    The blow, the crossings of ports and the orders that are due compete, and the first one is proved to be the first,
    ringing included. A machine whose valve can never switch again stalls, which is proved too; the blows
    that are left are followed.

    Parameters
    ----------
    machine
        What moves; times in its unit.
    start
        The bar and the valve at the beginning; by default at rest on the wall, with the valve's own starting state. The
        time of a `Start` is that at which the motion begins.
    modes
        N, the elastic modes kept; 0 is the rigid piston, which a machine with a supply needs: its motion is then a
        `FedTrajectory`, which tells the pressure.
    stop
        When to end; see `Stop`, its time in the machine's unit. By default after 2000 impacts, or when a periodic
        motion is found.
    progress
        Called now and then with a `Progress`; the motion ends as ``cancelled`` when it returns something true.

    Raises
    ------
    ParameterError
        For a start beyond the wall, with more modes than `modes`, or with a state that the valve does not have.

    Examples
    --------
    >>> from percuss.model import Kept, Machine, Port, UniformBar, Valve
    >>> from percuss.simulate import run_machine
    >>> ports = [Port("power", behind=1.0, side="back"), Port("return", on="impact")]
    >>> machine = Machine(UniformBar(20.0), Valve({"return": -0.4, "power": 1.8}, ports), Kept(0.2))
    >>> motion = run_machine(machine, modes=0)
    >>> print(motion.label, round(motion.cycle.period, 6))
    runs 1/1 3.148923
    """
    instance("machine", machine, Machine)
    given = start_of(start)
    stop = Stop() if stop is None else instance("stop", stop, Stop)
    callback("progress", progress)
    if machine.valve.supply is not None:
        return _fed(machine, given, modes, stop, progress)
    numbers = mechanism(machine, count("modes", modes, least=0, most=MAX_MODES))
    plant, room = plant_of(numbers, given), room_for(numbers, stop)
    resting = begun(plant, numbers, given, room.log)
    room.states[0], state = row_of(plant), int(plant.controls.now["state"])
    begin = given.bar.time
    with watched(progress) as watch:
        stretch = followed(plant, numbers, stop, room, begin, watch)
    return MachineTrajectory(
        machine=machine,
        modes=numbers.modes,
        events=stretch.events,
        states=stretch.states,
        first_state=state,
        resting=resting,
        stop=stop,
        begin_time=begin,
        **ending(stretch, numbers, stop, begin),
    )


def _fed(
    machine: Machine,
    start: MachineStart,
    modes: int,
    stop: Stop,
    progress: Callable[[Progress], object] | None,
) -> MachineTrajectory:
    """The motion of a machine with a supply."""
    from percuss.simulate.machine.fed_running import run_fed

    if count("modes", modes, least=0, most=MAX_MODES):
        remedy = "the elastic modes of a bar are not followed under a pressure that changes; leave out the supply"
        raise ParameterError("modes", modes, "0, a rigid piston, for a machine whose pressure follows it", remedy)
    with watched(progress) as watch:
        return run_fed(machine, start, stop, watch)


def start_of(start: MachineStart | Start | None) -> MachineStart:
    """A start of a machine, from what may be given for one."""
    if start is None:
        return MachineStart()
    return MachineStart(start) if isinstance(start, Start) else instance("start", start, MachineStart)


# ---- Many motions of machines on all cores: which starts run, and which stall

_CHUNK = 64
_OF_CYCLE = ("period", "blows", "valve_cycles", "kind", "blow_speed", "energy_lost")
_COLUMNS = ("impacts", "end_time", "stall", "wanders", *_OF_CYCLE)
_TYPES = dict.fromkeys(("impacts", "stall", "blows", "valve_cycles", "kind"), np.int64) | {"wanders": np.bool_}


@dataclass(frozen=True)
class MachineEnsemble(Shown):
    """The results of many motions of machines; one row each, in the order in which they were given.

    Attributes
    ----------
    modes
        N, the elastic modes of all.
    label
        What motion each is at its end, as `MachineTrajectory.label`.
    outcome
        How each ended: one of `percuss.simulate.MACHINE_OUTCOMES`.
    impacts
        From the start.
    end_time
        Time from the start to the last event.
    stall
        Where each stalls, by its number in `percuss.simulate.STALLS`; −1 for those that do not.
    wanders
        Whether the last changes of the valve do not come near any of the ones before.
    period, blows, valve_cycles, kind, blow_speed, energy_lost
        Of the periodic motion of each, as of `MachineCycle`; NaN, 0, 0, 0, NaN, NaN when none was found.
    """

    modes: int
    label: npt.NDArray[Any]
    outcome: npt.NDArray[Any]
    impacts: npt.NDArray[np.int64]
    end_time: Array
    stall: npt.NDArray[np.int64]
    wanders: npt.NDArray[np.bool_]
    period: Array
    blows: npt.NDArray[np.int64]
    valve_cycles: npt.NDArray[np.int64]
    kind: npt.NDArray[np.int64]
    blow_speed: Array
    energy_lost: Array

    def __len__(self) -> int:
        return int(self.label.size)

    @property
    def runs(self) -> npt.NDArray[np.bool_]:
        """Which members strike again and again; shape (members,)."""
        return np.asarray(self.blows > 0)

    @property
    def shares(self) -> dict[str, float]:
        """The share of the members that ends in each motion, the most frequent first."""
        found = Counter(self.label.tolist())
        return {name: number / len(self) for name, number in found.most_common()}

    def __str__(self) -> str:
        told = ", ".join(f"{name} {share:.3g}" for name, share in list(self.shares.items())[:5])
        return f"MachineEnsemble: {len(self)} motions with {self.modes} modes; shares {told}"


def simulate_machines(
    machines: Machine | Sequence[Machine],
    starts: MachineStart | Start | Sequence[MachineStart | Start] | MachineStarts,
    *,
    modes: int = 32,
    stop: Stop | None = None,
    threads: int | None = None,
    progress: Callable[[EnsembleProgress], object] | None = None,
) -> MachineEnsemble:
    """Follow many motions of machines, on all cores.

    Every member is computed by itself: the results are the same, bit for bit, for any number of threads.

    Parameters
    ----------
    machines, starts
        One of them for all members, or as many as members.
    modes
        N, the elastic modes kept; 0 is the rigid piston.
    stop
        When a member ends; see `run_machine`.
    threads
        How many; by default as many as cores.
    progress
        Called now and then with an `EnsembleProgress`; when it returns something true, the members not yet done end as
        ``cancelled``.

    Raises
    ------
    ParameterError
        For numbers of machines and starts that do not go together, or a start that does not fit.

    Examples
    --------
    >>> from percuss.model import Kept, Machine, Port, UniformBar, Valve
    >>> from percuss.simulate import Start, simulate_machines
    >>> ports = [Port("power", behind=1.0, side="back"), Port("return", on="impact")]
    >>> machine = Machine(UniformBar(20.0), Valve({"return": -0.4, "power": 1.8}, ports), Kept(0.2))
    >>> many = simulate_machines(machine, [Start.rigid(-0.2), Start.rigid(-0.9)], modes=0)
    >>> many.shares
    {'runs 1/1': 1.0}
    """
    listed = [machines] if isinstance(machines, Machine) else list(several("machines", machines, "a list of Machine"))
    several_starts = [starts] if isinstance(starts, MachineStart | Start) else several("starts", starts, "starts")
    if any(start is None for start in several_starts):
        raise ParameterError("starts", None, "starts", "Start.rigid(0.0) is rest on the wall")
    given = [start_of(start) for start in several_starts]
    for machine in listed:
        if instance("machines", machine, Machine).valve.supply is not None:
            raise ParameterError("machines", str(machine), "machines without a supply", "follow one with run_machine")
    members = max(len(listed), len(given))
    if {len(listed), len(given)} - {1, members} or not listed or not given:
        text = f"{len(listed)} machines and {len(given)} starts"
        raise ParameterError("starts", text, "as many starts as machines, or one of either")
    stop = Stop() if stop is None else instance("stop", stop, Stop)
    callback("progress", progress)
    workers = cores() if threads is None else count("threads", threads, least=1, most=1024)
    job = _Job(listed, given, members, count("modes", modes, least=0, most=MAX_MODES), stop)
    with watched(progress) as watch:
        job.work_off(workers, watch)
    return job.result()


class _Job:
    """The members of one call, and their results."""

    def __init__(
        self, machines: list[Machine], starts: list[MachineStart], members: int, modes: int, stop: Stop
    ) -> None:
        self.machines, self.starts, self.members, self.modes, self.stop = machines, starts, members, modes, stop
        self.shared = mechanism(machines[0], modes) if len(machines) == 1 else None
        self.labels, self.outcomes = ["undecided"] * members, ["cancelled"] * members
        self.columns = {name: np.zeros(members) for name in _COLUMNS}
        for name in ("period", "blow_speed", "energy_lost"):
            self.columns[name][:] = np.nan
        self.columns["stall"][:] = -1
        self.stopped = False

    def work_off(self, workers: int, progress: Callable[[EnsembleProgress], object] | None) -> None:
        """All members on the threads; results go into columns, so that no order can show."""
        chunks = [(i, min(i + _CHUNK, self.members)) for i in range(0, self.members, _CHUNK)]
        done = 0
        with ThreadPoolExecutor(max_workers=min(workers, len(chunks)), thread_name_prefix="percuss") as pool:
            running: dict[Future[None], int] = {pool.submit(self._portion, *c): c[1] - c[0] for c in chunks}
            try:
                while running:
                    finished, _ = wait(running, return_when=FIRST_COMPLETED)
                    for future in finished:
                        done += running.pop(future)
                        future.result()
                    if progress is not None and progress(EnsembleProgress(done, self.members)):
                        self.stopped = True
            except BaseException:
                self.stopped = True
                for future in running:
                    future.cancel()
                raise

    def _portion(self, first: int, last: int) -> None:
        for i in range(first, last):
            if self.stopped:
                return
            shared = self.shared
            numbers = mechanism(self.machines[i], self.modes) if shared is None else shared
            self._member(numbers, self.starts[i if len(self.starts) > 1 else 0], i)

    def _member(self, numbers: Mechanism, start: MachineStart, i: int) -> None:
        plant = plant_of(numbers, start)
        begun(plant, numbers, start, NO_VALVE_LOG)
        ended, wandering = carried_on(plant, numbers, self.stop, lambda: self.stopped)
        cycle, columns = cycle_of(plant, numbers), self.columns
        place = "in the chamber" if plant.controls.now["stalled"] else ended
        self.labels[i] = machine_label(place, cycle, wandering)
        self.outcomes[i] = outcome_of(ended, place in STALLS)
        columns["impacts"][i] = plant.motion.count["impacts"]
        columns["end_time"][i] = plant.controls.now["time"] * numbers.unit
        columns["stall"][i] = STALLS.index(place) if place in STALLS else -1
        columns["wanders"][i] = wandering
        if cycle is not None:
            for name in _OF_CYCLE:
                columns[name][i] = getattr(cycle, name)

    def result(self) -> MachineEnsemble:
        """The columns."""
        columns: dict[str, Any] = {
            name: values.astype(_TYPES.get(name, np.float64)) for name, values in self.columns.items()
        }
        return MachineEnsemble(
            modes=self.modes, label=np.array(self.labels), outcome=np.array(self.outcomes), **columns
        )
