"""Machines whose oil flows, as `data/oil.json` describes them: as case files, as objects, and drawn at random.

A description is that of the figures: position u <= 0, force toward the wall positive, all in one system of units::

    mass v' = force + gas.force (1 + gas.area u/gas.volume)^(-gas.exponent) + sum +-area_i p_i - mass drag v
    p_i = P - zeta q_i |q_i|,   C P' = pump - sum q_i - leak P - slope (P - relief.pressure)+
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from percuss.model import (
    Chamber,
    External,
    GasAccumulator,
    Join,
    Kept,
    Machine,
    Oil,
    OilChamber,
    Port,
    Relief,
    Supply,
    UniformBar,
    Valve,
)

CASES: list[dict[str, Any]] = json.loads((Path(__file__).parents[1] / "data" / "oil.json").read_text(encoding="utf-8"))
ORBITS = [case for case in CASES if case["kind"] == "orbit"]
RUNS = [case for case in CASES if case["kind"] == "run"]
PRESSURE = 160e5  # for which an SI case has its forces

System = dict[str, Any]


def named(word: str, kind: str = "orbit") -> System:
    """The system of the case in whose name a word stands."""
    return next(case["system"] for case in CASES if case["kind"] == kind and word in case["name"])


# ---- As a case file


def _toml(value: Any) -> str:
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key} = {_toml(own)}" for key, own in value.items() if own is not None) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(_toml, value)) + "]"
    return json.dumps(value)


def case_text(system: System, si: bool = False, start: System | None = None, until: float | None = None) -> str:
    """The case file of a system."""

    def unit(value: float | None, name: str) -> float | str | None:
        return value if not si or value is None else f"{value!r} {name}"

    def drop(zeta: float) -> dict[str, Any]:
        return {"drop": unit(zeta * 1e-6 if si else zeta, "Pa"), "at": unit(1e-3 if si else 1.0, "m^3/s")}

    def slope(value: float | None) -> dict[str, Any] | None:
        return None if not value else {"flow": unit(value * 1e5 if si else value, "m^3/s"), "at": one}

    one = unit(1e5 if si else 1.0, "Pa")
    gas, supply, pump = system.get("gas"), system["supply"], system["supply"].get("pump")
    fed: dict[str, Any] = {"leakage": slope(supply.get("leak"))}
    if pump is not None:
        held, relief = supply["accumulator"], supply.get("relief")
        if "precharge" in held:
            line = supply.get("line", 0.0)
            fed["accumulator"] = {
                "precharge": unit(held["precharge"], "Pa"), "volume": unit(held["volume"], "m^3"),
                "exponent": held["exponent"], "atmosphere": unit(held["atmosphere"], "Pa"),
            }  # fmt: skip
            fed["line"] = unit(line * 1.4e9 if si else line, "m^3")
        else:
            fed["accumulator"] = unit(held["compliance"], "m^3/Pa")
        if relief is not None:
            over = relief["slope"]
            opens = unit(relief["pressure"], "Pa")
            fed["relief"] = opens if over == "ideal" else {
                "opens": opens, "flow": unit(over * 1e5 if si else over, "m^3/s"), "over": one
            }  # fmt: skip
        fed |= {"flow": unit(pump["flow"], "m^3/s"), "start": unit(supply["start"], "Pa")}
        fed |= {"power": unit(pump.get("power"), "W"), "slip": slope(pump.get("slip"))}
    load = {
        "kind": "valve",
        "pressure": unit(PRESSURE, "Pa") if si else None,
        "chambers": {
            one["name"]: {"area": unit(one["area"], "m^2"), "side": one["side"]} for one in system["chambers"]
        },
        "states": {name: {own: join["to"] for own, join in state.items()} for name, state in system["states"].items()},
        "orifices": [
            {"chamber": own, "to": join["to"], "state": name}
            | {"in": drop(join["zeta_in"]), "out": drop(join["zeta_out"])}
            for name, state in system["states"].items() for own, join in state.items()
        ],
        "oil": {"tank": unit(system["tank"], "Pa")},
        "chamber": None if gas is None else {
            "force": unit(gas["force"], "N"), "area": unit(gas["area"], "m^2"), "volume": unit(gas["volume"], "m^3"),
            "exponent": gas["exponent"],
        },
        "ports": [
            {**port, **{key: unit(port[key], name) for key, name in (("behind", "m"), ("delay", "s")) if key in port}}
            for port in system["ports"]
        ],
        "start_state": system["start_state"],
        "spool": unit(system["spool"], "s") if system["spool"] else None,
        "force": unit(system["force"], "N") if system["force"] else None,
        "supply": {key: own for key, own in fed.items() if own is not None} or None,
    }  # fmt: skip
    drag = system["drag"]
    if si:
        body = '[bar]\nlength = "1 m"\narea = "10 cm^2"\nyoungs_modulus = "200 GPa"\n'
        body += f'density = "{system["mass"] / 1e-3!r} kg/m^3"\n'
        body += f'damping = {{kind = "external", value = {drag!r}}}\n' if drag else ""
        contact = f"[contact]\nrestitution = {system['restitution']}\n"
    else:
        body, contact = f"[system]\ns = 20.0\nd = {drag!r}\nrestitution = {system['restitution']}\n", ""
    text = body + contact + "[load]\n" + "".join(f"{k} = {_toml(v)}\n" for k, v in load.items() if v is not None)
    if start is not None and until is not None:
        place, speed, end = unit(start["u"], "m"), unit(start["v"], "m/s"), unit(until, "s")
        text += f"[start]\nposition = {_toml(place)}\nvelocity = {_toml(speed)}\n"
        text += f"[simulation]\nmodes = 0\ntime = {_toml(end)}\nperiodic = false\n"
    return text


# ---- As a machine of mass 1


def machine_of(system: System, s: float = 20.0) -> Machine:
    """The machine of a dimensionless system, with a uniform bar as its piston."""
    supply, gas, pump = system["supply"], system.get("gas"), system["supply"].get("pump")
    chambers = [OilChamber(one["name"], one["area"], one["side"]) for one in system["chambers"]]
    joins = {
        name: [Join(own, join["to"], join["zeta_in"], join["zeta_out"]) for own, join in state.items()]
        for name, state in system["states"].items()
    }
    oil = Oil(chambers, joins, system["tank"], system["spool"], supply.get("leak", 0.0), system["force"])
    chamber = Chamber()
    if gas is not None:
        chamber = Chamber(gas["force"], gas["force"] * gas["exponent"] * gas["area"] / gas["volume"], gas["exponent"])
    fed = None
    if pump is not None:
        held, relief = supply["accumulator"], supply.get("relief")
        linear = "compliance" in held
        fed = Supply(
            pump["flow"],
            held["compliance"] if linear else supply.get("line", 0.0),
            supply["start"],
            0.0,
            pump.get("slip", 0.0),
            pump.get("power"),
            None
            if relief is None
            else Relief(relief["pressure"], None if relief["slope"] == "ideal" else relief["slope"]),
            None if linear else GasAccumulator(*(held[k] for k in ("precharge", "volume", "exponent", "atmosphere"))),
        )
    ports = [
        Port(own["to"], own.get("behind"), own.get("side"), own.get("delay", 0.0), on=own.get("on", "entering"))
        for own in system["ports"]
    ]
    states = {name: oil.areas(name, "supply") for name in joins}
    valve = Valve(states, ports, system["start_state"], chamber, None, fed, oil)
    return Machine(UniformBar(s, External(system["drag"])), valve, Kept(system["restitution"]))


# ---- At random, over all that a description can say


def random_system(seed: int) -> System:
    """A machine of a piston of mass 1 with a port at 1, under a pressure near 1."""
    rng = np.random.default_rng([7, seed])

    def near(low: float, high: float) -> float:
        return round(float(rng.uniform(low, high)), 6)

    def some(part: float) -> bool:
        return bool(rng.random() < part)

    rear, front = near(1.7, 2.5), near(0.45, 0.85)
    size = 10.0 ** near(-2.0, 0.3)  # of all the passages

    def passage(area: float, to: str) -> dict[str, Any]:
        b = size * near(0.1, 0.5) / area**3
        return {"to": to, "zeta_in": b, "zeta_out": b * near(0.7, 1.4) if some(0.6) else b}

    at_blow = some(0.3)
    back = {"on": "impact", "to": "return"} if at_blow else {
        "behind": near(0.1, 0.25), "side": "front", "to": "return", "delay": near(0.0, 0.06) if some(0.7) else 0.0
    }  # fmt: skip
    system: System = {
        "mass": 1.0,
        "restitution": near(0.05, 0.45),
        "drag": near(0.0, 0.05) if some(0.5) else 0.0,
        "force": near(-0.04, 0.04) if some(0.4) else 0.0,
        "tank": near(0.0, 0.06) if some(0.6) else 0.0,
        "chambers": [
            {"name": "rear", "side": "rear", "area": rear}, {"name": "front", "side": "front", "area": front}
        ],
        "states": {
            "return": {"rear": passage(rear, "tank"), "front": passage(front, "supply")},
            "power": {"rear": passage(rear, "supply"), "front": passage(front, "supply")},
        },
        "ports": [
            {"behind": 1.0, "side": "back", "to": "power", "delay": near(0.0, 0.15) if some(0.6) else 0.0}, back
        ],
        "start_state": "return",
        "spool": near(0.01, 0.15) if some(0.4) else 0.0,
    }  # fmt: skip
    if some(0.5):
        system["gas"] = {
            "force": near(0.02, 0.15),
            "area": near(0.3, 0.6),
            "volume": near(1.5, 3.0),
            "exponent": near(1.0, 1.6),
        }
    leak = near(0.005, 0.06) if some(0.6) else 0.0
    if some(0.2):
        system["supply"] = {"pressure": 1.0, "leak": leak}
        return system
    pump: dict[str, Any] = {"flow": near(0.35, 0.8)}
    if some(0.3):
        pump["slip"] = near(0.005, 0.05)
    if some(0.3):
        pump["power"] = near(0.3, 0.8)
    if some(0.5):
        held = {"compliance": 10.0 ** near(-0.3, 1.5)}
    else:
        held = {
            "precharge": near(0.2, 0.9), "volume": near(0.6, 6.0), "exponent": near(1.0, 1.5),
            "atmosphere": near(0.0, 0.02) if some(0.5) else 0.0,
        }  # fmt: skip
    system["supply"] = {
        "pump": pump,
        "accumulator": held,
        "line": near(0.02, 0.2),
        "start": near(0.6, 1.2),
        "leak": leak,
    }
    if some(0.5):
        slope = "ideal" if some(0.4) else near(0.2, 1.0)
        system["supply"]["relief"] = {"pressure": near(0.7, 1.6), "slope": slope}
    return system
