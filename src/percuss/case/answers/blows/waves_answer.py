"""The answer to "how does this hammer move when every blow is resolved by waves?", beside that of its contact law."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass, replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from percuss.case.answers.blows.drilling_answer import taken_singly, warned
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
    figures,
    flat_of,
    grid_of,
    json_number,
    json_of,
    number,
    percent,
    picked,
    plain,
    quantity,
    rhythm,
)
from percuss.case.answers.heading import heading_dict, system_section
from percuss.case.answers.simulation_answer import ENDINGS, MotionReport, last_of, rates, told_of
from percuss.case.case import checked_case
from percuss.errors import PercussError
from percuss.model import System
from percuss.model.body import SteppedBar
from percuss.model.checks import callback, count, flag
from percuss.short_repr import ShortRepr

if TYPE_CHECKING:
    from percuss.blow import Rod, Wall
    from percuss.blow.periods import Impacts, WaveMotion
    from percuss.case.case import Case
    from percuss.simulate import Progress, Stop, Trajectory
    from percuss.steady import Orbit, TimedOrbit


# ---- What is told of a motion by waves


SETTLED: tuple[Fact[WaveMotion], ...] = (
    Fact("impacts", "", "how many", "", "settled.size"),
    Fact("phases", "", "load phase at the centroid of the contact force", "", "settled.phase"),
    Fact("velocities velocities_m_s", "", "of each impact the speed of the rigid motion there", "speed",
         "settled.velocity"),
    Fact("restitutions", "", "impulse over mass and speed, less 1", "", "settled.restitution"),
    Fact("ringing_shares", "", "elastic energy after the impact over the energy before it", "",
         "settled.ringing_share"),
    Fact("durations_s", "", "of each impact", "time", "settled.duration"),
    Fact("peak_forces_N", "", "the greatest contact force of each impact", "force", "settled.peak_force"),
    Fact("given_J", "", "of each impact the work done on what is struck", "energy", "settled.given"),
    Fact("rock_work_J", "", "of each impact what the rock keeps", "energy", "settled.rock_work"),
    Fact("fed_m", "", "how far the tool is fed after each impact", "length", "settled.fed"),
    Fact("energies_left_J", "", "with a feed, of each impact: energy that departs from the static state of the tool "
         "as it begins", "energy", "settled.energy_left"),
    Fact("stands", "", "with a feed, of each impact: 1 if the bit is on the rock as it begins, else 0", "",
         "settled.stands"),
    Fact("rhythm", "", "blows per load period, and by how much their impulses scatter, (max − min)/mean; a blow has "
         "half the greatest impulse or more", "", "rhythm"),
    Fact("left_bound", "", r"with a feed: $\sqrt{E_{left}/W_{load}}$, by which waves left in the tool by earlier blows "
         "may change a penetration at most; null without", "", "left_bound"),
    Fact("blow_rate blow_rate_Hz", "", "impacts per load period, or per second", "cycles", "blow_rate"),
    Fact("impulse_per_period", "", "sum of the impulses per load period; null if not periodic", "",
         "impulse_per_period"),
    Fact("delivered_power delivered_power_kW", "", "work done on what is struck per radian, or per second", "power",
         "delivered_power"),
    Fact("rock_power", "", "what the rock keeps of it", "power", "rock_power"),
)  # fmt: skip
"""What a cycle by waves is."""


IMPACT: tuple[Fact[Impacts], ...] = (
    Fact("start start_s", "start", "of its first contact; in seconds null for a dimensionless case", "time", "start"),
    Fact("phase", "phase [rad]", "load phase at the centroid of the contact force, in $[0, 2\\pi)$", "", "phase"),
    Fact("contacts", "contacts", "how many: contacts less than a round trip of waves apart are one impact; on rock, "
         "all between two feeds", "", "contacts"),
    Fact("velocity", "speed", "of the rigid motion at the centroid, as it would be without the contact", "speed",
         "velocity"),
    Fact("restitution", "restitution", "impulse over mass and `velocity`, less 1", "", "restitution"),
    Fact("ringing_share", "ringing", "elastic energy after the impact over the energy before it", "", "ringing_share",
         "{ringing_share:percent}"),
    *figures(r"""
end | of its last contact
impulse | $\int N\,dt$
peak_force | the greatest N
mean_velocity_before | mean velocity of the bar before the contacts | mean_before
mean_velocity_after | and after them | mean_after
given | work done on what is struck
rock_work | and what the rock keeps
fed | how far the tool is fed afterwards; 0 of a tool that returns to its place or is not fed
"""),
)  # fmt: skip
"""What an impact by waves is."""


# ---- What a case says of its machine by waves: what is struck, where the striker starts, when to end

_TURN = 2.0 * math.pi
_PERIODS = 200  # after which a machine ends that nobody wants for a certain time


class Struck(NamedTuple):
    """What a machine strikes, whether that is pushed back after a blow, and what was assumed of it."""

    target: Rod | Wall
    pushed_back: bool
    note: str


def struck_by(case: Case) -> Struck:
    """The tool of a case as a machine by waves can have it."""
    from percuss.blow import Wall

    tables, system = case.tables, case.system()
    contact = getattr(tables, "contact", None) or getattr(tables, "system", None)
    tool = case.tool()
    pushed_back = getattr(contact, "advance", None) == "pushed back" or getattr(tool, "end", None) == "free"
    if getattr(tool, "end", None) == "rock" and getattr(tool, "feed", None) is None:
        laid = "no feed: after each blow the tool is laid against the rock; describe what presses it in [feed]"
        return Struck(tool, pushed_back, laid)
    if isinstance(tool, Wall) and tables.tool is None and not system.contact.is_lossless:
        ratio, restitution = number(1.0 / system.contact.impedance_ratio), number(system.contact.restitution)
        note = (
            f"there is no [tool]: what is struck is an endless rod of {ratio} times the impedance of the striking end"
        )
        return Struck(_rod_of(system), pushed_back, f"{note}, which gives a uniform bar the restitution {restitution}")
    return Struck(tool, pushed_back, "")


def _rod_of(system: System) -> Rod:
    """The endless rod whose impedance gives a uniform bar the restitution: R = (Z_rod − Z)/(Z_rod + Z)."""
    from percuss.blow import Rod

    body = system.body
    own = float(body.sections.impedance[-1]) if isinstance(body, SteppedBar) else body.s
    scale = 1.0 if system.bar is None else system.bar.mass * system.angular_frequency
    return Rod.of_impedance(own * scale / system.contact.impedance_ratio)


def stop_of(case: Case) -> Stop:
    """When to end: what [simulation] says; without a time after 200 load periods."""
    from percuss.blow.periods.wave_motion import TOLERANCE

    table, stop = case.tables.simulation, case.simulation().stop
    given = None if table is None else table.tolerance
    tolerance = TOLERANCE if given is None else given
    return replace(stop, time=_PERIODS * _TURN if stop.time is None else stop.time, tolerance=tolerance)


# ---- What a person must know of a motion by waves before using its figures

_RINGING = 0.05  # of a blow's energy: beyond, the next blow is not that of a bar at rest in itself
_UNSURE = 1e-3  # radians of phase between two lattices
_APART = 0.05  # of two restitutions
_PRESSED = 0.2 * 2.0 * math.pi  # what lasts longer is no blow: the load presses


def waves_warnings(motion: WaveMotion) -> list[str]:
    """One sentence each; none for a settled motion that two lattices and the law agree about."""
    found = []
    if motion.outcome == "interrupted":
        found.append("ended early: interrupted; the figures are those of the part that was computed")
    elif motion.cycle is None and motion.stop.periodic:
        found.append(_unsettled(motion))
    own = motion.settled
    found += _restitution(motion)
    if motion.left_bound is not None:
        found += warned(bool(motion.main.stands.all()), motion.left_bound)
    left = float(np.median(own.ringing_share)) if own.size else 0.0
    if left > _RINGING and motion.cycle is None and not motion.quiet:
        found.append(f"a blow leaves {percent(left)} of its energy as ringing (median), which damping must end in time")
    unsure = motion.uncertainty
    if unsure is not None and unsure.phase is None:
        found.append(f"a lattice with half the cells settles on {unsure.label}: give more cells")
    elif unsure is not None and unsure.phase is not None and unsure.phase > _UNSURE:
        found.append(f"a lattice with half the cells has phases {unsure.phase:.2g} rad from these: give more cells")
    return found


_RHYTHM = 0.1  # scatter of impulses within which blows are alike


def _unsettled(motion: WaveMotion) -> str:
    """What there is in place of a periodic motion: blows that are nearly alike, or not."""
    blows, scatter = motion.rhythm
    if scatter <= _RHYTHM:
        own = motion.main.restitution
        near = f"blows per load period {number(blows, 3)}, R = {number(float(np.nanmean(own)), 3)} in the mean"
        return f"no periodic motion found, but a rhythm: {near}; impulses scatter by {percent(scatter)}"
    return "no periodic motion found: simulate for longer, or look at the ringing that blows leave behind"


def _restitution(motion: WaveMotion) -> list[str]:
    """That the restitution of the law is not that of the main blows, those of half the greatest impulse or more."""
    own, assumed = motion.settled, motion.system.restitution
    short = np.isfinite(own.restitution) & (own.duration < _PRESSED)
    main = short & (own.impulse >= 0.5 * own.impulse[short].max(initial=0.0))
    found = own.restitution[main]
    by_waves = float(np.median(found)) if found.size else assumed
    if motion.rests or math.isclose(by_waves, assumed, rel_tol=0.0, abs_tol=_APART):
        return []
    remedy = 'restitution = "from the blow" gives the law that of one blow on the tool'
    return [f"the blows have R = {number(by_waves, 3)} (median), the law beside them {number(assumed, 3)}: {remedy}"]


# ---- The answer to "how does this hammer move when every blow is resolved by waves?", beside that of its contact law


@dataclass(frozen=True)
class Beside(ShortRepr):
    """A settled motion by another law, and how much that by waves differs (rad, relative; None: other kinds)."""

    law: str
    label: str | None
    phases: tuple[float, ...]
    velocities: tuple[float, ...]
    blow_rate: float | None
    phase_difference: float | None
    velocity_difference: float | None


@dataclass(frozen=True)
class WavesAnswer(MotionReport):
    """A motion of a case with every contact resolved by waves.

    Attributes
    ----------
    name, title, notes
        The case as it was named, its title, and what was assumed, one sentence each.
    motion, law
        The motion by waves, and by the contact law of the case from the same start.
    beside
        What the laws say of the settled motion.
    """

    ROWS = "impacts"

    name: str
    title: str
    motion: WaveMotion
    law: Trajectory
    beside: tuple[Beside, ...]
    notes: tuple[str, ...] = ()

    @property
    def system(self) -> System:
        """The system that moved."""
        return self.motion.system

    @property
    def warnings(self) -> tuple[str, ...]:
        """What a reader of the figures should know, one sentence each."""
        return tuple(waves_warnings(self.motion))

    def to_json_dict(self, last: int | None = None) -> dict[str, Any]:
        """The answer in plain values; see `MotionReport`."""
        motion, tell = self.motion, Teller.of(self.system)
        settled = json_of(motion, SETTLED, tell)
        return {
            **heading_dict(self.name, self.title, self.system, self.notes),
            **picked(motion, "outcome label end_time grazes pushed_back quiet"),
            "begin_time": json_number(motion.start.time),
            "lattice": picked(motion.lattice, "steps cells rounding"),
            "uncertainty": None if motion.uncertainty is None else plain(asdict(motion.uncertainty)),
            "warnings": list(self.warnings),
            "settled": settled if self.system.frequency is not None else {**settled, "si": None},
            "energy": plain({**asdict(motion.energy), "error": motion.energy.error}),
            "beside": [plain(asdict(one)) for one in self.beside],
            "impacts": [flat_of(one, IMPACT, tell) for one in _last(motion, last)],
        }


def _last(motion: WaveMotion, last: int | None) -> list[Impacts]:
    every = motion.impacts
    return [every.part(i) for i in range(every.size)[last_of(every.size, last)]]


def waves_answer(
    case: Case, progress: Callable[[Progress], object] | None = None, *, quiet: bool = False, cells: int = 400
) -> WavesAnswer:
    """The motion of a case from its start, every contact resolved by waves, beside that of its contact law.

    Parameters
    ----------
    progress
        Called now and then, for both motions; they end as interrupted when it returns something true.
    quiet
        Whether all ringing is made to end between blows.
    cells
        Cells of the bar, at least.

    Raises
    ------
    CaseError
        When the start or the tool does not fit the case.

    Examples
    --------
    >>> from percuss.case import Case
    >>> case = Case.from_text('''
    ... [system]
    ... s = 20.0
    ... d = 0.01
    ... restitution = 0.6
    ... [load]
    ... kind = "harmonic"
    ... mean = 0.9
    ... amplitude = 1.0
    ... [start]
    ... position = -3.0
    ... ''')
    >>> answer = waves_answer(case, cells=100)
    >>> answer.motion.label, answer.law.label, [round(one.phase_difference, 4) for one in answer.beside]
    ('z=1/1', 'z=1/1', [0.0184])
    """
    from percuss.blow.periods import run_by_waves  # loads the compiler
    from percuss.simulate import run

    checked_case(case)
    callback("progress", progress)
    flag("quiet", quiet), count("cells", cells)
    simulation, system = case.simulation(), case.system()
    start, struck = case.start(simulation.modes), struck_by(case)
    motion = run_by_waves(
        system,
        struck.target,
        start,
        stop_of(case),
        pushed_back=struck.pushed_back,
        quiet=quiet,
        cells=cells,
        progress=progress,
    )
    law = run(system, start, modes=simulation.modes, stop=simulation.stop, progress=progress)
    notes = (*case.notes, struck.note) if struck.note else case.notes
    return WavesAnswer(case.file, case.title, motion, law, _beside(case, motion, law), notes)


# -- beside other laws ----------------------------------------------------------------------------------------------


def _beside(case: Case, motion: WaveMotion, law: Trajectory) -> tuple[Beside, ...]:
    found = [_simulated(motion, law)]
    cycle = motion.cycle
    if cycle is None or cycle.impacts != 1 or motion.rests:
        return tuple(found)
    from percuss.steady import steady_states, timed_states

    system, timed = motion.system, case.timed_law()
    orbits: tuple[Orbit | TimedOrbit, ...] = ()
    with suppress(PercussError):  # a load that does not push, a mode in resonance: there is no steady motion
        if found[0].phase_difference is None:
            orbits = steady_states(system, cycle.periods).orbits
            found += _steady(motion, f"{system.contact.law}, steady", orbits)
        if timed is not None:
            orbits = timed_states(system, timed, cycle.periods).orbits
            found += _steady(motion, f"{timed.law}, steady", orbits)
    return tuple(found)


def _steady(motion: WaveMotion, law: str, orbits: Sequence[Orbit | TimedOrbit]) -> list[Beside]:
    """The steady motion whose phase is nearest."""
    own, velocity = float(motion.phases[0]), float(motion.velocities[0])
    nearest = min(orbits, key=lambda orbit: abs(_apart(own, orbit.phase)), default=None)
    if nearest is None:
        return []
    speed, apart = nearest.rigid_velocity, _apart(own, nearest.phase)
    return [Beside(law, None, (nearest.phase,), (speed,), motion.blow_rate, apart, velocity / speed - 1.0)]


def _simulated(motion: WaveMotion, law: Trajectory) -> Beside:
    """The motion by the contact law, which settled or not."""
    phases: tuple[float, ...] = ()
    velocities: tuple[float, ...] = ()
    contact = law.system.contact
    if law.cycle is not None and law.label.startswith("z="):
        struck = law.events.of("impact")
        size = law.cycle.impacts
        phases = tuple(float(phase) for phase in struck.phase[-size:])
        after = law.velocity[law.events.kind == "impact", 0][-size:] if contact.rebounds else np.zeros(0)
        velocities = tuple(float(v / contact.velocity_factor) for v in after)
    name = law.system.contact.law
    if law.label != motion.label or not phases:
        return Beside(name, law.label, phases, velocities, law.summary.blow_rate, None, None)
    shifts = [
        max((_apart(a, b) for a, b in zip(motion.phases, np.roll(phases, k), strict=True)), key=abs)
        for k in range(len(phases))
    ]
    k = int(np.argmin(np.abs(shifts)))
    speeds = np.asarray(motion.velocities) / np.roll(velocities, k) - 1.0 if velocities else np.zeros(0)
    change = max(speeds.tolist(), key=abs) if speeds.size else None
    return Beside(name, law.label, phases, velocities, law.summary.blow_rate, shifts[k], change)


def _apart(one: float, other: float) -> float:
    """The first phase less the second, from −π to π."""
    return math.remainder(one - other, 2.0 * math.pi)


# ---- A motion by waves as the report that a person reads, beside that of the contact law

_FEW_WAVES = 4  # impacts of a cycle that are told one by one


def waves_report(answer: WavesAnswer, last: int | None) -> Report:
    """The report of `percuss simulate --contact waves` with the `last` impacts; None shows all of them."""
    sections: list[ReportSection | Grid] = [
        system_section(answer.name, answer.system, answer.notes),
        _waves_section(answer),
        _laws_grid(answer),
    ]
    if last != 0 and answer.motion.impacts.size:
        size = answer.motion.impacts.size
        heading = told_of("Impacts", size, last_of(size, last))
        sections.append(grid_of(heading, _last(answer.motion, last), IMPACT, Teller.of(answer.system)))
    text, tone = _waves_summary(answer)
    return Report(answer.title, text, tone, tuple(sections))


def _waves_summary(answer: WavesAnswer) -> tuple[str, str]:
    motion = answer.motion
    if motion.label == "rest":
        return "By waves the hammer comes to rest on what it strikes (rest).", BAD
    if motion.label == "none":
        return "By waves the hammer strikes nothing (none).", BAD
    if motion.cycle is None and motion.rhythm[1] <= _RHYTHM:
        blows, scatter = motion.rhythm
        text = f"By waves the hammer keeps a rhythm (blows per load period: {number(blows, 3)})"
        return f"{text}; impulses scatter by {percent(scatter)} (irregular).", PLAIN
    if motion.cycle is None:
        return "By waves no periodic motion has been found (irregular).", PLAIN
    text = f"By waves the hammer settles on {rhythm(motion.label)} ({motion.label})"
    first = answer.beside[0]
    return f"{text}; by the law {first.law}: {first.label}.", GOOD


def _waves_section(answer: WavesAnswer) -> ReportSection:
    motion, own = answer.motion, answer.motion.settled
    length = motion.end_time - motion.start.time
    rows = [
        ("followed", f"{number(length / _TURN, 6)} load periods; {counted(motion.impacts.size, 'impact')}"),
        ("ended", f"{ENDINGS[motion.outcome]} ({motion.outcome})"),
        ("struck", _struck(motion)),
    ]
    if own.size:
        which = "" if own.size <= _FEW_WAVES else f" (the first {_FEW_WAVES} of {own.size})"
        rows.append(("phase", f"{_each(own.phase[:_FEW_WAVES], 5)} rad at the centroid of the force{which}"))
        speeds = motion.velocities[:_FEW_WAVES]
        told = f"{_each(speeds * answer.system.speed_scale)} m/s" if answer.system.is_si else _each(speeds, 6)
        rows.append(("speed", f"{told}, of the rigid motion there"))
        rows.append(("restitution", f"{_each(own.restitution[:_FEW_WAVES], 4)}, as these impacts have it"))
        rows.append(("contact", _contact(motion)))
        rows.append(("ringing", f"{percent(float(own.ringing_share.max()))} of the energy before the impact, at most"))
        rows.append(("blow rate", rates(answer.system, motion.blow_rate)))
        if motion.left_bound is not None:
            stands = "on the rock at every blow" if motion.main.stands.all() else "off the rock at a blow"
            rows.append(("bit", stands))
            rows.append(("one by one", taken_singly(motion.left_bound)))
    if answer.system.is_si:
        rows.append(("given", _given(motion)))
    rows.append(("lattice", _lattice(motion)))
    rows += [("warning", warning) for warning in answer.warnings]
    return ReportSection("Motion by waves", tuple(rows))


def _struck(motion: WaveMotion) -> str:
    from percuss.blow import Wall

    if isinstance(motion.target, Wall):
        return "a rigid wall"
    end = motion.target.end
    stays = "is fed by what each blow leaves of the penetration" if end == "rock" else "stays where a blow has put it"
    how = "is pushed back after each blow" if motion.pushed_back else stays
    if motion.target.feed is not None:
        how = f"is pressed by {quantity(motion.target.feed.force, 'N')}"
        how += " with a recoil damper" if motion.target.feed.damping or motion.target.feed.stiffness else ""
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


def _lattice(motion: WaveMotion) -> str:
    lattice, unsure = motion.lattice, motion.uncertainty
    text = (
        f"{sum(lattice.cells[: lattice.striker])} cells, transit times rounded by {lattice.rounding:.1g} of the bar's"
    )
    if unsure is not None and unsure.phase is not None and unsure.velocity is not None:
        text += f"; with half the cells phases differ by {unsure.phase:.1g} rad, speeds by {unsure.velocity:.1g}"
    return text


def _each(values: Iterable[float], digits: int = 4) -> str:
    """Values one after another; equal ones, as they are shown, once."""
    return ", ".join(dict.fromkeys(number(float(value), digits) for value in values))


# -- beside the laws ------------------------------------------------------------------------------------------------


def _laws_grid(answer: WavesAnswer) -> Grid:
    motion = answer.motion
    unit, scale = (" [m/s]", motion.system.speed_scale) if motion.system.is_si else ("", 1.0)
    own = (tuple(motion.phases.tolist()), tuple(motion.velocities.tolist()))
    waves = Beside("waves", motion.label, *own, motion.blow_rate, None, None)
    rows = tuple(
        (
            one.law,
            one.label or "",
            _each(one.phases[:_FEW_WAVES], 5),
            _each([speed * scale for speed in one.velocities[:_FEW_WAVES]]),
            "" if one.blow_rate is None else number(one.blow_rate, 5),
            "" if one.phase_difference is None else f"{one.phase_difference:+.2g}",
            "" if one.velocity_difference is None else f"{100.0 * one.velocity_difference:+.2g} %",
        )
        for one in (waves, *answer.beside)
    )
    columns = ("", "settles on", "phase [rad]", f"speed{unit}", "blows per period", "phase less", "speed less")
    return Grid("Beside the laws", columns, rows)
