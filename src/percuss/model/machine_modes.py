"""The free motions of a body whose driven end a gas chamber holds: the rigid motion and the modes, coupled by it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from percuss.errors import ParameterError
from percuss.model.body import Body
from percuss.model.checks import Array, count, instance, non_negative, numbers

__all__ = ["MachineModes", "machine_modes"]

_MOST = 1 << 14


@dataclass(frozen=True)
class MachineModes:
    """Coordinates m_0 … m_N of a body on a gas chamber, each of which moves by itself; arrays of shape (N + 1,).

    m_i'' + damping_i m_i' + ω_i² m_i = driven_i p under the force p of the valve, without the chamber's stiffness,
    which is in ω. The modal masses are 1: the kinetic energy is ½ Σ m_i'². Without a chamber m_0 is the motion of the
    centre of mass, ω_0 = 0, and the others are the body's own modes, of modal mass 1.

    Parameters
    ----------
    omega
        Undamped frequencies, increasing.
    damping
        d_i: of the law of the body at these frequencies; the drag on the body as a whole for i = 0.
    end
        What m_i = 1 moves the striking end by.
    driven
        … and the place where the valve's force acts.
    mixing
        V, orthogonal, shape (N + 1, N + 1): r = V m are the body's own coordinates of modal mass 1, r_0 the position of
        the centre of mass. The identity without a chamber.
    """

    omega: Array
    damping: Array
    end: Array
    driven: Array
    mixing: Array

    @property
    def size(self) -> int:
        """N, the elastic modes."""
        return self.omega.size - 1

    @property
    def centre(self) -> Array:
        """What m_i = 1 moves the centre of mass by."""
        return np.asarray(self.mixing[0])

    def at(self, body: Body, x: Array) -> Array:
        """What m_i = 1 moves the places x (0 at the driven end to 1) of the body by; shape (len(x), N + 1)."""
        instance("body", body, Body)
        x = numbers("x", x)
        if np.any((x < 0.0) | (x > 1.0)):
            raise ParameterError("x", x, "places from 0 (driven end) to 1")
        own = np.ones((x.size, 1))
        if self.size:
            own = np.hstack([own, body.shapes(x, self.size).displacement * body.modes(self.size).end])
        return np.asarray(own @ self.mixing)


def _machine_modes(body: Body, at: int, stiffness: float, elastic: int) -> MachineModes:
    own = body.modes(elastic, at) if elastic else None
    omega = np.zeros(elastic + 1)
    end, driven = np.ones(elastic + 1), np.ones(elastic + 1)
    damping = np.full(elastic + 1, body.damping.rigid)
    if own is not None:
        omega[1:], end[1:], driven[1:], damping[1:] = own.omega, own.end, own.end * own.at_load, own.damping
    mixing = np.eye(elastic + 1)
    if stiffness > 0.0:
        # rank one beside a diagonal: every frequency rises, none beyond the next one before
        squares, mixing = np.linalg.eigh(np.diag(omega**2) + stiffness * np.outer(driven, driven))
        omega = np.sqrt(np.maximum(squares, 0.0))
        if elastic:
            damping[1:] = body.damping.of(omega[1:])
        mixing = mixing * np.where(mixing.T @ end < 0.0, -1.0, 1.0)
        end, driven = mixing.T @ end, mixing.T @ driven
    found = MachineModes(omega, damping, end, driven, mixing)
    for values in (omega, damping, end, driven, mixing):
        values.setflags(write=False)
    return found


_known = lru_cache(maxsize=32)(_machine_modes)


def machine_modes(body: Body, at: int, stiffness: float, elastic: int) -> MachineModes:
    """The free motions of a body on a gas chamber. Not to be written into.

    Parameters
    ----------
    body
        What moves.
    at
        The number of the place where the valve's force and the chamber act.
    stiffness
        κ of the chamber, 0 or greater (dimensionless).
    elastic
        N, the elastic modes kept.
    """
    body.place(at)
    return _known(body, at, non_negative("stiffness", stiffness), count("modes", elastic, least=0, most=_MOST))
