"""From a recorded history to one period of the load.

The record is taken to be one waveform, repeated with cycles of slightly different length (jitter), on a mean that
drifts slowly, with noise:

    p(T) = drift(T) + Re Σ_k p_k exp(ikθ(T)),   θ grows by 2π from one cycle boundary to the next, evenly in between.

All of it is fitted to the samples as they lie, without resampling: the p_k by least squares on the phases of the
samples, the boundaries and the drift as broken lines with a knot at every boundary. The lengths of the cycles are
kept together by a prior whose width is estimated from the record, so that noise is not taken for jitter; without
that alignment averaging would wear the high harmonics down. ``design/history.md`` has the measurements.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from percuss.errors import HistoryError
from percuss.recordings.columns import Array, ComplexArray
from percuss.recordings.cycle_fit import (
    LEAST_SAMPLES,
    MAX_CYCLES,
    CycleFit,
    found_period,
    given_period,
    no_repetition,
    unlike,
)
from percuss.short_repr import ShortRepr

# ---- Whether a record stays at its highest or lowest value, as where a sensor or a recorder has reached its limit

_NEAR = 0.02  # of the range: what a rounded peak passes through …
_LEAST = 0.005  # share of the samples below which clipping is of no account


def clipped_share(values: Array) -> tuple[float, float]:
    """The shares of the samples exactly at the lowest and at the highest value, where these look like limits."""
    # A rounded peak recorded in steps has several equal samples at its top too, but more in the steps next to it: its
    # width grows with the root of the depth. So a limit is told from the samples within 2 % of the range (4 steps, if
    # that is more) next to the highest value: where they are fewer than those at it, and those come three and more in a
    # row, the record is cut off there. A record of two values only is a square wave, and is not.
    low, high = float(np.min(values)), float(np.max(values))
    levels = np.unique(values)
    if levels.size < 3:
        return 0.0, 0.0
    at = [int(np.count_nonzero(values == limit)) for limit in (low, high)]
    if sum(at) > 0.9 * values.size:
        return 0.0, 0.0
    step = float(np.min(np.diff(levels)))
    width = max(_NEAR * (high - low), 4.0 * step)
    near = [int(np.count_nonzero(near)) for near in (values <= low + width, values >= high - width)]
    shares = [0.0, 0.0]
    for i, limit in enumerate((low, high)):
        runs = np.flatnonzero(np.diff(np.concatenate([[0], (values == limit).astype(int), [0]])))
        lengths = runs[1::2] - runs[::2]
        if at[i] > max(near[i] - at[i], _LEAST * values.size) and np.median(lengths) >= 3:
            shares[i] = at[i] / values.size
    return shares[0], shares[1]


# ---- From a recorded history to one period of the load

UNSTEADY = 0.03  # variation of the period, as a fraction of it, from which the report warns
DRIFTING = 0.25  # drift of the mean, as a fraction of the rms of the alternating part, from which the report warns


@dataclass(frozen=True)
class HistoryReport(ShortRepr):
    """What was found in a recorded history.

    Attributes
    ----------
    cycles, samples, sample_rate
        Whole cycles and samples used, and their mean rate, Hz.
    frequency, frequency_given, frequency_found
        Of the load, Hz: the one that was given, or else the one that was found, at which the record repeats.
    jitter
        Standard deviation of the length of the cycles, as a fraction of the period.
    scatter
        Root mean square (rms) of the cycles about the mean cycle, as a fraction of the rms of the alternating part.
    drift
        Largest change of the cycle mean over the record, as a fraction of the same.
    residual
        rms of the mean cycle less the harmonics kept, as a fraction of the same.
    harmonics
        The highest harmonic kept.
    warnings
        What a reader should know before trusting the load, one sentence each.
    clipped
        Share of the samples at a limit of the sensor or the recorder.
    """

    cycles: int
    frequency: float
    frequency_given: bool
    frequency_found: float
    jitter: float
    scatter: float
    drift: float
    residual: float
    harmonics: int
    samples: int
    sample_rate: float
    warnings: tuple[str, ...] = ()
    clipped: float = 0.0

    def __str__(self) -> str:
        source = f"given; the record repeats at {self.frequency_found:.5g} Hz" if self.frequency_given else "found"
        lines = [
            f"{self.cycles} cycles at {self.frequency:.5g} Hz ({source}), "
            f"{self.samples} samples at {self.sample_rate:.5g} Hz",
            f"length of the cycles ± {_percent(self.jitter)} (standard deviation)",
            f"cycles about their mean {_percent(self.scatter)}, drift of the mean {_percent(self.drift)} "
            "(of the rms of the alternating part)",
            f"harmonics up to {self.harmonics} kept, {_percent(self.residual)} left out",
        ]
        return "\n".join(lines + [f"warning: {w}" for w in self.warnings])


def analyse(
    time: npt.ArrayLike, values: npt.ArrayLike, *, frequency: float | None = None, harmonics: int | None = None
) -> tuple[ComplexArray, HistoryReport]:
    """The Fourier coefficients of the load that a record repeats.

    Parameters
    ----------
    time, values
        Shape (n,), s, strictly increasing, in steps that may differ; and in any unit.
    frequency
        Of the fundamental, Hz; None to find it. The cycles are aligned in either case.
    harmonics
        Keep exactly this many. None keeps those that stand out from the scatter of the cycles (3.5 standard
        errors) and are not negligible (1/1000 of the largest), 64 at most; those between that do not are zero.

    Examples
    --------
    >>> time = np.arange(2000) / 1e4
    >>> coefficients, report = analyse(time, 3 + 2 * np.cos(2 * np.pi * 50 * time))
    >>> bool(abs(coefficients - [3, 2]).max() < 1e-4), report.cycles
    (True, 10)
    """
    t, v = _series(time, values)
    middle, scale = 0.5 * (np.max(v) + np.min(v)), 0.5 * (np.max(v) - np.min(v))
    t, v = t - t[0], (v - middle) / scale
    period = found_period(t, v) if frequency is None else given_period(t, v, frequency)
    fit = CycleFit(t, v, period, harmonics)
    multiple = fit.cycles_in_turn()
    for _ in range(3):
        if frequency is not None or multiple == 1:
            break
        fit = CycleFit(t, v, multiple * fit.period, harmonics)
        multiple = fit.cycles_in_turn()
    kept = fit.kept()
    divisor = int(np.gcd.reduce(np.flatnonzero(kept[1:]) + 1))
    if divisor == 0:
        raise _no_fit(t, v, frequency)
    if divisor > 1 and frequency is None and harmonics is None:
        fit = CycleFit(t, v, fit.period / divisor, harmonics)
        kept = fit.kept()
    if fit.jitter > 0.1:  # lengths that vary so much follow noise
        raise _no_fit(t, v, frequency)
    report = _report(fit, kept, frequency, multiple, divisor)
    shares = clipped_share(v)
    report = replace(report, warnings=report.warnings + clipping(shares), clipped=sum(shares))
    kept = kept * scale
    kept[0] += middle
    return kept, report


def _no_fit(t: Array, v: Array, frequency: float | None) -> HistoryError:
    """Why no harmonics came out: the wrong frequency was given, or there is no repetition at all."""
    if frequency is not None:
        try:
            found = 1.0 / found_period(t, v)
        except HistoryError:
            return no_repetition()
        if abs(found / frequency - 1.0) > 0.02:
            return unlike(frequency, found)
    return no_repetition()


def _report(fit: CycleFit, kept: ComplexArray, frequency: float | None, multiple: int, divisor: int) -> HistoryReport:
    found = 1.0 / fit.period
    warnings = []
    if frequency is not None:
        if multiple > 1:
            warnings.append(f"successive cycles differ: the record repeats at {found / multiple:.5g} Hz")
        if divisor > 1:
            warnings.append(f"the record repeats {divisor} times in each period, at {found * divisor:.5g} Hz")
        apart = abs(found / frequency - 1.0)
        if apart > 5e-4 + 3.0 * fit.jitter / math.sqrt(fit.cycles):
            warnings.append(
                f"the record repeats at {found:.5g} Hz, {_percent(apart)} from the {frequency:.6g} Hz given: "
                "more than the scatter of the cycles explains"
            )
    if fit.cycles == MAX_CYCLES:
        warnings.append(f"only the first {MAX_CYCLES} cycles are used")
    scatter, residual = fit.scatter_and_residual(kept)
    if scatter > 0.5:
        warnings.append(f"the cycles hardly resemble each other: they scatter by {_percent(scatter)} of the load")
    drift = float(np.ptp(fit.drift)) / fit.alternating
    if drift > DRIFTING:
        warnings.append(
            f"the mean drifts by {_percent(drift)} of the rms of the alternating part, and only its average is kept: "
            "use a part of the record in which the machine runs evenly (from, to), or check whether the sensor drifts"
        )
    if fit.jitter > UNSTEADY:
        warnings.append(
            f"the period varies by {_percent(fit.jitter)}: the machine does not run evenly, and one period stands for "
            "all; use a part in which it does (from, to)"
        )
    return HistoryReport(
        cycles=fit.cycles,
        frequency=found if frequency is None else float(frequency),
        frequency_given=frequency is not None,
        frequency_found=found,
        jitter=fit.jitter,
        scatter=scatter,
        drift=drift,
        residual=residual,
        harmonics=kept.size - 1,
        samples=fit.v.size,
        sample_rate=(fit.v.size - 1) / float(fit.t[-1] - fit.t[0]),
        warnings=tuple(warnings),
    )


def clipping(shares: tuple[float, float], of: str = "") -> tuple[str, ...]:
    """What to say of a record, or of one channel of it, that stays at its limits."""
    said = []
    for share, limit in zip(shares, ("lowest", "highest"), strict=True):
        if share:
            said.append(
                f"{_percent(share)} of the samples{of} lie exactly at the {limit} value: the sensor or the recorder "
                "seems to have reached its limit there, and what lay beyond is missing"
            )
    return tuple(said)


def _percent(fraction: float) -> str:
    return f"{100.0 * fraction:.2g} %" if fraction < 0.995 else f"{100.0 * fraction:.0f} %"


def _series(time: npt.ArrayLike, values: npt.ArrayLike) -> tuple[Array, Array]:
    t, v = np.asarray(time, dtype=float), np.asarray(values, dtype=float)
    if t.ndim != 1 or t.shape != v.shape:
        raise HistoryError(f"time has the shape {t.shape}, the values {v.shape}", "give rows of the same length")
    if t.size < 2 * LEAST_SAMPLES:
        raise HistoryError(
            f"only {t.size} samples", f"at least two whole cycles of {LEAST_SAMPLES} samples or more are needed"
        )
    for name, data in (("time", t), ("values", v)):
        bad = np.flatnonzero(~np.isfinite(data))
        if bad.size:
            raise HistoryError(f"{name}[{bad[0]}] is {data[bad[0]]}", "cut the record there, or fill the gap")
    back = np.flatnonzero(np.diff(t) <= 0.0)
    if back.size:
        i = int(back[0]) + 1
        raise HistoryError(f"time[{i}] = {t[i]:.9g} does not follow {t[i - 1]:.9g}", "the time must increase")
    if np.max(np.abs(v)) > 1e300:
        raise HistoryError("the values are beyond 1e300", "check the unit")
    if np.ptp(v) <= max(1e-12 * float(np.max(np.abs(v))), 1e-300):
        raise HistoryError(f"the values are constant ({v[0]:.6g})", "check the column: the load must repeat")
    return t, v
