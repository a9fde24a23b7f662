"""What files of saved motions share: read whole or refused, with a sum that shows damage, records as plain numbers."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from percuss.errors import HistoryError, MissingExtraError, PercussError
from percuss.model.checks import path as checked_path
from percuss.recordings.untrusted_files import vetted_hdf5

if TYPE_CHECKING:
    import xarray

__all__ = ["SAID", "damaged", "digest", "opened", "plain", "records", "xarray_package"]

SAID = ("format", "label", "outcome", "description")
"""What is said in every file beside its numbers."""

_REMEDY = "give a file that 'percuss simulate -o', Trajectory.save or MachineTrajectory.save wrote"


def opened(path: str | os.PathLike[str]) -> tuple[str, xarray.Dataset]:
    """The name of a file and its content, of any format.

    Raises
    ------
    PercussError
        When there is no such file, or it is none that can be read.
    """
    name = checked_path("path", path)
    package = xarray_package()
    _need("h5netcdf")
    try:
        _vetted(name)
        # as it is written: what a file says of scales and dates would be done to numbers that are none
        with package.open_dataset(name, engine="h5netcdf", decode_cf=False) as dataset:
            dataset.load()
    except FileNotFoundError:
        raise PercussError(f"{name}: no such file", _REMEDY) from None
    except HistoryError as error:
        raise PercussError(f"{name}: {error.message}", _REMEDY) from None
    except Exception:  # a damaged file raises whatever it happens to hit
        raise PercussError(f"{name}: not a NetCDF 4 file, or a damaged one", _REMEDY) from None
    return name, dataset


def _vetted(name: str) -> None:
    """Refuse a file of which a few bytes stand for many numbers, or that would have others read."""
    import h5py

    vetted_hdf5(Path(name), most=os.path.getsize(name) // 4 + 2**25)
    with h5py.File(name, "r") as content:
        links = [content.get(key, getlink=True) for key in content]
    if not all(isinstance(link, h5py.HardLink) for link in links):
        raise HistoryError("refers to another file")


def damaged(name: str, what: str) -> PercussError:
    """The refusal of a file that is not what was written."""
    return PercussError(f"{name}: the file is damaged: {what}", "use a copy of it, or simulate again")


def digest(dataset: xarray.Dataset, told: str = "system") -> str:
    """SHA-256 of all numbers, their names, types and shapes, and of what is said about them; `told`: of what moves."""
    found = hashlib.sha256()
    for name in sorted(map(str, dataset.variables)):
        values = np.ascontiguousarray(dataset[name].values)
        found.update(f"{name} {values.dtype.newbyteorder('<').str} {values.shape}\n".encode())
        found.update(values.astype(values.dtype.newbyteorder("<"), copy=False).tobytes())
    for name in (*SAID[:3], told, *SAID[3:]):
        found.update(f"{name} {dataset.attrs[name]}\n".encode())
    return found.hexdigest()


def plain(name: str, array: npt.NDArray[Any]) -> tuple[list[str], npt.NDArray[Any], dict[str, str]]:
    """Records as rows of plain numbers, with the names of the columns beside them."""
    names = array.dtype.names
    about = {} if names is None else {"fields": " ".join(names)}
    if names is not None:
        array = array.view(_number_of(array.dtype)).reshape(array.shape[0], -1)
    return [f"engine_{name}_{i}" for i in range(array.ndim)], array, about


def _number_of(kind: np.dtype[Any]) -> np.dtype[Any]:
    """What the fields of a record are kept as; their bits as whole numbers where they are of several types."""
    types = {kind[i] for i in range(len(kind.names or ()))}
    return types.pop() if len(types) == 1 else np.dtype(np.int64)


def records(name: str, data: xarray.DataArray, kinds: Mapping[str, np.dtype[Any]]) -> npt.NDArray[Any]:
    """The records again; `kinds`: the types of those arrays that hold records.

    Raises
    ------
    ValueError
        When the columns are not the ones that this version knows.
    """
    values = np.ascontiguousarray(data.values)
    if name not in kinds:
        return values
    kind = kinds[name]
    names = kind.names or ()
    if (
        data.attrs.get("fields") != " ".join(names)
        or values.dtype != _number_of(kind)
        or values.shape[1:] != (len(names),)
    ):
        raise ValueError(f"engine_{name} has other columns")
    return values.view(kind).reshape(-1)


def xarray_package() -> Any:
    """The package xarray.

    Raises
    ------
    MissingExtraError
        When it is not installed.
    """
    try:
        import xarray
    except ImportError:
        raise MissingExtraError("xarray", "io") from None
    return xarray


def _need(package: str) -> None:
    from importlib.util import find_spec

    if find_spec(package) is None:
        raise MissingExtraError(package, "io")
