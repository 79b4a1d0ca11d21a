"""Plane walls along grid lines."""

from dataclasses import dataclass

import taichi as ti

from taichi_silo.walls.coulomb import Coulomb, NoSlip


@dataclass(frozen=True)
class PlaneWall:
    """All nodes on a grid line and beyond it.

    Parameters
    ----------
    name : "left", "right", "bottom", ...
    axis : 0 for a wall at constant x, 1 for one at constant y.
    side : -1 if the sand lies at greater coordinates, +1 if at smaller ones (the sign of the outward normal).
    node : index of the grid line along `axis`.
    contact : how it acts.
    moves : whether it moves with the grid (the bottom plate) or stands still in the laboratory.

    """

    name: str
    axis: int
    side: int
    node: int
    contact: Coulomb | NoSlip
    moves: bool = False

    @ti.func
    def holds(self, i, j):
        """Whether node (i, j) lies on the wall or beyond."""
        place = ti.select(self.axis == 0, i, j)
        return (place - self.node) * self.side >= 0

    @ti.func
    def slot(self, i, j):
        """Where along the wall the reaction of node (i, j) is booked."""
        return ti.select(self.axis == 0, j, i)

    @ti.func
    def normal(self):
        """Unit normal out of the sand."""
        across = 1.0 if self.axis == 0 else 0.0
        return ti.Vector([across * self.side, (1.0 - across) * self.side])
