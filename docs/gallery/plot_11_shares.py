"""
How often is each motion reached?
=================================

If several motions coexist, how often is each one reached? The answer depends on the distribution of the starts. The
figure shows three distributions of random starts for one hammer; the whiskers are 95 % intervals. The same seed gives
the same numbers on every machine.
"""

import matplotlib.pyplot as plt
import numpy as np

from percuss import Load, System
from percuss.explore import experiment

system = System(s=20.0, d=0.0, restitution=0.8, load=Load.harmonic(mean=1.2, amplitude=1.0))
labels = ("z=1/1", "rest", "z=1/2", "z=2/1")
places = np.arange(len(labels))

fig, ax = plt.subplots(layout="constrained")
for i, distribution in enumerate(("wall", "field", "gentle")):
    found = experiment(system, 2000, distribution, seed=1977, modes=0, workers=1)
    share, low, high = np.array([found.labels.get(label, (0.0, 0.0, 0.0)) for label in labels]).T
    ax.bar(
        places + 0.27 * (i - 1),
        100.0 * share,
        width=0.25,
        yerr=100.0 * np.array([share - low, high - share]),
        capsize=3,
        color=f"C{i}",
        label=distribution,
    )
ax.set_xticks(places, labels)
ax.set(xlabel="motion that the bar settles on", ylabel="share of the starts [%]")
ax.set_title("2000 starts of each distribution, R = 0.8, $p_0/p_1$ = 1.2")
ax.legend(frameon=False)
plt.show()
