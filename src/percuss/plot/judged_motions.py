"""What an answer hands to its picture: the steady motions of a system, each with its verdict and its figures in SI."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol, runtime_checkable

from percuss.stability import stability_of
from percuss.steady import si_report

if TYPE_CHECKING:
    from percuss.model import System
    from percuss.stability import Stability, TimedStability
    from percuss.steady import Orbit, SIReport, SteadyStates, TimedOrbit, TimedStates

__all__ = [
    "JudgedMotions",
    "JudgedOrbit",
    "JudgedPeriod",
    "JudgedStructure",
    "JudgedTimed",
    "JudgedTimedOrbit",
    "judged_states",
]


class JudgedOrbit(Protocol):
    """An orbit, whether it is stable, its figures in SI, and whether a hammer can sustain it."""

    @property
    def orbit(self) -> Orbit: ...
    @property
    def stability(self) -> Stability: ...
    @property
    def si(self) -> SIReport | None: ...
    @property
    def runs(self) -> bool: ...


class JudgedTimedOrbit(Protocol):
    """A motion under a law of blows that take time, and its verdict."""

    @property
    def orbit(self) -> TimedOrbit: ...
    @property
    def stability(self) -> TimedStability: ...


class JudgedTimed(Protocol):
    """All motions under such a law."""

    @property
    def states(self) -> TimedStates: ...
    @property
    def orbits(self) -> Sequence[JudgedTimedOrbit]: ...


class JudgedPeriod(Protocol):
    """All motions with one impact in so many load periods; those of a law of blows that take time, if there is one."""

    @property
    def states(self) -> SteadyStates: ...
    @property
    def orbits(self) -> Sequence[JudgedOrbit]: ...
    @property
    def timed(self) -> JudgedTimed | None: ...


class JudgedMotions(Protocol):
    """A steady answer: title, system, motions, and the one to look at first."""

    @property
    def title(self) -> str: ...
    @property
    def system(self) -> System: ...
    @property
    def periods(self) -> Sequence[JudgedPeriod]: ...
    @property
    def chosen(self) -> JudgedOrbit | None: ...


@runtime_checkable
class JudgedStructure(Protocol):
    """A steady answer of a structure that is held: title and motions."""

    @property
    def title(self) -> str: ...
    @property
    def states(self) -> Sequence[SteadyStates]: ...
    @property
    def motions(self) -> Sequence[Sequence[object]]: ...


@dataclass(frozen=True)
class _Orbit:
    orbit: Orbit
    stability: Stability
    si: SIReport | None

    @property
    def runs(self) -> bool:
        return self.orbit.admissible and self.stability.stable


@dataclass(frozen=True)
class _Period:
    states: SteadyStates
    orbits: tuple[_Orbit, ...]
    timed: None = None


@dataclass(frozen=True)
class _Motions:
    title: str
    system: System
    periods: tuple[_Period, ...]

    @property
    def chosen(self) -> _Orbit | None:
        found = self.periods[0].orbits
        return min(found, key=lambda one: (not one.runs, not one.orbit.admissible), default=None)


def judged_states(states: Sequence[SteadyStates], title: str = "") -> JudgedMotions:
    """Steady states that no judged answer stands behind, as one has them; of held structures those that strike."""
    system = states[0].system
    free = system.body.is_free  # else for each blow there is one that strikes backwards
    periods = []
    for each in states:
        shown = [orbit for orbit in each.orbits if free or orbit.impact_velocity > 0.0]
        si = free and system.is_si
        judged = tuple(_Orbit(one, stability_of(one), si_report(one) if si else None) for one in shown)
        periods.append(_Period(each, judged))
    return _Motions(title or str(system), system, tuple(periods))
