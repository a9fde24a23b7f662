"""The fit of one repeated waveform to a record: boundaries of the cycles, drift and harmonics."""

from __future__ import annotations

import math

import numpy as np

from percuss.errors import HistoryError
from percuss.recordings.arrays import Array, ComplexArray
from percuss.recordings.cycle_phases import TURN, CyclePhases
from percuss.recordings.repetition import LEAST_SAMPLES, too_few_cycles, too_few_samples

__all__ = ["MAX_CYCLES", "CycleFit"]

MAX_CYCLES = 400
"""Cycles beyond these add nothing and are left out (the report says so)."""
MAX_HARMONICS = 64
SIGNIFICANT = 3.5  # standard errors: one false harmonic in some thousand records
NEGLIGIBLE = 1e-3  # of the largest harmonic


class CycleFit(CyclePhases):
    """The model at the head of ``history.py``, fitted to the whole cycles of a record.

    Attributes: `t`, `v` the samples used; `bounds` the times of the cycle boundaries; `drift` at these boundaries;
    `coefficients`; `rest` what the fit leaves of every sample; `jitter`; `alternating` the rms of the fitted cycle.
    """

    def __init__(self, t: Array, v: Array, period: float, harmonics: int | None) -> None:
        per_cycle = period * (t.size - 1) / float(t[-1] - t[0])
        if per_cycle < 0.99 * LEAST_SAMPLES:
            raise too_few_samples(per_cycle, 1.0 / period)
        whole = t.size / per_cycle
        cycles = min(math.floor(whole + 0.05), MAX_CYCLES)
        if cycles < 2:
            raise too_few_cycles(whole, 1.0 / period)
        most = min(math.floor(0.45 * per_cycle), 1024)
        if harmonics is not None and not 1 <= harmonics <= most:
            many = "1 harmonic" if harmonics == 1 else f"{harmonics} harmonics"
            raise HistoryError(
                f"{many} of {1.0 / period:.5g} Hz from {per_cycle:.4g} samples in a cycle",
                f"give harmonics = {most} or fewer, but at least 1" if most else "sample faster",
            )
        gap = int(np.argmax(np.diff(t)))
        if t[gap + 1] - t[gap] > 0.25 * period:
            raise HistoryError(f"the record has a gap from {t[gap]:.6g} s to {t[gap + 1]:.6g} s", "cut it there")
        self._record = t, v
        block = max(1, int(per_cycle // 192))  # aligning needs no more samples than this in a cycle
        rows = t.size // block
        self._coarse = tuple(x[: rows * block].reshape(rows, block).mean(axis=1) for x in (t, v))
        self.asked = harmonics
        self.limit = min(most, MAX_HARMONICS) if harmonics is None else harmonics
        self.bounds = t[0] + period * np.arange(cycles + 1)
        self._align()
        whole = float(t[-1] - self.bounds[0]) / self.period + 1.0 / per_cycle
        if whole < 1.94:
            raise too_few_cycles(whole, 1.0 / self.period)
        self._finish()

    # Alignment

    def _align(self) -> None:
        self.place(*self._coarse)
        means = np.bincount(self.cell, self.v) / np.bincount(self.cell)
        self.drift = _at_bounds(means - np.mean(means))
        strong = self._demodulate(min(24, self.limit))
        for top in (max(8, strong), 24, 24, MAX_HARMONICS):
            top = min(top, self.limit)
            self.place(*self._coarse)
            coefficients = self.least_squares(top, self.v - self.broken_line(self.drift))
            rest = self._follow_drift(self.synthesis(coefficients))
            noise = float(np.var(rest - self.mean_cycle(rest)))
            coefficients[np.abs(coefficients) < 4.0 * math.sqrt(2.0 * noise / rest.size)] = 0.0  # tell no phases
            self._move_bounds(self.synthesis(1j * np.arange(top + 1) * coefficients), rest, noise)

    def _demodulate(self, top: int) -> int:
        """Bounds from the phase of the lowest strong harmonic, which may wander far; returns its number."""
        parts = self.by_cycle(self.v - self.broken_line(self.drift), top)
        strength = np.sum(np.abs(parts[:, 1:]) ** 2, axis=0)
        k = 1 + int(np.argmax(strength >= 0.25 * np.max(strength)))
        steps = np.angle(parts[1:, k] * parts[:-1, k].conj())
        if _rms(steps) < 1.0:  # noise alone makes 1.8
            self._shift_bounds(_at_bounds(np.concatenate([[0.0], np.cumsum(steps)]) / k))
        return k

    def _shift_bounds(self, lead: Array) -> None:
        """Move the bounds to where the phase, found to be ahead by `lead`, is whole."""
        bounds = self.bounds - lead * self.period / TURN
        bounds += min(0.0, float(self._record[0][0] - bounds[0]))  # the first cycle starts inside the record
        lengths = np.diff(bounds)
        if np.min(lengths) > 0.5 * np.median(lengths):
            last = self._record[0][-1] + 0.06 * self.period
            self.bounds = bounds[: max(3, int(np.searchsorted(bounds, last)))]
            self.drift = self.drift[: self.bounds.size]

    def _drift_basis(self) -> Array:
        """The knots that a drift may have: any, but in line where there are too few to tell a curve."""
        n = self.cycles
        return np.eye(n + 1) if n >= 4 else np.column_stack([np.ones(n + 1), np.linspace(-1.0, 1.0, n + 1)])

    def _follow_drift(self, fitted: Array) -> Array:
        """Fit the drift to what the harmonics leave, and return what both leave."""
        basis, data = self._drift_basis(), self.v - fitted
        matrix = basis.T @ self.hats(np.ones_like(self.u)) @ basis
        self.drift = basis @ np.linalg.solve(matrix, basis.T @ self.onto_hats(data))
        self.drift -= np.mean(self.broken_line(self.drift))
        rest = data - self.broken_line(self.drift)
        return np.asarray(rest - np.mean(rest))

    def _move_bounds(self, slope: Array, rest: Array, variance: float) -> None:
        """One Gauss–Newton step for the phases at the bounds, under a normal prior for the lengths of the cycles.

        The variance of that prior is what the lengths fitted without it vary, less what noise makes them vary:
        4.392 σ²/Σ slope² for knots of broken lines, the mean of (2 − 2 cos w)/(2/3 + cos w/3). The drift is free
        to move along, as the two are much alike in the half cycles at the ends.
        """
        n, basis = self.cycles, self._drift_basis()
        both = self.hats(slope) @ basis
        matrix = np.block([[self.hats(slope**2), both], [both.T, basis.T @ self.hats(np.ones_like(slope)) @ basis]])
        matrix += 1e-12 * np.diag(np.diag(matrix)) + 1e-300 * np.eye(matrix.shape[0])
        rhs = np.concatenate([self.onto_hats(slope * rest), basis.T @ self.onto_hats(rest)])
        noise = 6.0 * (math.sqrt(3.0) - 1.0) * variance * n / max(float(np.sum(slope**2)), 1e-300)
        lengths = TURN * np.diff(self.bounds) / self.period
        change = np.linalg.solve(matrix, rhs)
        spread = max(float(np.var(lengths - np.diff(change[: n + 1]), ddof=1)) - noise, 0.0)
        self.jitter = math.sqrt(spread) / TURN
        if variance > 0.0:
            difference = np.diff(np.eye(n + 1), axis=0)
            difference -= difference.mean(axis=0)
            weight = variance / max(spread, 1e-3 * noise, 1e-300)
            matrix[: n + 1, : n + 1] += weight * difference.T @ difference
            rhs[: n + 1] += weight * difference.T @ (lengths - lengths.mean())
            change = np.linalg.solve(matrix, rhs)
        self.drift = self.drift + basis @ change[n + 1 :]
        self._shift_bounds(np.clip(change[: n + 1], -1.0, 1.0))

    # Results

    def _finish(self) -> None:
        self.place(*self._record)
        coefficients = self.least_squares(self.limit, self.v - self.broken_line(self.drift))
        rest = self._follow_drift(self.synthesis(coefficients))
        coefficients += self.least_squares(self.limit, rest)
        fitted = self.synthesis(coefficients)
        coefficients[0] += np.mean(self.v - self.broken_line(self.drift) - fitted)
        self.rest = self._follow_drift(fitted)
        self._start = TURN * float(self.u[0])  # taken away, so that the first sample gets phase 0
        self.coefficients = coefficients * np.exp(1j * self._start * np.arange(coefficients.size))
        self.alternating = math.sqrt(0.5 * float(np.sum(np.abs(coefficients[1:]) ** 2)))
        self.parts = self.by_cycle(self.rest, self.limit)

    def kept(self) -> ComplexArray:
        """The coefficients that matter; those between that do not are zero."""
        if self.asked is not None:
            return np.asarray(self.coefficients)
        variance = np.sum(np.abs(self.parts[:, 1:]) ** 2, axis=0) / (self.cycles - 1) / self.cycles
        # a few cycles give a poor variance, so neighbouring harmonics share it
        near = np.arange(self.limit)
        sums = np.concatenate([[0.0], np.cumsum(variance)])
        high, low = np.minimum(near + 5, self.limit), np.maximum(near - 4, 0)
        variance = np.maximum(variance, (sums[high] - sums[low]) / (high - low))
        size = np.abs(self.coefficients[1:])
        keep = (size > SIGNIFICANT * np.sqrt(variance)) & (size > NEGLIGIBLE * np.max(size))
        top = int(np.max(np.flatnonzero(keep), initial=-1)) + 1
        return np.asarray(self.coefficients[: top + 1] * np.concatenate([[True], keep[:top]]))

    def scatter_and_residual(self, kept: ComplexArray) -> tuple[float, float]:
        """rms of the cycles about the mean cycle, and of the mean cycle less the harmonics kept."""
        back = np.exp(-1j * self._start * np.arange(kept.size))
        rest = self.v - self.broken_line(self.drift) - self.synthesis(kept * back)
        mean = self.mean_cycle(rest)
        freedom = math.sqrt(self.cycles / (self.cycles - 1))  # the mean cycle has taken its part
        return freedom * _rms(rest - mean) / self.alternating, _rms(mean) / self.alternating

    def cycles_in_turn(self) -> int:
        """How many cycles it takes until the record repeats: more than 1 when successive cycles differ.

        A line at a/b of the cycle frequency in what the fit leaves of the cycles, or in their lengths, that stands
        out from the rest of that spectrum.
        """
        slope = math.sqrt(float(np.sum(np.abs(np.arange(self.coefficients.size) * self.coefficients) ** 2)))
        lengths = slope * TURN * (np.diff(self.bounds) / self.period - 1.0 + 0j)
        for b in range(2, 17):
            n = self.cycles // b * b
            if n < min(3, b) * b:  # two turns of two cycles, three of more
                break
            power = np.abs(np.fft.fft(np.column_stack([lengths, self.parts[:, 1:]])[:n], axis=0)) ** 2
            power = power[: n // 2 + 1] + power[-np.arange(n // 2 + 1)]  # both signs
            # a single number for a cycle needs the higher level; the harmonics count together, the low ones also alone
            sums = np.cumsum(power[:, 1:], axis=1)[:, [min(4, self.limit) - 1, min(16, self.limit) - 1, -1]]
            tests = [(power[:, 0], 8.0), *((column, 4.0) for column in sums.T)]
            least = (2.0 * n * 0.01 * self.alternating) ** 2
            if any(_line_at(spectrum, n // b, chance, least) for spectrum, chance in tests):
                return b
        return 1


def _line_at(spectrum: Array, step: int, chance: float, least: float) -> bool:
    """Whether a spectrum has a line at a multiple of `step` that stands out from the rest and exceeds `least`."""
    lines = np.arange(step, spectrum.size, step)
    others = np.delete(spectrum, [0, *lines])
    # F distribution: passed by chance once in 10^chance if the others are noise of one degree of freedom each
    level = others.size * (10.0 ** (chance / others.size) - 1.0) * float(np.mean(others))
    beside = np.concatenate([[0.0], spectrum[1:], [0.0]])
    near = np.maximum(beside[lines - 1], beside[lines + 1])
    return bool(np.any((spectrum[lines] > max(level, least)) & (spectrum[lines] > 4.0 * near)))


def _at_bounds(centres: Array) -> Array:
    """Values at the cycle boundaries from those at the middles of the cycles."""
    inner = 0.5 * (centres[1:] + centres[:-1])
    return np.concatenate([[1.5 * centres[0] - 0.5 * centres[1]], inner, [1.5 * centres[-1] - 0.5 * centres[-2]]])


def _rms(data: Array) -> float:
    return math.sqrt(float(np.mean(data**2)))
