"""What a motion goes on from says again what its events and states say: both must agree.

The engine keeps the state after the last event, the one that later ones are compared with, the last impacts and running
sums. All of them are known from the record, most to the last bit.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from percuss.simulate.events import IMPACT
from percuss.simulate.kernels.bounds import bounded
from percuss.simulate.kernels.motion_records import NOW, STATE_NUMBERS, SUMS, TURN, WINDOW
from percuss.simulate.plausible import true, within
from percuss.simulate.simulated_motion import SimulatedMotion
from percuss.simulate.tables import prepared

_ROUNDING = 1e-9
_HELD = 1e-8
"""Time after a graze in which none is looked for."""


def remembered(motion: SimulatedMotion) -> None:
    """Refuse what the engine cannot have kept of these events and states.

    Raises
    ------
    ValueError
        Which says what does not agree.
    """
    _ends(motion)
    _anchor(motion)
    _bounds_of_the_flight(motion)
    _last_impacts(motion)
    _compared_with(motion)
    _sums(motion)


def _now(motion: SimulatedMotion) -> Any:
    return motion.snapshot["now"][0]


def _count(motion: SimulatedMotion) -> Any:
    return motion.snapshot["count"][0]


def _same(name: str, found: npt.ArrayLike, kept: npt.ArrayLike) -> None:
    true(np.array_equal(np.asarray(found), np.asarray(kept)), f"{name}, which is not what the events say,")


def _ends(motion: SimulatedMotion) -> None:
    """After an impact the modes move as fast, all together and at the end, as the event says; theory §2, B77 10."""
    # a bar of few modes that is beyond the wall after a release strikes with no speed, whatever its modes do
    at = (motion.events.code == IMPACT) & (motion.events.impact_velocity > 0.0)
    rates, blow = motion.velocity[at], motion.events.kinetic_energy[at]
    ends = rates * np.append(1.0, motion.spectrum.unit)
    noise = _ROUNDING * (np.sqrt(blow) + np.abs(motion.states[at, 1:]).sum(axis=1))
    off = np.abs(ends.sum(axis=1) - motion.events.rebound_velocity[at])
    true(np.all(off <= noise * (1.0 + _quickest(motion) / np.pi + _strongest(motion))), "the speed of a state")
    kinetic = 0.5 * rates[:, 0] ** 2 + 0.5 * (rates[:, 1:] ** 2) @ motion.spectrum.weight
    left = motion.system.contact.velocity_factor**2 * blow
    true(np.all(np.abs(kinetic - left) <= 1e-6 * blow + noise**2), "the kinetic energy of a state")


def _quickest(motion: SimulatedMotion) -> float:
    return float(motion.spectrum.omega.max(initial=0.0))


def _strongest(motion: SimulatedMotion) -> float:
    return max(motion.system.d, float(motion.spectrum.damping.max(initial=0.0)))


def _anchor(motion: SimulatedMotion) -> None:
    """The state after the last event, or at the start; under a load of steps it may be at a later one of them."""
    now, count, events = _now(motion), _count(motion), motion.events
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


def _bounds_of_the_flight(motion: SimulatedMotion) -> None:
    """What is proved of the flight follows from the amplitudes; and no finite free time is longer than the motion."""
    _, table = prepared(motion.system, motion.modes)
    now = _now(motion)
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
    if len(motion.events) and motion.events.code[-1] == IMPACT and motion.outcome not in ("work", "cancelled"):
        within("engine_now", hold, 0.0, _HELD)
    elif np.isfinite(hold):
        within("engine_now", hold, 0.0, long + 1.5 * motion.system.body.transit_time)
    times = np.array([now["last_flight"], now["since"]])
    within("engine_now", times[np.isfinite(times)], -1.0, long)
    within("engine_now", now["kinetic_energy"], 0.0, motion.events.kinetic_energy.max(initial=0.0))


def _last_impacts(motion: SimulatedMotion) -> None:
    struck, past = motion.events[motion.events.code == IMPACT], motion.snapshot["past"]
    kept = np.zeros_like(past)
    last = np.arange(max(len(struck) - WINDOW, 0), len(struck))
    for name, values in (("phase", struck.phase), ("speed", struck.impact_velocity), ("period", struck.period)):
        kept[name][last & (WINDOW - 1)] = values[last]
    _same("engine_past", past, kept)


def _compared_with(motion: SimulatedMotion) -> None:
    cycle, now, number = motion.snapshot["cycle"], _now(motion), int(_count(motion)["anchor"])
    kept = [now["anchor_phase"], now["anchor_speed"], now["anchor_rigid_rate"]]
    if number == 0:
        _same("engine_cycle", cycle, np.zeros_like(cycle))
        _same("engine_now", kept, [0.0, 0.0, 0.0])
        return
    at = int(np.flatnonzero(motion.events.code == IMPACT)[number - 1])
    state, events = motion.states[at], motion.events
    _same("engine_cycle", cycle, state[STATE_NUMBERS:].reshape(2, motion.modes))
    _same("engine_now", kept, [events.phase[at], events.impact_velocity[at], state[1]])


def _sums(motion: SimulatedMotion) -> None:
    """No sum is more than that of all events, and none is negative but a load period."""
    events, sums, now = motion.events, motion.snapshot["sums"], _now(motion)
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
