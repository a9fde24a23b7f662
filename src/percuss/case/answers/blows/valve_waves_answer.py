"""The answer to "how does this machine with a valve move when every blow is resolved by waves?"."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from percuss.case.answers.blows.drilling_answer import taken_singly, warned
from percuss.case.answers.facts import (
    GOOD,
    PLAIN,
    Fact,
    Grid,
    Report,
    ReportSection,
    Teller,
    counted,
    number,
    percent,
    plain,
    plain_of,
    quantity,
    rows_of,
)
from percuss.case.answers.simulation_answer import last_of
from percuss.case.case import checked_case
from percuss.errors import CaseError, ParameterError
from percuss.model.checks import callback, count
from percuss.short_repr import ShortRepr

if TYPE_CHECKING:
    from percuss.blow import Drilling
    from percuss.blow.periods import ValveWaves
    from percuss.case.case import Case
    from percuss.simulate import Progress
    from percuss.steady.self_excited.valve_cycle import ValveCycle

_RHYTHM = 0.1  # scatter within which blows are alike
_BLOWS = 200  # followed where the case does not say how many


@dataclass(frozen=True)
class ValveWavesAnswer(ShortRepr):
    """A machine that switches its own valve, by waves and beside the cycle of its contact law.

    Attributes
    ----------
    name, title
        The case as it was named, and its title.
    motion
        The motion by waves.
    law
        The cycle by the law of the contact; None where it has none of one blow.
    drilling
        What blows are worth in advance; None without a table [drilling].
    """

    name: str
    title: str
    motion: ValveWaves
    law: ValveCycle | None
    drilling: Drilling | None = None

    @property
    def rate_of_penetration(self) -> float | None:
        """Of the hole, in m/s; None without a table [drilling], and without blows."""
        if self.drilling is None or not self.motion.main.size:
            return None
        units = self.motion.units
        fed, kept = self._mean("fed") * units.length, self._mean("rock_work") * units.energy
        return self.motion.rate * self.drilling.advance(fed, kept)

    @property
    def law_rate(self) -> float | None:
        """Blows per second of the law."""
        return None if self.law is None else 1.0 / (self.law.period * self.motion.machine.time_scale)

    @property
    def law_speed(self) -> float | None:
        """Striking speed of the law, m/s."""
        return None if self.law is None else float(np.max(self.law.speeds)) * self.motion.machine.speed_scale

    def _mean(self, name: str) -> float:
        """The mean of a number of a blow over the later half, in the units of the lattice."""
        own = getattr(self.motion.main, name)
        return float(np.mean(own)) if own.size else float("nan")

    @property
    def warnings(self) -> tuple[str, ...]:
        """What a reader of the figures should know, one sentence each."""
        motion, found = self.motion, []
        if motion.target.feed is None:
            found.append(
                "no feed: after each blow the tool is laid against the rock; describe what presses it in [feed]"
            )
        if motion.label == "irregular":
            near = "a rhythm that scatters" if motion.scatter <= _RHYTHM else "no periodic motion: blows scatter"
            found.append(f"{near} by {percent(motion.scatter)} over the later half")
        found += warned(motion.stands, motion.left_bound)
        return tuple(found)

    def to_json_dict(self, last: int | None = None) -> dict[str, Any]:
        """The answer in plain values, in SI, with the last blows of the later half."""
        main, units = self.motion.main, self.motion.units
        shown = last_of(main.size, last)
        blows = [
            {"start": start / units.rate, "speed": speed, "restitution": back, "impulse": j * units.force / units.rate,
             "rock_work": work * units.energy, "fed": fed * units.length, "energy_left": left * units.energy,
             "stands": bool(stands)}
            for start, speed, back, j, work, fed, left, stands in zip(
                main.start[shown], self.motion.velocities[shown], self.motion.restitutions[shown],
                main.impulse[shown], main.rock_work[shown], main.fed[shown], main.energy_left[shown],
                main.stands[shown], strict=True)
        ]  # fmt: skip
        head = {"case": self.name, "title": self.title, "units": "SI", "warnings": list(self.warnings)}
        return plain({**head, **plain_of(self, VALVE_WAVES), "blows": blows})

    def to_json_text(self, last: int | None = None) -> str:
        """The same as text."""
        import json

        return json.dumps(self.to_json_dict(last), indent=1, allow_nan=False)


VALVE_WAVES: tuple[Fact[ValveWavesAnswer], ...] = (
    Fact("label", "settles on", '`"one blow in a cycle"` where blows scatter by less than 0.1 %, else `"irregular"` '
         'or `"none"`', "", "motion.label", lambda one, _: one.motion.label),
    Fact("outcome", "", '`"impacts"`, `"time"`, `"stalls"` or `"interrupted"`: why it was followed no further', "",
         "motion.outcome"),
    Fact("impacts", "followed", "all that have ended", "", "motion.impacts.size",
         lambda one, tell: f"{counted(one.motion.impacts.size, 'impact')} in {tell(one.motion.time, 'time')}; the "
         "figures below are of the later half"),
    Fact("end_time", "", "when it was left, s", "", "motion.time"),
    Fact("rate", "blow rate", "blows per second", "", "motion.rate",
         lambda one, _: _beside(f"{number(one.motion.rate)} Hz", one.law_rate, "Hz")),
    Fact("scatter", "scatter", "(max − min)/mean of impulses, or of the times between blows", "", "motion.scatter",
         lambda one, _: percent(one.motion.scatter)),
    Fact("speed", "speed", "of the striker as a blow begins, mean, m/s", "",
         lambda one: float(np.mean(one.motion.velocities)) if one.motion.main.size else None,
         lambda one, _: _beside(f"{number(float(np.mean(one.motion.velocities)))} m/s", one.law_speed, "m/s")
         if one.motion.main.size else None),
    Fact("restitution", "restitution", "−V_1/V_0, mean", "",
         lambda one: float(np.mean(one.motion.restitutions)) if one.motion.main.size else None,
         lambda one, _: _beside(f"{number(float(np.mean(one.motion.restitutions)), 3)}",
                                one.motion.machine.contact.restitution, "") if one.motion.main.size else None),
    Fact("law_rate", "", "blows per second of the cycle by the law of the contact; null without", "", "law_rate"),
    Fact("law_speed", "", "its striking speed", "", "law_speed"),
    Fact("law_restitution", "", "restitution of the law", "", "motion.machine.contact.restitution"),
    Fact("energy_taken", "", "from the supply, all over the time followed, J", "", "motion.taken"),
    Fact("rock_power", "into the rock", "what the rock keeps, W", "",
         lambda one: one._mean("rock_work") * one.motion.units.energy * one.motion.rate,
         lambda one, _: f"{quantity(one._mean('rock_work') * one.motion.units.energy, 'J')} of a blow, "
         f"{quantity(one._mean('rock_work') * one.motion.units.energy * one.motion.rate, 'W')}"),
    Fact("fed", "fed", "by which the tool advances in a blow, m", "length",
         lambda one: one._mean("fed") * one.motion.units.length),
    Fact("rate_of_penetration", "rate of penetration", "of the hole, m/s; null without `[drilling]`", "speed",
         "rate_of_penetration",
         lambda one, _: None if one.rate_of_penetration is None else
         f"{number(60.0 * one.rate_of_penetration)} m/min"),
    Fact("stands", "bit", "whether it is on the rock at every blow; null without a feed", "", "motion.stands",
         lambda one, _: None if one.motion.stands is None else
         "on the rock at every blow" if one.motion.stands else "off the rock at a blow"),
    Fact("left_bound", "one by one", r"$\sqrt{E_{left}/W_{load}}$, by which waves left in the tool may change a "
         "penetration at most; null without a feed", "", "motion.left_bound",
         lambda one, _: None if one.motion.left_bound is None else
         taken_singly(one.motion.left_bound)),
    Fact("cells", "lattice", "of each section of striker and tool", "", "motion.lattice.cells",
         lambda one, _: f"{one.motion.lattice.cells[0]} cells in the striker's first section"),
)  # fmt: skip
"""What a machine with a valve does by waves."""


def _beside(text: str, law: float | None, unit: str) -> str:
    return text if law is None else f"{text}; by the law of the contact {number(law)} {unit}".rstrip()


def valve_waves_answer(
    case: Case, progress: Callable[[Progress], object] | None = None, *, cells: int = 200
) -> ValveWavesAnswer:
    """The motion of a machine that switches its own valve from its start, every contact by waves, beside its cycle.

    Parameters
    ----------
    progress
        Called now and then; the motion ends as interrupted when it returns something true.
    cells
        Of the striker, at least.

    Raises
    ------
    CaseError
        For a case without a tool in SI, or with ports that read a place on the bar.
    """
    from percuss.blow import Rod
    from percuss.blow.periods import run_valve_by_waves
    from percuss.case.file_format.contact import drilling_of
    from percuss.steady import self_excited_motion

    checked_case(case)
    callback("progress", progress)
    count("cells", cells)
    machine, tool = case.machine(), case.tool()
    if not isinstance(tool, Rod) or machine.bar is None:
        raise CaseError(case.file, "tool", None, "a rod of sections that the machine strikes", "describe it in [tool]")
    start, stop = case.start(0), case.simulation().stop
    place = start.displacement[0] if start.gap is None else -start.gap
    most = None if stop.time is None else stop.time * machine.time_scale
    given = getattr(case.tables.simulation, "impacts", None)
    blows = _BLOWS if given is None else int(given)
    try:
        motion = run_valve_by_waves(
            machine, tool, max(0.0, -(place or 0.0)) * machine.length_scale,
            blows=blows, most_time=most, cells=cells, progress=progress,
        )  # fmt: skip
    except ParameterError as error:
        raise CaseError(case.file, "load", None, error.accepted, error.remedy) from error
    law, table = self_excited_motion(machine, modes=0).cycle, getattr(case.tables, "drilling", None)
    return ValveWavesAnswer(case.file, case.title, motion, law, None if table is None else drilling_of(table))


def valve_waves_report(answer: ValveWavesAnswer, last: int | None) -> Report:
    """The report of `percuss simulate --contact waves` for a machine with a valve, with the last blows."""
    tell, motion = Teller(None, True), answer.motion
    rows = [
        ("case", answer.name),
        *rows_of(answer, VALVE_WAVES, tell),
        *(("warning", text) for text in answer.warnings),
    ]
    sections: list[ReportSection | Grid] = [ReportSection("Machine by waves", tuple(rows))]
    if last != 0 and motion.main.size:
        data = answer.to_json_dict(last)["blows"]
        heads = ("start [s]", "speed [m/s]", "restitution", "rock [J]", "fed [m]", "left [J]", "bit")
        keys = ("start", "speed", "restitution", "rock_work", "fed", "energy_left")
        lines = tuple((*(number(one[key], 6) for key in keys), "on" if one["stands"] else "off") for one in data)
        sections.append(Grid(f"The last {len(lines)} blows", heads, lines))
    settled = motion.label == "one blow in a cycle"
    texts = {
        "none": "By waves the machine strikes nothing.",
        "irregular": "By waves no periodic motion has been found.",
    }
    if motion.label == "irregular" and motion.scatter <= _RHYTHM:
        texts["irregular"] = f"By waves the machine keeps a rhythm that scatters by {percent(motion.scatter)}."
    text = texts.get(motion.label, f"By waves the machine settles on one blow in a cycle, {number(motion.rate)} Hz.")
    return Report(answer.title, text, GOOD if settled else PLAIN, tuple(sections))
