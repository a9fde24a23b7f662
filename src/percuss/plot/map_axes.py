"""What a map hands to its pictures, and the axes of their panels."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, Protocol

import numpy as np

from percuss.explore.parameters import label_of

__all__ = ["Axis", "Curve", "Map", "answered_cells", "cell_edges", "is_signed", "lay_out", "round_ticks"]

_UNANSWERED = 2  # outcomes from this one on, and −1, leave a cell without a value; see percuss.explore.quantities


class Axis(Protocol):
    @property
    def name(self) -> str: ...
    @property
    def unit(self) -> str: ...
    @property
    def values(self) -> np.ndarray[Any, np.dtype[np.float64]]: ...


class Map(Protocol):
    """A sweep: axes, quantities and their arrays."""

    @property
    def axes(self) -> Sequence[Axis]: ...
    @property
    def quantities(self) -> Sequence[str]: ...
    @property
    def columns(self) -> Mapping[str, Any]: ...
    @property
    def words(self) -> Mapping[str, Sequence[str]]: ...
    def __getitem__(self, quantity: str) -> np.ndarray[Any, Any]: ...


class Curve(Protocol):
    """A boundary: its kind and its points."""

    @property
    def kind(self) -> str: ...
    @property
    def x(self) -> np.ndarray[Any, np.dtype[np.float64]]: ...
    @property
    def y(self) -> np.ndarray[Any, np.dtype[np.float64]]: ...


def answered_cells(found: Map) -> np.ndarray[Any, Any]:
    """Where the cells have values at all."""
    outcome = np.asarray(found["outcome"])
    return np.asarray((outcome >= 0) & (outcome < _UNANSWERED))


def is_signed(name: str) -> bool:
    return "margin" in name or name == "lyapunov"


def _named(axis: Axis) -> str:
    name = label_of(axis.name)
    return f"{name} [{axis.unit}]" if axis.unit else name


def _spans(values: np.ndarray[Any, Any]) -> bool:
    """Whether the values are at equal ratios rather than at equal distances."""
    if values.size < 4 or values.min() <= 0.0:
        return False
    ratios = values[1:] / values[:-1]
    return bool(np.ptp(ratios) < 1e-6 * abs(ratios[0] - 1.0) and np.ptp(np.diff(values)) > 1e-6 * np.ptp(values))


def cell_edges(axis: Axis) -> np.ndarray[Any, np.dtype[np.float64]]:
    """The borders of the cells, halfway between the values; one value has a cell of a tenth of it."""
    values = axis.values
    if values.size == 1:
        half = 0.5 if axis.name == "m" else 0.05 * abs(float(values[0])) or 0.5
        return np.array([values[0] - half, values[0] + half])
    at = np.log(values) if _spans(values) else values
    middle = 0.5 * (at[1:] + at[:-1])
    edges = np.concatenate([[2.0 * at[0] - middle[0]], middle, [2.0 * at[-1] - middle[-1]]])
    return np.exp(edges) if _spans(values) else edges


def lay_out(axis: Axis, side: Any, limits: tuple[float, float]) -> None:
    """Scale and ticks of the x or y axis (`side`) of a panel."""
    from matplotlib.ticker import NullLocator

    side.axes.set(**{f"{side.axis_name}label": _named(axis)})
    if _spans(axis.values):
        side.axes.set(**{f"{side.axis_name}scale": "log"})
    side.axes.set(**{f"{side.axis_name}lim": limits})
    if axis.values.size == 1 or (axis.name == "m" and axis.values.size <= 12):
        ticks = axis.values.tolist()
    elif axis.name == "m":
        ticks = [tick for tick in side.get_major_locator().tick_values(*limits) if tick == round(tick)]
    elif _spans(axis.values):
        ticks = round_ticks(*limits)
    else:
        return
    side.set_ticks(ticks, [f"{tick:g}" for tick in ticks])
    side.set_minor_locator(NullLocator())
    side.axes.set(**{f"{side.axis_name}lim": limits})


def round_ticks(low: float, high: float) -> list[float]:
    """Ticks for a logarithmic scale: 1, 2 and 5 times powers of ten, only those in long ranges; more in short ones."""
    decades = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
    digits: tuple[tuple[float, ...], ...] = ((1,), (1, 2, 5), (1, 1.5, 2, 3, 4, 5, 6, 7, 8, 9))
    found: list[float] = []
    for steps in digits:
        found = [tick for power in decades for digit in steps if low <= (tick := float(f"{digit}e{power}")) <= high]
        if len(found) >= 4:
            return found
    if len(found) >= 2:
        return found
    from matplotlib.ticker import MaxNLocator

    return [float(tick) for tick in MaxNLocator(4).tick_values(low, high) if low <= tick <= high]
