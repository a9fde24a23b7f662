"""NetCDF 4 files: their variables as plain arrays, read by a process of its own."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from percuss.errors import HistoryError, extra_package
from percuss.recordings.separate_process import Found, bounds_of, need, read_apart
from percuss.recordings.untrusted_files import MOST_NUMBERS, Damaged, vetted_hdf5

if TYPE_CHECKING:
    from xarray import Dataset


def netcdf_content(path: Path) -> Dataset:
    """What a file holds, as it is written: nothing that it says of scales and dates is done to its numbers."""
    xarray = extra_package("xarray", "io")
    need("h5netcdf")
    told, arrays = read_apart("percuss.recordings.netcdf_file:read_netcdf", path, {}, bounds_of(path))
    try:
        variables = {name: (dims, arrays[name], about) for name, (dims, about) in told["variables"].items()}
        made: Dataset = xarray.Dataset(variables, attrs=told["attributes"])
        return made
    except ValueError:  # sizes that contradict each other
        raise Damaged("is not a readable NetCDF 4 file") from None


def read_netcdf(path: Path, _: Mapping[str, Any]) -> Found:
    """Dimensions and attributes of the variables, and their numbers."""
    import h5netcdf
    import h5py

    try:
        vetted_hdf5(path, most=os.path.getsize(path) // 4 + MOST_NUMBERS)
        with h5py.File(path, "r") as content:
            links = [content.get(key, getlink=True) for key in content]
        if not all(isinstance(link, h5py.HardLink) for link in links):
            raise HistoryError("refers to another file")
        with h5netcdf.File(path, "r", decode_vlen_strings=True) as content:
            arrays = {name: _plain(np.asarray(variable[...])) for name, variable in content.variables.items()}
            about = {name: (list(v.dimensions), _said(v.attrs)) for name, v in content.variables.items()}
            return {"variables": about, "attributes": _said(content.attrs)}, arrays
    except HistoryError:
        raise
    except Exception:  # a damaged file raises whatever it happens to hit
        raise Damaged("is not a readable NetCDF 4 file") from None


def _plain(array: Any) -> Any:
    """Texts as arrays of fixed width: all others are plain."""
    return array.astype(str) if array.dtype == object else array


def _said(attributes: Mapping[str, Any]) -> dict[str, Any]:
    plain = {name: value.tolist() if hasattr(value, "tolist") else value for name, value in attributes.items()}
    return {name: value.decode() if isinstance(value, bytes) else value for name, value in plain.items()}
