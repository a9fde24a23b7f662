"""A recorded load read as a valve: the implied motion, the edges of the force, ports and delays, the machine."""

from percuss.steady.recorded.force_record import ForceRecord
from percuss.steady.recorded.recorded_valve import (
    Interval,
    PortAndDelay,
    Reading,
    RecordedSwitch,
    RecordedValve,
    recorded_together,
    recorded_valve,
)

__all__ = [
    "ForceRecord",
    "Interval",
    "PortAndDelay",
    "Reading",
    "RecordedSwitch",
    "RecordedValve",
    "recorded_together",
    "recorded_valve",
]
