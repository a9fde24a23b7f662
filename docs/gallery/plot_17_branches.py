"""
One blow, two, three: branches that meet at grazings
====================================================

A rigid bar under a harmonic load strikes once in every load period, or twice, or three times. Each of these motions is
followed through the mean load, round its fold, to where it ends. It ends where the bar, between two impacts, comes to
touch the wall (cross): there the motion with one impact more begins, and the new impact has no speed yet. Stable parts
are solid. At each triangle the period doubles.
"""

import matplotlib.pyplot as plt
import numpy as np

from percuss import Load, System
from percuss.explore import BranchEvent, follow
from percuss.steady import orbits

system = System(s=5.0, d=0.0, restitution=0.5, load=Load.harmonic(mean=0.6, amplitude=1.0))
marks = {BranchEvent.TOUCH: "x", BranchEvent.DEATH: "x", BranchEvent.FOLD: "s", BranchEvent.FLIP: "^"}


def seen(times):
    """Phases from −1 to 2π − 1: no branch of the picture is torn there."""
    return np.mod(np.asarray(times) + 1.0, 2.0 * np.pi) - 1.0


fig, ax = plt.subplots(layout="constrained")
for impacts in (1, 2, 3):
    begin = orbits(system, impacts, modes=0, tries=100).orbits[0]
    branch = follow(begin, "mean", (0.3, 1.0))
    for part, style in ((~branch.stable, "--"), (branch.stable, "-")):
        shown = part | np.append(part[1:], False)  # up to the next point
        phases = np.where(shown[:, None], seen(branch.phases), np.nan)
        lines = ax.plot(branch.values, phases, style, color=f"C{impacts - 1}")
    lines[0].set_label(branch.label)
    for point in branch.points:
        if point.kind in marks:
            phases = seen(point.orbit.phases)
            ax.plot(np.full(phases.size, point.value), phases, marks[point.kind], color="0.2", markersize=5)
ax.set(xlabel="mean load $p_0$ (dimensionless)", ylabel="impact phase φ [rad]")
ax.set_title("Motions with one, two and three impacts in a load period, R = 0.5")
ax.legend(title="solid: stable")
plt.show()
