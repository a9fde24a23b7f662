"""The best hammer within ranges: any figure of the whole hammer, under limits of any others."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from percuss.case.answers.exploring.best_answer import range_end, ranged_keys, sizes
from percuss.case.answers.exploring.comparison import Comparison, compare
from percuss.case.answers.facts import BAD, GOOD, PLAIN, Grid, Report, ReportSection, json_number, number, picked
from percuss.case.answers.whole_hammer import WHOLE_FIGURES, whole_figure
from percuss.case.case import checked_case
from percuss.case.parameters.case_family import CaseFamily
from percuss.case.parameters.moves import parsed_quantity
from percuss.case.parameters.spans import Span, own_value, rounded
from percuss.errors import Interrupted, ParameterError, PercussError
from percuss.model.checks import Array, callback, choice, count, finite, flag, instance, several, text
from percuss.optimum import Candidate, SearchProgress, best_place
from percuss.short_repr import ShortRepr

if TYPE_CHECKING:
    from percuss.case.answers.whole_hammer import WholeFigure, WholeHammer
    from percuss.case.case import Case

_COARSE = 4  # elastic modes while places are looked for; the polish, and all figures told, have those asked for

_NEAR = 200  # of the last that ran, to look for the cycle of the next one near the nearest of them

_BINDS = 1e-4  # share of a limit within which it binds

_MISSED = 1e-6  # share of a limit that rounding makes


@dataclass(frozen=True)
class Limit:
    """What a figure of a hammer must keep to, in base units of SI or dimensionless; None: no end there."""

    figure: str
    low: float | None = None
    high: float | None = None

    def __post_init__(self) -> None:
        whole_figure(text("figure", self.figure))
        for name in ("low", "high"):
            if getattr(self, name) is not None:
                object.__setattr__(self, name, finite(name, getattr(self, name)))
        ends = [end for end in (self.low, self.high) if end is not None]
        if not ends or (len(ends) == 2 and not ends[0] < ends[1]):
            raise ParameterError(self.figure, ends, "a least value, a greatest one, or both, the smaller one first")

    @classmethod
    def parsed(cls, words: str, sense: str, is_si: bool) -> Limit:
        """From ``FIGURE=VALUE`` that is to be `below` or `above`, or from ``FIGURE=LOW..HIGH`` (`want`).

        Examples
        --------
        >>> Limit.parsed("steel.stress=250MPa", "below", True)
        Limit(figure='steel.stress', low=None, high=250000000.0)
        >>> Limit.parsed("blow_rate=60..70 Hz", "want", True)
        Limit(figure='blow_rate', low=60.0, high=70.0)
        """
        choice("sense", sense, "want", "below", "above")
        name, sign, value = (word.strip() for word in text("words", words).partition("="))
        figure = whole_figure(name)
        low, dots, high = (word.strip() for word in value.partition(".."))
        if not sign or not value or bool(dots) != (sense == "want"):
            told = "FIGURE=LOW..HIGH" if sense == "want" else "FIGURE=VALUE"
            raise ParameterError(sense, words, told, "such as blow_rate=60..70Hz" if sense == "want" else "")
        if dots and not parsed_quantity(low)[1]:
            low = f"{low} {parsed_quantity(high)[1]}".strip()
        ends = [figure.given(name, one, flag("is_si", is_si)) for one in (low, high) if one]
        if sense == "want":
            return cls(name, *ends)
        return cls(name, high=ends[0]) if sense == "below" else cls(name, low=ends[0])


def _slacks(limit: Limit, value: float) -> tuple[float, ...]:
    """How far a value is inside each end, as a share of it; negative beyond."""
    ends = [(end, sign) for end, sign in ((limit.low, 1.0), (limit.high, -1.0)) if end is not None]
    return tuple(sign * (value - end) / (abs(end) or 1.0) for end, sign in ends)


def _words(limit: Limit, is_si: bool) -> str:
    figure = whole_figure(limit.figure)
    low, high = (None if end is None else figure.tell(end, is_si) for end in (limit.low, limit.high))
    if low is not None and high is not None:
        return f"{low} to {high}"
    return f"at most {high}" if low is None else f"at least {low}"


@dataclass(frozen=True)
class DesignAnswer(ShortRepr):
    """The best hammer that was found, beside the case as it is.

    Attributes
    ----------
    figure, greatest
        What was looked for the most of, or the least.
    limits, spans
        What it must keep to, and what may vary.
    values, own_values
        What the best has there, and the case (None where it has nothing), in the units of the spans.
    comparison
        The case (A) and the best (B), each with its answer.
    hammers, seed
        How many were computed, and with which random numbers.
    complete
        Whether the search came to its end; false where `progress` ended it.
    lacking
        How many of them ran, and had no such figure: it takes one blow that reaches the tool.
    """

    figure: str
    greatest: bool
    limits: tuple[Limit, ...]
    spans: tuple[Span, ...]
    values: tuple[float, ...]
    own_values: tuple[float | None, ...]
    comparison: Comparison
    hammers: int
    seed: int
    complete: bool
    lacking: int

    @property
    def case(self) -> Case:
        """The best one, to be saved."""
        return self.comparison.cases[1]

    @property
    def best(self) -> WholeHammer:
        """In its own answer, with all modes."""
        return self.comparison.answers[1].whole

    @cached_property
    def excess(self) -> dict[str, float]:
        """By how much the best is beyond its limits, as shares of them; only those that it does not keep."""
        found: dict[str, float] = {}
        for limit in self.limits:
            value = self.best.value(limit.figure)
            over = 1.0 if value is None else max(-slack for slack in _slacks(limit, value))
            if over > _MISSED:
                found[limit.figure] = max(over, found.get(limit.figure, 0.0))
        return found

    @property
    def allowed(self) -> bool:
        """Whether it runs and keeps all limits."""
        return self.best.runs and not self.excess

    @property
    def binding(self) -> tuple[str, ...]:
        """The figures that stand at a limit."""
        values = [(limit, self.best.value(limit.figure)) for limit in self.limits]
        near = (one.figure for one, x in values if x is not None and min(map(abs, _slacks(one, x))) < _BINDS)
        return tuple(dict.fromkeys(near))

    @property
    def ends(self) -> dict[str, str]:
        """Of what stands at an end of its range, which: lower or upper."""
        return {s.name: end for s, x in zip(self.spans, self.values, strict=True) if (end := range_end(s, x))}

    @property
    def summary(self) -> str:
        """The answer in a sentence or two."""
        told = self._told()
        return told if self.complete else f"{told} The search was interrupted: this is the best so far."

    def _told(self) -> str:
        row = next((row for row in self.comparison.figures if row.name == self.figure), None)
        if not self.best.runs or row is None or row.values[1] is None:
            return f"No hammer found within these ranges runs; of the nearest: {self.best.stopped}."
        value, change = row.figure.tell(row.values[1], row.is_si), row.changes[1]
        if self.excess:
            worst = max(self.excess, key=lambda name: self.excess[name])
            label, has = whole_figure(worst).label, self._tell(worst, 1)
            asked = " and ".join(_words(limit, row.is_si) for limit in self.limits if limit.figure == worst)
            others = [name for name in self.excess if name != worst]
            rest = f"{', '.join(others)} missed, too" if others else "all others are kept"
            over = number(100.0 * self.excess[worst], 3)
            return (
                "No hammer found within these ranges keeps all limits. Of the one that misses them by the least, "
                f"{worst} costs most: {label} {has}, {asked} wanted, missed by {over} %; {rest}."
            )
        parts = [f"The best hammer found: {row.label} {value}"]
        if change is not None and self.comparison.runs[0]:
            parts[0] += f", {100.0 * change:+.1f} %"
        parts += [f"at its limits: {', '.join(self.binding)}"] if self.binding else []
        parts += [f"{name} stands at the {which} end of its range" for name, which in self.ends.items()]
        return f"{'; '.join(parts)}."

    def plane(self, across: int = 25, progress: Callable[[SearchProgress], object] | None = None) -> DesignPlane:
        """The hammers of the first two ranges, the others as in the best one: which keep the limits, what others miss.

        Each has four elastic modes, as in the search.

        Parameters
        ----------
        across
            Hammers along each range.
        progress
            As of `design`.

        Raises
        ------
        Interrupted
            When `progress` ended it.
        ParameterError
            With one range.
        """
        across = count("across", across, 2, 1000)
        callback("progress", progress)
        if len(self.spans) < 2:
            raise ParameterError("vary", self.spans[0].name, "two ranges or more, for a plane of the first two")
        tried = _Tried(self.comparison.cases[0], self.spans, self.figure, self.limits)
        x, y = (np.linspace(span.low, span.high, across) for span in self.spans[:2])
        values, missed = np.full((across, across), np.nan), np.full((across, across), len(self.limits))
        whose = [k for k, limit in enumerate(self.limits) for _ in _slacks(limit, 0.0)]
        for k, (i, j) in enumerate(np.ndindex(across, across)):
            if progress is not None and progress(SearchProgress(k, across**2)):
                raise Interrupted(k, across**2, None, "the plane is not whole")
            try:
                one = tried((float(x[i]), float(y[j]), *self.values[2:]), _COARSE)
            except Interrupted:
                raise
            except PercussError:
                continue
            if one.value is None or one.fault:
                continue
            values[i, j] = one.value
            missed[i, j] = whose[int(np.argmin(one.slacks))] if min(one.slacks, default=0.0) < 0.0 else -1
        return DesignPlane(self, x, y, values, missed)

    def _tell(self, name: str, which: int) -> str:
        value = self.comparison.answers[which].whole.value(name)
        return "–" if value is None else whole_figure(name).tell(value, self.case.is_si)

    def to_json_dict(self) -> dict[str, Any]:
        """The answer in plain values, as `percuss design --json` prints it."""
        own = self.comparison.answers[0].whole
        together = zip(self.spans, self.own_values, self.values, strict=True)
        return {
            "case": self.comparison.cases[0].file, "title": self.comparison.cases[0].title, "summary": self.summary,
            **picked(self, "figure greatest allowed hammers lacking seed complete"), "runs": self.best.runs,
            "varied": [
                {**picked(s, "name unit low high"), "own": was, "best": x, "end": range_end(s, x)}
                for s, was, x in together
            ],
            "limits": [
                {
                    "name": one.figure, "label": whole_figure(one.figure).label,
                    "unit": whole_figure(one.figure).unit if self.case.is_si else "", "low": one.low, "high": one.high,
                    "own": json_number(own.value(one.figure)), "best": json_number(self.best.value(one.figure)),
                    "binds": one.figure in self.binding, "excess": self.excess.get(one.figure, 0.0),
                }
                for one in self.limits
            ],
            "figures": self.comparison.to_json_dict()["figures"],
            "best_case": self.case.to_dict(),
        }  # fmt: skip

    def report(self) -> Report:
        """What `percuss design` prints."""
        looked = f"{'most' if self.greatest else 'least'} {whole_figure(self.figure).label}"
        ranges = [("range", f"{s.name} from {number(s.low)} to {number(s.high)} {s.unit}".rstrip()) for s in self.spans]
        searched = [("looked for", looked), ("hammers", f"{self.hammers}, seed {self.seed}"), *ranges]
        if self.lacking:
            searched.append(("left out", f"{self.lacking} of them run, and have no such figure"))
        rows = []
        for limit in self.limits:
            name, over = limit.figure, self.excess.get(limit.figure)
            state = "binds" if name in self.binding else "kept"
            state = state if over is None else f"missed by {number(100.0 * over, 3)} %"
            told = (
                whole_figure(name).label,
                _words(limit, self.case.is_si),
                self._tell(name, 0),
                self._tell(name, 1),
                state,
            )
            rows.append(told)
        limits = Grid("Limits", ("figure", "limit", "A", "B", ""), tuple(rows))
        both = self.comparison.report().sections
        parts = (sizes(self.spans, self.own_values, self.values), *((limits,) if rows else ()), both[-1])
        tone = BAD if not self.allowed else GOOD if self.complete else PLAIN
        sections = (ReportSection("The search", tuple(searched)), both[0], *parts)
        return Report(self.comparison.cases[0].title, self.summary, tone, sections)


@dataclass(frozen=True, eq=False)
class DesignPlane(ShortRepr):
    """The hammers of two ranges about the best one, as `DesignAnswer.plane` has them.

    Attributes
    ----------
    answer
        The best one, with the ranges and the limits.
    x, y
        Values of the first range and of the second one, in their units, shapes (n,).
    values
        The figure that the most, or the least, is looked for of; NaN where no hammer runs, shape (n, n), x first.
    missed
        Which of the limits is missed by most, by its place among them; -1 where all are kept, and as many as there are
        limits where no hammer runs. Shape (n, n).
    """

    answer: DesignAnswer
    x: Array
    y: Array
    values: Array
    missed: npt.NDArray[np.int64]


def search_told(now: SearchProgress, figure: WholeFigure, is_si: bool) -> str:
    """How far a search for the best hammer has come, in words."""
    best = "" if now.best is None else f", best {figure.tell(now.best, is_si)}"
    return f"{min(now.tried, now.most)} of {now.most} hammers{best}"


@dataclass
class _Tried:
    """The hammers of ranges, each judged by a figure and by limits; in the order in which they are asked for."""

    case: Case
    spans: tuple[Span, ...]
    figure: str
    limits: tuple[Limit, ...]
    lacking: int = 0
    _ran: deque[tuple[Array, int | None, WholeHammer]] = field(default_factory=lambda: deque(maxlen=_NEAR))

    @cached_property
    def family(self) -> CaseFamily:
        return CaseFamily(self.case, {span.name: span.unit for span in self.spans})

    @cached_property
    def asked(self) -> dict[str, WholeFigure]:
        return {name: whole_figure(name) for name in (self.figure, *(limit.figure for limit in self.limits))}

    def __call__(self, values: Sequence[float], modes: int | None) -> Candidate[None]:
        tried = {span.name: rounded(x) for span, x in zip(self.spans, values, strict=True)}
        place = np.array(values) / [span.high - span.low for span in self.spans]
        known = [(float(np.sum((there - place) ** 2)), other) for there, kept, other in self._ran if kept == modes]
        near = min(known, key=lambda pair: pair[0])[1] if known and self.case.is_machine else None
        one = self.family.whole(tried, modes=modes, near=near)
        has = {} if one.motion is None else {name: each.value(one) for name, each in self.asked.items()}
        if not has or None in has.values():
            self.lacking += one.runs
            return Candidate(None, None)
        if one.runs:
            self._ran.append((place, modes, replace(one)))  # without what it has computed
        slacks = [slack for limit in self.limits for slack in _slacks(limit, has[limit.figure] or 0.0)]
        fault = 0.0 if one.runs else 1.0 + max(0.0, -(one.value("margin") or 0.0))
        return Candidate(None, has[self.figure], tuple(slacks), fault)


def design(
    case: Case,
    spans: Sequence[Span],
    figure: str = "rock_power",
    limits: Sequence[Limit] = (),
    *,
    greatest: bool = True,
    modes: int | None = None,
    seed: int = 0,
    most: int = 1500,
    progress: Callable[[SearchProgress], object] | None = None,
) -> DesignAnswer:
    """The best hammer within ranges: under a clock, of a valve, on a pump, rigid or elastic.

    Only hammers that run are looked for: whose motion is stable, with no blow or rest between the blows.

    Parameters
    ----------
    spans
        What may vary, and between which values; see `Span.parsed`.
    figure, greatest
        One of `percuss.case.answers.whole_hammer.WHOLE_FIGURES`, or ``piston[i].stress`` or ``steel[i].stress``, of
        which the most or the least is looked for.
    limits
        What else it must keep to.
    modes
        Elastic modes of the answer, as `steady_answer` and `machine_answer` take them. Places are looked for with 4, or
        fewer where fewer are asked for; the best is polished with all.
    seed, most, progress
        See `percuss.optimum.best_place`.

    Raises
    ------
    CaseError, ParameterError
        When the case cannot be used, or has no such keys or figures.
    Interrupted
        When `progress` ended the search before there was any hammer.
    MissingExtraError
        When scipy is not installed.

    Examples
    --------
    >>> from percuss.case import load_case
    >>> spans = [Span.parsed("load.ports[0].behind=8:24mm")]
    >>> limits = [Limit.parsed("flow=60 l/min", "below", True)]
    >>> found = design(load_case("valve-drifter"), spans, "blow_energy", limits, modes=0, most=80)
    >>> found.binding, found.allowed
    (('flow',), True)
    """
    checked_case(case)
    spans = tuple(instance("spans", span, Span) for span in several("spans", spans, "a list of Span"))
    limits = tuple(instance("limits", limit, Limit) for limit in several("limits", limits, "a list of Limit"))
    if not spans:
        raise ParameterError("vary", "", "one range or more", "say what may vary, such as bar.length=300:400mm")
    seed, most = count("seed", seed, 0, 2**32 - 1), count("most", most, 20, 10**7)
    callback("progress", progress)
    greatest = flag("greatest", greatest)
    tried = _Tried(case, spans, text("figure", figure), limits)
    family = tried.family
    own_values = tuple(
        own_value(case, key, span.unit) for key, span in zip(ranged_keys(family, spans), spans, strict=True)
    )
    modes = None if modes is None else count("modes", modes, least=0)
    rigid = case.is_machine and case.machine().valve.flows  # whose steps each mode shortens
    coarse = (0 if rigid else _COARSE) if modes is None else min(_COARSE, modes)
    own = family.whole({}, modes=coarse)
    for name, one in tried.asked.items():
        if own.motion is not None and one.value(own) is None:
            has = ", ".join(known for known in WHOLE_FIGURES if own.value(known) is not None)
            raise ParameterError("figure", name, f"a figure that this hammer has: {has}")
    inside = [x is not None and span.low <= x <= span.high for x, span in zip(own_values, spans, strict=True)]
    found = best_place(
        lambda values: tried(values, coarse),
        [(span.low, span.high) for span in spans],
        greatest=greatest,
        first=[x for x in own_values if x is not None] if all(inside) else None,
        seed=seed,
        most=most,
        progress=progress,
        finely=None if coarse == modes else lambda values: tried(values, modes),
    )
    if found is None or isinstance(found, PercussError):
        why = f"the last refusal: {found}" if found is not None else "none of them has a motion"
        ranges = ", ".join(f"{span.name}={span.low:g}:{span.high:g}{span.unit}" for span in spans)
        raise ParameterError("vary", ranges, "ranges in which a hammer has such a motion", why)
    values = tuple(map(rounded, found.values))
    best = family.varied({span.name: x for span, x in zip(spans, values, strict=True)})
    both = compare([case, best], (case.file, f"{case.file}, best"), modes)
    told = both, found.tried, seed, found.complete, tried.lacking
    return DesignAnswer(figure, greatest, limits, spans, values, own_values, *told)
