"""A first period of a record, to about a part in a thousand, from its autocorrelation."""

from __future__ import annotations

import math

import numpy as np

from percuss.errors import HistoryError
from percuss.recordings.arrays import Array

__all__ = [
    "LEAST_SAMPLES",
    "found_period",
    "given_period",
    "no_repetition",
    "too_few_cycles",
    "too_few_samples",
    "unlike",
]

LEAST_SAMPLES = 8  # per cycle
_ROUNDING = 1e-12  # what computing with n samples leaves of a slow record, relative to it


def _autocorrelation(t: Array, v: Array, window: int = 0) -> tuple[float, Array]:
    """Step, and autocorrelation r(lag) normalised to [−1, 1] (McLeod's NSDF), of the record less its slow part.

    The slow part is a cubic, and with `window` then also the mean over so many samples.
    """
    n = t.size
    step = float(t[-1] - t[0]) / (n - 1)
    even = v if np.ptp(np.diff(t)) < 0.01 * step else np.interp(t[0] + step * np.arange(n), t, v)
    x = np.linspace(-1.0, 1.0, n)
    x = even - np.polynomial.legendre.legval(x, np.polynomial.legendre.legfit(x, even, 3))
    if window:
        total = np.concatenate([[0.0], np.cumsum(x)])
        left, right = np.maximum(np.arange(n) - window // 2, 0), np.minimum(np.arange(n) + window // 2 + 1, n)
        x = x - (total[right] - total[left]) / (right - left)
    if float(np.abs(x).max()) <= _ROUNDING * float(np.abs(even).max()):
        raise no_repetition()  # nothing but rounding is left, and its correlation means nothing
    size = 1 << (2 * n - 1).bit_length()
    spectrum = np.fft.rfft(x, size)
    product = np.fft.irfft(spectrum.real**2 + spectrum.imag**2, size)[:n]
    squares = np.concatenate([[0.0], np.cumsum(x**2)])
    energy = squares[n - np.arange(n)] + squares[-1] - squares[np.arange(n)]
    return step, np.asarray(2.0 * product / np.maximum(energy, 1e-9 * squares[-1] + 1e-300))


def _first_peak(r: Array, last: int, level: float) -> int:
    """The first lag whose peak is nearly the highest after the first zero of r; 0 when none reaches `level`."""
    positive = r[: last + 1] > 0.0
    edges = np.flatnonzero(positive[1:] != positive[:-1]) + 1
    if edges.size == 0:
        return 0
    tops = np.maximum.reduceat(r[: last + 1], edges)
    highest = float(np.max(tops))
    if highest < level:
        return 0
    ends = np.append(edges[1:], last + 1)
    for i in np.flatnonzero(tops >= 0.85 * highest):
        peak = int(edges[i] + np.argmax(r[edges[i] : ends[i]]))
        if LEAST_SAMPLES <= peak < last:  # a strong high harmonic may repeat in fewer
            return peak
    return 0


def _refined(r: Array, lag: float) -> float:
    """The lag from its multiples 1, 2, 4, … inside the record; each fixes the next."""
    multiple = 1
    while True:
        half, middle = max(2, round(0.15 * lag)), round(multiple * lag)
        if middle + half + 1 > 0.9 * r.size:
            return lag
        i = middle - half + int(np.argmax(r[middle - half : middle + half + 1]))
        bend = r[i - 1] - 2.0 * r[i] + r[i + 1]
        if r[i] < 0.1 or bend >= 0.0 or not middle - half < i < middle + half:
            return lag
        lag = float(i + 0.5 * (r[i - 1] - r[i + 1]) / bend) / multiple
        multiple *= 2


def found_period(t: Array, v: Array) -> float:
    """The shortest period at which the record repeats well."""
    n = t.size
    level = max(0.1, min(0.5, 7.0 / math.sqrt(n)))
    for window in (0, n // 4, n // 16):  # the narrower the window, the faster a drift it takes away
        if 0 < window < 2 * LEAST_SAMPLES:
            break
        step, r = _autocorrelation(t, v, window)
        if lag := _first_peak(r, round(0.52 * n), level):
            return step * _refined(r, lag)
    raise no_repetition()


def given_period(t: Array, v: Array, frequency: float) -> float:
    """The period near the given one at which the record repeats best."""
    if not (math.isfinite(frequency) and frequency > 0.0):
        raise HistoryError(f"frequency = {frequency}", "a frequency greater than 0 is needed")
    n = t.size
    step, r = _autocorrelation(t, v)
    lag = 1.0 / (frequency * step)
    if lag < 0.99 * LEAST_SAMPLES:
        raise too_few_samples(lag, frequency)
    if n / lag < 1.95:
        raise too_few_cycles(n / lag, frequency)
    low, high = math.floor(0.9 * lag) - 1, min(math.ceil(1.1 * lag) + 1, n - 2)
    near = low + int(np.argmax(r[low : high + 1]))
    best = _first_peak(r, round(0.52 * n), 0.3)
    if best and r[near] < 0.5 * r[best]:
        raise unlike(frequency, 1.0 / (step * best))
    return step * _refined(r, near) if low < near < high and r[near] > 0.1 else 1.0 / frequency


def unlike(frequency: float, found: float) -> HistoryError:
    return HistoryError(
        f"the record does not repeat at the {frequency:.6g} Hz given, but at {found:.4g} Hz",
        "give that frequency, or leave it out to have it found",
    )


def no_repetition() -> HistoryError:
    return HistoryError(
        "no repetition found in the record",
        "it must hold at least two whole cycles of the same load: check the column, or record longer",
    )


def too_few_samples(count: float, frequency: float) -> HistoryError:
    return HistoryError(
        f"{count:.3g} samples in a cycle of {frequency:.6g} Hz, at least {LEAST_SAMPLES} are needed",
        "sample faster, or check the frequency and the unit of time",
    )


def too_few_cycles(count: float, frequency: float) -> HistoryError:
    return HistoryError(
        f"the record holds {count:.2g} cycles of {frequency:.6g} Hz, at least two whole cycles are needed",
        "record longer, or check the frequency and the unit of time",
    )
