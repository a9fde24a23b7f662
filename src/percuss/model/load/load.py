"""The load: the periodic force on the driven end, and the ways to make one."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from percuss.errors import ParameterError
from percuss.model.checks import Array, complex_numbers, count, finite, numbers, positive
from percuss.model.load.periodic_force import MAX_HARMONICS, TURN, PeriodicForce

__all__ = ["Load"]

_CANCELLED = 8.0 * np.finfo(float).eps


@dataclass(frozen=True)
class Load(PeriodicForce):
    """A force with period 2π in its own time, p(t) = Re Σ p_k exp(ikt), positive toward the wall.

    Make one with `harmonic`, `square`, `steps`, `fourier`, `from_function` or `history`.

    Parameters
    ----------
    coefficients
        Complex Fourier coefficients p_0 … p_K; p_0 is real. In N when `frequency` is given, otherwise dimensionless
        (theory: P/(M L² Ω²)).
    frequency
        Frequency of the fundamental in Hz, or None for a dimensionless load.
    breaks, values
        For a piecewise-constant load its exact form beside the coefficients: `values[i]` holds from phase `breaks[i]`
        to the next break. Empty for a smooth load.
    report
        What was found in the recording that the load was made from, or None.
    error
        Of a load made from a function: its greatest deviation from that function, over the greatest |f − mean|.
    at
        Where on the body it acts: 0, the driven end, or the number of a step of the body, counted from there.

    Raises
    ------
    ParameterError
        For coefficients or a frequency that are not finite, a mean that is not real, or breaks out of order.

    Examples
    --------
    >>> load = Load.harmonic(mean=0.9, amplitude=1.0)
    >>> print(load)
    Load: mean 0.9, 1 harmonic, load factor 0.9
    >>> round(float(load.value(0.0)), 12)
    1.9
    """

    # -- ways to make one --

    @classmethod
    def harmonic(cls, mean: float, amplitude: float, harmonic: int = 1, *, frequency: float | None = None) -> Load:
        """p(t) = mean + amplitude · cos(harmonic · t).

        Parameters
        ----------
        mean, amplitude
            In N when `frequency` is given, otherwise dimensionless.
        harmonic
            Which multiple of the fundamental.
        frequency
            Of the fundamental, in Hz; None for a dimensionless load.
        """
        k = count("harmonic", harmonic, most=MAX_HARMONICS)
        coefficients = np.zeros(k + 1, dtype=complex)
        coefficients[0], coefficients[k] = finite("mean", mean), finite("amplitude", amplitude)
        return cls(coefficients, frequency)

    @classmethod
    def square(cls, amplitude: float, kappa: float, harmonics: int = 64, *, frequency: float | None = None) -> Load:
        """Square wave: +amplitude for 0 < t < κπ and −amplitude for κπ < t < 2π (B77 34).

        The exact piecewise form is kept beside the first `harmonics` coefficients.

        Raises
        ------
        ParameterError
            When κ is not inside (0, 2) or the amplitude is 0.
        """
        q, k = positive("amplitude", amplitude), finite("kappa", kappa)
        if not 0.0 < k < 2.0:
            raise ParameterError("kappa", kappa, "a number greater than 0 and less than 2")
        return cls.steps([0.0, k * math.pi], [q, -q], harmonics, frequency=frequency)

    @classmethod
    def steps(
        cls,
        breaks: Sequence[float],
        values: Sequence[float],
        harmonics: int = 64,
        *,
        frequency: float | None = None,
    ) -> Load:
        """A piecewise-constant load: `values[i]` from phase `breaks[i]` (rad, in [0, 2π)) to the next."""
        b, v = numbers("breaks", breaks, "increasing phases in [0, 2π)"), numbers("values", values)
        if b.ndim != 1 or v.ndim != 1 or b.size != v.size or b.size < 2:
            raise ParameterError("breaks", breaks, "two or more phases, one for each value")
        k = np.arange(1, count("harmonics", harmonics, most=MAX_HARMONICS) + 1)
        jumps = v - np.roll(v, 1)  # at breaks[i]
        coefficients = np.empty(k.size + 1, dtype=complex)
        lengths = np.diff(np.append(b, b[0] + TURN))
        coefficients[0] = float(v @ lengths) / TURN
        sums = np.exp(-1j * np.outer(k, b)) @ jumps
        sums[np.abs(sums) <= _CANCELLED * (1.0 + k) * np.abs(jumps).sum()] = (
            0.0  # a harmonic that the steps do not hold
        )
        coefficients[1:] = sums / (1j * math.pi * k)
        return cls(coefficients, frequency, tuple(b.tolist()), tuple(v.tolist()))

    @classmethod
    def fourier(cls, coefficients: npt.ArrayLike, *, frequency: float | None = None) -> Load:
        """p(t) = Re Σ p_k exp(ikt) from p_0, p_1, …, complex numbers or [re, im] pairs, shape (K+1,) or (K+1, 2)."""
        accepted = "complex numbers or [re, im] pairs"
        found = complex_numbers("coefficients", coefficients, accepted)
        if found.ndim == 2 and found.shape[1] == 2 and not found.imag.any() and not np.iscomplexobj(coefficients):
            found = found @ np.array([1.0, 1.0j])
        if found.ndim != 1:
            raise ParameterError("coefficients", coefficients, accepted)
        return cls(found, frequency)

    @classmethod
    def from_function(
        cls,
        function: Callable[[Array], object],
        *,
        harmonics: int | None = None,
        tolerance: float = 1e-3,
        frequency: float | None = None,
    ) -> Load:
        """The load that a periodic function describes, by as few harmonics as a tolerance asks for.

        What was reached is in `error`.

        Parameters
        ----------
        function
            Of the load phase in radians, 0 … 2π; takes an array, or single numbers. Gives N when `frequency` is
            given, otherwise dimensionless values.
        harmonics
            Keep exactly this many instead.
        tolerance
            Greatest deviation of the sum from the function, over the greatest |f − mean|; dimensionless. It is looked
            for at 98 000 phases or more: what is narrower than 1e-4 of the period may be missed.
        frequency
            Of the fundamental, in Hz; None for a dimensionless load.

        Raises
        ------
        ParameterError
            When the function fails (then its error is the cause), gives no finite real numbers, or jumps, so that no
            number of harmonics reaches the tolerance.

        Examples
        --------
        >>> import numpy as np
        >>> load = Load.from_function(lambda theta: np.exp(np.cos(theta)) - 1.0, tolerance=1e-4)
        >>> load.harmonics.size, load.error < 1e-4
        (5, True)
        """
        from percuss.model.load.function_fit import coefficients_of  # only functions need it

        coefficients, error = coefficients_of(function, harmonics, tolerance, MAX_HARMONICS)
        return cls(coefficients, frequency, error=error)

    @classmethod
    def history(
        cls,
        time: npt.ArrayLike,
        values: npt.ArrayLike,
        *,
        area: float | None = None,
        frequency: float | None = None,
        harmonics: int | None = None,
    ) -> Load:
        """A load from a recorded history of several cycles.

        Finds the period, averages the cycles and keeps the harmonics that matter; what was found is in `report`.

        Parameters
        ----------
        time
            Shape (n,), in s, increasing.
        values
            Shape (n,): force in N, or pressure in Pa when `area` is given.
        area
            Area in m² that the pressure works on.
        frequency
            In Hz, when it is known; otherwise it is found from the data.
        harmonics
            Keep exactly this many instead of those that stand out from the scatter.

        Raises
        ------
        HistoryError
            When the data hold no two whole cycles, do not repeat, or are not finite and increasing in time.
        """
        from percuss.recordings.history import analyse  # only histories need it

        coefficients, report = analyse(
            _record("time", time),
            _record("values", values),
            frequency=None if frequency is None else positive("frequency", frequency),
            harmonics=None if harmonics is None else count("harmonics", harmonics, least=0, most=MAX_HARMONICS),
        )
        scale = 1.0 if area is None else positive("area", area)
        return cls(coefficients * scale, report.frequency, report=report)

    # -- ways to change it --

    def shifted(self, phi: float) -> Load:
        """The load that starts at phase `phi` (rad): its value at t is this one's at t + phi."""
        shift = finite("phi", phi)
        turned = self.coefficients * np.exp(1j * np.arange(self.coefficients.size) * shift)
        if not self.is_piecewise:
            return replace(self, coefficients=turned)
        moved = sorted(zip(((b - shift) % TURN % TURN for b in self.breaks), self.values, strict=True))
        breaks, values = zip(*moved, strict=True)
        return replace(self, coefficients=turned, breaks=breaks, values=values)

    def scaled(self, factor: float, *, frequency: float | None = None) -> Load:
        """All values times `factor`; `frequency` as given (None makes the result dimensionless)."""
        f = finite("factor", factor)
        values = tuple(v * f for v in self.values)
        return replace(self, coefficients=self.coefficients * f, values=values, frequency=frequency)

    def with_mean(self, mean: float) -> Load:
        """The same alternating part about another mean."""
        coefficients = self.coefficients.copy()
        wanted = finite("mean", mean)
        coefficients[0] = wanted
        values = tuple(v + (wanted - self.mean) for v in self.values)
        return replace(self, coefficients=coefficients, values=values)

    def acting_at(self, number: int) -> Load:
        """The same load on another place of the body: 0, the driven end, or the number of a step."""
        return replace(self, at=number)


def _record(name: str, values: npt.ArrayLike) -> Array:
    """A row of samples; those that are not finite are told of with the recording's own words."""
    try:
        return numbers(name, values, nan=True)
    except ParameterError:
        if np.asarray(values).dtype.kind == "f":  # infinite ones
            return np.asarray(values, dtype=float)
        raise
