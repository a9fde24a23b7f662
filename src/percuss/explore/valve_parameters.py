"""The parameters of machines that switch their own valve: every number that maps may vary."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import lru_cache
from typing import Any, cast

from percuss.errors import ParameterError
from percuss.explore.parameters import BODY_PARAMETERS, PARAMETERS
from percuss.model import Chamber, Machine, Supply
from percuss.model.checks import finite, instance, mapping
from percuss.model.parameter import Parameter

__all__ = ["PRESSURE", "machine_parameters", "vary_machine"]

PRESSURE = "pressure"
"""The parameter of all forces of the valve at once."""

_BODY, _VALVE, _PRESSURE = range(3)
"""Turns: a new body has no scales to SI any more, the pressure multiplies the forces as they then are."""


def machine_parameters(machine: Machine) -> dict[str, Parameter[Machine]]:
    """The dimensionless parameters of a machine, by name.

    ``pressure``, a factor on the forces of all states, or with a supply ``supply.flow`` and ``supply.compliance``;
    ``states.NAME``, the force of one; ``chamber.force`` and
    ``chamber.stiffness``; ``ports[i].behind`` and ``ports[i].delay``, counted from 0; ``restitution``; and the numbers
    of the body and its damping, such as ``s`` and ``d``.

    Examples
    --------
    >>> from percuss.model import Kept, Port, UniformBar, Valve
    >>> ports = [Port("power", behind=1.0, side="back"), Port("return", on="impact")]
    >>> machine = Machine(UniformBar(20.0), Valve({"return": -0.4, "power": 1.8}, ports), Kept(0.2))
    >>> [name for name in machine_parameters(machine) if name.startswith("ports")]
    ['ports[0].behind', 'ports[0].delay', 'ports[1].delay']
    """
    instance("machine", machine, Machine)
    entered = tuple(port.behind is not None for port in machine.valve.ports)
    return _table(tuple(name for name, _ in machine.valve.pairs), entered, machine.valve.supply is not None)


def vary_machine(machine: Machine, values: Mapping[str, float]) -> Machine:
    """A machine with other dimensionless parameters, whatever the order in which they are named.

    Raises
    ------
    ParameterError
        For a parameter that is unknown, out of range, or that the machine does not have.

    Examples
    --------
    >>> from percuss.model import Kept, Port, UniformBar, Valve
    >>> ports = [Port("power", behind=1.0, side="back"), Port("return", on="impact")]
    >>> machine = Machine(UniformBar(20.0), Valve({"return": -0.4, "power": 1.8}, ports), Kept(0.2))
    >>> vary_machine(machine, {"pressure": 2.0, "ports[0].behind": 0.5}).valve.force("power")
    3.6
    """
    known = machine_parameters(machine)
    unknown = mapping("values", values, "values of parameters by name, such as {'pressure': 1.2}").keys() - known.keys()
    if unknown:
        raise ParameterError("parameter", sorted(unknown)[0], f"one of {', '.join(known)}")
    for parameter in sorted((known[name] for name in values), key=lambda parameter: parameter.turn):
        machine = parameter.put(machine, finite(parameter.name, values[parameter.name]))
    return machine


@lru_cache(maxsize=32)
def _table(states: tuple[str, ...], entered: tuple[bool, ...], fed: bool) -> dict[str, Parameter[Machine]]:
    of_systems: Parameter[Any] = PARAMETERS["restitution"]
    restitution = replace(
        of_systems, get=lambda machine: machine.contact.restitution, put=_with_restitution, turn=_VALVE
    )
    found: list[Parameter[Any]] = [
        Parameter(
            PRESSURE, "pressure, as a multiple", "a factor on the forces of all states", lambda _: 1.0, _under,
            span=(0.5, 1.5), sets="load.scale", turn=_PRESSURE,
        ),
        *([_of_supply("flow", "flow of the pump"), _of_supply("compliance", "accumulator")] if fed else []),
        *(_of_state(name) for name in states),
        _of_chamber("force", "force of the chamber", "force of the gas chamber with the bar at the wall"),
        _of_chamber("stiffness", "stiffness of the chamber", "how much that force grows with the distance behind it"),
        *(_of_port(i, "behind", "place of port") for i, is_port in enumerate(entered) if is_port),
        *(_of_port(i, "delay", "delay of port") for i in range(len(entered))),
        restitution,
        *(replace(parameter, turn=_BODY) for parameter in BODY_PARAMETERS.values()),
    ]  # fmt: skip
    return {parameter.name: parameter for parameter in found if not (fed and parameter.name == PRESSURE)}


def _with_restitution(machine: Machine, value: float) -> Machine:
    return replace(machine, contact=machine.contact.with_restitution(value))


def _under(machine: Machine, factor: float) -> Machine:
    if not factor > 0.0:
        raise ParameterError(PRESSURE, factor, "a factor greater than 0")
    states = tuple((name, factor * force) for name, force in machine.valve.pairs)
    pressure = None if machine.pressure is None else factor * machine.pressure
    return replace(machine, valve=replace(machine.valve, states=states), pressure=pressure)


def _of_state(state: str) -> Parameter[Machine]:
    def get(machine: Machine) -> float:
        return dict(machine.valve.pairs)[state]

    def put(machine: Machine, force: float) -> Machine:
        states = tuple((name, force if name == state else own) for name, own in machine.valve.pairs)
        return machine.with_valve(replace(machine.valve, states=states))

    label = f"force, {state}"
    return Parameter(f"states.{state}", label, "force of the state without that of the chamber", get, put, turn=_VALVE)


def _of_supply(field: str, label: str) -> Parameter[Machine]:
    def get(machine: Machine) -> float | None:
        supply = machine.valve.supply
        return None if supply is None else float(getattr(supply, field))

    def put(machine: Machine, value: float) -> Machine:
        changed: dict[str, Any] = {field: value}
        supply: Supply = replace(cast("Supply", machine.valve.supply), **changed)
        return machine.with_valve(replace(machine.valve, supply=supply))

    meaning = {"flow": "power of the pump at the pressure 1", "compliance": "twice the energy stored at the pressure 1"}
    return Parameter(f"supply.{field}", label, meaning[field], get, put, turn=_VALVE)


def _of_chamber(field: str, label: str, meaning: str) -> Parameter[Machine]:
    def get(machine: Machine) -> float:
        return float(getattr(machine.valve.chamber, field))

    def put(machine: Machine, value: float) -> Machine:
        chamber: Chamber = replace(machine.valve.chamber, **{field: value})
        return machine.with_valve(replace(machine.valve, chamber=chamber))

    return Parameter(f"chamber.{field}", label, meaning, get, put, turn=_VALVE)


def _of_port(number: int, field: str, label: str) -> Parameter[Machine]:
    def get(machine: Machine) -> float | None:
        value: float | None = getattr(machine.valve.ports[number], field)
        return value

    def put(machine: Machine, value: float) -> Machine:
        ports = list(machine.valve.ports)
        changed: dict[str, Any] = {field: value}
        ports[number] = replace(ports[number], **changed)
        return machine.with_valve(replace(machine.valve, ports=tuple(ports)))

    meaning = {"behind": "distance behind the wall", "delay": "from the demand to the change of the state"}[field]
    return Parameter(f"ports[{number}].{field}", f"{label} {number}", meaning, get, put, turn=_VALVE)
