"""An answer as the report that a person reads: a title, a summary, and sections of labelled lines."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING

from percuss.case.answers.facts import Fact, Teller, rows_of
from percuss.case.answers.numerals import as_typed, counted, number, percent
from percuss.case.answers.reach_in_words import ends_in_words
from percuss.case.answers.report_parts import BAD, GOOD, Report, Section, system_section
from percuss.case.answers.sentences import ENDED, does, every, name_of, power, summary_of, timed_in_words
from percuss.case.answers.steady_answer import rest_note
from percuss.steady.figures import FIGURES
from percuss.steady.orbit import Reason

if TYPE_CHECKING:
    from percuss.case import OrbitAnswer, PeriodAnswer, SteadyAnswer
    from percuss.case.answers.ends import End, Ends
    from percuss.case.answers.steady_answer import TimedAnswer
    from percuss.case.answers.structure_answer import StructureAnswer, StructureMotion
    from percuss.model import System, Timed
    from percuss.stability import Stability
    from percuss.steady import Orbit, SteadyStates


# ---- What a law that knows the duration of the blow says, as lines of the report beside those of B77's law


def existence_row(period: PeriodAnswer) -> list[tuple[str, str]]:
    """How many motions there are under the law."""
    if period.timed is None:
        return []
    states = period.timed.states
    compared = f"level {number(states.level)}, greatest v_f − e p {number(states.level_max)}"
    return [(states.law.law, f"{counted(len(states.orbits), 'steady motion')}: {compared}")]


def timed_heading(answer: OrbitAnswer, law: Timed | None) -> str:
    """What is added to the heading of a motion of B77's law."""
    if law is None:
        return ""
    return f"; by {law.law} {'no motion' if answer.timed is None else _judged(answer.timed)}"


def timed_rows(answer: OrbitAnswer, law: Timed | None) -> list[tuple[str, str]]:
    """The lines on a motion of B77's law that say what becomes of it when its blows take time."""
    if law is None:
        return []
    return [(law.law, ENDED)] if answer.timed is None else _rows(answer.timed, answer.stability)


def alone_sections(period: PeriodAnswer) -> list[Section]:
    """Cards of the motions that continue none of B77's."""
    if period.timed is None:
        return []
    heading = f"Of {period.timed.states.law.law} alone, m = {period.states.periods}"
    return [
        Section(f"{heading}: {_judged(found)}", tuple(_rows(found, None)), GOOD if found.runs else BAD, level=2)
        for found in period.timed.alone
    ]


def _judged(found: TimedAnswer) -> str:
    verdict = "stable" if found.stability.stable else "unstable"
    return f"{verdict}, {'possible' if found.orbit.admissible else 'not possible'}"


def _rows(found: TimedAnswer, judged: Stability | None) -> list[tuple[str, str]]:
    first, *more = timed_in_words(found, judged)
    rows = [(found.orbit.law.law, first), *(("", text) for text in more)]
    return [*rows, *(("warning", warning) for warning in found.orbit.warnings)]


# ---- One orbit as a section of the report: what it is, whether it can be sustained, and what to change if not

MOST_WARNINGS = 3
"""Warnings that a card shows; the rest is in the JSON."""


def orbit_section(answer: OrbitAnswer, name: str, law: Timed | None = None) -> Section:
    """The card of an orbit, with what a law of blows that take time makes of it."""
    orbit, judged, tell = answer.orbit, answer.stability, Teller.of(answer.orbit.system)
    verdict = "stable" if judged.stable else "unstable"
    possible = "possible" if orbit.admissible else "not possible"
    rows = [
        ("phase", _phase(orbit.phase, tell)),
        ("possible", _possible(answer)),
        ("verdict", _verdict(judged)),
        ("margins", _margins(judged)),
        ("multipliers", _multipliers(judged)),
    ]
    if judged.disagreement:
        rows.append(("note", judged.disagreement))
    rows.append(("force at impact", _waveform(judged, tell)))
    if orbit.impact_velocity > 0.0:
        rows += rows_of(answer, _BLOW, tell)
    else:
        rows.append(("blow", _no_blow(orbit, tell)))
    rows += timed_rows(answer, law)
    rows += [("warning", warning) for warning in orbit.warnings[:MOST_WARNINGS]]
    if len(orbit.warnings) > MOST_WARNINGS:
        rows.append(("", f"and {len(orbit.warnings) - MOST_WARNINGS} more; --json has them all"))
    tone = GOOD if answer.runs else BAD
    heading = f"{name}: {verdict}, {possible}{timed_heading(answer, law)}"
    return Section(heading, tuple(rows), tone, level=2)


def _phase(phase: float, tell: Teller) -> str:
    text = f"{number(phase, 5)} rad = {number(math.degrees(phase))}°"
    return f"{text} = {tell(phase, 'time')} into the load period" if tell.is_si else text


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


def _verdict(judged: Stability) -> str:
    verdict = "stable" if judged.stable else "unstable"
    reason = judged.reason if judged.reason.startswith(verdict) else f"{verdict}: {judged.reason}"
    return reason


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


def _no_blow(orbit: Orbit, tell: Teller) -> str:
    speed = -orbit.impact_velocity
    told = tell(speed, "speed", plain=6)
    return f"none: the striking end would be leaving the wall at {told}" if speed else "none: the end would stand still"


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


def _mean_force(answer: OrbitAnswer, tell: Teller) -> str | None:
    si = answer.si
    text = None if si is None else f"momentum {number(si.momentum_N_s)} N·s per blow"
    return text and f"{tell(FIGURES['mean_force'].value(answer.orbit) or 0.0, 'force')}; {text}"


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


def _rate(answer: OrbitAnswer, _: Teller) -> str | None:
    si = answer.si
    return None if si is None else f"{number(si.blow_rate_Hz)} Hz = {number(si.blow_rate_per_min)} blows/min"


def _about(
    label: str, name: str, dimension: str, words: Callable[[OrbitAnswer, Teller], str | None]
) -> Fact[OrbitAnswer]:
    """A line about a figure of an orbit."""
    return Fact("", label, FIGURES[name].meaning, dimension, lambda one: FIGURES[name].value(one.orbit), words)


_BLOW = (
    _about("blow", "blow_energy", "energy", _blow),
    _about("rate", "blow_rate", "rate", _rate),
    _about("power", "power", "power", _power),
    _about("stroke", "stroke", "length", lambda one, tell: tell(one.orbit.stroke, "length", plain=6)),
    _about("stress", "stress", "stress", _stress),
    _about("mean force", "mean_force", "force", _mean_force),
    _about("drag", "drag_force", "force", _drag),
    _about("energy", "input_power", "energy", _energy),
)
"""What a blow is, of a motion that strikes."""


# ---- Where random starts end, as a section of the report


def ends_section(ends: Ends, name: str, system: System) -> Section:
    """What the starts were, and a line for each end."""
    if not ends.followed:
        return Section("Random starts", (("starts", f"not followed: {ends.note}"),))
    modes = counted(ends.modes, "elastic mode") if ends.modes else "a rigid bar"
    begun = f"{ends.followed} on the wall, leaving it with a random speed at a random phase; {modes}, up to "
    begun += f"{counted(ends.impacts, 'impact')}"
    rows = [("starts", f"{begun}; 'percuss experiment {as_typed(name)}' follows more")]
    rows += [(end.label, _line(end, ends.followed, system)) for end in ends.ends]
    if ends.note:
        rows.append(("note", ends.note))
    return Section("Random starts", tuple(rows))


def _line(end: End, followed: int, system: System) -> str:
    text = f"{end.starts} of {followed} {does(end.label, end.starts)}"
    delivered = power(end, system)
    return f"{text}: {delivered}" if delivered else text


# ---- An answer as the report that a person reads: a title, a summary, and sections of labelled lines


def steady_report(answer: SteadyAnswer) -> Report:
    """The report of `percuss steady`."""
    sections = [system_section(answer.name, answer.system, answer.notes, answer.law)]
    for period in answer.periods:
        sections.append(_existence_section(answer.system, period))
        count = len(period.orbits)
        for i, found in enumerate(period.orbits):
            sections.append(orbit_section(found, f"Orbit {i + 1} of {count}, m = {period.states.periods}", answer.law))
        sections += alone_sections(period)
    if answer.reach is not None:
        sections.append(_reach_section(answer))
    sections.append(_rest_section(answer))
    sections.append(ends_section(answer.starts, answer.name, answer.system))
    told = summary_of(answer)
    return Report(answer.title, told.text, GOOD if told.runs else BAD, tuple(sections))


# -- what exists ----------------------------------------------------------------------------------------------------


def _existence_section(system: System, period: PeriodAnswer) -> Section:
    states = period.states
    count = len(states.orbits)
    heading = f"One impact {every(states.periods)} (m = {states.periods})"
    compared = f"level {number(states.level)}, greatest v_f {number(states.level_max)}"
    if states.note and not states.exists:
        return Section(heading, (("exists", f"no: {states.note} ({compared})"),), BAD)
    if states.exists:
        text = f"{counted(count, 'steady motion')}: {compared}"
        note = (("note", states.note),) if states.note else ()
        return Section(heading, (("exists", text), *existence_row(period), *note))
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
    return Section(heading, tuple(rows), BAD)


def _another(rows: list[tuple[str, str]]) -> str:
    """The label of one more way to a motion."""
    return "or" if any(label == "nearest" for label, _ in rows) else "nearest"


def _less_damping(system: System, d: float) -> str:
    text = f"damping at most {percent(d / system.d)} of its present value, so that it drags the bar less"
    if system.bar is None:
        return f"{text}: d = {number(d)} (now {number(system.d)})"
    drag = system.bar.rigid_drag
    return f"{text}: c = {number(drag * d / system.d)} N·s/m (now {number(drag)})"


def _reach_section(answer: SteadyAnswer) -> Section:
    """How far parameters may move before the motion is lost."""
    heading = "How far parameters may move"
    chosen = answer.chosen
    if not answer.reach or chosen is None:
        return Section(heading, (("reach", "no stable motion to follow"),))
    law = "" if answer.law is None else ", by B77's law"
    rows = [("motion", f"{name_of(answer, chosen)}{law}")] + [(row.label, ends_in_words(row)) for row in answer.reach]
    return Section(heading, tuple(rows))


def _rest_section(answer: SteadyAnswer) -> Section:
    rest, system = answer.rest, answer.system
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
    return Section("At rest on the wall", (("rest", f"{text}. {note}" if note else text),))


# ---- The report of `percuss steady` on a structure that is held


def structure_report(answer: StructureAnswer) -> Report:
    """The report of `percuss steady`."""
    sections = [system_section(answer.name, answer.system, answer.notes)]
    for states, motions in zip(answer.states, answer.motions, strict=True):
        sections.append(_existence(states))
        for i, one in enumerate(motions):
            sections.append(_motion(one, f"Orbit {i + 1} of {len(motions)}, m = {states.periods}"))
    if answer.reach is not None:
        sections.append(_reach(answer))
    number_of = sum(len(motions) for motions in answer.motions)
    stable = sum(one.stable and one.orbit.admissible for motions in answer.motions for one in motions)
    text = f"{counted(number_of, 'steady motion')} with one impact, {stable} of them possible and stable."
    return Report(answer.title, text, GOOD if answer.runs else BAD, tuple(sections))


def _reach(answer: StructureAnswer) -> Section:
    rows = tuple((row.label, ends_in_words(row)) for row in answer.reach or ())
    return Section("How far parameters may move", rows or (("reach", "no stable motion to follow"),))


def _existence(states: SteadyStates) -> Section:
    heading = f"One impact {every(states.periods)} (m = {states.periods})"
    if states.note:
        return Section(heading, (("exists", f"not looked for: {states.note}"),), BAD)
    compared = f"gap {number(states.level)}, the contact would come to {number(states.level_max)} at most"
    if not states.exists:
        return Section(heading, (("exists", f"no: the contact does not reach the wall so ({compared})"),), BAD)
    return Section(heading, (("exists", f"{counted(len(states.orbits), 'steady motion')}: {compared}"),))


def _motion(one: StructureMotion, heading: str) -> Section:
    orbit, tell = one.orbit, Teller.of(one.orbit.system)
    speed, energy = tell(orbit.impact_velocity, "speed", plain=6), tell(orbit.blow_energy, "energy")
    possible = "possible" if orbit.obstacle is None else f"not possible: {orbit.obstacle.words}"
    largest = one.multipliers.largest
    rows = (
        ("impact", f"at the load phase {number(orbit.phase, 6)} rad with {speed}; kinetic energy {energy}"),
        ("motion", possible),
        ("stability", f"{'stable' if one.stable else 'not stable'}: largest multiplier {number(largest, 6)}"),
    )
    return Section(heading, rows, GOOD if one.stable and orbit.admissible else BAD)
