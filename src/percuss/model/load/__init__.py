"""The load: what pushes, over its period, and where on the body."""

from percuss.model.load.cushion import Cushion
from percuss.model.load.load import Load
from percuss.model.load.periodic_force import MAX_HARMONICS, MOST_STEPS, Jump, Side
from percuss.model.load.supply import Supply
from percuss.model.load.valve import Chamber, Port, Valve

__all__ = ["MAX_HARMONICS", "MOST_STEPS", "Chamber", "Cushion", "Jump", "Load", "Port", "Side", "Supply", "Valve"]
