"""Recordings that would do harm, as bytes: too much in a small file, other files inside, what is not what it says."""

from __future__ import annotations

import struct
import zlib
from typing import Any

import numpy as np
import pytest


def hdf5(folder: Any, make: Any) -> bytes:
    h5py = pytest.importorskip("h5py")
    with h5py.File(folder / "made.h5", "w") as content:
        make(content)
    return bytes((folder / "made.h5").read_bytes())


def mat(*elements: tuple[int, bytes]) -> bytes:
    head = b"MATLAB 5.0 MAT-file".ljust(116) + bytes(8) + b"\x00\x01IM"
    return head + b"".join(struct.pack("<II", kind, len(body)) + body for kind, body in elements)


def matrix(kind: int, sizes: tuple[int, ...], data: bytes = b"", told: int | None = None) -> bytes:
    """An array of MATLAB of version 5, its data of `told` bytes."""
    body = struct.pack("<IIII", 6, 8, kind, 0) + struct.pack("<II", 5, 4 * len(sizes))
    body += struct.pack(f"<{len(sizes)}i", *sizes).ljust(-(-len(sizes) // 2) * 8, b"\0") + struct.pack("<II", 1, 8)
    body += b"force_kN" + struct.pack("<II", 9, len(data) if told is None else told) + data
    return struct.pack("<II", 14, len(body)) + body


def bombs(folder: Any) -> dict[str, tuple[str, bytes, str]]:
    """Recordings that would do harm: name, bytes, and what the refusal says."""
    zeros = np.zeros(4000)

    def no_gzip_of_its_size(content: Any) -> None:
        found = content.create_dataset("force", shape=(1000,), dtype="f8", chunks=(1000,), compression="gzip")
        found.id.write_direct_chunk((0,), zlib.compress(bytes(50_000_000), 9))

    def virtual(content: Any) -> None:
        import h5py

        layout = h5py.VirtualLayout(shape=(4000,), dtype="f8")
        layout[:] = h5py.VirtualSource(str(folder / "secret.h5"), "force", shape=(4000,))
        content.create_virtual_dataset("force", layout)

    def linked(content: Any) -> None:
        import h5py

        content["force"] = h5py.ExternalLink(str(folder / "secret.h5"), "force")
        content["time"] = h5py.SoftLink("/force")

    def outside(content: Any) -> None:
        content.create_dataset("force", shape=(4000,), dtype="f8", external=[(str(folder / "secret.bin"), 0, 32_000)])

    def huge(content: Any) -> None:
        content.create_dataset("force", shape=(10**12,), dtype="f8", chunks=(10**6,), compression="gzip")

    def bare(content: Any) -> None:
        content.create_dataset("force", shape=(10**12,), dtype="f8")

    def objects(content: Any) -> None:
        import h5py

        content.create_dataset("force", data=np.array([b"cos\nsystem\n"] * 20, dtype=object), dtype=h5py.string_dtype())
        content.create_dataset("pickle", data=np.void(b"\x80\x04cos\nsystem\n."))

    def plain(content: Any) -> None:
        content["force"] = zeros + 3.0

    secret = hdf5(folder, plain)
    (folder / "secret.h5").write_bytes(secret)
    (folder / "secret.bin").write_bytes(zeros.tobytes())
    too_much, numbers = "more than 5000000 numbers", matrix(6, (1, 4000), bytes(32_000))
    cells = matrix(1, (1, 1), bytes(30_000_000))
    return {
        "hdf5 head": ("a.h5", b"\x89HDF\r\n\x1a\n", "not a readable"),
        "hdf5 cut": ("a.h5", secret[:3000], "not a readable"),
        "hdf5 of another kind": ("a.hdf5", b"time,force\n" * 100, "not a readable"),
        "hdf5 huge": ("a.h5", hdf5(folder, huge), too_much),
        "hdf5 huge, nothing stored": ("a.h5", hdf5(folder, bare), too_much),
        "hdf5 gzip beyond its chunk": ("a.h5", hdf5(folder, no_gzip_of_its_size), too_much),
        "hdf5 virtual": ("a.h5", hdf5(folder, virtual), "another file"),
        "hdf5 external data": ("a.h5", hdf5(folder, outside), "another file"),
        "hdf5 links": ("a.h5", hdf5(folder, linked), "no array of numbers"),
        "hdf5 objects": ("a.h5", hdf5(folder, objects), "no array of numbers"),
        "mat 7.3 virtual": ("a.mat", bytes(512) + hdf5(folder, virtual), "another file"),
        "mat head": ("a.mat", b"MATLAB 5.0 MAT-file", "not a MATLAB file"),
        "mat version 4": (
            "a.mat",
            struct.pack("<5i", 0, 10**6, 10**6, 0, 2) + b"a\0" + bytes(200),
            "not a MATLAB file",
        ),
        "mat cut": ("a.mat", mat((15, zlib.compress(numbers)))[:-9], "ends too early"),
        "mat gzip": ("a.mat", mat((15, zlib.compress(matrix(6, (1, 7_000_000), bytes(56_000_000)), 9))), too_much),
        "mat gzip of zeros": ("a.mat", mat((15, zlib.compress(bytes(90_000_000), 9))), too_much),
        "mat told": ("a.mat", mat((15, zlib.compress(matrix(6, (1, 4000), bytes(80), 32_000)))), "ends too early"),
        "mat cells": ("a.mat", mat((14, matrix(1, (30_000, 30_000))[8:])), "no array of numbers"),
        "mat extents": ("a.mat", mat((14, matrix(6, (-1, 4000), bytes(32_000))[8:])), "not a readable"),
        "mat extents and data": ("a.mat", mat((14, matrix(6, (9, 400), bytes(32_000))[8:])), "not a readable"),
        "mat many cells": ("a.mat", mat(*[(15, zlib.compress(cells, 9))] * 2), too_much),
        "mat many parts": ("a.mat", mat((14, matrix(6, (1, 1), bytes(8) + bytes(8) * 9, 8)[8:])), "not a readable"),
        "tdms head": ("a.tdms", b"TDSm", "no array of numbers"),
        "tdms of another kind": ("a.tdms", b"RIFF" * 30, "not a TDMS"),
        "tdms told": ("a.tdms", _tdms(folder, 10**12), "no readable|numbers|holds|constant"),
        "npz": ("a.npz", b"PK\x03\x04", "ends in"),
    }


def _tdms(folder: Any, told: int) -> bytes:
    """A file that says that its channel has so many values."""
    nptdms = pytest.importorskip("nptdms")
    with nptdms.TdmsWriter(folder / "made.tdms") as file:
        file.write_segment([nptdms.ChannelObject("g", "force", np.zeros(777))])
    data: bytes = (folder / "made.tdms").read_bytes()
    return data.replace(struct.pack("<Q", 777), struct.pack("<Q", told))
