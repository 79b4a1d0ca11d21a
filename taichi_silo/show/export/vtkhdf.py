"""All states of a run in one VTKHDF file, a series over time that ParaView opens at once.

The file is an unstructured grid of vertices, VTKHDF 2.0: the states stand one after the other in each array, and the
group `Steps` says where each begins. Arrays are those of the snapshots, compressed.
"""

import io
from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np

from taichi_silo.runs.result import Result
from taichi_silo.show.export import states
from taichi_silo.utils import atomic_write, vtu

VERSION = (2, 0)
CHUNK_BYTES = 1 << 18
PACKED = {"compression": "gzip", "compression_opts": 4, "shuffle": True}


def write(run: Result, target: Path, seen: Callable[[], None] = lambda: None) -> int:
    """Write all states of a run into a file, which is there when it is complete, or not at all.

    `seen` hears of each state that is written; returns their number.
    """
    with atomic_write.written(target) as passing, Sink(passing, "w+b") as sink:
        with h5py.File(sink, "w") as file:
            root = file.create_group("VTKHDF")
            root.attrs["Version"] = VERSION
            root.attrs.create("Type", b"UnstructuredGrid", dtype=h5py.string_dtype("ascii", 16))
            counts, times, series = [], [], Series(root)
            for row, position, arrays in states(run):
                series.append(position, arrays)
                sink.check()
                counts.append(len(position))
                times.append(row["time_s"])
                seen()
            _steps(root, np.array(counts), np.array(times), list(arrays))
        sink.check()
    return len(times)


class Sink(io.FileIO):
    """A file whose write errors are kept until `check`: HDF5 cannot bear them, and would crash later."""

    trouble: OSError | None = None

    def write(self, data) -> int:
        """Write all of the data; nothing after a first error."""
        rest = memoryview(data).cast("B")
        size = rest.nbytes
        try:
            while rest and self.trouble is None:
                rest = rest[super().write(rest) :]
        except OSError as error:
            self.trouble = error
        return size

    def readinto(self, buffer) -> int:
        """Read what the file holds; zeros beyond its end."""
        view = memoryview(buffer).cast("B")
        got = super().readinto(view) or 0
        view[got:] = bytes(len(view) - got)
        return len(view)

    def truncate(self, size: int | None = None) -> int:
        """Cut the file off; an error is kept."""
        try:
            return super().truncate(size)
        except OSError as error:
            self.trouble = self.trouble or error
            return size or 0

    def check(self) -> None:
        """Raise the OSError that has befallen the file, if one has."""
        if self.trouble is not None:
            raise self.trouble


class Series:
    """Arrays of a group that grow; they stay open, so that a chunk is packed once."""

    def __init__(self, root: h5py.Group):
        self.root = root
        self.data: dict[str, h5py.Dataset] = {}

    def append(self, position: np.ndarray, arrays: dict[str, np.ndarray]) -> None:
        """Add one state at the end of all arrays."""
        count = len(position)
        number = np.arange(count + 1, dtype=np.int64)
        self._extend("Points", vtu.spatial(position))
        types = np.full(count, vtu.VERTEX, np.uint8)
        for name, values in (("Connectivity", number[:-1]), ("Offsets", number), ("Types", types)):
            self._extend(name, values)
        for name in ("NumberOfPoints", "NumberOfCells", "NumberOfConnectivityIds"):
            self._extend(name, np.array([count], np.int64))
        for name, values in arrays.items():
            self._extend(f"PointData/{name}", values)

    def _extend(self, name: str, values: np.ndarray) -> None:
        if name not in self.data:
            shape = values.shape[1:]
            rows = CHUNK_BYTES // (values.dtype.itemsize * int(np.prod(shape)))
            self.data[name] = self.root.create_dataset(
                name, (0, *shape), values.dtype, maxshape=(None, *shape), chunks=(rows, *shape), **PACKED
            )
        data = self.data[name]
        old = len(data)
        data.resize(old + len(values), axis=0)
        data[old:] = values


def _steps(root: h5py.Group, counts: np.ndarray, times: np.ndarray, names: list[str]) -> None:
    """Write the group `Steps`: where each state begins in each array."""
    before = np.concatenate([[0], np.cumsum(counts)[:-1]]).astype(np.int64)
    steps = root.create_group("Steps")
    steps.attrs["NSteps"] = len(times)
    steps["Values"] = times
    steps["PartOffsets"] = np.arange(len(times), dtype=np.int64)
    steps["NumberOfParts"] = np.ones(len(times), np.int64)
    steps["PointOffsets"] = before
    steps["CellOffsets"] = before[:, None]
    steps["ConnectivityIdOffsets"] = before[:, None]
    for name in names:
        steps[f"PointDataOffsets/{name}"] = before
