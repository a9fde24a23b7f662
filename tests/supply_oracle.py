"""A second program for the rigid piston, whether its pressure follows a supply: integration, and the rules again."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np
from scipy.integrate import solve_ivp

from percuss.model import Valve
from percuss.model.load.valve import Orders


@dataclass
class Fed:
    """Where the piston is, its valve and its supply; `pumped` is the work of the pump, `dragged` what the drag took."""

    u: float
    v: float
    pressure: float
    state: str
    orders: Orders
    time: float = 0.0
    pumped: float = 0.0
    dragged: float = 0.0
    least: float = math.inf
    events: list[tuple[float, str, float | str]] = field(default_factory=list)
    ending: str = ""


def begun(valve: Valve, u: float, v: float, pressure: float = 1.0) -> Fed:
    """A start, where ports whose region is occupied demand at once."""
    now = Fed(u, v, pressure, valve.start, Orders(valve.start))
    for i, port in enumerate(valve.ports):
        if port.on == "entering" and (u < -port.behind if port.side == "back" else u > -port.behind):
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


def strike(now: Fed, valve: Valve, R: float) -> None:
    """A blow, and what it demands."""
    now.events.append((now.time, "impact", now.v))
    now.u, now.v = 0.0, -R * now.v
    for i, port in enumerate(valve.ports):
        if port.on == "impact":
            demand(now, valve, i)


def follow(now: Fed, valve: Valve, R: float, d: float, blows: float, until: float = math.inf) -> Fed:
    """On for so many blows, by plain integration."""
    forces, gas, kappa = dict(valve.states), valve.chamber.force, valve.chamber.stiffness
    q, c = (valve.supply.flow, valve.supply.compliance) if valve.supply else (0.0, math.inf)
    left, longest = blows, 0.25 * math.sqrt(min(p.behind or 1.0 for p in valve.ports))
    while left and now.time < until:
        carry_out(now)
        p = forces[now.state]
        due = now.orders.pending[0][0] if now.orders.pending else math.inf
        push = p * now.pressure + gas
        if now.u == 0.0 and now.v == 0.0 and push > 0.0:
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
            u, v, pi, _, _ = z
            return [v, p * pi + gas - kappa * u - d * v, (q - p * v) / c, q * pi, d * v * v]

        def wall(_t, z):
            return z[0]

        wall.direction, wall.terminal = 1.0, True
        watched, numbers = [wall], [-1]
        for i, port in enumerate(valve.ports):
            if port.on == "entering":

                def edge(_t, z, h=port.behind):
                    return z[0] + h

                edge.direction, edge.terminal = (-1.0 if port.side == "back" else 1.0), True
                watched.append(edge)
                numbers.append(i)
        start = [now.u, now.v, now.pressure, 0.0, 0.0]
        stop = min(due, until, now.time + longest)
        found = solve_ivp(
            rates, (now.time, stop), start, "DOP853", events=watched, rtol=1e-12, atol=1e-14, max_step=0.05 * longest
        )
        now.least = min(now.least, float(found.y[2].min()))
        which = [i for i, times in enumerate(found.t_events) if times.size]
        now.time = float(found.t[-1])
        now.u, now.v, now.pressure = map(float, found.y[:3, -1])
        now.pumped += float(found.y[3, -1])
        now.dragged += float(found.y[4, -1])
        if due <= now.time:
            now.time = due
        if which:
            first = min(which, key=lambda i: found.t_events[i][0])
            if numbers[first] < 0:
                left -= 1
                strike(now, valve, R)
            else:
                demand(now, valve, numbers[first])
                nudge(now, valve, d)
        if now.pressure < 0.0:
            now.ending = "no pressure"
            return now
    return now


def nudge(now: Fed, valve: Valve, d: float) -> None:
    """Off the edge of a port, whose function is 0 there, by a flight so short that its series has three terms."""
    q, c = (valve.supply.flow, valve.supply.compliance) if valve.supply else (0.0, math.inf)
    force = dict(valve.states)[now.state]
    step = min([1e-8, *(due - now.time for due, _ in now.orders.pending)])
    push = force * now.pressure + valve.chamber.force - valve.chamber.stiffness * now.u - d * now.v
    now.pumped += q * now.pressure * step
    now.pressure += (q - force * (now.v + 0.5 * push * step)) * step / c
    now.dragged += d * now.v**2 * step
    now.u, now.v, now.time = now.u + (now.v + 0.5 * push * step) * step, now.v + push * step, now.time + step


def stored(now: Fed, valve: Valve) -> float:
    """Energy of the piston, of the gas and of the accumulator."""
    gas = 0.5 * valve.chamber.stiffness * now.u**2 - valve.chamber.force * now.u
    return 0.5 * now.v**2 + gas + 0.5 * valve.supply.compliance * now.pressure**2


def after_cycle(valve: Valve, R: float, d: float, numbers: np.ndarray, state: str, orders: Orders) -> np.ndarray:
    """Speed, times of the pending orders and pressure just after the next blow, from those after one."""
    speed, *dues, pressure = numbers.tolist()
    pending = tuple((due, to) for due, (_, to) in zip(dues, orders.pending, strict=True))
    now = Fed(0.0, -speed, pressure, state, Orders(orders.last, pending))
    for i, port in enumerate(valve.ports):
        if port.on == "impact":
            demand(now, valve, i)
    entering = tuple(port for port in valve.ports if port.on != "impact")  # what the blow demands is the next cycle's
    ends = follow(now, replace(valve, ports=entering), R, d, 1)
    return np.array([-ends.v, *(due - ends.time for due, _ in ends.orders.pending), ends.pressure])
