"""Bodies that something holds: structures with one gap, which move by their modes alone.

Such a body has no rigid motion. Its modes n = 1 … N are q_n'' + d_n q_n' + ω_n² q_n = b_n p(t), and the gap function is
y = Σ a_n q_n − g ≤ 0, with a_n the mode at the contact, b_n the mode at the load (modal mass 1) and g the gap. In the
words of `Modes`: 1/inertia = a_n², at_load = b_n/a_n, so that γ_n = a_n b_n and q_n = b_n z_n.
"""

from __future__ import annotations

from abc import abstractmethod
from typing import ClassVar

import numpy as np

from percuss.errors import ParameterError
from percuss.model.body.body import Body, IntArray, Shape
from percuss.model.checks import Array

__all__ = ["MOST_GAP", "HeldBody", "need_free"]

MOST_GAP = 1e12
"""Far beyond any gap: displacements keep some digits of an impact."""


class HeldBody(Body):
    """A structure that something holds, with a wall at a gap before its contact; `Body` says what to write.

    Besides, `most_modes` and `gap`; static shapes and bounds of modes that nobody computes mean nothing here: all are
    computed.
    """

    is_free: ClassVar[bool] = False

    @property
    @abstractmethod
    def most_modes(self) -> int:
        """How many modes it has, or as many as are taken unless more are asked for."""

    def chosen(self, modes: int | None) -> int:
        """N, the modes that are taken where so many are asked for; None for `most_modes`.

        Raises
        ------
        ParameterError
            For none: its modes are all that moves.
        """
        if modes == 0:
            raise ParameterError("modes", 0, "1 or more: a body that is held has no rigid motion beside its modes")
        return self.most_modes if modes is None else self.kept(modes)

    def flexibility(self, modes: int, at: int = 0) -> float:
        """Displacement of the contact under a constant unit force at the load, of the first modes."""
        known = self.modes(modes, at)
        return float(np.sum(known.gamma / known.omega**2))

    def bent(self, modes: int, at: int = 0) -> Array:
        """The modes z_n of the shape in which a force at the contact bends it, the contact moved by 1; shape (N,).

        A mode that the load does not drive has no share in it.
        """
        known = self.modes(modes, at)
        share = 1.0 / (known.inertia * known.omega**2)
        driven = known.gamma != 0.0
        return np.where(driven, share / np.where(driven, known.gamma, 1.0), 0.0) / float(share[driven].sum())

    def static_shape(self, x: Array, source: float = 0.0) -> Shape:
        n = self.most_modes
        shapes = self.shapes(np.asarray(x, dtype=float), n)
        from_source = self.shapes(np.array([source]), n).displacement[0] / self.inertia(n) / self.frequencies(n) ** 2
        return Shape(shapes.displacement @ from_source, shapes.strain @ from_source)

    def frequency_floor(self, n: int) -> float:
        raise _of_bars("a bound of its higher modes")

    @property
    def coupling_bound(self) -> float:
        raise _of_bars("a bound of its higher modes")

    def mass_before(self, x: Array) -> Array:
        raise _of_bars("the mass along it")

    def nearest(self, omega: Array) -> IntArray:  # type: ignore[override]
        known = self.frequencies(self.most_modes)
        return np.asarray(1 + np.argmin(np.abs(known[None, :] - np.asarray(omega, dtype=float)[..., None]), axis=-1))

    @property
    def is_harmonic(self) -> bool:
        return False


def need_free(body: Body, what: str) -> None:
    """Refuse a body that is held where the answer is one of bars that move as a whole.

    Raises
    ------
    ParameterError
        With what was asked for.
    """
    if not body.is_free:
        raise _of_bars(what)


def _of_bars(what: str) -> ParameterError:
    return ParameterError("body", "held by a spring or a structure", f"a free bar for {what}")
