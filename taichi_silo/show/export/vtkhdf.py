"""All states of a run in VTKHDF files, series over time that ParaView opens at once: the points, and the walls.

Each file is an unstructured grid, VTKHDF 2.0: the states stand one after the other in each array, and the group `Steps`
says where each begins. Points are vertices with the arrays of the snapshots, compressed; stress is a symmetric tensor
in VTK's order. No array holds a NaN: where a value is missing there is 0. Each has its unit in the attribute `units`.
"""

import io
from collections.abc import Callable, Iterator
from pathlib import Path

import h5py
import numpy as np

from taichi_silo.runs.result import Result
from taichi_silo.runs.snapshot import unit_of
from taichi_silo.show.export import states
from taichi_silo.show.export.outline import wall_lines
from taichi_silo.utils import atomic_write, vtu

VERSION = (2, 0)
CHUNK_BYTES = 1 << 18
PACKED = {"compression": "gzip", "compression_opts": 4, "shuffle": True}
SYMMETRIC = (0, 1, 2, 3)  # of xx, yy, zz, xy in VTK's XX, YY, ZZ, XY, YZ, XZ

State = tuple[float, np.ndarray, np.ndarray, dict[str, np.ndarray], dict[str, np.ndarray]]  # see `_file`


def walls_beside(target: Path) -> Path:
    """The file of the walls of a file of points."""
    return target.with_name(f"{target.stem}_walls{target.suffix}")


def write(run: Result, target: Path, seen: Callable[[], None] = lambda: None) -> int:
    """Write all states of a run into a file, and the walls into another; each is there when it is complete, or not.

    `seen` hears of each state that is written; returns their number.
    """

    def points() -> Iterator[State]:
        for row, position, arrays in states(run):
            given = {name: _clean(values) for name, values in arrays.items()}
            yield row["time_s"], position, np.arange(len(position))[:, None], given, {}
            seen()

    def walls() -> Iterator[State]:
        for row in run.snapshots.to_dict("records"):
            corners, lines, number = wall_lines(run.scene, row["displacement_m"])
            yield row["time_s"], corners, lines, {}, {"wall": number}

    count = _file(target, points(), vtu.VERTEX)
    _file(walls_beside(target), walls(), vtu.LINE)
    return count


def _clean(values: np.ndarray) -> np.ndarray:
    """An array as VTK takes it: a stress (n, 4) as a symmetric tensor (n, 6), and 0 where there is no value."""
    if values.ndim == 2 and values.shape[1] == len(SYMMETRIC):
        tensor = np.zeros((len(values), 6), values.dtype)
        tensor[:, SYMMETRIC] = values
        values = tensor
    return np.nan_to_num(values, nan=0.0, posinf=0.0, neginf=0.0) if values.dtype.kind == "f" else values


def _file(target: Path, found: Iterator[State], kind: int) -> int:
    """Write states, each a time [s], places (n, 2) [m], cells (m, corners) of a kind, arrays of points and of cells."""
    with atomic_write.written(target) as passing, Sink(passing, "w+b") as sink:
        with h5py.File(sink, "w") as file:
            root = file.create_group("VTKHDF")
            root.attrs["Version"] = VERSION
            root.attrs.create("Type", b"UnstructuredGrid", dtype=h5py.string_dtype("ascii", 16))
            times, series = [], Series(root, kind)
            for time, position, cells, of_points, of_cells in found:
                series.append(position, cells, of_points, of_cells)
                sink.check()
                times.append(time)
            series.steps(np.array(times))
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

    def __init__(self, root: h5py.Group, kind: int):
        self.root, self.kind = root, kind
        self.data: dict[str, h5py.Dataset] = {}
        self.counts: list[tuple[int, int, int]] = []  # of each state: points, cells, corners of cells

    def append(
        self, position: np.ndarray, cells: np.ndarray, of_points: dict[str, np.ndarray], of_cells: dict[str, np.ndarray]
    ) -> None:
        """Add one state at the end of all arrays."""
        count, corners = cells.shape
        self.counts.append((len(position), count, count * corners))
        self._extend("Points", vtu.spatial(position))
        self._extend("Connectivity", cells.ravel().astype(np.int64))
        self._extend("Offsets", np.arange(count + 1, dtype=np.int64) * corners)
        self._extend("Types", np.full(count, self.kind, np.uint8))
        names = ("NumberOfPoints", "NumberOfCells", "NumberOfConnectivityIds")
        for name, number in zip(names, self.counts[-1], strict=True):
            self._extend(name, np.array([number], np.int64))
        for group, arrays in (("PointData", of_points), ("CellData", of_cells)):
            for name, values in arrays.items():
                self._extend(f"{group}/{name}", values)

    def _extend(self, name: str, values: np.ndarray) -> None:
        if name not in self.data:
            shape = values.shape[1:]
            rows = CHUNK_BYTES // (values.dtype.itemsize * int(np.prod(shape)))
            self.data[name] = self.root.create_dataset(
                name, (0, *shape), values.dtype, maxshape=(None, *shape), chunks=(rows, *shape), **PACKED
            )
            if "/" in name:
                self.data[name].attrs["units"] = unit_of(name.rpartition("/")[2])
        data = self.data[name]
        old = len(data)
        data.resize(old + len(values), axis=0)
        data[old:] = values

    def steps(self, times: np.ndarray) -> None:
        """Write the group `Steps`: where each state begins in each array."""
        counts = np.array(self.counts, np.int64).reshape(-1, 3)
        before = np.concatenate([np.zeros((1, 3), np.int64), np.cumsum(counts, axis=0)])[: len(times)]
        steps = self.root.create_group("Steps")
        steps.attrs["NSteps"] = len(times)
        steps["Values"] = times
        steps["PartOffsets"] = np.arange(len(times), dtype=np.int64)
        steps["NumberOfParts"] = np.ones(len(times), np.int64)
        steps["PointOffsets"] = before[:, 0]
        steps["CellOffsets"] = before[:, 1:2]
        steps["ConnectivityIdOffsets"] = before[:, 2:]
        for name in self.data:
            group, _, array = name.partition("/")
            if array:
                steps[f"{group}Offsets/{array}"] = before[:, 0 if group == "PointData" else 1]
