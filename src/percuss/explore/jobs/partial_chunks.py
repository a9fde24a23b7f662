"""The items of chunks that are not complete yet, kept beside them, so that a kill loses a second of work and no more.

A file to which records are added: the first item, the one after the last, and the bytes of all columns of the items
between, with a check sum. A record that was being written when the process was killed is passed over, and so is all
behind it.
"""

from __future__ import annotations

import math
import os
import struct
import zlib
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from pathlib import Path

import numpy as np

from percuss.explore.jobs.job import Column, Columns
from percuss.whole_file import replaced

__all__ = ["Record", "Underway"]

FILE = ".percuss-underway"
"""Name of the file inside the folder of the archive."""

Record = tuple[int, int, Columns]
"""First item, the one after the last, and their columns."""

_HEAD = struct.Struct("<8sQQQI")
_MARK = b"percuss1"
_APPEND = os.O_WRONLY | os.O_CREAT | os.O_APPEND | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_BINARY", 0)


class Underway:
    """The file of one archive.

    Attributes
    ----------
    bytes
        That this process knows to be in it.
    """

    def __init__(self, folder: Path, columns: Mapping[str, Column], size: int) -> None:
        self.bytes = 0
        self._file = folder / FILE
        self._columns = columns
        self._size = size

    def records(self) -> Iterator[Record]:
        """All that are whole, in the order in which they were kept."""
        try:
            if self._file.is_symlink():
                return
            data = memoryview(self._file.read_bytes())
        except OSError:
            return
        at = 0
        while at + _HEAD.size <= len(data):
            mark, first, last, size, check = _HEAD.unpack_from(data, at)
            body = data[at + _HEAD.size : at + _HEAD.size + size]
            fits = mark == _MARK and first < last <= self._size and size == self._width() * (last - first) == len(body)
            if not fits or check != _check(first, last, body):
                return
            yield first, last, self._unpacked(body, last - first)
            at += _HEAD.size + size

    def add(self, records: Iterable[Record]) -> None:
        """Keep more.

        Raises
        ------
        OSError
            When the disk is full or cannot be written.
        """
        data = b"".join(self._packed(*record) for record in records)
        if not data:
            return
        handle = os.open(self._file, _APPEND, 0o666)
        try:
            left = memoryview(data)
            while left:
                left = left[os.write(handle, left) :]
        finally:
            os.close(handle)
        self.bytes += len(data)

    def begin(self, records: Iterable[Record]) -> None:
        """Keep these and nothing else.

        Raises
        ------
        OSError
            As `add`.
        """
        data = b"".join(self._packed(*record) for record in records)
        self.bytes = len(data)
        if not data:
            self.remove()
            return
        with replaced(self._file, follow=False) as part, open(part, "wb") as file:
            file.write(data)

    def remove(self) -> None:
        """Keep nothing."""
        self.bytes = 0
        with suppress(FileNotFoundError):
            self._file.unlink()

    def _width(self) -> int:
        """Bytes of an item."""
        return sum(np.dtype(column.dtype).itemsize * math.prod(column.shape) for column in self._columns.values())

    def _packed(self, first: int, last: int, columns: Columns) -> bytes:
        parts = [
            np.ascontiguousarray(columns[name], dtype=np.dtype(column.dtype).newbyteorder("<")).tobytes()
            for name, column in self._columns.items()
        ]
        body = b"".join(parts)
        return _HEAD.pack(_MARK, first, last, len(body), _check(first, last, body)) + body

    def _unpacked(self, body: memoryview, items: int) -> Columns:
        found: Columns = {}
        at = 0
        for name, column in self._columns.items():
            kind = np.dtype(column.dtype)
            count = items * math.prod(column.shape)
            values = np.frombuffer(body, kind.newbyteorder("<"), count, at)
            found[name] = values.astype(kind).reshape(items, *column.shape)
            at += count * kind.itemsize
        return found


def _check(first: int, last: int, body: bytes | memoryview) -> int:
    return zlib.crc32(body, zlib.crc32(struct.pack("<QQ", first, last)))
