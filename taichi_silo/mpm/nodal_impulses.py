"""Impulses on the sand where each node has a thread of its own: kept by nodes, added up when they are read."""

import numpy as np

from taichi_silo.mpm.contracts import Wall
from taichi_silo.mpm.field_memory import put, values
from taichi_silo.mpm.grid import Grid
from taichi_silo.mpm.language import ti
from taichi_silo.mpm.runtime import real, whole_numbers


@ti.data_oriented
class NodalImpulses:
    """What `wall_impulses.Impulses` holds, without sums that wait for each other, and in a fixed order.

    ==============  ================  ===============================================================
    field           shape             meaning
    ==============  ================  ===============================================================
    given           wall + 1, node    impulse (x, y) of each wall, then of the noise control [N s/m]
    node            held node         the nodes that each wall may hold, by walls and slots
    begin           wall * slot + 1   where those of a slot begin
    report          first + ...       where the sums go: reaction (wall, slot, 2), control (row, 2)
    ==============  ================  ===============================================================

    Parameters
    ----------
    walls : on grid lines.
    surfaces : of walls that do not follow the grid; their slots are the rows.
    grid : the grid.
    first : entries of the report that others fill.

    """

    def __init__(self, walls: tuple[Wall, ...], surfaces: int, grid: Grid, first: int):
        self.walls, self.grid, self.first = walls, grid, first
        self.count, self.slots = max(len(walls) + surfaces, 1), max(grid.columns, grid.rows)
        self.given = ti.Vector.field(2, real, shape=(self.count + 1, grid.nodes))
        self.sums = self.count * self.slots
        self.report = ti.field(real, shape=first + 2 * (self.sums + grid.rows))
        slot = np.tile(np.arange(grid.nodes, dtype=np.int32) // grid.columns, (self.count, 1))
        if walls:
            slot[: len(walls)] = self._slots_of_walls()
        wall, node = np.nonzero(slot >= 0)
        place = wall * self.slots + slot[wall, node]
        order = np.argsort(place, kind="stable")
        self.node, self.begin = whole_numbers((max(len(order), 1),), (self.sums + 1,))
        put(self.node, np.resize(node[order], max(len(order), 1)))
        put(self.begin, np.searchsorted(place[order], np.arange(self.sums + 1)))

    def _slots_of_walls(self) -> np.ndarray:
        """Slot of each node at each wall on grid lines (wall, node); -1 where that does not hold it."""
        slot = np.empty((len(self.walls), self.grid.nodes), np.int32)
        self._find_slots(slot)
        return slot

    @ti.kernel
    def _find_slots(self, slot: ti.types.ndarray()):
        for k in range(self.grid.nodes):
            i, j = k % self.grid.columns, k // self.grid.columns
            for number, wall in ti.static(enumerate(self.walls)):
                slot[number, k] = -1
                if wall.holds(i, j):
                    slot[number, k] = wall.slot(i, j)

    @ti.func
    def add_wall(self, wall, slot, k, impulse):
        """Add an impulse (x, y) that a wall has given to the sand at node k."""
        self.given[wall, k] = self.given[wall, k] + ti.Vector([impulse[0], impulse[1]])

    @ti.func
    def add_damping(self, row, k, impulse):
        """Add an impulse (x, y) that the noise control has given to node k of a row."""
        self.add_wall(self.count, row, k, impulse)

    @ti.kernel
    def take(self):
        """Add up what has been given since the last time, and put it into the report."""
        for place in range(self.sums + self.grid.rows):
            total = ti.Vector([0.0, 0.0])
            if place < self.sums:
                for n in range(self.begin[place], self.begin[place + 1]):
                    k = self.node[n]
                    total += self.given[place // self.slots, k]
                    self.given[place // self.slots, k] = ti.Vector([0.0, 0.0])
            else:
                for i in range(self.grid.columns):
                    k = (place - self.sums) * self.grid.columns + i
                    total += self.given[self.count, k]
                    self.given[self.count, k] = ti.Vector([0.0, 0.0])
            for c in ti.static(range(2)):
                self.report[self.first + 2 * place + c] = total[c]

    def of_report(self, report: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Reaction (walls, slots, 2) and control (rows, 2) [N s/m]."""
        pairs = report[self.first :].reshape(-1, 2)
        return pairs[: self.sums].reshape(self.count, self.slots, 2), pairs[self.sums :]

    def read_and_reset(self) -> tuple[np.ndarray, np.ndarray]:
        """As of `Impulses`."""
        self.take()
        return self.of_report(values(self.report))
