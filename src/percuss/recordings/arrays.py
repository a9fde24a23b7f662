"""The kinds of arrays that the series of a recording are kept in."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

__all__ = ["Array", "ComplexArray"]

Array = npt.NDArray[np.float64]
ComplexArray = npt.NDArray[np.complex128]
