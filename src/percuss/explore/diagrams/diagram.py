"""The diagram of a hammer over one parameter: what simulations settle on, and the branches of all orbits found."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from percuss.errors import Interrupted, extra_package
from percuss.explore.attractors.hammers import ClockedHammer
from percuss.explore.continuation.branch import Branch
from percuss.explore.diagrams.diagram_job import (
    DEFAULT_RUNS,
    DEFAULT_UP_TO,
    DEFAULT_VALUES,
    UNKNOWN,
    DiagramJob,
    diagram_job,
)
from percuss.explore.diagrams.diagram_lines import SettledMotion, lines_from, with_new
from percuss.explore.diagrams.machine_diagram import machine_settled_at
from percuss.explore.family import Axis, Family
from percuss.explore.jobs.archive_export import OfValues
from percuss.explore.jobs.archive_layout import canonical, parsed
from percuss.explore.jobs.job import Columns
from percuss.model import Machine, System
from percuss.model.checks import DEFAULT_MODES, Array

if TYPE_CHECKING:
    import xarray

    from percuss.explore.jobs.archive import Archive
    from percuss.simulate import Stop


# ---- What the passes of a diagram settled on at a value of the parameter, each motion once


def settled_at(passes: Columns, i: int, value: float, scales: Array, load_scale: float) -> list[SettledMotion]:
    """What the passes settled on at value number i."""
    names = ("code", "cycle_impacts", "cycle_periods", "cycle_kind", "wanders", "invariants")
    there = np.flatnonzero(passes["code"][:, i] != UNKNOWN)
    if not there.size:
        return []
    here = {name: passes[name][there, i] for name in names}
    number, words = ClockedHammer.matched(here, load_scale), ClockedHammer.labels(here)
    found = []
    for group in range(int(number.max()) + 1):
        members = np.flatnonzero(number == group)
        row = int(there[members[0]])
        kept = np.isfinite(passes["phases"][row, i])
        energies = passes["blow_energy"][there[members], i]
        ended = str(words[members[0]]) in ("rest", "departed")  # whose blows were on the way there
        known = energies[np.isfinite(energies) & (not ended)]
        energy = float(known.mean()) if known.size else np.nan
        made = (float(scales[0]), float(scales[1])) if scales[0] > 0.0 else None
        kept_impacts = passes["phases"][row, i, kept], passes["speeds"][row, i, kept]
        found.append(SettledMotion(value, str(words[members[0]]), members.size, *kept_impacts, energy, made))
    return found


# ---- The diagram of a hammer over one parameter: what simulations settle on, and the branches of all orbits found

_LINES = ("branches", "impossible", "rest_branches")


@dataclass(frozen=True, eq=False)
class Diagram(OfValues):
    """Motions over one parameter; made by `diagram`.

    Parameters
    ----------
    axis
        The parameter, and the values at which motions were simulated.
    modes
        N, of the simulations and of the branches.
    settled
        What simulations settled on, value by value, the most frequent first.
    branches, rest_branches
        All that were traced, each of them once; those of cycles with rest of rigid bars, and of structures.
    impossible
        Roots of the equations beyond the grazings at which branches end: no motions.
    ask
        All that was asked.
    done
        The share of the work that was done: 1 for a whole diagram.
    left_out
        Branches that were found and left out, as there were too many.
    """

    axis: Axis
    modes: int
    settled: tuple[SettledMotion, ...] = field(repr=False)
    branches: tuple[Branch, ...]
    ask: Mapping[str, Any] = field(repr=False)
    done: float = 1.0
    left_out: int = 0
    impossible: tuple[Branch, ...] = field(default=(), repr=False)
    rest_branches: tuple[Branch, ...] = ()

    @classmethod
    def of(cls, job: DiagramJob, columns: Columns) -> Diagram:
        """The result of a job."""
        return cls._made(job.ask, columns)

    @classmethod
    def from_archive(cls, archive: Archive) -> Diagram:
        """The diagram in an archive, as far as it is done."""
        return cls._made(archive.ask, archive.read())

    @classmethod
    def _made(cls, ask: Mapping[str, Any], columns: Columns) -> Diagram:
        along = ask["along"]
        axis, labelled = Axis(along["name"], along["values"], along["unit"]), int(ask["traces"])
        known = columns["branch_bytes"] >= 0
        lines: list[Branch] = []
        rests: list[Branch] = []
        for i in np.flatnonzero(known[:labelled]).tolist():
            size = int(columns["branch_bytes"][i])
            new = lines_from(columns["branches"][i, :size].tobytes())
            lines = with_new(lines, [line for line in new if not line.has_rest])
            rests += [line for line in new if line.has_rest]
        passes = {name: np.asarray(values)[labelled:][known[labelled:]] for name, values in columns.items()}
        scales, load_scales = np.array(ask["scales"]), np.array(ask["load_scales"])
        settled = []
        for i, value in enumerate(axis.values.tolist()):
            if ask.get("machine"):
                settled += machine_settled_at(passes, i, value, scales[i])
            else:
                settled += settled_at(passes, i, value, scales[i], float(load_scales[i]))
        left_out = int(columns["left_out"][:labelled][known[:labelled]].sum())
        motions = tuple(line for line in lines if line.possible)
        others = tuple(line for line in lines if not line.possible)
        return cls(
            axis, int(ask["modes"]), tuple(settled), motions, ask, float(known.mean()), left_out, others, tuple(rests)
        )

    @property
    def is_si(self) -> bool:
        """Whether speeds and energies have units."""
        every: tuple[SettledMotion | Branch, ...] = (*self.settled, *self.branches, *self.rest_branches)
        return any(one.scales is not None for one in every)

    @cached_property
    def labels(self) -> tuple[str, ...]:
        """The labels of the motions that simulations settled on, the most frequent first."""
        found: dict[str, int] = {}
        for one in self.settled:
            found[one.label] = found.get(one.label, 0) + one.members
        return tuple(sorted(found, key=lambda label: (-found[label], label)))

    def to_xarray(self) -> xarray.Dataset:
        """A row for each impact of what was simulated and of each orbit of the branches, and the events, with units."""
        about = {"kind": "diagram", "parameter": self.axis.name, "modes": self.modes}
        return dataset_of(self.axis, self.settled, (*self.branches, *self.rest_branches), self.is_si, about)

    def as_json(self) -> dict[str, Any]:
        """All of it as plain values."""
        lines = {name: [line.as_json() for line in getattr(self, name)] for name in _LINES}
        settled = [{**vars(one), "phases": one.phases.tolist(), "speeds": one.speeds.tolist()} for one in self.settled]
        return {
            "ask": canonical(dict(self.ask)),
            "settled": settled,
            "done": self.done,
            "left_out": self.left_out,
            **lines,
        }

    @classmethod
    def from_json(cls, row: Mapping[str, Any]) -> Diagram:
        """`as_json` backwards."""
        ask = parsed(row["ask"])
        along, told = ask["along"], {name: row[name] for name in ("done", "left_out")}
        told |= {name: tuple(map(Branch.from_json, row[name])) for name in _LINES}
        settled = [
            SettledMotion(**{**one, "phases": np.array(one["phases"]), "speeds": np.array(one["speeds"])})
            for one in ({**one, "scales": one["scales"] and tuple(one["scales"])} for one in row["settled"])
        ]
        axis = Axis(along["name"], along["values"], along["unit"])
        return cls(axis, int(ask["modes"]), tuple(settled), ask=ask, **told)

    def __str__(self) -> str:
        low, high = float(self.axis.values.min()), float(self.axis.values.max())
        settled = (
            f"{len(self.settled)} settled motions at {len(self.axis)} values" if self.settled else "no simulations"
        )
        head = f"Diagram over {self.axis.name} from {low:.9g} to {high:.9g}, {self.modes} modes: {settled}, "
        head += f"{len(self.branches)} branches"
        if self.rest_branches:
            head += f", {len(self.rest_branches)} of cycles with rest"
        every = (*self.branches, *self.rest_branches)
        return "\n".join([head, *(f"  {line}".replace("\n", "\n  ") for line in every)])


def diagram(
    what: System | Machine | Family,
    along: Axis | str | tuple[Any, ...],
    *,
    up_to: tuple[int, int] | None = DEFAULT_UP_TO,
    searched: int = 5,
    switch: int = 2,
    tries: int = 100,
    starts: int = 8,
    runs: int = DEFAULT_RUNS,
    modes: int = DEFAULT_MODES,
    stop: Stop | None = None,
    seed: int = 0,
    **running: Any,
) -> Diagram:
    """The motions of a hammer over one parameter: what simulations settle on, and the branches of all orbits found.

    At each value of the parameter motions are simulated from random starts. Some of those found are taken along, up and
    down the values, each simulation from the state in which the one before ended: so a motion that few starts lead to
    is met, too, up to where it is lost. At a few values orbits are searched for, stable and unstable, and every branch
    that one of them lies on is followed through the whole range, with the branches that begin at its flips and
    grazings. So are the cycles without rest that simulations settle on, however narrow their range is, and cycles with
    rest of up to 4 load periods, of a rigid bar or a structure.

    Parameters
    ----------
    what
        A system, whose dimensionless parameters are varied, or a family such as `percuss.case.CaseFamily`.
    along
        The parameter and the values at which motions are simulated: text such as ``"load_factor=0.3:1.2:120"``, of 120
        values where no number is given, ``(name, values)``, ``(name, first, last, number)`` or an `Axis`. Its least and
        greatest value are the range of the branches.
    up_to
        Orbits with up to p impacts in up to n load periods are searched for; None for no branches.
    searched
        At how many values.
    switch
        How often to go on at flips to the doubled orbit, and of a rigid bar at grazings; see `follow`.
    tries
        Random starts of each search; see `percuss.steady.orbits`.
    starts
        Simulations from a new random start at each value.
    runs
        Motions that are taken along: of every three the most frequent ones at one value.
    modes
        N, of the simulations and of the orbits.
    stop
        When a simulation ends; by default after 2000 impacts or when a periodic motion is found.
    seed
        Of the random starts of the simulations.
    running
        ``workers``, ``archive``, ``resume``, ``pool``, ``chunk``, ``progress`` as `percuss.explore.carry_out` has them;
        its items are the labels, then the passes of simulations.

    Returns
    -------
    Diagram
        With what was `settled` on, and the `branches`.

    Raises
    ------
    ParameterError
        For numbers out of range, or an unknown parameter.
    Interrupted
        After Ctrl-C; its `partial` is the diagram of what was done.

    Examples
    --------
    >>> from percuss import Load, System
    >>> system = System(s=5.0, d=0.0, restitution=0.5, load=Load.harmonic(0.7, 1.0))
    >>> found = diagram(system, "mean=0.5:0.9:5", up_to=(1, 1), searched=1, switch=0, starts=2, runs=0, modes=0)
    >>> stable = next(branch for branch in found.branches if branch.stable.any())
    >>> stable.label, [point.kind.value for point in stable.points]
    ('z=1/1', ['limit', 'flip', 'limit'])
    """
    job = diagram_job(
        what, diagram_axis(along), up_to=up_to, searched=searched, switch=switch, tries=tries, starts=starts, runs=runs,
        modes=modes, stop=stop, seed=seed,
    )  # fmt: skip
    return carried_diagram(job, **running)


def diagram_axis(along: Axis | str | tuple[Any, ...]) -> Axis:
    """The axis of a diagram; a range without a number has the usual one."""
    ranged = isinstance(along, str) and along.count(":") == 1
    return Axis.of(f"{along}:{DEFAULT_VALUES}" if ranged else along)


def carried_diagram(job: DiagramJob, **running: Any) -> Diagram:
    """A job of a diagram carried out, item by item; what was interrupted is the `partial` of the error."""
    from percuss.explore.jobs.carrying_out import carry_out

    try:
        return Diagram.of(job, carry_out(job, **{"chunk": 1, **running}))
    except Interrupted as stop:
        if isinstance(stop.partial, dict):
            stop.partial = Diagram.of(job, stop.partial)
        raise


# ---- A diagram as an xarray dataset: rows of impacts, simulated and of the branches, and the events of the branches


class _Row(NamedTuple):
    """One impact."""

    source: str
    number: int
    label: str
    value: float
    stable: int
    impact: int
    phase: float
    speed: float
    energy: float
    speed_scale: float
    energy_scale: float
    release_phase: float = math.nan
    rest_phase: float = math.nan


def dataset_of(
    axis: Axis,
    settled: Sequence[SettledMotion],
    branches: Sequence[Branch],
    is_si: bool,
    about: Mapping[str, Any],
) -> xarray.Dataset:
    """A diagram over the dimensions ``row``, one impact each, and ``event``, with the attributes `about`."""
    name, unit = axis.name, axis.unit or "1"
    rows = [*_simulated(settled), *(row for i, line in enumerate(branches, 1) for row in _rows(i, line))]
    table = dict(zip(_Row._fields, (np.array(column) for column in zip(*rows, strict=True)), strict=True))
    if not rows:
        table = {field: np.array([]) for field in _Row._fields}
    variables: dict[str, Any] = {
        "source": ("row", table["source"].astype(object), {"long_name": "what the impact is of: simulated or branch"}),
        "number": ("row", table["number"], {"long_name": "of the simulated motion or of the branch, from 1 on"}),
        "label": ("row", table["label"].astype(object), {"long_name": "motion label"}),
        name: ("row", table["value"], {"units": unit, "long_name": "the parameter"}),
        "stable": ("row", table["stable"], {"long_name": "1: stable, 0: unstable; what is simulated is stable"}),
        "impact": ("row", table["impact"], {"long_name": "number of the impact, from 1 on"}),
        "phase": ("row", table["phase"], {"units": "rad", "long_name": "load phase of the impact"}),
        "speed": ("row", table["speed"], {"units": "1", "long_name": "speed of the striking end just before it"}),
        "energy": ("row", table["energy"], {"units": "1", "long_name": "mean kinetic energy before a blow"}),
        "release_phase": ("row", table["release_phase"], {"units": "rad", "long_name": "when the bar was let go"}),
        "rest_phase": ("row", table["rest_phase"], {"units": "rad", "long_name": "when it comes to rest after that"}),
    }
    for key, its_unit in (("speed", "m/s"), ("energy", "J")) if is_si else ():
        told = {"units": its_unit, "long_name": variables[key][2]["long_name"]}
        variables[f"{key}_{its_unit.replace('/', '_')}"] = ("row", table[key] * table[f"{key}_scale"], told)
    variables |= _events(branches, unit)
    made: xarray.Dataset = extra_package("xarray", "io").Dataset(variables, attrs=dict(about))
    return made


def _simulated(settled: Sequence[SettledMotion]) -> Iterator[_Row]:
    for number, one in enumerate(settled, 1):
        scales = one.scales or (math.nan, math.nan)
        for i, (phase, speed) in enumerate(zip(one.phases.tolist(), one.speeds.tolist(), strict=True), 1):
            yield _Row("simulated", number, one.label, one.value, 1, i, phase, speed, one.energy, *scales)


def _rows(number: int, line: Branch) -> Iterator[_Row]:
    """The impacts of each motion; of a cycle with rest the first ones after each release, numbered through it."""
    size = line.values.size
    scales = np.full((size, 2), math.nan) if line.scales is None else line.scales
    shape = (size, -1, line.times.shape[-1])
    phases, speeds = line.phases.reshape(shape), line.speeds.reshape(shape)
    flights = np.full((size, phases.shape[1], 2), math.nan)
    if line.has_rest:
        flights = np.stack([line.release_phases, line.rest_phases], axis=-1)
    for m in range(size):
        same, energies = (float(line.values[m]), int(line.stable[m])), (float(line.energies[m]), *scales[m].tolist())
        known = np.isfinite(phases[m])
        impacts = zip(np.argwhere(known)[:, 0], phases[m][known].tolist(), speeds[m][known].tolist(), strict=True)
        for i, (flight, phase, speed) in enumerate(impacts, 1):
            yield _Row("branch", number, line.label, *same, i, phase, speed, *energies, *flights[m, flight].tolist())


def _events(branches: Sequence[Branch], unit: str) -> dict[str, Any]:
    points = [(i, point) for i, line in enumerate(branches, 1) for point in line.points]
    values = np.array([point.value for _, point in points])
    return {
        "event_branch": ("event", np.array([i for i, _ in points], dtype=np.int64), {"long_name": "of which branch"}),
        "event_type": ("event", _texts([point.kind.value for _, point in points]), {"long_name": "what happens"}),
        "event_label": ("event", _texts([point.plain.label for _, point in points]), {"long_name": "motion label"}),
        "event_value": ("event", values, {"units": unit, "long_name": "the parameter"}),
        "event_beyond": ("event", _texts([point.beyond for _, point in points]), {"long_name": "what lies beyond"}),
    }


def _texts(values: list[str]) -> np.ndarray[Any, np.dtype[np.object_]]:
    return np.array(values, dtype=object)
