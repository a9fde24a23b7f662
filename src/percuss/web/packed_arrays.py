"""Arrays on their way to the page: a short JSON header and then the numbers as they lie in memory."""

from __future__ import annotations

import json
import struct
from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

__all__ = ["packed"]

_KINDS = {"f": "<f4", "b": "|u1", "u": "|u1", "i": "<i2"}
"""What each kind of numpy's travels as."""


def packed(header: Mapping[str, Any], arrays: Mapping[str, npt.NDArray[Any]]) -> bytes:
    """Header and arrays as one byte string: the length of the header in 4 bytes, the header, the arrays.

    Everything is little endian; the header is padded so that every array begins at a multiple of 8. Numbers beyond
    32 bits become infinite, whole numbers are clipped to 16 bits, truth values are 0 and 1.

    Examples
    --------
    >>> data = packed({"title": "x"}, {"t": np.array([0.0, 0.5])})
    >>> (4 + int.from_bytes(data[:4], "little")) % 8
    0
    """
    parts: list[bytes] = []
    told: list[dict[str, Any]] = []
    offset = 0
    for name, values in arrays.items():
        kind = _KINDS[values.dtype.kind]
        given = np.clip(values, -32768, 32767) if kind == "<i2" else values
        with np.errstate(over="ignore"):
            raw = np.ascontiguousarray(given, dtype=kind).tobytes()
        told.append({"name": name, "dtype": kind[1:], "shape": list(values.shape), "offset": offset, "bytes": len(raw)})
        room = -len(raw) % 8
        parts += [raw, b"\0" * room]
        offset += len(raw) + room
    text = json.dumps({**header, "arrays": told}, allow_nan=False, ensure_ascii=False).encode()
    text += b" " * (-(4 + len(text)) % 8)
    return b"".join([struct.pack("<I", len(text)), text, *parts])
