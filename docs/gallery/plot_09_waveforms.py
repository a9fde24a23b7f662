"""
Why a real hydraulic hammer runs
================================

A bar keeps its rhythm if the force at the moment of its blow lies in a band about zero: below the mean, and not far
below zero (the waveform criterion). At that moment the square wave of 1977 is at one of its two levels, far outside
the band. The pressure of a real drifter falls more slowly; it passes through the band, and the blow occurs there.
"""

import matplotlib.pyplot as plt
import numpy as np

from percuss import Load, System, stability_of, steady_states
from percuss.case import load_case

square = System(s=1e3, d=0.0, restitution=0.2, load=Load.square(1.0, 1.2))
drifter = load_case("hydraulic-drifter").system()
phase = np.linspace(0.0, 2.0 * np.pi, 2000)

fig, panels = plt.subplots(1, 2, sharey=True, figsize=(7.2, 3.9), layout="constrained")
for ax, system, title in zip(panels, (square, drifter), ("square wave, κ = 1.2", "sample drifter"), strict=True):
    mean = system.load.mean
    ax.plot(phase, system.load.value(phase) / mean, color="C0", linewidth=2)
    for orbit in steady_states(system).orbits:
        verdict = stability_of(orbit)
        marker, colour = ("o", "C2") if verdict.stable else ("X", "C1")
        ax.plot(orbit.phase, verdict.waveform.ratio, marker, color=colour, markersize=9)
    ax.axhspan(verdict.waveform.lower, verdict.waveform.upper, color="C2", alpha=0.2, linewidth=0)
    ax.set_xticks([0, np.pi, 2 * np.pi], ["0", "π", "2π"])
    ax.set(xlabel="load phase [rad]", title=title)
panels[0].set_ylabel("load over its mean, $p/p_0$")
panels[1].plot([], [], "o", color="C2", markersize=9, label="stable blow")
panels[1].plot([], [], "X", color="C1", markersize=9, label="unstable blow")
panels[1].fill_between([], [], color="C2", alpha=0.2, label="allowed band")
panels[1].legend(frameon=False)
plt.show()
