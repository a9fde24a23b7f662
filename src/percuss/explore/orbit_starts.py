"""Starts for a search for orbits: what begins at flips and grazings of the branches of shorter orbits."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from percuss.errors import PercussError
from percuss.halting import Elapsed, asked, check_interrupted, halting
from percuss.model import Machine, System
from percuss.model.checks import DEFAULT_MODES, Array, callback, count, having, instance, unit_interval
from percuss.steady import PeriodicOrbit, orbit_near, orbits
from percuss.steady.periodic.found_orbits import MOST_IMPACTS, MOST_PERIODS
from percuss.steady.states import MAX_MODES

if TYPE_CHECKING:
    from percuss.simulate import Start, Trajectory
    from percuss.steady import ValveCycle
    from percuss.steady.self_excited.cycle_times import CycleTimes

SWITCHED = "branches of shorter orbits"  # what the starts are called
_MOST_POINTS = 400  # of a branch, each way
_AROUND = 0.2  # of the pressure or the flow, on either side, where flips of machines are looked for


def switched_seeds(
    system: System, impacts: int, periods: int = 1, *, modes: int = DEFAULT_MODES, reach: float = 0.2, tries: int = 100
) -> dict[str, Array]:
    """Where `percuss.steady.orbits` is to start: orbits that begin at a flip or a grazing of a shorter one.

    The orbits with half the impacts in half the periods, and of a rigid bar those with one impact less, are followed
    through the mean load; from their flips and grazings the branches z=p/n are followed, and where one comes by the
    mean load of the system it is a start.

    Parameters
    ----------
    system
        What moves; nothing holds it.
    reach
        Share of the mean load by which it is changed, 0 to 1.
    tries
        Random starts in the search for the shorter orbits.

    Returns
    -------
    dict
        Rows of p times, by where they come from; for the parameter `near` of `orbits`.

    Raises
    ------
    LoadError, ResonanceError, ParameterError
        As `percuss.steady.orbits`.

    Examples
    --------
    >>> from percuss import Load, System
    >>> system = System(s=5.0, d=0.0, restitution=0.5, load=Load.harmonic(0.64, 1.0))
    >>> rows = switched_seeds(system, 2, 2, modes=0)["branches of shorter orbits"]
    >>> rows.shape
    (1, 2)
    """
    from percuss.explore.continuation.following import follow  # what one motion settles on needs no branch

    instance("system", system, System)
    p, n = count("impacts", impacts, most=MOST_IMPACTS), count("periods", periods, most=MOST_PERIODS)
    kept, wanted = count("modes", modes, least=0, most=MAX_MODES), count("tries", tries, most=10**7)
    share = unit_interval("reach", reach)
    shorter = [(p // 2, n // 2)] if p % 2 == 0 and n % 2 == 0 else []
    shorter += [(p - 1, n)] if kept == 0 and p > 1 else []
    mean = system.load.mean
    rows: list[Array] = []
    for fewer, within in shorter if system.body.is_free and share > 0.0 else []:
        for orbit in orbits(system, fewer, within, modes=kept, tries=wanted).orbits:
            branch = follow(
                orbit, "mean", (mean * (1.0 - share), mean * (1.0 + share)), switch=1, most=_MOST_POINTS
            )  # fmt: skip
            for one in branch.family():
                if (one.impacts, one.periods) == (p, n):
                    rows += one.times_at(mean)
    return {SWITCHED: np.array(rows).reshape(-1, p)}


def doubled_seeds(machine: Machine, blows: int, valve_cycles: int, *, modes: int) -> dict[str, list[CycleTimes]]:
    """The same of a machine: rhythms of what begins at flips of its shorter cycles, over pressure or flow."""
    from percuss.explore.continuation.machine_walk import doubled_cycles
    from percuss.explore.continuation.walk import varied

    supply, found = machine.valve.supply, list[CycleTimes]()
    name, here = ("pressure", 1.0) if supply is None else ("supply.flow", supply.flow)
    around = (1.0 - _AROUND) * here, (1.0 + _AROUND) * here
    for cycle in orbits(machine, blows // 2, valve_cycles // 2, modes=modes).orbits:
        over = varied(machine, None, [name], [around], [here])
        found += [one.rhythm for one in doubled_cycles(cast("ValveCycle", cycle), over)]
    return {SWITCHED: found}


# ---- Starts for a search for orbits: close returns of simulated motions

SIMULATED = "simulated motions"  # what the starts are called
_IMPACTS = 600  # of each motion, at most
_KEPT = 64  # last impacts that are looked at, besides a cycle
_CLOSE = 0.5  # rad, by which an impact may miss the time a cycle after itself
_EACH = 2  # starts of one motion
_MOST = 10**5  # motions
_NEW = 1e-4  # rad, by which two starts must differ


def orbit_seeds(
    system: System | Machine,
    impacts: int,
    periods: int = 1,
    *,
    modes: int = DEFAULT_MODES,
    motions: int = 64,
    seed: int = 0,
    progress: Callable[[Elapsed], object] | None = None,
) -> dict[str, Any]:
    """Where `percuss.steady.orbits` is to start: impacts of simulated motions that come back nearly after a cycle.

    Stable orbits are found in this way where few random starts lead to them; and an aperiodic motion comes near the
    unstable ones again and again (Auerbach et al., Phys. Rev. Lett. 58 (1987) 2387–2389).

    Parameters
    ----------
    system
        What moves; or a machine that switches its own valve.
    motions
        How many are simulated, from random starts.
    progress
        Called again and again; once it returns true no more motions are followed.

    Returns
    -------
    dict
        Rows of p times, of a machine each a `CycleTimes`, by where they come from, for the parameter `near` of `orbits`

    Raises
    ------
    ResonanceError
        When an undamped bar is driven exactly at one of its own frequencies.

    Examples
    --------
    >>> from percuss import Load, System
    >>> from percuss.steady import orbits
    >>> system = System(s=5.0, d=0.0, restitution=0.5, load=Load.harmonic(0.665, 1.0))
    >>> seeds = orbit_seeds(system, 3, 1, modes=0)
    >>> orbits(system, 3, 1, modes=0, tries=100, near=seeds).sources.keys()
    dict_keys(['simulated motions', 'random times'])
    """
    from percuss.simulate import Starts, Stop, simulate_many  # loads the compiler

    callback("progress", progress)
    if isinstance(system, Machine):
        return {SIMULATED: _rhythms(system, impacts, modes, motions, seed, asked(progress))}
    instance("system", system, System)
    p, n = count("impacts", impacts, most=MOST_IMPACTS), count("periods", periods, most=MOST_PERIODS)
    start = count("seed", seed, least=0, most=2**63 - 1)
    starts = Starts.random(system, count("motions", motions, most=_MOST), seed=start)
    ensemble = simulate_many(
        system, starts, modes=modes, stop=Stop(_IMPACTS + 2 * p), keep=_KEPT + p,
        progress=asked(progress),
    )  # fmt: skip
    found = [row for times in np.asarray(ensemble.last_time) for row in _returns(times[np.isfinite(times)], p, n)]
    return {SIMULATED: _different(np.array(found).reshape(-1, p))}


_BLOWS, _FED = 120, 960  # of each motion of a machine, and of one whose pressure has to settle


def last_rhythm(machine: Machine, start: Start, motion: Trajectory, blows: int = 1) -> CycleTimes | None:
    """Of the last blows of a simulated motion of a machine; None where there are no more."""
    from percuss.steady.self_excited.cycle_times import Switching, rhythm_of  # a load that keeps time has none

    if motion.impacts <= blows:
        return None
    before = Switching(machine.valve, *start.valve_of(machine))
    return rhythm_of(before, _heard(motion), blows, _pressures(motion))


def _heard(motion: Trajectory) -> list[tuple[float, str, Any]]:
    """The events of a motion of a machine as `CycleTimes.of_events` takes them."""
    return [(one.time, one.kind, one.port if one.kind == "port" else one.state) for one in motion.events]


def _pressures(motion: Trajectory) -> list[tuple[float, float]]:
    """Of the supply at the events, where delays follow it."""
    if not motion.machine.valve.delays_vary:
        return []
    return list(zip(motion.events.time.tolist(), motion.pressure(motion.events.time).tolist(), strict=True))


def _rhythms(
    machine: Machine, blows: int, modes: int, motions: int, seed: int, halt: Callable[[], bool] | None
) -> list[CycleTimes]:
    """Of motions of a machine the stretches of so many blows that come back most nearly: the last one, and the best."""
    from percuss.explore.attractors.drawn_starts import named, speed_scale
    from percuss.simulate import Stop, run
    from percuss.steady.self_excited.cycle_times import Switching, rhythm_of

    starts = named(machine, "wall" if speed_scale(machine) else "field", count("motions", motions, most=_MOST), seed)
    found = []
    with halting(halt):
        for start in starts:
            check_interrupted()
            followed = _BLOWS if machine.valve.supply is None else _FED
            motion = run(machine, start, modes=modes, stop=Stop(impacts=followed))
            events = _heard(motion)
            struck = [i for i, event in enumerate(events) if event[1] == "impact"]
            speeds = motion.blow_speeds
            if len(struck) <= 2 * blows:
                continue
            apart = np.abs(speeds[blows:] - speeds[:-blows])
            best = blows + int(np.argmin(apart[blows:])) + blows if apart.size > blows else len(struck) - 1
            for last in {best, len(struck) - 1}:
                before = Switching(machine.valve, *start.valve_of(machine))
                found.append(rhythm_of(before, events[: struck[last] + 1], blows, _pressures(motion)))
    return found


def _returns(times: Array, impacts: int, periods: int) -> Array:
    cycle = 2.0 * math.pi * periods
    if times.size <= impacts:
        return np.empty((0, impacts))
    windows = np.lib.stride_tricks.sliding_window_view(times, impacts + 1)
    off = np.abs(windows[:, -1] - windows[:, 0] - cycle)
    usable = (windows[:, -2] - windows[:, 0] < cycle) & np.all(np.diff(windows) > 0.0, axis=1) & (off < _CLOSE)
    best = np.flatnonzero(usable)[np.argsort(off[usable], kind="stable")][:_EACH]
    return np.asarray(windows[best, :-1])


def _different(rows: Array) -> Array:
    """Those that are not the same but for whole load periods."""
    kept: list[Array] = []
    for row in rows:
        first = np.mod(row[0], 2.0 * math.pi)
        moved = row - row[0] + first
        if all(np.abs(moved - other).max() > _NEW for other in kept):
            kept.append(moved)
    return np.array(kept).reshape(-1, rows.shape[1])


# ---- The orbit that a simulated motion has settled on: exact, with its multipliers

_TURN = 2.0 * math.pi
_SETTLED = 1e-4  # rad, from the last impacts to the orbit that they are on
_NEARLY = 0.05  # rad, to one that they still come nearer to
_RETURN = 0.02  # rad and share of the speed, within which an impact comes back
_CANDIDATES = 4
_MOST_MODES = 256  # an eigensolve with more takes seconds


def orbit_of(motion: Trajectory) -> PeriodicOrbit | None:
    """The periodic orbit that a simulated motion has settled on, solved for by Newton's method.

    A motion that is called ``aperiodic`` or ``undecided`` may be on its way to a long cycle: the lengths up to 64
    impacts after which its last impacts nearly come back are tried, and an orbit is the answer if it is stable and the
    last impacts are near it.

    Returns
    -------
    PeriodicOrbit or None
        With the modes of the motion; `PeriodicOrbit.multipliers` tells how fast disturbances die out. None
        for cycles with rest, for motions that settle on none, and for more than 64 impacts, 256 periods or 256 modes.

    Examples
    --------
    >>> from percuss import Load, Start, System, simulate
    >>> system = System(s=5.0, d=0.0, restitution=0.5, load=Load.harmonic(0.665, 1.0))
    >>> motion = simulate.run(system, Start.rigid(velocity=0.5, time=0.4), modes=0)
    >>> motion.label, orbit_of(motion).label
    ('z=2/1', 'z=2/1')
    """
    having("motion", motion, ("events", "label", "cycle", "system", "modes"), "a simulated motion")
    struck = motion.events.of("impact")
    times, speeds = np.asarray(struck.time), np.asarray(struck.impact_velocity)
    if motion.modes > _MOST_MODES:
        return None
    if motion.cycle is not None:
        p, n = motion.cycle.impacts, motion.cycle.periods
        fits = motion.cycle.kind == 0 and p <= min(MOST_IMPACTS, times.size) and n <= MOST_PERIODS
        return _near(motion, times[-p:], n, _SETTLED) if fits else None
    if motion.label not in ("aperiodic", "undecided") or motion.period_unresolved:
        return None
    for p, n in _lengths(times, speeds):
        found = _near(motion, times[-p:], n, _NEARLY)
        if found is not None and found.multipliers().stable:
            return found
    return None


def orbit_at(system: System, times: Array, periods: int, modes: int) -> PeriodicOrbit | None:
    """The orbit at which Newton's method ends from simulated impacts; None for none that is possible."""
    if not np.all(np.isfinite(times)) or np.any(np.diff(times) <= 0.0):
        return None
    try:
        orbit = orbit_near(system, times - _TURN * math.floor(times[0] / _TURN), periods, modes=modes)
    except PercussError:
        return None
    return orbit if orbit is not None and orbit.admissible else None


def _near(motion: Trajectory, times: Array, periods: int, room: float) -> PeriodicOrbit | None:
    """The orbit near impacts of a motion; None where there is none that is possible."""
    found = orbit_at(motion.system, times, periods, motion.modes)
    if found is None or found.resonant_modes:
        return None
    flights = np.diff(times, append=times[0] + found.period)
    shifts = [np.abs(np.roll(flights, -shift) - found.flight_times).max() for shift in range(found.impacts)]
    return found if min(shifts) < room else None


def _lengths(times: Array, speeds: Array) -> list[tuple[int, int]]:
    """Impacts and load periods after which the last impacts nearly come back, the shortest first."""
    found = []
    for p in range(1, min(MOST_IMPACTS, (times.size - 1) // 2) + 1):
        gone = times[-p:] - times[-2 * p : -p]
        n = round(float(gone[-1]) / _TURN)
        changed = np.abs(speeds[-p:] - speeds[-2 * p : -p]).max()
        near = np.abs(gone - _TURN * n).max() < _RETURN and changed < _RETURN * np.abs(speeds[-2 * p :]).max()
        if 1 <= n <= MOST_PERIODS and near:
            found.append((p, n))
    return found[:_CANDIDATES]
