"""
What a recoil damper is for
===========================

A drifter strikes a string of two rods sixty times a second, and each blow finds in the steel what those before it have
left there. Steel takes little, so that without a recoil damper no blow is like another: the rock keeps 115 J of one and
213 J of another. A dashpot beside the shank, of half the impedance of the rod, takes the compression that
the rock sends back, and every blow is like the one before. The feed force presses the bit to the rock; alone it calms
nothing.
"""

from dataclasses import replace

import matplotlib.pyplot as plt

from percuss.blow.periods import strike_repeatedly
from percuss.case import load_case

question = load_case("drill-string").blow_question()
rod, blows = question.target, 60
impedance = rod.pieces[0].impedance  # N s/m

fig, axes = plt.subplots(layout="constrained")
for share, name in ((0.0, "no recoil damper"), (0.1, "dashpot of Z/10"), (0.5, "dashpot of Z/2")):
    held = replace(rod, feed=replace(rod.feed, damping=share * impedance))
    train = strike_repeatedly(question.striker, held, question.velocity, 1.0 / question.rate, blows, estimate=False)
    axes.plot(range(1, blows + 1), [blow.rock_dissipated for blow in train.blows], ".-", label=name)
axes.set(xlabel="blow", ylabel="energy that the rock keeps [J]", ylim=(0.0, None))
axes.legend()
plt.show()
