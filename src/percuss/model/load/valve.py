"""A load that the piston itself switches: a valve with states, ports, delays, and a gas chamber behind the piston."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any, Literal, cast

from percuss.errors import ParameterError
from percuss.model.checks import choice, instance, non_negative, positive, several, text, unit_interval
from percuss.model.checks import force as checked_force
from percuss.model.load.oil import GasAccumulator, Oil, Relief

# ---- A cushion at the front end of the stroke, which stops a piston that finds no tool


@dataclass(frozen=True)
class Cushion:
    """A cushion beyond the wall, such as oil that the piston traps when it goes forward without the tool.

    At the depth z it pushes a piston that goes in back with `force` + `stiffness` z, and one that comes out with the
    part `returned` of that. It begins at the wall or beyond, so that it takes nothing from a blow on the tool.

    Parameters
    ----------
    beyond
        Distance beyond the wall at which it begins, 0 or greater (dimensionless).
    force
        At its beginning, 0 or greater; dimensionless, as a load is.
    stiffness
        Increase of the force per depth, 0 or greater (dimensionless).
    length
        Depth at which the piston meets the front end of the housing, greater than 0; None for no end.
    returned
        Part of the energy that it gives back, from 0 (oil that is throttled) to 1 (a spring).
    area
        Of the piston's ring that presses on the oil (m²), where its pressure is to be told.

    Examples
    --------
    >>> Cushion(beyond=0.02, force=1.0, stiffness=50.0).energy(0.1)
    0.35
    """

    beyond: float = 0.0
    force: float = 0.0
    stiffness: float = 0.0
    length: float | None = None
    returned: float = 0.0
    area: float | None = None

    def __post_init__(self) -> None:
        set_ = object.__setattr__
        for name in ("beyond", "force", "stiffness"):
            set_(self, name, non_negative(name, getattr(self, name)))
        set_(self, "returned", unit_interval("returned", self.returned))
        for name in ("length", "area"):
            if getattr(self, name) is not None:
                set_(self, name, positive(name, getattr(self, name)))

    def energy(self, depth: float) -> float:
        """What it takes from a piston that goes in to a depth, ∫ (force + stiffness z) dz."""
        depth = non_negative("depth", depth)
        return depth * (self.force + 0.5 * self.stiffness * depth)

    def scaled(self, force: float, length: float) -> Cushion:
        """The same cushion in other units of force and length; the area stays in m²."""
        force, length = positive("force", force), positive("length", length)
        end = None if self.length is None else self.length * length
        more = self.stiffness * force / length
        return Cushion(self.beyond * length, self.force * force, more, end, self.returned, self.area)


# ---- What feeds the valve of a machine: a pump with a steady flow, and an accumulator whose pressure falls and rises


@dataclass(frozen=True)
class Supply:
    """A pump of steady flow, and an accumulator from which the piston draws.

    The pressure π is a multiple of the one for which the forces of the valve's states hold. In the state k the piston
    is pushed by π p_k, and draws p_k u′ while it moves toward the wall with u′ (the area on which the pressure acts
    is the one that displaces oil), so that

        c π′ = q − p_k u′,   energy of the accumulator c π²/2.

    The accumulator is represented by its tangent: for a gas, c belongs to its volume V and exponent n by C = V/(n P).
    With a slip, a limit of the power, a relief valve or an accumulator with `gas` the closed form is lost, and the
    motion is that of oil that flows (`Oil`): (c + that of the gas) π′ = min(q − slip π, power/π) − p_k u′ − …

    Parameters
    ----------
    flow
        q, what the pump gives: the power that its flow has at the pressure 1, Q P (dimensionless, of the unit of mass).
    compliance
        c of the accumulator: the volume that it gives up per pressure, times the square of that pressure, C P².
    start
        The pressure at the start, 0 or greater.
    quickening
        How much faster the spool travels where the pressure is higher, 0 or greater and below 1: the delay of an order
        is divided by 1 + `quickening` (π − 1), π being the pressure when it is given. At 0 all delays are fixed.

    References
    ----------
    H. E. Merritt, Hydraulic Control Systems, Wiley, 1967, on compressibility as the capacity of a chamber.

    Examples
    --------
    >>> Supply.of_oil(flow=2.2e-3, compliance=2.5e-11, pressure=160e5).flow
    35200.0
    """

    flow: float
    compliance: float
    start: float = 1.0
    quickening: float = 0.0
    slip: float = 0.0
    power: float | None = None
    relief: Relief | None = None
    gas: GasAccumulator | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "flow", positive("flow", self.flow))
        checked = positive if self.gas is None else non_negative
        object.__setattr__(self, "compliance", checked("compliance", self.compliance))
        object.__setattr__(self, "slip", non_negative("slip", self.slip))
        if self.power is not None:
            object.__setattr__(self, "power", positive("power", self.power))
        for name, kind in (("relief", Relief), ("gas", GasAccumulator)):
            if getattr(self, name) is not None:
                instance(name, getattr(self, name), kind)
        object.__setattr__(self, "start", non_negative("start", self.start))
        object.__setattr__(self, "quickening", unit_interval("quickening", self.quickening))
        if self.quickening == 1.0:
            raise ParameterError(
                "quickening", self.quickening, "a number from 0 to below 1", "without pressure it waits"
            )

    @classmethod
    def of_oil(
        cls, flow: float, compliance: float, pressure: float, start: float | None = None, quickening: float = 0.0
    ) -> Supply:
        """The supply in SI, for a valve in newtons and metres whose forces hold at a pressure.

        Parameters
        ----------
        flow
            Q of the pump, m³/s.
        compliance
            C of the accumulator, m³/Pa.
        pressure
            For which the forces of the states hold, Pa.
        start
            The pressure at the start, Pa; `pressure` by default.
        quickening
            As of the supply.
        """
        flow, compliance = positive("flow", flow), positive("compliance", compliance)
        pressure = positive("pressure", pressure)
        begins = 1.0 if start is None else non_negative("start", start) / pressure
        return cls(flow * pressure, compliance * pressure**2, begins, quickening)

    def scaled(self, power: float, energy: float) -> Supply:
        """The same supply in other units of power and of energy."""
        flow, compliance = self.flow * positive("power", power), self.compliance * positive("energy", energy)
        limit = None if self.power is None else self.power * power
        relief, gas = self.relief, self.gas
        if relief is not None and relief.slope is not None:
            relief = replace(relief, slope=relief.slope * power)
        gas = None if gas is None else replace(gas, volume=gas.volume * energy)
        return replace(
            self, flow=flow, compliance=compliance, slip=self.slip * power, power=limit, relief=relief, gas=gas
        )

    @property
    def is_linear(self) -> bool:
        """Whether the pressure follows the piston in closed form."""
        return self.slip == 0.0 and self.power is None and self.relief is None and self.gas is None

    def capacity(self, pressure: float) -> float:
        """c of line and accumulator at a pressure."""
        return self.compliance + (0.0 if self.gas is None else self.gas.compliance(pressure))


# ---- A load that the piston itself switches: a valve with states, ports, delays, and a gas chamber behind the piston

MOST_STATES = 64  # the most states a valve may have

MOST_PORTS = 64  # the most ports a valve may have

_LEAST_FORCE = 1e-100  # what a smaller force does takes longer than any number can count


@dataclass(frozen=True)
class Chamber:
    """A gas chamber behind the piston, such as the nitrogen of a breaker, by its force at the wall and its stiffness.

    Its force towards the wall is `force` − `stiffness` u, with u = 0 at the wall and negative behind it, in every state
    of the valve. A polytropic gas is represented by its tangent; with an `exponent` it is itself, see `column`.

    Parameters
    ----------
    force
        Towards the wall, when the driven end is where it is at the blow; dimensionless, as a load is.
    stiffness
        Increase of that force per distance from the wall; dimensionless, 0 or greater. Of a polytropic gas at the wall.
    exponent
        n of a polytropic gas, whose force is `force` (1 + u/h)^(−n), with h the `column`; None for its tangent.

    Examples
    --------
    >>> Chamber(force=0.4, stiffness=0.9)
    Chamber(force=0.4, stiffness=0.9, exponent=None)
    """

    force: float = 0.0
    stiffness: float = 0.0
    exponent: float | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "force", checked_force("force", self.force, _LEAST_FORCE))
        object.__setattr__(self, "stiffness", non_negative("stiffness", self.stiffness))
        if self.exponent is not None:
            object.__setattr__(self, "exponent", positive("exponent", self.exponent))
            if not (self.force > 0.0 and self.stiffness > 0.0):
                raise ParameterError(
                    "exponent", self.exponent, "nothing without a force and a stiffness", "a gas pushes, and yields"
                )

    @property
    def column(self) -> float | None:
        """h, the length of a polytropic gas at the area of the piston: n force/stiffness; None for its tangent."""
        return None if self.exponent is None else self.exponent * self.force / self.stiffness


NO_CHAMBER = Chamber()  # no gas behind the piston


@dataclass(frozen=True)
class Port:
    """What demands a state of the valve: a port that the piston uncovers, or the blow.

    A port demands its state when the bar *enters* its region. Without delay the state changes at once.

    Parameters
    ----------
    behind
        Distance of the edge of its region from the wall, greater than 0 (dimensionless); None with `speed`, and with
        `on="impact"`.
    side
        "back" for the region farther from the wall than the edge, "front" for the region nearer to it; None with
        `on="impact"`. Of a speed: "back" where the bar goes away from the wall faster than that, "front" toward it.
    delay
        From the demand to the change of the state, 0 or greater (dimensionless time).
    reads
        Whose distance from the wall, or speed, it reads: "centre", of the centre of mass, or a place on the bar from 0
        (driven end) to 1 (striking end).
    on
        "impact": every blow demands the state. "entering", the default, is a port.
    speed
        In place of `behind`, greater than 0 (dimensionless): the port reads a speed, and enters its region where this
        one is passed between blows. A velocity that jumps at a blow passes nothing.

    Examples
    --------
    >>> Port("power", behind=1.0, side="back", delay=0.1).on
    'entering'
    >>> Port("return", on="impact").behind is None
    True
    """

    to: str
    behind: float | None = None
    side: Literal["back", "front"] | None = None
    delay: float = 0.0
    reads: Literal["centre"] | float = "centre"
    on: Literal["entering", "impact"] = "entering"
    speed: float | None = None

    def __post_init__(self) -> None:
        set_ = object.__setattr__
        set_(self, "to", text("to", self.to, "the name of a state"))
        set_(self, "delay", non_negative("delay", self.delay))
        choice("on", self.on, "entering", "impact")
        if not isinstance(self.reads, str):
            set_(self, "reads", unit_interval("reads", self.reads))
        elif self.reads != "centre":
            raise ParameterError("reads", self.reads, "'centre' or a place on the bar from 0 to 1")
        if self.on == "impact":
            for name, value, left_out in (
                ("behind", self.behind, None),
                ("speed", self.speed, None),
                ("side", self.side, None),
                ("reads", self.reads, "centre"),
            ):
                if value != left_out:
                    raise ParameterError(name, value, "nothing beside on='impact'", "leave out one of the two")
            return
        edge = self.edge
        if getattr(self, edge) is None or self.side is None:
            missing = edge if self.side is not None else "side"
            raise ParameterError(
                missing, None, "both behind and side of a port", "give both, or on='impact' for a demand at each blow"
            )
        if edge == "speed" and self.behind is not None:
            raise ParameterError("speed", self.speed, "nothing beside behind", "leave out one of the two")
        set_(self, edge, positive(edge, getattr(self, edge)))
        choice("side", self.side, "back", "front")

    @property
    def edge(self) -> Literal["behind", "speed"]:
        """The name of the number that says where its edge is."""
        return "behind" if self.speed is None else "speed"

    @property
    def sign(self) -> float:
        """1 where its region is above the level, −1 where it is below, 0 of the blow."""
        return {"front": 1.0, "back": -1.0, None: 0.0}[self.side]

    @property
    def level(self) -> float:
        """What it reads at its edge, a displacement or a velocity, positive toward the wall; 0 of the blow."""
        return -self.behind if self.behind is not None else self.sign * (self.speed or 0.0)


@dataclass(frozen=True)
class Valve:
    """A load that the piston switches: the force is constant in each state, and ports demand the states.

    On the driven end acts p_k − κ u, with p_k the force of the state k plus that of the chamber, and κ the stiffness of
    the chamber; forces are positive towards the wall.

    - A port demands its state when the bar enters its region; an `on="impact"` port demands it just after each blow. At
      the start, the ports whose region is occupied demand at once, in their order.
    - A demand equal to the last one is ignored. Any other drops the orders that would be due when it is due or later,
      and is carried out after its delay.
    - Of simultaneous events the blow comes first, then the ports in their order, then the orders that are due.
    - With a `supply` the forces of the states are those at the pressure 1, and are multiplied by the pressure, which
      falls while the piston draws; see `Supply`, by which the delays may follow it, too.

    Parameters
    ----------
    states
        The force of each state by its name, in order, without that of the chamber (dimensionless, as a load is). Kept
        as pairs.
    start
        The state at the start, which counts as the last one demanded; the first of `states` by default.
    chamber
        A gas chamber behind the piston.
    cushion
        What stops the piston when it finds no tool; None where it is not known.
    supply
        A pump and an accumulator; by default the pressure is constant.
    oil
        What the oil loses on its way; None for oil that loses nothing. The forces of the states are those of the
        chambers that they join to the supply.

    Examples
    --------
    >>> ports = [Port("power", behind=1.0, side="back"), Port("return", on="impact")]
    >>> valve = Valve({"return": -0.4, "power": 1.8}, ports)
    >>> valve.start, valve.force("power")
    ('return', 1.8)
    """

    states: Mapping[str, float] | tuple[tuple[str, float], ...]
    ports: tuple[Port, ...]
    start: str | None = None
    chamber: Chamber = NO_CHAMBER
    cushion: Cushion | None = None
    supply: Supply | None = None
    oil: Oil | None = None

    def __post_init__(self) -> None:
        set_ = object.__setattr__
        set_(self, "states", _pairs(self.states))
        names = [name for name, _ in self.pairs]
        ports = several("ports", self.ports, "objects of the class Port")
        if not 1 <= len(ports) <= MOST_PORTS:
            raise ParameterError("ports", len(ports), f"1 to {MOST_PORTS} ports", "without one nothing ever switches")
        for i, port in enumerate(ports):
            instance(f"ports[{i}]", port, Port)
            if port.to not in names:
                raise ParameterError(f"ports[{i}].to", port.to, _one_of(names), "demand one of the states")
        set_(self, "ports", ports)
        start = names[0] if self.start is None else self.start
        if not isinstance(start, str) or start not in names:
            raise ParameterError("start", start, _one_of(names))
        set_(self, "start", start)
        instance("chamber", self.chamber, Chamber)
        if self.cushion is not None:
            instance("cushion", self.cushion, Cushion)
        if self.supply is not None:
            instance("supply", self.supply, Supply)
        if self.oil is not None:
            instance("oil", self.oil, Oil)
            for name, force in self.pairs:
                pushed = self.oil.areas(name, "supply")
                if abs(pushed - force) > 1e-9 * max(abs(force), *(one.area for one in self.oil.chambers)):
                    wanted = f"{pushed:.6g}, that of the chambers joined to the supply"
                    raise ParameterError(f"states[{name!r:.40}]", force, wanted)

    @property
    def flows(self) -> bool:
        """Whether its oil is more than a closed form takes: losses, a gas that is polytropic, a pump that slips."""
        lossless = self.oil is None or self.oil.is_lossless
        linear = self.supply is None or self.supply.is_linear
        return not (lossless and linear and self.chamber.exponent is None)

    @property
    def pairs(self) -> tuple[tuple[str, float], ...]:
        """The states and their forces, without that of the chamber."""
        assert isinstance(self.states, tuple)
        return self.states

    def force(self, state: str) -> float:
        """The force towards the wall in a state, with that of the chamber at the wall."""
        for name, force in self.pairs:
            if name == state:
                return force + self.chamber.force
        raise ParameterError("state", state, _one_of([name for name, _ in self.pairs]))

    @property
    def time_unit(self) -> float:
        """A power of two near the time in which the greatest force drives the bar from the wall to the farthest port.

        Where ports have no place it is near the time to the greatest speed that they read, or the longest delay. What
        is taken for simultaneous, or for the end of chatter, is measured by it.
        """
        way = max((port.behind for port in self.ports if port.behind is not None), default=0.0)
        speed = max((port.speed for port in self.ports if port.speed is not None), default=0.0)
        push = max(abs(self.force(name)) for name, _ in self.pairs)
        if way > 0.0 and push > 0.0:
            exponent = 0.5 * (math.log2(way) - math.log2(push))
        elif speed > 0.0 and push > 0.0:
            exponent = math.log2(speed) - math.log2(push)
        else:
            exponent = math.log2(max(port.delay for port in self.ports) or 1.0)
        return 2.0 ** min(max(round(exponent), -300), 300)

    def scaled(self, force: float, length: float, time: float = 1.0) -> Valve:
        """The same valve in other units: forces, distances and delays multiplied by these numbers."""
        force, length, time = positive("force", force), positive("length", length), positive("time", time)
        factors = {"behind": length, "speed": length / time, "delay": time}
        ports = tuple(
            replace(port, **{key: getattr(port, key) and getattr(port, key) * by for key, by in factors.items()})
            for port in self.ports
        )
        gas = self.chamber
        chamber = Chamber(gas.force * force, gas.stiffness * force / length, gas.exponent)
        cushion = None if self.cushion is None else self.cushion.scaled(force, length)
        supply = None if self.supply is None else self.supply.scaled(force * length / time, force * length)
        oil = None if self.oil is None else self.oil.scaled(force, length, time)
        by_oil = set() if oil is None else {name for name, own in oil.pairs if own}
        states = {
            name: oil.areas(name, "supply") if oil is not None and name in by_oil else value * force
            for name, value in self.pairs
        }
        return Valve(states, ports, self.start, chamber, cushion, supply, oil)

    def at_pressure(self, pressure: float) -> Valve:
        """The valve under a constant pressure, a multiple of that for which the forces of the states hold."""
        factor = positive("pressure", pressure)
        ports = tuple(port_at(self, i, factor) for i in range(len(self.ports)))
        states = {name: factor * force for name, force in self.pairs}
        oil = None if self.oil is None else self.oil.at_pressure(factor)
        return replace(self, states=states, ports=ports, supply=None, oil=oil)

    @property
    def delays_vary(self) -> bool:
        """Whether they follow the pressure of the supply."""
        return self.supply is not None and self.supply.quickening > 0.0

    @property
    def orders(self) -> Orders:
        """The orders at the start: none, and the starting state as the last demand."""
        assert self.start is not None
        return Orders(self.start)


def port_at(valve: Valve, number: int, pressure: float) -> Port:
    """A port with the delay of an order that it gives at a pressure."""
    port, supply = valve.ports[number], valve.supply
    if supply is None or supply.quickening == 0.0:
        return port
    pace = 1.0 + supply.quickening * (pressure - 1.0)
    if not pace > 0.0:
        raise ParameterError("pressure", pressure, "a pressure at which the spool travels")
    return replace(port, delay=port.delay / pace)


@dataclass(frozen=True)
class Orders:
    """The state demanded last, and time and state of each order that waits, in the order they are due."""

    last: str
    pending: tuple[tuple[float, str], ...] = ()

    def after(self, time: float, port: Port) -> Orders:
        """The orders after a demand: a later demand replaces what would be carried out after it."""
        if port.to == self.last:
            return self
        due = time + port.delay
        return Orders(port.to, (*(order for order in self.pending if order[0] < due), (due, port.to)))


def _pairs(states: object) -> tuple[tuple[str, float], ...]:
    accepted = "the force of each state by its name"
    if isinstance(states, Mapping):
        states = states.items()
    try:
        found = [tuple(pair) for pair in several("states", cast("Iterable[Any]", states), accepted)]
    except TypeError:
        found = [()]
    if any(len(pair) != 2 for pair in found):
        raise ParameterError("states", states, accepted)
    if not 1 <= len(found) <= MOST_STATES:
        raise ParameterError("states", len(found), f"1 to {MOST_STATES} states")
    names = [text("states", name, "names of states as keys") for name, _ in found]
    if len(set(names)) < len(names):
        raise ParameterError("states", names, "states of different names")
    return tuple((name, checked_force(f"states[{name!r:.40}]", value, _LEAST_FORCE)) for name, value in found)


def _one_of(names: list[str]) -> str:
    return f"one of {', '.join(map(repr, names[:6]))}{', …' if len(names) > 6 else ''}"
