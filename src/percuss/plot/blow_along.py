"""What happens along striker and rod in a blow: the waves over place and time, and the greatest stresses."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from percuss import palette
from percuss.model.checks import Array
from percuss.plot.canvas import INK, legend_above, ramp

if TYPE_CHECKING:
    from percuss.blow.striker import Sections
    from percuss.plot.shown_blow import ShownBlow

__all__ = ["greatest_stresses", "waves_along"]

_TIMES, _CELLS = 400, 300
_REACH = 4.0
"""Of an endless rod: lengths of the striker that are shown."""


def waves_along(figure: Any, axes: Any, answer: ShownBlow, last: float, mark: str) -> None:
    """The stress over place and time."""
    from matplotlib.colors import TwoSlopeNorm

    from percuss.blow.over_time import cells_over_time

    clock, time = (1e6, "time [µs]") if answer.is_si else (1.0, "time [rad]")
    edges = np.linspace(0.0, last, _TIMES + 1)
    own, rod = cells_over_time(answer.blow, 0.5 * (edges[1:] + edges[:-1]), _CELLS, _reach(answer))
    bodies = [(own.edges - own.edges[-1], own.force / _areas(answer, 0)[own.section])]
    if rod is not None:
        bodies.append((rod.edges, rod.force / _areas(answer, 1)[rod.section]))
    scale = -1e-6 if answer.is_si else -1.0  # tension positive
    top = max(float(abs(stress).max()) for _, stress in bodies) * abs(scale) or 1.0
    for places, stress in bodies:
        image = axes.pcolormesh(
            places, edges * clock, stress * scale, cmap=ramp(palette.STRAIN), norm=TwoSlopeNorm(0.0, -top, top),
            rasterized=True,
        )  # fmt: skip
    for step in _steps(answer):
        axes.axvline(step, color=INK, linewidth=0.4, linestyle=":")
    axes.axvline(0.0, color=INK, linewidth=1.0)
    axes.set_xlim(bodies[0][0][0], bodies[-1][0][-1])
    bar = figure.colorbar(image, ax=axes, fraction=0.03, pad=0.01)
    bar.set_label(f"stress [MPa], {palette.SIGN}" if answer.is_si else f"force, {palette.SIGN}")
    axes.set_ylabel(time)
    axes.set_xlabel(_place(answer))
    axes.set_title(f"{mark} waves in the striker (left of the face) and in what it strikes")


def greatest_stresses(axes: Any, answer: ShownBlow, mark: str) -> None:
    """The greatest compression and tension at every place, with the exact ones of the sections as dots."""
    from percuss.blow.envelope import force_envelope

    scale = 1e-6 if answer.is_si else 1.0
    bodies = [body for body in force_envelope(answer.blow, _CELLS, _reach(answer)) if body is not None]
    kinds = (("compression", -scale, palette.STRAIN[1].light), ("tension", scale, palette.STRAIN[-2].light))
    for which, body in enumerate(bodies):
        start = -float(body.edges[-1]) if which == 0 else 0.0
        area = _areas(answer, which)
        for name, sign, colour in kinds:
            values = sign * getattr(body, name) / area[body.section]
            axes.stairs(values, body.edges + start, color=colour, fill=True, alpha=0.55,
                        label=name if which == 0 else None)  # fmt: skip
            for peak in answer.peaks[which]:
                place = getattr(peak, f"{name}_place")
                if place is not None:
                    axes.plot(place + start, sign * getattr(peak, name), ".", color=INK, markersize=4.0)
    for step in _steps(answer):
        axes.axvline(step, color=INK, linewidth=0.4, linestyle=":")
    axes.axvline(0.0, color=INK, linewidth=1.0)
    axes.axhline(0.0, color=INK, linewidth=0.6)
    axes.plot([], [], ".", color=INK, markersize=4.0, label="greatest of a section")
    legend_above(axes)
    axes.set_xlabel(_place(answer))
    axes.set_ylabel("stress [MPa]" if answer.is_si else "force")
    axes.set_title(f"{mark} greatest {'stress' if answer.is_si else 'force'} at each place")


def _place(answer: ShownBlow) -> str:
    return "place from the struck face [m]" if answer.is_si else "place from the struck face"


def _striker(answer: ShownBlow) -> Sections:
    from percuss.blow.striker import striker_sections

    return striker_sections(answer.blow.striker)


def _reach(answer: ShownBlow) -> float:
    """How far an endless rod is shown: m, or times of a wave."""
    sections = _striker(answer)
    return _REACH * float((sections.length if answer.is_si else sections.transit).sum())


def _lengths(answer: ShownBlow) -> tuple[Array, Array]:
    """Of the sections of striker and rod."""
    from percuss.blow.striker import rod_sections

    rod = answer.rod
    return _striker(answer).length, np.zeros(0) if rod is None else rod_sections(rod, answer.blow.striker).length


def _steps(answer: ShownBlow) -> list[float]:
    """Where sections meet, from the struck face."""
    own, rod = _lengths(answer)
    return [*(np.cumsum(own)[:-1] - own.sum()).tolist(), *np.cumsum(rod)[:-1].tolist()]


def _areas(answer: ShownBlow, which: int) -> Array:
    """Of the sections of striker or rod; 1 where they are not known, so that stresses are forces."""
    pieces = answer.pieces[which]
    return np.array([piece.area for piece in pieces]) if pieces else np.ones(_lengths(answer)[which].size)
