"""What a motion goes on from says again what its events and states say: both must agree.

The engine keeps the state after the last event, the one that later ones are compared with, the last impacts and running
sums. All of them are known from the record, most to the last bit.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from percuss.simulate import kernels as kn
from percuss.simulate.events import IMPACT
from percuss.simulate.soundness import TURN, true, within
from percuss.simulate.tables import prepared
from percuss.simulate.trajectory import Trajectory

__all__ = ["remembered"]

_ROUNDING = 1e-9
_HELD = 1e-8
"""Time after a graze in which none is looked for."""


def remembered(motion: Trajectory) -> None:
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


def _same(name: str, found: npt.ArrayLike, kept: npt.ArrayLike) -> None:
    true(np.array_equal(np.asarray(found), np.asarray(kept)), f"{name}, which is not what the events say,")


def _ends(motion: Trajectory) -> None:
    """After an impact the modes move as fast, all together and at the end, as the event says; theory §2, B77 10."""
    # a bar of few modes that is beyond the wall after a release strikes with no speed, whatever its modes do
    at = (motion.events.code == IMPACT) & (motion.events.impact_velocity > 0.0)
    rates, blow = motion.velocity[at], motion.events.kinetic_energy[at]
    ends = rates * np.where(np.arange(motion.modes + 1) % 2, -2.0, 2.0)
    ends[:, 0] = rates[:, 0]
    noise = _ROUNDING * (np.sqrt(blow) + np.abs(motion.states[at, 1:]).sum(axis=1))
    off = np.abs(ends.sum(axis=1) - motion.events.rebound_velocity[at])
    true(np.all(off <= noise * (1.0 + motion.system.s * motion.modes + motion.system.d)), "the speed of a state")
    kinetic = 0.5 * rates[:, 0] ** 2 + (rates[:, 1:] ** 2).sum(axis=1)
    left = motion.system.restitution**2 * blow
    true(np.all(np.abs(kinetic - left) <= 1e-6 * blow + noise**2), "the kinetic energy of a state")


def _anchor(motion: Trajectory) -> None:
    """The state after the last event, or at the start; under a load of steps it may be at a later one of them."""
    now, count, events = motion.snapshot["now"], motion.snapshot["count"], motion.events
    place, rate, z = motion.start.gap, motion.start.rigid_rate, motion.start.z
    phase, period = motion.start.phase, int(count[kn.PERIOD])
    if len(events):
        place, rate = (float(x) for x in motion.states[-1, : kn.STATE_NUMBERS])
        z = motion.states[-1, kn.STATE_NUMBERS :].reshape(2, motion.modes)
        phase, period = float(events.phase[-1]), int(events.period[-1])
    at = count[kn.PERIOD] * TURN + now[kn.PHASE]
    since = at - (period * TURN + phase) if len(events) else at - motion.begin_time
    true(since >= -1e-6 and at <= motion.end_time + 1e-6 * (1.0 + abs(motion.end_time)), "the time of engine_now")
    if motion.system.load.is_piecewise and (now[kn.PHASE] != phase or count[kn.PERIOD] != period):
        true(now[kn.PHASE] in motion.system.load.breaks, "the phase of engine_now")
        return
    _same("engine_now", (now[kn.GAP], now[kn.RIGID_RATE], now[kn.PHASE]), (place, rate, phase))
    _same("engine_count", count[kn.PERIOD], period)
    _same("engine_z", motion.snapshot["z"], z)
    if len(events):
        true(now[kn.GAP_RATE] in (0.0, events.rebound_velocity[-1]), "the speed of engine_now")


def _bounds_of_the_flight(motion: Trajectory) -> None:
    """What is proved of the flight follows from the amplitudes; and no finite free time is longer than the motion."""
    _, tables = prepared(motion.system, motion.modes)
    now: npt.NDArray[Any] = motion.snapshot["now"]
    fresh = np.array(now, dtype=float)
    kn.amplitudes(tables.par.copy(), tables.mode, np.ascontiguousarray(motion.snapshot["z"]), fresh, tables.over)
    rows = [kn.FREE, kn.FREE_OSCILLATING, kn.FREE_CURVE, kn.SUP, kn.SUP1, kn.SUP2, kn.SUP3]
    scale = [kn.SUP, kn.SUP, kn.SUP2, kn.SUP, kn.SUP1, kn.SUP2, kn.SUP3]
    true(np.all(np.abs(fresh[rows] - now[rows]) <= _ROUNDING * np.abs(fresh[scale])), "a bound of engine_now")
    long = max(motion.end_time - motion.begin_time, 0.0) + TURN
    hold = float(now[kn.HOLD])
    if len(motion.events) and motion.events.code[-1] == IMPACT and motion.outcome not in ("work", "cancelled"):
        within("engine_now", hold, 0.0, _HELD)
    elif np.isfinite(hold):
        within("engine_now", hold, 0.0, long + 1.0 / motion.system.s)
    times = now[[kn.LAST_FLIGHT, kn.SINCE]]
    within("engine_now", times[np.isfinite(times)], -1.0, long)
    within("engine_now", now[kn.KINETIC_ENERGY], 0.0, motion.events.kinetic_energy.max(initial=0.0))


def _last_impacts(motion: Trajectory) -> None:
    struck, past = motion.events[motion.events.code == IMPACT], motion.snapshot["past"]
    kept = np.zeros_like(past)
    last = np.arange(max(len(struck) - kn.WINDOW, 0), len(struck))
    kept[:, last & (kn.WINDOW - 1)] = struck.phase[last], struck.impact_velocity[last], struck.period[last]
    _same("engine_past", past, kept)


def _compared_with(motion: Trajectory) -> None:
    cycle, number = motion.snapshot["cycle"], int(motion.snapshot["count"][kn.ANCHOR])
    if number == 0:
        _same("engine_cycle", cycle, np.zeros_like(cycle))
        return
    at = int(np.flatnonzero(motion.events.code == IMPACT)[number - 1])
    state = motion.states[at, kn.STATE_RIGID :]
    _same("engine_cycle", cycle, [motion.events.phase[at], motion.events.impact_velocity[at], *state])


def _sums(motion: Trajectory) -> None:
    """No sum is more than that of all events, and none is negative but a load period."""
    events, sums = motion.events, motion.snapshot["sums"]
    struck = events[events.code == IMPACT]
    n, long = float(len(struck)), max(motion.end_time - motion.begin_time, 0.0)
    most = np.zeros(kn.LAST_PERIOD)
    most[[kn.ALL, kn.MAIN, kn.OPEN, kn.STRUCK]] = n
    most[[kn.ALL_TIME, kn.MAIN_TIME, kn.OPEN_TIME]] = long
    most[[kn.ALL_SQUARES, kn.MAIN_SQUARES, kn.OPEN_SQUARES]] = long * long
    most[[kn.SPEEDS, kn.OPEN_SPEEDS]] = struck.impact_velocity.sum()
    most[[kn.BLOWS, kn.OPEN_BLOWS]] = struck.kinetic_energy.sum()
    most[kn.TAKEN] = events.energy_lost.sum()
    _between(sums[: kn.LAST_PERIOD], most)
    _between(sums[kn.MARKED_SUMS :], most)
    whole = sums[[kn.ALL, kn.MAIN, kn.OPEN, kn.STRUCK, kn.LAST_PERIOD, kn.MAIN_PERIOD]]
    true(np.all(whole == np.floor(whole)), "a number of engine_sums")
    if sums[kn.BEGUN]:
        _same("engine_sums", sums[[kn.LAST_PERIOD, kn.LAST_PHASE]], (struck.period[-1], struck.phase[-1]))
        blows = np.array([struck.period, struck.phase])
        main = sums[[kn.MAIN_PERIOD, kn.MAIN_PHASE]]
        true(np.any(np.all(main == blows.T, axis=1)), "the main blow of engine_sums")
    true(set(sums[[kn.BEGUN, kn.CHATTERED]].tolist()) <= {0.0, 1.0}, "a sign of engine_sums")


def _between(sums: npt.NDArray[Any], most: npt.NDArray[Any]) -> None:
    true(np.all((sums >= 0.0) & (sums <= most * (1.0 + _ROUNDING) + _ROUNDING)), "a value of engine_sums")
