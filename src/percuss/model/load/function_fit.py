"""The Fourier coefficients of a function of the load phase, as many as a tolerance asks for."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NoReturn

import numpy as np

from percuss.errors import ParameterError
from percuss.model.checks import Array, ComplexArray, count, positive

__all__ = ["coefficients_of"]

_TURN = 2.0 * np.pi
_FIRST = 256  # samples of the first look
_PER_HARMONIC = 4  # samples for each harmonic kept, so that what is left out hardly comes back by aliasing
_FINER = 4  # values for each sample at which the sum is compared
_DENSE = 1 << 15  # the least number of phases between them at which it is compared as well
_APART = (0.5 * (math.sqrt(5.0) - 1.0), math.sqrt(2.0) - 1.0)  # those lie as far off, in places: no grid holds both
_SURE = 1 << 13  # samples at least where the number of harmonics is given
_ROUNDING = 1e-13  # beside the greatest value, a coefficient this small is none


def coefficients_of(
    function: Callable[[Array], object], harmonics: int | None, tolerance: float, most: int
) -> tuple[ComplexArray, float]:
    """p_0 … p_K of a function with period 2π, and how far the sum is from it.

    Parameters
    ----------
    function
        Of the phase in radians; arrays are tried first, single numbers else.
    harmonics
        K; None for as few as the tolerance asks for.
    tolerance
        Greatest deviation over the greatest |f − mean|. It is looked for at four times as many phases as are sampled,
        at 32768 or more that lie between those by an irrational share, and at twice as many elsewhere.
    most
        The greatest K.

    Returns
    -------
    coefficients, error
        Shape (K + 1,), and the deviation that was found.

    Raises
    ------
    ParameterError
        When the function fails or gives no finite real numbers, or the tolerance cannot be reached.
    """
    if not callable(function):
        raise ParameterError("function", function, "a function of the load phase in radians")
    wanted = positive("tolerance", tolerance)
    if harmonics is not None:
        kept = count("harmonics", harmonics, most=most)
        n = max(1 << (4 * _PER_HARMONIC * kept - 1).bit_length(), _SURE)
        seen = _Sampled.of(function, n).beside(function, 0)
        return seen.p[: kept + 1], seen.error(kept)
    n = _FIRST
    while n <= 2 * _PER_HARMONIC * most:
        seen, room = _Sampled.of(function, n), _room(n, most)
        for look in range(len(_APART)):
            if seen.error(room) > wanted:
                break
            seen = seen.beside(function, look)
        if seen.error(room) <= wanted:
            least = _least(seen, wanted, room)
            return seen.p[: least + 1], seen.error(least)
        n *= 2
    reached = seen.error(most)
    first, last = (float(_values(function, np.array([x]))[0]) for x in (0.0, _TURN * (1.0 - 1e-9)))
    ends = f"; f(0) = {first:.6g} and f(2π) = {last:.6g}" if abs(first - last) > wanted * seen.scale else ""
    raise ParameterError(
        "tolerance",
        tolerance,
        f"one that {most} harmonics reach: they miss {reached:.2g} of the alternating part{ends}",
        "for a function that jumps, use Load.steps or give harmonics=K; otherwise give a greater tolerance",
    )


def _room(n: int, most: int) -> int:
    return min(n // _PER_HARMONIC, most)


@dataclass(frozen=True)
class _Sampled:
    """Coefficients from n samples, and values to compare with, each evenly spaced from the phase before them on."""

    n: int
    p: ComplexArray
    looks: tuple[tuple[float, Array], ...]

    @classmethod
    def of(cls, function: Callable[[Array], object], n: int) -> _Sampled:
        values = _values(function, _TURN * np.arange(_FINER * n) / (_FINER * n))
        p = np.fft.rfft(values[::_FINER]) * (2.0 / n)
        p[0] = 0.5 * p[0].real
        p[1:][np.abs(p[1:]) <= _ROUNDING * float(np.abs(values).max())] = 0.0
        return cls(n, p, ((0.0, values),))

    def beside(self, function: Callable[[Array], object], look: int) -> _Sampled:
        """The same with values between the places looked at, where what is aliased there shows itself."""
        size = max(_FINER * self.n, _DENSE) << look
        start = _TURN * _APART[look] / size
        values = _values(function, start + _TURN * np.arange(size) / size)
        return _Sampled(self.n, self.p, (*self.looks, (start, values)))

    @cached_property
    def scale(self) -> float:
        """The greatest |f − mean|."""
        greatest = max(float(np.abs(values).max()) for _, values in self.looks)
        found = max(float(np.abs(values - self.p[0].real).max()) for _, values in self.looks)
        return found if found > _ROUNDING * greatest else 0.0

    def error(self, kept: int) -> float:
        """Greatest deviation of as many harmonics from the values, over the greatest |f − mean|."""
        if self.scale == 0.0:
            return 0.0
        return max(_deviation(self.p[: kept + 1], *look) for look in self.looks) / self.scale


def _values(function: Callable[[Array], object], phases: Array) -> Array:
    """The function at many phases, whether it takes arrays or not."""
    try:
        given = np.asarray(function(phases))
        found = given if given.dtype.kind == "c" else given.astype(float)
    except Exception:  # one that asks `if x < 1` takes no arrays; what else is wrong shows itself below
        found = np.empty(0)
    if found.dtype.kind == "c":
        _refuse_complex(function)
    if found.shape != phases.shape:
        found = np.array([_value(function, float(x)) for x in phases])
    bad = np.flatnonzero(~np.isfinite(found))
    if bad.size:
        at = float(phases[bad[0]])
        raise ParameterError("function", float(found[bad[0]]), f"a finite force; it is not at the phase {at:.6g}")
    return found


def _value(function: Callable[..., Any], phase: float) -> float:
    """The function at one phase."""
    try:
        given = function(phase)
        if not np.iscomplexobj(given):
            return float(given)
    except Exception as error:
        said = f"at the phase {phase:.6g} it ends with {type(error).__name__}: {error}"
        raise ParameterError("function", function, "one that gives a number for a phase", said) from error
    _refuse_complex(function)


def _refuse_complex(function: object) -> NoReturn:
    raise ParameterError(
        "function", function, "real forces; it gives complex numbers", "give the real part, numpy.real"
    )


def _deviation(p: ComplexArray, start: float, values: Array) -> float:
    """Greatest deviation from values that are evenly spaced from the phase `start` on."""
    waves = np.zeros(values.size, dtype=complex)
    waves[: p.size] = p * np.exp(1j * start * np.arange(p.size))
    return float(np.abs((values.size * np.fft.ifft(waves)).real - values).max())


def _least(seen: _Sampled, wanted: float, enough: int) -> int:
    """A number of harmonics that reaches the tolerance where one fewer does not."""
    low, high = -1, enough
    while high - low > 1:
        middle = (low + high) // 2
        if seen.error(middle) <= wanted:
            high = middle
        else:
            low = middle
    return high
