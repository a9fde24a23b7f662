"""Branches of cycles with rest over a parameter: all cycles at some values of it, followed, each branch once."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from percuss.errors import PercussError
from percuss.explore.continuation.rest_following import follow_rest_cycle
from percuss.explore.diagrams.rest_lines import DiagramRestBranch, rest_line_of
from percuss.explore.family import Family
from percuss.halting import halting
from percuss.model import System
from percuss.steady import RestCycle, rest_cycles

__all__ = ["MOST_REST_PERIODS", "rests_traced"]

MOST_REST_PERIODS = 4
"""Load periods of the cycles that are looked for: windows of longer ones are narrow, and take long to follow."""

_POINTS = 33  # over the whole range, at least
_NEAR = 0.05  # rad, within which the releases of two cycles of one label at one value are one


def rests_traced(
    family: Family,
    name: str,
    between: tuple[float, float],
    values: Sequence[float],
    modes: int,
    *,
    stopped: Callable[[], bool],
) -> list[DiagramRestBranch]:
    """All branches of cycles with rest that are met at one of the values; none of what does not rest as a whole.

    Parameters
    ----------
    family, name, between
        The systems, and which parameter is varied in which range.
    values
        Of the parameter, at which cycles are looked for; in the range.
    modes
        N: branches are those of rigid bars, and of structures of one mode.
    stopped
        Whether the answer is no longer wanted.
    """
    found: list[DiagramRestBranch] = []
    for value in values:
        try:
            with halting(stopped):
                system = family.system({name: value})
                known = rest_cycles(system, modes=modes, most=MOST_REST_PERIODS).cycles if _rests(system, modes) else ()
                for cycle in known:
                    if not any(_is_on(line, value, cycle) for line in found):
                        branch = follow_rest_cycle(cycle, name, between, family=family, value=value, points=_POINTS)
                        found.append(rest_line_of(branch))
        except PercussError:  # there is no such system, its load does not push, or nobody waits any longer
            if stopped():
                break
    return found


def _rests(system: System, modes: int) -> bool:
    """Whether the branches are few: after each touch an elastic bar goes on otherwise. With R = 1 no chatter ends."""
    return modes == (0 if system.body.is_free else 1) and system.contact.velocity_factor > -1.0


def _is_on(line: DiagramRestBranch, value: float, cycle: RestCycle) -> bool:
    """Whether a branch has a cycle: the phase at which the bar is let go tells all that follows."""
    release = line.release_at(value) if line.label == cycle.label else None
    return release is not None and abs(float(np.angle(np.exp(1j * (release - cycle.release_phase))))) < _NEAR
