"""The tables [tool], [feed], [rock], [blow], [drilling] and [contact]: what a bar strikes, and how it leaves it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import TYPE_CHECKING, Annotated, ClassVar, Literal, NamedTuple

from percuss.case.file_format.bodies import SectionTable, SystemTable, by_what_was_given, sections_of
from percuss.case.file_format.values import (
    FROM_THE_BLOW,
    Advance,
    Area,
    Attenuation,
    CaseTable,
    Dashpot,
    Force,
    Frequency,
    Law,
    Length,
    Mass,
    Restitution,
    SpecificEnergy,
    Steps,
    Stiffness,
    Strain,
    Time,
    Velocities,
    above_zero,
    given_in,
    keyed,
    list_of,
    number_of,
)
from percuss.errors import ParameterError
from percuss.model import Contact, Kept, Reversed, SizedBody, System, UniformBar
from percuss.model.body import Body, Section
from percuss.model.checks import count, non_negative
from percuss.model.contact import LAWS, Timed
from percuss.units import si

if TYPE_CHECKING:
    from percuss.blow import Drilling, EffectiveBlow, Feed, Joint, Rock, Rod, Wall
    from percuss.blow.bodies import End


# ---- What is struck: the tables [tool], [rock] and [blow] of a case, and the blow that is asked for


class ToolSectionTable(SectionTable):
    """A section of the tool; the last one may have no end."""

    length: Length | None = None  # type: ignore[assignment]  # a section of the bar has one
    """Length of the section. Allowed: greater than 0. When left out: the last section is endless; the others need
    it."""
    joint_mass: Mass | None = None
    """A mass at the step to the next section, such as a coupling too short to be a section. Allowed: 0 or greater; the
    last section has no step. When left out: none."""
    attenuation: Attenuation | None = None
    """α of the steel: a wave loses $e^{-\\alpha x}$ of its amplitude over a length $x$. Allowed: 0 or greater. When
    left out: none."""


ToolSections = Annotated[tuple[ToolSectionTable, ...], list_of("sections", '{length = "1.2 m", diameter = "38 mm"}')]
"""The sections of the tool from the struck face on."""


class JointTable(CaseTable):
    """What joins two sections of the tool other than rigidly."""

    at: int
    """The step, counted from 1: that between the first and the second section. Allowed: 1 or greater."""
    kind: Literal["mass", "elastic", "contact"] = "mass"
    """A mass; a spring with a dashpot beside it; or two faces that only push, until a thread catches them."""
    mass: Mass | None = None
    """Of a `"mass"`, such as a coupling sleeve. Allowed: 0 or greater."""
    stiffness: Stiffness | None = None
    """Of the spring of an `"elastic"` joint. Allowed: greater than 0."""
    damping: Dashpot | None = None
    """Force per velocity of the dashpot beside it. Allowed: 0 or greater. When left out: none."""
    slack: Length | None = None
    """How far the faces of a `"contact"` part before the thread bears tension. Allowed: 0 or greater. When left out: no
    limit."""


JointTables = Annotated[tuple[JointTable, ...], list_of("joints", '{at = 2, kind = "mass", mass = "1.8 kg"}')]
"""What joins the sections of the tool."""


class ToolTable(CaseTable):
    """What the bar strikes: a wall, or a rod of sections with something at its end."""

    kind: Literal["rod", "wall"] | None = None
    """A rod of `sections`, or a rigid wall, which takes no other key but `gap`. When left out: `"rod"`."""
    sections: ToolSections | None = None
    """Sections of the rod from the struck face on, see below. Allowed: up to 200 of them. When left out: only a wall
    has none."""
    end: Literal["infinite", "free", "fixed", "rock"] | None = None
    """What is at the end of the rod: nothing (`"free"`), a rigid support, the rock of `[rock]`; an infinite rod goes on
    for ever and sends nothing back. When left out: `"rock"`, with a table `[rock]`; `"infinite"`, when the last
    section has no length."""
    joints: JointTables | None = None
    """What joins its sections other than rigidly, see below. Allowed: one at a step. When left out: none."""
    bit_mass: Mass | None = None
    """A mass at the end of the rod, such as a bit too short to be a section. Allowed: 0 or greater. When left out:
    none."""
    gap: Length | None = None
    """Distance between the striking end and the struck face when the blow begins. Allowed: 0 or greater. When left out:
    none."""


class RockTable(CaseTable):
    """The rock, or the soil, at the end of the tool: loaded along one line, unloaded along a steeper one."""

    stiffness: Stiffness
    """Force per penetration while the force grows, $K_1$. Allowed: greater than 0."""
    unloading_ratio: float | None = None
    r"""γ: the force is taken off along $K_1/\gamma$, and $(1-\gamma)$ of the greatest penetration stays. Allowed:
    greater than 0, at most 1. When left out: 1, a rock that gives everything back."""
    gap: Length | None = None
    """Distance between the bit and the rock when the blow begins. Allowed: 0 or greater. When left out: none."""
    crater: Literal["new", "same"] | None = None
    """What the bit meets at the next blow: `"new"` rock, as the bit is turned on, or the crater of the blow before.
    When left out: `"new"`."""
    blows_per_crater: int | None = None
    """With `crater = "same"`: how many blows meet one crater before the bit is turned on. Allowed: 1 or greater. When
    left out: `number` of `[blow]`."""


FeedOf = Literal["tool", "machine"]


class FeedTable(CaseTable):
    """What presses the tool against the rock."""

    force: Force
    """The feed force $F$. Allowed: 0 or greater."""
    of: FeedOf = "tool"
    """What the force acts on: the tool, or the machine, whose blows push it back, so that the tool gets the force less
    rate × impulse of a blow; that needs `rate` in `[blow]`."""
    at: int = 0
    """Where it acts on the tool: 0, the struck face, or the number of a step of the tool, counted from there. Allowed:
    0 or greater."""
    stiffness: Stiffness | None = None
    """Of the spring of a recoil damper. Allowed: 0 or greater. When left out: the force is constant."""
    damping: Dashpot | None = None
    """Force per velocity of a recoil damper, which takes most where it is the impedance of the tool. Allowed: 0 or
    greater. When left out: none."""


class DrillingTable(CaseTable):
    """What the blows are worth in advance of the hole."""

    bit_diameter: Length
    """Diameter of the hole. Allowed: greater than 0."""
    crater_factor: float | None = None
    """Advance of the hole over the residual penetration of a blow. Allowed: greater than 0. When left out:
    `specific_energy` is needed."""
    specific_energy: SpecificEnergy | None = None
    """Work that stays in the rock per volume drilled, measured. Allowed: greater than 0. When left out: `crater_factor`
    is needed."""


class BlowTable(CaseTable):
    """One blow, or several, as `percuss blow` follows them."""

    in_plain: ClassVar = {"number": None, "rate": None, "between": None}

    velocity: Velocities | None = None
    """Speed of the bar toward the tool just before the blow, or a list with one for each section. When left out: that
    of the steady motion, or of the cycle of a machine that switches its own valve."""
    until: Time | None = None
    """Time from the start of the blow at which it is left. Allowed: greater than 0. When left out: the end of the blow,
    where that can be proved."""
    load: Steps | None = None
    """The force on the bar during the blow, positive toward the tool: pairs of a time and the force from then on. When
    left out: none."""
    load_at: int = 0
    """Where this force acts: 0, the driven end, or the number of a step of the bar, counted from there. Allowed: 0 or
    greater."""
    number: int | None = None
    """How many blows follow each other. Allowed: 1 or greater. When left out: one, or `blows_per_crater` of
    `[rock]`."""
    rate: Frequency | None = None
    """How many there are in a time. Allowed: greater than 0, and no blow before the end of the one before. When left
    out: unknown; no rate of penetration is told."""
    between: Literal["static", "waves"] | None = None
    """What a blow begins from: the tool at rest under its feed, or with the waves that the blow before has left in it.
    When left out: `"static"`."""


# ---- From these tables to what the bar strikes, and to the blow that is asked for


@dataclass(frozen=True)
class BlowQuestion:
    """One blow as a case asks for it: in SI, or dimensionless as the bar is."""

    striker: SizedBody | Body
    target: Rod | Wall
    velocity: float | tuple[float, ...] | None = None  # None asks for that of the steady motion
    until: float | None = None  # None until the blow is over
    load: tuple[tuple[float, float], ...] = ()  # pairs of a time and the force from then on
    load_at: int = 0
    number: int = 1
    rate: float | None = None  # blows in a second
    between: Literal["static", "waves"] = "static"
    crater: Literal["new", "same"] = "new"
    blows_per_crater: int = 1
    feed_of: FeedOf = "tool"
    drilling: Drilling | None = None


# -- [tool], [feed] and [rock] -----------------------------------------------------------------------------------------


def rock_of(table: RockTable) -> Rock:
    """The rock that the table [rock] describes."""
    from percuss.blow import Rock

    own = given_in(table)
    crater, blows = own.pop("crater", "new"), own.pop("blows_per_crater", None)
    if blows is not None:
        count("blows_per_crater", blows, 1, MOST_BLOWS)
        if crater == "new":
            accepted = 'no such key beside crater = "new", which each blow finds'
            raise ParameterError("blows_per_crater", blows, accepted, 'write crater = "same"')
    return Rock(**{"unloading_ratio": 1.0, "gap": 0.0} | own)


def feed_of(table: FeedTable) -> Feed:
    """The feed that the table [feed] describes."""
    from percuss.blow import Feed

    return Feed(**{key: value for key, value in given_in(table).items() if key != "of"})


def drilling_of(table: DrillingTable) -> Drilling:
    """What the table [drilling] describes."""
    from percuss.blow import Drilling

    return Drilling(**given_in(table))


def fed(target: Rod | Wall, feed: Feed) -> Rod:
    """What is struck, with its feed."""
    from percuss.blow import Rod

    if not isinstance(target, Rod):
        raise ParameterError("force", feed.force, "no feed of a wall", "describe a rod in [tool], or take [feed] away")
    with keyed(keys={"feed": "force", "feed.at": "at"}):
        return replace(target, feed=feed)


def _joints(tool: ToolTable) -> tuple[Joint, ...]:
    from percuss.blow import Joint

    found = []
    for i, table in enumerate(tool.joints or ()):
        if table.kind == "mass" and table.mass is None:
            raise ParameterError(f"joints[{i}].mass", None, "the mass at the joint", 'for example mass = "1.8 kg"')
        with keyed(f"joints[{i}]."):
            found.append(Joint(**given_in(table, f"joints[{i}].")))
    return tuple(found)


def struck_alone(receiving_area: str | None, bar: SizedBody) -> Rod | Wall:
    """What a bar in SI strikes without a table [tool]: the rod of `receiving_area`, as the bar is, or a rigid wall."""
    from percuss.blow import Rod, Wall

    if receiving_area is None:
        return Wall()
    area, last = si(receiving_area, "area", "receiving_area"), bar.pieces[-1]
    return Rod((Section(None, area=area, youngs_modulus=last.youngs_modulus, density=last.density),), "infinite")


def sized_target(tool: ToolTable, rock: Rock | None) -> Rod | Wall:
    """What a bar in SI strikes by a table [tool]."""
    from percuss.blow import Rod, Wall

    given = {"gap": 0.0, "bit_mass": 0.0} | given_in(tool)
    if tool.kind == "wall":
        for key in ("sections", "end", "bit_mass", "joints"):
            if getattr(tool, key) is not None:
                raise ParameterError(key, None, f"no {key} of a wall", 'a rod has kind = "rod"')
        if rock is not None:
            raise ParameterError("kind", "wall", '"rod" beside a table [rock]', "take [rock] away, or describe the rod")
        return Wall(given["gap"])
    if tool.sections is None:
        raise ParameterError("sections", None, 'the sections of the rod, or kind = "wall"', _SECTIONS)
    sections, joints, losses = sections_of(tool.sections, tool), [], []
    for i, table in enumerate(tool.sections):
        mass = non_negative(f"sections[{i}].joint_mass", given_in(table).get("joint_mass", 0.0))
        if mass > 0.0 and table is tool.sections[-1]:
            name, remedy = f"sections[{i}].joint_mass", "a mass at the end of the rod is bit_mass"
            raise ParameterError(name, table.joint_mass, "a section with another one behind it", remedy)
        joints += [] if table.joint_mass is None or table is tool.sections[-1] else [(i + 1, mass)]
        losses.append(non_negative(f"sections[{i}].attenuation", given_in(table).get("attenuation", 0.0)))
    end = _end(tool, sections, rock)
    with by_what_was_given(tool.sections):
        return Rod(
            sections, end, bit_mass=given["bit_mass"], joint_masses=tuple(joints), joints=_joints(tool),
            attenuation=tuple(losses), rock=rock, gap=given["gap"],
        )  # fmt: skip


MOST_BLOWS = 10_000  # that follow each other
_ROUNDED = 1e-9  # of the time between two blows
NO_BIT = 'describe what is struck in [tool], a bit for example: sections = [{length = "0.2 m", diameter = "90 mm"}]'
"""What to do about a table [rock] without a table [tool]."""

_SECTIONS = 'for example sections = [{length = "1.2 m", diameter = "38 mm"}]'


def _end(tool: ToolTable, sections: tuple[Section, ...], rock: Rock | None) -> End:
    """What is at the end of the rod: as the table says, or as the rest of the case leaves no doubt."""
    if tool.end is None and rock is None and all(section.length is not None for section in sections):
        remedy = 'a last section without a length is endless; a table [rock] describes the rock: end = "rock"'
        raise ParameterError("end", None, '"free", "fixed", "rock" or "infinite"', remedy)
    end: End = tool.end or ("infinite" if rock is None else "rock")
    if end == "rock" and rock is None:
        raise ParameterError("end", end, "a table [rock] beside it", 'for example stiffness = "400 kN/mm" in [rock]')
    if end != "rock" and rock is not None:
        raise ParameterError("end", end, '"rock" beside a table [rock]', 'take [rock] away, or write end = "rock"')
    return end


# -- [blow] -----------------------------------------------------------------------------------------------------------


def blow_question(
    table: BlowTable | None, striker: SizedBody | Body, target: Rod | Wall, rock: RockTable | None = None,
    feed: FeedTable | None = None,
) -> BlowQuestion:  # fmt: skip
    """The blow that the table [blow] asks for; without the table from the steady motion until it is over."""
    table = BlowTable() if table is None else table
    until = None if table.until is None else above_zero("until", table.until, "time")
    load = tuple((number_of("load", t, "time"), number_of("load", f, "force")) for t, f in table.load or ())
    times = [time for time, _ in load]
    if times and (times[0] < 0.0 or any(later <= earlier for earlier, later in pairwise(times))):
        raise ParameterError("load", [t for t, _ in table.load or ()], "times that increase from 0 or later")
    body = striker.body(1.0 / striker.transit_time) if isinstance(striker, SizedBody) else striker
    with keyed(keys={"at": "load_at"}):
        body.place(table.load_at)
    asked = BlowQuestion(striker, target, _velocity(table, striker), until, load, table.load_at)
    asked = replace(asked, feed_of="tool" if feed is None else feed.of)
    return _several(asked, table, rock)


def _several(asked: BlowQuestion, table: BlowTable, rock: RockTable | None) -> BlowQuestion:
    """The question with how many blows follow each other, how fast, and what they meet."""
    crater, same = ("new", None) if rock is None else (rock.crater or "new", rock.blows_per_crater)
    number = count("number", (same or 1) if table.number is None else table.number, 1, MOST_BLOWS)
    rate = None if table.rate is None else above_zero("rate", table.rate, "frequency")
    if asked.until is not None and rate is not None and asked.until * rate > 1.0 + _ROUNDED:
        wanted = f"a blow that ends before the next one, {1.0 / rate:.4g} s later"
        raise ParameterError("until", table.until, wanted, "an earlier end, or fewer blows in a second")
    if rate is None and (table.between == "waves" or asked.feed_of == "machine"):
        why = 'for between = "waves"' if table.between == "waves" else 'for of = "machine" in [feed]'
        raise ParameterError("rate", None, f"a rate of the blows {why}", 'for example rate = "60 Hz"')
    return replace(
        asked, number=number, rate=rate, between=table.between or "static", crater=crater,
        blows_per_crater=(same or number) if crater == "same" else 1,
    )  # fmt: skip


def _velocity(table: BlowTable, striker: SizedBody | Body) -> float | tuple[float, ...] | None:
    given = table.velocity
    if given is None:
        return None
    if not isinstance(given, tuple):
        speed = number_of("velocity", given, "velocity")
        if speed <= 0.0:
            raise ParameterError("velocity", given, "a speed greater than 0, toward the tool")
        return speed
    count = len(striker.pieces) if isinstance(striker, SizedBody) else len(getattr(striker, "impedances", (1.0,)))
    if len(given) != count:
        accepted = f"one speed, or one for each of the {count} sections" if count > 1 else "one speed of a uniform bar"
        raise ParameterError("velocity", list(given), accepted)
    return tuple(number_of("velocity", one, "velocity") for one in given)


# ---- The table [contact] of a case: how the bar leaves the wall, by a number, a law, or one blow


class ContactTable(CaseTable):
    """How the bar leaves the wall."""

    restitution: Restitution | None = None
    """Coefficient of restitution, or `"from the blow"`: that of the blow on the tool, resolved by waves. Allowed: 0 to
    1. When left out: `receiving_area` is needed, or the law of the blow."""
    receiving_area: Area | None = None
    """Cross-section of a long rod of the same material that is struck. Allowed: at least that of the bar. When left
    out: `restitution` is needed."""
    strain: Strain | None = None
    """What the impact does to the strain in the bar: keep it, or turn it over together with the velocity, as the waves
    in a uniform bar do. When left out: `"reversed"`, but `"kept"` for a bar that is not uniform."""
    law: Law | None = None
    """What is known of the blow: B77's impact takes no time; `"b77-tau"` adds the time that a uniform bar is in
    contact; `"b77-blow"` takes restitution, duration and advance from one blow resolved by waves. When left out:
    `"b77"`."""
    advance: Advance | None = None
    """With a law that knows the duration: the tool keeps the advance that a blow gives it, is pushed back, or advances
    by what the rock does not give back. When left out: `"kept"`, but `"residual penetration"` of a tool on rock and
    `"pushed back"` of others that have an end."""


# ---- The law of the contact, as far as no blow is resolved for it


def contact_of(table: ContactTable | SystemTable, bar: SizedBody | None, tool: bool) -> Contact | None:
    """The law of the contact; None where it depends on a bar that could not be made, or on the blow (on a `tool`)."""
    area = getattr(table, "receiving_area", None)
    if area is not None and table.restitution is not None:
        raise ParameterError("receiving_area", area, "either restitution or receiving_area, not both")
    _check_law(table, tool or area is not None)
    if table.law == "b77-blow" or table.restitution == FROM_THE_BLOW:
        return None
    law = law_of(table, bar)
    if area is not None:
        receiving = si(area, "area", "receiving_area")
        return None if bar is None else law(receiving_area=receiving, area=bar.pieces[-1].area)
    if table.restitution is None:
        remedy = f'that of the blow on the tool is restitution = "{FROM_THE_BLOW}"' if tool else ""
        raise ParameterError("restitution", None, "a restitution from 0 to 1, or a receiving_area", remedy)
    assert not isinstance(table.restitution, str)
    return law(table.restitution)


def law_of(table: ContactTable | SystemTable, bar: SizedBody | None) -> type[Contact]:
    """The law that the table names; else B77's, but in SI what the waves in a uniform bar do."""
    if table.strain is not None:
        return LAWS[table.strain]
    uniform = isinstance(table, ContactTable) and (bar is None or bar.kind == UniformBar.kind)
    return Reversed if uniform else Kept


def check_body(table: ContactTable | SystemTable, law: type[Contact], body: Body) -> None:
    """Refuse a body that the laws of the table do not hold for."""
    law(0.0).check(body)
    if table.law == "b77-tau" and not body.is_harmonic:
        remedy = 'take law = "b77-blow", which holds for any bar'
        raise ParameterError("law", table.law, "a uniform bar for the law b77-tau", remedy)


def _check_law(table: ContactTable | SystemTable, target: bool) -> None:
    """Refuse a law of the blow that lacks what it is made of; `target` tells whether the case says what is struck."""
    given = table.restitution
    if table.advance is not None and table.law in (None, "b77"):
        remedy = 'take it away, or write law = "b77-tau" or "b77-blow"'
        raise ParameterError("advance", table.advance, "a law that knows the duration of the blow beside it", remedy)
    if table.law == "b77-blow" and given not in (None, FROM_THE_BLOW):
        accepted = "no number beside the law b77-blow, which takes it from the blow"
        remedy = f'write restitution = "{FROM_THE_BLOW}", or take law = "b77" for a number'
        raise ParameterError("restitution", given, accepted, remedy)
    if not target and (table.law == "b77-blow" or given == FROM_THE_BLOW):
        key, remedy = ("law" if table.law == "b77-blow" else "restitution"), 'a rigid wall is kind = "wall" in [tool]'
        raise ParameterError(key, getattr(table, key), "a table [tool] that says what the bar strikes", remedy)


# ---- The contact of a case by one blow resolved by waves: its restitution, its duration, how far the tool moves on

_FELT = 1e-6  # a slope that is told
_SPENT = 1e-9  # a restitution that is as good as 0: the bar has given its momentum away
_FORWARD = (
    "a bar of greater impedance than the tool's goes on after the blow and presses or strikes it again and again, in "
    "steps that on an endless tool never end: make the tool "
    "thicker or the bar thinner, or give a number from 0 to 1"
)


def needs_speed(question: BlowQuestion) -> bool:
    """Whether the restitution of the blow depends on its speed: through a gap before the rock, a feed, a slack."""
    rock, feed = getattr(question.target, "rock", None), getattr(question.target, "feed", None)
    slack = any(joint.slack for joint in getattr(question.target, "joints", ()))
    return (rock is not None and rock.gap > 0.0) or feed is not None or slack


def blow_of(question: BlowQuestion) -> EffectiveBlow:
    """The blow of a bar on its tool without a load, which does not depend on the speed but for a gap; computed once."""
    from percuss.blow import effective_blow

    velocity = question.velocity if needs_speed(question) else 1.0
    assert isinstance(velocity, float)
    found = effective_blow(question.striker, question.target, velocity, until=question.until)
    if not found.contacts:
        remedy = "check the gap of [tool] and until in [blow]"
        raise ParameterError("restitution", None, "a blow of a bar that reaches the tool", remedy)
    return found


class OwnBlow(NamedTuple):
    """The blow of a cycle whose restitution is that of this blow: R, the question with its speed, and dR/dR.

    `slope`: by how much R of the blow at the speed of a cycle follows R of the cycle; 0 where the blow is linear.
    """

    restitution: float
    question: BlowQuestion
    slope: float


_USUAL = 0.2  # a restitution at which hammers run: where the search begins
_AGREE = 1e-12  # of two restitutions
_MOST_STEPS = 60


def own_blow(question: BlowQuestion, speed: Callable[[float], float]) -> OwnBlow:
    """The blow whose restitution R is that of the cycle: R = ρ(V(R)), by secants between bounds.

    V(R) is the speed of the cycle with that restitution, and ρ that of the blow at a speed. As 0 ≤ ρ ≤ 1, ρ(V(R)) − R
    falls through 0 between 0 and 1.
    """
    if not needs_speed(question):
        return OwnBlow(restitution_of(question), question, 0.0)
    low, high, slope, r = 0.0, 1.0, 0.0, _USUAL
    before: tuple[float, float] | None = None
    for step in range(_MOST_STEPS):
        asked = replace(question, velocity=speed(r))
        rest = restitution_of(asked) - r
        if before is not None and abs(r - before[0]) > 1e4 * _AGREE:  # else it is rounding
            slope = 1.0 + (rest - before[1]) / (r - before[0])
        if abs(rest) <= _AGREE:
            return OwnBlow(r, asked, slope)
        low, high = (r, high) if rest > 0.0 else (low, r)
        before, r = (r, rest), r + rest / (1.0 - slope) if slope != 1.0 else low
        if not low < r < high or step % 4 == 3:
            r = 0.5 * (low + high)
    accepted = "a restitution that is that of the cycle's own blow, which jumps here as its speed changes"
    raise ParameterError("restitution", None, accepted, "give a number from 0 to 1, or change the gap of [rock]")


def restitution_of(question: BlowQuestion) -> float:
    """The restitution of a blow as B77's law takes it."""
    from percuss.blow import BlowOutcome

    blow = blow_of(question)
    if abs(blow.restitution) <= _SPENT:
        return 0.0
    usual = 0.0 <= blow.restitution <= 1.0
    if not usual and blow.outcome is BlowOutcome.STILL_IN_CONTACT and question.until is None:
        accepted = f"a blow with a restitution from 0 to 1; on this tool R is {blow.restitution:.4g} so far"
        raise ParameterError("restitution", None, accepted, _FORWARD)
    if blow.outcome in (BlowOutcome.STILL_IN_CONTACT, BlowOutcome.GAP_CLOSING):
        accepted = f"a blow that is over; {blow.outcome.value}"
        raise ParameterError("restitution", None, accepted, "give a later end: until in [blow]")
    if not usual:
        accepted = f"a blow with a restitution from 0 to 1; that on this tool has R = {blow.restitution:.4g}"
        raise ParameterError("restitution", None, accepted, _FORWARD)
    return blow.restitution


def blow_note(own: OwnBlow) -> str:
    """What is to be known of a restitution that is that of a blow, one sentence."""
    blow = blow_of(own.question)
    several = "one contact" if blow.contacts == 1 else f"{blow.contacts} contacts"
    share = f"{100.0 * blow.ringing:.2g} % of the energy stays in the bar as ringing"
    text = f"R = {blow.restitution:.4g} is that of the blow on the tool, resolved by waves: {several}; {share}"
    if not needs_speed(own.question):
        return text
    text += f"; the gap in front of the rock makes it depend on the speed, which is {own.question.velocity:.4g} m/s "
    text += "in the cycle with this R, of one blow in a period; motions of other kinds are given the same R"
    if abs(own.slope) <= _FELT:
        return text
    return f"{text} (a cycle with another R would have a blow whose R follows it with the slope {own.slope:.3g})"


def law_note(table: ContactTable | SystemTable | None) -> str:
    """Where a law of blows that take time counts and where it does not, one sentence; "" without one."""
    if table is None or table.law in (None, "b77"):
        return ""
    return (
        f"law {table.law}: steady motions have its phases and multipliers beside those of B77's impact; simulations, "
        "maps and boundaries have B77's impact with the same restitution"
    )


def timed_law(table: ContactTable | SystemTable, question: BlowQuestion, system: System) -> Timed | None:
    """The law of a blow that takes time, as the table names it; None for B77's."""
    if table.law == "b77-tau":
        advance = table.advance or "kept"
        if advance == "residual penetration":
            raise ParameterError("advance", advance, '"kept" or "pushed back" beside the law b77-tau', _LAW_OF_ROCK)
        return Timed.of_uniform_bar(system.s, system.restitution, advance)
    if table.law != "b77-blow":
        return None
    blow = blow_of(question)
    if blow.duration is None or blow.centroid is None:
        accepted = f"a contact that ends; here {blow.outcome.value}"
        raise ParameterError("law", table.law, accepted, _FORWARD)
    time = 1.0 if system.bar is None else system.time_scale
    law = Timed(
        restitution_of(question),
        blow.duration / time,
        min(blow.centroid, blow.duration) / time,
        ringing_share=min(blow.ringing, 1.0),
        contacts=blow.contacts,
    )
    return replace(law, advance_per_impulse=_advance(table, question.target, blow) / time / law.impulse(1.0, 0.0))


_LAW_OF_ROCK = 'the penetration is known to law = "b77-blow"'


def _advance(table: ContactTable | SystemTable, target: Rod | Wall, blow: EffectiveBlow) -> float:
    """Advance of the tool per speed of the bar, in the unit of time of the blow."""
    from percuss.blow import Wall

    end = "wall" if isinstance(target, Wall) else target.end
    usual = {"rock": "residual penetration", "infinite": "kept"}.get(end, "pushed back")
    advance = table.advance or usual
    if advance not in (usual, "pushed back"):
        where = {"wall": "a wall", "rock": "a rod on rock", "infinite": "an endless rod"}
        accepted = f'"{usual}"' if usual == "pushed back" else f'"{usual}" or "pushed back"'
        raise ParameterError("advance", advance, f"{accepted} of {where.get(end, f'a rod with a {end} end')}")
    return 0.0 if advance == "pushed back" else blow.advance
