"""One blow as the report that a person reads: what became of its energy, its contacts, its forces and stresses."""

from __future__ import annotations

from typing import TYPE_CHECKING

from percuss.case.answers.blow_answer import blow_in_words
from percuss.case.answers.numerals import counted, number, percent, quantity
from percuss.case.answers.report_parts import BAD, GOOD, PLAIN, Grid, Report, Section

if TYPE_CHECKING:
    from percuss.blow import ContactInterval, Peak
    from percuss.case.answers.blow_answer import BlowAnswer

_SHOWN = 12
"""Contacts that are listed one by one."""


def blow_report(answer: BlowAnswer) -> Report:
    """The report of `percuss blow`."""
    sections: list[Section | Grid] = [_question(answer), _contacts(answer), _energy(answer)]
    if answer.rod is not None:
        sections.append(_rod(answer))
    if answer.measured is not None:
        sections.append(Section("Measured at the gauge", answer.measured.rows))
    if answer.blow.penetration is not None:
        sections.append(_rock(answer))
    sections += [_stresses(answer), *_beside(answer)]
    tone = GOOD if answer.blow.outcome.name in ("OVER", "SPENT") else PLAIN
    cut = answer.blow.outcome.name == "TOO_MANY_PIECES"
    return Report(answer.title, blow_in_words(answer), BAD if cut else tone, tuple(sections))


def _question(answer: BlowAnswer) -> Section:
    blow, rod = answer.blow, answer.rod
    struck = "a rigid wall" if rod is None else _rod_in_words(answer)
    rows = [
        ("case", answer.name),
        ("striker", str(blow.striker)),
        ("it strikes", struck),
        ("speed", f"{answer.tell(blow.mean_velocity_before, 'speed')}, {answer.speed}"),
        ("window", f"{answer.tell(blow.until, 'time')}; {blow.outcome.value}"),
    ]
    return Section("The blow", (*rows, *(("note", note) for note in answer.notes)))


def _rod_in_words(answer: BlowAnswer) -> str:
    rod = answer.rod
    assert rod is not None
    if rod.impedance is not None:
        return f"an endless rod of impedance {number(rod.impedance)}"
    far = {"infinite": "endless", "free": "free at its end", "fixed": "fixed at its end", "rock": "with a bit on rock"}
    areas = [1e6 * piece.area for piece in rod.pieces]
    span = f"{number(min(areas))} … {number(max(areas))}" if min(areas) < max(areas) else number(areas[0])
    known = sum(section.length for section in rod.sections if section.length is not None)
    long = f"{quantity(known, 'm')}, " if known else ""
    mass = f", {number(rod.bit_mass)} kg at the end" if rod.bit_mass else ""
    return f"a rod of {counted(len(rod.pieces), 'section')}, {long}{span} mm², {far[rod.end]}{mass}"


def _contacts(answer: BlowAnswer) -> Grid | Section:
    blow = answer.blow
    if not blow.contacts:
        return Section("Contacts", (("none", "the striker has not reached the target in the window"),), BAD)
    rows = tuple(_contact(answer, spell) for spell in blow.contacts[:_SHOWN])
    more = len(blow.contacts) - _SHOWN
    heading = counted(len(blow.contacts), "contact")
    if more > 0:
        heading += f", of which the first {_SHOWN}"
    if blow.grazes:
        heading += f"; {counted(blow.grazes, 'touch').replace('touchs', 'touches')} without an impulse left out"
    return Grid(heading, ("start", "end", "impulse", "peak force"), rows)


def _contact(answer: BlowAnswer, spell: ContactInterval) -> tuple[str, ...]:
    end = "still closed" if spell.end is None else answer.tell(spell.end, "time")
    return (
        answer.tell(spell.start, "time"),
        end,
        answer.tell(spell.impulse, "momentum"),
        answer.tell(spell.peak_force, "force"),
    )


def _energy(answer: BlowAnswer) -> Section:
    blow = answer.blow
    before = blow.energy_before + max(blow.load_work, 0.0)

    def share(value: float) -> str:
        told = answer.tell(value, "energy")
        return f"{told} ({percent(value / before)})" if before > 0.0 else told

    rows = [("before", answer.tell(blow.energy_before, "energy"))]
    if blow.load_work:
        rows.append(("work of the load", answer.tell(blow.load_work, "energy")))
    rows += [
        ("through the face", share(blow.work_through_face)),
        ("with the striker", f"{share(blow.rigid_energy_after)}, at {answer.tell(blow.mean_velocity_after, 'speed')}"),
        ("ringing in it", share(blow.vibration_energy_after)),
        ("closes to", f"energy {blow.energy_error:.1e}, momentum {blow.momentum_error:.1e}, relative"),
    ]
    if blow.effective_restitution is not None:
        rows.append(("restitution", f"R = {number(blow.effective_restitution, 6)}"))
    if blow.contact_duration is not None and blow.force_centroid is not None:
        centre = f"centroid of the force at {answer.tell(blow.force_centroid, 'time')}"
        rows.append(("contact", f"{answer.tell(blow.contact_duration, 'time')}; {centre}"))
    return Section("Energy", tuple(rows))


def _rod(answer: BlowAnswer) -> Section:
    pulse, waves = answer.blow.first_pulse, answer.waves
    assert waves is not None  # there is a rod
    rows = []
    if pulse is not None:
        tell = answer.tell
        first = f"{tell(pulse.length, 'time')} long, peak {tell(pulse.peak, 'force')} after {tell(pulse.rise, 'time')}"
        rows.append(("first pulse", f"{first}, {answer.tell(pulse.energy, 'energy')}"))
    place = "at the gauge" if answer.gauge is None else f"{answer.tell(answer.gauge, 'length')} from the face"
    rows += [
        ("gauge", place),
        ("incident wave", answer.tell(waves.incident_energy, "energy")),
        ("reflected wave", answer.tell(waves.reflected_energy, "energy")),
        (
            "∫F²/Z dt",
            f"{answer.tell(waves.tool_energy, 'energy')}; the energy that passes only while nothing has come back",
        ),
        ("left in the rod", answer.tell(answer.blow.rod_energy, "energy")),
    ]
    return Section("The wave in the rod", tuple(rows))


def _rock(answer: BlowAnswer) -> Section:
    blow = answer.blow
    assert blow.bit_force is not None
    depth = [blow.greatest_penetration or 0.0, blow.residual_penetration or 0.0]
    rows = [
        (
            "work on it",
            f"{answer.tell(blow.rock_work, 'energy')}, of which {answer.tell(blow.rock_dissipated, 'energy')} for good",
        ),
        ("penetration", f"{quantity(depth[0], 'm')}, of which {quantity(depth[1], 'm')} remain"),
        ("peak force", answer.tell(blow.bit_force.peak, "force")),
    ]
    if answer.beta is not None:
        rows.append(("β", f"{number(answer.beta)} = K₁T/Z of the first pulse; a rectangular one does most at 1.256"))
    if blow.efficiency is not None:
        rows.append(("efficiency", f"{percent(blow.efficiency)} of the energy before the blow"))
    if blow.efficiency_with_rebound is not None:
        rows.append(("", f"{percent(blow.efficiency_with_rebound)} without what rebounds with the striker"))
    return Section("The rock", tuple(rows))


def _stresses(answer: BlowAnswer) -> Grid:
    own, rod = answer.peaks
    rows = [_peak(answer, f"striker {i}", one) for i, one in enumerate(own)]
    rows += [_peak(answer, f"rod {i}", one) for i, one in enumerate(rod)]
    what = "stress" if answer.is_si else "force"
    columns = ("section, from 0", f"compression ({what})", "where", "when", "tension", "where", "when")
    return Grid("Greatest stresses" if answer.is_si else "Greatest forces", columns, tuple(rows))


def _peak(answer: BlowAnswer, name: str, peak: Peak) -> tuple[str, ...]:
    def told(value: float, place: float | None, time: float | None) -> tuple[str, str, str]:
        if place is None or time is None:
            return "none", "", ""
        return answer.tell(value, "stress"), answer.tell(place, "length"), answer.tell(time, "time")

    first = told(peak.compression, peak.compression_place, peak.compression_time)
    return (name, *first, *told(peak.tension, peak.tension_place, peak.tension_time))


def _beside(answer: BlowAnswer) -> list[Section]:
    """What formulas say of such a blow, and what the theory leaves out."""
    found = []
    if answer.formulas:
        found.append(Section("In closed form", tuple((one.name, one.text) for one in answer.formulas)))
    if answer.left_out:
        found.append(Section("What one-dimensional waves leave out", answer.left_out))
    return found
