"""The order of the points by cells, and the strips of groups that threads share.

The points are cut into strips, whose number depends on the points, not on the threads: the order of every sum, and
with it every bit of the result, is the same for any number of threads.
"""

import math

import numpy as np

from taichi_silo.mpm.field_memory import present, put, values
from taichi_silo.mpm.language import ti
from taichi_silo.mpm.simd.store import HALVES, STRIPS, Layout
from taichi_silo.mpm.simd.vectors import LANES
from taichi_silo.mpm.walls.outlets import OPENED

SORTED_FOR = 0.25  # of a cell: as far as points may move before they are sorted anew
WIDEST = 3  # patch of a point, of its shape or of a filter [nodes]
FAR = 1e9  # cells, beyond which no number of a cell is told from another


@ti.data_oriented
class Strips:
    """Keeps order and strips of a layout.

    Parameters
    ----------
    layout : whose they are.
    reach_m : as far as a point gives something to rows of nodes beside those of its shape [m].

    Attributes
    ----------
    count : strips that the points are cut into.

    """

    def __init__(self, layout: Layout, reach_m: float):
        self.layout, self.particles, self.grid, self.shape = layout, layout.particles, layout.grid, layout.shape
        self.revision, self.moved = -1, 0.0  # of the points, and how far they may have moved, since they were sorted
        self.count = 2
        # rows of cells between points of strips with the same sums: no common node, and a row that either may move
        reach = math.ceil(reach_m / min(self.grid.cell_size, self.grid.first_cell_height))
        self.apart = max(WIDEST + (4 if self.shape.DOMAIN else 0), reach) + 2
        self.gap = max(0, 2 * (WIDEST - self.shape.NODES), reach - self.shape.NODES)  # rows of nodes that must stay

    def outdate(self) -> None:
        """Have the points sorted before the next steps."""
        self.revision = -1

    def wear(self, count: int, dt: float, schedule: tuple[float, ...]) -> bool:
        """Whether the order is still good for so many steps (`Solver.advance`), which it counts as done."""
        carried = max(abs(v) for v in schedule[2:4]) if min(schedule[2:4]) > OPENED else 0.0
        # if something moves by itself faster than that, the order is not the best
        self.moved += count * (2.0 * dt * carried / self.grid.cell_size + 1e-4)
        return self.revision == self.particles.revision and self.moved < SORTED_FOR

    def sort(self) -> None:
        """Put the points in the order of their cells."""
        column, row = self._cells()
        order = np.lexsort((column, row)).astype(np.int32)
        del column
        rows = row[order]
        spare = self.layout.groups * LANES - len(order)
        put(self.layout.order, np.pad(order, (0, spare), constant_values=self.particles.count))
        self.revision, self.moved = self.particles.revision, 0.0
        self._cut(next(count for count in (16, 8, 4, 2) if count == 2 or self._stand_apart(rows, count)))

    def state(self) -> dict:
        """The order, and when it was found, for a checkpoint."""
        return {"sorted": [self.revision, self.moved], "order": present(self.layout.order), "strips": self.count}

    def restore(self, state: dict | None) -> None:
        """Go on from a state; without one the points are sorted before the next step.

        Raises
        ------
        ValueError
            if the order names points that are not there.

        """
        self.outdate()
        if state:
            if not ((state["order"] >= 0) & (state["order"] <= self.particles.count)).all():
                raise ValueError("the order names points that are not there")
            put(self.layout.order, state["order"])
            if "strips" in state:  # otherwise it is of a version that cut the points elsewhere
                self.revision, self.moved = state["sorted"]
                self._cut(int(state["strips"]))

    @ti.func
    def crowded(self):
        """Whether strips with the same sums have come closer than a row of nodes and the gap."""
        found = False
        for one in range(STRIPS):
            low, high = self.layout.reach[one, 0], self.layout.reach[one, 1]
            for other in range(one + 1, STRIPS):
                first, last = self.layout.reach[other, 0], self.layout.reach[other, 1]
                both = self.layout.half[one] == self.layout.half[other] and low < high and first < last
                found = found or (both and first <= high + self.gap)
        return found

    def _cells(self) -> tuple[np.ndarray, np.ndarray]:
        """Column and row of the cell of each point; all the same where a place is no number."""
        place, found = self.particles.present("position"), []
        if not np.isfinite(place).all():
            return np.zeros(len(place), np.int32), np.zeros(len(place), np.int32)
        heights = self.grid.cell_size, self.grid.first_cell_height * float(values(self.grid.stretch)[0])
        offset = self.shape.half_size if self.shape.NODES == 3 else 0.0
        for axis, size in enumerate(heights):
            # a lattice may lie on the edge of cells: round-off must not tear its rows apart
            cell = place[:, axis] * (1.0 / size)
            cell -= offset
            cell += 1e-9
            found.append(np.floor(cell, out=cell).clip(-FAR, FAR).astype(np.int32))
        return found[0], found[1]

    def _bounds(self, count: int) -> np.ndarray:
        """First group of each of so many strips, and the end of the last."""
        groups = (self.particles.number + LANES - 1) // LANES
        return np.arange(count + 1) * groups // count

    def _stand_apart(self, rows: np.ndarray, count: int) -> bool:
        """Whether strips with one between them are far enough apart, the points being in these rows of cells."""
        ends = self._bounds(count) * LANES
        if (np.diff(ends) == 0).any():
            return False
        first, last = rows[ends[:-1]], rows[np.minimum(ends[1:], len(rows)) - 1]
        return bool((first[2:] - last[:-2] >= self.apart).all())

    def _cut(self, count: int) -> None:
        """Cut the points into so many strips, a power of 2; the others are empty."""
        self.count = count
        bounds, every = self._bounds(count), STRIPS // count
        slots = np.arange(STRIPS + 1)
        put(self.layout.first, bounds[-(-slots // every)])
        put(self.layout.half, slots[:-1] // every % HALVES)
