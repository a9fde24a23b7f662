"""Figures 2 to 8 of B77 and those of elastic bars, each a function of its name: its columns, and how it is painted."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from percuss.explore.boundary_curves.boundary import Boundaries, boundaries
from percuss.explore.boundary_curves.motion_branches import folds_and_stretches
from percuss.explore.boundary_curves.plane_lines import Line, orbit_on
from percuss.explore.family import SystemFamily
from percuss.model import Load, System
from percuss.model.checks import Array
from percuss.paper.figure import (
    DAMPING,
    KAPPAS,
    RESTITUTIONS,
    STIFF,
    TENTHS,
    Columns,
    PaperFigure,
    branch_legend,
    branch_rows,
    draw_branches,
    hydraulic,
    pneumatic,
    stacked,
)
from percuss.stability import floquet_multipliers, reduced_criterion
from percuss.steady import steady_states

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Picture

_DASHED = (0, (4, 2))

# ---- Fig. 2: the load of a pneumatic hammer and its approximation by a mean and one harmonic
#
# B77 shows a measured history. None is at hand: the one here is made up, with what a measured one has (higher
# harmonics, noise), and goes the whole way from a recording to a load. It says so wherever it appears.

_SHAPE = (0.62, 1.0, 0.24 - 0.17j, -0.06 - 0.07j, 0.02 + 0.03j)  # p_0 … p_4 of the made-up history
_NOISE = 0.025
_FREQUENCY = 30.0  # Hz
_KEPT = 6
_CYCLES, _SAMPLES = 24, 360  # in the recording, and in each cycle


def fig2(seed: int) -> PaperFigure:
    """Columns phase [rad], measured, approximation; loads in units of the approximation's amplitude p_1."""
    time = np.arange(_CYCLES * _SAMPLES + 1) / (_SAMPLES * _FREQUENCY)
    angle = 2.0 * math.pi * _FREQUENCY * time
    truth = Load.fourier(np.array(_SHAPE)).value(angle)
    measured = truth + _NOISE * np.random.default_rng(seed).standard_normal(time.size)
    load = Load.history(time, measured, frequency=_FREQUENCY, harmonics=_KEPT)  # its first harmonic is all that is used
    size, turn = abs(complex(load.coefficients[1])), float(np.angle(load.coefficients[1]))
    first = int(np.searchsorted(angle + turn, 0.0)) if turn < 0.0 else 0
    kept = slice(first, first + 2 * _SAMPLES + 1)  # two cycles are shown
    phase = angle[kept] + turn
    columns = {"phase": phase, "measured": measured[kept] / size, "approximation": load.mean / size + np.cos(phase)}
    title = "Fig. 2: load of a pneumatic hammer (history made up, not measured)"
    return PaperFigure("fig2", title, columns, _paint_fig2, 6.2, 3.4)


def _paint_fig2(figure: PaperFigure, picture: Picture) -> None:
    from percuss.plot.canvas import COLOURS, INK

    axes, c = picture.add_subplot(), figure.columns
    axes.plot(c["phase"], c["measured"], color=INK, linewidth=0.9, label="history, noise and harmonics in it")
    axes.plot(c["phase"], c["approximation"], color=COLOURS[0], label="$p_0 + p_1\\,\\cos t$")
    axes.axhline(float(np.mean(c["approximation"][:-1])), color=COLOURS[0], linewidth=0.7, linestyle=":", label="$p_0$")
    axes.axhline(0.0, color=INK, linewidth=0.6)
    axes.set_xticks([i * math.pi for i in range(5)], ["0", "π", "2π", "3π", "4π"])
    axes.set(xlim=(float(c["phase"][0]), float(c["phase"][-1])), xlabel="$t$ [rad of the load]", ylabel="$p/p_1$")
    axes.margins(y=0.18)
    axes.legend(loc="upper center", ncols=3)


# ---- Fig. 3: the load of a hydraulic hammer, a square wave, beside its truncated Fourier series (B77 34)

_KAPPA = 1.3
_HARMONICS = (3, 10, 40)
_POINTS = 1441  # over two periods


def fig3(seed: int) -> PaperFigure:
    """Columns phase [rad] (a jump twice), load, series_3, series_10, series_40; in units of q, κ = 1.3."""
    square = Load.square(1.0, _KAPPA)
    jumps = np.array([turn + jump.phase for turn in (0.0, 2.0 * math.pi) for jump in square.jumps])
    jumps = jumps[(jumps > 0.0) & (jumps < 4.0 * math.pi)]
    even = np.linspace(0.0, 4.0 * math.pi, _POINTS)
    even = even[~np.isclose(even[:, None], jumps, rtol=0.0, atol=1e-9).any(axis=1)]
    phase = np.concatenate([even, jumps, jumps])
    within = square.value(np.minimum(even, 4.0 * math.pi - 1e-9))  # the last value is that before the next jump
    load = np.concatenate([within, square.value(jumps, "left"), square.value(jumps, "right")])
    order = np.argsort(phase, kind="stable")
    columns = {"phase": phase[order], "load": load[order]}
    for k in _HARMONICS:
        series = Load.fourier(Load.square(1.0, _KAPPA, k).coefficients)
        columns[f"series_{k}"] = series.value(phase[order])
    return PaperFigure("fig3", "Fig. 3: load of a hydraulic hammer, κ = 1.3", columns, _paint_fig3, 6.2, 3.4)


def _paint_fig3(figure: PaperFigure, picture: Picture) -> None:
    from percuss.plot.canvas import COLOURS, INK

    axes, c = picture.add_subplot(), figure.columns
    for colour, k in zip(COLOURS, _HARMONICS, strict=False):
        axes.plot(c["phase"], c[f"series_{k}"], color=colour, linewidth=0.9, label=f"{k} harmonics")
    axes.plot(c["phase"], c["load"], color=INK, linewidth=1.6, label="square wave")
    axes.axhline(_KAPPA - 1.0, color=INK, linewidth=0.7, linestyle=":", label="$p_0 = q(\\kappa - 1)$")
    axes.axhline(0.0, color=INK, linewidth=0.6)
    places = [0.0, _KAPPA, 2.0, 2.0 + _KAPPA, 4.0]
    axes.set_xticks([math.pi * x for x in places], ["0", "κπ", "2π", "(2 + κ)π", "4π"])
    axes.set_yticks([-1.0, 0.0, 1.0], ["$-q$", "0", "$q$"])
    axes.set(xlim=(0.0, 4.0 * math.pi), ylim=(-1.45, 2.0), xlabel="$t$ [rad of the load]", ylabel="$p$")
    axes.legend(loc="upper center", ncols=3)


# ---- Fig. 4: impact phase of the pneumatic hammer over the load factor, for R = 0, 0.1, …, 0.9 (B77 35–39)

_MOST_FACTOR = 10.0  # beyond the fold of R = 0.9, at 6.05
_SHOWN = 2.0


def fig4(seed: int) -> PaperFigure:
    """Columns restitution, load_factor, phase [rad], stable, admissible; s → ∞, d = 0, m = 1."""
    parts = [branch_rows(pneumatic(), r, "load_factor", 0.0, _MOST_FACTOR, 180) for r in TENTHS]
    title = "Fig. 4: impact phase of the pneumatic hammer, $m = 1$, $s \\to \\infty$, $d = 0$"
    return PaperFigure("fig4", title, stacked(parts), _paint_fig4, 6.2, 4.8)


def _paint_fig4(figure: PaperFigure, picture: Picture) -> None:
    axes = picture.add_subplot()
    draw_branches(axes, figure.columns, "load_factor")
    axes.set_yticks([0.0, math.pi / 4, math.pi / 2, 3 * math.pi / 4, math.pi], ["0", "π/4", "π/2", "3π/4", "π"])
    axes.set(xlim=(0.0, _SHOWN), ylim=(0.0, math.pi), xlabel="$p_0/p_1$", ylabel="impact phase φ")
    _number_curves(axes, figure.columns)
    branch_legend(axes)
    legend = axes.get_legend()
    if legend is not None:
        legend.remove()
    picture.legend(*axes.get_legend_handles_labels(), loc="outside lower center", ncols=3)


def _number_curves(axes: Axes, columns: Columns) -> None:
    """The number of each curve: at its fold, or at the edge of the picture where the fold lies beyond it."""
    for text in list(axes.texts):
        text.remove()
    for r in np.unique(columns["restitution"]).tolist():
        here = columns["restitution"] == r
        y, phase = columns["load_factor"][here], columns["phase"][here]
        fold = int(np.argmax(y))
        at, shift, side = (float(y[fold]), float(phase[fold])), (-2, 0), "right"
        if y[fold] > _SHOWN:
            last = np.flatnonzero(y > _SHOWN).min()
            inner = np.interp(_SHOWN, y[last - 1 : last + 1], phase[last - 1 : last + 1])
            at, shift, side = (_SHOWN, float(inner)), (3, 0), "left"
        name = f"{r:.1f}" if r else "R = 0"
        axes.annotate(name, at, shift, textcoords="offset points", fontsize=6.5, ha=side, va="center")


# ---- Fig. 5: the range of load factors with a stable motion of the pneumatic hammer, over R (B77 38, 39)


def fig5(seed: int) -> PaperFigure:
    """Columns restitution, lower, upper (d = 0), lower_damped, upper_damped (2πd = 0.03); s → ∞, m = 1."""
    columns = {"restitution": RESTITUTIONS}
    plane = ("restitution", RESTITUTIONS), ("load_factor", 0.0, 100.0)  # beyond the fold of R = 0.99, at 63.3
    for d, ending in ((0.0, ""), (DAMPING, "_damped")):
        found = boundaries(pneumatic(d=d), *plane, kinds=("fold", "flip"))
        columns[f"lower{ending}"], columns[f"upper{ending}"] = found.greatest("flip"), found.greatest("fold")
    title = "Fig. 5: stable motions of the pneumatic hammer, $m = 1$, $s \\to \\infty$"
    return PaperFigure("fig5", title, columns, _paint_fig5)


def _paint_fig5(figure: PaperFigure, picture: Picture) -> None:
    from percuss.plot.canvas import COLOURS

    axes, c = picture.add_subplot(), figure.columns
    axes.fill_between(c["restitution"], c["lower"], c["upper"], color=COLOURS[0], alpha=0.10, linewidth=0)
    lines = (
        ("upper", "-", 0, "upper, $d = 0$"),
        ("lower", "-", 1, "lower, $d = 0$"),
        ("upper_damped", _DASHED, 0, "upper, $2\\pi d = 0.03$"),
        ("lower_damped", _DASHED, 1, "lower, $2\\pi d = 0.03$"),
    )
    _over_restitution(axes, figure, lines, (0.0, 2.0), "$p_0/p_1$")
    for x, y, text in ((0.82, 1.4, "stable"), (0.25, 1.2, "no motion"), (0.62, 0.35, "unstable")):
        axes.text(x, y, text, ha="center")


_Line = tuple[str, str | tuple[int, tuple[int, int]], int, str]
"""The column of a curve over R, how the line is drawn, the number of its colour, and its name."""


def _over_restitution(
    axes: Axes, figure: PaperFigure, lines: Sequence[_Line], limits: tuple[float, float], label: str
) -> None:
    from percuss.plot.canvas import COLOURS

    for column, line, colour, name in lines:
        place, values = figure.columns["restitution"], figure.columns[column]
        axes.plot(place, values, color=COLOURS[colour], linestyle=line, label=name)
    axes.set(xlim=(0.0, 1.0), ylim=limits, xlabel="$R$", ylabel=label)
    axes.legend(loc="upper left")


# ---- Fig. 6: the stable range of the pneumatic hammer with ten load periods to an impact, near the first resonance
#
# B77 (37, 39). B77 measures frequencies from the impact, so that the load is its tenth harmonic, p_0 + p_10 cos 10t,
# and sπ = 10.1 and 10.01. Here frequencies are measured from the load: p_0 + p_1 cos t, m = 10, sπ = 1.01 and 1.001.
# The forces of the two scalings differ by m² = 100, the mean and the amplitude alike: p_0/p_10 there is p_0/p_1 here.

_SPEEDS = {"": STIFF, "_10_1": 1.01 / math.pi, "_10_01": 1.001 / math.pi}


def fig6(seed: int) -> PaperFigure:
    """Columns restitution, upper, lower (sπ → ∞), lower_10_1, lower_10_01, all as p_0/p_10; d = 0, m = 10."""
    columns = {"restitution": RESTITUTIONS}
    plane = ("restitution", RESTITUTIONS), ("load_factor", 0.0, 10.0), 10
    for ending, s in _SPEEDS.items():
        found = boundaries(pneumatic(s), *plane, kinds=("fold", "flip"))
        if not ending:
            columns["upper"] = found.greatest("fold")
        columns[f"lower{ending}"] = found.greatest("flip")
    return PaperFigure(
        "fig6", "Fig. 6: stable motions of the pneumatic hammer, $m = 10$, $d = 0$", columns, _paint_fig6
    )


def _paint_fig6(figure: PaperFigure, picture: Picture) -> None:
    lines = (
        ("upper", "-", 0, "upper, any $s$"),
        ("lower", "-", 1, "lower, $s\\pi \\to \\infty$"),
        ("lower_10_1", (0, (6, 2)), 1, "lower, B77's $s\\pi = 10.1$"),
        ("lower_10_01", (0, (2, 2)), 1, "lower, B77's $s\\pi = 10.01$"),
    )
    label = "$p_0/p_{10}$  (here: $p_0/p_1$ with $m = 10$)"
    _over_restitution(picture.add_subplot(), figure, lines, (0.0, 0.6), label)


# ---- Fig. 7: impact phase of the hydraulic hammer over κ, for R = 0, 0.1, …, 0.9; no motion is stable (B77 41)


def fig7(seed: int) -> PaperFigure:
    """Columns restitution, kappa, phase [rad], stable, admissible; s → ∞, d = 0, m = 1."""
    parts = [branch_rows(hydraulic(), r, "kappa", *KAPPAS, 90) for r in TENTHS]
    title = "Fig. 7: impact phase of the hydraulic hammer, $m = 1$, $s \\to \\infty$, $d = 0$"
    return PaperFigure("fig7", title, stacked(parts), _paint_fig7, 6.2, 4.8)


def _paint_fig7(figure: PaperFigure, picture: Picture) -> None:
    axes = picture.add_subplot()
    draw_branches(axes, figure.columns, "kappa", inside=False)
    axes.set_yticks([i * math.pi / 2 for i in range(5)], ["0", "π/2", "π", "3π/2", "2π"])
    axes.set(xlim=(1.0, 2.0), ylim=(0.0, 2.0 * math.pi), xlabel="$\\kappa$", ylabel="impact phase φ")
    branch_legend(axes)


# ---- Fig. 8: the greatest κ at which the hydraulic hammer has a motion with one impact in a period (B77 40)


def fig8(seed: int) -> PaperFigure:
    """Columns restitution, kappa (d = 0), kappa_damped (2πd = 0.03); m = 1, any s."""
    columns = {"restitution": RESTITUTIONS}
    for d, name in ((0.0, "kappa"), (DAMPING, "kappa_damped")):
        plane = ("restitution", RESTITUTIONS), ("kappa", *KAPPAS)
        columns[name] = boundaries(hydraulic(d=d), *plane, kinds=("fold",)).greatest("fold")
    return PaperFigure("fig8", "Fig. 8: motions of the hydraulic hammer exist below, $m = 1$", columns, _paint_fig8)


def _paint_fig8(figure: PaperFigure, picture: Picture) -> None:
    axes = picture.add_subplot()
    lines = (("kappa", "-", 0, "$d = 0$"), ("kappa_damped", _DASHED, 0, "$2\\pi d = 0.03$"))
    _over_restitution(axes, figure, lines, (1.0, 2.0), "$\\kappa$")
    axes.text(0.6, 1.25, "motions exist, none of them stable", ha="center")
    axes.text(0.2, 1.8, "no motion", ha="center")


# ---- What B77 cannot see: how the boundaries and the exact multipliers of the pneumatic hammer move with the wave
# speed s
#
# B77's reduced criterion holds for s ≫ 1/π. The exact multipliers of the bar's modes show how fast it becomes right,
# and where an elastic mode grows although it says stable: near the resonances of the impacts, where n s m is a whole
# number. That growth is a property of B77's contact law, which keeps the strain at the impact, and not of bars: waves
# turn the strain over (`percuss.model.Reversed`).

SPEEDS = np.geomspace(0.4, 100.0, 61)
RESTITUTION = 0.5
HALF = 0.5 * math.pi
MODES = 8
_MOST = 1.2
_HEIGHTS = 32  # rows of the map behind the curves


def elastic(seed: int) -> tuple[PaperFigure, ...]:
    """Three figures: the boundaries over s, the largest multiplier over s, and the instability of theory §5."""
    # elastic.csv: s, upper (the fold), lower_reduced, flip, neimark_sacker (of the exact multipliers of 8 modes on the
    # branch that B77 finds stable); R = 0.5, m = 1, 2πd = 0.03; nan where there is none.
    # elastic_multipliers.csv: s, reduced, exact_8, exact_16: largest modulus of the motion with phase beyond π/2 under
    # p = 0.9 + cos t, R = 0.6, m = 1, 2πd = 0.03.
    # elastic_instability.csv: the same for R = 0.8, m = 2, d = 0 and s from 4.5 to 5.5, with columns s, reduced,
    # exact_8, exact_16.
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
        motions = [orbit_on(stretch, place) for place in t.tolist()]
        matrices = [orbit.linear_map(MODES, side).dense() for orbit, side in motions]
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
