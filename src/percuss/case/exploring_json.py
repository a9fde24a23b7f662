"""Maps and experiments as JSON objects."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from percuss.case.plain import number

if TYPE_CHECKING:
    from percuss.case.case import Case
    from percuss.explore import Basins, Boundaries, Experiment, Sweep

__all__ = ["basins_dict", "experiment_dict", "sweep_dict"]


def sweep_dict(case: Case, found: Sweep, curves: Boundaries | None = None) -> dict[str, Any]:
    """A map as a tree of dict, list, str, bool, int, finite float and None: nested lists, the last axis innermost.

    Parameters
    ----------
    curves
        The boundaries in its plane, when they were asked for.
    """
    quantities: dict[str, Any] = {}
    for name in ("outcome", *found.quantities):
        values = found[name]
        if name in found.words:
            words = np.array([*found.words[name], ""])
            values = words[values]
        column = found.columns.get(name)
        quantities[name] = {"unit": column.unit if column else "", "values": _nested(values)}
    answer: dict[str, Any] = {
        "case": case.file,
        "title": case.title,
        "axes": [axis.to_json_dict() for axis in found.axes],
        "periods": found.ask["periods"],
        "modes": found.ask["modes"],
        "quantities": quantities,
    }
    if curves is not None:
        answer["curves"] = [
            {"kind": c.kind, "branch": c.branch, "x": _nested(c.x), "y": _nested(c.y), "phase": _nested(c.phase)}
            for c in curves.curves
        ]
    return answer


def experiment_dict(case: Case, found: Experiment) -> dict[str, Any]:
    """An experiment as a tree of dict, list, str, int, finite float and None."""
    return {"case": case.file, "title": case.title, **found.to_json_dict()}


def basins_dict(case: Case, found: Basins) -> dict[str, Any]:
    """Basins as a tree of dict, list, str, int, finite float and None: `image` holds numbers of attractors, row by row
    from the first value of y on, −1 where nothing is known."""
    (x, over), (y, up) = found.x, found.y
    return {
        "case": case.file,
        "title": case.title,
        "axes": [{"name": x, "values": list(over)}, {"name": y, "values": list(up)}],
        "at": dict(found.at),
        "modes": found.modes,
        "image": found.image.tolist(),
        "attractors": [
            {
                "label": share.label,
                "share": share.share,
                "phases": list(share.phases),
                "impact_velocities": list(share.impact_velocities),
            }
            for share in found.shares
        ],
    }


def _nested(values: np.ndarray[Any, Any]) -> Any:
    if values.ndim > 1:
        return [_nested(row) for row in values]
    return values.tolist() if values.dtype.kind in "bU" else [number(value) for value in values.tolist()]
