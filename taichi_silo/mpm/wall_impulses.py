"""Impulses on the sand, added up over the steps since they were last read."""

import numpy as np

from taichi_silo.mpm.field_memory import put, values
from taichi_silo.mpm.grid import Grid
from taichi_silo.mpm.language import ti
from taichi_silo.mpm.runtime import real


@ti.data_oriented
class Impulses:
    """What walls and noise control have given the sand [N s/m].

    ==============  ================  ===============================================================
    field           shape             meaning
    ==============  ================  ===============================================================
    reaction        wall, slot, 2     impulse (x, y) that each wall gave, by place along the wall
    control         grid row, 2       impulse (x, y) of the noise control
    ==============  ================  ===============================================================

    Nodes of one slot, or of one row, must not be updated at the same time: `NodalImpulses` is for that.

    Parameters
    ----------
    walls : number of walls.
    grid : the grid, whose rows and columns are the slots.

    """

    def __init__(self, walls: int, grid: Grid):
        self.reaction = ti.field(real, shape=(max(walls, 1), max(grid.columns, grid.rows), 2))
        self.control = ti.field(real, shape=(grid.rows, 2))

    @ti.func
    def add_wall(self, wall, slot, k, impulse):
        """Add an impulse (x, y) that a wall has given to the sand at node k."""
        for c in ti.static(range(2)):
            self.reaction[wall, slot, c] = self.reaction[wall, slot, c] + impulse[c]

    @ti.func
    def add_damping(self, row, k, impulse):
        """Add an impulse (x, y) that the noise control has given to node k of a row."""
        for c in ti.static(range(2)):
            self.control[row, c] = self.control[row, c] + impulse[c]

    def read_and_reset(self) -> tuple[np.ndarray, np.ndarray]:
        """Reaction (walls, slots, 2) and control (rows, 2) since the last call [N s/m]."""
        found = values(self.reaction), values(self.control)
        put(self.reaction, 0.0)
        put(self.control, 0.0)
        return found
