"""The whole machine by waves: periods of the load with every contact resolved, which judges the contact laws."""

from percuss.blow.machine.impacts import Impacts
from percuss.blow.machine.lattice import Lattice
from percuss.blow.machine.motion import Energy, MachineMotion, Uncertainty
from percuss.blow.machine.options import Ending, Limits, Release
from percuss.blow.machine.recurrence import Settled
from percuss.blow.machine.running import MachineProgress, machine_motion

__all__ = [
    "Ending",
    "Energy",
    "Impacts",
    "Lattice",
    "Limits",
    "MachineMotion",
    "MachineProgress",
    "Release",
    "Settled",
    "Uncertainty",
    "machine_motion",
]
