"""
Where a machine runs, and how hard it strikes
=============================================

A breaker whose piston switches its own valve, over the place of its rear port and the supply pressure. Below 110 bar
the return force does not lift the piston off the tool against the gas; a little above it, the piston does not reach the
port. Where it runs, a port farther back trades rate for energy, and the pressure gives both. Each cell is the cycle of
a rigid piston.
"""

import matplotlib.pyplot as plt
import numpy as np

from percuss.case import CaseFamily, load_case
from percuss.explore import sweep

units = {"load.ports[0].behind": "mm", "load.pressure": "bar"}
family = CaseFamily(load_case("valve-breaker"), units)
axes_of_map = "load.ports[0].behind=60mm:190mm:80", "load.pressure=80bar:200bar:80"
found = sweep(family, *axes_of_map, quantities=["stall", "blow_energy", "rate"], modes=0, workers=1)

place, pressure = (axis.values for axis in found.axes)
words = found.words["stall"]
energy, rate = found["blow_energy"].T / 1e3, 60.0 * found["rate"].T
stopped = np.where(found["stall"].T == 0, np.nan, found["stall"].T)

fig, axes = plt.subplots(layout="constrained")
shades = axes.pcolormesh(place, pressure, energy, shading="nearest", cmap="cividis")
fig.colorbar(shades, label="blow energy [kJ]")
lines = axes.contour(place, pressure, rate, levels=[450, 500, 550, 650, 800], colors="white", linewidths=1.0)
axes.clabel(lines, fmt="%.0f/min")
for number in np.unique(stopped[np.isfinite(stopped)]).astype(int):
    rows, columns = np.nonzero(stopped == number)
    middle = place[int(np.median(columns))], pressure[int(np.median(rows))]
    axes.annotate(words[number], middle, ha="center", va="center", fontsize="small")
axes.set(xlabel="place of the rear port [mm]", ylabel="supply pressure [bar]")
plt.show()
