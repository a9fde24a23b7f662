"""A motion as pictures in time: displacement and strain along the bar, the striking end's history, and every blow."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from percuss.case.answers.numerals import json_number as number
from percuss.case.answers.numerals import plain
from percuss.case.answers.orbits_answer import orbit_dict, rest_cycle_dict
from percuss.case.parameters.case_family import CaseFamily
from percuss.errors import ParameterError
from percuss.model.body import ModalBody
from percuss.model.checks import Array
from percuss.simulate import Start, Stop, run
from percuss.simulate.events import IMPACT
from percuss.stability import orbit_multipliers
from percuss.steady import PeriodicOrbit, orbit_near, steady_states
from percuss.steady.resting.rest_cycles import cycle_through

if TYPE_CHECKING:
    from percuss.case.case import Case
    from percuss.model import System
    from percuss.simulate import Trajectory


# ---- Which stretch of a simulated motion is framed: its first periods, or whole cycles of what it settles on

_FEWEST = 240
"""Points of the striking end's history that a cycle has at least, however often it is told."""

_Numbers = npt.NDArray[np.float64]

_TURN = 2.0 * math.pi
_NEAR = 1e-5
"""Rad within which an impact of a cycle and the one of the cycle after are at the same place."""


@dataclass(frozen=True)
class Stretch:
    """A stretch of a motion, which may be told several times over: one that repeats is simulated for few cycles.

    Attributes
    ----------
    motion
        Of which it is.
    begin, end
        The part of the simulation that it shows, in rad.
    copies
        How often.
    """

    motion: Trajectory
    begin: float
    end: float
    copies: int = 1

    @property
    def once(self) -> float:
        """Rad that are told once."""
        return self.end - self.begin

    @property
    def length(self) -> float:
        """Rad in all."""
        return self.copies * self.once

    def moments(self, times: _Numbers) -> _Numbers:
        """Times of the simulation that stand for `times` after the beginning of the stretch."""
        if self.copies == 1:
            return np.clip(self.begin + times, self.begin, self.end)
        return self.begin + np.where(times >= self.length, self.once, np.mod(times, self.once))

    def events(self) -> list[tuple[int, float]]:
        """Numbers of the events, and their times after the beginning; where copies join there is one and not two."""
        time = self.motion.events.time
        inside = np.flatnonzero((time >= self.begin) & (time <= self.end))
        later = inside[time[inside] > self.begin + _NEAR]
        first = [(int(i), float(time[i] - self.begin)) for i in inside]
        return first + [
            (int(i), float(time[i] - self.begin) + k * self.once) for k in range(1, self.copies) for i in later
        ]

    def end_point(self, points: int) -> tuple[_Numbers, _Numbers, _Numbers]:
        """Time after the beginning, gap and velocity of the striking end; NaN where its velocity jumps."""
        time = self.motion.events.time
        jumps = time[(time >= self.begin) & (time <= self.end)]
        each = max(points // self.copies, min(points, _FEWEST))
        times, gap, velocity = _history(self.motion, self.begin, self.end, jumps, each)
        times = times - self.begin
        parts = [(times, gap, velocity)]
        later = times > _NEAR
        parts += [(times[later] + k * self.once, gap[later], velocity[later]) for k in range(1, self.copies)]
        found = [np.concatenate([part[i] for part in parts]) for i in range(3)]
        return found[0], found[1], found[2]


def stretch_of(motion: Trajectory, settled: bool, cycles: int) -> Stretch:
    """The first load periods of a motion (`cycles`), or what it settles on.

    A periodic motion is shown from an impact on, in whole cycles and never with anything of the way there: where it was
    followed for fewer cycles than are wanted, the last one is told again.
    """
    first, last = motion.begin_time, motion.end_time
    length = cycles * _TURN
    if not settled:
        return Stretch(motion, first, min(first + length, last))
    if motion.cycle is None:
        return Stretch(motion, max(last - length, first, _half(motion)), last)
    once = motion.cycle.periods * _TURN
    wanted = max(cycles // motion.cycle.periods, 1)
    struck = motion.events.time[motion.events.code == IMPACT]
    begun = float(struck[motion.cycle.first])
    last = float(struck[-1])
    known = math.floor((last - begun + _NEAR) / once)  # whole cycles
    if known < wanted:
        begin = _impact(struck, last - once)
        return Stretch(motion, begin, _impact(struck, begin + once), wanted)
    begin = _impact(struck, last - wanted * once)
    return Stretch(motion, begin, _impact(struck, begin + wanted * once))


def _half(motion: Trajectory) -> float:
    """From when on a motion without a cycle may count as settled: its second half, if it has enough impacts."""
    struck = motion.events.time[motion.events.code == IMPACT]
    return float(struck[motion.summary.first]) if motion.summary.first else motion.begin_time


def _impact(struck: _Numbers, time: float) -> float:
    """The last impact until then, with some room for rounding."""
    before = struck[struck <= time + _NEAR]
    return float(before[-1]) if before.size else time


def _history(
    motion: Trajectory, begin: float, end: float, jumps: _Numbers, points: int
) -> tuple[_Numbers, _Numbers, _Numbers]:
    """Time, gap and velocity of the striking end: equal steps, and both sides of every jump with NaN between them."""
    if jumps.size > points // 4:
        jumps = jumps[:0]
    times = np.linspace(begin, end, max(points - 3 * jumps.size, 2))
    gap, velocity = motion.gap(times), motion.bar_velocity(1.0, times)[0]
    if not jumps.size:
        return times, gap, velocity
    before, after = (motion.bar_velocity(1.0, jumps, side)[0] for side in ("left", "right"))
    touch, nothing = motion.gap(jumps), np.full(jumps.size, np.nan)
    rank = np.concatenate([np.zeros(times.size), *(np.full(jumps.size, i) for i in (1, 2, 3))])
    clock = np.concatenate([times, jumps, jumps, jumps])
    rows: tuple[npt.NDArray[Any], ...] = (
        clock,
        np.concatenate([gap, touch, nothing, touch]),
        np.concatenate([velocity, before, nothing, after]),
    )
    order = np.lexsort((rank, clock))
    return rows[0][order], rows[1][order], rows[2][order]


# ---- A motion as pictures in time: displacement and strain along the bar, the striking end's history, and every blow

Arrays = dict[str, npt.NDArray[Any]]

_MOST_BLOWS = 2000
_MOST_POINCARE = 20_000


@dataclass(frozen=True)
class Frames:
    """A stretch of a motion: a header of JSON's types, and arrays by name.

    Attributes
    ----------
    header
        What moved, when, its blows, and the scales that its numbers have in SI.
    arrays
        ``x`` (places) from the driven to the striking end; ``t`` (frames) in rad after the beginning; ``displacement``
        and ``strain`` (frames, places), of a structure told by its modes those of its contact; ``end_t``, ``end_gap``,
        ``end_velocity`` of the striking end, with NaN where its velocity jumps; ``poincare_phase``,
        ``poincare_velocity``, ``poincare_settled`` of the impacts.
    """

    header: dict[str, Any]
    arrays: Arrays


def orbit_frames(
    case: Case,
    orbit: int,
    periods: int = 1,
    *,
    cycles: int = 1,
    frames: int = 240,
    places: int = 33,
    points: int = 2000,
    window: Sequence[float] | None = None,
) -> Frames:
    """Whole impact periods of a steady motion, which has a number from 1 in order of phase, from an impact on.

    `window`: only this part of the fields, from and to in rad after the impact.
    """
    system = case.system()
    orbits = steady_states(system, periods).orbits
    if not 1 <= orbit <= len(orbits):
        raise ParameterError("orbit", orbit, f"the number of a steady motion; there are {len(orbits)}")
    motion = orbits[orbit - 1]
    x = np.linspace(0.0, 1.0, places)
    t = np.linspace(*_part(window, cycles * motion.period), frames)
    field = motion.field(_known(system, x), t)
    each = max(points // cycles - 1, 2)
    one = np.linspace(0.0, motion.period, each)
    end = motion.field(1.0, one)
    whole = np.arange(cycles)[:, None] * motion.period + np.append(one, motion.period)
    gap, velocity = np.append(end.displacement[0], np.nan), np.append(end.velocity[0], np.nan)
    arrays: Arrays = {
        "x": x,
        "t": t,
        "displacement": field.displacement.T,
        "strain": _strain(system, x, field.strain).T,
        "end_t": whole.reshape(-1),
        "end_gap": np.tile(gap, cycles),
        "end_velocity": np.tile(velocity, cycles),
        "poincare_phase": np.array([motion.phase]),
        "poincare_velocity": np.array([motion.impact_velocity]),
        "poincare_settled": np.array([True]),
    }
    lost = motion.delivered_energy
    rows = [
        ("impact", n * motion.period, motion.phase, motion.impact_velocity, motion.rebound_velocity, lost)
        for n in range(cycles + 1)
    ]
    header = _header(system, motion.modes, motion.phase, motion.phase + cycles * motion.period, motion.period)
    about: dict[str, Any] = {"source": "orbit", "label": f"z=1/{periods}", "outcome": None, "summary": None}
    about["blows"] = _blows(system, rows)
    return Frames({**about, **header}, arrays)


def motion_frames(
    motion: Trajectory,
    *,
    settled: bool = True,
    cycles: int = 1,
    frames: int = 240,
    places: int = 33,
    points: int = 2000,
    window: Sequence[float] | None = None,
) -> Frames:
    """The first or the last load periods of a simulated motion; of a periodic one whole cycles, from an impact on.

    Of what a motion settles on nothing of the way there is shown: a cycle that was followed only a few times is told
    again. The window counts from the beginning of the stretch.
    """
    period = None if motion.cycle is None else motion.cycle.periods * _TURN
    about: dict[str, Any] = {"source": "simulation", "label": motion.label, "outcome": motion.outcome}
    about["summary"] = plain(asdict(motion.summary))
    stretch = stretch_of(motion, settled, cycles)
    return stretch_frames(stretch, about, period, frames=frames, places=places, points=points, window=window)


def stretch_frames(
    stretch: Stretch,
    about: dict[str, Any],
    period: float | None,
    *,
    frames: int = 240,
    places: int = 33,
    points: int = 2000,
    window: Sequence[float] | None = None,
) -> Frames:
    """A stretch of a simulated motion that repeats after `period`, or never; `about` is said in the header besides."""
    motion, events = stretch.motion, stretch.motion.events
    x = np.linspace(0.0, 1.0, places)
    t = np.linspace(*_part(window, stretch.length), frames)
    moments = stretch.moments(t)
    end_t, gap, velocity = stretch.end_point(points)
    struck = np.flatnonzero(events.code == IMPACT)
    kept = np.arange(max(struck.size - _MOST_POINCARE, 0), struck.size)
    at = struck[kept]
    arrays: Arrays = {
        "x": x,
        "t": t,
        "displacement": motion.position(_known(motion.system, x), moments).T,
        "strain": _strain(motion.system, x, motion.strain(_known(motion.system, x), moments)).T,
        "end_t": end_t,
        "end_gap": gap,
        "end_velocity": velocity,
        "poincare_phase": events.phase[at],
        "poincare_velocity": events.impact_velocity[at],
        "poincare_settled": kept >= motion.summary.first,
    }
    rows = [
        (
            str(events.kind[i]),
            time,
            float(events.phase[i]),
            float(events.impact_velocity[i]),
            float(events.rebound_velocity[i]),
            float(events.energy_lost[i]),
        )
        for i, time in stretch.events()[-_MOST_BLOWS:]
    ]
    header = _header(motion.system, motion.modes, stretch.begin, stretch.begin + stretch.length, period)
    return Frames({**about, **header, "blows": _blows(motion.system, rows)}, arrays)


def _part(window: Sequence[float] | None, length: float) -> tuple[float, float]:
    """The part of a stretch that is wanted, within it."""
    if window is None:
        return 0.0, length
    low, high = window
    if not 0.0 <= low < high:
        raise ParameterError("window", list(window), "from and to in rad after the beginning, 0 or greater, ascending")
    if low >= length:
        raise ParameterError("window", list(window), f"a part of the {length:.6g} rad that are framed")
    return low, min(high, length)


def _strain(system: System, x: Array, strain: Array) -> Array:
    """u_x; of a bar with sizes the stress over `stress_scale_Pa`, which differs where its material does."""
    if isinstance(system.body, ModalBody):
        return np.zeros_like(strain)  # it has none
    return system.stress(x, strain) / system.stress_scale if _has_stress(system) else strain


def _has_stress(system: System) -> bool:
    """Whether it is a bar with sizes; a structure told by its modes, or a rigid mass, has no stress."""
    return system.is_si and system.bar is not None and bool(system.bar.pieces)


def _known(system: System, x: Array) -> Array:
    """The places of which the displacement is known: of a structure that is told by its modes the contact alone."""
    return np.ones_like(x) if isinstance(system.body, ModalBody) else x


def _header(system: System, modes: int, begin: float, end: float, period: float | None) -> dict[str, Any]:
    si, first = system.is_si, float(system.body.frequencies(1)[0])
    return {
        "begin": number(begin),
        "end": number(end),
        "period": number(period),
        "load_phase": number(math.fmod(begin, _TURN)),
        "modes": int(modes),
        "first_mode": number(first),
        "first_mode_Hz": number(first * system.frequency) if system.frequency is not None else None,
        "time_scale_s": number(system.time_scale) if si else None,
        "length_scale_m": number(system.length_scale) if si else None,
        "stress_scale_Pa": number(system.stress_scale) if _has_stress(system) else None,
    }


def _blows(system: System, rows: list[tuple[str, float, float, float, float, float]]) -> list[dict[str, Any]]:
    si = system.is_si
    time, energy, speed = (
        (system.time_scale, system.energy_scale, system.speed_scale) if si else (math.nan, math.nan, math.nan)
    )
    return [
        {
            "kind": kind,
            "time": number(at),
            "time_s": number(at * time),
            "phase": number(phase),
            "impact_velocity": number(impact),
            "rebound_velocity": number(rebound),
            "energy": number(lost),
            "energy_J": number(lost * energy),
            "impact_velocity_m_s": number(impact * speed),
        }
        for kind, at, phase, impact, rebound, lost in rows
    ]


# ---- A motion of a branch as pictures in time: one cycle of it, simulated from an impact or a release and told again

_LOOKS = 121
"""Points of the load over its period."""

_MOST_IMPACTS = 20_000  # of a chatter that is simulated


def branch_frames(
    case: Case,
    name: str,
    value: float,
    times: Sequence[float],
    periods: int,
    *,
    unit: str = "",
    modes: int = 32,
    cycles: int = 1,
    frames: int = 240,
    places: int = 33,
    points: int = 2000,
) -> Frames:
    """Whole cycles of the orbit near given times of impacts (rad, increasing), at another value of a parameter.

    One cycle is simulated and told again and again, so that an unstable orbit stays what it is. Besides what a
    simulated motion has there is the orbit in the header, and the load over its period in ``load``.
    """
    system = CaseFamily(case, {name: unit} if unit else {}).system({name: value})
    orbit = orbit_near(system, times, periods, modes=modes)
    if orbit is None:
        raise ParameterError("times", list(times), f"times near those of an orbit z={len(times)}/{periods}")
    motion = _one_cycle(orbit)
    struck = motion.events.time
    end = float(struck[-1]) if struck.size else motion.end_time
    stretch = Stretch(motion, motion.begin_time, end, cycles)
    about = {"label": orbit.label, "orbit": orbit_dict(orbit, orbit_multipliers(orbit).values)}
    return _framed(stretch, about, orbit.period, frames=frames, places=places, points=points)


def rest_branch_frames(
    case: Case,
    name: str,
    value: float,
    release: float,
    periods: int,
    *,
    unit: str = "",
    modes: int = 32,
    cycles: int = 1,
    frames: int = 240,
    places: int = 33,
    points: int = 2000,
) -> Frames:
    """Whole cycles of the cycle with rest that leaves the wall near a phase, at another value of a parameter."""
    system = CaseFamily(case, {name: unit} if unit else {}).system({name: value})
    cycle, _, _ = cycle_through(system, release, modes=modes, most=periods)
    if cycle is None or cycle.periods != periods:
        raise ParameterError("release", release, f"a phase near that at which a cycle of {periods} load periods leaves")
    stop = Stop(_MOST_IMPACTS, time=cycle.period, periodic=False)
    motion = run(system, Start.rigid(0.0, 0.0, cycle.release_phase), modes=modes, stop=stop)
    stretch = Stretch(motion, motion.begin_time, motion.end_time, cycles)
    about = {"label": cycle.label, "orbit": rest_cycle_dict(cycle)}
    return _framed(stretch, about, cycle.period, frames=frames, places=places, points=points)


def _framed(stretch: Stretch, about: dict[str, Any], period: float, **sizes: Any) -> Frames:
    """A cycle again and again, with the load that drives it."""
    header: dict[str, Any] = {"source": "branch", "outcome": None, "summary": None, **about}
    found = stretch_frames(stretch, header, period, **sizes)
    return Frames(found.header, {**found.arrays, "load": _load(stretch.motion.system)})


def _one_cycle(orbit: PeriodicOrbit) -> Trajectory:
    stop = Stop(orbit.impacts, time=1.5 * orbit.period, periodic=False)
    return run(orbit.system, Start.orbit(orbit), modes=orbit.modes, stop=stop)


def _load(system: System) -> np.ndarray:
    return np.asarray(system.load.value(np.linspace(0.0, 2.0 * np.pi, _LOOKS)))
