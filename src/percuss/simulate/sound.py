"""What a saved motion, and the state that it goes on from, must be before anything is made of them.

A file may be cut short, changed by a bad disk, or made by somebody who means harm, and the kernels check no bound
themselves. All of it raises ValueError, which says what cannot be.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from percuss.model import Machine, System
from percuss.model.checks import count, finite
from percuss.simulate.events import IMPACT, KINDS, Events, MotionCycle
from percuss.simulate.kernels.motion_records import (
    COUNT,
    GRAZED,
    LOST_CYCLE,
    NOW,
    PAST,
    STATE_NUMBERS,
    SUMS,
    TURN,
    WINDOW,
)
from percuss.simulate.stop import MAX_MODES, MOST_IMPACTS, OUTCOMES

Motion: TypeAlias = Any  # a Trajectory, which is made of what this lets through
_MOST = 1e100  # no number of a motion is greater: its square must not overflow


def true(good: object, what: str) -> None:
    """Refuse what does not hold."""
    if not good:
        raise ValueError(f"{what} is impossible")


def shaped(name: str, values: npt.NDArray[Any], dtype: npt.DTypeLike, shape: tuple[int, ...]) -> None:
    """Refuse another type or shape."""
    true(isinstance(values, np.ndarray) and values.dtype == np.dtype(dtype), f"the type of {name}")
    true(values.shape == shape, f"the shape {values.shape} of {name}")


def numbers(name: str, values: npt.NDArray[Any], shape: tuple[int, ...]) -> None:
    """Refuse what is not an array of finite numbers of this shape."""
    shaped(name, values, np.float64, shape)
    true(np.all(np.abs(values) <= _MOST), f"a value of {name}")  # false of NaN too


def within(name: str, values: npt.ArrayLike, low: float, high: float) -> None:
    """Refuse numbers outside of an interval, and NaN."""
    array = np.asarray(values)
    true(np.all((array >= low) & (array <= high)), f"a value of {name}")


# ---- A saved motion
#
# Shapes and types follow from the number of modes; whole numbers that are used as places in an array must be places in
# it; all others must be finite, and where they count something, no less than 0. Impacts must obey the impact law.

MOST_PERIODS = 2**53
_ROUNDING = 1e-9


def sound(motion: Motion, kinds: Mapping[str, str]) -> None:
    """Refuse a motion of which not all can be what a simulation has left; `kinds`: types of the columns of events."""
    modes = count("modes", motion.modes, least=0, most=MAX_MODES)
    true(motion.outcome in OUTCOMES, f"outcome {str(motion.outcome)[:40]!r}")
    true(isinstance(motion.label, str) and len(motion.label) <= 100, "label")
    true(isinstance(motion.resting, bool), "resting")
    begin, end = finite("begin_time", motion.begin_time), finite("end_time", motion.end_time)
    true(begin <= end, "end_time")
    hammer = motion.hammer
    pieces = max(len(hammer.load.values), 1) if isinstance(hammer, System) else len(hammer.valve.pairs)
    within(
        "start_phase", finite("start_phase", motion.start.phase), *((0.0, TURN) if motion.is_clocked else (begin,) * 2)
    )
    count("start_piece", motion.start.piece, least=0, most=pieces - 1)
    row = width(hammer, modes)
    numbers("start_state", motion.start.row, (row,))
    _events(motion.events, kinds, pieces, 0 if isinstance(hammer, System) else len(hammer.valve.ports))
    numbers("state", motion.states, (len(motion.events), row))
    _impacts(motion)
    _cycle(motion.cycle, motion.impacts)


def _events(events: Events, kinds: Mapping[str, str], pieces: int, ports: int) -> None:
    shape = np.shape(events.code)
    true(len(shape) == 1, "the shape of code")
    for name, kind in kinds.items():
        if kind == "float64":
            numbers(name, getattr(events, name), shape)
        else:
            shaped(name, getattr(events, name), kind, shape)
    within("code", events.code, 0, len(KINDS) - 1 if events.states else KINDS.index("port") - 1)
    if events.states:
        true(not events.period.any(), "a value of period")
    else:
        within("period", events.period, -MOST_PERIODS, MOST_PERIODS)
        within("phase", events.phase, 0.0, TURN)
    within("resolved", events.resolved, 0, MOST_IMPACTS)
    within("piece", events.piece, 0, pieces - 1)
    within("port", events.port, -1, ports - 1)
    true(np.all(np.diff(events.time) >= 0.0), "the order of the events")


def _impacts(motion: Motion) -> None:
    """The impact law, B77 10, and the wall: what it takes, how fast the end leaves, that nothing is beyond it."""
    contact, events, at = motion.hammer.contact, motion.events, motion.events.code == IMPACT
    beta = contact.velocity_factor
    speed, blow, most = events.impact_velocity[at], events.kinetic_energy[at], 1.0 + _ROUNDING
    true(np.all(speed >= 0.0) and np.all(blow >= 0.0), "the speed of an impact")
    true(np.all(np.abs(events.rebound_velocity[at] - beta * speed) <= _ROUNDING * speed), "the rebound of an impact")
    taken = (
        events.energy_lost[at] - contact.energy_taken(1.0, 0.0) * blow
    )  # by the strain, where the impact turns it over
    flows = isinstance(motion.hammer, Machine) and motion.hammer.valve.flows
    if flows and not contact.keeps_strain:  # the driven end is turned over, and a gas behind it holds more or less
        true(np.all(np.isfinite(taken)), "what an impact takes")
    else:
        true(np.all((-np.abs(taken) if contact.keeps_strain else taken) >= -_ROUNDING * blow), "what an impact takes")
    true(np.all(events.energy_lost >= 0.0) and not np.any(events.kinetic_energy[~at]), "the energy of an event")
    if not motion.is_clocked:
        return
    place, rigid = motion.states[:, 0], motion.states[:, 1]
    noise = _ROUNDING * np.abs(motion.states).max(initial=0.0)
    true(not np.any(place[at]) and np.all(place <= noise), "the place of an event")
    true(np.all(np.abs(rigid[at]) <= most * abs(beta) * np.sqrt(2.0 * blow)), "the mean velocity after an impact")


def _cycle(cycle: MotionCycle | None, impacts: int) -> None:
    if cycle is None:
        return
    count("first", cycle.first, least=0, most=impacts)
    count("impacts", cycle.impacts, least=0, most=max(impacts, 1))
    count("periods", cycle.periods, least=0, most=MOST_PERIODS)
    count("kind", cycle.kind, least=0, most=2)
    for name in ("period", "energy_lost", "blow_speed"):
        true(finite(name, getattr(cycle, name)) >= 0.0, name)


def width(hammer: System | Machine, modes: int) -> int:
    """Numbers of a state."""
    if isinstance(hammer, Machine) and hammer.valve.flows:
        from percuss.simulate.oil import OilFlights  # the compiler

        return OilFlights(hammer, modes).width
    return 2 * modes + 2 + (isinstance(hammer, Machine) and hammer.valve.supply is not None)


# ---- The state that a motion under a clock goes on from
#
# The engine keeps the state after the last event, the one that later ones are compared with, the last impacts and
# running sums. All of them are known from the record, most to the last bit: both must agree.

_MOST_WORK = 2**62

_ENDLESS = ("hold", "last_flight", "since", "pushes")
"""Times among the numbers of the anchor: infinite when nothing bounds them."""

RECORDS = {"now": (NOW, 1), "count": (COUNT, 1), "past": (PAST, WINDOW), "sums": (SUMS, 2)}
"""Type and number of the records of a snapshot."""

OF_SNAPSHOT = ("z", "cycle", *RECORDS)


def kept(motion: Motion) -> None:
    """Refuse a state to go on from that does not agree with the events and states of a motion under a clock."""
    snapshot, system, modes = motion.snapshot, motion.system, motion.modes
    for name in OF_SNAPSHOT:
        true(name in snapshot, f"that there is no engine_{name}")
    for name in ("z", "cycle"):
        numbers(f"engine_{name}", snapshot[name], (2, modes))
    for name, (kind, size) in RECORDS.items():
        shaped(f"engine_{name}", snapshot[name], kind, (size,))
    for name in ("past", "sums"):
        values = snapshot[name].view(np.float64)
        numbers(f"engine_{name}", values, values.shape)
    _now(snapshot["now"])
    _counts(snapshot["count"], max(len(system.load.values), 1), motion.impacts, len(motion.events))
    for agrees in (_ends, _anchor, _bounds_of_the_flight, _last_impacts, _compared_with, _sums):
        agrees(motion)


def _now(now: npt.NDArray[Any]) -> None:
    bounded = now.copy()
    for name in _ENDLESS:
        bounded[name] = np.where(np.isposinf(now[name]), 0.0, now[name])
    values = bounded.view(np.float64)
    numbers("engine_now", values, values.shape)
    phase = float(now["phase"][0])
    within("engine_now", phase, 0.0, TURN)
    # else the load that the kernels see is another one than the phase says
    for name, exact in (("cosine", math.cos(phase)), ("sine", math.sin(phase))):
        within("engine_now", now[name], exact - 1e-9, exact + 1e-9)


def _counts(whole: npt.NDArray[Any], pieces: int, impacts: int, events: int) -> None:
    most = dict.fromkeys(COUNT.names or (), _MOST_WORK)
    least = dict.fromkeys(most, 0)
    for name in ("period", "anchor_period", "release_period", "mark_period", "cycle_periods"):
        least[name], most[name] = -MOST_PERIODS, MOST_PERIODS
    least["cycle_periods"] = 0
    most["piece"], most["mode"], most["cycle_kind"] = pieces - 1, GRAZED, 2
    least["impacts"] = most["impacts"] = impacts  # as many as are recorded
    most |= dict.fromkeys(("run", "anchor", "cycle_impacts", "confirmed", "found_at", "mark"), impacts)
    most |= dict.fromkeys(("rests", "chatters", "mark_releases", "mark_chatters"), events)
    most |= dict.fromkeys(("patience", "mark_patience"), 2 * events + 1)  # doubled when so many have gone by
    most["verdict"], most["events"] = LOST_CYCLE, 0
    for name in most:
        true(least[name] <= whole[name][0] <= most[name], f"{name} of engine_count")


_HELD = 1e-8  # time after a graze in which none is looked for


def _same(name: str, found: npt.ArrayLike, kept: npt.ArrayLike) -> None:
    true(np.array_equal(np.asarray(found), np.asarray(kept)), f"{name}, which is not what the events say,")


def _ends(motion: Motion) -> None:
    """After an impact the modes move as fast, all together and at the end, as the event says; theory §2, B77 10."""
    # a bar of few modes that is beyond the wall after a release strikes with no speed, whatever its modes do
    at = (motion.events.code == IMPACT) & (motion.events.impact_velocity > 0.0)
    rates, blow = motion.velocity[at], motion.events.kinetic_energy[at]
    ends = rates * np.append(1.0, motion.spectrum.unit)
    noise = _ROUNDING * (np.sqrt(blow) + np.abs(motion.states[at, 1:]).sum(axis=1))
    off = np.abs(ends.sum(axis=1) - motion.events.rebound_velocity[at])
    quickest = float(motion.spectrum.omega.max(initial=0.0))
    strongest = max(motion.system.d, float(motion.spectrum.damping.max(initial=0.0)))
    true(np.all(off <= noise * (1.0 + quickest / np.pi + strongest)), "the speed of a state")
    kinetic = 0.5 * rates[:, 0] ** 2 + 0.5 * (rates[:, 1:] ** 2) @ motion.spectrum.weight
    left = motion.system.contact.velocity_factor**2 * blow
    true(np.all(np.abs(kinetic - left) <= 1e-6 * blow + noise**2), "the kinetic energy of a state")


def _anchor(motion: Motion) -> None:
    """The state after the last event, or at the start; under a load of steps it may be at a later one of them."""
    now, count, events = motion.snapshot["now"][0], motion.snapshot["count"][0], motion.events
    row, phase, period = motion.start.row, motion.start.phase, int(count["period"])
    if len(events):
        row, phase, period = motion.states[-1], float(events.phase[-1]), int(events.period[-1])
    place, rate = (float(x) for x in row[:STATE_NUMBERS])
    z = row[STATE_NUMBERS:].reshape(2, motion.modes)
    at = count["period"] * TURN + now["phase"]
    since = at - (period * TURN + phase) if len(events) else at - motion.begin_time
    slack = 1e-6 * (1.0 + abs(motion.end_time))
    true(since >= -slack and at <= motion.end_time + slack, "the time of engine_now")
    if motion.system.load.is_piecewise and (now["phase"] != phase or count["period"] != period):
        true(now["phase"] in motion.system.load.breaks, "the phase of engine_now")
        return
    _same("engine_now", (now["gap"], now["rigid_rate"], now["phase"]), (place, rate, phase))
    _same("engine_count", count["period"], period)
    _same("engine_z", motion.snapshot["z"], z)
    if len(events):
        true(now["gap_rate"] in (0.0, events.rebound_velocity[-1]), "the speed of engine_now")


def _bounds_of_the_flight(motion: Motion) -> None:
    """What is proved of the flight follows from the amplitudes; and no finite free time is longer than the motion."""
    from percuss.simulate.engine import prepared
    from percuss.simulate.kernels.bounds import bounded  # the compiler

    _, table = prepared(motion.system, motion.modes)
    now = motion.snapshot["now"][0]
    fresh = np.zeros(1, NOW)[0]
    bounded(table.bar, table.modes, np.ascontiguousarray(motion.snapshot["z"]), fresh)
    bounds = ("sup", "sup1", "sup2", "sup3")
    for name, scale in (
        ("free", "sup"),
        ("free_oscillating", "sup"),
        ("free_curve", "sup2"),
        *zip(bounds, bounds, strict=True),
    ):
        true(abs(fresh[name] - now[name]) <= _ROUNDING * abs(fresh[scale]), "a bound of engine_now")
    long = max(motion.end_time - motion.begin_time, 0.0) + TURN
    hold = float(now["hold"])
    if len(motion.events) and motion.events.code[-1] == IMPACT and motion.outcome not in ("work", "interrupted"):
        within("engine_now", hold, 0.0, _HELD)
    elif np.isfinite(hold):
        within("engine_now", hold, 0.0, long + 1.5 * motion.system.body.transit_time)
    times = np.array([now["last_flight"], now["since"]])
    within("engine_now", times[np.isfinite(times)], -1.0, long)
    within("engine_now", now["kinetic_energy"], 0.0, motion.events.kinetic_energy.max(initial=0.0))


def _last_impacts(motion: Motion) -> None:
    struck, past = motion.events[motion.events.code == IMPACT], motion.snapshot["past"]
    kept = np.zeros_like(past)
    last = np.arange(max(len(struck) - WINDOW, 0), len(struck))
    for name, values in (("phase", struck.phase), ("speed", struck.impact_velocity), ("period", struck.period)):
        kept[name][last & (WINDOW - 1)] = values[last]
    _same("engine_past", past, kept)


def _compared_with(motion: Motion) -> None:
    cycle, now, number = motion.snapshot["cycle"], motion.snapshot["now"][0], int(motion.snapshot["count"]["anchor"][0])
    kept = [now["anchor_phase"], now["anchor_speed"], now["anchor_rigid_rate"]]
    if number == 0:
        _same("engine_cycle", cycle, np.zeros_like(cycle))
        _same("engine_now", kept, [0.0, 0.0, 0.0])
        return
    at = int(np.flatnonzero(motion.events.code == IMPACT)[number - 1])
    state, events = motion.states[at], motion.events
    _same("engine_cycle", cycle, state[STATE_NUMBERS:].reshape(2, motion.modes))
    _same("engine_now", kept, [events.phase[at], events.impact_velocity[at], state[1]])


def _sums(motion: Motion) -> None:
    """No sum is more than that of all events, and none is negative but a load period."""
    events, sums, now = motion.events, motion.snapshot["sums"], motion.snapshot["now"][0]
    struck = events[events.code == IMPACT]
    n, long = float(len(struck)), max(motion.end_time - motion.begin_time, 0.0)
    most: npt.NDArray[Any] = np.zeros(1, SUMS)
    for name, bound in (
        (("all", "main", "open", "struck"), n),
        (("all_time", "main_time", "open_time"), long),
        (("all_squares", "main_squares", "open_squares"), long * long),
        (("speeds", "open_speeds"), struck.impact_velocity.sum()),
        (("blows", "open_blows"), struck.kinetic_energy.sum()),
        (("taken",), events.energy_lost.sum()),
    ):
        for each in name:
            most[each] = bound
    _between(sums.view(np.float64).reshape(2, -1), most.view(np.float64))
    periods = np.array([now["struck_period"], now["blow_period"]])
    kept: npt.NDArray[Any] = sums
    whole = np.concatenate([*(kept[name] for name in ("all", "main", "open", "struck")), periods])
    true(np.all(whole == np.floor(whole)), "a number of engine_sums")
    if now["begun"]:
        _same("engine_now", (now["struck_period"], now["struck_phase"]), (struck.period[-1], struck.phase[-1]))
        blows = np.array([struck.period, struck.phase])
        main = np.array([now["blow_period"], now["blow_phase"]])
        true(np.any(np.all(main == blows.T, axis=1)), "the main blow of engine_now")
    true({float(now["begun"]), float(now["chattered"])} <= {0.0, 1.0}, "a sign of engine_now")


def _between(sums: npt.NDArray[Any], most: npt.NDArray[Any]) -> None:
    true(np.all((sums >= 0.0) & (sums <= most * (1.0 + _ROUNDING) + _ROUNDING)), "a value of engine_sums")


# ---- The state that a machine goes on from


def kept_valve(motion: Motion) -> None:
    """Refuse a state to go on from whose whole numbers are no places in arrays, or whose arrays have other shapes."""
    if motion.machine.valve.flows:
        _kept_oil(motion)
        return
    from percuss.simulate.valve import ROOM, unmoved  # the compiler

    snapshot, states = motion.snapshot, len(motion.mechanism.names)
    for name, room in unmoved(motion.mechanism, max(np.size(snapshot.get("valve_due", ())), ROOM)).items():
        true(name in snapshot, f"that there is no engine_{name}")
        shaped(f"engine_{name}", snapshot[name], room.dtype, room.shape)
    valve, count = snapshot["valve_now"], snapshot["count"]
    for name in ("state", "before", "last", "memo_state", "memo_last"):
        within(name, valve[name], 0, states - 1)
    for name in ("waiting", "memo_waiting"):
        within(name, valve[name], 0, snapshot["valve_due"].size)
    within("order", snapshot["valve_order"], 0, states - 1)
    within("mode", count["mode"], 0, GRAZED)
    true(count["events"][0] == 0 and valve["handed"][0] == 0, "a number of events")
    within("changes", valve["changes"], 0, 2**62)
    state = [snapshot["now"]["gap"], valve["force"], valve["charge"], snapshot["z"].reshape(-1)]
    true(np.isfinite(np.concatenate(state)).all(), "a number of the state")


def _kept_oil(motion: Motion) -> None:
    from percuss.mechanics import oil_records as kn  # the compiler
    from percuss.simulate.oil import OilFlights

    snapshot, shapes = motion.snapshot, OilFlights(motion.machine, motion.modes).shapes
    for name, shape in shapes.items():
        true(name in snapshot, f"that there is no engine_{name}")
        found = snapshot[name]
        free = tuple(own if size < 0 else size for own, size in zip(found.shape, shape, strict=True))
        shaped(f"engine_{name}", found, np.dtype(np.float64), free)
    now, states = snapshot["oil_now"], len(motion.machine.valve.pairs)
    endless = np.isin(np.arange(now.size), (kn.STROKE, kn.HOLD))
    true(np.isfinite(now[~endless]).all() and not np.isnan(now).any(), "a number of engine_oil_now")
    for place in (kn.STATE, kn.LAST):
        within("engine_oil_now", now[place], 0, states - 1)
    within("engine_oil_now", now[kn.COUNT], 0, len(snapshot["oil_orders"]))
    within("engine_oil_orders", snapshot["oil_orders"][:, 1], 0, states - 1)
    true(all(np.isfinite(snapshot[f"oil_{name}"]).all() for name in ("bar", "blend", "sums")), "a number of the state")
