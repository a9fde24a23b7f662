"""
Stress waves in space and time
==============================

The strain along a soft bar between two impacts under a square-wave load. Each switch of the load, and the impact at
time 0, sends fronts along the bar; the dashed line is a path with the wave speed s. A front is reflected from the
free struck end with the opposite sign, and the strain there is always 0.
"""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.colors import LinearSegmentedColormap

from percuss import Load, System, palette, steady_states

system = System(s=1.3, d=0.05, restitution=0.2, load=Load.square(amplitude=1.0, kappa=1.2))
orbit = steady_states(system).orbits[0]
place, time = np.linspace(0.0, 1.0, 161), np.linspace(0.0, orbit.period, 901)[1:-1]
strain = orbit.strain(place, time)

fig, ax = plt.subplots(figsize=(7.2, 3.9), layout="constrained")
limit = np.abs(strain).max()
blue_orange = LinearSegmentedColormap.from_list("strain", [stop.light for stop in palette.STRAIN])
image = ax.pcolormesh(time, place, strain, cmap=blue_orange, vmin=-limit, vmax=limit, rasterized=True)
switch = (system.load.jumps[1].phase - orbit.phase) % (2.0 * np.pi)
ax.plot(switch + np.arange(4) / system.s, [0.0, 1.0, 0.0, 1.0], color="k", linewidth=1, linestyle="--")
ax.annotate("load switches", (switch, 0.0), xytext=(-6, 5), textcoords="offset points", ha="right")
fig.colorbar(image, label=f"strain $u_x$ (scaled), {palette.SIGN}")
ax.set(xlabel="time after the impact [rad of the load]", ylabel="place along the bar [bar lengths]")
ax.set_yticks([0.0, 0.5, 1.0], ["0 driven", "0.5", "1 struck"])
ax.set_title("Strain between two impacts, s = 1.3")
plt.show()
