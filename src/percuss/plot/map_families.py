"""Found motions in a map: the seven families, each always in its own colour and hatch."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from percuss.palette import FAMILIES, family_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["families", "family_numbers", "is_motions"]

_HATCH_COLOUR = "#ffffff"


def is_motions(name: str) -> bool:
    """Whether a quantity is the label of a motion that was found."""
    return name == "label"


def family_numbers(labels: np.ndarray[Any, Any]) -> npt.NDArray[np.int64]:
    """The number of the family of every label; −1 where there is none."""
    kinds, where = np.unique(labels, return_inverse=True)
    numbers = np.array([family_of(str(kind)) if kind else -1 for kind in kinds], dtype=np.int64)
    return numbers[where].reshape(labels.shape)


def families(ax: Axes, x: Any, y: Any, labels: np.ndarray[Any, Any], answered: Any) -> Any:
    """Cells in the colours and hatches of their families, with a legend beside the panel; what is drawn.

    Parameters
    ----------
    x, y
        Edges of the cells.
    labels
        Shape (x, y); "" where there is none.
    answered
        Where the cells have values at all.
    """
    from matplotlib.colors import ListedColormap
    from matplotlib.patches import Patch

    numbers = family_numbers(labels)
    shown = np.ma.masked_where((numbers < 0) | ~answered, numbers)
    colours = ListedColormap([family.colour.light for family in FAMILIES])
    top = len(FAMILIES) - 0.5
    ax.pcolormesh(x, y, shown.T, shading="flat", rasterized=True, cmap=colours, vmin=-0.5, vmax=top)
    handles = []
    for i in np.unique(shown.compressed()).tolist():
        family = FAMILIES[i]
        look: dict[str, Any] = {"facecolor": family.colour.light, "hatch": 4 * family.hatch, "lw": 0.0}
        handles.append(Patch(edgecolor=_HATCH_COLOUR, label=family.name, **look))
        if family.hatch:
            _hatched(ax, x, y, (shown == i).filled(False), 2 * family.hatch)
    ax.legend(handles=handles, loc="upper left", bbox_to_anchor=(1.0, 1.0), borderaxespad=0.3)
    return shown


def _hatched(ax: Axes, x: Any, y: Any, here: Any, hatch: str) -> None:
    """One patch of all the cells, so that its lines go on from cell to cell; runs of cells are one rectangle."""
    from matplotlib.patches import PathPatch
    from matplotlib.path import Path

    corners = []
    for j in range(here.shape[1]):
        ends = np.flatnonzero(np.diff(np.concatenate([[False], here[:, j], [False]]).astype(int)))
        for first, last in zip(ends[::2].tolist(), ends[1::2].tolist(), strict=True):
            left, right, low, high = x[first], x[last], y[j], y[j + 1]
            corners.append([(left, low), (right, low), (right, high), (left, high), (left, low)])
    codes = [Path.MOVETO, Path.LINETO, Path.LINETO, Path.LINETO, Path.CLOSEPOLY] * len(corners)
    path = Path(np.array(corners, dtype=float).reshape(-1, 2), codes)
    ax.add_patch(PathPatch(path, facecolor="none", edgecolor=_HATCH_COLOUR, hatch=hatch, lw=0.0))
