"""Receptance of a chain of sections at complex frequencies: all its modes together, by transfer matrices.

U is the motion with unit displacement at a free end, M the mass that lies behind a point, each times its displacement:
the force there is −z²M. U_L comes from the driven end, U_R from the striking end, and w = U_L M_R + U_R M_L is the same
everywhere. The answer to a unit force at p is −U_L(a) U_R(b)/(z² w), a the nearer to the driven end of x and p. Its
rigid part −1/z² is taken off. Well below the first mode that would cancel, so there U = 1 − z²D and M = m − z²Q are told
by D and Q, and z² drops out of the difference.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from percuss.model.body.chain import Chain, sinc_deficit
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


def _motion(sections: Chain, z: ComplexArray, section: npt.NDArray[np.intp], time: Array, slow: bool) -> _Motion:
    """The motion from the first section's start on, at points; shapes (K, len(section))."""
    state = _Motion(np.zeros_like(z), np.zeros_like(z), np.zeros(z.size))
    if not slow:
        state = state._replace(first=np.ones_like(z))
    last = int(section.max(initial=0))
    starts = [state]
    for i in range(last):
        impedance, tau = float(sections.impedance[i]), float(sections.transit[i])
        starts.append(_along(starts[-1], z, impedance, tau, sections.before[i] if slow else None))
    at = _Motion(*(np.stack(parts, axis=-1)[:, section] for parts in zip(*starts, strict=True)))
    before = sections.before[section] if slow else None
    return _along(at, z[:, None], sections.impedance[section], time, before)


def _along(
    state: _Motion, z: ComplexArray, impedance: Array | float, time: Array | float, before: Array | float | None
) -> _Motion:
    """The motion after some time of a wave along a section; `before`, the mass behind its start, makes it (D, Q)."""
    q = z * time
    if before is not None:
        cosine, deficit = np.cos(q), sinc_deficit(q)
        sine, bend = time * (1.0 - deficit), 2.0 * (time * (1.0 - sinc_deficit(0.5 * q)) * 0.5) ** 2
        lag = np.asarray(time) ** 3 * _cubic(q)
        d, rest = state.first, state.second
        moved = before - z * z * rest
        return _Motion(
            bend + d * cosine + moved * sine / impedance,
            before * bend + rest * cosine + impedance * (lag + d * sine),
            state.log,
        )
    depth = -q.imag
    clipped = q.real - 1j * np.minimum(depth, _DEEP)
    scale = np.exp(-np.minimum(depth, _DEEP))
    cosine, sine = np.cos(clipped) * scale, np.sin(clipped) * scale / z
    u = state.first * cosine - z * z * state.second * sine / impedance
    m = state.second * cosine + impedance * state.first * sine
    size = np.abs(u) + np.abs(z * m) / impedance
    return _Motion(u / size, m / size, state.log + depth + np.log(size))


def _cubic(q: ComplexArray) -> ComplexArray:
    """(q − sin q)/q³, 1/6 at 0."""
    tiny = np.abs(q) < 1e-3
    far = np.where(tiny, 1.0, q)
    return np.asarray(np.where(tiny, (1.0 - q * q / 20.0) / 6.0, sinc_deficit(far) / far**2))
