"""
The road below the flip
=======================

As the load factor decreases, the motion with one impact in every period loses its stability: two impacts of different
phase alternate, then four, and at last no two impacts are alike. Every dot is an impact of a settled simulation; each
simulation starts where the one before it ended. The vertical line is the flip according to the theory, without any
simulation.
"""

import matplotlib.pyplot as plt
import numpy as np

from percuss import Load, Start, Stop, System, run, steady_states
from percuss.explore import boundaries

system = System(s=1e3, d=0.0, restitution=0.6, load=Load.harmonic(mean=1.0, amplitude=1.0))
edges = boundaries(system, ("restitution", [0.6]), ("load_factor", 0.0, 3.0), kinds=("flip",))
flip = edges.greatest("flip")[0]

load_factors = np.linspace(0.80, 0.58, 500)
orbit = steady_states(system.with_load_factor(load_factors[0])).orbits[-1]
start = Start.rigid(position=0.0, velocity=orbit.rebound_velocity, time=orbit.phase + 1e-3)
dots = []
for load_factor in load_factors:
    motion = run(system.with_load_factor(load_factor), start, modes=0, stop=Stop(impacts=800, periodic=False))
    last = motion.events[-1]
    start = Start.rigid(position=0.0, velocity=last.rebound_velocity, time=last.phase)
    dots += [(load_factor, event.phase) for event in motion.events[-64:] if event.kind == "impact"]

fig, ax = plt.subplots(layout="constrained")
ax.plot(*np.transpose(dots), ".", color="C0", markersize=1.5, markeredgewidth=0, rasterized=True)
ax.axvline(flip, color="C1", linewidth=1.5)
ax.annotate(f"flip at {flip:.4f}", (flip, 1.0), xytext=(5, 0), textcoords="offset points", color="C1")
ax.set(xlabel="load factor $p_0/p_1$ (dimensionless)", ylabel="impact phase φ [rad]")
ax.set_title("Impact phases of settled motions, R = 0.6, rigid bar")
plt.show()
