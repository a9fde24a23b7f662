"""The picture of the tolerances of a hammer: what dominates, and the figures of all that were drawn."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from percuss.case.answers.whole_hammer import whole_figure
from percuss.model.checks import having
from percuss.plot.canvas import COLOURS, INK, canvas, nothing

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from percuss.case.answers.exploring.tolerance import Spread, ToleranceAnswer

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
