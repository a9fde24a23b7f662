"""The orbit that a simulated motion has settled on, in a line."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from percuss.case.answers.numerals import number
from percuss.stability import orbit_multipliers

if TYPE_CHECKING:
    from percuss.steady import PeriodicOrbit

__all__ = ["orbit_in_words"]


def orbit_in_words(orbit: PeriodicOrbit) -> str:
    """Its label, its largest multiplier, and what that means."""
    found = orbit_multipliers(orbit)
    text = f"{orbit.label}, largest multiplier {number(found.largest)}"
    if not found.stable:
        return text
    if found.largest < 0.1:
        return f"{text}: disturbances die out within a cycle"
    cycles = math.ceil(math.log(0.1) / math.log(found.largest))
    return f"{text}: a disturbance dies out to a tenth in {cycles} cycle{'s' if cycles > 1 else ''}"
