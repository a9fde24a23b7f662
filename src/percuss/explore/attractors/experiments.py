"""Random starts and where they end: shares of the attractors, the same for any number of workers."""

from __future__ import annotations

import math
import os
from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field, fields, replace
from functools import cached_property
from statistics import NormalDist
from typing import TYPE_CHECKING, Any, Self

import numpy as np
import numpy.typing as npt

from percuss._version import __version__
from percuss.errors import ParameterError, extra_package
from percuss.explore.attractors.drawn_starts import (
    DISTRIBUTIONS,
    done,
    drawn,
    fingerprint,
    named,
    own,
    start_columns,
    start_values,
    starts_from,
)
from percuss.explore.attractors.hammers import DISTANCE, Attractor, Hammer, StartTally, hammer_of, seconds_of_start
from percuss.explore.jobs.archive_export import OfColumns, variables_of
from percuss.explore.jobs.job import ASK_FORMAT, Column, Columns
from percuss.model import Machine, System
from percuss.model.checks import DEFAULT_MODES, count, finite, instance, non_negative
from percuss.model.described import machine_from, system_from
from percuss.short_repr import ShortRepr

if TYPE_CHECKING:
    import xarray

    from percuss.simulate import Starts, Stop


# ---- What an experiment carries out: each start followed by itself, the same in any process

DEFAULT_STARTS = 100_000
_MOST_STARTS = 10**12


@dataclass(frozen=True, eq=False)
class StartsJob(ABC):
    """Starts, each followed by itself, on any number of `threads`; `asked`: kind of job, and what they depend on."""

    system: System | Machine
    modes: int
    stop: Stop
    threads: int | None

    @cached_property
    def hammer(self) -> Hammer:
        """What is followed, as it is asked."""
        return hammer_of(self.system)

    @property
    @abstractmethod
    def size(self) -> int:
        """Number of starts."""

    @abstractmethod
    def starts(self, first: int, last: int) -> Starts:
        """The starts `first` … `last` − 1, made where they are needed."""

    @property
    @abstractmethod
    def amplitudes(self) -> tuple[int, int]: ...

    @property
    @abstractmethod
    def asked(self) -> dict[str, Any]: ...

    @property
    def rough_seconds(self) -> float:
        """What all starts take, by rule of thumb."""
        return self.size * seconds_of_start(self.modes, clock=not self.hammer.states)

    @property
    def columns(self) -> Mapping[str, Column]:
        """The numbers of the motions, and the starts."""
        return {**start_columns(*self.amplitudes, not self.hammer.states), **self.hammer.columns}

    @property
    def ask(self) -> dict[str, Any]:
        """What the numbers depend on."""
        about = {"percuss": ASK_FORMAT, **self.hammer.described, "modes": self.modes, "stop": asdict(self.stop)}
        return {**about, **self.asked}

    def compute(self, first: int, last: int, stopped: Callable[[], bool]) -> Columns:
        """The motions from starts `first` … `last` − 1."""
        part = self.starts(first, last)
        return {**start_values(part), **self.hammer.followed(part, self.modes, self.stop, self.threads, stopped)}


def checked_question(system: System | Machine, modes: int, stop: Stop | None) -> tuple[Hammer, int, Stop]:
    """What any starts are followed with: a resonance is an error here, not in a worker."""
    from percuss.simulate import Stop

    hammer, kept = hammer_of(system), count("modes", modes, least=0, most=4096)
    stop = Stop() if stop is None else instance("stop", stop, Stop)
    count("impacts", stop.impacts)
    hammer.check(kept)
    return hammer, kept, stop


@dataclass(frozen=True, eq=False)
class ExperimentJob(StartsJob):
    """The starts of one experiment; see `experiment`. `rows`: one's own starts, or None for a named distribution."""

    number: int
    distribution: str
    seed: int
    rows: Starts | None = None

    @property
    def size(self) -> int:
        return self.number

    def starts(self, first: int, last: int) -> Starts:
        if self.rows is None:
            return named(self.system, self.distribution, last - first, self.seed, first)
        if self.number > len(self.rows):
            return drawn(self.rows, last - first, self.seed, first)
        return self.rows[first:last]

    @property
    def amplitudes(self) -> tuple[int, int]:
        bars = self.rows
        return (1, 1) if bars is None else (bars.displacement.shape[1], bars.velocity.shape[1])

    @property
    def asked(self) -> dict[str, Any]:
        found = {"kind": "experiment", "starts": self.number, "distribution": self.distribution, "seed": self.seed}
        return found if self.rows is None else {**found, "rows": fingerprint(self.rows)}


def experiment_job(
    system: System | Machine,
    starts: int | None = None,
    distribution: str | os.PathLike[str] | Starts | Callable[[int], Starts] = "wall",
    seed: int = 0,
    *,
    modes: int = DEFAULT_MODES,
    stop: Stop | None = None,
    threads: int | None = 1,
) -> ExperimentJob:
    """What `experiment` carries out."""
    from percuss.simulate import Starts

    _, kept, stop = checked_question(system, modes, stop)
    seed = count("seed", seed, least=0)
    number = None if starts is None else count("starts", starts, most=_MOST_STARTS)
    if isinstance(distribution, str) and distribution in DISTRIBUTIONS:
        named(system, distribution, 1, seed)  # refuses what cannot be drawn now, not in a worker
        return ExperimentJob(system, kept, stop, threads, number or DEFAULT_STARTS, distribution, seed)
    rows = own(system, distribution, seed)
    if rows.displacement[:, kept + 1 :].any() or rows.velocity[:, kept + 1 :].any():
        most = max(rows.displacement.shape[1], rows.velocity.shape[1]) - 1
        raise ParameterError("distribution", f"amplitudes of {most} modes", f"at most {kept}", "use more modes")
    if isinstance(distribution, Starts):
        name = "starts"
    elif callable(distribution):
        name = str(getattr(distribution, "__qualname__", type(distribution).__name__))
    else:
        name = os.path.basename(os.fspath(distribution))
    return ExperimentJob(system, kept, stop, threads, number or len(rows), name, seed, rows)


# ---- Shares of attractors among random starts, with intervals

CONFIDENCE = 0.95


def wilson(successes: int, trials: int, confidence: float = CONFIDENCE) -> tuple[float, float]:
    """Wilson's interval from counts; (0, 1) when nothing was tried (J. Am. Stat. Assoc. 22 (1927) 209–212)."""
    n, k = count("trials", trials, least=0), count("successes", successes, least=0)
    c = finite("confidence", confidence)
    if k > n:
        raise ParameterError("successes", successes, f"at most the number of trials, {n}")
    if not 0.0 < c < 1.0:
        raise ParameterError("confidence", confidence, "a number between 0 and 1")
    if n == 0:
        return 0.0, 1.0
    z = NormalDist().inv_cdf(0.5 + 0.5 * c)
    share, fade = k / n, z * z / n
    middle = (share + 0.5 * fade) / (1.0 + fade)
    half = z / (1.0 + fade) * math.sqrt(share * (1.0 - share) / n + 0.25 * fade / n)
    return (0.0 if k == 0 else max(middle - half, 0.0)), (1.0 if k == n else min(middle + half, 1.0))


@dataclass(frozen=True)
class Share(ShortRepr):
    """The share of the starts that ends in an attractor, and Wilson's interval of 95 % of its probability."""

    attractor: Attractor
    share: float
    low: float
    high: float

    @property
    def label(self) -> str:
        """The label of the motion, as `Trajectory.label` gives it."""
        return self.attractor.label

    @property
    def members(self) -> int:
        """How many starts end there."""
        return self.attractor.members

    @property
    def phases(self) -> tuple[float, ...]:
        """Load phases (rad) of the impacts of one cycle, from the fastest on; empty without a period or a clock."""
        return tuple(self.attractor.figures.get("phases", ()))

    @property
    def impact_velocities(self) -> tuple[float, ...]:
        """Striking speeds of the same."""
        return tuple(self.attractor.figures["impact_velocities"])

    def __str__(self) -> str:
        return f"{self.label}: {self.share:.4%} ({self.low:.4%} … {self.high:.4%})"


# ---- What starts end in, drawn by chance or over a plane


@dataclass(frozen=True, eq=False, kw_only=True)
class StartsFollowed(OfColumns):
    """Starts followed, a row of `columns` each (code −1: not done), and what they settle on, apart by `distance`."""

    system: System | Machine
    modes: int
    stop: Stop
    ask: dict[str, Any] = field(repr=False)
    columns: Columns = field(repr=False)
    distance: float = DISTANCE

    @classmethod
    def of(cls, job: Any, columns: Columns, distance: float = DISTANCE) -> Self:
        """The result of a job."""
        own = ("columns", "distance", "tally")
        asked = {one.name: getattr(job, one.name) for one in fields(cls) if one.name not in own}
        return cls(columns=columns, distance=distance, **asked)

    @staticmethod
    def _asked_in(ask: Mapping[str, Any]) -> dict[str, Any]:
        from percuss.simulate import Stop

        what = machine_from(ask["machine"]) if "machine" in ask else system_from(ask["system"])
        return {"ask": dict(ask), "system": what, "modes": int(ask["modes"]), "stop": Stop(**ask["stop"])}

    @cached_property
    def hammer(self) -> Hammer:
        """What was followed, as it is asked."""
        return hammer_of(self.system)

    @cached_property
    def known(self) -> Columns:
        """The columns of the starts that are done."""
        whole = done(self.columns)
        return self.columns if whole.all() else {name: values[whole] for name, values in self.columns.items()}

    @cached_property
    def numbers(self) -> npt.NDArray[np.int64]:
        """The number of the attractor of each of them, 0 for the most frequent."""
        return self.counted.numbers(self.known)

    @cached_property
    def counted(self) -> StartTally:
        """How many starts settle on what."""
        tally = StartTally(self.hammer, self.distance)
        tally.add(0, self.columns)
        return tally

    @cached_property
    def attractors(self) -> tuple[Attractor, ...]:
        """The attractors, the most frequent first."""
        return self.hammer.attractors(self.counted, self.modes, self.stop)

    @cached_property
    def shares(self) -> tuple[Share, ...]:
        """The share of each attractor, with 95 % intervals, most frequent first (a plane is no random sample)."""
        number = int(self.counted.members.sum())
        return tuple(Share(one, one.members / number, *wilson(one.members, number)) for one in self.attractors)

    def _si_of(self, name: str) -> dict[str, Any]:
        """What a column is to be multiplied by for SI, and the unit that it then has; nothing without scales."""
        return dict(zip(("si_scale", "si_units"), self.hammer.scales.get(name, ()), strict=False))

    @property
    def _about(self) -> Mapping[str, Column]:
        clock = not self.hammer.states
        known = {**start_columns(2, 2, clock), **start_columns(1, 1, clock), **self.hammer.columns}
        return {name: replace(known[name], shape=values.shape[1:]) for name, values in self.columns.items()}

    def _dataset_over(
        self, dims: tuple[str, ...], number: npt.NDArray[np.int64], about: dict[str, Any], but: tuple[str, ...] = ()
    ) -> xarray.Dataset:
        """Columns and their attractors as a dataset, dimensionless; in SI with `si_scale` and `si_units` besides."""
        hammer, columns = self.hammer, self._about
        inner = {name: f"{name}_mode" for name in ("start_displacement", "start_velocity")}
        told = {"attractor_number": (dims, number, {"long_name": "attractor that the motion settles on"})}
        arrays = {name: values for name, values in self.columns.items() if name not in but}
        variables = told | variables_of(
            columns, arrays, dims, number.shape, {**inner, "invariants": "invariant"}, hammer.words
        )
        for name in arrays:
            attributes = variables[name][2]
            attributes |= self._si_of(name)
            if not columns[name].unit and columns[name].dtype == "float64":
                attributes["comment"] = "dimensionless"
        meanings = {"label": "motion", "share": "part of the starts", "low": "its interval", "high": "its interval"}
        for name, meaning in meanings.items():
            found = np.array([getattr(share, name) for share in self.shares])
            key = name if name == "share" else f"attractor_{name}"
            variables[key] = ("attractor", found, {"long_name": meaning})
        attributes = {**about, "modes": self.modes, hammer.kind: str(self.system), **hammer.about}
        attributes["percuss_version"] = __version__
        attractors = {"attractor": np.arange(len(self.shares))}
        made: xarray.Dataset = extra_package("xarray", "io").Dataset(variables, attractors, attributes)
        return made


KEPT_STARTS = 1_000_000  # of which the columns of an experiment are kept in memory, unless asked otherwise


class _Followed:
    """What takes the starts of an experiment: all are counted, and the first `rows` are kept."""

    def __init__(self, hammer: Hammer, items: Any, distance: float, rows: int) -> None:
        from percuss.explore.jobs.carrying_out import Sheet

        self.tally, self._sheet = StartTally(hammer, distance), Sheet(items, rows)
        self.columns = self._sheet.columns

    def put(self, first: int, columns: Columns) -> None:
        self.tally.add(first, columns)
        self._sheet.put(first, columns)


@dataclass(frozen=True, eq=False, kw_only=True)
class Experiment(StartsFollowed):
    """The results of random starts; made by `experiment`.

    Parameters
    ----------
    system, modes, stop
        What was followed.
    distribution, seed
        What the starts were drawn from, and with.
    columns
        One row for each start, or for the first of very many: the start, how it ended and the numbers of its motion;
        see `to_xarray`.
    tally
        How many of all starts settle on what; None where all of them have rows.
    distance
        What tells attractors of one label apart; see `percuss.explore.attractors.hammers.Hammer.matched`.
    """

    distribution: str
    seed: int
    tally: StartTally | None = field(default=None, repr=False)

    @classmethod
    def from_archive(cls, archive: Any, rows: int = KEPT_STARTS) -> Experiment:
        """The experiment that an archive holds, of those starts that are done; with the columns of the first `rows`."""
        into = _Followed(hammer_of(cls._asked_in(archive.ask)["system"]), archive, DISTANCE, rows)
        for first, _, columns in archive.parts():
            into.put(first, columns)
        return replace(cls.of_done(archive.ask, into.columns), tally=into.tally)

    @classmethod
    def of_done(cls, ask: Mapping[str, Any], columns: Columns, distance: float = DISTANCE) -> Experiment:
        """What was asked for, of those starts that are done."""
        kept = {name: np.asarray(values)[done(columns)] for name, values in columns.items()}
        told = {"distribution": ask["distribution"], "seed": int(ask["seed"]), "distance": distance}
        return cls(columns=kept, **told, **cls._asked_in(ask))

    def __len__(self) -> int:
        return int(self.counted.members.sum())

    @cached_property
    def counted(self) -> StartTally:
        """How many starts settle on what."""
        return super().counted if self.tally is None else self.tally

    @property
    def starts(self) -> Starts:
        """The starts that have rows."""
        return starts_from(self.columns, self.hammer.states)

    @property
    def attractor(self) -> npt.NDArray[np.int64]:
        """The number of the attractor of each start that has a row, 0 for the most frequent."""
        return self.numbers

    @cached_property
    def label(self) -> npt.NDArray[np.str_]:
        """What motion each start that has a row ends in, as `Trajectory.label`."""
        return self.hammer.labels(self.columns)

    @cached_property
    def labels(self) -> dict[str, tuple[float, float, float]]:
        """Share, lower and upper end of its interval for each label, the most frequent first."""
        found: Counter[str] = Counter()
        for attractor in self.attractors:
            found[attractor.label] += attractor.members
        return {name: (k / len(self), *wilson(k, len(self))) for name, k in found.most_common()}

    @property
    def _rest(self) -> int:
        """How many starts have no rows."""
        return len(self) - int(np.count_nonzero(done(self.columns)))

    def _content(self) -> xarray.Dataset:
        if self._rest:
            remedy = f"ask for rows={len(self)}, or keep an archive, which holds all"
            raise ParameterError("rows", len(self) - self._rest, f"all {len(self)} starts in a file", remedy)
        return super()._content()

    def to_xarray(self) -> xarray.Dataset:
        """All columns over the dimension ``start``, and the attractors over ``attractor``, with units and meanings."""
        title = f"percuss experiment: {len(self)} starts, {self.distribution}, seed {self.seed}"
        about = {"title": title, "distribution": self.distribution, "seed": self.seed}
        about |= {"starts_without_rows": self._rest} if self._rest else {}
        return self._dataset_over(("start",), self.attractor, about)

    def to_json_dict(self) -> dict[str, Any]:
        """What ``percuss experiment --json`` prints: plain numbers, the most frequent attractor first."""
        return {
            "starts": len(self),
            "seed": self.seed,
            "distribution": self.distribution,
            "modes": self.modes,
            "shares": [
                {
                    **{name: getattr(share, name) for name in ("label", "share", "low", "high")},
                    **share.attractor.figures,
                }
                for share in self.shares
            ],
        }

    def __str__(self) -> str:
        head = f"Experiment: {len(self)} starts, {self.distribution}, seed {self.seed}, {self.modes} modes"
        return "\n".join([head, *(f"  {share}" for share in self.shares)])


def carried_experiment(
    job: ExperimentJob, distance: float = DISTANCE, rows: int = KEPT_STARTS, **running: Any
) -> Experiment:
    """A job of an experiment carried out; see `experiment`."""
    from percuss.explore.jobs.carrying_out import carried_into

    into = _Followed(job.hammer, job, distance, rows)
    return replace(Experiment.of(job, carried_into(into, job, **running), distance), tally=into.tally)


def experiment(
    system: System | Machine,
    starts: int | None = None,
    distribution: str | os.PathLike[str] | Starts | Callable[[int], Starts] = "wall",
    seed: int = 0,
    *,
    modes: int = DEFAULT_MODES,
    stop: Stop | None = None,
    distance: float = DISTANCE,
    rows: int = KEPT_STARTS,
    **running: Any,
) -> Experiment:
    """Follow random starts to what they settle on; the shares of the attractors, with intervals.

    The same seed gives the same numbers to the last bit, whatever the number of workers. Starts beyond `rows` are
    counted and forgotten: memory does not grow with their number.

    Parameters
    ----------
    system
        What moves, dimensionless: a system whose load keeps time, or a machine that switches its own valve.
    starts
        How many; 100 000 by default, or as many as one's own distribution has rows.
    distribution
        ``wall``, ``field`` or ``gentle`` (see `percuss.explore.attractors.drawn_starts.named`), a file of starts,
        `Starts`, or a function that makes them from the seed. More starts than there are rows are
        drawn from them by chance.
    seed
        0 or greater.
    modes
        N, the elastic modes kept; 0 is the rigid bar.
    stop
        When a motion ends; by default after 2000 impacts or when a periodic motion is found. See
        `percuss.simulate.Stop` for its tolerance.
    distance
        How far apart motions of one label are different attractors (radians, relative periods and speeds).
    rows
        Of how many starts, from the first on, the columns are given, some 200 bytes each; an archive keeps them of all.
    running
        ``workers``, ``archive``, ``resume``, ``chunk``, ``pool``, ``progress`` as `percuss.explore.carry_out` has them.

    Returns
    -------
    Experiment
        With `shares`, the columns of the starts by `to_xarray`, and `to_json_dict`.

    Raises
    ------
    ParameterError
        For numbers out of range, an unknown distribution or a file that holds no starts.
    ResonanceError
        When a harmonic of the load meets an undamped elastic mode.

    Examples
    --------
    >>> from percuss import Load, System
    >>> system = System(s=20.0, d=0.0, restitution=0.6, load=Load.harmonic(0.7, 1.0))
    >>> found = experiment(system, 500, "wall", seed=1, modes=0, workers=1)
    >>> [share.label for share in found.shares]
    ['chatter/1', 'z=2/2']
    """
    job = experiment_job(system, starts, distribution, seed, modes=modes, stop=stop)
    apart = non_negative("distance", distance)
    return carried_experiment(job, apart, count("rows", rows, least=0, most=_MOST_STARTS), **running)
