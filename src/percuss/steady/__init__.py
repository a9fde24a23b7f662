"""Closed-form steady motions: all phases, the orbit and its fields, admissibility, energy, rest, SI figures."""

from percuss.steady.admissible import Violation
from percuss.steady.drag import Drag, drag_of, greatest_drag
from percuss.steady.energy import Energy
from percuss.steady.full_rebound import grows
from percuss.steady.harmonic import Field
from percuss.steady.impact_state import ModalState
from percuss.steady.level import level
from percuss.steady.orbit import Orbit
from percuss.steady.periodic import (
    Drop,
    FoundOrbits,
    PeriodicOrbit,
    orbit_near,
    orbits,
    parameter_column,
    time_rates,
)
from percuss.steady.reason import Reason
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
from percuss.steady.rest import Rest, rest_on_wall
from percuss.steady.resting import FoundRestCycles, RestCycle, rest_cycles
from percuss.steady.self_excited import (
    BlankBlow,
    ElasticCycle,
    Obstacle,
    Rhythm,
    RigidCycle,
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
from percuss.steady.si import SIReport, si_report
from percuss.steady.states import Nearest, SteadyStates, steady_states
from percuss.steady.timed_orbit import TimedOrbit
from percuss.steady.timed_states import TimedStates, timed_states

__all__ = [
    "BlankBlow",
    "Drag",
    "Drop",
    "ElasticCycle",
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
    "RigidCycle",
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
