"""Closed-form steady motions: all phases, the orbit and its fields, admissibility, energy, rest, SI figures."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

from percuss.steady.admissible import Violation
from percuss.steady.energy import Energy
from percuss.steady.figures import SIReport, si_report
from percuss.steady.forced import Field
from percuss.steady.orbit import Orbit, Reason
from percuss.steady.oscillator import ModalState
from percuss.steady.phases import grows, level
from percuss.steady.rest import Rest, rest_on_wall
from percuss.steady.states import Drag, Nearest, SteadyStates, drag_of, greatest_drag, steady_states
from percuss.steady.timed_states import TimedOrbit, TimedStates, timed_states

if TYPE_CHECKING:
    from percuss.steady.periodic import (
        Drop,
        FoundOrbits,
        PeriodicOrbit,
        orbit_near,
        orbits,
        parameter_column,
        time_rates,
    )
    from percuss.steady.recorded import (
        ForceRecord,
        Interval,
        PortAndDelay,
        Reading,
        RecordedSwitch,
        RecordedValve,
        recorded_together,
        recorded_valve,
    )
    from percuss.steady.resting import FoundRestCycles, RestCycle, rest_cycles
    from percuss.steady.self_excited import (
        BlankBlow,
        Obstacle,
        Rhythm,
        SelfExcited,
        Sensitivity,
        SlowPressure,
        ValveCycle,
        ValveMargins,
        blank_blow,
        pressure_over,
        self_excited_motion,
        sensitivities,
        slow_pressure,
        valve_margins,
    )

__all__ = [
    "BlankBlow",
    "Drag",
    "Drop",
    "Energy",
    "Field",
    "ForceRecord",
    "FoundOrbits",
    "FoundRestCycles",
    "Interval",
    "ModalState",
    "Nearest",
    "Obstacle",
    "Orbit",
    "PeriodicOrbit",
    "PortAndDelay",
    "Reading",
    "Reason",
    "RecordedSwitch",
    "RecordedValve",
    "Rest",
    "RestCycle",
    "Rhythm",
    "SIReport",
    "SelfExcited",
    "Sensitivity",
    "SlowPressure",
    "SteadyStates",
    "TimedOrbit",
    "TimedStates",
    "ValveCycle",
    "ValveMargins",
    "Violation",
    "blank_blow",
    "drag_of",
    "greatest_drag",
    "grows",
    "level",
    "orbit_near",
    "orbits",
    "parameter_column",
    "pressure_over",
    "recorded_together",
    "recorded_valve",
    "rest_cycles",
    "rest_on_wall",
    "self_excited_motion",
    "sensitivities",
    "si_report",
    "slow_pressure",
    "steady_states",
    "time_rates",
    "timed_states",
    "valve_margins",
]

_ROOMS = {
    "periodic": ("Drop", "FoundOrbits", "PeriodicOrbit", "orbit_near", "orbits", "parameter_column", "time_rates"),
    "recorded": (
        "ForceRecord",
        "Interval",
        "PortAndDelay",
        "Reading",
        "RecordedSwitch",
        "RecordedValve",
        "recorded_together",
        "recorded_valve",
    ),
    "resting": ("FoundRestCycles", "RestCycle", "rest_cycles"),
    "self_excited": (
        "BlankBlow",
        "Obstacle",
        "Rhythm",
        "SelfExcited",
        "Sensitivity",
        "SlowPressure",
        "ValveCycle",
        "ValveMargins",
        "blank_blow",
        "pressure_over",
        "self_excited_motion",
        "sensitivities",
        "slow_pressure",
        "valve_margins",
    ),
}


def __getattr__(name: str) -> object:
    """The names of the larger rooms when they are first used: a motion with one impact needs none of them."""
    room = next((room for room, names in _ROOMS.items() if name in names), None)
    if room is None:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{room}"), name)


def __dir__() -> list[str]:
    return sorted(__all__)
