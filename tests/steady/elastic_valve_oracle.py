"""A second program for the elastic machine: B77's modal equations integrated from blow to blow, and the rules again."""

from __future__ import annotations

import math

import numpy as np
from scipy.integrate import solve_ivp

from percuss.model import Machine


def of_modes(machine: Machine, begin: np.ndarray) -> np.ndarray:
    """B77's u_0 … u_N, u_0' … u_N' of a uniform bar, from the coordinates of a machine; shape (2N + 2,)."""
    N = begin.shape[0] - 1
    own = machine.modes(N).mixing @ begin
    own[1:] *= ((-1.0) ** np.arange(1, N + 1) / math.sqrt(2.0))[:, None]
    return own.T.reshape(-1)


def one_cycle(
    machine: Machine, z: np.ndarray, state: str, last: str, pending: list[tuple[float, str]], blows: int = 1
) -> tuple[float, np.ndarray, str, list[tuple[float, str]]]:
    """Time of the blow, u and u' just after it, state and orders there; from just after the blow at time 0."""
    N = z.size // 2 - 1
    valve, body = machine.valve, machine.body
    forces, gas = dict(valve.states), valve.chamber
    n = np.arange(N + 1)
    omega = n * math.pi * body.s
    damping = np.concatenate([[body.damping.rigid], body.damping.of(omega[1:])])
    weights = np.where(n == 0, 1.0, 2.0)
    end = weights * (-1.0) ** n
    now, queue, time = z.astype(float), list(pending), 0.0
    x_of = slice(N + 1, None), slice(N + 1)  # speeds and places

    def row(port):
        return np.where(n == 0, 1.0, 0.0) if port.reads == "centre" else weights * np.cos(n * math.pi * port.reads)

    def demand(port):
        nonlocal last, queue
        if port.to != last:
            last = port.to
            queue = [order for order in queue if order[0] < time + port.delay] + [(time + port.delay, port.to)]

    def blow_demands():
        for port in valve.ports:
            if port.on == "impact":
                demand(port)

    def rates(_t, x):
        u, v = x[: N + 1], x[N + 1 :]
        push = forces[state] + gas.force - gas.stiffness * float(weights @ u)
        return np.concatenate([v, push - damping * v - omega**2 * u])

    blow_demands()
    for _ in range(60):
        while queue and queue[0][0] <= time + 1e-15:
            state = queue.pop(0)[1]
        entering = [port for port in valve.ports if port.on == "entering" and port.to != last]
        watched = [lambda _t, x: float(end @ x[: N + 1])]
        watched[0].direction, watched[0].terminal = 1.0, True
        for port in entering:
            own = row(port)

            def edge(_t, x, own=own, part=x_of[port.speed is None], level=port.level):
                return float(own @ x[part]) - level

            edge.direction, edge.terminal = (-1.0 if port.side == "back" else 1.0), True
            watched.append(edge)
        stop = queue[0][0] if queue else time + 50.0
        tiny = 1e-6 * (stop - time) if time == 0.0 else 0.0  # off the wall, before anything is watched
        if tiny:
            off = solve_ivp(rates, (time, time + tiny), now, "DOP853", rtol=1e-13, atol=1e-15)
            now, time = off.y[:, -1], time + tiny
        done = solve_ivp(rates, (time, stop), now, "DOP853", events=watched, rtol=1e-12, atol=1e-14)
        now, time = done.y[:, -1], float(done.t[-1])
        fired = [i for i, times in enumerate(done.t_events) if times.size]
        if fired and fired[0] == 0:
            blows -= 1
            u, v = now[: N + 1], machine.contact.velocity_factor * now[N + 1 :]
            kept = machine.contact.strain_factor
            moved = (1.0 - kept) * float(end[1:] @ u[1:])
            now = np.concatenate([[u[0] + moved], kept * u[1:], v])
            if blows == 0:
                return time, now, state, [(due - time, to) for due, to in queue]
            blow_demands()
        elif fired:
            demand(entering[fired[0] - 1])
    raise AssertionError("no blow")
