"""Maps: quantities of a system over a parameter curve or plane."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product
from math import prod
from typing import TYPE_CHECKING, Any

import numpy as np

from percuss.errors import MissingExtraError, ParameterError, PercussError
from percuss.explore.cells import (
    NO_START,
    Asked,
    StrikingFamily,
    SystemFunction,
    blow_columns,
    cell_columns,
    checked_functions,
    failure,
    fits_plane,
    function_values,
    label_text,
    machine_columns,
    plane_columns,
    qualified,
)
from percuss.explore.family import Axis, Family, drives_itself, family_of
from percuss.explore.jobs.job import ASK_FORMAT, Column, Columns
from percuss.explore.parameters import PERIODS
from percuss.explore.quantities import (
    CELL_OUTCOMES,
    CYCLE_KINDS,
    DEFAULT_MACHINE_QUANTITIES,
    DEFAULT_QUANTITIES,
    OF_FREE_BARS,
    REASONS,
    STALLS,
    Group,
    checked,
    columns_of,
    known_quantities,
    needs,
)
from percuss.explore.rough_time import seconds_of_cell, seconds_of_plane_cell
from percuss.model import Body, HeldBody, Machine, ModalBody, System
from percuss.model.checks import Array, count, instance
from percuss.shown import Shown
from percuss.simulate import OUTCOMES
from percuss.stability.verdict import DEFAULT_MODES
from percuss.steady.states import MAX_MODES, MAX_PERIODS

if TYPE_CHECKING:
    import xarray

    from percuss.explore.jobs.archive import Archive
    from percuss.simulate import Start, Stop


# ---- A map as a job: its cells, and what is asked of them


@dataclass(frozen=True, eq=False)
class SweepJob:
    """A map as a job: its items are the cells, the last axis running fastest.

    Attributes
    ----------
    family
        Gives the system, or the machine, of each cell.
    axes
        One or more.
    quantities
        Names; see `percuss.explore.QUANTITIES`, and `percuss.explore.MACHINE_QUANTITIES` for machines.
    periods
        m, where it is no axis.
    modes
        N, of the steady motions, their multipliers and the simulations; None for the steady motions of the continuous
        bar, multipliers of 32 modes, and simulations of `simulated`.
    simulated
        N of the simulations.
    start
        Of the simulations; None for that of the family.
    stop
        Of the simulations.
    impacts, discard
        Of a Lyapunov exponent.
    functions
        One's own quantities, by name.
    """

    family: Family
    axes: tuple[Axis, ...]
    quantities: tuple[str, ...]
    periods: int
    modes: int | None
    simulated: int
    start: Start | None
    stop: Stop
    impacts: int
    discard: int
    functions: tuple[tuple[str, SystemFunction], ...] = ()

    @property
    def shape(self) -> tuple[int, ...]:
        """Numbers of cells along the axes of the map."""
        return tuple(len(axis) for axis in self.axes)

    @property
    def size(self) -> int:
        """Number of cells."""
        return prod(self.shape)

    @property
    def groups(self) -> set[Group]:
        """The groups of what is asked."""
        return needs(self.quantities, known_quantities(self.family))

    @property
    def rough_seconds(self) -> float:
        """What all cells take, by rule of thumb."""
        groups = self.groups
        if self._is_plane:
            return self.size * seconds_of_plane_cell(groups, self.multiplier_modes)
        return self.size * seconds_of_cell(groups, self.multiplier_modes, self.simulated, len(self.functions))

    @property
    def _is_plane(self) -> bool:
        return not self.functions and fits_plane(self.family, [axis.name for axis in self.axes], self.quantities)

    @property
    def multiplier_modes(self) -> int:
        """N of the exact multipliers."""
        return DEFAULT_MODES if self.modes is None else self.modes

    @property
    def asks_systems(self) -> bool:
        """Whether anything is asked of the motion; a case of one blow alone has no system."""
        return bool(self.functions) or bool(self.groups - {"blow"})

    @cached_property
    def is_si(self) -> bool:
        """Whether the systems have scales: energies are in J then."""
        family = self.family
        if isinstance(family, StrikingFamily) and not drives_itself(family):
            return family.is_si
        make = family.machine if drives_itself(family) else family.system
        for at in (0, self.size // 2, self.size - 1):
            try:
                return make(self.system_values(self.cell(at))).is_si
            except PercussError:
                continue
        return False

    @property
    def columns(self) -> Mapping[str, Column]:
        """The columns of the quantities asked for, and the outcome of each cell."""
        own = {name: Column(meaning=f"of {qualified(function)}") for name, function in self.functions}
        return {**columns_of(self.quantities, self.is_si, known_quantities(self.family)), **own}

    @property
    def ask(self) -> dict[str, Any]:
        """Axes, quantities, the family and the options."""
        wanted = self.groups
        simulated = bool(wanted & {"simulation", "lyapunov"})
        of_machines = drives_itself(self.family)
        ask: dict[str, Any] = {
            "kind": "sweep",
            "percuss": ASK_FORMAT,
            "axes": [axis.to_json_dict() for axis in self.axes],
            "quantities": list(self.quantities),
            **({"machines": True} if of_machines else {"periods": self.periods}),
            "modes": self.multiplier_modes if wanted & {"orbits", "exact"} or not simulated else self.simulated,
            "family": self.family.describe(),
        }
        if self.modes is not None and wanted & {"orbits", "exact"}:
            ask["cut"] = self.modes
        if simulated:
            if ask["modes"] != self.simulated:
                ask["simulated"] = self.simulated
            ask["start"] = None if self.start is None else _described(self.start, self.simulated)
            ask["stop"] = {"impacts": self.stop.impacts, "time": self.stop.time, "tolerance": self.stop.tolerance}
            if "lyapunov" in self.quantities:
                ask["lyapunov"] = {"impacts": self.impacts, "discard": self.discard}
        if self.functions:
            ask["functions"] = {name: qualified(function) for name, function in self.functions}
        return ask

    def cell(self, i: int) -> dict[str, float]:
        """The parameters of cell number `i`."""
        at = np.unravel_index(i, self.shape)
        return {axis.name: float(axis.values[j]) for axis, j in zip(self.axes, at, strict=True)}

    def system_values(self, cell: Mapping[str, float]) -> dict[str, float]:
        """Those of a cell's parameters that its system has."""
        return {name: value for name, value in cell.items() if name != PERIODS}

    def compute(self, first: int, last: int, stopped: Callable[[], bool]) -> Columns:
        """The columns of the cells `first` … `last` − 1."""
        if self._is_plane:
            return self._by_plane(first, last)
        cells = [self.cell(i) for i in range(first, last)]
        whats: Sequence[System | Machine | None]
        if drives_itself(self.family):
            asked = self.quantities, self.multiplier_modes, self.is_si
            found, whats = machine_columns(self.family, cells, *asked, stopped)
        else:
            found, whats = self._of_systems(cells, stopped)
        if isinstance(self.family, StrikingFamily) and "blow" in self.groups:
            blow_columns(found, self.family, cells[: len(whats)], stopped)
        for name, function in self.functions:
            found[name] = function_values(function, whats, found["outcome"])
        return found

    @property
    def _asked(self) -> Asked:
        return Asked(
            self.quantities,
            self.multiplier_modes,
            self.modes,
            self.simulated,
            self.stop,
            self.impacts,
            self.discard,
            self.is_si,
        )

    def _of_systems(
        self, cells: Sequence[Mapping[str, float]], stopped: Callable[[], bool]
    ) -> tuple[Columns, list[System | None]]:
        """The columns of cells, one by one, and their systems."""
        systems: list[System | None] = []
        starts: list[Start | None] = []
        outcomes, periods = [], []
        for cell in cells:
            if stopped():
                break
            system, start, outcome = None, None, 0
            try:
                if self.asks_systems:
                    system = self.family.system(self.system_values(cell))
                    start = self._start(cell)
            except (PercussError, ArithmeticError) as error:
                outcome = failure(error) if system is None else NO_START
            systems.append(system)
            starts.append(start)
            outcomes.append(outcome)
            periods.append(int(cell.get(PERIODS, self.periods)))
        return cell_columns(self._asked, systems, outcomes, periods, starts, stopped), systems

    def _start(self, cell: Mapping[str, float]) -> Start | None:
        """The start of a cell's simulation; None when nothing is simulated."""
        if not self.groups & {"simulation", "lyapunov"}:
            return None
        if self.start is not None:
            return self.start
        from percuss.simulate import Start

        of_family = getattr(self.family, "start", None)
        return Start.rigid() if of_family is None else of_family(self.system_values(cell), self.simulated)

    def _by_plane(self, first: int, last: int) -> Columns:
        """All cells at once where only R, the load factor and m differ: the closed form over arrays."""
        at = np.unravel_index(np.arange(first, last), self.shape)
        values = {axis.name: axis.values[j] for axis, j in zip(self.axes, at, strict=True)}
        periods = values.pop(PERIODS, np.full(last - first, float(self.periods))).astype(int)
        return plane_columns(self._asked, self.family.system({}), values, periods)


def _described(start: Start, modes: int) -> dict[str, Any]:
    """A start in JSON's types."""
    displacement, velocity, gap = start.state(modes)
    return {
        "displacement": np.asarray(displacement).tolist(),
        "velocity": np.asarray(velocity).tolist(),
        "gap": float(gap),
        "time": start.time,
    }


# ---- The question of a sweep: its job, and which questions have no answer

_MOST_IMPACTS = 10**7


def sweep_job(
    what: System | Machine | Family,
    *axes: Axis | str,
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
    """The job of a sweep, checked; see `sweep`.

    Parameters
    ----------
    simulated
        Elastic modes of the simulations, when `modes` does not say it.
    """
    from percuss.simulate import Start, Stop

    family = family_of(what)
    own, by_default = checked_functions({} if functions is None else functions), quantities is None
    if quantities is None:
        quantities = DEFAULT_MACHINE_QUANTITIES if drives_itself(family) else DEFAULT_QUANTITIES
    names = checked(quantities, known_quantities(family)) if quantities or not own else ()
    spans = tuple(axis if isinstance(axis, Axis) else Axis.parsed(axis) for axis in axes)
    _check_axes(family, spans)
    _check_blows(family, names, spans)
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
        functions=own,
    )
    made = _check_some(job)
    return job if made is None or made.body.is_free else _of_held(job, made.body, by_default)


def _check_blows(family: Family, names: Sequence[str], axes: Sequence[Axis]) -> None:
    """Refuse what no blow depends on, and systems that do not know what they strike."""
    name = next((name for name in names if known_quantities(family)[name].group == "blow"), None)
    if name is None:
        return
    if not isinstance(family, StrikingFamily):
        remedy = "only a case says what is struck: percuss.case.CaseFamily, or percuss sweep"
        raise ParameterError("quantities", name, "quantities of the motion", remedy)
    if any(axis.name == PERIODS for axis in axes):
        raise ParameterError(PERIODS, "on an axis", "quantities of the motion only", "a blow has no load periods")


def _of_held(job: SweepJob, body: Body, by_default: bool) -> SweepJob:
    """The job for a structure that is held: without what only free bars have, which is refused if it was asked for."""
    unfit = [name for name in job.quantities if name in OF_FREE_BARS]
    if unfit and not by_default:
        raise ParameterError("quantities", unfit[0], "quantities of a structure that is held", OF_FREE_BARS[unfit[0]])
    if "stress" in job.quantities and isinstance(body, ModalBody):
        raise ParameterError("quantities", "stress", "what a table of modes knows", "ask for blow_energy")
    names = tuple(name for name in job.quantities if name not in unfit)
    if not isinstance(body, HeldBody):
        return replace(job, quantities=names)
    kept = None if job.modes is None else body.chosen(job.modes)
    return replace(job, quantities=names, modes=kept, simulated=body.chosen(job.simulated))


def _check_some(job: SweepJob) -> System | Machine | None:
    """What is made of a cell; the refusal of the first, when none of several over the map has an answer."""
    family = job.family
    made: System | Machine | None = None
    if job.asks_systems:
        made = _check_makes(job, family.machine if drives_itself(family) else family.system)
        if "flow" in job.quantities and isinstance(made, Machine) and made.is_si and made.pressure is None:
            remedy = "give pressure, that of the supply, in [load]"
            raise ParameterError("quantities", "flow", "what needs no pressure: this machine has none", remedy)
    if isinstance(family, StrikingFamily) and "blow" in job.groups:
        _check_makes(job, family.blow)
    return made


def _check_makes(job: SweepJob, made: Callable[[Mapping[str, float]], object]) -> Any:
    refused: list[Exception] = []
    some = np.unique([[0, n // 3, n // 2, 2 * n // 3, n - 1] for n in job.shape], axis=1)
    for place in product(*some.tolist()):
        cell = job.cell(int(np.ravel_multi_index(place, job.shape)))
        try:
            return made(job.system_values(cell))
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
        if axis.name == PERIODS and (axis.unit or np.any(axis.values % 1.0) or not _whole(axis.values)):
            raise ParameterError(PERIODS, axis.values, f"whole numbers from 1 to {MAX_PERIODS}")
    family.check({axis.name: axis.unit for axis in axes if axis.name != PERIODS})


def _whole(values: Array) -> bool:
    return bool(values.min() >= 1 and values.max() <= MAX_PERIODS)


# ---- Maps: quantities of a system over a parameter curve or plane


@dataclass(frozen=True, eq=False)
class Sweep(Shown):
    """A map: the columns of all cells.

    Attributes
    ----------
    axes
        The parameters and their values.
    quantities
        What was asked for.
    arrays
        By column, of the map's shape, and of one item's shape behind it.
    columns
        What they hold.
    ask
        All that was asked.
    """

    axes: tuple[Axis, ...]
    quantities: tuple[str, ...]
    arrays: dict[str, np.ndarray[Any, Any]]
    columns: Mapping[str, Column]
    ask: dict[str, Any]

    def __str__(self) -> str:
        over = " × ".join(f"{len(axis)} values of {axis.name}" for axis in self.axes)
        return f"Sweep: {over}; {', '.join(self.quantities)}"

    @classmethod
    def from_archive(cls, archive: Archive) -> Sweep:
        """The map in an archive; cells that are not done hold the fill values of their columns."""
        ask = archive.ask
        axes = tuple(Axis(a["name"], a["values"], a["unit"]) for a in ask["axes"])
        return cls._shaped(axes, _asked(ask), archive.read(), archive.columns, ask)

    @classmethod
    def shaped(cls, job: SweepJob, flat: Columns) -> Sweep:
        """The result of a job, in the map's shape."""
        return cls._shaped(job.axes, _asked(job.ask), flat, job.columns, job.ask)

    @classmethod
    def _shaped(
        cls,
        axes: tuple[Axis, ...],
        quantities: tuple[str, ...],
        flat: Columns,
        columns: Mapping[str, Column],
        ask: dict[str, Any],
    ) -> Sweep:
        shape = tuple(len(axis) for axis in axes)
        arrays = {name: np.asarray(flat[name]).reshape(*shape, *columns[name].shape) for name in columns}
        return cls(axes, quantities, arrays, columns, ask)

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

    @cached_property
    def dataset(self) -> xarray.Dataset:
        """The map with named coordinates and units, labels in words."""
        pass

        return map_dataset(self.axes, self.quantities, self.arrays, self.columns, self.words)


def _asked(ask: Mapping[str, Any]) -> tuple[str, ...]:
    """All quantities of a map, one's own last."""
    return (*ask["quantities"], *ask.get("functions", ()))


def sweep(
    what: System | Machine | Family,
    *axes: Axis | str,
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
        `Axis`, or text such as ``"restitution=0:0.9:200"``; ``m`` is the load periods per impact. The names are those
        of the family's parameters.
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

    Returns
    -------
    Sweep
        With a value in every cell; what could not be computed in one is its ``outcome``.

    Raises
    ------
    ParameterError
        For parameters and quantities that there are not, or axes that do not go together.

    Examples
    --------
    >>> from percuss import Load, System
    >>> from percuss.explore import sweep
    >>> system = System(s=20.0, d=0.0, restitution=0.6, load=Load.harmonic(0.9, 1.0))
    >>> found = sweep(system, "restitution=0.2,0.6", "load_factor=0.4,0.9", quantities=["orbits", "stable"], workers=1)
    >>> found["orbits"]
    array([[2, 0],
           [2, 2]], dtype=int16)
    >>> found.dataset["stable"].sel(restitution=0.6).values
    array([False,  True])
    """
    from percuss.explore.jobs.carrying_out import carry_out

    job = sweep_job(
        what, *axes, quantities=quantities, periods=periods, modes=modes, start=start, stop=stop, impacts=impacts,
        discard=discard, functions=functions,
    )  # fmt: skip
    return Sweep.shaped(job, carry_out(job, **running))


# ---- Results as xarray datasets: named coordinates, units, and a sentence for each variable

_LABEL_WORDS = {"label_outcome": OUTCOMES, "label_kind": CYCLE_KINDS}
"""Of the numbers that a label is kept in."""


def map_dataset(
    axes: Sequence[Axis],
    quantities: Collection[str],
    arrays: Columns,
    columns: Mapping[str, Column],
    known: Mapping[str, Sequence[str]],
) -> xarray.Dataset:
    """A map; what is kept as numbers of words has them in its attribute ``words``, labels are words themselves.

    Parameters
    ----------
    axes, quantities, arrays, columns
        As a `percuss.explore.Sweep` has them.
    known
        Of each column that is kept as numbers of words, the words.

    Raises
    ------
    MissingExtraError
        Without xarray.
    """
    try:
        import xarray
    except ImportError:
        raise MissingExtraError("xarray", "io") from None
    names = [axis.name for axis in axes]
    variables: dict[str, Any] = {}
    for name, column in columns.items():
        extra = ["orbit"] if column.shape else []
        attributes = {"units": column.unit or "1", "long_name": column.meaning}
        words = known.get(name) or _LABEL_WORDS.get(name)
        if words is not None:
            attributes["words"] = ", ".join(words)
        variables[name] = ([*names, *extra], arrays[name], attributes)
    if "label" in quantities:
        variables["label"] = (names, label_text(arrays).astype(object), {"long_name": "motion label"})
    coordinates = {axis.name: axis.coordinate() for axis in axes}
    return xarray.Dataset(variables, coordinates, {"kind": "sweep"})


# ---- Where along the one axis of a map something is true: ranges whose ends are solved for between its values

_HALVES = 30
_LAST = 1e-9  # share of the axis to which an end is found


@dataclass(frozen=True)
class Range:
    """A part of an axis, in its unit.

    Attributes
    ----------
    first, last
        Its ends, inside it.
    opens, closes
        Whether it ends there, and not with the axis.
    """

    first: float
    last: float
    opens: bool
    closes: bool


def true_ranges(job: SweepJob, found: Sweep, quantity: str) -> tuple[Range, ...]:
    """Where a yes-or-no quantity of a map with one axis is true.

    An end lies between two neighbouring values of the axis; the cells between them are asked until it is known to 1e-9
    of the axis. What begins and ends between two neighbours is not seen.

    Parameters
    ----------
    job, found
        The map's job and what it came to.
    quantity
        Such as ``stable``, ``exists`` or ``admissible``.

    Raises
    ------
    ParameterError
        For a map with more than one axis, or a quantity that is not yes or no.

    Examples
    --------
    >>> from percuss import Load, System
    >>> from percuss.explore import Sweep
    >>> from percuss.explore.sweeps import sweep_job
    >>> rigid = System(s=1e7, d=0.0, restitution=0.5, load=Load.harmonic(0.9, 1.0))
    >>> job = sweep_job(rigid, "load_factor=0.1:1.2:12", quantities=["reduced_stable"])
    >>> found = Sweep.shaped(job, job.compute(0, job.size, lambda: False))
    >>> [(round(part.first, 6), round(part.last, 6)) for part in true_ranges(job, found, "reduced_stable")]
    [(0.654954, 0.95493)]
    """
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
