"""The motion at a point of a curve of orbits."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from percuss.model.checks import Array
from percuss.steady import PeriodicOrbit
from percuss.steady.periodic.compiled_passage import compiled_passage
from percuss.steady.periodic.passage import Passage

__all__ = ["FollowedOrbit"]


class FollowedOrbit(PeriodicOrbit):
    """A `PeriodicOrbit` whose states at the impacts are computed by compiled functions, which a walk needs anyway.

    The mean velocity just after the first impact is given.
    """

    @cached_property
    def singular(self) -> tuple[float, float]:
        """det K(1) and det K(−1), each row taken by its length: 0 at a fold, and at a flip."""
        return self._computed[1:]

    @cached_property
    def amplitudes(self) -> Array:
        """The free part of each elastic mode, as it is just before each impact; shape (p, N)."""
        passage, omega = self._passage, self._chain.known.omega
        velocity = (passage.velocity - passage.forced_velocity) / omega
        return np.asarray(np.hypot(passage.displacement - passage.forced, velocity))

    @cached_property
    def _computed(self) -> tuple[Passage, float, float]:
        assert self.rebound is not None
        return compiled_passage(self._chain, np.array(self.times), self.rebound)

    @cached_property
    def _passage(self) -> Passage:
        return self._computed[0]
