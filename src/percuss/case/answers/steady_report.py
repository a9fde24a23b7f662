"""An answer as the report that a person reads: a title, a summary, and sections of labelled lines."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from percuss.case.answers.blows.transfer import transfer_section, transfer_sentence
from percuss.case.answers.facts import (
    BAD,
    GOOD,
    PLAIN,
    Fact,
    Grid,
    Report,
    ReportSection,
    Teller,
    as_typed,
    counted,
    every,
    measured,
    number,
    of_tool,
    percent,
    rhythm,
    rows_of,
    settles,
)
from percuss.case.answers.heading import CLOCKED, clock_in_short, system_section
from percuss.case.answers.steady_answer import rest_note
from percuss.steady.figures import FIGURES
from percuss.steady.multipliers import Reason

if TYPE_CHECKING:
    from percuss.case.answers.steady_answer import (
        CaseReach,
        End,
        Ends,
        OrbitAnswer,
        PeriodAnswer,
        SteadyAnswer,
        TimedAnswer,
    )
    from percuss.model import System, Timed
    from percuss.stability import Stability, TimedStability
    from percuss.steady import Rest


# ---- Where random starts end, in words: the same for the terminal and for a report


def _in(periods: int) -> str:
    """In how many load periods a motion has its blow, where that is not one."""
    return "" if periods == 1 else f", one blow in {periods} load periods"


def ends_sentence(ends: Ends, running: set[str], system: System) -> str:
    """The sentence of a summary; `running` holds the labels of the steady motions that can be sustained."""
    if not ends.followed:
        return ""
    there = sum(end.starts for end in ends.ends if end.label in running)
    others = [end for end in ends.ends if end.label not in running]
    starts = counted(ends.followed, "random start")
    many = "The random start" if ends.followed == 1 else f"All {ends.followed} random starts"
    where = "in this motion" if len(running) == 1 else "in one of these motions"
    if running and not others:
        return f"{many} {'ends' if ends.followed == 1 else 'end'} {where}."
    told = [f"{end.starts} {does(end.label, end.starts, _delivered(end, system))}" for end in others]
    if running:
        there_first = [f"{there or 'none'} {'ends' if there == 1 else 'end'} {where}"]
        return f"Of {starts}, {', '.join([*there_first, *told])}."
    found = f"Of {starts}, {', '.join(told)}."
    if len(others) == 1:
        taken = power(others[0], system)
        return f"{many} {does(others[0].label, ends.followed)}{f': {taken}' if taken else ''}."
    return found


def power(end: End, system: System) -> str:
    """Power that the impacts take, and main blows, where there are any."""
    if end.delivered_power is None or end.blow_rate is None or not end.delivered_power > 0.0:
        return ""
    rate = f"{number(end.blow_rate)} main blows per load period"
    if system.is_si and system.frequency is not None:
        rate = f"{number(end.blow_rate * system.frequency)} main blows/s"
    return f"{_delivered(end, system)}, {rate}"


def _delivered(end: End, system: System) -> str:
    """``10.7 kW taken by the impacts``, where anything is."""
    return f"{Teller.of(system)(end.delivered_power, 'power')} taken by the impacts" if end.delivered_power else ""


def does(label: str, many: int, more: str = "") -> str:
    """``settle on one blow every load period``; the verb agrees with `many`, and `more` follows the label."""
    s = "s" if many == 1 else ""
    named = f"({label}, {more})" if more else f"({label})"
    name, _, numbers = label.replace("z=", "z/", 1).partition("/")
    if name == "z":
        return f"settle{s} on {rhythm(label)} {named}"
    if name in ("chatter", "rest") and numbers:
        how = f"chatter{s} to rest" if name == "chatter" else f"strike{s} and come{s} to rest"
        return f"{how} once {every(int(numbers))} {named}" if numbers != "?" else f"{how} again and again {named}"
    return {
        "rest": f"come{s} to rest on the wall for good",
        "departed": f"leave{s} the wall for good",
        "aperiodic": f"find{s} no rhythm {named}",
    }.get(label, f"{'has' if many == 1 else 'have'} not settled {named}")


# ---- The first lines of an answer: one home of its sentences, for the terminal and for the report as a file


@dataclass(frozen=True)
class FirstLines:
    """What is said first of an answer: whether the hammer can run, and how; what else it can do, and of its load."""

    headline: str
    more: str
    runs: bool

    @property
    def text(self) -> str:
        """All sentences of the summary as one text."""
        return f"{self.headline} {self.more}".rstrip()


def summary_of(answer: SteadyAnswer) -> FirstLines:
    """The first lines of an answer."""
    running = answer.running
    if answer.rest is None:
        number_of = sum(len(period.orbits) for period in answer.periods)
        text = f"{counted(number_of, 'steady motion')} with one impact, {len(running)} of them possible and stable."
        return FirstLines(text, "", bool(running))
    labels = {f"z=1/{found.orbit.periods}" for found in running}
    clock = clock_in_short(answer.system.load) if answer.clocked is None else CLOCKED
    told = [ends_sentence(answer.starts, labels, answer.system), clock]
    if running:
        told.insert(0, transfer_sentence(answer.transfer))
        told.insert(1, "" if answer.uncertainty is None else answer.uncertainty.sentence)
        others = ", or ".join(every(m) for m in sorted({other.orbit.periods for other in running[1:]}))
        also = f"It can also settle on one blow {others}; which motion it takes depends on how it starts."
        more = [also, *told] if others else told
        return FirstLines(_can_run(answer, running[0]), of_tool(" ".join(filter(None, more)), answer.tool), True)
    alone = [one for period in answer.periods if period.timed is not None for one in period.timed.alone if one.runs]
    if alone:
        orbit, settled = alone[0].orbit, settles(1.0 - alone[0].stability.margin, "blow")
        text = (
            f"By {orbit.law.law} the hammer can run with one blow {every(orbit.periods)}: phase {number(orbit.phase)}"
        )
        text += f" rad; stable: {settled}. With blows that take no time it cannot."
        return FirstLines(text, " ".join(filter(None, told)), True)
    stays = answer.rest.possible and not answer.rest.held_by_waves  # of a simulated bar, too
    rest = "The bar may also come to rest on the wall." if stays else ""
    asked = [str(period.states.periods) for period in answer.periods]
    when = every(int(asked[0])) if len(asked) == 1 else f"in {', '.join(asked[:-1])} or {asked[-1]} load periods"
    found = any(period.orbits for period in answer.periods)
    why = "can be sustained; see below for what fails." if found else "exists; see below for the nearest one."
    text = f"No steady motion with one impact {when} {why}"
    return FirstLines(text, of_tool(" ".join(filter(None, [rest, *told])), answer.tool), False)


def _can_run(answer: SteadyAnswer, first: OrbitAnswer) -> str:
    orbit, tell = first.orbit, Teller.of(first.orbit.system)
    figures = f"phase {number(first.phase)} rad, striking speed {number(orbit.impact_velocity)}"
    if first.si is not None:
        rate = f"{number(first.si.blow_rate_Hz)} Hz ({number(first.si.blow_rate_per_min)} blows/min)"
        figures = f"{tell(orbit.blow_energy, 'energy')} at {rate}, {tell(orbit.impact_velocity, 'speed')}"
    judged = first.stability if first.timed is None else first.timed.stability
    law = "" if first.timed is None else f", by {first.timed.orbit.law.law}"
    settled = settles(1.0 - judged.margin, "blow")
    return f"The hammer can run with one blow {every(first.orbit.periods)}: {figures}; stable: {settled}{law}."


def name_of(answer: SteadyAnswer, found: OrbitAnswer) -> str:
    """``motion 2`` as the cards are numbered."""
    number_of = {id(one): i + 1 for period in answer.periods for i, one in enumerate(period.orbits)}
    return f"motion {number_of[id(found)]}{_in(found.orbit.periods)}"


# ---- A law that knows the duration of the blow, and its motions beside those of B77's law, in words

ENDED = "this motion does not exist when the blow takes time: it has met another one in a fold"
"""What is said of a motion of B77's law that the duration of the blow ends."""


def timed_sentences(found: TimedAnswer, judged: Stability | None = None) -> list[str]:
    """A motion in lines: its phase, its blow, its verdict beside that on B77's motion, and what makes it impossible."""
    orbit, tell = found.orbit, Teller.of(found.orbit.system)
    beside = "" if judged is None else f" (B77's rhythm {number(judged.margin_rhythm, 3)})"
    margin = f"{_verdict(found.stability)}; margin {number(found.stability.margin, 3)}{beside}"
    given = f"{tell(orbit.delivered_energy, 'energy', plain=6)} delivered to what is struck"
    given += f"; {tell(orbit.ringing_energy, 'energy', plain=6)} ring on in the bar" if orbit.ringing_energy else ""
    lines = [_timed_phase(found), _timed_blow(found), given, margin]
    if orbit.obstacle is Reason.NO_BLOW:
        lines.append("not possible: at the start of the contact the bar would be moving away from the wall")
    elif orbit.violation is not None:
        told = tell(orbit.violation.depth, "length")
        lines.append(f"not possible: between the blows the bar would be {told} beyond the place of the next one")
    return lines


def _timed_phase(found: TimedAnswer) -> str:
    orbit = found.orbit
    text = f"force centred at {number(orbit.phase, 5)} rad = {number(math.degrees(orbit.phase))}°"
    shift = orbit.phase_shift
    if shift is None:
        return f"{text}; no motion of B77's law corresponds to it"
    when = "later" if shift >= 0.0 else "earlier"
    return f"{text}, {Teller.of(orbit.system)(abs(shift), 'time', 3)} {when} than B77's impact"


def _timed_blow(found: TimedAnswer) -> str:
    orbit, tell = found.orbit, Teller.of(found.orbit.system)
    speed, energy = tell(orbit.rigid_velocity, "speed", plain=6), tell(orbit.blow_energy, "energy", plain=6)
    advance = tell(orbit.advance, "length", 3, plain=4)
    change = orbit.energy_change
    beside = "" if change is None else f" ({'+' if change >= 0.0 else ''}{percent(change)} against B77's rigid motion)"
    text = f"speed {speed}, energy {energy}{beside}"
    return f"{text}; the impact plane moves on by {advance} per blow" if orbit.advance else text


# ---- What a law that knows the duration of the blow says, as lines of the report beside those of B77's law


def existence_row(period: PeriodAnswer) -> list[tuple[str, str]]:
    """How many motions there are under the law."""
    if period.timed is None:
        return []
    states = period.timed.states
    compared = f"level {number(states.level)}, greatest v_f − e p {number(states.level_max)}"
    return [(states.law.law, f"{counted(len(states.orbits), 'steady motion')}: {compared}")]


def alone_sections(period: PeriodAnswer) -> list[ReportSection]:
    """Cards of the motions that continue none of B77's."""
    if period.timed is None:
        return []
    heading = f"Of {period.timed.states.law.law} alone{_in(period.states.periods)}"
    return [
        ReportSection(f"{heading}: {_judged(found)}", tuple(_rows(found, None)), GOOD if found.runs else BAD, level=2)
        for found in period.timed.alone
    ]


def _judged(found: TimedAnswer) -> str:
    verdict = "stable" if found.stability.stable else "unstable"
    return f"{verdict}, {'possible' if found.orbit.admissible else 'not possible'}"


def _rows(found: TimedAnswer, judged: Stability | None) -> list[tuple[str, str]]:
    first, *more = timed_sentences(found, judged)
    rows = [(found.orbit.law.law, first), *(("", text) for text in more)]
    return [*rows, *(("warning", warning) for warning in found.orbit.warnings)]


# ---- One orbit as a section of the report: what it is, whether it can be sustained, and what to change if not

MOST_WARNINGS = 3  # warnings that a card shows; the rest is in the JSON


def orbit_section(answer: OrbitAnswer, name: str, law: Timed | None = None) -> ReportSection:
    """The card of an orbit, with what a law of blows that take time makes of it."""
    orbit, judged, tell = answer.orbit, answer.stability, Teller.of(answer.orbit.system)
    if not orbit.system.body.is_free:
        return _of_structure(answer, name)
    verdict = "stable" if judged.stable else "unstable"
    possible = "possible" if orbit.admissible else "not possible"
    phase = f"{number(orbit.phase, 5)} rad = {number(math.degrees(orbit.phase))}°"
    phase += f" = {tell(orbit.phase, 'time')} into the load period" if tell.is_si else ""
    rows = [
        ("possible", _possible(answer)),
    ]
    if orbit.impact_velocity > 0.0:
        rows += rows_of(answer, _BLOW, tell)
    else:
        told = tell(-orbit.impact_velocity, "speed", plain=6)
        moving = f"the striking end would be leaving the wall at {told}"
        rows.append(("blow", f"none: {moving if orbit.impact_velocity else 'the end would stand still'}"))
    rows += [
        ("phase", phase),
        ("verdict", _verdict(judged)),
        ("margins", _margins(judged)),
        ("multipliers", _multipliers(judged)),
    ]
    if judged.disagreement:
        rows.append(("note", judged.disagreement))
    rows.append(("force at impact", _waveform(judged, tell)))
    if law is not None:  # what becomes of it when its blows take time
        rows += [(law.law, ENDED)] if answer.timed is None else _rows(answer.timed, judged)
    rows += [("warning", warning) for warning in orbit.warnings[:MOST_WARNINGS]]
    if len(orbit.warnings) > MOST_WARNINGS:
        rows.append(("", f"and {len(orbit.warnings) - MOST_WARNINGS} more; --json has them all"))
    tone = GOOD if answer.runs else BAD
    heading = f"{name}: {verdict}, {possible}"
    if law is not None:
        heading += f"; by {law.law} {'no motion' if answer.timed is None else _judged(answer.timed)}"
    return ReportSection(heading, tuple(rows), tone, level=2)


def _of_structure(answer: OrbitAnswer, heading: str) -> ReportSection:
    orbit, tell, largest = answer.orbit, Teller.of(answer.orbit.system), answer.stability.multipliers.largest
    speed, energy = tell(orbit.impact_velocity, "speed", plain=6), tell(orbit.blow_energy, "energy")
    stable = "stable" if answer.stability.stable else "not stable"
    rows = (
        ("impact", f"at the load phase {number(orbit.phase, 6)} rad with {speed}; kinetic energy {energy}"),
        ("motion", "possible" if orbit.obstacle is None else f"not possible: {orbit.obstacle.words}"),
        ("stability", f"{stable}: largest multiplier {number(largest, 6)}"),
    )
    return ReportSection(heading, rows, GOOD if answer.runs else BAD)


def _possible(answer: OrbitAnswer) -> str:
    orbit, tell = answer.orbit, Teller.of(answer.orbit.system)
    if orbit.admissible and not orbit.proven:
        return "yes, as far as the sums over modes tell, but not proved: a touch between the blows cannot be ruled out"
    if orbit.admissible:
        return "yes: the bar strikes forward and stays clear of the wall between the blows"
    if orbit.violation is None or orbit.obstacle is Reason.NO_BLOW:
        return "no: at the moment of impact the striking end would be moving away from the wall"
    time, depth = tell(orbit.violation.time, "time"), tell(orbit.violation.depth, "length")
    return f"no: {time} after the impact the striking end would be inside the wall, {depth} deep"


def _verdict(judged: Stability | TimedStability) -> str:
    verdict = "stable" if judged.stable else "unstable"
    return judged.reason if judged.reason.startswith(verdict) else f"{verdict}: {judged.reason}"


def _margins(judged: Stability) -> str:
    """What becomes of a disturbance of the bar as a whole, and of one that rings."""
    found, ringing = judged.multipliers, judged.margin_ringing
    text = f"rhythm {number(judged.margin_rhythm, 3)}: an error in the time or the speed of a blow "
    text += f"{_becomes(found.rhythm)} with every impact"
    if ringing is None or found.ringing is None:
        return text
    text += f"; ringing {number(ringing, 3)}: the slowest elastic mode ({found.ringing_mode})"
    return f"{text} {_becomes(found.ringing)}"


def _becomes(modulus: float) -> str:
    return f"shrinks to {percent(modulus)}" if modulus < 1.0 else f"grows by a factor of {number(modulus)}"


def _multipliers(judged: Stability) -> str:
    exact, reduced = judged.multipliers, judged.reduced
    text = f"largest exact {number(exact.largest, 6)} ({counted(exact.modes, 'mode')})"
    text += f"; reduced (B77) {number(max(float(x) for x in reduced.moduli), 6)}"
    if reduced.other_side is not None:
        text += f", {number(max(float(x) for x in reduced.other_side.moduli), 6)} on the other side of the jump"
    return text


def _waveform(judged: Stability, tell: Teller) -> str:
    """The waveform criterion (theory §11) in words, and what to change."""
    criterion = judged.waveform
    values = (criterion.force, criterion.force_lower, criterion.force_upper)
    force, lower, upper = (tell(value, "force") for value in values)
    text = f"{force}; a stable blow of a rigid, undamped bar needs a force between {lower} and {upper} (the mean)"
    if criterion.stable:
        return text
    if criterion.ratio >= criterion.upper:
        return f"{text}. The force is too large: let the blow fall where the load is below its mean"
    text += f". The force is too low: reduce the return force at the moment of impact to less than {lower.lstrip('-')}"
    needed = criterion.restitution_needed
    if needed is None:
        return text
    return f"{text}, or, with this force, strike with a restitution below {number(needed, 3)}"


def _blow(answer: OrbitAnswer, tell: Teller) -> str:
    orbit = answer.orbit
    end, rigid = (tell(value, "speed", plain=6) for value in (orbit.impact_velocity, orbit.rigid_velocity))
    apart = abs(orbit.rigid_velocity - orbit.impact_velocity) > 0.01 * abs(orbit.impact_velocity)
    speed = f"{end} at the striking end, {rigid} on average" if apart or not tell.is_si else end
    blow, taken = (tell(value, "energy", plain=6) for value in (orbit.blow_energy, orbit.delivered_energy))
    return f"{blow}, of which {taken} taken by the impact (R); {speed}"


def _power(answer: OrbitAnswer, tell: Teller) -> str:
    """Where the power goes; the blows carry more than is put in where the rebound keeps much."""
    orbit = answer.orbit
    blow, taken = orbit.blow_energy / orbit.period, orbit.delivered_energy / orbit.period
    share = FIGURES["efficiency"].value(orbit)
    efficiency = "" if share is None else f"; efficiency {percent(share)} of the input"
    return (
        f"input {tell(orbit.energy.input / orbit.period, 'power')}; percussive {tell(blow, 'power')} "
        f"(energy before the impact times rate) = {tell(taken, 'power')} taken by the impact + "
        f"{tell(blow - taken, 'power')} kept by the rebound{efficiency}"
    )


def _stress(answer: OrbitAnswer, _: Teller) -> str | None:
    si = answer.si
    if si is None:
        return None
    peak = "" if si.peak_stress_MPa is None else f"{number(si.peak_stress_MPa)} MPa peak, "
    return f"{peak}for a contact of {number(si.contact_time_us)} µs"


def _drag(answer: OrbitAnswer, tell: Teller) -> str | None:
    si, drag = answer.si, answer.drag
    if not answer.orbit.system.d:
        return None
    head = "" if si is None else f"c = {number(si.drag_N_s_m)} N·s/m: "
    text = f"{head}{tell(drag.force, 'force')} at the striking speed, {percent(drag.of_mean)} of the mean push"
    return text if drag.of_input is None else f"{text}; damping takes {percent(drag.of_input)} of the input"


def _energy(answer: OrbitAnswer, tell: Teller) -> str:
    energy = answer.orbit.energy
    put_in, impact, damping = (
        tell(value, "energy", plain=5) for value in (energy.input, energy.impact, energy.damping)
    )
    misses = abs(energy.imbalance) / max(abs(energy.input), abs(energy.impact), 1e-300)
    closing = f"closes to {number(misses, 2)} ({counted(answer.orbit.modes, 'mode')})"
    return f"{put_in} in per impact = {impact} to the impact + {damping} to damping; {closing}"


def _about(
    label: str, name: str, words: str | Callable[[OrbitAnswer, Teller], str | None] | None = None
) -> Fact[OrbitAnswer]:
    """A line about a figure of an orbit; without words its value in its unit."""
    figure = FIGURES[name]

    def said(answer: OrbitAnswer, tell: Teller) -> str | None:
        value = figure.in_si(answer.orbit) if tell.is_si else figure.value(answer.orbit)
        return None if value is None else measured(value, figure.unit if tell.is_si else "")

    return Fact("", label, figure.meaning, "", lambda one: figure.value(one.orbit), words or said)


_BLOW = (
    _about("blow", "blow_energy", _blow),
    _about("rate", "blow_rate", "{si.blow_rate_Hz} Hz = {si.blow_rate_per_min} blows/min"),
    _about("power", "power", _power),
    _about("stress", "stress", _stress),
    _about("drag", "drag_force", _drag),
    _about("energy", "input_power", _energy),
    *(_about(figure.label, name) for name, figure in FIGURES.items() if figure.line),
)
"""What a blow is, of a motion that strikes."""


# ---- Where random starts end, as a section of the report


def ends_section(ends: Ends, name: str, system: System) -> ReportSection:
    """What the starts were, and a line for each end."""
    if not ends.followed:
        return ReportSection("Random starts", (("starts", f"not followed: {ends.note}"),))
    modes = counted(ends.modes, "elastic mode") if ends.modes else "a rigid bar"
    begun = f"{ends.followed} on the wall, leaving it with a random speed at a random phase; {modes}, up to "
    begun += f"{counted(ends.impacts, 'impact')}"
    rows = [("starts", f"{begun}; 'percuss experiment {as_typed(name)}' follows more")]
    rows += [(end.label, _line(end, ends.followed, system)) for end in ends.ends]
    if ends.note:
        rows.append(("note", ends.note))
    return ReportSection("Random starts", tuple(rows))


def _line(end: End, followed: int, system: System) -> str:
    text = f"{end.starts} of {followed} {does(end.label, end.starts)}"
    delivered = power(end, system)
    return f"{text}: {delivered}" if delivered else text


# ---- An answer as the report that a person reads: a title, a summary, and sections of labelled lines


def steady_report(answer: SteadyAnswer) -> Report:
    sections: list[ReportSection | Grid] = [system_section(answer.name, answer.system, answer.told_notes, answer.law)]
    if answer.uncertainty is not None:
        sections.append(answer.uncertainty.grid)
    for period in answer.periods:
        sections.append(_existence_section(answer.system, period))
        count = len(period.orbits)
        for i, found in enumerate(period.orbits):
            sections.append(orbit_section(found, f"Motion {i + 1} of {count}{_in(period.states.periods)}", answer.law))
        sections += alone_sections(period)
    if answer.transfer is not None and answer.chosen is not None:
        which = f", one blow {every(answer.chosen.orbit.periods)}" if len(answer.running) > 1 else ""
        sections.append(transfer_section(answer.transfer, which))
    if answer.reach is not None:
        law = "" if answer.law is None else ", by B77's law"
        motion = "" if answer.chosen is None or answer.rest is None else f"{name_of(answer, answer.chosen)}{law}"
        sections.append(_reach_section(answer.reach, motion))
    if answer.rest is not None:
        sections.append(_rest_section(answer.rest, answer.system))
        sections.append(ends_section(answer.starts, answer.name, answer.system))
    told = summary_of(answer)
    return Report(answer.title, told.text, GOOD if told.runs else BAD, tuple(sections)).of_tool(answer.tool)


# -- what exists ----------------------------------------------------------------------------------------------------


def _existence_section(system: System, period: PeriodAnswer) -> ReportSection:
    states = period.states
    count = len(states.orbits)
    heading = f"One impact {every(states.periods)}"
    if not system.body.is_free:
        compared = f"gap {number(states.level)}, the contact would come to {number(states.level_max)} at most"
        text, tone = f"{counted(count, 'steady motion')}: {compared}", PLAIN
        if states.note:
            text, tone = f"not looked for: {states.note}", BAD
        elif not states.exists:
            text, tone = f"no: the contact does not reach the wall so ({compared})", BAD
        return ReportSection(heading, (("exists", text),), tone)
    compared = f"level {number(states.level)}, greatest v_f {number(states.level_max)}"
    if states.note and not states.exists:
        return ReportSection(heading, (("exists", f"no: {states.note} ({compared})"),), BAD)
    if states.exists:
        text = f"{counted(count, 'steady motion')}: {compared}"
        note = (("note", states.note),) if states.note else ()
        return ReportSection(heading, (("exists", text), *existence_row(period), *note))
    rows = [("exists", f"no: {Reason.NO_MOTION.words} ({compared})"), *existence_row(period)]
    nearest = states.nearest
    if nearest is not None and nearest.load_factor is not None:
        now, then = system.load.load_factor, nearest.load_factor
        text = f"load factor {number(then)} (now {number(now)})"
        if system.is_si:
            mean, tell = system.load.mean, Teller.of(system)
            text += (
                f": a mean force of {tell(mean * then / now, 'force')} instead of {tell(mean, 'force')} "
                "with the same alternating part"
            )
        rows.append(("nearest", text))
    if nearest is not None and nearest.restitution is not None:
        text = f"restitution {number(nearest.restitution)} (now {number(system.restitution)})"
        rows.append((_another(rows), text))
    if period.greatest_drag is not None:
        rows.append((_another(rows), _less_damping(system, period.greatest_drag)))
    if not any(label == "nearest" for label, _ in rows):
        rows.append(("nearest", "no load factor and no restitution allows one"))
    return ReportSection(heading, tuple(rows), BAD)


def _another(rows: list[tuple[str, str]]) -> str:
    """The label of one more way to a motion."""
    return "or" if any(label == "nearest" for label, _ in rows) else "nearest"


def _less_damping(system: System, d: float) -> str:
    text = f"damping at most {percent(d / system.d)} of its present value, so that it drags the bar less"
    if system.bar is None:
        return f"{text}: d = {number(d)} (now {number(system.d)})"
    drag = system.bar.rigid_drag
    return f"{text}: c = {number(drag * d / system.d)} N·s/m (now {number(drag)})"


def _reach_section(reach: tuple[CaseReach, ...], motion: str) -> ReportSection:
    """How far parameters may move before a motion is lost; `motion`: which one, "" where there is but one."""
    rows = [("motion", motion)] if motion and reach else []
    rows += [(row.label, row.words) for row in reach] or [("reach", "no stable motion to follow")]
    return ReportSection("How far parameters may move", tuple(rows))


def _rest_section(rest: Rest, system: System) -> ReportSection:
    tell = Teller.of(system)
    least, load = tell(rest.least_contact_force, "force"), tell(rest.quasi_static, "force")
    if not math.isfinite(rest.least_contact_force):
        text = f"not possible: a bar at rest is driven at resonance (the load itself never falls below {load})"
    elif rest.held_by_waves:
        text = (
            f"possible only with every wave in the bar: with them the contact force never falls below {least}, but the "
            f"load itself pulls with up to {tell(-rest.quasi_static, 'force')}. A simulation, which leaves these waves "
            "out at rest, lets the bar go there, so that random starts do not stay"
        )
    elif rest.possible:
        text = (
            f"possible: the contact force never falls below {least} with the waves in the bar "
            f"(the load itself not below {load}); a hammer started gently may stay at rest"
        )
    elif rest.lifted_by_waves:
        text = (
            f"not possible: waves in the bar let the contact force fall to {least}, which lifts the end off the wall "
            f"briefly (for the time a wave needs there and back, 2L/C); the load itself never falls below {load}, so a "
            "simulation, which neglects these waves while the bar rests, leaves it at rest"
        )
    else:
        text = (
            f"not possible: the contact force would fall to {least} with the waves in the bar "
            f"(the load itself to {load}), so the load pulls the bar off"
        )
    note = rest_note(rest, system.contact)
    return ReportSection("At rest on the wall", (("rest", f"{text}. {note}" if note else text),))
