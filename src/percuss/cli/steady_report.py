"""An answer as the report that a person reads: a title, a summary, and sections of labelled lines."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from percuss.case.answers.first_lines import every, name_of, summary_of
from percuss.case.answers.numerals import counted, number, percent, quantity
from percuss.case.answers.reach_in_words import ends_in_words
from percuss.case.answers.steady_json import rest_note
from percuss.cli.ends_section import ends_section
from percuss.cli.orbit_section import orbit_section
from percuss.cli.report_parts import BAD, GOOD, Report, Section
from percuss.cli.system_section import system_section
from percuss.cli.timed_section import alone_sections, existence_row
from percuss.steady.reason import Reason

if TYPE_CHECKING:
    from percuss.case import PeriodAnswer, SteadyAnswer
    from percuss.model import System

__all__ = ["steady_report"]


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
            mean = system.load.mean * system.force_scale
            text += (
                f": a mean force of {quantity(mean * then / now, 'N')} instead of {quantity(mean, 'N')} "
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

    def force(value: float) -> str:
        return quantity(value * system.force_scale, "N") if system.is_si else number(value)

    least, load = force(rest.least_contact_force), force(rest.quasi_static)
    if not math.isfinite(rest.least_contact_force):
        text = f"not possible: a bar at rest is driven at resonance (the load itself never falls below {load})"
    elif rest.held_by_waves:
        text = (
            f"possible only with every wave in the bar: with them the contact force never falls below {least}, but the "
            f"load itself pulls with up to {force(-rest.quasi_static)}. A simulation, which leaves these waves "
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
