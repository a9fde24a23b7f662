"""A force with a period, exactly: its harmonics or its steps, and what they tell at any phase."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise
from typing import TYPE_CHECKING, Literal

import numpy as np
import numpy.typing as npt

from percuss.errors import ParameterError
from percuss.model.checks import (
    Array,
    ComplexArray,
    choice,
    complex_numbers,
    count,
    instance,
    non_negative,
    numbers,
    positive,
)
from percuss.shown import Shown

if TYPE_CHECKING:
    from percuss.recordings.history import HistoryReport

__all__ = ["MAX_HARMONICS", "MOST_STEPS", "TURN", "Jump", "PeriodicForce", "Side"]

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


@dataclass(frozen=True)
class PeriodicForce(Shown):
    """What a `Load` is made of, and what that tells; see there for the parameters."""

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
        piece = self.piece(t, "right")
        gone = np.mod(np.asarray(t) - starts[piece], TURN)
        gone = np.where(gone < TURN - 2.0 * _SNAP * TURN, gone, gone - TURN)  # just before a break is at the break
        return np.asarray(knots[piece] + slopes[piece] * gone - offset)

    def _series(self, t: npt.ArrayLike, coefficients: ComplexArray) -> Array:
        phases = numbers("t", t)
        k = np.flatnonzero(coefficients)
        waves = np.exp(1j * phases[..., None] * k) * coefficients[k]
        return np.asarray(waves.real.sum(axis=-1))

    def piece(self, t: npt.ArrayLike, side: Side = "right") -> npt.NDArray[np.intp]:
        """Number of the step at the phases `t` of a piecewise load; at a break that on the given side."""
        choice("side", side, "left", "right")
        starts = np.asarray(self.breaks)
        phases = np.mod(numbers("t", t), TURN)
        nearest = np.abs(phases[..., None] - np.append(starts, starts[0] + TURN)) <= _SNAP * TURN
        at = np.where(nearest.any(axis=-1), nearest.argmax(axis=-1) % starts.size, -1)
        inside = (np.searchsorted(starts, phases, side="right") - 1) % starts.size
        there = at if side == "right" else (at - 1) % starts.size
        return np.asarray(np.where(at >= 0, there, inside))

    def __setstate__(self, state: dict[str, object]) -> None:
        """Copies and unpickled loads are as read-only as their originals."""
        self.__dict__.update(state)
        self.coefficients.setflags(write=False)

    def __hash__(self) -> int:
        return hash((self._key, self.frequency, self.breaks, self.values, self.at))

    def __repr__(self) -> str:
        return f"<{self}>"

    def __str__(self) -> str:
        unit = "" if self.frequency is None else " N"
        where = "" if self.frequency is None else f", {self.frequency:.4g} Hz"
        size = self.harmonics.size
        form = f"{len(self.breaks)} exact steps, " if self.is_piecewise else ""
        what = "constant" if self.is_constant else f"{form}{size} harmonic{'s' if size != 1 else ''}"
        factor = "" if self.is_constant else f", load factor {self.load_factor:.4g}"
        place = f", at step {self.at}" if self.at else ""
        return f"Load: mean {self.mean:.4g}{unit}, {what}{factor}{where}{place}"
