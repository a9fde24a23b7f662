"""What an orbit means in SI units (definitions of theory §10)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from percuss.errors import ParameterError
from percuss.model.checks import instance
from percuss.shown import Shown
from percuss.steady.orbit import Orbit

__all__ = ["SIReport", "si_report"]

_NOTHING = 1e3 * float(np.finfo(float).eps)  # beside the energy of a blow, an input this small is rounding


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
    bar, r = system.bar, system.restitution
    speed = system.speed_scale * orbit.impact_velocity
    rigid = system.speed_scale * orbit.rigid_velocity
    energy, rate = system.energy_scale * orbit.blow_energy, system.frequency / orbit.periods
    put_in = system.energy_scale * orbit.energy.input
    delivered = system.energy_scale * orbit.delivered_energy
    struck = bar.pieces[-1]
    wave = 1e-6 * struck.impedance / struck.area * speed / 2.0 if speed > 0.0 else None
    return SIReport(
        impact_velocity_m_s=speed,
        rigid_velocity_m_s=rigid,
        blow_energy_J=energy,
        delivered_energy_J=delivered,
        blow_rate_Hz=rate,
        blow_rate_per_min=60.0 * rate,
        percussive_power_kW=1e-3 * energy * rate,
        input_power_kW=1e-3 * put_in * rate,
        efficiency=_ratio(delivered, put_in, energy),
        stroke_mm=1e3 * system.length_scale * orbit.stroke,
        peak_stress_MPa=None if wave is None else wave * (1.0 + r),
        receiving_stress_MPa=None if wave is None else wave * (1.0 - r),
        contact_time_us=1e6 * bar.contact_duration,
        mean_force_kN=1e-3 * bar.mass * rigid * (1.0 + r) * rate,
        momentum_N_s=bar.mass * rigid,
        drag_N_s_m=bar.rigid_drag,
        drag_force_kN=1e-3 * bar.rigid_drag * rigid,
    )


def _ratio(delivered: float, put_in: float, blow: float) -> float | None:
    """Efficiency; None where nothing is put in and nothing taken (R = 1 without damping), beside the blow's energy."""
    if put_in <= _NOTHING * blow or not math.isfinite(put_in):
        return None
    return delivered / put_in
