"""Maps: quantities of a system over a parameter curve or plane."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np

from percuss.errors import ParameterError, PercussError, extra_package
from percuss.explore.attractors.hammers import CYCLE_KINDS
from percuss.explore.cells import StrikingFamily, SweepJob, SystemFunction, label_text
from percuss.explore.family import Axis, Family, drives_itself, family_of
from percuss.explore.jobs.archive_export import OfColumns, variables_of
from percuss.explore.jobs.job import Column, Columns
from percuss.explore.parameters import PERIODS
from percuss.explore.quantities import (
    CELL_OUTCOMES,
    DEFAULT_MACHINE_QUANTITIES,
    DEFAULT_QUANTITIES,
    MACHINE_QUANTITIES,
    OF_FREE_BARS,
    QUANTITIES,
    REASONS,
    STALLS,
    checked,
    known_quantities,
)
from percuss.model import HeldBody, Machine, ModalBody, System
from percuss.model.checks import DEFAULT_MODES, count, instance, mapping
from percuss.simulate import OUTCOMES
from percuss.steady.states import MAX_MODES, MAX_PERIODS

if TYPE_CHECKING:
    import xarray

    from percuss.simulate import Start, Stop


_MOST_IMPACTS = 10**7


def sweep_job(
    what: System | Machine | Family,
    *axes: Axis | str | tuple[Any, ...],
    quantities: Sequence[str] | None = None,
    periods: int = 1,
    modes: int | None = None,
    simulated: int = DEFAULT_MODES,
    start: Start | None = None,
    stop: Stop | None = None,
    impacts: int = 2000,
    discard: int = 500,
    functions: Mapping[str, SystemFunction] | None = None,
) -> SweepJob:
    """The job of a sweep, checked; see `sweep`. `simulated`: elastic modes of simulations if `modes` does not say."""
    from percuss.simulate import Start, Stop

    family = family_of(what)
    own = mapping("functions", {} if functions is None else functions, "functions of a system by name")
    for name, function in own.items():
        if name in QUANTITIES or name in MACHINE_QUANTITIES or name == "outcome" or not str(name).isidentifier():
            raise ParameterError("functions", name, "a name of one word that no quantity has")
        if not callable(function):
            raise ParameterError(name, function, "a function of a system")
    by_default = quantities is None
    if quantities is None:
        quantities = DEFAULT_MACHINE_QUANTITIES if drives_itself(family) else DEFAULT_QUANTITIES
    names = checked(quantities, known_quantities(family)) if quantities or not own else ()
    spans = tuple(map(Axis.of, axes))
    _check_axes(family, spans)
    number = None if modes is None else count("modes", modes, least=0, most=MAX_MODES)
    job = SweepJob(
        family=family,
        axes=spans,
        quantities=names,
        periods=count("periods", periods, most=MAX_PERIODS),
        modes=number,
        simulated=count("modes", simulated, least=0, most=MAX_MODES) if number is None else number,
        start=None if start is None else instance("start", start, Start),
        stop=Stop() if stop is None else instance("stop", stop, Stop),
        impacts=count("impacts", impacts, least=10, most=_MOST_IMPACTS),
        discard=count("discard", discard, least=0, most=_MOST_IMPACTS),
        functions=tuple(own.items()),
    )
    if struck := job.groups & {"blow", "transfer"}:
        name = next(name for name in names if known_quantities(family)[name].group in struck)
        if not isinstance(family, StrikingFamily):
            remedy = "only a case says what is struck: percuss.case.CaseFamily, or percuss sweep"
            raise ParameterError("quantities", name, "quantities of the motion", remedy)
        if "blow" in struck and any(axis.name == PERIODS for axis in spans):
            raise ParameterError(PERIODS, "on an axis", "quantities of the motion only", "a blow has no load periods")
    made: System | Machine | None = None
    if job.asks_hammers:
        made = _check_makes(job, job.hammer)
        if "flow" in names and isinstance(made, Machine) and made.is_si and made.pressure is None:
            remedy = "give pressure, that of the supply, in [load]"
            raise ParameterError("quantities", "flow", "what needs no pressure: this machine has none", remedy)
    if isinstance(family, StrikingFamily) and "blow" in job.groups:
        _check_makes(job, lambda cell: family.blow(job.values(cell)))
    if isinstance(family, StrikingFamily) and "transfer" in job.groups:
        whole = _check_makes(job, lambda cell: family.whole(job.values(cell), job.periods, job.modes))
        if whole.tool is None:
            remedy = "describe the rod that is struck in [tool]"
            raise ParameterError("quantities", "rock_power", "quantities of the motion alone", remedy)
    if number is None and isinstance(made, Machine) and made.valve.flows:  # whose steps each mode shortens
        job = replace(job, simulated=0)
    if made is None or made.body.is_free:
        return job
    # of a structure that is held without what only free bars have, which is refused if it was asked for
    unfit, body = [name for name in names if name in OF_FREE_BARS], made.body
    if unfit and not by_default:
        raise ParameterError("quantities", unfit[0], "quantities of a structure that is held", OF_FREE_BARS[unfit[0]])
    if "stress" in names and isinstance(body, ModalBody):
        raise ParameterError("quantities", "stress", "what a table of modes knows", "ask for blow_energy")
    job = replace(job, quantities=tuple(name for name in names if name not in unfit))
    if not isinstance(body, HeldBody):
        return job
    return replace(job, modes=None if number is None else body.chosen(number), simulated=body.chosen(job.simulated))


def _check_makes(job: SweepJob, made: Callable[[Mapping[str, float]], Any]) -> Any:
    """What is made of a cell; the refusal of the first, when none of several over the map has an answer."""
    refused: list[Exception] = []
    some = np.unique([[0, n // 3, n // 2, 2 * n // 3, n - 1] for n in job.shape], axis=1)
    for place in product(*some.tolist()):
        try:
            return made(job.cell(int(np.ravel_multi_index(place, job.shape))))
        except (PercussError, ArithmeticError) as error:
            refused.append(error)
    raise refused[0]


def _check_axes(family: Family, axes: tuple[Axis, ...]) -> None:
    if not axes:
        raise ParameterError("axes", None, "one or more axes, such as restitution=0:0.9:200")
    names = [axis.name for axis in axes]
    twice = [name for name in names if names.count(name) > 1]
    if twice:
        raise ParameterError("axes", twice[0], "each parameter on one axis only")
    for axis in axes:
        if axis.name == PERIODS and drives_itself(family):
            raise ParameterError(PERIODS, "on an axis", "a load that keeps time", "a piston that switches it has none")
        whole = axis.values.min() >= 1 and axis.values.max() <= MAX_PERIODS and not np.any(axis.values % 1.0)
        if axis.name == PERIODS and (axis.unit or not whole):
            raise ParameterError(PERIODS, axis.values, f"whole numbers from 1 to {MAX_PERIODS}")
    family.check({axis.name: axis.unit for axis in axes if axis.name != PERIODS})


@dataclass(frozen=True, eq=False)
class Sweep(OfColumns):
    """A map: the columns of all cells.

    Attributes
    ----------
    arrays
        By column, of the map's shape, and of one item's shape behind it.
    """

    axes: tuple[Axis, ...]
    quantities: tuple[str, ...]
    arrays: dict[str, np.ndarray[Any, Any]]
    columns: Mapping[str, Column]
    ask: dict[str, Any]

    def __str__(self) -> str:
        over = " × ".join(f"{len(axis)} values of {axis.name}" for axis in self.axes)
        modes = "continuous bar" if self.ask["modes"] is None else f"{self.ask['modes']} modes"
        return f"Sweep: {over}; {', '.join(self.quantities)}; {modes}"

    @classmethod
    def from_archive(cls, archive: Any) -> Sweep:
        """The map in an archive; cells that are not done hold the fill values of their columns."""
        return cls._of(archive.ask, archive.columns, archive.read())

    @classmethod
    def shaped(cls, job: SweepJob, flat: Columns) -> Sweep:
        """The result of a job, in the map's shape."""
        return cls._of(job.ask, job.columns, flat)

    @classmethod
    def _of(cls, ask: dict[str, Any], columns: Mapping[str, Column], flat: Columns) -> Sweep:
        axes = tuple(Axis(a["name"], a["values"], a["unit"]) for a in ask["axes"])
        shape = tuple(len(axis) for axis in axes)
        arrays = {name: np.asarray(flat[name]).reshape(*shape, *columns[name].shape) for name in columns}
        return cls(axes, (*ask["quantities"], *ask.get("functions", ())), arrays, columns, ask)

    @property
    def words(self) -> dict[str, tuple[str, ...]]:
        """What is kept as the number of a word, and the words."""
        return {"outcome": CELL_OUTCOMES, "reason": REASONS, "stall": STALLS}

    def __getitem__(self, quantity: str) -> np.ndarray[Any, Any]:
        """One quantity over the map; labels in words."""
        if quantity == "label" and "label" in self.quantities:
            return label_text(self.arrays)
        if quantity not in self.arrays:
            known = [name for name in (*self.quantities, "outcome")]
            raise ParameterError("quantity", quantity, f"one of {', '.join(known)}")
        return self.arrays[quantity]

    @property
    def _about(self) -> Mapping[str, Column]:
        return self.columns

    def to_xarray(self) -> xarray.Dataset:
        """The map with named coordinates and units; labels are words, numbers of words have them in ``words``."""
        names, shape = [axis.name for axis in self.axes], [len(axis) for axis in self.axes]
        known: dict[str, Sequence[str]] = {**self.words, "label_outcome": OUTCOMES, "label_kind": CYCLE_KINDS}
        variables = variables_of(self.columns, self.arrays, names, shape, {"phases": "orbit"}, known)
        if "label" in self.quantities:
            variables["label"] = (names, label_text(self.arrays).astype(object), {"long_name": "motion label"})
        coordinates = {axis.name: axis.coordinate() for axis in self.axes}
        made: xarray.Dataset = extra_package("xarray", "io").Dataset(variables, coordinates, {"kind": "sweep"})
        return made


def sweep(
    what: System | Machine | Family,
    *axes: Axis | str | tuple[Any, ...],
    quantities: Sequence[str] | None = None,
    periods: int = 1,
    modes: int | None = None,
    start: Start | None = None,
    stop: Stop | None = None,
    impacts: int = 2000,
    discard: int = 500,
    functions: Mapping[str, SystemFunction] | None = None,
    **running: Any,
) -> Sweep:
    """Quantities of a system over a parameter curve (one axis), a plane (two), or more.

    Parameters
    ----------
    what
        A system, or a machine that switches its own valve, whose dimensionless parameters are varied; or a family, such
        as `percuss.case.CaseFamily`.
    axes
        Text such as ``"restitution=0:0.9:200"``, ``(name, values)``, ``(name, first, last, number)`` or `Axis`;
        ``m`` is the load periods per impact. The names are those of the family's parameters.
    quantities
        Names of `percuss.explore.QUANTITIES`, for machines of `percuss.explore.MACHINE_QUANTITIES`; by default some of
        those that cost little.
    periods
        m, when it is no axis.
    modes
        N: every quantity is that of the bar of modes 0 … N. None, as elsewhere: the steady motions are those of the
        continuous bar, the exact multipliers, the simulations and the machines take 32 modes.
    start, stop
        Of the simulations. By default each starts at rest one bar length off the wall, or as the case says, and ends
        when its motion is found, after 2000 impacts at the latest.
    impacts, discard
        Of a Lyapunov exponent: the impacts it is taken from, and those that are let pass before.
    functions
        One's own quantities by name: functions of a system or machine that return a number. Worker processes import
        them: from a module, or from the main part of a script whose call stands under a main guard. One that raises a
        `PercussError` or divides by 0 leaves NaN.
    **running
        How it is carried out: ``workers``, ``archive``, ``resume``, ``pool``, ``progress``; see
        `percuss.explore.carry_out`.

    Examples
    --------
    >>> from percuss import Load, System
    >>> from percuss.explore import sweep
    >>> system = System(s=20.0, d=0.0, restitution=0.6, load=Load.harmonic(0.9, 1.0))
    >>> found = sweep(system, "restitution=0.2,0.6", "load_factor=0.4,0.9", quantities=["orbits", "stable"], workers=1)
    >>> found["orbits"]
    array([[2, 0],
           [2, 2]], dtype=int16)
    >>> found.to_xarray()["stable"].sel(restitution=0.6).values
    array([False,  True])
    """
    from percuss.explore.jobs.carrying_out import carry_out

    job = sweep_job(
        what, *axes, quantities=quantities, periods=periods, modes=modes, start=start, stop=stop, impacts=impacts,
        discard=discard, functions=functions,
    )  # fmt: skip
    return Sweep.shaped(job, carry_out(job, **running))


# ---- Where along the one axis of a map something is true: ranges whose ends are solved for between its values

_HALVES = 30
_LAST = 1e-9  # share of the axis to which an end is found


@dataclass(frozen=True)
class Range:
    """A part of an axis, in its unit: its ends, inside it, and whether it ends there and not with the axis."""

    first: float
    last: float
    opens: bool
    closes: bool


def true_ranges(job: SweepJob, found: Sweep, quantity: str) -> tuple[Range, ...]:
    """Where a yes-or-no quantity of a map with one axis is true, to 1e-9; not what lies between neighbours."""
    if len(job.axes) != 1:
        raise ParameterError("axes", len(job.axes), "a map with one axis")
    values, truth = job.axes[0].values, found[quantity]
    if truth.dtype != bool or truth.ndim != 1:
        raise ParameterError("quantity", quantity, "one that is yes or no, such as stable or exists")
    ranges = []
    edges = np.flatnonzero(np.diff(np.concatenate([[False], truth, [False]]).astype(int)))
    for i, j in zip(edges[::2].tolist(), (edges[1::2] - 1).tolist(), strict=True):
        opens, closes = i > 0, j < values.size - 1
        first = _end(job, quantity, float(values[i]), float(values[i - 1])) if opens else float(values[i])
        last = _end(job, quantity, float(values[j]), float(values[j + 1])) if closes else float(values[j])
        ranges.append(Range(first, last, opens, closes))
    return tuple(ranges)


def _end(job: SweepJob, quantity: str, inside: float, outside: float) -> float:
    """The last value at which it is true, from one where it is towards one where it is not."""
    axis = job.axes[0]
    if axis.name == PERIODS:
        return inside
    alone = replace(job, quantities=(quantity,), functions=())
    for _ in range(_HALVES):
        if abs(outside - inside) <= _LAST * float(np.ptp(axis.values)):
            break
        middle = 0.5 * (inside + outside)
        cell = replace(alone, axes=(Axis(axis.name, np.array([middle]), axis.unit),))
        if cell.compute(0, 1, lambda: False)[quantity][0]:
            inside = middle
        else:
            outside = middle
    return inside
