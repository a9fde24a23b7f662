"""A machine under its periodic load with every contact resolved by waves: `run_by_waves`, and the motion that it is."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass, fields, replace
from functools import cached_property

import numpy as np
import numpy.typing as npt

from percuss.blow.bodies import Rod, Target, Wall
from percuss.blow.kernels.lattice_motion import follow
from percuss.blow.kernels.lattice_records import (
    CONTACT,
    COUNT,
    ELASTIC,
    LOAD,
    MASS,
    NOW,
    OFF,
    LatticeMachine,
    LatticeRow,
)  # fmt: skip
from percuss.blow.periods.lattice import Lattice, machine_record
from percuss.halting import check_interrupted
from percuss.model import Load, System
from percuss.model.checks import Array, callback, count, flag, instance
from percuss.short_repr import ShortRepr, watched
from percuss.simulate import MotionCycle, Progress, Start, Stop

_TURN = 2.0 * math.pi

# ---- A machine followed load period by load period: its clock, its contacts, its state at the end of each

_ROOM = 1024  # contacts in the log of a call
_AT_ONCE = 1 << 20  # steps between two looks at the outside
MOST, TOLERANCE = 400, 1e-6
"""Load periods after which a motion ends, and how near a state must come back, where nothing else is asked for."""


class LatticeRun:
    """A machine on its way, from a rigid motion of the striker at a distance from what it strikes."""

    def __init__(self, machine: LatticeMachine, gap: float, velocity: float = 0.0, time: float = 0.0) -> None:
        self.machine = machine
        self.now, self.count = np.zeros(1, NOW), np.zeros(1, COUNT)
        self._log, self._done, self._gone = np.zeros(_ROOM, CONTACT), list[npt.NDArray[np.void]](), 0
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
        if machine.held.active and machine.bit.stiffness > 0.0 and machine.held.preload[-1] > 0.0:
            self._stand(machine.held.preload[-1])

    def _stand(self, force: float) -> None:
        """Let the bit stand on fresh rock under a force."""
        bit = self.machine.bit
        self.now["penetration"] = self.now["greatest"] = force / bit.stiffness
        self.now["rock_work"] = -0.5 * (1.0 - bit.ratio) * force**2 / bit.stiffness
        self.machine.held.tool["rock_force"] = force

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

    def taken(self) -> npt.NDArray[np.void]:
        """The contacts from the start, or from when they were last taken."""
        found = self.contacts
        self._gone += int(self.count["contacts"][0])
        self._done.clear()
        self.count["contacts"] = 0
        return found

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
        """√(2 Z Δt) f and g of all cells, in order of space (sum of squares 2 E), motion and force of the bit."""
        machine, now, bit = self.machine, self.now[0], self.machine.bit
        force = float(now["penetration"]) - (1.0 - bit.ratio) * float(now["greatest"])
        ends = [
            math.sqrt(bit.mass) * float(now["bit_velocity"]),
            math.sqrt(bit.stiffness / bit.ratio) * max(force, 0.0),
        ]
        if machine.held.active:
            joint, held = machine.held.joint, machine.held
            stiff = np.where(held.kind == ELASTIC, held.spring, 1.0)
            ends += [np.sqrt(held.mass) * joint["velocity"], np.sqrt(stiff) * joint["place"] * (held.kind > MASS)]
            ends += [math.sqrt(held.stiffness) * float(held.tool["place"][0])]
        rows = (_ordered(chain, machine.step) for chain in (machine.striker, machine.rod))
        return np.concatenate([*rows, *(np.atleast_1d(end) for end in ends)])

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


# ---- Contacts gathered to impacts, with what each impact did

ROUND_TRIP = 2.0  # transit times: contacts nearer than the way of waves there and back belong to one impact

_GRAZE = 1e-9  # of the greatest impulse


@dataclass(frozen=True)
class Impacts(ShortRepr):
    """The impacts of a machine, one after another; every array of shape (impacts,), dimensionless.

    Contacts that are less than a wave's way there and back apart are one impact; on a tool that is fed between blows,
    all contacts from one time that it is fed to the next.

    Attributes
    ----------
    start, end
        Of the contact, or of the first and the last contact; radians.
    contacts, impulse, centroid
        How many there are, J = ∫ N dt of all of them, and the time of the centroid of the force.
    velocity
        Of the rigid motion at the centroid, as it would be without the contact force (b77-blow's V). It tells little of
        an impact that lasts for a good part of a load period, such as a chatter that ends in rest.
    mean_before, mean_after
        Mean velocity of the striker when the contact starts and when it has ended.
    ringing_share
        Elastic energy when the contact has ended, over the striker's energy when it started.
    given
        ∫ N v dt at the struck face: the work done on what is struck.
    rock_work
        Work that the rock has kept by the next impact, ½ (1 − γ) K u_m²; 0 without rock.
    fed
        By how much the tool is fed after the impact; 0 of one that comes back to its place or is not fed.
    energy_left, stands
        Of a tool with a feed: the energy of what departs from its static state when the impact begins, and whether the
        bit is on the rock then (1 or 0). 0 of others.
    """

    start: Array
    end: Array
    contacts: npt.NDArray[np.int64]
    impulse: Array
    centroid: Array
    velocity: Array
    mean_before: Array
    mean_after: Array
    peak_force: Array
    ringing_share: Array
    given: Array
    rock_work: Array
    fed: Array
    energy_left: Array
    stands: Array

    @property
    def size(self) -> int:
        """How many impacts."""
        return self.start.size

    @property
    def phase(self) -> Array:
        """Of the load at the centroid, in [0, 2π)."""
        return np.asarray(self.centroid % _TURN % _TURN)

    @property
    def duration(self) -> Array:
        """From the start of the first contact to the end of the last."""
        return self.end - self.start

    @property
    def restitution(self) -> Array:
        """R of each impact, J/V − 1 with V at the centroid; NaN where V is not toward the struck face."""
        moving = self.velocity > 0.0
        return np.where(moving, self.impulse / np.where(moving, self.velocity, 1.0) - 1.0, math.nan)

    def part(self, which: int | slice | Array) -> Impacts:
        """Some of them; with a number that one, in plain numbers."""
        return Impacts(*(getattr(self, one.name)[which] for one in fields(self)))


def impacts_of(
    contacts: npt.NDArray[np.void], load: Load, transit: float, tool: tuple[float, float] | None = None
) -> tuple[Impacts, int]:
    """The impacts that contacts make, and how many grazing ones were left out; `tool`: rock's work, and feed."""
    impulses = contacts["impulse"]
    real = impulses > _GRAZE * impulses.max(initial=0.0)
    kept = contacts[real]
    first = np.ones(kept.size, dtype=bool)
    if tool is None:
        first[1:] = kept["start"][1:] - kept["end"][:-1] >= ROUND_TRIP * transit
    else:
        first[1:] = np.diff(kept["blow"]) > 0
    at = np.flatnonzero(first)
    last = np.append(at[1:], kept.size) - 1 if at.size else at
    impulse = _sums(kept["impulse"], at)
    centroid = _sums(kept["moment"] + kept["impulse"] * kept["start"], at) / impulse
    start, before = kept["start"][at], kept["momentum_before"][at]
    fallen = load.mean * (centroid - start) + load.antiderivative(centroid) - load.antiderivative(start)
    energy, after = kept["energy_before"][at], kept["momentum_after"][last]
    hidden = kept["averaged_after"][last] - kept["averaged_before"][at]  # in cells that fronts divide
    elastic = kept["energy_after"][last] + hidden - 0.5 * after**2
    found = Impacts(
        start=start,
        end=kept["end"][last],
        contacts=last - at + 1,
        impulse=impulse,
        centroid=centroid,
        velocity=before + fallen,
        mean_before=before,
        mean_after=after,
        peak_force=np.maximum.reduceat(kept["peak"], at) if at.size else np.zeros(0),
        ringing_share=np.maximum(elastic, 0.0) / np.where(energy > 0.0, energy, math.inf),
        given=_sums(kept["given"], at),
        rock_work=_between(kept["rock_before"], at, tool and tool[0]),
        fed=_between(kept["advanced_before"], at, tool and tool[1]),
        energy_left=kept["left"][at],
        stands=kept["stood"][at],
    )
    return found, int(np.count_nonzero(~real))


def _between(before: Array, at: npt.NDArray[np.intp], last: float | None) -> Array:
    """By how much a sum grows from each impact to the next, and from the last to the end."""
    return np.diff(before[at], append=last) if last is not None and at.size else np.zeros(at.size)


def _sums(values: Array, at: npt.NDArray[np.intp]) -> Array:
    return np.add.reduceat(values, at) if at.size else np.zeros(0)


# ---- Whether a machine does the same again: its whole state at the ends of load periods, compared

MOST_PERIODS = 16  # the longest cycle that is looked for
_CONFIRMED = 2
_NEAR = 100.0  # times the tolerance


class Recurrence:
    """The last states at the ends of load periods."""

    def __init__(self, tolerance: float) -> None:
        self.tolerance = tolerance
        self._states: deque[tuple[float, Array]] = deque(maxlen=MOST_PERIODS)
        self._seen = [0] * (MOST_PERIODS + 1)

    def after(self, gap: float, waves: Array, speed: float) -> int:
        """How many periods ago the state was the same, twice in a row, and no shorter cycle nearer; 0: never."""
        found, apart = 0, [math.inf] * (MOST_PERIODS + 1)
        for periods, (old_gap, old) in enumerate(reversed(self._states), 1):
            off = float(np.linalg.norm(waves - old)) + abs(gap - old_gap) / (2.0 * math.pi)
            apart[periods] = off / speed if speed > 0.0 else math.inf if off > 0.0 else 0.0
            same = apart[periods] <= self.tolerance
            self._seen[periods] = self._seen[periods] + 1 if same else 0
            nearer = any(apart[part] <= _NEAR * self.tolerance for part in range(1, periods) if periods % part == 0)
            if not found and self._seen[periods] >= _CONFIRMED and not nearer:
                found = periods
        self._states.append((gap, waves))
        return found


# ---- The motion of a machine whose every contact is resolved by waves

_LONG = 2  # load periods in contact from which on the bar is said to rest
_MAIN = 0.5  # of the greatest impulse: what gives as much is a blow


@dataclass(frozen=True)
class WaveEnergy(ShortRepr):
    """Where the energy of a motion went; all over the time followed, dimensionless.

    Attributes
    ----------
    load_work, given, damped
        Done by the load, to what is struck, ∫ N v dt at its face, and taken by damping.
    averaged
        What the lattice does not show: in a cell in which a contact starts or ends, or met a front, waves are known by
        their mean. It falls with the size of the cells.
    stored
        Rise of the striker's kinetic and elastic energy.
    """

    load_work: float
    given: float
    damped: float
    averaged: float
    stored: float

    @property
    def error(self) -> float:
        """What is missing, over the sum of the amounts: rounding; dimensionless."""
        parts = self.load_work, self.given, self.damped, self.averaged, self.stored
        missing = parts[0] - sum(parts[1:])
        whole = sum(map(abs, parts))
        return abs(missing) / whole if whole > 0.0 else 0.0


@dataclass(frozen=True)
class Uncertainty(ShortRepr):
    """How far the settled motion of a lattice with half the cells is from this one.

    Attributes
    ----------
    phase, velocity
        Greatest difference of the phases of the impacts, in radians, and greatest relative one of the striking speeds;
        None where the other lattice settled otherwise.
    label
        What the other lattice settled on.
    """

    phase: float | None
    velocity: float | None
    label: str


@dataclass(frozen=True)
class WaveMotion(ShortRepr):
    """The striker under its load, contact by contact.

    Everything is dimensionless; `system` has the scales to SI.

    Attributes
    ----------
    system, target
        What strikes under which load, and what is struck. The contact law of the system has no part in this.
    pushed_back
        Whether the rod is pushed back to its place as soon as the striker has left it the room, or stays where it is.
    quiet
        Whether all ringing was made to end between blows.
    impacts, grazes
        All impacts that have ended, and how many contacts without an impulse to speak of were left out.
    outcome
        One of `percuss.simulate.OUTCOMES`: why it was followed no further.
    touching, since, end_time
        Whether the faces are in contact at the end, since when (NaN out of contact), and when that is, in radians.
    uncertainty
        What a coarser lattice gives; None where that was not asked for.
    """

    system: System
    target: Target
    pushed_back: bool
    quiet: bool
    start: Start
    stop: Stop
    lattice: Lattice
    impacts: Impacts
    grazes: int
    outcome: str
    cycle: MotionCycle | None
    touching: bool
    since: float
    end_time: float
    energy: WaveEnergy
    uncertainty: Uncertainty | None = None

    @property
    def rests(self) -> bool:
        """Whether the striker has lain on what it strikes for the last load periods."""
        return self.touching and self.end_time - self.since >= _LONG * _TURN

    @property
    def label(self) -> str:
        """z=p/n for p impacts in n load periods; else rest, irregular, or none where nothing is struck."""
        if self.rests:
            return "rest"
        if self.cycle is None:
            return "irregular" if self.impacts.size else "none"
        return f"z={self.cycle.impacts}/{self.cycle.periods}" if self.cycle.impacts else "none"

    @cached_property
    def settled(self) -> Impacts:
        """The impacts of the last settled cycle, or of the last half of an irregular motion."""
        n = self.impacts.size
        count = self.cycle.impacts if self.cycle is not None else (n + 1) // 2
        return self.impacts.part(slice(n - count, n))

    @cached_property
    def main(self) -> Impacts:
        """Of the settled impacts the blows: those with half the greatest impulse or more."""
        own = self.settled
        return own.part(own.impulse >= _MAIN * own.impulse.max(initial=0.0))

    @property
    def rhythm(self) -> tuple[float, float]:
        """Blows per load period, and by how much their impulses scatter, (max − min)/mean; NaN without blows."""
        own = self.main
        if not own.size:
            return math.nan, math.nan
        periods = self.cycle.periods if self.cycle is not None else math.nan
        if self.cycle is None and own.size > 1:
            periods = own.size * float(own.start[-1] - own.start[0]) / (own.size - 1) / _TURN
        return own.size / periods, float(np.ptp(own.impulse) / np.mean(own.impulse))

    @property
    def left_bound(self) -> float | None:
        """√(E_left/W_load): the most by which waves left in the tool change a blow; None without feed or rock.

        The greatest of all blows; W_load = K_1 U²/2 with U = `fed`/(1 − γ), the penetration that a blow adds.
        """
        target, own = self.target, self.main
        if not isinstance(target, Rod) or target.feed is None or target.rock is None or self.system.bar is None:
            return None
        stiffness = target.rock.stiffness / (self.system.bar.mass * self.system.angular_frequency**2)
        deep = own.fed / max(1.0 - target.rock.unloading_ratio, 1e-9)
        loads = 0.5 * stiffness * deep[deep > 0.0] ** 2
        return float(np.sqrt(own.energy_left[deep > 0.0] / loads).max()) if loads.size else None

    @property
    def phases(self) -> Array:
        """Phases of the load at the force centroids of the cycle's impacts, in [0, 2π)."""
        return self.settled.phase

    @property
    def velocities(self) -> Array:
        """Striking speeds of the rigid motion at those."""
        return self.settled.velocity

    @property
    def blow_rate(self) -> float:
        """Impacts per load period."""
        if self.cycle is not None:
            return self.cycle.impacts / self.cycle.periods
        own = self.settled
        return _TURN * (own.size - 1) / float(own.start[-1] - own.start[0]) if own.size > 1 else math.nan

    @property
    def impulse_per_period(self) -> float:
        """Σ J of the cycle over its load periods: p_0 2π of every periodic motion without drag."""
        return float(np.sum(self.settled.impulse)) / self.cycle.periods if self.cycle is not None else math.nan

    @property
    def delivered_power(self) -> float:
        """Work done on what is struck, per radian of the load."""
        return self._power(self.settled.given)

    @property
    def rock_power(self) -> float:
        """Work that the rock keeps, per radian of the load; 0 without rock."""
        return self._power(self.settled.rock_work)

    def _power(self, work: Array) -> float:
        return float(np.mean(work)) * self.blow_rate / _TURN if work.size else 0.0

    def __str__(self) -> str:
        phases = ", ".join(f"{phase:.6g}" for phase in self.phases[:4]) if self.cycle is not None else ""
        where = f", phase {phases}{' …' if self.settled.size > 4 else ''}" if phases else ""
        count = self.impacts.size
        return (
            f"Machine by waves: {self.label}{where}; {count} impact{'s' if count != 1 else ''}, ended: {self.outcome}"
        )


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
    system, target
        Striker, load and damping, which acts on the striker alone, in contact too; and a rigid wall, or a rod with any
        end. Its own gap is not used: the start has one. A rod with a `Feed` is held by it: waves and bit stay as a blow
        leaves them, and when the striker turns forward again the rock is replaced at equal force on the bit, while the
        machine follows. Without one, a rod on rock or with a free end is fed between blows: when the
        striker that has gone back turns forward again, and the rod has been without contact for four ways of a wave
        through it and half a swing of its mass on the rock, it is laid at rest against fresh rock.
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
    cells, estimate
        Cells of the striker, at least, and whether to tell, from a lattice with half as many, how sure a settled motion
        is.
    progress
        Called now and then with a `percuss.simulate.Progress`; the motion ends when it returns something true.

    Raises
    ------
    ParameterError
        For a rod with a free end that is not pushed back, and numbers out of range.
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
            check_interrupted()
            share = max(lattice_run.periods / most, lattice_run.strikes / max(stop.most_impacts, 1))
            now = Progress(lattice_run.strikes, lattice_run.time - begun, min(share, 1.0))
            if progress is not None and progress(now):
                outcome = "interrupted"
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
    """The impacts that have ended: waves have gone there and back without another contact, or the tool is fed."""
    transit, tool = system.body.transit_time, _tool(course)
    found, grazes = impacts_of(course.contacts, system.load, transit, tool)
    if tool is not None:
        open_ = bool(course.count["struck"][0])  # the tool has not been fed since
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
