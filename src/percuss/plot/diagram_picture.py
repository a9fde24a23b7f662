"""The picture of a diagram: what simulations settle on as points, the branches of all orbits as lines, their events."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from percuss import palette
from percuss.errors import ParameterError
from percuss.explore.parameters import label_of
from percuss.model.checks import choice, having, text
from percuss.plot.branch_picture import EVENT_MARKS
from percuss.plot.canvas import COLOURS, INK, new_figure, style, titled

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from percuss.explore import Diagram, DiagramBranch, DiagramPoint, DiagramRestBranch, SettledMotion

__all__ = ["diagram"]

QUANTITIES = ("phase", "speed", "energy")
_JUMP = np.pi  # from which on a phase has gone round
_TITLES = {"phase": "phase of the impacts [rad]", "speed": "speed at the impacts", "energy": "mean blow energy"}
_UNITS = {"speed": "m/s", "energy": "J"}
_RESTS = {"release_phases": ("is let go", "-."), "rest_phases": ("comes to rest", ":")}


def diagram(found: Diagram, title: str = "", quantities: tuple[str, ...] = ("phase", "speed")) -> Figure:
    """Draw a diagram: simulated motions as points, branches as lines, stable parts solid, unstable ones dashed.

    Thin lines are roots of the equations beyond an end of a branch, which are no motions. Of a cycle with rest
    the first impacts after each release are drawn, and among the phases when it is let go and comes to rest.

    Parameters
    ----------
    found
        A `percuss.explore.Diagram`.
    title
        What stands above.
    quantities
        What is shown over the parameter, one panel each: ``phase`` and ``speed`` of the impacts, ``energy``, the mean
        energy of a blow; in SI where the diagram is.

    Raises
    ------
    ParameterError
        When it is no diagram, or a quantity is none of these.

    Examples
    --------
    >>> from percuss import Load, System
    >>> from percuss.explore import diagram as made
    >>> system = System(s=5.0, d=0.0, restitution=0.5, load=Load.harmonic(0.8, 1.0))
    >>> found = made(system, "mean=0.75:0.9:3", up_to=(1, 1), searched=1, switch=0, starts=1, runs=0, modes=0)
    >>> len(diagram(found).axes)
    2
    """
    having("found", found, ("settled", "branches", "axis"), "a percuss.explore.Diagram")
    text("title", title, "a text")
    if not isinstance(quantities, tuple) or not quantities:
        raise ParameterError("quantities", quantities, f"some of {', '.join(QUANTITIES)}")
    for quantity in quantities:
        choice("quantities", quantity, *QUANTITIES)
    with style():
        figure = new_figure(7.2, 1.2 + 2.9 * len(quantities))
        panels: list[Axes] = list(np.atleast_1d(figure.subplots(len(quantities), 1, sharex=True)))
        colours = _colours(found)
        for ax, quantity in zip(panels, quantities, strict=True):
            _points(ax, found, quantity)
            for line in _lines(found):
                _line(ax, line, quantity, colours[line.label])
            if quantity == "phase":
                for rests in found.rest_branches:
                    _rests(ax, rests, colours[rests.label])
            for line in _lines(found):
                _events(ax, line, quantity)
            for line in found.impossible:
                _thin(ax, line, quantity)
            _label(ax, found, quantity)
        unit = f" [{found.axis.unit}]" if found.axis.unit else ""
        panels[-1].set_xlabel(f"{label_of(found.axis.name)}{unit}")
        panels[-1].set_xlim(float(found.axis.values.min()), float(found.axis.values.max()))
        _legend(figure, panels[0], found)
        titled(figure, title)
    return figure


_Line: TypeAlias = "DiagramBranch | DiagramRestBranch"


def _lines(found: Diagram) -> tuple[_Line, ...]:
    """All that is drawn as lines of motions."""
    return (*found.branches, *found.rest_branches)


def _points(ax: Axes, found: Diagram, quantity: str) -> None:
    """What simulations settled on, in the colours of their families."""
    for number, family in enumerate(palette.FAMILIES):
        mine = [one for one in found.settled if palette.family_of(one.label) == number]
        rows = [(one.value, y) for one in mine for y in _heights(one, quantity)]
        if rows:
            x, y = np.array(rows).T
            ax.plot(x, y, ".", ms=3.6, color=family.colour.light, mew=0.0, label=family.name, zorder=1)


def _heights(one: SettledMotion, quantity: str) -> list[float]:
    speed, energy = one.scales or (1.0, 1.0)
    if quantity == "energy":
        return [one.energy * energy] if np.isfinite(one.energy) else []
    return list((one.phases if quantity == "phase" else one.speeds * speed).tolist())


def _rows(line: _Line, quantity: str) -> np.ndarray[Any, np.dtype[np.float64]]:
    """What is drawn of a branch; shape (m, lines)."""
    size = line.values.size
    if quantity == "phase":
        return line.phases.reshape(size, -1)
    scales = np.ones((size, 2)) if line.scales is None else line.scales
    if quantity == "speed":
        return line.speeds.reshape(size, -1) * scales[:, :1]
    return (line.energies * scales[:, 1])[:, None]


def _line(ax: Axes, line: _Line, quantity: str, colour: str) -> None:
    """One line for each impact, cut where the stability changes and where a phase goes round."""
    changes = np.flatnonzero(np.diff(line.stable.astype(int))) + 1
    for start, stop in pairwise([0, *changes.tolist(), line.values.size]):
        part = slice(max(start - 1, 0), stop)
        solid = bool(line.stable[start])
        for row in _rows(line, quantity).T:
            x, y = _cut(line.values[part], np.array(row[part]), quantity)
            ax.plot(x, y, "-" if solid else "--", color=colour, lw=1.4 if solid else 0.9, label="_", zorder=2)


def _rests(ax: Axes, line: DiagramRestBranch, colour: str) -> None:
    """Between which phases a cycle with rest lies on the wall."""
    for name, (_, dashes) in _RESTS.items():
        for row in getattr(line, name).T:
            x, y = _cut(line.values, row, "phase")
            ax.plot(x, y, dashes, color=colour, lw=1.0, label="_", zorder=2)


def _thin(ax: Axes, line: DiagramBranch, quantity: str) -> None:
    """Beyond an end, where the roots of the equations are no motions."""
    for row in _rows(line, quantity).T:
        x, y = _cut(line.values, row, quantity)
        ax.plot(x, y, "-", color=INK, alpha=0.45, lw=0.5, label="_", zorder=1.5)


def _cut(
    x: np.ndarray[Any, Any], y: np.ndarray[Any, Any], quantity: str
) -> tuple[np.ndarray[Any, Any], np.ndarray[Any, Any]]:
    """A line with gaps where a phase goes round."""
    gone = np.flatnonzero(np.abs(np.diff(y)) > _JUMP) + 1 if quantity == "phase" else np.array([], dtype=int)
    return np.insert(x, gone, np.nan), np.insert(y, gone, np.nan)


def _events(ax: Axes, line: _Line, quantity: str) -> None:
    for point in line.points:
        mark = EVENT_MARKS.get(point.kind.value)
        if mark is not None:
            heights = _point_heights(line, point, quantity)
            x, label = np.full(len(heights), point.value), point.kind.value.replace("_", " ")
            edge = 1.0 if mark == "x" else 0.0  # which has no face
            ax.plot(x, heights, mark, color=INK, ms=3.5, mew=edge, ls="", label=label, zorder=3)


def _point_heights(line: _Line, point: DiagramPoint, quantity: str) -> list[float]:
    if quantity == "phase":
        return list(point.phases.tolist())
    row = int(np.argmin(np.abs(line.values - point.value)))
    speed, energy = (1.0, 1.0) if line.scales is None else line.scales[row]
    return [point.energy * energy] if quantity == "energy" else list((point.speeds * speed).tolist())


def _label(ax: Axes, found: Diagram, quantity: str) -> None:
    unit = _UNITS.get(quantity, "")
    words = f" [{unit}]" if found.is_si else ", dimensionless"
    ax.set_ylabel(_TITLES[quantity] + (words if unit else ""))
    if quantity == "phase":
        ax.set_ylim(0.0, 2.0 * np.pi)
        ax.set_yticks([0.0, np.pi, 2.0 * np.pi], ["0", "π", "2π"])


_MOST_TOLD = 14  # labels of branches that the legend tells of


def _legend(figure: Figure, ax: Axes, found: Diagram) -> None:
    """Beside the panels: families of points, labels of branches, how they are drawn, events."""
    from matplotlib.lines import Line2D

    handles, labels = ax.get_legend_handles_labels()
    kept = dict(zip(labels, handles, strict=True))
    points = {family.name: kept[family.name] for family in palette.FAMILIES if family.name in kept}
    named = {*[*_labels(found.rest_branches), *_labels(found.branches)][:_MOST_TOLD]}
    lines = {label: Line2D([], [], color=c, lw=1.4) for label, c in _colours(found).items() if label in named}
    ways = {"stable": Line2D([], [], color=INK, lw=1.4), "unstable": Line2D([], [], color=INK, lw=0.9, ls="--")}
    if found.impossible:
        ways["not a motion"] = Line2D([], [], color=INK, alpha=0.45, lw=0.5)
    if found.rest_branches and ax.get_ylabel() == _TITLES["phase"]:
        ways |= {words: Line2D([], [], color=INK, lw=1.0, ls=dashes) for words, dashes in _RESTS.values()}
    marks = {name: handle for name, handle in kept.items() if name not in points}
    told = [*points.items(), *lines.items(), *(ways.items() if lines else ()), *marks.items()]
    if told:
        names, drawn = zip(*told, strict=True)
        figure.legend(drawn, names, loc="outside right upper", frameon=False, markerscale=1.8)


def _labels(lines: Sequence[_Line]) -> list[str]:
    """Each label once, in the order in which they come."""
    return list(dict.fromkeys(line.label for line in lines))


def _colours(found: Diagram) -> dict[str, str]:
    """The colour of each label: cycles with rest take it from the other end, so that few labels share none."""
    orbits, rests = _labels(found.branches), _labels(found.rest_branches)
    given = {label: COLOURS[i % len(COLOURS)] for i, label in enumerate(orbits)}
    return given | {label: COLOURS[-1 - i % len(COLOURS)] for i, label in enumerate(rests)}
