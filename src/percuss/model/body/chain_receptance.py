"""Receptance of a chain of sections at complex frequencies: all its modes together, by transfer matrices.

U is the motion with unit displacement at a free end, M the sum of all mass between there and a point, each part times
its displacement: the force at the point is −z²M. U_L comes from the driven end, U_R from the striking end, and
w = U_L M_R + U_R M_L is the same everywhere. The answer to a unit force at p is −U_L(a) U_R(b)/(z² w), a the one of x
and p that is nearer to the driven end, b the other. Its rigid part −1/z² is taken off. Well below the first mode that
would cancel, so there U = 1 − z²D and M = m − z²Q are told by D and Q, and z² drops out of the difference.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from percuss.model.body.chain import Chain, Numbers, sinc_deficit
from percuss.model.checks import Array, ComplexArray

__all__ = ["elastic_receptance"]

_DEEP = 50.0  # Im zτ beyond which the wave that fades away is nothing beside the other


class _Motion(NamedTuple):
    """(U, M) times e^{−log}, or (D, Q) and log 0; first axis frequencies."""

    first: ComplexArray
    second: ComplexArray
    log: Array


def elastic_receptance(
    sections: Chain, z: ComplexArray, x: Array, source: float, lowest: float
) -> tuple[ComplexArray, ComplexArray]:
    """Σ_{n≥1} φ_n(x) φ_n(p)/(ω_n² − z²) and its slope, shapes (K, len(x)), of a unit force at p = `source`.

    Parameters
    ----------
    z
        Complex frequencies, Im z ≤ 0, shape (K,).
    lowest
        ω_1.
    """
    shape = np.empty((z.size, x.size), complex)
    slope = np.empty_like(shape)
    slow = np.abs(z) <= min(0.5 * lowest, 1.0 / float(sections.transit.sum()))
    for chosen, answer in ((slow, _slow), (~slow, _fast)):
        if chosen.any():
            shape[chosen], slope[chosen] = answer(sections, z[chosen], x, source)
    return shape, slope


def _slow(sections: Chain, z: ComplexArray, x: Array, source: float) -> tuple[ComplexArray, ComplexArray]:
    """Well below the first mode."""
    square = (z * z)[:, None]
    at_x, at_p = _both(sections, z, x, True), _both(sections, z, np.array([source]), True)
    (here, (m_x, n_x)), (there, (m_p, n_p)) = at_x, at_p
    left = (x < source)[None, :]  # of the source
    d_left, q_left = (np.where(left, own, other) for own, other in zip(here[0][:2], there[0][:2], strict=True))
    d_right = np.where(left, there[1].first, here[1].first)
    near_d, near_q = (np.where(left, own, other) for own, other in zip(here[1][:2], there[1][:2], strict=True))
    m, n = np.where(left, m_x, m_p), np.where(left, n_x, n_p)
    u_left, m_left = 1.0 - square * d_left, m - square * q_left
    w = u_left * (n - square * near_q) + (1.0 - square * near_d) * m_left
    shape = (m * d_left - q_left + u_left * (d_right - near_q) - near_d * m_left) / w
    force = np.where(
        left,
        (m_x - square * here[0].second) * (1.0 - square * there[1].first),
        -(n_x - square * here[1].second) * (1.0 - square * there[0].first),
    )
    return shape, force / w / sections.stiffness[sections.locate(x)[0]]


def _fast(sections: Chain, z: ComplexArray, x: Array, source: float) -> tuple[ComplexArray, ComplexArray]:
    """Where the rigid part is not much greater than what is left without it."""
    square = (z * z)[:, None]
    (x_left, x_right), _ = _both(sections, z, x, False)
    (p_left, p_right), _ = _both(sections, z, np.array([source]), False)
    w = p_left.first * p_right.second + p_right.first * p_left.second
    left = (x < source)[None, :]
    fading = np.exp(np.where(left, x_left.log - p_left.log, x_right.log - p_right.log))
    product = np.where(left, x_left.first * p_right.first, p_left.first * x_right.first)
    force = np.where(left, x_left.second * p_right.first, -p_left.first * x_right.second)
    shape = 1.0 / square - product * fading / (square * w)
    return shape, force * fading / w / sections.stiffness[sections.locate(x)[0]]


def _both(
    sections: Chain, z: ComplexArray, x: Array, slow: bool
) -> tuple[tuple[_Motion, _Motion], tuple[Array, Array]]:
    """The motions from the driven and from the striking end at points, and the masses on both sides of these."""
    section, time = sections.locate(x)
    rest = sections.transit[section] - time
    masses = sections.masses(section, time)
    turned = sections.mirrored
    left = _motion(sections, z, section, time, slow)
    return (left, _motion(turned, z, sections.size - 1 - section, rest, slow)), masses


def _motion(sections: Chain, z: ComplexArray, section: Numbers, time: Array, slow: bool) -> _Motion:
    """The motion from the first section's start on, at points; shapes (K, len(section))."""
    still = np.zeros_like(z)
    starts = [_Motion(still if slow else still + 1.0, still, np.zeros(z.size))]
    z_i, tau, m = sections.impedance, sections.transit, sections.before
    for i in range(int(section.max(initial=0))):
        here = starts[-1]
        starts.append(_deviating(here, z, z_i[i], tau[i], m[i]) if slow else _growing(here, z, z_i[i], tau[i]))
    at = _Motion(*(np.stack(parts, axis=-1)[:, section] for parts in zip(*starts, strict=True)))
    z = z[:, None]
    return _deviating(at, z, z_i[section], time, m[section]) if slow else _growing(at, z, z_i[section], time)


def _growing(state: _Motion, z: ComplexArray, impedance: Array, time: Array) -> _Motion:
    """(U, M) after some time of a wave along a section, its growth in the logarithm."""
    q = z * time
    depth = np.minimum(-q.imag, _DEEP)
    scale = np.exp(-depth)
    cosine, sine = np.cos(q.real - 1j * depth) * scale, np.sin(q.real - 1j * depth) * scale / z
    u = state.first * cosine - z * z * state.second * sine / impedance
    m = state.second * cosine + impedance * state.first * sine
    size = np.abs(u) + np.abs(z * m) / impedance
    return _Motion(u / size, m / size, state.log - q.imag + np.log(size))


def _deviating(state: _Motion, z: ComplexArray, impedance: Array, time: Array, before: Array) -> _Motion:
    """(D, Q) after some time of a wave along a section; `before` is the mass behind its start."""
    d, rest, _ = state
    q = z * time
    cosine = np.cos(q)
    sine = time * (1.0 - sinc_deficit(q))  # sin(zt)/z
    bend = 0.5 * (time * (1.0 - sinc_deficit(0.5 * q))) ** 2  # (1 − cos zt)/z²
    lag = time**3 * _cubic(q)  # (t − sin(zt)/z)/z²
    return _Motion(
        bend + d * cosine + (before - z * z * rest) * sine / impedance,
        before * bend + rest * cosine + impedance * (lag + d * sine),
        state.log,
    )


def _cubic(q: ComplexArray) -> ComplexArray:
    """(q − sin q)/q³, 1/6 at 0."""
    tiny = np.abs(q) < 1e-3
    far = np.where(tiny, 1.0, q)
    return np.asarray(np.where(tiny, (1.0 - q * q / 20.0) / 6.0, sinc_deficit(far) / far**2))
