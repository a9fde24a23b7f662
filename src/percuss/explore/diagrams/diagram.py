"""The diagram of a hammer over one parameter: what simulations settle on, and the branches of all orbits found."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from percuss.errors import Interrupted
from percuss.explore.axis import Axis
from percuss.explore.diagrams.diagram_job import DEFAULT_RUNS, DEFAULT_UP_TO, DiagramJob, diagram_job
from percuss.explore.diagrams.found_twice import with_new
from percuss.explore.diagrams.lines import DiagramBranch, lines_from
from percuss.explore.diagrams.rest_lines import DiagramRestBranch
from percuss.explore.diagrams.settled import SettledMotion, settled_at
from percuss.explore.family import Family
from percuss.explore.jobs.job import Columns
from percuss.model import Machine, System
from percuss.shown import Shown

if TYPE_CHECKING:
    import xarray

    from percuss.explore.jobs.archive import Archive
    from percuss.simulate import Stop

__all__ = ["Diagram", "carried_diagram", "diagram"]


@dataclass(frozen=True, eq=False)
class Diagram(Shown):
    """Motions over one parameter; made by `diagram`.

    Parameters
    ----------
    axis
        The parameter, and the values at which motions were simulated.
    modes
        N, of the simulations and of the branches.
    settled
        What simulations settled on, value by value, the most frequent first.
    branches
        All that were traced; each of them once.
    rest_branches
        Those of cycles with rest: of rigid bars, and of structures of one mode.
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
    branches: tuple[DiagramBranch, ...]
    ask: Mapping[str, Any] = field(repr=False)
    done: float = 1.0
    left_out: int = 0
    impossible: tuple[DiagramBranch, ...] = field(default=(), repr=False)
    rest_branches: tuple[DiagramRestBranch, ...] = ()

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
        lines: list[DiagramBranch] = []
        rests: list[DiagramRestBranch] = []
        for i in np.flatnonzero(known[:labelled]).tolist():
            size = int(columns["branch_bytes"][i])
            new = lines_from(columns["branches"][i, :size].tobytes())
            lines = with_new(lines, [line for line in new if isinstance(line, DiagramBranch)])
            rests += [line for line in new if isinstance(line, DiagramRestBranch)]
        passes = {name: np.asarray(values)[labelled:][known[labelled:]] for name, values in columns.items()}
        scales, load_scales = np.array(ask["scales"]), np.array(ask["load_scales"])
        settled = [
            one
            for i, value in enumerate(axis.values.tolist())
            for one in settled_at(passes, i, value, scales[i], float(load_scales[i]))
        ]
        left_out = int(columns["left_out"][:labelled][known[:labelled]].sum())
        motions = tuple(line for line in lines if line.possible)
        others = tuple(line for line in lines if not line.possible)
        return cls(
            axis, int(ask["modes"]), tuple(settled), motions, ask, float(known.mean()), left_out, others, tuple(rests)
        )

    @property
    def is_si(self) -> bool:
        """Whether speeds and energies have units."""
        return (
            any(one.scales is not None for one in self.settled)
            or any(line.scales is not None for line in self.branches)
            or any(line.scales is not None for line in self.rest_branches)
        )

    @cached_property
    def labels(self) -> tuple[str, ...]:
        """The labels of the motions that simulations settled on, the most frequent first."""
        found: dict[str, int] = {}
        for one in self.settled:
            found[one.label] = found.get(one.label, 0) + one.members
        return tuple(sorted(found, key=lambda label: (-found[label], label)))

    @cached_property
    def dataset(self) -> xarray.Dataset:
        """A row for each impact of what was simulated and of each orbit of the branches, and the events, with units."""
        from percuss.explore.diagrams.diagram_dataset import dataset_of

        about = {"kind": "diagram", "parameter": self.axis.name, "modes": self.modes}
        return dataset_of(self.axis, self.settled, (*self.branches, *self.rest_branches), self.is_si, about)

    def __str__(self) -> str:
        low, high = float(self.axis.values.min()), float(self.axis.values.max())
        settled = (
            f"{len(self.settled)} settled motions at {len(self.axis)} values" if self.settled else "no simulations"
        )
        head = f"Diagram over {self.axis.name} from {low:.9g} to {high:.9g}: {settled}, {len(self.branches)} branches"
        if self.rest_branches:
            head += f", {len(self.rest_branches)} of cycles with rest"
        every = (*self.branches, *self.rest_branches)
        return "\n".join([head, *(f"  {line}".replace("\n", "\n  ") for line in every)])


def diagram(
    what: System | Machine | Family,
    axis: Axis | str,
    *,
    up_to: tuple[int, int] | None = DEFAULT_UP_TO,
    searched: int = 5,
    switch: int = 2,
    tries: int = 100,
    starts: int = 8,
    runs: int = DEFAULT_RUNS,
    modes: int = 8,
    stop: Stop | None = None,
    seed: int = 0,
    **running: Any,
) -> Diagram:
    """The motions of a hammer over one parameter: what simulations settle on, and the branches of all orbits found.

    At each value of the parameter motions are simulated from random starts. Some of those found are taken along, up and
    down the values, each simulation from the state in which the one before ended: so a motion that few starts lead to
    is met, too, up to where it is lost. At a few values orbits are searched for, stable and unstable, and every branch
    that one of them lies on is followed through the whole range, with the branches that begin at its flips and
    grazings. So are the longer cycles that simulations settle on there, and cycles with rest of up to 4 load periods,
    of a rigid bar or a structure of one mode.

    Parameters
    ----------
    what
        A system, whose dimensionless parameters are varied, or a family such as `percuss.case.CaseFamily`.
    axis
        The parameter and the values at which motions are simulated: an `Axis`, or text such as
        ``"load_factor=0.3:1.2:120"``. Its least and greatest value are the range of the branches.
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
        For numbers out of range, an unknown parameter, or a machine that switches its own valve.
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
    along = Axis.parsed(axis) if isinstance(axis, str) else axis
    job = diagram_job(
        what, along, up_to=up_to, searched=searched, switch=switch, tries=tries, starts=starts, runs=runs,
        modes=modes, stop=stop, seed=seed,
    )  # fmt: skip
    return carried_diagram(job, **running)


def carried_diagram(job: DiagramJob, **running: Any) -> Diagram:
    """A job of a diagram carried out, item by item; what was interrupted is the `partial` of the error."""
    from percuss.explore.jobs.carrying_out import carry_out

    try:
        return Diagram.of(job, carry_out(job, **{"chunk": 1, **running}))
    except Interrupted as stop:
        if isinstance(stop.partial, dict):
            stop.partial = Diagram.of(job, stop.partial)
        raise
