"""What the tolerances of its numbers do to a hammer: the spread of its figures, worst corners, and what dominates."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np

from percuss.case.answers.facts import (
    BAD,
    GOOD,
    Grid,
    Report,
    ReportSection,
    counted,
    json_number,
    number,
    numbers,
    percent,
)
from percuss.case.answers.whole_hammer import HEADLINE, WHOLE_FIGURES, FigureUncertainty, UncertainFigure, whole_figure
from percuss.case.case import Case, checked_case
from percuss.case.parameters.case_family import CaseFamily
from percuss.case.parameters.case_keys import LOAD_SCALE
from percuss.case.parameters.moves import number_held
from percuss.case.parameters.spans import Span, check_ends, parsed_tolerance, rounded, uncertain_spans
from percuss.errors import ParameterError, PercussError, extra_package
from percuss.explore.jobs.job import ASK_FORMAT, Column, Columns
from percuss.model.checks import Array, count, instance, several, text
from percuss.short_repr import ShortRepr

if TYPE_CHECKING:
    from percuss.case.answers.whole_hammer import WholeHammer

SAMPLES = 4096
"""Hammers of a tolerance by default."""

_CORNERS = 6  # tolerances of which all corners are tried
_SURE = 0.95
_NINE_OF_TEN = (0.05, 0.95)
_ROUNDING = 1e-9  # share of a figure: what depends on none of the numbers
_BENT = 0.5  # of the half width: what is not linear
_FEW = 0.01  # of the hammers: if more do not run, what dominates is not told
_MAIN = ("rock_power", "blow_energy")


def standard_tolerances(case: Case) -> tuple[Span, ...]:
    """Those of a drawing: areas and a pump's flow 5 %, places of ports 0.2 mm, the load or its pressure 10 %, R 0.1.

    Raises
    ------
    ParameterError
        For a case that has none of these.
    """
    checked_case(case)
    keys, found = CaseFamily(case, {}).keys, []
    rules = ((r"load\.states\..*\.(front|rear)|load\.area", "±5%"), (r"load\.ports\[\d+\]\.behind", "±0.2mm"),
             (r"load\.pressure", "±10%"), (r"load\.supply\.flow", "±5%"))  # fmt: skip
    for key in keys:
        for rule, half in rules:
            if re.fullmatch(rule, key) and number_held(case, key)[0]:
                found.append(parsed_tolerance(f"{key}={half}", case))
    if LOAD_SCALE in keys and not case.is_machine:
        found.append(Span(LOAD_SCALE, 0.9, 1.1))
    middle, _ = number_held(case, "contact.restitution")
    if middle is not None:
        low, high = max(0.0, middle - 0.1), min(1.0, middle + 0.1)
        found.append(Span("contact.restitution", rounded(low), rounded(high)))
    if not found:
        raise ParameterError("vary", None, "tolerances: this case has none of the usual keys", "give --vary KEY=±HALF")
    return tuple(found)


# ---- The hammers that are computed: as the case has it, each end alone, random ones, all corners


@dataclass(frozen=True)
class ToleranceJob:
    """Hammers within tolerances as a job: the case, the ends of each tolerance alone, random ones, and the corners.

    The random ones are those from which Saltelli et al. (2010) find indices: two tables A and B of a scrambled Sobol
    sequence, and A with one column of B at a time.
    """

    family: CaseFamily
    tolerances: tuple[Span, ...]
    figures: tuple[str, ...]
    base: int
    seed: int
    modes: int | None

    @cached_property
    def unit_places(self) -> Array:
        """Of each hammer in the unit cube, shape (hammers, tolerances); NaN for what the case itself has."""
        from scipy.stats.qmc import Sobol

        d = len(self.tolerances)
        ends = np.full((2 * d, d), np.nan)
        ends[np.arange(2 * d), np.repeat(np.arange(d), 2)] = np.tile([0.0, 1.0], d)
        drawn = Sobol(2 * d, seed=self.seed).random(self.base)
        a, b = drawn[:, :d], drawn[:, d:]
        mixed = np.repeat(a[None], d, axis=0)
        for i in range(d):
            mixed[i, :, i] = b[:, i]
        corners = np.array(list(product((0.0, 1.0), repeat=d))) if d <= _CORNERS else np.empty((0, d))
        return np.concatenate([np.full((1, d), np.nan), ends, a, b, mixed.reshape(-1, d), corners])

    def part(self, name: str) -> slice:
        """Which rows are the "ends", the random "a", "b" and "mixed" ones, or the "corners"."""
        d, first = len(self.tolerances), 1
        for word, size in (("ends", 2 * d), ("a", self.base), ("b", self.base), ("mixed", d * self.base)):
            if word == name:
                return slice(first, first + size)
            first += size
        return slice(first, None)

    @property
    def size(self) -> int:
        return int(self.unit_places.shape[0])

    @property
    def columns(self) -> Mapping[str, Column]:
        units = {name: whole_figure(name).unit if self.family.is_si else "" for name in self.figures}
        told = {name: Column(unit=units[name], meaning=whole_figure(name).label) for name in self.figures}
        return {"runs": Column("bool", meaning="whether the hammer can sustain its motion"), **told}

    @property
    def ask(self) -> dict[str, Any]:
        return {
            "kind": "tolerance", "percuss": ASK_FORMAT, "family": self.family.describe(), "seed": self.seed,
            "tolerances": [[one.name, one.low, one.high, one.unit] for one in self.tolerances],
            "figures": list(self.figures), "base": self.base, "modes": self.modes,
        }  # fmt: skip

    @cached_property
    def nominal(self) -> WholeHammer:
        """The hammer of the case."""
        return self.family.whole({}, modes=self.modes)

    def values(self, place: Array) -> dict[str, float]:
        """The numbers of one hammer, without those that the case has."""
        both = zip(self.tolerances, place.tolist(), strict=True)
        return {one.name: one.low + (one.high - one.low) * x for one, x in both if not math.isnan(x)}

    def figures_at(self, place: Array) -> dict[str, float] | None:
        """The figures of one hammer, looked for near that of the case; NaN for one that it has not, None if not run."""
        try:
            found = self.family.whole(self.values(place), modes=self.modes, near=self.nominal)
            if not found.runs:
                return None
            values = {name: found.value(name) for name in self.figures}
        except (PercussError, ArithmeticError):
            return None
        return {name: math.nan if value is None else value for name, value in values.items()}

    def compute(self, first: int, last: int, stopped: Callable[[], bool]) -> Columns:
        out: Columns = {name: np.full(last - first, column.empty) for name, column in self.columns.items()}
        for i, place in enumerate(self.unit_places[first:last]):
            if stopped():
                break
            found = self.figures_at(place)
            out["runs"][i] = found is not None
            for name, value in (found or {}).items():
                out[name][i] = value
        return out


# ---- The answer


@dataclass(frozen=True)
class Spread:
    """A figure of hammers within tolerances, in base units: of the case, and of the random ones that run.

    `known` is the share of those that have it: figures of the blow take one that reaches the tool.
    `corners` are the least and the greatest of the corners of all tolerances, and `at` where: the sign of each.
    `first`, `total` are the Sobol indices of each tolerance: its share of the variance alone, and with all in which it
    takes part; None where too many hammers do not run.
    """

    name: str
    nominal: float
    known: float
    median: float
    low: float
    high: float
    least: float
    greatest: float
    corners: tuple[float, float]
    at: tuple[str, str]
    first: tuple[float, ...] | None
    total: tuple[float, ...] | None


@dataclass(frozen=True, eq=False)
class ToleranceAnswer(ShortRepr):
    """Hammers within tolerances.

    Attributes
    ----------
    job, columns
        What was computed, and the figures of all.
    standard
        Whether the tolerances are the usual ones of a drawing.
    """

    case: Case
    job: ToleranceJob
    columns: Columns
    standard: bool

    @cached_property
    def drawn(self) -> dict[str, Array]:
        """The columns of the hammers that were drawn at random, each by itself."""
        parts = [self.job.part("a"), self.job.part("b")]
        return {name: np.concatenate([column[part] for part in parts]) for name, column in self.columns.items()}

    @cached_property
    def running(self) -> tuple[float, float, float]:
        """The share of the hammers that run, and its exact interval of 95 %."""
        from scipy.stats import binomtest

        runs = self.drawn["runs"]
        ends = binomtest(int(runs.sum()), runs.size).proportion_ci(_SURE, "exact")  # Clopper and Pearson
        return float(runs.mean()), float(ends.low), float(ends.high)

    @cached_property
    def spreads(self) -> tuple[Spread, ...]:
        """Each figure that the hammer of the case has."""
        return tuple(self._spread(name) for name in self.job.figures if np.isfinite(self.columns[name][0]))

    def _spread(self, name: str) -> Spread:
        column, drawn = self.columns[name], self.drawn[name]
        known = drawn[np.isfinite(drawn)]
        if not known.size:
            accepted = f"tolerances within which some run, and have the {whole_figure(name).label}"
            raise ParameterError("vary", counted(len(drawn), "hammer"), accepted)
        low, high = np.quantile(known, _NINE_OF_TEN).tolist()
        corners, signs = self._corners(name)
        ends = (int(np.nanargmin(corners)), int(np.nanargmax(corners))) if np.isfinite(corners).any() else None
        at = ("", "") if ends is None else (signs[ends[0]], signs[ends[1]])
        worst = (math.nan, math.nan) if ends is None else (float(corners[ends[0]]), float(corners[ends[1]]))
        first, total = self._indices(name)
        share = known.size / int(self.drawn["runs"].sum())
        whole = float(np.median(known)), low, high, float(known.min()), float(known.max())
        return Spread(name, float(column[0]), share, *whole, worst, at, first, total)

    def _corners(self, name: str) -> tuple[Array, list[str]]:
        """The figure at all corners; of many tolerances at the two where it changes most, linearised."""
        d = len(self.job.tolerances)
        if d <= _CORNERS:
            places = self.job.unit_places[self.job.part("corners")]
            values = self.columns[name][self.job.part("corners")]
        else:
            ends = self.columns[name][self.job.part("ends")].reshape(d, 2)
            low, high = np.where(np.isfinite(ends), ends, self.columns[name][0]).T
            up = (high >= low).astype(float)
            places = np.array([1.0 - up, up])
            values = np.array([(self.job.figures_at(place) or {}).get(name, math.nan) for place in places])
        return values, ["".join("−+"[int(x)] for x in place) for place in places]

    def _indices(self, name: str) -> tuple[tuple[float, ...] | None, tuple[float, ...] | None]:
        from scipy.stats import sobol_indices

        parts = [self.columns[name][self.job.part(word)] for word in ("a", "b", "mixed")]
        lost = float(np.mean(~np.isfinite(np.concatenate(parts))))
        middle = float(np.nanmean(parts[0])) if np.isfinite(parts[0]).any() else math.nan
        if lost > _FEW or not np.nanmax(np.abs(parts[0] - middle), initial=0.0) > 1e-9 * abs(middle):
            return None, None
        if len(self.job.tolerances) == 1:
            return (1.0,), (1.0,)
        a, b, mixed = (np.where(np.isfinite(part), part, middle) - middle for part in parts)
        shape = len(self.job.tolerances), 1, self.job.base
        tables: Any = {"f_A": a[None], "f_B": b[None], "f_AB": mixed.reshape(shape)}
        found = sobol_indices(func=tables, n=self.job.base)
        first, total = (np.clip(np.ravel(one), 0.0, 1.0).tolist() for one in (found.first_order, found.total_order))
        return tuple(first), tuple(total)

    @property
    def main(self) -> Spread | None:
        """The figure that the sentence is about: power into the rock, else blow energy, else the first."""
        told = {one.name: one for one in self.spreads}
        return next((told[name] for name in _MAIN if name in told), next(iter(told.values()), None))

    @property
    def ranked(self) -> tuple[tuple[Span, float, float], ...]:
        """The tolerances by their total index of the main figure, with both indices; none where they are not told."""
        main = self.main
        if main is None or main.first is None or main.total is None:
            return ()
        rows = zip(self.job.tolerances, main.first, main.total, strict=True)
        return tuple(sorted(rows, key=lambda row: -row[2]))

    def _tell(self, name: str, value: float) -> str:
        """A figure with its unit."""
        return "–" if math.isnan(value) else whole_figure(name).tell(value, self.case.is_si)

    @property
    def summary(self) -> str:
        """The answer in a few sentences."""
        share, low, high = self.running
        drawn = len(self.drawn["runs"])
        kept = "all" if share == 1.0 else number(100.0 * share, 4) + " %"
        said = f"Of {drawn} such hammers {kept} run: {number(100.0 * low, 4)} to {number(100.0 * high, 4)} % of all."
        main = self.main
        if main is None:
            return said
        label = whole_figure(main.name).label.capitalize()
        said += f" {label}: {self._tell(main.name, main.low)} to {self._tell(main.name, main.high)} in nine of ten, "
        said += f"{self._tell(main.name, main.nominal)} as drawn."
        if ranked := self.ranked:
            tightest, _, total = ranked[0]
            left = math.sqrt(max(0.0, 1.0 - 0.75 * total))
            said += f" {'Tightest' if self.standard else 'What dominates'}: {tightest.name}, with {percent(total)} "
            said += f"of the variance; halved, it leaves {percent(left)} of the spread."
        elif share < 1.0 or main.known < 1.0:
            why = "do not run" if share < 1.0 - _FEW else "have no such figure"
            said += f" What dominates is not told, as too many {why}."
        return said

    def to_json_dict(self) -> dict[str, Any]:
        """The answer in plain values, as `percuss tolerance --json` prints it."""
        share, low, high = self.running
        return {
            "case": self.case.file, "title": self.case.title, "summary": self.summary, "standard": self.standard,
            "hammers": self.job.size, "drawn": len(self.drawn["runs"]), "seed": self.job.seed,
            "runs": {"share": share, "low": low, "high": high},
            "tolerances": [{"name": one.name, "low": one.low, "high": one.high, "unit": one.unit}
                           for one in self.job.tolerances],
            "ranked": [one.name for one, _, _ in self.ranked],
            "figures": [
                {
                    "name": one.name, "unit": whole_figure(one.name).unit if self.case.is_si else "",
                    **{key: json_number(getattr(one, key))
                       for key in ("nominal", "known", "median", "low", "high", "least", "greatest")},
                    "corners": numbers(one.corners), "at": list(one.at),
                    "first": one.first and numbers(one.first), "total": one.total and numbers(one.total),
                }
                for one in self.spreads
            ],
        }  # fmt: skip

    def report(self) -> Report:
        """What `percuss tolerance` prints."""
        unranked = [(one, None, None) for one in self.job.tolerances]
        rows = tuple(
            (
                one.name,
                f"{number(one.low, 6)} to {number(one.high, 6)} {one.unit}".rstrip(),
                *("–" if share is None else percent(share) for share in shares),
            )
            for one, *shares in self.ranked or unranked
        )
        main = self.main
        of = "" if main is None else f" (shares of the variance of the {whole_figure(main.name).label})"
        order = ", ".join(one.name for one in self.job.tolerances)
        drawn = f"{len(self.drawn['runs'])} hammers, every number as likely all over its range; seed {self.job.seed}"
        notes = [("drawn", drawn), ("corners", f"all numbers at their ends, − and + in the order {order}")]
        if self.standard:
            notes.append(("tolerances", "those usual in a drawing, as none were given"))
        heads = ("figure", "as drawn", "median", "nine of ten", "all of them", "least corner", "greatest corner")
        sections = (
            Grid(f"Tolerances{of}", ("key", "range", "alone", "in all"), rows),
            Grid("Figures of those that run", heads, tuple(map(self._row, self.spreads))),
            ReportSection("How", tuple(notes)),
        )
        return Report(self.case.title, self.summary, GOOD if self.running[0] == 1.0 else BAD, sections)

    def _row(self, one: Spread) -> tuple[str, ...]:
        tell = partial(self._tell, one.name)
        corners = (f"{tell(value)} ({at})" if at else "–" for value, at in zip(one.corners, one.at, strict=True))
        ends = f"{tell(one.low)} to {tell(one.high)}", f"{tell(one.least)} to {tell(one.greatest)}"
        label = whole_figure(one.name).label + (f" ({percent(one.known)} have it)" if one.known < 1.0 else "")
        return label, tell(one.nominal), tell(one.median), *ends, *corners


def tolerance_job(
    case: Case,
    tolerances: Sequence[Span] = (),
    figures: Sequence[str] = (),
    *,
    samples: int = SAMPLES,
    seed: int = 0,
    modes: int | None = None,
) -> ToleranceJob:
    """The job of a tolerance, checked; see `tolerance`."""
    extra_package("scipy", "io")
    checked_case(case)
    given = tuple(instance("tolerances", one, Span) for one in several("tolerances", tolerances, "a list of Span"))
    given = given or uncertain_spans(case) or standard_tolerances(case)
    family = CaseFamily(case, {one.name: one.unit for one in given})
    family.check({one.name: one.unit for one in given})
    for one in given:
        check_ends(family, one, family.machine if family.is_machine else family.system)
    most = count("samples", samples, 64, 10**7)
    base = 2 ** round(math.log2(most / (len(given) + 2)))
    kept = None if modes is None else count("modes", modes, least=0)
    names = several("figures", figures, f"names of figures, such as {next(iter(WHOLE_FIGURES))}") or HEADLINE
    for name in names:
        whole_figure(text("figures", name))
    job = ToleranceJob(family, given, tuple(names), base, count("seed", seed, 0, 2**32 - 1), kept)
    if job.nominal.motion is None or not job.nominal.runs:
        raise ParameterError("case", case.file, f"a hammer that runs: {job.nominal.stopped}", "see 'percuss steady'")
    if not figures:
        told = tuple(name for name in names if job.nominal.value(name) is not None)
        job = ToleranceJob(family, given, told, base, job.seed, kept)
    return job


def tolerance(
    case: Case,
    tolerances: Sequence[Span] = (),
    figures: Sequence[str] = (),
    *,
    samples: int = SAMPLES,
    seed: int = 0,
    modes: int | None = None,
    **running: Any,
) -> ToleranceAnswer:
    """What the tolerances of its numbers do to a hammer.

    Parameters
    ----------
    tolerances
        Ranges of keys of the case (`parsed_tolerance`); none for the ± of the case, or where
        it has none for those usual in a drawing (`standard_tolerances`).
    figures
        Names of `percuss.case.answers.whole_hammer.WHOLE_FIGURES`; none for those that matter.
    samples, seed
        About how many hammers are drawn, by a scrambled Sobol sequence: the same seed gives the same numbers.
    modes
        Elastic modes, as `steady_answer` and `machine_answer` take them.
    **running
        How it is carried out: ``workers``, ``archive``, ``resume``, ``pool``, ``progress``; see
        `percuss.explore.carry_out`.

    Raises
    ------
    ParameterError
        For a key or a figure that there is not, an end that no hammer has, and a case that does not run as it is.
    MissingExtraError
        When scipy is not installed.

    Notes
    -----
    The indices are those of Sobol by the formulae of Saltelli et al. (Comput. Phys. Commun. 181, 259, 2010), of scipy.

    Examples
    --------
    >>> from percuss.case import load_case, parsed_tolerance, tolerance
    >>> case = load_case("valve-breaker")
    >>> keys = [parsed_tolerance(text, case) for text in ("load.pressure=±10bar", "contact.restitution=0.1..0.2")]
    >>> found = tolerance(case, keys, ["blow_energy"], samples=64, modes=0, workers=1)
    >>> found.running[0], found.ranked[0][0].name
    (1.0, 'load.pressure')
    """
    from percuss.explore.jobs.carrying_out import carry_out

    job = tolerance_job(case, tolerances, figures, samples=samples, seed=seed, modes=modes)
    return ToleranceAnswer(case, job, carry_out(job, **running), not tolerances and not case.uncertain)


# ---- Numbers that the case itself has within ±: what they leave of its figures, linearised


def uncertainty_of(case: Case, modes: int | None = None, periods: int = 1) -> FigureUncertainty | None:
    """What the ± of the numbers of a case leaves of its figures; None where no number has one, or it does not run.

    Each number is taken to both ends of its range by itself, the others as they are. The ± of a figure means what that
    of the numbers means: limits at one level of confidence in, the same out, if the numbers are independent.

    Examples
    --------
    >>> from percuss.case import load_case
    >>> case = load_case("valve-breaker").varied({"load.pressure": "160 ± 5 bar"})
    >>> uncertainty_of(case, modes=0).told("blow_energy")
    '3.75 ± 0.14 kJ'
    """
    checked_case(case)
    if not case.uncertain:
        return None
    kept = None if modes is None else count("modes", modes, least=0)
    spans = uncertain_spans(case)
    family = CaseFamily(case, {one.name: one.unit for one in spans})
    nominal = family.whole({}, periods, kept)
    if not nominal.runs:
        return None
    names = [name for name in HEADLINE if nominal.value(name) is not None]
    stopped: list[str] = []

    def at(span: Span, end: float) -> dict[str, float | None]:
        try:
            found: WholeHammer = family.whole({span.name: end}, periods, kept, nominal)
            why = found.stopped
        except PercussError as error:
            found, why = nominal, str(error)
        if why:
            stopped.append(f"{why} at {span.name} = {number(end, 6)} {span.unit}".rstrip())
            return {}
        return {name: found.value(name) for name in names}

    ends = [(span.name, at(span, span.low), at(span, span.high)) for span in spans]
    told = (_figure(name, nominal.value(name), ends) for name in names)
    return FigureUncertainty(case.uncertain, tuple(one for one in told if one is not None), tuple(stopped), case.is_si)


_Ends = list[tuple[str, dict[str, Any], dict[str, Any]]]  # of each number: its key, and the figures at both ends


def _figure(name: str, value: float | None, ends: _Ends) -> UncertainFigure | None:
    assert value is not None
    halves, bent = {}, 0.0
    for key, low, high in ends:
        below, above = low.get(name), high.get(name)
        if below is None and above is None:
            return None
        one, other = (value if end is None else end for end in (below, above))
        both = below is not None and above is not None
        halves[key] = abs(other - one) * (0.5 if both else 1.0)
        bent += abs(one + other - 2.0 * value) * 0.5 if both else 0.0
    half = math.hypot(*halves.values())
    if half <= _ROUNDING * abs(value):
        return None
    shares = {key: (one / half) ** 2 for key, one in sorted(halves.items(), key=lambda pair: -pair[1])}
    return UncertainFigure(name, value, half, shares, bent > _BENT * half)
