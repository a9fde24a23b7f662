"""Where the energy of a cycle goes: from what drives it through its own blow, by waves, into the tool and the rock."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from operator import attrgetter
from typing import TYPE_CHECKING, Any, NamedTuple

from percuss.case.answers.facts import (
    PLAIN,
    Fact,
    ReportSection,
    Teller,
    counted,
    number,
    percent,
    picked,
    plain_of,
    rows_of,
)
from percuss.short_repr import ShortRepr

if TYPE_CHECKING:
    from percuss.blow import Blow, Peak
    from percuss.case.case import Case
    from percuss.case.file_format.contact import BlowQuestion
    from percuss.steady import Orbit
    from percuss.steady.self_excited.valve_cycle import ValveCycle

ASSUMED = "a tool that nothing holds against the rock (no feed), and steel that nothing damps"
"""What a share of the energy that reaches the rock assumes."""


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
        return self._energy("damping")

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
        """What waves in the tool have left at the end of the blow, with that of its masses, or take away for ever."""
        return self.blow.rod_energy + self.blow.bit_kinetic_energy_after

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
        losses = (self.drag_loss, self.ringing_before, self.rebound_difference, self.blow.vibration_energy_after)
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
    from percuss.blow import BlowOutcome, strike
    from percuss.blow.striking import FEW_PIECES

    system, until = motion.system, question.until
    speed = motion.rigid_velocity * (system.speed_scale if system.is_si else 1.0)
    blow = strike(question.striker, question.target, speed, until=until, few_pieces=FEW_PIECES)
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
         f"{{overall_efficiency:percent}} of the input of {{input_power:power}}; it assumes {ASSUMED}"),
    Fact("input_power", "", "`input` over time", "power", "input_power"),
    Fact("input", "input", "what the load, the valve or the pump puts into a cycle", "energy", "input",
         "{input:energy} a cycle"),
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
    Fact("imbalance", "closes to", "what is left of `input` after `rock_energy` and these five, relative", "",
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
