"""What an orbit means in SI units (definitions of theory §10)."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import NamedTuple

from percuss.errors import ParameterError
from percuss.model.checks import instance
from percuss.shown import Shown
from percuss.steady.figures import FIGURES, Figure
from percuss.steady.orbit import Orbit

__all__ = ["CARDS", "REPORTED", "Reported", "SIReport", "figures_in_si", "si_report"]


class Reported(NamedTuple):
    """A field of `SIReport`: its figure, its unit, and the factor to it from the unit of the figure."""

    figure: Figure
    factor: float
    unit: str


def _reported(name: str, factor: float = 1.0, unit: str = "") -> Reported:
    return Reported(FIGURES[name], factor, unit or FIGURES[name].unit)


REPORTED = {
    "impact_velocity_m_s": _reported("impact_velocity"),
    "rigid_velocity_m_s": _reported("rigid_velocity"),
    "blow_energy_J": _reported("blow_energy"),
    "delivered_energy_J": _reported("delivered"),
    "blow_rate_Hz": _reported("blow_rate"),
    "blow_rate_per_min": _reported("blow_rate", 60.0, "blows/min"),
    "percussive_power_kW": _reported("power", 1e-3, "kW"),
    "input_power_kW": _reported("input_power", 1e-3, "kW"),
    "efficiency": _reported("efficiency"),
    "stroke_mm": _reported("stroke", 1e3, "mm"),
    "peak_stress_MPa": _reported("stress", 1e-6, "MPa"),
    "receiving_stress_MPa": _reported("receiving_stress", 1e-6, "MPa"),
    "contact_time_us": _reported("contact_time", 1e6, "µs"),
    "mean_force_kN": _reported("mean_force", 1e-3, "kN"),
    "momentum_N_s": _reported("momentum"),
    "drag_N_s_m": _reported("drag"),
    "drag_force_kN": _reported("drag_force", 1e-3, "kN"),
}
"""The fields of `SIReport`: which figure each holds, and in which unit."""

CARDS = (
    "blow_energy_J", "delivered_energy_J", "blow_rate_Hz", "blow_rate_per_min", "impact_velocity_m_s",
    "percussive_power_kW", "input_power_kW", "efficiency", "stroke_mm", "peak_stress_MPa", "receiving_stress_MPa",
    "contact_time_us", "mean_force_kN", "momentum_N_s", "drag_force_kN",
)  # fmt: skip
"""What a report shows of them, in order."""


@dataclass(frozen=True)
class SIReport(Shown):
    """An orbit's figures in the units of its field; each name ends in its unit.

    The striking speed is that of the striking end; momentum and mean force belong to the mean motion of the bar, for
    which they are exact. Stress is that of first contact with R read as an impedance ratio; None for a motion whose end
    would be leaving the wall at the impact. Efficiency is None when the load puts nothing in. The drag is that of the
    damping on the whole bar, per velocity, and at the striking speed of the rigid motion.
    """

    impact_velocity_m_s: float
    rigid_velocity_m_s: float
    blow_energy_J: float
    delivered_energy_J: float
    blow_rate_Hz: float
    blow_rate_per_min: float
    percussive_power_kW: float
    input_power_kW: float
    efficiency: float | None
    stroke_mm: float
    peak_stress_MPa: float | None
    receiving_stress_MPa: float | None
    contact_time_us: float
    mean_force_kN: float
    momentum_N_s: float
    drag_N_s_m: float
    drag_force_kN: float


def si_report(orbit: Orbit) -> SIReport:
    """The figures of an orbit in joules, hertz, metres per second and megapascals.

    Raises
    ------
    ParameterError
        When the orbit's system was made from dimensionless numbers.

    Examples
    --------
    >>> from percuss import Bar, Kept, Load, System, si_report, steady_states
    >>> bar = Bar(length=0.341, diameter=0.049, damping_ratio=1e-4)
    >>> load = Load.harmonic(mean=4.0e3, amplitude=9.0e3, frequency=60.0)
    >>> system = System.from_si(bar, load, Kept(restitution=0.2))
    >>> report = si_report(steady_states(system).orbits[1])
    >>> print(f"{report.blow_energy_J:.0f} J, {report.blow_rate_Hz:.0f} Hz, {report.impact_velocity_m_s:.1f} m/s")
    306 J, 60 Hz, 11.0 m/s
    """
    system = instance("orbit", orbit, Orbit).system
    if system.bar is None or system.frequency is None:
        raise ParameterError(
            "system", "dimensionless", "a system made from SI", "use System.from_si for figures in SI units"
        )
    return SIReport(**figures_in_si(orbit, REPORTED))  # type: ignore[arg-type]


def figures_in_si(orbit: Orbit, keys: Iterable[str]) -> dict[str, float | None]:
    """Some of the figures of an orbit whose system has scales, by their names in `SIReport`."""
    found: dict[str, float | None] = {}
    for key in keys:
        value = REPORTED[key].figure.in_si(orbit)
        found[key] = None if value is None else REPORTED[key].factor * value
    return found
