"""The figures of an orbit, each once: what it is called, what it means, how it is found, and its scale to SI.

Tables, JSON, maps, reports and the page all read them from here; none has a formula of its own.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, fields
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

import numpy as np

from percuss.errors import ParameterError
from percuss.short_repr import ShortRepr

if TYPE_CHECKING:
    from percuss.model import System
    from percuss.steady.flight import Energy

_NOTHING = 1e3 * float(np.finfo(float).eps)  # beside the energy of a blow, an input this small is rounding


class Striking(Protocol):
    """What an orbit must have for its figures: of several impacts the strongest's speeds, mean energies; no bounces."""

    @property
    def system(self) -> Any: ...
    @property
    def periods(self) -> float: ...
    @property
    def impacts(self) -> int: ...
    @property
    def period(self) -> float: ...
    @property
    def phase(self) -> float: ...
    @property
    def impact_velocity(self) -> float: ...
    @property
    def rigid_velocity(self) -> float: ...
    @property
    def blow_energy(self) -> float: ...
    @property
    def delivered_energy(self) -> float: ...
    @property
    def energy(self) -> Energy | None: ...
    @property
    def stroke(self) -> float | None: ...
    @property
    def rests(self) -> bool: ...


@dataclass(frozen=True)
class Figure:
    """A figure of an orbit.

    Parameters
    ----------
    label
        What it is called before its value.
    meaning
        The same in a few words more.
    unit
        Its unit in SI without a prefix; "" for a share, "rad" for an angle.
    value
        Of an orbit, dimensionless; None where there is no such figure, as there is no stress without a blow.
    scale
        What makes SI of it, of a system with scales; None for what is the same in SI.
    line
        Whether it has a line of its own in reports.
    """

    label: str
    meaning: str
    unit: str
    value: Callable[[Striking], float | None]
    scale: Callable[[System], float] | None = None
    line: bool = False

    def in_si(self, orbit: Striking) -> float | None:
        """The figure in its unit, of an orbit whose system has scales."""
        found = self.value(orbit)
        return found if found is None or self.scale is None else self.scale(orbit.system) * found


def _efficiency(orbit: Striking) -> float | None:
    """None where nothing is put in and nothing taken (R = 1 without damping), beside the blow's energy."""
    if orbit.energy is None:
        return None
    put_in = orbit.energy.input
    if put_in <= _NOTHING * orbit.blow_energy or not math.isfinite(put_in):
        return None
    return orbit.impacts * orbit.delivered_energy / put_in


def _peak_stress(orbit: Striking) -> float | None:
    """At first contact, with R read as a ratio of impedances: over E (theory §10); None where no waves run."""
    speed, body = orbit.impact_velocity, orbit.system.body
    return 0.5 * orbit.system.contact.impulse * speed / body.s if speed > 0.0 and body.transit_time > 0.0 else None


def _receiving_stress(orbit: Striking) -> float | None:
    """The same force on the greater area of the struck rod, of the same material."""
    stress = _peak_stress(orbit)
    return None if stress is None else orbit.system.contact.impedance_ratio * stress


def _stress_scale(system: System) -> float:
    """ρC of the section that strikes, in Pa per m/s, times a wave's mean speed: E of a uniform bar."""
    bar = system.bar
    if bar is None:
        return system.stress_scale  # which tells of no scales
    struck = bar.pieces[-1]
    return struck.impedance / struck.area * system.speed_scale * system.body.s


def _mean_force(orbit: Striking) -> float | None:
    """Of several impacts by all of them; with a rest, under a clock, that of the load, as nothing else pushes."""
    if orbit.rests:
        return orbit.system.push if hasattr(orbit.system, "push") else None
    whole = np.sum(getattr(orbit, "rigid_velocities", orbit.impacts * orbit.rigid_velocity))
    return float(orbit.system.contact.impulse * whole / orbit.period)


def _speed(system: System) -> float:
    return system.speed_scale


def _force(system: System) -> float:
    return system.force_scale


def _energy(system: System) -> float:
    return system.energy_scale


def _power(system: System) -> float:
    return system.power_scale


FIGURES = {
    "phase": Figure("impact phase", "phase of the load at the impact", "rad", lambda orbit: orbit.phase),
    "impact_velocity": Figure(
        "striking speed", "speed of the striking end just before the blow", "m/s", lambda o: o.impact_velocity, _speed
    ),
    "rigid_velocity": Figure(
        "rigid speed", "striking speed of the rigid motion", "m/s", lambda o: o.rigid_velocity, _speed
    ),
    "blow_energy": Figure(
        "blow energy", "kinetic energy just before the blow, all modes", "J", lambda o: o.blow_energy, _energy
    ),
    "delivered": Figure(
        "energy taken", "energy that the impact takes by R: for the tool, and for what rings on in a stepped bar", "J",
        lambda o: o.delivered_energy, _energy,
    ),
    "blow_rate": Figure(
        "blow rate", "blows in a load period, or in a second", "Hz", lambda o: o.impacts / o.periods,
        lambda one: getattr(one, "frequency", None) or 0.5 / (math.pi * one.time_scale),  # which tells of no scales
    ),
    "power": Figure(
        "percussive power", "blow energy times blow rate; the rebound keeps a part", "W",
        lambda o: o.impacts * o.blow_energy / o.period, _power,
    ),
    "input_power": Figure(
        "input power", "mean of force times speed where the load acts", "W",
        lambda o: None if o.energy is None else o.energy.input / o.period, _power,
    ),
    "efficiency": Figure("efficiency", "power that the impact takes over input power", "", _efficiency),
    "stroke": Figure(
        "stroke", "range of the striking end's position", "m", lambda o: o.stroke, lambda s: s.length_scale, line=True
    ),
    "stress": Figure(
        "peak stress", "compression in the hammer at first contact; dimensionless: over E", "Pa", _peak_stress,
        _stress_scale,
    ),
    "receiving_stress": Figure(
        "peak stress, struck rod", "compression in a rod of the same material", "Pa", _receiving_stress, _stress_scale
    ),
    "contact_time": Figure(
        "contact time", "a wave's way through the bar and back", "s",
        lambda o: 2.0 * o.system.body.transit_time, lambda s: s.time_scale,
    ),
    "mean_force": Figure("mean contact force", "on the wall, over time", "N", _mean_force, _force, line=True),
    "momentum": Figure(
        "momentum", "of the rigid motion at the blow", "N·s", lambda o: o.rigid_velocity,
        lambda s: s.force_scale * s.time_scale, line=True,
    ),
    "impulse": Figure(
        "impulse", "of the contact force of a blow: momentum times 1 + R", "N·s",
        lambda o: o.system.contact.impulse * o.rigid_velocity, lambda s: s.force_scale * s.time_scale, line=True,
    ),
    "drag": Figure(
        "drag coefficient", "force of the damping on the whole bar, over its speed", "N·s/m",
        lambda o: o.system.body.rigid_drag, lambda s: s.force_scale / s.speed_scale,
    ),
    "drag_force": Figure(
        "drag at the striking speed", "of the damping on the whole bar", "N",
        lambda o: o.system.body.rigid_drag * o.rigid_velocity, _force,
    ),
}  # fmt: skip
"""Every figure by the name that maps and programs have for it."""


def figures_of(orbit: Striking) -> dict[str, float | None]:
    """All of them, dimensionless; None where there is none."""
    return {name: figure.value(orbit) for name, figure in FIGURES.items()}


# ---- What an orbit means in SI units (definitions of theory §10)


class Reported(NamedTuple):
    """A field of `SIReport`: its figure, its unit, and the factor to it from the unit of the figure."""

    figure: Figure
    factor: float
    unit: str


def _of(name: str, factor: float = 1.0, unit: str = "", card: bool = True) -> Any:
    """A field that holds a figure in a unit; without `card` reports do not list it."""
    return field(metadata={"is": Reported(FIGURES[name], factor, unit or FIGURES[name].unit), "card": card})


@dataclass(frozen=True)
class SIReport(ShortRepr):
    """An orbit's figures in the units of its field; each name ends in its unit.

    The striking speed is that of the striking end; momentum and mean force belong to the mean motion of the bar, for
    which they are exact. Stress is that of first contact with R read as an impedance ratio; None for a motion whose end
    would be leaving the wall at the impact. Efficiency is None when the load puts nothing in. The drag is that of the
    damping on the whole bar, per velocity, and at the striking speed of the rigid motion.
    """

    blow_energy_J: float = _of("blow_energy")
    delivered_energy_J: float = _of("delivered")
    blow_rate_Hz: float = _of("blow_rate")
    blow_rate_per_min: float = _of("blow_rate", 60.0, "blows/min")
    impact_velocity_m_s: float = _of("impact_velocity")
    percussive_power_kW: float = _of("power", 1e-3, "kW")
    input_power_kW: float = _of("input_power", 1e-3, "kW")
    efficiency: float | None = _of("efficiency")
    stroke_mm: float = _of("stroke", 1e3, "mm")
    peak_stress_MPa: float | None = _of("stress", 1e-6, "MPa")
    receiving_stress_MPa: float | None = _of("receiving_stress", 1e-6, "MPa")
    contact_time_us: float = _of("contact_time", 1e6, "µs")
    mean_force_kN: float = _of("mean_force", 1e-3, "kN")
    momentum_N_s: float = _of("momentum")
    impulse_N_s: float = _of("impulse")
    drag_force_kN: float = _of("drag_force", 1e-3, "kN")
    rigid_velocity_m_s: float = _of("rigid_velocity", card=False)
    drag_N_s_m: float = _of("drag", card=False)


REPORTED: dict[str, Reported] = {one.name: one.metadata["is"] for one in fields(SIReport)}
"""The fields of `SIReport`: which figure each holds, and in which unit."""

CARDS = tuple(one.name for one in fields(SIReport) if one.metadata["card"])
"""What a report shows of them, in order."""


def si_report(orbit: Striking) -> SIReport:
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
    if not isinstance(orbit, ShortRepr) or not hasattr(orbit, "blow_energy"):
        raise ParameterError("orbit", orbit, "an orbit")
    system = orbit.system
    if system.bar is None or system.frequency is None:
        raise ParameterError(
            "system", "dimensionless", "a system made from SI", "use System.from_si for figures in SI units"
        )
    return SIReport(**figures_in_si(orbit, REPORTED))  # type: ignore[arg-type]


def figures_in_si(orbit: Striking, keys: Iterable[str]) -> dict[str, float | None]:
    """Some of the figures of an orbit whose system has scales, by their names in `SIReport`."""
    found: dict[str, float | None] = {}
    for key in keys:
        value = REPORTED[key].figure.in_si(orbit)
        found[key] = None if value is None else REPORTED[key].factor * value
    return found
