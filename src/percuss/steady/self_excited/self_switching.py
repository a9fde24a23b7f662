"""The machine that switches its own valve: its cycle, or what keeps it from running."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property

from percuss.model import Machine
from percuss.model.checks import count, instance, positive
from percuss.shown import Shown
from percuss.steady.self_excited.obstacle import Obstacle, why_none, why_several
from percuss.steady.self_excited.piston_records import Piston
from percuss.steady.self_excited.settled_cycle import followed_legs, settled
from percuss.steady.self_excited.valve_cycle import ValveCycle

__all__ = ["SelfExcited", "piston_of", "self_excited_motion"]

_MOST_MODES = 4096


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


def self_excited_motion(machine: Machine, *, modes: int = 32, room: float | None = None) -> SelfExcited:
    """The cycle of a machine that switches its own valve, or what keeps it from running.

    The units of length and of time are free; the mass is 1. For a rigid piston every flight is closed (parabola,
    exponential or circle), and Newton's method with exact derivatives finds the motion that repeats, for any number of
    ports, states and delays. Its ports are read at the centre of mass wherever they are.

    Parameters
    ----------
    machine
        Body, valve and contact.
    modes
        N, the elastic modes kept; 0 for a rigid piston.
    room
        Distance behind the wall that the piston can go; without limit by default.

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
    >>> from percuss.model import Kept, Machine, Port, UniformBar, Valve
    >>> ports = [Port("power", behind=1.0, side="back"), Port("return", on="impact")]
    >>> machine = Machine(UniformBar(20.0), Valve({"return": -0.4, "power": 1.8}, ports), Kept(0.2))
    >>> print(self_excited_motion(machine, modes=0))
    SelfExcited: runs, RigidCycle: 1 blow, speed 2.14087, period 3.14892, stroke 1.27315, multiplier 0.04
    """
    instance("machine", machine, Machine)
    modes = count("modes", modes, least=0, most=_MOST_MODES)
    space = math.inf if room is None else positive("room", room)
    piston = piston_of(machine)
    asked = SelfExcited(machine, modes, space, None, None)
    if piston.drag == 0.0 and piston.contact.velocity_factor == -1.0:
        return replace(asked, obstacle=Obstacle.NO_LOSS)
    cycle, last = settled(piston)
    if cycle is None:
        return replace(asked, **why_none(piston, last))
    if cycle.blows > 1:
        return replace(asked, cycle=cycle, **why_several(piston, cycle))
    if cycle.stroke > space:
        return replace(asked, cycle=cycle, obstacle=Obstacle.NO_ROOM, found=cycle.stroke, needed=space)
    if not cycle.stable:
        return replace(asked, cycle=cycle, obstacle=Obstacle.FLIP, found=abs(cycle.multiplier), needed=1.0)
    return replace(asked, cycle=cycle)
