"""Files that are whole or not there: the one way in which this package writes a file.

What is written goes into a new file of a random name in the same folder, which nobody can have put there before; it is
brought to the disk, and only then given its name. So a full disk, a kill or a power cut leaves what was there before,
never a stump; and no link that somebody has laid is followed but the one that was named.
"""

from __future__ import annotations

import errno
import io
import os
import secrets
import stat
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING

from percuss.errors import PercussError, extra_package

if TYPE_CHECKING:
    import xarray

PARTS = ".percuss-????????????????.part"
"""Names of what is being written, for `glob`; one is left behind only by a process that was killed."""

_FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
_NO_SYNC = (errno.EINVAL, errno.ENOTSUP, errno.ENOSYS, errno.EBADF)
"""What file systems say that have nothing to bring to a disk."""

_NEW = os.O_RDWR | os.O_CREAT | os.O_EXCL | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_BINARY", 0)


@contextmanager
def whole_file(path: str | os.PathLike[str]) -> Iterator[str]:
    """The name of an empty file to fill, which takes the place of `path` at the block's end; errors name `path`."""
    try:
        with replaced(path) as part:
            yield part
    except OSError as error:
        full = error.errno in _FULL
        remedy = "free some space, or give another place" if full else "give a place where you may write"
        told = f"{os.fspath(path)}: cannot be written: {error.strerror or error}"
        raise PercussError(told, remedy) from error


def write_whole(path: str | os.PathLike[str], content: str | bytes) -> None:
    """Write all of a file at once, text as UTF-8 with its line ends as they are."""
    with whole_file(path) as part, open(part, "wb") as file:
        file.write(content.encode() if isinstance(content, str) else content)


def write_dataset(dataset: xarray.Dataset, path: str | os.PathLike[str]) -> None:
    """Write a dataset as one NetCDF 4 file."""
    h5netcdf = extra_package("h5netcdf", "io")
    from xarray.backends import H5NetCDFStore

    with whole_file(path) as part, open(part, "r+b", buffering=0) as raw:
        file = _Patient(raw)
        with h5netcdf.File(file, "w") as content:
            dataset.dump_to_store(H5NetCDFStore(content))
        if file.error is not None:
            raise file.error


class _Patient:
    """A file that keeps the first error of the disk until asked: HDF5 would end the process when it cannot write."""

    def __init__(self, raw: io.FileIO) -> None:
        self.error: OSError | None = None
        self._raw = raw

    def read(self, size: int = -1) -> bytes:
        return self._raw.read(size)  # never called: that it is there tells the libraries that this is a file

    def write(self, data: bytes) -> int:
        left = memoryview(data)
        while left and self.error is None:
            try:
                left = left[self._raw.write(left) :]
            except OSError as error:
                self.error = error
        return len(data)

    def readinto(self, buffer: bytearray) -> int:
        found = self._raw.readinto(buffer) or 0
        memoryview(buffer)[found:] = bytes(len(buffer) - found)  # of what could not be written
        return len(buffer)

    def seek(self, offset: int, whence: int = os.SEEK_SET) -> int:
        return self._raw.seek(offset, whence)

    def tell(self) -> int:
        return self._raw.tell()

    def truncate(self, size: int) -> int:
        try:
            return self._raw.truncate(size)
        except OSError as error:
            self.error = self.error or error
            return size

    def flush(self) -> None:
        """Nothing is held back."""


@contextmanager
def replaced(path: str | os.PathLike[str], follow: bool = True) -> Iterator[str]:
    """As `whole_file`, with the errors of the system as they are; without `follow` a link is replaced by the file."""
    folder, name = os.path.split(os.path.abspath(path))
    target = os.path.realpath(path) if follow else os.path.join(os.path.realpath(folder), name)
    before = _regular(target, follow)
    folder = os.path.dirname(target)
    part = os.path.join(folder, f".percuss-{secrets.token_hex(8)}.part")
    handle = os.open(part, _NEW, 0o666)
    try:
        try:
            if before is not None and hasattr(os, "fchmod"):
                with suppress(OSError):  # only the system's administrator may give a file away
                    os.fchown(handle, before.st_uid, before.st_gid)
                os.fchmod(handle, stat.S_IMODE(before.st_mode))  # what nobody else could read stays so
            yield part
            _fsync(handle)
        finally:
            os.close(handle)
        os.replace(part, target)
    except BaseException:
        with suppress(OSError):
            os.remove(part)
        raise
    synced(folder)


def synced(folder: str | os.PathLike[str]) -> None:
    """Bring the names in a folder, or the content of a file, to the disk; Windows has no such thing for folders."""
    if os.name == "nt":
        return
    handle = os.open(folder, os.O_RDONLY)
    try:
        _fsync(handle)
    finally:
        os.close(handle)


def _fsync(handle: int) -> None:
    try:
        os.fsync(handle)
    except OSError as error:
        if error.errno not in _NO_SYNC:
            raise


def _regular(target: str, follow: bool) -> os.stat_result | None:
    """What is there now; None when nothing is, or a link that is not followed."""
    try:
        found = os.stat(target, follow_symlinks=follow)
    except FileNotFoundError:
        return None
    if stat.S_ISLNK(found.st_mode):
        return None
    if not stat.S_ISREG(found.st_mode):
        raise OSError(errno.EINVAL, "not a regular file")
    return found
