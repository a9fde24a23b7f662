"""The dispatcher's answer for a recorded load: the machine that may have made it, beside the verdict under a clock."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from percuss.case.answers.machine_answer import MachineAnswer
from percuss.case.answers.recorded_json import recorded_dict
from percuss.case.answers.told_record import ByClock, ToldRecord
from percuss.case.case import checked_case
from percuss.case.file_format.start_and_simulation import DEFAULT_MODES, MAX_MODES
from percuss.model.checks import count, finite, positive
from percuss.stability import stability_of
from percuss.steady import ForceRecord, recorded_valve, self_excited_motion, steady_states
from percuss.steady.recorded.force_record import load_phases

if TYPE_CHECKING:
    import numpy.typing as npt

    from percuss.case.case import Case
    from percuss.model import System
    from percuss.steady import RecordedValve

__all__ = ["ByClock", "RecordedAnswer", "recorded_answer"]

_SAME = 0.3  # rad: a root farther from the recorded blow is another motion


@dataclass(frozen=True)
class RecordedAnswer(ToldRecord):
    """A recorded load read as a valve.

    Attributes
    ----------
    read
        The switches, ports and delays.
    clock
        The verdict on the recorded motion for a load that keeps time by itself.
    answer
        How the machine of the best reading runs.
    """

    def to_json_dict(self) -> dict[str, Any]:
        """The answer in plain values, as `percuss machine --json` prints it for a recorded load."""
        return recorded_dict(self)


def recorded_answer(
    case: Case,
    modes: int | None = None,
    *,
    blow: float | None = None,
    blows: npt.ArrayLike | None = None,
    longest_delay: float | None = None,
) -> RecordedAnswer:
    """Read the load of a case, a recording or steps, as that of a machine whose valve the piston works.

    Parameters
    ----------
    modes
        Elastic modes of the machine's cycle; 32 by default, 0 for a rigid piston.
    blow
        A time (s, on the clock of the recording) at which the piston struck. Of the motions that the load allows, the
        one that strikes nearest is taken; by default the one that strikes nearest to the fall of the force.
    blows
        The times of all blows (s), where they were measured: then every cycle is read by itself, and the restitution
        with it.
    longest_delay
        The longest delay that the valve may have: s, or dimensionless with the case.

    Raises
    ------
    CaseError
        When the recording cannot be read or used, or the piston itself switches the load.
    LoadError
        When the load does not push, or does not switch.

    Examples
    --------
    >>> from percuss.case import Case
    >>> case = Case.from_text('''
    ... [system]
    ... s = 50.0
    ... d = 0.0
    ... restitution = 0.2
    ... [load]
    ... kind = "square"
    ... amplitude = 1.0
    ... kappa = 1.2
    ... ''')
    >>> answer = recorded_answer(case, modes=0)
    >>> answer.clock.exists, [switch.to for switch in answer.read.switches]
    (False, ['power', 'return'])
    """
    checked_case(case)
    kept = DEFAULT_MODES if modes is None else count("modes", modes, least=0, most=MAX_MODES)
    longest = None if longest_delay is None else positive("longest_delay", longest_delay)
    system, samples = case.system(), case.recorded_force
    record, phase = None, None
    if samples is not None:
        record = ForceRecord(*samples, blows)
        if blow is not None:
            phase = _phase_at(system, record, finite("blow", blow))
    elif blow is not None:
        phase = finite("blow", blow) * (system.angular_frequency if system.is_si else 1.0)
    read = recorded_valve(system, blow=phase, record=record, longest_delay=longest)
    motion = self_excited_motion(read.machine, modes=kept)
    rigid = motion if kept == 0 else self_excited_motion(read.machine, modes=0)
    answer = MachineAnswer(case.file, case.title, motion, rigid, (*_read_notes(case), *read.notes))
    return RecordedAnswer(read, _by_clock(read), answer)


def _phase_at(system: System, record: ForceRecord, time: float) -> float:
    """The phase of the load at a time of its recording."""
    phases = load_phases(system, record)
    return float(np.interp(time, record.time, phases) % (2.0 * math.pi))


def _read_notes(case: Case) -> tuple[str, ...]:
    """What was assumed in reading the recording, but for what a clock would say."""
    return tuple(note for note in case.notes if "as a valve does" not in note)


def _by_clock(read: RecordedValve) -> ByClock:
    orbits = [
        orbit
        for orbit in steady_states(read.system).orbits
        if abs(math.remainder(orbit.phase - read.phase, 2.0 * math.pi)) < _SAME
    ]
    if not orbits:
        return ByClock(False, None, None)
    orbit = min(orbits, key=lambda one: abs(math.remainder(one.phase - read.phase, 2.0 * math.pi)))
    judged = stability_of(orbit)
    values = judged.multipliers.values[list(judged.multipliers.rigid)]
    return ByClock(orbit.admissible, judged.stable, complex(values[np.argmax(np.abs(values))]))
