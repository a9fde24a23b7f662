"""The whole machine by waves: periods of the load with every contact resolved, which judges the contact laws."""

from percuss.blow.periods.lattice import Lattice
from percuss.blow.periods.repeated import BlowInTrain, Regime, RepeatedBlows, strike_repeatedly
from percuss.blow.periods.wave_motion import Impacts, Uncertainty, WaveEnergy, WaveMotion, run_by_waves

__all__ = [
    "BlowInTrain", "Impacts", "Lattice", "Regime", "RepeatedBlows", "Uncertainty", "WaveEnergy", "WaveMotion",
    "run_by_waves", "strike_repeatedly",
]  # fmt: skip
