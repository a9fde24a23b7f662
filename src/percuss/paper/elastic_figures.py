"""What B77 cannot see: how the boundaries and the exact multipliers of the pneumatic hammer move with the wave speed s.

B77's reduced criterion holds for s ≫ 1/π. The exact multipliers of the bar's modes show how fast it becomes right, and
where an elastic mode grows although it says stable: near the resonances of the impacts, where n s m is a whole number.
That growth is a property of B77's contact law, which keeps the strain at the impact, and not of bars: waves turn the
strain over (`percuss.model.Reversed`).
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from percuss.explore.boundary_curves.boundary import Boundaries, boundaries
from percuss.explore.boundary_curves.motion_branches import folds_and_stretches
from percuss.explore.boundary_curves.plane_lines import Line, orbit_on
from percuss.explore.family import SystemFamily
from percuss.model import Load, System
from percuss.model.checks import Array
from percuss.paper.figure import DAMPING, PaperFigure
from percuss.stability import floquet_multipliers, linear_map, reduced_criterion
from percuss.steady import steady_states

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Picture

SPEEDS = np.geomspace(0.4, 100.0, 61)
RESTITUTION = 0.5
HALF = 0.5 * math.pi
MODES = 8
_MOST = 1.2
_HEIGHTS = 32  # rows of the map behind the curves


def elastic(seed: int) -> tuple[PaperFigure, ...]:
    """Three figures: the boundaries over s, the largest multiplier over s, and the instability of theory §5.

    elastic.csv: s, upper (the fold), lower_reduced, flip, neimark_sacker (of the exact multipliers of 8 modes on the
    branch that B77 finds stable); R = 0.5, m = 1, 2πd = 0.03; nan where there is none.

    elastic_multipliers.csv: s, reduced, exact_8, exact_16: largest modulus of the motion with phase beyond π/2 under
    p = 0.9 + cos t, R = 0.6, m = 1, 2πd = 0.03.

    elastic_instability.csv: the same for R = 0.8, m = 2, d = 0 and s from 4.5 to 5.5, with columns s, reduced, exact_8,
    exact_16.
    """
    return (
        _limits(),
        _largest("multipliers", np.geomspace(0.4, 100.0, 241), 0.6, 1, DAMPING),
        _largest("instability", np.linspace(4.5, 5.5, 201), 0.8, 2, 0.0),
    )


# -- the boundaries over s --


def _limits() -> PaperFigure:
    system = System(s=1.0, d=DAMPING, restitution=RESTITUTION, load=Load.harmonic(1.0, 1.0))
    plane = ("s", SPEEDS), ("load_factor", 0.0, _MOST)
    reduced = boundaries(system, *plane, kinds=("fold", "flip"))
    exact = boundaries(system, *plane, criterion="exact", modes=MODES, kinds=("flip", "neimark-sacker"), samples=21)
    columns = {
        "s": SPEEDS,
        "upper": reduced.greatest("fold"),
        "lower_reduced": reduced.greatest("flip"),
        "flip": _beyond_the_fold(exact, "flip"),
        "neimark_sacker": _beyond_the_fold(exact, "neimark-sacker"),
    }
    title = f"Elastic: boundaries over $s$, $R = {RESTITUTION}$, $m = 1$, $2\\pi d = 0.03$"
    return PaperFigure("elastic", title, columns, _paint_limits, 6.6, 4.4, _map(system))


def _map(system: System) -> dict[str, npt.NDArray[Any]]:
    """Load factors and largest exact moduli of the motions with φ > π/2, over s and along the branch."""
    heights, moduli = np.empty((2, SPEEDS.size, _HEIGHTS))
    for i, s in enumerate(SPEEDS.tolist()):
        line = Line(SystemFamily(system), {"s": s}, "load_factor", 0.0, _MOST, 1, MODES)
        stretch = next(part for part in folds_and_stretches(line, 2)[1] if part.place(np.array([0.5]))[1][0] > HALF)
        t = (np.arange(_HEIGHTS) + 0.5) / _HEIGHTS
        heights[i] = stretch.place(t)[0]
        found = (orbit_on(stretch, place) for place in t.tolist())
        matrices = [linear_map(orbit, MODES, side).dense() for orbit, side in found]
        moduli[i] = np.abs(np.linalg.eigvals(np.array(matrices))).max(axis=1)
    return {"heights": heights, "moduli": moduli}


def _beyond_the_fold(found: Boundaries, kind: str) -> Array:
    """The greatest load factor of a crossing with φ > π/2, where B77 finds the stable motions."""
    greatest = np.full(SPEEDS.size, math.nan)
    for curve in found.of(kind):
        greatest = np.fmax(greatest, np.where(curve.phase > HALF, curve.y, math.nan))
    return greatest


def _paint_limits(figure: PaperFigure, picture: Picture) -> None:
    from matplotlib.colors import ListedColormap

    from percuss.plot.canvas import COLOURS

    axes, c = picture.add_subplot(), figure.columns
    s, heights = np.broadcast_arrays(c["s"][:, None], figure.marks["heights"])
    stable = np.where(figure.marks["moduli"] < 1.0, 1.0, math.nan)
    axes.pcolormesh(s, heights, stable, cmap=ListedColormap(["#d3ece3"]), shading="nearest", rasterized=True)
    axes.plot(c["s"], c["upper"], color=COLOURS[0], label="upper: fold")
    axes.plot(c["s"], c["lower_reduced"], color=COLOURS[1], label="lower: flip, B77's reduced criterion")
    axes.plot(c["s"], c["flip"], ".", color=COLOURS[2], markersize=4, label=f"flip, exact multipliers, {MODES} modes")
    axes.plot(
        c["s"], c["neimark_sacker"], "x", color=COLOURS[3], markersize=4,
        label="Neimark–Sacker: a pair leaves the circle",
    )  # fmt: skip
    axes.fill([], [], color="#d3ece3", label="stable by the exact multipliers")
    axes.set_xscale("log")
    axes.set_xticks([0.4, 1.0, 3.0, 10.0, 30.0, 100.0], ["0.4", "1", "3", "10", "30", "100"])
    limits = (float(c["s"][0]), float(c["s"][-1])), (0.0, _MOST)
    axes.set(xlim=limits[0], ylim=limits[1], xlabel="$s = C/(L\\Omega)$", ylabel="$p_0/p_1$")
    axes.legend(loc="lower right")


# -- the multipliers over s --


def _largest(name: str, speeds: Array, r: float, m: int, d: float) -> PaperFigure:
    """Largest modulus by the reduced criterion and by the exact multipliers, of the motion with the later phase."""
    rows = []
    for s in speeds.tolist():
        system = System(s=s, d=d, restitution=r, load=Load.harmonic(0.9, 1.0))
        orbit = steady_states(system, m).orbits[-1]
        rows.append([max(reduced_criterion(orbit).moduli), *(floquet_multipliers(orbit, n).largest for n in (8, 16))])
    columns = {"s": speeds, **dict(zip(("reduced", "exact_8", "exact_16"), np.array(rows).T, strict=True))}
    damping = "2\\pi d = 0.03" if d else "d = 0"
    title = f"Elastic: largest multiplier, $p = 0.9 + \\cos t$, $R = {r}$, $m = {m}$, ${damping}$"
    return PaperFigure(f"elastic_{name}", title, columns, _paint_multipliers, 6.6, 4.0)


def _paint_multipliers(figure: PaperFigure, picture: Picture) -> None:
    from percuss.plot.canvas import COLOURS, INK

    axes, c = picture.add_subplot(), figure.columns
    names = [name for name in c if name != "s"]
    exact = names[1:]
    low = min(float(c[name].min()) for name in exact)
    high = max(float(c[name].max()) for name in exact)
    for name, colour in zip(exact, (COLOURS[2], COLOURS[0]), strict=True):
        axes.plot(c["s"], c[name], color=colour, linewidth=0.9, label=f"exact, {name.rpartition('_')[2]} modes")
        grows = c[name] > 1.0
        axes.plot(c["s"][grows], c[name][grows], "o", color=COLOURS[1], markersize=2.5)
    axes.plot([], [], "o", color=COLOURS[1], markersize=2.5, label="an elastic mode grows, as the strain is kept")
    text = f"B77's reduced criterion: largest modulus at most {float(c['reduced'].max()):.3f}, stable at every $s$"
    axes.text(0.02, 0.04, text, transform=axes.transAxes)
    axes.set_ylim(low - 0.2 * (high - low), high + 0.3 * (high - low))
    axes.axhline(1.0, color=INK, linewidth=0.7)
    if c["s"][-1] > 10.0 * c["s"][0]:
        axes.set_xscale("log")
        axes.set_xticks([0.4, 1.0, 3.0, 10.0, 30.0, 100.0], ["0.4", "1", "3", "10", "30", "100"])
    axes.set(xlim=(float(c["s"][0]), float(c["s"][-1])), xlabel="$s = C/(L\\Omega)$", ylabel="largest modulus")
    axes.legend(loc="upper center", ncols=3)
