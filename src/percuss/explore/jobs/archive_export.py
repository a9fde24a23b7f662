"""An archive as one xarray dataset, and that as one file: NetCDF for programs, CSV for everything else."""

from __future__ import annotations

import csv
import json
import os
from typing import TYPE_CHECKING, Any

import numpy as np

from percuss.errors import MissingExtraError
from percuss.explore.jobs.archive import Archive
from percuss.explore.jobs.archive_layout import canonical
from percuss.whole_file import whole_file, write_dataset

if TYPE_CHECKING:
    import xarray

_ROWS = 1 << 15
"""Rows of a CSV file that are made at once."""


def dataset_of(archive: Archive) -> xarray.Dataset:
    """What an archive holds, as its kind of result has it, with where it comes from in the attributes."""
    found: xarray.Dataset | None = getattr(archive.result(), "dataset", None)
    dataset = plain_dataset(archive) if found is None else found
    origin = {
        "kind": archive.kind,
        "ask": canonical(archive.ask),
        "sha256": archive.sha256,
        "created": archive.created,
        "versions": json.dumps(archive.versions),
        "items": archive.size,
        "items_done": archive.items_done,
    }
    return dataset.assign_attrs({**dataset.attrs, **origin})


def plain_dataset(archive: Archive) -> xarray.Dataset:
    """The columns of any archive: over the axes that were asked for, else over the dimension ``item``."""
    try:
        import xarray
    except ImportError:
        raise MissingExtraError("xarray", "io") from None
    axes = _axes(archive)
    dims = tuple(axes) or ("item",)
    shape = tuple(len(values) for values, _ in axes.values()) or (archive.size,)
    variables: dict[str, Any] = {}
    for name, values in archive.read().items():
        column = archive.columns[name]
        inner = tuple(f"{name}_{i}" for i in range(len(column.shape)))
        about = {"units": column.unit or "1", "long_name": column.meaning}
        variables[name] = ((*dims, *inner), values.reshape(*shape, *column.shape), about)
    coordinates: dict[str, Any] = {
        name: (name, np.array(values), {"units": unit or "1"}) for name, (values, unit) in axes.items()
    }
    return xarray.Dataset(variables, coordinates or {"item": np.arange(archive.size)})


def write_netcdf(dataset: xarray.Dataset, path: str | os.PathLike[str]) -> None:
    """One NetCDF 4 file."""
    write_dataset(dataset, path)


def write_csv(dataset: xarray.Dataset, path: str | os.PathLike[str]) -> None:
    """One line for each item, after a line of names with units.

    The items are those of the first variable; what has other dimensions, such as a table of attractors, is left out,
    and what has more becomes a column for each. Numbers that stand for words are written as the words, empty where
    there is none.

    Raises
    ------
    PercussError
        When it cannot be written.
    """
    dims = _row_dims(dataset)
    shape = tuple(dataset.sizes[dim] for dim in dims)
    fields: list[tuple[str, Any]] = []  # header, and values of as many rows, to be broadcast where it is a coordinate
    for i, dim in enumerate(dims):
        coordinate = dataset[dim]
        along = coordinate.values.reshape([-1 if j == i else 1 for j in range(len(dims))])
        fields.append((_header(dim, coordinate), np.broadcast_to(along, shape)))
    for name, variable in dataset.data_vars.items():
        if not set(dims) <= set(variable.dims):
            continue
        values = variable.transpose(*dims, ...).values
        inner = values.shape[len(dims) :]
        for index in np.ndindex(inner):
            mark = "".join(f"_{j}" for j in index)
            fields.append((_header(f"{name}{mark}", variable), _worded(variable, values[(..., *index)])))
    with whole_file(path) as part, open(part, "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow([header for header, _ in fields])
        for first in range(0, int(np.prod(shape)), _ROWS):
            rows = np.unravel_index(np.arange(first, min(first + _ROWS, int(np.prod(shape)))), shape)
            writer.writerows(zip(*(_texts(values[rows]) for _, values in fields), strict=True))


def _axes(archive: Archive) -> dict[str, tuple[list[Any], str]]:
    """Name → values and unit, when they make up the items."""
    try:
        axes = {str(axis["name"]): (list(axis["values"]), str(axis.get("unit", ""))) for axis in archive.ask["axes"]}
    except (KeyError, TypeError, AttributeError):
        return {}
    number = int(np.prod([len(values) for values, _ in axes.values()])) if axes else 0
    return axes if number == archive.size and not set(axes) & set(archive.columns) else {}


def _row_dims(dataset: xarray.Dataset) -> tuple[str, ...]:
    """The dimensions whose places are the rows: those of the first variable that all related variables have too."""
    every = [set(variable.dims) for variable in dataset.data_vars.values()]
    first = next(iter(dataset.data_vars.values())).dims
    related = [dims for dims in every if first[0] in dims]
    return tuple(str(dim) for dim in first if all(dim in dims for dims in related))


def _header(name: str, variable: xarray.DataArray) -> str:
    unit = str(variable.attrs.get("units", ""))
    return f"{name} [{unit}]" if unit not in ("", "1") else name


def _worded(variable: xarray.DataArray, values: Any) -> Any:
    """The words that the numbers of a variable stand for, or the values themselves."""
    words = variable.attrs.get("words")
    return values if words is None else np.array([*str(words).split(", "), ""])[values]


def _texts(values: Any) -> list[Any]:
    """Numbers with all their digits; truth in lower case, as other programs write it."""
    found: list[Any] = values.tolist()
    return [str(value).lower() for value in found] if values.dtype == bool else found
