"""The machine that switches its own valve: cycles, what prevents them, margins; the rigid piston in closed form."""

from percuss.steady.self_excited.blank_blow import BlankBlow, blank_blow
from percuss.steady.self_excited.elastic_chain import Rhythm
from percuss.steady.self_excited.elastic_cycle import ElasticCycle
from percuss.steady.self_excited.margins import (
    Sensitivity,
    SlowPressure,
    ValveMargins,
    pressure_over,
    sensitivities,
    slow_pressure,
    valve_margins,
)
from percuss.steady.self_excited.piston_legs import Leg, Rebound, Segment, Switch, Uncovering
from percuss.steady.self_excited.rigid_cycle import Blow, ModeShare, RigidCycle, Ringing, ValveCycle
from percuss.steady.self_excited.self_switching import Obstacle, SelfExcited, self_excited_motion

__all__ = [
    "BlankBlow",
    "Blow",
    "ElasticCycle",
    "Leg",
    "ModeShare",
    "Obstacle",
    "Rebound",
    "Rhythm",
    "RigidCycle",
    "Ringing",
    "Segment",
    "SelfExcited",
    "Sensitivity",
    "SlowPressure",
    "Switch",
    "Uncovering",
    "ValveCycle",
    "ValveMargins",
    "blank_blow",
    "pressure_over",
    "self_excited_motion",
    "sensitivities",
    "slow_pressure",
    "valve_margins",
]
