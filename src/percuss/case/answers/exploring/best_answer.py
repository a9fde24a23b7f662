"""The dispatcher's answer to "which sizes give the best blow?"."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from percuss.blow.best import OBJECTIVES
from percuss.blow.figures import FIGURES
from percuss.case.answers.blows.blow_answer import BlowAnswer, blow_answer
from percuss.case.answers.facts import BAD, GOOD, PLAIN, Grid, Report, ReportSection, number, percent, picked
from percuss.case.case import checked_case
from percuss.case.parameters.case_family import CaseFamily
from percuss.case.parameters.case_keys import LOAD_SCALE, with_generic_places
from percuss.case.parameters.moves import number_held
from percuss.case.parameters.spans import Span, check_ends, own_value, rounded
from percuss.errors import ParameterError
from percuss.model.checks import instance, several
from percuss.optimum import SearchProgress
from percuss.short_repr import ShortRepr

if TYPE_CHECKING:
    from percuss.blow import Blow
    from percuss.case.case import Case


_STEADY = ("load.", "contact.", "bar.damping", "bar.drag", "system.d", "system.restitution")
"""How the keys begin that a blow of given speed does not depend on."""

_END = 1e-6  # share of a range


@dataclass(frozen=True)
class BestAnswer(ShortRepr):
    """The case at its best, beside the case as it is.

    Attributes
    ----------
    objective, below
        What was looked for, and under which stress (Pa; dimensionless: force).
    own_values
        What the case has there, in the units of the ranges; None where it has nothing.
    case
        The best one, to be saved.
    own, best
        The blow of the case as it is, and at its best.
    allowed
        Whether any blow was below the limit.
    blows, seed
        How many were computed, and with which random numbers.
    complete
        Whether the search came to its end; false where `progress` ended it.
    """

    objective: str
    below: float | None
    spans: tuple[Span, ...]
    values: tuple[float, ...]
    own_values: tuple[float | None, ...]
    case: Case
    own: BlowAnswer
    best: BlowAnswer
    allowed: bool
    blows: int
    seed: int
    complete: bool = True

    @property
    def figures(self) -> dict[str, tuple[float | None, float | None]]:
        """Each figure of the case as it is, and at its best."""
        return {name: (one.value(self.own.blow), one.value(self.best.blow)) for name, one in FIGURES.items()}

    def to_json_dict(self) -> dict[str, Any]:
        """The answer in plain values, as `percuss blow --best --json` prints it."""
        together = zip(self.spans, self.own_values, self.values, strict=True)
        return {
            "case": self.own.name,
            "title": self.own.title,
            **picked(self, "objective below allowed blows seed complete"),
            "varied": [
                {"name": s.name, "unit": s.unit, "low": s.low, "high": s.high, "own": own, "best": best}
                for s, own, best in together
            ],
            "figures": {
                name: {"unit": FIGURES[name].unit if self.own.is_si else "", "own": own, "best": best}
                for name, (own, best) in self.figures.items()
            },
            "best_case": self.case.to_dict(),
        }


def best_answer(
    case: Case,
    spans: Sequence[Span],
    objective: str = "rock-energy",
    *,
    below: float | None = None,
    seed: int = 0,
    most: int = 1500,
    progress: Callable[[SearchProgress], object] | None = None,
) -> BestAnswer:
    """The sizes of a case that give the best blow.

    Parameters
    ----------
    spans
        What may vary, and between which values.
    objective, below, seed, most, progress
        See `percuss.blow.best.best_blow`.

    Raises
    ------
    CaseError, ParameterError
        When the case cannot be used, or has no such keys.
    Interrupted
        When `progress` ended the search before there was any blow.

    Examples
    --------
    >>> from percuss.case import load_case
    >>> spans = [Span.parsed("bar.length=100:300mm")]
    >>> found = best_answer(load_case("laboratory-striker"), spans, "efficiency", most=40)
    >>> found.best.blow.efficiency >= found.own.blow.efficiency
    True
    """
    from percuss.blow.best import best_blow  # loads the compiler

    checked_case(case)
    spans = [instance("spans", span, Span) for span in several("spans", spans, "a list of Span")]
    family = CaseFamily(case, {span.name: span.unit for span in spans})
    speed = case.blow_question().velocity
    keys = ranged_keys(family, spans, () if speed is None else _STEADY)
    own = blow_answer(case)
    _check_figure(own, objective)
    own_values = tuple(own_value(case, key, span.unit) for key, span in zip(keys, spans, strict=True))

    def varied(values: Sequence[float]) -> Case:
        return family.varied({span.name: rounded(v) for span, v in zip(spans, values, strict=True)})

    def made(values: tuple[float, ...]) -> Blow:
        return blow_answer(varied(values)).blow

    inside = [v is not None and span.low <= v <= span.high for v, span in zip(own_values, spans, strict=True)]
    first = [v for v in own_values if v is not None] if all(inside) else None
    ranges = [(span.low, span.high) for span in spans]
    if first is None:
        made(tuple(0.5 * (low + high) for low, high in ranges))  # a wrong key or unit says so
    found = best_blow(made, ranges, objective, below=below, first=first, seed=seed, most=most, progress=progress)
    best = varied(found.values)
    values = tuple(map(rounded, found.values))
    return BestAnswer(
        objective, below, tuple(spans), values, own_values, best, own, blow_answer(best), found.allowed,
        found.blows, seed, found.complete,
    )  # fmt: skip


def ranged_keys(family: CaseFamily, spans: Sequence[Span], but: tuple[str, ...] = ()) -> list[str]:
    """The keys that vary; ParameterError for one that the case has not, and for one that says nothing of the blow.

    `but`: how the latter begin.
    """
    known = [key for key in family.keys if key != LOAD_SCALE and not key.startswith(but)]
    found: list[str] = []
    for span in spans:
        try:
            key = family.key(span.name)
        except ParameterError as error:
            raise _unknown(span.name, known, error.remedy) from None
        if not key or key == LOAD_SCALE:
            raise _unknown(span.name, known)
        if key not in known:
            remedy = "without a velocity in [blow], that of the steady motion is taken"
            raise ParameterError("vary", span.name, "a key that a blow of the given speed depends on", remedy)
        if key in found:
            raise ParameterError("vary", key, "each key once")
        _, unit = number_held(family.case, key)
        if unit and not span.unit:
            told = f"{span.name}={span.low:g}:{span.high:g}{unit}"
            raise ParameterError(
                "vary", f"{span.name}={span.low:g}:{span.high:g}", "limits with a unit", f"such as {told}"
            )
        found.append(key)
    for span in spans:
        check_ends(family, span, family.varied)
    return found


def _unknown(name: str, known: Sequence[str], remedy: str = "") -> ParameterError:
    return ParameterError("vary", name, f"a key of the case: {', '.join(with_generic_places(known))}", remedy)


def _check_figure(own: BlowAnswer, objective: str) -> None:
    if objective in ("rock-energy", "efficiency") and own.blow.bit_force is None:
        needed, remedy = "a tool that ends in rock", 'give the case [tool] with end = "rock", and [rock]'
    elif objective == "incident-energy" and own.rod is None:
        needed, remedy = "a tool that is struck", "give the case [tool]"
    else:
        return
    raise ParameterError("best", objective, f"a case with {needed}", remedy)


# ---- The report: the best sizes and what they change, against the case as it is

_OF_UNITS = {"J": "energy", "Pa": "stress", "s": "time"}


def best_report(answer: BestAnswer) -> Report:
    searched = [("blows", f"{answer.blows}, seed {answer.seed}")]
    for span in answer.spans:
        searched.append(("range", f"{span.name} from {number(span.low)} to {number(span.high)} {span.unit}".rstrip()))
    figures = {
        name: (FIGURES[name].label, *(_figure(answer, name, value) for value in values), _change(*values))
        for name, values in answer.figures.items()
        if values != (None, None)
    }
    limit = "" if answer.below is None else answer.own.tell(answer.below, "stress")
    label, before, after, _ = figures[OBJECTIVES[answer.objective][0]]
    summary = f"The best blow found: {label} {after}; the case as it is: {before}."
    summary += f" No stress is above {limit}." if limit else ""
    if not answer.allowed:
        summary = f"No blow within these ranges keeps its stresses below {limit}; this one has the least."
    if not answer.complete:
        summary += " The search was interrupted: this is the best so far."
    sections = (
        ReportSection("The search", tuple(searched)),
        sizes(answer.spans, answer.own_values, answer.values),
        Grid("The blow", ("figure", "the case", "best", "change"), tuple(figures.values())),
    )
    tone = BAD if not answer.allowed else GOOD if answer.complete else PLAIN
    return Report(answer.own.title, summary, tone, sections)


def range_end(span: Span, value: float) -> str:
    """The end of its range at which a value stands: lower, upper, or neither ("")."""
    near = _END * (span.high - span.low)
    return "lower" if value <= span.low + near else "upper" if value >= span.high - near else ""


def sizes(spans: Sequence[Span], own_values: Sequence[float | None], values: Sequence[float]) -> Grid:
    """What varied, before and after."""
    rows = []
    for span, own, best in zip(spans, own_values, values, strict=True):
        unit = f" {span.unit}" if span.unit else ""
        end = f", at the {which} limit" if (which := range_end(span, best)) else ""
        was = "-" if own is None else f"{number(own, 6)}{unit}"
        rows.append((span.name, was, f"{number(best, 6)}{unit}{end}", _change(own, best)))
    return Grid("Sizes", ("key", "the case", "best", "change"), tuple(rows))


def _figure(answer: BestAnswer, name: str, value: float | None) -> str:
    if value is None:
        return "-"
    if name in ("rock_efficiency", "ringing"):
        return percent(value)
    return answer.own.tell(value, _OF_UNITS.get(FIGURES[name].unit, ""))


def _change(own: float | None, best: float | None) -> str:
    return "" if not own or best is None else f"{100.0 * (best / own - 1.0):+.1f} %"
