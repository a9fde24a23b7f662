"""The report of `percuss steady` on a structure that is held."""

from __future__ import annotations

from typing import TYPE_CHECKING

from percuss.case.answers.first_lines import every
from percuss.case.answers.numerals import counted, number, quantity
from percuss.case.answers.reach_in_words import ends_in_words
from percuss.cli.report_parts import BAD, GOOD, Report, Section
from percuss.cli.system_section import system_section

if TYPE_CHECKING:
    from percuss.case.answers.structure_answer import StructureAnswer, StructureMotion
    from percuss.steady import SteadyStates

__all__ = ["structure_report"]


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
    orbit, system = one.orbit, one.orbit.system
    speed, energy = number(orbit.impact_velocity, 6), number(orbit.blow_energy, 4)
    if system.is_si:
        speed = f"{number(orbit.impact_velocity * system.speed_scale)} m/s"
        energy = quantity(orbit.blow_energy * system.energy_scale, "J")
    possible = "possible" if orbit.obstacle is None else f"not possible: {orbit.obstacle.words}"
    largest = one.multipliers.largest
    rows = (
        ("impact", f"at the load phase {number(orbit.phase, 6)} rad with {speed}; kinetic energy {energy}"),
        ("motion", possible),
        ("stability", f"{'stable' if one.stable else 'not stable'}: largest multiplier {number(largest, 6)}"),
    )
    return Section(heading, rows, GOOD if one.stable and orbit.admissible else BAD)
