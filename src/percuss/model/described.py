"""Systems and machines in JSON's types, exactly, and back: what archives and saved motions are known by."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np

from percuss.errors import ParameterError
from percuss.model.body import BODIES, DAMPINGS, SIZED_BODIES, External, UniformBar
from percuss.model.contact import LAWS, Kept
from percuss.model.load import (
    Chamber,
    Cushion,
    GasAccumulator,
    Join,
    Load,
    Oil,
    OilChamber,
    Port,
    Relief,
    Supply,
    Valve,
)
from percuss.model.machine import Machine
from percuss.model.system import System

_KINDS: dict[str, Mapping[str, type]] = {"body": BODIES, "bar": SIZED_BODIES, "contact": LAWS, "damping": DAMPINGS}


def describe_system(system: System) -> dict[str, Any]:
    """A system in JSON's types, exactly: B77's by s, d and R, others by their body and contact law."""
    about: dict[str, Any] = {"load": _load(system.load)}
    plain = isinstance(system.body, UniformBar) and isinstance(system.body.damping, External)
    if plain and isinstance(system.contact, Kept):
        about |= {"s": system.s, "d": system.d, "restitution": system.restitution}
    else:
        about |= {"body": _described(system.body), "contact": _described(system.contact)}
    if system.bar is not None:
        about |= {"bar": _described(system.bar), "frequency": system.frequency}
    return about


def describe_machine(machine: Machine) -> dict[str, Any]:
    """A machine that switches its own valve in JSON's types, exactly."""
    body, contact, valve = _described(machine.body), _described(machine.contact), _plain(machine.valve)
    about: dict[str, Any] = {"body": body, "contact": contact, "valve": valve, "at": machine.at}
    if machine.bar is not None:
        about |= {"bar": _described(machine.bar), "pressure": machine.pressure}
    return about


def system_from(about: Mapping[str, Any]) -> System:
    """The system that a description tells of; `describe_system` backwards; ParameterError when it tells of none."""
    told = about["load"]
    p = np.array([complex(*pair) for pair in told["coefficients"]])
    load = Load(p, None, tuple(told.get("breaks", ())), tuple(told.get("values", ())), at=told.get("at", 0))
    if "body" in about:
        body, contact = _made("body", about["body"]), _made("contact", about["contact"])
    else:
        body, contact = UniformBar(about["s"], External(about["d"])), Kept(about["restitution"])
    if about.get("bar") is None:
        return System(body, load, contact)
    return System(body, load, contact, bar=_made("bar", about["bar"]), frequency=float(about["frequency"]))


def machine_from(about: Mapping[str, Any]) -> Machine:
    """The machine that a description tells of; `describe_machine` backwards; ParameterError when it tells of none."""
    body, contact, valve = _made("body", about["body"]), _made("contact", about["contact"]), about["valve"]
    made = Valve(
        tuple(tuple(state) for state in valve["states"]),
        tuple(Port(**port) for port in valve["ports"]),
        valve["start"],
        Chamber(**valve["chamber"]),
        None if valve.get("cushion") is None else Cushion(**valve["cushion"]),
        _supply(valve.get("supply")),
        _oil(valve.get("oil")),
    )
    if about.get("bar") is None:
        return Machine(body, made, contact, at=about["at"])
    return Machine(body, made, contact, at=about["at"], bar=_made("bar", about["bar"]), pressure=about["pressure"])


def _supply(about: Mapping[str, Any] | None) -> Supply | None:
    if about is None:
        return None
    relief, gas = about.get("relief"), about.get("gas")
    parts = {"relief": relief and Relief(**relief), "gas": gas and GasAccumulator(**gas)}
    return Supply(**{**about, **parts})


def _oil(about: Mapping[str, Any] | None) -> Oil | None:
    if about is None:
        return None
    chambers = tuple(OilChamber(**one) for one in about["chambers"])
    joins = tuple((name, tuple(Join(**one) for one in own)) for name, own in about["joins"])
    return Oil(**{**about, "chambers": chambers, "joins": joins})


def _load(load: Load) -> dict[str, Any]:
    about: dict[str, Any] = {"coefficients": [[c.real, c.imag] for c in load.coefficients.tolist()]}
    if load.is_piecewise:
        about |= {"breaks": list(load.breaks), "values": list(load.values)}
    if load.at:
        about["at"] = load.at
    return about


def _described(part: Any) -> dict[str, Any]:
    """A body, a law of damping or of contact: its kind and its fields."""
    return {"kind": part.kind} | {field.name: _plain(getattr(part, field.name)) for field in fields(part)}


def _plain(value: Any) -> Any:
    if hasattr(value, "kind"):
        return _described(value)
    if is_dataclass(value):
        return {field.name: _plain(getattr(value, field.name)) for field in fields(value)}
    return [_plain(own) for own in value] if isinstance(value, tuple) else value


def _made(room: str, about: Mapping[str, Any]) -> Any:
    kinds = _KINDS[room]
    kind = str(about.get("kind"))
    if kind not in kinds:
        raise ParameterError(room, kind, f"one of {', '.join(map(repr, kinds))}")
    values = {name: _value(name, value) for name, value in about.items() if name != "kind"}
    return kinds[kind](**values)


def _value(name: str, value: Any) -> Any:
    if isinstance(value, Mapping) and name in _KINDS:
        return _made(name, value)
    return tuple(_value(name, own) for own in value) if isinstance(value, list) else value
