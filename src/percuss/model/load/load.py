"""The load: the periodic force on the driven end, and the ways to make one."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise
from typing import TYPE_CHECKING, Any, Literal, NoReturn

import numpy as np
import numpy.typing as npt

from percuss.errors import ParameterError
from percuss.model.checks import (
    Array,
    ComplexArray,
    choice,
    complex_numbers,
    count,
    finite,
    instance,
    non_negative,
    numbers,
    positive,
)
from percuss.short_repr import ShortRepr

if TYPE_CHECKING:
    from percuss.recordings.history import HistoryReport


# ---- The load: its harmonics or its steps, what they tell at any phase, and the ways to make one

MAX_HARMONICS = 4096
"""The most harmonics a load may have."""

MOST_STEPS = 199
"""The most steps a body may have, and so the last place on it where a load may act."""

TURN = 2.0 * math.pi
_SNAP = 8.0 * np.finfo(float).eps  # phases this close (times 2π) to a jump are at the jump

Side = Literal["left", "right"]


@dataclass(frozen=True)
class Jump:
    """A jump of the load: its phase in [0, 2π) and the one-sided values before and after it."""

    phase: float
    before: float
    after: float


_CANCELLED = 8.0 * np.finfo(float).eps


@dataclass(frozen=True)
class Load(ShortRepr):
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

    Examples
    --------
    >>> load = Load.harmonic(mean=0.9, amplitude=1.0)
    >>> print(load)
    Load: mean 0.9, 1 harmonic, load factor 0.9
    >>> round(float(load.value(0.0)), 12)
    1.9
    """

    coefficients: ComplexArray = field(compare=False)
    frequency: float | None = None
    breaks: tuple[float, ...] = ()
    values: tuple[float, ...] = ()
    report: HistoryReport | None = field(default=None, compare=False)
    error: float | None = field(default=None, compare=False)
    at: int = 0
    _key: tuple[complex, ...] = field(init=False, repr=False, default=())

    def __post_init__(self) -> None:
        set_ = object.__setattr__
        array = complex_numbers("coefficients", self.coefficients, "complex numbers p_0, p_1, …").reshape(-1)
        if not 1 <= array.size <= MAX_HARMONICS + 1:
            raise ParameterError("coefficients", array.size, f"1 to {MAX_HARMONICS + 1} coefficients")
        if not np.all(np.isfinite(array)):
            bad = int(np.flatnonzero(~np.isfinite(array))[0])
            raise ParameterError(f"coefficients[{bad}]", complex(array[bad]), "a finite complex number")
        if array[0].imag != 0.0:
            raise ParameterError("coefficients[0]", complex(array[0]), "a real mean (imaginary part 0)")
        array.setflags(write=False)
        set_(self, "coefficients", array)
        set_(self, "_key", tuple(array.tolist()))
        if self.frequency is not None:
            set_(self, "frequency", positive("frequency", self.frequency))
        self._check_steps()
        if self.report is not None:
            from percuss.recordings.history import HistoryReport

            instance("report", self.report, HistoryReport)
        if self.error is not None:
            set_(self, "error", non_negative("error", self.error))
        set_(self, "at", count("at", self.at, least=0, most=MOST_STEPS))

    def _check_steps(self) -> None:
        if isinstance(self.breaks, tuple) and isinstance(self.values, tuple) and not self.breaks and not self.values:
            return
        breaks = tuple(numbers("breaks", self.breaks, "increasing phases in [0, 2π)").reshape(-1).tolist())
        values = tuple(numbers("values", self.values).reshape(-1).tolist())
        if len(breaks) != len(values) or len(breaks) == 1:
            raise ParameterError("breaks", breaks, "two or more phases, one for each value")
        inside = all(0.0 <= b < TURN for b in breaks)
        if not inside or any(b >= c for b, c in pairwise(breaks)):
            raise ParameterError("breaks", breaks, "increasing phases in [0, 2π)")
        object.__setattr__(self, "breaks", breaks)
        object.__setattr__(self, "values", values)

    # -- what it tells --

    @property
    def mean(self) -> float:
        """p_0."""
        return float(self.coefficients[0].real)

    @property
    def is_piecewise(self) -> bool:
        """Whether the exact piecewise-constant form is known."""
        return bool(self.breaks)

    @property
    def sides(self) -> tuple[Side, ...]:
        """From where its values may differ: a smooth load has one side only."""
        return ("left", "right") if self.is_piecewise else ("right",)

    @cached_property
    def harmonics(self) -> npt.NDArray[np.int64]:
        """The numbers k ≥ 1 of the harmonics that are present."""
        present = np.flatnonzero(self.coefficients[1:]) + 1
        present.setflags(write=False)
        return present

    @property
    def is_constant(self) -> bool:
        """Whether the load has no alternating part, hence no period."""
        return len(set(self.values)) == 1 if self.is_piecewise else self.harmonics.size == 0

    @property
    def load_factor(self) -> float:
        """B77's p_0/p_k with the lowest harmonic present; infinite for a constant load."""
        present = self.harmonics
        return self.mean / abs(complex(self.coefficients[present[0]])) if present.size else math.inf

    @property
    def jumps(self) -> tuple[Jump, ...]:
        """The jumps of a piecewise load, in order of phase."""
        before = (self.values[-1], *self.values[:-1]) if self.is_piecewise else ()
        triples = zip(self.breaks, before, self.values, strict=True)
        return tuple(Jump(b, x, y) for b, x, y in triples if x != y)

    def value(self, t: npt.ArrayLike, side: Side = "right") -> Array:
        """p(t); at a jump the limit from the given side. Same shape as `t` (rad)."""
        choice("side", side, "left", "right")
        if not self.is_piecewise:
            return self._series(t, self.coefficients)
        return np.asarray(self.values, dtype=float)[self.piece(t, side)]

    def derivative(self, t: npt.ArrayLike, side: Side = "right") -> Array:
        """p'(t), one-sided at a jump. Same shape as `t` (rad)."""
        choice("side", side, "left", "right")
        if self.is_piecewise:
            return np.zeros(numbers("t", t).shape)
        return self._series(t, 1j * np.arange(self.coefficients.size) * self.coefficients)

    def antiderivative(self, t: npt.ArrayLike) -> Array:
        """The periodic antiderivative of p(t) − p_0 with mean zero. Same shape as `t` (rad)."""
        if not self.is_piecewise:
            k = np.arange(1, self.coefficients.size)
            return self._series(t, np.concatenate([[0.0], self.coefficients[1:] / (1j * k)]))
        slopes = np.asarray(self.values) - self.mean
        starts = np.asarray(self.breaks)
        lengths = np.diff(np.append(starts, starts[0] + TURN))
        knots = np.concatenate([[0.0], np.cumsum(slopes * lengths)[:-1]])
        offset = float(np.sum(knots * lengths + slopes * lengths**2 / 2.0)) / TURN
        _, phase, piece = self.on_steps(t)
        gone = np.mod(phase - starts[piece], TURN)
        return np.asarray(knots[piece] + slopes[piece] * gone - offset)

    def _series(self, t: npt.ArrayLike, coefficients: ComplexArray) -> Array:
        phases = numbers("t", t)
        k = np.flatnonzero(coefficients)
        waves = np.exp(1j * phases[..., None] * k) * coefficients[k]
        return np.asarray(waves.real.sum(axis=-1))

    def piece(self, t: npt.ArrayLike, side: Side = "right") -> npt.NDArray[np.intp]:
        """Number of the step at the phases `t` of a piecewise load; at a break that on the given side."""
        choice("side", side, "left", "right")
        _, phases, piece = self.on_steps(t)
        starts = np.asarray(self.breaks)
        return piece if side == "right" else (piece - (phases == starts[piece])) % starts.size

    def on_steps(
        self, t: npt.ArrayLike, error: npt.ArrayLike = 0.0
    ) -> tuple[npt.NDArray[np.intp], Array, npt.NDArray[np.intp]]:
        """Where the phases `t` of a piecewise load stand: a phase that is at a break but for rounding is that break.

        `error` is what rounding may have added to them, where that is more than 8 eps · 2π. Told are turns by which a
        phase moved to a break of the turn before or after; the phase in [0, 2π); and the number of the step that holds
        from there on; each of the shape of `t`.
        """
        starts, phases = np.asarray(self.breaks), np.mod(numbers("t", t), TURN)
        off = np.abs(phases[..., None] - np.concatenate([[starts[-1] - TURN], starts, [starts[0] + TURN]]))
        at, nearest = off.min(axis=-1) <= np.maximum(_SNAP * TURN, numbers("error", error)), off.argmin(axis=-1)
        piece = np.where(at, nearest - 1, np.searchsorted(starts, phases, side="right") - 1) % starts.size
        turns = np.where(at, (nearest > starts.size) * 1 - (nearest == 0), 0)
        return turns, np.where(at, starts[piece], phases), piece

    # -- ways to make one --

    @classmethod
    def harmonic(cls, mean: float, amplitude: float, harmonic: int = 1, *, frequency: float | None = None) -> Load:
        """p(t) = mean + amplitude · cos(harmonic · t).

        Parameters
        ----------
        mean, amplitude
            In N when `frequency` is given, otherwise dimensionless.
        harmonic, frequency
            Which multiple of the fundamental, and its frequency in Hz; None for a dimensionless load.
        """
        k = count("harmonic", harmonic, most=MAX_HARMONICS)
        coefficients = np.zeros(k + 1, dtype=complex)
        coefficients[0], coefficients[k] = finite("mean", mean), finite("amplitude", amplitude)
        return cls(coefficients, frequency)

    @classmethod
    def square(cls, amplitude: float, kappa: float, harmonics: int = 64, *, frequency: float | None = None) -> Load:
        """Square wave: +amplitude for 0 < t < κπ and −amplitude for κπ < t < 2π (B77 34), 0 < κ < 2.

        The exact piecewise form is kept beside the first `harmonics` coefficients.
        """
        q, k = positive("amplitude", amplitude), finite("kappa", kappa)
        if not 0.0 < k < 2.0:
            raise ParameterError("kappa", kappa, "a number greater than 0 and less than 2")
        return cls.steps([0.0, k * math.pi], [q, -q], harmonics, frequency=frequency)

    @classmethod
    def steps(
        cls, breaks: Sequence[float], values: Sequence[float], harmonics: int = 64, *, frequency: float | None = None
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
        none = np.abs(sums) <= _CANCELLED * (1.0 + k) * np.abs(jumps).sum()
        sums[none] = 0.0  # a harmonic that the steps do not hold
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
        time, values
            Shape (n,): s, increasing, and force in N, or pressure in Pa when `area` is given.
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
        return self if number is self.at else replace(self, at=number)

    def __setstate__(self, state: dict[str, object]) -> None:
        """Copies and unpickled loads are as read-only as their originals."""
        self.__dict__.update(state)
        self.coefficients.setflags(write=False)

    def __hash__(self) -> int:
        return hash((self._key, self.frequency, self.breaks, self.values, self.at))

    def __str__(self) -> str:
        unit = "" if self.frequency is None else " N"
        where = "" if self.frequency is None else f", {self.frequency:.4g} Hz"
        size = self.harmonics.size
        form = f"{len(self.breaks)} exact steps, " if self.is_piecewise else ""
        what = "constant" if self.is_constant else f"{form}{size} harmonic{'s' if size != 1 else ''}"
        factor = "" if self.is_constant else f", load factor {self.load_factor:.4g}"
        place = f", at step {self.at}" if self.at else ""
        return f"Load: mean {self.mean:.4g}{unit}, {what}{factor}{where}{place}"


def _record(name: str, values: npt.ArrayLike) -> Array:
    """A row of samples; those that are not finite are told of with the recording's own words."""
    try:
        return numbers(name, values, nan=True)
    except ParameterError:
        if np.asarray(values).dtype.kind == "f":  # infinite ones
            return np.asarray(values, dtype=float)
        raise


# ---- The Fourier coefficients of a function of the load phase, as many as a tolerance asks for

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
    """p_0 … p_K of a function with period 2π, K at most `most`, and how far their sum is from it."""
    # Arrays of phases are tried first, single numbers else. The tolerance is looked for at four times as many phases as
    # are sampled, at 32768 or more that lie between those by an irrational share, and at twice as many elsewhere.
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
        seen, room = _Sampled.of(function, n), min(n // _PER_HARMONIC, most)
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
