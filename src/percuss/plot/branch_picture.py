"""The picture of branches of orbits: phases of the impacts over the parameter, and what happens where."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from percuss import palette
from percuss.errors import ParameterError
from percuss.explore.parameters import label_of
from percuss.model.checks import choice, having, several, text
from percuss.plot.canvas import COLOURS, INK, new_figure, style, titled

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from percuss.explore import (
        Branch,
        BranchPoint,
        Diagram,
        DiagramBranch,
        PointCurve,
        SettledMotion,
    )

EVENT_MARKS = {
    "fold": "s", "flip": "D", "neimark_sacker": "o", "grazing_touch": "v", "grazing_impact_dies": "^", "corner": "P",
    "branch_point": "x", "nonsmooth_fold": "X", "sticking": "*", "onset": "<", "release_lost": ">",
    "label_changes": "p",
}  # fmt: skip
_JUMP = np.pi  # from which on a phase has gone round


def branch(found: Branch, title: str = "") -> Figure:
    """Draw branches: the phases of the impacts, above them the speeds; stable parts solid, unstable ones dashed.

    Parameters
    ----------
    found
        A `percuss.explore.Branch`, drawn with those that were switched to from it.
    title
        What stands above.

    Raises
    ------
    ParameterError
        When it is no branch.

    Examples
    --------
    >>> from percuss import Load, System
    >>> from percuss.explore import follow
    >>> from percuss.steady import orbit_near
    >>> system = System(s=5.0, d=0.0, restitution=0.5, load=Load.harmonic(0.8, 1.0))
    >>> len(branch(follow(orbit_near(system, [2.2], modes=0), "mean", (0.75, 0.9))).axes)
    2
    """
    having("found", found, ("points", "family", "values"), "a percuss.explore.Branch")
    if not len(found.values):
        raise ParameterError("found", str(found), "a branch with points")
    text("title", title, "a text")
    with style():
        figure = new_figure(6.4, 6.0)
        upper, lower = figure.subplots(2, 1, sharex=True)
        marks: dict[str, object] = {}
        for number, one in enumerate(found.family()):
            colour = COLOURS[number % len(COLOURS)]
            for ax, rows in ((upper, one.speeds), (lower, one.phases)):
                _lines(ax, one, rows, colour, one.label if ax is upper else "")
            _marked(upper, lower, one, marks)
        upper.set_ylabel("speed at the impacts, dimensionless")
        lower.set_ylabel("phase of the impacts [rad]")
        lower.set_xlabel(found.parameter)
        lower.set_ylim(0.0, 2.0 * np.pi)
        lower.set_yticks([0.0, np.pi, 2.0 * np.pi], ["0", "π", "2π"])
        _legend(upper)
        titled(figure, title)
    return figure


def _lines(ax: Axes, one: Branch, rows: np.ndarray, colour: str, label: str) -> None:
    """One line for each impact, cut where the stability changes and where a phase goes round."""
    changes = np.flatnonzero(np.diff(one.stable.astype(int))) + 1
    cuts = [0, *changes.tolist(), one.values.size]
    for start, stop in pairwise(cuts):
        part = slice(start, min(stop + 1, one.values.size))
        solid = bool(one.stable[start])
        for row in rows.T:
            y = np.array(row[part])
            gone = np.flatnonzero(np.abs(np.diff(y)) > _JUMP) + 1
            x = np.insert(one.values[part], gone, np.nan)
            ax.plot(x, np.insert(y, gone, np.nan), "-" if solid else "--", color=colour, label=label or "_", lw=1.2)
            label = ""


def _marked(upper: Axes, lower: Axes, one: Branch, marks: dict[str, object]) -> None:
    for point in one.points:
        mark = EVENT_MARKS.get(point.kind.value)
        if mark is None:
            continue
        label = "_" if mark in marks else point.kind.value.replace("_", " ")
        marks[mark] = point
        for ax, heights in ((upper, point.orbit.speeds), (lower, point.orbit.phases)):
            x = np.full(heights.size, point.value)
            ax.plot(x, heights, mark, color=INK, ms=4.0, label=label if ax is upper else "_", ls="")


def _legend(ax: Axes) -> None:
    handles, labels = ax.get_legend_handles_labels()
    kept = dict(zip(labels, handles, strict=True))
    ax.legend(kept.values(), kept.keys(), loc="best", ncols=2)


# ---- The picture of a branch of cycles with rest: releases, rests and the first impacts over the parameter

_MOST = 6
"""Impacts that are drawn: those of a chatter have no last one."""


def rest_branch(found: Branch, title: str = "") -> Figure:
    """Draw cycles with rest: when the bar is let go, strikes and comes to rest; above, how fast it strikes.

    Parameters
    ----------
    found
        A `percuss.explore.Branch`. Its first impacts are drawn.
    title
        What stands above.

    Raises
    ------
    ParameterError
        When it is no such branch.

    Examples
    --------
    >>> from percuss import Load, System
    >>> from percuss.explore import follow_rest_cycle
    >>> from percuss.steady import rest_cycles
    >>> (cycle,) = rest_cycles(System(5.0, 0.0, 0.5, Load.harmonic(0.8, 1.0)), modes=0).cycles
    >>> len(rest_branch(follow_rest_cycle(cycle, "mean", (0.7, 0.9), points=3)).axes)
    2
    """
    having("found", found, ("points", "cycles", "values"), "a percuss.explore.Branch")
    if not len(found.values):
        raise ParameterError("found", str(found), "a branch with points")
    text("title", title, "a text")
    drawn = min(_MOST, *(cycle.speeds.size for cycle in found.cycles))
    rests = min(cycle.release_phases.size for cycle in found.cycles)
    with style():
        figure = new_figure(6.4, 6.0)
        upper, lower = figure.subplots(2, 1, sharex=True)
        for impact in range(drawn):
            label = "_" if impact else found.label
            _line(upper, found.values, [cycle.speeds[impact] for cycle in found.cycles], COLOURS[0], "-", label)
            label = "_" if impact else f"impact{'s' if drawn > 1 else ''}"
            _line(lower, found.values, [cycle.phases[impact] for cycle in found.cycles], COLOURS[0], "-", label)
        for rest in range(rests):
            for name, colour, dashes in (("release", COLOURS[1], "-."), ("rest", COLOURS[2], "--")):
                phases = [getattr(cycle, f"{name}_phases")[rest] for cycle in found.cycles]
                _line(lower, found.values, phases, colour, dashes, "_" if rest else name)
        for point in found.points:
            _rest_marked(
                upper, lower, point.value, point.kind.value, point.cycle.speeds[:drawn], point.cycle.phases[:drawn]
            )
        upper.set_ylabel("speed at the impacts, dimensionless")
        lower.set_ylabel("phase [rad]")
        lower.set_xlabel(found.parameter)
        lower.set_ylim(0.0, 2.0 * np.pi)
        lower.set_yticks([0.0, np.pi, 2.0 * np.pi], ["0", "π", "2π"])
        upper.legend(loc="best")
        lower.legend(loc="best", ncols=3)
        titled(figure, title)
    return figure


def _line(ax: Axes, x: np.ndarray, heights: list[float], colour: str, dashes: str, label: str) -> None:
    """A line, cut where a phase goes round."""
    y = np.array(heights)
    gone = np.flatnonzero(np.abs(np.diff(y)) > np.pi) + 1
    ax.plot(np.insert(x, gone, np.nan), np.insert(y, gone, np.nan), dashes, color=colour, label=label, lw=1.2)


def _rest_marked(upper: Axes, lower: Axes, value: float, kind: str, speeds: np.ndarray, phases: np.ndarray) -> None:
    mark = EVENT_MARKS.get(kind)
    if mark is None:
        return
    for ax, heights in ((upper, speeds), (lower, phases)):
        told = kind.replace("_", " ") if ax is upper else "_"
        ax.plot(np.full(len(heights), value), heights, mark, color=INK, ms=4.0, ls="", label=told)


# ---- The picture of curves over two parameters: folds, flips, grazings …, and the points of codimension two on them

_ENDS = ("limit", "parameter_end", "stopped", "closed", "lost", "load_stops_pushing")
_WORDS = {
    "grazing_touch": "touch", "grazing_impact_dies": "dying impact", "neimark_sacker": "Neimark–Sacker points",
}  # fmt: skip
_MARKS = "sD^vPX*op<>h"


def curves(found: Sequence[PointCurve], title: str = "") -> Figure:
    """Draw curves of `percuss.explore.follow_point` over their two parameters; thin and dotted where no orbit is.

    Parameters
    ----------
    found
        The curves, all of them over the same two parameters.
    title
        What stands above.

    Raises
    ------
    ParameterError
        When there are none, or over different parameters.

    Examples
    --------
    >>> from percuss import Load, System
    >>> from percuss.explore import BranchEvent, follow, follow_point
    >>> from percuss.steady import orbit_near
    >>> system = System(s=5.0, d=0.0, restitution=0.5, load=Load.harmonic(0.65, 1.0))
    >>> branch = follow(orbit_near(system, [0.35, 2.2], modes=0), "mean", (0.64, 0.7))
    >>> flip, = branch.at(BranchEvent.FLIP)
    >>> len(curves([follow_point(flip, ("restitution", "mean"), ((0.49, 0.51), (0.5, 0.8)))]).axes)
    1
    """
    kept = several("found", found, "curves of percuss.explore.follow_point")
    for one in kept:
        having("found", one, ("event", "parameters", "values", "is_orbit"), "curves of percuss.explore.follow_point")
    if not kept or len({(one.parameters, one.units) for one in kept}) > 1:
        raise ParameterError("found", str(len(kept)), "one curve or more, all over the same two parameters")
    text("title", title, "a text")
    with style():
        figure = new_figure(6.4, 4.8)
        ax = figure.subplots()
        kinds = list(dict.fromkeys((one.event.value, one.label) for one in kept))
        for one in kept:
            _curve_line(ax, one, COLOURS[kinds.index((one.event.value, one.label)) % len(COLOURS)])
        _curve_marked(ax, kept)
        for name, unit, side in zip(kept[0].parameters, kept[0].units, "xy", strict=True):
            ax.set(**{f"{side}label": f"{label_of(name)} [{unit}]" if unit else label_of(name)})
        handles, labels = ax.get_legend_handles_labels()
        shown = dict(zip(labels, handles, strict=True))
        figure.legend(shown.values(), shown.keys(), loc="outside lower left", ncols=3)
        titled(figure, title)
    return figure


def _curve_line(ax: Axes, one: PointCurve, colour: str) -> None:
    name = f"{_WORDS.get(one.event.value, one.event.value)} of {one.label}"
    ax.plot(*one.values.T, ":", color=colour, lw=0.8)
    ax.plot(*one.real.T, "-", color=colour, lw=1.4, label=name)


def _curve_marked(ax: Axes, found: Sequence[PointCurve]) -> None:
    marks: dict[str, Any] = {}
    for one in found:
        for point in one.points:
            word = point.kind.value
            if word in _ENDS:
                continue
            mark = marks.setdefault(word, _MARKS[len(marks) % len(_MARKS)])
            place = np.array(point.values)[:, None]
            ax.plot(*place, mark, color=INK, ms=4.5, ls="", label=word.replace("_", " "))


# ---- The picture of a diagram: what simulations settle on as points, the branches of all orbits as lines, their events

QUANTITIES = ("phase", "speed", "energy")
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
            for line in _diagram_lines(found):
                _diagram_line(ax, line, quantity, colours[line.label])
            if quantity == "phase":
                for rests in found.rest_branches:
                    _rests(ax, rests, colours[rests.label])
            for line in _diagram_lines(found):
                _events(ax, line, quantity)
            for line in found.impossible:
                _thin(ax, line, quantity)
            _label(ax, found, quantity)
        unit = f" [{found.axis.unit}]" if found.axis.unit else ""
        panels[-1].set_xlabel(f"{label_of(found.axis.name)}{unit}")
        panels[-1].set_xlim(float(found.axis.values.min()), float(found.axis.values.max()))
        _diagram_legend(figure, panels[0], found)
        titled(figure, title)
    return figure


def _diagram_lines(found: Diagram) -> tuple[DiagramBranch, ...]:
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


def _rows(line: DiagramBranch, quantity: str) -> np.ndarray[Any, np.dtype[np.float64]]:
    """What is drawn of a branch; shape (m, lines)."""
    size = line.values.size
    if quantity == "phase":
        return line.phases.reshape(size, -1)
    scales = np.ones((size, 2)) if line.scales is None else line.scales
    if quantity == "speed":
        return line.speeds.reshape(size, -1) * scales[:, :1]
    return (line.energies * scales[:, 1])[:, None]


def _diagram_line(ax: Axes, line: DiagramBranch, quantity: str, colour: str) -> None:
    """One line for each impact, cut where the stability changes and where a phase goes round."""
    changes = np.flatnonzero(np.diff(line.stable.astype(int))) + 1
    for start, stop in pairwise([0, *changes.tolist(), line.values.size]):
        part = slice(max(start - 1, 0), stop)
        solid = bool(line.stable[start])
        for row in _rows(line, quantity).T:
            x, y = _cut(line.values[part], np.array(row[part]), quantity)
            ax.plot(x, y, "-" if solid else "--", color=colour, lw=1.4 if solid else 0.9, label="_", zorder=2)


def _rests(ax: Axes, line: DiagramBranch, colour: str) -> None:
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


def _events(ax: Axes, line: DiagramBranch, quantity: str) -> None:
    for point in line.points:
        mark = EVENT_MARKS.get(point.kind.value)
        if mark is not None:
            heights = _point_heights(line, point, quantity)
            x, label = np.full(len(heights), point.value), point.kind.value.replace("_", " ")
            edge = 1.0 if mark == "x" else 0.0  # which has no face
            ax.plot(x, heights, mark, color=INK, ms=3.5, mew=edge, ls="", label=label, zorder=3)


def _point_heights(line: DiagramBranch, point: BranchPoint, quantity: str) -> list[float]:
    if quantity == "phase":
        return list(point.plain.phases.tolist())
    row = int(np.argmin(np.abs(line.values - point.value)))
    speed, energy = (1.0, 1.0) if line.scales is None else line.scales[row]
    return [point.plain.energy * energy] if quantity == "energy" else list((point.plain.speeds * speed).tolist())


def _label(ax: Axes, found: Diagram, quantity: str) -> None:
    unit = _UNITS.get(quantity, "")
    words = f" [{unit}]" if found.is_si else ", dimensionless"
    ax.set_ylabel(_TITLES[quantity] + (words if unit else ""))
    if quantity == "phase":
        ax.set_ylim(0.0, 2.0 * np.pi)
        ax.set_yticks([0.0, np.pi, 2.0 * np.pi], ["0", "π", "2π"])


_MOST_TOLD = 14  # labels of branches that the legend tells of


def _diagram_legend(figure: Figure, ax: Axes, found: Diagram) -> None:
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


def _labels(lines: Sequence[DiagramBranch]) -> list[str]:
    """Each label once, in the order in which they come."""
    return list(dict.fromkeys(line.label for line in lines))


def _colours(found: Diagram) -> dict[str, str]:
    """The colour of each label: cycles with rest take it from the other end, so that few labels share none."""
    orbits, rests = _labels(found.branches), _labels(found.rest_branches)
    given = {label: COLOURS[i % len(COLOURS)] for i, label in enumerate(orbits)}
    return given | {label: COLOURS[-1 - i % len(COLOURS)] for i, label in enumerate(rests)}
