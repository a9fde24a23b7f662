"""A machine that switches its own valve: its numbers, its flights, and the loop around its kernels."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
import numpy.typing as npt

from percuss.mechanics.flow import propagator, series
from percuss.model import Machine, Supply
from percuss.model.checks import Array
from percuss.model.machine import MachineModes, check_closed_form, machine_modes
from percuss.simulate.engine import (
    GOES_ON,
    NO_LOG,
    NO_MODES,
    Progress,
    Snapshot,
    bar_of,
    copied,
    desk_for,
    gathered,
    tabled_modes,
    to_change,
)
from percuss.simulate.events import PORT, RELEASE, STALLS, VALVE, Events, MotionCycle, machine_label
from percuss.simulate.kernels import motion_records as kn
from percuss.simulate.kernels.motion import follow_valve
from percuss.simulate.spectrum import Anchor, DampedModes, ModalMotion, Moment, units
from percuss.simulate.start import Start, Starts, states_of
from percuss.simulate.stop import Stop

# ---- The numbers of a machine as the kernels want them, in a unit of time of its own

_NODE = 1e-12
_SOFTEST = 1e-100  # frequency of a chamber that is none
_OF_MODES = ("law", "base", "base_half", "half", "delta", "quickest", "wane", "lasting", "linger")  # in a BAR


@dataclass(frozen=True)
class ElasticModes(DampedModes):
    """The elastic modes of a machine as q_i, what m_i moves the striking end by; fields as of `MachineModes`."""

    omega: Array
    damping: Array
    end: Array
    driven: Array

    @cached_property
    def statics(self) -> Array:
        """q_i under a constant unit force."""
        return np.asarray(self.end * self.driven / self.omega**2)

    @property
    def unit(self) -> Array:
        """q_i of q_i = 1."""
        return np.ones(self.omega.size)

    @cached_property
    def inertia(self) -> Array:
        """What q_i'²/2 is multiplied by to be a kinetic energy."""
        return np.asarray(1.0 / self.end**2)


@dataclass(frozen=True)
class Mechanism:
    """A machine cut at mode N in one state of its valve, in the units of the kernels; made by `mechanism`.

    Their unit of time is a power of two, see `Valve.time_unit`, so that only exponents differ. With a supply,
    c π' = q − p u', the force π p is p/c times the charge c π + p u, which grows with the flow q alone, less a spring
    of p²/c. So each state has modes of its own.
    """

    machine: Machine
    modes: int
    piece: int = 0

    @cached_property
    def states_of(self) -> list[Mechanism]:
        """The machine in each state."""
        return [replace(self, piece=i) if i != self.piece else self for i in range(len(self.names))]

    def in_state(self, number: int) -> Mechanism:
        """The machine with the modes of a state, which are the same without a supply."""
        return self if self.supply is None else self.states_of[number]

    @cached_property
    def unit(self) -> float:
        """The unit of time, in that of the machine."""
        return self.machine.valve.time_unit

    @cached_property
    def end(self) -> Array:
        """What m_i = 1 moves the striking end by, shape (N+1,); next to nothing, not 0, where a mode has a node."""
        end = self._own.end
        return np.where(np.abs(end) < _NODE, _NODE, end)

    @cached_property
    def forces(self) -> Array:
        """Forces of the states, with that of the chamber; in the unit of the machine."""
        valve = self.machine.valve
        return np.array([valve.force(name) for name, _ in valve.pairs])

    @property
    def names(self) -> list[str]:
        """The names of the valve's states, in order."""
        return [name for name, _ in self.machine.valve.pairs]

    @property
    def supply(self) -> Supply | None:
        """What feeds the valve; None at a constant pressure."""
        return self.machine.valve.supply

    @cached_property
    def fed(self) -> tuple[float, float, float]:
        """q, p of the state and p/c of a supply, in the unit of the machine; 0 without one."""
        if self.supply is None:
            return 0.0, 0.0, 0.0
        draw = self.machine.valve.pairs[self.piece][1]
        return self.supply.flow, draw, draw / self.supply.compliance

    @cached_property
    def ramp(self) -> float:
        """What a flow adds to the force in a unit of time."""
        flow, _, slope = self.fed
        return slope * flow

    @cached_property
    def _own(self) -> MachineModes:
        machine, (_, draw, slope) = self.machine, self.fed
        return machine_modes(machine.body, machine.at, machine.valve.chamber.stiffness + draw * slope, self.modes)

    @property
    def spring(self) -> float:
        """ω_0 on the gas of the chamber, and on the oil of an accumulator; 0 without them."""
        found = float(self._own.omega[0])
        return found if found * self.unit > _SOFTEST else 0.0

    def elastic(self, unit: float = 1.0) -> ElasticModes:
        """The elastic modes, in a unit of time."""
        own = self._own
        return ElasticModes(own.omega[1:] * unit, own.damping[1:] * unit, self.end[1:], own.driven[1:])

    @cached_property
    def slow(self) -> ElasticModes:
        """The elastic modes in the machine's unit of time."""
        return self.elastic()

    @cached_property
    def tables(self) -> tuple[kn.MotionTable, kn.MotionTable]:
        """The kernels' tables of the machine, and of its rigid motion alone."""
        machine, unit, elastic = self.machine, self.unit, self.elastic(self.unit)
        bar = bar_of(machine.body, elastic)
        bar["damping"] *= unit
        bar["wave"], bar["contact"] = bar["wave"] / unit, bar["contact"] / unit
        bar["spring"], bar["whole"] = self.spring * unit, 1.0 / self.end[0] ** 2
        bar["restitution"] = -machine.contact.velocity_factor
        bar["strain"] = machine.contact.strain_factor
        bar["force"] = float(np.abs(self.forces).max()) * unit**2
        bar["pushing"] = np.inf
        bar["ramp"] = self.ramp * unit**3
        bar["lift"], bar["climb"] = self.gear.gain * bar["ramp"], bar["ramp"] * elastic.statics.sum()
        modes, none = tabled_modes(elastic, bar), np.empty(0)
        waves = kn.Harmonics(none, none, none, none, none, none)
        table = kn.MotionTable(bar, modes, waves, np.empty((0, 2, self.modes)), none, none, none)
        alone = to_change(table)._replace(modes=NO_MODES, coupling=np.empty((0, 2, 0)))
        for name in _OF_MODES:
            alone.bar[name] = 0.0
        return table, alone

    @cached_property
    def gear(self) -> kn.Gear:
        """The kernels' table of the valve."""
        machine, unit, ports = self.machine, self.unit, self.machine.valve.ports
        own, names, (flow, draw, slope) = self._own, self.names, self.fed
        rows = [
            own.centre if port.reads == "centre" else own.at(machine.body, np.array([port.reads]))[0] for port in ports
        ]
        rows += [own.driven] if flow else []
        ratio = np.array(rows, dtype=float).reshape(len(rows), self.modes + 1) / self.end
        speeds = np.array([port.speed is not None for port in ports] + [False] * bool(flow), dtype=np.int64)
        held = self.forces if self.supply is None else np.full(len(names), machine.valve.chamber.force)
        return kn.Gear(
            forces=held * unit**2,
            to=np.array([names.index(port.to) for port in ports], dtype=np.int64),
            edge=np.array([-port.level * (1.0 if port.speed is None else unit) for port in ports]),
            side=np.array([port.sign for port in ports]),
            delay=np.array([port.delay / unit for port in ports]),
            ratio=ratio,
            rigid=np.array([not row[1:].any() for row in ratio], dtype=np.int64),
            gain=float(self.end[0] * own.driven[0]),
            bend=ratio[:, 1:] @ self.elastic(unit).statics,
            speeds=speeds,
            flow=flow * unit**3,
            draw=draw * unit**2,
            slope=slope,
            soft=0.0 if self.supply is None else 1.0 / (self.supply.compliance * unit**2),
            quickening=0.0 if self.supply is None else self.supply.quickening,
            **self._reaches(ratio * self.end, speeds),
        )

    def _reaches(self, weights: Array, speeds: npt.NDArray[np.int64]) -> dict[str, Array]:
        """Of what the ports read: its place under a unit force, and how far a unit of energy drives it from there."""
        own, unit = self._own, self.unit
        if self.spring == 0.0:
            return {"still": np.zeros(len(weights)), "sway": np.full(len(weights), np.inf)}
        soft = weights / (own.omega * unit) ** 2
        far = np.where(speeds, np.sqrt((weights**2).sum(axis=1)), np.sqrt((soft * weights).sum(axis=1)))
        return {"still": (1 - speeds) * (soft @ own.driven), "sway": far * (1.0 + 1e-12)}

    @cached_property
    def of_states(self) -> tuple[kn.MotionTable, kn.MotionTable, kn.Gear, Array]:
        """Tables, gear and turns of all states as of a `Plant`; the `bar`s are to be copied."""
        own = [self] if self.supply is None else self.states_of
        turns = [[one.turned(other) for other in own] for one in own] if len(own) > 1 else np.empty((1, 1, 0, 0))
        table, alone = (_together(list(tables)) for tables in zip(*(one.tables for one in own), strict=True))
        return table, alone, _stacked([one.gear for one in own]), np.array(turns)

    # -- the state in two forms: B77's u_n, and the kernels' amplitudes of the free motion --

    @cached_property
    def own_units(self) -> Array:
        """What B77's u_n = 1 is in the body's coordinates of modal mass 1, shape (N+1,)."""
        own = self.machine.body.modes(self.modes, self.machine.at)
        return np.concatenate([[1.0], units(own) / own.end])

    def ends(self, displacement: Array) -> Array:
        """q_i of B77's u_n; both of shape (…, N+1)."""
        # each row by itself, so that its digits are the same among others
        return np.asarray(self.end * np.matmul(self._own.mixing.T, (self.own_units * displacement)[..., None])[..., 0])

    def bars(self, ends: Array) -> Array:
        """B77's u_n of q_i; both of shape (N+1, …)."""
        return np.asarray(((self._own.mixing @ (ends.T / self.end).T).T / self.own_units).T)

    def freed(self, q: Array, rate: Array, force: Array) -> Array:
        """The kernels' amplitudes z, (…, 2, N), of q_i and q_i', (…, N+1) each, in their unit, under forces, (…)."""
        modes, ramp = self.tables[0].modes, self.ramp * self.unit**3
        place, speed = q[..., 1:] - modes.statics * force[..., None], rate[..., 1:]
        if ramp:
            place, speed = place + ramp * self._late, speed - ramp * modes.statics
        turned = -modes.inverse * (speed + modes.half * place)
        return np.stack([place, np.where(modes.oscillates > 0.0, turned, speed)], axis=-2)

    @cached_property
    def _late(self) -> Array:
        """How far q_i, (N,), stays behind its place at rest under a unit ramp of the force."""
        modes = self.tables[0].modes
        return np.asarray(modes.statics * modes.damping / modes.omega**2)

    def bound(self, rows: Array) -> tuple[Array, Array]:
        """q_i and q_i' of states that the kernels have left, in their unit; each of shape (states, N+1)."""
        n, modes, ramp = self.modes, self.tables[0].modes, self.ramp * self.unit**3
        z0, z1 = rows[:, 2 : 2 + n], rows[:, 2 + n : 2 + 2 * n]
        q, rate = np.empty((2, len(rows), n + 1))
        q[:, 1:] = z0 + self.force_of(rows)[:, None] * modes.statics
        rate[:, 1:] = (1.0 - modes.oscillates) * z1 - modes.lam * z1 - modes.half * z0
        if ramp:
            q[:, 1:] -= ramp * self._late
            rate[:, 1:] += ramp * modes.statics
        q[:, 0], rate[:, 0] = rows[:, 0] - q[:, 1:].sum(axis=1), rows[:, 1]
        return q, rate

    def force_of(self, rows: Array) -> Array:
        """What pushes the modes in states that the kernels have left, in their unit."""
        held = float(self.gear.forces[self.piece])
        return held + self.fed[2] * rows[:, -1] if self.supply is not None else np.full(len(rows), held)

    def turned(self, to: Mechanism) -> Array:
        """What makes q_i of another state's modes of those of this one's, shape (N+1, N+1)."""
        return np.asarray(to.end[:, None] * (to._own.mixing.T @ self._own.mixing) / self.end)

    def states(self, rows: Array, phase: Array, piece: npt.NDArray[np.int64]) -> tuple[Array, Array]:
        """See `ClockedFlights`; `rows` are states that the kernels have left."""
        found = np.empty((2, len(rows), self.modes + 1))
        for i in np.unique(piece):
            own, here = self.states_of[i], piece == i
            q, rate = own.bound(rows[here])
            found[0, here], found[1, here] = own.bars(q.T).T, own.bars(rate.T).T / self.unit
        return found[0], found[1]

    def after(self, anchor: Anchor, tau: Array) -> ModalMotion:
        """See `ClockedFlights`."""
        own, row, unit = self.states_of[anchor.piece], anchor.row[None], self.unit
        (place,), (speed,), force = *own.bound(row), float(own.force_of(row)[0]) / unit**2
        speed = speed / unit
        elastic, w, d, gain = own.slow, own.spring, self.machine.drag, own.gear.gain
        pull, lift = gain * force - w * w * place[0], gain * own.ramp
        slope, h, integral, twice = series(tau, float(tau.max(initial=0.0)), w * w, d)
        step = propagator(elastic.omega[:, None], elastic.damping[:, None], tau)
        climb = own.ramp * elastic.statics[:, None]
        rest = force * elastic.statics[:, None] - own.ramp * unit**3 * own._late[:, None]
        z, v = place[1:, None] - rest, speed[1:, None] - climb
        q = rest + climb * tau + z * step.a + v * step.b
        rate = climb + z * step.c + v * step.e
        q0 = place[0] + speed[0] * h + pull * integral + lift * twice
        rate0 = speed[0] * slope + pull * h + lift * integral
        return ModalMotion(own.bars(np.vstack([q0, q])), own.bars(np.vstack([rate0, rate])))

    def force(self, at: Moment) -> Array:
        """See `ClockedFlights`."""
        chamber, pushed = self.machine.valve.chamber, self.forces[at.piece]
        if at.pressure is not None:
            pushed = (pushed - chamber.force) * at.pressure + chamber.force
        return np.asarray(pushed - chamber.stiffness * self.driven(at.modes.displacement))

    @property
    def driven_by(self) -> Array:
        """What B77's u_n = 1 moves the driven place by, shape (N+1,)."""
        return np.asarray(self.own_units * (self._own.mixing @ self._own.driven))

    def driven(self, modes: Array) -> Array:
        """What the driven place moves, of the motions of the modes."""
        return np.asarray(self.driven_by @ modes)

    def pressure(self, piece: npt.NDArray[np.int64], charge: Array, since: Array, displacement: Array) -> Array:
        """π of a supply in states of the valve, from the charge at the last event and the modes."""
        supply = self.supply
        assert supply is not None
        draw = np.array([force for _, force in self.machine.valve.pairs])[piece]
        full = charge / self.unit**2 + supply.flow * since
        return np.asarray((full - draw * self.driven(displacement)) / supply.compliance)

    def put_in(self, at: Moment) -> Array:
        """See `ClockedFlights`: by the valve; or by the pump, and the constant part of the chamber's force."""
        speed = self.driven(at.modes.velocity)
        if self.supply is None or at.pressure is None:
            return np.asarray(self.forces[at.piece] * speed)
        return np.asarray(self.supply.flow * at.pressure + self.machine.valve.chamber.force * speed)

    def stored(self, at: Moment) -> Array | float:
        """See `ClockedFlights`: in the gas and in an accumulator."""
        gas = 0.5 * self.machine.valve.chamber.stiffness * self.driven(at.modes.displacement) ** 2
        if self.supply is None or at.pressure is None:
            return gas
        return np.asarray(gas + 0.5 * self.supply.compliance * at.pressure**2)

    def lost(self, at: Moment) -> Array:
        """See `ClockedFlights`."""
        found = np.empty(at.time.size)
        for i in np.unique(at.piece):
            own, here = self.states_of[i]._own, at.piece == i
            found[here] = own.damping @ (own.mixing.T @ (self.own_units * at.modes.velocity[:, here].T).T) ** 2
        return found

    @property
    def rates(self) -> tuple[float, float]:
        """See `ClockedFlights`."""
        own = [one._own for one in self.states_of]
        return max(1e-300, *(float(o.omega.max()) for o in own)), max(float(o.damping.max()) for o in own)

    def breaks(self, begin: float, end: float) -> Array:
        """See `ClockedFlights`."""
        return np.empty(0)


def _stacked(records: list[Any]) -> Any:
    """One record of the arrays and numbers of several, with one more axis in front."""
    columns = zip(*records, strict=True)
    return type(records[0])(*(np.array(own) if len(own) > 1 else np.asarray(own[0])[None] for own in columns))


def _together(tables: list[kn.MotionTable]) -> kn.MotionTable:
    """A table of several states, as of a `Plant`."""
    modes = [table.modes for table in tables]
    ended = [np.append(one.creeping, np.full(one.omega.size - one.creeping.size, -1)) for one in modes]
    own = _stacked([one._replace(creeping=row) for one, row in zip(modes, ended, strict=True)])
    return tables[0]._replace(bar=np.frombuffer(b"".join(table.bar.tobytes() for table in tables), kn.BAR), modes=own)


@lru_cache(maxsize=16)
def mechanism(machine: Machine, modes: int) -> Mechanism:
    """The numbers of a machine, kept for the next motion of it."""
    check_closed_form(machine)
    return Mechanism(machine, modes)


# ---- The memory that the kernels work in: the whole state of a motion between two events, kept and put back

ROOM = 256  # orders that wait for which there is room at first
_WINDOW = 64  # last changes of the valve that are kept


Kept = dict[str, npt.NDArray[Any]]

_OF_MOTION = ("z", "now", "count", "anchor", "past", "sums")


def unmoved(mechanism: Mechanism, queue: int = ROOM) -> Kept:
    """All that the next event depends on, by name, of a motion not begun, with room for orders that wait."""
    ports, states, n = len(mechanism.gear.ratio), mechanism.gear.forces.size, mechanism.modes
    bar, whole = Snapshot.empty(n, 1), np.int64
    valve = kn.Controls(
        np.zeros(1, kn.VALVE_NOW), np.zeros(states), np.zeros(ports), np.zeros(queue), np.zeros(queue, whole),
        np.zeros(ports), np.zeros(ports, whole), np.zeros(ports, whole), np.zeros((2, n)), np.zeros(queue),
        np.zeros(_WINDOW, kn.TURNING),
    )  # fmt: skip
    found = dict(zip(_OF_MOTION, (bar.z, bar.now, bar.count, bar.cycle, bar.past, bar.sums), strict=True))
    return found | {f"valve_{name}": values for name, values in valve._asdict().items()}


def kept(plant: kn.Plant) -> Kept:
    """The same of a plant; copies."""
    found = {name: np.array(getattr(plant.motion, name), ndmin=1) for name in _OF_MOTION}
    return found | {f"valve_{name}": np.array(values, ndmin=1) for name, values in plant.controls._asdict().items()}


def plant_of(mechanism: Mechanism, arrays: Kept) -> kn.Plant:
    """A machine in a state whose motion stands there: the same memory; nothing else of it is shared."""
    table, alone, gear, turns = _own_tables(mechanism)
    motion = Snapshot(*(arrays[name] for name in _OF_MOTION)).motion
    now, *rest = (arrays[f"valve_{name}"] for name in kn.Controls._fields)
    eye, spot = (Snapshot.empty(size, 1).motion for size in (mechanism.modes, 0))
    controls, words = kn.Controls(now[0], *rest), now.view(np.int64)
    return kn.Plant(table, alone, gear, turns, motion, eye, spot, desk_for(table), desk_for(alone), controls, words)


def _own_tables(mechanism: Mechanism) -> tuple[kn.MotionTable, kn.MotionTable, kn.Gear, Array]:
    table, alone, gear, turns = mechanism.of_states
    return table._replace(bar=copied(table.bar)), alone._replace(bar=copied(alone.bar)), gear, turns


def plant_for(mechanism: Mechanism, queue: int, last: kn.Plant | None) -> kn.Plant:
    """A machine to be put at starts, with room for orders that wait; in the memory of the last one if that fits."""
    if last is not None:
        controls = last.controls
        sizes = (last.motion.z.shape[1], controls.usual.size, controls.cross.size)
        if sizes == (mechanism.modes, mechanism.forces.size, len(mechanism.gear.ratio)) and controls.due.size >= queue:
            table, alone, gear, turns = _own_tables(mechanism)
            return last._replace(table=table, alone=alone, gear=gear, turns=turns)
    return plant_of(mechanism, unmoved(mechanism, queue))


def roomier(plant: kn.Plant) -> kn.Plant:
    """The same plant with room for twice as many orders that wait; all else is shared."""
    controls = plant.controls

    def grown(row: npt.NDArray[Any]) -> npt.NDArray[Any]:
        return np.concatenate([row, np.zeros_like(row)])

    return plant._replace(
        controls=controls._replace(
            due=grown(controls.due), order=grown(controls.order), memo_due=grown(controls.memo_due)
        )
    )


# ---- Where motions start

_NOWHERE = kn.MachineStarts(
    np.empty(0, kn.START), np.empty((0, 2, 0)), np.empty((0, 0)), np.empty((0, 0), dtype=np.int64)
)


def machine_starts(mechanism: Mechanism, starts: Starts | Sequence[Start]) -> kn.MachineStarts:
    """The starts of motions for the kernels."""
    machine, unit, names = mechanism.machine, mechanism.unit, mechanism.names
    u, v, gap = states_of(starts, mechanism.modes, machine)
    single: Sequence[Start] = starts if not isinstance(starts, Starts) else starts.valves
    asked = [(*start.valve_of(machine), start.orders is None, start.pressure) for start in single]
    pending = [orders.pending for _, orders, *_ in asked]
    rows, z, most = np.zeros(len(asked), kn.START), np.empty((len(asked), 2, mechanism.modes)), max(map(len, pending))
    due, order = np.zeros((len(asked), most)), np.zeros((len(asked), most), dtype=np.int64)
    for i, waiting in enumerate(pending):
        for j, (time, to) in enumerate(waiting):
            due[i, j], order[i, j] = time / unit, names.index(to)
    rows["state"] = [names.index(state) for state, *_ in asked]
    rows["last"] = [names.index(orders.last) for _, orders, *_ in asked]
    rows["waiting"], rows["asked"] = [len(one) for one in pending], [one for *_, one, _ in asked]
    for i in set(rows["state"].tolist()):
        own, here = mechanism.in_state(i), rows["state"] == i
        q, rate, charge = own.ends(u[here]), own.ends(v[here]) * unit, np.zeros(np.count_nonzero(here))
        if own.supply is not None:
            pressure = np.array([own.supply.start if one is None else one for *_, one in asked])[here]
            pressed = np.matmul(own.driven_by, u[here][..., None])[..., 0]
            charge = (own.supply.compliance * pressure + own.fed[1] * pressed) * unit**2
        rows["charge"][here], z[here] = charge, own.freed(q, rate, own.gear.forces[i] + own.fed[2] * charge)
        rows["gap"][here], rows["gap_rate"][here] = q.sum(axis=1), rate.sum(axis=1)
        rows["rigid_rate"][here] = rate[:, 0]
    on = gap == 0.0
    rows["gap"][on] = 0.0
    rows["mode"] = np.where(on, np.where(v.any(axis=1) | u.any(axis=1), kn.ON_WALL, kn.RESTING), kn.FLYING)
    return kn.MachineStarts(rows, z, due, order)


# ---- The loop around the kernels of a machine

_MOST_NUMBERS, _MOST_ROWS = 1 << 23, 1 << 15  # of the states of a stretch
_EVENTS = 6  # of a blow: itself, two ports, two changes of the valve, and one more
_MOST_IDLE = 17  # strides without an event end a simulation
_MANY_STRIDES = 4096  # … between two looks, of a motion that is not recorded
ENDS = {
    kn.BY_IMPACTS: "impacts",
    kn.BY_TIME: "time",
    kn.PERIODIC: "periodic",
    kn.AT_REST: "on the tool",
    kn.IN_CHAMBER: "in the chamber",
    kn.ON_PORT: "on a port",
    kn.DEPARTED: "leaves",
    kn.EMPTY: "without pressure",
}
"""What the kernels' ends are called; of a stall, where."""


@dataclass
class SelfSwitching:
    """Motions of a machine on their way: the kernels' memory, what they recorded, and what is kept of the last one."""

    mechanism: Mechanism
    plant: kn.Plant
    log: kn.Log = NO_LOG
    found: npt.NDArray[Any] = field(default_factory=lambda: np.zeros(1, kn.MEMBER))

    @property
    def modes(self) -> int:
        """N."""
        return self.mechanism.modes

    @classmethod
    def ready(cls, mechanism: Mechanism, starts: kn.MachineStarts, last: kn.Plant | None = None) -> SelfSwitching:
        """With room for the orders of these starts; see `plant_for`."""
        queue = ROOM
        while queue < starts.due.shape[1] + mechanism.gear.to.size:
            queue *= 2
        return cls(mechanism, plant_for(mechanism, queue, last))

    @classmethod
    def begun(cls, mechanism: Mechanism, start: Start, stop: Stop) -> tuple[SelfSwitching, Anchor, bool]:
        """A motion put at a start, the state there, and whether it rests on the wall."""
        starts = machine_starts(mechanism, [start])
        moved, at = cls.ready(mechanism, starts), starts.rows[0]
        moved.log = moved._room(stop)
        moved.follow(starts, stop, moved.found, 0)
        row = [at["gap"], at["rigid_rate"], *starts.z.reshape(-1), *([at["charge"]] if mechanism.supply else [])]
        anchor = Anchor(start.time, int(at["state"]), np.array(row))
        return moved, anchor, bool(at["mode"] == kn.RESTING)

    @classmethod
    def restored(cls, mechanism: Mechanism, snapshot: Kept, stop: Stop) -> SelfSwitching:
        """A motion that goes on from a snapshot that is sound."""
        moved = cls(mechanism, plant_of(mechanism, {name: np.array(values) for name, values in snapshot.items()}))
        moved.log = moved._room(stop)
        return moved

    def _room(self, stop: Stop) -> kn.Log:
        """Room for the record of a whole motion, or a stretch: memory that nothing is written into costs nothing."""
        width, ports = 2 * self.modes + kn.STATE_NUMBERS, self.mechanism.gear.to.size
        width += self.mechanism.supply is not None
        rows = max(64, min(_MOST_NUMBERS // width, _MOST_ROWS, _EVENTS * (stop.most_impacts + 16))) + 2 * ports
        return kn.Log(np.empty(rows, kn.EVENT), np.empty((rows, width)))

    def followed(
        self, stop: Stop, begin_time: float, progress: Callable[[Progress], object] | None = None
    ) -> dict[str, Any]:
        """The motion on until the stop rule holds; what a `Trajectory` has of it, by the names of its fields."""
        count, unit, stride = self.plant.motion.count, self.mechanism.unit, kn.STRIDE // (self.modes + 30)
        valve = self.plant.controls.now

        def step() -> tuple[str, bool]:
            budget = (int(count["work"]) // stride + 1) * stride
            self.follow(_NOWHERE, stop, self.found, budget, goes_on=True)
            code = int(self.found["ended"][0])
            given_up = code == kn.BY_WORK and int(count["work"]) < budget
            return "work" if given_up else ENDS.get(code, ""), code == kn.BY_WORK

        def gone() -> tuple[int, float]:
            return int(count["impacts"]), float(valve["time"]) * unit

        told, states, ended = gathered(self.log, count, step, gone, stop, progress, (_MOST_IDLE, True))
        events = self._in_units(told, begin_time)
        stalled = bool(valve["stalled"]) or (not valve["waiting"] and _released_in_vain(events))
        known, over = float(valve["time"]) * unit, ended in STALLS and ended != ENDS[kn.EMPTY]
        spring = self.mechanism.in_state(int(valve["state"])).spring
        if over and spring > 0.0:
            known += 2.0 * math.pi / spring  # it goes on for ever
        if stop.time is not None and (ended == "time" or over):
            known = stop.time
        last, cycle = float(events.time[-1]) if len(events) else begin_time, self.cycle
        return {
            "events": events,
            "states": states.copy() if 4 * states.size < self.log.states.size else states,
            "snapshot": kept(self.plant),
            "outcome": outcome_of(ended, stalled),
            "label": machine_label("in the chamber" if stalled else ended, cycle, bool(self.found["wanders"][0])),
            "cycle": cycle,
            "end_time": max(begin_time + known, last),
        }

    def follow(
        self,
        starts: kn.MachineStarts,
        stop: Stop,
        found: npt.NDArray[Any],
        budget: int,
        stopped: npt.NDArray[np.int64] = GOES_ON,
        goes_on: bool = False,
    ) -> None:
        """As `follow_valve`, with room for all orders that come to wait."""
        time, done = np.inf if stop.time is None else stop.time / self.mechanism.unit, 0
        rules = kn.Rules(np.inf, time, stop.most_impacts, stop.periodic, stop.tolerance, 0, budget)
        while True:
            done = follow_valve(self.plant, starts, rules, self.log, done, goes_on, stopped, found)
            if stopped[0] or done == len(found):
                return
            self.plant, goes_on = roomier(self.plant), True

    @property
    def cycle(self) -> MotionCycle | None:
        """The cycle that was found, in the machine's unit of time."""
        found, unit = self.found[0], self.mechanism.unit
        if found["first"] < 0:
            return None
        return MotionCycle(
            first=int(found["first"]),
            impacts=int(found["cycle_impacts"]),
            periods=int(found["cycle_periods"]),
            kind=int(found["cycle_kind"]),
            period=float(found["period"]) * unit,
            energy_lost=float(found["energy_lost_per_period"]) / unit**2,
            blow_speed=float(found["blow_speed"]) / unit,
        )

    def _in_units(self, told: Events, begin_time: float) -> Events:
        unit = self.mechanism.unit
        return replace(
            told,
            phase=begin_time + told.phase * unit,
            impact_velocity=told.impact_velocity / unit,
            rebound_velocity=told.rebound_velocity / unit,
            energy_lost=told.energy_lost / unit**2,
            kinetic_energy=told.kinetic_energy / unit**2,
            states=tuple(self.mechanism.names),
        )


def most_work(modes: int) -> int:
    """Evaluations after which a motion that is not recorded ends."""
    return _MANY_STRIDES * (kn.STRIDE // (modes + 30))


def outcome_of(ended: str, stalled: bool) -> str:
    """The outcome of a motion: a stall that is proved stays one, however far its last blows are followed."""
    return "stalls" if ended in STALLS or (stalled and ended in ("impacts", "time", "work")) else ended


def _released_in_vain(events: Events) -> bool:
    """Whether the valve heard nothing since the last release but one: what begins at rest then repeats itself."""
    releases = np.flatnonzero(events.code == RELEASE)
    return releases.size > 1 and not np.isin(events.code[releases[-2] :], (PORT, VALVE)).any()
