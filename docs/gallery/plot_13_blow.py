"""
Inside a blow
=============

A stepped piston strikes a long rod. At each step a part of every wave turns back, so that the pulse in the rod has as
many levels as waves return while the faces touch. Time runs upward; the faces meet at the black line.
"""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.colors import LinearSegmentedColormap

from percuss import palette
from percuss.blow import Rod, strike
from percuss.model import Section, SectionedBar

sizes = ((0.140, 0.036), (0.160, 0.052), (0.150, 0.038))  # m
piston = SectionedBar([Section(length, diameter=diameter) for length, diameter in sizes])
blow = strike(piston, Rod([Section(None, diameter=0.052, bore=0.012)]), 9.5)

times = np.linspace(0.0, blow.until, 400)[1:]
places = np.linspace(-piston.length, 2.0 * piston.length, 600)
force = np.zeros((times.size, places.size))
for row, time in zip(force, times, strict=True):
    state = blow.state_at(time)
    own, rod = state.striker, state.rod
    row[places < 0] = np.interp(places[places < 0] + piston.length, own.places, own.force)
    row[places >= 0] = np.interp(places[places >= 0], rod.places, rod.force, right=0.0)

top = 1e-3 * abs(force).max()
fig, axes = plt.subplots(layout="constrained")
blue_orange = LinearSegmentedColormap.from_list("strain", [stop.light for stop in palette.STRAIN])
image = axes.pcolormesh(places, 1e6 * times, -1e-3 * force, cmap=blue_orange, vmin=-top, vmax=top, rasterized=True)
fig.colorbar(image, label=f"force [kN], {palette.SIGN}")
axes.axvline(0.0, color="k", linewidth=1.5)
for step in np.cumsum([length for length, _ in sizes])[:-1] - piston.length:
    axes.axvline(step, color="0.5", linewidth=0.8, linestyle=":")
contact, restitution = 1e6 * blow.contact_duration, blow.effective_restitution
axes.set(xlabel="place from the struck face [m]", ylabel="time [µs]")
axes.set_title(f"Contact {contact:.0f} µs, restitution {restitution:.3f}")
plt.show()
