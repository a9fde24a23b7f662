"""Tables in ``.mat``, ``.h5``, ``.tdms`` and ``.wav`` files, with the extra ``[io]``; each gives named arrays."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from percuss.errors import HistoryError, MissingExtraError
from percuss.model.checks import Array
from percuss.model.table import Table
from percuss.units import split_header

__all__ = ["READERS"]


def _arrays_table(
    file: str, arrays: Iterable[tuple[str, str | None, npt.NDArray[Any]]], sample_rate: float | None = None
) -> Table:
    """A table of the one-dimensional numeric arrays, and of the columns of two-dimensional ones."""
    names: list[str] = []
    units: list[str | None] = []
    data: list[Array] = []
    for name, unit, array in arrays:
        flat = np.squeeze(np.asarray(array))
        if flat.dtype.kind not in "iuf" or flat.ndim > 2:
            continue
        if flat.ndim == 0:
            if name.split("/")[-1].lower() in {"fs", "sample_rate", "samplerate", "sampling_rate"} and flat > 0:
                sample_rate = float(flat)
            continue
        block = np.atleast_2d(flat) if flat.ndim == 1 or flat.shape[0] < flat.shape[1] else flat.T
        plain, own = split_header(name)
        for j, row in enumerate(block):
            names.append(plain if len(block) == 1 else f"{plain}:{j + 1}")
            units.append(unit or own)
            data.append(row.astype(float))
    if not data:
        raise HistoryError("holds no array of numbers", "save time and force or pressure as plain arrays", file)
    return Table(
        file, names, units, [True] * len(data), lambda columns: [data[i] for i in columns], sample_rate=sample_rate
    )


def _damaged(path: Path, kind: str, error: Exception) -> HistoryError:
    return HistoryError(f"is no readable {kind} file ({error})"[:300], "save it again, or export it as CSV", str(path))


def _read_mat(path: Path) -> Table:
    try:
        from scipy.io import loadmat
    except ImportError:
        raise MissingExtraError("scipy", "io") from None
    try:
        content = loadmat(path)
    except NotImplementedError:  # MATLAB 7.3 writes HDF5
        return _read_h5(path)
    except Exception as error:  # a damaged file raises whatever it happens to hit
        raise _damaged(path, "MATLAB", error) from None
    return _arrays_table(
        str(path), [(k, None, v) for k, v in content.items() if not k.startswith("__") and isinstance(v, np.ndarray)]
    )


def _read_h5(path: Path) -> Table:
    try:
        import h5py
    except ImportError:
        raise MissingExtraError("h5py", "io") from None
    found: list[tuple[str, str | None, npt.NDArray[Any]]] = []
    rates: list[float] = []

    def visit(name: str, item: Any) -> None:
        if isinstance(item, h5py.Dataset) and item.dtype.kind in "iuf":
            unit = next((item.attrs[a] for a in ("unit", "units") if a in item.attrs), None)
            found.append((name, unit.decode() if isinstance(unit, bytes) else unit, item[()]))
            rates.extend(float(item.attrs[a]) for a in ("sample_rate", "fs") if a in item.attrs)

    try:
        with h5py.File(path, "r") as content:
            rates.extend(float(content.attrs[a]) for a in ("sample_rate", "fs") if a in content.attrs)
            content.visititems(visit)
    except Exception as error:  # as above
        raise _damaged(path, "HDF5", error) from None
    return _arrays_table(str(path), found, rates[0] if rates else None)


def _read_tdms(path: Path) -> Table:
    try:
        from nptdms import TdmsFile
    except ImportError:
        raise MissingExtraError("npTDMS", "io") from None
    try:
        groups = TdmsFile.read(path).groups()
        channels = [(group, channel) for group in groups for channel in group.channels()]
        steps = [float(c.properties["wf_increment"]) for _, c in channels if "wf_increment" in c.properties]
        found = [
            (c.name if len(groups) == 1 else f"{g.name}/{c.name}", c.properties.get("unit_string") or None, c[:])
            for g, c in channels
        ]
    except Exception as error:  # as above
        raise _damaged(path, "TDMS", error) from None
    return _arrays_table(str(path), found, 1.0 / steps[0] if steps and steps[0] > 0 else None)


def _read_wav(path: Path) -> Table:
    try:
        from scipy.io import wavfile
    except ImportError:
        raise MissingExtraError("scipy", "io") from None
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # unknown chunks are of no interest
            rate, data = wavfile.read(path)
    except Exception as error:  # as above
        raise _damaged(path, "WAV", error) from None
    if data.dtype.kind in "iu":
        bits = 8 * data.dtype.itemsize
        data = (data.astype(float) - (128.0 if data.dtype.kind == "u" else 0.0)) / math.ldexp(1.0, bits - 1)
    return _arrays_table(str(path), [("channel", None, data)], float(rate))


READERS: dict[str, Callable[[Path], Table]] = {
    ".mat": _read_mat,
    ".h5": _read_h5,
    ".hdf5": _read_h5,
    ".tdms": _read_tdms,
    ".wav": _read_wav,
}
"""By the ending of the file; any other is read as text."""
