"""
Four motions for one hammer
===========================

The motion on which the bar settles can depend on how it starts. Every point of the picture is a start on the wall,
given by the phase of the load and the velocity of the bar; its colour is the motion that the bar settles on. The
label ``z=p/n`` stands for a motion with p impacts in n load periods.
"""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.colors import BoundaryNorm, ListedColormap

from percuss import Load, System
from percuss.explore import basins
from percuss.palette import FAMILIES, family_of

system = System(s=20.0, d=0.0, restitution=0.8, load=Load.harmonic(mean=1.2, amplitude=1.0))
found = basins(system, ("time", 0.0, 2.0 * np.pi, 240), ("velocity", -14.0, -0.05, 160), workers=1, modes=0)

number = len(found.shares)
colours = ListedColormap([FAMILIES[family_of(share.label)].colour.light for share in found.shares])
fig, ax = plt.subplots(layout="constrained")
image = ax.pcolormesh(
    found.x[1],
    found.y[1],
    found.image,
    cmap=colours,
    norm=BoundaryNorm(np.arange(number + 1) - 0.5, number),
    rasterized=True,
)
bar = fig.colorbar(image, ticks=range(number), label="motion at the end: share of the starts")
bar.ax.set_yticklabels([f"{share.label}: {share.share:.1%}" for share in found.shares])
ax.set_xticks([0, np.pi / 2, np.pi, 3 * np.pi / 2, 2 * np.pi], ["0", "π/2", "π", "3π/2", "2π"])
ax.set(xlabel="load phase at the start [rad]", ylabel="velocity at the start [bar lengths/rad]")
ax.set_title("Where the starts end, R = 0.8, $p_0/p_1$ = 1.2")
plt.show()
