"""The motion through p impacts at given times: its states, its speeds and its linearisation."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from percuss.errors import ParameterError
from percuss.model import System
from percuss.model.checks import Array, choice, finite, instance
from percuss.model.load import Side
from percuss.shown import Shown
from percuss.steady.impact_state import ModalState
from percuss.steady.periodic.flight import state_at
from percuss.steady.periodic.impact_chain import ImpactChain
from percuss.steady.periodic.linearised import bordered, eliminated
from percuss.steady.periodic.many_numbers import ManyNumbers
from percuss.steady.periodic.passage import Passage

__all__ = ["ImpactMotion"]

TURN = 2.0 * math.pi


@dataclass(frozen=True)
class ImpactMotion(Shown):
    """What a `PeriodicOrbit` is before it is asked whether it is possible; see there for the parameters."""

    system: System
    periods: int
    times: tuple[float, ...]
    modes: int
    rebound: float | None = None

    # -- the impacts --

    @property
    def impacts(self) -> int:
        """p."""
        return len(self.times)

    @property
    def label(self) -> str:
        """z=p/n."""
        return f"z={self.impacts}/{self.periods}"

    @property
    def period(self) -> float:
        """T = 2πn."""
        return TURN * self.periods

    @property
    def phases(self) -> Array:
        """Phase of the load at each impact, in [0, 2π); shape (p,)."""
        return np.mod(self.times, TURN)

    @property
    def flight_times(self) -> Array:
        """How long the bar flies after each impact; shape (p,)."""
        return self._passage.flights

    @property
    def speeds(self) -> Array:
        """Speed of the striking end just before each impact; shape (p,)."""
        return self._passage.speed

    @property
    def rebound_speeds(self) -> Array:
        """Speed with which the striking end leaves the wall after each impact: R times that before; shape (p,)."""
        return np.asarray(-self.system.contact.velocity_factor * self.speeds)

    @property
    def rigid_velocities(self) -> Array:
        """Mean velocity of the bar just before each impact; shape (p,)."""
        return self._passage.rigid

    @property
    def rigid_rebounds(self) -> Array:
        """Mean velocity of the bar just after each impact; shape (p,)."""
        return self._passage.rebound

    @property
    def blow_energies(self) -> Array:
        """Kinetic energy of all modes just before each impact; shape (p,)."""
        weight = self._chain.known.weight
        return np.asarray(0.5 * self._passage.rigid**2 + 0.5 * self._passage.velocity**2 @ weight)

    @cached_property
    def states(self) -> tuple[ModalState, ...]:
        """The elastic modes at each impact, just before and just after it."""
        known, passage = self._chain.known, self._passage
        rows = zip(
            zip(passage.displacement, passage.velocity, strict=True),
            zip(passage.forced, passage.forced_velocity, strict=True),
            strict=True,
        )
        return tuple(state_at(known.omega, before, forced, self.system) for before, forced in rows)

    # -- just after the first impact, as for a steady motion --

    @property
    def phase(self) -> float:
        """Phase of the load at the first impact."""
        return float(self.phases[0])

    @property
    def rigid_velocity(self) -> float:
        """Mean velocity of the bar just before the first impact."""
        return float(self.rigid_velocities[0])

    def modal_state(self, modes: int) -> ModalState:
        """The first elastic modes at the first impact.

        Raises
        ------
        ParameterError
            When the orbit is one of a bar with fewer.
        """
        if modes > self.modes:
            raise ParameterError("modes", modes, f"at most {self.modes}, the modes of the orbit")
        return self.states[0].first(modes)

    # -- how it is computed --

    @cached_property
    def _chain(self) -> ImpactChain:
        kept = self.system.body.kept(self.modes)
        if kept != self.modes:
            raise ParameterError("modes", self.modes, f"at most {kept}", "so many modes the structure has")
        return ImpactChain(self.system, self.impacts, self.periods, self.modes)

    @cached_property
    def _passage(self) -> Passage:
        return self._passage_on("right")

    def _passage_on(self, side: Side) -> Passage:
        rebound = None if self.rebound is None else np.array(self.rebound)
        return self._chain.passage(np.array(self.times), rebound, side)

    @property
    def residuals(self) -> Array:
        """The p equations of the flights and that for the rigid velocity, 0 for an orbit; see `off`. Shape (p + 1,)."""
        return np.append(self._passage.gap, self._passage.closure)

    @property
    def residual(self) -> float:
        """How far the striking end is from the wall at the impacts, at most: rounding."""
        return float(np.abs(self.residuals).max())

    def off(self, system: System) -> Array:
        """The equations for the times, with the times of this orbit and another system: 0 if it has this orbit, too.

        The p equations of the flights, and by how much the rigid velocity after the first impact changes in a cycle
        where it does not follow from the times. Shape (p + 1,).
        """
        chain = ImpactChain(instance("system", system, System), self.impacts, self.periods, self.modes)
        passage = chain.passage(np.array(self.times), None if self.rebound is None else np.array(self.rebound))
        return np.append(passage.gap, passage.closure)

    def linearised(self, xi: complex = 1.0, side: Side = "right") -> npt.NDArray[np.complex128] | Array:
        """K(ξ), which is singular where ξ is a multiplier of the orbit; shape (p, p).

        K(1) is the derivative of the p equations for the impact times, the matrix of Newton's method. A fold has
        det K(1) = 0, a flip det K(−1) = 0; nothing is divided by the speed of an impact.

        Parameters
        ----------
        xi
            ξ, real or complex.
        side
            Which value of the load counts where it jumps at an impact.
        """
        return eliminated(self.bordered(xi, side))

    def bordered(self, xi: complex = 1.0, side: Side = "right") -> npt.NDArray[np.complex128] | Array:
        """K(ξ) before the rigid velocity is eliminated, which is finite where that does not follow from the times.

        The last column belongs to a change of the mean velocity after the first impact, the last row says that it is ξ
        times itself after a cycle. Shape (p + 1, p + 1).

        Parameters
        ----------
        xi, side
            As for `linearised`.
        """
        choice("side", side, "left", "right")
        if not isinstance(xi, complex):
            xi = finite("xi", xi)
        passage = self._passage if side == "right" else self._passage_on(side)
        return bordered(self._chain, passage, xi)

    def many_numbers(self) -> ManyNumbers:
        """`bordered` for many ξ at once."""
        return ManyNumbers.of(self._chain, self._passage)

    def modal_determinants(self, xi: complex = 1.0) -> npt.NDArray[np.complex128] | Array:
        """det(ξ − M_n), with M_n the map of mode n through the cycle with the times of the impacts held; shape (N,).

        Where one of them vanishes at ξ = 1 the amplitude of the mode is free: internal resonance.
        """
        if not isinstance(xi, complex):
            xi = finite("xi", xi)
        blocks = self._passage.blocks
        return np.asarray((xi - blocks.a) * (xi - blocks.e) - blocks.b * blocks.c)
