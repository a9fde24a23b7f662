"""The machine that switches its own valve: its cycle, or what keeps it from running."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import Enum
from functools import cached_property
from typing import Self, TypedDict

import numpy as np
import numpy.typing as npt

from percuss.errors import ParameterError
from percuss.mechanics.kernel_cache import ensure_cache
from percuss.model import Machine, Valve
from percuss.model.checks import DEFAULT_MODES, Array, count, instance, positive
from percuss.short_repr import ShortRepr
from percuss.steady.oil.oil_cycle import OilSettled, settled_oil, starts_oil
from percuss.steady.self_excited import piston_kernels as kn
from percuss.steady.self_excited.cycle_times import CycleTimes
from percuss.steady.self_excited.piston import Lost, Piston, settled, starts
from percuss.steady.self_excited.piston_flight import (
    FACTOR,
    NO_PORTS,
    at,
    first_crossing,
    last_place,
    turning_places,
    turning_time,
)
from percuss.steady.self_excited.settling import (
    Settled,
    settled_from,
    solved,
    starts_supplied,
    supplied,
    under_pressure,
)
from percuss.steady.self_excited.valve_cycle import ValveCycle, ValveFlight, pressure_multiplier

# ---- What keeps a machine that switches itself from running with one blow in a cycle, and what would be needed


class Obstacle(Enum):
    """What keeps a self-excited machine from running with one blow in a cycle; its value is the word for it.

    Attributes
    ----------
    words
        What happens.
    remedy
        What to do about it.

    Examples
    --------
    >>> Obstacle("stays on the wall").remedy
    'make the return force pull the piston away from the wall at the wall, against the chamber'
    """

    words: str
    remedy: str

    def __new__(cls, word: str, words: str, remedy: str) -> Self:
        made = object.__new__(cls)
        made._value_, made.words, made.remedy = word, words, remedy
        return made

    NO_LOSS = (
        "no loss",
        "nothing takes the energy that the valve puts in, so that the piston strikes faster with every blow",
        "give a restitution below 1, or a drag",
    )
    ON_THE_WALL = (
        "stays on the wall",
        "the piston lies on the wall, is pushed towards it, and no order is pending",
        "make the return force pull the piston away from the wall at the wall, against the chamber",
    )
    NO_PORT = (
        "reaches no port",
        "the piston comes to no port that would change the state, and does not strike",
        "put the port nearer to the wall, make the return force greater, or the chamber softer",
    )
    BOUNCES = (
        "bounces",
        "the bar strikes again and again and comes to no port",
        "make the restitution or the return force greater, or put the port nearer to the wall",
    )
    NO_ROOM = (
        "no room",
        "the piston goes farther back than there is room",
        "put the rear port nearer to the wall, shorten its delay, or make the power force greater",
    )
    NO_BLOW = (
        "cycles without a blow",
        "the valve turns the piston round before it strikes",
        "put the front port nearer to the wall, or give it a longer delay",
    )
    DOUBLE_BLOW = (
        "double blow",
        "the return comes late: the piston has fallen back to the wall and strikes again",
        "shorten the delay of the return, or make its force greater",
    )
    OVERTAKEN = (
        "order overtaken",
        "the rebound reaches the rear port before the return is due, and its demand replaces the order",
        "shorten the delay of the return, or put the rear port farther from the wall",
    )
    FLIP = (
        "flip",
        "weak and strong blows alternate, farther and farther apart (period doubling)",
        "shorten the delay of the return, or lower the restitution",
    )
    SPIRAL = (
        "spiral",
        "a slow beat of the blows grows: two multipliers are beyond the unit circle, as of ringing that the blows feed",
        "damp the elastic modes, or take the contact law that turns the strain over with the velocity",
    )
    GROWS = (
        "grows",
        "a disturbance grows from blow to blow, as of ringing that the blows feed",
        "damp the elastic modes, or take the contact law that turns the strain over with the velocity",
    )
    HUNTS = (
        "pressure swings",
        "a strong blow leaves the next one a lower pressure: blows and pressure go up and down, farther and farther",
        "take a greater accumulator, more flow, or a softer gas behind the piston",
    )
    NO_PRESSURE = (
        "no pressure",
        "the pressure of the supply falls to 0: the piston draws more than pump and accumulator give",
        "take a greater accumulator, more flow, or a smaller stroke",
    )
    UNEVEN = (
        "uneven blows",
        "the blows differ from each other, and repeat after a few of them",
        "damp the elastic modes, or lower the restitution",
    )
    IRREGULAR = ("irregular", "the blows do not repeat", "shorten the delays, or lower the restitution")


class Reasoned(TypedDict, total=False):
    """An obstacle, and the number that decides: as it is, and as it would have to be."""

    obstacle: Obstacle
    found: float | None
    needed: float | None


def why_unstable(multiplier: complex) -> Obstacle:
    """How a cycle with a multiplier of modulus 1 or more is left."""
    if multiplier.imag != 0.0:
        return Obstacle.SPIRAL
    return Obstacle.FLIP if multiplier.real < 0.0 else Obstacle.GROWS


OBSTACLES = (
    None,
    Obstacle.ON_THE_WALL,
    Obstacle.NO_PORT,
    Obstacle.NO_BLOW,
    Obstacle.DOUBLE_BLOW,
    Obstacle.OVERTAKEN,
    Obstacle.IRREGULAR,
)
"""By the numbers of `piston_kernels`; what these have no answer for is taken for irregular."""


def why_none(machine: Machine, lost: Lost) -> Reasoned:
    """What the last flights of a machine without a cycle tell of it."""
    obstacle = Obstacle.IRREGULAR if lost.why == kn.UNKNOWN else OBSTACLES[lost.why]
    assert obstacle is not None
    leg = lost.leg
    if obstacle is Obstacle.ON_THE_WALL:
        state = leg.switches[-1].to if leg.switches else lost.began.state
        return {"obstacle": obstacle, "found": machine.valve.force(state), "needed": 0.0}
    if obstacle is Obstacle.NO_BLOW:
        nearest = min(min(_places(flight)) for flight in leg.flights[1:])
        return {"obstacle": obstacle, "found": nearest, "needed": 0.0}
    if obstacle is Obstacle.NO_PORT:
        edges = [port.behind for port in machine.valve.ports if port.side == "back"]
        beyond = [edge for edge in edges if edge is not None and edge > leg.farthest]
        return {"obstacle": obstacle, "found": leg.farthest, "needed": min(beyond, default=None)}
    return {"obstacle": obstacle}


def _places(flight: ValveFlight) -> list[float]:
    """How far behind the wall a rigid piston turns and ends."""
    end = last_place(flight.rigid) if flight.duration == math.inf else -float(flight.end[0, 0])
    return [end, *turning_places(flight.rigid, flight.duration)]


def why_more_blows(cycle: ValveCycle) -> Obstacle:
    """Why a cycle of an elastic machine has several blows: the valve changes once for each of them, or less often."""
    first = cycle.switches[0].to
    turns = sum(switch.to == first for switch in cycle.switches)
    return Obstacle.UNEVEN if turns >= cycle.blows else Obstacle.DOUBLE_BLOW


def why_several(machine: Machine, cycle: ValveCycle, dropped: bool) -> Reasoned:
    """Why a cycle of a rigid piston has several blows: an order was replaced, or came too late after the strongest."""
    if dropped:
        return {"obstacle": Obstacle.OVERTAKEN}
    times = np.array([switch.time for switch in cycle.switches])
    strongest = int(np.argmax(cycle.blow_speeds))
    since = np.mod(times - (cycle.blow_times[strongest] if strongest < cycle.blows - 1 else 0.0), cycle.period)
    first, ended = int(np.argmin(since)), [one for one in cycle.flights if one.time < cycle.blow_times[strongest]]
    speed = Piston(machine).numbers[2][FACTOR] * -cycle.blow_speed
    needed = latest_return(Piston(machine), speed, ended[-1].state, cycle.switches[first].to)
    return {"obstacle": Obstacle.DOUBLE_BLOW, "found": float(since[first]), "needed": needed}


def latest_return(piston: Piston, speed: float, state: str, to: str) -> float | None:
    """The latest time after a blow at which a state keeps the piston from falling back to the wall; None for none."""
    falling = piston.flight(state, 0.0, speed)
    late, _, way, _ = first_crossing(falling, NO_PORTS, math.inf)
    if way == 0:
        return math.inf if speed > 0.0 else 0.0

    def nearest(due: float) -> float:
        x, v = at(falling, due)
        pulled = piston.flight(to, x, v)
        turn = turning_time(pulled)
        return at(pulled, turn)[0] if math.isfinite(turn) else math.copysign(x, v)

    early = turning_time(falling)
    if not nearest(early) > 0.0 >= nearest(late):
        return None
    while late - early > _CLOSE * late:
        middle = 0.5 * (early + late)
        early, late = (middle, late) if nearest(middle) > 0.0 else (early, middle)
    return 0.5 * (early + late)


# ---- The machine that switches its own valve: its cycle, or what keeps it from running

_MOST_MODES = 4096
_CLOSE = 1e-15


@dataclass(frozen=True)
class SelfExcited(ShortRepr):
    """What a machine does that switches its own valve.

    Parameters
    ----------
    cycle
        The periodic motion; None when there is none. With `obstacle` "double blow" or "order overtaken" it has several
        blows, and with "no room" it is the one that there would be.
    obstacle
        What keeps the machine from running with one blow in a cycle, the first that is met; None when it runs.
    found, needed
        The number that decides, as it is and as it would have to be, dimensionless; None where there is none. "stays on
        the wall": the force at the wall, which must be below `needed`. "reaches no port": the distance behind the wall
        that the piston reaches, and that of the port. "no room": the stroke, and the room. "cycles without a blow": the
        least distance from the wall, and 0. "flip": the modulus of the multiplier, and 1. "double blow": the time from
        the strongest blow to the return, and the longest with which the piston does not fall back.
    """

    machine: Machine
    modes: int
    room: float
    cycle: ValveCycle | None
    obstacle: Obstacle | None
    found: float | None = None
    needed: float | None = None

    @property
    def runs(self) -> bool:
        """Whether there is a stable cycle with one blow."""
        return self.obstacle is None

    @cached_property
    def starts_from_rest(self) -> bool:
        """Whether the machine keeps going when it starts at rest on the wall, with the valve in its starting state."""
        if self.cycle is None:
            return False
        if self.machine.valve.flows:
            return starts_oil(self.machine)
        return (starts if self.machine.valve.supply is None else starts_supplied)(self.machine, self.cycle)

    def __str__(self) -> str:
        if self.obstacle is None:
            assert self.cycle is not None
            return f"SelfExcited: runs, {self.cycle}"
        found = "" if self.found is None or self.needed is None else f" ({self.found:.6g}, needed {self.needed:.6g})"
        return f"SelfExcited: {self.obstacle.value}{found} — {self.obstacle.remedy}"


def self_excited_motion(
    machine: Machine,
    *,
    modes: int = DEFAULT_MODES,
    room: float | None = None,
    near: CycleTimes | ValveCycle | None = None,
) -> SelfExcited:
    """The cycle of a machine that switches its own valve, or what keeps it from running.

    The units of length and of time are free; the mass is 1. For a rigid piston every flight is closed (parabola,
    exponential or circle), and Newton's method with exact derivatives finds the motion that repeats, for any number of
    ports, states and delays. Its ports are read at the centre of mass wherever they are.

    With a supply the pressure follows the piston: the flights stay closed, and the pressure at the blow is found with
    the speed. The multipliers are those of both.

    With elastic modes the unknowns are the times at which ports are passed and blows fall: every mode follows from them
    in closed form. Newton's method starts from the rhythm of the rigid piston. Where that leads to no cycle, or to an
    unstable one, the machine is followed from blow to blow until it settles. Of every cycle it is proved that the bar
    neither strikes nor enters the region of a port in between.

    Parameters
    ----------
    modes
        N, the elastic modes kept; 0 for a rigid piston.
    room
        Distance behind the wall that the piston can go; without limit by default.
    near
        With elastic modes: a rhythm near that of the cycle, as of a simulation, or another cycle; by default that of
        the rigid piston.

    Notes
    -----
    Without delay and drag the square of the blow speed of a rigid piston is 2 Σ Δ_i x_i/(1 − R²), with Δ_i the jump of
    the force at the distance x_i behind the wall, and the multiplier is R².

    Examples
    --------
    >>> from percuss.model import External, Machine, Port, Reversed, UniformBar, Valve
    >>> ports = [Port("power", behind=1.0, side="back"), Port("return", on="impact")]
    >>> valve = Valve({"return": -0.4, "power": 1.8}, ports)
    >>> machine = Machine(UniformBar(20.0, External(0.01)), valve, Reversed(0.2))
    >>> print(self_excited_motion(machine, modes=0))
    SelfExcited: runs, ValveCycle: 1 blow, speed 2.12761, period 3.15229, stroke 1.26743, multiplier 0.03876, 0 modes
    >>> print(self_excited_motion(machine))
    SelfExcited: runs, ValveCycle: 1 blow, speed 2.04435, period 3.15231, stroke 1.27017, multiplier 0.197, 32 modes
    """
    instance("machine", machine, Machine)
    modes = count("modes", modes, least=0, most=_MOST_MODES)
    space = math.inf if room is None else positive("room", room)
    rhythm = _checked(near, modes, machine.valve)
    asked = SelfExcited(machine, modes, space, None, None)
    if machine.contact.is_lossless and machine.body.damping.is_zero:
        return replace(asked, obstacle=Obstacle.NO_LOSS)
    if machine.valve.flows:
        return _of_oil(asked, settled_oil(machine, modes, near if isinstance(near, ValveCycle) else None))
    if modes and rhythm is not None:
        return _elastic(asked, rhythm, None)
    if machine.valve.supply is not None:
        found = supplied(machine)
        return _elastic(asked, found.cycle.rhythm, found.cycle) if modes and found.cycle else _told(asked, found)
    rigid, lost, dropped = settled(machine)
    if rigid is None:
        assert lost is not None
        return replace(asked, **why_none(machine, lost))
    if modes:
        return _elastic(asked, rigid.rhythm, rigid)
    if rigid.blows > 1:
        return replace(asked, cycle=rigid, **why_several(machine, rigid, dropped))
    return _judged(asked, rigid)


def _of_oil(asked: SelfExcited, found: OilSettled) -> SelfExcited:
    """What the cycle of a machine whose oil flows, or the motion in which it ends, says of it."""
    cycle, valve = found.cycle, asked.machine.valve
    if cycle is None:
        obstacle = _ENDED.get(found.ending, Obstacle.IRREGULAR)
        if found.motion is None or obstacle not in (Obstacle.ON_THE_WALL, Obstacle.NO_PORT):
            return replace(asked, obstacle=obstacle)
        if obstacle is Obstacle.ON_THE_WALL:
            return replace(asked, obstacle=obstacle, found=found.motion.force, needed=0.0)
        reached, edges = found.motion.balance.farthest, [port.behind for port in valve.ports if port.side == "back"]
        beyond = [edge for edge in edges if edge is not None and edge > reached]
        return replace(asked, obstacle=obstacle, found=reached, needed=min(beyond, default=None))
    if cycle.blows > 1 and cycle.stable:
        hunts = why_more_blows(cycle) is Obstacle.UNEVEN and valve.supply is not None
        return replace(asked, cycle=cycle, obstacle=Obstacle.HUNTS if hunts else why_more_blows(cycle))
    if asked.room < math.inf and cycle.stroke > asked.room:
        return replace(asked, cycle=cycle, obstacle=Obstacle.NO_ROOM, found=cycle.stroke, needed=asked.room)
    if cycle.stable:
        return replace(asked, cycle=cycle)
    pressed = valve.supply is not None and abs(pressure_multiplier(cycle.slope, cycle.modes)) >= 1.0
    why = Obstacle.HUNTS if pressed else why_unstable(cycle.multiplier)
    return replace(asked, cycle=cycle, obstacle=why, found=abs(cycle.multiplier), needed=1.0)


def _checked(near: object, modes: int, valve: Valve) -> CycleTimes | None:
    if near is None:
        return None
    if modes == 0 and not valve.flows:
        raise ParameterError("near", near, "nothing beside modes=0", "the rigid piston needs no start")
    if isinstance(near, ValveCycle):
        return near.rhythm
    rhythm = instance("near", near, CycleTimes)
    named = [rhythm.state, rhythm.orders.last, *(to for _, to in rhythm.orders.pending)]
    for state in named:
        valve.force(state)
    if any(port >= len(valve.ports) or valve.ports[port].on == "impact" for _, port in rhythm.passages):
        raise ParameterError("near", rhythm.passages, "passages of ports that this valve has")
    return rhythm


def _elastic(asked: SelfExcited, rhythm: CycleTimes, rigid: ValveCycle | None) -> SelfExcited:
    """What an elastic machine does, from a rhythm on."""
    start, period = (None, rhythm.period) if rigid is None else (rigid.rebound, rigid.period)
    return _told(asked, settled_from(asked.machine, asked.modes, rhythm, start, period))


def _told(asked: SelfExcited, found: Settled) -> SelfExcited:
    """What the cycle or the motion in which a machine ends says of it."""
    if found.cycle is None:
        motion = found.motion
        obstacle = _ENDED.get((None if motion is None else motion.ending) or "", Obstacle.IRREGULAR)
        if motion is not None and obstacle is Obstacle.IRREGULAR and motion.strikes_twice:
            obstacle = Obstacle.DOUBLE_BLOW
        if motion is not None and obstacle is Obstacle.NO_PORT:
            edges = [port.behind for port in asked.machine.valve.ports if port.side == "back"]
            beyond = [edge for edge in edges if edge is not None and edge > motion.farthest]
            return replace(asked, obstacle=obstacle, found=motion.farthest, needed=min(beyond, default=None))
        return replace(asked, obstacle=obstacle)
    if not found.cycle.switches:
        return replace(asked, cycle=found.cycle, obstacle=Obstacle.BOUNCES)
    if found.cycle.blows > 1 and found.cycle.stable:
        why = why_more_blows(found.cycle)
        hunts = why is Obstacle.UNEVEN and asked.machine.valve.supply is not None
        return replace(asked, cycle=found.cycle, obstacle=Obstacle.HUNTS if hunts else why)
    return _judged(asked, found.cycle)


_ENDED = {
    "on the wall": Obstacle.ON_THE_WALL,
    "nothing follows": Obstacle.NO_PORT,
    "no blow": Obstacle.NO_BLOW,
    "no pressure": Obstacle.NO_PRESSURE,
}


def _judged(asked: SelfExcited, cycle: ValveCycle) -> SelfExcited:
    """Whether a cycle has room and is stable."""
    if asked.room < math.inf and cycle.stroke > asked.room:
        return replace(asked, cycle=cycle, obstacle=Obstacle.NO_ROOM, found=cycle.stroke, needed=asked.room)
    if cycle.stable:
        return replace(asked, cycle=cycle)
    why = why_unstable(cycle.multiplier)
    if cycle.rebound.pressure is not None:
        constant = under_pressure(asked.machine, cycle.rebound.pressure)
        steady = solved(constant, asked.modes, cycle.rhythm)
        if steady is None or steady.stable:
            why = Obstacle.HUNTS
    return replace(asked, cycle=cycle, obstacle=why, found=abs(cycle.multiplier), needed=1.0)


# ---- Many rigid pistons at once


@dataclass(frozen=True)
class RigidCycles:
    """What many rigid pistons do, as of a `ValveCycle`; shape (n,), NaN where a piston has no cycle of one blow.

    `answered` is False where this has no answer, as with very many orders under way or a supply; `starts` tells if it
    keeps going from rest on the wall, False where nobody asked. Only the modulus of the multiplier is told.
    """

    obstacles: tuple[Obstacle | None, ...]
    answered: npt.NDArray[np.bool_]
    period: Array
    speed: Array
    energy: Array
    stroke: Array
    work: Array
    taken: Array
    duty: Array
    multiplier: Array
    starts: npt.NDArray[np.bool_]


def rigid_cycles(
    machines: Sequence[Machine], rooms: Sequence[float | None] | None = None, *, starts: bool = False
) -> RigidCycles:
    """What `self_excited_motion` tells of each of these machines with a rigid piston, without the flights."""
    # All have as many states and ports; `rooms`: how far behind the wall each can go.
    ensure_cache()
    from percuss.steady.self_excited import cycle_kernels as many  # only here is the compiler needed

    pistons = [Piston(machine) for machine in machines]
    fed = np.array([machine.valve.supply is not None or machine.valve.flows for machine in machines], dtype=bool)
    n = len(pistons)
    does, told = np.full(n, many.UNKNOWN, dtype=np.int64), np.full((n, many.TOLD), np.nan)
    derivatives, begun = np.zeros((n, many.NUMBERS, many.NUMBERS)), np.zeros(n, dtype=np.bool_)
    if n:
        rows, slopes = np.zeros((many.ROWS, many.ROW)), np.zeros((many.SLOPES, many.NUMBERS))
        matrices, tells = np.zeros((many.MATRICES, many.NUMBERS, many.NUMBERS + 1)), np.zeros((many.ROWS, many.TOLD))
        step = np.zeros(many.NUMBERS)
        many.cycles_of(*_packed(pistons), starts, rows, slopes, matrices, tells, step, does, told, derivatives, begun)
    does[fed] = many.UNKNOWN
    limits = np.array([math.inf] * n if rooms is None else [math.inf if room is None else room for room in rooms])
    return _judged_all(machines, does, told.T, derivatives, begun, limits)


def _packed(pistons: Sequence[Piston]) -> tuple[npt.NDArray[np.float64], ...]:
    """Forces, ports, laws and first states as the kernels have them."""
    forces, ports, laws = (np.array([piston.numbers[i] for piston in pistons]) for i in range(3))
    first = [piston.names.index(piston.start.state) for piston in pistons]
    return forces, ports, laws, np.array(first, dtype=float)


def _judged_all(
    machines: Sequence[Machine],
    does: npt.NDArray[np.int64],
    told: Array,
    derivatives: Array,
    begun: npt.NDArray[np.bool_],
    limits: Array,
) -> RigidCycles:
    factor = np.array([machine.contact.velocity_factor for machine in machines])
    lossless = np.array(
        [machine.contact.is_lossless and machine.body.damping.is_zero for machine in machines], dtype=bool
    )
    does, told, begun = np.where(lossless, -1, does), np.where(lossless, np.nan, told), begun & ~lossless
    answered = does < len(OBSTACLES)
    obstacles = [OBSTACLES[code] if known else None for code, known in zip(does, answered, strict=True)]
    period, speed, stroke, rise = told[kn.DURATION], told[kn.SPEED], told[kn.FARTHEST], told[kn.RISE]
    multipliers = np.full((does.size, derivatives.shape[1]), np.nan, dtype=complex)
    there = np.flatnonzero(does == 0)
    multipliers[there] = np.linalg.eigvals(derivatives[there])
    for i in range(len(machines)):
        if lossless[i]:
            obstacles[i] = Obstacle.NO_LOSS
        elif does[i] == 0 and stroke[i] > limits[i]:
            obstacles[i] = Obstacle.NO_ROOM
        elif does[i] == 0 and not np.abs(multipliers[i]).max() < 1.0:
            obstacles[i] = why_unstable(complex(multipliers[i, np.argmax(np.abs(multipliers[i]))]))
    multiplier = np.abs(multipliers).max(axis=1)
    energy = 0.5 * speed**2
    taken = (1.0 - factor**2) * energy
    duty = np.where(rise < 0.0, 0.0, (period - rise) / period)
    return RigidCycles(
        tuple(obstacles), answered, period, speed, energy, stroke, told[kn.WORK], taken, duty, multiplier, begun
    )
