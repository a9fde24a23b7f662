"""The machine that switches its own valve: its cycle, or what keeps it from running."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property

from percuss.errors import ParameterError
from percuss.model import Machine, Valve
from percuss.model.checks import count, instance, positive
from percuss.shown import Shown
from percuss.steady.self_excited.elastic_cycle import ElasticCycle
from percuss.steady.self_excited.elastic_settling import settled_from
from percuss.steady.self_excited.fed_cycle import fed, under_pressure
from percuss.steady.self_excited.obstacle import Obstacle, why_more_blows, why_none, why_several, why_unstable
from percuss.steady.self_excited.piston_records import Piston
from percuss.steady.self_excited.rhythm import Rhythm
from percuss.steady.self_excited.rigid_cycle import RigidCycle
from percuss.steady.self_excited.settled_cycle import continued, followed_legs, settled
from percuss.steady.self_excited.valve_cycle import ValveCycle

__all__ = ["NO_MODES", "SelfExcited", "piston_of", "self_excited_motion"]

_MOST_MODES = 4096
NO_MODES = "the elastic modes of a bar are not followed under a pressure that changes; leave out the supply for them"
"""Why a machine with a supply has a rigid piston."""


@dataclass(frozen=True)
class SelfExcited(Shown):
    """What a machine does that switches its own valve.

    Parameters
    ----------
    machine, modes, room
        What was asked.
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
        return self.cycle is not None and followed_legs(piston_of(self.machine))[-1].ending == "blow"

    def __str__(self) -> str:
        if self.obstacle is None:
            assert self.cycle is not None
            return f"SelfExcited: runs, {self.cycle}"
        found = "" if self.found is None or self.needed is None else f" ({self.found:.6g}, needed {self.needed:.6g})"
        return f"SelfExcited: {self.obstacle.value}{found} — {self.obstacle.remedy}"


def piston_of(machine: Machine) -> Piston:
    """The machine with a rigid piston."""
    return Piston(machine.valve, machine.contact, machine.drag)


def self_excited_motion(
    machine: Machine, *, modes: int = 32, room: float | None = None, near: Rhythm | ValveCycle | None = None
) -> SelfExcited:
    """The cycle of a machine that switches its own valve, or what keeps it from running.

    The units of length and of time are free; the mass is 1. For a rigid piston every flight is closed (parabola,
    exponential or circle), and Newton's method with exact derivatives finds the motion that repeats, for any number of
    ports, states and delays. Its ports are read at the centre of mass wherever they are.

    With a supply the pressure follows the piston, which is rigid then: the flights stay closed, and the pressure at the
    blow is found with the speed. Its multipliers are those of both.

    With elastic modes the unknowns are the times at which ports are passed and blows fall: every mode follows from them
    in closed form. Newton's method starts from the rhythm of the rigid piston. Where that leads to no cycle, or to an
    unstable one, the machine is followed from blow to blow until it settles. Of every cycle it is proved that the bar
    neither strikes nor enters the region of a port in between.

    Parameters
    ----------
    machine
        Body, valve and contact.
    modes
        N, the elastic modes kept; 0 for a rigid piston, which a machine with a supply needs.
    room
        Distance behind the wall that the piston can go; without limit by default.
    near
        With elastic modes: a rhythm near that of the cycle, as of a simulation, or another cycle; by default that of
        the rigid piston.

    Raises
    ------
    ParameterError
        When an argument is none of these.

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
    SelfExcited: runs, RigidCycle: 1 blow, speed 2.12761, period 3.15229, stroke 1.26743, multiplier 0.03876
    >>> print(self_excited_motion(machine))
    SelfExcited: runs, ElasticCycle: 1 blow, speed 2.04435, period 3.15231, stroke 1.27017, multiplier 0.197
    """
    instance("machine", machine, Machine)
    modes = count("modes", modes, least=0, most=_MOST_MODES)
    space = math.inf if room is None else positive("room", room)
    if modes and machine.valve.supply is not None:
        raise ParameterError("modes", modes, "0, a rigid piston, for a machine whose pressure follows it", NO_MODES)
    near = _checked(near, modes, machine.valve)
    piston = piston_of(machine)
    asked = SelfExcited(machine, modes, space, None, None)
    if machine.contact.is_lossless and machine.body.damping.is_zero:
        return replace(asked, obstacle=Obstacle.NO_LOSS)
    if machine.valve.supply is not None:
        return _fed(asked, piston)
    rigid, last = settled(piston) if modes == 0 or near is None else (None, [])
    if modes:
        rhythm = near if near is not None or rigid is None else Rhythm.of_rigid(rigid)
        if rhythm is not None:
            return _elastic(asked, rhythm, rigid)
    if rigid is None:
        return replace(asked, **why_none(piston, last))
    if rigid.blows > 1:
        return replace(asked, cycle=rigid, **why_several(piston, rigid))
    return _judged(asked, rigid)


def _checked(near: object, modes: int, valve: Valve) -> Rhythm | None:
    if near is None:
        return None
    if modes == 0:
        raise ParameterError("near", near, "nothing beside modes=0", "the rigid piston needs no start")
    if isinstance(near, RigidCycle):
        return Rhythm.of_rigid(near)
    if isinstance(near, ElasticCycle):
        return near.rhythm
    rhythm = instance("near", near, Rhythm)
    named = [rhythm.state, rhythm.orders.last, *(to for _, to in rhythm.orders.pending)]
    for state in named:
        valve.force(state)
    if any(port >= len(valve.ports) or valve.ports[port].behind is None for _, port in rhythm.passages):
        raise ParameterError("near", rhythm.passages, "passages of ports that this valve has")
    return rhythm


def _elastic(asked: SelfExcited, rhythm: Rhythm, rigid: RigidCycle | None) -> SelfExcited:
    """What an elastic machine does, from a rhythm on."""
    found = settled_from(asked.machine, asked.modes, rhythm, rigid)
    if found.cycle is None:
        ended = {"on the wall": Obstacle.ON_THE_WALL, "nothing follows": Obstacle.NO_PORT, "no blow": Obstacle.NO_BLOW}
        return replace(asked, obstacle=ended.get(found.ending or "", Obstacle.IRREGULAR))
    if not found.cycle.switches:
        return replace(asked, cycle=found.cycle, obstacle=Obstacle.BOUNCES)
    if found.cycle.blows > 1 and found.cycle.stable:
        return replace(asked, cycle=found.cycle, obstacle=why_more_blows(found.cycle))
    return _judged(asked, found.cycle)


def _fed(asked: SelfExcited, piston: Piston) -> SelfExcited:
    """What a machine does that pump and accumulator feed."""
    cycle, last = fed(piston)
    if cycle is None:
        return replace(asked, **why_none(piston, last))
    if cycle.blows > 1:
        return replace(asked, cycle=cycle, **why_several(piston, cycle))
    judged = _judged(asked, cycle)
    if cycle.stable or judged.obstacle is Obstacle.NO_ROOM:
        return judged
    pressure = cycle.rebound.pressure
    assert pressure is not None
    steady = continued(under_pressure(piston, pressure), cycle.at_constant_pressure)
    return judged if steady is not None and not steady.stable else replace(judged, obstacle=Obstacle.HUNTS)


def _judged(asked: SelfExcited, cycle: ValveCycle) -> SelfExcited:
    """Whether a cycle has room and is stable."""
    if asked.room < math.inf and cycle.stroke > asked.room:
        return replace(asked, cycle=cycle, obstacle=Obstacle.NO_ROOM, found=cycle.stroke, needed=asked.room)
    if not cycle.stable:
        why = why_unstable(cycle.multiplier)
        return replace(asked, cycle=cycle, obstacle=why, found=abs(cycle.multiplier), needed=1.0)
    return replace(asked, cycle=cycle)
