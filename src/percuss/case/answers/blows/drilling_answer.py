"""What holds a tool, and what its blows are worth: figures and sections of the answer to one blow, or to several."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

from percuss.case.answers.facts import (
    BAD,
    PLAIN,
    Fact,
    Grid,
    ReportSection,
    Teller,
    figures,
    number,
    percent,
    plain_of,
    quantity,
    rows_of,
)
from percuss.short_repr import ShortRepr

if TYPE_CHECKING:
    from percuss.blow import Blow, BlowsOneByOne, ContactInterval, JointTurns, Peak

ONE_BY_ONE = 0.05  # E_left's share of the penetration up to which blows may be treated one by one
_SECONDS = 60.0  # of a minute


@dataclass(frozen=True, eq=False)
class Drilled(ShortRepr):
    """Blows on a tool, told by the first of them.

    Attributes
    ----------
    all
        The blows.
    """

    all: BlowsOneByOne

    @property
    def blow(self) -> Blow:
        """The first blow."""
        return self.all.first

    @property
    def tool(self) -> Any:
        """The rod that is struck."""
        return self.blow.target

    @property
    def feed_force(self) -> float | None:
        """On the tool; None without a feed."""
        return self.all.feed_force

    # -- the static state --

    @property
    def static_force(self) -> float:
        """On the rock."""
        return self.feed_force or 0.0

    @property
    def static_penetration(self) -> float | None:
        """Of the bit before the blow, from the original surface."""
        from percuss.blow.drilling import rest_penetration

        return rest_penetration(self.blow, self.blow.penetration_before or 0.0)

    @property
    def static_penetration_after(self) -> float | None:
        """Where the bit will come to rest."""
        from percuss.blow.drilling import rest_penetration

        return rest_penetration(self.blow, self.blow.greatest_penetration or 0.0)

    @property
    def advance(self) -> float | None:
        """By how much it rests deeper after the blow."""
        before, after = self.static_penetration, self.static_penetration_after
        return None if before is None or after is None else after - before

    # -- after the blow --

    @property
    def returned_energy(self) -> float:
        """M V²/2 of the striker's mean velocity after."""
        return self.blow.rigid_energy_after

    @property
    def rock_force_after(self) -> float | None:
        """On the rock at the end of the window."""
        force = self.blow.bit_force
        return None if force is None else float(force.before(self.blow.until))

    @cached_property
    def bit_contacts(self) -> tuple[ContactInterval, ...]:
        """When the bit pressed on the rock."""
        from percuss.blow.drilling import bit_contacts

        return bit_contacts(self.blow)

    @property
    def contacts_of_bit(self) -> list[list[float | None]]:
        """Start, end, impulse and greatest force of each."""
        return [[one.start, one.end, one.impulse, one.peak_force] for one in self.bit_contacts]

    @property
    def contacts(self) -> list[list[float | None]]:
        """The same of the faces."""
        return [[one.start, one.end, one.impulse, one.peak_force] for one in self.blow.contacts]

    @property
    def joints(self) -> tuple[JointTurns, ...]:
        """When joints opened."""
        from percuss.blow.drilling import joint_turns

        return joint_turns(self.blow)

    @property
    def joint_opens(self) -> list[float]:
        """All times at which joints opened."""
        return sorted(time for joint in self.joints for time in joint.opens)

    @property
    def joint_closes(self) -> list[float]:
        """All times at which they met again."""
        return sorted(time for joint in self.joints for time in joint.closes)

    @property
    def tension(self) -> Peak:
        """The greatest tension in the tool."""
        return max(self.blow.peaks[self.blow._course.striker :], key=lambda peak: peak.tension)

    @property
    def tension_section(self) -> int:
        """Where it is."""
        return self.blow.peaks[self.blow._course.striker :].index(self.tension)

    @property
    def rate_per_minute(self) -> float | None:
        """Rate of penetration in m/min."""
        rate = self.all.rate_of_penetration
        return None if rate is None else _SECONDS * rate

    def to_json_dict(self) -> dict[str, Any]:
        """The answer's keys about what holds the tool."""
        told = plain_of(self, HELD) | plain_of(self, DRILLING) | {"static": plain_of(self, STATIC)}
        if self.all.number > 1:
            told["per_blow"] = [plain_of(one, BLOW) for one in self.each]
        return told

    @cached_property
    def each(self) -> list[Drilled]:
        """Those blows that differ, each by itself."""
        return [Drilled(replace(self.all, blows=(blow,))) for blow in self.all.blows]


# ---- What is told, in JSON and in reports


def _share(value: float, one: Drilled) -> str:
    before = one.blow.energy_before
    return f" ({percent(value / before)})" if before > 0.0 else ""


def _energy(path: str, label: str, meaning: str, key: str = "") -> Fact[Drilled]:
    """An energy and its share of the striker's; no line where there is none of it."""

    def words(one: Drilled, tell: Teller) -> str | None:
        value = fact.found(one)
        return None if not value else f"{tell(value, 'energy')}{_share(value, one)}"

    fact: Fact[Drilled] = Fact(key or path.rpartition(".")[2], label, meaning, "energy", path, words)
    return fact


def _left_words(one: Drilled, tell: Teller) -> str:
    told = f"{tell(one.all.energy_left, 'energy')}{_share(one.all.energy_left, one)}"
    when = "when the next blow comes" if one.all.rate is not None else "at the end of the window"
    bound = one.all.left_bound
    if bound is None:
        return f"{told} at most {when}"
    text = f"{told} at most {when}: it may change the penetration of a next blow by {percent(bound)}, not more"
    if bound <= ONE_BY_ONE:
        return text
    return f'{text}; above 5 % blows are not independent: follow them with their waves, between = "waves"'


def _stands_words(one: Drilled, tell: Teller) -> str | None:
    least, force = one.all.least_feed, one.feed_force
    if one.all.stands is None or least is None or force is None:
        return None
    if least == 0.0:
        return "yes: the bit does not leave the rock"
    told = f"a feed force above {tell(least, 'force')} brings the tool back in time; it is {tell(force, 'force')}"
    return f"yes: {told}" if one.all.stands else f"no, the bit is off the rock then: {told}"


def _machine_words(one: Drilled, tell: Teller) -> str | None:
    if one.all.machine_force is None or one.feed_force is None or one.all.recoil_force is None:
        return None
    recoil = tell(one.all.recoil_force, "force")
    return f"{tell(one.all.machine_force, 'force')} on the machine, of which the blows take {recoil}, rate × impulse"


STATIC: tuple[Fact[Drilled], ...] = (
    Fact("force", "", "on the rock", "", "static_force"),
    Fact("penetration", "", "of the bit, from the original surface; null without rock", "", "static_penetration"),
    Fact("strain_energy", "", "in the tool", "", "blow.tool_energy_before"),
)
"""The tool before the blow."""

HELD: tuple[Fact[Drilled], ...] = (
    Fact("feed_force", "", "only with a rod, as all keys that follow: the feed force on the tool; null without one", "",
         "feed_force"),
    Fact("machine_force", "machine", "the feed force on the machine, where the case gives that", "",
         "all.machine_force", _machine_words),
    _energy("blow.tool_energy_before", "preload", "strain energy of the static state", "tool_energy_before"),
    _energy("blow.feed_work", "work of the feed", r"$\int Q\,v\,dt$: the three keys that follow, less the loss"),
    Fact("feed_force_work", "", "what the constant force does of it", "", "blow.feed_force_work"),
    Fact("recoil_spring_work", "", "what the spring of a recoil damper does", "", "blow.recoil_spring_work"),
    _energy("blow.recoil_damper_loss", "in the recoil damper", "what its dashpot takes"),
    _energy("blow.steel_loss", "in the steel", "what attenuation takes, less what it gives back of the preload"),
    _energy("blow.joint_loss", "in joints", "what the dashpots of joints take"),
    _energy("blow.joint_energy_change", "held by joints", "rise of the energy in masses and springs of joints"),
    _energy("blow.energy_out_of_the_end", "out of the end", "what has gone down an endless rod"),
    _energy("blow.tool_energy_after", "left in the tool", "energy of sections and bit, preload included"),
    _energy("all.energy_left", "", r"$E_\mathrm{left}$, a bound of what departs from the static state when the next "
            "blow comes, or at the end of the window without a rate"),
    Fact("left_bound", "still under way", r"$\sqrt{E_\mathrm{left}/(K_1U^2/2)}$, by which share this may change the "
         "penetration of the next blow; null without rock", "", "all.left_bound", _left_words),
    Fact("bit_stands", "next blow", "whether the bit is back on the rock when the next blow comes; null without a "
         "rate, a feed or rock", "", "all.stands", _stands_words),
    Fact("least_feed", "", "$2fP_r$, the feed force above which it is; null without a rate", "", "all.least_feed"),
    Fact("mean_rock_force", "mean force", "on the rock, feed force and rate × impulse; null without either", "force",
         "all.mean_rock_force", "{all.mean_rock_force:force} on the rock: feed force and rate × impulse, "
         "{all.recoil_force:force}"),
    Fact("joint_opens", "joints", "times at which joints of the kind contact opened", "", "joint_opens",
         lambda one, tell: "; ".join(
             f"that at step {joint.at} opens at {tell(joint.opens[0], 'time')}, {len(joint.opens)} × in all"
             if joint.opens else f"that at step {joint.at} stays shut" for joint in one.joints) or None),
    *figures(r"""
joint_closes | times at which they met again, or a thread caught them
bit_contacts | likewise as `contacts`, of bit and rock | contacts_of_bit
backward_momentum | $P_r$, the greatest momentum with which the tool leaves the rock | all.backward_momentum
recoil_force | rate × impulse, with which the blows push the machine back; null without a rate | all.recoil_force
returned_energy | $\frac12MV_1^2$, as `rigid_energy_after`
tool_dynamic_energy_after | of the waves in the tool that depart from the static state | blow.tool_dynamic_energy
tool_momentum_after | of sections and bit, without joints | blow.tool_momentum
face_advance | how far the struck face has moved | blow.face_advance
rock_impulse | $\int F\,dt$ on the rock | blow.rock_impulse
rock_force_after | on the rock at the end of the window
static_penetration_after | where the bit comes to rest under the feed
advance | by how much that is deeper than before the blow
"""),
)  # fmt: skip
"""What holds the tool, and where the energy goes besides the rock."""

DRILLING: tuple[Fact[Drilled], ...] = (
    Fact("advance_per_blow", "advance per blow", "by the crater factor or the specific energy of `[drilling]`; null "
         "without it, as the keys that follow", "", "all.advance_per_blow", "{all.advance_per_blow:length}"),
    Fact("rate_of_penetration_m_per_min", "rate of penetration", "advance × rate in m/min", "", "rate_per_minute",
         lambda one, _: None if one.rate_per_minute is None else f"{number(one.rate_per_minute)} m/min"),
    Fact("specific_energy_rock", "specific energy", "what stays in the rock per volume drilled, J/m³", "",
         "all.specific_energy_rock",
         lambda one, _: None if one.all.specific_energy_rock is None or one.all.specific_energy_blow is None else
         f"{quantity(one.all.specific_energy_rock, 'J')}/m³ of the rock, "
         f"{quantity(one.all.specific_energy_blow, 'J')}/m³ of the striker"),
    *figures("""
specific_energy_blow | energy of the striker per volume drilled, J/m³ | all.specific_energy_blow
"""),
)  # fmt: skip
"""What the blows are worth."""

BLOW: tuple[Fact[Drilled], ...] = figures("""
energy_before | as above, of this blow | blow.energy_before
rock_work | likewise | blow.rock_work
rock_work_dissipated | likewise | blow.rock_dissipated
rock_impulse | likewise | blow.rock_impulse
impulse | likewise | blow.impulse
returned_energy | likewise
mean_velocity_after | likewise | blow.mean_velocity_after
greatest_penetration | from the original surface, as all | blow.greatest_penetration
residual_penetration | likewise | blow.residual_penetration
penetration_after | likewise | blow.penetration_after
advance | likewise
feed_work | likewise | blow.feed_work
recoil_damper_loss | likewise | blow.recoil_damper_loss
steel_loss | likewise | blow.steel_loss
tool_dynamic_energy_after | likewise | blow.tool_dynamic_energy
contacts | likewise, times from the start of this blow | contacts
bit_contacts | likewise | contacts_of_bit
""")
"""One of several blows."""


def taken_singly(bound: float) -> str:
    """Whether blows may be taken one by one, by √(E_left/W_load)."""
    told = f"waves that blows leave in the tool may change a penetration by up to {percent(bound)}"
    return f"{told}: blows {'may' if bound <= ONE_BY_ONE else 'must not'} be taken one by one"


def warned(stands: bool | None, bound: float | None) -> list[str]:
    """What is to be known of blows that follow each other: of the bit, and of the waves left in the tool."""
    found = [] if stands is not False else ["the bit is off the rock when a blow comes: more feed, or a recoil damper"]
    return found if bound is None or bound <= ONE_BY_ONE else [*found, taken_singly(bound)]


def said_first(one: Drilled, tell: Teller) -> list[tuple[str, str]]:
    """What is to be known of every blow with a tool: whether it is fed, and whether its steel takes anything."""
    rod, feed = one.tool, one.tool.feed
    if feed is None:
        told = "none: nothing holds the tool before the blow or brings it back"
    else:
        where = "the struck face" if feed.at == 0 else f"step {feed.at}"
        told = f"{tell(feed.force, 'force')} on {where} of the tool"
        if feed.stiffness > 0.0:
            told += f", spring {quantity(feed.stiffness, 'N/m')}"
        told += f", dashpot {quantity(feed.damping, 'N s/m')}" if feed.damping > 0.0 else ""
        told += "" if feed.stiffness > 0.0 or feed.damping > 0.0 else ", constant: no recoil damper"
    losses = [alpha for alpha in rod.attenuation if alpha > 0.0]
    steel = "undamped: waves in the tool lose nothing on the way"
    if losses:
        steel = f"waves lose e^−αx of their amplitude, α up to {number(max(losses))} per m"
    return [("feed", told), ("steel", steel)]


def drilled_sections(one: Drilled, tell: Teller) -> list[ReportSection | Grid]:
    """The sections of a report, after that of the energy."""
    rows = rows_of(one, HELD, tell)
    if one.tension.tension > 0.0 and one.tension.tension_time is not None:
        told = f"{tell(one.tension.tension, 'stress')} in section {one.tension_section} of the tool"
        rows.insert(0, ("greatest tension", f"{told}, at {tell(one.tension.tension_time, 'time')}"))
    bound = one.all.left_bound
    warns = one.all.stands is False or (one.feed_force is not None and bound is not None and bound > ONE_BY_ONE)
    found: list[ReportSection | Grid] = [ReportSection("What holds the tool", tuple(rows), BAD if warns else PLAIN)]
    if one.all.drilling is not None:
        found.append(ReportSection("The hole", tuple(rows_of(one, DRILLING, tell))))
    if one.all.number > 1:
        found.append(_several(one, tell))
    return found


def _several(one: Drilled, tell: Teller) -> Grid:
    columns = ("blow", "into the rock", "penetration", "advance", "back with the striker", "left in the waves")
    rows = tuple(
        (str(i), tell(each.blow.rock_work, "energy"), tell(each.blow.greatest_penetration or 0.0, "length"),
         tell(each.advance or 0.0, "length"), tell(each.returned_energy, "energy"),
         tell(each.blow.tool_dynamic_energy, "energy"))
        for i, each in enumerate(one.each, 1)
    )  # fmt: skip
    alike = f"{one.all.number} blows, each in new rock: all alike"
    if one.all.crater == "same":
        alike = f"{one.all.number} blows one by one, {len(one.all.blows)} in a crater"
    return Grid(alike, columns, rows)
