"""The motion in closed form from an event on, at any place and time: no engine, only the formulas of theory §2."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from percuss.model.checks import Array
from percuss.simulate.spectrum import Spectrum

__all__ = ["Anchor", "Modes", "drift", "free_motion", "modal_motion"]

_TURN = 2.0 * np.pi


class Oscillators(Protocol):
    """Damped oscillators, each array of shape (N,); a `Spectrum` is such."""

    @property
    def omega(self) -> Array: ...
    @property
    def damping(self) -> Array: ...
    @property
    def square(self) -> Array: ...
    @property
    def lam(self) -> Array: ...


@dataclass(frozen=True)
class Anchor:
    """The state at an instant of free motion.

    Parameters
    ----------
    phase, piece
        Load phase, and the number of the load's step that holds.
    gap, rigid_rate, z
        u(1), u_0' and the amplitudes of the free motion, shape (2, N).
    """

    phase: float
    piece: int
    gap: float
    rigid_rate: float
    z: Array


@dataclass(frozen=True)
class Modes:
    """u_n and u_n', n = 0 … N, at some times; each of shape (N+1, len(t))."""

    displacement: Array
    velocity: Array


def modal_motion(spectrum: Spectrum, anchor: Anchor, tau: Array) -> Modes:
    """The modes at the times `tau` ≥ 0, ascending, after an anchor, as long as the bar touches nothing."""
    load = spectrum.system.load
    if not load.is_piecewise:
        return _within(spectrum, anchor, tau)
    parts, done, gone = [], 0, 0.0
    while True:
        following = (anchor.piece + 1) % len(load.breaks)
        ahead = load.breaks[following] - anchor.phase
        ahead += _TURN if following == 0 and ahead < 0.0 else 0.0
        ahead = max(ahead, 0.0)
        stop = int(np.searchsorted(tau, gone + ahead, side="left"))
        last = done + stop - done == tau.size
        parts.append(_within(spectrum, anchor, tau[done:stop] - gone))
        if last:
            break
        anchor = _over_step(spectrum, anchor, ahead, following)
        done, gone = stop, gone + ahead
    return Modes(
        np.concatenate([part.displacement for part in parts], axis=1),
        np.concatenate([part.velocity for part in parts], axis=1),
    )


def _within(spectrum: Spectrum, anchor: Anchor, tau: Array) -> Modes:
    """Under one form of the load."""
    d, mean, k = spectrum.system.d, spectrum.mean(anchor.piece), spectrum.k
    turned = np.exp(1j * k * anchor.phase)
    waves = turned[:, None] * np.exp(1j * np.outer(k, tau))  # e^{ik(θ+τ)}, shape (K, T)
    start, _ = spectrum.modal(anchor.z, anchor.gap, anchor.rigid_rate, anchor.phase, mean)
    left, h, h_rate = free_motion(spectrum, tau)
    z0, w0 = anchor.z[0][:, None], spectrum.free_rate(anchor.z)[:, None]
    q = z0 * left + w0 * h
    rate = w0 * h_rate - z0 * (spectrum.omega[:, None] ** 2 * h)
    q = q + (spectrum.response.T @ waves).real + mean * spectrum.statics[:, None]
    rate = rate + ((1j * k[:, None] * spectrum.response).T @ waves).real

    if not spectrum.system.body.is_free:
        mean = 0.0
    first, second = drift(d, tau)
    drifting = anchor.rigid_rate - float(((1j * k * turned) @ spectrum.rigid).real)
    steps = turned[:, None] * _turn_less_one(np.outer(k, tau))
    u0 = start[0] + drifting * first + mean * second + (spectrum.rigid @ steps).real
    v0 = anchor.rigid_rate + (mean - d * drifting) * first + ((1j * k * spectrum.rigid) @ steps).real
    unit = spectrum.unit[:, None]
    return Modes(np.vstack([u0, q / unit]), np.vstack([v0, rate / unit]))


def _over_step(spectrum: Spectrum, anchor: Anchor, ahead: float, piece: int) -> Anchor:
    """The anchor at the next step of the load."""
    at = _within(spectrum, anchor, np.array([ahead]))
    u, v = at.displacement[:, 0], at.velocity[:, 0]
    phase = spectrum.system.load.breaks[piece]
    z = spectrum.amplitudes(u, v, phase, spectrum.mean(piece))
    return Anchor(phase, piece, float(u[0] + spectrum.unit @ u[1:]), float(v[0]), z)


def free_motion(spectrum: Oscillators, tau: Array) -> tuple[Array, Array, Array]:
    """e, h and h' of the free motion q = q(0) e + q'(0) h, q' = q'(0) h' − q(0) ω² h; each of shape (N, T)."""
    half, square = 0.5 * spectrum.damping[:, None], spectrum.square[:, None]
    t = tau[None, :]
    fade = np.exp(-half * t)
    lam = spectrum.lam[:, None]
    c, h = fade * np.cos(lam * t), fade * np.sin(lam * t) / lam
    e, rate = c + half * h, c - half * h
    over = spectrum.square <= 0.0
    if over.any():
        kappa = np.sqrt(-square[over])
        slow = spectrum.omega[over, None] ** 2 / (half[over] + kappa)  # d/2 − κ
        fade, safe = np.exp(-slow * t), np.where(kappa > 0.0, kappa, 1.0)
        h[over] = fade * np.where(kappa > 0.0, -np.expm1(-2.0 * kappa * t) / (2.0 * safe), t)
        e[over] = fade + slow * h[over]
        rate[over] = fade * np.exp(-2.0 * kappa * t) - slow * h[over]
    return e, h, rate


def drift(d: float, tau: Array) -> tuple[Array, Array]:
    """(1 − e^{−dτ})/d and its integral, for any d ≥ 0."""
    x = d * tau
    small = x < 0.5
    series = np.zeros_like(x)
    for k in range(18, 0, -1):  # Σ (−x)^j/(j+2)!
        series = (1.0 - x * series) / (k + 1.0)
    series = np.where(small, series, 0.0)
    first = np.where(small, tau * (1.0 - x * series), -np.expm1(-x) / (d if d else 1.0))
    return first, np.where(small, tau**2 * series, (tau - first) / (d if d else 1.0))


def _turn_less_one(angle: Array) -> Array:
    """e^{iα} − 1 without cancellation."""
    half = np.sin(0.5 * angle)
    return np.asarray(-2.0 * half * half + 1j * np.sin(angle))
