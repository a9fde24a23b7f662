"""What damping makes of elastic modes: which of them swing, and how fast."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from percuss.model.checks import Array

__all__ = ["DampedModes"]

# A mode with d_n/2 beyond this part of ω_n is treated as if overdamped: its amplitude and phase lose their meaning
_NEARLY_OVERDAMPED = 0.95


class DampedModes:
    """Elastic modes with frequencies ω_n and damping d_n, which those who inherit give: as fields, or computed."""

    if TYPE_CHECKING:  # a property here would be in the way of a field

        @property
        def omega(self) -> Array: ...
        @property
        def damping(self) -> Array: ...

    @cached_property
    def square(self) -> Array:
        """λ_n² = ω_n² − d_n²/4, negative where overdamped; shape (N,)."""
        half = 0.5 * self.damping
        return np.asarray((self.omega - half) * (self.omega + half))

    @cached_property
    def lam(self) -> Array:
        """λ_n, and 1 where overdamped; shape (N,)."""
        return np.sqrt(np.where(self.square > 0.0, self.square, 1.0))

    @cached_property
    def creeps(self) -> npt.NDArray[np.bool_]:
        """Which modes are overdamped or nearly so: the kernels keep their state in another form; shape (N,)."""
        return np.asarray(0.5 * self.damping > _NEARLY_OVERDAMPED * self.omega)
