"""The picture of a hammer that fits measured blows: each figure over the blows, and the residuals."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from percuss.model.checks import having
from percuss.plot.canvas import COLOURS, INK, canvas

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from percuss.case.answers.exploring.identify import IdentifyAnswer


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
