"""Pictures of whole hammers: side by side, about the best of a search, within tolerances, and fitted to their blows."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from percuss.case.answers.whole_hammer import whole_figure
from percuss.model.checks import having
from percuss.plot.blow_picture import draw_forces, draw_stresses
from percuss.plot.canvas import COLOURS, INK, canvas, legend_above, nothing, units_of, wall

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from percuss.case.answers.exploring.comparison import Comparison
    from percuss.case.answers.exploring.design import DesignPlane
    from percuss.case.answers.exploring.identify import IdentifyAnswer
    from percuss.case.answers.exploring.tolerance import Spread, ToleranceAnswer

_POINTS = 721


def comparison(answer: Comparison) -> Figure:
    """Draw hammers side by side.

    Two panels: (a) the striking end of each between two blows; (b) by how much the figures differ from those of the
    first. Where each has a tool three more: (c) the force between the faces, (d) that on the rock, (e) the greatest
    stress of each section.

    Examples
    --------
    >>> from percuss.case import compare, load_case
    >>> from percuss.plot import comparison
    >>> drifter = load_case("valve-drifter")
    >>> both = compare([drifter, drifter.varied({"contact.restitution": 0.3})], modes=0)
    >>> len(comparison(both).axes)
    5
    """
    having("answer", answer, ("figures", "differences"), "a comparison, such as percuss.case.compare gives")
    title = " / ".join(f"{letter} {name}" for letter, name in zip(answer.letters, answer.names, strict=True))
    blows = [(blow, _colour(i), answer.letters[i]) for i, blow in enumerate(answer.blows)]
    on_rock = bool(blows) and all(blow.blow.bit_force is not None for blow, *_ in blows)
    with canvas(11.0, 8.5 if blows else 4.5, title) as figure:
        grid = figure.add_gridspec(2 if blows else 1, 6)
        _cycles(figure.add_subplot(grid[0, :4]), answer)
        _changes(figure.add_subplot(grid[0, 4:]), answer)
        if blows:
            wide = 2 if on_rock else 3
            draw_forces(figure.add_subplot(grid[1, :wide]), blows, "face_force", "(c) force between the faces")
            if on_rock:
                draw_forces(figure.add_subplot(grid[1, 2:4]), blows, "bit_force", "(d) force on the rock")
            mark = "(e)" if on_rock else "(d)"
            draw_stresses(figure.add_subplot(grid[1, -wide:]), blows, f"{mark} greatest stresses")
        for narrow in figure.axes[2:]:  # whose colours are those of (a)
            narrow.get_legend().remove()  # type: ignore[union-attr]
    return figure


def _colour(i: int) -> str:
    return COLOURS[i % len(COLOURS)]


def _cycles(axes: Any, answer: Comparison) -> None:
    axes.set_title("(a) the striking end between two blows")
    for i, motion in enumerate(answer.motions):
        if motion is None:
            continue
        units = units_of(answer.cases[i].hammer)
        times = np.linspace(0.0, motion.period, _POINTS)
        line = "-" if answer.runs[i] else "--"
        axes.plot(
            times * units.time, motion.motion(times) * units.length, line, color=_colour(i), label=answer.letters[i]
        )
        axes.set(xlabel=units.time_label, ylabel=units.length_label)
    if not any(answer.motions):
        nothing(axes, "no motion")
        return
    wall(axes, answer.blows or None)
    axes.set_xlim(left=0.0)
    legend_above(axes, columns=8)


def _changes(axes: Any, answer: Comparison) -> None:
    """Bars of the relative differences from the first hammer."""
    rows = [row for row in answer.figures if any(row.changes[1:])][::-1]
    axes.set(title="(b) beside A", xlabel="difference [%]")
    wide = 0.8 / (len(answer.cases) - 1)
    for i in range(1, len(answer.cases)):
        places = np.arange(len(rows)) - (i - 0.5 * len(answer.cases)) * wide
        axes.barh(places, [100.0 * (row.changes[i] or 0.0) for row in rows], wide, color=_colour(i))
    axes.set_yticks(np.arange(len(rows)), [row.label for row in rows], fontsize=7)
    axes.axvline(0.0, color=INK, linewidth=0.6)


def design_plane(plane: DesignPlane) -> Figure:
    """Draw which hammers about the best one keep the limits, what they have, and what the others miss.

    Examples
    --------
    >>> from percuss.case import Limit, Span, design, load_case
    >>> from percuss.plot import design_plane
    >>> spans = [Span.parsed("load.ports[0].behind=8:24mm"), Span.parsed("load.pressure=120:200bar")]
    >>> limits = [Limit.parsed("flow=60 l/min", "below", True)]
    >>> found = design(load_case("valve-drifter"), spans, "blow_energy", limits, modes=0, most=40)
    >>> len(design_plane(found.plane(5)).axes)
    2
    """
    from matplotlib.colors import to_rgba
    from matplotlib.patches import Patch

    having("plane", plane, ("answer", "missed"), "what DesignAnswer.plane gives")
    answer, inside = plane.answer, plane.missed == -1
    figure, spans = whole_figure(answer.figure), answer.spans[:2]
    kept = np.ma.masked_where(~inside, plane.values)
    scale, unit = figure.axis(float(np.abs(kept).max()) if inside.any() else 0.0, answer.case.is_si)
    with canvas(7.5, 5.5, answer.case.title) as drawn:
        axes = drawn.subplots()
        colours = [to_rgba(COLOURS[(k + 1) % len(COLOURS)], 0.3) for k in range(len(answer.limits))] + [to_rgba("0.85")]
        words = [f"{limit.figure} missed" for limit in answer.limits] + ["none runs"]
        looks = np.array([*colours, (1.0, 1.0, 1.0, 0.0)])[plane.missed]  # the last one: where all limits are kept
        half = [0.5 * (values[1] - values[0]) for values in (plane.x, plane.y)]
        box = (plane.x[0] - half[0], plane.x[-1] + half[0], plane.y[0] - half[1], plane.y[-1] + half[1])
        axes.imshow(looks.transpose(1, 0, 2), origin="lower", extent=box, aspect="auto", interpolation="nearest")
        if inside.any():
            shown = axes.pcolormesh(plane.x, plane.y, scale * kept.T, shading="nearest", cmap="viridis")
            drawn.colorbar(shown, ax=axes, label=f"{figure.label} [{unit}]" if unit else figure.label)
        axes.plot(*answer.values[:2], "D", color="white", markeredgecolor=INK, label="the best")
        own = answer.own_values[:2]
        if all(x is not None and span.low <= x <= span.high for x, span in zip(own, spans, strict=True)):
            axes.plot(*own, "o", color="white", markeredgecolor=INK, label="the case")  # type: ignore[arg-type]
        missed = [Patch(color=colours[k], label=words[k]) for k in np.unique(plane.missed[~inside])]
        marks, _ = axes.get_legend_handles_labels()
        drawn.legend(handles=[*marks, *missed], loc="outside lower center", ncols=4, fontsize=7)
        axes.set(xlabel=f"{spans[0].name} [{spans[0].unit}]", ylabel=f"{spans[1].name} [{spans[1].unit}]")
    return drawn


# ---- Hammers within tolerances

_SHOWN = ("rock_power", "blow_energy", "blow_rate", "steel.stress", "margin", "stroke", "impact_velocity")
_PANELS = 5


def tolerance(answer: ToleranceAnswer) -> Figure:
    """Draw the share of each tolerance in the variance of the main figure, and how the figures spread.

    Examples
    --------
    >>> from percuss.case import load_case, parsed_tolerance, tolerance
    >>> from percuss.plot import tolerance as picture
    >>> case = load_case("valve-breaker")
    >>> found = tolerance(case, [parsed_tolerance("load.pressure=±5%", case)], ["blow_energy"], samples=64, modes=0)
    >>> len(picture(found).axes)
    2
    """
    having("answer", answer, ("spreads", "ranked"), "what percuss.case.tolerance gives")
    told = {one.name: one for one in answer.spreads}
    shown = [told.pop(name) for name in _SHOWN if name in told][:_PANELS]
    shown = [*shown, *told.values()][:_PANELS]
    rows = math.ceil((len(shown) + 1) / 2)
    with canvas(10.0, 2.9 * rows + 0.6, f"{answer.case.title}: {len(answer.drawn['runs'])} hammers drawn") as figure:
        axes = figure.subplots(rows, 2, squeeze=False).ravel()
        _shares(axes[0], answer)
        for i, spread in enumerate(shown):
            _spread(axes[i + 1], answer, spread, f"({'bcdefg'[i]})")
        for one in axes[len(shown) + 1 :]:
            one.remove()
    return figure


def _shares(axes: Any, answer: ToleranceAnswer) -> None:
    main = answer.main
    if main is None or not answer.ranked:
        axes.set_title("(a) what dominates")
        nothing(axes, "not told: too many hammers do not run")
        return
    axes.set_title(f"(a) shares of the variance of the {whole_figure(main.name).label}")
    rows = answer.ranked[::-1]
    places = np.arange(len(rows))
    axes.barh(places + 0.2, [100.0 * total for *_, total in rows], 0.38, color=COLOURS[0], label="in all")
    axes.barh(places - 0.2, [100.0 * first for _, first, _ in rows], 0.38, color=COLOURS[1], label="alone")
    axes.set_yticks(places, [one.name for one, *_ in rows])
    axes.set_xlabel("%")
    axes.legend(loc="lower right")


def _spread(axes: Any, answer: ToleranceAnswer, spread: Spread, mark: str) -> None:
    figure, is_si = whole_figure(spread.name), answer.case.is_si
    axes.set_title(f"{mark} {figure.label}")
    values = answer.drawn[spread.name]
    values = values[np.isfinite(values)]
    scale, unit = figure.axis(float(np.abs(values).max(initial=0.0)), is_si)
    bins = 40 if float(np.ptp(values)) > 1e-9 * float(np.abs(values).max(initial=0.0)) else 1
    axes.hist(values * scale, bins, color=COLOURS[0], alpha=0.5)
    for place, line, label in (
        (spread.nominal, "-", "as drawn"), (spread.low, ":", "nine of ten"), (spread.high, ":", None)
    ):  # fmt: skip
        axes.axvline(place * scale, linestyle=line, color=INK, label=label)
    axes.set(xlabel=unit, yticks=[])
    if mark == "(b)":
        axes.legend(loc="upper right")


# ---- Numbers from measured blows


def identify(answer: IdentifyAnswer) -> Figure:
    """Draw each measured figure over the number of the blow, with that of the hammer that fits; below the residuals.

    Examples
    --------
    >>> import numpy as np
    >>> from percuss.case import identify, load_case
    >>> from percuss.plot import identify as picture
    >>> from percuss.recordings import BlowRecord
    >>> noise = np.random.default_rng(1).normal(size=(2, 100))
    >>> record = BlowRecord(np.cumsum(0.11 + 1e-4 * noise[0]), {"rebound_velocity": 1.4 + 0.01 * noise[1]})
    >>> len(picture(identify(load_case("valve-breaker"), record, modes=0)).axes)
    4
    """
    having("answer", answer, ("means", "figures"), "what percuss.case.identify gives")
    columns = len(answer.figures)
    with canvas(1.5 + 3.6 * columns, 5.0, f"{answer.case.title}: {answer.means.blows[-1] + 1} blows") as figure:
        axes = figure.subplots(2, columns, squeeze=False, sharex=True, height_ratios=(2, 1))
        for i, one in enumerate(answer.figures):
            blows, series = answer.means.blows, answer.means.series[one.name]
            scale, unit = one.figure.axis(float(np.abs(series).max()), True)
            _measured(axes[0, i], blows, series * scale)
            axes[0, i].axhline(one.fitted * scale, color=COLOURS[1], label="fitted")
            if one.own is not None:
                axes[0, i].axhline(one.own * scale, color=INK, linestyle=":", label="the case")
            axes[0, i].set(title=f"({'abcde'[i]}) {one.figure.label}", ylabel=unit)
            _measured(axes[1, i], blows, 100.0 * (series / one.fitted - 1.0))
            axes[1, i].axhline(0.0, color=COLOURS[1])
            axes[1, i].set(xlabel="number of the blow", ylabel="residual [%]")
        axes[0, 0].legend(loc="upper right")
    return figure


def _measured(axes: Any, blows: Any, values: Any) -> None:
    axes.plot(blows, values, ".", color=COLOURS[0], markersize=3.0, label="measured")
