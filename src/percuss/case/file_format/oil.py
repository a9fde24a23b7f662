"""The oil of a table [load]: chambers, passages, pump, relief and accumulator of a case, and what is made of them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Discriminator, Field, Tag

from percuss.case.file_format.values import (
    Area,
    CaseTable,
    Compliance,
    Flow,
    Kind,
    NumberOrDensity,
    PlainNumber,
    Power,
    Stress,
    Volume,
    above_zero,
    list_of,
    number_of,
)
from percuss.errors import ParameterError, did_you_mean
from percuss.model.load.oil import GasAccumulator, Join, Oil, OilChamber, Relief

ATMOSPHERE = 101325.0  # Pa
BULK_MODULUS = 1.4e9  # Pa, of hydraulic oil with the little air that is in it
DENSITY = 870.0  # kg/m³


class OilChamberTable(CaseTable):
    """A chamber of oil beside the piston."""

    area: Area
    """Area on which its pressure acts. Allowed: greater than 0."""
    side: Literal["front", "rear"]
    """Which way its pressure pushes: the rear one toward the wall, the front one away from it."""


class PassageTable(CaseTable):
    """What a flow loses in a passage: by its area, or by a drop of the pressure at a flow."""

    in_plain: ClassVar = {"area": None, "discharge": None}

    area: Area | None = None
    """Area of the orifice. Allowed: greater than 0. When left out: `drop` and `at` are needed."""
    discharge: float | None = None
    """Coefficient of discharge of that area. Allowed: greater than 0. When left out: 0.65, of a sharp edge."""
    drop: Stress | None = None
    """Drop of the pressure at the flow `at`; it grows with the square of the flow. Allowed: 0 or greater."""
    at: Flow | None = None
    """The flow at which that drop is known. Allowed: greater than 0."""


class WaysTable(PassageTable):
    """What a passage to a face of the piston loses, the same for both ways unless said."""

    inward: PassageTable | None = Field(None, alias="in")
    """What it loses for a flow towards the face, if that is something else. When left out: the same."""
    out: PassageTable | None = None
    """The same for a flow away from it. When left out: the same."""


class OrificeTable(WaysTable):
    """A passage between a chamber and supply or tank."""

    chamber: str
    """The chamber, one of `chambers`."""
    to: Literal["supply", "tank"]
    """What it joins the chamber to."""
    state: str | None = None
    """The state in which it is the passage. When left out: in all states that join the chamber so."""


class OilTable(CaseTable):
    """The oil, and the line to the tank."""

    density: NumberOrDensity | None = None
    """Density, for orifices by their area. Allowed: greater than 0. When left out: that of mineral oil, 870 kg/m³."""
    tank: Stress | None = None
    """Pressure of the line to the tank. Allowed: 0 or greater. When left out: none."""


class FlowAtTable(CaseTable):
    """A flow that grows with the pressure, known at one."""

    flow: Flow
    """The flow. Allowed: 0 or greater."""
    at: Stress
    """The pressure at which it is known. Allowed: greater than 0."""


class ReliefTable(CaseTable):
    """A relief valve."""

    opens: Stress
    """The pressure from which on it lets oil through. Allowed: greater than 0."""
    flow: Flow | None = None
    """What it lets through at `over` above that. When left out: as much as comes, the pressure is held."""
    over: Stress | None = None
    """See `flow`. Allowed: greater than 0."""


class GasAccumulatorTable(CaseTable):
    """An accumulator by its gas."""

    precharge: Stress
    """Pressure of the gas without oil. Allowed: greater than 0."""
    volume: Volume
    """Volume of the gas at its precharge. Allowed: greater than 0."""
    exponent: float | None = None
    """Exponent n of the gas. Allowed: 1 or greater. When left out: 1.4, of nitrogen that has no time to exchange
    heat."""
    atmosphere: Stress | None = None
    """Pressure of the atmosphere, which gauge pressures lack. Allowed: 0 or greater. When left out: that at sea
    level, 1.013 bar; none in a dimensionless case."""


def _is_table(value: Any) -> str:
    return "table" if isinstance(value, dict | CaseTable) else "text"


Joins = dict[str, Literal["supply", "tank"]]
Chambers = Annotated[
    dict[str, OilChamberTable],
    Kind("table of tables", lambda value: _some(value, 'chambers, {rear = {area = "10 cm^2", side = "rear"}, …}')),
]
Orifices = Annotated[tuple[OrificeTable, ...], list_of("orifices", '{chamber = "rear", to = "tank", drop = …, at = …}')]
Accumulator = Annotated[
    Annotated[Compliance, Tag("text")] | Annotated[GasAccumulatorTable, Tag("table")], Discriminator(_is_table)
]
ReliefValve = Annotated[Annotated[Stress, Tag("text")] | Annotated[ReliefTable, Tag("table")], Discriminator(_is_table)]


def _some(value: Any, example: str) -> Any:
    if not isinstance(value, dict) or not value:
        raise ValueError(f"a table of {example}")
    return value


class SupplyTable(CaseTable):
    """A pump of steady flow and an accumulator: the pressure of the supply follows the piston."""

    flow: Flow | None = None
    """What the pump gives. Allowed: greater than 0. When left out: the pressure is constant."""
    accumulator: Accumulator | None = None
    """Volume that the accumulator gives up for a fall of the pressure, V/(n p) of its gas, greater than 0; or the gas
    itself, see below. When left out: only a constant pressure has none."""
    start: Stress | None = None
    """The pressure at the start. Allowed: 0 or greater. When left out: `pressure`."""
    quickening: PlainNumber | None = None
    """How much faster the spool of the valve travels under a higher pressure: the delay of an order is divided by 1 +
    `quickening` · (P/`pressure` − 1), P being the pressure when it is given. Allowed: 0 or greater and below 1. When
    left out: 0, all delays are fixed."""
    power: Power | None = None
    """The greatest power of the pump, above which it gives less. Allowed: greater than 0. When left out: no limit."""
    slip: FlowAtTable | None = None
    """What the pump gives less at a pressure, see below. When left out: nothing."""
    leakage: FlowAtTable | None = None
    """What leaks from the supply to the tank at a pressure, see below. When left out: nothing."""
    relief: ReliefValve | None = None
    """The pressure that a relief valve holds, or a table, see below. When left out: there is none."""
    line: Volume | None = None
    """Volume of oil in the line, by which an accumulator with gas is not stiff when it is empty; at 1.4 GPa. In a
    dimensionless case its volume per pressure. Allowed: 0 or greater, beside gas. When left out: none."""


# ---- From these tables to the oil of a valve


def _positive(key: str, given: Any, dimension: str) -> float:
    return above_zero(key, given, dimension)


def _from_zero(key: str, given: Any, dimension: str) -> float:
    value = number_of(key, given, dimension)
    if value < 0.0:
        raise ParameterError(key, given, f"{'an' if dimension[0] in 'aeiou' else 'a'} {dimension}, 0 or greater")
    return value


def passage_of(table: PassageTable, key: str, density: float) -> float | None:
    """ζ = Δp/q² of a passage; None where nothing of it is given."""
    by_area, by_drop = table.area is not None, table.drop is not None or table.at is not None
    if table.discharge is not None and not by_area:
        raise ParameterError(f"{key}.discharge", table.discharge, "nothing without an area", "give the area")
    if by_area and by_drop:
        raise ParameterError(f"{key}.area", table.area, "nothing beside drop and at", "leave out one of the two")
    if by_area:
        area = _positive(f"{key}.area", table.area, "area")
        given = 0.65 if table.discharge is None else table.discharge
        if not given > 0.0:
            raise ParameterError(f"{key}.discharge", given, "a number greater than 0")
        return density / (2.0 * (given * area) ** 2)
    if not by_drop:
        return None
    for name in ("drop", "at"):
        if getattr(table, name) is None:
            raise ParameterError(f"{key}.{name}", None, "both drop and at: a pressure, and the flow that takes it")
    drop, at = _from_zero(f"{key}.drop", table.drop, "pressure"), _positive(f"{key}.at", table.at, "flow")
    return drop / at**2


def ways_of(table: WaysTable, key: str, density: float = DENSITY) -> tuple[float, float]:
    """ζ of the flow towards a face, and away from it."""
    both = passage_of(table, key, density)
    found = []
    for name, own in (("in", table.inward), ("out", table.out)):
        way = None if own is None else passage_of(own, f"{key}.{name}", density)
        if way is None and both is None:
            raise ParameterError(f"{key}.{'area' if not table.is_plain else 'drop'}", None, "an area, or drop and at")
        found.append(both if way is None else way)
    return float(found[0] or 0.0), float(found[1] or 0.0)


def oil_of(load: Any, pressure: float, spool: float, force: float) -> Oil:
    """The oil that a table [load] describes, with forces at the pressure of the supply and flows times it."""
    table: OilTable = load.oil or OilTable()
    density = DENSITY if table.density is None else _positive("oil.density", table.density, "density")
    tank = 0.0 if table.tank is None else _from_zero("oil.tank", table.tank, "pressure")
    chambers, joins = _chambers(load, pressure), dict[str, tuple[Join, ...]]()
    known = {one.name for one in chambers}
    losses = _losses(load, density, known)
    used = set[tuple[str, str, str | None]]()
    for name, state in load.states.items():
        own = []
        for chamber, to in joined(name, state).items():
            if chamber not in known:
                near = did_you_mean(chamber, sorted(known))
                raise ParameterError(f"states.{name}.{chamber}", to, f"a chamber: {', '.join(sorted(known))}", near)
            found = next((at for at in ((chamber, to, name), (chamber, to, None)) if at in losses), None)
            used.update(at for at in ((chamber, to, name), (chamber, to, None)) if at in losses)
            inward, outward = losses[found][1] if found else (0.0, 0.0)
            own.append(Join(chamber, to, inward / pressure**3, outward / pressure**3))
        joins[name] = tuple(own)
    for at, (key, _) in losses.items():
        if at not in used:
            where = f"a state that joins the chamber {at[0]!r} to the {at[1]}"
            raise ParameterError(f"{key}.chamber", at[0], where, "join it in [load.states], or leave the orifice out")
    leakage = 0.0
    if load.supply is not None and load.supply.leakage is not None:
        leakage = slope_of(load.supply.leakage, "supply.leakage") * pressure**2
    return Oil(chambers, joins, tank / pressure, spool, leakage, force)


def joined(name: str, state: Any) -> Mapping[str, Literal["supply", "tank"]]:
    """What a state joins its chambers to; areas are chambers of their own on the supply."""
    if isinstance(state, Mapping):
        return state
    return {f"{side} of {name}": "supply" for side in ("front", "rear") if _side(name, state, side) > 0.0}


def _side(name: str, state: Any, side: str) -> float:
    area = getattr(state, side, None)
    return 0.0 if area is None else number_of(f"states.{name}.{side}", area, "area")


def _chambers(load: Any, pressure: float) -> tuple[OilChamber, ...]:
    found = []
    for name, own in (load.chambers or {}).items():
        found.append(OilChamber(name, _positive(f"chambers.{name}.area", own.area, "area") * pressure, own.side))
    for name, state in load.states.items():
        if not isinstance(state, Mapping):
            for side in ("front", "rear"):
                if (area := _side(name, state, side)) > 0.0:
                    found.append(OilChamber(f"{side} of {name}", area * pressure, side))
    return tuple(found)


_Losses = dict[tuple[str, str, str | None], tuple[str, tuple[float, float]]]


def _losses(load: Any, density: float, known: set[str]) -> _Losses:
    """The orifices by chamber, line and state, with their keys."""
    found: _Losses = {}
    for i, own in enumerate(load.orifices or ()):
        key = f"orifices[{i}]"
        if own.chamber not in known:
            near = did_you_mean(own.chamber, sorted(known))
            raise ParameterError(f"{key}.chamber", own.chamber, f"a chamber: {', '.join(sorted(known))}", near)
        if own.state is not None and own.state not in load.states:
            near = did_you_mean(own.state, load.states)
            raise ParameterError(f"{key}.state", own.state, f"a state: {', '.join(load.states)}", near)
        at = (own.chamber, own.to, own.state)
        if at in found:
            raise ParameterError(key, own.chamber, "one orifice of a chamber to a line", "put two in series into one")
        found[at] = (key, ways_of(own, key, density))
    return found


def slope_of(table: FlowAtTable, key: str) -> float:
    """Flow per pressure."""
    return _from_zero(f"{key}.flow", table.flow, "flow") / _positive(f"{key}.at", table.at, "pressure")


def relief_of(given: Any, pressure: float) -> Relief:
    """The relief valve of a supply, in multiples of a pressure."""
    if not isinstance(given, ReliefTable):
        return Relief(_positive("relief", given, "pressure") / pressure)
    opens = _positive("relief.opens", given.opens, "pressure")
    if (given.flow is None) != (given.over is None):
        missing = "flow" if given.flow is None else "over"
        raise ParameterError(f"relief.{missing}", None, "both flow and over, or neither")
    if given.flow is None:
        return Relief(opens / pressure)
    over = _positive("relief.over", given.over, "pressure")
    return Relief(opens / pressure, _positive("relief.flow", given.flow, "flow") / over * pressure**2)


def gas_of(given: GasAccumulatorTable, pressure: float) -> GasAccumulator:
    """The gas of an accumulator, in multiples of a pressure, and volumes times it."""
    key = "supply.accumulator"
    left_out = 0.0 if given.is_plain else ATMOSPHERE
    air = left_out if given.atmosphere is None else _from_zero(f"{key}.atmosphere", given.atmosphere, "pressure")
    exponent = 1.4 if given.exponent is None else given.exponent
    if exponent < 1.0:
        raise ParameterError(f"{key}.exponent", exponent, "a number from 1 on")
    precharge = _positive(f"{key}.precharge", given.precharge, "pressure")
    volume = _positive(f"{key}.volume", given.volume, "volume")
    return GasAccumulator(precharge / pressure, volume * pressure, exponent, air / pressure)
