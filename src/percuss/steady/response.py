"""What a forced response answers, whatever form the load has: the questions that steady motions ask of one."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

import numpy as np
import numpy.typing as npt

from percuss.model import System
from percuss.model.checks import Array

if TYPE_CHECKING:
    from percuss.steady.energy import Balanced
    from percuss.steady.harmonic import Field, HarmonicResponse

__all__ = ["Response"]


class Response(Protocol):
    """Periodic motion of the bar under its load, without rigid drift.

    Where a response is asked for `modes`, these are the modes of those of its sums that have no closed form; `cut`
    ends the others there too.
    """

    system: System

    @property
    def is_smooth(self) -> bool:
        """Whether its modes fall off so fast, like 1/n³, that nothing rings: the load does not jump."""
        ...

    @property
    def by_harmonics(self) -> HarmonicResponse:
        """The response to the harmonics that the load keeps; itself when there is nothing else."""
        ...

    def __hash__(self) -> int: ...

    # -- rigid part --

    def rigid_velocity(self, theta: Array) -> Array:
        """v_f(θ) (theory §4); shape of `theta`."""
        ...

    def rigid_bounds(self) -> tuple[float, float]:
        """Bounds of |v_f| and of the alternating force."""
        ...

    def rigid_acceleration(self, theta: Array) -> Array:
        """v_f'(θ), right-sided at a jump."""
        ...

    def slope_on(self, arc: int, theta: Array) -> Array:
        """v_f'(θ) on arc number `arc`, at its ends too; shape of `theta`."""
        ...

    def rigid_displacement(self, theta: Array) -> Array:
        """The periodic antiderivative of v_f with mean zero."""
        ...

    def force(self, theta: Array) -> Array:
        """p(θ) with its mean, right-sided at a jump."""
        ...

    def plateau(self, phase: float) -> tuple[float, float] | None:
        """First and last phase of the arc around `phase` if v_f is flat there, or None."""
        ...

    # -- where v_f meets a level --

    @property
    def ends(self) -> Array:
        """The phases in [0, 2π), increasing, between which v_f is monotone."""
        ...

    @property
    def flat(self) -> npt.NDArray[np.bool_]:
        """On which of the arcs that begin there v_f does not change but for rounding; shape of `ends`."""
        ...

    def turning(self, velocities: Array) -> npt.NDArray[np.bool_]:
        """At which ends v_f turns round, from v_f at the ends and a turn later at the first one; that shape."""
        ...

    def phases_at(self, ends: Array, velocities: Array, arc: npt.NDArray[np.intp], level: Array) -> Array:
        """The phase on each arc where v_f equals a level between its ends, for `percuss.steady.phases.Arcs`."""
        ...

    # -- elastic part --

    def elastic(self, x: Array, theta: Array, modes: int, *, cut: bool = False) -> Field:
        """Elastic part of the forced motion, with the static shape of the mean; shapes (len(x), len(θ))."""
        ...

    def end_motion(self, theta: Array, modes: int, *, cut: bool = False) -> tuple[Array, Array]:
        """Forced displacement (but for a constant) and velocity of the striking end, rigid part and elastic part."""
        ...

    def end_velocity(self, theta: float, modes: int, *, cut: bool = False) -> float:
        """Elastic part of the forced velocity of the striking end at one load phase."""
        ...

    def end_rates(self, modes: int, *, cut: bool = False) -> tuple[float, float]:
        """Bounds of the second and third derivative of the striking end's forced elastic motion that is no ringing."""
        ...

    # -- mode by mode --

    def modal(self, modes: int, theta: Array) -> tuple[Array, Array]:
        """(f_n, f_n') of the elastic modes n = 1 … `modes`, each of shape (modes, len(θ))."""
        ...

    def modal_apart(self, modes: int, theta: Array) -> tuple[Array, Array]:
        """As `modal`, with the same bits for a phase alone and in a row."""
        ...

    def modal_bounds(self, modes: int) -> tuple[Array, Array]:
        """Bounds over all phases of |f_n|, but for what rings, and of |f_n'|; each of shape (modes,)."""
        ...

    def displacement_tail(self, omega: float) -> float:
        """P with |f_n| ≤ P/ω_n², but for what rings, for every mode with ω_n ≥ `omega`; inf when that is too low."""
        ...

    def modal_velocity_bound(self, theta: float, omega: float, damping: float) -> float:
        """P with |f_n'(θ)| ≤ P/ω_n² for every mode with ω_n ≥ `omega`, d_n ≥ `damping`; inf for none."""
        ...

    def ringing(self, modes: int) -> Array:
        """Greatest amplitudes of free motion in the forced response, after the jumps of the load; shape (modes,)."""
        ...

    @property
    def most_modes(self) -> int:
        """So many modes are looked at when it is decided how many to keep."""
        ...

    def exchange(self, motion: Balanced) -> tuple[float, float]:
        """Energy put in by the load and taken by the damping over an impact period of a motion (theory §4)."""
        ...
