"""The cells of a map: what each system has of the quantities asked for, failures as values."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from percuss.errors import CaseError, ConvergenceError, LoadError, ParameterError, PercussError, ResonanceError
from percuss.explore.jobs.job import Columns
from percuss.explore.quantities import BRANCHES, CELL_OUTCOMES, QUANTITIES, Quantity, columns_of, needs
from percuss.model import System
from percuss.model.body import need_free
from percuss.stability.multipliers import NEUTRAL
from percuss.steady import Orbit, rest_on_wall, steady_states
from percuss.steady.figures import FIGURES
from percuss.steady.reason import VERDICTS

if TYPE_CHECKING:
    from percuss.simulate import Start, Stop
    from percuss.stability import Stability
    from percuss.stability.reduced import Reduced

__all__ = ["Asked", "cell_columns", "failure", "label_text"]

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
    from percuss.simulate.summary import Cycle, label_of

    names = ("label_outcome", "label_impacts", "label_periods", "label_kind", "label_wanders")
    keys = np.stack([np.asarray(columns[name]).astype(np.int64) for name in names], axis=-1)
    kinds, which = np.unique(keys.reshape(-1, 5), axis=0, return_inverse=True)
    words = [
        "" if code < 0 else label_of(OUTCOMES[code], Cycle(0, p, n, kind) if n else None, bool(wanders))
        for code, p, n, kind, wanders in kinds.tolist()
    ]
    return np.array(words, dtype=str)[which].reshape(keys.shape[:-1])
