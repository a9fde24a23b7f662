"""A motion as pictures in time: displacement and strain along the bar, the striking end's history, and every blow."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from percuss.case.answers.framed_stretch import Stretch, stretch_of
from percuss.case.answers.json_values import number, plain
from percuss.errors import ParameterError
from percuss.model.body import ModalBody
from percuss.model.checks import Array
from percuss.simulate.events import IMPACT
from percuss.steady import steady_states

if TYPE_CHECKING:
    from percuss.case.case import Case
    from percuss.model import System
    from percuss.simulate import Trajectory

__all__ = ["Frames", "motion_frames", "orbit_frames", "stretch_frames"]

Arrays = dict[str, npt.NDArray[Any]]

_TURN = 2.0 * math.pi
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
    """Whole impact periods of a steady motion, from an impact on.

    Parameters
    ----------
    orbit
        Its number, from 1, in order of phase.
    periods
        Load periods per impact.
    cycles
        Impact periods.
    frames, places
        Number of instants and of places along the bar.
    points
        Of the striking end's history.
    window
        Only this part of the fields, from and to in rad after the impact.

    Raises
    ------
    ParameterError
        When there is no such motion.
    LoadError, ResonanceError, CaseError
        As `steady_answer`.
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
    again.

    Parameters
    ----------
    settled
        The last ones.
    cycles
        Load periods.
    frames, places, points, window
        As for `orbit_frames`; the window counts from the beginning of the stretch.
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
