"""One blow in plain values."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from percuss.case.answers.json_values import plain

if TYPE_CHECKING:
    from percuss.blow import Peak
    from percuss.case.answers.told_blow import ToldBlow

__all__ = ["blow_dict"]

_ALWAYS = (
    "striker_mass",
    "mean_velocity_before",
    "mean_velocity_after",
    "striker_momentum_after",
    "impulse",
    "effective_restitution",
    "restitution_from_impulse",
    "contact_duration",
    "force_centroid",
    "gap_after",
    "energy_before",
    "kinetic_energy_before",
    "load_work",
    "rigid_energy_after",
    "vibration_energy_after",
    "work_through_face",
)
_OF_ROD = {
    "rod_energy_after": "rod_energy",
    "rod_momentum_after": "rod_momentum",
    "bit_kinetic_energy_after": "bit_kinetic_energy_after",
}
_OF_ROCK = {
    "rock_work": "rock_work",
    "rock_work_dissipated": "rock_dissipated",
    "rock_work_stored": "rock_stored",
    "efficiency": "efficiency",
    "efficiency_with_rebound": "efficiency_with_rebound",
    "greatest_penetration": "greatest_penetration",
    "residual_penetration": "residual_penetration",
    "penetration_after": "penetration_after",
}


def blow_dict(answer: ToldBlow) -> dict[str, Any]:
    """The answer as JSON has it: SI units, or the scales of a dimensionless bar (mass, length, frequency 1)."""
    blow = answer.blow
    told: dict[str, Any] = {
        "case": answer.name,
        "title": answer.title,
        "units": "SI" if answer.is_si else "dimensionless",
        "notes": list(answer.notes),
        "velocity": None if blow.velocity is None else blow.velocity.tolist(),
        "velocity_from": answer.speed,
        "until": blow.until,
        "outcome": blow.outcome.name.lower(),
        "outcome_in_words": blow.outcome.value,
        "contacts": [[one.start, one.end, one.impulse, one.peak_force] for one in blow.contacts],
        "touches_without_impulse": blow.grazes,
    }
    told |= {name: getattr(blow, name) for name in _ALWAYS}
    if answer.rod is not None:
        told |= {name: getattr(blow, source) for name, source in _OF_ROD.items()}
        told |= _rod_dict(answer)
    if blow.penetration is not None and blow.bit_force is not None:
        told |= {name: getattr(blow, source) for name, source in _OF_ROCK.items()}
        told["greatest_rock_force"] = blow.bit_force.peak
        told["beta"] = answer.beta
    if answer.measured is not None:
        told["measured"] = answer.measured.to_json_dict()
    told |= _stress_dict(answer)
    told |= {"momentum_error": blow.momentum_error, "energy_error": blow.energy_error}
    found: dict[str, Any] = plain(told)
    return found


def _rod_dict(answer: ToldBlow) -> dict[str, Any]:
    """The first pulse, and the waves at the gauge."""
    pulse, waves = answer.blow.first_pulse, answer.waves
    assert waves is not None  # there is a rod
    names = ("length", "rise", "peak", "energy", "momentum")
    return {
        "first_pulse": None if pulse is None else {name: getattr(pulse, name) for name in names},
        "gauge": {
            "place": answer.gauge,
            "impedance": waves.impedance,
            "incident_energy": waves.incident_energy,
            "reflected_energy": waves.reflected_energy,
            "tool_energy": waves.tool_energy,
        },
    }


def _stress_dict(answer: ToldBlow) -> dict[str, Any]:
    """The greatest compression and tension of each section: stress, or force of a dimensionless bar."""
    kind = "stress" if answer.is_si else "force"
    own, rod = answer.peaks
    found = {
        f"peak_compressive_{kind}": [peak.compression for peak in own],
        f"peak_tensile_{kind}": [peak.tension for peak in own],
        "peaks_of_striker": [_peak_dict(peak) for peak in own],
    }
    return found | ({"peaks_of_rod": [_peak_dict(peak) for peak in rod]} if rod else {})


def _peak_dict(peak: Peak) -> dict[str, Any]:
    names = ("compression", "compression_place", "compression_time", "tension", "tension_place", "tension_time")
    return {name: getattr(peak, name) for name in names}
