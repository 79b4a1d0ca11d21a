"""Every field of the nodes, and where the nodes are."""

import taichi as ti

from taichi_silo.runtime import real

MARGIN = 2  # nodes beyond the sand on every side: a domain that reaches through a wall still finds its nodes


@ti.data_oriented
class Grid:
    """Square cells over a box [0, width] x [0, height], node (i, j) at ((i - MARGIN) h, (j - MARGIN) h).

    The grid may be laid anew in each step, so its origin follows the bottom plate; no field here outlives a step but
    `memory`.

    ==============  ==========  ========================================================================
    field           shape       meaning
    ==============  ==========  ========================================================================
    mass            copy, node  nodal mass [kg/m], one copy for each thread
    momentum        copy, node  nodal momentum [kg m/s /m]
    force           copy, node  internal force [N/m]
    velocity        node        after the step [m/s]
    change          node        of the velocity in the step [m/s]
    memory          node        exponential mean of the velocity, for the noise control [m/s]
    ==============  ==========  ========================================================================

    Parameters
    ----------
    width_m, height_m : size of the box that sand may fill.
    cell_size_m : h.
    copies : number of copies of the three sums.

    """

    def __init__(self, width_m: float, height_m: float, cell_size_m: float, copies: int = 1):
        self.cell_size = cell_size_m
        self.columns = round(width_m / cell_size_m) + 1 + 2 * MARGIN
        self.rows = round(height_m / cell_size_m) + 1 + 2 * MARGIN
        self.nodes = self.columns * self.rows
        self.copies = copies
        self.mass = ti.field(real)
        self.momentum = ti.Vector.field(2, real)
        self.force = ti.Vector.field(2, real)
        ti.root.dense(ti.i, copies * self.nodes).place(self.mass, self.momentum, self.force)
        self.velocity = ti.Vector.field(2, real)
        self.change = ti.Vector.field(2, real)
        ti.root.dense(ti.i, self.nodes).place(self.velocity, self.change)
        self.memory = ti.Vector.field(2, real, shape=self.nodes)

    def node_along(self, position_m: float) -> int:
        """Index, along its axis, of the node at a coordinate.

        Raises
        ------
        ValueError
            if no node lies there.

        """
        cells = position_m / self.cell_size
        if abs(cells - round(cells)) > 1e-6:
            raise ValueError(f"{position_m} m is not on a grid line of {self.cell_size} m cells")
        return round(cells) + MARGIN
