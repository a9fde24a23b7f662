"""
Which starts run, which stall
=============================

The piston of this machine switches its own valve, and a spring of gas pushes it toward the wall. Every point of the
picture is a start: where the piston is, and how fast. From most starts the machine finds its rhythm; from others the
piston swings on the gas and never comes to the port that would switch the valve. The white line is the energy that
just takes the piston from a state of return to the port, at the position −1.
"""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.colors import ListedColormap

from percuss.explore import basins
from percuss.model import Chamber, Kept, Machine, Port, UniformBar, Valve

ports = [Port("power", behind=1.0, side="back"), Port("return", on="impact")]
stiffness, back = 1.2, 0.3
valve = Valve({"return": -back, "power": 1.0}, ports, chamber=Chamber(stiffness=stiffness))
machine = Machine(UniformBar(20.0), valve, Kept(0.5))
found = basins(machine, ("position", -1.4, -0.004, 160), ("velocity", -2.5, 2.5, 140), workers=1, modes=0)

fig, ax = plt.subplots(layout="constrained")
runs = np.char.startswith(found.label, "runs")
ax.pcolormesh(found.x[1], found.y[1], runs, cmap=ListedColormap(["#D8D8D8", "#56B4E9"]), rasterized=True)
place = np.linspace(-1.0, 0.0, 200)
speed = np.sqrt(np.maximum(stiffness * (1.0 - place**2) - 2.0 * back * (1.0 + place), 0.0))
ax.plot(place, -speed, color="white")
ax.set(xlabel="position of the piston at the start", ylabel="velocity at the start, positive toward the wall")
ax.set_title(f"{runs.mean():.0%} of these starts run (blue); the others stall in the chamber")
plt.show()
