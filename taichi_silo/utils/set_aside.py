"""Arrays that wait in a file until they are used, and take no memory meanwhile."""

import tempfile
from pathlib import Path
from typing import BinaryIO

import numpy as np


class InFile:
    """An array in a file; `numpy.asarray` reads it."""

    def __init__(self, file: BinaryIO, values: np.ndarray):
        self.file, self.begin, self.dtype, self.shape = file, file.tell(), values.dtype, values.shape
        file.write(np.ascontiguousarray(values).data)

    def __array__(self, dtype: np.dtype | None = None, copy: bool | None = None) -> np.ndarray:
        """All of it, as a new array."""
        values = np.empty(self.shape, self.dtype)
        self.file.seek(self.begin)
        if values.size and self.file.readinto(values.data) < values.nbytes:  # type: ignore[attr-defined]
            raise OSError("a file of arrays has lost its end")
        return values if dtype is None else values.astype(dtype)


class SetAside:
    """Arrays and numbers by name; the arrays are in a file without a name, which ends with them or the process.

    Parameters
    ----------
    folder : on whose disk the file is; where temporary files are if None.
    kept : arrays, also `InFile`, and what else there is.

    Attributes
    ----------
    kept : the same, with each array `InFile`.

    """

    def __init__(self, folder: Path | None, kept: dict):
        file = tempfile.TemporaryFile(dir=folder)  # noqa: SIM115 - it stays open
        self.kept = {
            name: InFile(file, np.asarray(value)) if is_array(value) else value for name, value in kept.items()
        }
        file.flush()  # a full disk is told at once

    def read(self, *names: str) -> dict:
        """All of it, or the arrays of these names and what is no array."""
        return {
            name: np.asarray(value) if is_array(value) else value
            for name, value in self.kept.items()
            if not names or name in names or not is_array(value)
        }


def is_array(value: object) -> bool:
    """Whether it is an array, in memory or in a file."""
    return isinstance(value, np.ndarray | InFile)
