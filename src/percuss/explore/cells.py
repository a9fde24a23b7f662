"""The cells of a map: what each system has of the quantities asked for, failures as values."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol, runtime_checkable

import numpy as np
import numpy.typing as npt

from percuss.blow.parts import FIGURES as figures_FIGURES
from percuss.blow.parts import BlowOutcome
from percuss.errors import CaseError, ConvergenceError, LoadError, ParameterError, PercussError, ResonanceError
from percuss.explore.family import Family, SwitchingFamily
from percuss.explore.jobs.job import Columns
from percuss.explore.parameters import PERIODS
from percuss.explore.quantities import (
    BRANCHES,
    CELL_OUTCOMES,
    MACHINE_QUANTITIES,
    QUANTITIES,
    STALLS,
    Quantity,
    columns_of,
    needs,
)
from percuss.model import Machine, System
from percuss.model.body import need_free
from percuss.model.checks import Array, mapping
from percuss.stability import stability_plane
from percuss.stability.multipliers import NEUTRAL
from percuss.steady import Orbit, rest_on_wall, steady_states
from percuss.steady.figures import FIGURES
from percuss.steady.orbit import VERDICTS
from percuss.steady.phases import Arcs, forced_response
from percuss.steady.self_excited import Obstacle, SelfExcited, self_excited_motion
from percuss.steady.self_excited.many_pistons import rigid_cycles

if TYPE_CHECKING:
    from percuss.blow import Blow
    from percuss.simulate import Start, Stop
    from percuss.stability import Stability
    from percuss.stability.verdict import Reduced

OK, NO_PUSH, RESONANCE, INACCURATE, NO_SYSTEM, FAILED, NO_START = range(len(CELL_OUTCOMES))


@dataclass(frozen=True)
class Asked:
    """What is asked of every cell.

    Attributes
    ----------
    names
        Of the quantities.
    modes
        N, the elastic modes of the multipliers.
    cut
        N of the steady motions themselves; None for those of the continuous bar.
    simulated
        N of the simulation.
    stop, impacts, discard
        Of the simulation; impacts of a Lyapunov exponent and those before them.
    si
        Whether the systems have scales.
    """

    names: tuple[str, ...]
    modes: int
    cut: int | None
    simulated: int
    stop: Stop
    impacts: int = 2000
    discard: int = 500
    si: bool = False


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


def empty_columns(names: Sequence[str], number: int, si: bool, known: Mapping[str, Quantity] = QUANTITIES) -> Columns:
    """The columns of so many cells, of which nothing is known yet."""
    return {
        key: np.full((number, *column.shape), column.empty, dtype=column.dtype)
        for key, column in columns_of(names, si, known).items()
    }


def cell_columns(
    asked: Asked,
    systems: Sequence[System | None],
    outcomes: Sequence[int],
    periods: Sequence[int],
    starts: Sequence[Start | None],
    stopped: Callable[[], bool],
) -> Columns:
    """The columns of the cells whose systems are given, one by one.

    Parameters
    ----------
    systems, outcomes
        Of each cell; where there is no system, the outcome says why.
    periods, starts
        m and the start of a simulation, of each cell.
    """
    out = empty_columns(asked.names, len(systems), asked.si)
    out["outcome"][:] = outcomes
    wanted = needs(asked.names)
    for i, system in enumerate(systems):
        if system is None:
            continue
        if stopped():
            return out
        try:
            if "rest" in wanted:
                out["rest"][i] = rest_on_wall(system).possible
            if wanted & {"orbits", "exact"}:
                _orbits(out, i, system, periods[i], asked, "exact" in wanted)
            if "lyapunov" in wanted:
                need_free(system.body, "the Lyapunov exponent")
        except (PercussError, ArithmeticError) as error:
            out["outcome"][i] = failure(error)
    if wanted & {"simulation", "lyapunov"}:
        simulated_columns(out, asked, systems, starts, stopped)
    return out


# -- steady motions ---------------------------------------------------------------------------------------------------


def _orbits(out: Columns, i: int, system: System, periods: int, asked: Asked, exact: bool) -> None:
    """What the closed form says of one cell."""
    from percuss.stability import reduced_criterion, stability_of

    if "exists" in out:
        out["exists"][i] = False
    if "orbits" in out:
        out["orbits"][i] = 0
    orbits = steady_states(system, periods, modes=asked.cut).orbits
    if not system.body.is_free:  # for each blow there is one that strikes backwards
        orbits = tuple(orbit for orbit in orbits if orbit.impact_velocity > 0.0)
    if "exists" in out:
        out["exists"][i] = bool(orbits)
    if "orbits" in out:
        out["orbits"][i] = len(orbits)
    if "phases" in out:
        phases = [orbit.phase for orbit in orbits[:BRANCHES]]
        out["phases"][i, : len(phases)] = phases
    if not orbits or not any(name in _OF_THE_BEST for name in asked.names):
        return
    verdicts: list[Stability] = []
    reduced: list[Reduced] = []
    exact = exact or not system.body.is_free  # of which there is no other criterion
    if exact:
        verdicts = [stability_of(orbit, modes=asked.modes) for orbit in orbits]
        reduced = [verdict.reduced for verdict in verdicts] if system.body.is_free else []
    else:
        reduced = [reduced_criterion(orbit) for orbit in orbits]
    reduced_margins = [1.0 - max(max(r.moduli), max(r.other_side.moduli) if r.other_side else 0.0) for r in reduced]
    best = int(np.argmax([v.margin for v in verdicts] if exact else reduced_margins))
    found: dict[str, Any] = {}
    if reduced:
        found["reduced_stable"] = any(margin > NEUTRAL for margin in reduced_margins)
        found["reduced_margin"] = max(reduced_margins)
    if exact:
        found["stable"] = any(v.stable for v in verdicts)
        found["margin"] = verdicts[best].margin
        for name in ("margin_rhythm", "margin_ringing"):
            if name in out:
                value = getattr(verdicts[best], name)
                found[name] = np.nan if value is None else value
        found["reason"] = VERDICTS.index(verdicts[best].kind)
    for name, value in found.items():
        if name in out:
            out[name][i] = value
    _of_orbit(out, i, orbits[best], asked.si)


_OF_THE_BEST = {name for name, quantity in QUANTITIES.items() if quantity.group in ("orbits", "exact")} - {
    "exists",
    "orbits",
    "phases",
}


_FIGURES = tuple(name for name, quantity in QUANTITIES.items() if quantity.one and name in FIGURES)


def _of_orbit(out: Columns, i: int, orbit: Orbit, si: bool) -> None:
    """Figures of one orbit, in SI for a system with scales."""
    if "admissible" in out:
        out["admissible"][i] = orbit.admissible
    for name in _FIGURES:
        if name not in out:
            continue
        value = FIGURES[name].in_si(orbit) if si else FIGURES[name].value(orbit)
        if value is not None:
            out[name][i] = value


# -- simulation -------------------------------------------------------------------------------------------------------

_PORTION = 256  # systems simulated between two looks at whether the answer is still wanted


def simulated_columns(
    out: Columns,
    asked: Asked,
    systems: Sequence[System | None],
    starts: Sequence[Start | None],
    stopped: Callable[[], bool],
) -> None:
    """What a simulation from a start says of every cell that has a system."""
    there = [
        i
        for i, system in enumerate(systems)
        if system is not None and starts[i] is not None and not _resonant(out, i, system, asked.simulated)
    ]
    for first in range(0, len(there), _PORTION):
        if stopped():
            return
        rows = there[first : first + _PORTION]
        members = [system for i in rows if (system := systems[i]) is not None]
        begins = [start for i in rows if (start := starts[i]) is not None]
        if "simulation" in needs(asked.names):
            _simulated(out, rows, members, begins, asked)
        if "lyapunov" in out and all(system.body.is_free for system in members):
            _lyapunov(out, rows, members, begins, asked)


def _resonant(out: Columns, i: int, system: System, modes: int) -> bool:
    """Whether the cell has no bounded motion; its outcome then says so."""
    from percuss.simulate.tables import table_of

    try:
        if not system.body.modes(modes, system.load.at).is_damped:
            table_of(system, modes)
    except PercussError as error:
        out["outcome"][i] = failure(error)
        return True
    return False


def _simulated(out: Columns, rows: list[int], systems: list[System], starts: list[Start], asked: Asked) -> None:
    from percuss.simulate import simulate_many

    many = simulate_many(systems, starts, modes=asked.simulated, stop=asked.stop, threads=1)
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
    for name, values in found.items():
        if name in out:
            out[name][rows] = values


def _lyapunov(out: Columns, rows: list[int], systems: list[System], starts: list[Start], asked: Asked) -> None:
    from percuss.explore.lyapunov import lyapunov_many

    found = lyapunov_many(
        systems, starts, modes=asked.simulated, impacts=asked.impacts, discard=asked.discard, threads=1
    )
    out["lyapunov"][rows] = found.exponent


def label_text(columns: Mapping[str, Any]) -> np.ndarray[Any, np.dtype[np.str_]]:
    """The motion labels of cells in words, from the five columns they are kept in; empty where nothing was simulated.

    Examples
    --------
    >>> columns = {"label_outcome": np.array([3, -1]), "label_impacts": np.array([2, 0])}
    >>> columns |= {"label_periods": np.array([2, 0]), "label_kind": np.zeros(2), "label_wanders": np.zeros(2)}
    >>> label_text(columns).tolist()
    ['z=2/2', '']
    """
    from percuss.simulate import OUTCOMES
    from percuss.simulate.events import Cycle, label_of

    names = ("label_outcome", "label_impacts", "label_periods", "label_kind", "label_wanders")
    keys = np.stack([np.asarray(columns[name]).astype(np.int64) for name in names], axis=-1)
    kinds, which = np.unique(keys.reshape(-1, 5), axis=0, return_inverse=True)
    words = [
        "" if code < 0 else label_of(OUTCOMES[code], Cycle(0, p, n, kind) if n else None, bool(wanders), kind)
        for code, p, n, kind, wanders in kinds.tolist()
    ]
    return np.array(words, dtype=str)[which].reshape(keys.shape[:-1])


# ---- The cells of a map of machines that switch their own valves: what each does, failures as values

_NUMBERS = {obstacle: STALLS.index(obstacle.value) for obstacle in Obstacle}


def machine_columns(
    family: SwitchingFamily,
    cells: Sequence[Mapping[str, float]],
    names: Sequence[str],
    modes: int,
    si: bool,
    stopped: Callable[[], bool],
) -> tuple[Columns, list[Machine | None]]:
    """The columns of cells, and their machines.

    Parameters
    ----------
    cells
        The parameters of each.
    names
        Of the quantities.
    modes
        N, the elastic modes.
    si
        Whether the machines have scales: energies are in J then.
    """
    out = empty_columns(names, len(cells), si, MACHINE_QUANTITIES)
    out["outcome"][:] = 0
    machines: list[Machine | None] = []
    for i, cell in enumerate(cells):
        machine = None
        try:
            machine = family.machine(cell)
        except (PercussError, ArithmeticError) as error:
            out["outcome"][i] = failure(error)
        machines.append(machine)
    if not any(MACHINE_QUANTITIES[name].group == "machine" for name in names):
        return out, machines
    there = [(i, machine) for i, machine in enumerate(machines) if machine is not None]
    for first in range(0, len(there), _PORTION):
        if stopped():
            break
        _of_machines(out, family, there[first : first + _PORTION], modes, si)
    return out, machines


class _Cycle(NamedTuple):
    """What is used of a cycle with one blow, per unit of mass."""

    period: float
    speed: float
    energy: float
    stroke: float
    work: float
    taken: float
    duty: float
    multiplier: float


def _of_machines(
    out: Columns, family: SwitchingFamily, there: Sequence[tuple[int, Machine]], modes: int, si: bool
) -> None:
    """What some machines do: rigid pistons all at once."""
    left = there
    if modes == 0:
        machines = [machine for _, machine in there]
        found = rigid_cycles(machines, [family.room(machine) for machine in machines], starts="starts" in out)
        arrays = (getattr(found, name).tolist() for name in _Cycle._fields)
        rows = zip(there, found.answered, found.obstacles, zip(*arrays, strict=True), found.starts, strict=True)
        left = []
        for one, answered, obstacle, numbers, starts in rows:
            if answered:
                _put(out, *one, obstacle, _Cycle(*numbers), starts, si)
            else:
                left.append(one)
    for i, machine in left:
        try:
            kept = modes if machine.valve.supply is None else 0  # the piston of a machine with a supply is rigid
            motion = self_excited_motion(machine, modes=kept, room=family.room(machine))
            starts = "starts" in out and motion.starts_from_rest
            _put(out, i, machine, motion.obstacle, _of(motion), starts, si)
        except (PercussError, ArithmeticError) as error:
            out["outcome"][i] = failure(error)


def _of(motion: SelfExcited) -> _Cycle | None:
    cycle = motion.cycle
    if cycle is None or cycle.blows > 1:
        return None
    return _Cycle(
        cycle.period,
        cycle.blow_speed,
        cycle.blow_energy,
        cycle.stroke,
        cycle.work,
        cycle.taken,
        cycle.duty,
        abs(cycle.multiplier),
    )


def _put(
    out: Columns, i: int, machine: Machine, obstacle: Obstacle | None, cycle: _Cycle | None, starts: bool, si: bool
) -> None:
    """Fill in one cell."""
    found: dict[str, float | None] = {"runs": obstacle is None, "starts": starts}
    found["stall"] = 0 if obstacle is None else _NUMBERS[obstacle]
    if cycle is not None:
        found["multiplier"] = cycle.multiplier
        if obstacle is None:
            found |= _figures(machine, cycle, si)
    for name, values in out.items():
        value = found.get(name)
        if value is not None:
            values[i] = value


def _figures(machine: Machine, cycle: _Cycle, si: bool) -> dict[str, float | None]:
    """Of a machine that runs, in SI or dimensionless; None where there is no such figure."""
    length, time, energy = (machine.length_scale, machine.time_scale, machine.energy_scale) if si else (1.0, 1.0, 1.0)
    period = cycle.period * time
    drawn, supply = None, machine.valve.supply
    volume = cycle.work if supply is None else supply.flow * cycle.period
    if machine.pressure is not None and si:
        drawn = volume * energy / machine.pressure
    elif not si:
        forces = [force for _, force in machine.valve.pairs]
        drawn = volume / (max(forces) - min(forces))
    return {
        "blow_energy": cycle.energy * energy,
        "rate": 1.0 / period,
        "speed": cycle.speed * length / time,
        "stroke": cycle.stroke * length,
        "power": cycle.taken * energy / period,
        "flow": None if drawn is None else drawn / period,
        "efficiency": cycle.taken / cycle.work,
        "duty": cycle.duty,
    }


# ---- The cells of a map that tell of one blow, resolved by waves


@runtime_checkable
class StrikingFamily(Protocol):
    """A family of hammers that know what they strike, such as `percuss.case.CaseFamily`."""

    @property
    def is_si(self) -> bool:
        """Whether its blows are in SI."""
        ...

    def blow(self, values: Mapping[str, float]) -> Blow:
        """One blow of the hammer at these values; PercussError where there is none."""
        ...


def blow_columns(
    out: Columns, family: StrikingFamily, cells: Sequence[Mapping[str, float]], stopped: Callable[[], bool]
) -> None:
    """Fill in the columns of the blow; where it fails they stay NaN, and the outcome says so.

    Parameters
    ----------
    out
        Columns of these cells, changed.
    cells
        The parameters of each.
    """
    names = [name for name in figures_FIGURES if name in out]
    for i, values in enumerate(cells):
        if stopped():
            return
        try:
            blow = family.blow(values)
            if blow.outcome is BlowOutcome.TOO_MANY_PIECES:
                raise ConvergenceError("the waves of this blow have too many pieces", "leave short sections out")
            found = {name: figures_FIGURES[name].value(blow) for name in names}
        except (PercussError, ArithmeticError) as error:
            out["outcome"][i] = out["outcome"][i] or failure(error)
            continue
        for name, value in found.items():
            if value is not None:
                out[name][i] = value


# ---- One's own quantities of a map: functions of a system, by name

SystemFunction = Callable[[System], float] | Callable[[Machine], float]
"""One's own quantity of a map, of a system or of a machine that switches its own valve."""


def checked_functions(functions: Mapping[str, SystemFunction]) -> tuple[tuple[str, SystemFunction], ...]:
    for name, function in mapping("functions", functions, "functions of a system by name").items():
        if name in QUANTITIES or name in MACHINE_QUANTITIES or name == "outcome" or not str(name).isidentifier():
            raise ParameterError("functions", name, "a name of one word that no quantity has")
        if not callable(function):
            raise ParameterError(name, function, "a function of a system")
    return tuple(functions.items())


def qualified(function: SystemFunction) -> str:
    """What the function is called, with its module."""
    return f"{function.__module__}.{getattr(function, '__qualname__', type(function).__name__)}"


def function_values(
    function: Callable[[Any], float], systems: Sequence[System | Machine | None], outcome: npt.NDArray[Any]
) -> Array:
    """The function of every system or machine; where it fails NaN, and the outcome says so."""
    found = np.full(len(outcome), np.nan)
    for i, system in enumerate(systems):
        if system is not None:
            try:
                found[i] = function(system)
            except (PercussError, ArithmeticError) as error:
                outcome[i] = failure(error)
    return found


# ---- Maps over restitution, load factor and m alone: the closed form and the multipliers over whole arrays

_MOST = 1 << 20
"""Branches × cells handled at once: a load of a thousand harmonics has two thousand branches."""

AXES = ("restitution", "load_factor", PERIODS)
"""What may vary where arrays answer."""

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


def plane_columns(asked: Asked, system: System, values: Mapping[str, Array], periods: npt.NDArray[np.int64]) -> Columns:
    """The columns of cells that differ from a system in these parameters and in m."""
    out = empty_columns(asked.names, periods.size, asked.si)
    restitution = values.get("restitution", np.full(periods.size, system.restitution))
    factor = values.get("load_factor", np.full(periods.size, system.load.load_factor))
    bad = ~((restitution >= 0.0) & (restitution <= 1.0))
    out["outcome"][:] = np.where(bad, 4, np.where(factor > 0.0, 0, 1))
    lossless = (system.contact.velocity_factors(restitution) == -1.0) & ~bad & (system.d == 0.0)
    _one_by_one(out, np.flatnonzero(lossless), asked, system, restitution, factor, periods)
    for m in np.unique(periods[~lossless]):
        rows = np.flatnonzero((periods == m) & ~bad & ~lossless)
        try:
            size = max(1, _MOST // Arcs.of(forced_response(system)).ends.size)
            for part in (rows[i : i + size] for i in range(0, rows.size, size)):
                _fill(out, part, asked, system, restitution[part], factor[part], int(m))
        except (PercussError, ArithmeticError) as error:
            out["outcome"][rows] = failure(error)
    return out


def _one_by_one(
    out: Columns,
    rows: npt.NDArray[np.intp],
    asked: Asked,
    system: System,
    restitution: Array,
    factor: Array,
    periods: npt.NDArray[np.int64],
) -> None:
    """The cells with R = 1 and d = 0, where only `steady_states` knows whether the bar's ringing grows for ever."""
    if not rows.size:
        return
    pairs = zip(restitution[rows].tolist(), factor[rows].tolist(), strict=True)
    systems = [system.with_restitution(r).with_load_factor(value) for r, value in pairs]
    n = rows.size
    found = cell_columns(asked, systems, [0] * n, periods[rows].tolist(), [None] * n, lambda: False)
    for name, values in found.items():
        out[name][rows] = values


def _fill(
    out: Columns, rows: npt.NDArray[np.intp], asked: Asked, system: System, restitution: Array, factor: Array, m: int
) -> None:
    plane = stability_plane(system, restitution, factor, m)
    there = ~np.isnan(plane.phase)
    found: dict[str, npt.ArrayLike] = {"exists": there.any(axis=0), "orbits": there.sum(axis=0)}
    reduced = np.where(there, 1.0 - _largest(plane.a), np.nan)
    best = reduced
    found["reduced_margin"] = _greatest(reduced)
    found["reduced_stable"] = np.nan_to_num(found["reduced_margin"], nan=-1.0) > NEUTRAL
    if "exact" in needs(asked.names):
        from percuss.stability.plane import exact_plane

        exact = exact_plane(system, restitution, factor, m, modes=asked.modes, plane=plane, threads=1)
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
    for name in asked.names:
        for key in QUANTITIES[name].columns:
            if key in found:
                out[key][rows] = found[key]


def _largest(a: Array) -> Array:
    """Largest modulus of the roots of a_2 ξ² + a_1 ξ + a_0; shape of one coefficient."""
    a_0, a_1, a_2 = a
    with np.errstate(invalid="ignore", divide="ignore"):
        inside = a_1 * a_1 - 4.0 * a_2 * a_0
        big = -0.5 * (a_1 + np.copysign(np.sqrt(np.maximum(inside, 0.0)), a_1))
        real = np.maximum(np.abs(big / a_2), np.where(big == 0.0, 0.0, np.abs(a_0 / big)))
        return np.asarray(np.where(inside < 0.0, np.sqrt(np.abs(a_0 / a_2)), real))


def _greatest(values: Array) -> Array:
    """Along the branches, without the NaN of those that hold no root; NaN where none does."""
    least = np.where(np.isnan(values), -np.inf, values).max(axis=0)
    return np.asarray(np.where(np.isneginf(least), np.nan, least))
