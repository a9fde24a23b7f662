"""A system as the kernels take it: one row of numbers; and the arrays that they work in."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any

import numpy as np

from percuss.model import System
from percuss.model.checks import Array
from percuss.steady.resonance import refuse_resonance

__all__ = ["Numbers", "numbers_of"]


@dataclass(frozen=True)
class Numbers:
    """A system with the modes 0 … N in one row, and how many of them there are.

    Parameters
    ----------
    row
        As `percuss.steady.periodic.kernels.layout` says.
    modes, waves, steps
        N; harmonics of the load, or its steps.
    """

    row: Array = field(repr=False)
    modes: int
    waves: int
    steps: int

    def room(self, impacts: int) -> Any:
        """The arrays for orbits with p impacts."""
        from percuss.steady.periodic.kernels.layout import room_for

        return room_for(self.modes, self.waves, self.steps, impacts)


@lru_cache(maxsize=64)
def numbers_of(system: System, modes: int) -> Numbers:
    """The numbers of a system; the last ones are kept. Not to be written into.

    Raises
    ------
    ResonanceError
        When an undamped bar is driven at one of its own frequencies.
    """
    refuse_resonance(system)
    load, contact = system.load, system.contact
    known = system.body.modes(modes, load.at)
    is_free = system.body.is_free
    row = [load.mean, system.push, system.d, contact.strain_factor, contact.velocity_factor]
    row += [float(is_free), system.body.gap]
    for values in (known.omega, known.damping, known.gamma):
        row += values.tolist()
    if load.is_piecewise:
        return Numbers(np.array([*row, *load.breaks, *load.values]), modes, 0, len(load.breaks))
    k = load.harmonics
    p = load.coefficients[k]
    return Numbers(np.array([*row, *k.tolist(), *p.real.tolist(), *p.imag.tolist()]), modes, k.size, 0)
