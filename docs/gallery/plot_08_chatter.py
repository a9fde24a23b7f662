"""
Chatter and rest
================

Infinitely many bounces, smaller and smaller, in a finite time: the bar chatters, comes to rest on the wall, and lies
there until the load pulls it off. The simulation completes the chatter in closed form, so that it neither skips it
nor gets stuck in it.
"""

import matplotlib.pyplot as plt
import numpy as np

from percuss import Load, Start, Stop, System, run

system = System(s=20.0, d=0.0, restitution=0.6, load=Load.harmonic(mean=0.9, amplitude=1.0))
motion = run(system, Start.rigid(position=0.0, velocity=-0.2, time=np.pi), modes=0, stop=Stop(time=5.0 * np.pi))

events = motion.events
time = np.unique(np.concatenate([np.linspace(motion.begin_time, motion.end_time, 3000), events.time]))
fig, (above, below) = plt.subplots(2, sharex=True, height_ratios=[2, 1], layout="constrained")
rests = [event.time for event in events if event.kind == "rest"]
releases = [event.time for event in events if event.kind == "release"]
for axes in (above, below):
    for rest, release in zip(rests, [*releases, motion.end_time], strict=False):
        axes.axvspan(rest, release, color="C4", alpha=0.2, linewidth=0)
above.plot(time, motion.gap(time), color="C0", linewidth=1.5)
above.set_ylabel("gap [bar lengths]")
above.set_title("Bounces, rest (shaded) and release, R = 0.6, $p_0/p_1$ = 0.9")
below.plot(time, system.load.value(time), color="C2")
below.axhline(0.0, color="0.6", linewidth=0.8)
below.set_xticks(np.pi * np.arange(1, 7), ["π", "2π", "3π", "4π", "5π", "6π"])
below.set(xlabel="time [rad of the load]", ylabel="load p", xlim=(np.pi, 6.0 * np.pi))
plt.show()
