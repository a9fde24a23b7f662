"""Hammers side by side: where their cases differ, and what that makes of their figures."""

from __future__ import annotations

import re
import string
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

from percuss.case.answers.blows.blow_answer import blow_answer
from percuss.case.answers.exploring.tolerance import uncertainty_of
from percuss.case.answers.facts import BAD, GOOD, Grid, Report, ReportSection, json_number, number
from percuss.case.answers.machine_answer import MachineAnswer, headline, machine_answer
from percuss.case.answers.steady_answer import SteadyAnswer, steady_answer
from percuss.case.answers.steady_report import summary_of
from percuss.case.answers.whole_hammer import WHOLE_FIGURES, WholeFigure
from percuss.case.case import checked_case, json_tables
from percuss.errors import ParameterError
from percuss.model.checks import several, text
from percuss.short_repr import ShortRepr

if TYPE_CHECKING:
    from percuss.case.answers.blows.blow_answer import BlowAnswer
    from percuss.case.case import Case
    from percuss.steady import Orbit
    from percuss.steady.self_excited.valve_cycle import ValveCycle

MOST = 8
"""The most hammers of one comparison."""

_SPOKEN = ("blow_energy", "blow_rate", "power", "rock_power")
_NO_RATIOS = ("phase", "margin")
_SAME = 1e-12  # share of a figure that rounding makes


@dataclass(frozen=True)
class ComparedFigure:
    """A figure of several hammers.

    Attributes
    ----------
    name
        As maps have it.
    values
        Of each hammer, in base units; None where it has none.
    is_si
        Whether they have units.
    """

    name: str
    values: tuple[float | None, ...]
    is_si: bool

    @property
    def figure(self) -> WholeFigure:
        """What it is."""
        return WHOLE_FIGURES[self.name]

    @property
    def label(self) -> str:
        """What reports call it."""
        return self.figure.label

    @property
    def unit(self) -> str:
        """That of the values, without a prefix; "" for a share, and of dimensionless hammers."""
        return self.figure.unit if self.is_si else ""

    @property
    def changes(self) -> tuple[float | None, ...]:
        """By how much each is greater than that of the first hammer, as a share of it; None where that says nothing."""
        first = self.values[0]
        if self.name in _NO_RATIOS:
            return tuple(None for _ in self.values)
        found = [None if not first or value is None else value / first - 1.0 for value in self.values]
        return tuple(one and (one if abs(one) > _SAME else 0.0) for one in found)


@dataclass(frozen=True)
class Comparison(ShortRepr):
    """Several hammers, each with its answer.

    Attributes
    ----------
    names
        What each is called: its file, and what was set in it.
    cases
        Their cases, all in SI or all dimensionless.
    answers
        How each moves, as `steady_answer` and `machine_answer` have it.
    """

    names: tuple[str, ...]
    cases: tuple[Case, ...]
    answers: tuple[SteadyAnswer | MachineAnswer, ...]

    @cached_property
    def motions(self) -> tuple[Orbit | ValveCycle | None, ...]:
        """The motion that each is compared by: the one to look at first; None where it has none."""
        return tuple(answer.whole.motion for answer in self.answers)

    @property
    def runs(self) -> tuple[bool, ...]:
        """Whether each can sustain its motion."""
        return tuple(answer.whole.runs for answer in self.answers)

    @property
    def letters(self) -> str:
        """A letter for each hammer."""
        return string.ascii_uppercase[: len(self.cases)]

    @cached_property
    def differences(self) -> tuple[tuple[str, tuple[str, ...]], ...]:
        """The keys in which the cases differ, and the values of each as it writes them; "" where it has none."""
        tables = [dict(_flat(json_tables(case))) for case in self.cases]
        keys = dict.fromkeys(key for table in tables for key in table if key != "title")
        rows = ((key, tuple(table.get(key, "") for table in tables)) for key in keys)
        return tuple((key, values) for key, values in rows if len(set(values)) > 1)

    @cached_property
    def figures(self) -> tuple[ComparedFigure, ...]:
        """What each blow, and each cycle, has that several hammers can be compared by."""
        wholes, is_si = [answer.whole for answer in self.answers], self.cases[0].is_si
        rows = (ComparedFigure(name, tuple(one.value(name) for one in wholes), is_si) for name in WHOLE_FIGURES)
        known = (row for row in rows if any(row.values))
        return tuple(row for row in known if row.name != "phase" or not any(case.is_machine for case in self.cases))

    @cached_property
    def blows(self) -> tuple[BlowAnswer, ...]:
        """One blow of each by waves, with the speed of its motion; none where a case has no tool, or no blow."""
        if any(case.tables.tool is None for case in self.cases):
            return ()
        speeds = [answer.whole.value("rigid_velocity") for answer in self.answers]
        if any(value is None or value <= 0.0 for value in speeds):
            return ()
        return tuple(map(blow_answer, self.cases, speeds))

    @property
    def summary(self) -> str:
        """The answer in a sentence or two."""
        stopped = [letter for letter, runs in zip(self.letters, self.runs, strict=True) if not runs]
        told = [self._changed(i) for i in range(1, len(self.cases))]
        if stopped:
            told.append(f"{' and '.join(stopped)} cannot sustain {'its' if len(stopped) == 1 else 'their'} motion.")
        return " ".join(told)

    def _changed(self, i: int) -> str:
        rows = {row.name: row for row in self.figures}
        parts = []
        for name in _SPOKEN:
            change = rows[name].changes[i] if name in rows else None
            if change:
                parts.append(f"{rows[name].label} {_percent(change)}")
        if "margin" in rows and None not in (pair := (rows["margin"].values[0], rows["margin"].values[i])):
            before, after = (number(value, 3) for value in pair if value is not None)
            parts += [f"margin {before} to {after}"] if before != after else []
        same = "as A to all digits shown" if self.differences else "the same case as A"
        return f"{self.letters[i]} against A: {', '.join(parts) if parts else same}."

    def _told(self, row: ComparedFigure, i: int) -> str:
        """A figure of one hammer, with its ± where that is known."""
        given, value = self.answers[i].uncertainty, row.values[i]
        assert value is not None
        return (given and given.told(row.name)) or row.figure.tell(value, row.is_si)

    def to_json_dict(self) -> dict[str, Any]:
        """The answer in plain values, as `percuss compare --json` prints it."""
        hammers = zip(self.letters, self.names, self.cases, self.runs, self.answers, strict=True)
        return {
            "hammers": [
                {"letter": letter, "case": name, "title": case.title, "runs": runs, "summary": _sentence(answer)}
                for letter, name, case, runs, answer in hammers
            ],
            "summary": self.summary,
            "differences": [{"key": key, "values": list(values)} for key, values in self.differences],
            "figures": [
                {
                    "name": row.name, "label": row.label, "unit": row.unit,
                    "values": [json_number(value) for value in row.values],
                    "changes": [json_number(change) for change in row.changes],
                }
                for row in self.figures
            ],
        }  # fmt: skip

    def report(self) -> Report:
        """What `percuss compare` prints."""
        hammers = zip(self.letters, self.names, self.answers, strict=True)
        who = tuple((f"{letter}  {name}", _sentence(answer)) for letter, name, answer in hammers)
        heads = tuple(self.letters)
        differ = tuple((key, *(value or "–" for value in values)) for key, values in self.differences)
        against = tuple(f"{letter} − A" for letter in heads[1:])
        rows = tuple(
            (
                row.label,
                *("–" if value is None else self._told(row, i) for i, value in enumerate(row.values)),
                *("–" if change is None else _percent(change) for change in row.changes[1:]),
            )
            for row in self.figures
        )
        cases = Grid("Where the cases differ", ("key", *heads), differ or (("nowhere", *("" for _ in heads)),))
        figures = Grid("Figures", ("figure", *heads, *against), rows)
        title = " / ".join(dict.fromkeys(case.title or name for case, name in zip(self.cases, self.names, strict=True)))
        sections = (ReportSection("Hammers", who), cases, figures)
        return Report(title, self.summary, GOOD if all(self.runs) else BAD, sections)


def compare(cases: Sequence[Case], names: Sequence[str] = (), modes: int | None = None) -> Comparison:
    """Hammers side by side: where their cases differ, and the figures of the motion that each is looked at for first.

    Parameters
    ----------
    cases
        Two to eight of them, all in SI or all dimensionless, of any kinds.
    names
        What each is called; none for their files.
    modes
        Elastic modes, as `steady_answer` and `machine_answer` take them.

    Raises
    ------
    ParameterError
        For fewer cases or more, and for some in SI beside dimensionless ones, which have no figure in common.

    Examples
    --------
    >>> from percuss.case import compare, load_case
    >>> drifter = load_case("hydraulic-drifter")
    >>> both = compare([drifter, drifter.varied({"contact.restitution": 0.3})])
    >>> both.differences
    (('contact.restitution', ('0.2', '0.3')),)
    >>> row = next(row for row in both.figures if row.name == "blow_energy")
    >>> print(f"{row.values[0]:.0f} J, {row.values[1]:.0f} J, {row.changes[1]:.1%}")
    310 J, 264 J, -14.8%
    """
    cases = several("cases", cases, f"2 to {MOST} cases")
    for case in cases:
        checked_case(case)
    names = several("names", names, "a name for each case") or tuple(case.file for case in cases)
    if not 2 <= len(cases) <= MOST or len(names) != len(cases):
        raise ParameterError("cases", f"{len(cases)}, {len(names)} names", f"2 to {MOST} cases, each with a name")
    names = tuple(text("names", name, "a name for each case") for name in names)
    if len({case.is_si for case in cases}) > 1:
        remedy = "a dimensionless case has no scales: give each hammer in SI"
        raise ParameterError("cases", "in SI and dimensionless", "all in SI, or all dimensionless", remedy)
    answers = []
    for case in cases:
        answer = machine_answer(case, modes) if case.is_machine else steady_answer(case, (1,), modes)
        answers.append(replace(answer, uncertainty=uncertainty_of(case, modes)))
    return Comparison(names, cases, tuple(answers))


def _sentence(answer: SteadyAnswer | MachineAnswer) -> str:
    if isinstance(answer, MachineAnswer):
        return headline(answer)
    return re.sub("; see below.*", ".", summary_of(answer).text)


def _percent(change: float) -> str:
    """A change with its sign."""
    shown = change if abs(change) > 5e-6 else 0.0
    return f"{'+' if shown > 0.0 else ''}{number(100.0 * shown, 3)} %".replace("-", "−")


def _flat(table: Any, key: str = "") -> Iterator[tuple[str, str]]:
    """The dotted keys of tables, and their values as text."""
    if isinstance(table, dict):
        for name, value in table.items():
            yield from _flat(value, f"{key}.{name}" if key else name)
    elif isinstance(table, list) and table and isinstance(table[0], dict):
        for i, value in enumerate(table):
            yield from _flat(value, f"{key}[{i}]")
    else:
        yield key, str(table)
