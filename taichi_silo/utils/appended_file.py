"""A file that grows by whole pieces, and can be cut back to what it held at some time before."""

import contextlib
import errno
import os
from pathlib import Path

from taichi_silo.errors import BadInput
from taichi_silo.utils.machine_faults import of_file


class AppendedFile:
    """An open file; a piece is in it as soon as `append` returns, and is not in it at all if that fails.

    With a size it goes on after so many bytes and cuts off the rest, or raises BadInput if there are fewer; without it
    begins anew.
    """

    def __init__(self, file: Path, size: int | None = None):
        self.file, self.size = file, size or 0
        if size is not None:
            there = file.stat().st_size if file.exists() else 0
            if there < size:
                raise BadInput(f"{file} has {there} bytes; the run cannot go on without a gap, it had written {size}")
            os.truncate(file, size)
        self._stream = open(file, "wb" if size is None else "ab", buffering=0)  # noqa: SIM115 - see close()

    def append(self, piece: bytes) -> None:
        """Write one piece at the end; OSError that names the file if there is no room for it."""
        rest = memoryview(piece)
        try:
            while rest:
                rest = rest[self._stream.write(rest) :]
        except OSError as error:
            with contextlib.suppress(OSError):
                os.ftruncate(self._stream.fileno(), self.size)
            raise of_file(error, self.file) from error
        self.size += len(piece)

    def sync(self) -> int:
        """Bring all pieces to the disk; returns their bytes. OSError if that fails, or if the file was removed."""
        try:
            os.fsync(self._stream.fileno())
            if not os.fstat(self._stream.fileno()).st_nlink:
                raise OSError(errno.ENOENT, "it has been removed")
        except OSError as error:
            raise of_file(error, self.file) from error
        return self.size

    def close(self) -> None:
        """Close the file."""
        self._stream.close()
