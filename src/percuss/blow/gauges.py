"""What a strain gauge on the rod sees: the incident wave, the reflected one, and the energy in them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from percuss.blow.parts import Pulse
from percuss.blow.trace import Trace

__all__ = ["Waves", "first_pulse"]

_NOTHING = 1e-12
"""Share of the peak that counts as no force."""


@dataclass(frozen=True, eq=False)
class Waves:
    """The forces in the two waves that pass a gauge; their sum is the force there, compression positive.

    Parameters
    ----------
    incident
        Z f of the wave from the struck face: N where nothing has come back yet.
    reflected
        −Z g of the wave that comes back.
    impedance
        Z at the gauge.
    """

    incident: Trace
    reflected: Trace
    impedance: float

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


def first_pulse(waves: Waves, start: float) -> Pulse | None:
    """The incident wave at the struck face from the first contact until its force is 0 or a returned wave arrives."""
    last = _arrival(waves)
    whole = waves.incident
    count = max(1, int(np.searchsorted(whole.times, last)))
    incident = Trace(whole.times[: count + 1], whole.coefficients[:count])
    peaks = incident.piece_peaks
    inside = (incident.times[:-1] < last) & (incident.times[1:] > start)
    if not inside.any() or not peaks[inside].max() > 0.0:
        return None
    end = min(last, _falls(incident, start, _NOTHING * float(peaks[inside].max())))
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


def _arrival(waves: Waves) -> float:
    """When the returned wave begins; the end of the window where none does."""
    back = waves.reflected
    moving = np.flatnonzero(abs(back.coefficients).max(axis=1) > _NOTHING * abs(waves.incident.coefficients).max())
    return float(back.times[moving[0]] if moving.size else back.times[-1])


def _falls(trace: Trace, start: float, least: float) -> float:
    """When a trace that is positive after the start is at most `least` for the first time."""
    for k in np.flatnonzero(trace.times[1:] > start):
        row, (low, high) = trace.coefficients[k], trace.times[k : k + 2]
        if not row[1:].any():
            if row[0] <= least:
                return float(max(low, start))
            continue
        series = np.polynomial.Chebyshev(np.trim_zeros(row, "b"))
        zeros = (series - least).roots()
        real = np.sort(zeros.real[(abs(zeros.imag) < 1e-9) & (abs(zeros.real) <= 1.0)])
        times = 0.5 * (low + high) + 0.5 * (high - low) * np.append(-1.0, real)
        for time, x in zip(times, np.append(-1.0, real), strict=True):
            if time >= start and series(min(1.0, x + 1e-6)) <= least:
                return float(time)
    return float(trace.times[-1])
