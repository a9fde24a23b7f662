"""A second program for machines whose oil flows: the equations by a Runge-Kutta method of order 8, with its own events.

A description is that of `oil_cases`. Every change of the right-hand side ends a piece of the motion: ports, orders that
are due, ends of strokes of the spool, turnings, relief valve, accumulator, power limit. The time of an event is found
on the interpolant of a step, and then on the solution itself.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.integrate import DOP853, solve_ivp
from scipy.optimize import brentq

RTOL = 3e-12
SUMS = ("input", "rear", "front", "leakage", "relief", "return_line", "drag", "pumped", "drawn", "leaked", "relieved")
MOST = 4000  # pieces


@dataclass
class Flow:
    """A machine on its way with N elastic modes of a free uniform bar; a spool that travels comes from `before`."""

    system: dict[str, Any]
    place: np.ndarray
    speed: np.ndarray
    pressure: float
    state: str
    last: str
    orders: list[tuple[float, str]] = field(default_factory=list)
    before: str = ""
    moving_since: float = -math.inf
    transit: float = 1.0
    time: float = 0.0
    struck: bool = False
    blows: list[tuple[float, float, float]] = field(default_factory=list)
    ports: list[tuple[float, int]] = field(default_factory=list)
    changes: list[tuple[float, str]] = field(default_factory=list)
    dry: bool = False

    def __post_init__(self) -> None:
        self.n = self.place.size
        n, numbers = self.n, np.arange(self.place.size)
        self.omega2 = (numbers * math.pi / self.transit) ** 2
        self.end = np.where(numbers == 0, 1.0, math.sqrt(2.0))
        self.driven = self.end * (-1.0) ** numbers
        self.fed = "pump" in self.system["supply"]
        self.y = np.concatenate([self.place, self.speed, [self.pressure], np.zeros(len(SUMS))])
        self.rows = {name: self._row(name) for name in self.system["states"]}
        self.blend = (self.rows[self.state], 0.0 * self.rows[self.state])
        self.stroke_end = math.inf
        if self.system["spool"] and self.before and self.time - self.moving_since < self.system["spool"]:
            self._move(self.before, self.state, self.moving_since)
        supply = self.system["supply"]
        relief, held = supply.get("relief"), supply.get("accumulator", {})
        self.relief = "none" if relief is None else "open" if self.pressure > relief["pressure"] else "closed"
        self.filled = self.pressure > held.get("precharge", math.inf)
        self.limited = self._corner(self.pressure) < 0.0
        self.sign = math.copysign(1.0, float(self.driven @ self.y[n : 2 * n]))
        self.inside = [self._into(i, self.y) > 0.0 for i in range(len(self.system["ports"]))]
        self.fired = ""
        if self.struck:
            self.fired = "wall"
            self._demands_of_blow()

    # -- the equations --

    def _row(self, name: str) -> np.ndarray:
        """Of a state: area on the supply, area on the tank, b of each chamber toward the wall and away from it."""
        row = np.zeros(6)
        for i, chamber in enumerate(self.system["chambers"]):
            join = self.system["states"][name].get(chamber["name"])
            if join is not None:
                sign = 1.0 if chamber["side"] == "rear" else -1.0
                row[0 if join["to"] == "supply" else 1] += sign * chamber["area"]
                ways = (join["zeta_in"], join["zeta_out"])[:: int(sign)]
                row[2 + 2 * i : 4 + 2 * i] = [chamber["area"] ** 3 * way for way in ways]
        return row

    def _move(self, old: str, new: str, begun: float) -> None:
        t_v = self.system["spool"]
        slope = (self.rows[new] - self.rows[old]) / t_v
        self.blend, self.stroke_end = (self.rows[old] - slope * begun, slope), begun + t_v

    def _pump(self, pressure: float) -> float:
        pump = self.system["supply"]["pump"]
        return pump["power"] / pressure if self.limited else pump["flow"] - pump.get("slip", 0.0) * pressure

    def _corner(self, pressure: float) -> float:
        """What is left of the power at full flow."""
        pump = self.system["supply"].get("pump", {})
        if "power" not in pump:
            return math.inf
        return float(pump["power"] - (pump["flow"] - pump.get("slip", 0.0) * pressure) * pressure)

    def _surplus(self, t: float, y: np.ndarray) -> float:
        row = self.blend[0] + self.blend[1] * t
        v, P = float(self.driven @ y[self.n : 2 * self.n]), y[2 * self.n]
        return float(self._pump(P) - row[0] * v - self.system["supply"].get("leak", 0.0) * P)

    def rates(self, t: float, y: np.ndarray) -> np.ndarray:
        n, system = self.n, self.system
        supply, found = system["supply"], np.zeros_like(y)
        row = self.blend[0] + self.blend[1] * t
        u, v, P = float(self.driven @ y[:n]), float(self.driven @ y[n : 2 * n]), float(y[2 * n])
        way = 0 if self.sign > 0.0 else 1
        rear, front = row[2 + way], row[4 + way]
        push = system["force"] + row[0] * P + row[1] * system["tank"] - self.sign * (rear + front) * v * v
        gas = system.get("gas")
        if gas is not None:
            push += gas["force"] * (1.0 + gas["area"] * u / gas["volume"]) ** -gas["exponent"]
        found[:n] = y[n : 2 * n]
        found[n : 2 * n] = self.driven * push / system["mass"] - system["drag"] * y[n : 2 * n] - self.omega2 * y[:n]
        leak, relief, drawn = supply.get("leak", 0.0) * P, 0.0, row[0] * v
        pumped = drawn + leak
        if self.fed:
            pumped = self._pump(P)
            if self.relief == "open":
                relief = supply["relief"]["slope"] * (P - supply["relief"]["pressure"])
            if self.relief == "held":
                relief = pumped - drawn - leak
            else:
                held = supply["accumulator"]
                capacity = held.get("compliance") or supply.get("line", 0.0)
                if self.filled:
                    seen = P + held["atmosphere"]
                    part = (held["precharge"] + held["atmosphere"]) / seen
                    capacity += held["volume"] / (held["exponent"] * seen) * part ** (1.0 / held["exponent"])
                found[2 * n] = (pumped - drawn - leak - relief) / capacity
        lost = abs(v) ** 3
        rigid = float(y[n : 2 * n] @ y[n : 2 * n])
        found[2 * n + 1 :] = [
            P * pumped, rear * lost, front * lost, P * leak, P * relief, -system["tank"] * row[1] * v,
            system["mass"] * system["drag"] * rigid, pumped, drawn, leak, relief,
        ]  # fmt: skip
        return found

    # -- the guards: each positive while nothing happens --

    def _into(self, i: int, y: np.ndarray) -> float:
        """How far a port is uncovered."""
        port = self.system["ports"][i]
        if port.get("on") == "impact":
            return -1.0
        return float((y[0] + port["behind"]) * (1.0 if port["side"] == "front" else -1.0))

    def guards(self) -> dict[str, Callable[[float, np.ndarray], float]]:
        n, supply = self.n, self.system["supply"]
        found: dict[str, Callable[[float, np.ndarray], float]] = {
            "wall": lambda t, y: -float(self.end @ y[:n]),
            "turns": lambda t, y: self.sign * float(self.driven @ y[n : 2 * n]),
        }
        for i, inside in enumerate(self.inside):
            way = 1.0 if inside else -1.0
            found[f"port {i}"] = lambda t, y, i=i, way=way: way * self._into(i, y)
        if not self.fed:
            return found
        found["dry"] = lambda t, y: float(y[2 * n])
        if self.relief == "held":
            found["relief"] = self._surplus
        elif self.relief != "none":
            way, opens = 1.0 if self.relief == "open" else -1.0, supply["relief"]["pressure"]
            found["relief"] = lambda t, y: way * float(y[2 * n] - opens)
        if "precharge" in supply["accumulator"]:
            side, charge = 1.0 if self.filled else -1.0, supply["accumulator"]["precharge"]
            found["charge"] = lambda t, y: side * float(y[2 * n] - charge)
        if "power" in supply["pump"]:
            over = -1.0 if self.limited else 1.0
            found["limit"] = lambda t, y: over * self._corner(float(y[2 * n]))
        return found

    # -- on its way --

    def run(self, blows: int, until: float = math.inf) -> None:
        """On until so many blows, or a time; with the last blow before what it demands."""
        for _ in range(MOST):
            due = min(self.orders[0][0] if self.orders else math.inf, self.stroke_end, until)
            if due > self.time:
                event = self._piece(due)
                if event:
                    self.fired = event
                    if event == "wall":
                        self.blows.append(
                            (self.time, float(self.end @ self.y[self.n : 2 * self.n]), float(self.y[2 * self.n]))
                        )
                        self._rebounds()
                        if len(self.blows) == blows:
                            return
                        self._demands_of_blow()
                    elif event == "dry":
                        self.dry = True
                        return
                    else:
                        self._happens(event)
                    continue
            if until <= self.time:
                return
            self.fired = ""
            if self.stroke_end <= self.time:
                self.blend, self.stroke_end = (self.rows[self.state], 0.0 * self.rows[self.state]), math.inf
            while self.orders and self.orders[0][0] <= self.time:
                self._changes(self.orders.pop(0)[1])
        raise RuntimeError("too many events")

    def _rebounds(self) -> None:
        n = self.n
        self.y[n : 2 * n] *= -self.system["restitution"]
        if n == 1:
            self.y[0] = 0.0
        self.sign = math.copysign(1.0, float(self.driven @ self.y[n : 2 * n]))

    def _demands_of_blow(self) -> None:
        for port in self.system["ports"]:
            if port.get("on") == "impact":
                self._demand(port)

    def _happens(self, event: str) -> None:
        word, _, number = event.partition(" ")
        if word == "turns":
            self.sign = -self.sign
        elif word == "port":
            i = int(number)
            self.inside[i] = not self.inside[i]
            if self.inside[i]:
                port = self.system["ports"][i]
                if port["to"] != self.last:
                    self.ports.append((self.time, i))
                    self._demand(port)
        elif word == "relief":
            ideal = self.system["supply"]["relief"]["slope"] == "ideal"
            self.relief = ("held" if ideal else "open") if self.relief == "closed" else "closed"
        elif word == "charge":
            self.filled = not self.filled
        elif word == "limit":
            self.limited = not self.limited

    def _demand(self, port: dict[str, Any]) -> None:
        if port["to"] == self.last:
            return
        due = self.time + port.get("delay", 0.0)
        self.last = port["to"]
        self.orders = [order for order in self.orders if order[0] < due] + [(due, port["to"])]

    def _changes(self, to: str) -> None:
        if self.stroke_end < math.inf:
            raise RuntimeError("an order is due while the spool travels")
        self.changes.append((self.time, to))
        if self.system["spool"]:
            self._move(self.state, to, self.time)
        else:
            self.blend = (self.rows[to], 0.0 * self.rows[to])
        self.state = to

    def _piece(self, end: float) -> str:
        """On until a time, or the first event, whose name is told."""
        scale = 1e-14 * np.maximum(np.abs(self.y), 1.0)
        guards, begun = self.guards(), self.time
        solver = DOP853(self.rates, self.time, self.y, min(end, begun + 1e3), rtol=RTOL, atol=scale)
        skip = self.fired
        while solver.status == "running":
            message = solver.step()
            if solver.status == "failed":
                raise RuntimeError(message)
            t_0, t_1, y_0 = solver.t_old, solver.t, solver.dense_output()
            assert t_0 is not None
            first, name = math.inf, ""
            looks = np.linspace(t_0, t_1, 6 if self.n == 1 else 3)[1:]
            seen = y_0(looks)
            for key, guard in guards.items():
                for i, t in enumerate(looks):
                    if guard(t, seen[:, i]) < 0.0:
                        low = t_0 if i == 0 else looks[i - 1]
                        inside = [guard(s, y_0(s)) for s in (low, t)]
                        if not (key == skip and t_0 == begun and i == 0):
                            root = low if inside[0] <= 0.0 else brentq(lambda s: guard(s, y_0(s)), low, t, xtol=1e-15)  # noqa: B023
                            if root < first:
                                first, name = root, key
                        break
            if name:
                self.time, self.y = t_0, y_0(t_0)
                self._to(first, guards[name])
                return name
            self.y = solver.y
        self.time, self.y = solver.t, solver.y
        return ""

    def _to(self, t: float, guard: Callable[[float, np.ndarray], float]) -> None:
        """To the event near a time, by Newton's method on the solution."""
        for _ in range(3):
            if t > self.time:
                span = solve_ivp(self.rates, (self.time, t), self.y, method="DOP853", rtol=RTOL, atol=1e-15)
                at = span.y[:, -1]
            else:
                at = self.y
            rate = self.rates(t, at)
            here, eps = guard(t, at), 1e-7
            slope = (guard(t + eps, at + eps * rate) - guard(t - eps, at - eps * rate)) / (2.0 * eps)
            late = -here / slope if slope else 0.0
            if abs(late) < 1e-9:
                self.time, self.y = (
                    t + late,
                    at + late * rate + 0.5 * late**2 * (self.rates(t + late, at + late * rate) - rate) / (late or 1.0),
                )
                return
            t += late
        self.time, self.y = t, at

    @property
    def sums(self) -> dict[str, float]:
        """What has been put in and lost."""
        return dict(zip(SUMS, self.y[2 * self.n + 1 :].tolist(), strict=True))
