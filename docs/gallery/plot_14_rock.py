"""
How long should the hammer be?
==============================

A hammer of the rod's cross-section sends a rectangular wave to the rock. If the wave is short for its rock, most of it
comes back as tension; if it is long, most of it comes back as compression, once the rock bears the whole force. For the
best length in between the rock takes 81 % of 1 − γ, which is all that it keeps of any work (Lundberg 1973). The dots
are blows by waves, cut off before the second wave arrives.
"""

import matplotlib.pyplot as plt
import numpy as np

from percuss.blow import Rock, Rod, strike
from percuss.blow.closed_forms import BEST_BETA, best_efficiency, matched_efficiency
from percuss.model import Bar, Section

area, length, gamma = 1e-3, 0.5, 0.2  # m², m
hammer = Bar(length, area=area)
compliance = length / (area * hammer.youngs_modulus)

betas = np.geomspace(0.1, 10.0, 200)
fig, axes = plt.subplots(layout="constrained")
axes.semilogx(betas, [best_efficiency(beta, gamma) for beta in betas], color="0.6", label="best wave")
axes.semilogx(betas, [matched_efficiency(beta, gamma) for beta in betas], label="rectangular wave")

dots = np.geomspace(0.1, 10.0, 13)
rod_length = 4.0 * length
taken = []
for beta in dots:
    rock = Rock(beta / (2.0 * compliance), gamma)
    rod = Rod([Section(rod_length, area=area)], end="rock", rock=rock)
    blow = strike(hammer, rod, 8.0, until=2.5 * rod_length / hammer.wave_speed)
    taken.append(blow.rock_dissipated / blow.energy_before)
axes.semilogx(dots, taken, "o", color="C1", label="blow by waves")
axes.axvline(BEST_BETA, color="0.7", linewidth=0.8, linestyle=":")
axes.set(xlabel="β = 2 K₁ L/(A E)", ylabel="share of the energy that the rock takes", ylim=(0.0, 1.0))
axes.legend()
plt.show()
