"""Plane walls along grid lines."""

from taichi_silo.mpm.frozen import frozen
from taichi_silo.mpm.grid import MARGIN, Grid
from taichi_silo.mpm.language import ti
from taichi_silo.mpm.walls.bands import Bands
from taichi_silo.mpm.walls.contact import Coulomb, Frictionless, NoSlip, RoughFree


@frozen
class PlaneWall:
    """All nodes on a grid line and beyond it.

    Parameters
    ----------
    name : "left", "right", "bottom", ...
    axis : 0 for a wall at constant x, 1 for one at constant y.
    side : -1 if the sand lies at greater coordinates, +1 if at smaller ones (the sign of the outward normal).
    node : index of the grid line along `axis`.
    contact : how it acts.
    motion : its velocity as a multiple, along x and y, of the plate velocity of the step; (0, 0) stands still.
    lowest : of a wall at constant x, the row of nodes at which it begins (above a hopper).
    fade : of a wall at constant x, number of cells above a bottom that moves, over which its nodes move less and less
        with that (see `followed`).
    bears_from : of a wall of no slip, the row of nodes from which it bears sand; lower ones, which a floor bears, it
        only keeps in.
    openings : first and last row, or column, of the nodes of openings in it, which others hold.
    bands : friction that changes along it (see `bands`); `contact` then says nothing.

    """

    name: str
    axis: int
    side: int
    node: int
    contact: Coulomb | NoSlip | Frictionless | RoughFree
    motion: tuple[float, float] = (0.0, 0.0)
    lowest: int = 0
    fade: float = 0.0
    bears_from: int = 0
    openings: tuple[tuple[int, int], ...] = ()
    bands: Bands | None = None

    @property
    def banded(self) -> bool:
        """Whether its friction changes along it."""
        return self.bands is not None

    def plane(self, grid: Grid) -> tuple[int, int, float]:
        """Axis, side and coordinate [m] (Python scope)."""
        size = grid.cell_size if self.axis == 0 else grid.first_cell_height
        return self.axis, self.side, (self.node - MARGIN) * size

    @ti.func
    def holds(self, i, j):
        """Whether node (i, j) lies on the wall or beyond."""
        place = ti.select(self.axis == 0, i, j)
        beyond = (place - self.node) * self.side
        held = beyond >= 0
        if ti.static(self.lowest > 0):
            held = held and j >= self.lowest
        for first, last in ti.static(self.openings):
            along = self.slot(i, j)
            held = held and (along < first or along > last)
        return held

    @ti.pyfunc
    def followed(self, j):
        """Share of the bottom's velocity that nodes of row j have, beside what `motion` says.

        Where a bottom sinks along a wall to which sand sticks, the velocity would jump within a cell. It falls smoothly
        from that of the bottom to that of the wall instead.
        """
        s = ti.max(0.0, 1.0 - ti.max(0.0, float(j) - MARGIN) / self.fade)
        return s * s * (3.0 - 2.0 * s)

    @ti.func
    def slot(self, i, j):
        """Where along the wall the reaction of node (i, j) is booked."""
        return ti.select(self.axis == 0, j, i)

    @ti.func
    def normal(self, i, j):
        """Unit normal out of the sand."""
        across = 1.0 if self.axis == 0 else 0.0
        return across * self.side, (1.0 - across) * self.side


@frozen
class FixedNode:
    """One node that does not move along x.

    Parameters
    ----------
    column, row : of the node.

    """

    column: int
    row: int
    name: str = "pin"
    contact: Frictionless = Frictionless()
    motion: tuple[float, float] = (0.0, 0.0)

    @ti.func
    def holds(self, i, j):
        """Whether node (i, j) is the one, or below it."""
        return i == self.column and j <= self.row

    @ti.func
    def slot(self, i, j):
        """Where the reaction is booked."""
        return 0 * i

    @ti.func
    def normal(self, i, j):
        """Along x."""
        return 1.0, 0.0
