"""Words in the cells of a map: which there are, in which order, and what stands where there is none."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from percuss import palette

if TYPE_CHECKING:
    from percuss.plot.map_axes import Map

__all__ = ["HATCH", "no_value", "words_of"]

MOST_WORDS = 12
"""Labels with a colour of their own: the most frequent; the others share one."""

HATCH = palette.BOTH["none"]  # on white: no value


def no_value() -> dict[str, Any]:
    from matplotlib.patches import Patch

    return {"no value": Patch(facecolor="white", edgecolor=HATCH, hatch="////", lw=0.4)}


def words_of(found: Map, name: str, values: np.ndarray[Any, Any]) -> tuple[np.ndarray[Any, Any], list[str]] | None:
    """Numbers of words and the words, for labels and what is kept as numbers of words; −1 where there is nothing."""
    if name in found.words:
        words = list(found.words[name])
        present = [i for i in range(len(words)) if np.any(values == i)]
        numbers = np.full(values.shape, -1)
        for at, i in enumerate(present):
            numbers[values == i] = at
        return numbers, [words[i] for i in present]
    if values.dtype.kind != "U":
        return None
    kinds, counts = np.unique(values, return_counts=True)
    ordered = [kind for kind in kinds[np.argsort(-counts, kind="stable")].tolist() if kind]
    names = sorted(ordered[:MOST_WORDS], key=_order)
    numbers = np.full(values.shape, -1)
    for at, kind in enumerate(names):
        numbers[values == kind] = at
    if len(ordered) > MOST_WORDS:
        numbers[(numbers < 0) & (values != "")] = len(names)
        names.append("others")
    return numbers, names


def _order(label: str) -> tuple[int, str, int, int]:
    """Periodic motions by p and n first, then those with rest, then the others."""
    head, _, tail = label.partition("=" if label.startswith("z=") else "/")
    p, _, n = tail.partition("/")
    first, second = (int(part) if part.isdecimal() else 0 for part in (p, n))
    return ("z", "rest", "chatter").index(head) if head in ("z", "rest", "chatter") else 9, head, first, second
