"""Fatigue of striker and rod by a blow: what governs, safety factors and hours to failure, as text and JSON."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

from percuss.case.answers.facts import (
    BAD,
    PLAIN,
    Fact,
    Grid,
    ReportSection,
    Teller,
    figures,
    grid_of,
    number,
    plain_of,
    rows_of,
)
from percuss.short_repr import ShortRepr

if TYPE_CHECKING:
    from percuss.blow import Blow, Fatigue, SectionFatigue, Steel
    from percuss.case.file_format.steel import CaseSteel

_TELL = Teller(None, True)

LEFT_OUT = (
    "bending, threads and joints, corrosion, size and surface, preload and residual stress, what rings on after the "
    "window, the scatter of S–N lines, breaks from inclusions after very many cycles"
)
"""What such a life leaves out."""


class RatedSection(NamedTuple):
    """Fatigue of a section, and the blows per second, None where they are not known."""

    fatigue: SectionFatigue
    rate: float | None

    @property
    def hours(self) -> float | None:
        """Hours to failure; None where no cycle is above the limit, and without a rate."""
        blows = self.fatigue.blows
        return None if blows is None or self.rate is None else blows / self.rate / 3600.0

    @property
    def where(self) -> str:
        """The place in words."""
        end = "driven end" if self.fatigue.body == "striker" else "face"
        return f"{_TELL(self.fatigue.place, 'length')} from the {end}"


@dataclass(frozen=True)
class BlowFatigue(ShortRepr):
    """Fatigue of the sections of striker and rod by blows like one.

    Attributes
    ----------
    fatigue
        Of each section, at its worst place.
    steel
        The steels of bar and tool, and the notch factors.
    rate
        Blows per second, Hz: those of the hammer's own cycle; None where it has none.
    notes
        What was assumed, one sentence each.
    """

    fatigue: Fatigue
    steel: CaseSteel
    rate: float | None
    notes: tuple[str, ...] = ()

    @property
    def sections(self) -> tuple[RatedSection, ...]:
        """Of the striker, then of the rod."""
        return tuple(RatedSection(one, self.rate) for one in self.fatigue.sections)

    @property
    def governing(self) -> RatedSection:
        """The section that fails first, or that has the least factor."""
        return RatedSection(self.fatigue.governing, self.rate)

    @property
    def sentence(self) -> str:
        """What governs, the first line of a report."""
        return f"Governs: {_governs(self, _TELL)}."

    @property
    def parts(self) -> tuple[ReportSection | Grid, ...]:
        """The sections of a report."""
        rows = (*rows_of(self, FATIGUE, _TELL), *(("note", note) for note in self.notes), ("left out", LEFT_OUT))
        tone = BAD if self.governing.fatigue.factor < 1.0 else PLAIN
        return ReportSection("Fatigue", rows, tone), grid_of("Fatigue of the sections", self.sections, SECTION, _TELL)

    def to_json_dict(self) -> dict[str, Any]:
        """Its numbers in plain values."""
        return {
            **plain_of(self, FATIGUE),
            "notes": list(self.notes),
            "left_out": LEFT_OUT,
            "sections": [plain_of(one, SECTION) for one in self.sections],
        }


def blow_fatigue(blow: Blow, steel: CaseSteel, rate: float | None, assumed: bool) -> BlowFatigue:
    """Fatigue by blows like this one, in SI; `assumed` tells whether the case says nothing of its steel."""
    from percuss.blow import fatigue

    notes = [f"the case has no [steel]: {steel.name} is assumed"] if assumed else []
    if not steel.notches:
        notes.append("no notch factors in [steel]: every section counts as smooth, with no fillet, groove or hole")
    for body, one in (("striker", blow.striker), ("rod", blow.target)):
        for i, piece in enumerate(getattr(one, "pieces", ())):
            if not _STEEL[0] <= piece.youngs_modulus <= _STEEL[1]:
                notes.append(f"{body} {i} is not of steel, and is told as if it were")
    return BlowFatigue(fatigue(blow, steel.steel, steel.tool, notches=steel.notches), steel, rate, tuple(notes))


_STEEL = 180e9, 230e9
"""Young's moduli of steels, Pa."""


# ---- What is told of it


def _governs(one: BlowFatigue, tell: Teller) -> str:
    worst, rate = one.governing, one.rate
    text = f"{worst.fatigue.name}, {worst.where}, safety factor {number(worst.fatigue.factor, 3)}"
    if worst.fatigue.blows is None:
        return f"{text}: no cycle exceeds the fatigue limit"
    if worst.hours is None or rate is None:
        return f"{text}: {number(worst.fatigue.blows, 2)} blows to failure"
    return f"{text}: {number(worst.hours, 2)} hours to failure at {tell(rate, 'rate', 3)}"


def _line(steel: Steel, name: str) -> str:
    text = f"{name}: fatigue limit {_TELL(steel.fatigue_limit, 'stress')} at {steel.knee:.0e} cycles, slope "
    return f"{text}{number(steel.slope, 3)}, tensile strength {_TELL(steel.ultimate, 'stress')}"


def _tool_line(one: BlowFatigue, _: Teller) -> str | None:
    return None if one.steel.tool == one.steel.steel else _line(one.steel.tool, one.steel.tool_name)


STEEL: tuple[Fact[Steel], ...] = figures("""
ultimate | tensile strength, Pa
fatigue_limit | amplitude about 0 that is borne for ever, Pa
slope | of the S–N line above it
knee | cycles at which the line reaches it
""")
"""What a steel bears."""

FATIGUE: tuple[Fact[BlowFatigue], ...] = (
    Fact("governs", "governs", 'the section that fails first, or that has the least factor: `"rod 0"`', "",
         "governing.fatigue.name", _governs),
    Fact("safety_factor", "", "fatigue limit over the equivalent amplitude of its worst cycle; null without a stress",
         "", "governing.fatigue.factor"),
    Fact("blows", "", "blows to failure; null where no cycle exceeds the limit", "", "governing.fatigue.blows"),
    Fact("hours", "", "the same in hours at `blow_rate`; null, too, without one", "", "governing.hours"),
    Fact("blow_rate", "rate", "blows per second of the hammer's own cycle, Hz; null without one", "rate", "rate",
         lambda one, tell: "not known without a cycle of its own: lives are numbers of blows" if one.rate is None else
         f"{tell(one.rate, 'rate')}, that of the hammer's own cycle"),
    Fact("steel", "steel", "that of the bar, see below", "", lambda one: plain_of(one.steel.steel, STEEL),
         lambda one, _: _line(one.steel.steel, one.steel.name)),
    Fact("tool_steel", "of the tool", "that of the tool", "", lambda one: plain_of(one.steel.tool, STEEL), _tool_line),
    Fact("", "method", "how cycles are counted and added up", "", "",
         lambda *_: "exact turning points of the force, rainflow (ASTM E1049), Goodman for means in tension, no credit "
         "for those in compression; Miner, with Haibach's slope below the limit"),
)  # fmt: skip
"""Fatigue by a blow."""

SECTION: tuple[Fact[RatedSection], ...] = (
    Fact("section", "section", 'its body and its number from 0: `"striker 0"`, `"rod 0"`', "", "fatigue.name",
         lambda one, _: one.fatigue.name),
    Fact("notch", "notch", "fatigue notch factor, which all stresses here have", "", "fatigue.notch"),
    Fact("range", "range", "of the cycle that does most, at the worst place, Pa", "stress", "fatigue.range",
         "{fatigue.range:stress}"),
    Fact("mean", "mean", "of this cycle, Pa; tension is positive", "stress", "fatigue.mean", "{fatigue.mean:stress}"),
    Fact("equivalent_amplitude", "", "amplitude about 0 that does as much, by Goodman, Pa", "stress",
         "fatigue.amplitude"),
    Fact("place", "where", "the worst place, m from the driven end of the striker or the face of the rod", "length",
         "fatigue.place", "{fatigue.place:length}"),
    Fact("cycles_above_limit", "above the limit", "cycles of one blow there that exceed the limit", "", "fatigue.over"),
    Fact("safety_factor", "safety factor", "fatigue limit over `equivalent_amplitude`; null without a stress", "",
         "fatigue.factor", lambda one, _: number(one.fatigue.factor, 3)),
    Fact("damage", "", "share of the life that a blow takes; 0 where no cycle exceeds the limit", "", "fatigue.damage"),
    Fact("blows", "blows", "blows to failure; null where no cycle exceeds the limit", "", "fatigue.blows",
         lambda one, _: "no end" if one.fatigue.blows is None else number(one.fatigue.blows, 2)),
    Fact("hours", "hours", "the same in hours; null, too, without a rate", "", "hours",
         lambda one, _: "" if one.hours is None else number(one.hours, 2)),
)  # fmt: skip
"""Fatigue of a section."""
