"""A map as a job: its cells, what each hammer has of the quantities asked for, failures as values."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import prod
from typing import TYPE_CHECKING, Any, Protocol, runtime_checkable

import numpy as np
import numpy.typing as npt

from percuss.blow.figures import FIGURES as BLOW_FIGURES
from percuss.blow.figures import BlowOutcome
from percuss.errors import CaseError, ConvergenceError, LoadError, ParameterError, PercussError, ResonanceError
from percuss.explore.attractors.hammers import seconds_of_start
from percuss.explore.family import Axis, Family, SwitchingFamily, drives_itself
from percuss.explore.jobs.job import ASK_FORMAT, Column, Columns
from percuss.explore.parameters import AXES, PERIODS
from percuss.explore.quantities import (
    BRANCHES,
    CELL_OUTCOMES,
    QUANTITIES,
    STALLS,
    Group,
    columns_of,
    known_quantities,
    needs,
)
from percuss.halting import on_threads
from percuss.model import Machine, System
from percuss.model.checks import DEFAULT_MODES, Array
from percuss.stability import stability_plane
from percuss.stability.verdict import moduli_of
from percuss.steady import rest_on_wall, steady_states
from percuss.steady.figures import FIGURES
from percuss.steady.forced import forced_response
from percuss.steady.multipliers import NEUTRAL, VERDICTS
from percuss.steady.phases import Arcs
from percuss.steady.self_excited.self_switching import Obstacle, rigid_cycles, self_excited_motion

if TYPE_CHECKING:
    from percuss.blow import Blow
    from percuss.simulate import Start, Stop
    from percuss.stability import Stability
    from percuss.stability.verdict import Reduced

OK, NO_PUSH, RESONANCE, INACCURATE, NO_SYSTEM, FAILED, NO_START = range(len(CELL_OUTCOMES))

SystemFunction = Callable[[System], float] | Callable[[Machine], float]
"""One's own quantity of a map, of a system or of a machine that switches its own valve."""

_CELL = {
    "orbits": 2e-3,
    "exact": 2e-3,
    "rest": 1e-4,
    "blow": 8e-3,
    "transfer": 3e-2,
}  # seconds of one cell, by rule of thumb
_OF_ARRAYS = {"orbits": 1e-5, "exact": 1e-4}  # of one among many at once
_PORTION = 256  # hammers simulated, or solved, between two looks at whether the answer is still wanted


@runtime_checkable
class StrikingFamily(Protocol):
    """A family of hammers that know what they strike, such as `percuss.case.CaseFamily`."""

    @property
    def is_si(self) -> bool: ...

    def blow(self, values: Mapping[str, float]) -> Blow:
        """One blow of the hammer at these values; PercussError where there is none."""

    def whole(self, values: Mapping[str, float], periods: int, modes: int | None) -> Any:
        """The hammer at these values in its motion, with its own blow: `percuss.case.answers.whole_hammer`."""


def failure(error: Exception) -> int:
    """The outcome of a cell whose computation raised this."""
    for kind, code in (
        (LoadError, NO_PUSH),
        (ResonanceError, RESONANCE),
        (ConvergenceError, INACCURATE),
        (ParameterError, NO_SYSTEM),
        (CaseError, NO_SYSTEM),
    ):
        if isinstance(error, kind):
            return code
    return FAILED


def qualified(function: SystemFunction) -> str:
    """What the function is called, with its module."""
    return f"{function.__module__}.{getattr(function, '__qualname__', type(function).__name__)}"


@dataclass(frozen=True, eq=False)
class SweepJob:
    """A map as a job: its items are the cells, the last axis running fastest; see `percuss.explore.sweep`."""

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
    workers: int = 1
    """Threads for the kernels, where no other processes work at the map; the cells are the same for any number."""

    @property
    def shape(self) -> tuple[int, ...]:
        """Numbers of cells along the axes of the map."""
        return tuple(len(axis) for axis in self.axes)

    @property
    def size(self) -> int:
        """Number of cells."""
        return prod(self.shape)

    @cached_property
    def groups(self) -> set[Group]:
        return needs(self.quantities, known_quantities(self.family))

    @cached_property
    def simulates(self) -> bool:
        return bool(self.groups & {"simulation", "lyapunov"})

    @cached_property
    def own_columns(self) -> Mapping[str, Column]:
        """The columns of the quantities that have names, and the outcome of each cell."""
        return columns_of(self.quantities, self.is_si, known_quantities(self.family))

    @property
    def rough_seconds(self) -> float:
        """What all cells take, by rule of thumb."""
        groups, modes, simulated = self.groups, self.multiplier_modes, self.simulated
        if self.is_plane:
            return self.size * sum(_OF_ARRAYS.get(group, 0.0) for group in groups) * (1.0 + (modes / 32.0) ** 2)
        more = {
            "exact": 1e-3 * (modes / 32.0) ** 2,
            "simulation": seconds_of_start(simulated),
            "machine": 3e-4 + 6e-4 * modes,
            "lyapunov": 4e-3 * (1.0 + simulated / 8.0),
        }
        alone = sum(_CELL.get(group, 0.0) + more.get(group, 0.0) for group in groups)
        return self.size * (alone + 1e-3 * len(self.functions))

    @property
    def is_plane(self) -> bool:
        """Whether arrays answer for all cells at once."""
        return not self.functions and fits_plane(self.family, [axis.name for axis in self.axes], self.quantities)

    @property
    def multiplier_modes(self) -> int:
        """N of the exact multipliers; without a number of a machine whose oil flows, 0."""
        if self.modes is not None:
            return self.modes
        return 0 if drives_itself(self.family) and self.family.machine({}).valve.flows else DEFAULT_MODES

    @property
    def asks_hammers(self) -> bool:
        """Whether anything is asked of the motion; a case of one blow alone may have none."""
        return bool(self.functions) or bool(self.groups - {"blow"})

    @cached_property
    def is_si(self) -> bool:
        """Whether the systems have scales: energies are in J then."""
        family = self.family
        if isinstance(family, StrikingFamily) and not drives_itself(family):
            return family.is_si
        for at in (0, self.size // 2, self.size - 1):
            try:
                return self.hammer(self.cell(at)).is_si
            except PercussError:
                continue
        return False

    @property
    def columns(self) -> Mapping[str, Column]:
        """The columns of the quantities asked for, and the outcome of each cell."""
        own = {name: Column(meaning=f"of {qualified(function)}") for name, function in self.functions}
        return {**self.own_columns, **own}

    @property
    def ask(self) -> dict[str, Any]:
        """Axes, quantities, the family and the options."""
        wanted = self.groups
        simulated = self.simulates
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
            ask["start"] = None
            if self.start is not None:
                u, v, gap = self.start.state(self.simulated)
                place = {"displacement": u.tolist(), "velocity": v.tolist(), "gap": float(gap)}
                ask["start"] = {**place, "time": self.start.time}
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

    def values(self, cell: Mapping[str, float]) -> dict[str, float]:
        """Those of a cell's parameters that its hammer has."""
        return {name: value for name, value in cell.items() if name != PERIODS}

    def hammer(self, cell: Mapping[str, float]) -> System | Machine:
        """The system, or the machine, of a cell; PercussError where there is none."""
        family = self.family
        return (family.machine if drives_itself(family) else family.system)(self.values(cell))

    def start_of(self, cell: Mapping[str, float]) -> Start | None:
        """The start of a cell's simulation; None when nothing is simulated."""
        if not self.simulates or self.start is not None:
            return self.start
        from percuss.simulate import Start

        of_family = getattr(self.family, "start", None)
        usual = Start.rigid(0.0 if drives_itself(self.family) else -1.0)
        return usual if of_family is None else of_family(self.values(cell), self.simulated)

    def empty(self, number: int) -> Columns:
        """The columns of so many cells, of which nothing is known but that nothing has failed yet."""
        out = {
            key: np.full((number, *column.shape), column.empty, dtype=column.dtype)
            for key, column in self.own_columns.items()
        }
        out["outcome"][:] = OK
        return out

    def compute(self, first: int, last: int, stopped: Callable[[], bool]) -> Columns:
        """The columns of the cells `first` … `last` − 1."""
        if self.is_plane:
            return _by_plane(self, first, last)
        cells = [self.cell(i) for i in range(first, last)]
        out, groups, family = self.empty(len(cells)), self.groups, self.family
        hammers: list[System | Machine | None] = [None] * len(cells)
        starts: list[Start | None] = [None] * len(cells)
        for i, cell in enumerate(cells if self.asks_hammers else ()):
            if stopped():
                return out
            try:
                hammers[i] = self.hammer(cell)
                starts[i] = self.start_of(cell)
            except (PercussError, ArithmeticError) as error:
                out["outcome"][i] = failure(error) if hammers[i] is None else NO_START
        machines = [(i, one) for i, one in enumerate(hammers) if isinstance(one, Machine)]
        if drives_itself(family) and "machine" in groups:
            for at in range(0, len(machines), _PORTION):
                if stopped():
                    return out
                _machines(self, out, family, machines[at : at + _PORTION])
        for i, system in enumerate(hammers):
            if isinstance(system, System):
                if stopped():
                    return out
                _steady(self, out, i, system, int(cells[i].get(PERIODS, self.periods)))
        if self.simulates:
            _simulated(self, out, hammers, starts, stopped)
        if isinstance(family, StrikingFamily) and "blow" in groups:
            _blows(self, out, family, cells, stopped)
        if isinstance(family, StrikingFamily) and "transfer" in groups:
            _transfers(self, out, family, cells, stopped)
        for name, function in self.functions:
            out[name] = np.full(len(cells), np.nan)
            for i, hammer in enumerate(hammers):
                if hammer is not None:
                    try:
                        out[name][i] = function(hammer)  # type: ignore[arg-type]
                    except (PercussError, ArithmeticError) as error:
                        out["outcome"][i] = failure(error)
        return out


# ---- Steady motions of systems


def _steady(job: SweepJob, out: Columns, i: int, system: System, periods: int) -> None:
    """What is known of one cell without a simulation."""
    wanted = job.groups
    try:
        if "rest" in wanted:
            out["rest"][i] = rest_on_wall(system).possible
        if wanted & {"orbits", "exact"}:
            _orbits(job, out, i, system, periods)
    except (PercussError, ArithmeticError) as error:
        out["outcome"][i] = failure(error)


def _orbits(job: SweepJob, out: Columns, i: int, system: System, periods: int) -> None:
    """What the closed form says of one cell."""
    from percuss.stability import reduced_criterion, stability_of

    for name in {"exists", "orbits"} & set(out):
        out[name][i] = 0
    orbits = steady_states(system, periods, modes=job.modes).orbits
    if not system.body.is_free:  # for each blow there is one that strikes backwards
        orbits = tuple(orbit for orbit in orbits if orbit.impact_velocity > 0.0)
    for name in {"exists", "orbits"} & set(out):
        out[name][i] = len(orbits)
    if "phases" in out:
        phases = [orbit.phase for orbit in orbits[:BRANCHES]]
        out["phases"][i, : len(phases)] = phases
    if not orbits or not any(name in _OF_THE_BEST for name in job.quantities):
        return
    verdicts: list[Stability] = []
    reduced: list[Reduced] = []
    exact = "exact" in job.groups or not system.body.is_free  # of which there is no other criterion
    if exact:
        verdicts = [stability_of(orbit, modes=job.multiplier_modes) for orbit in orbits]
        reduced = [verdict.reduced for verdict in verdicts] if system.body.is_free else []
    else:
        reduced = [reduced_criterion(orbit) for orbit in orbits]
    reduced_margins = [1.0 - max(max(r.moduli), max(r.other_side.moduli) if r.other_side else 0.0) for r in reduced]
    best = int(np.argmax([v.margin for v in verdicts] if exact else reduced_margins))
    orbit = orbits[best]
    found: dict[str, Any] = {}
    if "admissible" in out:  # its proof takes longer than all the rest
        found["admissible"] = orbit.admissible
    if reduced:
        found["reduced_stable"] = any(margin > NEUTRAL for margin in reduced_margins)
        found["reduced_margin"] = max(reduced_margins)
    if exact:
        found["stable"] = any(v.stable for v in verdicts)
        found |= {name: getattr(verdicts[best], name) for name in _MARGINS & out.keys()}
        found["reason"] = VERDICTS.index(verdicts[best].kind)
    figures = [name for name in out if name in FIGURES and QUANTITIES[name].one]
    found |= {name: FIGURES[name].in_si(orbit) if job.is_si else FIGURES[name].value(orbit) for name in figures}
    _set(out, i, found)


def _set(out: Columns, i: int, found: Mapping[str, Any]) -> None:
    for name in found.keys() & out.keys():
        if found[name] is not None:
            out[name][i] = found[name]


_MARGINS = {"margin", "margin_rhythm", "margin_ringing"}
_OF_ALL = {"exists", "orbits", "phases"}
_OF_THE_BEST = {name for name, quantity in QUANTITIES.items() if quantity.group in ("orbits", "exact")} - _OF_ALL

# ---- Simulation


def _simulated(
    job: SweepJob,
    out: Columns,
    hammers: Sequence[System | Machine | None],
    starts: Sequence[Start | None],
    stopped: Callable[[], bool],
) -> None:
    from percuss.explore.lyapunov import lyapunov_many
    from percuss.simulate import simulate_many

    there = []
    for i, (system, start) in enumerate(zip(hammers, starts, strict=True)):
        if system is not None and start is not None and not _resonant(out, i, system, job.simulated):
            there.append((i, system, start))
    for first in range(0, len(there), _PORTION):
        if stopped():
            return
        part = there[first : first + _PORTION]
        rows, begins = [i for i, _, _ in part], [start for _, _, start in part]
        systems: list[Any] = [one for _, one, _ in part]
        if "simulation" in job.groups:
            many = simulate_many(systems, begins, modes=job.simulated, stop=job.stop, workers=job.workers)
            found = {
                "label_outcome": many.code,
                "label_impacts": many.cycle_impacts,
                "label_periods": many.cycle_periods,
                "label_kind": many.cycle_kind,
                "label_wanders": many.wanders,
                "blow_rate": many.blow_rate,
                "blow_scatter": many.interval_std / many.interval_mean,
                "main_blow_rate": many.main_blow_rate,
                "main_blow_scatter": many.main_interval_std / many.main_interval_mean,
            }
            for name in found.keys() & out.keys():
                out[name][rows] = found[name]
        if "lyapunov" in job.groups:
            every = "lyapunov_all" in out
            asked = {"modes": job.simulated, "impacts": job.impacts, "discard": job.discard}
            exponents = lyapunov_many(systems, begins, **asked, every=every, workers=job.workers)
            if "lyapunov" in out:
                out["lyapunov"][rows] = exponents.exponent
            for row, spectrum in zip(rows, exponents.spectrum, strict=False):  # none where it was not asked for
                out["lyapunov_all"][row, : len(spectrum)] = spectrum[:BRANCHES]


def _resonant(out: Columns, i: int, system: System | Machine, modes: int) -> bool:
    """Whether the cell has no bounded motion; its outcome then says so."""
    if isinstance(system, Machine):
        return False
    from percuss.simulate.engine import table_of

    try:
        if not system.body.modes(modes, system.load.at).is_damped:
            table_of(system, modes)
    except PercussError as error:
        out["outcome"][i] = failure(error)
        return True
    return False


def label_text(columns: Mapping[str, Any]) -> np.ndarray[Any, np.dtype[np.str_]]:
    """The motion labels of cells in words, from their five columns; empty where nothing was simulated."""
    from percuss.simulate.ensemble import labels_of

    numbers = [np.asarray(columns[f"label_{name}"]) for name in ("outcome", "impacts", "periods", "kind", "wanders")]
    found = np.full(numbers[0].shape, "", dtype="<U32")
    known = numbers[0] >= 0
    if known.any():
        found[known] = labels_of(*(values[known] for values in numbers))
    return found


# ---- Machines that switch their own valves

_OF_CYCLES = ("period", "stroke", "work", "taken", "duty", "speed", "energy", "multiplier")
"""What a map takes of the cycle with one blow, per unit of mass."""


def _machines(job: SweepJob, out: Columns, family: SwitchingFamily, there: Sequence[tuple[int, Machine]]) -> None:
    """What some machines do: rigid pistons all at once."""
    left, modes = there, job.multiplier_modes
    if modes == 0:
        machines = [machine for _, machine in there]
        many = rigid_cycles(machines, [family.room(machine) for machine in machines], starts="starts" in out)
        cycles = zip(*(getattr(many, name).tolist() for name in _OF_CYCLES), strict=True)
        left = []
        for one, obstacle, starts, figures, answered in zip(
            there, many.obstacles, many.starts, cycles, many.answered, strict=True
        ):
            if answered:
                _put(job, out, *one, obstacle, starts, figures)
            else:
                left.append(one)
    for i, machine in left:
        try:
            motion = self_excited_motion(machine, modes=modes, room=family.room(machine))
            cycle = motion.cycle
            numbers: tuple[float, ...] | None = None
            if cycle is not None and cycle.blows == 1:
                numbers = tuple(getattr(cycle, name) for name in _OF_CYCLES[:5])
                numbers = (*numbers, cycle.blow_speed, cycle.main_energy, abs(cycle.multiplier))
            drawn = None if cycle is None or cycle.oil is None else cycle.drawn
            _put(job, out, i, machine, motion.obstacle, "starts" in out and motion.starts_from_rest, numbers, drawn)
        except (PercussError, ArithmeticError) as error:
            out["outcome"][i] = failure(error)


def _put(
    job: SweepJob,
    out: Columns,
    i: int,
    machine: Machine,
    obstacle: Obstacle | None,
    starts: bool,
    cycle: tuple[float, ...] | None,
    drawn: float | None = None,
) -> None:
    found: dict[str, float | None] = {"runs": obstacle is None, "starts": starts}
    found["stall"] = STALLS.index("runs" if obstacle is None else obstacle.value)
    if cycle is not None:
        period, stroke, work, taken, duty, speed, energy, found["multiplier"] = cycle
    if cycle is not None and obstacle is None:
        length, time, joule = 1.0, 1.0, 1.0
        if job.is_si:
            length, time, joule = machine.length_scale, machine.time_scale, machine.energy_scale
        supply, forces = machine.valve.supply, [force for _, force in machine.valve.pairs]
        volume, lasts = work if supply is None else supply.flow * period, period * time
        volume = volume if drawn is None else drawn
        if machine.pressure is not None and job.is_si:
            found["flow"] = volume * joule / machine.pressure / lasts
        elif not job.is_si:
            found["flow"] = volume / (max(forces) - min(forces)) / lasts
        found |= {"blow_energy": energy * joule, "rate": 1.0 / lasts, "speed": speed * length / time}
        found |= {"stroke": stroke * length, "power": taken * joule / lasts, "efficiency": taken / work, "duty": duty}
    _set(out, i, found)


# ---- One blow, resolved by waves


def _blows(
    job: SweepJob,
    out: Columns,
    family: StrikingFamily,
    cells: Sequence[Mapping[str, float]],
    stopped: Callable[[], bool],
) -> None:
    """Fill in the columns of the blow; where it fails they stay NaN, and the outcome says so."""
    names = [name for name in BLOW_FIGURES if name in out]

    def found(cell: Mapping[str, float]) -> dict[str, Any]:
        blow = family.blow(cell)
        if blow.outcome is BlowOutcome.TOO_MANY_PIECES:
            raise ConvergenceError("the waves of this blow have too many pieces", "leave short sections out")
        return {name: BLOW_FIGURES[name].value(blow) for name in names}

    _one_by_one(job, out, found, cells, stopped)


def _transfers(
    job: SweepJob,
    out: Columns,
    family: StrikingFamily,
    cells: Sequence[Mapping[str, float]],
    stopped: Callable[[], bool],
) -> None:
    """Fill in what reaches the rock, of the cell's own cycle and its blow; NaN where there is none."""
    names = [name for name in job.quantities if known_quantities(job.family)[name].group == "transfer"]

    def found(cell: Mapping[str, float]) -> dict[str, Any]:
        whole = family.whole(job.values(cell), int(cell.get(PERIODS, job.periods)), job.modes)
        return {name: whole.value(name) for name in names} if whole.runs or not drives_itself(job.family) else {}

    _one_by_one(job, out, found, cells, stopped)


def _one_by_one(
    job: SweepJob,
    out: Columns,
    found: Callable[[Mapping[str, float]], Mapping[str, Any]],
    cells: Sequence[Mapping[str, float]],
    stopped: Callable[[], bool],
) -> None:
    """Cells that are waves for most of their time, which leave Python's lock to other threads."""

    def put(i: int) -> None:
        if stopped():
            return
        try:
            _set(out, i, found(cells[i]))
        except (PercussError, ArithmeticError) as error:
            out["outcome"][i] = out["outcome"][i] or failure(error)

    on_threads(put, range(len(cells)), job.workers)


# ---- Maps over restitution, load factor and m alone: the closed form and the multipliers over whole arrays

_MOST = 1 << 20  # branches × cells handled at once: a load of a thousand harmonics has two thousand branches

_NAMES = {"exists", "orbits", "phases", "phase", "reduced_stable", "reduced_margin", "stable", "margin"}


def fits_plane(family: Family, axes: Sequence[str], quantities: Sequence[str]) -> bool:
    """Whether arrays can answer: only R, p_0/p_1 and m vary, and no quantity needs a cell for itself."""
    if not set(axes) <= set(AXES) or not set(quantities) <= _NAMES:
        return False
    try:
        system = family.system({})
        return system.body.is_free and not system.load.is_constant
    except PercussError:
        return False


def _by_plane(job: SweepJob, first: int, last: int) -> Columns:
    """All cells at once where only R, the load factor and m differ: the closed form over arrays."""
    at, size, system = np.unravel_index(np.arange(first, last), job.shape), last - first, job.family.system({})
    values = {axis.name: axis.values[j] for axis, j in zip(job.axes, at, strict=True)}
    periods = values.pop(PERIODS, np.full(size, float(job.periods))).astype(int)
    out = job.empty(size)
    restitution = values.get("restitution", np.full(size, system.restitution))
    factor = values.get("load_factor", np.full(size, system.load.load_factor))
    bad = ~((restitution >= 0.0) & (restitution <= 1.0))
    out["outcome"][:] = np.where(bad, NO_SYSTEM, np.where(factor > 0.0, OK, NO_PUSH))
    lossless = (system.contact.velocity_factors(restitution) == -1.0) & ~bad & (system.d == 0.0)
    for i in np.flatnonzero(lossless).tolist():  # only `steady_states` knows whether the bar's ringing grows for ever
        out["outcome"][i] = OK
        here = system.with_restitution(float(restitution[i])).with_load_factor(float(factor[i]))
        _steady(job, out, i, here, int(periods[i]))
    for m in np.unique(periods[~lossless]):
        rows = np.flatnonzero((periods == m) & ~bad & ~lossless)
        try:
            most = max(1, _MOST // Arcs.of(forced_response(system)).ends.size)
            for part in (rows[i : i + most] for i in range(0, rows.size, most)):
                _fill(job, out, part, system, restitution[part], factor[part], int(m))
        except (PercussError, ArithmeticError) as error:
            out["outcome"][rows] = failure(error)
    return out


def _fill(
    job: SweepJob, out: Columns, rows: npt.NDArray[np.intp], system: System, restitution: Array, factor: Array, m: int
) -> None:
    plane = stability_plane(system, restitution, factor, m)
    there = ~np.isnan(plane.phase)
    found: dict[str, npt.ArrayLike] = {"exists": there.any(axis=0), "orbits": there.sum(axis=0)}
    reduced = np.where(there, 1.0 - moduli_of(*plane.a)[0], np.nan)
    best = reduced
    found["reduced_margin"] = _greatest(reduced)
    found["reduced_stable"] = np.nan_to_num(found["reduced_margin"], nan=-1.0) > NEUTRAL
    if "exact" in job.groups:
        from percuss.stability.plane import exact_plane

        modes, workers = job.multiplier_modes, job.workers
        exact = exact_plane(system, restitution, factor, m, modes=modes, plane=plane, workers=workers)
        best = exact.margin
        found["stable"] = exact.stable.any(axis=0)
        found["margin"] = _greatest(exact.margin)
    if "phase" in out:
        at = np.argmax(np.where(np.isnan(best), -np.inf, best), axis=0)
        found["phase"] = np.take_along_axis(plane.phase, at[None], axis=0)[0]
    if "phases" in out:
        phases = np.full((rows.size, BRANCHES), np.nan)
        ordered = np.sort(plane.phase, axis=0)[:BRANCHES].T
        phases[:, : ordered.shape[1]] = ordered
        found["phases"] = phases
    for name in found.keys() & out.keys():
        out[name][rows] = found[name]


def _greatest(values: Array) -> Array:
    """Along the branches, without the NaN of those that hold no root; NaN where none does."""
    least = np.where(np.isnan(values), -np.inf, values).max(axis=0)
    return np.asarray(np.where(np.isneginf(least), np.nan, least))
