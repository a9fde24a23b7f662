"""The motion at a point of a curve of orbits."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from percuss.steady import PeriodicOrbit
from percuss.steady.periodic.compiled_passage import compiled_passage
from percuss.steady.periodic.passage import Passage

__all__ = ["FollowedOrbit"]


class FollowedOrbit(PeriodicOrbit):
    """A `PeriodicOrbit` whose states at the impacts are computed by compiled functions, which a walk needs anyway."""

    @cached_property
    def _passage(self) -> Passage:
        if self.rebound is None:
            return self._passage_on("right")
        return compiled_passage(self._chain, np.array(self.times), self.rebound)
