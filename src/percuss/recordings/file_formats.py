"""Files that are no text, with the extra ``[io]``: tables in ``.mat``, ``.h5``, ``.tdms``, ``.wav``, and NetCDF 4."""

from __future__ import annotations

import io
import math
import os
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from percuss.errors import HistoryError, MissingExtraError, extra_package
from percuss.recordings.columns import Array, RecordedTable
from percuss.recordings.separate_process import Found, bounds_of, need, read_apart
from percuss.recordings.untrusted_files import MOST_NUMBERS, Damaged, plain_mat, too_many, vetted, vetted_hdf5
from percuss.units import split_header

if TYPE_CHECKING:
    import xarray

# ---- Tables of named arrays


def _arrays_table(
    file: str, arrays: Iterable[tuple[str, str | None, npt.NDArray[Any]]], sample_rate: float | None = None
) -> RecordedTable:
    """A table of the one-dimensional numeric arrays, and of the columns of two-dimensional ones."""
    names: list[str] = []
    units: list[str | None] = []
    data: list[Array] = []
    left = MOST_NUMBERS
    for name, unit, array in arrays:
        flat = np.squeeze(np.asarray(array))
        if flat.dtype.kind not in "iuf" or flat.ndim > 2:
            continue
        if flat.ndim == 0:
            if name.split("/")[-1].lower() in {"fs", "sample_rate", "samplerate", "sampling_rate"} and flat > 0:
                sample_rate = float(flat)
            continue
        left -= flat.size
        if left < 0:  # as doubles they take several times the room that they take in the file
            raise _named(too_many(MOST_NUMBERS), file)
        block = np.atleast_2d(flat) if flat.ndim == 1 or flat.shape[0] < flat.shape[1] else flat.T
        plain, own = split_header(name)
        for j, row in enumerate(block):
            names.append(plain if len(block) == 1 else f"{plain}:{j + 1}")
            units.append(unit or own)
            data.append(row.astype(float))
    if not data:
        remedy = "save time and force or pressure as plain arrays"
        if file.lower().endswith(".mat"):
            remedy += ", not in a struct: save(file, '-struct', 'name') writes the fields of one"
        raise HistoryError("holds no array of numbers", remedy, file)
    return RecordedTable(
        file, names, units, [True] * len(data), lambda columns: [data[i] for i in columns], sample_rate=sample_rate
    )


def _damaged(path: Path, kind: str, error: Exception) -> HistoryError:
    told = error.message if isinstance(error, HistoryError) else error
    return HistoryError(f"is not a readable {kind} file ({told})"[:300], "save it again or export it as CSV", str(path))


def _named(error: HistoryError, file: str) -> HistoryError:
    return HistoryError(error.message, error.remedy, file)


@contextmanager
def _read(path: Path, kind: str) -> Iterator[None]:
    """Whatever a damaged file makes its reader raise, as a `HistoryError` with its name."""
    try:
        yield
    except MissingExtraError:
        raise
    except Damaged as error:
        raise _damaged(path, kind, error) from None
    except HistoryError as error:
        raise error if error.file else _named(error, str(path)) from None
    except Exception as error:
        raise _damaged(path, kind, error) from None


def _read_mat(path: Path) -> RecordedTable:
    extra_package("scipy", "io")
    from scipy.io import loadmat

    with _read(path, "MATLAB"):
        data = path.read_bytes()
        version_4 = 0 in data[:4]  # which packs nothing
    if data[512:520] == b"\x89HDF\r\n\x1a\n":  # MATLAB 7.3 writes HDF5
        return _read_h5(path)
    with _read(path, "MATLAB"):
        plain = data if version_4 else plain_mat(data)
        content = loadmat(io.BytesIO(plain))  # type: ignore[arg-type]  # files are taken too
    return _arrays_table(
        str(path), [(k, None, v) for k, v in content.items() if not k.startswith("__") and isinstance(v, np.ndarray)]
    )


def _read_h5(path: Path) -> RecordedTable:
    need("h5py")
    told, arrays = read_apart("percuss.recordings.file_formats:h5_content", path, {}, bounds_of(path))
    rates = told["rates"]
    found = [(name, told["units"][name], array) for name, array in arrays.items()]
    return _arrays_table(str(path), found, rates[0] if rates else None)


def h5_content(path: Path, _: Mapping[str, Any]) -> Found:
    """The arrays of numbers in a file of HDF5, with their units, and the sample rates that it tells."""
    import h5py

    units: dict[str, str | None] = {}
    arrays: dict[str, npt.NDArray[Any]] = {}
    rates: list[float] = []

    def visit(name: str, item: Any) -> None:
        if isinstance(item, h5py.Dataset) and item.dtype.kind in "iuf":
            unit = next((item.attrs[a] for a in ("unit", "units") if a in item.attrs), None)
            units[name] = unit.decode() if isinstance(unit, bytes) else None if unit is None else str(unit)
            arrays[name] = np.asarray(item[()])
            rates.extend(float(item.attrs[a]) for a in ("sample_rate", "fs") if a in item.attrs)

    with _read(path, "HDF5"):
        vetted(path)
        with h5py.File(path, "r") as content:
            rates.extend(float(content.attrs[a]) for a in ("sample_rate", "fs") if a in content.attrs)
            content.visititems(visit)
    return {"units": units, "rates": rates}, arrays


def _read_tdms(path: Path) -> RecordedTable:
    try:
        from nptdms import TdmsFile
    except ImportError:
        raise MissingExtraError("npTDMS", "io") from None
    with _read(path, "TDMS"):
        vetted(path)
        groups = TdmsFile.read(path).groups()
        channels = [(group, channel) for group in groups for channel in group.channels()]
        steps = [float(c.properties["wf_increment"]) for _, c in channels if "wf_increment" in c.properties]
        found = [
            (c.name if len(groups) == 1 else f"{g.name}/{c.name}", c.properties.get("unit_string") or None, c[:])
            for g, c in channels
        ]
    return _arrays_table(str(path), found, 1.0 / steps[0] if steps and steps[0] > 0 else None)


def _read_wav(path: Path) -> RecordedTable:
    extra_package("scipy", "io")
    from scipy.io import wavfile

    with _read(path, "WAV"), warnings.catch_warnings():
        warnings.simplefilter("ignore")  # unknown chunks are of no interest
        rate, data = wavfile.read(path)
    if data.dtype.kind in "iu":
        bits = 8 * data.dtype.itemsize
        data = (data.astype(float) - (128.0 if data.dtype.kind == "u" else 0.0)) / math.ldexp(1.0, bits - 1)
    return _arrays_table(str(path), [("channel", None, data)], float(rate))


READERS: dict[str, Callable[[Path], RecordedTable]] = {
    ".mat": _read_mat,
    ".h5": _read_h5,
    ".hdf5": _read_h5,
    ".tdms": _read_tdms,
    ".wav": _read_wav,
}
"""By the ending of the file; any other is read as text."""


# ---- NetCDF 4: the variables of a file as plain arrays


def netcdf_content(path: Path) -> xarray.Dataset:
    """What a file holds, as it is written: nothing that it says of scales and dates is done to its numbers."""
    extra_package("xarray", "io")
    import xarray

    need("h5netcdf")
    told, arrays = read_apart("percuss.recordings.file_formats:read_netcdf", path, {}, bounds_of(path))
    try:
        variables = {name: (dims, arrays[name], about) for name, (dims, about) in told["variables"].items()}
        return xarray.Dataset(variables, attrs=told["attributes"])
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
