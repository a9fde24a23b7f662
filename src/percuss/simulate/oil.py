"""A machine whose oil flows, followed from a start: its record, its flights between events, and when it repeats."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from percuss.mechanics import oil_records as kn
from percuss.mechanics.oil import OilEvent, OilMachine, OilMotion, held_energy, oil_machine, states_at
from percuss.model import Machine
from percuss.model.checks import Array
from percuss.model.load.valve import Orders
from percuss.simulate.engine import Progress
from percuss.simulate.events import IMPACT, PORT, RELEASE, REST, STALLS, VALVE, Events, MotionCycle, machine_label
from percuss.simulate.spectrum import Anchor, ModalMotion, Moment, units
from percuss.simulate.start import Start
from percuss.simulate.stop import Stop

_CODES = {"impact": IMPACT, "port": PORT, "valve": VALVE, "rest": REST, "leaves": RELEASE}
_STRETCH = 4  # blows between two looks at the outside
_SHORTER = 1e5  # times the tolerance: a motion that nearly repeats may come to do so
_MEMORY = 32  # blows that later ones are compared with
_WANDERS, _NEAR = 64, 1e-3  # blows after which a motion that comes back to none of them is irregular
_SNAPSHOT = ("now", "bar", "blend", "orders", "touched", "sums")


# ---- Between two events


@dataclass(frozen=True)
class OilFlights:
    """What moves between two events; as `ClockedFlights` of a system."""

    machine: Machine
    modes: int

    @cached_property
    def numbers(self) -> OilMachine:
        """The tables of the kernel."""
        return oil_machine(self.machine, self.modes)

    @cached_property
    def own_units(self) -> Array:
        """What B77's u_n = 1 is in coordinates of modal mass 1, shape (N+1,)."""
        own = self.machine.body.modes(self.modes, self.machine.at)
        return np.concatenate([[1.0], units(own) / own.end])

    @property
    def names(self) -> list[str]:
        """Of the states."""
        return self.numbers.names

    @property
    def width(self) -> int:
        """Numbers of a state between two events."""
        return int(kn.STEP + 2 * self.numbers.law.joins.shape[1] + 2 * (self.modes + 1))

    @property
    def shapes(self) -> dict[str, tuple[int, ...]]:
        """Of the arrays of a snapshot; −1 for any length."""
        n, joins = self.modes + 1, self.numbers.law.joins.shape[1]
        return {
            "oil_now": (kn.NOW,), "oil_bar": (2, n), "oil_blend": (2, joins), "oil_orders": (-1, 2),
            "oil_touched": (len(self.machine.valve.ports),), "oil_sums": (kn.ORIFICES + len(self.numbers.chambers),),
            "oil_counts": (4,), "oil_blows": (-1, 6 + 2 * n),
        }  # fmt: skip

    def states(self, rows: Array, phase: Array, piece: npt.NDArray[np.int64]) -> tuple[Array, Array]:
        """See `ClockedFlights`."""
        n = self.modes + 1
        bars = rows[:, rows.shape[1] - 2 * n :].reshape(-1, 2, n) / self.own_units
        return bars[:, 0], bars[:, 1]

    def looked(self, anchor: Anchor, tau: Array) -> tuple[Array, Array, Array]:
        """Bar (2, N + 1, t) of modal mass 1, pressure and force at times after an anchor, until the next event."""
        motion = OilMotion.from_row(self.numbers, anchor.row, anchor.piece, recorded=True)
        motion.run(float(tau.max(initial=0.0)))
        if not motion.steps:
            motion.run(1e-300)
        begins = np.array([step[0] for step in motion.steps])
        which = np.clip(np.searchsorted(begins, tau, side="left") - 1, 0, None)
        return states_at(self.numbers, motion.steps, tau - begins[which], which.astype(np.int64))

    def after(self, anchor: Anchor, tau: Array) -> ModalMotion:
        """See `ClockedFlights`."""
        bar = self.looked(anchor, tau)[0] / self.own_units[:, None]
        return ModalMotion(bar[0], bar[1])

    def spent(self, anchor: Anchor, tau: float) -> tuple[float, float]:
        """Input and losses in a time after an anchor."""
        motion = OilMotion.from_row(self.numbers, anchor.row, anchor.piece)
        motion.run(tau, exact=True)
        found = motion.balance
        return found.input, found.losses

    def driven(self, modes: Array) -> Array:
        """What the driven place moves, of the motions of the modes."""
        return np.asarray((self.own_units * self.numbers.own.driven) @ modes)

    def stored(self, at: Moment) -> Array:
        """See `ClockedFlights`: in gas and accumulator."""
        pressure = np.ones(at.time.size) if at.pressure is None else at.pressure
        return held_energy(self.numbers, self.driven(at.modes.displacement), pressure)

    @property
    def rates(self) -> tuple[float, float]:
        """See `ClockedFlights`."""
        own = self.numbers.own
        slow = 1.0 / float(self.numbers.law.numbers[kn.UNIT])
        return max(slow, float(own.omega.max())), max(1e-300, float(own.damping.max()))

    def breaks(self, begin: float, end: float) -> Array:
        """See `ClockedFlights`."""
        return np.empty(0)


# ---- A motion on its way


@dataclass
class FlowingOil:
    """A motion of a machine whose oil flows, on its way; as `SelfSwitching`."""

    flights: OilFlights
    motion: OilMotion
    blows: list[Array] = field(default_factory=list)  # time, changes, rests, taken, speed, pressure, bar after
    changes: int = 0
    rests: int = 0
    taken: float = 0.0
    stroke: float = -1e300  # when the last one began
    cycle: MotionCycle | None = None
    _piece: int = -1  # the state of the valve after the last event

    def __post_init__(self) -> None:
        if self._piece < 0:
            self._piece = int(self.motion.state.now[kn.STATE])

    @property
    def modes(self) -> int:
        """N."""
        return self.flights.modes

    @classmethod
    def begun(cls, machine: Machine, modes: int, start: Start) -> tuple[FlowingOil, Anchor, bool]:
        """A motion put at a start, the state there, and whether it rests on the wall."""
        flights = OilFlights(machine, modes)
        state, orders = start.valve_of(machine)
        u, v, gap = start.state(modes, machine)
        bar = np.stack([flights.own_units * u, flights.own_units * v], axis=1)
        supply = machine.valve.supply
        pressure = 1.0 if supply is None else supply.start if start.pressure is None else start.pressure
        rests = gap == 0.0 and not u.any() and not v.any()
        motion = OilMotion.begun(
            flights.numbers, bar, pressure, state, orders, resting=rests, struck=gap == 0.0, recorded=True
        )
        occupied = [] if start.orders is not None else _occupied(flights.numbers, bar)
        anchor = Anchor(start.time, flights.names.index(state), motion.row())
        motion.run(0.0, entering=occupied)
        return cls(flights, motion), anchor, rests

    @classmethod
    def restored(cls, machine: Machine, modes: int, snapshot: dict[str, npt.NDArray[Any]]) -> FlowingOil:
        """A motion that goes on from a snapshot."""
        flights = OilFlights(machine, modes)
        names = flights.names
        motion = OilMotion.begun(
            flights.numbers, np.zeros((modes + 1, 2)), 1.0, names[0], Orders(names[0]), recorded=True
        )
        spare = motion.state
        kept = {name: np.array(snapshot[f"oil_{name}"], dtype=float) for name in _SNAPSHOT}
        queue = kept["orders"].shape[0]
        motion.state = spare._replace(**kept, dues=np.zeros((queue, 0)))
        changes, rests, taken, stroke = snapshot["oil_counts"].tolist()
        made = cls(flights, motion, list(np.array(snapshot["oil_blows"])), int(changes), int(rests), taken, stroke)
        return made

    def snapshot(self) -> dict[str, npt.NDArray[Any]]:
        """What the motion goes on from."""
        found = {f"oil_{name}": np.array(getattr(self.motion.state, name)) for name in _SNAPSHOT}
        found["oil_counts"] = np.array([float(self.changes), float(self.rests), self.taken, self.stroke])
        width = 6 + 2 * (self.modes + 1)
        found["oil_blows"] = np.array(self.blows[-2 * _MEMORY - 1 :]).reshape(-1, width)
        return found

    def followed(
        self, stop: Stop, begin_time: float, progress: Callable[[Progress], object] | None = None
    ) -> dict[str, Any]:
        """The motion on until the stop rule holds; what a `Trajectory` has of it, by the names of its fields."""
        events, rows, ended = list[list[float]](), list[Array](), ""
        self._taken_up(events, rows)
        while not ended:
            ended = self._on(stop)
            self._taken_up(events, rows)
            if not ended and stop.periodic:
                ended = "periodic" if self._repeats(stop.tolerance) else ""
            gone = Progress(
                self.motion.blows, self.motion.time, min(self.motion.blows / max(stop.most_impacts, 1), 1.0)
            )
            if not ended and progress is not None and progress(gone):
                ended = "interrupted"
        told = _columns(events, begin_time, tuple(self.flights.names))
        width = self.motion.row().size
        over = ended in ("time", *STALLS) and ended != "without pressure"
        known = stop.time if stop.time is not None and over else self.motion.time
        last = float(told.time[-1]) if len(told) else begin_time
        return {
            "events": told,
            "states": np.array(rows).reshape(-1, width),
            "snapshot": self.snapshot(),
            "outcome": "stalls" if ended in STALLS else ended,
            "label": machine_label(ended, self.cycle, self.wanders),
            "cycle": self.cycle,
            "end_time": max(begin_time + known, last),
        }

    def carried_on(self, stop: Stop, stopped: Callable[[], bool]) -> tuple[str, bool]:
        """A motion that is not recorded, to its end: how it ended, and whether its last blows wander."""
        ended = ""
        self._taken_up(None, None)
        while not ended:
            ended = self._on(stop)
            self._taken_up(None, None)
            if not ended and stop.periodic and self._repeats(stop.tolerance):
                ended = "periodic"
            if not ended and stopped():
                ended = "interrupted"
        return ended, self.wanders

    def _on(self, stop: Stop) -> str:
        """Some blows on: how the motion ended, or nothing."""
        motion, end = self.motion, math.inf if stop.time is None else stop.time
        before = motion.blows
        if before >= stop.most_impacts:
            return "impacts"
        until, blows = min(end, motion.time + motion.idle), min(before + _STRETCH, stop.most_impacts)
        ended = motion.run(until, float(blows), most=1 << 20)
        if ended in (kn.NO_PRESSURE, kn.EMPTY_LINE):
            return "without pressure"
        if motion.blows > before:
            return "impacts" if motion.blows >= stop.most_impacts else ""
        if ended == kn.STEPS_FULL:
            return "work"
        resting, waits = motion.state.now[kn.RESTING] > 0.0, motion.state.now[kn.COUNT] > 0.0
        quiet = resting or not any(e.kind == "valve" for e in motion.events)
        if ended == kn.BY_TIME and not waits and quiet:
            if resting:
                return "on the tool"
            if end == math.inf:
                return "in the chamber" if self.flights.machine.valve.chamber.stiffness > 0.0 else "leaves"
        return "time" if end < math.inf else ""

    def _taken_up(self, events: list[list[float]] | None, rows: list[Array] | None) -> None:
        """What has happened since the last time, into the record, if there is one, and into the memory of blows."""
        motion, own, turn = self.motion, self.flights.numbers.own, self.flights.numbers.turn
        steps, spool = motion.steps, self.flights.machine.valve.oil
        stroke = 0.0 if spool is None else spool.spool
        piece = self._piece
        for event in motion.events:
            code = _CODES.get(event.kind)
            speed = float(own.end @ event.state[:, 1])
            if event.kind == "valve":
                self.changes, self.stroke, piece = self.changes + 1, event.time, event.detail
            if code is None:
                continue
            kinetic = lost = 0.0
            after = speed
            if event.kind == "impact":
                kinetic, lost, after = self._blow(event, own, turn)
                self.taken += lost
            elif event.kind == "rest":
                lost = 0.5 * float((event.state[:, 1] ** 2 + (own.omega * event.state[:, 0]) ** 2).sum())
                self.taken, self.rests, after = self.taken + lost, self.rests + 1, 0.0
            if events is None or rows is None:
                continue
            port = event.detail if event.kind == "port" else -1
            if port >= 0:
                table = motion.numbers.law
                speed = after = float(table.reads[port] @ event.state[:, 1])
            events.append([code, event.time, speed, after, lost, kinetic, piece, port])
            row = steps[event.step].copy() if event.step < len(steps) else motion.row()
            left = self.stroke + stroke - event.time
            row[1] = left if stroke and left > 0.0 else -1.0
            rows.append(row)
        self._piece = piece
        motion.events.clear()
        motion.steps.clear()

    def _blow(self, event: OilEvent, own: Any, turn: Array) -> tuple[float, float, float]:
        """Kinetic energy before a blow, what it takes, and the speed after it; the state joins the memory."""
        bar = event.state * turn
        kinetic = 0.5 * float(event.state[:, 1] @ event.state[:, 1])
        strain = 0.5 * float((own.omega * event.state[:, 0]) @ (own.omega * event.state[:, 0]))
        lost = (1.0 - turn[1] ** 2) * kinetic + (1.0 - turn[0] ** 2) * strain
        if self.modes:  # a law that turns the strain over moves the driven end in no time
            ends = np.array([float(own.driven @ place) for place in (event.state[:, 0], bar[:, 0])])
            held = held_energy(self.flights.numbers, ends, np.ones(2))
            lost += float(held[0] - held[1])
        told = [event.time, self.changes, self.rests, self.taken, float(own.end @ event.state[:, 1]), event.pressure]
        self.blows.append(np.concatenate([told, bar.T.reshape(-1)]))
        return kinetic, lost, float(own.end @ bar[:, 1])

    def _repeats(self, tolerance: float) -> bool:
        """Whether the last blows are those before them, twice; the cycle is kept."""
        table = np.array(self.blows[-2 * _MEMORY - 1 :])
        if len(table) < 3:
            return False
        own, n = self.flights.numbers.own, self.modes + 1
        scales = np.concatenate(
            [[1.0], np.full(n, math.inf), np.full(n, max(float(np.abs(table[:, 4]).max()), 1e-300))]
        )
        scales[1 : n + 1] = scales[-1] / np.maximum(own.omega, 1.0 / float(self.motion.numbers.law.numbers[kn.UNIT]))
        states = table[:, 5:] / scales
        for p in range(1, min(_MEMORY, (len(table) - 1) // 2) + 1):
            off = max(float(np.abs(states[-1 - i] - states[-1 - p - i]).max()) for i in range(p + 1))
            if tolerance < off <= _SHORTER * tolerance:
                return False  # it may come to repeat so, and a multiple of p be met before
            if off <= tolerance:
                last, first = table[-1], table[-1 - p]
                changes, rests = int(last[1] - first[1]), int(last[2] - first[2])
                states_used = len({port.to for port in self.flights.machine.valve.ports})
                turns = max(round(changes / max(states_used, 1)), 0)
                self.cycle = MotionCycle(
                    first=max(self.motion.blows - 2 * p - 1, 0), impacts=p, periods=turns, kind=1 if rests else 0,
                    period=float(last[0] - first[0]), energy_lost=float(last[3] - first[3]),
                    blow_speed=float(table[-p:, 4].max()),
                )  # fmt: skip
                return True
        return False

    @property
    def wanders(self) -> bool:
        """Whether the last blows come near none before them."""
        table = np.array(self.blows[-2 * _MEMORY - 1 :])
        if self.cycle is not None or len(self.blows) < _WANDERS:
            return False
        speeds = table[:, 4:6]
        near = np.abs(speeds[:-1] - speeds[-1]).max(axis=1) <= _NEAR * np.abs(speeds).max()
        return not bool(near.any())


def _occupied(numbers: OilMachine, bar: Array) -> list[int]:
    """The ports whose regions a bar is in at a start."""
    law, found = numbers.law, []
    for i, port in enumerate(numbers.machine.valve.ports):
        seen = float(law.reads[i] @ bar[:, 1 if port.speed is not None else 0])
        if port.sign * (port.level - seen) < 0.0:
            found.append(i)
    return found


def _columns(rows: list[list[float]], begin_time: float, states: tuple[str, ...]) -> Events:
    table = np.array(rows).reshape(-1, 8)
    whole = table[:, [0, 6, 7]].astype(np.int64)
    none = np.zeros(len(table), dtype=np.int64)
    return Events(
        code=whole[:, 0].astype(np.int8), period=none, phase=begin_time + table[:, 1], impact_velocity=table[:, 2],
        rebound_velocity=table[:, 3], energy_lost=table[:, 4], kinetic_energy=table[:, 5], resolved=none.copy(),
        piece=whole[:, 1], port=whole[:, 2], states=states,
    )  # fmt: skip
