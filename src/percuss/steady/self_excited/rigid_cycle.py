"""A periodic motion of a rigid piston that switches its own valve, found by Newton's method, and its figures."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property, reduce

import numpy as np

from percuss.model.checks import Array, ComplexArray
from percuss.steady.self_excited.piston_legs import leg_after
from percuss.steady.self_excited.piston_records import Leg, Piston, Rebound, Segment, Switch, Uncovering
from percuss.steady.self_excited.supply_course import pressure_integral
from percuss.steady.self_excited.valve_cycle import Place, ValveCycle

__all__ = ["RigidCycle", "cycle_near"]

_STEPS = 40
_SHRINKING = 16  # steps after which each is shorter than the one before, or there is no cycle near
_CLOSELY = 3  # the same for a start close to the cycle
_SHRUNK = 0.9  # of the step before: at a fold it is 0.5
_CLOSED = 1e-13  # of the speed and of the period
_MEETS = 1e-9  # … of the rebound and the one that follows: at a grazing the slope is so great that no step is long
_HALVINGS = 6


@dataclass(frozen=True)
class RigidCycle(ValveCycle):
    """A periodic motion of a rigid piston that switches its own valve.

    Parameters
    ----------
    legs
        Its flights from blow to blow.
    rebound
        The piston just after the blow at time 0.
    piston
        What moves.
    """

    legs: tuple[Leg, ...]
    rebound: Rebound
    piston: Piston

    @property
    def blow_times(self) -> Array:
        """When the blows fall, the last one at the period."""
        return np.cumsum([leg.duration for leg in self.legs])

    @property
    def blow_speeds(self) -> Array:
        """Speed just before each blow."""
        return np.array([leg.blow_speed for leg in self.legs])

    @property
    def blow_energies(self) -> Array:
        """Kinetic energy just before each blow."""
        return np.asarray(0.5 * self.blow_speeds**2)

    @property
    def level_difference(self) -> float:
        """The greatest force of the valve minus the least."""
        forces = [force for _, force in self.piston.valve.pairs]
        return max(forces) - min(forces)

    @property
    def switches(self) -> tuple[Switch, ...]:
        """Every change of the valve's state, in order of time."""
        return tuple(
            Switch(start + s.time, s.to, s.behind, s.velocity, s.work)
            for start, leg in self._timed
            for s in leg.switches
        )

    @property
    def uncoverings(self) -> tuple[Uncovering, ...]:
        """Where ports demand a new state, in order of time; blows that do are not among them."""
        return tuple(
            Uncovering(u.port, start + u.time, u.velocity) for start, leg in self._timed for u in leg.uncoverings
        )

    @property
    def segments(self) -> tuple[Segment, ...]:
        """The flights between events, in order of time."""
        return tuple(replace(s, time=start + s.time) for start, leg in self._timed for s in leg.segments)

    @property
    def _timed(self) -> list[tuple[float, Leg]]:
        return list(zip([0.0, *self.blow_times.tolist()], self.legs, strict=False))

    @property
    def stroke(self) -> float:
        """The greatest distance behind the wall."""
        return max(leg.farthest for leg in self.legs)

    @property
    def work(self) -> float:
        """What the switches of the valve put into the motion in a cycle; the blows and the drag take the same."""
        supply = self.piston.valve.supply
        if supply is None:
            return math.fsum(switch.work for switch in self.switches)
        return supply.flow * math.fsum(pressure_integral(one, self.piston) for one in self.segments)

    @property
    def drawn(self) -> float:
        """Volume that the valve takes from the supply in a cycle, times the pressure for which its forces hold."""
        supply = self.piston.valve.supply
        return self.work if supply is None else supply.flow * self.period

    @property
    def taken(self) -> float:
        """Energy that the blows of a cycle take."""
        speeds = [(leg.blow_speed, leg.rebound.speed) for leg in self.legs if leg.rebound is not None]
        return math.fsum(0.5 * (before**2 - after**2) for before, after in speeds)

    @property
    def rests(self) -> bool:
        """Whether the piston lies on the wall for some time."""
        return any(s.flight.v == s.velocity == s.behind == 0.0 for leg in self.legs for s in leg.segments)

    @property
    def slope(self) -> Array:
        """Derivative of the numbers of the rebound after a cycle by those before it."""
        slope: Array = reduce(lambda done, leg: leg.slope @ done, self.legs, np.eye(self.rebound.numbers.size))
        return slope

    @cached_property
    def multipliers(self) -> ComplexArray:
        """Multipliers of the map from cycle to cycle, the greatest first, without the neutral one, a shift in time."""
        found: ComplexArray = np.linalg.eigvals(self.slope).astype(complex)
        return found[np.argsort(-np.abs(found), kind="stable")]

    @property
    def at_constant_pressure(self) -> RigidCycle:
        """The same with its pressure forgotten: what a cycle under the constant one is looked for from."""
        return replace(self, rebound=replace(self.rebound, pressure=None))

    def _displacement(self, within: Array, place: Place) -> Array:
        segments = self.segments  # all of the piston moves alike
        begins = np.array([segment.time for segment in segments])
        which = np.maximum(np.searchsorted(begins, within, side="right") - 1, 0)
        found = np.empty(within.shape)
        for i in np.unique(which).tolist():
            there = which == i
            found[there] = segments[i].flight.distances(within[there] - begins[i])
        return -found


def cycle_near(piston: Piston, rebound: Rebound, blows: int, *, close: bool = False) -> RigidCycle | None:
    """The cycle of so many blows to which Newton's method leads from a rebound near it, or None.

    With `close` the rebound is so near it that the steps soon get shorter.
    """
    now, legs, before = rebound, _legs(piston, rebound, blows), math.inf
    for number in range(_STEPS):
        if legs is None or _is_idle(now, legs):
            return None
        error = _error(now, legs)
        slope: Array = reduce(lambda done, leg: leg.slope @ done, legs, np.eye(now.numbers.size))
        try:
            step: Array = np.linalg.solve(np.eye(slope.shape[0]) - slope, error).astype(float)
        except np.linalg.LinAlgError:
            return None
        if not np.all(np.isfinite(step)):
            return None
        scale = np.array([max(leg.blow_speed for leg in legs), *[sum(leg.duration for leg in legs)] * (step.size - 1)])
        if now.pressure is not None:
            scale[-1] = now.pressure
        size = float(np.max(np.abs(step) / scale))
        if size <= _CLOSED:
            return _made(piston, now, legs) if np.all(np.abs(error) <= _MEETS * scale) else None
        if number >= (_CLOSELY if close else _SHRINKING) and size > _SHRUNK * before:
            return None
        before = size
        now, legs = _stepped(piston, now, step, blows)
    return None


def _legs(piston: Piston, rebound: Rebound, blows: int) -> tuple[Leg, ...] | None:
    """The flights of so many blows, when they lead to a rebound of the same kind."""
    legs: list[Leg] = []
    now = rebound
    for _ in range(blows):
        legs.append(leg_after(piston, now))
        following = legs[-1].rebound
        if following is None:
            return None
        now = following
    return tuple(legs) if now.label == rebound.label else None


def _is_idle(rebound: Rebound, legs: tuple[Leg, ...]) -> bool:
    """Whether no demand was accepted.

    A slower rebound passes some of the same ports, so that it changes nothing either: Newton's method leads to rest.
    """
    return not rebound.orders.pending and not any(leg.switches or leg.dropped for leg in legs)


def _error(rebound: Rebound, legs: tuple[Leg, ...]) -> Array:
    last = legs[-1].rebound
    assert last is not None
    return last.numbers - rebound.numbers


def _stepped(piston: Piston, rebound: Rebound, step: Array, blows: int) -> tuple[Rebound, tuple[Leg, ...] | None]:
    """The rebound after a step, or after a part of it where the whole one leads to another kind of motion."""
    for halving in range(_HALVINGS):
        numbers = rebound.numbers + 0.5**halving * step
        if np.all(numbers >= 0.0):
            following = rebound.with_numbers(numbers)
            legs = _legs(piston, following, blows)
            if legs is not None:
                return following, legs
    return rebound, None


def _made(piston: Piston, rebound: Rebound, legs: tuple[Leg, ...]) -> RigidCycle:
    """The cycle, with its longest flight first."""
    longest = int(np.argmax([leg.duration for leg in legs]))
    begins = [rebound, *(leg.rebound for leg in legs)][longest]
    assert begins is not None
    return RigidCycle(legs[longest:] + legs[:longest], begins, piston)
