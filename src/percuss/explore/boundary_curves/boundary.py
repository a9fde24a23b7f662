"""The boundaries of steady motions in a plane of two parameters, as curves that are solved for and not read off a grid.

For every value of x all values of y are found at which two motions meet in a fold, one of them doubles its period in a
flip, a pair of its multipliers leaves the unit circle, or the bar begins to touch the wall between two impacts.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import reduce
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from percuss.errors import Interrupted, ParameterError, PercussError, extra_package
from percuss.explore.boundary_curves.crossings import (
    FLIP,
    GRAZING,
    SPIRAL,
    exact_crossings,
    grazings,
    reduced_crossings,
)
from percuss.explore.boundary_curves.motion_branches import folds_and_stretches
from percuss.explore.boundary_curves.plane_lines import FOLD, BoundaryCrossing, Line
from percuss.explore.family import Axis, Family, family_of
from percuss.explore.jobs.archive_export import OfValues
from percuss.explore.jobs.progress import JobProgress, Meter
from percuss.explore.parameters import PARAMETERS, PERIODS
from percuss.halting import halting
from percuss.model import System
from percuss.model.body import need_free
from percuss.model.checks import DEFAULT_MODES, Array, callback, count, finite, numbers, several
from percuss.model.contact import Result
from percuss.shown import Shown
from percuss.steady import Orbit
from percuss.steady.states import MAX_MODES, MAX_PERIODS

if TYPE_CHECKING:
    from xarray import Dataset

KINDS = (FOLD, FLIP, SPIRAL, GRAZING)
"""What can happen on a branch of steady motions."""

CRITERIA = ("reduced", "exact")

_FAR = 0.75  # in shares of the range of y and of a half turn: points farther apart are not of one curve
_GAP = 1e-3  # what each missing value of x adds to that
_OVER_X = ("y", "phase", "residual", "angle", "outside", "impact_velocity")


@dataclass(frozen=True, eq=False)
class BoundaryCurve(Shown):
    """One boundary over x; every array of shape (n,), NaN where x has none.

    `branch`: the monotone arc of v_f (for a fold: its extremum) on which the curve begins, counted by phase from 0.
    `x`, `y`: the parameters, in their own units. `phase`: load phase of the impact, rad in [0, 2π). `residual`: the
    step in y that Newton's method would still make. `angle`: of the multiplier on the unit circle, in rad: 0 at a fold,
    π at a flip; NaN for a grazing. `outside`: how many other multipliers are outside the circle there: where there are
    some, the motion is unstable on both sides; NaN for folds and grazing. `impact_velocity`: striking speed of the
    motion there, dimensionless; where it is not greater than 0 the motion strikes backward, which a bar does not.
    """

    kind: str
    branch: int
    x: Array
    y: Array
    phase: Array
    residual: Array
    angle: Array
    outside: Array
    impact_velocity: Array

    @property
    def found(self) -> npt.NDArray[np.bool_]:
        """Where there is a boundary."""
        return ~np.isnan(self.y)

    def without(self, points: npt.NDArray[np.bool_]) -> BoundaryCurve:
        """The curve with gaps at some of its points."""
        return replace(self, y=np.where(points, math.nan, self.y))


@dataclass(frozen=True, eq=False)
class Boundaries(OfValues):
    """All boundaries of a plane.

    Parameters
    ----------
    x_name, y_name
        The parameters.
    x
        Values of the first, shape (n,).
    low, high
        Range of the second.
    curves
        The boundaries, in order of kind.
    failed
        Values of x at which nothing could be computed, with the reason.
    """

    x_name: str
    y_name: str
    x: Array
    low: float
    high: float
    curves: tuple[BoundaryCurve, ...]
    failed: tuple[tuple[float, str], ...] = ()

    def of(self, kind: str) -> tuple[BoundaryCurve, ...]:
        """The curves of one kind."""
        if kind not in KINDS:
            raise ParameterError("kind", kind, f"one of {', '.join(KINDS)}")
        return tuple(curve for curve in self.curves if curve.kind == kind)

    @property
    def real(self) -> tuple[BoundaryCurve, ...]:
        """The curves without points on motions that strike backward."""
        kept = [c if c.kind == GRAZING else c.without(c.impact_velocity <= 0.0) for c in self.curves]
        return tuple(curve for curve in kept if curve.found.any())

    @property
    def of_stability(self) -> tuple[BoundaryCurve, ...]:
        """The curves at which stability or existence of motions that there can be ends.

        Without crossings of motions that are unstable anyhow, or strike backward.
        """
        kept = [c.without(c.outside > 0.0) for c in self.real if c.kind != GRAZING]
        return tuple(curve for curve in kept if curve.found.any())

    def greatest(self, kind: str) -> Array:
        """The greatest y of one kind at every x, NaN where there is none; shape (n,)."""
        return self._extreme(kind, np.fmax)

    def least(self, kind: str) -> Array:
        """The least y of one kind at every x, NaN where there is none; shape (n,)."""
        return self._extreme(kind, np.fmin)

    def _extreme(self, kind: str, choose: np.ufunc) -> Array:
        return np.asarray(reduce(choose, (curve.y for curve in self.of(kind)), np.full(self.x.shape, math.nan)))

    def to_xarray(self) -> Dataset:
        """All curves, over the dimension ``curve`` and over x."""
        over = {name: np.array([getattr(c, name) for c in self.curves]).reshape(-1, self.x.size) for name in _OVER_X}
        variables: dict[str, Any] = {name: (("curve", self.x_name), values) for name, values in over.items()}
        about_each = {name: ("curve", [getattr(c, name) for c in self.curves]) for name in ("kind", "branch")}
        about = {"y": self.y_name, "low": self.low, "high": self.high}
        made: Dataset = extra_package("xarray", "io").Dataset(variables, {self.x_name: self.x, **about_each}, about)
        return made

    def as_json(self) -> dict[str, Any]:
        """All of it as plain values."""
        curves = [
            {name: value.tolist() if isinstance(value, np.ndarray) else value for name, value in vars(curve).items()}
            for curve in self.curves
        ]
        return {**vars(self), "x": self.x.tolist(), "curves": curves}

    @classmethod
    def from_json(cls, row: Mapping[str, Any]) -> Boundaries:
        """`as_json` backwards."""

        def made(one: Mapping[str, Any]) -> BoundaryCurve:
            told: dict[str, Any] = {key: np.array(it) if isinstance(it, list) else it for key, it in one.items()}
            return BoundaryCurve(**told)

        failed = tuple((value, why) for value, why in row["failed"])
        return cls(**{**row, "x": np.array(row["x"]), "curves": tuple(map(made, row["curves"])), "failed": failed})

    def __str__(self) -> str:
        head = f"{self.y_name} from {self.low:g} to {self.high:g} over {self.x.size} values of {self.x_name}"
        return "\n".join([head, *(f"  {c.kind}, branch {c.branch}: {int(c.found.sum())} points" for c in self.curves)])


def linked(kind: str, x: Array, rows: list[list[BoundaryCrossing]], span: float) -> list[BoundaryCurve]:
    """Join the points of one kind to curves: each goes on with the point that is nearest in y and phase."""
    threads: list[dict[int, BoundaryCrossing]] = []
    for i, row in enumerate(rows):
        points = [crossing for crossing in row if crossing.kind == kind]
        pairs = sorted(
            (_distance(thread[max(thread)], point, span) + _GAP * (i - 1 - max(thread)), a, b)
            for a, thread in enumerate(threads)
            for b, point in enumerate(points)
        )
        taken_threads: set[int] = set()
        taken_points: set[int] = set()
        for distance, a, b in pairs:
            if distance < _FAR and a not in taken_threads and b not in taken_points:
                threads[a][i] = points[b]
                taken_threads.add(a)
                taken_points.add(b)
        threads += [{i: point} for b, point in enumerate(points) if b not in taken_points]
    curves = []
    for thread in threads:
        columns = np.full((6, x.size), math.nan)
        for i, point in thread.items():
            columns[:, i] = point.y, point.phase, point.residual, point.angle, point.outside, point.speed
        curves.append(BoundaryCurve(kind, thread[min(thread)].branch, x, *columns))
    return curves


def _distance(a: BoundaryCrossing, b: BoundaryCrossing, span: float) -> float:
    return abs(a.y - b.y) / span + abs(math.remainder(a.phase - b.phase, 2.0 * math.pi)) / math.pi


def boundaries(
    system: System | Family,
    x: Axis | str | tuple[str, npt.ArrayLike],
    y: Axis | str | tuple[str, float, float],
    periods: int = 1,
    criterion: str = "reduced",
    *,
    modes: int | None = None,
    kinds: Sequence[str] = KINDS,
    samples: int | None = None,
    progress: Callable[[JobProgress], object] | None = None,
) -> Boundaries:
    """The boundaries of steady motions with one impact every m load periods, each point solved for as a root.

    Folds do not depend on the criterion. A branch is followed by its phase where y moves the level of B77 (14) alone
    (the load factor, the mean, the amplitude, R), otherwise by y from fold to fold. What happens twice between two
    samples of a branch, and leaves no trace in them, is not found.

    Parameters
    ----------
    system
        The system, or a family of systems, of which x and y are parameters.
    x
        A parameter and its values, also as text, ``"restitution=0:0.9:31"``; besides the family's own, "m" for the load
        periods per impact.
    y
        Another parameter and the range in which boundaries are looked for; of an axis the range of its values.
    periods
        m, unless x is m.
    criterion
        ``reduced`` for B77 (29)–(32), ``exact`` for the multipliers of modes 0 … `modes`.
    modes
        N. None: the exact multipliers of 32 modes, and grazing of the continuous bar.
    kinds
        What to look for; grazing takes the longest.
    samples
        Of each branch at first: by default 49, for the exact multipliers 33, for grazing 25, and more for many
        harmonics.
    progress
        Called with a `percuss.explore.JobProgress` that counts values of x, says which part of the present one is done
        and how long the rest will take; once it returns something true, the present value and those that follow are
        given up and count as failed.

    Returns
    -------
    Boundaries
        With a curve for everything that was found; a value of x that fails leaves NaN and says why. Some points may be
        on motions that strike backward, which only the equations have: `Boundaries.real` is without them.

    References
    ----------
    U. Björkenstam, Int. J. Mech. Sci. 19 (1977) 471–481, equations (14), (29)–(32), Figs 5, 6 and 8.

    Examples
    --------
    The range of Fig. 5 at R = 0, 0.3 and 0.6:

    >>> from percuss import Load, System
    >>> pneumatic = System(s=1e7, d=0.0, restitution=0.0, load=Load.harmonic(1.0, 1.0))
    >>> plane = ("restitution", [0.0, 0.3, 0.6]), ("load_factor", 0.0, 2.0)
    >>> found = boundaries(pneumatic, *plane, kinds=("fold", "flip"))
    >>> found.greatest("fold"), found.greatest("flip")
    (array([0.31830989, 0.59114693, 1.27323954]), array([0.26851464, 0.470072  , 0.75684712]))
    """
    family = family_of(system)
    callback("progress", progress)
    if samples is not None:
        count("samples", samples, least=2, most=10**6)
    x_name, values, y_name, low, high = checked_boundaries(family, x, y, periods, criterion, modes, kinds)
    try:
        corner = family.system({y_name: low} if x_name == PERIODS else {x_name: float(values[0]), y_name: low})
    except PercussError:
        pass  # there is none
    else:
        need_free(corner.body, "boundary curves; `follow` finds those of structures")
    meter = Meter(values.size, 0, progress)
    rows: list[list[BoundaryCrossing]] = []
    failed: list[tuple[float, str]] = []
    meter.start(0)
    with halting(meter):
        for value in values.tolist():
            fixed, m = ({}, int(value)) if x_name == PERIODS else ({x_name: value}, periods)
            rows.append([])
            try:
                line = Line(family, fixed, y_name, low, high, m, modes, told=meter.within)
                rows[-1] = _on_line(line, criterion, tuple(kinds), samples)
            except Interrupted:
                failed.append((value, "given up"))
            except PercussError as error:
                failed.append((value, str(error)))
            meter.add(1)
        meter.tell()
    curves = [curve for kind in KINDS if kind in kinds for curve in linked(kind, values, rows, high - low)]
    return Boundaries(x_name, y_name, values, low, high, tuple(curves), tuple(failed))


def checked_boundaries(
    family: Family,
    x: Axis | str | tuple[str, npt.ArrayLike],
    y: Axis | str | tuple[str, float, float],
    periods: int = 1,
    criterion: str = "reduced",
    modes: int | None = None,
    kinds: Sequence[str] = KINDS,
) -> tuple[str, Array, str, float, float]:
    """The names, values and range of a question to `boundaries`; ParameterError when it has no answer."""
    kinds = several("kinds", kinds, f"some of {', '.join(KINDS)}")
    if isinstance(x, Axis | str):
        axis = Axis.parsed(x) if isinstance(x, str) else x
    else:
        _check_line("x", x, 2, "(name, values) or an Axis")
        axis = Axis(x[0], np.atleast_1d(numbers(x[0], x[1])))
    y = Axis.parsed(y) if isinstance(y, str) else y
    if isinstance(y, Axis):
        y = y.name, float(y.values.min()), float(y.values.max())
    _check_line("y", y, 3, "(name, lowest, highest) or an Axis")
    name, low, high = y[0], finite(y[0], y[1]), finite(y[0], y[2])
    if not low < high:
        raise ParameterError(name, (low, high), "a range from a lower to a higher value")
    things = [PARAMETERS[own].thing if own in PARAMETERS else own for own in (name, axis.name)]
    if things[0] == things[1]:
        raise ParameterError("y", name, f"a parameter that can be moved beside {axis.name}")
    units: Mapping[str, str] = getattr(family, "units", {})  # of a case's keys; plain numbers have none
    names = {axis.name: axis.unit or units.get(axis.name, ""), name: units.get(name, "")}
    if name == PERIODS:
        raise ParameterError("y", name, "a parameter that is not a whole number")
    if names.pop(PERIODS, None) is not None:
        for value in axis.values.tolist():
            count(PERIODS, int(value) if value == int(value) else value, most=MAX_PERIODS)
    family.check(names)
    count("periods", periods, most=MAX_PERIODS)
    if modes is not None:
        count("modes", modes, least=0, most=MAX_MODES)
    if criterion not in CRITERIA:
        raise ParameterError("criterion", criterion, f"one of {', '.join(CRITERIA)}")
    unknown = [kind for kind in kinds if not isinstance(kind, str) or kind not in KINDS]
    if unknown or not kinds:
        raise ParameterError("kinds", unknown[0] if unknown else kinds, f"some of {', '.join(KINDS)}")
    return axis.name, axis.values, name, low, high


def _check_line(axis: str, line: object, size: int, accepted: str) -> None:
    if not isinstance(line, tuple | list) or len(line) != size or not isinstance(line[0], str):
        raise ParameterError(axis, line, accepted)


def _on_line(line: Line, criterion: str, kinds: tuple[str, ...], samples: int | None) -> list[BoundaryCrossing]:
    """Everything that happens at one value of x; ParameterError where it does not hold for the contact law."""
    line.middle.contact.need(Result.LEVEL)
    if criterion == "reduced" and {FLIP, SPIRAL} & set(kinds):
        line.middle.contact.need(Result.REDUCED)
    alone = set(kinds) == {FOLD}
    folds, stretches = folds_and_stretches(line, samples or (17 if alone else 33), alone)
    found = folds if FOLD in kinds else []
    exact, grazing = criterion == "exact" and bool({FLIP, SPIRAL} & set(kinds)), GRAZING in kinds
    parts = len(stretches) * max(exact + grazing, 1)  # of the work; the reduced criterion is hardly any
    part = 0

    def told(share: float) -> None:
        if line.told is not None:
            line.told((part + share) / parts)

    for stretch in stretches:
        crossings: list[BoundaryCrossing] = []
        if exact:
            most = DEFAULT_MODES if line.modes is None else line.modes
            crossings += exact_crossings(stretch, samples, most, SPIRAL in kinds, told)
            part += 1
        elif FLIP in kinds or SPIRAL in kinds:
            crossings += reduced_crossings(stretch, samples, SPIRAL in kinds)
        if grazing:
            crossings += grazings(stretch, samples, told)
            part += 1
        found += [crossing for crossing in crossings if crossing.kind in kinds]
    return [crossing._replace(speed=_speed(line, crossing)) for crossing in found]


def _speed(line: Line, crossing: BoundaryCrossing) -> float:
    few = DEFAULT_MODES if line.modes is None else line.modes
    motion = Orbit(line.system(crossing.y), line.periods, crossing.phase, False, few)
    if line.modes is None and motion.impact_velocity < 0.2 * motion.rigid_velocity:
        motion = replace(motion, requested_modes=None)
    return motion.impact_velocity
