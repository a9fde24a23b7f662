"""A blow as it is asked for, checked: what strikes what, how fast, under which load, for how long."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np

from percuss.blow.striker import Sections, Striker, rod_sections, striker_sections
from percuss.blow.target import Rod, Target, Wall
from percuss.errors import ParameterError
from percuss.model.checks import Array, callback, count, finite, numbers, positive, several

__all__ = ["MOST_TRANSITS", "Field", "Question"]

MOST_TRANSITS = 20
"""Transit times of the striker for which a blow is followed unless told otherwise."""

LONGEST = 1e6
"""Transit times that a window may have."""

Field = tuple[Callable[[Array], Array], Callable[[Array], Array]]
"""Velocity and compressive force of the striker before the blow, as functions of x from 0 to 1."""


@dataclass(frozen=True)
class Question:
    """What `strike` is asked, in the striker's units; see there."""

    striker: Striker
    target: Target
    velocity: Array | None
    field: Field | None
    load: tuple[tuple[float, float], ...]
    load_at: int
    until: float | None

    @classmethod
    def checked(
        cls, striker: Striker, target: Target, velocity: Any, field: Any, load: Any, load_at: int, until: Any
    ) -> Question:
        """The question, or a ParameterError that says what is wrong with it."""
        sections = striker_sections(striker).impedance.size
        if not isinstance(target, Wall | Rod):
            raise ParameterError("target", target, "a Wall or a Rod")
        steps = _load(load)
        count("load_at", load_at, 0, sections - 1)
        if (velocity is None) == (field is None):
            raise ParameterError("velocity", velocity, "a velocity, or a field of them", "give one of the two")
        speeds = None if velocity is None else _velocities(velocity, sections)
        until = None if until is None else positive("until", until)
        found = cls(striker, target, speeds, _field(field), steps, load_at, until)
        longest = LONGEST * float(found.sections.transit.sum())
        if until is not None and until > longest:
            raise ParameterError("until", until, f"at most {longest:g}, a million transit times of the striker")
        return found

    @cached_property
    def transits(self) -> float:
        """Transit times of the striker that are followed unless told otherwise, and once through the rod and back."""
        rod = np.zeros(0) if self.rod is None else self.rod.transit
        return MOST_TRANSITS + 2.0 * float(rod[np.isfinite(rod)].sum() / self.sections.transit.sum())

    @cached_property
    def sections(self) -> Sections:
        """Of the striker."""
        return striker_sections(self.striker)

    @cached_property
    def rod(self) -> Sections | None:
        """Sections of the rod; None where the target is a wall."""
        return rod_sections(self.target, self.striker) if isinstance(self.target, Rod) else None


def _velocities(given: Any, sections: int) -> Array:
    accepted = f"a number, or one for each of {sections} sections" if sections > 1 else "a number"
    found = np.atleast_1d(numbers("velocity", given, accepted))
    if found.ndim != 1 or found.size not in (1, sections):
        raise ParameterError("velocity", given, accepted)
    return np.array(np.broadcast_to(found, sections))


def _field(given: Any) -> Field | None:
    if given is None:
        return None
    both = several("field", given, "two functions of x: velocity and force")
    if len(both) != 2:
        raise ParameterError("field", given, "two functions of x: velocity and force")
    for one in both:
        callback("field", one)
        if one is None:
            raise ParameterError("field", given, "two functions of x: velocity and force")
    return both[0], both[1]


def _load(given: Any) -> tuple[tuple[float, float], ...]:
    accepted = "pairs (time, force), with times that increase from 0 or later on"
    pairs = [several("load", pair, accepted) for pair in several("load", given, accepted)]
    if any(len(pair) != 2 for pair in pairs):
        raise ParameterError("load", given, accepted)
    found = tuple((finite("load", time), finite("load", force)) for time, force in pairs)
    times = [time for time, _ in found]
    if any(time < 0.0 for time in times) or any(a >= b for a, b in pairwise(times)):
        raise ParameterError("load", given, accepted)
    return found
