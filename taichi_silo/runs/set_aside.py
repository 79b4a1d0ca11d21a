"""States of the points that wait in a file until they are used, and take no memory meanwhile."""

import tempfile
from pathlib import Path

import numpy as np


class SetAside:
    """Arrays and numbers by name; the arrays are in a file without a name, which ends with this object or the process.

    Parameters
    ----------
    folder : on whose disk the file is; where temporary files are if None.
    state : what is kept; it comes back bit by bit.

    """

    def __init__(self, folder: Path | None, state: dict):
        self.state = dict(state)  # of an array: its place in the file, type and shape
        self.file = tempfile.TemporaryFile(dir=folder)  # noqa: SIM115 - it stays open
        for name, values in state.items():
            if isinstance(values, np.ndarray):
                self.state[name] = _Array(self.file.tell(), values.dtype, values.shape)
                self.file.write(np.ascontiguousarray(values).data)
        self.file.flush()  # a full disk is told at once

    def read(self, *names: str) -> dict:
        """All of it, or the arrays of these names and what is no array."""
        arrays = {name: one for name, one in self.state.items() if isinstance(one, _Array)}
        wanted = {name: arrays[name] for name in names} if names else arrays
        rest = {name: one for name, one in self.state.items() if name not in arrays}
        return {name: self._read(one) for name, one in wanted.items()} | rest

    def _read(self, one: "_Array") -> np.ndarray:
        values = np.empty(one.shape, one.kind)
        self.file.seek(one.begin)
        if values.size and self.file.readinto(values.data) < values.nbytes:  # type: ignore[attr-defined]
            raise OSError("a file of states has lost its end")
        return values


class _Array:
    """Where an array is in a file, and what it is."""

    def __init__(self, begin: int, kind: np.dtype, shape: tuple[int, ...]):
        self.begin, self.kind, self.shape = begin, kind, shape
