"""The whole machine by waves: periods of the load with every contact resolved, which judges the contact laws."""

from percuss.blow.machine.lattice import Lattice
from percuss.blow.machine.wave_motion import (
    Ending,
    Energy,
    Impacts,
    Limits,
    MachineMotion,
    Release,
    Settled,
    Uncertainty,
)
from percuss.blow.machine.wave_running import MachineProgress, machine_motion

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
