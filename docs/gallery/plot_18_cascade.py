"""
Down the cascade
================

The motion with one impact in every load period flips: its period doubles, and doubles again. No simulation is needed
to see it: every branch is followed from the flip at which it begins, stable (solid) or not (dashed). The flips come
closer and closer together; the ratios of their distances, on the right, tend to Feigenbaum's number, 4.669.
"""

import matplotlib.pyplot as plt
import numpy as np

from percuss import Load, System
from percuss.explore import follow
from percuss.steady import orbits

system = System(s=20.0, d=0.005, restitution=0.8, load=Load.harmonic(mean=0.95, amplitude=1.0))
branch = follow(orbits(system, 1, modes=0).orbits[-1], "load_factor", (0.79, 0.96), switch=5)

fig, (ax, right) = plt.subplots(1, 2, width_ratios=[3, 1], layout="constrained")
for number, one in enumerate(branch.family()):
    for part, style in ((~one.stable, "--"), (one.stable, "-")):
        shown = part | np.append(part[1:], False)  # up to the next point
        phases = np.where(shown[:, None], one.phases, np.nan)
        lines = ax.plot(one.values, phases, style, color=f"C{number}", linewidth=1.2)
    lines[0].set_label(one.label)
for row in branch.cascade:
    ax.axvline(row.value, color="0.6", linewidth=0.6)
ax.set(xlabel="load factor $p_0/p_1$ (dimensionless)", ylabel="impact phase φ [rad]")
ax.set_title("Six flips, R = 0.8, rigid bar")
ax.legend()
ratios = [row.ratio for row in branch.cascade if row.ratio is not None]
right.plot(range(1, len(ratios) + 1), ratios, "o")
right.axhline(4.669, color="0.6", linewidth=0.8)
right.set(xlabel="flip", ylabel="ratio of intervals (dimensionless)", xticks=range(1, len(ratios) + 1), ylim=(0.0, 8.0))
plt.show()
