"""Maps and experiments as JSON objects."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from percuss.case.answers.json_values import number
from percuss.model import Machine

if TYPE_CHECKING:
    from percuss.case.case import Case
    from percuss.explore import Basins, Boundaries, Experiment, Sweep
    from percuss.model import System

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
        elif name != "outcome":
            values = _known(found, values)
        column = found.columns.get(name)
        quantities[name] = {"unit": column.unit if column else "", "values": _nested(values)}
    answer: dict[str, Any] = {
        "case": case.file,
        "title": case.title,
        "notes": list(case.notes),
        "axes": [axis.to_json_dict() for axis in found.axes],
        "periods": found.ask.get("periods"),
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
    return {
        "case": case.file,
        "title": case.title,
        "notes": list(case.notes),
        **found.to_json_dict(),
        "si": _scales(found.system),
    }


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
        "si": _scales(found.system),
        "image": found.image.tolist(),
        "attractors": [
            {
                "label": share.label,
                "share": share.share,
                **share.attractor.figures,
            }
            for share in found.shares
        ],
    }


def _known(found: Sweep, values: np.ndarray[Any, Any]) -> np.ndarray[Any, Any]:
    """The values, None in cells that have none: those without a system, or not computed."""
    if values.dtype.kind == "f" or values.dtype.kind == "U":
        return values
    shown = values.astype(object)
    outcome = found["outcome"]
    nothing = (outcome < 0) | (outcome > 1) & (outcome < len(found.words["outcome"]) - 1)
    shown[nothing] = None
    return shown


def _scales(system: System | Machine) -> dict[str, float | None] | None:
    """What the dimensionless numbers are multiplied by for SI, and the frequency of a clock; None without scales."""
    if not system.is_si:
        return None
    return {
        "length_m": system.length_scale,
        "speed_m_s": system.speed_scale,
        "time_s": system.time_scale,
        "energy_J": system.energy_scale,
        **({} if isinstance(system, Machine) else {"frequency_Hz": system.frequency}),
    }


def _nested(values: np.ndarray[Any, Any]) -> Any:
    if values.ndim > 1:
        return [_nested(row) for row in values]
    if values.dtype.kind in "bUO":
        return values.tolist()
    return [_number(value) for value in values.tolist()]


def _number(value: float | int) -> float | int | str | None:
    """A number as JSON can hold it; −∞, the Lyapunov exponent of a motion that comes to rest, becomes a word."""
    return "-inf" if value == -np.inf else number(value)
