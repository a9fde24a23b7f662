"""A recorded load read as a valve: the implied motion, the edges of the force, ports and delays, the machine."""

from percuss.steady.recorded.force_record import ForceRecord
from percuss.steady.recorded.machines_read import RecordedSwitch
from percuss.steady.recorded.port_and_delay import Interval, PortAndDelay
from percuss.steady.recorded.recorded_valve import RecordedValve, recorded_valve
from percuss.steady.recorded.together import recorded_together

__all__ = [
    "ForceRecord",
    "Interval",
    "PortAndDelay",
    "RecordedSwitch",
    "RecordedValve",
    "recorded_together",
    "recorded_valve",
]
