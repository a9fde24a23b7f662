"""Columns of motions, and what they settle on, as a dataset."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from percuss.errors import MissingExtraError
from percuss.explore.jobs.job import Columns

if TYPE_CHECKING:
    import xarray

    from percuss.explore.attractors.hammer import Hammer

__all__ = ["dataset_of", "si_attributes"]


def dataset_of(
    columns: Columns,
    dims: tuple[str, ...],
    number: npt.NDArray[np.int64],
    shares: Any,
    hammer: Hammer,
    about: dict[str, Any],
) -> xarray.Dataset:
    """Columns of motions and their attractors as a dataset; `dims`: of the motions, and `number` of their shape.

    All of it is dimensionless and says so; of a hammer in SI it has the scales besides, as `si_scale` and `si_units` of
    each variable that has one.
    """
    try:
        import xarray
    except ImportError:
        raise MissingExtraError("xarray", "io") from None
    from percuss._version import __version__

    known, words = {**hammer.start_columns(2, 2), **hammer.start_columns(1, 1), **hammer.columns}, hammer.words
    variables: dict[str, Any] = {
        "attractor_number": (dims, number, {"long_name": "attractor that the motion settles on"}),
    }
    for name, values in columns.items():
        column = known[name]
        inner = () if values.ndim == 1 else ({"invariants": "invariant"}.get(name, f"{name}_mode"),)
        attributes = {"long_name": column.meaning, "units": column.unit or "1", **si_attributes(name, hammer)}
        if not column.unit and column.dtype == "float64":
            attributes["comment"] = "dimensionless"
        if name in words:
            attributes["words"] = ", ".join(words[name])
        variables[name] = ((*dims, *inner), values.reshape(*number.shape, *values.shape[1:]), attributes)
    meanings = {"label": "motion", "share": "part of the starts", "low": "its interval", "high": "its interval"}
    for name, meaning in meanings.items():
        found = np.array([getattr(share, name) for share in shares])
        variables[f"attractor_{name}" if name != "share" else "share"] = ("attractor", found, {"long_name": meaning})
    return xarray.Dataset(
        variables,
        coords={"attractor": np.arange(len(shares))},
        attrs={
            **about,
            **hammer.about,
            "percuss_version": __version__,
        },
    )


def si_attributes(name: str, hammer: Hammer) -> dict[str, Any]:
    """What a column is to be multiplied by for SI, and the unit that it then has; nothing without scales."""
    if name not in hammer.scales:
        return {}
    scale, unit = hammer.scales[name]
    return {"si_scale": scale, "si_units": unit}
