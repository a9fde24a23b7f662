"""The whole machine by waves: periods of the load with every contact resolved, which judges the contact laws."""

from percuss.blow.periods.lattice import Lattice
from percuss.blow.periods.wave_motion import Impacts, Uncertainty, WaveEnergy, WaveMotion, run_by_waves

__all__ = ["Impacts", "Lattice", "Uncertainty", "WaveEnergy", "WaveMotion", "run_by_waves"]
