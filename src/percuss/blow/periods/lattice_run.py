"""`run_by_waves`: a machine under its periodic load with every contact resolved by waves."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from percuss.blow.bodies import Rod, Target, Wall
from percuss.blow.kernels.lattice_motion import follow
from percuss.blow.kernels.lattice_records import CONTACT, COUNT, LOAD, NOW, OFF, LatticeMachine, LatticeRow
from percuss.blow.periods.lattice import machine_record
from percuss.blow.periods.wave_motion import (
    MOST_PERIODS,
    ROUND_TRIP,
    Impacts,
    Recurrence,
    Uncertainty,
    WaveEnergy,
    WaveMotion,
    impacts_of,
)
from percuss.halting import look
from percuss.model import System
from percuss.model.checks import Array, callback, count, flag, instance
from percuss.shown import watched
from percuss.simulate import MotionCycle, Progress, Start, Stop

# ---- A machine followed load period by load period: its clock, its contacts, its state at the end of each

_TURN = 2.0 * math.pi
_ROOM = 1024  # contacts in the log of a call
_AT_ONCE = 1 << 20  # steps between two looks at the outside
MOST, TOLERANCE = 400, 1e-6
"""Load periods after which a motion ends, and how near a state must come back, where nothing else is asked for."""


class LatticeRun:
    """A machine on its way, from a rigid motion of the striker at a distance from what it strikes."""

    def __init__(self, machine: LatticeMachine, gap: float, velocity: float = 0.0, time: float = 0.0) -> None:
        self.machine = machine
        self.now, self.count = np.zeros(1, NOW), np.zeros(1, COUNT)
        self._log, self._done = np.zeros(_ROOM, CONTACT), list[npt.NDArray[np.void]]()
        self._gone = 0
        wave = 0.5 * velocity
        machine.striker.right[:] = machine.striker.left[:] = wave
        steps, size = round(time / machine.step), machine.load.size
        self.periods = 0
        self.count["step"] = steps % size
        self.count["branch"] = OFF if machine.bit.gap > 0.0 else LOAD
        state = {
            "gap": gap,
            "momentum": velocity,
            "energy": 0.5 * velocity**2,
            "arrived": wave,
            "penetration": -machine.bit.gap,
            "time": (steps // size) * _TURN,
            "next_drag": steps % size + 0.5 * machine.drag.interval,
        }
        for name, value in state.items():
            self.now[name] = value

    def period(self) -> Iterator[None]:
        """To the end of the load's present period; stops now and then on the way."""
        while self.count["step"][0] < self.machine.load.size:
            follow(self.machine, self.now, self.count, self._log, _AT_ONCE)
            self._empty()
            yield
        self.count["step"] = 0
        self.now["time"] += _TURN
        self.now["next_drag"] = 0.5 * self.machine.drag.interval
        self.periods += 1

    def _empty(self) -> None:
        """Take all contacts but the last, which may go on, out of the log."""
        n = int(self.count["contacts"][0])
        if n > 1:
            self._done.append(self._log[: n - 1].copy())
            self._gone += n - 1
            self._log[0] = self._log[n - 1]
            self.count["contacts"] = 1

    @property
    def touching(self) -> bool:
        """Whether the faces are pressed together now."""
        return bool(self.count["touching"][0])

    @property
    def time(self) -> float:
        """In radians of the load."""
        return float(self.now["time"][0] + self.count["step"][0] * self.machine.step)

    @property
    def strikes(self) -> int:
        """Contacts from the start."""
        return self._gone + int(self.count["contacts"][0])

    @property
    def blow_over(self) -> bool:
        """Whether the tool has been fed since the last contact."""
        return not self.count["struck"][0]

    @property
    def rock_work(self) -> float:
        """That the rock keeps of all blows; of the one under way as far as it has come."""
        now, bit = self.now[0], self.machine.bit
        return float(now["rock_work"]) + 0.5 * bit.stiffness * (1.0 - bit.ratio) * float(now["greatest"]) ** 2

    @property
    def advanced(self) -> float:
        """By which the tool has been fed since the start."""
        return float(self.now["advanced"][0])

    @property
    def contacts(self) -> npt.NDArray[np.void]:
        """All contacts from the start, the one under way included."""
        return np.concatenate([*self._done, self._log[: int(self.count["contacts"][0])]])

    def contacts_since(self, time: float) -> npt.NDArray[np.void]:
        """The contacts that have ended after a time."""
        parts = [self._log[: int(self.count["contacts"][0])]]
        for part in reversed(self._done):
            if part["end"][-1] < time:
                break
            parts.append(part)
        found = np.concatenate(parts[::-1])
        return found[found["end"] >= time]

    @property
    def waves(self) -> Array:
        """f and g of all cells, in order of space, each times √(2 Z Δt), and the motion and the force of the bit.

        The sum of squares is twice the energy.
        """
        machine, now, bit = self.machine, self.now[0], self.machine.bit
        force = float(now["penetration"]) - (1.0 - bit.ratio) * float(now["greatest"])
        ends = [
            math.sqrt(bit.mass) * float(now["bit_velocity"]),
            math.sqrt(bit.stiffness / bit.ratio) * max(force, 0.0),
        ]
        return np.concatenate([*(_ordered(chain, machine.step) for chain in (machine.striker, machine.rod)), ends])

    @property
    def energy(self) -> float:
        """Of the striker, from its cells."""
        return 0.5 * float(np.sum(_ordered(self.machine.striker, self.machine.step) ** 2))

    @property
    def momentum(self) -> float:
        """Of the striker, from its cells."""
        chain = self.machine.striker
        mass = np.repeat(chain.impedance, chain.cells) * self.machine.step
        return float(np.sum(mass * (chain.right + chain.left)))


def _ordered(chain: LatticeRow, step: float) -> Array:
    parts = [np.zeros(0)]
    for z, first, cells, slot in zip(chain.impedance, chain.first, chain.cells, chain.slot, strict=True):
        scale = math.sqrt(2.0 * z * step)
        parts += [scale * np.roll(wave[first : first + cells], -slot) for wave in (chain.right, chain.left)]
    return np.concatenate(parts)


# ---- `run_by_waves`: a machine under its periodic load with every contact resolved by waves


def run_by_waves(
    system: System,
    target: Target,
    start: Start | None = None,
    stop: Stop | None = None,
    *,
    pushed_back: bool = False,
    quiet: bool = False,
    cells: int = 400,
    estimate: bool = True,
    progress: Callable[[Progress], object] | None = None,
) -> WaveMotion:
    """A machine from a start on: flights under the load and contacts, all of them by waves.

    Waves travel exactly on a lattice of equal cells (d'Alembert; Courant number 1), and a contact starts and ends
    within a cell, so that the error of an impulse falls as the square of the cells' size. What the contact law of the
    system says is not used: this is what judges it.

    Parameters
    ----------
    system
        Striker, load and damping. The damping acts on the striker alone, in contact too.
    target
        A rigid wall, or a rod with any end. Its own gap is not used: the start has one. A rod on rock or with a free
        end is fed between blows: when the striker that has gone back turns forward again, and the rod has been without
        contact for four ways of a wave through it and half a swing of its mass on the rock, it is laid at rest against
        fresh rock.
    start
        Of which the rigid motion is taken; one length of the striker off, at rest, by default.
    stop
        When to end, at the end of a load period: by default after 400 of them, 2000 impacts, or when a periodic motion
        is found. A state is the same when it comes back to within the tolerance, 1e-6 by default: the energy of the
        difference of two states, as a speed, and the difference of their gaps over a period, both over the greatest
        striking speed.
    pushed_back
        Whether the rod is pushed back to its place as soon as the striker has left it the room; else it stays where the
        blow put it, and the machine follows. A rod on rock is fed by what the bit has gone deeper, or pushed back to
        where it was, with the rock as it was; one with a free end can only be pushed back.
    quiet
        Whether all ringing of the striker is made to end between blows, as the laws b77 and b77-blow assume.
    cells
        Cells of the striker, at least; those of a coarser lattice are half as many.
    estimate
        Whether to tell, from a lattice with half the cells, how sure a settled motion is.
    progress
        Called now and then with a `percuss.simulate.Progress`; the motion ends when it returns something true.

    Raises
    ------
    ParameterError
        For a rod with a free end that is not pushed back, masses between sections, and numbers out of range.
    Interrupted
        When a block of `percuss.halting` was told to stop.

    Examples
    --------
    >>> from percuss import Load, System
    >>> from percuss.blow import Rod
    >>> from percuss.simulate import Start
    >>> system = System(s=20.0, d=0.0, restitution=0.6, load=Load.harmonic(0.9, 1.0))
    >>> rod = Rod.of_impedance(20.0 * (1.0 + 0.6) / (1.0 - 0.6))
    >>> motion = run_by_waves(system, rod, Start.rigid(-2.0, time=0.3), quiet=True, cells=100)
    >>> motion.label, motion.phases.round(3).tolist(), motion.settled.restitution.round(4).tolist()
    ('z=1/1', [2.372], [0.6])
    """
    instance("system", system, System)
    if not isinstance(target, Wall | Rod):
        instance("target", target, Rod)
    start = Start.rigid() if start is None else instance("start", start, Start)
    stop = Stop(2000, MOST * _TURN, tolerance=TOLERANCE) if stop is None else instance("stop", stop, Stop)
    flag("pushed_back", pushed_back), flag("quiet", quiet), flag("estimate", estimate)
    number = count("cells", cells, least=16, most=100_000)
    callback("progress", progress)

    def motion(cells: int) -> WaveMotion:
        with watched(progress) as watch:
            return _followed(system, target, start, stop, pushed_back, quiet, cells, watch)

    found = motion(number)
    if not estimate or found.cycle is None or not found.cycle.impacts:
        return found
    return replace(found, uncertainty=_apart(found, motion(max(8, number // 2))))


def _followed(
    system: System,
    target: Target,
    start: Start,
    stop: Stop,
    pushed_back: bool,
    quiet: bool,
    cells: int,
    progress: Callable[[Progress], object] | None,
) -> WaveMotion:
    lattice, machine = machine_record(system, target, cells, pushed_back=pushed_back, quiet=quiet)
    lattice_run, recurrence = LatticeRun(machine, *rigid_state(start, system)), Recurrence(stop.tolerance)
    begun, energy = lattice_run.time, lattice_run.energy
    most = MOST if stop.time is None else max(1, math.ceil(stop.time / _TURN - 1e-9))
    outcome, periods = "", 0
    while not outcome:
        for _ in lattice_run.period():
            look()
            share = max(lattice_run.periods / most, lattice_run.strikes / max(stop.most_impacts, 1))
            now = Progress(lattice_run.strikes, lattice_run.time - begun, min(share, 1.0))
            if progress is not None and progress(now):
                outcome = "cancelled"
                break
        else:
            recent = lattice_run.contacts_since(lattice_run.time - MOST_PERIODS * _TURN)
            speed = float(np.abs(recent["momentum_before"]).max(initial=0.0))
            periods = recurrence.after(float(lattice_run.now["gap"][0]), lattice_run.waves, speed)
            if stop.periodic and periods:
                outcome = "periodic"
            elif lattice_run.periods >= most:
                outcome = "time"
            elif lattice_run.strikes >= stop.most_impacts:
                outcome = "impacts"
    impacts, grazes = _finished(lattice_run, system)
    cycle = None
    if outcome == "periodic":
        since = impacts_of(recent, system.load, system.body.transit_time, _tool(lattice_run))[0].start
        number = int(np.count_nonzero(since >= lattice_run.time - periods * _TURN))
        cycle = MotionCycle(impacts.size - number, number, periods, 0)
    contacts = lattice_run.contacts
    taken, given, damped, averaged = (
        float(lattice_run.now[name][0]) for name in ("load_work", "rod_work", "damped", "averaged")
    )
    return WaveMotion(
        system=system,
        target=target,
        pushed_back=pushed_back,
        quiet=quiet,
        start=start,
        stop=stop,
        lattice=lattice,
        impacts=impacts,
        grazes=grazes,
        outcome=outcome,
        cycle=cycle,
        touching=lattice_run.touching,
        since=float(contacts["start"][-1]) if lattice_run.touching else math.nan,
        end_time=lattice_run.time,
        energy=WaveEnergy(taken, given, damped, averaged, lattice_run.energy - energy),
    )


def rigid_state(start: Start, system: System) -> tuple[float, float, float]:
    """A start as a rigid motion: the gap before the striking end, the mean velocity, the phase of the load."""
    place, velocity = start.gap, start.velocity[0]
    if start.source is not None or start.profile is not None or len(start.displacement) > 1:
        modes = len(start.displacement) - 1
        if start.source is not None:
            velocity += system.contact.velocity_factor * start.source.rigid_velocity
        gamma = system.body.modes(modes, system.load.at).gamma if modes else np.zeros(0)
        place = start.displacement[0] + float(gamma @ np.array(start.displacement[1:])) if place is None else place
    return max(0.0, -(0.0 if place is None else place)), velocity, start.time


def _finished(course: LatticeRun, system: System) -> tuple[Impacts, int]:
    """The impacts that have ended: after the last contact waves have gone there and back without another one.

    Those on a tool that is fed have ended when it is.
    """
    transit, tool = system.body.transit_time, _tool(course)
    found, grazes = impacts_of(course.contacts, system.load, transit, tool)
    if tool is not None:
        open_ = not course.blow_over
    else:
        open_ = course.touching or (found.size > 0 and course.time - found.end[-1] < ROUND_TRIP * transit)
    return found.part(slice(0, max(0, found.size - open_))), grazes


def _tool(course: LatticeRun) -> tuple[float, float] | None:
    """What `impacts_of` is to know of a tool that is fed."""
    return (course.rock_work, course.advanced) if course.machine.bit.fed else None


def _apart(one: WaveMotion, other: WaveMotion) -> Uncertainty:
    """How far two settled motions are apart, whichever impact of a cycle comes first."""
    if other.label != one.label or one.settled.size != other.settled.size:
        return Uncertainty(None, None, other.label)
    best = math.inf, math.inf
    for shift in range(one.settled.size):
        phases = np.angle(np.exp(1j * (one.phases - np.roll(other.phases, shift))))
        speeds = np.roll(other.velocities, shift) / one.velocities - 1.0
        best = min(best, (float(np.abs(phases).max()), float(np.abs(speeds).max())))
    return Uncertainty(*best, other.label)
