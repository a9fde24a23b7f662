"""Oil that flows: what chambers, passages, relief valve, pump and accumulator take and hold."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, Literal

from percuss.errors import ParameterError
from percuss.model.checks import choice, finite, instance, non_negative, positive, several, text

Towards = Literal["supply", "tank"]


@dataclass(frozen=True)
class OilChamber:
    """A chamber of oil beside the piston.

    Parameters
    ----------
    area
        On which its pressure acts, greater than 0: the force at the pressure 1 (dimensionless, as a load is).
    side
        "rear": it pushes toward the wall; "front": away from it.
    """

    name: str
    area: float
    side: Literal["front", "rear"]

    def __post_init__(self) -> None:
        object.__setattr__(self, "name", text("name", self.name, "the name of a chamber"))
        object.__setattr__(self, "area", positive("area", self.area))
        choice("side", self.side, "front", "rear")

    @property
    def sign(self) -> float:
        """1 at the rear, −1 at the front."""
        return 1.0 if self.side == "rear" else -1.0


@dataclass(frozen=True)
class Join:
    """What joins a chamber in a state of the valve: to supply or tank, by an orifice that takes ζ q|q|.

    `inward` and `outward` are ζ of the flow into and out of the chamber, 0 or greater, pressure per flow squared
    (dimensionless, with flow times pressure as unit of the flow).
    """

    chamber: str
    to: Towards
    inward: float = 0.0
    outward: float = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "chamber", text("chamber", self.chamber, "the name of a chamber"))
        choice("to", self.to, "supply", "tank")
        for name in ("inward", "outward"):
            object.__setattr__(self, name, non_negative(name, getattr(self, name)))


@dataclass(frozen=True)
class Relief:
    """A relief valve: from `pressure` on it lets through `slope` times what is beyond; None for as much as comes."""

    pressure: float
    slope: float | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "pressure", positive("pressure", self.pressure))
        if self.slope is not None:
            object.__setattr__(self, "slope", positive("slope", self.slope))


@dataclass(frozen=True)
class GasAccumulator:
    """A volume V = V_0 ((P_0 + p_a)/(P + p_a))^(1/n) of gas at P; empty of oil at and below its precharge P_0.

    Parameters
    ----------
    precharge, volume
        P_0, a multiple of the pressure for which the states hold, and V_0, times that pressure (an energy).
    exponent
        n, 1 or greater.
    atmosphere
        p_a, by which the gauge pressures are less than absolute ones.
    """

    precharge: float
    volume: float
    exponent: float = 1.4
    atmosphere: float = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "precharge", positive("precharge", self.precharge))
        object.__setattr__(self, "volume", positive("volume", self.volume))
        exponent = finite("exponent", self.exponent, "a number from 1 on")
        if exponent < 1.0:
            raise ParameterError(
                "exponent", self.exponent, "a number from 1 on", "1.4 is that of nitrogen, 1 isothermal"
            )
        object.__setattr__(self, "exponent", exponent)
        object.__setattr__(self, "atmosphere", non_negative("atmosphere", self.atmosphere))

    def compliance(self, pressure: float) -> float:
        """V/(n (P + p_a)) at a pressure; 0 where it is empty."""
        if pressure <= self.precharge:
            return 0.0
        absolute = pressure + self.atmosphere
        ratio = (self.precharge + self.atmosphere) / absolute
        return float(self.volume * ratio ** (1.0 / self.exponent) / (self.exponent * absolute))


def _pairs(given: Any) -> list[tuple[Any, Any]]:
    """The states with what they join."""
    accepted = "the joins of each state by its name"
    pairs = [
        several("joins", pair, accepted)
        for pair in several("joins", given.items() if isinstance(given, Mapping) else given, accepted)
    ]
    if any(len(pair) != 2 for pair in pairs):
        raise ParameterError("joins", given, accepted)
    return [(name, own) for name, own in pairs]


@dataclass(frozen=True)
class Oil:
    """The oil between valve and piston, with what it loses on its way.

    Chamber i has the pressure p = P − ζ q|q| of the line that it is joined to, less what its orifice takes of the flow
    q into it, and pushes the piston with ±area·p. So the orifices of a state brake with b v|v|, b = Σ area³ ζ.

    Parameters
    ----------
    chambers
        Each an `OilChamber`.
    joins
        Of each state of the valve a `Join` for each of its chambers; one that has none is shut off without pressure.
    tank
        Pressure of the line to the tank, 0 or greater, a multiple of the pressure for which the states hold.
    spool
        Time in which the spool goes from one state to the next, 0 for none: pressures and orifices follow it linearly.
    leakage
        Flow per pressure from supply to tank, 0 or greater.
    force
        A constant force toward the wall, such as the weight.

    Examples
    --------
    >>> chambers = [OilChamber("rear", 2.2, "rear"), OilChamber("front", 0.4, "front")]
    >>> joins = {"return": [Join("rear", "tank"), Join("front", "supply")],
    ...          "power": [Join("rear", "supply", 0.03, 0.03), Join("front", "supply")]}
    >>> tuple(round(one, 9) for one in Oil(chambers, joins).drag("power"))
    (0.31944, 0.31944)
    """

    chambers: tuple[OilChamber, ...]
    joins: Mapping[str, tuple[Join, ...]] | tuple[tuple[str, tuple[Join, ...]], ...]
    tank: float = 0.0
    spool: float = 0.0
    leakage: float = 0.0
    force: float = 0.0

    def __post_init__(self) -> None:
        chambers = several("chambers", self.chambers, "objects of the class OilChamber")
        for i, chamber in enumerate(chambers):
            instance(f"chambers[{i}]", chamber, OilChamber)
        object.__setattr__(self, "chambers", chambers)
        joins = tuple(
            (text("joins", name, "names of states"), several("joins", own, "objects of the class Join"))
            for name, own in _pairs(self.joins)
        )
        known, used = {chamber.name for chamber in chambers}, set()
        for name, own in joins:
            for one in own:
                instance(f"joins.{name}", one, Join)
                if one.chamber not in known:
                    raise ParameterError(f"joins.{name}", one.chamber, f"a chamber: {', '.join(sorted(known))}")
                used.add(one.chamber)
            if len({one.chamber for one in own}) < len(own):
                raise ParameterError(f"joins.{name}", name, "one join of a chamber", "a chamber has one line at a time")
        object.__setattr__(self, "joins", joins)
        for key in ("tank", "spool", "leakage"):
            object.__setattr__(self, key, non_negative(key, getattr(self, key)))
        object.__setattr__(self, "force", finite("force", self.force, "a force"))

    @property
    def pairs(self) -> tuple[tuple[str, tuple[Join, ...]], ...]:
        """The states with their joins."""
        assert isinstance(self.joins, tuple)
        return self.joins

    def joined(self, state: str) -> tuple[Join, ...]:
        """The joins of a state."""
        return dict(self.pairs).get(state, ())

    def areas(self, state: str, to: Towards) -> float:
        """Σ ± area of the chambers that a state joins to supply or tank."""
        areas = {one.name: one.sign * one.area for one in self.chambers}
        return sum(areas[one.chamber] for one in self.joined(state) if one.to == to)

    def losses(self, state: str) -> dict[str, tuple[float, float]]:
        """area³ ζ of each chamber that a state joins, where the piston goes toward the wall, and away from it."""
        found, by_name = {}, {one.name: one for one in self.chambers}
        for one in self.joined(state):
            chamber = by_name[one.chamber]
            ways = (one.inward, one.outward) if chamber.side == "rear" else (one.outward, one.inward)
            found[one.chamber] = (chamber.area**3 * ways[0], chamber.area**3 * ways[1])
        return found

    def drag(self, state: str) -> tuple[float, float]:
        """b of a state, toward the wall and away from it: the orifices brake with b v|v| (`docs/oil.md`, section 1)."""
        own = self.losses(state).values()
        return sum(one for one, _ in own), sum(back for _, back in own)

    @property
    def is_lossless(self) -> bool:
        """Whether it takes nothing, so that the closed forms of a machine hold."""
        free = not any(one.inward or one.outward for _, own in self.pairs for one in own)
        tank = self.tank * max((abs(self.areas(name, "tank")) for name, _ in self.pairs), default=0.0)
        return free and not (tank or self.spool or self.leakage or self.force)

    def scaled(self, force: float, length: float, time: float = 1.0) -> Oil:
        """The same oil in other units of force, length and time."""
        power = force * length / time
        chambers = tuple(replace(one, area=one.area * force) for one in self.chambers)
        joins = {
            name: tuple(
                replace(one, inward=one.inward / power**2, outward=one.outward / power**2) for one in own
            )
            for name, own in self.pairs
        }  # fmt: skip
        return replace(
            self, chambers=chambers, joins=joins, spool=self.spool * time, leakage=self.leakage * power,
            force=self.force * force,
        )  # fmt: skip

    def at_pressure(self, factor: float) -> Oil:
        """The same oil with a multiple of the pressure as the unit of pressure."""
        chambers = tuple(replace(one, area=one.area * factor) for one in self.chambers)
        joins = {
            name: tuple(
                replace(one, inward=one.inward / factor**3, outward=one.outward / factor**3) for one in own
            )
            for name, own in self.pairs
        }  # fmt: skip
        return replace(self, chambers=chambers, joins=joins, tank=self.tank / factor, leakage=self.leakage * factor**2)
