r"""
Two motions for one load
========================

At which moment of the load can the bar strike? Momentum must balance over a period, and this condition usually allows
two impact phases :math:`\varphi`. The two branches meet in a **fold**, and beyond it the mean load is too large for a
motion with one impact in every period. The upper branch is stable over a part of its length, the lower one nowhere.
"""

import matplotlib.pyplot as plt
import numpy as np

from percuss import Load, System
from percuss.explore import boundaries
from percuss.stability import stability_plane

pneumatic = System(s=1e3, d=0.0, restitution=0.6, load=Load.harmonic(mean=1.0, amplitude=1.0))
restitution, load_factor = 0.6, np.linspace(0.01, 1.35, 1500)

found = stability_plane(pneumatic, restitution, load_factor)  # .phase[branch, load factor]
edges = boundaries(pneumatic, ("restitution", [restitution]), ("load_factor", 0.0, 2.0), kinds=("fold", "flip"))
fold, flip = edges.greatest("fold")[0], edges.greatest("flip")[0]

fig, ax = plt.subplots(layout="constrained")
for phase, stable in zip(found.phase, found.stable, strict=True):
    ax.plot(load_factor, np.where(stable, phase, np.nan), color="C0", linewidth=2.5)
    ax.plot(load_factor, np.where(stable, np.nan, phase), color="C1", linestyle="--")
ax.plot([], [], color="C0", linewidth=2.5, label="stable")
ax.plot([], [], color="C1", linestyle="--", label="unstable")
ax.plot(fold, np.pi / 2, "ko")
ax.annotate("fold", (fold, np.pi / 2), xytext=(8, -4), textcoords="offset points")
ax.axvline(flip, color="0.6", linewidth=1, linestyle=":")
ax.annotate("flip: the period doubles", (flip, 0.15), xytext=(6, 0), textcoords="offset points", color="0.3")
ax.set(xlim=(0, 1.5), ylim=(0, np.pi), xlabel="load factor $p_0/p_1$ (dimensionless)", ylabel="impact phase φ [rad]")
ax.set_yticks([0, np.pi / 4, np.pi / 2, 3 * np.pi / 4, np.pi], ["0", "π/4", "π/2", "3π/4", "π"])
ax.set_title(f"Impact phase of a pneumatic hammer, R = {restitution}")
ax.legend(loc="upper right", frameon=False)
plt.show()
