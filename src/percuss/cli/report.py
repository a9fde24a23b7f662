"""An answer as the report that a person reads: a title, a summary, and sections of labelled lines."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from percuss.cli.blocks import BAD, GOOD, Report, Section
from percuss.cli.card import orbit_section
from percuss.cli.numbers import number, percent, quantity

if TYPE_CHECKING:
    from percuss.case import OrbitAnswer, PeriodAnswer, SteadyAnswer
    from percuss.model import System
    from percuss.model.history import HistoryReport

__all__ = ["steady_report", "system_section"]


def steady_report(answer: SteadyAnswer) -> Report:
    """The report of `percuss steady`."""
    sections = [system_section(answer.name, answer.system, answer.notes)]
    for period in answer.periods:
        sections.append(_existence_section(answer.system, period))
        count = len(period.orbits)
        for i, found in enumerate(period.orbits):
            sections.append(orbit_section(found, f"Orbit {i + 1} of {count}, m = {period.states.periods}"))
    sections.append(_rest_section(answer))
    summary, tone = _summary(answer)
    return Report(answer.title, summary, tone, tuple(sections))


def _summary(answer: SteadyAnswer) -> tuple[str, str]:
    running = answer.running
    asked = ", ".join(str(period.states.periods) for period in answer.periods)
    if running:
        first = running[0]
        how = f"one blow {every(first.orbit.periods)}"
        figures = f"phase {number(first.orbit.phase)} rad, striking speed {number(first.orbit.impact_velocity)}"
        if first.si is not None:
            rate = f"{number(first.si.blow_rate_Hz)} Hz ({number(first.si.blow_rate_per_min)} blows/min)"
            figures = f"{quantity(first.si.blow_energy_J, 'J')} at {rate}, {number(first.si.impact_velocity_m_s)} m/s"
        margin = number(first.stability.margin, 3)
        text = f"The hammer runs with {how}: {figures}; stable, margin {margin} ({_name(answer, first)} below)."
        others = sorted({other.orbit.periods for other in running[1:]})
        if others:
            also = ", ".join(str(m) for m in others)
            text += f" It can also settle on m = {also}; which one it takes depends on how it starts."
        return text, GOOD
    rest = " The bar may also come to rest on the wall." if answer.rest.possible else ""
    if any(period.orbits for period in answer.periods):
        return f"No motion with m = {asked} can be kept up: see below what fails.{rest}", BAD
    return (
        f"No steady motion with one impact per m = {asked} load periods exists: see below what would.{rest}",
        BAD,
    )


def _name(answer: SteadyAnswer, found: OrbitAnswer) -> str:
    """``orbit 2`` as the cards are numbered."""
    number_of = {id(one): i + 1 for period in answer.periods for i, one in enumerate(period.orbits)}
    return f"orbit {number_of[id(found)]}, m = {found.orbit.periods}"


def every(m: int) -> str:
    """``every load period``, ``in 3 load periods``."""
    return "every load period" if m == 1 else f"in {m} load periods"


# -- the hammer -----------------------------------------------------------------------------------------------------


def system_section(name: str, system: System, notes: tuple[str, ...]) -> Section:
    """What was understood of the hammer: bar, dimensionless numbers, load, recording."""
    rows: list[tuple[str, str]] = [("case", name)]
    bar, history = system.bar, system.load.report
    if bar is not None:
        first = float(bar.natural_frequencies(1)[0])
        rows.append(
            (
                "bar",
                f"{quantity(bar.length, 'm')} long, {number(1e4 * bar.area)} cm², {number(bar.mass)} kg, wave speed "
                f"{number(bar.wave_speed)} m/s, first mode {quantity(first, 'Hz')}",
            )
        )
    rows.append(
        (
            "dimensionless",
            f"s = {number(system.s, 6)}, d = {number(system.d, 6)}, restitution R = {number(system.restitution)}",
        )
    )
    rows.append(("load", _load_text(system)))
    if history is not None:
        rows.append(("history", _history_text(history)))
        rows += [("warning", warning) for warning in history.warnings]
    rows += [("note", note) for note in notes]
    return Section("Hammer", tuple(rows))


def _load_text(system: System) -> str:
    load = system.load
    size = load.harmonics.size
    shape = f"{size} harmonic{'s' if size != 1 else ''}"
    if load.is_piecewise:
        shape = f"{len(load.values)} exact steps ({shape} beside them)"
    factor = f"mean / first harmonic = {number(load.load_factor)}"
    if not system.is_si or system.frequency is None:
        return f"mean {number(load.mean)}, {shape}, {factor}"
    return f"mean {quantity(load.mean * system.force_scale, 'N')}, {shape}, {factor}, {number(system.frequency)} Hz"


def _history_text(report: HistoryReport) -> str:
    found = "given" if report.frequency_given else "found"
    return (
        f"{report.cycles} cycles, {report.samples} samples at {quantity(report.sample_rate, 'Hz')}; "
        f"{number(report.frequency, 5)} Hz ({found}), period varies by {percent(report.jitter)}; cycles scatter "
        f"{percent(report.scatter)} about their mean, drift {percent(report.drift)}; {report.harmonics} harmonics "
        f"kept, residual {percent(report.residual)}"
    )


# -- what exists ----------------------------------------------------------------------------------------------------


def _existence_section(system: System, period: PeriodAnswer) -> Section:
    states = period.states
    count = len(states.orbits)
    heading = f"One impact {every(states.periods)} (m = {states.periods})"
    compared = f"level {number(states.level)}, greatest v_f {number(states.level_max)}"
    if states.note:
        return Section(heading, (("exists", f"no: {states.note} ({compared})"),), BAD)
    if states.exists:
        text = f"{count} steady motion{'s' if count != 1 else ''}: {compared}"
        return Section(heading, (("exists", text),))
    rows = [("exists", f"no: the level is above what the load can reach ({compared})")]
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
        rows.append(("or" if len(rows) > 1 else "nearest", text))
    if len(rows) == 1:
        rows.append(("nearest", "no load factor and no restitution makes one"))
    return Section(heading, tuple(rows), BAD)


def _rest_section(answer: SteadyAnswer) -> Section:
    rest, system = answer.rest, answer.system
    force = number(rest.least_contact_force)
    if system.is_si:
        force = quantity(rest.least_contact_force * system.force_scale, "N")
    if not math.isfinite(rest.least_contact_force):
        text = "not possible: a bar at rest is driven in resonance"
    elif rest.possible:
        text = f"possible: the contact force never falls below {force}; a hammer started gently may stay there"
    else:
        text = f"not possible: the contact force would fall to {force}, so the load pulls the bar off"
    return Section("At rest on the wall", (("rest", text),))
