"""The pictures of where starts end: the shares of an experiment, and basins of attraction as an image."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from percuss import palette
from percuss.model.checks import having, text
from percuss.plot.canvas import INK, canvas, patches_beside

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from percuss.explore import Basins, Experiment
    from percuss.explore.attractors.experiments import Share
    from percuss.model import Machine, System

MOST_SHOWN = 10
"""Attractors with a line or a colour of their own: the most frequent."""

MOST_POINTS = 20_000
"""Starts drawn; of more an even choice."""

_OTHERS = "#B5B5B5"
_NAMES = {
    "time": "load phase of the start [rad]",
    "velocity": "velocity of the start",
    "position": "position of the start [bar lengths]",
}
_SI_NAMES = {
    "time": "time of the start, from the beginning of a load period [ms]",
    "velocity": "velocity of the start [m/s]",
    "position": "position of the start [mm]",
}


def experiment(found: Experiment, title: str = "") -> Figure:
    """Draw an experiment: the shares of the attractors with their intervals, and the starts in their colours.

    Examples
    --------
    >>> from percuss import Load, System
    >>> from percuss.explore import experiment
    >>> from percuss.plot import experiment as picture
    >>> system = System(s=20.0, d=0.0, restitution=0.6, load=Load.harmonic(0.7, 1.0))
    >>> len(picture(experiment(system, 200, modes=0, workers=1)).axes)
    2
    """
    having("found", found, ("shares", "attractor", "columns"), "what percuss.explore.experiment gives")
    with canvas(10.5, 4.4, text("title", title)) as figure:
        left, right = figure.subplots(1, 2, width_ratios=(1.0, 1.3))
        _bars(left, found.shares)
        _scatter(right, found)
    return figure


def basins(found: Basins, title: str = "") -> Figure:
    """Draw basins of attraction as an image: each start in the colour of the attractor that it leads to.

    Examples
    --------
    >>> from percuss import Load, System
    >>> from percuss.explore import basins
    >>> from percuss.plot import basins as picture
    >>> system = System(s=20.0, d=0.0, restitution=0.6, load=Load.harmonic(0.7, 1.0))
    >>> found = basins(system, ("time", 0.0, 6.2, 16), ("velocity", -6.0, -0.1, 10), modes=0, workers=1)
    >>> picture(found).axes[0].get_xlabel()
    'load phase of the start [rad]'
    """
    from matplotlib.colors import ListedColormap

    having("found", found, ("shares", "image", "x", "y"), "what percuss.explore.basins gives")
    with canvas(7.5, 5.0, text("title", title)) as figure:
        ax = figure.add_subplot()
        ax.set_facecolor("white")
        n = min(len(found.shares), MOST_SHOWN)
        image = np.ma.masked_less(np.minimum(found.image, MOST_SHOWN), 0)
        colours = [_colour(i) for i in range(MOST_SHOWN + 1)]
        (x, x_name), (y, y_name) = (_axis(name, values, found.system) for name, values in (found.x, found.y))
        ax.pcolormesh(
            x, y, image, shading="nearest", cmap=ListedColormap(colours), vmin=-0.5,
            vmax=MOST_SHOWN + 0.5, rasterized=True,
        )  # fmt: skip
        ax.set(xlabel=x_name, ylabel=y_name)
        _legend(ax, found.shares, n)
    return figure


def _axis(name: str, values: Any, system: System | Machine) -> tuple[np.ndarray[Any, Any], str]:
    """Values of a start and their name on an axis, in SI where the system has scales."""
    found = np.asarray(values, dtype=float)
    if not system.is_si or name not in _SI_NAMES:
        unit = " [bar lengths/rad]" if name == "velocity" and hasattr(system, "load") else ""
        return found, _NAMES.get(name, name) + unit
    scales = {"time": 1e3 * system.time_scale, "velocity": system.speed_scale, "position": 1e3 * system.length_scale}
    return found * scales[name], _SI_NAMES[name]


def _colour(i: int) -> str:
    return palette.AREAS[i] if i < MOST_SHOWN else _OTHERS


def _name(shares: Sequence[Share], i: int) -> str:
    """The label, and what else tells it from others where several have the same one."""
    share = shares[i]
    alone = sum(other.label == share.label for other in shares) == 1
    return share.label if alone else f"{share.label} {share.attractor.mark}".rstrip()


def _legend(ax: Axes, shares: Sequence[Share], n: int) -> None:
    looks = [{"facecolor": _colour(i), "label": _name(shares, i)} for i in range(n)]
    if len(shares) > n:
        looks.append({"facecolor": _OTHERS, "label": f"{len(shares) - n} others"})
    patches_beside(ax, looks)


def _bars(ax: Axes, shares: Sequence[Share]) -> None:
    shown = list(shares[:MOST_SHOWN])
    places = np.arange(len(shown))
    share, low, high = (np.array([getattr(s, name) for s in shown]) for name in ("share", "low", "high"))
    ax.barh(places, share, color=[_colour(i) for i in range(len(shown))], height=0.7)
    ax.errorbar(share, places, xerr=np.abs([share - low, high - share]), fmt="none", ecolor=INK, capsize=2.5, lw=1.0)
    ax.set_yticks(places, [_name(shares, i) for i in range(len(shown))])
    ax.invert_yaxis()
    ax.set_xlim(0.0, min(1.0, 1.12 * float(high.max())))
    ax.set_xlabel("share of the starts, with 95 % intervals")
    rest = len(shares) - len(shown)
    ax.set_title("(a) attractors" + (f"; {rest} more are rarer" if rest else ""))


def _scatter(ax: Axes, found: Experiment) -> None:
    number = found.attractor
    (x, x_name), (y, y_name) = _plane(ax, found)
    step = max(1, -(-number.size // MOST_POINTS))
    size = float(np.clip(3000.0 / (number.size / step), 0.3, 14.0))
    for i in range(min(int(number.max()), MOST_SHOWN), -1, -1):  # the most frequent last, over the others' edges
        here = np.flatnonzero(np.minimum(number, MOST_SHOWN) == i)[::step]
        ax.scatter(x[here], y[here], s=size, color=_colour(i), linewidths=0.0, rasterized=True)
    ax.set(xlabel=x_name, ylabel=y_name, title="(b) starts in the colour of what they lead to")


_Line = tuple[np.ndarray[Any, Any], str]


def _plane(ax: Axes, found: Experiment) -> tuple[_Line, _Line]:
    """The two quantities over which starts are drawn; of a machine the position, or at one place the state."""
    columns = found.columns
    speed = columns.get("velocity", columns.get("start_velocity"))
    assert speed is not None
    velocity = speed if speed.ndim == 1 else speed[:, 0]
    if "time" in columns:
        name, values = ("velocity", velocity) if np.ptp(velocity) else ("position", columns["position"])
        return _axis("time", columns["time"], found.system), _axis(name, values, found.system)
    if np.ptp(columns["position"]) > 0.0:
        return _axis("position", columns["position"], found.system), _axis("velocity", velocity, found.system)
    states = found.hammer.words["state"]
    ax.set_yticks(range(len(states)), list(states))
    spread = 0.6 * ((np.arange(velocity.size) * _GOLDEN) % 1.0 - 0.5)
    return _axis("velocity", velocity, found.system), (columns["state"] + spread, "state of the valve at the start")


_GOLDEN = 0.6180339887498949  # fills a strip evenly, the same every time
