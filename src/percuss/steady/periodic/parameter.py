"""How an orbit moves with a parameter: the column of the parameter beside the matrix of the times."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from percuss.errors import ParameterError, PercussError
from percuss.model import System
from percuss.model.checks import Array, finite, instance
from percuss.steady.periodic.periodic_orbit import PeriodicOrbit

__all__ = ["parameter_column", "time_rates"]

_STEP = 1e-6  # of the parameter, relative where that is large


def parameter_column(orbit: PeriodicOrbit, family: Callable[[float], System], value: float) -> Array:
    """∂F/∂λ at fixed times of the impacts, by central differences: exact to 1e-10 of F, and of the load to rounding.

    Beside `orbit.bordered()` it is the matrix with which a branch is followed.

    Parameters
    ----------
    orbit
        The orbit.
    family
        The system at a value of the parameter λ.
    value
        λ of the orbit.

    Returns
    -------
    numpy.ndarray
        Shape (p + 1,): of the p equations, and of that for the rigid velocity (0 where this follows from the times).

    Raises
    ------
    ParameterError
        When the family gives no system.

    Examples
    --------
    >>> from percuss import Load, System
    >>> from percuss.steady import orbit_near
    >>> def family(mean):
    ...     return System(s=5.0, d=0.0, restitution=0.5, load=Load.harmonic(mean, 1.0))
    >>> orbit = orbit_near(family(0.62), [0.4, 2.3], modes=0)
    >>> parameter_column(orbit, family, 0.62).shape
    (3,)
    """
    instance("orbit", orbit, PeriodicOrbit)
    here = finite("value", value)
    if not callable(family) or isinstance(family, type):
        raise ParameterError("family", family, "a function from a number to a System")
    step = _STEP * max(1.0, abs(here))

    def off(by: float) -> Array:
        return orbit.off(instance("family", family(here + by), System))

    try:
        forward, inner = off(step), step
    except PercussError:  # the range of the parameter ends here
        forward, inner = off(-step), -step
    try:
        return np.asarray((forward - off(-inner)) / (2.0 * inner))
    except PercussError:
        return np.asarray((4.0 * forward - off(2.0 * inner) - 3.0 * off(0.0)) / (2.0 * inner))


def time_rates(orbit: PeriodicOrbit, family: Callable[[float], System], value: float) -> Array:
    """dt_i/dλ, how the impact times move with the parameter; shape (p,).

    They grow without bound towards a fold.

    Parameters
    ----------
    orbit, family, value
        As for `parameter_column`.

    Raises
    ------
    ParameterError
        As `parameter_column`; and at a fold.

    Examples
    --------
    >>> from percuss import Load, System
    >>> from percuss.steady import orbit_near
    >>> def family(mean):
    ...     return System(s=5.0, d=0.0, restitution=0.5, load=Load.harmonic(mean, 1.0))
    >>> orbit = orbit_near(family(0.62), [0.4, 2.3], modes=0)
    >>> later = orbit_near(family(0.62 + 1e-6), orbit.times, modes=0)
    >>> moved = (np.array(later.times) - orbit.times) / 1e-6
    >>> bool(abs(moved - time_rates(orbit, family, 0.62)).max() < 1e-4)
    True
    """
    column = parameter_column(orbit, family, value)
    try:
        return np.asarray(-np.linalg.solve(orbit.bordered(), column)[:-1])
    except np.linalg.LinAlgError:
        raise ParameterError("value", value, "a value at which the orbit is no fold") from None
