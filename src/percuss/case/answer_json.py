"""An answer in plain values with the names that other programs read; every number finite or null."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from percuss.case.answer import OrbitAnswer, PeriodAnswer, SteadyAnswer
    from percuss.stability import Reduced

__all__ = ["answer_dict"]


def answer_dict(answer: SteadyAnswer) -> dict[str, Any]:
    """The JSON object of an answer: a tree of dict, list, str, bool, int, finite float and None."""
    system, rest = answer.system, answer.rest
    return {
        "case": answer.name,
        "title": answer.title,
        "system": {
            "s": _number(system.s),
            "d": _number(system.d),
            "restitution": _number(system.restitution),
            "coefficients": [[_number(p.real), _number(p.imag)] for p in system.load.coefficients.tolist()],
            "load_factor": _number(system.load.load_factor),
        },
        "history": None if answer.history is None else _plain(asdict(answer.history)),
        "notes": list(answer.notes),
        "periods": [_period(period) for period in answer.periods],
        "rest": {
            "possible": bool(rest.possible),
            "least_contact_force": _number(rest.least_contact_force),
            "phase": _number(rest.phase),
            "quasi_static": _number(rest.quasi_static),
        },
    }


def _period(period: PeriodAnswer) -> dict[str, Any]:
    states = period.states
    nearest = states.nearest
    return {
        "m": int(states.periods),
        "level": _number(states.level),
        "level_max": _number(states.level_max),
        "exists": bool(states.exists),
        "orbits": [_orbit(answer) for answer in period.orbits],
        "nearest": None
        if nearest is None
        else {"load_factor": _number(nearest.load_factor), "restitution": _number(nearest.restitution)},
        "note": states.note,
    }


def _orbit(answer: OrbitAnswer) -> dict[str, Any]:
    orbit, judged = answer.orbit, answer.stability
    violation, waveform, energy = orbit.violation, judged.waveform, orbit.energy
    return {
        "phase": _number(orbit.phase),
        "impact_velocity": _number(orbit.impact_velocity),
        "rigid_velocity": _number(orbit.rigid_velocity),
        "modes": int(orbit.modes),
        "error_bound": _number(orbit.error_bound),
        "proven": bool(orbit.proven),
        "admissible": bool(orbit.admissible),
        "violation": None
        if violation is None
        else {"time": _number(violation.time), "depth": _number(violation.depth)},
        "stable": bool(judged.stable),
        "reason": judged.reason,
        "margin": _number(judged.margin),
        "reduced": _reduced(judged.reduced),
        "multipliers": {
            "modes": int(judged.multipliers.modes),
            "largest": _number(judged.multipliers.largest),
            "moduli": _numbers(judged.multipliers.moduli),
            "dominant_mode": int(judged.multipliers.dominant_mode),
        },
        "disagreement": judged.disagreement,
        "waveform": _plain({name: getattr(waveform, name) for name in _WAVEFORM}),
        "energy": {
            "input": _number(energy.input),
            "damping": _number(energy.damping),
            "impact": _number(energy.impact),
            "imbalance": _number(energy.imbalance),
        },
        "si": None if answer.si is None else _plain(asdict(answer.si)),
        "warnings": list(orbit.warnings),
    }


_WAVEFORM = ("ratio", "lower", "upper", "stable", "force", "force_lower", "force_upper", "restitution_needed")


def _reduced(reduced: Reduced) -> dict[str, Any]:
    other = reduced.other_side
    found = {
        "sigma": _number(reduced.sigma),
        "a": _numbers(reduced.a),
        "schur": _numbers(reduced.schur),
        "moduli": _numbers(reduced.moduli),
        "stable": bool(reduced.stable),
    }
    return found if other is None else {**found, "other_side": _reduced(other)}


def _number(value: Any) -> float | int | None:
    """A finite number as Python has it, or None."""
    if value is None:
        return None
    if isinstance(value, int):
        return int(value)
    number = float(value)
    return number if math.isfinite(number) else None


def _numbers(values: Iterable[Any]) -> list[float | int | None]:
    return [_number(value) for value in values]


def _plain(values: dict[str, Any]) -> dict[str, Any]:
    """Numbers made finite or None; text, truth values, tuples of text and None as they are."""
    return {key: _plain_value(value) for key, value in values.items()}


def _plain_value(value: Any) -> Any:
    if isinstance(value, tuple | list):
        return [_plain_value(item) for item in value]
    if isinstance(value, str):
        return value
    return bool(value) if _is_bool(value) else _number(value)


def _is_bool(value: Any) -> bool:
    return type(value).__name__ in ("bool", "bool_")
