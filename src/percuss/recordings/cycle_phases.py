"""The samples of a record by their place in its cycles, and what is linear once these places are known."""

from __future__ import annotations

import math

import numpy as np

from percuss.recordings.arrays import Array, ComplexArray
from percuss.recordings.repetition import LEAST_SAMPLES

__all__ = ["TURN", "CyclePhases"]

TURN = 2.0 * math.pi


class CyclePhases:
    """Samples cut into cycles at given boundaries.

    Attributes: `bounds` the times of the cycle boundaries; `t`, `v` the samples inside; for each of these `cell` the
    number of its cycle, `u` the fraction of that cycle gone by, and `turn` exp(2πiu).
    """

    bounds: Array

    @property
    def cycles(self) -> int:
        return int(self.bounds.size) - 1

    @property
    def period(self) -> float:
        return float(self.bounds[-1] - self.bounds[0]) / self.cycles

    # Phases. Harmonics have whole numbers, so a sample is at exp(2πi · fraction of its own cycle).

    def place(self, t: Array, v: Array) -> None:
        """Cut the samples of whole cycles and give each its cycle and its place in it."""
        end = int(np.searchsorted(t, self.bounds[-1], side="left"))
        self.t, self.v = t[:end], v[:end]
        inner = np.searchsorted(self.t, self.bounds[1:-1])
        self.cell = np.zeros(end, dtype=np.int64)
        np.add.at(self.cell, inner[inner < end], 1)
        self.cell = np.cumsum(self.cell)
        self.u = (self.t - self.bounds[self.cell]) / np.diff(self.bounds)[self.cell]
        self.turn = np.empty(end, complex)
        self.turn.real, self.turn.imag = np.cos(TURN * self.u), np.sin(TURN * self.u)  # twice as fast as exp

    def broken_line(self, knots: Array) -> Array:
        """For every sample the broken line through `knots` at the bounds."""
        return np.asarray(knots[self.cell] * (1.0 - self.u) + knots[self.cell + 1] * self.u)

    def hats(self, weight: Array) -> Array:
        """Σ weight · h_i h_j over the samples; h_i is the broken line that is 1 at bound i, 0 at the others."""
        n = self.cycles
        i, j = np.arange(n), np.arange(1, n + 1)  # the bounds before and after every cycle
        left, right = (1.0 - self.u) * weight, self.u * weight
        matrix = np.zeros((n + 1, n + 1))
        matrix[i, i] += np.bincount(self.cell, left * (1.0 - self.u))
        matrix[j, j] += np.bincount(self.cell, right * self.u)
        matrix[i, j] = matrix[j, i] = np.bincount(self.cell, left * self.u)
        return matrix

    def onto_hats(self, data: Array) -> Array:
        """Σ data · h_i over the samples."""
        before, after = np.bincount(self.cell, (1.0 - self.u) * data), np.bincount(self.cell, self.u * data)
        return np.asarray(np.append(before, 0.0) + np.append(0.0, after))

    def least_squares(self, top: int, data: Array) -> ComplexArray:
        """Coefficients 0 … top of the data; a Toeplitz system, as its columns are exp(ikθ).

        Phases are rounded to 1/8192 turn, so that FFTs do it; a second call with what is left corrects for that.
        """
        place = np.rint(8192.0 * self.u).astype(np.int64) % 8192
        rhs = np.fft.fft(np.bincount(place, data, 8192))[: top + 1]
        sums = np.resize(np.fft.fft(np.bincount(place, minlength=8192)).conj(), 2 * top + 1)
        both = _toeplitz_solve(sums.conj(), np.concatenate([rhs[:0:-1].conj(), rhs]))
        return np.concatenate([both[top : top + 1].real, 2.0 * both[top + 1 :]])

    def by_cycle(self, data: Array, top: int) -> ComplexArray:
        """Fourier coefficients 0 … top of every cycle, shape (cycles, top + 1), from phases rounded to 1/512 turn."""
        count = max(512, 4 * top)
        place = self.cell * count + np.rint(count * self.u).astype(np.int64) % count
        fold = np.bincount(place, data, self.cycles * count).reshape(self.cycles, count)
        parts = np.fft.rfft(fold, axis=1)[:, : top + 1]
        return np.asarray(2.0 * parts / np.bincount(self.cell, minlength=self.cycles)[:, None])

    def synthesis(self, coefficients: ComplexArray) -> Array:
        """For every sample the sum of the harmonics."""
        total = np.full_like(self.turn, coefficients[-1])
        for c in coefficients[-2::-1]:
            total *= self.turn
            total += c
        return np.asarray(total.real)

    def mean_cycle(self, data: Array) -> Array:
        """For every sample the mean of the data at its place in the cycle."""
        count = max(LEAST_SAMPLES, min(1024, self.t.size // self.cycles))
        place = np.clip((self.u * count).astype(np.int64), 0, count - 1)
        means = np.bincount(place, data, count) / np.maximum(np.bincount(place, minlength=count), 1)
        return np.asarray(means[place])


def _toeplitz_solve(column: ComplexArray, rhs: ComplexArray) -> ComplexArray:
    """Solve a Hermitian Toeplitz system that is nearly diagonal, by conjugate gradients with products by FFT.

    A threaded BLAS takes 50 ms for such a small system when the machine is busy; this takes one.
    """
    n = rhs.size
    length = 1 << (2 * n).bit_length()
    circulant = np.zeros(length, complex)
    circulant[:n], circulant[length - n + 1 :] = column, column[:0:-1].conj()
    kernel = np.fft.fft(circulant).real
    x, rest = np.zeros_like(rhs), rhs.copy()
    step, size = rest, float(np.sum(np.abs(rest) ** 2))
    least = 1e-28 * size
    for _ in range(300):
        if size <= least:
            break
        image = np.fft.ifft(kernel * np.fft.fft(step, length))[:n]
        move = size / float(np.sum(step.conj() * image).real)
        x, rest = x + move * step, rest - move * image
        size, before = float(np.sum(np.abs(rest) ** 2)), size
        step = rest + (size / before) * step
    return x
