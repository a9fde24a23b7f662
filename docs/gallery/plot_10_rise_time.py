"""
How fast may a valve switch?
============================

A design question: a valve needs time to let the pressure rise and fall. If it switches at once, no motion is stable.
The slower the valve is, the nearer the force at the moment of the blow comes to the allowed band, and from a certain
rise time on the hammer keeps its rhythm; if the valve is slower still, there is no such motion. Any other waveform
can be tested in the same way, from its Fourier coefficients.
"""

import matplotlib.pyplot as plt
import numpy as np

from percuss import Load, System, stability_of, steady_states

SQUARE = Load.square(amplitude=1.0, kappa=1.3, harmonics=16).coefficients


def trapezoid(rise: float) -> Load:
    """A square wave whose flanks take a part `rise` of the period."""
    return Load.fourier(SQUARE * np.sinc(np.arange(SQUARE.size) * rise))


rises = np.linspace(0.0, 0.45, 91)
margins = np.full(rises.size, np.nan)
for i, rise in enumerate(rises):
    orbits = steady_states(System(s=40.0, d=0.25, restitution=0.2, load=trapezoid(rise))).orbits
    if orbits:
        margins[i] = max(stability_of(orbit, modes=8).margin for orbit in orbits)

fig, (left, right) = plt.subplots(1, 2, figsize=(7.6, 3.6), layout="constrained")
phase = np.linspace(0.0, 2.0 * np.pi, 801)
for rise, colour in ((0.05, "C1"), (0.20, "C0"), (0.35, "C2")):
    left.plot(phase, trapezoid(rise).value(phase), color=colour, label=f"{rise:.0%} of the period")
left.set_xticks([0, np.pi, 2 * np.pi], ["0", "π", "2π"])
left.set(xlabel="load phase [rad]", ylabel="load over its amplitude", title="Rise time", ylim=(-1.2, 2.1))
left.legend(loc="upper right", frameon=False)
right.axhspan(0.0, 1.0, color="C2", alpha=0.15, linewidth=0)
right.plot(100.0 * rises, margins, color="C0", linewidth=2)
right.text(2.0, 0.75, "stable", color="C2")
right.text(38.5, -0.85, "no\nmotion", color="0.4")
right.set(xlabel="rise time [% of the period]", ylabel="margin (dimensionless)", xlim=(0, 46), ylim=(-2.0, 1.0))
right.set_title("Stability margin of the best motion")
plt.show()
