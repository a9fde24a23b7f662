"""Results handed over: columns of numbers as one xarray dataset, and that as one file, NetCDF or CSV."""

from __future__ import annotations

import csv
import json
import os
import zlib
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from percuss.atomic_write import whole_file, write_dataset
from percuss.errors import ParameterError, extra_package
from percuss.explore.jobs.archive_layout import about_column, canonical, column_from, parsed
from percuss.explore.jobs.job import Column
from percuss.model.checks import path as checked_path
from percuss.recordings.file_formats import netcdf_content
from percuss.short_repr import ShortRepr

if TYPE_CHECKING:
    import xarray

    from percuss.explore.jobs.archive import Archive

_ROWS = 1 << 15  # rows of a CSV file that are made at once


def variables_of(
    columns: Mapping[str, Column],
    arrays: Mapping[str, Any],
    dims: Sequence[str],
    shape: Sequence[int],
    inner: Mapping[str, str],
    words: Mapping[str, Sequence[str]],
) -> dict[str, Any]:
    """The variables of a dataset over `dims`, with units, meanings and words; `inner`: the dimension of an item."""
    made: dict[str, Any] = {}
    for name, values in arrays.items():
        column = columns[name]
        own = [inner.get(name, f"{name}_{i}") for i in range(len(column.shape))]
        about = {"units": column.unit or "1", "long_name": column.meaning}
        if name in words:
            about["words"] = ", ".join(words[name])
        made[name] = ((*dims, *own), np.asarray(values).reshape(*shape, *column.shape), about)
    return made


class HandedOver(ShortRepr, ABC):
    """A result that hands its numbers over: as an xarray dataset, a pandas table, a file."""

    @abstractmethod
    def to_xarray(self) -> xarray.Dataset:
        """All numbers with named coordinates, units and meanings; numbers that stand for words have them in `words`."""

    def to_pandas(self) -> Any:
        """What has a number for every cell, start, point of a branch …, as a table with a row for each."""
        data = self.to_xarray()
        rows = _row_dims(data)
        return data[[name for name, one in data.data_vars.items() if one.dims == rows]].to_dataframe()

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write one file: NetCDF (``.nc``), which `load` reads, or a table as text (``.csv``)."""
        name = checked_path("path", path).lower()
        if name.endswith(".csv"):
            write_csv(self.to_xarray(), path)
        elif name.endswith(".nc"):
            write_dataset(self._content(), path)
        else:
            raise ParameterError("path", path, "a name that ends in .nc or .csv")

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Self:
        """The result that `save` wrote into a NetCDF file; ParameterError for a file of something else."""
        try:
            return cls._from_content(netcdf_content(Path(checked_path("path", path))))
        except (OSError, LookupError, TypeError, ValueError, AttributeError, zlib.error) as error:
            accepted = f"a file that {cls.__name__}.save wrote"
            raise ParameterError("path", str(path), accepted, repr(error)[:200]) from None

    @abstractmethod
    def _content(self) -> xarray.Dataset:
        """What a file holds: the numbers for others, and what `load` needs."""

    @classmethod
    @abstractmethod
    def _from_content(cls, data: xarray.Dataset) -> Self: ...


class OfColumns(HandedOver):
    """That of a job: columns, and what was asked."""

    columns: Mapping[str, Any]
    ask: dict[str, Any]

    @classmethod
    @abstractmethod
    def from_archive(cls, archive: Any) -> Self:
        """The result that an archive holds."""

    @property
    @abstractmethod
    def _about(self) -> Mapping[str, Column]:
        """What the columns hold."""

    def _content(self) -> xarray.Dataset:
        data = self.to_xarray()
        columns = {key: about_column(column) for key, column in self._about.items()}
        about = {"ask": canonical(self.ask), "columns": json.dumps(columns), "rows": json.dumps(_row_dims(data))}
        return data.assign_attrs({**data.attrs, **about})

    @classmethod
    def _from_content(cls, data: xarray.Dataset) -> Self:
        rows = json.loads(data.attrs["rows"])
        columns = {name: column_from(one) for name, one in json.loads(data.attrs["columns"]).items()}
        over = data[next(iter(data.data_vars))].isel({}).reset_coords(drop=True)
        flat = {}
        for name, column in columns.items():
            values = data[name].broadcast_like(over).transpose(*rows, ...).values
            flat[name] = values.reshape(-1, *column.shape).astype(column.dtype)
        size, ask = next(iter(flat.values())).shape[0], parsed(data.attrs["ask"])
        held = {"read": lambda: flat, "parts": lambda: [(0, size, flat)]}
        return cls.from_archive(SimpleNamespace(ask=ask, columns=columns, size=size, **held))


class OfValues(HandedOver):
    """One of any parts: all of it as plain values."""

    @abstractmethod
    def as_json(self) -> dict[str, Any]:
        """All of it as plain values, which `from_json` takes."""

    @classmethod
    @abstractmethod
    def from_json(cls, row: Mapping[str, Any]) -> Self:
        """`as_json` backwards."""

    def _content(self) -> xarray.Dataset:
        whole = zlib.compress(json.dumps({type(self).__name__: self.as_json()}).encode(), 6)
        return self.to_xarray().assign({_WHOLE: ("byte", np.frombuffer(whole, dtype=np.uint8))})

    @classmethod
    def _from_content(cls, data: xarray.Dataset) -> Self:
        whole = data[_WHOLE].values.astype(np.uint8).tobytes()
        return cls.from_json(json.loads(zlib.decompress(whole))[cls.__name__])


_WHOLE = "percuss_result"


def dataset_of(archive: Archive) -> xarray.Dataset:
    """What an archive holds, as its kind of result has it, with where it comes from in the attributes."""
    result = archive.result(**({"rows": archive.size} if archive.kind == "experiment" else {}))
    dataset = plain_dataset(archive) if not hasattr(result, "to_xarray") else result.to_xarray()
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
    axes = _axes(archive)
    shape = [len(values) for values, _ in axes.values()] or [archive.size]
    variables = variables_of(archive.columns, archive.read(), tuple(axes) or ("item",), shape, {}, {})
    coordinates: dict[str, Any] = {
        name: (name, np.array(values), {"units": unit or "1"}) for name, (values, unit) in axes.items()
    }
    made: xarray.Dataset = extra_package("xarray", "io").Dataset(
        variables, coordinates or {"item": np.arange(archive.size)}
    )
    return made


def write_csv(dataset: xarray.Dataset, path: str | os.PathLike[str]) -> None:
    """A line for each item of the first variable's dimension; more dimensions become columns; words as words."""
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
        inner, words = values.shape[len(dims) :], variable.attrs.get("words")
        values = values if words is None else np.array([*str(words).split(", "), ""])[values]
        for index in np.ndindex(inner):
            mark = "".join(f"_{j}" for j in index)
            fields.append((_header(f"{name}{mark}", variable), values[(..., *index)]))
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


def _texts(values: Any) -> list[Any]:
    """Numbers with all their digits; truth in lower case, as other programs write it."""
    found: list[Any] = values.tolist()
    return [str(value).lower() for value in found] if values.dtype == bool else found
