"""From the table [load] of a machine that switches itself to its valve."""

from __future__ import annotations

from typing import Any

from percuss.case.file_format.valve_tables import (
    AreasTable,
    ChamberTable,
    CushionTable,
    PlainChamber,
    PlainCushion,
    PlainPort,
    PlainSupply,
    PortTable,
    SupplyTable,
    ValveForce,
    ValveLoad,
)
from percuss.errors import ParameterError
from percuss.model import Chamber, Cushion, Port, Supply, Valve
from percuss.model.checks import non_negative, positive
from percuss.units import si

__all__ = ["pressure_of", "room_of", "valve_of"]

_PRESSURE = "give pressure, that of the supply, or the forces of the states"


def valve_of(table: ValveForce | ValveLoad) -> Valve:
    """The valve that a table describes: in N, m and s, or dimensionless; what else the table says is checked, too.

    Raises
    ------
    ParameterError
        By the key of the table.
    """
    pressure = pressure_of(table)
    room = room_of(table)
    states = {name: _force(name, given, pressure) for name, given in table.states.items()}
    given: tuple[PortTable | PlainPort, ...] = table.ports
    ports = tuple(_port(f"ports[{i}].", port) for i, port in enumerate(given))
    for i, (port, own) in enumerate(zip(ports, given, strict=True)):
        if port.behind is not None and room is not None and port.behind >= room:
            accepted = f"a port within the room, {table.room}"
            raise ParameterError(f"ports[{i}].behind", own.behind, accepted, "the piston cannot reach it")
    try:
        chamber, cushion = _chamber(table.chamber), _cushion(table.cushion)
        return Valve(states, ports, table.start_state, chamber, cushion, _supply(table, pressure))
    except ParameterError as error:
        name = {"start": "start_state"}.get(error.name, error.name).replace("']", "").replace("['", ".")
        raise ParameterError(name, error.value, error.accepted, _near(error, table)) from None


def pressure_of(table: ValveForce | ValveLoad) -> float | None:
    """The pressure of the supply in Pa, or None."""
    given = table.pressure if isinstance(table, ValveForce) else None
    return None if given is None else _above_zero("pressure", given, "pressure")


def room_of(table: ValveForce | ValveLoad) -> float | None:
    """How far behind the wall the piston can go: in m, or dimensionless; None without a limit."""
    return None if table.room is None else _above_zero("room", table.room, "length")


def _near(error: ParameterError, table: ValveForce | ValveLoad) -> str:
    """The state that was probably meant, else the remedy as it is."""
    from percuss.case.file_format.suggest import did_you_mean

    if error.name.endswith(".to") or error.name == "start":
        return did_you_mean(error.value, table.states) or error.remedy
    return error.remedy


def _force(name: str, given: Any, pressure: float | None) -> float:
    key = f"states.{name}"
    if not isinstance(given, AreasTable):
        return _value(key, given, "force")
    if pressure is None:
        raise ParameterError(key, None, "a force, as there is no pressure for the areas", _PRESSURE)
    areas = {side: _area(f"{key}.{side}", getattr(given, side)) for side in ("front", "rear")}
    return pressure * (areas["rear"] - areas["front"])


def _area(key: str, given: str | None) -> float:
    if given is None:
        return 0.0
    try:
        return non_negative(key, si(given, "area", key))
    except ParameterError:
        raise ParameterError(key, given, "an area, 0 or greater") from None


def _port(key: str, table: PortTable | PlainPort) -> Port:
    given: dict[str, Any] = {"to": table.to}
    if table.behind is not None:
        given["behind"] = _above_zero(f"{key}behind", table.behind, "length", _BEHIND)
    if table.delay is not None:
        given["delay"] = _value(f"{key}delay", table.delay, "time")
    given |= {name: value for name in ("side", "reads", "on") if (value := getattr(table, name)) is not None}
    try:
        return Port(**given)
    except ParameterError as error:
        raise ParameterError(key + error.name, error.value, error.accepted, error.remedy) from None


_BEHIND = "the wall is at 0, and the distance is counted away from it"


def _chamber(table: ChamberTable | PlainChamber | None) -> Chamber:
    if table is None:
        return Chamber()
    try:
        return Chamber(
            0.0 if table.force is None else _value("force", table.force, "force"),
            0.0 if table.stiffness is None else _value("stiffness", table.stiffness, "stiffness"),
        )
    except ParameterError as error:
        raise ParameterError(f"chamber.{error.name}", error.value, error.accepted, error.remedy) from None


_CUSHION = {"beyond": "length", "force": "force", "stiffness": "stiffness", "length": "length", "area": "area"}


def _cushion(table: CushionTable | PlainCushion | None) -> Cushion | None:
    if table is None:
        return None
    given = {name: value for name in type(table).model_fields if (value := getattr(table, name)) is not None}
    try:
        return Cushion(
            **{
                name: value if name == "returned" else _value(f"cushion.{name}", value, _CUSHION[name])
                for name, value in given.items()
            }
        )
    except ParameterError as error:
        remedy = error.remedy
        if error.name == "beyond":
            remedy = "one that began behind the wall would take part of every blow, which is not in the model"
        raise ParameterError(f"cushion.{error.name}", given[error.name], error.accepted, remedy) from None


def _supply(table: ValveForce | ValveLoad, pressure: float | None) -> Supply | None:
    given: SupplyTable | PlainSupply | None = table.supply
    if given is None:
        return None
    flow = _above_zero("supply.flow", given.flow, "flow")
    accumulator = _above_zero("supply.accumulator", given.accumulator, "compliance")
    start = None if given.start is None else _value("supply.start", given.start, "pressure")
    if start is not None and start < 0.0:
        raise ParameterError("supply.start", given.start, "a pressure, 0 or greater")
    if isinstance(table, ValveLoad):
        return Supply(flow, accumulator, 1.0 if start is None else start)
    for name, state in table.states.items():
        if not isinstance(state, AreasTable):
            remedy = "a piston displaces oil by the areas on which its pressure acts"
            raise ParameterError(f"states.{name}", state, "areas, {front = …, rear = …}, beside a supply", remedy)
    if pressure is None:
        raise ParameterError("pressure", None, "the pressure for which the states hold, beside a supply", _PRESSURE)
    return Supply.of_oil(flow, accumulator, pressure, start)


def _value(key: str, given: float | str, dimension: str) -> float:
    """The number, in base units where it has one."""
    return si(given, dimension, key) if isinstance(given, str) else float(given)


def _above_zero(key: str, given: float | str, dimension: str, remedy: str = "") -> float:
    try:
        return positive(key, _value(key, given, dimension))
    except ParameterError as error:
        raise ParameterError(key, given, f"a {dimension} greater than 0", remedy or error.remedy) from None
