"""The arrays of an archive on the disk: a column each, chunk by chunk, and the signs of the chunks that are there."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from percuss.explore.jobs.archive_layout import DONE, whole_chunks
from percuss.explore.jobs.job import Column, Columns

__all__ = ["ChunkArrays", "chunk_bounds"]


def chunk_bounds(number: int, chunk: int, size: int) -> tuple[int, int]:
    """First item of a chunk, and the one after its last."""
    return number * chunk, min((number + 1) * chunk, size)


class ChunkArrays:
    """The arrays of one archive.

    Parameters
    ----------
    path, group
        The folder, and the zarr group in it.
    columns
        What the attributes of the archive say of the columns.
    size, chunk
        Items, and how many of them are in a chunk.

    Raises
    ------
    LookupError, ValueError
        When an array is missing, or of another kind than the attributes say.
    """

    def __init__(self, path: Path, group: Any, columns: Mapping[str, Column], size: int, chunk: int) -> None:
        self.path, self.columns, self.size, self.chunk = path, columns, size, chunk
        with whole_chunks():
            self._arrays = {name: group[name] for name in [*columns, DONE]}
        if size < 0 or chunk < 1:
            raise ValueError(f"{size} items in chunks of {chunk}")
        wanted = {name: (c.dtype, (size, *c.shape), chunk) for name, c in columns.items()}
        for name, (dtype, shape, each) in {**wanted, DONE: ("uint8", (-(-size // chunk),), 1)}.items():
            array = self._arrays[name]
            if (array.dtype, array.shape) != (np.dtype(dtype), shape) or array.chunks[0] != each:
                raise ValueError(f"the column {name} is of another kind")

    def signs(self) -> tuple[npt.NDArray[np.bool_], list[int]]:
        """Which chunks are done, and those of which this cannot be read."""
        try:
            return np.asarray(self._arrays[DONE][:]).astype(bool), []
        except Exception:  # whatever the codecs make of damage
            found = np.zeros(self._arrays[DONE].shape, dtype=bool)
            bad = []
            for number in range(len(found)):
                try:
                    found[number] = bool(self._arrays[DONE][number])
                except Exception:  # as above, of this one
                    bad.append(number)
            return found, bad

    def sign(self, number: int, done: int) -> None:
        """Note that a chunk is there, 1, or is not, 0."""
        self._arrays[DONE][number : number + 1] = np.full(1, done, dtype=np.uint8)

    def write(self, first: int, last: int, columns: Columns) -> None:
        """All columns of the items `first` … `last` − 1."""
        for name in self.columns:
            self._arrays[name][first:last] = columns[name]

    def column(self, name: str, signs: npt.NDArray[np.bool_]) -> tuple[npt.NDArray[Any], list[int]]:
        """A column, and the chunks of it that are done, as `signs` says, and not there as they were written."""
        column, array = self.columns[name], self._arrays[name]
        done = np.flatnonzero(signs).tolist()
        # of a file that is not there zarr gives the fill value
        bad = [number for number in done if array.size and not self._file(name, number).is_file()]
        try:
            return np.asarray(array[:]), bad
        except Exception:  # as above
            found = np.full(array.shape, column.empty, dtype=array.dtype)
        for number in done:
            first, last = chunk_bounds(number, self.chunk, self.size)
            try:
                found[first:last] = array[first:last]
            except Exception:  # as above, of this one
                bad.append(number)
        return found, sorted(set(bad))

    def _file(self, name: str, number: int) -> Path:
        inner = ["0"] * len(self.columns[name].shape)
        return self.path.joinpath(name, "c", str(number), *inner)
