"""The contacts of a blow: when the faces were pressed together, with which impulse and which greatest force."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from percuss.blow.course import Course
from percuss.blow.parts import Spell
from percuss.blow.trace import Trace

__all__ = ["centroid", "contacts"]

_GRAZING = 1e-12
"""Share of the greatest impulse below which a contact is rounding, or a touch without force."""


def contacts(course: Course, force: Trace) -> tuple[tuple[Spell, ...], int]:
    """The contacts, in the scales of the blow, and how many touches without an impulse there were besides."""
    turns = [*course.turns, course.end] if course.in_contact else course.turns
    peaks, middle = force.piece_peaks, 0.5 * (force.times[:-1] + force.times[1:])
    found = []
    for begin, end in list(pairwise(turns))[::2]:
        inside = (middle > begin * course.tick) & (middle < end * course.tick)
        impulse = course.sums(2 * course.size, begin, end).plain
        lasting = end == course.end and course.in_contact
        peak = float(peaks[inside].max()) if inside.any() else 0.0
        found.append(Spell(begin * course.tick, None if lasting else end * course.tick, impulse, peak))
    least = _GRAZING * max((spell.impulse for spell in found), default=0.0)
    kept = tuple(spell for spell in found if spell.impulse > least)
    return kept, len(found) - len(kept) + int(course.held.state.now[0].grazes)


def centroid(force: Trace) -> float:
    """∫ N t dt / ∫ N dt, from the time 0 on; NaN without a force."""
    moment = float(np.sum(force.piece_moments + force.times[:-1] * force.piece_integrals))
    impulse = force.integral()
    return moment / impulse if impulse > 0.0 else float("nan")
