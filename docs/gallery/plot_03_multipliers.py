"""
Multipliers and the unit circle
===============================

A small disturbance of a steady motion is multiplied, from one impact to the next, by numbers in the complex plane. If
all of them are inside the unit circle, the disturbance dies out. Two of these multipliers belong to the motion of the
bar as a whole. One of them starts at +1, in the **fold**; the two move through the plane as the restitution grows,
and one leaves the circle at −1, in the **flip**. The others come from elastic modes, in pairs on the real axis whose
product is nearly −R.
"""

import matplotlib.pyplot as plt
import numpy as np

from percuss import Load, System, steady_states
from percuss.stability import floquet_multipliers

load = Load.harmonic(mean=0.9, amplitude=1.0)
restitution, rigid, elastic = [], [], []
for r in 0.4785 + 0.32 * np.linspace(0.0, 1.0, 161) ** 2:
    orbits = steady_states(System(s=20.0, d=0.0048, restitution=r, load=load)).orbits
    if orbits:
        restitution.append(r)
        rigid.append(floquet_multipliers(orbits[-1], modes=0).values)
        elastic.append(floquet_multipliers(orbits[-1], modes=4).values[np.newaxis])

fig, ax = plt.subplots(figsize=(6.8, 5.2), layout="constrained")
turn = np.linspace(0.0, 2.0 * np.pi, 400)
ax.fill(np.cos(turn), np.sin(turn), color="0.95")
ax.plot(np.cos(turn), np.sin(turn), color="0.3", linewidth=1)
every = np.concatenate(elastic).ravel()
ax.plot(every.real, every.imag, ".", color="0.6", markersize=4, label="with four elastic modes")
pairs = np.array(rigid)
shown = ax.scatter(
    pairs.real, pairs.imag, c=np.repeat(restitution, 2), s=16, cmap="cividis", zorder=3, label="rigid bar"
)
fig.colorbar(shown, label="coefficient of restitution R")
ax.set_aspect("equal")
ax.set(xlim=(-1.3, 1.3), ylim=(-1.1, 1.1), xlabel="Re μ (dimensionless)", ylabel="Im μ (dimensionless)")
ax.annotate("fold", (1.0, 0.0), xytext=(6, 6), textcoords="offset points")
ax.annotate("flip", (-1.0, 0.0), xytext=(-28, 6), textcoords="offset points")
ax.set_title("Multipliers of the later motion, $p_0/p_1$ = 0.9")
fig.legend(loc="outside lower center", ncols=2, frameon=False, markerscale=2)
plt.show()
