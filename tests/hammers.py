"""One of every kind of hammer, for tests of what all of them share: a new kind joins those by one line here."""

from __future__ import annotations

from typing import NamedTuple

from percuss import Kept, Load, System
from percuss.model import Chamber, External, Machine, Mounted, Port, Reversed, Supply, UniformBar, Valve

PORTS = (Port("power", behind=1.0, side="back", delay=0.05), Port("return", on="impact"))
VALVE = Valve({"return": -0.4, "power": 1.8}, PORTS)
GAS = Valve({"return": -0.3, "power": 1.0}, PORTS, chamber=Chamber(0.0, 1.2))
FAST = Valve({"return": -0.4, "power": 1.8}, (PORTS[0], Port("return", speed=1.6, side="front", delay=0.1)))
FED = Valve({"return": -0.4, "power": 1.8}, PORTS, supply=Supply(0.7, 15.0))
LATE = (Port("power", behind=1.0, side="back", delay=0.3), Port("return", behind=0.2, side="front", delay=0.2))
QUICKENED = Valve({"return": -0.4, "power": 1.8}, LATE, supply=Supply(0.5, 8.0, quickening=0.6))


class Hammer(NamedTuple):
    """A hammer, the elastic modes with which it is followed, and the axes of its maps."""

    what: System | Machine
    modes: int
    axes: tuple[str, ...]


HAMMERS = {
    "smooth": Hammer(System(20.0, 0.0, 0.6, Load.harmonic(0.7, 1.0)), 0, ("restitution=0.3:0.7:4", "mean=0.5:0.9:3")),
    "twins": Hammer(System(1e6, 0.0, 0.6, Load.fourier([0.6, 1.0, 0.5 + 0.8j])), 0, ("s=1e3:1e6:2", "d=0:0.1:4")),
    "elastic": Hammer(System(3.0, 0.1, 0.5, Load.square(1.0, 1.3, 5)), 3, ("kappa=1.1:1.4:4", "restitution=0.1:0.9:3")),
    "structure": Hammer(
        System(Mounted(0.15, dashpot=0.05, gap=0.2), Load.harmonic(0.1, 0.5), Kept(0.6)),
        1,
        ("gap=0.1:0.3:3", "stiffness=0.1:0.2:3"),
    ),
    "machine": Hammer(Machine(UniformBar(20.0), GAS, Kept(0.5)), 0, ("pressure=0.5:1.5:4", "ports[0].delay=0:0.6:3")),
    "elastic machine": Hammer(
        Machine(UniformBar(20.0, External(0.01)), VALVE, Reversed(0.2)), 2, ("restitution=0.1:0.3:3",)
    ),
    "machine that feels its speed": Hammer(
        Machine(UniformBar(20.0, External(0.01)), FAST, Kept(0.3)), 2, ("ports[1].speed=1.4:1.8:3",)
    ),
    "machine on its pump": Hammer(Machine(UniformBar(20.0), FED, Kept(0.2)), 0, ("restitution=0.1:0.3:3",)),
    "machine whose spool feels the pressure": Hammer(
        Machine(UniformBar(20.0, External(0.01)), QUICKENED, Kept(0.2)), 1, ("supply.quickening=0:0.8:3",)
    ),
}
