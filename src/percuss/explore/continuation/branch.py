"""Branches and curves as values: the motions that were walked through, what happens on them, and where they end.

A branch goes over one parameter, a curve over two; either is of orbits z=p/n or of cycles with rest.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from enum import Enum
from functools import cached_property
from itertools import pairwise
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, Self

import numpy as np
import numpy.typing as npt

from percuss.errors import ParameterError, extra_package
from percuss.explore.jobs.archive_export import OfValues
from percuss.model.checks import Array, ComplexArray, choice
from percuss.short_repr import ShortRepr
from percuss.steady import PeriodicOrbit, RestCycle
from percuss.steady.multipliers import Repeating
from percuss.steady.self_excited.valve_cycle import ValveCycle

if TYPE_CHECKING:
    import xarray

# ---- What may happen: the kinds of points, with their words


class BranchEvent(Enum):
    """A kind of point on a branch or on a curve; its value is the word in files and tables.

    Examples
    --------
    >>> BranchEvent("cusp") is BranchEvent.CUSP, BranchEvent.CUSP.words
    (True, 'two folds meet and vanish: the curve has a cusp')
    """

    words: str

    def __new__(cls, word: str, words: str) -> Self:
        made = object.__new__(cls)
        made._value_, made.words = word, words
        return made

    # on a branch over one parameter
    FOLD = "fold", "a multiplier is 1: the branch turns back"
    FLIP = "flip", "a multiplier is −1: an orbit of twice the period begins"
    NEIMARK_SACKER = "neimark_sacker", "a pair of multipliers is on the unit circle"
    CROSSING = "branch_point", "a multiplier is 1, and another branch crosses this one"
    CORNER = "corner", "an impact meets a step of the load, or two events of a valve change places: there is a corner"
    NONSMOOTH_FOLD = "nonsmooth_fold", "the same, and the branch turns back"
    TOUCH = "grazing_touch", "the striking end touches the wall between two impacts"
    DEATH = "grazing_impact_dies", "an impact has no speed"
    STICKING = "sticking", "the striking end would rest on the wall after an impact (R = 0)"
    RESONANCE = "resonance", "a mode comes back after a cycle by itself, so that its amplitude is free"
    ONSET = "onset", "rest begins: the end of a chatter, or an impact before a rest, meets the next release"
    RELEASE_LOST = "release_lost", "the load no longer lets go"
    CHANGE = "label_changes", "the bar comes back to its release otherwise"

    # on a branch of a machine that switches its own valve
    ORDER_LOST = "order_lost", "two events of the valve exchange their order, and no cycle has the other one"
    PORT_LOST = "port_not_reached", "the piston turns just at a port that it passes: beyond, it does not reach it"
    PORT_TOUCH = "turning_at_port", "the piston turns just at a port that it does not pass: beyond, it passes it"
    PRESSURE_GONE = "pressure_gone", "the pressure of the supply falls to 0"
    STALL = "stall", "the cycle takes longer and longer: the machine comes to a standstill"

    # on a curve over two
    CUSP = "cusp", "two folds meet and vanish: the curve has a cusp"
    GENERALIZED_FLIP = "generalized_flip", "beyond, the doubled orbit begins towards the other side"
    WITH_FOLD = "with_fold", "another multiplier is 1: a curve of folds goes through here"
    WITH_FLIP = "with_flip", "another multiplier is −1: a curve of flips goes through here"
    RESONANCE_1 = "resonance_1_1", "a double multiplier 1: a curve of Neimark–Sacker points ends on one of folds"
    RESONANCE_2 = "resonance_1_2", "a double multiplier −1: a curve of Neimark–Sacker points ends on one of flips"
    RESONANCE_3 = "resonance_1_3", "the pair turns by 120° in a cycle: strong resonance"
    RESONANCE_4 = "resonance_1_4", "the pair turns by 90° in a cycle: strong resonance"
    RESONANT_GRAZING = "resonant_grazing", "the multiplier that grows without bound beside grazing changes its sign"
    FLAT_GRAZING = "flat_grazing", "the striking end has no acceleration where it grazes"
    WITH_TOUCH = "with_touch", "the striking end touches the wall in another place as well"
    WITH_DEATH = "with_death", "another impact has no speed"
    WITH_STICKING = "with_sticking", "the striking end would rest on the wall after an impact (R = 0)"
    WITH_CORNER = "with_corner", "an impact meets a step of the load, or two events of a valve change places"
    OTHER_CYCLE = "other_cycle", "beyond, what is let go does not come back as this cycle does"
    UNPRESSED = "unpressed", "the strain no longer presses the bar on the wall where its chatter ends"
    ENDLESS = "endless_chatter", "the chatter has more impacts than are followed: where R = 1 it has no end"

    # the ends of either
    HALVING = (
        "period_halving",
        "the orbit becomes one of half its period, at its flip: the curve would go back over itself",
    )
    COALESCENCE = "impacts_coalesce", "two impacts, or an impact and the touch, fall together"
    NO_PUSH = "load_stops_pushing", "the mean load is 0"
    NO_SYSTEM = "parameter_end", "a parameter goes no further"
    LIMIT = "limit", "the end of a range that was asked for"
    CLOSED = "closed", "the curve comes back to where it began"
    STOPPED = "stopped", "the following was stopped"
    LOST = "lost", "no further point of the curve was found"


def event_of(word: str) -> BranchEvent:
    """The kind of a word; ParameterError, with all the words, for anything else."""
    choice("kind", word, *(one.value for one in BranchEvent))
    return next(one for one in BranchEvent if one.value == word)


# ---- Points at which something happens


class PlainMotion(NamedTuple):
    """A motion as plain numbers: its label, phases and speeds of its impacts, and the mean energy of a blow."""

    label: str
    phases: Array
    speeds: Array
    energy: float


@dataclass(frozen=True)
class BranchPoint(ShortRepr):
    """A point of a branch or of a curve at which something happens.

    Parameters
    ----------
    kind
        What happens.
    values
        Of the parameter, to 1e-10 of it or better; of both on a curve over two.
    motion
        The orbit there, its impacts in the order of the branch, the cycle with rest, or that of a machine; on a branch
        of a diagram these as plain numbers, and None on a curve of ends of cycles with rest.
    beyond
        What lies beyond, in a sentence.
    multipliers
        Those of the orbit, largest modulus first; None where they grow without bound.
    impact
        Number, from 1 on, of the impact of the motion that dies or meets a step, after which the bar stays on the wall
        or, of a cycle with rest, that is born; or None.
    touch_phase
        Phase of the load at which the bar touches the wall; or None.
    side
        Towards which values of the parameter the branch begins that begins there, of flips and grazings: "greater" or
        "smaller"; None where there is none, or it is not resolved.
    criticality
        Of a flip: "supercritical" where the doubled orbit begins beside orbits that are no longer stable in this
        direction, else "subcritical"; None of other points, and where it is not resolved.
    """

    kind: BranchEvent
    values: tuple[float, ...]
    motion: PeriodicOrbit | RestCycle | ValveCycle | PlainMotion | None = field(repr=False)
    beyond: str
    multipliers: ComplexArray | None = field(default=None, repr=False)
    impact: int | None = None
    touch_phase: float | None = None
    side: str | None = None
    criticality: str | None = None

    @property
    def value(self) -> float:
        """Of the parameter, or of the first one."""
        return self.values[0]

    @property
    def orbit(self) -> PeriodicOrbit:
        """The orbit, of a branch or curve of such."""
        assert isinstance(self.motion, PeriodicOrbit)
        return self.motion

    @property
    def cycle(self) -> RestCycle:
        """The cycle with rest, of a branch of such."""
        assert isinstance(self.motion, RestCycle)
        return self.motion

    @property
    def valve_cycle(self) -> ValveCycle:
        """The cycle of a machine, of a branch of such."""
        assert isinstance(self.motion, ValveCycle)
        return self.motion

    @property
    def plain(self) -> PlainMotion:
        """The motion as plain numbers, of a branch of a diagram."""
        assert isinstance(self.motion, PlainMotion)
        return self.motion

    @property
    def plainly(self) -> BranchPoint:
        """The same with its motion as plain numbers: of a cycle with rest the impacts that its branch has."""
        motion, impact, touch = self.motion, self.impact, self.touch_phase
        if motion is None or isinstance(motion, PlainMotion):
            return self
        phases, speeds = motion.phases, motion.speeds
        if isinstance(motion, RestCycle):
            first = [one for chain in motion.chains for one in chain.impacts[:KEPT_IMPACTS]]
            phases, speeds = np.mod([one.time for one in first], _TURN), np.array([one.speed for one in first])
            dies = self.kind is BranchEvent.DEATH
            impact, touch = impact if dies else None, None if dies else touch
        plain = PlainMotion(motion.label, phases, speeds, motion.blow_energy)
        return replace(self, motion=plain, impact=impact, touch_phase=touch)

    def as_json(self) -> dict[str, Any]:
        """All of it as plain values."""
        one, motion = self.plainly, self.plainly.motion
        found = {name: getattr(one, name) for name in _OF_POINT} | {"kind": one.kind.value, "motion": None}
        if motion is not None:
            found["motion"] = [motion.label, motion.phases.tolist(), motion.speeds.tolist(), one.plain.energy]
        if one.multipliers is not None:
            found["multipliers"] = [one.multipliers.real.tolist(), one.multipliers.imag.tolist()]
        return found

    @classmethod
    def from_json(cls, row: Mapping[str, Any]) -> Self:
        """`as_json` backwards."""
        motion, values = row["motion"], row.get("multipliers")
        if motion is not None:
            motion = PlainMotion(motion[0], np.array(motion[1]), np.array(motion[2]), motion[3])
        made = None if values is None else np.array(values[0]) + 1j * np.array(values[1])
        plain = {name: row[name] for name in _OF_POINT if name != "values"}
        return cls(event_of(row["kind"]), tuple(row["values"]), motion, multipliers=made, **plain)

    def __str__(self) -> str:
        of = "" if self.motion is None else f" of {self.motion.label}"
        return f"{self.kind.value}{of} at {', '.join(f'{value:.12g}' for value in self.values)}: {self.beyond}"


# ---- Branches and curves


KEPT_IMPACTS = 8  # impacts after each release that a branch has, at most: those of a chatter have no last one
_TURN = 2.0 * np.pi
_OF_POINT = ("values", "beyond", "impact", "touch_phase", "side", "criticality")


class Doubling(NamedTuple):
    """A flip of a cascade: which orbit doubles there, the parameter, and the ratio of this interval to the next one."""

    label: str
    value: float
    ratio: float | None


def _nothing() -> Array:
    return np.empty(0)


@dataclass(frozen=True, kw_only=True)
class Branch(OfValues):
    """Motions of one label followed through a parameter, each of them `branch[i]`; made by `follow`, and in diagrams.

    Parameters
    ----------
    label, modes
        z=p/n, chatter/n or rest/n, the same all along; and N.
    values
        Of the parameter, along the branch: it may turn back. Shape (m,).
    points
        What happens, in order along the branch, its two ends first and last; of a closed one both are where it closes.
    times
        Times of the impacts in rad, unwrapped, in the order of the orbit that it was followed from: the first impact
        stays the same all along; shape (m, p). Of cycles with rest those of the first 8 impacts after each release, as
        a chatter has no last one: shape (m, rests, impacts), NaN where there are fewer.
    speeds
        Of the striking end just before these impacts; of the same shape.
    unstable
        How many multipliers are outside the unit circle, -1 where they grow without bound; shape (m,).
    releases, rests
        When the bar is let go, and when it comes to rest after that; shape (m, rests). Empty without rest.
    motions
        The motions themselves; none of a branch that was read, or of a diagram, whose motions are plain numbers.
    cycle_times
        Of machines that switch their own valve the duration of each cycle, whose `times` are those of the blows after
        the last one of the cycle before, in the unit of the machine; shape (m,). Empty of others.
    energies
        Mean kinetic energy just before a blow, of machines and in diagrams; NaN where it is not known. Shape (m,).
    recorded
        What was asked for by `record`, by name; each of shape (m,).
    scales
        Metres per second and joules of a speed and an energy of 1, in diagrams; shape (m, 2), None without units.
    possible
        Whether these are motions; if not, they are roots of the equations beyond an end of a branch.
    switched
        The branches that begin at its points, as far as they were asked for; the first point of each is that.
    """

    parameters: tuple[str, ...]
    label: str
    modes: int
    values: Array = field(repr=False)
    points: tuple[BranchPoint, ...]
    times: Array = field(default_factory=_nothing, repr=False)
    speeds: Array = field(default_factory=_nothing, repr=False)
    unstable: npt.NDArray[np.int64] = field(default_factory=lambda: np.empty(0, dtype=np.int64), repr=False)
    releases: Array = field(default_factory=_nothing, repr=False)
    rests: Array = field(default_factory=_nothing, repr=False)
    motions: tuple[Repeating, ...] = field(default=(), repr=False)
    cycle_times: Array = field(default_factory=_nothing, repr=False)
    energies: Array = field(default_factory=_nothing, repr=False)
    recorded: Mapping[str, Array] = field(default_factory=dict)
    scales: Array | None = field(default=None, repr=False)
    possible: bool = True
    switched: tuple[Branch, ...] = ()

    def __len__(self) -> int:
        return len(self.values)

    def __getitem__(self, number: int) -> Repeating | PlainMotion:
        if self.motions:
            return self.motions[number]
        energy = float(self.energies[number]) if self.energies.size else np.nan
        return PlainMotion(self.label, self.phases[number], self.speeds[number], energy)

    @cached_property
    def multipliers(self) -> ComplexArray:
        """Of each motion, largest modulus first, NaN where they grow without bound; shape (m, multipliers)."""
        found = [_multipliers(motion) for motion in self.motions]
        made = np.full((len(found), max((one.size for one in found), default=0)), np.nan, dtype=complex)
        for row, values in zip(made, found, strict=True):
            row[: values.size] = values
        return made

    # -- handed over --

    _PLAIN: ClassVar[tuple[str, ...]] = ("label", "modes", "possible")
    _ARRAYS: ClassVar[tuple[str, ...]] = (
        "values",
        "times",
        "speeds",
        "unstable",
        "releases",
        "rests",
        "cycle_times",
        "energies",
    )

    def as_json(self) -> dict[str, Any]:
        """All of it as plain values, its motions too."""
        return {
            **{name: getattr(self, name) for name in ("parameters", *self._PLAIN)},
            **{name: getattr(self, name).tolist() for name in self._ARRAYS},
            "scales": None if self.scales is None else self.scales.tolist(),
            "recorded": {name: values.tolist() for name, values in self.recorded.items()},
            "points": [point.as_json() for point in self.points],
            "switched": [one.as_json() for one in self.switched],
        }

    @classmethod
    def from_json(cls, row: Mapping[str, Any]) -> Self:
        """`as_json` backwards."""
        return cls(**cls._fields_of(row))

    @classmethod
    def _fields_of(cls, row: Mapping[str, Any]) -> dict[str, Any]:
        return {
            "parameters": tuple(row["parameters"]),
            **{name: row[name] for name in cls._PLAIN},
            **{name: np.array(row[name]) for name in cls._ARRAYS},
            "scales": None if row["scales"] is None else np.array(row["scales"]),
            "recorded": {name: np.array(values) for name, values in row["recorded"].items()},
            "points": tuple(map(BranchPoint.from_json, row["points"])),
            "switched": tuple(map(cls.from_json, row["switched"])),
        }

    def to_xarray(self) -> xarray.Dataset:
        """Its motions over the dimension ``point`` and what happens on it over ``event``; dimensionless."""
        flights = ("point", "impact") if self.times.ndim == 2 else ("point", "rest", "impact")
        columns = self.values.reshape(len(self), -1).T
        made: dict[str, Any] = {
            name: ("point", values, {"long_name": "the parameter"})
            for name, values in zip(self.parameters, columns, strict=True)
        }
        of_each = {"unstable": "multipliers outside the unit circle", "energies": "mean kinetic energy before a blow"}
        of_each |= {"cycle_times": "duration of the cycle"}
        for name, meaning in of_each.items():
            if len(values := getattr(self, name)) == len(self):
                made[name] = ("point", values, {"long_name": meaning})
        made |= {name: ("point", values) for name, values in self.recorded.items()}
        for name, meaning in (
            ("times", "of the impacts, rad of a load"),
            ("speeds", "of the striking end just before them"),
        ):
            if len(values := getattr(self, name)) == len(self):
                made[name] = (flights, values, {"long_name": meaning})
        if self.motions:
            about = {"long_name": "part of the multipliers, largest modulus first"}
            made["multipliers_real"] = (("point", "multiplier"), self.multipliers.real, about)
            made["multipliers_imag"] = (("point", "multiplier"), self.multipliers.imag, about)
        for i, name in enumerate(self.parameters):
            made[f"event_{name}"] = ("event", np.array([point.values[i] for point in self.points]))
        made["event_type"] = ("event", np.array([point.kind.value for point in self.points], dtype=object))
        made["event_beyond"] = ("event", np.array([point.beyond for point in self.points], dtype=object))
        told = {"kind": "branch", "label": self.label, "modes": self.modes}
        found: xarray.Dataset = extra_package("xarray", "io").Dataset(made, attrs=told)
        return found

    def recording(self, record: Mapping[str, Callable[[Any], float]]) -> Self:
        """The same with the values of functions of the motion, by name, and so those switched to."""
        if not record:
            return self
        kept = {name: np.array([told(one) for one in self.motions], dtype=float) for name, told in record.items()}
        return replace(self, recorded=kept, switched=tuple(one.recording(record) for one in self.switched))

    @property
    def parameter(self) -> str:
        """The name of the parameter, or of the first one."""
        return self.parameters[0]

    @property
    def has_rest(self) -> bool:
        """Whether it is of cycles with rest, of a hammer under a clock."""
        return not self.is_machine and self.label.startswith(("chatter", "rest"))

    @property
    def is_machine(self) -> bool:
        """Whether it is of machines that switch their own valve: labels are blows and valve cycles then."""
        return self.cycle_times.size > 0

    @property
    def impacts(self) -> int:
        """p, of orbits z=p/n."""
        return int(self.times.shape[1])

    @property
    def periods(self) -> int:
        """n."""
        return int(self.label.rpartition("/")[2])

    @property
    def phases(self) -> Array:
        """Phases of the load at the impacts, in [0, 2π), or of the cycle of a machine; of the shape of `times`."""
        return np.mod(self.times if not self.is_machine else _TURN * self.times / self.cycle_times[:, None], _TURN)

    @property
    def release_phases(self) -> Array:
        """Phases of the load at which the bar is let go; shape (m, rests)."""
        return np.mod(self.releases, _TURN)

    @property
    def rest_phases(self) -> Array:
        """Phases of the load at which the bar comes to rest; shape (m, rests)."""
        return np.mod(self.rests, _TURN)

    @property
    def rest_times(self) -> Array:
        """The shortest rest of each cycle, in rad of the load; shape (m,)."""
        return np.array([cycle.rest_times.min() for cycle in self.cycles])

    @property
    def cycles(self) -> tuple[RestCycle, ...]:
        """Those of `motions` that are cycles with rest."""
        return tuple(one for one in self.motions if isinstance(one, RestCycle))

    @property
    def stable(self) -> npt.NDArray[np.bool_]:
        """Whether no multiplier is outside the unit circle; shape (m,)."""
        return np.asarray(self.unstable == 0)

    @property
    def ends(self) -> tuple[BranchPoint, BranchPoint]:
        """Its first and its last point."""
        return self.points[0], self.points[-1]

    def at(self, kind: BranchEvent | str) -> tuple[BranchPoint, ...]:
        """The points of a kind, which may be told by its word; ParameterError for an unknown one."""
        wanted = kind if isinstance(kind, BranchEvent) else event_of(kind)
        return tuple(point for point in self.points if point.kind is wanted)

    def releases_at(self, value: float) -> list[float]:
        """The first releases of its cycles with rest at a value, straight between the points."""
        return [float(release) for release in self._between(value, np.unwrap(self.releases[:, 0]))]

    def times_at(self, value: float) -> list[Array]:
        """The times of the impacts where it has a value of the parameter, straight between its points."""
        return self._between(value, self.times)

    def speeds_at(self, value: float) -> list[Array]:
        """The same of their speeds."""
        return self._between(value, self.speeds)

    def _between(self, value: float, rows: Array) -> list[Array]:
        off = self.values - value
        found = [rows[i] for i in np.flatnonzero(off == 0.0).tolist()]
        for i in np.flatnonzero(off[:-1] * off[1:] < 0.0).tolist():
            share = off[i] / (off[i] - off[i + 1])
            found.append((1.0 - share) * rows[i] + share * rows[i + 1])
        return found

    def family(self) -> Iterator[Branch]:
        """This branch and all that were switched to from it."""
        yield self
        for branch in self.switched:
            yield from branch.family()

    @property
    def cascade(self) -> tuple[Doubling, ...]:
        """The longest chain of flips, each of the branch that begins at the one before.

        Where the period doubles without end the ratios of the intervals tend to 4.669 (Feigenbaum, J. Stat. Phys. 19
        (1978) 25–52).
        """
        chain = _chain(self)
        gaps = [first - second for (_, first), (_, second) in pairwise(chain)]
        ratios = [None, *(first / second if second else None for first, second in pairwise(gaps)), None]
        return tuple(Doubling(label, value, ratio) for (label, value), ratio in zip(chain, ratios, strict=False))

    def __str__(self) -> str:
        columns = self.values.reshape(len(self.values), -1).T
        pairs = zip(self.parameters, columns, strict=True)
        over = ", ".join(f"{name} {row.min():.9g} to {row.max():.9g}" for name, row in pairs)
        head = f"{self.label}: {len(self.values)} points, {over}, {self.modes} modes"
        return "\n".join([head, *(f"  {point}" for point in self.points)])


def recorded(record: object) -> dict[str, Callable[[Any], float]]:
    """Functions of a motion by name, or an error."""
    found = {} if record is None else record
    if not isinstance(found, Mapping) or not all(isinstance(key, str) and callable(found[key]) for key in found):
        raise ParameterError("record", str(record), "functions of the motion, by name")
    return dict(found)


def _multipliers(motion: Repeating) -> ComplexArray:
    try:
        return motion.judged().values
    except (ParameterError, np.linalg.LinAlgError):  # an event without speed, or too many modes
        return np.full(1, np.nan, dtype=complex)


def _chain(branch: Branch) -> list[tuple[str, float]]:
    """Labels and flips of the longest cascade from a branch on."""
    longer = [
        [(branch.label, child.points[0].value), *_chain(child)]
        for child in branch.switched
        if child.points[0].kind is BranchEvent.HALVING
    ]
    last = [[(branch.label, point.value)] for point in branch.at(BranchEvent.FLIP)[:1]]
    return max([*longer, *last], key=len, default=[])


@dataclass(frozen=True, kw_only=True)
class PointCurve(Branch):
    """Motions over two parameters that are all folds, flips, grazings, onsets …; made by `follow_point`.

    A `Branch` with the names of both `parameters`, and their `values` in the shape (m, 2).

    Parameters
    ----------
    event
        What they are.
    is_orbit
        Where the motion is possible otherwise; elsewhere it touches the wall in another place, strikes backwards or,
        let go from rest, comes back otherwise. Shape (m,).
    angles
        Of the multipliers on the unit circle, in rad: 0 for folds, π for flips; NaN for others. Shape (m,).
    event_phases
        Of ends of cycles with rest, when they end: the release that the rest meets, the touch, the least load; shape
        (m,). The bar whose way ends so is let go at `release_phases`, of the same shape.
    units
        Of both parameters; empty for plain numbers.
    """

    event: BranchEvent
    is_orbit: npt.NDArray[np.bool_] = field(repr=False)
    angles: Array = field(default_factory=_nothing, repr=False)
    event_phases: Array = field(default_factory=_nothing, repr=False)
    units: tuple[str, ...]

    _ARRAYS = (*Branch._ARRAYS, "is_orbit", "angles", "event_phases")

    def as_json(self) -> dict[str, Any]:
        """All of it as plain values, its motions too."""
        return {**super().as_json(), "event": self.kind, "units": self.units}

    @classmethod
    def _fields_of(cls, row: Mapping[str, Any]) -> dict[str, Any]:
        return {**super()._fields_of(row), "event": event_of(row["event"]), "units": tuple(row["units"])}

    @property
    def kind(self) -> str:
        """The word of what they are."""
        return str(self.event.value)

    @property
    def real(self) -> Array:
        """`values`, NaN where the motion is none; shape (m, 2)."""
        return np.where(self.is_orbit[:, None], self.values, np.nan)

    def __str__(self) -> str:
        return f"{self.kind} of {super().__str__()}"
