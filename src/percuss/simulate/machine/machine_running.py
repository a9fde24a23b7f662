"""`run_machine`: the only public door to the kernels for a single motion of a machine."""

from __future__ import annotations

from collections.abc import Callable

from percuss.errors import ParameterError
from percuss.model import Machine
from percuss.model.checks import callback, count, instance
from percuss.notebook import watched
from percuss.simulate.engine import Progress
from percuss.simulate.machine.machine_engine import ending, followed, room_for
from percuss.simulate.machine.machine_start import MachineStart
from percuss.simulate.machine.machine_trajectory import MachineTrajectory
from percuss.simulate.machine.mechanism import mechanism
from percuss.simulate.machine.plant import begun, plant_of, row_of
from percuss.simulate.start import Start
from percuss.simulate.stop import MAX_MODES, Stop

__all__ = ["run_machine", "start_of"]


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
    ringing included. A machine to which nothing can happen any more stalls, which is proved too.

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
