"""A second program for machines that switch their own valve: matrix exponentials, a fine grid, and the rules again."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from scipy.linalg import expm
from scipy.optimize import brentq, minimize_scalar

from percuss.model import Machine
from percuss.simulate import Start

GRID = 1500
SLOW = 2e-2
FINE = 0.08  # of a radian of the fastest mode, and of the time in which the force drives the piston to a port


@dataclass
class Second:
    """A machine followed by sampling, in the coordinates of its own modes; `events` are (time, kind, detail)."""

    machine: Machine
    place: np.ndarray
    speed: np.ndarray
    state: str
    last: str = ""
    queue: list[tuple[float, str]] = field(default_factory=list)
    pressure: float = 1.0
    time: float = 0.0
    struck: float = -math.inf
    blows: int = 0
    events: list[tuple[float, str, object]] = field(default_factory=list)
    ending: str = ""

    def __post_init__(self) -> None:
        self.valve, self.last, self.size = self.machine.valve, self.last or self.state, self.place.size
        self.own = own = self.machine.modes(self.size - 1)
        rows = [
            own.centre if port.reads == "centre" else own.at(self.machine.body, np.array([port.reads]))[0]
            for port in self.valve.ports
        ]
        still = np.zeros(self.size)
        self.rows = {-1: np.concatenate([own.end, still, [0.0, 0.0]])}
        """The wall, and how far each port is uncovered, or how much faster the piston is than it asks for."""
        for i, (port, row) in enumerate(zip(self.valve.ports, rows, strict=True)):
            toward = 1.0 if port.side == "front" else -1.0
            if port.on == "entering" and port.speed is None:
                self.rows[i] = np.concatenate([toward * row, still, [0.0, toward * port.behind]])
            elif port.on == "entering":
                self.rows[i] = np.concatenate([still, toward * row, [0.0, -port.speed]])

    @property
    def numbers(self) -> np.ndarray:
        return np.concatenate([self.place, self.speed, [self.pressure, 1.0]])

    def demand(self, i: int) -> None:
        port = self.valve.ports[i]
        if port.to == self.last:
            return
        fed = self.valve.supply
        due = self.time + port.delay / (1.0 + (fed.quickening * (self.pressure - 1.0) if fed else 0.0))
        self.last = port.to
        self.queue = [order for order in self.queue if order[0] < due] + [(due, port.to)]
        self.events.append((self.time, "port", i))

    def by_the_blow(self) -> None:
        for i, port in enumerate(self.valve.ports):
            if port.on == "impact":
                self.demand(i)

    def carry_out(self) -> None:
        while self.queue and self.queue[0][0] <= self.time:
            before, self.state = self.state, self.queue.pop(0)[1]
            if self.state != before:
                self.events.append((self.time, "valve", self.state))

    def rates(self) -> np.ndarray:
        """The matrix of the rates of u, v, the pressure and 1, as long as the state stands."""
        own, n, supply = self.own, self.size, self.valve.supply
        pushed, found = dict(self.valve.pairs)[self.state] * own.driven, np.zeros((2 * n + 2, 2 * n + 2))
        found[:n, n : 2 * n] = np.eye(n)
        found[n : 2 * n, :n], found[n : 2 * n, n : 2 * n] = -np.diag(own.omega**2), -self.damping(pushed)
        found[n : 2 * n, -2], found[n : 2 * n, -1] = pushed, self.valve.chamber.force * own.driven
        if supply is not None:
            found[-2, n : 2 * n], found[-2, -1] = -pushed / supply.compliance, supply.flow / supply.compliance
        return found

    def damping(self, pushed: np.ndarray) -> np.ndarray:
        """By the law of the body at the frequencies that it has on the gas and on the oil of the accumulator."""
        law, supply = self.machine.body.damping, self.valve.supply
        if supply is None:
            return np.diag(self.own.damping)
        squares, modes = np.linalg.eigh(np.diag(self.own.omega**2) + np.outer(pushed, pushed) / supply.compliance)
        return (modes * np.append(law.rigid, law.of(np.sqrt(np.abs(squares[1:]))))) @ modes.T

    def held(self, flight: float) -> bool:
        """Whether the force holds the bar on the wall after a flight shorter than a contact takes by that law."""
        own, contact = self.own, self.machine.contact
        if contact.keeps_strain or not 0.0 < contact.restitution < 1.0:
            return False
        pushed = float((self.rates() @ self.numbers)[self.size])
        wave = 2.0 / self.machine.body.s
        return flight < wave and 0.0 <= -2.0 * own.end[0] * self.speed[0] <= 1.001 * own.end[0] * pushed * wave

    def strike(self) -> None:
        wall, contact = self.own.end, self.machine.contact
        self.blows += 1
        self.events.append((self.time, "impact", float(wall @ self.speed)))
        self.place[0] -= wall @ self.place / wall[0]
        self.place = contact.strain_factor * self.place
        self.speed = -contact.restitution * self.speed

    def step(self, cap: float, most: float) -> bool:
        """On to the next event; whether there was one before `cap`, and more are to come."""
        rates, n = self.rates(), self.size
        due = self.queue[0][0] if self.queue else math.inf
        horizon = min(due, cap) - self.time
        force = max(abs(float(rates[n, -2] * self.pressure + rates[n, -1])), 1e-3)
        near = min((port.behind for port in self.valve.ports if port.behind), default=1.0)
        width = FINE * min(1.0 / max(self.own.omega[-1], 1e-9), math.sqrt(near / force))
        one, begin, z, found = expm(rates * width), 0.0, self.numbers, None
        while found is None and begin < horizon:
            steps = min(GRID, math.ceil((horizon - begin) / width))
            states, power = z[:, None], one
            while states.shape[1] <= steps:
                states, power = np.hstack([states, power @ states]), power @ power
            states = states[:, : steps + 1]
            found = self.entered(rates, states, width, begin == 0.0)
            tau, what = found or (math.inf, None)
            if begin + tau >= horizon:
                tau, what = horizon - begin, None
            k = min(int(tau / width), steps)
            if (states[-2, : k + 1] < 0.0).any():
                self.ending = "no pressure"
                return False
            if found is None and begin + steps * width < horizon:
                begin, z = begin + steps * width, states[:, -1]
                continue
            z = expm(rates * (tau - k * width)) @ states[:, k]
            break
        self.place, self.speed, self.pressure = z[:n], z[n : 2 * n], float(z[-2])
        if what is None:
            self.time = min(due, cap)
            self.carry_out()
            return due < cap
        self.time += begin + tau
        if what == -1:
            self.strike()
            if self.blows == most:
                return False
            self.by_the_blow()
            flight, self.struck = self.time - self.struck, self.time
            if abs(self.own.end @ self.speed) < SLOW or self.held(flight):
                self.ending = "nearly at rest"  # what follows is not this program's
                return False
        else:
            self.demand(what)
        self.carry_out()
        return True

    def entered(self, rates: np.ndarray, states: np.ndarray, width: float, at_begin: bool) -> tuple[float, int] | None:
        """Time and number of the first of the watched to rise through 0 on a grid of states; ports that matter only."""
        times = []
        for what, row in self.rows.items():
            if what >= 0 and self.valve.ports[what].to == self.last:
                continue
            values = row @ states

            def value(t: float, k: int, row: np.ndarray = row) -> float:
                return float(row @ (expm(rates * t) @ states[:, k]))

            if at_begin and abs(values[0]) < 1e-11:  # where the last event was
                values[0] = math.copysign(1e-300, value(1e-3 * width, 0))
            if values[0] < 0.0 and values[1] < 0.0 and value(1e-3 * width, 0) > values[0]:  # it may come and go at once
                high = minimize_scalar(
                    lambda t: -value(t, 0), bounds=(0.0, width), method="bounded", options={"xatol": 1e-10 * width}
                )
                if high.fun < 0.0:
                    low = 0.0 if values[0] < -1e-200 else 1e-3 * width
                    times.append((brentq(value, low, high.x, (0,), xtol=1e-15, rtol=1e-14), what))
                    continue
            up = np.flatnonzero((values[:-1] < 0.0) & (values[1:] >= 0.0))[:1]
            left, top, right = values[:-2], values[1:-1], values[2:]
            near = (top > left) & (top >= right) & (top < 0.0) & (top > -np.abs(top - left) - np.abs(top - right))
            for k in np.flatnonzero(near[: up[0]] if up.size else near).tolist():
                high = minimize_scalar(
                    lambda t, k=k: -value(t, k), bounds=(0.0, 2.0 * width), method="bounded",
                    options={"xatol": 1e-10 * width},
                )  # fmt: skip
                if high.fun < 0.0:
                    low = 0.0 if values[k] < -1e-200 else 1e-3 * width
                    times.append((k * width + brentq(value, low, high.x, (k,), xtol=1e-15, rtol=1e-14), what))
                    break
            else:
                for k in up.tolist():
                    low = 0.0 if values[k] < -1e-200 else 1e-3 * width
                    times.append((k * width + brentq(value, low, width, (k,), xtol=1e-15, rtol=1e-14), what))
        return min(times, default=None)

    def run(self, cap: float, most: float = math.inf, blows: float = math.inf) -> Second:
        """Up to a time, so many events, or so many blows."""
        while len(self.events) < most and self.step(cap, blows):
            pass
        return self


def second(machine: Machine, modes: int, start: Start) -> Second:
    """The other program at a start, where ports whose region is occupied demand at once."""
    u, v, _ = start.state(modes, machine)
    elastic, supply = machine.body.modes(modes, machine.at), machine.valve.supply
    unit = np.append(1.0, elastic.gamma / elastic.end)  # coordinates that move the driven place by 1, in modal mass 1
    place, speed = (machine.modes(modes).mixing.T @ (unit * given) for given in (u, v))
    state = start.valve_state or machine.valve.start
    now = Second(machine, place, speed, state, pressure=1.0 if supply is None else supply.start)
    for i, row in now.rows.items():
        if i >= 0 and row @ now.numbers > 0.0:
            now.demand(i)
    now.carry_out()
    return now


def after_blows(machine: Machine, numbers: np.ndarray, state: str, last: str, waiting: list[str], blows: int = 1):
    """Time and numbers just after a blow, from those after one: u, v, the pressure, when the pending orders are due."""
    n = (numbers.size - 1 - len(waiting)) // 2
    queue = list(zip(numbers[2 * n + 1 :].tolist(), waiting, strict=True))
    now = Second(machine, numbers[:n], numbers[n : 2 * n], state, last, queue, float(numbers[2 * n]))
    now.place = now.place.copy()
    now.by_the_blow()
    now.carry_out()
    now.run(60.0, blows=blows)  # what the last blow demands is the next cycle's
    assert now.blows == blows and [to for _, to in now.queue] == waiting and now.state == state
    return now.time, np.concatenate([now.place, now.speed, [now.pressure], [due - now.time for due, _ in now.queue]])
