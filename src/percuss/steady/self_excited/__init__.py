"""The machine that switches its own valve: cycles, what prevents them, margins; the rigid piston in closed form."""

from percuss.steady.self_excited.blank_blow import BlankBlow, blank_blow
from percuss.steady.self_excited.margins import (
    Sensitivity,
    SlowPressure,
    ValveMargins,
    pressure_over,
    sensitivities,
    slow_pressure,
    valve_margins,
)
from percuss.steady.self_excited.rhythm import Rhythm
from percuss.steady.self_excited.self_switching import Obstacle, SelfExcited, self_excited_motion
from percuss.steady.self_excited.valve_cycle import (
    MachineBlow,
    ModeShare,
    Rebound,
    Ringing,
    Switch,
    Uncovering,
    ValveCycle,
    ValveFlight,
)

__all__ = [
    "BlankBlow",
    "MachineBlow",
    "ModeShare",
    "Obstacle",
    "Rebound",
    "Rhythm",
    "Ringing",
    "SelfExcited",
    "Sensitivity",
    "SlowPressure",
    "Switch",
    "Uncovering",
    "ValveCycle",
    "ValveFlight",
    "ValveMargins",
    "blank_blow",
    "pressure_over",
    "self_excited_motion",
    "sensitivities",
    "slow_pressure",
    "valve_margins",
]
