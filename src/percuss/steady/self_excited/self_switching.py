"""The rigid piston that switches its own valve: its cycle, or what keeps it from running."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property

from percuss.model import Contact, Valve
from percuss.model.checks import instance, non_negative, positive
from percuss.shown import Shown
from percuss.steady.self_excited.obstacle import Obstacle, why_none, why_several
from percuss.steady.self_excited.piston_records import Piston
from percuss.steady.self_excited.settled_cycle import followed_legs, settled
from percuss.steady.self_excited.valve_cycle import ValveCycle

__all__ = ["SelfExcited", "self_excited_motion"]


@dataclass(frozen=True)
class SelfExcited(Shown):
    """What a rigid piston does that switches its own valve.

    Parameters
    ----------
    valve, contact, drag, room
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

    valve: Valve
    contact: Contact
    drag: float
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
        return self.cycle is not None and followed_legs(self.piston)[-1].ending == "blow"

    @property
    def piston(self) -> Piston:
        """What moves."""
        return Piston(self.valve, self.contact, self.drag)

    def __str__(self) -> str:
        if self.obstacle is None:
            assert self.cycle is not None
            return f"SelfExcited: runs, {self.cycle}"
        found = "" if self.found is None or self.needed is None else f" ({self.found:.6g}, needed {self.needed:.6g})"
        return f"SelfExcited: {self.obstacle.value}{found} — {self.obstacle.remedy}"


def self_excited_motion(valve: Valve, contact: Contact, drag: float = 0.0, room: float | None = None) -> SelfExcited:
    """The cycle of a rigid piston that switches its own valve, in closed form, or what keeps it from running.

    The units of length and of time are free; the mass is 1. Every flight is closed (parabola, exponential or circle),
    and Newton's method with exact derivatives finds the motion that repeats, for any number of ports, states and
    delays. Ports are read at the centre of mass wherever they are, as the piston is rigid.

    Parameters
    ----------
    valve
        States, ports, chamber.
    contact
        How the piston leaves the wall.
    drag
        d of a drag that is proportional to the speed (dimensionless).
    room
        Distance behind the wall that the piston can go; without limit by default.

    Raises
    ------
    ParameterError
        When an argument is none of these.

    Notes
    -----
    Without delay and drag the square of the blow speed is 2 Σ Δ_i x_i/(1 − R²), with Δ_i the jump of the force at the
    distance x_i behind the wall, and the multiplier is R².

    Examples
    --------
    >>> from percuss.model import Kept, Port, Valve
    >>> ports = [Port("power", behind=1.0, side="back"), Port("return", on="impact")]
    >>> print(self_excited_motion(Valve({"return": -0.4, "power": 1.8}, ports), Kept(0.2)))
    SelfExcited: runs, ValveCycle: 1 blow, speed 2.14087, period 3.14892, stroke 1.27315, multiplier 0.04
    """
    instance("valve", valve, Valve)
    instance("contact", contact, Contact)
    drag = non_negative("drag", drag)
    space = math.inf if room is None else positive("room", room)
    piston = Piston(valve, contact, drag)
    asked = SelfExcited(valve, contact, drag, space, None, None)
    if drag == 0.0 and contact.velocity_factor == -1.0:
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
