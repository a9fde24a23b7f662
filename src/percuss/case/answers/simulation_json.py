"""A simulated motion in plain values with the names that other programs read; every number finite or null."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from percuss.case.answers.json_values import number, plain

if TYPE_CHECKING:
    from percuss.simulate import Trajectory

__all__ = ["motion_dict"]


def motion_dict(motion: Trajectory, warnings: Sequence[str], last: int | None = None) -> dict[str, Any]:
    """The JSON object of a motion: a tree of dict, list, str, bool, int, finite float and None.

    Parameters
    ----------
    last
        The number of last events to keep; None keeps all.
    """
    return {
        "outcome": motion.outcome,
        "label": motion.label,
        "modes": int(motion.modes),
        "begin_time": number(motion.begin_time),
        "end_time": number(motion.end_time),
        "transient": number(motion.transient),
        "period_unresolved": motion.period_unresolved,
        "warnings": list(warnings),
        "events": _events(motion, last),
        "summary": plain(asdict(motion.summary)),
    }


def _events(motion: Trajectory, last: int | None) -> list[dict[str, Any]]:
    events, system = motion.events, motion.system
    part = events if last is None else events[max(len(events) - last, 0) :]
    seconds = system.time_scale if system.is_si else None
    return [
        {
            "kind": event.kind,
            "time": number(event.time),
            "time_s": None if seconds is None else number(event.time * seconds),
            "phase": number(event.phase),
            "impact_velocity": number(event.impact_velocity),
            "rebound_velocity": number(event.rebound_velocity),
            "energy_lost": number(event.energy_lost),
            "resolved": int(event.resolved),
        }
        for event in part
    ]
