"""A second program for machines that switch their own valve: complex exponentials, a fine grid, and the rules again."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from scipy.optimize import brentq, minimize_scalar

from percuss.model import Machine

GRID = 1500
SLOW = 2e-2
FINE = 0.08  # of a radian of the fastest mode, and of the time in which the force drives the piston to a port


@dataclass
class Piece:
    """Free motion from a time on: u_i(τ) = still + a e^{rτ} + b e^{sτ}, or a polynomial, of each decoupled motion."""

    force: float
    omega: np.ndarray
    damping: np.ndarray
    driven: np.ndarray
    place: np.ndarray
    speed: np.ndarray

    def __post_init__(self) -> None:
        w, d = self.omega.astype(complex), self.damping
        root = np.sqrt(0.25 * d * d - w * w)
        near = np.abs(root) < 1e-7 * (np.abs(w) + d + 1e-300)
        root = np.where(near, 1e-7 * (np.abs(w) + d + 1e-300), root)
        # the smaller of two real roots without cancellation
        quick = -0.5 * d - root
        slow = np.where(np.abs(quick) > 0.0, w * w / np.where(quick == 0.0, 1.0, quick), -0.5 * d + root)
        self.roots = np.where(root.real > 0.0, slow, -0.5 * d + root), quick

    def at(self, tau: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Places and speeds, each of shape (N+1, len(tau))."""
        tau = np.atleast_1d(np.asarray(tau, dtype=float))
        places, speeds = [], []
        for i, (w, d) in enumerate(zip(self.omega.tolist(), self.damping.tolist(), strict=True)):
            p, u, v = self.force * self.driven[i], self.place[i], self.speed[i]
            if w == 0.0 and d == 0.0:
                places.append(u + v * tau + 0.5 * p * tau**2)
                speeds.append(v + p * tau)
            elif w == 0.0:
                gone = -np.expm1(-d * tau)
                places.append(u + (v - p / d) * gone / d + p / d * tau)
                speeds.append(p / d + (v - p / d) * (1.0 - gone))
            else:
                r, s = self.roots[0][i], self.roots[1][i]
                still = p / w**2
                a = (v - s * (u - still)) / (r - s)
                b = (u - still) - a
                first, second = a * np.exp(r * tau), b * np.exp(s * tau)
                places.append(still + (first + second).real)
                speeds.append((r * first + s * second).real)
        return np.array(places), np.array(speeds)


@dataclass
class Second:
    """A machine followed by sampling; `events` are (time, kind, detail)."""

    machine: Machine
    modes: int
    place: np.ndarray
    speed: np.ndarray
    state: str
    time: float = 0.0
    struck: float = -math.inf
    events: list[tuple[float, str, object]] = field(default_factory=list)
    ending: str = ""

    def __post_init__(self) -> None:
        machine, own = self.machine, self.machine.modes(self.modes)
        self.own, self.valve, self.last, self.queue = own, machine.valve, self.state, []
        self.rows = [
            own.centre if port.reads == "centre" else own.at(machine.body, np.array([port.reads]))[0]
            for port in self.valve.ports
        ]
        for i, port in enumerate(self.valve.ports):
            if port.on == "entering" and self.off(i, self.place, self.speed) > 0.0:
                self.demand(i)
        self.carry_out()

    def off(self, port: int, place: np.ndarray, speed: np.ndarray) -> np.ndarray:
        """How far a port is uncovered, or how much faster than it is asked for."""
        own = self.valve.ports[port]
        toward = 1.0 if own.side == "front" else -1.0
        if own.speed is not None:
            return toward * (self.rows[port] @ speed) - own.speed
        return toward * (self.rows[port] @ place + own.behind)

    def demand(self, i: int) -> None:
        port = self.valve.ports[i]
        if port.to == self.last:
            return
        due = self.time + port.delay
        self.last = port.to
        self.queue = [order for order in self.queue if order[0] < due] + [(due, port.to)]
        self.events.append((self.time, "port", i))

    def carry_out(self) -> None:
        while self.queue and self.queue[0][0] <= self.time:
            before, self.state = self.state, self.queue.pop(0)[1]
            if self.state != before:
                self.events.append((self.time, "valve", self.state))

    def piece(self) -> Piece:
        own = self.own
        return Piece(self.valve.force(self.state), own.omega, own.damping, own.driven, self.place, self.speed)

    def held(self, flight: float) -> bool:
        """Whether the force holds the bar on the wall after a flight shorter than a contact takes by that law."""
        own, contact = self.own, self.machine.contact
        if contact.keeps_strain or not 0.0 < contact.restitution < 1.0:
            return False
        pushed = self.valve.force(self.state) * own.driven[0] - own.omega[0] ** 2 * self.place[0]
        wave = 2.0 / self.machine.body.s
        return flight < wave and 0.0 <= -2.0 * own.end[0] * self.speed[0] <= 1.001 * own.end[0] * pushed * wave

    def step(self, cap: float) -> bool:
        """On to the next event; whether there was one before `cap`."""
        piece, horizon = self.piece(), min(self.queue[0][0] if self.queue else math.inf, cap) - self.time
        force = max(abs(piece.force), 1e-3)
        near = min((port.behind for port in self.valve.ports if port.behind), default=1.0)
        width = FINE * min(1.0 / max(self.own.omega[-1], 1e-9), math.sqrt(near / force))
        wall = self.own.end
        watched = [(-1, lambda q, _: wall @ q)]
        watched += [
            (i, lambda q, v, i=i: self.off(i, q, v)) for i, p in enumerate(self.valve.ports) if p.on == "entering"
        ]
        begin, found = 0.0, None
        while begin < horizon and found is None:
            grid = np.linspace(begin, min(begin + GRID * width, horizon), GRID)
            found = self._first(piece, grid, watched, begin == 0.0)
            begin = grid[-1]
        if found is None and horizon + self.time >= cap:
            self.place, self.speed = (a[:, 0] for a in piece.at(horizon))
            self.time = cap
            return False
        tau, what = (horizon, None) if found is None else found
        self.place, self.speed = (a[:, 0] for a in piece.at(tau))
        if what is None:
            self.time = self.queue[0][0]
            self.carry_out()
            return True
        self.time += tau
        if what == -1:
            self.events.append((self.time, "impact", float(wall @ self.speed)))
            self.place[0] -= wall @ self.place / wall[0]
            self.speed = -self.machine.contact.restitution * self.speed
            if not self.machine.contact.keeps_strain:
                self.place = -self.machine.contact.restitution * self.place
            for i, port in enumerate(self.valve.ports):
                if port.on == "impact":
                    self.demand(i)
            flight, self.struck = self.time - self.struck, self.time
            if abs(wall @ self.speed) < SLOW or self.held(flight):
                self.ending = "nearly at rest"  # what follows is not this program's
                return False
        else:
            self.demand(what)
        self.carry_out()
        return True

    def _first(self, piece, grid, watched, at_begin):
        """Time and number of the first of the watched functions to rise through 0 on a grid; ports that matter only."""
        states = piece.at(grid)
        best = None
        for what, function in watched:
            if what >= 0 and self.valve.ports[what].to == self.last:
                continue
            values = np.asarray(function(*states))

            def value(t, function=function):
                return float(function(*piece.at(t))[0])

            if at_begin and abs(values[0]) < 1e-11:  # where the last event was
                values[0] = -1e-300 if value(1e-3 * grid[1]) < 0.0 else 1e-300
            up = np.flatnonzero((values[:-1] < 0.0) & (values[1:] >= 0.0))
            tops = (
                np.flatnonzero((values[1:-1] > values[:-2]) & (values[1:-1] >= values[2:]) & (values[1:-1] < 0.0)) + 1
            )
            tops = tops[
                values[tops] > -np.abs(values[tops] - values[tops - 1]) - np.abs(values[tops] - values[tops + 1])
            ]
            times = []
            for k in tops.tolist():
                top = minimize_scalar(lambda t: -value(t), bounds=(grid[k - 1], grid[k + 1]), method="bounded",
                                      options={"xatol": 1e-12 * grid[k]})  # fmt: skip
                if top.fun < 0.0:
                    times.append(brentq(value, grid[k - 1], top.x, xtol=1e-15, rtol=1e-14))
            if up.size:
                k = int(up[0])
                low = grid[k] if values[k] < -1e-200 else 1e-3 * grid[1]
                times.append(brentq(value, low, grid[k + 1], xtol=1e-15, rtol=1e-14))
            if times and (best is None or min(times) < best[0]):
                best = (min(times), what)
        return best

    def run(self, cap: float, most: int) -> None:
        """Up to so many events, or to a time."""
        while len(self.events) < most and self.step(cap):
            pass
