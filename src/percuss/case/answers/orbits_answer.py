"""The orbits of a case with several impacts in a cycle: searched for by their labels, and followed."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from contextlib import suppress
from typing import TYPE_CHECKING

from percuss.case.answers.orbit_phases import orbit_at_phases
from percuss.case.case import Case, checked_case
from percuss.case.parameters.case_family import CaseFamily
from percuss.case.parameters.case_keys import LOAD_SCALE
from percuss.case.parameters.parameter_list import quantity_of
from percuss.errors import Interrupted, ParameterError
from percuss.explore import Axis, follow, orbit_seeds, switched_seeds
from percuss.explore.parameters import PARAMETERS
from percuss.halting import halting
from percuss.model.checks import count, flag, text
from percuss.steady import FoundOrbits, PeriodicOrbit, orbits
from percuss.steady.periodic.search import MOST_IMPACTS, MOST_PERIODS
from percuss.steady.states import check_pushes

if TYPE_CHECKING:
    from percuss.explore import Branch

__all__ = ["branch_answer", "orbits_answer", "parsed_label", "value_of"]

_LABEL = re.compile(r"\s*(?:z\s*=\s*)?(\d{1,3})\s*/\s*(\d{1,3})\s*", re.ASCII)
_CHOICE = "P/N:NUMBER or P/N:phases=1.2,4.5"


def parsed_label(label: str) -> tuple[int, int]:
    """p and n of a label such as 3/2.

    Raises
    ------
    ParameterError
        For anything else.

    Examples
    --------
    >>> parsed_label("2/1"), parsed_label("z=3/2")
    ((2, 1), (3, 2))
    """
    found = _LABEL.fullmatch(text("label", label, "P/N: impacts and load periods of a cycle"))
    if found is None:
        raise ParameterError("label", label, "P/N: impacts and load periods of a cycle", "for example 2/1")
    impacts = count("impacts", int(found[1]), most=MOST_IMPACTS)
    return impacts, count("periods", int(found[2]), most=MOST_PERIODS)


def orbits_answer(
    case: Case,
    label: str,
    *,
    modes: int | None = None,
    tries: int = 400,
    seed: int = 0,
    motions: int = 64,
    switch: bool = False,
    halt: Callable[[], bool] | None = None,
) -> FoundOrbits:
    """The orbits z=p/n of a case; see `percuss.steady.orbits`.

    Parameters
    ----------
    case
        A hammer whose load keeps time.
    label
        p/n.
    modes
        N, in the forced motion, too; None for the case's, or 32.
    tries, seed
        As for `percuss.steady.orbits`.
    motions
        How many are simulated to start from their close returns; 0 for none.
    switch
        Whether to start also from what begins on branches of shorter orbits; see `percuss.explore.switched_seeds`.
    halt
        As for `percuss.steady.orbits`.

    Raises
    ------
    CaseError, LoadError, ResonanceError, ParameterError
        When there is nothing to search.

    Examples
    --------
    >>> from percuss.case import load_case
    >>> print(orbits_answer(load_case("hydraulic-drifter"), "1/1", modes=0).label)
    z=1/1
    """
    checked_case(case)
    impacts, periods = parsed_label(label)
    system, kept, drawn = case.system(), _modes(case, modes), count("motions", motions, least=0, most=10**5)
    if drawn and impacts == 2 and kept == 0:  # the list is complete without them, as a rule
        found = orbits(system, impacts, periods, modes=kept, tries=1, halt=halt)
        if found.complete:
            return found
    near = {}
    if drawn and impacts > 1:
        check_pushes(system)
        near = orbit_seeds(system, impacts, periods, modes=kept, motions=drawn, seed=seed, halt=halt)
    if flag("switch", switch) and impacts > 1:
        with suppress(Interrupted), halting(halt):
            near |= switched_seeds(system, impacts, periods, modes=kept)
    return orbits(system, impacts, periods, modes=kept, tries=tries, seed=seed, near=near, halt=halt)


def branch_answer(
    case: Case,
    orbit: str,
    along: str,
    *,
    switch: int = 0,
    modes: int | None = None,
    halt: Callable[[], bool] | None = None,
) -> Branch:
    """An orbit of a case followed through a parameter; see `percuss.explore.follow`.

    Parameters
    ----------
    case
        A hammer whose load keeps time.
    orbit
        ``2/1:3`` for number 3 of the orbits of a label, ``2/1:phases=1.2,4.5`` for that near these phases, in order of
        time; ``2/1`` for the first.
    along
        A parameter and its range, ``load_factor=0.3:1.2`` or ``frequency=40 Hz:80 Hz``; a key of the case in its unit.
        Without a range, ``load_factor``, the branch is followed to its ends.
    switch
        How deep to go on at flips, and of rigid bars at grazings.
    modes
        As for `orbits_answer`.
    halt
        As for `percuss.explore.follow`.

    Raises
    ------
    CaseError, LoadError, ResonanceError, ParameterError
        When there is no such orbit or parameter.

    Examples
    --------
    >>> from percuss.case import load_case
    >>> branch = branch_answer(load_case("pneumatic-jackleg"), "1/1:1", "load_factor=0.39:0.41", modes=0)
    >>> branch.label, branch.points[0].kind.value
    ('z=1/1', 'limit')
    """
    checked_case(case)
    name, family, ends = followed(case, along)
    value = value_of(case, family, name, ends)
    start = _chosen(case, orbit, _modes(case, modes))
    return follow(start, name, ends, family=family, value=value, switch=switch, halt=halt)


def followed(case: Case, along: str) -> tuple[str, CaseFamily, tuple[float, float] | None]:
    """A parameter, the systems that differ in it, and its range if one is given."""
    if "=" in text("along", along, "NAME=FROM:TO or NAME"):
        axis = Axis.spanned(along)
        family = CaseFamily(case, {axis.name: axis.unit} if axis.unit else {})
        return axis.name, family, (float(axis.values[0]), float(axis.values[1]))
    name, plain = along.strip(), CaseFamily(case, {})
    key = plain.key(name)
    unit = "" if key in ("", LOAD_SCALE) else quantity_of(case, key)[1]
    return name, CaseFamily(case, {name: unit}) if unit else plain, None


def _modes(case: Case, modes: int | None) -> int:
    return case.simulation().modes if modes is None else modes


def value_of(case: Case, family: CaseFamily, name: str, ends: tuple[float, float] | None = None) -> float:
    """A parameter of the case itself, in the unit of the family; it must lie between the ends, if any."""
    value = _value(case, family, name)
    if ends is not None and not ends[0] <= value <= ends[1]:
        held_here = f"a range that holds {value:.6g}, the value of the case"
        raise ParameterError(name, f"{ends[0]:g}:{ends[1]:g}", held_here, "another case begins elsewhere")
    return value


def _value(case: Case, family: CaseFamily, name: str) -> float:
    key = family.key(name)
    if not key:
        found = PARAMETERS[name].get(case.system())
        if found is None or not math.isfinite(found):  # of a structure s
            PARAMETERS[name].check(case.system())
            raise ParameterError(name, None, "a parameter that the case has")
        return found
    if key == LOAD_SCALE:
        return 1.0
    (value, unit), asked = quantity_of(case, key), family.units.get(name, "")
    if value is None:
        raise ParameterError(name, "none", "a value in the case to begin at", "now it is that of the record")
    if unit != asked:
        raise ParameterError(name, asked or "a plain number", f"the unit of the case: {unit or 'none'}")
    return value


def _chosen(case: Case, orbit: str, modes: int) -> PeriodicOrbit:
    """The orbit that a text names."""
    label, _, which = text("orbit", orbit, _CHOICE).partition(":")
    impacts, periods = parsed_label(label)
    if which.strip().startswith("phases"):
        return _near(case, orbit, (impacts, periods), which.partition("=")[2], modes)
    if which.strip() and not re.fullmatch(r"\s*\d{1,4}\s*", which, re.ASCII):
        raise ParameterError("orbit", orbit, _CHOICE)
    found = orbits_answer(case, label, modes=modes)
    number = count("orbit", int(which or 1), most=10**4)
    if number > len(found.orbits):
        told = f"one of the {len(found.orbits)} orbits {found.label} that were found"
        raise ParameterError("orbit", orbit, told, "'percuss orbits' lists them")
    return found.orbits[number - 1]


def _near(case: Case, orbit: str, label: tuple[int, int], phases: str, modes: int) -> PeriodicOrbit:
    """The orbit near phases, which are listed in order of time."""
    try:
        given = [float(phase) for phase in phases.split(",")]
    except ValueError:
        raise ParameterError("orbit", orbit, _CHOICE) from None
    if len(given) != label[0]:
        raise ParameterError("orbit", orbit, f"{label[0]} phases, one of each impact")
    return orbit_at_phases(case.system(), orbit, given, label, modes)
