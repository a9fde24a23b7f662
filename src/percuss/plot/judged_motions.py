"""What an answer hands to its picture: the steady motions of a system, each with its verdict and its figures in SI."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

from percuss.stability import stability_of
from percuss.steady import si_report

if TYPE_CHECKING:
    from percuss.model import System
    from percuss.stability import Stability, TimedStability
    from percuss.steady import Orbit, SIReport, SteadyStates, TimedOrbit, TimedStates

__all__ = ["JudgedMotions", "JudgedOrbit", "JudgedPeriod", "JudgedTimed", "JudgedTimedOrbit", "judged_states"]


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


def judged_states(states: SteadyStates) -> JudgedMotions:
    """Steady states that no case stands behind, as an answer has them."""
    si = states.system.is_si
    orbits = tuple(_Orbit(one, stability_of(one), si_report(one) if si else None) for one in states.orbits)
    return _Motions(str(states.system), states.system, (_Period(states, orbits),))
