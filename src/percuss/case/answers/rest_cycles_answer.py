"""The cycles with rest of a case: by their labels, in words and as JSON."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

from percuss.case.case import Case, checked_case
from percuss.steady import rest_cycles

if TYPE_CHECKING:
    from percuss.steady import FoundRestCycles, RestCycle

__all__ = ["is_rest_label", "rest_cycle_dict", "rest_cycles_answer", "rest_cycles_dict"]

_LABEL = re.compile(r"\s*(chatter|rest)\s*/\s*([1-9]\d{0,2})\s*", re.ASCII)


def is_rest_label(label: str) -> bool:
    """Whether a label is one of a cycle with rest.

    Examples
    --------
    >>> is_rest_label("chatter/1"), is_rest_label("rest/2"), is_rest_label("2/1")
    (True, True, False)
    """
    return _LABEL.fullmatch(label) is not None


def rest_cycles_answer(case: Case, *, modes: int | None = None, most: int = 64) -> FoundRestCycles:
    """All cycles of a case in which the bar rests on the wall; see `percuss.steady.rest_cycles`.

    Parameters
    ----------
    case
        A hammer whose load keeps time.
    modes
        N, in the forced motion, too; None for the case's, or 32.
    most
        Load periods of a cycle, 1 to 256.

    Raises
    ------
    CaseError, ResonanceError, ParameterError
        When there is nothing to follow.

    Examples
    --------
    >>> from percuss.case import load_case
    >>> rest_cycles_answer(load_case("pneumatic-jackleg"), modes=0).modes
    0
    """
    checked_case(case)
    return rest_cycles(case.system(), modes=case.simulation().modes if modes is None else modes, most=most)


def rest_cycles_dict(found: FoundRestCycles, label: str) -> dict[str, Any]:
    """The cycles of a label, in the form of the answers of a search for orbits."""
    told = re.sub(r"\s", "", label)
    return {
        "label": told,
        "modes": found.modes,
        "orbits": [rest_cycle_dict(cycle) for cycle in found.labelled(told)],
        "complete": True,
        "halted": False,
        "unseen": 0.0,
        "ended": 0,
        "tries": len(found.releases),
        "sources": {},
        "resonant_modes": [],
        "dropped": {},
    }


def rest_cycle_dict(cycle: RestCycle) -> dict[str, Any]:
    """A cycle with rest."""
    impacts = zip(cycle.phases.tolist(), cycle.speeds.tolist(), strict=True)
    return {
        "label": cycle.label,
        "release_phase": cycle.release_phase,
        "impacts": [{"phase": phase, "speed": speed} for phase, speed in impacts],
        "rest_phase": cycle.rest_phase,
        "flight_times": cycle.flight_times.tolist(),
        "multipliers": [[0.0, 0.0]],
        "stable": cycle.stable,
        "admissible": cycle.admissible,
        "reason": None,
    }
