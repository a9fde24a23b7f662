"""A line through a plane of parameters, x fixed and y moving, and what lies on it: folds, and stretches of branches."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple, Protocol

import numpy as np

from percuss.explore.family import Family
from percuss.model import System
from percuss.model.checks import Array
from percuss.model.load import Side
from percuss.steady import Orbit
from percuss.steady.level import level_of
from percuss.steady.phase_condition import PhaseCondition, phase_condition
from percuss.steady.phases import Arcs, forced_response

__all__ = ["SAMPLES", "Fold", "Halted", "Line", "Stretch", "orbit_on", "phase_at", "places"]

SAMPLES, EXACT_SAMPLES, GRAZING_SAMPLES = 49, 33, 25
"""Places of a stretch that are looked at first: for the reduced criterion, for the exact map, and for grazing.

Under a load of K harmonics by `PER_HARMONIC` more for each: what happens on a branch turns as often as they do.
"""

PER_HARMONIC = 8


class Halted(Exception):
    """The result of this line is no longer wanted."""


@dataclass(frozen=True)
class Line:
    """All systems at one value of x: y runs from `low` to `high`.

    Parameters
    ----------
    family
        Gives the systems.
    fixed
        The value of x, or other parameters that stay as they are, by name.
    name, low, high
        The parameter y and its range.
    periods
        m.
    modes, tolerance
        Of the orbits; see `steady_states`.
    halt
        Asked by `go_on`, which every long search calls again and again.
    told
        Called with the share of the line's work that is done, 0 to 1.
    """

    family: Family
    fixed: dict[str, float]
    name: str
    low: float
    high: float
    periods: int
    modes: int | None
    tolerance: float = 1e-11
    halt: Callable[[], bool] | None = field(default=None, repr=False)
    told: Callable[[float], None] | None = field(default=None, repr=False)
    _systems: dict[float, System] = field(default_factory=dict, repr=False)
    _known: dict[float, PhaseCondition] = field(default_factory=dict, repr=False)

    @property
    def period(self) -> float:
        """T = 2πm."""
        return 2.0 * math.pi * self.periods

    def go_on(self) -> None:
        """Raise `Halted` when nobody waits any more."""
        if self.halt is not None and self.halt():
            raise Halted

    def tell(self, share: float) -> None:
        """So much of the line's work is done, 0 to 1."""
        if self.told is not None:
            self.told(share)

    def system(self, y: float) -> System:
        """The system at a value of y, made once."""
        self.go_on()
        if y not in self._systems:
            self._systems[y] = self.family.system({**self.fixed, self.name: y})
        return self._systems[y]

    def condition(self, y: float) -> PhaseCondition:
        """The curve whose arcs meet a level at the impact phases, at a value of y, made once."""
        if y not in self._known:
            self._known[y] = self.condition_of(self.system(y))
        return self._known[y]

    def condition_of(self, system: System) -> PhaseCondition:
        """The same of any system on the line.

        Under a load of steps v_f stands for the curve of a contact law that changes the strain: right to second order
        in 1/s.
        """
        response = forced_response(system)
        if response.is_smooth:
            return phase_condition(system, self.periods, self.modes)
        return PhaseCondition(Arcs.of(response), level_of(system, self.period))

    @cached_property
    def middle(self) -> System:
        """The system in the middle of the range: its arcs are those of all where y moves the level alone."""
        return self.system(0.5 * (self.low + self.high))


class Fold(NamedTuple):
    """Where two branches meet: the value of y, the phase, the extremum's number, and an estimate of the error of y."""

    y: float
    phase: float
    branch: int
    residual: float


class Stretch(Protocol):
    """A part of one branch, over t in [0, 1]."""

    @property
    def line(self) -> Line:
        """What it lies on."""
        ...

    @property
    def branch(self) -> int:
        """The number of its arc."""
        ...

    def nodes(self, samples: int | None, inside: float, least: int = SAMPLES) -> Array:
        """Increasing places, `inside` the ends, at which what happens on it shows.

        As many as `samples`, or with None as `places` says and, where resonances crowd, more.
        """
        ...

    def place(self, t: Array) -> tuple[Array, Array]:
        """y and phase; shapes of `t`."""
        ...

    def quadratic(self, t: Array) -> tuple[Array, Array, Array]:
        """a_0, a_1, a_2 of B77 (29)–(31); shapes of `t`."""
        ...


def places(line: Line, least: int) -> int:
    """How many places of a stretch are looked at first: `least`, and more for many harmonics."""
    return least + PER_HARMONIC * int(line.middle.load.harmonics.max(initial=0))


def orbit_on(stretch: Stretch, t: float) -> tuple[Orbit, Side]:
    """The orbit at a place of a stretch, and the side from which its load is to be taken should it jump there."""
    y, phase = (float(v[0]) for v in stretch.place(np.array([t])))
    system = stretch.line.system(y)
    side: Side = "right"
    if system.load.is_piecewise:
        ahead, behind = (float(stretch.place(np.array([v]))[1][0]) for v in (min(t + 1e-3, 1.0), max(t - 1e-3, 0.0)))
        rising = math.remainder(ahead - behind, 2.0 * math.pi) > 0.0
        side = "right" if (t < 0.5) == rising else "left"
    line = stretch.line
    return Orbit(system, line.periods, phase, False, line.modes, line.tolerance), side


def phase_at(arcs: Arcs, arc: int, height: float) -> float:
    """Where an arc meets a height, on the arc itself and not back on the circle."""
    for end in (arc, arc + 1):
        if height == arcs.velocities[end]:
            return float(arcs.ends[end])
    return arcs.phase_on(arc, height)
