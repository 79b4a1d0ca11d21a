"""The step of half a symmetric body: points of one half, nodes that know of the other.

A point next to the axis reaches nodes beyond it. What it gives them, its mirror image gives to the nodes before it, so
the sums beyond the axis are folded back, turned round, before the nodes move; afterwards the nodes beyond move as their
images do. The half is then that of the whole to round-off.
"""

import taichi as ti

from taichi_silo.mpm.grid import MARGIN
from taichi_silo.mpm.loops import NODES
from taichi_silo.mpm.solver import Solver


@ti.func
def turned(vector):
    """A vector in a mirror at constant x."""
    return ti.Vector([-vector[0], vector[1]])


@ti.func
def fold(sums: ti.template(), here, n: ti.template()):
    """The vector n nodes beyond the axis to its image."""
    sums[here - n] = sums[here - n] + turned(sums[here + n])
    sums[here + n] = ti.Vector([0.0, 0.0])


@ti.func
def fold_row(grid: ti.template(), j):
    """Sums of row j beyond the axis to their images; nothing crosses the axis itself."""
    for copy in ti.static(range(grid.copies)):
        here = copy * grid.nodes + grid.node(grid.columns - 1 - MARGIN, j)
        grid.momentum[here][0] = 0.0
        grid.force[here][0] = 0.0
        for n in ti.static(range(1, MARGIN + 1)):
            grid.mass[here - n] = grid.mass[here - n] + grid.mass[here + n]
            grid.mass[here + n] = 0.0
            fold(grid.momentum, here, n)
            fold(grid.force, here, n)


@ti.func
def unfold_row(grid: ti.template(), j):
    """Velocities of row j beyond the axis from their images."""
    here = grid.node(grid.columns - 1 - MARGIN, j)
    for n in ti.static(range(1, MARGIN + 1)):
        grid.velocity[here + n] = turned(grid.velocity[here - n])
        grid.change[here + n] = turned(grid.change[here - n])
        grid.second_velocity[here + n] = turned(grid.second_velocity[here - n])


@ti.data_oriented
class MirroredSolver(Solver):
    """A solver of the left half; the axis is the grid's last column before its margin."""

    MIRRORED = True

    def program(self, stress_update: str) -> list[tuple]:
        """The phases of a step, each over nodes between folding and unfolding."""
        phases = []
        for over, do, option in super().program(stress_update):
            phase = (over, do, option)
            phases += [(NODES, self._fold, None), phase, (NODES, self._unfold, None)] if over == NODES else [phase]
        return phases

    @ti.func
    def _fold(self, i, j, step, option: ti.template(), shared: ti.template()):
        """Before nodes move."""
        if i == 0:
            fold_row(self.grid, j)

    @ti.func
    def _unfold(self, i, j, step, option: ti.template(), shared: ti.template()):
        """After they have."""
        if i == 0:
            unfold_row(self.grid, j)
