"""A simulated motion as the report that a person reads: what it settled on, its figures, its last events."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING

from percuss.case.answers.clock_note import clock_in_short
from percuss.case.answers.facts import Teller
from percuss.case.answers.numerals import counted, number, percent, quantity
from percuss.case.answers.report_parts import BAD, GOOD, PLAIN, Grid, Report, Section, system_section
from percuss.case.answers.sentences import orbit_in_words
from percuss.case.answers.simulation_answer import held_down_in_words
from percuss.model.system import rests

if TYPE_CHECKING:
    from percuss.blow.periods import Impacts, WaveMotion
    from percuss.case import SimulationAnswer, WavesAnswer
    from percuss.case.answers.waves_answer import Beside
    from percuss.model import System
    from percuss.simulate import Event, Summary, Trajectory

_TURN = 2.0 * math.pi
_FEW = 3  # blows of a cycle that the headline tells one by one

_OUTCOMES = {
    "impacts": "the number of impacts is reached",
    "time": "the time is reached",
    "rest": "the bar lies on the wall for good",
    "periodic": "a periodic motion is found",
    "departed": "the bar has left the wall for good",
    "work": "one flight takes too much work",
    "memory": "the record has reached 1 GB",
    "cancelled": "interrupted",
    "unresolved": "released twice in the same state, but the period hangs on rounding",
}


def motion_report(answer: SimulationAnswer, last: int | None) -> Report:
    """The report of `percuss simulate` with the `last` events; None shows all of them."""
    motion = answer.motion
    sections: list[Section | Grid] = [
        system_section(answer.name, answer.system, answer.notes),
        _motion_section(answer),
        _figures_section(answer),
    ]
    if last != 0 and len(motion.events):
        sections.append(_events_grid(answer, last))
    summary, tone = _summary(answer)
    clock = clock_in_short(answer.system.load)
    return Report(answer.title, f"{summary} {clock}".rstrip(), tone, tuple(sections))


# -- in words -------------------------------------------------------------------------------------------------------


def _summary(answer: SimulationAnswer) -> tuple[str, str]:
    motion = answer.motion
    text = f"{label_in_words(motion)} ({motion.label})"
    figures, si = motion.summary, motion.summary.si
    if motion.label in ("rest", "departed") or figures.main_blow_rate is None:
        return f"{text}.", BAD if motion.label in ("rest", "departed") else PLAIN
    if si is not None and si.main_blow_rate_Hz is not None and si.blow_energy_J is not None:
        blows = "main blows/s" if _chatters(figures) else "Hz"
        speeds, energies = (
            each if each and len(each) <= _FEW else None for each in (si.cycle_velocities_m_s, si.cycle_energies_J)
        )
        speed = _values(si.impact_velocity_m_s or 0.0, speeds, lambda v: f"{number(v)} m/s")
        energy = _values(si.blow_energy_J, energies, lambda e: quantity(e, "J"))
        text += f": {energy} at {number(si.main_blow_rate_Hz)} {blows}, {speed}"
    elif figures.impact_velocity is not None:
        text += f": mean striking speed {number(figures.impact_velocity)}"
    settled = motion.label.startswith("z=")
    return f"{text}.", GOOD if settled else PLAIN


def label_in_words(motion: Trajectory) -> str:
    """What the label of a motion says."""
    name, _, numbers = motion.label.replace("z=", "z/", 1).partition("/")
    system = motion.system
    who, blow = ("The hammer", "blow") if system.body.is_free else ("The structure", "impact")
    if name == "z":
        p, n = (int(x) for x in numbers.split("/"))
        blows = f"one {blow}" if p == 1 else f"{p} {blow}s"
        return f"{who} settles on {blows} {_in_periods(n)}"
    if motion.period_unresolved:
        return f"{who} rests on the wall again and again from the same release on, but how soon depends on rounding"
    if name in ("chatter", "rest") and numbers:
        how = "chatters to rest on the wall" if name == "chatter" else "comes to rest on the wall"
        return (
            f"{who} settles on a cycle {_of_periods(int(numbers))}: it {how}, until {_what_pulls(system)} pulls it off"
        )
    if name == "rest" and not rests(system, motion.modes):
        return "The wall stops the contact, and the structure goes on in ways that are not simulated"
    if name == "rest":
        return f"{who} comes to rest on the wall and stays there"
    if name == "departed":
        return f"{'The bar' if system.body.is_free else who} leaves the wall for good"
    if name == "aperiodic":
        return f"{who} finds no rhythm: its last impacts do not return to any earlier state"
    return "No periodic motion has been found so far"


def _what_pulls(system: System) -> str:
    return "the load" if system.body.is_free else "the force of load and spring"


def _in_periods(n: int) -> str:
    return "every load period" if n == 1 else f"in {n} load periods"


def _of_periods(n: int) -> str:
    return "of one load period" if n == 1 else f"of {n} load periods"


def _chatters(figures: Summary) -> bool:
    """Whether the settled part has completed chatter, so that a mean over all impacts says little."""
    main, every = figures.main_blow_rate, figures.blow_rate
    return main is not None and every is not None and not math.isclose(main, every, rel_tol=1e-9)


# -- sections -------------------------------------------------------------------------------------------------------


def _motion_section(answer: SimulationAnswer) -> Section:
    motion, system = answer.motion, answer.system
    length = motion.end_time - motion.begin_time
    span = f"{number(length / _TURN, 6)} load periods"
    if system.is_si:
        span += f" = {Teller.of(system)(length, 'time')}"
    counts = [counted(motion.impacts, "impact")]
    mode = "elastic mode" if system.body.is_free else "mode"
    modes = counted(motion.modes, mode) if motion.modes else "no elastic modes"
    for kind, many in (("chatter", "chatters"), ("rest", "rests"), ("release", "releases"), ("grazing", "grazings")):
        size = len(motion.events.of(kind))
        if size:
            counts.append(f"{size} {kind if size == 1 else many}")
    rows = [
        ("start", _start(answer)),
        ("followed", f"{span}; {', '.join(counts)}; {modes}"),
        ("ended", f"{_OUTCOMES[motion.outcome]} ({motion.outcome})"),
        ("label", f"{motion.label}, {_tolerance(motion)}"),
    ]
    if answer.orbit is not None:
        rows.append(("orbit", orbit_in_words(answer.orbit)))
    rows += held_down_in_words(answer.motion.events.held_down)
    rows += [("warning", warning) for warning in answer.warnings]
    return Section("Motion", tuple(rows))


def _start(answer: SimulationAnswer) -> str:
    motion, system = answer.motion, answer.system
    y = float(motion.gap([motion.begin_time])[0])
    velocity = float(motion.bar_velocity(1.0, [motion.begin_time], "left")[0, 0])
    velocity = velocity if abs(velocity) > 1e-15 else 0.0  # the sum of the modes rounds
    tell, end = Teller.of(system), "striking end" if system.body.is_free else "contact"
    start = f"{end} at {tell(y, 'length')} with velocity {tell(velocity, 'speed')}"
    return f"load phase {number(motion.begin_time)} rad, {start}"


def _tolerance(motion: Trajectory) -> str:
    if motion.transient is not None:
        impacts = "impact" if motion.transient == 1 else "impacts"
        return (
            f"from impact {motion.transient + 1} on ({motion.transient} {impacts} before), to {motion.stop.tolerance:g}"
        )
    if motion.period_unresolved:
        return "released twice in the same state, but a change of 1e-12 in R changes the number of load periods between"
    if motion.label == "aperiodic":
        return "the last 64 impacts do not return to any of the 32 before each (within 1e-3)"
    return "proved" if motion.label in ("rest", "departed") else f"no return within {motion.stop.tolerance:g}"


def _figures_section(answer: SimulationAnswer) -> Section:
    figures = answer.summary
    if figures.impacts == 0:
        return Section("Figures", (("impacts", "none: the bar never strikes in the time simulated"),))
    shown = f"Figures (impacts {figures.first + 1} to {figures.last + 1})"
    return Section(shown, tuple(_figure_rows(answer, figures)))


def _figure_rows(answer: SimulationAnswer, figures: Summary) -> list[tuple[str, str]]:
    tell, si, rows = Teller.of(answer.system), figures.si, []
    if figures.blow_rate is not None:
        rows.append(("blow rate", _rates(answer.system, figures.blow_rate, figures.main_blow_rate)))
        rows.append(("interval", _interval(tell, figures)))
    if figures.impact_velocity is not None and figures.blow_energy is not None:
        which, share = _which(figures), ""
        speed = _values(figures.impact_velocity, figures.cycle_velocities, lambda v: tell(v, "speed", plain=6))
        blow = _values(figures.blow_energy, figures.cycle_energies, lambda e: tell(e, "energy", plain=6))
        if si is not None and si.delivered_energy_J is not None and si.blow_energy_J:
            share = f", of which the impact takes {number(100.0 * si.delivered_energy_J / si.blow_energy_J)} %"
        rows += [("striking speed", f"{speed}{which}"), ("blow", f"{blow}{which}{share}")]
    if figures.energy_lost_per_period is not None:
        each = f"by the impacts {tell(figures.energy_lost_per_period, 'energy', plain=6)} per load period"
        power = f", {tell(figures.energy_lost_per_period / _TURN, 'power')}" if tell.is_si else ""
        rows.append(("taken", each + power))
    return rows


def _values(mean: float, each: tuple[float, ...] | None, shown: Callable[[float], str]) -> str:
    """The values of a short cycle, or the mean; equal ones, as they are shown, once."""
    texts = list(dict.fromkeys(shown(value) for value in each)) if each else [shown(mean)]
    return texts[0] if len(texts) == 1 else f"{', '.join(texts[:-1])} and {texts[-1]}"


def _which(figures: Summary) -> str:
    """The words that say over which blows a speed or an energy is the mean."""
    blows = "main blows" if _chatters(figures) else "blows"
    if figures.cycle_velocities is None:
        return f" (mean of the {blows})"
    many = len(figures.cycle_velocities)
    return f" (the {blows} of one cycle)" if many > 1 else f" (the {blows[:-1]})" if _chatters(figures) else ""


def _rates(system: System, all_blows: float, main: float | None) -> str:
    scale, unit = (1.0, "per load period") if system.frequency is None else (system.frequency, "Hz")
    text = f"{number(all_blows * scale, 6)} {unit}"
    if main is None or math.isclose(main, all_blows, rel_tol=1e-9):
        return text
    return f"{text}, all impacts; {number(main * scale, 6)} {unit}, main blows (each chatter counted once)"


def _interval(tell: Teller, figures: Summary) -> str:
    mean, std = figures.interval_mean or 0.0, figures.interval_std or 0.0
    if std <= 1e-9 * mean:
        return f"{tell(mean, 'time', plain=6)}, the same every time to 1e-9"
    return f"{tell(mean, 'time', plain=6)} (mean), {tell(std, 'time', plain=6)} (standard deviation)"


# -- events ---------------------------------------------------------------------------------------------------------


def _events_grid(answer: SimulationAnswer, last: int | None) -> Grid:
    events, si = answer.motion.events, answer.system.is_si
    part = events if last is None else events[max(len(events) - last, 0) :]
    shown = f"all {len(events)}" if len(part) == len(events) else f"last {len(part)} of {len(events)}"
    time, speed, energy = ("time [s]", "before [m/s]", "lost [J]") if si else ("time [rad]", "before", "lost")
    columns = ("kind", time, "phase [rad]", speed, speed.replace("before", "after"), energy)
    return Grid(f"Events ({shown})", columns, tuple(_row(answer, event) for event in part))


def _row(answer: SimulationAnswer, event: Event) -> tuple[str, ...]:
    time, speed, energy = map(Teller.of(answer.system).scale, ("time", "speed", "energy"))
    kind = f"chatter after {event.resolved}" if event.kind == "chatter" else event.kind
    return (
        kind,
        f"{event.time * time:.6f}",
        f"{event.phase:.6f}",
        f"{event.impact_velocity * speed:.5g}",
        f"{event.rebound_velocity * speed:.5g}",
        f"{event.energy_lost * energy:.4g}",
    )


# ---- A motion by waves as the report that a person reads, beside that of the contact law

_FEW_WAVES = 4  # impacts of a cycle that are told one by one


def waves_report(answer: WavesAnswer, last: int | None) -> Report:
    """The report of `percuss simulate --contact waves` with the `last` impacts; None shows all of them."""
    sections: list[Section | Grid] = [
        system_section(answer.name, answer.system, answer.notes),
        _waves_section(answer),
        _laws_grid(answer),
    ]
    if last != 0 and answer.motion.impacts.size:
        sections.append(_impacts_grid(answer.motion, last))
    text, tone = _waves_summary(answer)
    return Report(answer.title, text, tone, tuple(sections))


def _waves_summary(answer: WavesAnswer) -> tuple[str, str]:
    motion = answer.motion
    if motion.label == "rest":
        return "By waves the hammer comes to rest on what it strikes (rest).", BAD
    if motion.label == "none":
        return "By waves the hammer strikes nothing (none).", BAD
    if motion.cycle is None:
        return "By waves no periodic motion has been found (irregular).", PLAIN
    p, n = motion.cycle.impacts, motion.cycle.periods
    blows = "one blow" if p == 1 else f"{p} blows"
    periods = "every load period" if n == 1 else f"in {n} load periods"
    text = f"By waves the hammer settles on {blows} {periods} ({motion.label})"
    first = answer.beside[0]
    return f"{text}; by the law {first.law}: {first.label}.", GOOD


def _waves_section(answer: WavesAnswer) -> Section:
    motion, own = answer.motion, answer.motion.settled
    length = motion.end_time - motion.start.time
    rows = [
        ("followed", f"{number(length / _TURN, 6)} load periods; {counted(motion.impacts.size, 'impact')}"),
        ("ended", f"{_OUTCOMES[motion.outcome]} ({motion.outcome})"),
        ("struck", _struck(motion)),
    ]
    if own.size:
        which = "" if own.size <= _FEW_WAVES else f" (the first {_FEW_WAVES} of {own.size})"
        rows.append(("phase", f"{_each(own.phase[:_FEW_WAVES], 5)} rad at the centroid of the force{which}"))
        rows.append(("speed", f"{_speeds(motion)}, of the rigid motion there"))
        rows.append(("restitution", f"{_each(own.restitution[:_FEW_WAVES], 4)}, as these impacts have it"))
        rows.append(("contact", _contact(motion)))
        rows.append(("ringing", f"{percent(float(own.ringing_share.max()))} of the energy before the impact, at most"))
        rows.append(("blow rate", _rate(motion)))
    if answer.system.is_si:
        rows.append(("given", _given(motion)))
    rows.append(("lattice", _lattice(motion)))
    rows += [("warning", warning) for warning in answer.warnings]
    return Section("Motion by waves", tuple(rows))


def _struck(motion: WaveMotion) -> str:
    from percuss.blow import Wall

    if isinstance(motion.target, Wall):
        return "a rigid wall"
    end = motion.target.end
    stays = "is fed by what each blow leaves of the penetration" if end == "rock" else "stays where a blow has put it"
    how = "is pushed back after each blow" if motion.pushed_back else stays
    ringing = "; all ringing is made to end between blows" if motion.quiet else ""
    return f"{_RODS[end]}, which {how}{ringing}"


_RODS = {
    "infinite": "a rod with an endless end",
    "fixed": "a rod with a fixed end",
    "free": "a rod with a free end",
    "rock": "a rod on rock",
}


def _given(motion: WaveMotion) -> str:
    system, own = motion.system, motion.settled
    text = f"{quantity(motion.delivered_power * system.power_scale, 'W')} to what is struck"
    if motion.rock_power:
        text += f"; the rock keeps {quantity(motion.rock_power * system.power_scale, 'W')} of it"
    deepest = float(own.fed.max()) if own.size else 0.0
    return f"{text}; fed by {quantity(deepest * system.length_scale, 'm', 3)} after a blow" if deepest else text


def _contact(motion: WaveMotion) -> str:
    own, system = motion.settled, motion.system
    longest = float(own.duration.max())
    time = quantity(longest * system.time_scale, "s", 3) if system.is_si else f"{number(longest)} rad"
    transits = number(longest / system.body.transit_time, 3)
    many = f"; up to {counted(int(own.contacts.max()), 'contact')} an impact" if own.contacts.max() > 1 else ""
    return f"{time} at most, {transits} transit times of the bar{many}"


def _rate(motion: WaveMotion) -> str:
    system = motion.system
    if system.frequency is not None:
        return f"{number(motion.blow_rate * system.frequency, 6)} Hz"
    return f"{number(motion.blow_rate, 6)} per load period"


def _lattice(motion: WaveMotion) -> str:
    lattice, unsure = motion.lattice, motion.uncertainty
    text = (
        f"{sum(lattice.cells[: lattice.striker])} cells, transit times rounded by {lattice.rounding:.1g} of the bar's"
    )
    if unsure is not None and unsure.phase is not None and unsure.velocity is not None:
        text += f"; with half the cells phases differ by {unsure.phase:.1g} rad, speeds by {unsure.velocity:.1g}"
    return text


def _speeds(motion: WaveMotion) -> str:
    velocities, system = motion.velocities[:_FEW_WAVES], motion.system
    return f"{_each(velocities * system.speed_scale)} m/s" if system.is_si else _each(velocities, 6)


def _each(values: object, digits: int = 4) -> str:
    """Values one after another; equal ones, as they are shown, once."""
    texts = list(dict.fromkeys(number(float(value), digits) for value in values))  # type: ignore[attr-defined]
    return ", ".join(texts)


# -- beside the laws ------------------------------------------------------------------------------------------------


def _laws_grid(answer: WavesAnswer) -> Grid:
    motion = answer.motion
    own = (
        "waves",
        motion.label,
        _each(motion.phases[:_FEW_WAVES], 5),
        _scaled_speeds(motion, motion.velocities[:_FEW_WAVES]),
        number(motion.blow_rate, 5),
        "",
        "",
    )
    unit = " [m/s]" if motion.system.is_si else ""
    columns = ("", "settles on", "phase [rad]", f"speed{unit}", "blows per period", "phase less", "speed less")
    return Grid("Beside the laws", columns, (own, *(_law_row(motion, one) for one in answer.beside)))


def _law_row(motion: WaveMotion, one: Beside) -> tuple[str, ...]:
    return (
        one.law,
        one.label or "",
        _each(one.phases[:_FEW_WAVES], 5),
        _scaled_speeds(motion, one.velocities[:_FEW_WAVES]),
        "" if one.blow_rate is None else number(one.blow_rate, 5),
        "" if one.phase_difference is None else f"{one.phase_difference:+.2g}",
        "" if one.velocity_difference is None else f"{100.0 * one.velocity_difference:+.2g} %",
    )


def _scaled_speeds(motion: WaveMotion, velocities: object) -> str:
    scale = Teller.of(motion.system).scale("speed")
    return _each([float(v) * scale for v in velocities], 4)  # type: ignore[attr-defined]


# -- impacts --------------------------------------------------------------------------------------------------------


def _impacts_grid(motion: WaveMotion, last: int | None) -> Grid:
    every, system = motion.impacts, motion.system
    part = every if last is None else every.part(slice(max(every.size - last, 0), every.size))
    shown = f"all {every.size}" if part.size == every.size else f"last {part.size} of {every.size}"
    time, speed = ("start [s]", "speed [m/s]") if system.is_si else ("start [rad]", "speed")
    columns = (time, "phase [rad]", "contacts", speed, "restitution", "ringing")
    return Grid(f"Impacts ({shown})", columns, tuple(_waves_row(motion, part, i) for i in range(part.size)))


def _waves_row(motion: WaveMotion, part: Impacts, i: int) -> tuple[str, ...]:
    time, speed = map(Teller.of(motion.system).scale, ("time", "speed"))
    return (
        f"{part.start[i] * time:.6f}",
        f"{part.phase[i]:.6f}",
        str(int(part.contacts[i])),
        f"{part.velocity[i] * speed:.5g}",
        f"{part.restitution[i]:.4f}",
        percent(float(part.ringing_share[i])),
    )
