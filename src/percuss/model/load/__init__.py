"""The load: what pushes, over its period, and where on the body."""

from percuss.model.load.load import MAX_HARMONICS, MOST_STEPS, Jump, Load, Side
from percuss.model.load.oil import GasAccumulator, Join, Oil, OilChamber, Relief
from percuss.model.load.valve import Chamber, Cushion, Port, Supply, Valve
