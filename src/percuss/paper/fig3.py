"""Fig. 3 of B77: the load of a hydraulic hammer, a square wave, beside its truncated Fourier series (B77 34)."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from percuss.model import Load
from percuss.paper.figure import Figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Picture

KAPPA = 1.3
HARMONICS = (3, 10, 40)
_POINTS = 1441  # over two periods


def figures(seed: int = 1977) -> tuple[Figure, ...]:
    """Fig. 3: columns phase [rad], load, series_3, series_10, series_40; loads in units of q, κ = 1.3.

    The phase of a jump stands there twice, with the load's value before it and after it.
    """
    square = Load.square(1.0, KAPPA)
    jumps = np.array([turn + jump.phase for turn in (0.0, 2.0 * math.pi) for jump in square.jumps])
    jumps = jumps[(jumps > 0.0) & (jumps < 4.0 * math.pi)]
    even = np.linspace(0.0, 4.0 * math.pi, _POINTS)
    even = even[~np.isclose(even[:, None], jumps, rtol=0.0, atol=1e-9).any(axis=1)]
    phase = np.concatenate([even, jumps, jumps])
    within = square.value(np.minimum(even, 4.0 * math.pi - 1e-9))  # the last value is that before the next jump
    load = np.concatenate([within, square.value(jumps, "left"), square.value(jumps, "right")])
    order = np.argsort(phase, kind="stable")
    columns = {"phase": phase[order], "load": load[order]}
    for k in HARMONICS:
        series = Load.fourier(Load.square(1.0, KAPPA, k).coefficients)
        columns[f"series_{k}"] = series.value(phase[order])
    return (Figure("fig3", "Fig. 3: load of a hydraulic hammer, κ = 1.3", columns, _paint, 6.2, 3.4),)


def _paint(figure: Figure, picture: Picture) -> None:
    from percuss.plot.canvas import COLOURS, INK

    axes, c = picture.add_subplot(), figure.columns
    for colour, k in zip(COLOURS, HARMONICS, strict=False):
        axes.plot(c["phase"], c[f"series_{k}"], color=colour, linewidth=0.9, label=f"{k} harmonics")
    axes.plot(c["phase"], c["load"], color=INK, linewidth=1.6, label="square wave")
    axes.axhline(KAPPA - 1.0, color=INK, linewidth=0.7, linestyle=":", label="$p_0 = q(\\kappa - 1)$")
    axes.axhline(0.0, color=INK, linewidth=0.6)
    places = [0.0, KAPPA, 2.0, 2.0 + KAPPA, 4.0]
    axes.set_xticks([math.pi * x for x in places], ["0", "κπ", "2π", "(2 + κ)π", "4π"])
    axes.set_xlim(0.0, 4.0 * math.pi)
    axes.set_yticks([-1.0, 0.0, 1.0], ["$-q$", "0", "$q$"])
    axes.set_ylim(-1.45, 2.0)
    axes.set_xlabel("$t$ [rad of the load]")
    axes.set_ylabel("$p$")
    axes.legend(loc="upper center", ncols=3)
