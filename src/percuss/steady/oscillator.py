"""Damped oscillators, u'' + d u' + ω² u = 0: their propagator and the functions that stay exact as d → 0.

Everything broadcasts over modes, each with its own damping, and times; overdamped and critically damped modes are no
special case for the caller.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from percuss.halting import look
from percuss.model import Body, Modes
from percuss.model.checks import Array, ComplexArray

__all__ = ["Propagator", "dissipated", "flights", "free_sum", "phi1", "phi2", "propagator"]

_CHUNK = 1 << 20  # modes × times handled at once
_EVEN = 48  # times at one distance from which on products of exponentials are quicker than exponentials
_TURNS = 4.0 * math.pi  # times since a step of the load are as exact as the phases, up to here, that they come from
_MUCH = 1 << 13  # modes × times from which on it is worth while to look whether they are
_SMALL = 0.1  # below this the differences in phi2 would lose digits and the series takes over


def phi1(x: npt.ArrayLike) -> Array:
    """(1 − exp(−x))/x, with its limit 1 at x = 0."""
    x = np.asarray(x, dtype=float)
    safe = np.where(x == 0.0, 1.0, x)
    return np.asarray(np.where(x == 0.0, 1.0, -np.expm1(-safe) / safe))


def phi2(x: npt.ArrayLike) -> Array:
    """(exp(−x) − 1 + x)/x², with its limit 1/2 at x = 0."""
    x = np.asarray(x, dtype=float)
    small = np.abs(x) < _SMALL
    everywhere = bool(small.all())
    y = np.asarray(x if everywhere else np.where(small, x, 0.0), dtype=np.float64)
    series = np.full(y.shape, 1.0 / 11.0)
    for j in range(10, 1, -1):  # 1/2 − x/6 + x²/24 − …, by Horner's rule
        series = (1.0 - y * series) / j
    if everywhere:
        return np.asarray(series)
    safe = np.where(small, 1.0, x)
    return np.asarray(np.where(small, series, (np.expm1(-safe) + safe) / safe**2))


def _one_for_all(d: npt.ArrayLike) -> Array:
    """Damping, as a single number where all modes have the same: then it is turned into exponentials only once."""
    d = np.asarray(d, dtype=float)
    return d.reshape(-1)[0] if d.size and np.all(d == d.reshape(-1)[0]) else d


class Propagator(NamedTuple):
    """Φ(t) = [[a, b], [c, e]] of (u, u'), and numbers of it that would cancel if taken from a … e.

    `half` is exp(−dt/2); `versine` is exp(−dt/2)(1 − cos λt).
    """

    a: Array
    b: Array
    c: Array
    e: Array
    half: Array
    versine: Array


def propagator(omega: npt.ArrayLike, d: npt.ArrayLike, t: npt.ArrayLike) -> Propagator:
    """Propagator over time t ≥ 0 of oscillators with undamped frequency `omega` > 0 and damping `d` ≥ 0.

    Parameters
    ----------
    omega, d, t
        Broadcast against each other; dimensionless.
    """
    omega, t = np.asarray(omega, dtype=float), np.asarray(t, dtype=float)
    half_d = 0.5 * _one_for_all(d)
    square = omega**2 - half_d**2
    half = np.exp(-half_d * t)
    if np.all(square > 0.0):
        angle = np.sqrt(square) * t
        cosine, b = half * np.cos(angle), half * t * np.sinc(angle / np.pi)
        versine = half * 2.0 * np.sin(0.5 * angle) ** 2
    else:
        rate = np.sqrt(np.abs(square))
        over = square < 0.0
        angle = np.where(over, 0.0, rate) * t
        # exp(−dt/2) cosh and sinh without overflow: the slow decay is ω²/(d/2 + μ)
        slow = np.exp(-np.where(over, omega**2 / (half_d + rate), 0.0) * t)
        spread = np.where(over, 2.0 * rate, 0.0) * t
        cosine = np.where(over, 0.5 * slow * (1.0 + np.exp(-spread)), half * np.cos(angle))
        b = np.where(over, slow * t * phi1(spread), half * t * np.sinc(angle / np.pi))
        versine = np.where(over, half - cosine, half * 2.0 * np.sin(0.5 * angle) ** 2)
    return Propagator(cosine + half_d * b, b, -(omega**2) * b, cosine - half_d * b, half, versine)


@lru_cache(maxsize=8)
def flights(body: Body, at: int, period: float, modes: int) -> tuple[Modes, Propagator]:
    """The elastic modes n = 1 … `modes` and their propagators over one period, each of shape (modes,).

    The last few are kept: they are the same for every load at the place number `at`, every phase and contact law.
    """
    known = body.modes(modes, at)
    step = propagator(known.omega, known.damping, period)
    for values in step:
        values.setflags(write=False)
    return known, step


def free_sum(omega: Array, d: npt.ArrayLike, start: tuple[Array, Array], t: Array, rows: Array) -> tuple[Array, Array]:
    """Σ_n rows[i, n] z_n(t) and its derivative for free oscillators z_n: the free motion of the bar.

    Parameters
    ----------
    omega, d
        Undamped frequencies and damping, each of shape (N,); a number when all have the same damping.
    start
        z_n and z_n' at t = 0, each of shape (N,).
    t
        Times, shape (nt,).
    rows
        Weights of the first `rows.shape[1]` modes, shape (ni, modes).

    Returns
    -------
    tuple of numpy.ndarray
        Two arrays of shape (ni, nt).
    """
    modes, half_d = rows.shape[1], 0.5 * _one_for_all(d)
    half_d = half_d[:modes] if half_d.ndim else half_d
    omega, z, v = omega[:modes], start[0][:modes], start[1][:modes]
    ringing = omega > half_d * (1.0 + 1e-3)  # the others do not oscillate, or nearly so
    if ringing.all():
        both = _ringing_sum(omega, half_d, (z, v), t, rows)
    else:
        half_d = np.broadcast_to(half_d, omega.shape)
        both = _ringing_sum(omega[ringing], half_d[ringing], (z[ringing], v[ringing]), t, rows[:, ringing])
        slow = ~ringing
        both += _creeping_sum(omega[slow], 2.0 * half_d[slow], (z[slow], v[slow]), t, rows[:, slow])
    return both[: rows.shape[0]], both[rows.shape[0] :]


def _ringing_sum(omega: Array, half_d: Array, start: tuple[Array, Array], t: Array, rows: Array) -> Array:
    """`free_sum` of modes that oscillate; the sum and its derivative, shape (2 ni, nt)."""
    z, v = start
    rate = np.sqrt(omega**2 - half_d**2)
    exponent = -half_d + 1j * rate
    turned = rows * (z - 1j * (v + half_d * z) / rate)
    weights = np.concatenate([turned, turned * exponent])
    much = rate.size * t.size >= _MUCH
    return _even_sum(weights, exponent, t) if much and _is_even(t) else _plain_sum(weights, exponent, t)


def _creeping_sum(omega: Array, d: Array, start: tuple[Array, Array], t: Array, rows: Array) -> Array:
    """The same of modes that do not oscillate, or nearly so."""
    z, v = start[0][:, None], start[1][:, None]
    both = np.empty((2 * rows.shape[0], t.size))
    width = max(1, _CHUNK // omega.size)
    for i in range(0, t.size, width):
        look()
        step = propagator(omega[:, None], d[:, None], t[None, i : i + width])
        both[: rows.shape[0], i : i + width] = rows @ (step.a * z + step.b * v)
        both[rows.shape[0] :, i : i + width] = rows @ (step.c * z + step.e * v)
    return both


def _plain_sum(weights: ComplexArray, exponent: ComplexArray, t: Array) -> Array:
    """Re Σ_n w_in exp(e_n t), time by time; shape (ni, nt)."""
    both = np.empty((weights.shape[0], t.size))
    width = max(1, _CHUNK // max(1, exponent.size))
    for i in range(0, t.size, width):
        look()
        both[:, i : i + width] = (weights @ np.exp(np.outer(exponent, t[i : i + width]))).real
    return both


def _is_even(t: Array) -> bool:
    """Whether so many times follow each other at one distance that `_even_sum` is worth while."""
    if t.size < _EVEN:
        return False
    step = (t[-1] - t[0]) / (t.size - 1)
    off = np.abs(t - (t[0] + step * np.arange(t.size))).max()
    return bool(off <= 4.0 * np.finfo(float).eps * max(abs(float(t[0])), abs(float(t[-1])), _TURNS))


def _even_sum(weights: ComplexArray, exponent: ComplexArray, t: Array) -> Array:
    """The sum of `_plain_sum` for times at one distance, summed as a matrix product.

    As exp(e(t_a + τ_b)) = exp(e t_a) exp(e τ_b), it takes √nt exponentials of each mode in place of nt; what is left is
    a twentieth of their time.
    """
    fine = math.isqrt(t.size - 1) + 1
    coarse = -(-t.size // fine)
    step = (t[-1] - t[0]) / (t.size - 1)
    near = np.exp(np.outer(exponent, step * np.arange(fine)))
    both = np.zeros((weights.shape[0], coarse * fine))
    width = max(1, _CHUNK // (weights.shape[0] * coarse))
    for i in range(0, exponent.size, width):
        look()
        part = slice(i, i + width)
        far = np.exp(np.outer(t[0] + step * fine * np.arange(coarse), exponent[part]))
        turned = (weights[:, None, part] * far).reshape(-1, far.shape[1])
        # Re of a product, as real products: half the work of the complex one
        both += (turned.real @ near[part].real - turned.imag @ near[part].imag).reshape(both.shape)
    return both[:, : t.size]


def dissipated(omega: Array, d: npt.ArrayLike, start: tuple[Array, Array], t: Array) -> Array:
    """d ∫₀ᵗ z'² of free oscillators, from z' = Re Z exp((−d/2 + iλ)t); overdamped ones by their loss of energy.

    Parameters
    ----------
    omega, d, t
        Undamped frequencies, damping and times; broadcast with the arrays of `start`.
    start
        z and z' at t = 0.
    """
    z, v = start
    d = _one_for_all(d)
    if not np.any(d):
        return np.zeros(np.broadcast_shapes(np.shape(omega), np.shape(z), np.shape(t)))
    ringing = omega > 0.5 * d * (1.0 + 1e-3)
    rate = np.sqrt(np.where(ringing, omega**2 - 0.25 * d**2, 1.0))
    exponent = -0.5 * d + 1j * rate
    amplitude = exponent * (z - 1j * (v + 0.5 * d * z) / rate)
    swing = (amplitude**2 * np.expm1(2.0 * exponent * t) / (2.0 * exponent)).real
    lost = 0.5 * (np.abs(amplitude) ** 2 * -np.expm1(-d * t) + d * swing)
    step = propagator(omega, d, t)
    end, end_v = step.a * z + step.b * v, step.c * z + step.e * v
    fallen = 0.5 * (v**2 - end_v**2 + omega**2 * (z**2 - end**2))
    return np.asarray(np.where(ringing, lost, fallen))
