"""One periodic motion with p impacts in n load periods, as a value: is it possible, where does the bar go?"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from percuss.errors import Interrupted, ParameterError, PercussError
from percuss.mechanics.cycle import CycleStep, guarded, linearised
from percuss.model import Load, System
from percuss.model.checks import Array, array, choice, count, finite, instance
from percuss.model.load import Side
from percuss.steady.flight import Contactless, Energy, Flight, Stretch, Violation, damped, flight_check, stays_off
from percuss.steady.multipliers import CycleMap, Multipliers, Reason, Repeating, blocks, multipliers_of
from percuss.steady.orbit import Orbit
from percuss.steady.oscillator import ModalState
from percuss.steady.periodic.impact_chain import ImpactChain, Passage, RationalMatrix, orbit_kernels

TURN = 2.0 * math.pi
MOST_MAPPED = 512  # an eigensolve with more modes takes minutes


# ---- One periodic motion with p impacts in n load periods, as a value: is it possible, where does the bar go?


@dataclass(frozen=True)
class PeriodicOrbit(Repeating):
    """A periodic motion z=p/n with p impacts in n load periods; made by `orbits` and `orbit_near`.

    An orbit is told by the times of its impacts; all else follows. Times are in radians of the load's fundamental, all
    quantities are dimensionless. The bar has the modes 0 … N, forced part included, exactly as a simulation with N
    modes moves: `Start.orbit` starts one just after the first impact.

    Parameters
    ----------
    periods
        n.
    times
        t_1 < … < t_p < t_1 + 2πn, unwrapped; the first impact is that with the least phase of the load.
    modes
        N.
    rebound
        Mean velocity of the bar just after the first impact, where it does not follow from the times: R = 1, no drag
        and an even number of impacts. Else None.
    """

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
        weight, velocity = self._chain.known.weight, self._passage.elastic[1]
        return np.asarray(0.5 * self._passage.rigid**2 + 0.5 * velocity**2 @ weight)

    @cached_property
    def states(self) -> tuple[ModalState, ...]:
        """The elastic modes at each impact, just before and just after it."""
        omega, contact = self._chain.known.omega, self.system.contact
        found = []
        for u, v, f, rate in zip(*self._passage.elastic, strict=True):
            after, after_rate = contact.after(u, v)
            found.append(ModalState(omega, u, v, after, after - f, after_rate - rate, rate, np.ones_like(omega)))
        return tuple(found)

    @property
    def amplitudes(self) -> Array:
        """The free part of each elastic mode, as it is just before each impact; shape (p, N)."""
        u, v, f, rate = self._passage.elastic
        return np.asarray(np.hypot(u - f, (v - rate) / self._chain.known.omega))

    @property
    def impact_velocity(self) -> float:
        """Greatest of the speeds."""
        return float(self.speeds.max())

    @property
    def blow_energy(self) -> float:
        """Mean of the energies of the blows."""
        return float(self.blow_energies.mean())

    @property
    def delivered_energy(self) -> float:
        """Mean of what the impacts take."""
        weight, contact, omega = self._chain.known.weight, self.system.contact, self._chain.known.omega
        strain = 0.5 * (omega * self._passage.elastic[0]) ** 2 @ weight
        taken = [contact.energy_taken(*pair) for pair in zip(self.blow_energies.tolist(), strain.tolist(), strict=True)]
        return float(np.mean(taken))

    @property
    def steady(self) -> Orbit | None:
        """The same as a motion of `steady_states`, of so many modes, where it strikes once."""
        return Orbit(self.system, self.periods, self.phase, requested_modes=self.modes) if self.impacts == 1 else None

    @cached_property
    def energy(self) -> Energy:
        """Energy over the cycle: put in by the load, taken by damping and by the impacts."""
        if self.steady is not None:
            return self.steady.energy
        taken = self.impacts * self.delivered_energy
        flown = (Stretch(flight.phase, flight.period, flight.rates) for flight in self.flights)
        lost = damped(self.system, self._chain.known.weight, flown)
        return Energy(taken + lost, lost, taken)

    @cached_property
    def stroke(self) -> float:
        """Range of the striking end's position."""
        return self.steady.stroke if self.steady is not None else max(flight.depth for flight in self.flights)

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
        """The first elastic modes at the first impact."""
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
        return self._chain.passage(np.array(self.times), self.rebound)

    def _passage_on(self, side: Side) -> Passage:
        choice("side", side, "left", "right")
        if side == "right":
            return self._passage
        return self._chain.passage(np.array(self.times), self.rebound, side)

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
        passage = chain.passage(np.array(self.times), self.rebound)
        return np.append(passage.gap, passage.closure)

    def linearised(self, xi: complex = 1.0, side: Side = "right") -> npt.NDArray[np.complex128] | Array:
        """K(ξ), which is singular where ξ is a multiplier of the orbit; shape (p, p).

        K(1) is the derivative of the p equations for the impact times, the matrix of Newton's method. A fold has
        det K(1) = 0, a flip det K(−1) = 0; nothing is divided by the speed of an impact.

        Parameters
        ----------
        side
            Which value of the load counts where it jumps at an impact.
        """
        matrix = self.bordered(xi, side)
        return np.asarray(matrix[:-1, :-1] - matrix[:-1, -1:] * matrix[-1:, :-1] / matrix[-1, -1])

    def bordered(self, xi: complex = 1.0, side: Side = "right") -> npt.NDArray[np.complex128] | Array:
        """K(ξ) before the rigid velocity is eliminated, which is finite where that does not follow from the times.

        The last column belongs to a change of the mean velocity after the first impact, the last row says that it is ξ
        times itself after a cycle. Shape (p + 1, p + 1).

        Parameters
        ----------
        xi, side
            As for `linearised`.
        """
        if not isinstance(xi, complex):
            xi = finite("xi", xi)
        return self._passage_on(side).bordered(xi)

    def singular(self, side: Side = "right") -> tuple[float, float]:
        """det K(1) and det K(−1), each row taken by its length: 0 at a fold, and at a flip."""
        return self._passage_on(side).singular

    def many_numbers(self) -> RationalMatrix:
        """`bordered` for many ξ at once."""
        return self._passage.rational

    def modal_determinants(self, xi: complex = 1.0) -> npt.NDArray[np.complex128] | Array:
        """det(ξ − M_n), with M_n the map of mode n through the cycle with the times of the impacts held; shape (N,).

        Where one of them vanishes at ξ = 1 the amplitude of the mode is free: internal resonance.
        """
        if not isinstance(xi, complex):
            xi = finite("xi", xi)
        return np.asarray(self._passage.blocks.away(xi)[2])

    # -- is it stable --
    #
    # The linearised motion over a cycle is W = S_p Φ_p … S_1 Φ_1, flights and saltation matrices of the states of all
    # modes (`percuss.mechanics.cycle`). The p × p matrix K(ξ) of the shifts of the impacts says the same,
    #
    #     det(ξ − W) = det K(ξ) (Πβ E_i − ξ) Π_n det(ξ − M_n) / Π_i (−h·ẋ⁻_i),
    #
    # with M_n the map of mode n through the cycle with the times held; the eigenvalue that belongs to a shift of the
    # whole bar along its path has dropped out of K.

    def map(self, side: Side = "right") -> CycleMap:
        """W, the linearised motion over a cycle, from just after the first impact; at fixed times.

        Raises
        ------
        ParameterError
            For an orbit of more than 512 modes, or with an impact of no speed, beside which it grows without bound.
        """
        choice("side", side, "left", "right")
        if self.modes > MOST_MAPPED:
            raise ParameterError("modes", self.modes, f"an orbit with at most {MOST_MAPPED} modes")
        if not np.all(self.speeds != 0.0):
            raise ParameterError("orbit", str(self), "impacts with a speed", "see `linearised`, which stays finite")
        system, first = self.system, int(not self.system.body.is_free)
        flights = [blocks(system.body, system.load.at, flight, self.modes) for flight in self.flight_times.tolist()]
        damping, omega, gamma = flights[0].damping, flights[0].omega, flights[0].gamma
        turn = np.array([system.contact.strain_factor, system.contact.velocity_factor])
        forces = system.load.value(self.times, side)

        def rate(state: Array, force: float) -> Array:
            return np.stack([state[:, 1], force - damping * state[:, 1] - omega**2 * state[:, 0]], axis=1)

        events = []
        for i, flight in enumerate(flights):
            to, flow = (i + 1) % self.impacts, np.stack(flight[:4], axis=-1)
            place, velocity = self.states[to].displacement, self.states[to].velocity
            state = np.stack([np.append(0.0, place), np.append(self.rigid_velocities[to], velocity)], axis=1)[first:]
            force = float(forces[to])
            events.append(
                CycleStep(flow.reshape(-1, 2, 2), rate(state, force), rate(turn * state, force), np.diag(turn))
            )
        size, row = 2 * omega.size, np.stack([gamma, 0.0 * gamma], axis=1)
        whole, _ = linearised(events, np.eye(size).reshape(-1, 2, size), lambda _, now, rate: guarded(row, now, rate))
        return CycleMap(whole.reshape(size, size), omega, gamma)

    def _multipliers(self, side: Side) -> Multipliers:
        return multipliers_of(self.label, self.system, self.map(side))

    def characteristic(self, xi: complex, side: Side = "right") -> complex:
        """det(ξ − W), whose zeros are the multipliers, in O(p²N) from K(ξ).

        Its sign at 1 and at −1 tells which folds and flips an orbit has gone through. It may overflow with thousands of
        modes, and grows without bound where the speed of an impact goes to 0; det `linearised` does neither.
        """
        whole = complex(np.linalg.det(self.bordered(xi, side)))
        scale = float(np.prod(-self.speeds)) if self.system.body.is_free else -float(np.prod(self.speeds))  # −1 below K
        return whole * complex(np.prod(self.modal_determinants(xi))) / scale

    def outside(self, beyond: float = 0.0) -> int | None:
        """The number of multipliers with a modulus greater than 1 + `beyond`, which is from 0 to 1.

        None where a multiplier is so near to that circle that rounding decides, or so many modes are hardly damped that
        several may be near it side by side, where det K(ξ) turns about 0 unseen.
        """
        numbers = self.many_numbers()
        return outside_number(numbers, 2 if self.system.body.is_free else 0, 1.0 + finite("beyond", beyond))

    # -- as an orbit --

    @property
    def plain(self) -> PeriodicOrbit:
        """The same, with the mean velocity only where it does not follow from the times."""
        return replace(self, rebound=float(self.rigid_rebounds[0]) if self._chain.is_neutral else None)

    @property
    def from_first(self) -> PeriodicOrbit:
        """The same orbit told from the impact with the least phase of the load on, in the first period of the load."""
        turn = load_turn(self.system.load)
        moved, first = canonical(np.array(self.times), self.period, turn)
        kept = float(self.rigid_rebounds[first]) if self._chain.is_neutral else None
        return PeriodicOrbit(self.system, self.periods, tuple(moved.tolist()), self.modes, kept)

    # -- motion --

    @cached_property
    def flights(self) -> tuple[Flight, ...]:
        """The flights."""
        passage, coming = self._passage, np.roll(self.speeds, -1)
        rows = zip(passage.times, passage.flights, passage.rebound, -self.rebound_speeds, coming, strict=True)
        return tuple(
            Flight(self.system, self.modes, float(phase), float(period), state, float(mean), float(away), float(back))
            for state, (phase, period, mean, away, back) in zip(self.states, rows, strict=True)
        )

    def motion(self, t: npt.ArrayLike) -> Array:
        """Gap function y(t) = u(1, t) at times after the first impact: 0 at impacts, negative between. Shape (len(t),).

        Times beyond a cycle are taken back into it.
        """
        times = np.mod(array("t", t, -np.inf, np.inf), self.period)
        starts = np.array(self.times) - self.times[0]
        which, found = np.searchsorted(starts, times, side="right") - 1, np.empty_like(times)
        for i, flight in enumerate(self.flights):
            here = which == i
            if here.any():
                found[here] = flight.end_motion(times[here] - starts[i], self.modes)[0]
        return found

    # -- is it real --

    @cached_property
    def sampled(self) -> SampledFlights:
        """The flights looked at eight times in each period of the fastest mode, by compiled functions."""
        return self.sampled_but()

    def sampled_but(self, flight: int | None = None, time: float = 0.0, impact: int | None = None) -> SampledFlights:
        """The same without a maximum that is known, in a flight at a time after its impact, and those at an impact."""
        given, most = (("flight", flight), ("impact", impact)), self.impacts - 1
        known, about = (-1 if value is None else count(name, value, 0, most) for name, value in given)
        found, apart = np.empty(4), np.array([known, finite("time", time), about], dtype=float)
        orbit_kernels().flown(self._passage.room, found, apart)
        height, when, which, proven = found.tolist()
        height = -math.inf if math.isnan(height) else height
        return SampledFlights(height, self.times[int(which)] - self.times[0] + when, int(which), proven == 1.0)

    def end_at(self, flight: int, time: float) -> Array:
        """The gap function, its rate and its acceleration in a flight, at a time after its impact; shape (3,)."""
        found, number = np.empty(3), count("flight", flight, 0, self.impacts - 1)
        orbit_kernels().end_at(self._passage.room, number, finite("time", time), found)
        return found

    @cached_property
    def _doubtful(self) -> tuple[Flight, ...]:
        """The flights, on the scale of the orbit's stroke; none where samples prove that all stay off the wall."""
        fastest = self.system.body.modes(self.modes, self.system.load.at).omega[-1] if self.modes else 0.0
        many = (
            PER_WAVE * float(fastest) * self.period / TURN * self.modes > MOST
        )  # longer than a proof flight by flight
        if not many and self.sampled.proven:
            return ()
        stroke = max(flight.mean_range(flight.rigid_rebound) for flight in self.flights) or 1.0
        return tuple(replace(flight, rigid_stroke=stroke) for flight in self.flights)

    @cached_property
    def _contactless(self) -> tuple[Contactless, ...]:
        return tuple(map(flight_check, self._doubtful)) or (Contactless(None),) * self.impacts

    @cached_property
    def _stays_off(self) -> bool:
        """Whether there is no `violation`, whose time and depth are spared."""
        return all(map(stays_off, self._doubtful))

    @cached_property
    def violation(self) -> Violation | None:
        """Where the bar would first pass through the wall within a flight, in rad after the first impact; or None."""
        for start, found in zip(self.times, self._contactless, strict=True):
            if found.violation is not None:
                return Violation(start - self.times[0] + found.violation.time, found.violation.depth)
        return None

    @property
    def proven(self) -> bool:
        """Whether the absence of a contact between the impacts, or the first one, is proved."""
        return all(found.proven for found in self._contactless)

    @property
    def obstacle(self) -> Reason | None:
        """Why the motion is not physical: `Reason.NO_BLOW` or `Reason.THROUGH_WALL`; None for one that is."""
        if not np.all(self.speeds > 0.0):
            return Reason.NO_BLOW
        return None if self._stays_off else Reason.THROUGH_WALL

    @property
    def admissible(self) -> bool:
        """Whether the motion is physical: each impact strikes forward, and y < 0 between impacts."""
        return self.obstacle is None

    @property
    def resonant_modes(self) -> tuple[int, ...]:
        """Modes n that come back after a cycle by themselves, so that their amplitude is free: internal resonance."""
        return tuple(int(n) + 1 for n in np.flatnonzero(self._passage.blocks.resonant))

    def __str__(self) -> str:
        phases = ", ".join(f"{phase:.6f}" for phase in self.phases[:4])
        more = ", …" if self.impacts > 4 else ""
        where = "admissible" if self.admissible else f"not admissible ({self.obstacle.value if self.obstacle else ''})"
        return f"PeriodicOrbit {self.label}: phases {phases}{more} rad, {where}, {self.modes} modes"


# ---- The flights of an orbit at many samples: the greatest maximum of the gap function, and a quick proof with bounds

PER_WAVE = 8.0
MOST = 3e7  # samples of a mode in a cycle, which take a tenth of a second


class SampledFlights(NamedTuple):
    """What samples of the flights tell: the greatest local maximum of the gap function inside them, and a proof.

    The maximum is −∞ where there is none; its time is counted from the first impact. `proven`: whether the samples
    prove, with a bound of y'' over each flight, that each impact strikes and the bar stays off the wall between them.
    That they do not means nothing: the bar may be near the wall somewhere.
    """

    height: float
    time: float
    flight: int
    proven: bool


# ---- How many multipliers are outside the unit circle, from the p equations for the impact times: no matrix of all
# modes
#
# Outside the circle det K(ξ) has no poles, since with the times held no mode grows. It grows as ξ² there (as ξ⁰ of a
# body that is held), so that by the argument principle the number of its zeros outside is 2, or 0, less the number of
# turns that it makes about 0 as ξ goes once round the circle.

_WINDING = 0.7  # rad, by which det K(ξ) may turn between two places
_NODES = 48  # places at first, of half the circle, besides those nearest to the poles
_DEPTH, _FEW = 0.01, 2  # distance from the circle of a pole of a mode that is hardly damped; so many may be there
_FINEST, _MOST = 1e-13, 1 << 14  # distance of places; more are not looked at


def outside_number(numbers: RationalMatrix, growth: int, radius: float) -> int | None:
    """How many zeros det K(ξ), which grows as ξ to a power, has outside a circle; None where rounding decides."""
    size, poles = np.abs(numbers.blocks.poles), np.abs(np.angle(numbers.blocks.poles))
    if np.count_nonzero(size > 1.0 - _DEPTH) > _FEW:
        return None
    depth = np.clip(1.0 - size, 1e-9, 0.2)
    beside = np.concatenate([poles, poles - depth, poles + depth])  # there det K(ξ) turns fast
    angles = np.unique(np.append(np.linspace(0.0, np.pi, _NODES), beside[(beside > 0.0) & (beside < np.pi)]))
    signs = numbers.directions(radius * np.exp(1j * angles))
    while True:
        turns = np.angle(signs[1:] / signs[:-1])
        wide = np.flatnonzero(~(np.abs(turns) <= _WINDING))
        if not wide.size:
            break
        middle = 0.5 * (angles[wide] + angles[wide + 1])
        if np.min(angles[wide + 1] - angles[wide]) < _FINEST or angles.size > _MOST:
            return None
        angles = np.insert(angles, wide + 1, middle)
        signs = np.insert(signs, wide + 1, numbers.directions(radius * np.exp(1j * middle)))
    return growth - round(float(turns.sum()) / np.pi)  # of both halves, which mirror each other


# ---- Which impact times belong to one and the same orbit: shifts of the first impact, and by whole periods of the load

SAME = 1e-7  # impact times that are as near as this are the same, in radians of the load

_ROUNDING = 1e-12


def load_turn(load: Load) -> float:
    """After how long the load repeats: 2π, or an even part of it, as where only its harmonics 2, 4, … are present."""
    if not load.is_piecewise:
        return TURN / math.gcd(*load.harmonics.tolist()) if load.harmonics.size else TURN
    breaks, values = np.asarray(load.breaks), np.asarray(load.values)
    for shift in range(1, breaks.size):  # by so many steps
        if breaks.size % shift:
            continue
        moved = np.mod(np.roll(breaks, -shift) - breaks, TURN)
        if np.ptp(moved) <= _ROUNDING and np.all(np.roll(values, -shift) == values):
            return float(moved[0])
    return TURN


def differences(times: Array, others: Array, period: float, turn: float) -> Array:
    """t_i − t'_{i+c} for every shift c of the first impact, least by whole periods: (…, p), (K, p) to (…, K, p, p)."""
    p = others.shape[-1]
    endless = np.concatenate([others, others + period], axis=-1)
    shifted = np.stack([endless[:, c : c + p] for c in range(p)], axis=1)
    off = times[..., None, None, :] - shifted
    return np.asarray(off - turn * np.rint(off.mean(axis=-1, keepdims=True) / turn))


def repeats(times: Array, period: float, turn: float) -> int:
    """How often a shorter orbit is repeated in the cycle: 1 for none; `times` of shape (p,)."""
    p = times.size
    turns = round(period / turn)
    for often in range(math.gcd(p, turns), 1, -1):
        if p % often or turns % often:
            continue
        step = p // often
        endless = np.concatenate([times, times + period])
        if np.abs(endless[step : step + p] - times - period / often).max() <= SAME:
            return often
    return 1


def canonical(times: Array, period: float, turn: float) -> tuple[Array, int]:
    """The times from the impact with the least phase on (of equal ones that before the shortest flight); its number."""
    flights = np.append(times[1:], times[0] + period) - times
    phases = np.mod(times, turn)
    phases = np.where(turn - phases <= SAME, phases - turn, phases)
    least = np.flatnonzero(phases <= phases.min() + SAME)
    first = int(least[np.argmin(flights[least])])
    moved = np.concatenate([times[first:], times[:first] + period])
    start = float(np.mod(moved[0], turn))
    return start + np.append(0.0, np.cumsum(np.diff(moved))), first


# ---- How an orbit moves with a parameter: the column of the parameter beside the matrix of the times

_STEP = 1e-6  # of the parameter, relative where that is large


def slope(function: Callable[[float], Array], step: float, refusal: type[Exception] = PercussError) -> Array:
    """The derivative at 0 by central differences; to one side where the function refuses, as the range ends there."""

    def at(place: float) -> Array | None:
        try:
            return function(place)
        except Interrupted:
            raise
        except (PercussError, refusal):
            return None

    forward, inner = at(step), step
    if forward is None:
        forward, inner = function(-step), -step
    back = at(-inner)
    if back is not None:
        return np.asarray((forward - back) / (2.0 * inner))
    return np.asarray((4.0 * forward - function(2.0 * inner) - 3.0 * function(0.0)) / (2.0 * inner))


def parameter_column(orbit: PeriodicOrbit, family: Callable[[float], System], value: float) -> Array:
    """∂F/∂λ at fixed times of the impacts, by central differences: exact to 1e-10 of F, and of the load to rounding.

    Beside `orbit.bordered()` it is the matrix with which a branch is followed.

    Parameters
    ----------
    family
        The system at a value of the parameter λ.
    value
        λ of the orbit.

    Returns
    -------
    numpy.ndarray
        Shape (p + 1,): of the p equations, and of that for the rigid velocity (0 where this follows from the times).

    Raises
    ------
    ParameterError
        When the family gives no system.

    Examples
    --------
    >>> from percuss import Load, System
    >>> from percuss.steady import orbit_near
    >>> def family(mean):
    ...     return System(s=5.0, d=0.0, restitution=0.5, load=Load.harmonic(mean, 1.0))
    >>> orbit = orbit_near(family(0.62), [0.4, 2.3], modes=0)
    >>> parameter_column(orbit, family, 0.62).shape
    (3,)
    """
    instance("orbit", orbit, PeriodicOrbit)
    here = finite("value", value)
    if not callable(family) or isinstance(family, type):
        raise ParameterError("family", family, "a function from a number to a System")

    def off(by: float) -> Array:
        return orbit.off(instance("family", family(here + by), System))

    return slope(off, _STEP * max(1.0, abs(here)))


def time_rates(orbit: PeriodicOrbit, family: Callable[[float], System], value: float) -> Array:
    """dt_i/dλ, how the impact times move with the parameter; shape (p,).

    They grow without bound towards a fold.

    Parameters
    ----------
    orbit, family, value
        As for `parameter_column`.

    Raises
    ------
    ParameterError
        As `parameter_column`; and at a fold.

    Examples
    --------
    >>> from percuss import Load, System
    >>> from percuss.steady import orbit_near
    >>> def family(mean):
    ...     return System(s=5.0, d=0.0, restitution=0.5, load=Load.harmonic(mean, 1.0))
    >>> orbit = orbit_near(family(0.62), [0.4, 2.3], modes=0)
    >>> later = orbit_near(family(0.62 + 1e-6), orbit.times, modes=0)
    >>> moved = (np.array(later.times) - orbit.times) / 1e-6
    >>> bool(abs(moved - time_rates(orbit, family, 0.62)).max() < 1e-4)
    True
    """
    column = parameter_column(orbit, family, value)
    try:
        return np.asarray(-np.linalg.solve(orbit.bordered(), column)[:-1])
    except np.linalg.LinAlgError:
        raise ParameterError("value", value, "a value at which the orbit is no fold") from None
