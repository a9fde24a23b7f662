"""Checks MATLAB, HDF5 and TDMS files before a reader trusts what they say.

A few megabytes of them can stand for more numbers than any memory holds, and HDF5 can name other files to be read.
What is found here is refused; what is left, the readers read as always.
"""

from __future__ import annotations

import os
import struct
import zlib
from collections.abc import Iterator
from itertools import islice
from pathlib import Path
from typing import Any

from percuss.errors import HistoryError, MissingExtraError, extra_package

MOST_NUMBERS = 2**25
"""In one file, all its arrays together; as many as the largest file that is read holds of 16 bits each."""

MOST_UPLOADED = 5_000_000  # the same of a file that comes from elsewhere; as many as a text of 10 MB can hold
_MOST_ARRAYS = 10_000
_REMEDY = "save the plain numbers of time and force or pressure alone, or as CSV"


class Damaged(HistoryError):
    """A file that is not of its kind, or not complete."""


def _refused(message: str) -> HistoryError:
    return HistoryError(message, _REMEDY)


def too_many(most: int) -> HistoryError:
    """The refusal of a file that holds, or unpacks to, more numbers than that."""
    return _refused(f"unpacks to more than {most} numbers")


# -- MATLAB ---------------------------------------------------------------------------------------------------------

_MI_MATRIX, _MI_COMPRESSED = 14, 15
_NUMBERS = range(6, 16)
"""Classes of arrays of numbers: double, single, and whole numbers; others have cells, fields or objects in them."""


def plain_mat(data: bytes, most: int = MOST_NUMBERS) -> bytes:
    """A MATLAB file reduced to its plain arrays of at most so many numbers, unpacked; one that is HDF5 as it is."""
    if data[512:520] == b"\x89HDF\r\n\x1a\n":  # version 7.3
        return data
    order = {b"IM": "<", b"MI": ">"}.get(data[126:128])
    if order is None or data[124:126] != struct.pack(f"{order}H", 0x0100):
        raise Damaged("is not a MATLAB file of version 5 to 7.3", _REMEDY)
    found, left, size, most_bytes = [], most, 0, 8 * most
    for count, (kind, body) in enumerate(_elements(data, 128, order, padded=False), 1):
        if kind == _MI_COMPRESSED:
            matrix = _unpacked(body, most_bytes + 4096 - size, most)
        elif kind == _MI_MATRIX:
            matrix = struct.pack(f"{order}II", kind, len(body)) + body
        else:
            raise Damaged("is not a readable MATLAB file", _REMEDY)
        size += len(matrix)  # of what is left out too: unpacking it takes as long
        numbers = _numbers(matrix, order)
        if numbers is not None:
            found.append(matrix)
            left -= numbers
        if left < 0 or size > most_bytes or count > _MOST_ARRAYS:
            raise too_many(most)
    head = b"MATLAB 5.0 MAT-file".ljust(116) + bytes(8) + data[124:128]
    return head + b"".join(found)


def _unpacked(body: bytes, room: int, most: int) -> bytes:
    """Not more than `room` bytes are ever unpacked."""
    try:
        unpacking = zlib.decompressobj()
        matrix = unpacking.decompress(body, max(room, 1))
    except zlib.error:
        raise Damaged("is not a readable MATLAB file", _REMEDY) from None
    if unpacking.unconsumed_tail:
        raise too_many(most)
    if not unpacking.eof:
        raise Damaged("ends too early", _REMEDY)
    return matrix


def _elements(data: bytes, at: int, order: str, padded: bool) -> Iterator[tuple[int, bytes]]:
    """Kind and content of the elements from a place on, each within the data."""
    while at < len(data):
        if at + 8 > len(data):
            raise Damaged("ends too early", _REMEDY)
        kind, size = struct.unpack_from(f"{order}II", data, at)
        if padded and kind >> 16:  # a small one, packed into its own tag
            kind, size, at = kind & 0xFFFF, kind >> 16, at + 4
            if size > 4:
                raise Damaged("is not a readable MATLAB file", _REMEDY)
            end = at + 4
        else:
            at += 8
            end = at + (-(-size // 8) * 8 if padded else size)
        if at + size > len(data):
            raise Damaged("ends too early", _REMEDY)
        yield kind, data[at : at + size]
        at = end


def _numbers(matrix: bytes, order: str) -> int | None:
    """How many numbers a plain array holds; None of anything else."""
    if len(matrix) < 8 or struct.unpack_from(f"{order}II", matrix) != (_MI_MATRIX, len(matrix) - 8):
        raise Damaged("is not a readable MATLAB file", _REMEDY)
    parts = _elements(matrix, 8, order, padded=True)
    flags = next(parts, (0, b""))[1]
    if len(flags) != 8:
        raise Damaged("is not a readable MATLAB file", _REMEDY)
    if struct.unpack_from(f"{order}I", flags)[0] & 0xFF not in _NUMBERS:
        return None
    sizes = next(parts, (0, b""))[1]
    product = 1
    for extent in struct.unpack(f"{order}{len(sizes) // 4}i", sizes[: len(sizes) // 4 * 4]):
        if extent < 0 or len(sizes) > 4 * 32:
            raise Damaged("is not a readable MATLAB file", _REMEDY)
        product *= extent
    if len(list(islice(parts, 4))) > 3:  # name, real and imaginary part, each within its bounds
        raise Damaged("is not a readable MATLAB file", _REMEDY)
    return product


# -- HDF5 and TDMS --------------------------------------------------------------------------------------------------


def vetted(path: Path, most: int = MOST_NUMBERS) -> None:
    """Refuse a file of HDF5 or TDMS (by its suffix) that would unpack to too much, or that names other files."""
    with path.open("rb") as file:
        head = file.read(520)
    try:
        if path.suffix == ".tdms":
            if not head.startswith(b"TDSm"):
                raise Damaged("is not a TDMS file", _REMEDY)
            _vet_tdms(path, most)
        elif path.suffix != ".mat" or head[512:] == b"\x89HDF\r\n\x1a\n":
            vetted_hdf5(path, most)
    except (HistoryError, MissingExtraError):
        raise
    except Exception:  # a damaged file raises whatever it happens to hit
        raise Damaged("is not a readable file of its kind", _REMEDY) from None


def vetted_hdf5(path: Path, most: int) -> None:
    """Refuse a file of HDF5 that would unpack to too much, or whose arrays lie in other files."""
    os.environ["HDF5_PLUGIN_PRELOAD"] = "::"  # no filters but those of the library
    extra_package("h5py", "io")
    import h5py

    left = [most, _MOST_ARRAYS]

    def visit(name: str, item: Any) -> None:  # soft and external links are not visited, here nor by the reader
        _vet_attributes(item, h5py)
        if not isinstance(item, h5py.Dataset) or item.dtype.kind not in "iuf":
            return
        if item.is_virtual or item.external:
            raise _refused(f'"{name[:60]}" refers to another file')
        left[0] -= int(item.size or 0)
        left[1] -= 1
        if min(left) < 0:
            raise too_many(most)
        _vet_chunks(name, item, h5py, most)

    with h5py.File(path, "r") as content:
        _vet_attributes(content, h5py)
        content.visititems(visit)


def _vet_attributes(item: Any, h5py: Any) -> None:
    """Check the attributes that the reader looks at: each must be a word or a number."""
    for name in ("unit", "units", "sample_rate", "fs"):
        if name in item.attrs:
            found = h5py.h5a.open(item.id, name.encode())
            if found.get_storage_size() > 4096 or found.get_space().get_simple_extent_npoints() > 64:
                raise _refused(f"has an attribute {name} that is neither text nor a number")


def _vet_chunks(name: str, item: Any, h5py: Any, most: int) -> None:
    """What is packed unpacks to the size of its chunk: the library itself would unpack whatever there is."""
    if item.chunks is None:
        return
    creation = item.id.get_create_plist()
    filters = [creation.get_filter(i)[0] for i in range(creation.get_nfilters())]
    z = h5py.h5z
    if not set(filters) <= {z.FILTER_DEFLATE, z.FILTER_SHUFFLE, z.FILTER_FLETCHER32}:
        raise _refused(f'"{name[:60]}" is compressed, but not with gzip')
    size = item.dtype.itemsize
    for extent in item.chunks:
        size *= extent
    if size > 8 * most:
        raise too_many(most)
    if z.FILTER_DEFLATE not in filters:
        return
    # what follows gzip in the list was done to the packed bytes; only a check sum may
    behind = filters[filters.index(z.FILTER_DEFLATE) + 1 :]
    if behind not in ([], [z.FILTER_FLETCHER32]):
        raise _refused(f'"{name[:60]}" is compressed more than once')
    offsets: list[tuple[int, ...]] = []
    item.id.chunk_iter(lambda chunk: offsets.append(chunk.chunk_offset))
    for offset in offsets:
        mask, data = item.id.read_direct_chunk(offset)
        if not mask & 1 << filters.index(z.FILTER_DEFLATE):
            unpacked = zlib.decompressobj().decompress(data, size + 8)
            if len(unpacked) > size + 4:  # a check sum may be in it
                raise too_many(most)


def _vet_tdms(path: Path, most: int) -> None:
    try:
        from nptdms import TdmsFile
    except ImportError:
        raise MissingExtraError("npTDMS", "io") from None
    with TdmsFile.open(path) as content:
        channels = [channel for group in content.groups() for channel in group.channels()]
        numbers = sum(len(channel) for channel in channels)
    if len(channels) > _MOST_ARRAYS or numbers > most:
        raise too_many(most)
    if numbers > path.stat().st_size:  # TDMS packs nothing
        raise _refused("says that it holds more than it does")
