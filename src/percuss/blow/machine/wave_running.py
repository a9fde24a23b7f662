"""`machine_motion`: a machine under its periodic load with every contact resolved by waves."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from percuss.blow.bodies import Rod, Target, Wall
from percuss.blow.kernels.lattice_motion import follow
from percuss.blow.kernels.lattice_records import CONTACT, COUNT, LOAD, NOW, OFF, Chain, Machine
from percuss.blow.machine.lattice import machine_record
from percuss.blow.machine.wave_motion import (
    MOST_PERIODS,
    ROUND_TRIP,
    Ending,
    Energy,
    Impacts,
    Limits,
    MachineMotion,
    Recurrence,
    Release,
    Settled,
    Uncertainty,
    impacts_of,
)
from percuss.halting import look
from percuss.model import System
from percuss.model.checks import Array, callback, count, flag, instance
from percuss.shown import watched

# ---- A machine followed load period by load period: its clock, its contacts, its state at the end of each

_TURN = 2.0 * math.pi
_ROOM = 1024  # contacts in the log of a call
_AT_ONCE = 1 << 20  # steps between two looks at the outside


class Course:
    """A machine on its way."""

    def __init__(self, machine: Machine, release: Release) -> None:
        self.machine = machine
        self.now, self.count = np.zeros(1, NOW), np.zeros(1, COUNT)
        self._log, self._done = np.zeros(_ROOM, CONTACT), list[npt.NDArray[np.void]]()
        self._gone = 0
        wave = 0.5 * release.velocity
        machine.striker.right[:] = machine.striker.left[:] = wave
        steps, size = round(release.time / machine.step), machine.load.size
        self.periods = 0
        self.count["step"] = steps % size
        self.count["branch"] = OFF if machine.bit.gap > 0.0 else LOAD
        state = {
            "gap": release.gap,
            "momentum": release.velocity,
            "energy": 0.5 * release.velocity**2,
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


def _ordered(chain: Chain, step: float) -> Array:
    parts = [np.zeros(0)]
    for z, first, cells, slot in zip(chain.impedance, chain.first, chain.cells, chain.slot, strict=True):
        scale = math.sqrt(2.0 * z * step)
        parts += [scale * np.roll(wave[first : first + cells], -slot) for wave in (chain.right, chain.left)]
    return np.concatenate(parts)


# ---- `machine_motion`: a machine under its periodic load with every contact resolved by waves


@dataclass(frozen=True)
class MachineProgress:
    """How far a machine has been followed.

    Attributes
    ----------
    impacts
        From the start, about.
    time
        From the start, in radians.
    fraction
        0 to 1, of the load periods or the impacts asked for, whichever is nearer.
    """

    impacts: int
    time: float
    fraction: float


def machine_motion(
    system: System,
    target: Target,
    release: Release | None = None,
    limits: Limits | None = None,
    *,
    pushed_back: bool = False,
    quiet: bool = False,
    cells: int = 400,
    estimate: bool = True,
    progress: Callable[[MachineProgress], object] | None = None,
) -> MachineMotion:
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
    release
        The start; one length of the striker off, at rest, by default.
    limits
        When to end: by default after 400 load periods, 2000 impacts, or when a periodic motion is found.
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
        Called now and then with a `MachineProgress`; the motion ends as cancelled when it returns something true.

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
    >>> system = System(s=20.0, d=0.0, restitution=0.6, load=Load.harmonic(0.9, 1.0))
    >>> rod = Rod.of_impedance(20.0 * (1.0 + 0.6) / (1.0 - 0.6))
    >>> motion = machine_motion(system, rod, Release(gap=2.0, time=0.3), quiet=True, cells=100)
    >>> motion.label, motion.phases.round(3).tolist(), motion.cycle.restitution.round(4).tolist()
    ('z=1/1', [2.372], [0.6])
    """
    instance("system", system, System)
    if not isinstance(target, Wall | Rod):
        instance("target", target, Rod)
    release = Release() if release is None else instance("release", release, Release)
    limits = Limits() if limits is None else instance("limits", limits, Limits)
    flag("pushed_back", pushed_back), flag("quiet", quiet), flag("estimate", estimate)
    number = count("cells", cells, least=16, most=100_000)
    callback("progress", progress)

    def motion(cells: int) -> MachineMotion:
        with watched(progress) as watch:
            return _followed(system, target, release, limits, pushed_back, quiet, cells, watch)

    found = motion(number)
    if not estimate or found.settled is None or not found.settled.impacts:
        return found
    return replace(found, uncertainty=_apart(found, motion(max(8, number // 2))))


def _followed(
    system: System,
    target: Target,
    release: Release,
    limits: Limits,
    pushed_back: bool,
    quiet: bool,
    cells: int,
    progress: Callable[[MachineProgress], object] | None,
) -> MachineMotion:
    lattice, machine = machine_record(system, target, cells, pushed_back=pushed_back, quiet=quiet)
    course, recurrence = Course(machine, release), Recurrence(limits.tolerance)
    begun, energy = course.time, course.energy
    ending, settled = None, None
    while ending is None:
        for _ in course.period():
            look()
            if progress is not None and progress(_progress(course, limits, begun)):
                ending = Ending.CANCELLED
                break
        if ending is None:
            ending, settled = _judged(course, recurrence, limits, system)
    impacts, grazes = _finished(course, system)
    now = course.now[0]
    contacts = course.contacts
    return MachineMotion(
        system=system,
        target=target,
        pushed_back=pushed_back,
        quiet=quiet,
        release=release,
        limits=limits,
        lattice=lattice,
        impacts=impacts,
        grazes=grazes,
        ending=ending,
        settled=settled,
        touching=course.touching,
        since=float(contacts["start"][-1]) if course.touching else math.nan,
        end_time=course.time,
        energy=Energy(
            float(now["load_work"]),
            float(now["rod_work"]),
            float(now["damped"]),
            float(now["averaged"]),
            course.energy - energy,
        ),
    )


def _judged(
    course: Course, recurrence: Recurrence, limits: Limits, system: System
) -> tuple[Ending | None, Settled | None]:
    """Whether the motion ends at the end of this period, and the periodic motion found."""
    recent = course.contacts_since(course.time - MOST_PERIODS * _TURN)
    speed = float(np.abs(recent["momentum_before"]).max(initial=0.0))
    periods, off = recurrence.after(float(course.now["gap"][0]), course.waves, speed)
    if limits.settled and periods:
        impacts = impacts_of(recent, system.load, system.body.transit_time, _tool(course))[0]
        number = int(np.count_nonzero(impacts.start >= course.time - periods * _TURN))
        return Ending.SETTLED, Settled(number, periods, off)
    if course.periods >= limits.periods:
        return Ending.PERIODS, None
    if course.strikes >= limits.impacts:
        return Ending.IMPACTS, None
    return None, None


def _finished(course: Course, system: System) -> tuple[Impacts, int]:
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


def _tool(course: Course) -> tuple[float, float] | None:
    """What `impacts_of` is to know of a tool that is fed."""
    return (course.rock_work, course.advanced) if course.machine.bit.fed else None


def _progress(course: Course, limits: Limits, begun: float) -> MachineProgress:
    fraction = max(course.periods / limits.periods, course.strikes / limits.impacts)
    return MachineProgress(course.strikes, course.time - begun, min(fraction, 1.0))


def _apart(one: MachineMotion, other: MachineMotion) -> Uncertainty:
    """How far two settled motions are apart, whichever impact of a cycle comes first."""
    if other.label != one.label or one.cycle.size != other.cycle.size:
        return Uncertainty(None, None, other.label)
    best = math.inf, math.inf
    for shift in range(one.cycle.size):
        phases = np.angle(np.exp(1j * (one.phases - np.roll(other.phases, shift))))
        speeds = np.roll(other.velocities, shift) / one.velocities - 1.0
        best = min(best, (float(np.abs(phases).max()), float(np.abs(speeds).max())))
    return Uncertainty(*best, other.label)
