"""A periodic motion of a machine that switches its own valve, rigid or elastic, and what it tells."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from enum import Enum
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import numpy as np
import numpy.typing as npt

from percuss.errors import ParameterError
from percuss.mechanics.crossing import farthest
from percuss.mechanics.flow import ModalFlight, StateFlow, state_flows
from percuss.mechanics.oil import OilBalance
from percuss.model import Contact, Machine, MachineModes, Valve
from percuss.model.checks import Array, ComplexArray, numbers, unit_interval
from percuss.model.load import Side
from percuss.model.load.valve import Orders
from percuss.short_repr import ShortRepr
from percuss.steady.multipliers import CycleMap, Multipliers, Repeating
from percuss.steady.self_excited.cycle_times import CycleTimes
from percuss.steady.self_excited.piston_flight import PistonFlight, extremes

if TYPE_CHECKING:
    from percuss.steady.flight import Energy

# ---- Which multipliers of an elastic machine belong to its rhythm and which to its ringing, and to which mode
#
# By participation factors l_n·r_n of the left and right eigenvectors (I. J. Pérez-Arriaga, G. C. Verghese and
# F. C. Schweppe, IEEE Trans. Power Apparatus and Systems 101, 1982), which do not depend on the scales of
# the coordinates.

_SQUARINGS, _GROWN = 6, 1e30  # of the map of a cycle; a power that will not shrink any more
_NOTHING = 1e-7  # a multiplier that is 0 but for rounding, which several zeros together magnify
_BELONGS = 0.5  # share of the motion as a whole from which a multiplier is one of the rhythm
_TOLD = 0.1  # share from which a mode is told


class ModeShare(NamedTuple):
    """A coordinate of the machine by its number (0: the motion as a whole), and its part in a multiplier, 0 to 1."""

    mode: int
    share: float


@dataclass(frozen=True)
class Ringing(ShortRepr):
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


def _directions(slope: Array) -> tuple[ComplexArray, ComplexArray, ComplexArray]:
    """Eigenvalues with their eigenvectors and those of the transpose, by the nearest of its values; of length 1."""
    values, right = np.linalg.eig(slope)
    others, left = np.linalg.eig(slope.T)
    nearest = np.argmin(np.abs(others - values[:, None]), axis=1)
    return values.astype(complex), left[:, nearest].astype(complex), right.astype(complex)


def parted(slope: Array, modes: int) -> Parted:
    """The multipliers of a cycle's map, parted into rhythm and ringing; pending orders are part of the rhythm."""
    values, left, right = _directions(slope)
    felt = np.flatnonzero((np.abs(values) > _NOTHING) & (values.imag >= 0.0))
    felt = felt[np.argsort(-np.abs(values[felt]), kind="stable")]
    factors = left[:, felt] * right[:, felt]
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


def pressure_multiplier(slope: Array, modes: int) -> complex:
    """The multiplier of a cycle's map in which the pressure of a supply has the greatest part."""
    values, left, right = _directions(slope)
    number = 2 * (modes + 1) if modes else 1
    return complex(values[np.argmax(np.abs(left[number] * right[number]))])


# ---- A flight, and what happens between flights

Place = Literal["centre"] | float  # of a body: its centre of mass, or from 0 (driven end) to 1 (striking end)


@dataclass(frozen=True, kw_only=True)
class ValveFlight(ModalFlight):
    """A flight from `time` on, with the valve's state and last demand, and the pressure of a supply at its start.

    `held`: the bar has left the wall at rest, so that no contact is looked for so long after the start.
    """

    state: str
    last: str
    time: float
    held: float = 0.0
    pressure: float = 1.0

    @property
    def lies(self) -> bool:
        """Whether it is none: the bar lies on the wall."""
        return self.force == 0.0 and not self.begin.any()

    @property
    def rigid(self) -> PistonFlight:
        """That of a rigid piston without a supply, by its distance behind the wall."""
        modes, (u, v) = self.modes, self.begin[0].tolist()
        return PistonFlight(-self.force, float(modes.omega[0]) ** 2, float(modes.damping[0]), -u, -v)

    @property
    def farthest(self) -> float:
        """The greatest distance of the striking end from the wall."""
        if self.modes.size or self.ramp:
            return farthest(self, self.modes.end)
        return max(extremes(self.rigid, self.duration)[1], -float(self.end[0, 0]))

    @cached_property
    def way(self) -> float:
        """The integral over time of how far the place where the valve acts has moved from the start of the flight."""
        modes, t = self.modes, self.duration
        came, faster = (self.end - self.begin).T
        pull = self.force * modes.driven - modes.omega**2 * self.begin[:, 0]
        with np.errstate(divide="ignore", invalid="ignore"):  # of the equation of motion
            found = (pull * t + 0.5 * self.ramp * modes.driven * t * t - faster - modes.damping * came) / modes.omega**2
        if float(modes.omega[0]) * t < 1.0:  # where it cancels; Gauss's rule is exact there
            x, weights = np.polynomial.legendre.leggauss(12)
            moved = self.moved(0.5 * t * (x + 1.0))[0][0]
            found[0] = 0.5 * t * float(weights @ moved)
        return float(modes.driven @ found)


@dataclass(frozen=True)
class Switch:
    """A change of the valve's state.

    Attributes
    ----------
    behind, velocity
        Of the piston: distance behind the wall, and velocity away from it.
    work
        Rise of the force times that distance, per unit of mass: what the switch puts into the motion.
    """

    time: float
    to: str
    behind: float
    velocity: float
    work: float


@dataclass(frozen=True)
class Uncovering:
    """A port demands a state: its number, the time after the blow, and the velocity away from the wall."""

    port: int
    time: float
    velocity: float


@dataclass(frozen=True)
class Rebound:
    """The piston just after a blow at time 0, before the blow demands anything: its speed, and what the valve is.

    The pressure of the supply is None where it is constant.
    """

    speed: float
    state: str
    orders: Orders
    pressure: float | None = None

    @property
    def numbers(self) -> Array:
        """What can change a little: the speed, when the pending orders are due, and the pressure of a supply."""
        pressure = [] if self.pressure is None else [self.pressure]
        return np.array([self.speed, *(due for due, _ in self.orders.pending), *pressure])


def checked_place(place: object) -> Place:
    """A place of the body, or an error."""
    if isinstance(place, str):
        if place != "centre":
            raise ParameterError("place", place, "'centre' or a place on the bar from 0 to 1")
        return "centre"
    return unit_interval("place", place)


@dataclass(frozen=True)
class MachineBlow(ShortRepr):
    """A blow of a machine.

    Attributes
    ----------
    time, speed
        When, and the speed of the striking end just before.
    kinetic, strain
        Energies just before, per unit of mass; that of the chamber, which follows the driven end, is part of `strain`.
    """

    time: float
    speed: float
    kinetic: float
    strain: float


def place_row(machine: Machine, modes: MachineModes, place: Place) -> Array:
    """What each coordinate moves a place of the body by."""
    return modes.centre if isinstance(place, str) else modes.at(machine.body, np.array([place]))[0]


def strain_of(flow: StateFlow, state: Array) -> float:
    """Elastic energy of a state (N + 1, 2), with that of the chamber; per unit of mass."""
    strained, place = flow.modes.omega * state[:, 0], float(flow.modes.driven @ state[:, 0])
    return 0.5 * (float(strained @ strained) - flow.spring * place * place)


# ---- The cycle

_LOOKS = 24  # at each flight
_BEYOND = 1e-9  # of the way to the farthest place


@dataclass(frozen=True)
class ValveCycle(Repeating):
    """A periodic motion of a machine that switches its own valve; per unit of mass, as loads are.

    Time 0 is just after the last blow of the cycle; the longest flight comes first. Speeds of blows are those of the
    striking end just before.

    Parameters
    ----------
    state, orders
        Of the valve at time 0, before the blow demands anything.
    flights
        The stretches between events, in order of time.
    switches
        Every change of the valve's state, in order of time, with place and velocity of the driven end.
    uncoverings
        Where ports demand a new state, in order of time; blows that do are not among them.
    slope
        Derivative of the map from cycle to cycle: of the numbers of the rebound of a rigid piston, or of displacement
        and velocity of every coordinate, one coordinate after the other, of the pressure of a supply, and of the times
        of the pending orders.
    lying
        Numbers of the blows after which the bar lies on the wall, if only for a moment; the last one is that at time 0.
    taken_by_rest
        Energy lost on lying down: what the last blow left, for a body at rest on the wall is undeformed.
    obstacle
        Why it is a root of the equations, but no motion; None for one that is.
    oil
        Where the energy of oil that flows goes; None where the oil loses nothing.
    passage
        Of oil that flows: the passage of a port at which the cycle is solved for (`percuss.steady.oil`).
    """

    machine: Machine
    modes: int
    state: str
    orders: Orders
    flights: tuple[ValveFlight, ...]
    struck: tuple[MachineBlow, ...]
    switches: tuple[Switch, ...]
    uncoverings: tuple[Uncovering, ...]
    slope: Array
    lying: tuple[int, ...] = ()
    taken_by_rest: float = 0.0
    obstacle: Enum | None = None
    oil: OilBalance | None = None
    passage: Any = None

    @property
    def system(self) -> Machine:
        """`machine`, as other motions call what moves."""
        return self.machine

    @property
    def admissible(self) -> bool:
        """Whether it is a motion."""
        return self.obstacle is None

    @property
    def rests(self) -> bool:
        """Whether the striking end lies on the wall for some time."""
        return bool(self.lying)

    @property
    def valve(self) -> Valve:
        """Of the machine."""
        return self.machine.valve

    @property
    def contact(self) -> Contact:
        """How the machine leaves the wall."""
        return self.machine.contact

    @cached_property
    def rhythm(self) -> CycleTimes:
        """When it strikes and passes ports, and the valve at time 0."""
        passages = tuple((one.time, one.port) for one in self.uncoverings)
        sticks = self.contact.velocity_factor == 0.0
        pressed = {flight.time for flight in self.flights if flight.lies}
        lying = tuple(i for i in self.lying if not sticks or np.append(self.blow_times[:-1], 0.0)[i] not in pressed)
        told = [(flight.time, flight.pressure) for flight in self.flights] if self.valve.delays_vary else []
        fed = (*told, (self.period, told[0][1])) if told else ()
        return CycleTimes(tuple(self.blow_times.tolist()), passages, self.state, self.orders, lying, sticks, fed)

    @property
    def rebound(self) -> Rebound:
        """The piston as a whole just after the blow at time 0."""
        first, fed = self.flights[0], self.valve.supply is not None
        speed = 0.0 - float(first.modes.centre @ first.begin[:, 1])  # no −0
        return Rebound(speed, self.state, self.orders, first.pressure if fed else None)

    @cached_property
    def stroke(self) -> float:
        """The greatest distance of the striking end from the wall."""
        if self.oil is not None:
            return self.oil.farthest
        return max((flight.farthest for flight in self.flights if flight.duration > 0.0), default=0.0)

    @property
    def keeps_before_the_wall(self) -> bool:
        """Whether the striking end is nowhere found beyond the wall, wherever it is looked at in flight."""
        looks = np.linspace(0.0, 1.0, _LOOKS)
        free = [one for one in self.flights if one.held < one.duration]
        seen = [one.modes.end @ one.at(one.held + looks * (one.duration - one.held))[0] for one in free]
        return max(float(y.max()) for y in seen) <= -_BEYOND * min(float(y.min()) for y in seen)

    @cached_property
    def work(self) -> float:
        """Energy that the valve puts in in a cycle: its force over the way of the driven end in flight.

        The blows, the damping and the rests take the same; with a supply it is the work of the pump. The constant part
        of the chamber's force is in it: without a rest or a blow that turns the strain over, in which the driven end
        moves in no time, its work is none.
        """
        if self.oil is not None:
            return self.oil.input
        supply, ways = self.valve.supply, [float((f.end - f.begin)[:, 0] @ f.modes.driven) for f in self.flights]
        if supply is None:
            return math.fsum(flight.force * way for flight, way in zip(self.flights, ways, strict=True))
        gas = self.valve.chamber.force * math.fsum(ways) if self.modes else 0.0
        return supply.flow * self.mean_pressure * self.period + gas

    @cached_property
    def mean_pressure(self) -> float:
        """Of the supply, over a cycle; 1 where the pressure is constant."""
        supply, found, bare = self.valve.supply, [], dict(self.valve.pairs)
        if self.oil is not None:
            return self.oil.pressed / self.period
        if supply is None:
            return 1.0
        for one in self.flights:
            t = one.duration
            found.append(one.pressure * t + 0.5 * supply.flow * t * t / supply.compliance)
            if one.ramp != 0.0:
                found.append(-bare[one.state] / supply.compliance * one.way)
        return math.fsum(found) / self.period

    # -- what follows --

    @property
    def blow_times(self) -> Array:
        """When the blows fall, the last one at the period."""
        return np.array([blow.time for blow in self.struck])

    @property
    def blow_speeds(self) -> Array:
        """Speed just before each blow."""
        return np.array([blow.speed for blow in self.struck])

    @property
    def blow_energies(self) -> Array:
        """Kinetic energy just before each blow, that of the ringing with it."""
        return np.array([blow.kinetic for blow in self.struck])

    @property
    def taken(self) -> float:
        """Energy that the blows of a cycle take."""
        return math.fsum(self.contact.energy_taken(blow.kinetic, blow.strain) for blow in self.struck)

    @property
    def level_difference(self) -> float:
        """The greatest force of the valve minus the least."""
        forces = [force for _, force in self.valve.pairs]
        return max(forces) - min(forces)

    def _multipliers(self, side: Side) -> Multipliers:
        return self._of_slope

    @cached_property
    def _of_slope(self) -> Multipliers:
        values = np.linalg.eigvals(self.slope).astype(complex)
        values = values[np.argsort(-np.abs(values), kind="stable")]
        own = self.flights[0].modes
        matrix = CycleMap(self.slope, own.omega, own.end) if self.modes and not self.rests else None
        return Multipliers(self.label, self.modes, values, self.machine, matrix)

    @cached_property
    def contraction(self) -> float:
        """A bound of all multipliers by a power of the map, infinite where that grows; below 1 none need be known."""
        own, unit = self.flights[0].modes.omega, np.ones(len(self.slope))
        if self.modes:
            unit[: 2 * own.size : 2] = np.maximum(own, 1.0 / self.period)
        power = self.slope * unit[:, None] / unit
        for _ in range(_SQUARINGS):
            power = power @ power
            if not np.abs(power).max() < _GROWN:
                return math.inf
        return float(np.linalg.norm(power) ** 0.5**_SQUARINGS)

    @property
    def period(self) -> float:
        """Duration of the cycle."""
        return float(self.blow_times[-1])

    @property
    def blows(self) -> int:
        """Blows in a cycle."""
        return self.blow_times.size

    @property
    def flight_times(self) -> Array:
        """From blow to blow, the first after that at time 0; shape (blows,)."""
        return np.diff(self.blow_times, prepend=0.0)

    @property
    def valve_cycles(self) -> int:
        """How often the valve goes through its states: changes to the state it changes to most often."""
        changes = [switch.to for switch in self.switches]
        return max((changes.count(state) for state in set(changes)), default=0)

    @property
    def label(self) -> str:
        """Blows and valve cycles in a cycle: "1/1"; "chatter/1" or "rest/1" of one that rests."""
        return cycle_label(self.blows, self.valve_cycles, len(self.lying))

    @property
    def resonant_modes(self) -> tuple[int, ...]:
        """None: without a clock no mode comes back by itself."""
        return ()

    @property
    def phases(self) -> Array:
        """When the blows fall in the cycle, in rad of it; the last one at 0."""
        return np.mod(2.0 * math.pi * self.blow_times / self.period, 2.0 * math.pi)

    @property
    def phase(self) -> float:
        """That of the strongest blow."""
        return float(self.phases[np.argmax(self.speeds)])

    @property
    def times(self) -> tuple[float, ...]:
        """`blow_times`, `speeds` are `blow_speeds` and `impacts` are `blows`, as other motions call them."""
        return tuple(self.blow_times.tolist())

    @property
    def speeds(self) -> Array:
        """`blow_speeds`."""
        return self.blow_speeds

    @property
    def impacts(self) -> int:
        """`blows`."""
        return self.blows

    @property
    def periods(self) -> float:
        """The cycle in units of 2π, the period of a load."""
        return self.period / (2.0 * math.pi)

    @property
    def impact_velocity(self) -> float:
        """Greatest of the speeds."""
        return self.blow_speed

    @property
    def rigid_velocity(self) -> float:
        """Velocity of the centre of mass just before the strongest blow."""
        struck = float(self.blow_times[np.argmax(self.speeds)])
        before = [one for one in self.flights if one.time + one.duration <= struck * (1.0 + 1e-12)][-1]
        return float(before.modes.centre @ before.end[:, 1])

    @property
    def delivered_energy(self) -> float:
        """Mean of what the blows take, with what lying down takes."""
        return (self.taken + self.taken_by_rest) / self.blows

    @property
    def energy(self) -> Energy:
        """Over the cycle: put in by the valve, taken by damping and by the blows."""
        from percuss.steady.flight import Energy  # with the forced motion under a clock, which no machine has

        taken = self.taken + self.taken_by_rest
        return Energy(self.work, self.work - taken, taken)

    @property
    def blow_speed(self) -> float:
        """Speed just before the strongest blow."""
        return float(self.blow_speeds.max())

    @property
    def blow_energy(self) -> float:
        """Mean of the energies of the blows."""
        return float(self.blow_energies.mean())

    @property
    def main_energy(self) -> float:
        """Kinetic energy just before the strongest blow."""
        return float(self.blow_energies.max())

    @property
    def drawn(self) -> float:
        """Volume that the valve takes from the supply in a cycle, times the pressure for which its forces hold."""
        if self.oil is not None:
            return self.oil.pumped
        supply = self.valve.supply
        return self.work if supply is None else supply.flow * self.period

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
        return complex(self._judged.values[0])

    @cached_property
    def _parted(self) -> Parted:
        return parted(self.slope, self.modes) if self.modes else Parted(self.multiplier, None)

    @property
    def rhythm_multiplier(self) -> complex | None:
        """The greatest multiplier of the motion as a whole; None where it cannot be told from the ringing."""
        return self._parted.rhythm

    @property
    def ringing(self) -> Ringing | None:
        """What rings longest; None where nothing is left of the ringing after a cycle, and of a rigid piston."""
        return self._parted.ringing

    def motion(self, t: npt.ArrayLike) -> Array:
        """Gap function y(t), the position of the striking end: 0 at blows, negative between; the shape of `t`."""
        return self.position(numbers("t", t))

    def position(self, times: npt.ArrayLike, place: Place = 1.0) -> Array:
        """Displacement of a place of the body, 0 at the wall and negative behind it; the shape of `times`.

        Parameters
        ----------
        times
            Any; the motion is repeated with its period.
        place
            From 0 (driven end) to 1 (striking end), or "centre".
        """
        within, place = np.mod(numbers("times", times), self.period), checked_place(place)
        found, which = np.empty(within.shape), flights_at(self, within)
        for number in np.unique(which).tolist():
            mine, flight = which == number, self.flights[number]
            row = place_row(self.machine, flight.modes, place)
            found[mine] = row @ flight.at(within[mine] - flight.time)[0]
        return found

    def __str__(self) -> str:
        blows = "1 blow" if self.blows == 1 else f"{self.blows} blows"
        return (
            f"ValveCycle: {blows}, speed {self.blow_speed:.6g}, period {self.period:.6g}, "
            f"stroke {self.stroke:.6g}, multiplier {abs(self.multiplier):.4g}, {self.modes} modes"
        )


def cycle_label(blows: int, valve_cycles: int, rests: int) -> str:
    """What a cycle is called, with rests after so many of its blows."""
    if not rests:
        return f"{blows}/{valve_cycles}"
    return f"{'chatter' if blows > rests else 'rest'}/{valve_cycles}"


def flights_at(cycle: ValveCycle, within: Array) -> npt.NDArray[np.intp]:
    """The number of the flight at times of a cycle."""
    begins = np.array([flight.time for flight in cycle.flights])
    return np.maximum(np.searchsorted(begins, within, side="right") - 1, 0)


Happened = tuple[float, str, object, Array, float]
"""An event: its time, "impact", "valve" or "port", the new state or the number of the port, and the state before with
the pressure."""


def cycle_told(
    machine: Machine,
    modes: int,
    state: str,
    orders: Orders,
    flights: tuple[ValveFlight, ...],
    happened: Iterable[Happened],
    slope: Array,
    lying: tuple[int, ...] = (),
    taken_by_rest: float = 0.0,
) -> ValveCycle:
    """The cycle of these flights and events, of a machine with so many elastic modes."""
    valve, now, forces, flows = machine.valve, state, dict(machine.valve.pairs), state_flows(machine, modes)
    struck, changed, passed = [], [], []
    for time, kind, detail, before, pressure in happened:
        own, speed = flows[now].modes, before[:, 1]
        if kind == "impact":
            strain = strain_of(flows[now], before)
            struck.append(MachineBlow(time, float(own.end @ speed), 0.5 * float(speed @ speed), strain))
        elif kind == "valve":
            rise, behind = pressure * (forces[str(detail)] - forces[now]), -float(own.driven @ before[:, 0])
            changed.append(Switch(time, str(detail), behind, -float(own.driven @ speed), rise * behind))
            now = str(detail)
        elif isinstance(detail, int) and (port := valve.ports[detail]).on == "entering":
            passed.append(Uncovering(detail, time, -float(place_row(machine, own, port.reads) @ speed)))
    return ValveCycle(
        machine, modes, state, orders, flights, tuple(struck), tuple(changed), tuple(passed), slope, lying,
        taken_by_rest,
    )  # fmt: skip
