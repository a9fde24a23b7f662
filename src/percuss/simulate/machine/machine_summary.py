"""A machine's motion in short: its cycle, and its label."""

from __future__ import annotations

from dataclasses import dataclass

from percuss.shown import Shown

__all__ = ["MACHINE_OUTCOMES", "STALLS", "MachineCycle", "machine_label"]

STALLS = ("on the tool", "in the chamber", "on a port", "leaves", "without pressure")
"""How a machine stalls: it lies on the wall and no order waits; it swings on the gas of its chamber, with ever
weaker blows or none; the valve switches to and fro at a port without end; it leaves and never comes back; the pressure
of its supply falls to 0. Each is proved."""

MACHINE_OUTCOMES = ("impacts", "time", "periodic", "stalls", "work", "memory", "cancelled")
"""How a simulation of a machine ends; as `OUTCOMES`, but for ``stalls``: nothing can happen any more."""


@dataclass(frozen=True)
class MachineCycle(Shown):
    """A periodic motion that was found.

    Attributes
    ----------
    first
        The number of impacts before the motion is on the cycle to within the tolerance.
    blows
        Main blows in a period.
    valve_cycles
        How often the valve comes to the same state in a period.
    kind
        0: no rest; 1: with rest; 2: with rest at the end of complete chatter.
    period
        In the machine's unit of time.
    energy_lost
        What blows, chatter and rest take in a period, per unit of mass.
    blow_speed
        Striking speed of the strongest blow.
    """

    first: int
    blows: int
    valve_cycles: int
    kind: int
    period: float
    energy_lost: float
    blow_speed: float


def machine_label(ended: str, cycle: MachineCycle | None, wanders: bool) -> str:
    """The motion's name.

    ``runs n/m``, n blows in a valve cycle and m valve cycles until the motion repeats; ``double blow n/m`` with n of 2
    or more; ``runs with rest n/m``; ``cycles without blow``; ``stalls (…)``, see `STALLS`; ``irregular``, or
    ``undecided`` where too little was followed to tell.

    Parameters
    ----------
    ended
        How the simulation ended, one of `STALLS` among them.
    cycle
        The periodic motion, when one was found.
    wanders
        Whether the last changes of the valve do not come near any of the ones before.
    """
    if ended in STALLS:
        return f"stalls ({ended})"
    if cycle is None:
        return "irregular" if wanders else "undecided"
    if cycle.blows == 0:
        return "cycles without blow"
    blows = cycle.blows / cycle.valve_cycles
    numbers = f"{blows:.3g}/{cycle.valve_cycles}"
    if cycle.kind:
        return f"runs with rest {numbers}"
    return f"double blow {numbers}" if blows >= 2.0 else f"runs {numbers}"
