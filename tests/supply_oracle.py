"""A second program for a piston, rigid or not, whether its pressure follows a supply: integration, and the rules."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np
from scipy.integrate import solve_ivp

from percuss.model import Machine, Valve
from percuss.model.load.valve import Orders


class Piston(NamedTuple):
    """Frequencies of its motions of modal mass 1, of which the first moves it as a whole, and their ends; (N+1,)."""

    omega: np.ndarray
    end: np.ndarray
    driven: np.ndarray


RIGID = Piston(np.zeros(1), np.ones(1), np.ones(1))


def piston(machine: Machine, modes: int) -> Piston:
    own = machine.body.modes(modes, machine.at)
    return Piston(np.append(0.0, own.omega), np.append(1.0, own.end), np.append(1.0, own.end * own.at_load))


@dataclass
class Fed:
    """Where the piston is, its valve and its supply; `pumped` is the work of the pump, `dragged` what the drag took."""

    u: np.ndarray
    v: np.ndarray
    pressure: float
    state: str
    orders: Orders
    time: float = 0.0
    pumped: float = 0.0
    dragged: float = 0.0
    least: float = math.inf
    events: list[tuple[float, str, float | str]] = field(default_factory=list)
    ending: str = ""


def begun(valve: Valve, u: float, v: float, pressure: float = 1.0, modes: int = 0) -> Fed:
    """An undeformed start, where ports whose region is occupied demand at once."""
    one = np.eye(1, modes + 1)[0]
    now = Fed(u * one, v * one, pressure, valve.start, Orders(valve.start))
    for i, port in enumerate(valve.ports):
        if port.on == "entering" and port.sign * ((u if port.speed is None else v) - port.level) > 0.0:
            demand(now, valve, i)
    return now


def demand(now: Fed, valve: Valve, number: int) -> None:
    before, now.orders = now.orders, now.orders.after(now.time, valve.ports[number])
    if now.orders is not before:
        now.events.append((now.time, "port", number))
    carry_out(now)


def carry_out(now: Fed) -> None:
    while now.orders.pending and now.orders.pending[0][0] <= now.time:
        now.state = now.orders.pending[0][1]
        now.orders = Orders(now.orders.last, now.orders.pending[1:])
        now.events.append((now.time, "valve", now.state))


def strike(now: Fed, valve: Valve, R: float, bar: Piston, turned: bool) -> None:
    """A blow, and what it demands; `turned`: the strain as well."""
    now.events.append((now.time, "impact", float(bar.end @ now.v)))
    now.u[0] = -float(bar.end[1:] @ now.u[1:])
    now.u, now.v = (-R * now.u if turned else now.u), -R * now.v
    for i, port in enumerate(valve.ports):
        if port.on == "impact":
            demand(now, valve, i)


def follow(
    now: Fed,
    valve: Valve,
    R: float,
    d: float,
    blows: float,
    until: float = math.inf,
    bar: Piston = RIGID,
    turned: bool = False,
) -> Fed:
    """On for so many blows, by plain integration."""
    n = bar.omega.size
    forces, gas, kappa = dict(valve.states), valve.chamber.force, valve.chamber.stiffness
    q, c = (valve.supply.flow, valve.supply.compliance) if valve.supply else (0.0, math.inf)
    left, longest = blows, 0.25 * math.sqrt(min(p.behind or 1.0 for p in valve.ports))
    while left and now.time < until:
        carry_out(now)
        p = forces[now.state]
        due = now.orders.pending[0][0] if now.orders.pending else math.inf
        push = p * now.pressure + gas
        if not now.u.any() and not now.v.any() and push > 0.0:
            rises = math.inf if p >= 0.0 or q == 0.0 else (-gas / p - now.pressure) * c / q
            stop = min(due, now.time + rises, until)
            if stop == math.inf:
                now.ending = "on the wall"
                return now
            stay = stop - now.time
            now.pumped += q * stay * (now.pressure + 0.5 * q * stay / c)
            now.pressure += q * stay / c
            if stop == now.time + rises:
                now.pressure *= 1.0 + 1e-14
            now.time = stop
            continue

        def rates(_t, z, p=p):
            u, v, pi = z[:n], z[n : 2 * n], z[2 * n]
            push = p * pi + gas - kappa * (bar.driven @ u)
            drawn = (q - p * (bar.driven @ v)) / c
            return np.concatenate([v, bar.driven * push - bar.omega**2 * u - d * v, [drawn, q * pi, d * v @ v]])

        def wall(_t, z):
            return bar.end @ z[:n]

        wall.direction, wall.terminal = 1.0, True
        watched, numbers = [wall], [-1]
        for i, port in enumerate(valve.ports):
            if port.on == "entering":

                def edge(_t, z, at=0 if port.speed is None else n, level=port.level):
                    return z[at] - level

                edge.direction, edge.terminal = (-1.0 if port.side == "back" else 1.0), True
                watched.append(edge)
                numbers.append(i)
        start = np.concatenate([now.u, now.v, [now.pressure, 0.0, 0.0]])
        stop, step = min(due, until, now.time + longest), 0.05 * longest
        if n > 1:
            step = min(step, 0.3 / bar.omega[-1])  # no event between two steps
        found = solve_ivp(
            rates, (now.time, stop), start, "DOP853", events=watched, rtol=1e-12, atol=1e-14, max_step=step
        )
        now.least = min(now.least, float(found.y[2 * n].min()))
        which = [i for i, times in enumerate(found.t_events) if times.size]
        now.time = float(found.t[-1])
        now.u, now.v, now.pressure = found.y[:n, -1], found.y[n : 2 * n, -1], float(found.y[2 * n, -1])
        now.pumped += float(found.y[2 * n + 1, -1])
        now.dragged += float(found.y[2 * n + 2, -1])
        if due <= now.time:
            now.time = due
        if which:
            first = min(which, key=lambda i: found.t_events[i][0])
            if numbers[first] < 0:
                left -= 1
                strike(now, valve, R, bar, turned)
            else:
                demand(now, valve, numbers[first])
                nudge(now, valve, d, bar)
        if now.pressure < 0.0:
            now.ending = "no pressure"
            return now
    return now


def nudge(now: Fed, valve: Valve, d: float, bar: Piston) -> None:
    """Off the edge of a port, whose function is 0 there, by a flight so short that its series has three terms."""
    q, c = (valve.supply.flow, valve.supply.compliance) if valve.supply else (0.0, math.inf)
    force, gas = dict(valve.states)[now.state], valve.chamber
    step = min([1e-8, *(due - now.time for due, _ in now.orders.pending)])
    push = bar.driven * (force * now.pressure + gas.force - gas.stiffness * (bar.driven @ now.u))
    push = push - bar.omega**2 * now.u - d * now.v
    way = (now.v + 0.5 * push * step) * step
    now.pumped += q * now.pressure * step
    now.pressure += (q * step - force * (bar.driven @ way)) / c
    now.dragged += d * float(now.v @ now.v) * step
    now.u, now.v, now.time = now.u + way, now.v + push * step, now.time + step


def after_cycle(valve: Valve, R: float, d: float, numbers: np.ndarray, state: str, orders: Orders) -> np.ndarray:
    """Speed, times of the pending orders and pressure just after the next blow, from those after one."""
    speed, *dues, pressure = numbers.tolist()
    pending = tuple((due, to) for due, (_, to) in zip(dues, orders.pending, strict=True))
    now = Fed(np.zeros(1), np.array([-speed]), pressure, state, Orders(orders.last, pending))
    for i, port in enumerate(valve.ports):
        if port.on == "impact":
            demand(now, valve, i)
    entering = tuple(port for port in valve.ports if port.on != "impact")  # what the blow demands is the next cycle's
    ends = follow(now, replace(valve, ports=entering), R, d, 1)
    return np.array([-ends.v[0], *(due - ends.time for due, _ in ends.orders.pending), ends.pressure])
