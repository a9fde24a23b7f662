"""Where the energy of a cycle goes, by its own blow into the tool and the rock, and how long bar and tool bear it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from operator import attrgetter
from typing import TYPE_CHECKING, Any, NamedTuple

from percuss.case.answers.facts import (
    BAD,
    PLAIN,
    Fact,
    Grid,
    ReportSection,
    Teller,
    counted,
    figures,
    grid_of,
    number,
    percent,
    picked,
    plain_of,
    rows_of,
    said,
)
from percuss.short_repr import ShortRepr

if TYPE_CHECKING:
    from percuss.blow import Blow, Fatigue, Peak, SectionFatigue, Steel
    from percuss.case.case import Case
    from percuss.case.file_format.contact import BlowQuestion
    from percuss.case.file_format.steel import CaseSteel
    from percuss.steady import Orbit
    from percuss.steady.self_excited.valve_cycle import ValveCycle


def assumed(target: object) -> str:
    """What a share of the energy that reaches the rock assumes of the tool, a rod.

    >>> from percuss.blow import Feed, Rock, Rod
    >>> from percuss.model import Section
    >>> assumed(Rod([Section(1.0, 1e-3)], "rock", rock=Rock(1e8), feed=Feed(8e3)))
    'steel that nothing damps'
    """
    missing = []
    if getattr(target, "feed", None) is None:
        missing.append("a tool that nothing holds against the rock (no feed)")
    if not any(getattr(target, "attenuation", ())):
        missing.append("steel that nothing damps")
    return ", and ".join(missing) or "waves in one dimension"


class PeakStress(NamedTuple):
    """The greatest stress of a body (dimensionless: force): its kind, in which section, where and when."""

    stress: float
    kind: str
    section: int
    place: float
    time: float


@dataclass(frozen=True)
class Transfer(ShortRepr):
    """The energy of a cycle with one blow, from its input to the rock.

    In SI of a hammer with scales, else with mass, length and the unit of time as 1. The blow is resolved by waves, at
    the mean speed that the bar has in the cycle, from a bar without stress.

    Attributes
    ----------
    motion
        The cycle: under a clock, or of a machine that switches its own valve.
    blow
        Its blow.
    """

    motion: Orbit | ValveCycle
    blow: Blow

    def _scaled(self, value: float, scale: str) -> float:
        system = self.motion.system
        return value * float(getattr(system, f"{scale}_scale")) if system.is_si else value

    def _energy(self, name: str) -> float:
        return self._scaled(float(getattr(self.motion.energy, name)), "energy")

    @property
    def tell(self) -> Teller:
        """Says its values with their units."""
        return Teller(None, self.motion.system.is_si)

    @property
    def period(self) -> float:
        """From blow to blow."""
        return self._scaled(self.motion.period, "time")

    @property
    def input(self) -> float:
        """What load, valve or pump put into a cycle."""
        return self._energy("input")

    @property
    def input_power(self) -> float:
        """The same over time."""
        return self.input / self.period

    @property
    def drag_loss(self) -> float:
        """What drag and damping take between two blows."""
        return self._energy("damping") - self.oil_loss

    @property
    def oil_loss(self) -> float:
        """What passages, leaks and the lines of oil that flows take."""
        oil = getattr(self.motion, "oil", None)
        return 0.0 if oil is None else self._scaled(oil.losses - oil.drag, "energy")

    @cached_property
    def _taken_as_a_whole(self) -> float:
        """What the law of the contact takes of the motion as a whole."""
        return self.motion.system.contact.energy_taken(self.blow.energy_before, 0.0)

    @property
    def ringing_before(self) -> float:
        """What the law takes of the ringing that is left from earlier blows."""
        return self._energy("impact") - self._taken_as_a_whole

    @property
    def rebound_difference(self) -> float:
        """What rebounds by waves and not in the cycle; 0 where the cycle has the restitution of its blow."""
        return self._taken_as_a_whole - (self.blow.energy_before - self.blow.rigid_energy_after)

    @property
    def steel_energy(self) -> float:
        """What waves in the tool have left at the end of the blow, with that of its masses, or take away for ever.

        What steel and joints take is in it, and what the feed brings is not.
        """
        blow = self.blow
        taken = blow.steel_loss + blow.joint_loss - blow.feed_work - blow.tool_energy_before
        return blow.rod_energy + blow.bit_kinetic_energy_after + taken

    @property
    def rock_energy(self) -> float | None:
        """Work on the rock in one blow; None without rock."""
        return None if self.blow.greatest_penetration is None else self.blow.rock_work

    @property
    def rock_power(self) -> float | None:
        """The same over time."""
        return None if self.rock_energy is None else self.rock_energy / self.period

    @property
    def overall_efficiency(self) -> float | None:
        """Work on the rock over the input; None without rock, or an input."""
        return None if self.rock_energy is None else self.share(self.rock_energy)

    def share(self, energy: float) -> float | None:
        """An energy over the input; None without one."""
        return energy / self.input if self.input > 0.0 else None

    @property
    def imbalance(self) -> float:
        """By how much the balance does not close, over the input."""
        losses = (
            self.oil_loss,
            self.drag_loss,
            self.ringing_before,
            self.rebound_difference,
            self.blow.vibration_energy_after,
        )
        return abs(self.input - sum(losses) - self.steel_energy - self.blow.rock_work) / max(self.input, 1e-300)

    @property
    def later_impulse(self) -> float:
        """Share of the impulse that comes after the first contact, by waves that come back to the bar."""
        return 1.0 - self.blow.contacts[0].impulse / self.blow.impulse

    @property
    def sections(self) -> tuple[Sequence[Peak], Sequence[Peak]]:
        """The peaks of each section of the bar, and of the tool."""
        from percuss.blow.bodies import striker_sections

        own = striker_sections(self.blow.striker).impedance.size
        return self.blow.peaks[:own], self.blow.peaks[own:]

    @cached_property
    def peaks(self) -> tuple[PeakStress | None, PeakStress | None]:
        """The greatest stresses of the bar and of the tool."""
        bar, tool = map(_greatest, self.sections)
        return bar, tool


def _greatest(peaks: Sequence[Peak]) -> PeakStress | None:
    found = [
        PeakStress(getattr(peak, kind), kind, i, getattr(peak, f"{kind}_place"), getattr(peak, f"{kind}_time"))
        for i, peak in enumerate(peaks)
        for kind in ("compression", "tension")
        if getattr(peak, f"{kind}_place") is not None
    ]
    return max(found, key=lambda one: one.stress, default=None)


def tool_of(case: Case) -> BlowQuestion | None:
    """The blow on the rod that a case describes in [tool]; None without one."""
    if case.tables.body is not None or case.tables.tool is None:
        return None
    from percuss.blow import Rod

    question = case.blow_question()
    return question if isinstance(question.target, Rod) else None


def transfer_of(motion: Orbit | ValveCycle | None, question: BlowQuestion | None) -> Transfer | None:
    """The energy of a cycle; None without a rod or one blow that reaches it."""
    if motion is None or question is None or motion.impacts != 1 or not motion.rigid_velocity > 0.0:
        return None
    from percuss.blow import BlowOutcome, Rod, blows_one_by_one, strike
    from percuss.blow.striking import FEW_PIECES

    system, until = motion.system, question.until
    speed = motion.rigid_velocity * (system.speed_scale if system.is_si else 1.0)

    def struck(rod: Rod, crater: float = 0.0) -> Blow:
        return strike(question.striker, rod, speed, until=until, crater=crater, few_pieces=FEW_PIECES)

    rod, of_machine = question.target, question.feed_of == "machine"
    assert isinstance(rod, Rod)
    blow = blows_one_by_one(struck, rod, rate=question.rate, of_machine=of_machine).first
    whole = blow.outcome is not BlowOutcome.TOO_MANY_PIECES and bool(blow.contacts)
    return Transfer(motion, blow) if whole else None


# ---- What is told of it


def _part(name: str, more: str = "") -> Callable[[Transfer, Teller], str | None]:
    """An energy, and what part it is of the input; no line where it is next to nothing."""

    def words(one: Transfer, tell: Teller) -> str | None:
        value = float(attrgetter(name)(one))
        share = one.share(value)
        if share is not None and abs(share) < _NOTHING:
            return None
        told = tell(value, "energy") + ("" if share is None else f" ({percent(share)})")
        return told + (f": {more}" if more else "")

    return words


_NOTHING = 1e-6  # of the input, or of the blow: no line of a report


def _speed(one: Transfer, tell: Teller) -> str:
    text = f"{tell(one.blow.mean_velocity_before, 'speed')}, the mean of the bar in the cycle; by waves R = "
    text += number(one.blow.effective_restitution or 0.0)
    if abs(one.rebound_difference) < _NOTHING * one.blow.energy_before:
        return text
    return f"{text}, and in the cycle R = {number(one.motion.system.contact.restitution)}"


def _steel(one: Transfer, tell: Teller) -> str | None:
    endless = getattr(one.blow.target, "end", "") == "infinite"
    where = "gone down the endless rod" if endless else "in waves and masses when the window ends"
    return _part("steel_energy", where)(one, tell)


def _difference(one: Transfer, tell: Teller) -> str | None:
    more = "more" if one.rebound_difference >= 0.0 else "less"
    text = f"so much {more} rebounds by waves than by the R of the case"
    return _part("rebound_difference", f'{text}; with restitution = "from the blow" they agree')(one, tell)


def _returned(one: Transfer, tell: Teller) -> str:
    blow = one.blow
    way = "with the bar at" if blow.mean_velocity_after < 0.0 else "with the bar, which goes on at"
    text = f"{tell(blow.rigid_energy_after, 'energy')} {way} {tell(abs(blow.mean_velocity_after), 'speed')}: kept"
    if len(blow.contacts) == 1:
        return f"{text}; no wave finds the bar at the tool again"
    again = counted(len(blow.contacts) - 1, "more contact")
    return f"{text}; waves come back in {again}, with {percent(one.later_impulse)} of the impulse"


def _peak(which: int) -> Callable[[Transfer, Teller], str | None]:
    def words(one: Transfer, tell: Teller) -> str | None:
        peak = one.peaks[which]
        if peak is None:
            return None
        where = f"section {peak.section}, {tell(peak.place, 'length')} from {('the driven end', 'its face')[which]}"
        return f"{tell(peak.stress, 'stress')} in {peak.kind}: {where}, after {tell(peak.time, 'time')}"

    return words


def _peak_dict(which: int) -> Callable[[Transfer], dict[str, Any] | None]:
    return lambda one: None if one.peaks[which] is None else picked(one.peaks[which], " ".join(PeakStress._fields))


TRANSFER: tuple[Fact[Transfer], ...] = (
    Fact("speed", "speed", "mean speed of the bar before the blow, that of the cycle", "speed",
         "blow.mean_velocity_before", _speed),
    Fact("effective_restitution", "", "$R$ of the blow by waves", "", "blow.effective_restitution"),
    Fact("rock_power", "into the rock", "power into the rock; null without rock, as the next two", "power",
         "rock_power", "{rock_power:power}, {rock_energy:energy} a blow"),
    Fact("rock_energy", "", "work on the rock in one blow", "energy", "rock_energy"),
    Fact("overall_efficiency", "efficiency", "this work over `input`", "", "overall_efficiency",
         lambda one, tell: said("{overall_efficiency:percent} of the input of {input_power:power}; it assumes "
                                f"{assumed(one.blow.target)}", one, tell)),
    Fact("input_power", "", "`input` over time", "power", "input_power"),
    Fact("input", "input", "what the load, the valve or the pump puts into a cycle", "energy", "input",
         "{input:energy} a cycle"),
    Fact("oil_loss", "in the oil", "what passages, leakage, relief valve and the line to the tank take of it", "energy",
         "oil_loss", _part("oil_loss", "passages, leaks, relief and the line to the tank")),
    Fact("drag_loss", "drag", "what drag and damping take of it between two blows", "energy", "drag_loss",
         _part("drag_loss", "drag and damping between the blows")),
    Fact("ringing_before", "earlier ringing", "what the law of the contact takes of the ringing that is left from "
         "earlier blows", "energy", "ringing_before", _part("ringing_before", "taken at the blow")),
    Fact("rebound_difference", "rebound", "what rebounds by waves and not by the restitution of the cycle; 0 where "
         'that is `"from the blow"`', "energy", "rebound_difference", _difference),
    Fact("ringing_energy", "in the bar", "what rings in the bar after the blow", "energy",
         "blow.vibration_energy_after", _part("blow.vibration_energy_after", "rings in it after the blow")),
    Fact("steel_energy", "in the tool", "what waves in the tool have left at the end of the window, or what went down "
         "an endless one", "energy", "steel_energy", _steel),
    Fact("imbalance", "closes to", "what is left of `input` after `rock_energy` and these six, relative", "",
         "imbalance", lambda one, _: f"{one.imbalance:.1e} of the input"),
    Fact("rebound_energy", "comes back", "what rebounds with the bar, which is not lost", "energy",
         "blow.rigid_energy_after", _returned),
    Fact("rebound_speed", "", "its mean speed; negative where it goes on", "speed",
         lambda one: 0.0 - one.blow.mean_velocity_after),
    Fact("contacts", "", "contacts of the blow", "", lambda one: len(one.blow.contacts)),
    Fact("later_impulse", "", "share of the impulse after the first of them", "", "later_impulse"),
    Fact("peak_of_bar", "stress in the bar", "the greatest stress in the bar, see below", "", _peak_dict(0), _peak(0)),
    Fact("peak_of_tool", "stress in the tool", "the same in the tool", "", _peak_dict(1), _peak(1)),
    Fact("outcome", "window", "how the window of the blow ended", "",
         lambda one: one.blow.outcome.name.lower(),
         lambda one, tell: f"{tell(one.blow.until, 'time')}; {one.blow.outcome.value}"),
    Fact("fineness", "waves", 'how finely the waves were followed: `"exact"`, or `"smoothed"` or `"coarse"` where they '
         "have too many pieces", "",
         lambda one: one.blow.fineness.name.lower(),
         lambda one, _: one.blow.fineness.value if one.blow.fineness.name != "EXACT" else None),
)  # fmt: skip
"""Where the energy of a cycle goes."""


def transfer_dict(found: Transfer | None) -> dict[str, Any]:
    """What the JSON of an answer has of it."""
    return {"transfer": None if found is None else plain_of(found, TRANSFER)}


def transfer_section(found: Transfer, whose: str = "") -> ReportSection:
    """The section of a report."""
    heading = "Into the rock" if found.rock_energy is not None else "Into the tool"
    return ReportSection(f"{heading}{whose}", tuple(rows_of(found, TRANSFER, found.tell)), PLAIN)


def transfer_sentence(found: Transfer | None) -> str:
    """What reaches the rock, in one sentence; "" without rock."""
    if found is None or found.rock_power is None or found.overall_efficiency is None:
        return ""
    return f"{found.tell(found.rock_power, 'power')} reach the rock, {percent(found.overall_efficiency)} of the input."


# ---- Fatigue of bar and tool

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
