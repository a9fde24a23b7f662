"""
Where a hammer runs
===================

The plane of restitution and load factor has three regions. Above the fold there is no motion with one impact in every
load period; below the flip there is one, but its period doubles; between the two curves the hammer runs. Every point
of the curves is solved for as a root, so no grid is needed.
"""

import matplotlib.pyplot as plt
import numpy as np

from percuss import Load, System
from percuss.explore import boundaries

pneumatic = System(s=1e3, d=0.0, restitution=0.0, load=Load.harmonic(mean=1.0, amplitude=1.0))
restitution = np.linspace(0.0, 0.9, 91)
edges = boundaries(pneumatic, ("restitution", restitution), ("load_factor", 0.0, 10.0), kinds=("fold", "flip"))
fold, flip = edges.greatest("fold"), edges.greatest("flip")

fig, ax = plt.subplots(layout="constrained")
ax.fill_between(restitution, fold, 3.0, color="0.93")
ax.fill_between(restitution, flip, fold, color="C0", alpha=0.18, linewidth=0)
ax.fill_between(restitution, 0.0, flip, color="C4", alpha=0.18, linewidth=0)
ax.plot(restitution, fold, color="C0", linewidth=2, label="fold: two motions meet and vanish")
ax.plot(restitution, flip, color="C1", linewidth=2, label="flip: the period doubles")
for text, place in (("no such motion", (0.28, 1.5)), ("runs", (0.72, 1.35)), ("exists, does not last", (0.62, 0.25))):
    ax.text(*place, text, ha="center", fontsize=12)
ax.set(xlim=(0, 0.9), ylim=(0, 2.2), xlabel="coefficient of restitution R", ylabel="load factor $p_0/p_1$")
ax.set_title("One impact in every load period, pneumatic hammer")
ax.legend(loc="upper left", frameon=False)
plt.show()
