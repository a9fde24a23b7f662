"""A simulated motion: what happened, and where the bar is at any time."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from percuss.errors import ParameterError
from percuss.model import System
from percuss.model.checks import Array, array, choice
from percuss.shown import Shown
from percuss.simulate.events import CHATTER, IMPACT, RELEASE, REST, Events
from percuss.simulate.flight import Anchor, Modes, modal_motion
from percuss.simulate.kernels.codes import LOST_CYCLE
from percuss.simulate.spectrum import Spectrum
from percuss.simulate.stop import Stop
from percuss.simulate.summary import Cycle, Summary, main_blows, summary_of

__all__ = ["SimulatedMotion", "unresolved"]

Side = Literal["left", "right"]

_TURN = 2.0 * np.pi


@dataclass(frozen=True)
class SimulatedMotion(Shown):
    """What a simulation has left, and all that is read off it; `Trajectory` says what each of its parts is."""

    system: System
    modes: int
    events: Events
    states: Array
    start: Anchor
    resting: bool
    snapshot: dict[str, npt.NDArray[np.generic]]
    outcome: str
    label: str
    cycle: Cycle | None
    stop: Stop
    begin_time: float
    end_time: float

    # -- what happened --

    @property
    def impacts(self) -> int:
        """The number of impacts."""
        return int(np.count_nonzero(self.events.code == IMPACT))

    @property
    def main_blows(self) -> npt.NDArray[np.bool_]:
        """Which impacts are main blows: a completed chatter counts once. Shape (impacts,)."""
        return main_blows(self.events)

    @property
    def period_unresolved(self) -> bool:
        """Whether the motion repeats, as it was released twice in the same state, in a time that hangs on rounding."""
        return self.cycle is None and unresolved(self.snapshot["count"])

    @cached_property
    def summary(self) -> Summary:
        """Blow rate, its scatter, energies; in SI besides for a system made from SI."""
        return summary_of(self.system, self.events, self.cycle, over=self.outcome in ("rest", "departed"))

    @property
    def transient(self) -> int | None:
        """Impacts before the periodic motion; None when none was found."""
        return None if self.cycle is None else self.cycle.first

    # -- the state --

    @cached_property
    def spectrum(self) -> Spectrum:
        """Frequencies and forced response of the modes."""
        return Spectrum(self.system, self.modes)

    def _anchor(self, i: int) -> Anchor:
        """The state after event number i; −1 is the start."""
        if i < 0:
            return self.start
        row, n = self.states[i], self.modes
        z = np.stack([row[2 : 2 + n], row[2 + n :]])
        return Anchor(float(self.events.phase[i]), int(self.events.piece[i]), float(row[0]), float(row[1]), z)

    def _at(self, i: int) -> tuple[Array, Array]:
        a = self._anchor(i)
        return self.spectrum.modal(a.z, a.gap, a.rigid_rate, a.phase, self.spectrum.mean(a.piece))

    @cached_property
    def _modal_states(self) -> tuple[Array, Array]:
        n, e = self.modes, self.events
        z = self.states[:, 2:].reshape(len(e), 2, n)
        values = np.asarray(self.system.load.values)
        mean = values[e.piece] if values.size else np.full(len(e), self.system.load.mean)
        return self.spectrum.modal(z, self.states[:, 0], self.states[:, 1], e.phase, mean)

    @property
    def displacement(self) -> Array:
        """u_n after each event, n = 0 … N; shape (events, N+1)."""
        return self._modal_states[0]

    @property
    def velocity(self) -> Array:
        """u_n' after each event, n = 0 … N; shape (events, N+1)."""
        return self._modal_states[1]

    def modal(self, t: npt.ArrayLike, side: Side = "right") -> Modes:
        """u_n(t) and u_n'(t), each of shape (N+1, len(t)).

        Parameters
        ----------
        t
            Times (rad) from `begin_time` to `end_time`.
        side
            At the time of an event: the state after it (``right``) or before it (``left``).

        Raises
        ------
        ParameterError
            For times outside the simulated ones.
        """
        choice("side", side, "left", "right")
        times = array("t", t, -np.inf, np.inf)
        if times.size and (times.min() < self.begin_time or times.max() > self.end_time):
            accepted = f"times from {self.begin_time:.6g} to {self.end_time:.6g}"
            raise ParameterError("t", f"{times.min():.6g} … {times.max():.6g}", accepted, "simulate for longer")
        order = np.argsort(times, kind="stable")
        ordered = times[order]
        last = np.searchsorted(self.events.time, ordered, side=side) - 1
        u, v = np.empty((self.modes + 1, times.size)), np.empty((self.modes + 1, times.size))
        for i in np.unique(last):
            here = np.flatnonzero(last == i)
            part = self._between(int(i), ordered[here])
            u[:, order[here]], v[:, order[here]] = part.displacement, part.velocity
        return Modes(u, v)

    def _between(self, i: int, times: Array) -> Modes:
        rests = self.events.code[i] == REST if i >= 0 else self.resting
        nothing = np.zeros((self.modes + 1, times.size))
        if rests and not self.system.body.is_free and i >= 0:  # as it was struck last
            return Modes(self._at(i)[0][:, None] + nothing, nothing)
        if rests:
            return Modes(nothing, nothing)
        if i + 1 < len(self.events) and self.events.code[i + 1] == CHATTER:
            return Modes(self._at(i)[0][:, None] + nothing, nothing)  # infinitely many bounces of less than 1e-9
        periods, phase = divmod(self.begin_time, _TURN) if i < 0 else (self.events.period[i], self.events.phase[i])
        return modal_motion(self.spectrum, self._anchor(i), np.maximum((times - periods * _TURN) - phase, 0.0))

    # -- fields --

    def position(self, x: npt.ArrayLike, t: npt.ArrayLike) -> Array:
        """u(x, t), with the wall at u = 0; shape (len(x), len(t))."""
        return self._shapes(x) @ self.modal(t).displacement

    def bar_velocity(self, x: npt.ArrayLike, t: npt.ArrayLike, side: Side = "right") -> Array:
        """u_t(x, t); shape (len(x), len(t))."""
        return self._shapes(x) @ self.modal(t, side).velocity

    def strain(self, x: npt.ArrayLike, t: npt.ArrayLike) -> Array:
        """u_x(x, t), negative in compression; shape (len(x), len(t)). 0 in a bar that rests on the wall.

        The free motion has N modes; the forced one is summed over all of them, so that −s² u_x(0, t) = p(t).
        """
        places, times = array("x", x, 0.0, 1.0), array("t", t, -np.inf, np.inf)
        slopes = self.system.body.shapes(places, self.modes).strain * self.spectrum.unit
        found = slopes @ self.modal(times).displacement[1:]
        load, flies = self.system.load, ~self._rests(times)
        steps = np.asarray(load.values)
        mean = steps[load.piece(times[flies])] if steps.size else np.full(int(flies.sum()), load.mean)
        found[:, flies] += self.spectrum.forced_strain_beyond(places, times[flies], mean)
        return np.asarray(found)

    def gap(self, t: npt.ArrayLike) -> Array:
        """Gap function y(t) = u(1, t): 0 at contact, negative between; shape (len(t),).

        After a release, for the time of one wave and as long as the load pulls, the ripple of a finite number of modes
        may show above 0.
        """
        return np.asarray(self.position(1.0, t)[0])

    def energy(self, t: npt.ArrayLike, side: Side = "right") -> Array:
        """Kinetic and elastic energy ½ ∫ u_t² dx + ½ s² ∫ u_x² dx of the bar; shape (len(t),)."""
        at = self.modal(t, side)
        weight = np.append(0.5, 0.5 * self.spectrum.weight)
        stiffness = 0.5 * self.spectrum.weight * self.spectrum.omega**2
        return np.asarray(weight @ at.velocity**2 + stiffness @ at.displacement[1:] ** 2)

    def contact_force(self, t: npt.ArrayLike) -> Array:
        """Force p(t) with which a bar that rests presses on the wall, quasi-static; 0 elsewhere. Shape (len(t),)."""
        times = array("t", t, self.begin_time, self.end_time)
        return np.where(self._rests(times), self.system.load.value(times), 0.0)

    def _rests(self, times: Array) -> npt.NDArray[np.bool_]:
        last = np.searchsorted(self.events.time, times, side="right") - 1
        codes = np.append(self.events.code, REST if self.resting else RELEASE)
        return np.asarray(codes[last] == REST)

    def _shapes(self, x: npt.ArrayLike) -> Array:
        places = array("x", x, 0.0, 1.0)
        shapes = self.system.body.shapes(places, self.modes).displacement * self.spectrum.unit
        return np.column_stack([np.ones(places.size), shapes])


def unresolved(count: npt.NDArray[Any]) -> bool:
    """Whether the engine's whole numbers tell of equal releases with a number of load periods that is lost."""
    return bool(count["verdict"][0] == LOST_CYCLE)
