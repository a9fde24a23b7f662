"""A blow as pictures in time: stresses along striker and rod, the force between the faces, and where the energy is."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
import numpy.typing as npt

from percuss.case.answers.blow_answer import BlowAnswer, blow_answer, blow_in_words
from percuss.case.answers.motion_frames import Frames
from percuss.case.answers.numerals import plain
from percuss.model.body import SizedBody
from percuss.model.checks import Array

if TYPE_CHECKING:
    from percuss.blow import Blow, Trace
    from percuss.blow.bodies import Sections
    from percuss.blow.over_time import CellsOverTime
    from percuss.case.case import Case

Part = Literal["start", "contact", "window"]
"""What is shown: the first 300 µs (6 transit times of a dimensionless striker), until it has parted, or all of it."""

_START = 300e-6
_TRANSITS = 6.0
_AFTER = 2.0
"""Transit times of the striker that are shown after the last contact."""

_BREAKS = 4000
"""Jumps of a force that are drawn as such."""

_REACH = 2.0
"""Of an endless rod: lengths of the striker that are shown."""


def blow_frames(
    case: Case,
    show: Part = "start",
    *,
    frames: int = 181,
    cells: int = 120,
    whole: bool = True,
    most_pieces: int | None = None,
) -> Frames:
    """The blow of a case, in SI or in the scales of a dimensionless bar; about so many instants, and places of a body.

    Without `whole` the start of a blow is followed no further than it is shown, and has no answer. Lengths of a
    dimensionless rod are those of one with the wave speed of the striking end.
    """
    from percuss.blow.bodies import rod_sections, striker_sections
    from percuss.blow.over_time import cells_over_time, energy_over_time

    until = None if whole or show != "start" else _shortened(case)
    answer = blow_answer(case, until=until, most_pieces=most_pieces)
    blow = answer.blow
    sections = striker_sections(blow.striker)
    end = _end(blow, show, sections)
    times = np.linspace(0.0, end, frames)
    reach = _REACH * float(sections.length.sum() if answer.is_si else sections.transit.sum())
    own, rod = cells_over_time(blow, times, cells, reach)
    energy = energy_over_time(blow, times)
    arrays: dict[str, npt.NDArray[Any]] = {"t": times, **_body("striker", own, sections)}
    told = None
    if rod is not None and answer.rod is not None:
        struck = rod_sections(answer.rod, blow.striker)
        if not answer.is_si:  # places along it are times of a wave: lengths with the speed of waves in the striking end
            speed = float(sections.speed[-1])
            rod, reach = replace(rod, edges=speed * rod.edges), speed * reach
        arrays |= _body("rod", rod, struck)
        told = {**_sections(struck, reach), **_far_end(answer)}
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
        "sentence": blow_in_words(answer) if whole else None,
        "answer": answer.to_json_dict() if whole else None,
    }


def _shortened(case: Case) -> float:
    """The end of the window when only the start is asked for."""
    from percuss.blow.bodies import striker_sections

    question = case.blow_question()
    short = _start(question.striker, striker_sections(question.striker))
    return short if question.until is None else min(short, question.until)


def _start(striker: Any, sections: Sections) -> float:
    return _START if isinstance(striker, SizedBody) else _TRANSITS * float(sections.transit.sum())


def _end(blow: Blow, show: Part, sections: Sections) -> float:
    """The end of what is shown."""
    if show == "start":
        return min(blow.until, _start(blow.striker, sections))
    last = None if show == "window" or not blow.contacts else blow.contacts[-1].end
    return blow.until if last is None else min(blow.until, last + _AFTER * float(sections.transit.sum()))


def _body(name: str, cells: CellsOverTime, sections: Sections) -> dict[str, npt.NDArray[Any]]:
    """Stress (force where no areas are known), tension positive, and velocity."""
    area = np.ones(cells.section.size) if sections.area is None else sections.area[cells.section]
    return {
        f"{name}_edges": cells.edges,
        f"{name}_stress": -cells.force / area,
        f"{name}_velocity": cells.velocity,
    }


def _sections(sections: Sections, reach: float) -> dict[str, Any]:
    """Sizes of the sections of a body; an endless one has the length that is shown."""
    return {
        "lengths": np.where(np.isfinite(sections.length), sections.length, reach).tolist(),
        "areas": None if sections.area is None else sections.area.tolist(),
        "impedances": sections.impedance.tolist(),
    }


def _far_end(answer: BlowAnswer) -> dict[str, Any]:
    rod = answer.rod
    assert rod is not None
    rock = rod.rock
    numbers = None if rock is None else {"stiffness": rock.stiffness, "ratio": rock.unloading_ratio, "gap": rock.gap}
    return {"end": rod.end, "bit_mass": rod.bit_mass, "rock": numbers}


def _curve(trace: Trace, end: float) -> tuple[Array, Array]:
    """Times and values up to a time, both values at each jump."""
    jumps = trace.times[trace.times < end]
    inside = np.linspace(0.0, end, 1001)
    times = inside if jumps.size > _BREAKS else np.unique(np.concatenate([jumps, inside]))
    return np.repeat(times, 2), np.stack([trace.before(times), trace.at(times)], axis=1).ravel()
