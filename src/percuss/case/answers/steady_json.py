"""An answer in plain values with the names that other programs read; every number finite or null."""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from percuss.case.answers.json_values import body_dict, contact_dict, number, numbers, plain, system_dict

if TYPE_CHECKING:
    from percuss.case.answers.steady_answer import OrbitAnswer, PeriodAnswer, SteadyAnswer
    from percuss.stability import Reduced

__all__ = ["answer_dict"]


def answer_dict(answer: SteadyAnswer) -> dict[str, Any]:
    """The JSON object of an answer: a tree of dict, list, str, bool, int, finite float and None."""
    rest = answer.rest
    return {
        "case": answer.name,
        "title": answer.title,
        "system": system_dict(answer.system),
        "body": body_dict(answer.system),
        "contact": contact_dict(answer.system),
        "history": None if answer.history is None else plain(asdict(answer.history)),
        "notes": list(answer.notes),
        "periods": [_period(period) for period in answer.periods],
        "rest": {
            "possible": bool(rest.possible),
            "least_contact_force": number(rest.least_contact_force),
            "phase": number(rest.phase),
            "quasi_static": number(rest.quasi_static),
            "lifted_by_waves": bool(rest.lifted_by_waves),
            "held_by_waves": bool(rest.held_by_waves),
        },
        "starts": plain(answer.starts.to_json_dict(answer.system)),
    }


def _period(period: PeriodAnswer) -> dict[str, Any]:
    states = period.states
    nearest = states.nearest
    return {
        "m": int(states.periods),
        "level": number(states.level),
        "level_max": number(states.level_max),
        "exists": bool(states.exists),
        "orbits": [_orbit(answer) for answer in period.orbits],
        "nearest": None
        if nearest is None
        else {
            "load_factor": number(nearest.load_factor),
            "restitution": number(nearest.restitution),
            "d": number(period.greatest_drag),
        },
        "note": states.note,
    }


def _orbit(answer: OrbitAnswer) -> dict[str, Any]:
    orbit, judged = answer.orbit, answer.stability
    violation, waveform, energy = orbit.violation, judged.waveform, orbit.energy
    return {
        "phase": number(orbit.phase),
        "impact_velocity": number(orbit.impact_velocity),
        "rigid_velocity": number(orbit.rigid_velocity),
        "modes": int(orbit.modes),
        "error_bound": number(orbit.error_bound),
        "proven": bool(orbit.proven),
        "admissible": bool(orbit.admissible),
        "violation": None if violation is None else {"time": number(violation.time), "depth": number(violation.depth)},
        "stable": bool(judged.stable),
        "reason": judged.reason,
        "margin": number(judged.margin),
        "margin_rhythm": number(judged.margin_rhythm),
        "margin_ringing": number(judged.margin_ringing),
        "reduced": _reduced(judged.reduced),
        "multipliers": {
            "modes": int(judged.multipliers.modes),
            "largest": number(judged.multipliers.largest),
            "moduli": numbers(judged.multipliers.moduli),
            "dominant_mode": int(judged.multipliers.dominant_mode),
            "rigid": list(judged.multipliers.rigid),
            "ringing_mode": int(judged.multipliers.ringing_mode),
        },
        "disagreement": judged.disagreement,
        "waveform": plain({name: getattr(waveform, name) for name in _WAVEFORM}),
        "energy": {
            "input": number(energy.input),
            "damping": number(energy.damping),
            "impact": number(energy.impact),
            "imbalance": number(energy.imbalance),
        },
        "drag": plain(asdict(answer.drag)),
        "si": None if answer.si is None else plain(asdict(answer.si)),
        "warnings": list(orbit.warnings),
    }


_WAVEFORM = ("ratio", "lower", "upper", "stable", "force", "force_lower", "force_upper", "restitution_needed")


def _reduced(reduced: Reduced) -> dict[str, Any]:
    other = reduced.other_side
    found = {
        "sigma": number(reduced.sigma),
        "a": numbers(reduced.a),
        "schur": numbers(reduced.schur),
        "moduli": numbers(reduced.moduli),
        "stable": bool(reduced.stable),
    }
    return found if other is None else {**found, "other_side": _reduced(other)}
