"""Results as xarray datasets: named coordinates, units, and a sentence for each variable."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from percuss.errors import MissingExtraError
from percuss.explore.axis import Axis
from percuss.explore.cells import label_text
from percuss.explore.jobs.job import Column, Columns
from percuss.explore.quantities import CYCLE_KINDS
from percuss.simulate import OUTCOMES

if TYPE_CHECKING:
    import xarray

__all__ = ["map_dataset"]

_LABEL_WORDS = {"label_outcome": OUTCOMES, "label_kind": CYCLE_KINDS}
"""Of the numbers that a label is kept in."""


def map_dataset(
    axes: Sequence[Axis],
    quantities: Collection[str],
    arrays: Columns,
    columns: Mapping[str, Column],
    known: Mapping[str, Sequence[str]],
) -> xarray.Dataset:
    """A map; what is kept as numbers of words has them in its attribute ``words``, labels are words themselves.

    Parameters
    ----------
    axes, quantities, arrays, columns
        As a `percuss.explore.Sweep` has them.
    known
        Of each column that is kept as numbers of words, the words.

    Raises
    ------
    MissingExtraError
        Without xarray.
    """
    try:
        import xarray
    except ImportError:
        raise MissingExtraError("xarray", "io") from None
    names = [axis.name for axis in axes]
    variables: dict[str, Any] = {}
    for name, column in columns.items():
        extra = ["orbit"] if column.shape else []
        attributes = {"units": column.unit or "1", "long_name": column.meaning}
        words = known.get(name) or _LABEL_WORDS.get(name)
        if words is not None:
            attributes["words"] = ", ".join(words)
        variables[name] = ([*names, *extra], arrays[name], attributes)
    if "label" in quantities:
        variables["label"] = (names, label_text(arrays).astype(object), {"long_name": "motion label"})
    coordinates = {axis.name: axis.coordinate() for axis in axes}
    return xarray.Dataset(variables, coordinates, {"kind": "sweep"})
