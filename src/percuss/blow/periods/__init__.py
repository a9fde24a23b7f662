"""The whole machine by waves: periods of the load with every contact resolved, which judges the contact laws."""

from percuss.blow.periods.lattice import Lattice
from percuss.blow.periods.repeated import BlowInTrain, Regime, RepeatedBlows, strike_repeatedly
from percuss.blow.periods.valve_waves import ValveWaves, run_valve_by_waves
from percuss.blow.periods.wave_motion import Impacts, Uncertainty, WaveEnergy, WaveMotion, run_by_waves

__all__ = [
    "BlowInTrain", "Impacts", "Lattice", "Regime", "RepeatedBlows", "Uncertainty", "ValveWaves", "WaveEnergy",
    "WaveMotion", "run_by_waves", "run_valve_by_waves", "strike_repeatedly",
]  # fmt: skip
