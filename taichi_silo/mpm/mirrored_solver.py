"""The step of half a symmetric body: points of one half, nodes that know of the other.

A point next to the axis reaches nodes beyond it. What it gives them, its mirror image gives to the nodes before it, so
the sums beyond the axis are folded back, turned round, before the nodes move; afterwards the nodes beyond move as their
images do. The half is then that of the whole to round-off.
"""

from taichi_silo.mpm.executors import NODES, ROWS, Phase
from taichi_silo.mpm.grid import MARGIN
from taichi_silo.mpm.language import ti
from taichi_silo.mpm.solver import Solver


@ti.data_oriented
class MirroredSolver(Solver):
    """A solver of the left half; the axis is the grid's last column before its margin."""

    MIRRORED = True

    def phases(self) -> list[Phase]:
        """The phases of a step, each over nodes between folding and unfolding of the same row."""
        found: list[Phase] = []
        for phase in super().phases():
            if phase.over == NODES:
                found += [Phase(ROWS, self._fold), phase._replace(waits=False), Phase(ROWS, self._unfold, waits=False)]
            else:
                found.append(phase)
        return found

    @ti.func
    def _fold(self, nodes: ti.template(), j, step, option: ti.template()):
        """Sums of row j beyond the axis to their images; nothing crosses the axis itself."""
        axis = self.grid.node(self.grid.columns - 1 - MARGIN, j)
        nodes.clear_axis(axis, j)
        for n in ti.static(range(1, MARGIN + 1)):
            nodes.fold(axis - n, axis + n, j)

    @ti.func
    def _unfold(self, nodes: ti.template(), j, step, option: ti.template()):
        """Velocities of row j beyond the axis from their images."""
        axis = self.grid.node(self.grid.columns - 1 - MARGIN, j)
        for n in ti.static(range(1, MARGIN + 1)):
            nodes.unfold(axis - n, axis + n)
