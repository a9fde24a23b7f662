"""The dispatcher's answer to "how does this hammer move from this start?"."""

from __future__ import annotations

import json
import math
import os
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

from percuss.case.answers.facts import (
    BAD,
    GOOD,
    PLAIN,
    Fact,
    Grid,
    Report,
    ReportSection,
    Teller,
    counted,
    flat_of,
    grid_of,
    json_number,
    number,
    numbers,
    picked,
    plain,
    rhythm,
)
from percuss.case.answers.heading import (
    clock_in_short,
    figures_in_short,
    heading_dict,
    machine_section,
    supply_pressure,
    system_section,
)
from percuss.case.case import checked_case
from percuss.errors import ParameterError
from percuss.model.checks import Array, callback, count, positive
from percuss.short_repr import ShortRepr
from percuss.simulate import Stop, Trajectory
from percuss.units import si

if TYPE_CHECKING:
    from percuss.case.case import Case
    from percuss.model import Machine, System
    from percuss.simulate import Event, Progress, Summary
    from percuss.steady import PeriodicOrbit


def held_down_sentences(shares: Array) -> tuple[tuple[str, str], ...]:
    """A row of a report: that the load held a bar on the wall before the time of a contact was over; none if never."""
    if not shares.size:
        return ()
    most = float(shares.max())
    text = (
        f"at {counted(int(shares.size), 'rest')} the load turned the rebound within the time of one contact, and held "
        f"the bar on the wall; that gave up {100.0 * most:.2g} % of the energy of the greatest blow, at most"
    )
    return (("held down", text + (": for so soft a bar the law is coarse" if most > _COARSE else "")),)


_COARSE = 0.01


# ---- A motion that is told event by event, or impact by impact


class MotionReport(ShortRepr, ABC):
    """A motion that is told event by event, or impact by impact."""

    ROWS: ClassVar[str] = "events"  # the key of the list

    @abstractmethod
    def to_json_dict(self, last: int | None = None) -> dict[str, Any]:
        """The answer in plain values, as `percuss simulate --json` prints it; with so many last events, or all."""

    def to_json_text(self, last: int | None = None) -> str:
        """The same as text, one line for each event or impact."""
        tree = self.to_json_dict(last)
        rows = [json.dumps(row, allow_nan=False) for row in tree[self.ROWS]]
        text = json.dumps({**tree, self.ROWS: []}, indent=1, allow_nan=False)
        if not rows:
            return text
        key = f'\n "{self.ROWS}": ['  # keys of objects within stand further in, and no text has a line break
        return text.replace(key + "]", key + "\n  " + ",\n  ".join(rows) + "\n ]")


def last_of(size: int, last: int | None) -> slice:
    """Where so many last of them are, or all of them."""
    return slice(0 if last is None else max(size - count("last", last, least=0), 0), size)


def told_of(what: str, size: int, part: slice) -> str:
    """The heading of a table of the last of them."""
    return f"{what} ({f'last {size - part.start}' if part.start else 'all'}{' of' * bool(part.start)} {size})"


@dataclass(frozen=True)
class SimulationAnswer(MotionReport):
    """A simulated motion of a case, of a hammer under a clock or of a machine that switches its own valve.

    Attributes
    ----------
    name, title, notes
        The case as it was named, its title, and what was assumed, one sentence each.
    motion
        The motion: events, summary, fields.
    """

    name: str
    title: str
    motion: Trajectory
    notes: tuple[str, ...] = ()

    @property
    def system(self) -> System:
        """The system that moved."""
        return self.motion.system

    @property
    def machine(self) -> Machine:
        """The machine that moved, where it switches its own valve."""
        return self.motion.machine

    @property
    def summary(self) -> Summary:
        """Means over the settled part of the motion of a system."""
        return self.motion.summary

    @cached_property
    def orbit(self) -> PeriodicOrbit | None:
        """The periodic orbit that the motion of a system has settled on, see `percuss.explore.orbit_of`; or None."""
        from percuss.explore import orbit_of  # loads the compiler

        return orbit_of(self.motion)

    @property
    def warnings(self) -> tuple[str, ...]:
        """What a reader of the figures of a system's motion should know, one sentence each."""
        return tuple(_warnings(self.motion))

    def to_json_dict(self, last: int | None = None) -> dict[str, Any]:
        """The answer in plain values; see `MotionReport`."""
        motion, held = self.motion, self.motion.events.held_down
        tell, part = Teller.of(motion.hammer), motion.events[last_of(len(motion.events), last)]
        both = {
            **picked(motion, "outcome label modes begin_time end_time"),
            "held_down": {"rests": int(held.size), "greatest_share": json_number(held.max())} if held.size else None,
            "events": [flat_of(event, EVENT if motion.is_clocked else MACHINE_EVENT, tell) for event in part],
        }
        if not motion.is_clocked:
            cycle = None if motion.cycle is None else plain(asdict(motion.cycle))
            if cycle is not None:  # with the words of machines
                cycle |= {"blows": cycle.pop("impacts"), "valve_cycles": cycle.pop("periods")}
            about = {"case": self.name, "title": self.title, "notes": list(self.notes)}
            return {**about, **both, "cycle": cycle, "pressure": _pressure(motion)}
        from percuss.case.answers.exploring.orbits_answer import orbit_dict  # which loads what follows branches

        found = self.orbit
        return {
            **heading_dict(self.name, self.title, self.system, self.notes),
            **both,
            **picked(motion, "transient period_unresolved"),
            "warnings": list(self.warnings),
            "summary": plain(asdict(motion.summary)),
            "orbit": None if found is None else orbit_dict(found, found.multipliers().values),
        }


_BOTH: tuple[Fact[Event], ...] = (
    Fact("rebound_velocity", "after", "speed of the striking end after the event, away from the wall", "speed",
         "rebound_velocity"),
    Fact("energy_lost", "lost", "energy that the event takes from the bar", "energy", "energy_lost"),
    Fact("resolved", "", "for a chatter, the number of its impacts that are listed one by one before it, starting with "
         "the main blow; 0 otherwise", "", "resolved"),
)  # fmt: skip
EVENT: tuple[Fact[Event], ...] = (
    Fact("kind", "event", '`"impact"`, `"grazing"`, `"chatter"`, `"rest"` or `"release"`', "", "kind",
         lambda one, _: f"chatter after {one.resolved}" if one.kind == "chatter" else one.kind),
    Fact("time time_s", "time", "$2\\pi$ times the number of completed load periods, plus `phase`; in seconds null for "
         "a dimensionless case", "time", "time"),
    Fact("phase", "phase [rad]", "load phase, in $[0, 2\\pi)$", "", "phase"),
    Fact("impact_velocity", "before", "$u_t(1)$ of the striking end before", "speed", "impact_velocity"),
    *_BOTH,
)  # fmt: skip
"""What is told of an event under a clock."""

MACHINE_EVENT: tuple[Fact[Event], ...] = (
    Fact("kind", "event", 'also `"port"`, which demands a state, and `"valve"`, where the state changes', "", "kind",
         lambda e, _: {"port": f"ports[{e.port}] demands", "valve": f"valve: {e.state}"}.get(e.kind, e.kind)),
    Fact("time time_s", "time", "from the start; in seconds null for a dimensionless case", "time", "time"),
    Fact("speed", "speed toward the wall", "toward the wall, at a port of what it reads", "speed", "impact_velocity"),
    Fact("kinetic_energy", "", "of an impact: that of the bar before it", "energy", "kinetic_energy"),
    Fact("port", "", "which port demands a state", "", "port"),
    Fact("to", "", "the state of the valve after the event", "", "state"),
    *_BOTH,
)  # fmt: skip
"""What is told of an event of a machine that switches its own valve."""


def _pressure(motion: Trajectory) -> dict[str, Any] | None:
    """Of a supply, in Pa, or as a multiple of that of the states where it is not known."""
    if motion.machine.valve.supply is None:
        return None
    unit = motion.machine.pressure or 1.0
    return {
        "at_start": json_number(float(motion.pressure([motion.begin_time])[0]) * unit),
        "after_blows": numbers(motion.pressure(motion.blow_times) * unit),
        "at_end": json_number(float(motion.pressure(motion.end_time)[0]) * unit),
    }


def simulation_answer(case: Case, progress: Callable[[Progress], object] | None = None) -> SimulationAnswer:
    """The motion that the tables [start] and [simulation] of a case describe; see `Case.changed` for others.

    Parameters
    ----------
    progress
        Called now and then; the motion ends as ``interrupted`` when it returns something true.

    Raises
    ------
    CaseError
        When the start does not fit the case, or its recording cannot be used.
    ResonanceError
        When an undamped bar is driven at one of its own frequencies.

    Examples
    --------
    >>> from percuss.case import load_case
    >>> for name in ("dth-4-inch", "valve-drifter"):
    ...     answer = simulation_answer(load_case(name).changed(simulation={"modes": 0}))
    ...     print(answer.motion.label, answer.motion.outcome)
    z=1/1 periodic
    runs 1/1 periodic
    """
    from percuss.simulate import run  # loads the compiler

    checked_case(case)
    callback("progress", progress)
    hammer, simulation = case.hammer, case.simulation()
    start = case.start(simulation.modes)
    motion = run(hammer, start, modes=simulation.modes, stop=simulation.stop, progress=progress)
    return SimulationAnswer(case.file, case.title, motion, case.notes)


def resumed_answer(
    path: str | os.PathLike[str],
    impacts: int | None = None,
    time: float | str | None = None,
    progress: Callable[[Progress], object] | None = None,
) -> SimulationAnswer:
    """The motion of a file that `save` of a trajectory wrote, followed further with the same bits.

    Parameters
    ----------
    impacts, time
        When to end, both counted from the start of the motion; time in radians (of a machine: its unit), or text
        with a unit where the file has scales. None for both: as many impacts again. A periodic motion that is found
        does not end it.

    Raises
    ------
    PercussError
        When the file cannot be read or holds no trajectory.
    ParameterError
        When the motion in the file already goes as far.
    """
    callback("progress", progress)
    motion = Trajectory.load(path)
    if impacts is None and time is None:
        stop = None
    else:
        if time is not None:
            time = _plain(motion, time) if isinstance(time, str) else positive("time", time)
        if impacts is not None:
            impacts = count("impacts", impacts)
        gone = motion.end_time - motion.begin_time
        if impacts is not None and impacts <= motion.impacts:
            raise ParameterError("impacts", impacts, f"more than the {motion.impacts} that the file holds")
        if time is not None and time <= gone:
            raise ParameterError("time", time, f"more than the {gone:.6g} that the file holds")
        tolerance = motion.stop.tolerance
        stop = replace(Stop(impacts=impacts, time=time), periodic=False, tolerance=tolerance)
    return SimulationAnswer(os.fspath(path), Path(path).stem, motion.continued(stop, progress))


def _plain(motion: Trajectory, text: str) -> float:
    moved = motion.hammer
    if not moved.is_si:
        raise ParameterError("time", text, "a plain number: the file has no scales")
    return si(text, "time", "time") / moved.time_scale


def _warnings(motion: Trajectory) -> list[str]:
    found = []
    touches = len(motion.events.of("grazing"))
    if touches:
        some = "one touch" if touches == 1 else f"{touches} touches"
        found.append(f"{some} so slight that rounding hides whether the bar strikes or misses; it goes on unchanged")
    if motion.outcome == "work":
        found.append("ended early: one flight hovers before the wall for longer than can be followed")
    if motion.outcome == "memory":
        found.append("ended early: the record has reached 1 GB; continue a saved motion, or use fewer modes")
    if motion.outcome == "interrupted":
        found.append("ended early: interrupted; the figures are those of the part that was computed")
    if motion.label == "undecided" and motion.outcome in ("impacts", "time"):
        found.append("no periodic motion found yet, and too few impacts to call it aperiodic: simulate for longer")
    if motion.outcome == "departed":
        found.append("the bar has left the wall for good: the load does not push it back")
    return found


_TURN = 2.0 * math.pi
_FEW = 3  # blows of a cycle that the headline tells one by one

ENDINGS = {
    "impacts": "the number of impacts is reached",
    "time": "the time is reached",
    "rest": "the bar lies on the wall for good",
    "periodic": "a periodic motion is found",
    "departed": "the bar has left the wall for good",
    "work": "one flight takes too much work",
    "memory": "the record has reached 1 GB",
    "interrupted": "interrupted",
    "unresolved": "released twice in the same state, but the period hangs on rounding",
}


def motion_report(answer: SimulationAnswer, last: int | None) -> Report:
    """The report of `percuss simulate` with the `last` events; None shows all of them."""
    motion = answer.motion
    if not motion.is_clocked:
        return _machine_report(answer, last)
    sections: list[ReportSection | Grid] = [
        system_section(answer.name, answer.system, answer.notes),
        _motion_section(answer),
        _figures_section(answer),
    ]
    if last != 0 and len(motion.events):
        part = last_of(len(motion.events), last)
        heading = told_of("Events", len(motion.events), part)
        sections.append(grid_of(heading, motion.events[part], EVENT, Teller.of(motion.system)))
    summary, tone = _summary(answer)
    clock = clock_in_short(answer.system.load)
    return Report(answer.title, f"{summary} {clock}".rstrip(), tone, tuple(sections))


# -- in words -------------------------------------------------------------------------------------------------------


def _summary(answer: SimulationAnswer) -> tuple[str, str]:
    motion = answer.motion
    text = f"{label_sentence(motion)} ({motion.label})"
    figures, tell, system = motion.summary, Teller.of(motion.system), motion.system
    if motion.label in ("rest", "departed") or figures.main_blow_rate is None:
        return f"{text}.", BAD if motion.label in ("rest", "departed") else PLAIN
    if tell.is_si and system.frequency is not None and figures.blow_energy is not None:
        blows = "main blows/s" if _chatters(figures) else "Hz"
        speeds, energies = (
            each if each and len(each) <= _FEW else None for each in (figures.cycle_velocities, figures.cycle_energies)
        )
        speed = _values(figures.impact_velocity or 0.0, speeds, lambda v: tell(v, "speed"))
        energy = _values(figures.blow_energy, energies, lambda e: tell(e, "energy"))
        text += f": {energy} at {number(figures.main_blow_rate * system.frequency)} {blows}, {speed}"
    elif figures.impact_velocity is not None:
        text += f": mean striking speed {number(figures.impact_velocity)}"
    settled = motion.label.startswith("z=")
    return f"{text}.", GOOD if settled else PLAIN


def label_sentence(motion: Trajectory) -> str:
    name, _, numbers = motion.label.replace("z=", "z/", 1).partition("/")
    system = motion.system
    who, blow = ("The hammer", "blow") if system.body.is_free else ("The structure", "impact")
    if name == "z":
        return f"{who} settles on {rhythm(motion.label, blow)}"
    if motion.period_unresolved:
        return f"{who} rests on the wall again and again from the same release on, but how soon depends on rounding"
    if name in ("chatter", "rest") and numbers:
        how = "chatters to rest on the wall" if name == "chatter" else "comes to rest on the wall"
        pull = "the load" if system.body.is_free else "the force of load and spring"
        periods = "one load period" if numbers == "1" else f"{numbers} load periods"
        return f"{who} settles on a cycle of {periods}: it {how}, until {pull} pulls it off"
    if name == "rest":
        return f"{who} comes to rest on the wall and stays there"
    if name == "departed":
        return f"{'The bar' if system.body.is_free else who} leaves the wall for good"
    if name == "aperiodic":
        return f"{who} finds no rhythm: its last impacts do not return to any earlier state"
    return "No periodic motion has been found so far"


def _chatters(figures: Summary) -> bool:
    """Whether the settled part has completed chatter, so that a mean over all impacts says little."""
    main, every = figures.main_blow_rate, figures.blow_rate
    return main is not None and every is not None and not math.isclose(main, every, rel_tol=1e-9)


# -- sections -------------------------------------------------------------------------------------------------------


def _motion_section(answer: SimulationAnswer) -> ReportSection:
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
        ("ended", f"{ENDINGS[motion.outcome]} ({motion.outcome})"),
        ("label", f"{motion.label}, {_tolerance(motion)}"),
    ]
    if answer.orbit is not None:
        rows.append(("orbit", orbit_sentence(answer.orbit)))
    rows += held_down_sentences(answer.motion.events.held_down)
    rows += [("warning", warning) for warning in answer.warnings]
    return ReportSection("Motion", tuple(rows))


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


def _figures_section(answer: SimulationAnswer) -> ReportSection:
    figures = answer.summary
    if figures.impacts == 0:
        return ReportSection("Figures", (("impacts", "none: the bar never strikes in the time simulated"),))
    shown = f"Figures (impacts {figures.first + 1} to {figures.last + 1})"
    return ReportSection(shown, tuple(_figure_rows(answer, figures)))


def _figure_rows(answer: SimulationAnswer, figures: Summary) -> list[tuple[str, str]]:
    tell, si, rows = Teller.of(answer.system), figures.si, []
    if figures.blow_rate is not None:
        rows.append(("blow rate", rates(answer.system, figures.blow_rate, figures.main_blow_rate)))
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


def rates(system: System, all_blows: float, main: float | None = None) -> str:
    """How often it strikes, in Hz where there are seconds; all impacts, and main blows where these are fewer."""
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


# ---- The orbit that a simulated motion has settled on, in a line


def orbit_sentence(orbit: PeriodicOrbit) -> str:
    """Its label, its largest multiplier, and what that means."""
    found = orbit.multipliers()
    text = f"{orbit.label}, largest multiplier {number(found.largest)}"
    if not found.stable:
        return text
    if found.largest < 0.1:
        return f"{text}: disturbances die out within a cycle"
    cycles = math.ceil(math.log(0.1) / math.log(found.largest))
    return f"{text}: a disturbance dies out to a tenth in {cycles} cycle{'s' if cycles > 1 else ''}"


# ---- The first sentence of the answer for a machine that switches itself from a start: one home for terminal and page


def from_this_start(answer: SimulationAnswer) -> str:
    """How the motion ends, in one sentence."""
    motion, machine, cycle = answer.motion, answer.machine, answer.motion.cycle
    text = f"From this start the machine {_sentence(motion.label)}"
    if cycle is None or not motion.impacts:
        return f"{text}."
    energy = float(motion.blow_energies[-max(cycle.impacts, 1) :].max())
    told = figures_in_short(machine, energy, cycle.blow_speed, cycle.impacts, cycle.period)
    return f"{text}: {told}, after {counted(cycle.first, 'impact')}."


def _sentence(label: str) -> str:
    """The label behind "the machine"."""
    if label.startswith(("runs", "stalls", "cycles")):
        return label
    return {"undecided": "has not settled yet", "irregular": "strikes irregularly"}.get(label, f"ends as '{label}'")


# ---- A simulated motion of a machine that switches its own valve, as the report that a person reads


def _machine_report(answer: SimulationAnswer, last: int | None) -> Report:
    motion, machine, tell = answer.motion, answer.machine, Teller.of(answer.machine)
    sections: list[ReportSection | Grid] = [machine_section(answer.name, machine, answer.notes, math.inf)]
    rows = [
        ("ended", f"{motion.outcome}, after {counted(motion.impacts, 'impact')} and {tell(motion.end_time, 'time')}"),
        ("modes", counted(motion.modes, "elastic mode") if motion.modes else "rigid piston"),
    ]
    if motion.machine.valve.supply is not None:
        rows.append(("pressure", _pressures(motion)))
    if motion.cycle is not None:
        rows.append(("period", tell(motion.cycle.period, "time")))
    rows += held_down_sentences(motion.events.held_down)
    sections.append(ReportSection("Motion", tuple(rows)))
    if last != 0 and len(motion.events):
        part = last_of(len(motion.events), last)
        sections.append(grid_of(told_of("Events", len(motion.events), part), motion.events[part], MACHINE_EVENT, tell))
    tone = GOOD if motion.label.startswith("runs") else PLAIN if motion.label == "undecided" else BAD
    return Report(answer.title, from_this_start(answer), tone, tuple(sections))


def _pressures(motion: Trajectory) -> str:
    """The pressure of a supply at the start, and after the last blow."""
    last = motion.blow_times[-1:] if motion.impacts else motion.end_time
    values = (float(motion.pressure(time)[0]) for time in ([motion.begin_time], last))
    first, then = (supply_pressure(motion.machine, value) for value in values)
    return f"{first} at the start, {then} {'at the last blow' if motion.impacts else 'at the end'}"
