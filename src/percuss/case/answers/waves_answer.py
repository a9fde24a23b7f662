"""The answer to "how does this hammer move when every blow is resolved by waves?", beside that of its contact law."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from percuss.case.answers.json_values import heading_dict, plain
from percuss.case.answers.told_motion import ToldMotion
from percuss.case.answers.waves_json import waves_dict
from percuss.case.answers.waves_question import limits_of, release_of, struck_by
from percuss.case.answers.waves_warnings import waves_warnings
from percuss.case.case import checked_case
from percuss.errors import PercussError
from percuss.model.checks import callback, count, flag
from percuss.shown import Shown

if TYPE_CHECKING:
    from percuss.blow.machine import MachineMotion, MachineProgress
    from percuss.case.case import Case
    from percuss.model import System
    from percuss.simulate import Progress, Trajectory
    from percuss.steady import Orbit, TimedOrbit

__all__ = ["Beside", "WavesAnswer", "waves_answer"]


@dataclass(frozen=True)
class Beside(Shown):
    """A settled motion by another law, beside the one by waves.

    Attributes
    ----------
    law
        Its name.
    label
        What it settles on, or None of a steady motion that is computed as such.
    phases, velocities
        Of its impacts in a cycle; radians, and speeds of the rigid motion, dimensionless.
    blow_rate
        Impacts per load period, or None.
    phase_difference, velocity_difference
        Of the motion by waves against it, in radians and relative; None where the two are not of one kind.
    """

    law: str
    label: str | None
    phases: tuple[float, ...]
    velocities: tuple[float, ...]
    blow_rate: float | None
    phase_difference: float | None
    velocity_difference: float | None


@dataclass(frozen=True)
class WavesAnswer(ToldMotion):
    """A motion of a case with every contact resolved by waves.

    Attributes
    ----------
    name, title
        The case as it was named, and its title.
    motion
        The motion by waves.
    law
        The motion by the contact law of the case, from the same start.
    beside
        What the laws say of the settled motion.
    notes
        What was assumed.
    """

    ROWS = "impacts"

    name: str
    title: str
    motion: MachineMotion
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

    def _told(self, last: int | None) -> dict[str, Any]:
        heading = heading_dict(self.name, self.title, self.system, self.notes)
        beside = [plain(asdict(one)) for one in self.beside]
        return {**heading, **waves_dict(self.motion, self.warnings, beside, last)}


def waves_answer(
    case: Case,
    progress: Callable[[MachineProgress | Progress], object] | None = None,
    *,
    quiet: bool = False,
    cells: int = 400,
) -> WavesAnswer:
    """The motion of a case from its start, every contact resolved by waves, beside that of its contact law.

    Parameters
    ----------
    progress
        Called now and then, for both motions; they end as cancelled when it returns something true.
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
    from percuss.blow.machine import machine_motion  # loads the compiler
    from percuss.simulate import run

    checked_case(case)
    callback("progress", progress)
    flag("quiet", quiet), count("cells", cells)
    simulation, system = case.simulation(), case.system()
    start, struck = case.start(simulation.modes), struck_by(case)
    motion = machine_motion(
        system,
        struck.target,
        release_of(start, system),
        limits_of(case),
        pushed_back=struck.pushed_back,
        quiet=quiet,
        cells=cells,
        progress=progress,
    )
    law = run(system, start, modes=simulation.modes, stop=simulation.stop, progress=progress)
    notes = (*case.notes, struck.note) if struck.note else case.notes
    return WavesAnswer(case.file, case.title, motion, law, _beside(case, motion, law), notes)


# -- beside other laws ----------------------------------------------------------------------------------------------


def _beside(case: Case, motion: MachineMotion, law: Trajectory) -> tuple[Beside, ...]:
    found = [_simulated(motion, law)]
    settled = motion.settled
    if settled is None or settled.impacts != 1 or motion.rests:
        return tuple(found)
    from percuss.steady import steady_states, timed_states

    system, timed = motion.system, case.timed_law()
    orbits: tuple[Orbit | TimedOrbit, ...] = ()
    with suppress(PercussError):  # a load that does not push, a mode in resonance: there is no steady motion
        if found[0].phase_difference is None:
            orbits = steady_states(system, settled.periods).orbits
            found += _steady(motion, f"{system.contact.law}, steady", orbits)
        if timed is not None:
            orbits = timed_states(system, timed, settled.periods).orbits
            found += _steady(motion, f"{timed.law}, steady", orbits)
    return tuple(found)


def _steady(motion: MachineMotion, law: str, orbits: Sequence[Orbit | TimedOrbit]) -> list[Beside]:
    """The steady motion whose phase is nearest."""
    own, velocity = float(motion.phases[0]), float(motion.velocities[0])
    nearest = min(orbits, key=lambda orbit: abs(_apart(own, orbit.phase)), default=None)
    if nearest is None:
        return []
    speed, apart = nearest.rigid_velocity, _apart(own, nearest.phase)
    return [Beside(law, None, (nearest.phase,), (speed,), motion.blow_rate, apart, velocity / speed - 1.0)]


def _simulated(motion: MachineMotion, law: Trajectory) -> Beside:
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
