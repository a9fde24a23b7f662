"""A machine whose oil flows, on its way from event to event: the tables of its kernel, its starts and what it records.

The equations, per unit of mass (`docs/oil.md`, section 1): the coordinates of the bar move under the force of the
chambers, of the gas and of what drives them, and the pressure P of the supply obeys

    C(P) P′ = Q_p(P) − a_k v − G P − k_r (P − P_r)₊.

All its motions, steady or followed from a start, are made of these steps.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cache, cached_property, lru_cache, partial
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from percuss.errors import PercussError
from percuss.halting import check_interrupted
from percuss.mechanics import oil_records as kn
from percuss.mechanics.kernel_cache import ensure_cache
from percuss.model import Machine, MachineModes
from percuss.model.checks import Array
from percuss.model.load.valve import Orders
from percuss.model.machine import machine_modes

_STEPS = 1 << 12  # of a call
_EVENTS = 1 << 10
_QUEUE = 64
_IDLE = 400.0  # units of time without a blow after which a motion has ended
KINDS = {
    kn.IMPACT: "impact", kn.PORT_MET: "port", kn.VALVE: "valve", kn.REST: "rest", kn.LEAVES: "leaves",
    kn.OPENS: "relief opens", kn.CLOSES: "relief closes", kn.EMPTIES: "empty", kn.FILLS: "filled",
    kn.LIMITS: "power limit", kn.FULL_FLOW: "full flow", kn.DRY: "no pressure",
}  # fmt: skip
"""What the events are called."""


@cache
def oil_kernels() -> Any:
    """The compiled functions, which are loaded only when a motion is asked for."""
    ensure_cache()
    from percuss.mechanics import oil_kernels as kernels  # the compiler

    return kernels


class OilEvent(NamedTuple):
    """An event: the state of the bar just before it, (N + 1, 2), and the pressure; `detail` is a port or a state."""

    time: float
    kind: str
    detail: int
    state: Array
    pressure: float
    step: int


class OilBalance(NamedTuple):
    """Energies and volumes since the beginning, least and greatest pressure, and how far the bar went back.

    Volumes are multiplied by the pressure for which the states hold, so that they are energies as well.
    """

    input: float
    orifices: tuple[float, ...]
    leakage: float
    relief: float
    return_line: float
    drag: float
    impact: float
    pumped: float
    leaked: float
    relieved: float
    drawn: float
    pressed: float

    least: float
    greatest: float
    farthest: float

    @property
    def losses(self) -> float:
        """All but what the blows take."""
        return math.fsum([*self.orifices, self.leakage, self.relief, self.return_line, self.drag])


@dataclass(frozen=True)
class OilMachine:
    """The numbers of a machine, cut at N elastic modes, as its kernel has them; see `oil_machine`."""

    machine: Machine
    modes: int

    @cached_property
    def own(self) -> MachineModes:
        """The free motions of the body, of which no gas is a part."""
        return machine_modes(self.machine.body, self.machine.at, 0.0, self.modes)

    @cached_property
    def names(self) -> list[str]:
        """Of the states."""
        return [name for name, _ in self.machine.valve.pairs]

    @property
    def fed(self) -> bool:
        """Whether the pressure follows the piston."""
        return self.machine.valve.supply is not None

    @cached_property
    def law(self) -> kn.OilLaw:
        """The tables of the kernel."""
        valve, own, oil = self.machine.valve, self.own, self.machine.valve.oil
        gas, supply, ports = valve.chamber, valve.supply, valve.ports
        g = np.zeros(kn.LAW)
        g[kn.FORCE] = (oil.force if oil else 0.0) + (gas.force if gas.exponent is None else 0.0)
        g[kn.KAPPA] = gas.stiffness if gas.exponent is None else 0.0
        g[kn.COLUMN] = 1.0
        if gas.exponent is not None:
            g[kn.GAS], g[kn.COLUMN], g[kn.EXPONENT] = gas.force, gas.column or 1.0, gas.exponent
        g[kn.TANK], g[kn.SPOOL], g[kn.LEAK] = (oil.tank, oil.spool, oil.leakage) if oil else (0.0, 0.0, 0.0)
        g[kn.FACTOR], g[kn.STRAIN] = self.machine.contact.velocity_factor, self.machine.contact.strain_factor
        g[kn.RELIEF] = g[kn.CORNER] = g[kn.CORNER_TO] = math.inf
        g[kn.POLYTROPIC] = 1.0
        if supply is not None:
            g[kn.FED], g[kn.FLOW], g[kn.SLIP], g[kn.COMPLIANCE] = 1.0, supply.flow, supply.slip, supply.compliance
            g[kn.QUICKENING] = supply.quickening
            if supply.relief is not None:
                slope = supply.relief.slope
                g[kn.RELIEF], g[kn.SLOPE] = supply.relief.pressure, math.inf if slope is None else slope
            if supply.gas is not None:
                g[kn.VOLUME], g[kn.PRECHARGE] = supply.gas.volume, supply.gas.precharge
                g[kn.ATMOSPHERE], g[kn.POLYTROPIC] = supply.gas.atmosphere, supply.gas.exponent
            if supply.power is not None:
                g[kn.POWER] = supply.power
                g[kn.CORNER], g[kn.CORNER_TO] = _corners(supply.flow, supply.slip, supply.power)
        g[kn.UNIT] = valve.time_unit
        push = max(abs(valve.force(name)) for name, _ in valve.pairs)
        g[kn.SPEED] = max(push * g[kn.UNIT], 1e-300)
        g[kn.WAVE] = (1.0 + 0.5 / max(self.modes, 1)) * self.machine.body.transit_time if self.modes else 0.0
        modes = np.array([own.omega**2, own.damping, own.driven, own.end])
        reads = np.array([
            own.centre if port.reads == "centre" or not self.modes
            else own.at(self.machine.body, np.array([port.reads]))[0]
            for port in ports
        ])  # fmt: skip
        table = np.array([
            [self.names.index(port.to), port.level, port.sign, port.delay, port.speed is not None, port.on == "impact"]
            for port in ports
        ], dtype=float)  # fmt: skip
        return kn.OilLaw(g, modes, reads, self._joins, table)

    @property
    def _joins(self) -> Array:
        valve = self.machine.valve
        oil, chambers = valve.oil, self.chambers
        rows = np.zeros((len(self.names), kn.CHAMBERS + 2 * len(chambers)))
        for row, (name, area) in zip(rows, valve.pairs, strict=True):
            row[kn.AREA] = area
            if oil is not None:
                row[kn.TANKED] = oil.areas(name, "tank")
                row[kn.DRAG_OUT], row[kn.DRAG_BACK] = oil.drag(name)
                for chamber, (out, back) in oil.losses(name).items():
                    first = kn.CHAMBERS + 2 * chambers.index(chamber)
                    row[first], row[first + 1] = out, back
        return rows

    @cached_property
    def idle(self) -> float:
        """How long a motion at a steady pressure may go without a blow."""
        return _IDLE * self.machine.valve.time_unit

    @property
    def chambers(self) -> list[str]:
        """Names of the chambers of oil."""
        oil = self.machine.valve.oil
        return [] if oil is None else [one.name for one in oil.chambers]

    @property
    def turn(self) -> Array:
        """What a blow multiplies displacements and velocities by."""
        return np.array([self.machine.contact.strain_factor, self.machine.contact.velocity_factor])


def _corners(flow: float, slip: float, power: float) -> tuple[float, float]:
    """Between which pressures the power limits the pump: where (Q_0 − g P) P = W."""
    if slip == 0.0:
        return power / flow, math.inf
    root = flow * flow - 4.0 * slip * power
    if root <= 0.0:
        return math.inf, math.inf
    low = 2.0 * power / (flow + math.sqrt(root))
    return low, power / (slip * low)


@lru_cache(maxsize=64)
def oil_machine(machine: Machine, modes: int) -> OilMachine:
    """The numbers of a machine, kept for its next motion."""
    return OilMachine(machine, modes)


@cache
def _collocation(q: int) -> tuple[Array, Array, Array]:
    """Gauss's nodes c and weights on (0, 1), (2, q), Lagrange's l_j(c_m c_p) as (m, p, j), and their ∫₀¹ dp."""
    if q == 0:
        return np.zeros((2, 0)), np.zeros((0, 0, 0)), np.zeros((0, 0))
    x, weights = np.polynomial.legendre.leggauss(q)
    c, of = 0.5 * (x + 1.0), partial(np.polynomial.legendre.legvander, deg=q - 1)
    parts = of(2.0 * np.outer(c, c) - 1.0) @ np.linalg.inv(of(x))
    return np.array([c, 0.5 * weights]), parts, np.einsum("p,mpj->mj", 0.5 * weights, parts)


@dataclass
class OilMotion:
    """A motion on its way, with its derivatives by D numbers of its start."""

    numbers: OilMachine
    state: kn.OilState
    work: kn.OilWork
    log: kn.OilLog
    events: list[OilEvent] = field(default_factory=list)
    steps: list[Array] = field(default_factory=list)

    @classmethod
    def begun(
        cls,
        numbers: OilMachine,
        bar: Array,
        pressure: float,
        state: str,
        orders: Orders,
        *,
        resting: bool = False,
        struck: bool = False,
        directions: int = 0,
        recorded: bool = False,
    ) -> OilMotion:
        """A motion put at a state: `bar`, (N + 1, 2), at time 0; `struck`: it has just left the wall."""
        made = cls._empty(numbers, _QUEUE + len(orders.pending), directions, recorded)
        state_of, last, now = numbers.names.index(state), numbers.names.index(orders.last), made.state.now
        now[kn.PRESSURE], now[kn.RESTING] = pressure, float(resting)
        now[kn.STATE], now[kn.LAST], now[kn.COUNT], now[kn.STROKE] = state_of, last, len(orders.pending), math.inf
        now[kn.HOLD] = -math.inf
        now[kn.AT_ZERO] = 1.0 if pressure == 0.0 else 0.0
        for i, (time, to) in enumerate(orders.pending):
            made.state.orders[i] = time, numbers.names.index(to)
        made.state.bar[:] = np.asarray(bar).T
        made.state.blend[0] = numbers.law.joins[state_of]
        made.state.sums[kn.LEAST] = made.state.sums[kn.GREATEST] = pressure
        oil_kernels().begun(numbers.law, made.state, made.work)
        if struck and not resting:
            now[kn.WALL] = 1.0 if float(numbers.own.end @ np.asarray(bar)[:, 1]) < 0.0 else 2.0
        return made

    @classmethod
    def _empty(cls, numbers: OilMachine, queue: int, D: int, recorded: bool) -> OilMotion:
        law, n = numbers.law, numbers.modes + 1
        width, size = law.joins.shape[1], 2 * n + 1
        order = (kn.ELASTIC_ORDER if numbers.modes else kn.ORDER) + 2
        q = 0 if D == 0 else kn.ELASTIC_NODES if numbers.modes else kn.NODES
        state = kn.OilState(
            np.zeros(kn.NOW), np.zeros((2, n)), np.zeros((2, width)), np.zeros((queue, 2)),
            np.zeros(law.ports.shape[0]), np.zeros(kn.ORIFICES + len(numbers.chambers)), np.zeros((size, D)),
            np.zeros((queue, D)), np.zeros((2, 4, D)), np.zeros(D),
        )  # fmt: skip
        work = kn.OilWork(
            np.zeros((kn.ROWS, order)), np.zeros((order, n)), np.zeros((order, n)), np.zeros((64, order)),
            np.zeros((64, 2)), np.zeros(size), np.zeros(size), np.zeros(D), *_collocation(q), np.zeros(2),
            np.zeros((2, q, 2 * n)), np.zeros((2, q, q)), np.zeros((4, n)), np.zeros((2, n, q)),
            np.zeros((2 * q, 2 * q)), np.zeros((2 * q, D)),
        )  # fmt: skip
        steps = np.zeros((_STEPS if recorded else 0, kn.STEP + 2 * width + 2 * n))
        return cls(numbers, state, work, kn.OilLog(np.zeros((_EVENTS, kn.EVENT + 2 * n)), steps, np.zeros(2, np.int64)))

    @classmethod
    def again(cls, numbers: OilMachine, state: kn.OilState, directions: int = 0, recorded: bool = False) -> OilMotion:
        """A motion from the state of another one on, with time, blows and sums from 0."""
        made = cls._empty(numbers, max(_QUEUE, state.orders.shape[0]), directions, recorded)
        fresh = made.state
        for name in ("now", "bar", "blend", "touched"):
            getattr(fresh, name)[:] = getattr(state, name)
        fresh.orders[: state.orders.shape[0]] = state.orders
        time, now = state.now[kn.TIME], fresh.now
        fresh.orders[:, 0] -= time
        now[kn.TIME] = now[kn.BLOWS] = 0.0
        now[kn.STROKE] -= time
        now[kn.HOLD] -= time
        fresh.sums[kn.LEAST] = fresh.sums[kn.GREATEST] = now[kn.PRESSURE]
        return made

    def run(
        self,
        until: float = math.inf,
        blows: float = math.inf,
        *,
        section: int = -1,
        since: float = 0.0,
        entering: Sequence[int] = (),
        exact: bool = False,
        most: int = 1 << 22,
    ) -> int:
        """On until a time, so many blows in all, or a port after `since` blows: how it ended, a number of the kernel.

        It is left at the beginning of the step that goes beyond the time, or `exact`ly there.
        """
        done, first = 0, np.array(entering, dtype=np.int64)
        while done < most:
            check_interrupted()
            ended = oil_kernels().followed(
                self.numbers.law,
                self.state,
                self.work,
                self.log,
                until,
                exact,
                float(blows),
                _STEPS,
                section,
                since,
                first,
            )
            first = first[:0]
            if section < 0:
                self._drained()
            self.log.filled[:] = 0
            done += _STEPS
            if ended == kn.CROWDED:
                self._grown()
            elif ended not in (kn.LOG_FULL, kn.STEPS_FULL):
                if ended == kn.NO_STEP:
                    raise PercussError("the oil of this machine has no step", remedy="check the units of its figures")
                return int(ended)
        return kn.STEPS_FULL

    def _drained(self) -> None:
        taken, rows = len(self.steps), self.log.events[: self.log.filled[0]]
        bars = rows[:, kn.EVENT :].reshape(-1, 2, self.numbers.modes + 1).transpose(0, 2, 1).copy()
        for (time, kind, detail, pressure, step), bar in zip(rows[:, : kn.EVENT].tolist(), bars, strict=True):
            self.events.append(OilEvent(time, KINDS[int(kind)], int(detail), bar, pressure, taken + int(step)))
        self.steps.extend(self.log.steps[: self.log.filled[1]].copy())

    def _grown(self) -> None:
        state = self.state
        self.state = state = state._replace(
            orders=np.concatenate([state.orders, np.zeros_like(state.orders)]),
            dues=np.concatenate([state.dues, np.zeros_like(state.dues)]),
        )
        rows = np.zeros((2 * self.log.events.shape[0], self.log.events.shape[1]))
        self.log = self.log._replace(events=rows)

    # -- its state as a row: what it is between two events, but for the orders that wait --

    def row(self) -> Array:
        """The state now, as `from_row` takes it up: a step, its length what is left of a stroke, −1 of none."""
        state = self.state
        now = state.now
        kept = [now[i] for i in (kn.PRESSURE, kn.SIGN, kn.OPEN, kn.FILLED, kn.LIMITED, kn.RESTING)]
        left = now[kn.STROKE] - now[kn.TIME] if now[kn.STROKE] < math.inf else -1.0
        return np.concatenate([[now[kn.TIME], left], kept, state.blend.reshape(-1), state.bar.reshape(-1)])

    @classmethod
    def from_row(cls, numbers: OilMachine, row: Array, state: int, *, recorded: bool = False) -> OilMotion:
        """A motion at time 0 in the state of a row and of the valve, without orders; nothing is met again at once."""
        made = cls.begun(
            numbers, np.zeros((numbers.modes + 1, 2)), 1.0, numbers.names[0], Orders(numbers.names[0]),
            recorded=recorded,
        )  # fmt: skip
        now, width = made.state.now, made.state.blend.shape[1]
        for i, value in zip(
            (kn.PRESSURE, kn.SIGN, kn.OPEN, kn.FILLED, kn.LIMITED, kn.RESTING), row[2 : kn.STEP], strict=True
        ):
            now[i] = value
        now[kn.STATE], now[kn.STROKE] = float(state), row[1] if row[1] >= 0.0 else math.inf
        now[kn.HOLD] = math.inf  # a wall and ports are events, and none is within
        made.state.blend[:] = row[kn.STEP : kn.STEP + 2 * width].reshape(2, width)
        made.state.bar[:] = row[kn.STEP + 2 * width :].reshape(2, -1)
        limits, g = numbers.machine.valve.supply, numbers.law.numbers
        if limits is not None:  # a limit at which the row begins has been met
            at = now[kn.PRESSURE]
            now[kn.AT_ZERO] = float(at == 0.0)
            now[kn.AT_RELIEF] = float(at == g[kn.RELIEF])
            now[kn.AT_CHARGE] = float(at == g[kn.PRECHARGE])
            now[kn.AT_CORNER] = float(at in (g[kn.CORNER], g[kn.CORNER_TO]))
        speed = float(numbers.own.driven @ made.state.bar[1])
        now[kn.TURNED] = float(speed * now[kn.SIGN] <= 0.0)
        sums = made.state.sums
        sums[kn.LEAST] = sums[kn.GREATEST] = now[kn.PRESSURE]
        return made

    # -- what it is now --

    @property
    def time(self) -> float:
        """Since its start."""
        return float(self.state.now[kn.TIME])

    @property
    def idle(self) -> float:
        """How long a motion may go without a blow: as long as a pump needs to fill the accumulator, twenty times."""
        supply = self.numbers.machine.valve.supply
        filling = 0.0 if supply is None else 20.0 * supply.capacity(max(1.0, self.pressure)) / supply.flow
        return max(self.numbers.idle, filling)

    @property
    def pressure(self) -> float:
        """Of the supply."""
        return float(self.state.now[kn.PRESSURE])

    @property
    def blows(self) -> int:
        """Since its start."""
        return int(self.state.now[kn.BLOWS])

    @property
    def bar(self) -> Array:
        """Displacement and velocity of every coordinate, (N + 1, 2)."""
        return np.array(self.state.bar.T)

    @property
    def orders(self) -> Orders:
        """Those that wait, counted from now."""
        names, now = self.numbers.names, self.state.now
        rows = self.state.orders[: int(now[kn.COUNT])]
        return Orders(names[int(now[kn.LAST])], tuple((float(due - self.time), names[int(to)]) for due, to in rows))

    @property
    def balance(self) -> OilBalance:
        """Since its start."""
        s = self.state.sums.tolist()
        fed = s[kn.PUMPED_ENERGY] if self.numbers.fed else s[kn.DRAWN] * self.pressure + s[kn.LEAK_LOSS]
        volume = s[kn.PUMPED] if self.numbers.fed else s[kn.DRAWN] + s[kn.LEAKED]
        losses, volumes = s[kn.LEAK_LOSS : kn.IMPACT_LOSS + 1], s[kn.LEAKED : kn.FARTHEST + 1]
        return OilBalance._make([fed, tuple(s[kn.ORIFICES :]), *losses, volume, *volumes])

    @property
    def force(self) -> float:
        """On the driven place now."""
        return float(oil_kernels().rates_at(self.numbers.law, self.state, np.zeros(2 * self.numbers.modes + 3)))

    @property
    def rates(self) -> Array:
        """Of displacements, velocities and the pressure, (2 N + 3,)."""
        found = np.zeros(2 * self.numbers.modes + 3)
        oil_kernels().rates_at(self.numbers.law, self.state, found)
        return found


def held_energy(numbers: OilMachine, place: Array, pressure: Array) -> Array:
    """What gas, constant force and accumulator hold, by the place of the driven end and the pressure."""
    valve = numbers.machine.valve
    gas, oil, supply = valve.chamber, valve.oil, valve.supply
    found = np.zeros_like(place) - (0.0 if oil is None else oil.force) * place
    if gas.exponent is None or gas.column is None:
        found += 0.5 * gas.stiffness * place**2 - gas.force * place
    else:
        z, e = 1.0 + place / gas.column, 1.0 - gas.exponent
        found -= gas.force * gas.column * (np.log(z) if e == 0.0 else np.expm1(e * np.log(z)) / e)
    if supply is None:
        return found
    found = np.asarray(found + 0.5 * supply.compliance * pressure**2)
    if supply.gas is not None:
        P, n, air = supply.gas.precharge + supply.gas.atmosphere, supply.gas.exponent, supply.gas.atmosphere
        ratio = np.maximum(pressure + air, P) / P
        volume, e = supply.gas.volume, (supply.gas.exponent - 1.0) / n
        work = np.log(ratio) if e == 0.0 else np.expm1(e * np.log(ratio)) / (n * e)
        found += P * volume * work - air * volume * (1.0 - ratio ** (-1.0 / n))
    return found


def states_at(
    numbers: OilMachine, steps: Sequence[Array], times: Array, of_step: npt.NDArray[np.int64]
) -> tuple[Array, Array, Array]:
    """Of recorded steps, and times after the beginnings of steps by number: bar (2, N + 1, t), pressure and force."""
    n = numbers.modes + 1
    at_rest = OilMotion.begun(numbers, np.zeros((n, 2)), 1.0, numbers.names[0], Orders(numbers.names[0]))
    found = np.zeros((times.size, 2 * n + 2))
    oil_kernels().at_times(numbers.law, at_rest.state, at_rest.work, np.array(steps), times, of_step, found)
    return found[:, : 2 * n].T.reshape(2, n, -1), found[:, 2 * n], found[:, 2 * n + 1]
