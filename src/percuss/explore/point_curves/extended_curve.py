"""The orbits of a family over two parameters that are all a fold, a flip, a grazing …: equations, way back, tangent.

The unknowns are the impact times, the mean velocity just after the first impact, both parameters in their units, and
what the condition brings, x = (t_1 … t_p, r, λ, μ, …). There is one equation less, so that the solutions are a curve,
which is walked by its arclength as a branch over one parameter is.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from percuss.errors import PercussError
from percuss.explore.continuation.walk import CorrectorFailed, CurvePoint
from percuss.explore.family import Family
from percuss.explore.point_curves.conditions import Condition
from percuss.explore.point_curves.differenced import TwoParameters
from percuss.model import System
from percuss.model.checks import Array
from percuss.steady import PeriodicOrbit

_KEPT = 64
_MOST_STEPS = 16
_CLOSE = 1e-9  # after a step below this, with the derivatives of the place, there is none
_LONGEST = 0.5  # rad


@dataclass(frozen=True)
class ExtendedCurve(TwoParameters):
    """All orbits z=p/n of a family for which a condition holds.

    Parameters
    ----------
    family, names, units
        The systems, both parameters, and by how much each changes for what counts as a step of 1 rad.
    impacts, periods, modes
        p, n and N.
    condition
        What makes the orbits what they are.
    """

    family: Family
    names: tuple[str, str]
    units: tuple[float, float]
    impacts: int
    periods: int
    modes: int
    condition: Condition
    _motions: dict[bytes, PeriodicOrbit] = field(default_factory=dict, repr=False, compare=False)
    _systems: dict[tuple[float, float], System] = field(default_factory=dict, repr=False, compare=False)

    def renewed(self, x: Array) -> ExtendedCurve:
        """The same curve with what belongs to a place on it taken anew."""
        condition = self.condition.renewed(self.motion(x), self.extra(x))
        return self if condition is self.condition else replace(self, condition=condition, _motions={})

    def extra(self, x: Array) -> Array:
        """The unknowns of the condition."""
        return x[self.impacts + 3 :]

    oriented = False  # as conditions are renewed

    @property
    def places(self) -> tuple[int, int]:
        """Which of the unknowns are the parameters."""
        return self.impacts + 1, self.impacts + 2

    def motion(self, x: Array) -> PeriodicOrbit:
        """The motion at a point."""
        p, key = self.impacts, x[: self.impacts + 3].tobytes()
        if key not in self._motions:
            if len(self._motions) > _KEPT:
                self._motions.clear()
            system = self.system_at(x)
            times = self.condition.placed(system, x[:p])
            self._motions[key] = PeriodicOrbit(system, self.periods, tuple(times.tolist()), self.modes, float(x[p]))
        return self._motions[key]

    def residual(self, x: Array) -> Array:
        """The equations: those of the orbit, then the condition; one less than unknowns."""
        orbit = self.motion(x)
        return np.append(orbit.residuals, self.condition.off(orbit, x[: self.impacts], self.extra(x)))

    def settled(self, start: Array) -> CurvePoint:
        """The nearest point of the curve, with a tangent either way; or CorrectorFailed."""
        x = np.array(start)
        try:
            for step in range(1, _MOST_STEPS + 1):
                matrix = self.matrix(x)
                moved = -np.linalg.pinv(matrix) @ self.residual(x)
                if not float(np.abs(moved).max()) <= _LONGEST:
                    break
                x = x + moved
                if float(np.abs(moved).max()) <= _CLOSE:
                    if self.refusal_at(x) is not None:  # by rounding, where a parameter begins
                        x[self.impacts + 1 : self.impacts + 3] = start[self.impacts + 1 : self.impacts + 3]
                    return CurvePoint(x, np.linalg.svd(matrix)[2][-1], step, matrix)
        except (PercussError, np.linalg.LinAlgError) as error:
            raise CorrectorFailed(str(error)) from None
        raise CorrectorFailed("no convergence")
