"""The numbers of a case that fit measured blows, with intervals that carry the scatter and what was only given."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import combinations
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from percuss.case.answers.exploring.best_answer import range_end
from percuss.case.answers.facts import BAD, GOOD, Grid, Report, ReportSection, number, percent, picked, quantity
from percuss.case.answers.whole_hammer import whole_figure
from percuss.case.case import Case, checked_case
from percuss.case.parameters.case_family import CaseFamily
from percuss.case.parameters.case_keys import FREQUENCY, LOAD_PRESSURE, LOAD_SCALE
from percuss.case.parameters.moves import number_held, placed
from percuss.case.parameters.spans import Span, check_ends, own_value, parsed_tolerance, rounded, uncertain_spans
from percuss.errors import HistoryError, ParameterError, PercussError, extra_package
from percuss.model.checks import Array, count, instance, positive, several, text
from percuss.recordings import BlowRecord
from percuss.short_repr import ShortRepr
from percuss.steady.oil.data_sheet import DataSheetFit, data_sheet
from percuss.steady.oil.oil_figures import path_losses

if TYPE_CHECKING:
    from percuss.case.answers.whole_hammer import WholeFigure, WholeHammer

_COLUMNS = {
    "blow_rate": "times", "rebound_velocity": "rebound speeds", "rigid_velocity": "striking speeds",
    "pressure": "the pressure of the supply", "flow": "the flow of the supply",
}  # fmt: skip
"""The figures that may be measured, and as what; speeds are those of the bar as a whole, as those of its end ring."""

_SURE = 0.95
_DOUBTED = 0.01  # probability of the misfit below which model and record do not agree
_EXACT = 1e-6  # share of a mean below which none is sure: that of a clock
_APART = 1e4  # condition of the scaled slopes beyond which the model would have to be right to 0.01 % to tell
_STEP = 1e-4  # share of a range, for slopes
_LEAST, _BATCHES = 16, 8  # rows, and means of successive ones
_MISSED = 1.5  # times the median interval: a blow in between was not seen
_LOST = 0.1  # share of the rows that may be left out
_UNLIKE, _LONGEST = 1e-6, 4  # probability below which blows in turn are unequal by no chance, and the most of them


def parsed_unknown(words: str, case: Case) -> Span:
    """A number to be found, ``KEY`` or ``KEY=LOW..HIGH``; without a range R from 0 to 1, others from half to twice.

    Examples
    --------
    >>> from percuss.case import load_case
    >>> parsed_unknown("load.pressure", load_case("valve-breaker"))
    Span(name='load.pressure', low=80.0, high=320.0, unit='bar')
    """
    checked_case(case)
    if "=" in text("vary", words):
        return parsed_tolerance(words, case)
    try:
        key = CaseFamily(case, {}).key(words.strip())
    except ParameterError as error:
        raise ParameterError("vary", words, "a key of the case", error.remedy) from None
    own, unit = (1.0, "") if key == LOAD_SCALE else number_held(case, key) if key else (None, "")
    if not own:
        raise ParameterError("vary", words, "a key that the case holds", f"give the range: {words}=LOW..HIGH")
    low, high = (0.0, 1.0) if key == "contact.restitution" else sorted((0.5 * own, 2.0 * own))
    return Span(key, rounded(low), rounded(high), unit)


def _usual_unknowns(case: Case) -> tuple[Span, ...]:
    """R, and the pressure or the scale of the load; of a load that keeps time its frequency, too."""
    known = CaseFamily(case, {}).keys
    keys = [LOAD_PRESSURE if LOAD_PRESSURE in known else LOAD_SCALE]
    keys += [key for key in ("contact.restitution", FREQUENCY) if key in known and number_held(case, key)[0]]
    return tuple(parsed_unknown(key, case) for key in keys)


# ---- What a record says: means of figures, and how sure they are


@dataclass(frozen=True, eq=False)
class BlowMeans(ShortRepr):
    """The means of measured blows, and how sure they are.

    Attributes
    ----------
    series, blows
        Of each figure its values, shape (rows,), in base units, and of which blow each is, counted from 1. Those of the
        blow rate are linear in the intervals, so that their mean is one over the mean interval.
    means, covariance
        Shape (figures,) and (figures, figures): the means, and the covariance of their errors.
    batches
        From how many means of successive blows that comes, long enough to forget each other.
    unequal
        How many unequal blows follow each other in turn; 1 where all are alike.
    notes
        What was left out or looks odd, one sentence each.
    """

    series: Mapping[str, Array]
    blows: npt.NDArray[np.intp]
    means: Array
    covariance: Array
    batches: int
    unequal: int
    notes: tuple[str, ...]


def _means(record: BlowRecord) -> BlowMeans:
    interval = np.diff(record.time)
    table = np.array([interval, *(values[:-1] for values in record.figures.values())])
    middle = float(np.median(interval))
    good = np.isfinite(table).all(axis=0) & (interval < _MISSED * middle) & (interval > middle / _MISSED)
    table, lost, notes = table[:, good], int(np.sum(~good)), list(record.notes)
    if lost > _LOST * interval.size or interval.size - lost < _LEAST:
        told = f"{interval.size - lost} of {interval.size} intervals can be used: the others lack a value, or are not "
        told += f"within a factor of {_MISSED} of their median, {quantity(middle, 's')}"
        raise HistoryError(told, f"at least {_LEAST} and nine of ten are needed", record.file)
    if lost:
        notes.append(f"{lost} of {interval.size} intervals are left out: a blow was missed, or lacks a value")
    table[0] = (2.0 - table[0] / table[0].mean()) / table[0].mean()
    memory = max(map(_memory, table))
    wanted = 1 + math.ceil(10.0 * memory)  # so that batch means are independent to a twentieth
    size = min(wanted, len(table[0]) // _BATCHES)
    if wanted > 2 * size:
        notes.append(
            f"the record is short for its slow changes, over some {memory:.0f} blows: intervals may be too narrow"
        )
    batches = len(table[0]) // size
    parts = table[:, : batches * size].reshape(len(table), batches, size).mean(axis=2)
    means = parts.mean(axis=1)
    covariance = np.cov(parts).reshape(len(table), -1) / batches + np.diag((_EXACT * means) ** 2)
    unequal = max(map(_in_turn, [*table, *([] if record.peaks is None else [record.peaks[:-1][good]])]))
    if unequal > 1:
        notes.append(
            f"{unequal} unequal blows follow each other in turn: their means are compared with a steady motion of one "
            "blow, from which they differ by the square of the inequality"
        )
    kept = dict(zip(("blow_rate", *record.figures), table, strict=True))
    return BlowMeans(kept, np.flatnonzero(good) + 1, means, covariance, batches, unequal, tuple(notes))


def _is_even(series: Array) -> bool:
    return not float(np.ptp(series)) > _EXACT * float(np.abs(series).max())


def _memory(series: Array) -> float:
    """By how many blows the integrated autocorrelation time is off 1, up or down, in a window of 5 of it (Wolff 2004).

    Less than 1 is that of intervals whose ends alone scatter: the next one makes up for it.
    """
    around, n = series - series.mean(), series.size
    if _is_even(series):
        return 0.0
    time, window = 1.0, 0
    while window < n // 4 and window < 5.0 * time:
        window += 1
        time += 2.0 * float(around[window:] @ around[:-window]) / float(around @ around)
    return abs(time * (1.0 + (2 * window + 1) / n) - 1.0)


def _in_turn(series: Array) -> int:
    """How many unequal values follow each other in turn; 1 where there are none."""
    from scipy.stats import f_oneway

    series = series[np.isfinite(series)]
    sizes = () if _is_even(series) else range(2, _LONGEST + 1)
    unlike = (size for size in sizes if f_oneway(*(series[i::size] for i in range(size))).pvalue < _UNLIKE)
    return next(unlike, 1)


# ---- The figures of the hammer at any numbers, their slopes, and whether those tell the numbers apart


@dataclass(eq=False)
class _Model:
    """The figures of a hammer over the numbers of its case: a place is in the unit cube of their ranges."""

    family: CaseFamily
    spans: tuple[Span, ...]
    periods: int
    modes: int | None
    near: WholeHammer | None = None
    known: dict[tuple[object, ...], WholeHammer | None] = field(default_factory=dict)

    def whole(self, place: Array, other: Mapping[str, float] | None = None) -> WholeHammer | None:
        both = zip(self.spans, place.tolist(), strict=True)
        values = {one.name: one.low + (one.high - one.low) * x for one, x in both} | dict(other or {})
        if (key := tuple(values.items())) not in self.known:
            near = self.near if self.family.is_machine else None
            try:
                found = self.family.whole(values, self.periods, self.modes, near)
                self.near = found if found.motion is not None else near
            except (PercussError, ArithmeticError):
                found = None
            self.known[key] = found
        return self.known[key]

    def figures(self, place: Array, names: Sequence[str], other: Mapping[str, float] | None = None) -> Array:
        """In base units, by their names; NaN where there is none."""
        found = self.whole(place, other)
        return np.array([math.nan if found is None or (x := found.value(name)) is None else x for name in names])

    def slopes(self, place: Array, names: Sequence[str]) -> Array:
        """By each number, per width of its range, shape (figures, numbers)."""
        here = self.figures(place, names)
        steps = np.diag(np.where(place < 0.5, _STEP, -_STEP))
        return np.array([(self.figures(place + step, names) - here) / step.sum() for step in steps]).T

    def by_given(self, place: Array, names: Sequence[str], given: Sequence[Span]) -> Array:
        """By the numbers that were given, per half of their ±, the mean of both sides; shape (figures, numbers)."""
        found = np.empty((len(names), len(given)))
        for i, one in enumerate(given):
            ends = [{one.name: one.low + share * (one.high - one.low)} for share in (0.25, 0.75)]
            below, above = (self.figures(place, names, end) for end in ends)
            found[:, i] = 0.5 * (above - below)
        return found

    def check(self, place: Array, measured: Sequence[str], file: str | None) -> None:
        """Refuse a record that cannot tell the numbers, with the one that could."""
        slopes = self.slopes(place, tuple(_COLUMNS)) / self.figures(place, tuple(_COLUMNS))[:, None]
        rows = dict(zip(_COLUMNS, slopes, strict=True))
        if _tells([rows[name] for name in measured]):
            return
        others = [name for name in _COLUMNS if name not in measured and np.isfinite(rows[name]).all()]
        sets = (more for size in range(1, len(others) + 1) for more in combinations(others, size))
        more = next((more for more in sets if _tells([rows[name] for name in (*measured, *more)])), None)
        seen = " and ".join(_COLUMNS[name] for name in measured)
        what = f"{seen}{' alone' if len(measured) == 1 else ''} do not tell {' and '.join(s.name for s in self.spans)}"
        remedy = "no record of blows tells them: vary others, and give what is known of these with its ± (--given)"
        if more is not None:
            remedy = f"give {' and '.join(_COLUMNS[name] for name in more)}, too"
        raise HistoryError(f"{what}{' apart' if len(self.spans) > 1 else ''}", remedy, file)


def _tells(slopes: Sequence[Array]) -> bool:
    """Whether figures with these relative slopes tell all numbers apart."""
    sizes = np.linalg.norm(slopes, axis=0)
    if len(slopes) < sizes.size or not np.all(sizes > _EXACT):
        return False
    return float(np.linalg.cond(np.array(slopes) / sizes)) < _APART


# ---- The answer


@dataclass(frozen=True)
class Identified:
    """A number that was found, in the unit of its range, and where it lies at 95 %, within that.

    `own` is what the case has, `given` the shares of the numbers that were given in the variance.
    """

    span: Span
    own: float | None
    value: float
    low: float
    high: float
    given: tuple[float, ...]

    @property
    def end(self) -> str:
        """The end of its range at which it stands, lower or upper; "" at neither."""
        return range_end(self.span, self.value)

    def tell(self) -> tuple[str, str]:
        """The number and its interval, with two digits of its width."""
        size, wide = max(abs(self.low), abs(self.high)), self.high - self.low
        digits = min(2 + math.ceil(math.log10(size / wide)), 9) if wide > 0.0 else 9
        value, low, high = (number(x, digits) for x in (self.value, self.low, self.high))
        return f"{value} {self.span.unit}".rstrip(), f"{low} to {high}"


@dataclass(frozen=True)
class FittedFigure:
    """A figure that was compared, in base units: of the case, of the hammer that fits, and the mean that was measured.

    `spread` is the standard deviation of what was measured less what fits, with that of what was given.
    """

    name: str
    own: float | None
    fitted: float
    measured: float
    spread: float

    @property
    def figure(self) -> WholeFigure:
        """What it is."""
        return whole_figure(self.name)

    @property
    def residual(self) -> float:
        """Measured less fitted, in standard deviations."""
        return (self.measured - self.fitted) / self.spread


@dataclass(frozen=True)
class IdentifyAnswer(ShortRepr):
    """Numbers of a case that fit measured blows.

    Attributes
    ----------
    case, means
        The case as it was, and what the record says.
    found, given
        The numbers that were found, and those that were given with a ±.
    figures
        What was compared.
    chi_square, spare, agreement
        The misfit, how many more figures there are than numbers, and the probability of such a misfit; 1 without any.
    stopped
        Why the hammer that fits does not run; "" where it does.
    """

    case: Case
    means: BlowMeans
    found: tuple[Identified, ...]
    given: tuple[Span, ...]
    figures: tuple[FittedFigure, ...]
    chi_square: float
    spare: int
    agreement: float
    stopped: str

    @property
    def best(self) -> Case:
        """The case with the numbers that fit, to be saved.

        Raises
        ------
        ParameterError
            For a factor on the forces of a valve, or a number of a recording, which stand in no case.
        """
        family = CaseFamily(self.case, {one.span.name: one.span.unit for one in self.found})
        values = {one.span.name: rounded(one.value) for one in self.found}
        scale = values.pop(LOAD_SCALE, None)
        if scale is not None and self.case.is_machine:
            raise ParameterError("vary", LOAD_SCALE, "numbers that a case can hold", "vary the forces of the states")
        best = family.varied(values) if values else self.case
        return best if scale is None else placed(best, {LOAD_SCALE: scale})

    @property
    def agrees(self) -> bool:
        """Whether the misfit may be chance."""
        return self.agreement >= _DOUBTED

    @property
    def summary(self) -> str:
        """The answer in a few sentences."""
        told = (f"{one.span.name} {one.tell()[0]} ({one.tell()[1]} at 95 %)" for one in self.found)
        said = [f"What fits: {', '.join(told)}."]
        for one in (one for one in self.found if one.end):
            said.append(f"{one.span.name} stands at the {one.end} end of its range: no interval holds.")
        worst = max(self.figures, key=lambda one: abs(one.residual))
        if not self.spare:
            said.append("As many figures as numbers: nothing is left to judge the model by.")
        elif self.agrees:
            said.append(f"Model and record agree: {percent(self.agreement, 2)} of records differ as much by chance.")
        else:
            most = f"most of all in the {worst.figure.label}; no interval holds"
            said.append(f"Model and record differ, by chance only in {percent(self.agreement, 2)} of records, {most}.")
        if self.stopped:
            said.append(f"The hammer that fits does not run: {self.stopped}.")
        by_given = [(share, one, by) for one in self.found for share, by in zip(one.given, self.given, strict=True)]
        for share, one, by in by_given:
            if share >= 0.5:
                said.append(f"{percent(share, 2)} of the variance of {one.span.name} comes from the ± of {by.name}.")
        return " ".join(said)

    def to_json_dict(self) -> dict[str, Any]:
        """The answer in plain values, as `percuss identify --json` prints it."""
        return {
            "case": self.case.file, "title": self.case.title, "summary": self.summary,
            "blows": int(self.means.blows[-1]) + 1, **picked(self.means, "batches unequal"),
            "notes": list(self.means.notes),
            "found": [{**picked(one.span, "name unit"), "range": [one.span.low, one.span.high],
                       **picked(one, "own value low high end given")} for one in self.found],
            "given": [picked(one, "name low high unit") for one in self.given],
            "figures": [{**picked(one, "name"), **picked(one.figure, "label unit"),
                         **picked(one, "own fitted measured spread residual")} for one in self.figures],
            **picked(self, "chi_square spare agreement agrees"), "runs": not self.stopped,
        }  # fmt: skip

    def report(self) -> Report:
        """What `percuss identify` prints."""
        rows = []
        for one in self.found:
            was = "–" if one.own is None else f"{number(one.own, 6)} {one.span.unit}".rstrip()
            rows.append((one.span.name, was, *one.tell(), percent(sum(one.given))))
        figures = []
        for each in self.figures:
            own, fitted, mean = (
                "–" if x is None else each.figure.tell(x, True, 6) for x in (each.own, each.fitted, each.measured)
            )
            sure = percent(each.spread / abs(each.measured), 2)
            figures.append((each.figure.label, own, fitted, f"{mean} ± {sure}", number(each.residual, 2)))
        record = [("blows", f"{self.means.blows[-1] + 1}; scatter of the means from {self.means.batches} batches")]
        if self.spare:
            told = f"{number(self.chi_square, 3)}, figures to spare: {self.spare}"
            record.append(("chi-square", f"{told}; as much by chance in {percent(self.agreement)} of records"))
        record += [("given", f"{s.name} from {number(s.low, 6)} to {number(s.high, 6)} {s.unit}".rstrip())
                   for s in self.given]  # fmt: skip
        heads = ("figure", "the case", "fitted", "measured ± standard deviation", "residual/deviation")
        sections = (
            Grid("Numbers", ("key", "the case", "fitted", "at 95 %", "of the variance given"), tuple(rows)),
            Grid("Figures", heads, tuple(figures)),
            ReportSection("The record", (*record, *(("note", note) for note in self.means.notes))),
        )
        good = self.agrees and not self.stopped and not any(one.end for one in self.found)
        return Report(self.case.title, self.summary, GOOD if good else BAD, sections)


def identify(
    case: Case,
    record: BlowRecord,
    vary: Sequence[Span] = (),
    given: Sequence[Span] = (),
    *,
    modes: int | None = None,
) -> IdentifyAnswer:
    """The numbers of a case with which its steady motion has the figures that were measured of its blows.

    Generalised least squares of the means of the record. The covariance of these is that of batch means, to which
    numbers that are only given with a ± add theirs, by their slopes. Intervals are those of Student's t.

    Parameters
    ----------
    record
        Measured blows (`percuss.recordings.read_blows`).
    vary
        The numbers to be found, and their ranges (`parsed_unknown`); none for R, the pressure or the scale of the
        load, and the frequency of one that keeps time.
    given
        Other numbers, and where they lie at 95 % (`percuss.case.parsed_tolerance`), besides those that stand in the
        case with ±.
    modes
        Elastic modes, as `steady_answer` and `machine_answer` take them.

    Raises
    ------
    ParameterError
        For a key that there is not, an end of a range that no hammer has, and a case that does not move, or has no
        units.
    HistoryError
        When the record cannot tell the numbers; says which could.
    MissingExtraError
        When scipy is not installed.

    References
    ----------
    U. Wolff, Comput. Phys. Commun. 156 (2004) 143: means of correlated values. C. R. Rao, Proc. Fifth Berkeley Symp.
    Math. Stat. Prob. 1 (1967) 355: least squares with an estimated covariance. B. L. Welch, Biometrika 34 (1947) 28.

    Examples
    --------
    >>> import numpy as np
    >>> from percuss.case import identify, load_case
    >>> from percuss.recordings import BlowRecord
    >>> noise = np.random.default_rng(1).normal(size=(2, 100))
    >>> record = BlowRecord(np.cumsum(0.11 + 1e-4 * noise[0]), {"rebound_velocity": 1.4 + 0.01 * noise[1]})
    >>> found = identify(load_case("valve-breaker"), record, modes=0)
    >>> [f"{one.span.name} {one.value:.3g}" for one in found.found]
    ['load.pressure 147', 'contact.restitution 0.16']
    """
    optimize, stats = extra_package("scipy.optimize", "io"), extra_package("scipy.stats", "io")
    checked_case(case)
    if not case.is_si:
        raise ParameterError("case", case.file, "a case in SI: blows are measured in units")
    means, file = _means(instance("record", record, BlowRecord)), record.file
    spans = tuple(instance("vary", one, Span) for one in several("vary", vary, "a list of Span"))
    spans = spans or _usual_unknowns(case)
    given = tuple(instance("given", one, Span) for one in several("given", given, "a list of Span"))
    modes = None if modes is None else count("modes", modes, least=0)
    taken = {one.name for one in (*spans, *given)}
    given += tuple(one for one in uncertain_spans(case) if one.name not in taken)
    units = {one.name: one.unit for one in (*spans, *given)}
    if len(units) < len(spans) + len(given):
        raise ParameterError("given", [one.name for one in given], "each key once, and none that is to be found")
    family = CaseFamily(case, units)
    family.check(units)
    for one in (*spans, *given):
        check_ends(family, one, family.machine if family.is_machine else family.system)
    names, beats = tuple(means.series), 1.0
    if not case.is_machine:
        beats = (case.system().frequency or 0.0) / float(means.means[0])
    if beats < 0.75:
        told = f"{1.0 / beats:.3g} blows in a load period of the case: a motion with one blow is what is fitted"
        raise HistoryError(told, "see whether load.frequency is that of the record", file)
    model = _Model(family, spans, round(beats), modes)
    own = [family.whole({}, round(beats), modes).value(name) for name in names]
    own_values = [1.0 if one.name == LOAD_SCALE else own_value(case, family.key(one.name), one.unit) for one in spans]
    low, wide = np.array([one.low for one in spans]), np.array([one.high - one.low for one in spans])
    place = (np.array([math.nan if x is None else x for x in own_values]) - low) / wide
    place = np.where((place > 0.01) & (place < 0.99), place, 0.5)
    lacking = [name for name, x in zip(names, model.figures(place, names), strict=True) if not math.isfinite(x)]
    if lacking:
        accepted = f"a hammer that moves, and has the figures {', '.join(lacking)}, in the midst of the ranges"
        raise ParameterError("case", case.file, accepted, "see 'percuss steady'")
    model.check(place, names, file)

    def fit(start: Array, covariance: Array) -> Array:
        white = np.linalg.inv(np.linalg.cholesky(covariance))
        found = optimize.least_squares(
            lambda place: white @ (model.figures(place, names) - means.means),
            start,
            lambda place: white @ model.slopes(place, names),
            bounds=(0.0, 1.0),
            xtol=1e-9,
        )
        return np.asarray(found.x)

    place = fit(place, means.covariance)
    model.check(place, names, file)
    by_given = model.by_given(place, names, given)  # half the half width is a standard deviation
    covariance, spare = means.covariance + by_given @ by_given.T, len(names) - len(spans)
    if given and spare:
        place = fit(place, covariance)
    slopes, fitted, weights = model.slopes(place, names), model.figures(place, names), np.linalg.inv(covariance)
    gain = np.linalg.solve(slopes.T @ weights @ slopes, slopes.T @ weights)
    chi_square = float((means.means - fitted) @ weights @ (means.means - fitted))
    free = means.batches - 1
    scatter = np.diag(gain @ means.covariance @ gain.T) * (free + chi_square) / (free - spare)  # Rao (1967)
    shares = (gain @ by_given) ** 2
    variance = scatter + shares.sum(axis=1)
    half = stats.t.ppf(0.5 + 0.5 * _SURE, (free - spare) * (variance / scatter) ** 2) * np.sqrt(variance)  # Welch
    if half.max() > 0.5:
        i = int(half.argmax())
        told = f"the record tells {spans[i].name} no better than its range, {low[i]:g} to {low[i] + wide[i]:g}"
        remedy = "give a longer record, more figures of it, or a wider range"
        if shares[i].sum() > 0.5 * variance[i]:
            remedy = f"the ± of {given[int(shares[i].argmax())].name} decides: measure that better"
        raise HistoryError(f"{told} {spans[i].unit}".rstrip(), remedy, file)
    # Hotelling's T² of the figures to spare
    ratio = chi_square * (free + 1 - spare) / (free * max(spare, 1))
    agreement = float(stats.f.sf(ratio, spare, free + 1 - spare)) if spare else 1.0
    ends = [low + wide * np.clip(place + side * half, 0.0, 1.0) for side in (0.0, -1.0, 1.0)]
    rows = zip(spans, own_values, *(end.tolist() for end in ends), (shares / variance[:, None]).tolist(), strict=True)
    compared = zip(names, own, fitted.tolist(), means.means.tolist(), np.diag(covariance).tolist(), strict=True)
    best = model.whole(place)
    return IdentifyAnswer(
        case, means, tuple(Identified(one, was, x, a, b, tuple(by)) for one, was, x, a, b, by in rows), given,
        tuple(FittedFigure(name, was, x, mean, math.sqrt(spread)) for name, was, x, mean, spread in compared),
        chi_square, spare, agreement, "" if best is None else best.stopped,
    )  # fmt: skip


# ---- What losses explain a data sheet


@dataclass(frozen=True)
class DataSheetAnswer(ShortRepr):
    """What areas, places of ports and losses of its oil a hammer has that meets a data sheet.

    Attributes
    ----------
    given
        Pressure, flow, rate and energy of the sheet, in base units.
    """

    case: Case
    given: Mapping[str, float]
    fit: DataSheetFit

    @property
    def shares(self) -> dict[str, float]:
        """Parts of the input, by name."""
        return {name: loss / self.fit.cycle.work for name, loss in path_losses(self.fit.cycle).items()}

    @property
    def passages(self) -> list[dict[str, Any]]:
        """Of each: chamber, line, state, area of the chamber (m²), and its drop (Pa) at the flow of the blow speed."""
        machine, oil = self.fit.machine, self.fit.machine.valve.oil
        assert oil is not None
        known, pressure, rows = {one.name: one for one in oil.chambers}, self.given["pressure"], []
        speed = self.fit.cycle.blow_speed
        for state, joins in oil.pairs:
            for join in joins:
                area, zeta = known[join.chamber].area, max(join.inward, join.outward)
                size = area * machine.force_scale / pressure
                flow = area * speed
                rows.append({
                    "chamber": join.chamber, "to": join.to, "state": state, "area_m2": size,
                    "drop_Pa": zeta * flow * flow * pressure, "at_m3_s": size * speed * machine.speed_scale,
                })  # fmt: skip
        return rows

    @property
    def lost(self) -> float:
        """Part of the input that passages take."""
        return math.fsum(share for name, share in self.shares.items() if name.startswith("orifice_"))

    @property
    def efficiency(self) -> float:
        """Delivered over input."""
        return self.shares["impact"]

    @property
    def best(self) -> Case:
        """The case with these areas, places and passages, and the pressure and flow of the sheet."""
        tables, oil = self.case.to_dict(), self.fit.machine.valve.oil
        load = dict(tables["load"])
        assert oil is not None
        sizes = {row["chamber"]: row["area_m2"] for row in self.passages}
        load["pressure"] = f"{self.given['pressure'] / 1e5:.6g} bar"
        load["chambers"] = {
            one.name: {"area": f"{1e4 * sizes[one.name]:.6g} cm^2", "side": one.side} for one in oil.chambers
            if one.name in sizes
        }  # fmt: skip
        load["states"] = {name: {join.chamber: join.to for join in joins} for name, joins in oil.pairs}
        load["orifices"] = [
            {"chamber": row["chamber"], "to": row["to"], "state": row["state"],
             "drop": f"{row['drop_Pa'] / 1e5:.6g} bar", "at": f"{6e4 * row['at_m3_s']:.6g} l/min"}
            for row in self.passages if row["drop_Pa"] > 0.0
        ]  # fmt: skip
        scale = self.fit.machine.length_scale
        ports = zip(load["ports"], self.fit.machine.valve.ports, strict=True)
        load["ports"] = [
            own if port.behind is None else {**own, "behind": f"{1e3 * port.behind * scale:.6g} mm"}
            for own, port in ports
        ]  # fmt: skip
        if "supply" in load and "flow" in load["supply"]:
            load["supply"] = {**load["supply"], "flow": f"{6e4 * self.given['flow']:.6g} l/min"}
        return self.case._with({**tables, "load": load})

    @property
    def summary(self) -> str:
        """What explains the sheet, in a sentence or two."""
        worst = max(self.passages, key=lambda row: row["drop_Pa"] * row["at_m3_s"])
        text = f"{percent(self.efficiency)} of the input reaches the steel; {percent(self.lost)} is lost in passages: "
        text += f"{worst['drop_Pa'] / 1e5:.3g} bar at {6e4 * worst['at_m3_s']:.3g} l/min"
        text += f" between the {worst['chamber']} chamber and the {worst['to']}."
        free = self.fit.lossless_energy * self.fit.machine.energy_scale
        return f"{text} Without losses the same pressure, flow and rate would give {quantity(free, 'J')} a blow."

    def to_json_dict(self) -> dict[str, Any]:
        """In plain values, as `percuss identify --energy … --json` prints it."""
        scale = self.fit.machine
        return {
            "case": self.case.file, "title": self.case.title, "given": dict(self.given),
            "areas": self.fit.areas, "places": self.fit.places, "passages_factor": self.fit.passages,
            "passages": self.passages, "losses": self.shares, "efficiency": self.efficiency,
            "stroke_m": self.fit.cycle.stroke * scale.length_scale,
            "impact_velocity_m_s": self.fit.cycle.blow_speed * scale.speed_scale,
            "lossless_energy_J": self.fit.lossless_energy * scale.energy_scale,
        }  # fmt: skip

    def report(self) -> Report:
        """What `percuss identify` prints."""
        machine, cycle = self.fit.machine, self.fit.cycle
        told = [
            (f"{row['chamber']} chamber", row["to"], row["state"], f"{1e4 * row['area_m2']:.4g} cm²",
             f"{row['drop_Pa'] / 1e5:.4g} bar at {6e4 * row['at_m3_s']:.4g} l/min")
            for row in self.passages
        ]  # fmt: skip
        rows = (
            ("areas", f"{number(self.fit.areas)} times those of the case"),
            ("ports", f"{number(self.fit.places)} times as far behind the tool"),
            ("stroke", quantity(cycle.stroke * machine.length_scale, "m")),
            ("speed", f"{number(cycle.blow_speed * machine.speed_scale)} m/s"),
            ("losses", ", ".join(f"{name.replace('_', ' ')} {percent(share)}" for name, share in self.shares.items()
                                 if share >= 5e-4)),
            ("assumed", "a constant pressure; the mass, the delays and the ratio of the areas of the case; each "
                        "passage takes the same pressure at the same speed of the piston, where the case has none"),
        )  # fmt: skip
        sections = (
            ReportSection("What explains the data sheet", rows),
            Grid("Passages", ("chamber", "to", "state", "area", "drop"), tuple(told)),
        )
        return Report(self.case.title, self.summary, GOOD, sections)


def data_sheet_answer(case: Case, pressure: float, flow: float, rate: float, energy: float) -> DataSheetAnswer:
    """What losses of its oil explain the data sheet of a hammer whose piston switches the valve.

    Parameters
    ----------
    pressure, flow, rate, energy
        Of the sheet, in Pa, m³/s, Hz and J; mass, delays and the ratio of areas are those of the case.

    Raises
    ------
    ParameterError
        For a case without units or valve, and figures that contradict each other.
    ConvergenceError
        Where no areas, places of ports and losses have these figures.

    Examples
    --------
    >>> from percuss.case import data_sheet_answer, load_case
    >>> found = data_sheet_answer(load_case("valve-drifter"), 175e5, 123 / 6e4, 68.0, 277.0)
    >>> f"{found.efficiency:.3f} {found.lost:.3f}"
    '0.504 0.473'
    """
    checked_case(case)
    pressure, flow = positive("pressure", pressure), positive("flow", flow)
    rate, energy = positive("rate", rate), positive("energy", energy)
    if not case.is_machine or not case.is_si:
        raise ParameterError("case", case.file, "a case in SI whose piston switches the valve")
    machine = case.machine()
    nominal = machine.pressure
    if nominal is None:
        raise ParameterError("case", case.file, "a valve by areas, beside its pressure", "give load.pressure and areas")
    try:
        fit = data_sheet(
            machine, pressure / nominal, flow * nominal / machine.power_scale, rate * machine.time_scale,
            energy / machine.energy_scale,
        )  # fmt: skip
    except ParameterError as error:
        if error.name != "energy":
            raise
        most = pressure * flow / rate / (1.0 - machine.contact.velocity_factor**2)
        raise ParameterError("energy", f"{energy:g} J", f"less than {most:.4g} J, which takes all of the input",
                             error.remedy) from None  # fmt: skip
    given = {"pressure": pressure, "flow": flow, "rate": rate, "energy": energy}
    return DataSheetAnswer(case, given, fit)
