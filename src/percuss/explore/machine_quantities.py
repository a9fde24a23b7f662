"""What a map can show of machines that switch their own valves."""

from __future__ import annotations

from collections.abc import Mapping

from percuss.explore.family import Family, drives_itself
from percuss.explore.quantities import QUANTITIES, Quantity, single
from percuss.steady.self_excited import Obstacle

__all__ = ["DEFAULT_MACHINE_QUANTITIES", "MACHINE_QUANTITIES", "STALLS", "known_quantities"]

STALLS = ("runs", *(obstacle.value for obstacle in Obstacle))
"""What keeps a machine from running with one blow in a cycle, by number: ``stall`` of a map; 0 when it runs."""


def _of_cycle(name: str, meaning: str, unit: str = "") -> Quantity:
    return single(name, "machine", f"{meaning}; NaN where the machine does not run", unit=unit)


MACHINE_QUANTITIES: dict[str, Quantity] = {
    "stall": single("stall", "machine", f"what keeps the machine from running: {', '.join(STALLS)}, by number", "int8"),
    "runs": single("runs", "machine", "whether it has a stable cycle with one blow", "bool"),
    "starts": single("starts", "machine", "whether it keeps striking when it starts at rest on the wall", "bool"),
    "blow_energy": _of_cycle("blow_energy", "kinetic energy just before the blow, all modes", "J"),
    "rate": _of_cycle("rate", "blows in a second; dimensionless: in a unit of time", "Hz"),
    "speed": _of_cycle("speed", "speed of the striking end just before the blow", "m/s"),
    "stroke": _of_cycle("stroke", "greatest distance of the striking end from the wall", "m"),
    "power": _of_cycle("power", "energy that the blows take, over time", "W"),
    "flow": _of_cycle(
        "flow", "what the valve draws from the supply, over time; dimensionless: over the area that it switches", "m³/s"
    ),
    "efficiency": _of_cycle("efficiency", "energy that the blows take over what the valve puts in"),
    "duty": _of_cycle("duty", "part of the period between the last rise of the force and the blow"),
    "multiplier": single("multiplier", "machine", "modulus of the greatest multiplier of the cycle with one blow"),
    **{name: quantity for name, quantity in QUANTITIES.items() if quantity.group == "blow"},
}
"""Everything that can be asked of a machine that switches its own valve, by name."""

DEFAULT_MACHINE_QUANTITIES = ("stall", "blow_energy", "rate", "stroke")


def known_quantities(family: Family) -> Mapping[str, Quantity]:
    """What can be asked of the systems, or of the machines, of a family."""
    return MACHINE_QUANTITIES if drives_itself(family) else QUANTITIES
