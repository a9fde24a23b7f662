"""Closed-form steady motions: all phases, the orbit and its fields, admissibility, energy, rest, SI figures."""

from percuss.steady.admissible import Violation
from percuss.steady.energy import Energy
from percuss.steady.harmonic import Field
from percuss.steady.impact_state import ModalState
from percuss.steady.level import level
from percuss.steady.orbit import Orbit
from percuss.steady.rest import Rest, rest_on_wall
from percuss.steady.si import SIReport, si_report
from percuss.steady.states import Nearest, SteadyStates, steady_states

__all__ = [
    "Energy",
    "Field",
    "ModalState",
    "Nearest",
    "Orbit",
    "Rest",
    "SIReport",
    "SteadyStates",
    "Violation",
    "level",
    "rest_on_wall",
    "si_report",
    "steady_states",
]
