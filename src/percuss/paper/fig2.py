"""Fig. 2 of B77: the load of a pneumatic hammer and its approximation by a mean and one harmonic.

B77 shows a measured history. None is at hand: the one here is made up, with what a measured one has (higher harmonics,
noise), and goes the whole way from a recording to a load. It says so wherever it appears.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from percuss.model import Load
from percuss.paper.figure import Figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Picture

_SHAPE = (0.62, 1.0, 0.24 - 0.17j, -0.06 - 0.07j, 0.02 + 0.03j)  # p_0 … p_4 of the made-up history
_NOISE = 0.025
_FREQUENCY = 30.0  # Hz
_KEPT = 6
_CYCLES, _SAMPLES = 24, 360  # in the recording, and in each cycle


def figures(seed: int = 1977) -> tuple[Figure, ...]:
    """Fig. 2: columns phase [rad], measured, approximation; loads in units of the approximation's amplitude p_1."""
    time = np.arange(_CYCLES * _SAMPLES + 1) / (_SAMPLES * _FREQUENCY)
    angle = 2.0 * math.pi * _FREQUENCY * time
    truth = Load.fourier(np.array(_SHAPE)).value(angle)
    measured = truth + _NOISE * np.random.default_rng(seed).standard_normal(time.size)
    load = Load.history(time, measured, frequency=_FREQUENCY, harmonics=_KEPT)  # its first harmonic is all that is used
    size, turn = abs(complex(load.coefficients[1])), float(np.angle(load.coefficients[1]))
    first = int(np.searchsorted(angle + turn, 0.0)) if turn < 0.0 else 0
    kept = slice(first, first + 2 * _SAMPLES + 1)  # two cycles are shown
    phase = angle[kept] + turn
    columns = {
        "phase": phase,
        "measured": measured[kept] / size,
        "approximation": load.mean / size + np.cos(phase),
    }
    return (
        Figure("fig2", "Fig. 2: load of a pneumatic hammer (history made up, not measured)", columns, _paint, 6.2, 3.4),
    )


def _paint(figure: Figure, picture: Picture) -> None:
    from percuss.plot.canvas import COLOURS, INK

    axes, c = picture.add_subplot(), figure.columns
    axes.plot(c["phase"], c["measured"], color=INK, linewidth=0.9, label="history, noise and harmonics in it")
    axes.plot(c["phase"], c["approximation"], color=COLOURS[0], label="$p_0 + p_1\\,\\cos t$")
    axes.axhline(float(np.mean(c["approximation"][:-1])), color=COLOURS[0], linewidth=0.7, linestyle=":", label="$p_0$")
    axes.axhline(0.0, color=INK, linewidth=0.6)
    axes.set_xticks([i * math.pi for i in range(5)], ["0", "π", "2π", "3π", "4π"])
    axes.set_xlim(float(c["phase"][0]), float(c["phase"][-1]))
    axes.set_xlabel("$t$ [rad of the load]")
    axes.set_ylabel("$p/p_1$")
    axes.margins(y=0.18)
    axes.legend(loc="upper center", ncols=3)
