"""A synthetic history of chamber pressure, for the catalogue's sample cases.

No machine was measured: the file says so in its first line. It has what a measured history has, noise, cycles of
slightly different length and a drifting mean, so that the whole way from a recording to a load is walked.
"""

from __future__ import annotations

import math
import os
from collections.abc import Sequence

import numpy as np

from percuss.atomic_write import write_whole


def write_sample_history(
    path: str | os.PathLike[str],
    *,
    pressure_coefficients: Sequence[complex],
    frequency: float,
    cycles: int = 40,
    sample_rate: float = 50e3,
    noise: float = 0.02,
    jitter: float = 0.003,
    drift: float = 0.02,
    seed: int = 1977,
) -> None:
    """Write "time [s]" and "pressure [MPa]", same bytes for the same arguments; noise, drift: parts of the rms."""
    coefficients = np.asarray(pressure_coefficients, dtype=complex)
    # PCG64's raw integers are the same everywhere and for ever; numpy may change how it makes normal numbers of them
    raw = np.random.PCG64(seed)
    lengths = (1.0 + jitter * _normal(raw, cycles)) / frequency
    lengths *= cycles / frequency / lengths.sum()
    bounds = np.concatenate([[0.0], np.cumsum(lengths)])
    time = np.arange(math.floor(cycles * sample_rate / frequency)) / sample_rate
    turns = np.interp(time, bounds, np.arange(cycles + 1.0))
    values = np.full(time.size, coefficients[0].real)
    for k, c in enumerate(coefficients[1:], start=1):
        if c != 0:
            values += (c * np.exp(2j * math.pi * k * turns)).real
    rms = math.sqrt(0.5 * float(np.sum(np.abs(coefficients[1:]) ** 2)))
    values += rms * (noise * _normal(raw, time.size) + drift * (time / time[-1] - 0.5))
    head = (
        "# Synthetic history of chamber pressure: computed, not measured on any machine\n"
        f"# {cycles} cycles at {frequency:.6g} Hz, sampled at {sample_rate:.6g} Hz, noise {100 * noise:.3g} %, "
        f"jitter {100 * jitter:.3g} %, drift {100 * drift:.3g} %, seed {seed}\n"
        "time [s],pressure [MPa]\n"
    )
    digits = max(3, math.ceil(math.log10(sample_rate)))
    row = f"%.{digits}f,%.4f\n"
    body = "".join([row % pair for pair in zip(time.tolist(), (1e-6 * values).tolist(), strict=True)])
    write_whole(path, head + body)


def _normal(raw: np.random.PCG64, count: int) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    """Normal numbers by Box and Muller from the generator's 64-bit integers."""
    pairs = (count + 1) // 2
    uniform = (raw.random_raw(2 * pairs) >> np.uint64(11)).astype(float) * 2.0**-53
    radius = np.sqrt(-2.0 * np.log1p(-uniform[:pairs]))
    angle = 2.0 * math.pi * uniform[pairs:]
    return np.concatenate([radius * np.cos(angle), radius * np.sin(angle)])[:count]
