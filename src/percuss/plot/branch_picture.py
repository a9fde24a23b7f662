"""The pictures of branches: what the impacts are over one parameter, what happens where, and curves over two."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from percuss import palette
from percuss.errors import ParameterError
from percuss.explore.parameters import label_of
from percuss.model.checks import choice, having, several, text
from percuss.plot.canvas import COLOURS, INK, canvas, named_once, segments

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from percuss.explore import Branch, BranchPoint, Diagram, PointCurve, SettledMotion
    from percuss.model.checks import Array

EVENT_MARKS = {
    "fold": "s", "flip": "D", "neimark_sacker": "o", "grazing_touch": "v", "grazing_impact_dies": "^", "corner": "P",
    "branch_point": "x", "nonsmooth_fold": "X", "sticking": "*", "onset": "<", "release_lost": ">",
    "label_changes": "p",
}  # fmt: skip
_JUMP = np.pi  # from which on a phase has gone round
QUANTITIES = ("phase", "speed", "energy")
_TITLES = {"phase": "phase of the impacts [rad]", "speed": "speed at the impacts", "energy": "mean blow energy"}
_UNITS = {"speed": "m/s", "energy": "J"}
_RESTS = {"release_phases": ("is let go", "-."), "rest_phases": ("comes to rest", ":")}


# ---- What every picture of a branch draws of it: a line for each impact, its rests, and what happens at its points


def _draw(
    ax: Axes, line: Branch, quantity: str, colour: str, widths: tuple[float, float] = (1.2, 1.2),
    label: str = "_",
) -> None:  # fmt: skip
    """A line for each impact, solid where stable and dashed elsewhere; among phases those of releases and rests."""
    rows = _rows(line, quantity)
    for part, solid in segments(line.stable):
        for row in rows.T:
            x, y = _cut(line.values[part], row[part], quantity)
            ax.plot(x, y, "-" if solid else "--", color=colour, label=label, lw=widths[not solid], zorder=2)
            label = "_"
    if quantity == "phase" and line.has_rest:
        for name, (words, dashes) in _RESTS.items():
            for row in getattr(line, name).T:
                ax.plot(*_cut(line.values, row, quantity), dashes, color=colour, lw=1.0, label=words, zorder=2)


def _rows(line: Branch, quantity: str) -> Array:
    """What is drawn of a branch; shape (m, lines)."""
    size = line.values.size
    if quantity == "phase":
        return line.phases.reshape(size, -1)
    scales = getattr(line, "scales", None)
    speed, energy = (1.0, 1.0) if scales is None else (scales[:, :1], scales[:, 1])
    return line.speeds.reshape(size, -1) * speed if quantity == "speed" else (line.energies * energy)[:, None]


def _cut(x: Array, y: Array, quantity: str) -> tuple[Array, Array]:
    """A line with gaps where a phase goes round."""
    gone = np.flatnonzero(np.abs(np.diff(y)) > (_JUMP if quantity == "phase" else np.inf)) + 1
    return np.insert(x, gone, np.nan), np.insert(y, gone, np.nan)


def _mark(ax: Axes, line: Branch, quantity: str, size: float = 4.0) -> None:
    """What happens at the points of a branch, where it is something to be marked."""
    for point in line.points:
        mark = EVENT_MARKS.get(point.kind.value)
        if mark is not None:
            heights = _point_heights(line, point, quantity)
            look: dict[str, Any] = {"ms": size, "mew": float(mark == "x"), "ls": "", "zorder": 3}  # a cross has no face
            word = point.kind.value.replace("_", " ")
            ax.plot(np.full(len(heights), point.value), heights, mark, color=INK, label=word, **look)


def _point_heights(line: Branch, point: BranchPoint, quantity: str) -> list[float]:
    motion: Any = point.motion
    drawn, scales = line.phases[0].size, getattr(line, "scales", None)
    if quantity == "phase":
        return list(motion.phases[:drawn].tolist())
    speed, energy = (1.0, 1.0) if scales is None else scales[int(np.argmin(np.abs(line.values - point.value)))]
    return [motion.energy * energy] if quantity == "energy" else list((motion.speeds[:drawn] * speed).tolist())


def _phase_axis(ax: Axes) -> None:
    ax.set_ylim(0.0, 2.0 * np.pi)
    ax.set_yticks([0.0, np.pi, 2.0 * np.pi], ["0", "π", "2π"])


# ---- A branch: speeds above phases, with those that were switched to from it


def branch(found: Branch, title: str = "") -> Figure:
    """Draw branches: the phases of the impacts, above them the speeds; stable parts solid, unstable ones dashed.

    Parameters
    ----------
    found
        A `percuss.explore.Branch`, drawn with those that were switched to from it. Of cycles with rest the first
        impacts after each release are drawn, and among the phases when the bar is let go and comes to rest.

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
    with canvas(6.4, 6.0, text("title", title, "a text")) as figure:
        panels = dict(zip(("speed", "phase"), figure.subplots(2, 1, sharex=True), strict=True))
        panels["speed"].set_ylabel("speed at the impacts, dimensionless")
        panels["phase"].set(ylabel=_TITLES["phase"], xlabel=found.parameter)
        _phase_axis(panels["phase"])
        for number, one in enumerate(found.family()):
            for quantity, ax in panels.items():
                label = one.label if quantity == "speed" else "_"
                _draw(ax, one, quantity, COLOURS[number % len(COLOURS)], label=label)
                _mark(ax, one, quantity)
        kept = named_once(panels["speed"])
        panels["speed"].legend(kept.values(), kept.keys(), loc="best", ncols=2)
        rests = {name: line for name, line in named_once(panels["phase"]).items() if name in dict(_RESTS.values())}
        if rests:
            panels["phase"].legend(rests.values(), rests.keys(), loc="best", ncols=2)
    return figure


# ---- Curves over two parameters: folds, flips, grazings …, and the points of codimension two on them

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
    with canvas(6.4, 4.8, text("title", title, "a text")) as figure:
        ax = figure.subplots()
        kinds = list(dict.fromkeys((one.event.value, one.label) for one in kept))
        for one in kept:
            colour = COLOURS[kinds.index((one.event.value, one.label)) % len(COLOURS)]
            name = f"{_WORDS.get(one.event.value, one.event.value)} of {one.label}"
            ax.plot(*one.values.T, ":", color=colour, lw=0.8)
            ax.plot(*one.real.T, "-", color=colour, lw=1.4, label=name)
        points = [point for one in kept for point in one.points if point.kind.value not in _ENDS]
        words = list(dict.fromkeys(point.kind.value for point in points))
        for point in points:
            mark, word = _MARKS[words.index(point.kind.value) % len(_MARKS)], point.kind.value.replace("_", " ")
            ax.plot(*np.array(point.values)[:, None], mark, color=INK, ms=4.5, ls="", label=word)
        for name, unit, side in zip(kept[0].parameters, kept[0].units, "xy", strict=True):
            ax.set(**{f"{side}label": f"{label_of(name)} [{unit}]" if unit else label_of(name)})
        shown = named_once(ax)
        figure.legend(shown.values(), shown.keys(), loc="outside lower left", ncols=3)
    return figure


# ---- A diagram: what simulations settle on as points, the branches of all orbits as lines, their events


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
    if not isinstance(quantities, tuple) or not quantities:
        raise ParameterError("quantities", quantities, f"some of {', '.join(QUANTITIES)}")
    for quantity in quantities:
        choice("quantities", quantity, *QUANTITIES)
    with canvas(7.2, 1.2 + 2.9 * len(quantities), text("title", title, "a text")) as figure:
        panels: list[Axes] = list(np.atleast_1d(figure.subplots(len(quantities), 1, sharex=True)))
        colours, every = _colours(found), (*found.branches, *found.rest_branches)
        for ax, quantity in zip(panels, quantities, strict=True):
            _points(ax, found, quantity)
            for line in every:
                _draw(ax, line, quantity, colours[line.label], (1.4, 0.9))
            for line in every:
                _mark(ax, line, quantity, 3.5)
            for line in found.impossible:  # beyond an end, where the roots of the equations are no motions
                for row in _rows(line, quantity).T:
                    x, y = _cut(line.values, row, quantity)
                    ax.plot(x, y, "-", color=INK, alpha=0.45, lw=0.5, label="_", zorder=1.5)
            unit = _UNITS.get(quantity, "")
            words = f" [{unit}]" if found.is_si else ", dimensionless"
            ax.set_ylabel(_TITLES[quantity] + (words if unit else ""))
            if quantity == "phase":
                _phase_axis(ax)
        unit = f" [{found.axis.unit}]" if found.axis.unit else ""
        panels[-1].set_xlabel(f"{label_of(found.axis.name)}{unit}")
        panels[-1].set_xlim(float(found.axis.values.min()), float(found.axis.values.max()))
        _diagram_legend(figure, panels[0], found)
    return figure


def _points(ax: Axes, found: Diagram, quantity: str) -> None:
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


_MOST_TOLD = 14  # labels of branches that the legend tells of


def _diagram_legend(figure: Figure, ax: Axes, found: Diagram) -> None:
    """Beside the panels: families of points, labels of branches, how they are drawn, events."""
    from matplotlib.lines import Line2D

    kept = named_once(ax)
    points = {family.name: kept[family.name] for family in palette.FAMILIES if family.name in kept}
    named = {*[*_labels(found.rest_branches), *_labels(found.branches)][:_MOST_TOLD]}
    lines = {label: Line2D([], [], color=c, lw=1.4) for label, c in _colours(found).items() if label in named}
    ways = {"stable": Line2D([], [], color=INK, lw=1.4), "unstable": Line2D([], [], color=INK, lw=0.9, ls="--")}
    if found.impossible:
        ways["not a motion"] = Line2D([], [], color=INK, alpha=0.45, lw=0.5)
    marks = {name: handle for name, handle in kept.items() if name not in points}
    told = [*points.items(), *lines.items(), *(ways.items() if lines else ()), *marks.items()]
    if told:
        names, drawn = zip(*told, strict=True)
        figure.legend(drawn, names, loc="outside right upper", frameon=False, markerscale=1.8)


def _labels(lines: Sequence[Branch]) -> list[str]:
    """Each label once, in the order in which they come."""
    return list(dict.fromkeys(line.label for line in lines))


def _colours(found: Diagram) -> dict[str, str]:
    """The colour of each label: cycles with rest take it from the other end, so that few labels share none."""
    orbits, rests = _labels(found.branches), _labels(found.rest_branches)
    given = {label: COLOURS[i % len(COLOURS)] for i, label in enumerate(orbits)}
    return given | {label: COLOURS[-1 - i % len(COLOURS)] for i, label in enumerate(rests)}
