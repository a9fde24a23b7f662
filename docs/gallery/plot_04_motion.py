"""
The motion of a drifter's piston
================================

The motion of the sample drifter's piston in two periods of its load, in millimetres and milliseconds. The piston
rebounds; the load pulls it back, reverses it and drives it forward; and it strikes again at the same phase.
"""

import matplotlib.pyplot as plt
import numpy as np

from percuss import stability_of, steady_states
from percuss.case import load_case

system = load_case("hydraulic-drifter").system()
orbit = next(orbit for orbit in steady_states(system).orbits if stability_of(orbit).stable and orbit.admissible)

phase = np.linspace(0.0, 4.0 * np.pi, 1201)  # of the load
time = 1e3 * system.time_scale * phase  # ms
after = phase - orbit.phase  # the orbit counts from its impact
blows = 1e3 * system.time_scale * (orbit.phase + np.array([0.0, 2.0 * np.pi]))

fig, (above, below) = plt.subplots(2, sharex=True, height_ratios=[2, 1], layout="constrained")
above.plot(time, 1e3 * system.length_scale * orbit.motion(after), color="C0", linewidth=2)
above.axhline(0.0, color="0.3", linewidth=4, alpha=0.4)
above.annotate("the bit", (time[-1], 0.0), xytext=(-4, 6), textcoords="offset points", ha="right", color="0.3")
above.plot(blows, [0.0, 0.0], "o", color="C1", label="blow")
above.set_ylabel("gap [mm]")
above.set_title(f"Hydraulic drifter: striking end, stroke {1e3 * system.length_scale * orbit.stroke:.1f} mm")
above.legend(loc="lower center", bbox_to_anchor=(0.63, 0.0), frameon=False)
below.plot(time, 1e-3 * system.force_scale * system.load.value(phase), color="C2")
below.axhline(1e-3 * system.force_scale * system.load.mean, color="C2", linestyle=":")
below.plot(blows, 1e-3 * system.force_scale * system.load.value(np.full(2, orbit.phase)), "o", color="C1")
below.set(xlabel="time [ms]", ylabel="load [kN]", xlim=(0, time[-1]))
plt.show()
