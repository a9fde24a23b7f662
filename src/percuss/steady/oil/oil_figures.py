"""What the cycle of a machine tells whose oil flows: chamber pressures, closed forms, what lifts the piston."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from percuss.mechanics import oil_records as kn
from percuss.mechanics.oil import oil_machine
from percuss.model import Machine
from percuss.steady.oil.oil_cycle import OilFlight
from percuss.steady.self_excited.valve_cycle import ValveCycle

_LOOKS = 200  # times of a flight
_GAUSS = np.polynomial.legendre.leggauss(12)


# ---- The pressures of the chambers


class ChamberPressure(NamedTuple):
    """The least and the greatest pressure of a chamber over a cycle, in multiples of that of the states."""

    chamber: str
    least: float
    greatest: float


def chamber_pressures(cycle: ValveCycle) -> tuple[ChamberPressure, ...]:
    """Of every chamber of oil, at many times of each flight; empty without chambers."""
    oil = cycle.valve.oil
    if oil is None:
        return ()
    found = {one.name: (math.inf, -math.inf) for one in oil.chambers}
    for flight, since, before in _flown(cycle):
        t = np.linspace(0.0, flight.duration, _LOOKS)
        bar, pressure, _ = flight.looked(t)
        speed = flight.modes.driven @ bar[1]
        part = np.ones_like(t) if oil.spool == 0.0 else np.minimum((since + t) / oil.spool, 1.0)
        for one in oil.chambers:
            flow, seen = one.sign * one.area * speed, 0.0 * t
            for state, weight in ((before, 1.0 - part), (flight.state, part)):
                join = next((own for own in oil.joined(state) if own.chamber == one.name), None)
                if join is not None:
                    line = pressure if join.to == "supply" else oil.tank
                    loss = np.where(flow > 0.0, join.inward, join.outward) * flow * np.abs(flow)
                    seen = seen + weight * (line - loss)
            low, high = found[one.name]
            found[one.name] = min(low, float(seen.min())), max(high, float(seen.max()))
    return tuple(ChamberPressure(name, *ends) for name, ends in found.items())


def _flown(cycle: ValveCycle) -> Iterator[tuple[OilFlight, float, str]]:
    """The flights with what has gone since the last change of the state, and the state before."""
    flights = [one for one in cycle.flights if isinstance(one, OilFlight)]
    changes = [(s.time - cycle.period, s.to) for s in cycle.switches] + [(s.time, s.to) for s in cycle.switches]
    for flight in flights:
        past = [change for change in changes if change[0] <= flight.time + 1e-12 * cycle.period]
        since = flight.time - past[-1][0] if past else math.inf
        yield flight, since, past[-2][1] if len(past) > 1 else flight.state


# ---- Checks by closed forms


class Check(NamedTuple):
    """A number of the answer, and what a closed form gives."""

    name: str
    found: float
    expected: float

    @property
    def off(self) -> float:
        """Relative difference."""
        return abs(self.found / self.expected - 1.0) if self.expected else abs(self.found)


def oil_checks(cycle: ValveCycle) -> tuple[Check, ...]:
    """The closed forms that hold for a cycle: of multipliers by the path, of blow speed and period of the simplest one.

    The product of the multipliers of a rigid piston whose ports have no delay, and whose spool takes no time, is
    R² exp(−dT − 2Σβℓ − ∫(G + k_r[open] − dQ_p/dP)/C dt) (docs/oil.md, section 4).
    """
    oil, valve = cycle.oil, cycle.valve
    delays = any(port.delay for port in valve.ports) or (valve.oil is not None and valve.oil.spool)
    held = valve.supply is not None and valve.supply.relief is not None and valve.supply.relief.slope is None
    if oil is None or cycle.modes or cycle.blows > 1 or cycle.rests or delays or held:
        return ()
    fed = valve.supply is not None
    product = float(np.real(np.prod(np.linalg.eigvals(cycle.slope)))) if fed else float(cycle.slope[0, 0])
    factor = cycle.contact.velocity_factor
    name = "product of the multipliers, by the path" if fed else "multiplier, by the path"
    found = [Check(name, product, factor * factor * math.exp(-_decay(cycle)))]
    closed = closed_form(cycle.machine)
    if closed is not None:
        speed, period = closed
        found += [Check("blow speed", cycle.blow_speed, speed), Check("period", cycle.period, period)]
    return tuple(found)


def _decay(cycle: ValveCycle) -> float:
    """d T + 2 Σ β ℓ + ∫ (G + k_r[open] − dQ_p/dP)/C dt over a cycle, by Gauss's rule on each step."""
    machine, x, weights = cycle.machine, *_GAUSS
    numbers, supply = oil_machine(machine, 0), cycle.valve.supply
    leak = 0.0 if cycle.valve.oil is None else cycle.valve.oil.leakage
    total = float(numbers.own.damping[0]) * cycle.period
    for flight in cycle.flights:
        assert isinstance(flight, OilFlight)
        for i, step in enumerate(flight.steps):
            h = step[1]
            bar, pressure, _ = OilFlight(
                modes=flight.modes, begin=flight.begin, force=0.0, duration=h, state=flight.state, last=flight.last,
                time=float(step[0]), numbers=numbers, steps=flight.steps[i : i + 1],
            ).looked(0.5 * h * (x + 1.0))  # fmt: skip
            drag = step[kn.STEP + (kn.DRAG_OUT if step[3] > 0.0 else kn.DRAG_BACK)]
            rate = 2.0 * drag * np.abs(bar[1, 0])
            if supply is not None:
                slip = supply.power / pressure**2 if step[6] and supply.power else supply.slip + 0.0 * pressure
                relief = supply.relief.slope if step[4] == kn.OPENED and supply.relief else 0.0
                capacity = np.array([supply.capacity(float(p)) if step[5] else supply.compliance for p in pressure])
                rate = rate + (leak + slip + (relief or 0.0)) / capacity
            total += 0.5 * h * float(weights @ rate)
    return total


def closed_form(machine: Machine) -> tuple[float, float] | None:
    """Blow speed and period of the machine of two states at a constant pressure, without delay; None for any other.

    The blow sends the piston back, a port at S gives the power; no gas that yields, no drag but the orifices
    (docs/oil.md, section 3): w = (a_p/β₊)(1 − exp(−2β₊X)), X = S + ln(1 + β₋w_S/a_p)/(2β₋).
    """
    valve, oil, R = machine.valve, machine.valve.oil, -machine.contact.velocity_factor
    if oil is None or oil.spool or valve.supply is not None or valve.chamber.stiffness or machine.drag:
        return None
    if len(valve.pairs) != 2 or len(valve.ports) != 2 or any(port.delay for port in valve.ports):
        return None
    back = next((port for port in valve.ports if port.side == "back" and port.behind is not None), None)
    blow = next((port for port in valve.ports if port.on == "impact"), None)
    if back is None or blow is None or back.behind is None or back.to == blow.to:
        return None
    a_r, a_p = (valve.force(to) + oil.force + oil.tank * oil.areas(to, "tank") for to in (blow.to, back.to))
    if not a_p > 0.0 > a_r:
        return None
    (_, b_r), (b_p, b_m), a_r, S = oil.drag(blow.to), oil.drag(back.to), -a_r, back.behind
    w = 2.0 * a_p * S
    for _ in range(2000):
        w_s = _away(R * R * w, a_r, b_r, S)
        X = S + (math.log1p(b_m * w_s / a_p) / (2.0 * b_m) if b_m else w_s / (2.0 * a_p))
        new = a_p / b_p * -math.expm1(-2.0 * b_p * X) if b_p else 2.0 * a_p * X
        if abs(new - w) <= 1e-16 * new:
            break
        w = new
    v, v_s = math.sqrt(w), math.sqrt(w_s)
    c_r, c_m, c_p = (math.sqrt(a * b) for a, b in ((a_r, b_r), (a_p, b_m), (a_p, b_p)))
    out = (_artanh(v_s, math.sqrt(a_r / b_r), R * v) / c_r) if b_r else (v_s - R * v) / a_r
    turn = math.atan(v_s * math.sqrt(b_m / a_p)) / c_m if b_m else v_s / a_p
    stroke = math.atanh(v * math.sqrt(b_p / a_p)) / c_p if b_p else v / a_p
    return v, out + turn + stroke


def _away(w: float, a: float, b: float, way: float) -> float:
    """w = v² after a way under the acceleration a and the drag b w."""
    return w + 2.0 * a * way if b == 0.0 else a / b + (w - a / b) * math.exp(-2.0 * b * way)


def _artanh(fast: float, limit: float, slow: float) -> float:
    """artanh(fast/limit) − artanh(slow/limit), also where both are above the limit."""
    one, other = fast / limit, slow / limit
    return 0.5 * math.log(((1.0 + one) * (1.0 - other)) / ((1.0 - one) * (1.0 + other)))


# ---- What lifts the piston off the wall


class Lift(NamedTuple):
    """The pressure that lifts the piston off the wall, and what the supply comes to while it lies there."""

    needed: float
    reached: float
    limited_by: str

    @property
    def lifts(self) -> bool:
        """Whether the piston leaves the wall."""
        return self.reached > self.needed


def lift_of(machine: Machine) -> Lift | None:
    """P_min of the state that returns, and the pressure at which leakage, slip and relief take all that is pumped."""
    valve, oil = machine.valve, machine.valve.oil
    pull, back = min((force, name) for name, force in valve.pairs)
    if pull >= 0.0:
        return None
    tank = 0.0 if oil is None else oil.force + oil.tank * oil.areas(back, "tank")
    needed = max((valve.chamber.force + tank) / -pull, 0.0)
    supply = valve.supply
    if supply is None:
        return Lift(needed, 1.0, "the pressure, which is constant")
    leak = 0.0 if oil is None else oil.leakage
    relief = supply.relief

    def surplus(pressure: float) -> float:
        flow = supply.flow - supply.slip * pressure
        if supply.power is not None:
            flow = min(flow, supply.power / pressure)
        flow -= leak * pressure
        if relief is not None and relief.slope is not None:
            flow -= relief.slope * max(pressure - relief.pressure, 0.0)
        return flow

    low, high = 0.0, 1.0
    ceiling = math.inf if relief is None or relief.slope is not None else relief.pressure
    while surplus(high) > 0.0 and high < min(ceiling, 1e6):
        low, high = high, 2.0 * high
    if high >= min(ceiling, 1e6) and surplus(min(high, ceiling)) > 0.0:
        return Lift(needed, min(ceiling, math.inf), "the relief valve" if ceiling < math.inf else "nothing")
    for _ in range(200):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if surplus(middle) > 0.0 else (low, middle)
    by_relief = relief is not None and low > relief.pressure
    return Lift(needed, low, "the relief valve" if by_relief else "the leakage" if leak else "the power of the pump")


def path_losses(cycle: ValveCycle) -> dict[str, float]:
    """The losses of a cycle by name; together they are its input."""
    oil = cycle.oil
    assert oil is not None
    chambers = [] if cycle.valve.oil is None else [one.name for one in cycle.valve.oil.chambers]
    found = {f"orifice_{name}": loss for name, loss in zip(chambers, oil.orifices, strict=True)}
    return found | {
        "leakage": oil.leakage, "relief": oil.relief, "return_line": oil.return_line, "drag": oil.drag,
        "impact": oil.impact,
    }  # fmt: skip


def duty_of(cycle: ValveCycle) -> float | None:
    """The part of the period from the change to the state that pushes most to the one that follows."""
    strongest = max(cycle.valve.pairs, key=lambda pair: pair[1])[0]
    changes = sorted((one.time, one.to) for one in cycle.switches)
    rises = [time for time, to in changes if to == strongest]
    falls = [time for time, to in changes if to != strongest]
    if not rises or not falls:
        return None
    begun = rises[-1]
    ends = [time if time > begun else time + cycle.period for time in falls]
    return (min(ends) - begun) / cycle.period


def relief_margin(cycle: ValveCycle) -> float | None:
    """How far the greatest pressure is from the relief valve, as a part of it; negative where that opens."""
    supply = cycle.valve.supply
    if supply is None or supply.relief is None or cycle.oil is None:
        return None
    return 1.0 - cycle.oil.greatest / supply.relief.pressure


def precharge_margin(cycle: ValveCycle) -> float | None:
    """How far the least pressure is above the precharge, as a part of it; negative where the accumulator empties."""
    supply = cycle.valve.supply
    if supply is None or supply.gas is None or cycle.oil is None:
        return None
    return cycle.oil.least / supply.gas.precharge - 1.0
