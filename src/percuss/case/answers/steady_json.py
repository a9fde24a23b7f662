"""Steady motions in plain values with the names that other programs read; every number finite or null."""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from percuss.case.answers.json_values import number, numbers, plain
from percuss.steady.figures import FIGURES

if TYPE_CHECKING:
    from percuss.case.answers.timed_answer import TimedAnswer
    from percuss.model import Contact
    from percuss.stability import Reduced, Stability, Waveform
    from percuss.steady import Drag, Orbit, Rest, SIReport, SteadyStates

__all__ = [
    "orbit_dict",
    "period_dict",
    "reduced_dict",
    "rest_dict",
    "rest_note",
    "waveform_dict",
    "with_blow",
]


def rest_note(rest: Rest, contact: Contact) -> str:
    """What a possible rest leaves open of motions that fall onto the wall; empty under a law that keeps the strain.

    Seen in simulations of uniform bars under loads that never pull: at s = 20 the bar bounces on from R = 0.7 up, at
    s = 200 from R = 0.65, at s = 2 at no R. A chatter of small bounces ends at rest under either law.
    """
    if not rest.possible or contact.strain_factor == 1.0:
        return ""
    return (
        "As the impact turns the strain over, a bar that falls onto the wall may bounce on without end and never come "
        "to rest, in particular a stiff one with a large restitution; the random starts show whether it does"
    )


def rest_dict(rest: Rest, contact: Contact) -> dict[str, Any]:
    """Whether the bar can lie on the wall for all time."""
    return {
        "possible": bool(rest.possible),
        "least_contact_force": number(rest.least_contact_force),
        "phase": number(rest.phase),
        "quasi_static": number(rest.quasi_static),
        "lifted_by_waves": bool(rest.lifted_by_waves),
        "held_by_waves": bool(rest.held_by_waves),
        "note": rest_note(rest, contact),
    }


def period_dict(states: SteadyStates, orbits: list[dict[str, Any]], greatest_drag: float | None) -> dict[str, Any]:
    """What exists with one impact in so many load periods, with the orbits as `orbit_dict` has them."""
    nearest = states.nearest
    return {
        "m": int(states.periods),
        "level": number(states.level),
        "level_max": number(states.level_max),
        "exists": bool(states.exists),
        "orbits": orbits,
        "nearest": None
        if nearest is None
        else {
            "load_factor": number(nearest.load_factor),
            "restitution": number(nearest.restitution),
            "d": number(greatest_drag),
        },
        "note": states.note,
    }


def orbit_dict(orbit: Orbit, judged: Stability, drag: Drag, si: SIReport | None) -> dict[str, Any]:
    """One steady motion: the orbit, its stability, its drag and, for a case in SI, its figures."""
    violation, energy = orbit.violation, orbit.energy
    return {
        **plain({name: FIGURES[name].value(orbit) for name in ("phase", "impact_velocity", "rigid_velocity")}),
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
        "reduced": reduced_dict(judged.reduced),
        "multipliers": {
            "modes": int(judged.multipliers.modes),
            "largest": number(judged.multipliers.largest),
            "moduli": numbers(judged.multipliers.moduli),
            "dominant_mode": int(judged.multipliers.dominant_mode),
            "rigid": list(judged.multipliers.rigid),
            "ringing_mode": int(judged.multipliers.ringing_mode),
        },
        "disagreement": judged.disagreement,
        "waveform": waveform_dict(judged.waveform),
        "energy": {
            "input": number(energy.input),
            "damping": number(energy.damping),
            "impact": number(energy.impact),
            "imbalance": number(energy.imbalance),
        },
        "drag": plain(asdict(drag)),
        "si": None if si is None else plain(asdict(si)),
        "warnings": list(orbit.warnings),
    }


def with_blow(told: dict[str, Any], timed: TimedAnswer | None) -> dict[str, Any]:
    """A motion of B77's law with the phase of the motion that continues it when its blows take time; None for none."""
    phase = told["phase"] if timed is None else number(timed.orbit.phase)
    blow = {"blow_multipliers": None, "advance_per_blow": None} if timed is None else timed.in_orbit
    return {**told, "phase": phase, "phase_b77": told["phase"], **blow}


_WAVEFORM = ("ratio", "lower", "upper", "stable", "force", "force_lower", "force_upper", "restitution_needed")


def waveform_dict(waveform: Waveform) -> dict[str, Any]:
    """The waveform criterion (theory §11)."""
    return plain({name: getattr(waveform, name) for name in _WAVEFORM})


def reduced_dict(reduced: Reduced) -> dict[str, Any]:
    """B77's reduced criterion, with the other side of a jump of the load where there is one."""
    other = reduced.other_side
    found = {
        "sigma": number(reduced.sigma),
        "a": numbers(reduced.a),
        "schur": numbers(reduced.schur),
        "moduli": numbers(reduced.moduli),
        "stable": bool(reduced.stable),
    }
    return found if other is None else {**found, "other_side": reduced_dict(other)}
