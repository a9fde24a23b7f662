"""What a strain gauge on the rod sees: the incident wave, the reflected one, and the energy in them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from percuss.blow.figures import Pulse
from percuss.blow.wave_history import Trace
from percuss.errors import ParameterError
from percuss.model.checks import Array, numbers, positive

_NOTHING = 1e-12  # share of the peak that counts as no force


@dataclass(frozen=True, eq=False)
class GaugeWaves:
    """The forces in the two waves that pass a gauge; their sum and the preload are the force there, compression
    positive.

    `incident` is Z f of the wave from the struck face, N where nothing has come back yet; `reflected` −Z g of the wave
    that comes back; `impedance` Z at the gauge; `preload` the static force there under the feed, which a gauge that is
    set to zero before the blow does not show.
    """

    incident: Trace
    reflected: Trace
    impedance: float
    preload: float = 0.0

    @property
    def incident_energy(self) -> float:
        """Z ∫ f² dt over the window."""
        return self.incident.product_integral(self.incident) / self.impedance

    @property
    def reflected_energy(self) -> float:
        """Z ∫ g² dt over the window."""
        return self.reflected.product_integral(self.reflected) / self.impedance

    @property
    def tool_energy(self) -> float:
        """∫ F²/Z dt of the force F at the gauge: the energy that passes only as long as nothing comes back."""
        both = self.incident.product_integral(self.reflected)
        return self.incident_energy + self.reflected_energy + 2.0 * both / self.impedance


def first_pulse(waves: GaugeWaves, start: float) -> Pulse | None:
    """The incident wave at the struck face from the first contact until its force is 0 or a returned wave arrives."""
    last = _arrival(waves)
    incident = waves.incident.around(start, last)
    peaks = incident.piece_peaks
    inside = (incident.times[:-1] < last) & (incident.times[1:] > start)
    if not inside.any() or not peaks[inside].max() > 0.0:
        return None
    end = _falls(incident, start, last, _NOTHING * float(peaks[inside].max()))
    edges = np.unique(np.clip(incident.times, start, end))
    half, (nodes, weights) = 0.5 * np.diff(edges)[:, None], np.polynomial.legendre.leggauss(26)
    force = incident.at(edges[:-1, None] + half * (1.0 + nodes))
    momentum = float(np.sum(half * weights * force))
    energy = float(np.sum(half * weights * force**2)) / waves.impedance
    times, values = incident.sampled(2000)
    here = (times >= start) & (times <= end)
    top = float(peaks[inside & (incident.times[:-1] < end)].max())
    at_top = float(times[here][np.argmax(values[here])])
    return Pulse(end - start, at_top - start, top, energy, momentum)


def _arrival(waves: GaugeWaves) -> float:
    """When the returned wave begins; the end of the window where none does."""
    back = waves.reflected
    moving = np.flatnonzero(abs(back.coefficients).max(axis=1) > _NOTHING * abs(waves.incident.coefficients).max())
    return float(back.times[moving[0]] if moving.size else back.times[-1])


def _falls(trace: Trace, start: float, last: float, least: float) -> float:
    """When a trace that is positive after the start is at most `least` for the first time; `last` if not before."""
    for k in np.flatnonzero((trace.times[1:] > start) & (trace.times[:-1] < last)):
        row, (low, high) = trace.coefficients[k], trace.times[k : k + 2]
        if not row[1:].any():
            if row[0] <= least:
                return float(min(last, max(low, start)))
            continue
        series = np.polynomial.Chebyshev(np.trim_zeros(row, "b"))
        zeros = (series - least).roots()
        real = np.sort(zeros.real[(abs(zeros.imag) < 1e-9) & (abs(zeros.real) <= 1.0)])
        times = 0.5 * (low + high) + 0.5 * (high - low) * np.append(-1.0, real)
        for time, x in zip(times, np.append(-1.0, real), strict=True):
            if time >= start and series(min(1.0, x + 1e-6)) <= least:
                return float(min(last, time))
    return last


# ---- A measured force laid over the computed one at a gauge: the shift of the clock, the zero, the sign, what is left

_LEAST = 16  # samples in the window without which nothing can be laid over
_COARSE, _LONGEST = 4096, 1 << 19  # points in the window, and in the whole record, that the shift is searched for with
_ALIKE = 0.1  # share of the record's variance in the window that the computed force must explain
_ROUNDS, _TRIED = 5, 21
_SEEN = 0.01  # share of the computed force's variance that a record must at least cover


@dataclass(frozen=True)
class RecordFit:
    """How a measured force lies over the computed one, by least squares; residuals over its greatest value."""

    shift: float
    sign: int
    zero: float
    scale: float
    residual: float
    residual_scaled: float
    overlap: float


def fitted_record(
    waves: GaugeWaves, until: float, time: npt.ArrayLike, force: npt.ArrayLike, *, sign: int | None = None
) -> RecordFit:
    """Lay a measured force over that at a gauge."""
    # The shift is the one at which the computed force, a zero and a factor explain most of the record: searched for by
    # cross-correlation at all shifts, then refined by least squares on the samples. Before the blow the rod is at rest,
    # so what the record shows up to one window before the blow is compared with 0. The computed force is averaged over
    # the time between two samples, as a recorder does.
    # `until`: end of the window, in s. `time` (s, increasing), `force` (N), shape (n,): the record. `sign`: if known, 1
    # or −1; otherwise the one that fits better is taken.
    t, y, until = numbers("time", time), numbers("force", force), positive("until", until)
    if t.ndim != 1 or t.shape != y.shape or t.size < _LEAST or not (np.diff(t) > 0.0).all():
        raise ParameterError("time", time, f"{_LEAST} or more increasing times, and as many forces")
    if float(np.ptp(y)) <= 1e-12 * float(abs(y).max(initial=0.0)):
        raise ParameterError("force", force, "a record that is not constant", "check the column, and that it was on")
    step = float(np.median(np.diff(t)))
    computed = _Computed(waves, until, step)
    if not computed.peak > 0.0:
        raise ParameterError("until", until, "a window in which a wave reaches the gauge", "a later end of the window")
    origin = float(t[0])
    t = t - origin  # clocks of a day have few digits left for microseconds
    shift, wide = _coarse_shift(computed, until, t, y, step, sign)
    shift = _fine_shift(computed, until, t, y, shift, wide)
    return _fit(computed, until, t, y, shift, sign, origin)


class _Computed:
    """The computed force, averaged over the time between samples; 0 before the blow."""

    def __init__(self, waves: GaugeWaves, until: float, step: float) -> None:
        self.step = min(step, until)
        size = int(np.clip(8.0 * until / step, _COARSE, 1 << 20))
        grid = np.linspace(0.0, until, size)
        times = np.unique(np.concatenate([waves.incident.times, waves.reflected.times, grid]))
        times = times[(times >= 0.0) & (times <= until)]
        after = waves.incident.at(times) + waves.reflected.at(times)
        before = waves.incident.before(times) + waves.reflected.before(times)
        self.peak = float(max(abs(after).max(), abs(before[1:]).max(initial=0.0)))
        steps = 0.5 * np.diff(times) * (after[:-1] + before[1:])
        # beyond the window the last value goes on, for the average over its last sample
        self._times = np.concatenate([times, [until + self.step]])
        self._impulse = np.concatenate([[0.0], np.cumsum(steps), [float(steps.sum()) + self.step * float(before[-1])]])

    def at(self, times: Array) -> Array:
        half = 0.5 * self.step
        late, early = (np.interp(times + s, self._times, self._impulse) for s in (half, -half))
        return np.asarray((late - early) / self.step)


def _coarse_shift(
    computed: _Computed, until: float, t: Array, y: Array, step: float, sign: int | None
) -> tuple[float, float]:
    """The shift at which most of the record is explained, by cross-correlation, and how far it may be off."""
    h = max(step, until / _COARSE, float(t[-1]) / _LONGEST)
    inside = max(round(until / h), 2)
    record = np.interp(h * np.arange(int(t[-1] / h) + 1), t, y)
    record = record - np.median(record)
    pattern = computed.at(h * np.arange(-inside, inside + 1, dtype=float))
    size = 1 << int(np.ceil(np.log2(record.size + pattern.size)))

    def correlated(x: Array, p: Array) -> Array:
        found = np.fft.irfft(np.fft.rfft(x, size) * np.conj(np.fft.rfft(p, size)), size)
        return np.asarray(np.concatenate([found[size - pattern.size + 1 :], found[: record.size]]))

    ones, window = np.ones(record.size), np.ones(pattern.size)
    count = np.maximum(np.round(correlated(ones, window)), 1.0)
    total = correlated(ones, pattern)
    spread = correlated(ones, pattern**2) - total**2 / count
    common = correlated(record, pattern) - correlated(record, window) * total / count
    explained = common**2 / np.maximum(spread, _SEEN * float(spread.max()))
    explained[spread < _SEEN * float(spread.max())] = 0.0
    if sign is not None:
        explained[np.sign(common) != sign] = 0.0
    best = int(np.argmax(explained)) - pattern.size + 1  # where in the record the pattern begins
    return -h * (best + inside), 2.0 * h


def _fine_shift(computed: _Computed, until: float, t: Array, y: Array, shift: float, wide: float) -> float:
    """The shift of least squares near another one, on the samples that are in the window all the time."""
    used = (t + shift >= wide - until) & (t + shift <= until - wide)
    if np.count_nonzero(used) < _LEAST:
        return shift
    t, y = t[used], y[used] - float(y[used].mean())
    for _ in range(_ROUNDS):
        tried: Array = shift + wide * np.linspace(-1.0, 1.0, _TRIED, dtype=np.float64)
        explained = np.zeros(_TRIED)
        for i, one in enumerate(tried.tolist()):
            force = computed.at(t + one)
            force -= force.mean()
            square = float(force @ force)
            explained[i] = float(force @ y) ** 2 / square if square > 0.0 else 0.0
        shift = float(np.mean(tried[explained >= explained.max() * (1.0 - 1e-12)]))  # the middle of a flat top
        wide *= 0.2
    return shift


def _fit(
    computed: _Computed, until: float, t: Array, y: Array, shift: float, sign: int | None, origin: float
) -> RecordFit:
    used = (t + shift >= -until) & (t + shift <= until)
    inside = used & (t + shift >= 0.0)
    if np.count_nonzero(inside) < _LEAST:
        raise ParameterError(
            "time", t, f"a record with {_LEAST} or more samples in the window of the blow", "sample faster"
        )
    force, seen = computed.at(t[used] + shift), y[used]
    centred, deviation = force - force.mean(), seen - seen.mean()
    squares = float(centred @ centred)
    factor = float(centred @ deviation) / squares if squares > 0.0 else 0.0
    alike = factor * float(centred @ deviation) / float(deviation @ deviation) if deviation.any() else 0.0
    if alike < _ALIKE or (sign is not None and factor * sign <= 0.0):
        raise ParameterError(
            "force", y, "a record of the blow: nothing in it resembles the computed force",
            "check the column, the unit of time and the place of the gauge",
        )  # fmt: skip
    zero = float(seen.mean() - factor * force.mean())
    found = 1 if factor > 0.0 else -1
    one, measured = computed.at(t[inside] + shift), found * (y[inside] - zero)
    scale = found * factor

    def left(s: float) -> float:
        return float(np.sqrt(np.mean((measured - s * one) ** 2))) / computed.peak

    covered = min(float(t[-1]) + shift, until) - max(float(t[0]) + shift, 0.0)
    return RecordFit(shift - origin, found, zero, scale, left(1.0), left(scale), float(np.clip(covered / until, 0, 1)))
