"""Answers as pictures in time, for the page: motions, machines that switch themselves, and blows."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
import numpy.typing as npt

from percuss.case.answers.blows.blow_answer import BlowAnswer, blow_answer, blow_sentence
from percuss.case.answers.exploring.orbits_answer import orbit_dict, rest_cycle_dict
from percuss.case.answers.exploring.tolerance import uncertainty_of
from percuss.case.answers.facts import Fact, Teller, counted, flat_of, json_number, plain, scales_of, settles
from percuss.case.answers.heading import motion_dict
from percuss.case.answers.machine_answer import cycle_dict, headline, machine_answer, machine_numbers
from percuss.case.answers.machine_figures import course_from_start, course_of
from percuss.case.answers.simulation_answer import from_this_start
from percuss.case.parameters.case_family import CaseFamily
from percuss.errors import ParameterError
from percuss.model.body import ModalBody, SizedBody
from percuss.model.checks import Array, count
from percuss.simulate import Start, Stop, run
from percuss.simulate.events import IMPACT
from percuss.simulate.spectrum import units
from percuss.steady import PeriodicOrbit, RestCycle, orbit_near, steady_states
from percuss.steady.resting.rest_cycles import cycle_through

if TYPE_CHECKING:
    from percuss.blow import Blow, CellsOverTime, Trace
    from percuss.blow.bodies import Sections
    from percuss.case.answers.machine_figures import CycleCurve
    from percuss.case.answers.simulation_answer import SimulationAnswer
    from percuss.case.case import Case
    from percuss.model import Machine, System
    from percuss.simulate import Event, Trajectory


# ---- Which stretch of a simulated motion is framed: its first periods, or whole cycles of what it settles on

_FEWEST = 240  # points of the striking end's history that a cycle has at least, however often it is told

_Numbers = npt.NDArray[np.float64]

_TURN = 2.0 * math.pi
_NEAR = 1e-5  # rad within which an impact of a cycle and the one of the cycle after are at the same place


@dataclass(frozen=True)
class PlayedStretch:
    """A stretch of a motion, `begin` to `end` (rad), told `copies` times over, as what repeats is simulated once."""

    motion: Trajectory
    begin: float
    end: float
    copies: int = 1

    @property
    def once(self) -> float:
        """Rad that are told once."""
        return self.end - self.begin

    @property
    def length(self) -> float:
        """Rad in all."""
        return self.copies * self.once

    def moments(self, times: _Numbers) -> _Numbers:
        """Times of the simulation that stand for `times` after the beginning of the stretch."""
        if self.copies == 1:
            return np.clip(self.begin + times, self.begin, self.end)
        return self.begin + np.where(times >= self.length, self.once, np.mod(times, self.once))

    def events(self) -> list[tuple[int, float]]:
        """Numbers of the events, and their times after the beginning; where copies join there is one and not two."""
        time = self.motion.events.time
        inside = np.flatnonzero((time >= self.begin) & (time <= self.end))
        later = inside[time[inside] > self.begin + _NEAR]
        first = [(int(i), float(time[i] - self.begin)) for i in inside]
        return first + [
            (int(i), float(time[i] - self.begin) + k * self.once) for k in range(1, self.copies) for i in later
        ]

    def end_point(self, points: int) -> tuple[_Numbers, _Numbers, _Numbers]:
        """Time after the beginning, gap and velocity of the striking end; NaN where its velocity jumps."""
        time = self.motion.events.time
        jumps = time[(time >= self.begin) & (time <= self.end)]
        each = max(points // self.copies, min(points, _FEWEST))
        times, gap, velocity = _history(self.motion, self.begin, self.end, jumps, each)
        times = times - self.begin
        parts = [(times, gap, velocity)]
        later = times > _NEAR
        parts += [(times[later] + k * self.once, gap[later], velocity[later]) for k in range(1, self.copies)]
        found = [np.concatenate([part[i] for part in parts]) for i in range(3)]
        return found[0], found[1], found[2]


def stretch_of(motion: Trajectory, settled: bool, cycles: int) -> PlayedStretch:
    """The first load periods of a motion (`cycles`), or what it settles on: whole cycles, the last told again."""
    first, last = motion.begin_time, motion.end_time
    length = cycles * _TURN
    if not settled:
        return PlayedStretch(motion, first, min(first + length, last))
    if motion.cycle is None:
        return PlayedStretch(motion, max(last - length, first, _half(motion)), last)
    once = motion.cycle.periods * _TURN
    wanted = max(cycles // motion.cycle.periods, 1)
    struck = motion.events.time[motion.events.code == IMPACT]
    begun = float(struck[motion.cycle.first])
    last = float(struck[-1])
    known = math.floor((last - begun + _NEAR) / once)  # whole cycles
    if known < wanted:
        begin = _impact(struck, last - once)
        return PlayedStretch(motion, begin, _impact(struck, begin + once), wanted)
    begin = _impact(struck, last - wanted * once)
    return PlayedStretch(motion, begin, _impact(struck, begin + wanted * once))


def _half(motion: Trajectory) -> float:
    """From when on a motion without a cycle may count as settled: its second half, if it has enough impacts."""
    struck = motion.events.time[motion.events.code == IMPACT]
    return float(struck[motion.summary.first]) if motion.summary.first else motion.begin_time


def _impact(struck: _Numbers, time: float) -> float:
    """The last impact until then, with some room for rounding."""
    before = struck[struck <= time + _NEAR]
    return float(before[-1]) if before.size else time


def _history(
    motion: Trajectory, begin: float, end: float, jumps: _Numbers, points: int
) -> tuple[_Numbers, _Numbers, _Numbers]:
    """Time, gap and velocity of the striking end: equal steps, and both sides of every jump with NaN between them."""
    if jumps.size > points // 4:
        jumps = jumps[:0]
    times = np.linspace(begin, end, max(points - 3 * jumps.size, 2))
    gap, velocity = motion.gap(times), motion.bar_velocity(1.0, times)[0]
    if not jumps.size:
        return times, gap, velocity
    before, after = (motion.bar_velocity(1.0, jumps, side)[0] for side in ("left", "right"))
    touch, nothing = motion.gap(jumps), np.full(jumps.size, np.nan)
    rank = np.concatenate([np.zeros(times.size), *(np.full(jumps.size, i) for i in (1, 2, 3))])
    clock = np.concatenate([times, jumps, jumps, jumps])
    rows: tuple[npt.NDArray[Any], ...] = (
        clock,
        np.concatenate([gap, touch, nothing, touch]),
        np.concatenate([velocity, before, nothing, after]),
    )
    order = np.lexsort((rank, clock))
    return rows[0][order], rows[1][order], rows[2][order]


# ---- A motion as pictures in time: displacement and strain along the bar, the striking end's history, and every blow

Arrays = dict[str, npt.NDArray[Any]]

_MOST_BLOWS = 2000
_MOST_POINCARE = 20_000


@dataclass(frozen=True)
class Frames:
    """A stretch of a motion: a header of JSON's types, and arrays by name.

    Attributes
    ----------
    header
        What moved, when, its blows, and the scales that its numbers have in SI.
    arrays
        ``x`` (places) from the driven to the striking end; ``t`` (frames) in rad after the beginning; ``displacement``
        and ``strain`` (frames, places), of a structure told by its modes those of its contact; ``end_t``, ``end_gap``,
        ``end_velocity`` of the striking end, with NaN where its velocity jumps; ``poincare_phase``,
        ``poincare_velocity``, ``poincare_settled`` of the impacts.
    """

    header: dict[str, Any]
    arrays: Arrays


def orbit_playback(
    case: Case,
    orbit: int,
    periods: int = 1,
    *,
    cycles: int = 1,
    frames: int = 240,
    places: int = 33,
    points: int = 2000,
    window: Sequence[float] | None = None,
) -> Frames:
    """Whole periods of a steady motion (numbered by phase) from an impact on; `window`: part of the fields."""
    system = case.system()
    orbits = steady_states(system, periods).orbits
    if not 1 <= orbit <= len(orbits):
        raise ParameterError("orbit", orbit, f"the number of a steady motion; there are {len(orbits)}")
    motion = orbits[orbit - 1]
    x = np.linspace(0.0, 1.0, places)
    t = np.linspace(*_part(window, cycles * motion.period), frames)
    field = motion.field(_known(system, x), t)
    each = max(points // cycles - 1, 2)
    one = np.linspace(0.0, motion.period, each)
    end = motion.field(1.0, one)
    whole = np.arange(cycles)[:, None] * motion.period + np.append(one, motion.period)
    gap, velocity = np.append(end.displacement[0], np.nan), np.append(end.velocity[0], np.nan)
    arrays: Arrays = {
        "x": x,
        "t": t,
        "displacement": field.displacement.T,
        "strain": _strain(system, x, field.strain).T,
        "end_t": whole.reshape(-1),
        "end_gap": np.tile(gap, cycles),
        "end_velocity": np.tile(velocity, cycles),
        "poincare_phase": np.array([motion.phase]),
        "poincare_velocity": np.array([motion.impact_velocity]),
        "poincare_settled": np.array([True]),
    }
    lost = motion.delivered_energy
    rows = [
        ("impact", n * motion.period, motion.phase, motion.impact_velocity, motion.rebound_velocity, lost)
        for n in range(cycles + 1)
    ]
    header = _header(system, motion.modes, motion.phase, motion.phase + cycles * motion.period, motion.period)
    about: dict[str, Any] = {"source": "orbit", "label": f"z=1/{periods}", "outcome": None, "summary": None}
    about["blows"] = [flat_of(row, BLOW, Teller.of(system)) for row in rows]
    return Frames({**about, **header}, arrays)


def motion_playback(motion: Trajectory, *, settled: bool = True, cycles: int = 1, **sizes: Any) -> Frames:
    """The first or last load periods of a simulated motion, or whole cycles; `sizes` as of `stretch_playback`."""
    period = None if motion.cycle is None else motion.cycle.periods * _TURN
    about: dict[str, Any] = {"source": "simulation", "label": motion.label, "outcome": motion.outcome}
    about["summary"] = plain(asdict(motion.summary))
    return stretch_playback(stretch_of(motion, settled, cycles), about, period, **sizes)


def stretch_playback(
    stretch: PlayedStretch,
    about: dict[str, Any],
    period: float | None,
    *,
    frames: int = 240,
    places: int = 33,
    points: int = 2000,
    window: Sequence[float] | None = None,
) -> Frames:
    """A stretch of a simulated motion that repeats after `period`, or never; `about` is said in the header besides."""
    motion, events = stretch.motion, stretch.motion.events
    x = np.linspace(0.0, 1.0, places)
    t = np.linspace(*_part(window, stretch.length), frames)
    moments = stretch.moments(t)
    end_t, gap, velocity = stretch.end_point(points)
    struck = np.flatnonzero(events.code == IMPACT)
    kept = np.arange(max(struck.size - _MOST_POINCARE, 0), struck.size)
    at = struck[kept]
    arrays: Arrays = {
        "x": x,
        "t": t,
        "displacement": motion.position(_known(motion.system, x), moments).T,
        "strain": _strain(motion.system, x, motion.strain(_known(motion.system, x), moments)).T,
        "end_t": end_t,
        "end_gap": gap,
        "end_velocity": velocity,
        "poincare_phase": events.phase[at],
        "poincare_velocity": events.impact_velocity[at],
        "poincare_settled": kept >= motion.summary.first,
    }
    rows = [
        (
            str(events.kind[i]),
            time,
            float(events.phase[i]),
            float(events.impact_velocity[i]),
            float(events.rebound_velocity[i]),
            float(events.energy_lost[i]),
        )
        for i, time in stretch.events()[-_MOST_BLOWS:]
    ]
    header = _header(motion.system, motion.modes, stretch.begin, stretch.begin + stretch.length, period)
    return Frames({**about, **header, "blows": [flat_of(row, BLOW, Teller.of(motion.system)) for row in rows]}, arrays)


def _part(window: Sequence[float] | None, length: float) -> tuple[float, float]:
    if window is None:
        return 0.0, length
    low, high = window
    if not 0.0 <= low < high:
        raise ParameterError("window", list(window), "from and to in rad after the beginning, 0 or greater, ascending")
    if low >= length:
        raise ParameterError("window", list(window), f"a part of the {length:.6g} rad that are framed")
    return low, min(high, length)


def _strain(system: System, x: Array, strain: Array) -> Array:
    """u_x; of a bar with sizes the stress over `stress_scale_Pa`, which differs where its material does."""
    if isinstance(system.body, ModalBody):
        return np.zeros_like(strain)  # it has none
    return system.stress(x, strain) / system.stress_scale if _has_stress(system) else strain


def _has_stress(system: System) -> bool:
    """Whether it is a bar with sizes; a structure told by its modes, or a rigid mass, has no stress."""
    return system.is_si and system.bar is not None and bool(system.bar.pieces)


def _known(system: System, x: Array) -> Array:
    """The places of which the displacement is known: of a structure that is told by its modes the contact alone."""
    return np.ones_like(x) if isinstance(system.body, ModalBody) else x


def _header(system: System, modes: int, begin: float, end: float, period: float | None) -> dict[str, Any]:
    si, first = system.is_si, float(system.body.frequencies(1)[0])
    return {
        "begin": json_number(begin),
        "end": json_number(end),
        "period": json_number(period),
        "load_phase": json_number(math.fmod(begin, _TURN)),
        "modes": int(modes),
        "first_mode": json_number(first),
        "first_mode_Hz": json_number(first * system.frequency) if system.frequency is not None else None,
        "time_scale_s": json_number(system.time_scale) if si else None,
        "length_scale_m": json_number(system.length_scale) if si else None,
        "stress_scale_Pa": json_number(system.stress_scale) if _has_stress(system) else None,
    }


BLOW: tuple[Fact[Any], ...] = (
    Fact("kind", "", "as an event of a simulation", "", lambda row: row[0]),
    Fact("time time_s", "", "after the beginning of the stretch", "time", lambda row: row[1]),
    Fact("phase", "", "of the load", "", lambda row: row[2]),
    Fact("impact_velocity impact_velocity_m_s", "", "speed of the striking end before", "speed", lambda row: row[3]),
    Fact("rebound_velocity", "", "and after", "speed", lambda row: row[4]),
    Fact("energy energy_J", "", "what the blow takes from the bar", "energy", lambda row: row[5]),
)
"""What the page tells of a blow."""


# ---- A motion of a branch as pictures in time: one cycle of it, simulated from an impact or a release and told again

_LOOKS = 121  # points of the load over its period

_MOST_IMPACTS = 20_000  # of a chatter that is simulated


def branch_playback(
    case: Case,
    name: str,
    value: float,
    at: Sequence[float] | float,
    periods: int,
    *,
    unit: str = "",
    modes: int = 32,
    cycles: int = 1,
    **sizes: Any,
) -> Frames:
    """Whole cycles of a motion at another value of a parameter, simulated once and told again and again."""
    # `at`: times near those of the impacts of the orbit (rad, increasing), or a phase near that at which a cycle with
    # rest leaves the wall. So an unstable orbit stays what it is. The motion is in the header, and the load over its
    # period in ``load``.
    system = CaseFamily(case, {name: unit} if unit else {}).system({name: value})
    found: PeriodicOrbit | RestCycle | None
    if isinstance(at, int | float):
        found, _, _ = cycle_through(system, at, modes=modes, most=periods)
        if found is None or found.periods != periods:
            raise ParameterError("release", at, f"a phase near that at which a cycle of {periods} load periods leaves")
        start, told = Start.rigid(0.0, 0.0, found.release_phase), rest_cycle_dict(found)
        if found.is_several:  # several modes of a structure: from the rest before
            time, shape = found.lying[-1]
            shape = shape / units(system.body.modes(found.modes, system.load.at))
            start = Start.modal(np.append(0.0, shape), np.zeros(found.modes + 1), time)
        stop = Stop(_MOST_IMPACTS, time=found.period, periodic=False)
    else:
        found = orbit_near(system, at, periods, modes=modes)
        if found is None:
            raise ParameterError("times", list(at), f"times near those of an orbit z={len(at)}/{periods}")
        start, told = Start.orbit(found), orbit_dict(found, found.multipliers().values)
        stop = Stop(found.impacts, time=1.5 * found.period, periodic=False)
    motion = run(system, start, modes=found.modes, stop=stop)
    struck = motion.events.time
    end = float(struck[-1]) if struck.size and isinstance(found, PeriodicOrbit) else motion.end_time
    about = {"source": "branch", "outcome": None, "summary": None, "label": found.label, "orbit": told}
    framed = stretch_playback(PlayedStretch(motion, motion.begin_time, end, cycles), about, found.period, **sizes)
    load = system.load.value(np.linspace(0.0, _TURN, _LOOKS))
    return Frames(framed.header, {**framed.arrays, "load": np.asarray(load)})


# ---- A machine over its cycle


def machine_playback(case: Case, *, modes: int | None = None, points: int = 401, whole: bool = True) -> Frames:
    """A machine's cycle in its units; `whole`: with margins and the curve over the pressure, which take longer."""
    answer = machine_answer(case, modes)
    if whole and answer.runs:
        answer = replace(answer, uncertainty=uncertainty_of(case, modes))
    machine = answer.machine
    told = answer.to_json_dict() if whole else cycle_dict(answer)
    header = {
        "title": answer.title,
        "modes": answer.motion.modes,
        "whole": whole,
        "runs": answer.runs,
        "sentence": headline(answer) if whole or not answer.runs else None,
        "settles": settles(abs(answer.cycle.multiplier)) if answer.cycle is not None and answer.runs else None,
        "answer": told,
        **of_machine(machine),
    }
    if answer.cycle is None:
        return Frames(plain(header), {})
    course = course_of(machine, answer.cycle, points)
    return Frames(plain(header), course_arrays(machine, course, np.asarray(answer.cycle.blow_times)[:-1]))


def of_machine(machine: Machine) -> dict[str, Any]:
    """What a picture needs of the machine itself."""
    pairs, scale = machine.valve.pairs, Teller.of(machine).scale
    return {
        "units": "SI" if machine.is_si else "dimensionless",
        "scales": scales_of(machine, "length_m time_s speed_m_s force_N energy_J"),
        "states": [name for name, _ in pairs],
        "forces": [json_number(machine.valve.force(name) * scale("force")) for name, _ in pairs],
        "stiffness": json_number(machine.valve.chamber.stiffness * (scale("force") / scale("length"))),
        "pressure_Pa": json_number(machine.pressure),
        "motion": motion_dict(machine),
    }


def course_arrays(machine: Machine, course: CycleCurve, blows: Array) -> dict[str, Any]:
    """A course over time; the velocity is the mean one between two instants, in the middle between them."""
    names = {name: i for i, (name, _) in enumerate(machine.valve.pairs)}
    length, time, force = map(Teller.of(machine).scale, ("length", "time", "force"))
    steps = np.diff(course.times)
    struck = np.searchsorted(blows, course.times[:-1], side="right") != np.searchsorted(blows, course.times[1:])
    goes = (steps > 1e-9 * course.times[-1]) & ~struck
    return {
        "t": course.times * time,
        "striking_end": course.striking_end * length,
        "centre": course.centre * length,
        "force": course.force * force,
        "state": np.array([names[state] for state in course.states], dtype=np.int16),
        "velocity_t": 0.5 * (course.times[1:] + course.times[:-1])[goes] * time,
        "velocity": np.diff(course.centre)[goes] / steps[goes] * length / time,
    }


# ---- A machine that switches itself from a start, as pictures in time: its first blows, in the form of a cycle


def start_playback(found: SimulationAnswer, blows: int = 12, points: int = 2000) -> Frames:
    """The first blows of a simulated motion, at most so many, with the header and the arrays of a cycle."""
    motion, machine = found.motion, found.machine
    count("blows", blows)
    course = course_from_start(motion, blows, count("points", points, least=2))
    length = float(course.times[-1])
    events = motion.events
    shown = [event for event in events if event.time - motion.begin_time <= length]
    header = {
        "title": found.title,
        "modes": motion.modes,
        "label": motion.label,
        "sentence": f"{from_this_start(found)} {_shown(motion, shown)}",
        "answer": _answer_from_start(found, course, shown),
        **of_machine(machine),
    }
    struck = events.of("impact").time - motion.begin_time
    return Frames(plain(header), course_arrays(machine, course, struck))


def _shown(motion: Trajectory, shown: Sequence[Event]) -> str:
    words = counted(sum(event.kind == "impact" for event in shown), "blow")
    return f"ShortRepr: all of it, {words}." if len(shown) == len(motion.events) else f"ShortRepr: the first {words}."


def _answer_from_start(found: SimulationAnswer, course: CycleCurve, shown: Sequence[Event]) -> dict[str, Any]:
    """The part of the answer for a cycle that a picture reads, of a motion from its start."""
    motion, machine = found.motion, found.machine
    begin = motion.begin_time
    each = {kind: [event for event in shown if event.kind == kind] for kind in ("impact", "port", "valve")}
    return {
        "machine": machine_numbers(machine),
        "period": json_number(float(course.times[-1])),
        "stroke": json_number(max(-float(course.striking_end.min()), 0.0)),
        "first_state": machine.valve.pairs[motion.start.piece][0],
        "blows": [
            {
                "time": json_number(e.time - begin),
                "speed": json_number(e.impact_velocity),
                "energy": json_number(e.kinetic_energy),
            }
            for e in each["impact"]
        ],
        "ports": [{"port": e.port, "time": json_number(e.time - begin)} for e in each["port"]],
        "valve": [{"time": json_number(e.time - begin), "to": e.state} for e in each["valve"]],
        "si": None,
    }


# ---- A blow


Part = Literal["start", "contact", "window"]
"""What is shown: the first 300 µs (6 transit times of a dimensionless striker), until it has parted, or all of it."""

_START = 300e-6
_TRANSITS = 6.0
_AFTER = 2.0  # transit times of the striker that are shown after the last contact

_BREAKS = 4000  # jumps of a force that are drawn as such

_REACH = 2.0  # of an endless rod: lengths of the striker that are shown


def blow_playback(
    case: Case,
    show: Part = "start",
    *,
    frames: int = 181,
    cells: int = 120,
    whole: bool = True,
    most_pieces: int | None = None,
) -> Frames:
    """A blow over time and place; without `whole` its start as far as it is shown, and no answer."""
    from percuss.blow.bodies import rod_sections, striker_sections

    until = None
    if not whole and show == "start":  # the end of the window when only the start is asked for
        question = case.blow_question()
        short = _start(question.striker, striker_sections(question.striker))
        until = short if question.until is None else min(short, question.until)
    answer = blow_answer(case, until=until, most_pieces=most_pieces)
    blow = answer.blow
    sections = striker_sections(blow.striker)
    end = _end(blow, show, sections)
    times = np.linspace(0.0, end, frames)
    reach = _REACH * float(sections.length.sum() if answer.is_si else sections.transit.sum())
    own, rod = blow.cells_over_time(times, cells, reach)
    energy = blow.energy_over_time(times)
    arrays: dict[str, npt.NDArray[Any]] = {"t": times, **_body("striker", own, sections)}
    told = None
    if rod is not None and answer.rod is not None:
        struck = rod_sections(answer.rod, blow.striker)
        if not answer.is_si:  # places along it are times of a wave: lengths with the speed of waves in the striking end
            speed = float(sections.speed[-1])
            rod, reach = replace(rod, edges=speed * rod.edges), speed * reach
        arrays |= _body("rod", rod, struck)
        told = {**_sections(struck, reach), **_held(answer)}
    arrays |= _forces(blow, times, end)
    for name in ("rigid", "vibration", "rod", "rock_dissipated", "rock_stored"):
        arrays[f"energy_{name}"] = getattr(energy, name)
    header = _heading(answer, whole) | {"show": show, "end": end, "striker": _sections(sections, 0.0), "rod": told}
    return Frames(plain(header), arrays)


def _forces(blow: Blow, times: Array, end: float) -> dict[str, npt.NDArray[Any]]:
    """The forces at the face and on the rock until the end, and at which of the times the faces touch."""
    found: dict[str, npt.NDArray[Any]] = {}
    found["face_t"], found["face_force"] = _curve(blow.face_force, end)
    if blow.bit_force is not None:
        found["rock_t"], found["rock_force"] = _curve(blow.bit_force, end)
    found["touching"] = np.any(
        [(one.start <= times) & (times < (np.inf if one.end is None else one.end)) for one in blow.contacts]
        or [np.zeros(times.size, bool)],
        axis=0,
    )
    return found


def _heading(answer: BlowAnswer, whole: bool) -> dict[str, Any]:
    """What is told of the blow beside the arrays."""
    blow = answer.blow
    return {
        "title": answer.title,
        "units": "SI" if answer.is_si else "dimensionless",
        "notes": list(answer.notes),
        "mean_velocity": blow.mean_velocity_before,
        "velocity_from": answer.speed,
        "energy_before": blow.energy_before,
        "contacts": [[one.start, one.end] for one in blow.contacts[:1000]],
        "gap": blow.target.gap,
        "waves": blow.fineness.value,
        "sentence": blow_sentence(answer) if whole else None,
        "answer": answer.to_json_dict() if whole else None,
    }


def _start(striker: Any, sections: Sections) -> float:
    return _START if isinstance(striker, SizedBody) else _TRANSITS * float(sections.transit.sum())


def _end(blow: Blow, show: Part, sections: Sections) -> float:
    if show == "start":
        return min(blow.until, _start(blow.striker, sections))
    last = None if show == "window" or not blow.contacts else blow.contacts[-1].end
    return blow.until if last is None else min(blow.until, last + _AFTER * float(sections.transit.sum()))


def _body(name: str, cells: CellsOverTime, sections: Sections) -> dict[str, npt.NDArray[Any]]:
    """Stress (force where no areas are known), tension positive, and velocity."""
    area = np.ones(cells.section.size) if sections.area is None else sections.area[cells.section]
    return {f"{name}_edges": cells.edges, f"{name}_stress": -cells.force / area, f"{name}_velocity": cells.velocity}


def _sections(sections: Sections, reach: float) -> dict[str, Any]:
    """Sizes of the sections of a body; an endless one has the length that is shown."""
    return {
        "lengths": np.where(np.isfinite(sections.length), sections.length, reach).tolist(),
        "areas": None if sections.area is None else sections.area.tolist(),
        "impedances": sections.impedance.tolist(),
    }


def _held(answer: BlowAnswer) -> dict[str, Any]:
    """What is at the far end of the rod, and what holds it."""
    from percuss.blow.drilling import joint_turns

    rod = answer.rod
    assert rod is not None
    rock = rod.rock
    numbers = None if rock is None else {"stiffness": rock.stiffness, "ratio": rock.unloading_ratio, "gap": rock.gap}
    turns = {one.at: {"opens": one.opens, "closes": one.closes} for one in joint_turns(answer.blow)}
    return {
        "end": rod.end,
        "bit_mass": rod.bit_mass,
        "rock": numbers,
        "feed": None if rod.feed is None else asdict(rod.feed),
        "joints": [asdict(joint) | turns.get(at, {}) for at, joint in sorted(rod.joint_at.items())],
        "attenuation": list(rod.attenuation),
    }


def _curve(trace: Trace, end: float) -> tuple[Array, Array]:
    """Times and values up to a time, both values at each jump."""
    jumps = trace.times[trace.times < end]
    inside = np.linspace(0.0, end, 1001)
    times = inside if jumps.size > _BREAKS else np.unique(np.concatenate([jumps, inside]))
    return np.repeat(times, 2), np.stack([trace.before(times), trace.at(times)], axis=1).ravel()
