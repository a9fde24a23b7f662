"""The keys of a valve: which a case may be varied by, and what they are in the scales of its machine."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import TYPE_CHECKING

from percuss.case.file_format.valve_tables import PlainPort, PortTable, ValveForce, ValveLoad
from percuss.errors import ParameterError
from percuss.explore.valve_parameters import PRESSURE
from percuss.units import si

if TYPE_CHECKING:
    from percuss.case.case import Case
    from percuss.model import Machine

__all__ = ["LOAD_PRESSURE", "is_of_machine", "of_machine", "valve_keys", "valve_label"]

LOAD_PRESSURE = "load.pressure"

_SCALE = "load.scale"
_NAME = re.compile(r"[^\W\d][\w-]*")  # a state whose name can stand in a dotted key
_OF_MACHINE = re.compile(
    r"load\.(?:scale|pressure|chamber\.(?:force|stiffness)|ports\[\d+\]\.(?:behind|delay)|states\.[^.]+)"
)
_DIMENSIONS = {"behind": "length", "delay": "time", "stiffness": "stiffness", "force": "force"}


def valve_keys(table: ValveForce | ValveLoad) -> list[str]:
    """The dotted keys of a valve that hold one number, or may; a state by areas has one for each of them."""
    given_pressure = isinstance(table, ValveForce) and table.pressure is not None and table.supply is None
    keys = [LOAD_PRESSURE] if given_pressure else []
    for name, given in table.states.items():
        if _NAME.fullmatch(name):
            areas = [side for side in ("front", "rear") if getattr(given, side, None) is not None]
            keys += [f"load.states.{name}.{side}" for side in areas] or [f"load.states.{name}"]
    keys += ["load.chamber.force", "load.chamber.stiffness"]
    keys += ["load.supply.flow", "load.supply.accumulator"] if table.supply is not None else []
    ports: tuple[PortTable | PlainPort, ...] = table.ports
    for i, port in enumerate(ports):
        keys += [f"load.ports[{i}].{name}" for name in ("behind", "delay") if name == "delay" or port.on is None]
    return keys


def valve_label(table: object, key: str) -> str:
    """A key of a valve in a few words, its ports counted from 1; any other key as it is written."""
    if not isinstance(table, ValveForce | ValveLoad):
        return key
    match key.replace("[", ".").replace("]", "").split("."):
        case ["load", "ports", number, name]:
            port = table.ports[int(number)]
            of = "blow" if port.on == "impact" else f"port {int(number) + 1}"
            return f"{of} → {port.to}: {'place' if name == 'behind' else name}"
        case ["load", "states", state, side]:
            return f"{state}: {side} area"
        case ["load", "states", state]:
            return f"{state}: force"
    return key


def is_of_machine(key: str) -> bool:
    """Whether a key is put on the machine, which is quicker than another case: all of the load but its areas."""
    return _OF_MACHINE.fullmatch(key) is not None


def of_machine(case: Case, keys: Mapping[str, tuple[float, str]]) -> dict[str, float]:
    """The parameters of the machine of a case that some of its keys stand for, dimensionless.

    Parameters
    ----------
    keys
        Value and unit of each.

    Raises
    ------
    ParameterError, UnitError
        For a unit that the key does not have, or none where it has one.
    """
    found, machine = {}, case.machine()
    for key, (value, unit) in keys.items():
        name = PRESSURE if key in (_SCALE, LOAD_PRESSURE) else key.partition(".")[2]
        found[name] = value if key == _SCALE or not case.is_si else _in_si(key, value, unit) / _scale(machine, key)
        if not case.is_si and unit:
            raise ParameterError(key, f"{value:g} {unit}", "a plain number: it is dimensionless")
    return found


def _dimension(key: str) -> str:
    return "pressure" if key == LOAD_PRESSURE else _DIMENSIONS.get(key.rpartition(".")[2], "force")


def _in_si(key: str, value: float, unit: str) -> float:
    return si(f"{value!r} {unit}".rstrip(), _dimension(key), key)


def _scale(machine: Machine, key: str) -> float:
    """What the value of a key in SI is divided by to be dimensionless; the pressure, to be a multiple."""
    dimension = _dimension(key)
    if dimension == "pressure":
        assert machine.pressure is not None  # else there is no such key
        return machine.pressure
    if dimension == "stiffness":
        return machine.force_scale / machine.length_scale
    return float(getattr(machine, f"{dimension}_scale"))
