"""A second program for the piston under a valve: numerical integration with events, and the rules again."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from scipy.integrate import solve_ivp

from percuss.model import Valve


@dataclass
class Record:
    """What happened: (time, kind, detail) with the kinds port, valve, impact, rest, release; and the end."""

    events: list[tuple[float, str, float | str]] = field(default_factory=list)
    ending: str = ""

    def of(self, kind: str) -> list[tuple[float, float | str]]:
        return [(time, detail) for time, own, detail in self.events if own == kind]


def simulated(valve: Valve, R: float, d: float, u: float, v: float, until: float) -> Record:
    """From u (negative behind the wall) and v (positive towards it), by plain integration."""
    forces = dict(valve.states)
    gas, kappa = valve.chamber.force, valve.chamber.stiffness
    ports = valve.ports
    now, state, last, queue, record = 0.0, valve.start, valve.start, [], Record()

    def demand(number: int) -> None:
        nonlocal last, queue
        port = ports[number]
        if port.to == last:
            return
        last = port.to
        queue = [order for order in queue if order[0] < now + port.delay] + [(now + port.delay, port.to)]
        record.events.append((now, "port", number))

    for i, port in enumerate(ports):
        if port.on == "entering" and (u < -port.behind if port.side == "back" else u > -port.behind):
            demand(i)
    lying = False
    while now < until:
        while queue and queue[0][0] <= now:
            state = queue.pop(0)[1]
            record.events.append((now, "valve", state))
        p = forces[state] + gas
        if u == 0.0 and abs(v) < 1e-9 and p >= 0.0:
            if not lying:
                record.events.append((now, "rest", 0.0))
            lying = True
            if not queue:
                record.ending = "on the wall"
                return record
            now, v = queue[0][0], 0.0
            continue
        if lying:
            record.events.append((now, "release", 0.0))
        lying = False
        stop = min(until, queue[0][0] if queue else math.inf)

        def wall(_t, z, *_):
            return z[0]

        wall.direction, wall.terminal = 1.0, True
        watched = [wall]
        for port in ports:
            if port.on == "entering":

                def edge(_t, z, h=port.behind):
                    return z[0] + h

                edge.direction, edge.terminal = (-1.0 if port.side == "back" else 1.0), True
                watched.append(edge)
        tiny, away = 0.0, p - kappa * u - d * v
        if u > -1e-300 or any(
            u == -port.behind for port in ports if port.behind
        ):  # off the place of the last event, whose function is 0 there, by a flight too short to matter
            tiny = 1e-7 * min(1.0, abs(v) or 1.0, stop - now)
        start = np.array([u + v * tiny + 0.5 * away * tiny**2, v + away * tiny])
        done = solve_ivp(
            lambda _t, z, p=p: [z[1], p - kappa * z[0] - d * z[1]],
            (now + tiny, stop), start, "DOP853", events=watched, rtol=3e-13, atol=1e-13,
            max_step=0.25,
        )  # fmt: skip
        fired = [i for i, times in enumerate(done.t_events) if times.size]
        u, v, now = float(done.y[0, -1]), float(done.y[1, -1]), float(done.t[-1])
        if fired and fired[0] == 0:
            u = 0.0
            record.events.append((now, "impact", v))
            v *= -R
            for i, port in enumerate(ports):
                if port.on == "impact":
                    demand(i)
        elif fired:
            entered = [i for i, port in enumerate(ports) if port.on == "entering"]
            u = -ports[entered[fired[0] - 1]].behind
            for own in fired:
                demand(entered[own - 1])
    record.ending = "until"
    return record
