"""The machine that switches its own valve: cycles, what prevents them, margins; the rigid piston in closed form."""

from percuss.steady.self_excited.blank_blow import BlankBlow, blank_blow
from percuss.steady.self_excited.elastic_cycle import Blow, ElasticCycle
from percuss.steady.self_excited.margins import ValveMargins, valve_margins
from percuss.steady.self_excited.obstacle import Obstacle
from percuss.steady.self_excited.piston_records import Leg, Rebound, Segment, Switch, Uncovering
from percuss.steady.self_excited.rhythm import Rhythm
from percuss.steady.self_excited.rigid_cycle import RigidCycle
from percuss.steady.self_excited.ringing import ModeShare, Ringing
from percuss.steady.self_excited.self_switching import SelfExcited, self_excited_motion
from percuss.steady.self_excited.sensitivity import Sensitivity, sensitivities
from percuss.steady.self_excited.slow_pressure import SlowPressure, pressure_over, slow_pressure
from percuss.steady.self_excited.valve_cycle import ValveCycle

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
