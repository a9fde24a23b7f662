"""What the cycle of a machine that switches itself means in SI."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from percuss.model import Machine
    from percuss.steady.self_excited import ValveCycle

__all__ = ["MachineFigures", "machine_figures"]


@dataclass(frozen=True)
class MachineFigures:
    """A cycle in SI; with several blows in it, energy and speed are those of the strongest.

    Attributes
    ----------
    delivered_energy_J
        What the blows of a cycle take from the bar, for the tool and what it strikes.
    input_power_kW
        What the valve puts in: pressure times oil flow.
    delivered_power_kW
        The part of it that the blows take; damping and drag take the rest.
    efficiency
        Delivered over input power; the energy of the rebound comes back and is in neither. None without an input.
    oil_per_cycle_cm3, oil_flow_l_per_min
        From the supply, without leakage; None when its pressure is not known.
    blank_energy_J, blank_distance_m
        When the tool is not there: what the piston brings to where the blow would be, and how far the force that then
        acts would let it go; None when nothing stops it.
    contact_time_us
        How long a uniform bar of this length is in contact, one round trip of its waves; the model lets the blow take
        no time.
    """

    blow_energy_J: float
    impact_velocity_m_s: float
    blow_rate_Hz: float
    blow_rate_per_min: float
    stroke_m: float
    delivered_energy_J: float
    input_power_kW: float
    delivered_power_kW: float
    efficiency: float | None
    oil_per_cycle_cm3: float | None
    oil_flow_l_per_min: float | None
    blank_energy_J: float
    blank_distance_m: float | None
    contact_time_us: float


def machine_figures(machine: Machine, cycle: ValveCycle) -> MachineFigures:
    """The figures of a cycle of a machine in SI.

    Raises
    ------
    ParameterError
        When the machine is dimensionless.
    """
    energy, period = machine.energy_scale, cycle.period * machine.time_scale
    rate, work, taken = cycle.blows / period, cycle.work * energy, cycle.taken * energy
    oil = None if machine.pressure is None else cycle.drawn * energy / machine.pressure
    distance = _blank_distance(machine, cycle)
    assert machine.bar is not None
    return MachineFigures(
        blow_energy_J=cycle.blow_energy * energy,
        impact_velocity_m_s=cycle.blow_speed * machine.speed_scale,
        blow_rate_Hz=rate,
        blow_rate_per_min=60.0 * rate,
        stroke_m=cycle.stroke * machine.length_scale,
        delivered_energy_J=taken,
        input_power_kW=work / period / 1e3,
        delivered_power_kW=taken / period / 1e3,
        efficiency=taken / work if work > 0.0 else None,
        oil_per_cycle_cm3=None if oil is None else 1e6 * oil,
        oil_flow_l_per_min=None if oil is None else 6e4 * oil / period,
        blank_energy_J=cycle.blow_energy * energy,
        blank_distance_m=None if distance is None else distance * machine.length_scale,
        contact_time_us=1e6 * machine.bar.contact_duration,
    )


def _blank_distance(machine: Machine, cycle: ValveCycle) -> float | None:
    """How far beyond the wall a piston goes that strikes nothing, E = f x + κ x²/2, when a front port turns it back."""
    valve = machine.valve
    pull, back = max((-valve.force(name), name) for name, _ in valve.pairs)
    if not any(port.to == back and port.side == "front" for port in valve.ports):
        return None
    energy = cycle.blow_energy
    reached: float = pull + (pull * pull + 2.0 * valve.chamber.stiffness * energy) ** 0.5
    return 2.0 * energy / reached if reached > 0.0 else None
