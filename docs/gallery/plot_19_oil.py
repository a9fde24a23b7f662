"""
What the oil takes
==================

A breaker whose piston switches its own valve, at flows of the pump from 80 to 160 l/min. Passages take a pressure that
grows as the square of the flow through them, leaks take oil, the line to the tank keeps a back pressure: what is left
reaches the chisel. More oil means a higher pressure, more blows a minute and harder ones, until the relief valve opens.
The passages of this machine are assumed.
"""

import matplotlib.pyplot as plt
import numpy as np

from percuss.case import load_case, machine_answer
from percuss.steady.oil.oil_figures import path_losses

names = {
    "impact": "into the chisel", "orifice_rear": "passages of the rear chamber", "leakage": "leakage",
    "orifice_front": "passage of the front chamber", "return_line": "line to the tank", "drag": "seals",
    "relief": "relief valve",
}  # fmt: skip
flows, shares = np.linspace(80.0, 160.0, 9), []
for flow in flows:
    case = load_case("oil-breaker").varied({"load.supply.flow": f"{flow} l/min"})
    losses = path_losses(machine_answer(case, modes=0).motion.cycle)
    shares.append([100.0 * losses[name] / sum(losses.values()) for name in names])

fig, axes = plt.subplots(layout="constrained")
colours = ["0.8", *(f"C{i}" for i in range(len(names) - 1))]
axes.stackplot(flows, np.transpose(shares), labels=names.values(), colors=colours)
axes.set(xlabel="flow of the pump [l/min]", ylabel="share of the input [%]", xlim=flows[[0, -1]], ylim=(0, 100))
axes.legend(loc="lower left")
plt.show()
