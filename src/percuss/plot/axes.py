"""Units on the axes: factors and labels that turn dimensionless results into SI where the system has scales."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from percuss.model import System
    from percuss.model.checks import Array

__all__ = ["Units", "stress_of", "units_of"]


@dataclass(frozen=True)
class Units:
    """What one unit of each quantity is on the axis, and what the axis is called."""

    time: float
    time_label: str
    force: float
    force_label: str
    length: float
    length_label: str
    speed: float
    speed_label: str
    stress_label: str


def units_of(system: System) -> Units:
    """Milliseconds, kilonewtons, millimetres, m/s and megapascals for an SI system; radians and 1 otherwise."""
    if not system.is_si:
        return Units(
            1.0,
            "time after impact [rad]",
            1.0,
            "load p [dimensionless]",
            1.0,
            "gap u(1, t)",
            1.0,
            "velocity of the striking end",
            "strain u_x",
        )
    newtons = system.force_scale
    kilo = max(abs(p) for p in system.load.coefficients) * newtons >= 500.0
    return Units(
        1e3 * system.time_scale,
        "time after impact [ms]",
        newtons / 1e3 if kilo else newtons,
        "force [kN]" if kilo else "force [N]",
        1e3 * system.length_scale,
        "striking end [mm]",
        system.speed_scale,
        "velocity of the striking end [m/s]",
        "stress [MPa]",
    )


def stress_of(system: System, x: Array, strain: Array) -> Array:
    """What `Units.stress_label` names, at the places x: the stress in MPa of an SI system, else the strain itself."""
    return system.stress(x, strain) / 1e6 if system.is_si else strain
