"""A motion of a branch as pictures in time: one cycle of it, simulated from an impact or a release and told again."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from percuss.case.answers.framed_stretch import Stretch
from percuss.case.answers.motion_frames import Frames, stretch_frames
from percuss.case.answers.orbits_json import orbit_dict
from percuss.case.answers.rest_cycles_answer import rest_cycle_dict
from percuss.case.parameters.case_family import CaseFamily
from percuss.errors import ParameterError
from percuss.simulate import Start, Stop, run
from percuss.stability import orbit_multipliers
from percuss.steady import PeriodicOrbit, orbit_near
from percuss.steady.resting.search import cycle_through

if TYPE_CHECKING:
    from percuss.case.case import Case
    from percuss.model import System
    from percuss.simulate import Trajectory

__all__ = ["branch_frames", "rest_branch_frames"]

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
    """Whole cycles of the orbit near given times of impacts, at another value of a parameter, stable or not.

    One cycle is simulated and told again and again, so that an unstable orbit stays what it is.

    Parameters
    ----------
    case
        The hammer.
    name, value, unit
        Of the parameter, as for `percuss.case.CaseFamily`.
    times
        Of the impacts in rad, increasing, as the branch has them; shape (p,).
    periods
        n, the load periods of a cycle.
    modes
        N.
    cycles
        How many.
    frames, places, points
        As for `percuss.case.answers.motion_frames.motion_frames`.

    Returns
    -------
    Frames
        As of a simulated motion; besides, the orbit in the header, and the load over its period in ``load``.

    Raises
    ------
    ParameterError
        When there is no such orbit, or no such parameter.
    CaseError, LoadError, ResonanceError
        When there is no such hammer, or it has no steady impacts.

    Examples
    --------
    >>> from percuss.case import load_case
    >>> found = branch_frames(load_case("mini-breaker"), "load_factor", 0.35, [1.9], 1, modes=0)
    >>> found.header["label"], found.header["orbit"]["stable"]
    ('z=1/1', True)
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
    """Whole cycles of the cycle with rest that leaves the wall near a phase, at another value of a parameter.

    Parameters
    ----------
    case, name, value, unit, modes, cycles, frames, places, points
        As for `branch_frames`.
    release
        Phase of the load at which the bar is let go, rad.
    periods
        n, the load periods of a cycle.

    Returns
    -------
    Frames
        As of a simulated motion from the release on; besides, the cycle in the header as ``orbit``, and the load over
        its period in ``load``.

    Raises
    ------
    ParameterError
        When there is no such cycle, or no such parameter.
    CaseError, ResonanceError
        When there is no such hammer.

    Examples
    --------
    >>> from percuss.case import load_case
    >>> found = rest_branch_frames(load_case("laboratory-striker"), "load_factor", 0.6, 2.2, 1, modes=0)
    >>> found.header["label"], [blow["kind"] for blow in found.header["blows"]][-2:]
    ('chatter/1', ['chatter', 'rest'])
    """
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
