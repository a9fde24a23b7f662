"""The answer of a structure that is held while a value is being moved: its motions with one impact, and verdicts."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from percuss.case.answers.json_values import number
from percuss.case.answers.structure_answer import StructureMotion, structure_answer

if TYPE_CHECKING:
    from percuss.case.case import Case

__all__ = ["quick_structure_dict"]


def quick_structure_dict(case: Case, periods: int = 1) -> dict[str, Any]:
    """All motions of a structure with one impact in `periods` load periods, in the form of `quick_dict`.

    What that has of a free bar alone is null: both criteria, the margins of rhythm and ringing, the nearest motion.

    Raises
    ------
    ParameterError
        For a case of a free bar.
    LoadError, ResonanceError, CaseError
        As `structure_answer`.

    Examples
    --------
    >>> from percuss.case import Case
    >>> tables = '''
    ... [body]
    ... kind = "mounted"
    ... spring = 0.25
    ... [system]
    ... restitution = 0.8
    ... [load]
    ... kind = "harmonic"
    ... mean = 0.0
    ... amplitude = 0.25
    ... '''
    >>> [motion["reason"] for motion in quick_structure_dict(Case.from_text(tables))["orbits"]]
    ['stable', 'stable']
    """
    answer = structure_answer(case, (periods,))
    states, load = answer.states[0], answer.system.load
    return {
        "m": int(states.periods),
        "level": number(states.level),
        "level_max": number(states.level_max),
        "exists": bool(states.exists),
        "nearest": None,
        "note": states.note or "The contact comes nowhere near the wall.",
        "clocked": "",
        "load_factor": number(load.load_factor),
        "restitution": number(answer.system.restitution),
        "orbits": [_motion(one) for one in answer.motions[0]],
        "curve": None,
    }


def _motion(one: StructureMotion) -> dict[str, Any]:
    orbit, found = one.orbit, one.multipliers
    told = one.to_json_dict()
    si = {name: told.get(name) for name in ("impact_velocity_m_s", "blow_energy_J")} if orbit.system.is_si else None
    words = "stable" if one.stable else f"unstable: largest multiplier {found.largest:.3g}"
    return {
        **{name: told[name] for name in ("phase", "impact_velocity", "blow_energy", "fold", "stable")},
        "margin": number(1.0 - found.largest),
        "margin_rhythm": None,
        "margin_ringing": None,
        "reason": words,
        "reduced": None,
        "waveform": None,
        "multipliers": {
            "modes": int(found.modes),
            "largest": number(found.largest),
            "dominant_mode": int(found.dominant_mode),
            "rigid": None,
            "values": told["multipliers"],
        },
        "si": si,
    }
