"""The fit of one repeated waveform to a record: boundaries of the cycles, drift and harmonics."""

from __future__ import annotations

import math

import numpy as np

from percuss.errors import HistoryError
from percuss.recordings.columns import Array, ComplexArray

# ---- A first period of a record, to about a part in a thousand, from its autocorrelation

LEAST_SAMPLES = 8  # per cycle
_ROUNDING = 1e-12  # what computing with n samples leaves of a slow record, relative to it


def _autocorrelation(t: Array, v: Array, window: int = 0) -> tuple[float, Array]:
    """Step, and autocorrelation r(lag) in [−1, 1] (McLeod's NSDF), less a cubic and the mean over `window`."""
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


# ---- The fit of one repeated waveform to a record: boundaries of the cycles, drift and harmonics

TURN = 2.0 * math.pi
MAX_CYCLES = 400  # cycles beyond these add nothing and are left out (the report says so)
MAX_HARMONICS = 64
SIGNIFICANT = 3.5  # standard errors: one false harmonic in some thousand records
NEGLIGIBLE = 1e-3  # of the largest harmonic


class CycleFit:
    """The model at the head of ``history.py``, fitted to the whole cycles of a record.

    Attributes: `t`, `v` the samples used, for each of these `cell` the number of its cycle, `u` the fraction of that
    cycle gone by, and `turn` exp(2πiu); `bounds` the times of the cycle boundaries; `drift` at these boundaries;
    `coefficients`; `rest` what the fit leaves of every sample; `jitter`; `alternating` the rms of the fitted cycle.
    """

    bounds: Array

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

    @property
    def cycles(self) -> int:
        return int(self.bounds.size) - 1

    @property
    def period(self) -> float:
        return float(self.bounds[-1] - self.bounds[0]) / self.cycles

    # Samples by their place: harmonics have whole numbers, so one is at exp(2πi · fraction of its own cycle)

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
        """Coefficients 0 … top of the data: a Toeplitz system by FFTs, phases to 1/8192 turn, corrected once."""
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
        """One Gauss–Newton step for the phases at the bounds, under a normal prior for the lengths of the cycles."""
        # The variance of that prior is what the lengths fitted without it vary, less what noise makes them vary: 4.392
        # σ²/Σ slope² for knots of broken lines, the mean of (2 − 2 cos w)/(2/3 + cos w/3). The drift is free to move
        # along, as the two are much alike in the half cycles at the ends.
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
        """After how many cycles the record repeats: a line at a/b of the frequency in residuals or lengths."""
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


def _toeplitz_solve(column: ComplexArray, rhs: ComplexArray) -> ComplexArray:
    """A nearly diagonal Hermitian Toeplitz system by conjugate gradients: a threaded BLAS takes 50 ms for it."""
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


# ---- Where in its cycle each sample of a record lies, by the alignment that its load was made with


def recorded_phases(time: Array, values: Array, frequency: float | None) -> Array:
    """The phase of the load (rad) at every sample, increasing, 0 at the first; `frequency` as of `analyse`."""
    t = time - time[0]
    middle, scale = 0.5 * (np.max(values) + np.min(values)), 0.5 * float(np.ptp(values))
    v = (values - middle) / (scale or 1.0)
    fit = CycleFit(t, v, found_period(t, v) if frequency is None else 1.0 / frequency, None)
    turns = np.interp(t, fit.bounds, np.arange(fit.bounds.size, dtype=float))
    beyond = t > fit.bounds[-1]
    turns[beyond] += (t[beyond] - fit.bounds[-1]) / fit.period
    return np.asarray(2.0 * np.pi * (turns - turns[0]))
