"""What a case says of its machine by waves: what is struck, where the striker starts, when to end."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from percuss.case.answers.numerals import number
from percuss.model import Contact, System
from percuss.model.body import SteppedBar

if TYPE_CHECKING:
    from percuss.blow import Rod, Wall
    from percuss.blow.machine import Limits, Release
    from percuss.case.case import Case
    from percuss.simulate import Start

__all__ = ["Struck", "limits_of", "release_of", "struck_by"]

_TURN = 2.0 * math.pi
_PERIODS = 200  # after which a machine ends that nobody wants for a certain time


class Struck(NamedTuple):
    """What a machine strikes, whether that is pushed back after a blow, and what was assumed of it."""

    target: Rod | Wall
    pushed_back: bool
    note: str


def struck_by(case: Case) -> Struck:
    """The tool of a case as a machine by waves can have it.

    Raises
    ------
    CaseError
        When the tables of the tool cannot be used.
    """
    from percuss.blow import Wall

    tables, system = case.tables, case.system()
    contact = getattr(tables, "contact", None) or getattr(tables, "system", None)
    tool = case.tool()
    pushed_back = getattr(contact, "advance", None) == "pushed back" or getattr(tool, "end", None) == "free"
    if isinstance(tool, Wall) and tables.tool is None and not system.contact.is_lossless:
        return Struck(_rod_of(system), pushed_back, _note_of(system.contact))
    return Struck(tool, pushed_back, "")


def _note_of(contact: Contact) -> str:
    return (
        f"there is no [tool]: what is struck is an endless rod of {number(1.0 / contact.impedance_ratio)} times the "
        f"impedance of the striking end, which gives a uniform bar the restitution {number(contact.restitution)}"
    )


def _rod_of(system: System) -> Rod:
    """The endless rod whose impedance gives a uniform bar the restitution: R = (Z_rod − Z)/(Z_rod + Z)."""
    from percuss.blow import Rod

    body = system.body
    own = float(body.sections.impedance[-1]) if isinstance(body, SteppedBar) else body.s
    scale = 1.0 if system.bar is None else system.bar.mass * system.angular_frequency
    return Rod.of_impedance(own * scale / system.contact.impedance_ratio)


def release_of(start: Start, system: System) -> Release:
    """The start as a rigid motion: the place of the striking end, the mean velocity, the phase of the load."""
    from percuss.blow.machine import Release

    place, velocity = start.gap, start.velocity[0]
    if start.source is not None or start.profile is not None or len(start.displacement) > 1:
        modes = len(start.displacement) - 1
        if start.source is not None:
            velocity += system.contact.velocity_factor * start.source.rigid_velocity
        gamma = system.body.modes(modes, system.load.at).gamma if modes else np.zeros(0)
        place = start.displacement[0] + float(gamma @ np.array(start.displacement[1:])) if place is None else place
    return Release(max(0.0, -(0.0 if place is None else place)), velocity, start.time)


def limits_of(case: Case) -> Limits:
    """When to end: what [simulation] says; without a time after 200 load periods."""
    from percuss.blow.machine import Limits

    table, stop = case.tables.simulation, case.simulation().stop
    periods = _PERIODS if stop.time is None else max(1, math.ceil(stop.time / _TURN))
    given = None if table is None else table.tolerance
    tolerance = Limits.tolerance if given is None else given
    return Limits(min(periods, 10**6), max(1, min(stop.most_impacts, 10**6)), stop.periodic, max(tolerance, 1e-12))
