"""
How thick should the rod be?
============================

A restitution of your own: if the hammer strikes a long rod of the same steel, the two cross-sections determine the
coefficient of restitution. A thicker rod throws the piston back faster. The blow then has less energy and the rod
takes less of it; the margin shows how thick the rod may be.
"""

import matplotlib.pyplot as plt
import numpy as np

from percuss import Kept, si_report, stability_of, steady_states
from percuss.case import load_case

drifter = load_case("hydraulic-drifter").system()
ratios = np.linspace(1.0, 2.6, 41)
delivered, margins = np.full((2, ratios.size), np.nan)
for i, ratio in enumerate(ratios):
    contact = Kept(receiving_area=ratio * drifter.bar.area, area=drifter.bar.area)
    for orbit in steady_states(drifter.with_restitution(contact.restitution)).orbits:
        if orbit.admissible:
            delivered[i], margins[i] = si_report(orbit).delivered_energy_J, stability_of(orbit, modes=8).margin

fig, (above, below) = plt.subplots(2, sharex=True, layout="constrained")
above.plot(ratios, delivered, color="C0", linewidth=2)
above.set(xlim=(1.0, 2.6), ylabel="energy into the rod [J]", title="Sample drifter on rods of other cross-sections")
above.annotate("no motion", (1.1, 250.0), color="0.4")
below.axhspan(0.0, 1.0, color="C2", alpha=0.15, linewidth=0)
below.plot(ratios, margins, color="C1", linewidth=2)
below.set(xlabel="cross-section of the rod over that of the piston", ylabel="stability margin", ylim=(-0.2, 1.0))
plt.show()
