"""How far the parameters of a case may move before its motion is lost, and what comes then."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from percuss.case.answers.steady_answer import CaseReach
from percuss.case.case import Case, checked_case
from percuss.case.parameters.case_family import CaseFamily
from percuss.case.parameters.description import parameters
from percuss.errors import Interrupted, ParameterError, PercussError
from percuss.explore.continuation.following import reach
from percuss.halting import Asked, Elapsed, asked
from percuss.model.checks import DEFAULT_MODES, callback, count, instance, several, text
from percuss.simulate.stop import MAX_MODES
from percuss.steady import Orbit, PeriodicOrbit, orbit_near
from percuss.steady.self_excited.valve_cycle import ValveCycle

_USUAL = ("load.mean", "load.frequency", "load.pressure", "load.supply.flow")
_WIDE = 3.0  # how many times smaller and greater the values are that are looked at
_ENDS = {"restitution": (0.0, 1.0), "kappa": (0.0, 2.0)}
_FROM_NOTHING = ("load_factor", "mean", "amplitude", "d", "damping", "damping_ratio", "drag", "eta")


def reach_answer(
    case: Case,
    orbit: Orbit | ValveCycle,
    names: Sequence[str] | None = None,
    *,
    modes: int | None = None,
    progress: Callable[[Elapsed], object] | None = None,
) -> tuple[CaseReach, ...]:
    """How far parameters of a case may move before a steady motion of it is lost; see `percuss.explore.reach`.

    Parameters
    ----------
    orbit
        One of its steady motions, which must be possible and stable: `SteadyAnswer.chosen` has one; or the cycle of a
        machine that switches its own valve.
    names
        Parameters as of `percuss sweep`; None for those with a slider on the page, mean load and frequency.
    modes
        N of the multipliers and of what is simulated beyond the ends; 32 by default.
    progress
        As for `percuss.explore.follow`; once it returns true the parameters that follow are left out.

    Raises
    ------
    CaseError, ParameterError
        For an unknown parameter, or a motion that is not stable.

    Examples
    --------
    >>> from percuss.case import load_case, steady_answer
    >>> case = load_case("pneumatic-jackleg")
    >>> found = reach_answer(case, steady_answer(case).chosen.orbit, ["load_factor"], modes=0)
    >>> print(found[0])
    load factor p₀/p₁ = 0.3925: down to 0.3584, where the period doubles (then 2 blows in 2 load \
periods); up to 0.4307, where the motion ceases to exist (then chatter to rest every load period)
    """
    wanted = varied_parameters(case, names)
    callback("progress", progress)
    halt = asked(progress)
    start = orbit if isinstance(orbit, ValveCycle) else _with_modes(instance("orbit", orbit, Orbit), modes)
    found = []
    for row in wanted:
        if halt is not None and halt():
            break
        try:
            found.append(_row(case, start, row, halt))
        except Interrupted:
            break
    return tuple(found)


def _with_modes(orbit: Orbit, modes: int | None) -> PeriodicOrbit:
    """A steady motion with the modes that are asked for."""
    kept = DEFAULT_MODES if modes is None else count("modes", modes, least=0, most=MAX_MODES)
    kept = orbit.system.body.chosen(kept)
    start = PeriodicOrbit(orbit.system, orbit.periods, (orbit.phase,), kept)
    return orbit_near(orbit.system, start.times, orbit.periods, modes=kept) or start  # fewer modes, another phase


def varied_parameters(case: Case, names: Sequence[str] | None = None) -> list[dict[str, Any]]:
    """Name, label, unit and value of parameters, None: those told by default; ParameterError for no number of it."""
    checked_case(case)
    rows = {row["name"]: row for row in parameters(case)}
    return _usual(rows) if names is None else [_known(case, rows, name) for name in several("names", names, "names")]


def _usual(rows: dict[str, dict[str, Any]]) -> list[dict[str, Any]]:
    """What is told unless it is asked for: what has a slider; of a case in SI its mean load in place of its factor."""
    known = {name: row for name, row in rows.items() if row["value"] is not None}
    if "load.mean" in known:
        known.pop("load_factor", None)
    found = [row for name, row in known.items() if row["slides"] or name in _USUAL]
    return sorted(found, key=lambda row: not row["name"].startswith("load"))  # the load first


def _known(case: Case, rows: dict[str, dict[str, Any]], name: str) -> dict[str, Any]:
    """The row of a parameter, by its name or its key; those that are no numbers of the case are unknown."""
    key = CaseFamily(case, {}).key(text("names", name)) if name not in rows else name
    if key not in rows or rows[key]["value"] is None:
        raise ParameterError("names", name, f"one of {', '.join(rows)}")
    return rows[key]


def _row(case: Case, start: PeriodicOrbit | ValveCycle, row: dict[str, Any], halt: Asked | None) -> CaseReach:
    name, unit, value = row["name"], row["unit"], row["value"]
    about = (name, row["label"], unit, value)
    family = CaseFamily(case, {name: unit} if unit else {})
    try:
        between = None if _is_open(start, name, value) else _range(name, value)
        found = reach(start, name, between, family=family, value=value, progress=halt)
    except Interrupted:
        raise
    except PercussError as error:
        return CaseReach(*about, None, error.message)
    return CaseReach(*about, found)


def _is_open(start: PeriodicOrbit | ValveCycle, name: str, value: float) -> bool:
    """Whether a parameter that is 0 may be of either sign: the gap and the mean load of what is held."""
    short = name.rpartition(".")[2]
    return (
        not value
        and not (start.machine if isinstance(start, ValveCycle) else start.system).body.is_free
        and short in ("gap", "mean", "load_factor")
    )


def _range(name: str, value: float) -> tuple[float, float]:
    """The values that are looked at: of a share all there are, of others a third to three times."""
    short = name.rpartition(".")[2]
    if short in _ENDS:
        return _ENDS[short]
    if not value:
        return 0.0, 1.0
    low = 0.0 if short in _FROM_NOTHING else value / _WIDE
    return (low, _WIDE * value) if value > 0.0 else (_WIDE * value, -low)
