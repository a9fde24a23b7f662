"""The orbits of a case with several impacts in a cycle: searched for by their labels, and followed."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from itertools import combinations, islice
from typing import TYPE_CHECKING, Any

import numpy as np

from percuss.case.answers.facts import PLAIN, Grid, Report, ReportSection, counted, picked, plain_value, table_text
from percuss.case.case import Case, checked_case
from percuss.case.parameters.case_family import CaseFamily
from percuss.case.parameters.case_keys import LOAD_SCALE
from percuss.case.parameters.description import quantity_of
from percuss.errors import Interrupted, ParameterError
from percuss.explore import Axis, BranchEvent, follow, orbit_seeds, switched_seeds
from percuss.explore.orbit_starts import doubled_seeds
from percuss.explore.parameters import parameters_of
from percuss.halting import Elapsed, asked, halting
from percuss.model import Machine, System
from percuss.model.checks import Array, count, flag, text
from percuss.steady import FoundOrbits, PeriodicOrbit, orbit_near, orbits, rest_cycles
from percuss.steady.multipliers import NEUTRAL
from percuss.steady.periodic.found_orbits import MOST_IMPACTS, MOST_PERIODS, free_amplitude
from percuss.steady.self_excited.valve_cycle import ValveCycle
from percuss.steady.self_excited.valve_orbits import valve_rest_cycles
from percuss.steady.states import check_pushes

if TYPE_CHECKING:
    from percuss.explore import Branch, BranchPoint, PointCurve
    from percuss.model.checks import ComplexArray
    from percuss.steady import FoundRestCycles, RestCycle, ValveCycle


# ---- The orbit of a label that is near the phases of its impacts, whatever load periods these fall into

_TURN = 2.0 * math.pi
_NEAR = 0.5  # rad, by which each phase may be off
_MOST = 500  # ways in which the impacts may fall into the load periods


def orbit_at_phases(
    system: System, asked: str, phases: list[float], label: tuple[int, int], modes: int
) -> PeriodicOrbit:
    """The nearest orbit p/n whose phases (rad, any turns more or less) are near those given, in order of time."""
    given = np.array(phases)
    if not np.all(np.abs(given) < 1e6):
        raise ParameterError("orbit", asked, "phases in rad")
    given = np.mod(given, _TURN)
    best, least, nearest = None, math.inf, None
    for times in islice(_unwrapped(given, label[1]), _MOST):
        found = orbit_near(system, times, label[1], modes=modes)
        if found is None:
            continue
        off = _off(found.phases, given)
        if off < least:
            nearest, least = found, off
        if off < _NEAR and (best is None or (found.admissible, -off) > (best.admissible, -_off(best.phases, given))):
            best = found
    if best is None:
        told = "" if nearest is None else f"the nearest has {', '.join(f'{phase:.6g}' for phase in nearest.phases[:4])}"
        raise ParameterError("orbit", asked, "phases near those of an orbit, in order of time", told)
    return best


def _unwrapped(phases: Array, periods: int) -> Iterator[Array]:
    """Times with these phases in order, within so many load periods: the turns that are left go to any flights."""
    flights = np.mod(np.diff(phases, append=phases[:1]), _TURN)
    flights = np.where(flights > 0.0, flights, _TURN if phases.size == 1 else 0.0)
    spare = periods - round(float(flights.sum()) / _TURN)
    if spare < 0:
        return
    p = phases.size
    for bars in combinations(range(spare + p - 1), p - 1):
        places = (-1, *bars, spare + p - 1)
        turns = np.diff(places) - 1
        longer = flights + _TURN * turns
        if np.all(longer > 0.0):
            yield phases[0] + np.append(0.0, np.cumsum(longer)[:-1])


def _off(phases: Array, given: Array) -> float:
    """How far phases are off, at most, whichever impact is the first."""
    shifts = [np.abs(np.mod(np.roll(phases, -k) - given + math.pi, _TURN) - math.pi).max() for k in range(phases.size)]
    return float(min(shifts))


# ---- The orbits of a case with several impacts in a cycle: searched for by their labels, and followed

_LABEL = re.compile(r"\s*(?:z\s*=\s*)?(\d{1,3})\s*/\s*(\d{1,3})\s*", re.ASCII)
_CHOICE = "P/N:NUMBER or P/N:phases=1.2,4.5"
_REST_CHOICE = "chatter/N:NUMBER or rest/N:NUMBER"


def parsed_label(label: str) -> tuple[int, int]:
    """p and n of a label such as 3/2 or z=3/2."""
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
    progress: Callable[[Elapsed], object] | None = None,
) -> FoundOrbits:
    """The orbits z=p/n of a case, or p/n of one whose piston switches the valve; see `percuss.steady.orbits`.

    Parameters
    ----------
    modes
        N, in the forced motion, too; None for the case's, or 32.
    motions
        How many are simulated to start from their close returns; 0 for none.
    switch
        Whether to start also from what begins on branches of shorter orbits; see `percuss.explore.switched_seeds`.

    Examples
    --------
    >>> from percuss.case import load_case
    >>> print(orbits_answer(load_case("hydraulic-drifter"), "1/1", modes=0).label)
    z=1/1
    """
    checked_case(case)
    asked: dict[str, Any] = {"tries": tries, "seed": seed, "motions": motions, "switch": switch, "progress": progress}
    return _searched(case.hammer, label, _modes(case, modes), **asked)


def _searched(
    system: System | Machine,
    label: str,
    kept: int,
    *,
    tries: int = 400,
    seed: int = 0,
    motions: int = 64,
    switch: bool = False,
    progress: Callable[[Elapsed], object] | None = None,
) -> FoundOrbits:
    if isinstance(system, Machine) and is_rest_label(label):
        word, _, number = re.sub(r"\s", "", label).partition("/")
        return valve_rest_cycles(system, word, int(number), modes=kept)
    (impacts, periods), drawn = parsed_label(label), count("motions", motions, least=0, most=10**5)
    if isinstance(system, Machine):
        near: dict[str, Any] = (
            orbit_seeds(system, impacts, periods, modes=kept, motions=drawn, seed=seed, progress=progress)
            if drawn and not system.valve.flows  # whose own starts are followed until they have settled
            else {}
        )
        if flag("switch", switch) and impacts % 2 == periods % 2 == 0:
            with suppress(Interrupted), halting(asked(progress)):
                near |= doubled_seeds(system, impacts, periods, modes=kept)
        return orbits(system, impacts, periods, modes=kept, tries=tries, seed=seed, near=near, progress=progress)
    if drawn and impacts == 2 and kept == 0:  # the list is complete without them, as a rule
        found = orbits(system, impacts, periods, modes=kept, tries=1, progress=progress)
        if found.complete:
            return found
    near = {}
    if drawn and impacts > 1:
        check_pushes(system)
        near = orbit_seeds(system, impacts, periods, modes=kept, motions=drawn, seed=seed, progress=progress)
    if flag("switch", switch) and impacts > 1:
        with suppress(Interrupted), halting(asked(progress)):
            near |= switched_seeds(system, impacts, periods, modes=kept)
    return orbits(system, impacts, periods, modes=kept, tries=tries, seed=seed, near=near, progress=progress)


def branch_answer(
    case: Case,
    orbit: str,
    along: str,
    *,
    switch: int = 0,
    modes: int | None = None,
    progress: Callable[[Elapsed], object] | None = None,
) -> Branch:
    """An orbit or a cycle with rest of a case followed through a parameter.

    See `percuss.explore.follow`.

    Parameters
    ----------
    orbit
        ``2/1:3`` for number 3 of the orbits of a label, ``2/1:phases=1.2,4.5`` for that near these phases, in order of
        time; ``chatter/1:2`` or ``rest/1:2`` for number 2 of the cycles with rest of a label; ``2/1`` for the first.
        Of a machine that switches its own valve labels are blows and valve cycles in a period.
    along
        A parameter and its range, ``load_factor=0.3:1.2`` or ``frequency=40 Hz:80 Hz``; a key of the case in its unit.
        Without a range, ``load_factor``, the branch is followed to its ends. Where the range does not hold the value of
        the case, the orbit is one of the case with the nearest end of the range: see `begun_at`.
    switch
        How deep to go on at flips, and of rigid bars at grazings; 0 for a cycle with rest, but of several modes of a
        structure.

    Examples
    --------
    >>> from percuss.case import load_case
    >>> branch = branch_answer(load_case("pneumatic-jackleg"), "1/1:1", "load_factor=0.39:0.41", modes=0)
    >>> branch.label, branch.points[0].kind.value
    ('z=1/1', 'limit')
    """
    checked_case(case)
    name, family, ends = followed(case, along)
    own, kept = _value(case, family, name), _modes(case, modes)
    value = own if ends is None else min(max(own, ends[0]), ends[1])
    if case.is_machine:
        machine = case.machine() if value == own else family.machine({name: value})
        begun = _chosen(machine, orbit, kept)
        return follow(begun, name, ends, family=family, value=value, switch=switch, progress=progress)
    system = case.system() if value == own else family.system({name: value})
    if is_rest_label(text("orbit", orbit, _CHOICE).partition(":")[0]):
        cycle = _chosen_cycle(system, orbit, kept)
        if count("switch", switch, least=0) and not cycle.is_several:
            raise ParameterError("switch", switch, "0: nothing branches off a cycle whose rests forget everything")
        return follow(cycle, name, ends, family=family, value=value, switch=switch, progress=progress)
    start = _chosen(system, orbit, kept)
    return follow(start, name, ends, family=family, value=value, switch=switch, progress=progress)


def begun_at(case: Case, along: str) -> float | None:
    """The end of a range at which a branch of a case begins, whose own value is not in it; else None."""
    name, family, ends = followed(case, along)
    own = _value(case, family, name)
    return None if ends is None or ends[0] <= own <= ends[1] else min(max(own, ends[0]), ends[1])


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
        hammer: Any = case.hammer
        parameter = parameters_of(hammer)[name]
        found = parameter.get(hammer)
        if found is None or not math.isfinite(found):  # of a structure s
            parameter.check(hammer)
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


def _chosen(system: System | Machine, orbit: str, modes: int) -> Any:
    label, _, which = orbit.partition(":")
    if which.strip().startswith("phases") and isinstance(system, System):
        return _near(system, orbit, parsed_label(label), which.partition("=")[2], modes)
    if which.strip() and not re.fullmatch(r"\s*\d{1,4}\s*", which, re.ASCII):
        raise ParameterError("orbit", orbit, _CHOICE)
    found = _searched(system, label, modes)
    number = count("orbit", int(which or 1), most=10**4)
    if number > len(found.orbits):
        told = f"one of the {len(found.orbits)} orbits {found.label} that were found"
        raise ParameterError("orbit", orbit, told, "'percuss orbits' lists them")
    return found.orbits[number - 1]


def _near(system: System, orbit: str, label: tuple[int, int], phases: str, modes: int) -> PeriodicOrbit:
    try:
        given = [float(phase) for phase in phases.split(",")]
    except ValueError:
        raise ParameterError("orbit", orbit, _CHOICE) from None
    if len(given) != label[0]:
        raise ParameterError("orbit", orbit, f"{label[0]} phases, one of each impact")
    return orbit_at_phases(system, orbit, given, label, modes)


# ---- Orbits and their branches as JSON


def orbits_dict(found: FoundOrbits) -> dict[str, Any]:
    return {
        **picked(found, "label modes complete unseen unseen_bound interrupted ended tries resonant_modes"),
        "orbits": [orbit_json(orbit) for orbit in found.orbits],
        "sources": {name: tally._asdict() for name, tally in found.sources.items()},
        "dropped": {reason.value: number for reason, number in found.dropped.items()},
    }


def orbit_json(orbit: PeriodicOrbit | ValveCycle) -> dict[str, Any]:
    """An orbit of either kind of hammer, with its multipliers."""
    if isinstance(orbit, PeriodicOrbit):
        return orbit_dict(orbit, orbit.multipliers().values)
    blows = zip(orbit.blow_times.tolist(), orbit.blow_speeds.tolist(), strict=True)
    return {
        **picked(orbit, "label period flight_times"),
        "impacts": [{"time": time, "speed": speed} for time, speed in blows],
        "ports": [picked(one, "port time") for one in orbit.uncoverings],
        "pressure": orbit.rebound.pressure,
        "multipliers": plain_value(orbit.multipliers().values.tolist()),
        "stable": bool(abs(orbit.multiplier) < 1.0 - NEUTRAL),
        "admissible": True,
        "reason": None,
    }


def branch_dict(branch: Branch, curves: Sequence[PointCurve] = (), begun: float | None = None) -> dict[str, Any]:
    """A branch, and all that were switched to from it; and curves of their points. `begun`: see `begun_at`."""
    return {
        **picked(branch, "parameter modes"),
        **_branch_dict(branch),
        "switched": [_branch_dict(other) for other in branch.family() if other is not branch],
        "cascade": [row._asdict() for row in branch.cascade],
        "curves": [curve_dict(curve) for curve in curves],
        **({} if begun is None else {"begun_at": begun}),
    }


def curve_dict(curve: PointCurve) -> dict[str, Any]:
    """Points of a branch followed through two parameters, or ends of cycles with rest."""
    points = [{"type": point.kind.value, **picked(point, "values beyond")} for point in curve.points]
    if not curve.has_rest:
        orbits = [picked(point.motion, "phases speeds") for point in curve.points]
        points = [told | orbit for told, orbit in zip(points, orbits, strict=True)]
        along = picked(curve, "values phases is_orbit angles")
        along["angles"] = None if None in along["angles"] else along["angles"]
    else:
        last = "event_phases" if curve.event_phases.size else "angles"
        along = picked(curve, f"values release_phases is_orbit {last}")
    return {"type": curve.event.value, **picked(curve, "label parameters units"), "points": points, "curve": along}


def _branch_dict(branch: Branch) -> dict[str, Any]:
    along = picked(branch, "phases times speeds stable")
    along |= picked(branch, "cycle_times") if branch.is_machine else {}
    if branch.has_rest:  # each cycle has its own number of impacts
        names = ("phases", "times", "speeds", "stable", "release_phases", "rest_phases")
        along = {name: [plain_value(getattr(cycle, name)) for cycle in branch.cycles] for name in names}
        along["impacts"] = [[len(chain.impacts) for chain in cycle.chains] for cycle in branch.cycles]
    return {
        "label": branch.label,
        "points": [_point(point, branch.has_rest) for point in branch.points],
        "branch": {"value": branch.values.tolist(), **along},
    }


def _point(point: BranchPoint, has_rest: bool) -> dict[str, Any]:
    told = picked(point, "value beyond impact touch_phase side criticality")
    if isinstance(point.motion, ValveCycle):
        return {"type": point.kind.value, "orbit": orbit_json(point.motion), **told}
    if not has_rest:
        return {"type": point.kind.value, "orbit": orbit_dict(point.orbit, point.multipliers), **told}
    told["touch_phase" if point.kind is BranchEvent.DEATH else "impact"] = None
    return {"type": point.kind.value, "orbit": rest_cycle_dict(point.cycle), **told}


def _impacts(orbit: PeriodicOrbit | RestCycle) -> list[dict[str, float]]:
    impacts = zip(orbit.phases.tolist(), orbit.speeds.tolist(), strict=True)
    return [{"phase": phase, "speed": speed} for phase, speed in impacts]


def orbit_dict(orbit: PeriodicOrbit, multipliers: ComplexArray | None) -> dict[str, Any]:
    """An orbit; its multipliers are null where they grow without bound."""
    values = None if multipliers is None else multipliers.tolist()
    return {
        **picked(orbit, "label flight_times admissible"),
        "impacts": _impacts(orbit),
        "multipliers": None if values is None else plain_value(values),
        "stable": None if values is None else max(abs(value) for value in values) < 1.0 - NEUTRAL,
        "reason": orbit.obstacle.value if orbit.obstacle is not None else None,
    }


# ---- Branches as a table of text


def branch_table(branch: Branch) -> str:
    """A branch and its family as CSV: a line for each impact, of a chatter for each that was followed by itself."""
    heads = ("branch", "label", "point", branch.parameter, "stable", "impact", "phase", "speed")
    rows: list[tuple[object, ...]] = []
    for number, one in enumerate(branch.family(), 1):
        motions = [_rows_with_rest(cycle) for cycle in one.cycles] or [
            list(zip(*pair, strict=True)) for pair in zip(one.phases.tolist(), one.speeds.tolist(), strict=True)
        ]
        points = zip(one.values.tolist(), one.stable.tolist(), motions, strict=True)
        for point, (value, stable, motion) in enumerate(points, 1):
            about = (number, one.label, point, value, int(stable))
            rows += [(*about, impact, *figures) for impact, figures in enumerate(motion, 1)]
    return table_text((*heads, *(("release_phase", "rest_phase") if branch.has_rest else ())), rows)


def _rows_with_rest(cycle: RestCycle) -> list[tuple[float, ...]]:
    """Phase and speed of each impact, and the phases of the release before it and of the rest after it."""
    chains = zip(cycle.release_phases.tolist(), cycle.rest_phases.tolist(), cycle.chains, strict=True)
    ends = [(release, rest) for release, rest, chain in chains for _ in chain.impacts]
    impacts = zip(cycle.phases.tolist(), cycle.speeds.tolist(), ends, strict=False)
    return [(phase, speed, *end) for phase, speed, end in impacts]


# ---- The cycles with rest of a case: by their labels, in words and as JSON

_REST_LABEL = re.compile(r"\s*(chatter|rest)\s*/\s*([1-9]\d{0,2})\s*", re.ASCII)


def is_rest_label(label: str) -> bool:
    """Whether a label is one of a cycle with rest, such as ``chatter/1``."""
    return _REST_LABEL.fullmatch(label) is not None


def rest_cycles_answer(case: Case, *, modes: int | None = None, most: int = 64) -> FoundRestCycles:
    """All cycles of a case in which the bar rests on the wall; see `percuss.steady.rest_cycles`.

    Parameters
    ----------
    modes
        N, in the forced motion, too; None for the case's, or 32.
    most
        Load periods of a cycle, 1 to 256.

    Examples
    --------
    >>> from percuss.case import load_case
    >>> rest_cycles_answer(load_case("pneumatic-jackleg"), modes=0).modes
    0
    """
    checked_case(case)
    return rest_cycles(case.system(), modes=_modes(case, modes), most=most)


def rest_cycles_dict(found: FoundRestCycles, label: str) -> dict[str, Any]:
    """The cycles of a label, in the form of the answers of a search for orbits."""
    told = re.sub(r"\s", "", label)
    bound = 0.0 if found.complete else 1.0
    nothing: dict[str, Any] = {"unseen": 0.0, "unseen_bound": bound, "sources": {}, "resonant_modes": [], "dropped": {}}
    return {
        "label": told,
        "modes": found.modes,
        "orbits": [rest_cycle_dict(cycle) for cycle in found.labelled(told)],
        "complete": found.complete,
        "interrupted": False,
        "ended": 0,
        "tries": found.rests or len(found.releases),
        **nothing,
    }


def rest_cycle_dict(cycle: RestCycle) -> dict[str, Any]:
    told = picked(cycle, "label release_phase rest_phase flight_times stable admissible")
    values = list(cycle.remembered) or [0.0j]
    return {**told, "impacts": _impacts(cycle), "multipliers": plain_value(values), "reason": None}


def _chosen_cycle(system: System, orbit: str, modes: int) -> RestCycle:
    """The cycle that a text names."""
    label, _, which = orbit.partition(":")
    number = re.fullmatch(r"\s*(\d{1,4})\s*", which or "1", re.ASCII)
    if number is None or int(number[1]) < 1:
        raise ParameterError("orbit", orbit, _REST_CHOICE)
    found = rest_cycles(system, modes=modes)
    cycles = found.labelled(re.sub(r"\s", "", label))
    if int(number[1]) > len(cycles):
        others = ", ".join(cycle.label for cycle in found.orbits) or "none"
        told = f"one of the {len(cycles)} cycles {label.strip()} of this case"
        raise ParameterError("orbit", orbit, told, f"all its cycles with rest: {others}")
    return cycles[int(number[1]) - 1]


# ---- Reports


_MOST_TOLD = 4  # impacts of which a line tells


def _few(values: list[float]) -> str:
    told = ", ".join(f"{value:.6f}" for value in values[:_MOST_TOLD])
    return told + (", …" if len(values) > _MOST_TOLD else "")


def branch_report(
    title: str, branch: Branch, curves: Sequence[PointCurve] = (), begun: float | None = None, again: str = ""
) -> Report:
    """What happens on a branch, its family, and curves of its points; `again`: the parameter that was given twice."""
    every = list(branch.family())
    sections: list[ReportSection | Grid] = [branch_section(one.label, one) for one in every]
    if branch.has_rest:
        rests, told = branch.rest_times, "all 0: stable all along"
        if any(cycle.remembered for cycle in branch.cycles):
            sizes = [cycle.multipliers().largest for cycle in branch.cycles]
            told = f"the largest from {min(sizes):.6g} to {max(sizes):.6g}, "
            told += f"stable at {counted(int(branch.stable.sum()), 'point')} of {branch.values.size}"
        lines = (
            ("multipliers", told),
            ("shortest rest", f"{rests.min():.6g} to {rests.max():.6g} rad of the load"),
        )
        sections.append(ReportSection(f"{branch.label}: on the way", lines))
    if len(branch.cascade) > 1:
        rows = tuple(
            (row.label, f"{row.value:.12g}", "" if row.ratio is None else f"{row.ratio:.4f}") for row in branch.cascade
        )
        sections.append(Grid("Cascade", ("label", branch.parameter, "ratio"), rows))
    for curve in curves:
        over = " and ".join(curve.parameters)
        sections.append(branch_section(f"{curve.event.value} of {curve.label} over {over}", curve))
    low, high = float(branch.values.min()), float(branch.values.max())
    summary = f"{branch.label} over {branch.parameter}, {low:.9g} to {high:.9g}"
    told = "" if begun is None else f" Begun at {begun:.9g}, the end of the range that is nearest to the case."
    told += f" Over {again} alone a point stays where it is: curves need another second parameter." if again else ""
    return Report(title, f"{summary}; branches: {len(every)}.{told}", PLAIN, tuple(sections))


def branch_section(heading: str, line: Branch) -> ReportSection:
    """What happens on a branch or a curve."""
    rows = tuple(
        (point.kind.value, f"{', '.join(f'{value:.12g}' for value in point.values)}: {point.beyond}")
        for point in line.points
    )
    return ReportSection(f"{heading}, {counted(len(line.values), 'point')}", rows)


_COLUMNS = ("number", "phases [rad]", "speeds", "largest multiplier", "stable")
_CYCLE_COLUMNS = ("number", "blows after", "speeds", "largest multiplier", "stable")
_REST_COLUMNS = (
    "number", "release [rad]", "phases [rad]", "speeds", "rest from [rad]", "largest multiplier", "stable",
)  # fmt: skip


def orbits_report(
    title: str, found: Sequence[FoundOrbits], resting: FoundRestCycles | None, rests: Sequence[str], mode: str
) -> Report:
    """What searches found, and the cycles with rest of some labels; `mode`: what a mode is called."""
    sections: list[ReportSection | Grid] = []
    for one in found:
        sections += _search_sections(one, mode)
    told = counted(sum(len(one.orbits) for one in found), "orbit")
    if resting is not None:
        sections += [section for label in rests for section in _rest_sections(resting, label)]
        told += f", {counted(sum(cycle.label in rests for cycle in resting), 'cycle')} with rest"
    free = free_amplitude({n for one in found for n in one.resonant_modes})
    return Report(title, f"{told}, {counted(found[0].modes, mode)}{free}.", PLAIN, tuple(sections))


def _search_sections(one: FoundOrbits, mode: str) -> list[ReportSection | Grid]:
    rows = tuple(_orbit_row(number, orbit) for number, orbit in enumerate(one.orbits, 1))
    lines = [("tries", str(one.tries)), ("unseen share", one.unseen_sentence)]
    lines = [("complete", "yes (proved)")] if one.complete else lines
    lines += [
        (f"from {name}", f"{counted(tally.orbits, 'orbit')} in {tally.tries}") for name, tally in one.sources.items()
    ]
    lines += [(reason.value, str(number)) for reason, number in one.dropped.items()]
    if one.interrupted:
        lines.append(("interrupted", "before all tries were made; there may be more orbits"))
    if one.resonant_modes:
        told = ", ".join(map(str, one.resonant_modes[:_MOST_TOLD]))
        told += ", …" if len(one.resonant_modes) > _MOST_TOLD else ""
        lines.append(("free amplitude", f"of {mode}s {told}, which come back after a cycle by themselves"))
    search = ReportSection(f"{one.label}: the search", tuple(lines))
    columns = _COLUMNS if isinstance(one.system, System) else _CYCLE_COLUMNS
    return [Grid(one.label, columns, rows), search] if rows else [search]


def _orbit_row(number: int, orbit: PeriodicOrbit | ValveCycle) -> tuple[str, ...]:
    if not isinstance(orbit, PeriodicOrbit):
        figures = _few(orbit.blow_times.tolist()), _few(orbit.blow_speeds.tolist()), f"{abs(orbit.multiplier):.6g}"
        return (str(number), *figures, "yes" if abs(orbit.multiplier) < 1.0 - NEUTRAL else "no")
    found = orbit.multipliers()
    impacts = (_few(orbit.phases.tolist()), _few(orbit.speeds.tolist()))
    return (str(number), *impacts, f"{found.largest:.6g}", "yes" if found.stable else "no")


def rest_report(title: str, found: FoundRestCycles, label: str) -> Report:
    """The cycles of a label, and where the other releases lead."""
    told = rest_cycles_dict(found, label)["label"]
    cycles = found.labelled(told)
    mode = "elastic mode" if found.system.body.is_free else "mode"
    summary = f"{counted(len(cycles), 'cycle')} {told}, {counted(found.modes, mode)}."
    return Report(title, summary, PLAIN, _rest_sections(found, told))


def _rest_sections(found: FoundRestCycles, label: str) -> tuple[ReportSection | Grid, ...]:
    """The parts of a report on the cycles of a label."""
    cycles = found.labelled(label)
    sections: list[ReportSection | Grid] = []
    if cycles:
        rows = tuple(
            (
                str(number),
                f"{cycle.release_phase:.9f}",
                _few(cycle.phases.tolist()),
                _few(cycle.speeds.tolist()),
                f"{cycle.rest_phase:.9f}",
                f"{cycle.multipliers().largest:.6g}",
                "yes" if cycle.stable else "no",
            )
            for number, cycle in enumerate(cycles, 1)
        )
        sections.append(Grid(label, _REST_COLUMNS, rows))
    lines = [("complete", "yes: one motion from each phase at which the load lets go")]
    if not found.complete:
        told = "no: several modes move on while the wall holds the contact, and the structure leaves at any phase"
        lines = [("complete", told), ("looked for", f"from {counted(found.rests, 'rest')}")]
    for release, number in zip(found.releases, found.leads_to, strict=True):
        end = (
            found[number].label
            if number >= 0
            else f"no return within {found.most} load periods, or rounding decides when"
        )
        lines.append((f"released at {release:.6f} rad", end))
    if found.complete and not found.releases:
        lines.append(("release", "the load never turns from push to pull"))
    sections.append(ReportSection(f"{label}: from the releases", tuple(lines)))
    return tuple(sections)
