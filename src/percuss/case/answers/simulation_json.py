"""A simulation's answer in plain values with the names that other programs read; every number finite or null."""

from __future__ import annotations

import json
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from percuss.case.answers.json_values import body_dict, contact_dict, number, plain, system_dict

if TYPE_CHECKING:
    from percuss.case.answers.simulation_answer import SimulationAnswer

__all__ = ["simulation_dict", "simulation_text"]


def simulation_dict(answer: SimulationAnswer, last: int | None = None) -> dict[str, Any]:
    """The JSON object of an answer: a tree of dict, list, str, bool, int, finite float and None.

    Parameters
    ----------
    last
        The number of last events to keep; None keeps all.
    """
    motion = answer.motion
    return {
        "case": answer.name,
        "title": answer.title,
        "system": system_dict(answer.system),
        "body": body_dict(answer.system),
        "contact": contact_dict(answer.system),
        "history": None if answer.history is None else plain(asdict(answer.history)),
        "notes": list(answer.notes),
        "outcome": motion.outcome,
        "label": motion.label,
        "modes": int(motion.modes),
        "begin_time": number(motion.begin_time),
        "end_time": number(motion.end_time),
        "transient": number(motion.transient),
        "period_unresolved": motion.period_unresolved,
        "warnings": list(answer.warnings),
        "events": _events(answer, last),
        "summary": plain(asdict(motion.summary)),
    }


def _events(answer: SimulationAnswer, last: int | None) -> list[dict[str, Any]]:
    events, system = answer.motion.events, answer.system
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


def simulation_text(answer: SimulationAnswer, last: int | None = None) -> str:
    """The JSON object as text, one line for each event."""
    tree = simulation_dict(answer, last)
    rows = [json.dumps(event, allow_nan=False) for event in tree["events"]]
    text = json.dumps({**tree, "events": []}, indent=1, allow_nan=False)
    # a quote inside a text is written \", so this is the list itself
    return text.replace('"events": []', '"events": [\n  ' + ",\n  ".join(rows) + "\n ]") if rows else text
