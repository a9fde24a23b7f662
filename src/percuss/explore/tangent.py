"""Small differences carried along a simulated motion, compiled: how they grow from impact to impact.

Whatever drives the hammer, a difference moves freely between two events, each coordinate by itself, and goes through
the saltation matrix at every event (`percuss.mechanics.cycle` has the formula; theory §5). Steps of a load are at times
that nothing moves. A machine that switches its own valve has no clock: differences are taken on the section of its
blows, the time counted anew from each, so that a shift along the motion is none. An order that waits is as much later
as the crossing that gave it, and by what the pressure makes of its delay; a supply has its pressure for a coordinate
more. While a structure of several modes rests, differences move as what the wall holds does: they begin with the shape,
and as much later as it comes to rest.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from percuss.compiled import entry, inner, twin
from percuss.mechanics import flow
from percuss.mechanics.held_structure import held_structure
from percuss.model import HeldBody
from percuss.model.checks import Array, ComplexArray
from percuss.model.load.valve import port_at
from percuss.simulate import Trajectory
from percuss.simulate.events import CHATTER, IMPACT, PORT, RELEASE, REST, VALVE, Events

free, response = twin(flow.free), twin(flow.response)

# ---- The events of a motion as rows of numbers, whatever drives it

NOTHING, CROSSED, DUE, SAME, LIFTED, CHATTERED, LAID = range(7)
"""How much later a difference makes an event: not at all; as a guard is met; as the order was given; as the event
before; as the force that rises lifts a bar that rests; as a chatter ends, counted from its last impact; as that, for
a structure that then rests and moves on."""

_LATE = 1e-9  # a step of the load this near to an event is at it
_TURN = 2.0 * math.pi
STRUCK = int(IMPACT)
END = -1  # the guard of the striking end


class Coordinates(NamedTuple):
    """What moves by itself, in each state of a valve that has modes of its own; all in what it moves the end by.

    `stiffness`, `drag`, `gain`: ω², d and the acceleration under a unit force, of the shape (states, n). `rows`: what
    each port reads, with a supply the driven place last, (states, rows, n); `speeds`: 1 where a velocity is read.
    `turned`: from the coordinates of one state to those of another, (states, states, n, n). `flow`, `draw`, `slope`: of
    a supply, (states,). `weight`: of displacements in the size of a difference, (n,). `factors`: α and β of an impact.
    `clocked`: whether time is told. `held`, `into`, `out`: of a structure of several modes at rest the exponents of
    what moves on, (h,), and the matrices from place and speed to them, (h, n, 2), and back, (n, 2, h).
    """

    stiffness: Array
    drag: Array
    gain: Array
    rows: Array
    speeds: npt.NDArray[np.int64]
    turned: Array
    flow: Array
    draw: Array
    slope: Array
    weight: Array
    factors: Array
    clocked: bool
    held: ComplexArray
    into: ComplexArray
    out: ComplexArray


class EventRows(NamedTuple):
    """Events, or steps of the load; the first is an impact. All but `gone` are of the moment just after.

    `gone`: time since the row before. `later`: how its shift is found, by which `guard`, or which `slot` of orders;
    `given`: the slot of the order that it gives, −1 for none; `quickens`: by how much the charge of a supply shortens
    the delay of that. `step`: whether the motion only goes on. `place` and `speed` are without the waves, which
    harmonics make, `waves` velocity and acceleration of these. `begun`: the acceleration with which what moves on at
    rest begins.
    """

    gone: Array
    code: npt.NDArray[np.int8]
    later: npt.NDArray[np.int8]
    guard: npt.NDArray[np.int64]
    slot: npt.NDArray[np.int64]
    given: npt.NDArray[np.int64]
    quickens: Array
    step: npt.NDArray[np.bool_]
    rests: npt.NDArray[np.bool_]
    state: npt.NDArray[np.int64]
    force: Array
    place: Array
    speed: Array
    waves: Array
    begun: Array


def told(motion: Trajectory, first: int) -> tuple[Coordinates, EventRows]:
    """The rows of a motion from an impact on, by its number among the events."""
    return _clocked(motion, first) if motion.is_clocked else _self_switching(motion, first)


def _clocked(motion: Trajectory, first: int) -> tuple[Coordinates, EventRows]:
    spectrum, system, e = motion.spectrum, motion.system, motion.events[first:]
    begin = int(isinstance(system.body, HeldBody))  # it has no motion as a whole
    omega, gain = np.append(0.0, spectrum.omega)[begin:], np.append(1.0, spectrum.elastic.gamma)[begin:]
    steps, load = np.asarray(system.load.values), system.load
    mean = steps[e.piece] if steps.size else np.full(len(e), load.mean)
    z = motion.states[first:, 2:].reshape(len(e), 2, motion.modes)
    k = spectrum.k
    angles = np.outer(e.phase, k)
    shapes = np.hstack([spectrum.rigid[:, None], spectrum.response])[:, begin:]
    moved = np.hstack([1j * k[:, None] * shapes, -((k**2)[:, None]) * shapes])
    turned = np.hstack([np.cos(angles), np.sin(angles)]) @ np.vstack([moved.real, -moved.imag])
    waves = turned.reshape(len(e), 2, -1) if k.size else np.zeros((1, 2, omega.size))
    speed = np.hstack([motion.states[first:, 1:2], spectrum.free_rate(z)])[:, begin:]
    if not begin and k.size:
        speed[:, 0] -= waves[:, 0, 0]
    place = np.hstack([np.zeros((len(e), 1)), z[:, 0] + mean[:, None] * spectrum.statics])[:, begin:]
    later = np.where(e.code == IMPACT, CROSSED, NOTHING).astype(np.int8)
    gone = np.append(0.0, np.diff(e.period) * _TURN + np.diff(e.phase))
    no = np.full(len(e), -1)
    held, begun = _nothing_held(omega.size), np.zeros((1, omega.size))
    if begin and motion.modes > 1:
        held = held_structure(system, motion.modes).exponents
        later[e.code == REST] = LAID
        pull = gain * load.value(e.phase)[:, None] - omega**2 * spectrum.unit * motion.displacement[first:, 1:]
        begun = pull - np.outer(pull.sum(axis=1) / (1.0 / spectrum.inertia).sum(), 1.0 / spectrum.inertia)
    rows = EventRows(
        gone, e.code, later, no, no, no, 0.0 * mean, np.zeros(len(e), bool), motion.lies[first + 1 :], 0 * no, mean,
        place, speed, waves, begun,
    )  # fmt: skip
    none = np.zeros(1)
    own = Coordinates(
        omega[None] ** 2, np.append(system.d, spectrum.damping)[None, begin:], gain[None], np.empty((1, 0, omega.size)),
        np.zeros(0, np.int64), np.empty((1, 1, 0, 0)), none, none, none, np.where(omega > 0.0, omega, 1.0),
        _factors(motion), True, *held,
    )  # fmt: skip
    return own, _over_steps(rows, e, np.asarray(load.breaks), steps) if steps.size else rows


def _nothing_held(size: int) -> tuple[ComplexArray, ComplexArray, ComplexArray]:
    return np.zeros(0, complex), np.zeros((0, size, 2), complex), np.zeros((size, 2, 0), complex)


def _factors(motion: Trajectory) -> Array:
    contact = motion.hammer.contact
    return np.array([contact.strain_factor, contact.velocity_factor])


def _over_steps(rows: EventRows, e: Events, breaks: Array, values: Array) -> EventRows:
    """With a row for each step of the load between two events."""
    following = np.append(rows.gone[1:], 0.0)
    ahead = np.mod(breaks - e.phase[:, None], _TURN)
    turns = _TURN * np.arange(int(following.max(initial=0.0) / _TURN) + 1)
    times = ahead[:, :, None] + turns
    at, number, turn = np.nonzero((times > _LATE) & (times < following[:, None, None] - _LATE))
    since = times[at, number, turn]
    order = np.lexsort((np.append(np.zeros(len(e)), since), np.append(np.arange(len(e)), at)))
    which, step = np.append(np.arange(len(e)), at)[order], order >= len(e)
    when = np.append(np.zeros(len(e)), since)[order]
    force = np.append(rows.force, values[number])[order]
    gone = np.where(step, when, rows.gone[which]) - np.append(0.0, when[:-1])
    parts: list[Any] = [part if part.shape[0] == 1 else part[which] for part in rows]
    taken = EventRows(*parts)
    later = np.where(step, NOTHING, taken.later).astype(np.int8)
    return taken._replace(gone=gone, step=step, later=later, force=force)


def _self_switching(motion: Trajectory, first: int) -> tuple[Coordinates, EventRows]:
    mechanism, e, states = motion.mechanism, motion.events[first:], motion.states[first:]
    fed = mechanism.supply is not None
    sets = mechanism.states_of if fed else [mechanism]
    unit, ports, size = mechanism.unit, mechanism.machine.valve.ports, motion.modes + 1
    place, speed, force = np.empty((len(e), size)), np.empty((len(e), size)), np.empty(len(e))
    for piece, one in enumerate(mechanism.states_of):
        here = e.piece == piece
        place[here], speed[here] = one.bound(states[here])
        force[here] = one.force_of(states[here])
    omega = np.array([np.append(one.spring, one.slow.omega) for one in sets]) * unit
    drag = np.array([np.append(mechanism.machine.drag, one.slow.damping) for one in sets]) * unit
    gain = np.array([np.append(one.gear.gain, one.slow.statics * one.slow.omega**2) for one in sets])
    turned = np.array([[a.turned(b) for b in sets] for a in sets]) if fed else np.empty((1, 1, 0, 0))
    flow, draw, slope = np.array([[one.gear.flow, one.gear.draw, one.gear.slope] for one in sets]).T.copy()
    own = Coordinates(
        omega**2, drag, gain, np.array([one.gear.ratio for one in sets]), mechanism.gear.speeds, turned, flow, draw,
        slope, np.where(omega[0] > 0.0, omega[0], 1.0), _factors(motion), False, *_nothing_held(size),
    )  # fmt: skip
    gone = np.append(0.0, np.diff(e.phase)) / unit
    at_once = gone == 0.0
    before = np.append(-1, e.code[:-1])
    later = np.full(len(e), NOTHING, dtype=np.int8)
    later[e.code == IMPACT] = CROSSED
    later[e.code == CHATTER] = CHATTERED
    later[((e.code == REST) | (e.code == RELEASE)) & at_once] = SAME
    later[(e.code == RELEASE) & ~(at_once & (before == VALVE)) & fed] = LIFTED
    crossing = np.array([port.side is not None for port in ports] + [False])[e.port] & ~at_once
    later[e.code == PORT] = np.where(crossing, CROSSED, SAME)[e.code == PORT]
    slot, given, quickens = _orders(motion, e)
    later[slot >= 0] = DUE
    rows = EventRows(
        gone, e.code, later, np.where(e.code == PORT, e.port, END), slot, given, quickens, np.zeros(len(e), bool),
        motion.lies[first + 1 :], e.piece if fed else 0 * e.piece, force, place, speed, np.zeros((1, 2, size)),
        np.zeros((1, size)),
    )  # fmt: skip
    return own, rows


def _orders(motion: Trajectory, e: Events) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64], Array]:
    """Of each event the slots of the order that it carries out and of that which it gives, −1 for none; `quickens`."""
    # The order that a change of the valve carries out is that to its state which was due then.
    valve, unit, names = motion.machine.valve, motion.mechanism.unit, motion.mechanism.names
    to, quickens = [names.index(port.to) for port in valve.ports], np.zeros(len(e))
    pressure = motion.pressure(e.time) if valve.delays_vary else np.ones(len(e))
    waiting: list[tuple[float, int]] = []
    pairs: list[tuple[int, int]] = []
    for i in np.flatnonzero((e.code == PORT) | (e.code == VALVE)).tolist():
        time = float(e.phase[i])
        if e.code[i] == PORT:
            delay = port_at(valve, e.port[i], pressure[i]).delay
            waiting.append((time + delay, i))
            if valve.supply is not None and valve.delays_vary and delay > 0.0:
                change = valve.supply.quickening * delay * delay / valve.ports[e.port[i]].delay
                quickens[i] = change / (valve.supply.compliance * unit**3)
            continue
        mine = [(abs(due - time), by) for due, by in waiting if to[e.port[by]] == e.piece[i]]
        if mine:
            pairs.append((min(mine)[1], i))
        waiting = [one for one in waiting if one[0] > time]
    slot, given = np.full(len(e), -1), np.full(len(e), -1)
    if pairs:
        by, due = np.array(pairs).T
        number = np.arange(by.size)
        number %= int((np.searchsorted(by, due) - number).max())  # orders are carried out as they were given
        slot[due], given[by] = number, number
    return slot, given, quickens


# ---- The differences, carried from impact to impact

LOST = 1e-14  # of a column: what is left beside the ones before it is rounding


def differences(own: Coordinates, rows: EventRows, columns: int) -> tuple[Array, Array]:
    """Where the columns begin: of displacement and velocity, (n, 2, C), of pressure and orders, (1 + slots, C)."""
    n = own.weight.size
    now, more = np.zeros((2 * n, columns)), np.zeros((2 + int(rows.given.max(initial=-1)), columns))
    whole = np.array([[1.0, 1.0]]) if n and own.stiffness[0, 0] == 0.0 else np.empty((0, 2))
    omega = np.sqrt(own.stiffness[0, len(whole) :])
    shares = 1.0 / (np.arange(omega.size) + 2.0)
    elastic = np.stack([shares, (omega - 0.5 * own.drag[0, len(whole) :]) * shares], axis=1)
    now[:, 0] = np.concatenate([whole, elastic]).reshape(-1)
    rest = np.arange(1, columns)
    now[rest[rest < 2 * n], rest[rest < 2 * n]] = 1.0
    more[rest[rest >= 2 * n] - 2 * n, rest[rest >= 2 * n]] = 1.0
    return now.reshape(n, 2, columns), more


def growths(motion: Trajectory, first: int, every: bool) -> Array:
    """Logarithm of the growth from impact to impact after event number `first`; shape (impacts, exponents)."""
    own, rows = told(motion, first)
    n, fed = own.weight.size, bool(own.flow.any())
    columns = 2 * n if own.clocked else 2 * n - 1 + fed + _waiting(rows)
    now, more = differences(own, rows, columns if every else 1)
    growth = np.empty((max(int(np.count_nonzero(motion.events.code[first:] == IMPACT)) - 1, 1), now.shape[2]))
    waits = np.zeros(more.shape[0], dtype=np.int64)
    found = log_growths(
        own, rows, now, more, waits, np.zeros((4, n, 2)), np.zeros((4, now.shape[2])), np.zeros_like(own.held), growth
    )
    return growth[:found]


def _waiting(rows: EventRows) -> int:
    """The most orders that wait at an impact."""
    events, struck = np.arange(rows.code.size), np.flatnonzero((rows.code == IMPACT) & ~rows.step)
    given, carried = events[rows.given >= 0], events[rows.slot >= 0]
    return int((np.searchsorted(given, struck) - np.searchsorted(carried, struck)).max(initial=0))


@inner
def flown(own, k, gone, force, now, more, motion, charge):
    """Free motions in the coordinates of state k, in place: of the hammer under a force, and of the differences."""
    gain, draw, slope, ramp = own.gain[k], own.draw[k], own.slope[k], own.slope[k] * own.flow[k]
    for j in range(charge.shape[0]):
        charge[j] = more[0, j] + draw * moved(own.rows[k], now, 0, j) if draw != 0.0 else 0.0
    for m in range(motion.shape[0]):
        square, drag, lift = own.stiffness[k, m], own.drag[k, m], gain[m] * slope
        u, v = motion[m, 0], motion[m, 1]
        if slope == 0.0:  # about its place at rest; of what has none only the velocity is asked for
            ds, s = free(gone, square, drag)
            q, rest = 0.0, gain[m] * force / square if square > 0.0 else u
            motion[m, 0] = rest + (u - rest) * (ds + drag * s) + v * s
            motion[m, 1] = v * ds + (gain[m] * force - square * u) * s
        else:
            ds, s, q, w = response(gone, square, drag)
            pull, climb = gain[m] * force - square * u, gain[m] * ramp
            motion[m, 0], motion[m, 1] = u + v * s + pull * q + climb * w, v * ds + pull * s + climb * q
        left = ds + drag * s  # of a displacement, without a force
        for j in range(charge.shape[0]):
            u, v, more_force = now[m, 0, j], now[m, 1, j], lift * charge[j]
            now[m, 0, j], now[m, 1, j] = u * left + v * s + more_force * q, v * ds + (more_force - square * u) * s
    if draw != 0.0:
        for j in range(charge.shape[0]):
            more[0, j] = charge[j] - draw * moved(own.rows[k], now, 0, j)


@inner
def moved_on(own, gone, now, room):
    """Differences of what the wall holds, in place: those of its contact end here."""
    for j in range(now.shape[2]):
        for h in range(own.held.shape[0]):
            room[h] = 0.0
            for m in range(now.shape[0]):
                room[h] += own.into[h, m, 0] * now[m, 0, j] + own.into[h, m, 1] * now[m, 1, j]
            room[h] *= np.exp(own.held[h] * gone)
        for m in range(now.shape[0]):
            for part in range(2):
                total = 0.0
                for h in range(own.held.shape[0]):
                    total += (own.out[m, part, h] * room[h]).real
                now[m, part, j] = total


@inner
def moved(rows, now, part, j):
    """What a difference moves the driven place of a machine with a supply by, or its speed."""
    total = 0.0
    for m in range(now.shape[0]):
        total += rows[rows.shape[0] - 1, m] * now[m, part, j]
    return total


@inner
def rates_at(own, rows, i, k, force, motion, rests, found):
    """Velocity and acceleration of the motion at row i, in the coordinates of state k."""
    for m in range(found.shape[0]):
        found[m, 0] = found[m, 1] = 0.0
        if not rests:
            found[m, 0] = motion[m, 1]
            found[m, 1] = own.gain[k, m] * force - own.stiffness[k, m] * motion[m, 0] - own.drag[k, m] * motion[m, 1]
            if rows.waves.shape[0] > 1:
                found[m, 0] += rows.waves[i, 0, m]
                found[m, 1] += rows.waves[i, 1, m]


@inner
def met_later(own, rows, i, k, now, before, j):
    """How much later a guard is met: that of the striking end, or of a port."""
    guard = rows.guard[i]
    part = 0 if guard == END else own.speeds[guard]
    off = rate = 0.0
    for m in range(now.shape[0]):
        weight = 1.0 if guard == END else own.rows[k, guard, m]
        off += weight * now[m, part, j]
        rate += weight * before[m, part]
    return -off / rate


@inner
def handed(turned, now, room):
    """The coordinates of another state of the valve."""
    for part in range(2):
        for j in range(now.shape[2]):
            for m in range(now.shape[0]):
                room[m] = 0.0
                for other in range(now.shape[0]):
                    room[m] += turned[m, other] * now[other, part, j]
            for m in range(now.shape[0]):
                now[m, part, j] = room[m]


@inner
def orthonormal(weight, now, more, late, growth):
    """Gram and Schmidt's columns in the size that a difference has, and the logarithm of what each was long."""
    # what is kept of an impact until a chatter ends, in `late`, goes with them
    for j in range(now.shape[2]):
        whole = left = inside(weight, now, more, j, j)
        for i in range(j):
            part = inside(weight, now, more, i, j)
            added(now, more, late, j, -part, i)
            left = inside(weight, now, more, j, j)
        if j > 0 and not left > LOST * LOST * whole:
            left = 0.0
        growth[j] = 0.5 * math.log(left) if left > 0.0 else -math.inf
        scale = 1.0 / math.sqrt(left) if left > 0.0 else 0.0
        added(now, more, late, j, scale - 1.0, j)


@inner
def inside(weight, now, more, i, j):
    """The inner product of two columns."""
    total = 0.0
    for m in range(now.shape[0]):
        total += weight[m] * weight[m] * now[m, 0, i] * now[m, 0, j] + now[m, 1, i] * now[m, 1, j]
    for m in range(more.shape[0]):
        total += more[m, i] * more[m, j]
    return total


@inner
def added(now, more, late, j, share, i):
    """A share of column i on column j."""
    for m in range(now.shape[0]):
        now[m, 0, j] += share * now[m, 0, i]
        now[m, 1, j] += share * now[m, 1, i]
    for m in range(more.shape[0]):
        more[m, j] += share * more[m, i]
    for m in (1, 3):
        late[m, j] += share * late[m, i]


@entry
def log_growths(own, rows, now, more, waits, room, late, amounts, growth):
    """Logarithms of the growth of differences over each flight and impact, into `growth`; returns of how many."""
    # `now`, `more`: the columns, as `differences` says; `waits`, zeros: whether each order waits; `room`: of the
    # motion, its rates on the two sides of an event and one more, of the shape (4, n, 2); `late`: four rows of a
    # number for each column; `amounts`: a number for each exponent at rest.
    motion, before, after, other = room[0], room[1], room[2], room[3, :, 0]
    shift, rebound, charge, at_impact = late[0], late[1], late[2], late[3]
    size, columns, impacts, since = now.shape[0], now.shape[2], 0, 0.0
    for i in range(rows.gone.shape[0]):
        struck = rows.code[i] == STRUCK and not rows.step[i]
        k, to = rows.state[max(i - 1, 0)], rows.state[i]
        if i > 0:
            since += rows.gone[i]
            if not rows.rests[i - 1]:
                flown(own, k, rows.gone[i], rows.force[i - 1], now, more, motion, charge)
            elif amounts.shape[0] > 0:
                moved_on(own, rows.gone[i], now, amounts)
            if rows.step[i]:
                continue
            force = rows.force[i - 1] + own.slope[k] * own.flow[k] * rows.gone[i]
            rates_at(own, rows, i, k, force, motion, rows.rests[i - 1], before)
        for m in range(size):
            motion[m, 0], motion[m, 1] = rows.place[i, m], rows.speed[i, m]
        if i == 0:
            continue
        rates_at(own, rows, i, to, rows.force[i], motion, rows.rests[i], after)
        drawn = own.draw[to] * moved(own.rows[to], after.reshape(size, 2, 1), 0, 0) if own.flow[to] > 0.0 else 0.0
        drawn_before = own.draw[k] * moved(own.rows[k], before.reshape(size, 2, 1), 0, 0) if own.flow[to] > 0.0 else 0.0
        for j in range(columns):
            how = rows.later[i]
            if how == CROSSED:
                shift[j] = met_later(own, rows, i, k, now, before, j)
            elif how == DUE:
                shift[j] = more[1 + rows.slot[i], j]
                more[1 + rows.slot[i], j] = 0.0
            elif how == LIFTED:
                shift[j] = -more[0, j] / own.flow[to]
            elif how == CHATTERED:
                shift[j] = since * rebound[j]
            elif how == LAID:
                shift[j] = at_impact[j] + since * rebound[j]
            elif how == NOTHING:
                shift[j] = 0.0
            for m in range(size):
                now[m, 0, j] += before[m, 0] * shift[j]
                now[m, 1, j] += before[m, 1] * shift[j]
            more[0, j] += (own.flow[to] - drawn_before) * shift[j]
            charge[j] = more[0, j]  # where the event is
        if rows.slot[i] >= 0:
            waits[1 + rows.slot[i]] = 0
        if to != k:
            handed(own.turned[k, to], now, other)
        if rows.rests[i] and amounts.shape[0] == 0:
            now[:] = 0.0
        elif rows.later[i] == LAID:
            for j in range(columns):
                for m in range(size):
                    now[m, 0, j] -= before[m, 0] * shift[j]  # the bounces in between move nothing
                    now[m, 1, j] = -rows.begun[i, m] * shift[j]
                shift[j] = 0.0
        if struck:
            since, rate = 0.0, 0.0
            for m in range(size):
                rate += after[m, 0]
            for j in range(columns):
                rebound[j], at_impact[j] = 0.0, shift[j]
                for m in range(size):
                    now[m, 0, j] *= own.factors[0]
                    now[m, 1, j] *= own.factors[1]
                    rebound[j] += now[m, 1, j] / rate if rate != 0.0 else 0.0
                if not own.clocked:  # the time anew
                    for one in range(1, more.shape[0]):
                        more[one, j] -= shift[j] * waits[one]
                    shift[j] = 0.0
        for j in range(columns):
            for m in range(size):
                now[m, 0, j] -= after[m, 0] * shift[j]
                now[m, 1, j] -= after[m, 1] * shift[j]
            more[0, j] -= (own.flow[to] - drawn) * shift[j]
            if rows.given[i] >= 0:
                more[1 + rows.given[i], j] = shift[j] - rows.quickens[i] * charge[j]
        if rows.given[i] >= 0:
            waits[1 + rows.given[i]] = 1
        if struck:
            orthonormal(own.weight, now, more, late, growth[impacts])
            impacts += 1
            if not -math.inf < growth[impacts - 1, 0] < math.inf:
                return impacts
    return impacts
