"""A periodic motion of a rigid piston that switches its own valve, found by Newton's method, and its figures."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property, reduce
from typing import Literal, NamedTuple

import numpy as np
import numpy.typing as npt

from percuss.errors import ParameterError
from percuss.halting import look
from percuss.model.checks import Array, ComplexArray, numbers, unit_interval
from percuss.shown import Shown
from percuss.steady.self_excited import piston_kernels as kn
from percuss.steady.self_excited.piston_flight import distances
from percuss.steady.self_excited.piston_legs import (
    MOST,
    Leg,
    Piston,
    Rebound,
    Segment,
    Switch,
    Uncovering,
    leg_after,
    leg_from,
    pressure_integral,
    rebound_of,
    row_of,
    table,
)

# ---- Which multipliers of an elastic machine belong to its rhythm and which to its ringing, and to which mode
#
# By participation factors l_n·r_n of the left and right eigenvectors (I. J. Pérez-Arriaga, G. C. Verghese and
# F. C. Schweppe, IEEE Trans. Power Apparatus and Systems 101, 1982), which do not depend on the scales of
# the coordinates.

_NOTHING = 1e-7  # a multiplier that is 0 but for rounding, which several zeros together magnify
_BELONGS = 0.5  # share of the motion as a whole from which a multiplier is one of the rhythm
_TOLD = 0.1  # share from which a mode is told


class ModeShare(NamedTuple):
    """A coordinate of the machine by its number (0: the motion as a whole), and its part in a multiplier, 0 to 1."""

    mode: int
    share: float


@dataclass(frozen=True)
class Ringing(Shown):
    """What rings longest of a machine in its cycle.

    Parameters
    ----------
    multiplier
        The greatest of those that belong to the elastic modes; of a pair that with the positive imaginary part.
    shares
        What each mode has of it, the greatest first; they sum to 1. Of a machine with a chamber the modes are its own
        (`Machine.modes`), which the chamber couples.
    """

    multiplier: complex
    shares: tuple[ModeShare, ...]

    @property
    def mode(self) -> int:
        """The mode with the greatest share."""
        return self.shares[0].mode

    @property
    def told(self) -> tuple[ModeShare, ...]:
        """The modes that are worth telling: that with the greatest share, and all with a tenth or more."""
        return tuple(one for i, one in enumerate(self.shares) if i == 0 or one.share >= _TOLD)

    @property
    def decay(self) -> float:
        """Cycles in which it falls to 1/e; infinite where it does not die out."""
        modulus = abs(self.multiplier)
        return -1.0 / math.log(modulus) if modulus < 1.0 else math.inf

    def __str__(self) -> str:
        return f"Ringing: mode {self.mode} ({100.0 * self.shares[0].share:.3g} %), modulus {abs(self.multiplier):.4g}"


class Parted(NamedTuple):
    """The greatest multiplier of the motion as a whole, and the ringing; None where there is none."""

    rhythm: complex | None
    ringing: Ringing | None


def parted(slope: Array, modes: int) -> Parted:
    """The multipliers of a cycle's map, parted into rhythm and ringing; pending orders are part of the rhythm."""
    from scipy.linalg import eig  # slow to import

    values, left, right = (np.asarray(one, dtype=complex) for one in eig(slope, left=True, right=True))
    felt = np.flatnonzero((np.abs(values) > _NOTHING) & (values.imag >= 0.0))
    felt = felt[np.argsort(-np.abs(values[felt]), kind="stable")]
    factors = left[:, felt].conj() * right[:, felt]
    size = 2 * (modes + 1)
    own = np.abs(factors[:size].reshape(modes + 1, 2, -1).sum(axis=1))
    own[0] += np.abs(factors[size:]).sum(axis=0)
    shares = own / np.maximum(own.sum(axis=0), np.finfo(float).tiny)
    whole = shares[0] > _BELONGS
    rhythm = complex(values[felt[whole][0]]) if whole.any() else None
    if whole.all():
        return Parted(rhythm, None)
    first = int(np.flatnonzero(~whole)[0])
    order = np.argsort(-shares[:, first], kind="stable").tolist()
    parts = tuple(ModeShare(mode, float(shares[mode, first])) for mode in order)
    return Parted(rhythm, Ringing(complex(values[felt[first]]), parts))


# ---- What a periodic motion of a machine that switches its own valve tells, whether its piston is rigid or elastic

Place = Literal["centre"] | float
"""Of a body: its centre of mass, or from 0 (driven end) to 1 (striking end)."""


def checked_place(place: object) -> Place:
    """A place of the body, or an error."""
    if isinstance(place, str):
        if place != "centre":
            raise ParameterError("place", place, "'centre' or a place on the bar from 0 to 1")
        return "centre"
    return unit_interval("place", place)


class ValveCycle(Shown, ABC):
    """A periodic motion of a machine that switches its own valve; per unit of mass, as loads are.

    Time 0 is just after the last blow of the cycle; the longest flight comes first. Speeds of blows are those of the
    striking end just before.
    """

    # -- what each kind of cycle tells --

    @property
    @abstractmethod
    def blow_times(self) -> Array:
        """When the blows fall, the last one at the period."""

    @property
    @abstractmethod
    def blow_speeds(self) -> Array:
        """Speed just before each blow."""

    @property
    @abstractmethod
    def blow_energies(self) -> Array:
        """Kinetic energy just before each blow, that of the ringing with it."""

    @property
    @abstractmethod
    def switches(self) -> tuple[Switch, ...]:
        """Every change of the valve's state, in order of time."""

    @property
    @abstractmethod
    def uncoverings(self) -> tuple[Uncovering, ...]:
        """Where ports demand a new state, in order of time; blows that do are not among them."""

    @property
    @abstractmethod
    def stroke(self) -> float:
        """The greatest distance of the striking end from the wall."""

    @property
    @abstractmethod
    def work(self) -> float:
        """What the valve puts into the motion in a cycle; the blows, the damping and the rests take the same."""

    @property
    @abstractmethod
    def taken(self) -> float:
        """Energy that the blows of a cycle take."""

    @property
    @abstractmethod
    def taken_by_rest(self) -> float:
        """Energy lost on lying down: what the last blow left, for a piston at rest on the wall is undeformed."""

    @property
    @abstractmethod
    def level_difference(self) -> float:
        """The greatest force of the valve minus the least."""

    @property
    @abstractmethod
    def rests(self) -> bool:
        """Whether the piston lies on the wall for some time."""

    @property
    @abstractmethod
    def multipliers(self) -> ComplexArray:
        """Multipliers of the map from cycle to cycle, the greatest first, without the neutral one, a shift in time."""

    @abstractmethod
    def _displacement(self, within: Array, place: Place) -> Array:
        """Displacement of a place of the body at times of the cycle; the shape of `within`."""

    # -- what follows --

    @property
    def period(self) -> float:
        """Duration of the cycle."""
        return float(self.blow_times[-1])

    @property
    def blows(self) -> int:
        """Blows in a cycle."""
        return self.blow_times.size

    @property
    def blow_speed(self) -> float:
        """Speed just before the strongest blow."""
        return float(self.blow_speeds.max())

    @property
    def blow_energy(self) -> float:
        """Kinetic energy just before the strongest blow."""
        return float(self.blow_energies.max())

    @property
    def drawn(self) -> float:
        """Volume that the valve takes from the supply in a cycle, times the pressure for which its forces hold."""
        return self.work

    @property
    def swept_length(self) -> float:
        """Volume that the valve takes from the supply in a cycle, per area that it switches."""
        return self.drawn / self.level_difference if self.level_difference > 0.0 else 0.0

    @property
    def duty(self) -> float:
        """Part of the period between the last rise of the force and the blow that follows."""
        rises = [switch.time for switch in self.switches if switch.work > 0.0]
        if not rises:
            return 0.0
        blow = min(time for time in self.blow_times.tolist() if time >= rises[-1])
        return float((blow - rises[-1]) / self.period)

    @property
    def multiplier(self) -> complex:
        """The greatest multiplier: what is left of a disturbance after a cycle."""
        return complex(self.multipliers[0])

    @property
    def rhythm_multiplier(self) -> complex | None:
        """The greatest multiplier of the motion as a whole; None where it cannot be told from the ringing."""
        return self.multiplier

    @property
    def ringing(self) -> Ringing | None:
        """What rings longest; None where nothing is left of the ringing after a cycle, and of a rigid piston."""
        return None

    @property
    def stable(self) -> bool:
        """Whether disturbances die out."""
        return abs(self.multiplier) < 1.0

    def position(self, times: npt.ArrayLike, place: Place = 1.0) -> Array:
        """Displacement of a place of the body, 0 at the wall and negative behind it; the shape of `times`.

        Parameters
        ----------
        times
            Any; the motion is repeated with its period.
        place
            From 0 (driven end) to 1 (striking end), or "centre".

        Raises
        ------
        ParameterError
            When an argument is none of these.
        """
        found = np.mod(numbers("times", times), self.period)
        return self._displacement(np.asarray(found), checked_place(place))

    def __str__(self) -> str:
        blows = "1 blow" if self.blows == 1 else f"{self.blows} blows"
        return (
            f"{type(self).__name__}: {blows}, speed {self.blow_speed:.6g}, period {self.period:.6g}, "
            f"stroke {self.stroke:.6g}, multiplier {abs(self.multiplier):.4g}"
        )


# ---- A periodic motion of a rigid piston that switches its own valve, found by Newton's method, and its figures


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
    def taken_by_rest(self) -> float:
        """None: a rigid piston rests where a blow has taken all that it had."""
        return 0.0

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
            found[there] = distances(segments[i].flight, within[there] - begins[i])
        return -found


@dataclass(frozen=True)
class _Search:
    """A piston, and room to look for its cycle."""

    piston: Piston
    most: int = 0  # legs that are followed
    room: int = MOST  # for pending orders

    @cached_property
    def work(self) -> kn.Tables:
        """What the functions work on."""
        forces, ports, law, _ = self.piston.numbers
        rows, size = kn.FIRST + self.most, 2 + self.room
        matrices = [table(size, size + 1) for _ in range(kn.MATRICES)]
        slopes, tells = table(kn.BY_ORDER + self.room, size), table(rows, kn.TOLD)
        return kn.Tables(forces, ports, law, table(rows, kn.DUE + 2 * self.room), slopes, matrices, tells, [0.0] * size)

    def near(self, rebound: Rebound, blows: int, shrinking: int) -> RigidCycle | None:
        """The cycle of so many blows to which Newton's method leads from a rebound near it, or None."""
        look()
        begin, supply = row_of(self.piston, rebound, self.room), self.piston.numbers[-1]
        return self.found(blows if kn.cycle_near(begin, blows, shrinking, self.work, supply) else 0)

    def after(self, rebound: Rebound) -> RigidCycle | None:
        """The cycle that one of the blows after a rebound is near."""
        look()
        kn.copied(row_of(self.piston, rebound, self.room), self.work.rows[kn.NOW])
        supply = self.piston.numbers[-1]
        number, ending = kn.followed(self.most, self.work, supply)
        return self.found(kn.cycle_at(0, number if ending == kn.BLOW else number - 1, self.work, supply))

    def found(self, blows: int) -> RigidCycle | None:
        """The cycle of so many blows that was found, with its longest flight first; none of 0."""
        if blows == 0:
            return None
        rebound = rebound_of(self.piston, self.work.rows[kn.NEXT])
        legs = tuple(_followed(self.piston, leg_after(self.piston, rebound), blows))
        longest = int(np.argmax([leg.duration for leg in legs]))
        begins = [rebound, *(leg.rebound for leg in legs)][longest]
        assert begins is not None
        return RigidCycle(legs[longest:] + legs[:longest], begins, self.piston)


def cycle_near(piston: Piston, rebound: Rebound, blows: int, *, close: bool = False) -> RigidCycle | None:
    """The cycle of so many blows to which Newton's method leads from a rebound near it, or None.

    With `close` the rebound is so near it that the steps soon get shorter.
    """
    return _Search(piston, 0, _room(rebound)).near(rebound, blows, kn.CLOSELY if close else kn.SHRINKING)


def _room(rebound: Rebound) -> int:
    return MOST + 2 * len(rebound.orders.pending)


# ---- The cycle in which a machine that switches itself ends: some blows from a fast start, then Newton's method

_LAST = 5  # rebounds + 1
_MOST_ROOM = 400  # for pending orders: a leg has no more events


def followed_legs(
    piston: Piston, behind: float = 0.0, velocity: float = 0.0, most: int = kn.STARTED_BLOWS
) -> list[Leg]:
    """The flights from a start, blow by blow, until nothing follows; the valve begins in its starting state."""
    return _followed(piston, leg_from(piston, behind, velocity), most)


def _followed(piston: Piston, first: Leg, most: int) -> list[Leg]:
    legs, greatest = [first], 0.0
    while len(legs) < most and (rebound := legs[-1].rebound) is not None:
        greatest = max(greatest, rebound.speed)
        if rebound.speed < kn.CHATTER * greatest and piston.after(replace(rebound, speed=0.0)).push < 0.0:
            rebound = replace(rebound, speed=0.0)
        legs.append(leg_after(piston, rebound))
    return legs


def followed_from(piston: Piston, rebound: Rebound, most: int) -> list[Leg]:
    """The flights from a rebound on, blow by blow, until nothing follows."""
    return _followed(piston, leg_after(piston, rebound), most)


def settled(piston: Piston) -> tuple[RigidCycle | None, list[Leg]]:
    """The cycle in which a fast start ends, and without one the flights of the fastest start."""
    look()
    room, why, part = MOST, kn.UNKNOWN, 1.0
    while why == kn.UNKNOWN and room <= _MOST_ROOM:
        search = _Search(piston, kn.MOST_BLOWS, room)
        why, blows, part = kn.settled(search.work, piston.numbers[-1])
        room *= 2
    if blows:
        return search.found(blows), []
    row = search.work.rows[kn.NOW]
    kn.fast(*piston.numbers[:3], part, row)
    return None, followed_from(piston, rebound_of(piston, row), kn.MOST_BLOWS)


def continued(piston: Piston, cycle: RigidCycle) -> RigidCycle | None:
    """The cycle with one blow of a machine that differs little from the one that has the given cycle."""
    found = cycle_near(piston, cycle.rebound, 1, close=True)
    if found is not None:
        return found
    legs = _followed(piston, leg_after(piston, cycle.rebound), kn.FEW)
    rebounds = [leg.rebound for leg in legs if leg.rebound is not None]
    tried = (cycle_near(piston, rebound, 1, close=True) for rebound in rebounds[:-_LAST:-1])
    return next((one for one in tried if one is not None and one.switches), None)


# ---- The cycle of a machine that a pump and an accumulator feed: first the pressure that results, then Newton's method
#
# Under a constant pressure a cycle draws a volume in its time; the pressure that results is the one at which the pump
# gives just that. It is the cycle's for an accumulator without end, which is then made smaller step by step.

_TRIED = (1.0, 2.0, 0.5, 4.0)
"""Pressures at which a machine may run."""
_STEP = 0.25  # of the logarithm of the pressure
_MOST_STEPS = 40
_NEAR = 1e-6
_SMALL_SWING = 0.05  # of the pressure in a cycle: where the steps of the accumulator begin
_MOST_HALVINGS = 40
_MOST_FED_BLOWS = 120


def under_pressure(piston: Piston, pressure: float) -> Piston:
    """The piston under a constant pressure."""
    return replace(piston, valve=piston.valve.at_pressure(pressure))


def fed(piston: Piston) -> tuple[RigidCycle | None, list[Leg]]:
    """The cycle of a piston with a supply, and the flights of a start near it when there is none with one blow."""
    balance = _balanced(piston)
    rebound = None if balance is None else _with_pressure(piston, *balance)
    cycle = None if rebound is None or balance is None else _with_less_oil(piston, rebound, *balance)
    if cycle is not None:
        return cycle, []
    rebound = rebound or _start(piston)
    cycle = _Search(piston, _MOST_FED_BLOWS, _room(rebound)).after(rebound)
    return cycle, [] if cycle is not None else followed_from(piston, rebound, _MOST_FED_BLOWS)


def _start(piston: Piston) -> Rebound:
    """The piston on the wall, as the machine starts."""
    valve, supply = piston.valve, piston.valve.supply
    assert supply is not None
    return Rebound(0.0, valve.orders.last, valve.orders, supply.start)


def _with_pressure(piston: Piston, cycle: RigidCycle, pressure: float) -> Rebound:
    return replace(cycle.rebound, pressure=pressure)


def _balanced(piston: Piston) -> tuple[RigidCycle, float] | None:
    """The cycle under the constant pressure at which it draws what the pump gives, and that pressure."""
    low = high = None
    for pressure in _TRIED:
        cycle, _ = settled(under_pressure(piston, pressure))
        if cycle is not None and cycle.blows == 1 and cycle.work > 0.0:
            break
    else:
        return None
    for _ in range(_MOST_STEPS):
        surplus = _surplus(piston, cycle, pressure)
        if surplus > 0.0:
            low = cycle, pressure
        else:
            high = cycle, pressure
        if low is not None and high is not None:
            return _between(piston, low, high)
        pressure *= math.exp(math.copysign(_STEP, surplus))
        following = continued(under_pressure(piston, pressure), cycle)
        if following is None:
            break
        cycle = following
    return low or high


def _surplus(piston: Piston, cycle: RigidCycle, pressure: float) -> float:
    """The logarithm of what the pump gives in a cycle over what the piston draws under a constant pressure."""
    supply = piston.valve.supply
    assert supply is not None
    return math.log(supply.flow * cycle.period * pressure / cycle.work)


def _between(piston: Piston, low: tuple[RigidCycle, float], high: tuple[RigidCycle, float]) -> tuple[RigidCycle, float]:
    """The pressure of balance between two at which the piston runs."""
    while high[1] - low[1] > _NEAR * low[1]:
        pressure = math.sqrt(low[1] * high[1])
        cycle = continued(under_pressure(piston, pressure), low[0])
        if cycle is None:
            break
        if _surplus(piston, cycle, pressure) > 0.0:
            low = cycle, pressure
        else:
            high = cycle, pressure
    return low


def _with_less_oil(piston: Piston, rebound: Rebound, cycle: RigidCycle, pressure: float) -> RigidCycle | None:
    """The cycle with the accumulator there is, from one with which the pressure hardly swings."""
    found = None
    for compliance in _compliances(piston, cycle.work / (_SMALL_SWING * pressure**2)):
        supply = piston.valve.supply
        assert supply is not None
        other = replace(piston, valve=replace(piston.valve, supply=replace(supply, compliance=compliance)))
        found = cycle_near(other, rebound, 1)
        if found is None or not found.switches:
            return None
        rebound = found.rebound
    return found


def _compliances(piston: Piston, most: float) -> Iterator[float]:
    supply = piston.valve.supply
    assert supply is not None
    halvings = min(max(math.ceil(math.log2(most / supply.compliance)), 0), _MOST_HALVINGS)
    for halving in range(halvings, -1, -1):
        yield supply.compliance * 2.0**halving
