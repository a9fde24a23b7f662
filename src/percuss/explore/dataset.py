"""Results as xarray datasets: named coordinates, units, and a sentence for each variable."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from percuss.errors import MissingExtraError
from percuss.explore.cells import label_text
from percuss.explore.quantities import CYCLE_KINDS
from percuss.simulate import OUTCOMES

if TYPE_CHECKING:
    import xarray

    from percuss.explore.sweeps import Sweep

__all__ = ["map_dataset"]

_LABEL_WORDS = {"label_outcome": OUTCOMES, "label_kind": CYCLE_KINDS}
"""Of the numbers that a label is kept in."""


def map_dataset(found: Sweep) -> xarray.Dataset:
    """A map; what is kept as numbers of words has them in its attribute ``words``, labels are words themselves.

    Raises
    ------
    MissingExtraError
        Without xarray.
    """
    try:
        import xarray
    except ImportError:
        raise MissingExtraError("xarray", "io") from None
    names = [axis.name for axis in found.axes]
    variables: dict[str, Any] = {}
    for name, column in found.columns.items():
        extra = ["orbit"] if column.shape else []
        attributes = {"units": column.unit or "1", "long_name": column.meaning}
        words = found.words.get(name) or _LABEL_WORDS.get(name)
        if words is not None:
            attributes["words"] = ", ".join(words)
        variables[name] = ([*names, *extra], found.arrays[name], attributes)
    if "label" in found.quantities:
        variables["label"] = (names, label_text(found.arrays).astype(object), {"long_name": "motion label"})
    coordinates = {axis.name: axis.coordinate() for axis in found.axes}
    return xarray.Dataset(variables, coordinates, {"kind": "sweep"})
