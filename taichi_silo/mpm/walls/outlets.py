"""A flat floor with an opening, and the gate that closes it.

Both hold the nodes on the floor's line and below it. Of what the node at an edge stands for, half lies on the floor and
half in the opening: it sinks half as fast as the gate, so that what passes is the opening's width times the way of the
gate, and above an open gate it is free. In a round silo less of it lies in the opening (`pace_of_edge`). The nodes
below it belong to the gate, so that what has passed touches the floor no more.
"""

from taichi_silo.mpm.frozen import frozen
from taichi_silo.mpm.language import ti
from taichi_silo.mpm.walls.contact import Coulomb, NoSlip

OPENED = -20.0  # speed of a gate that sand cannot follow [m/s]


def pace_of_edge(radius_cells: float | None, points_across: int) -> float:
    """Speed of an edge node over that of the gate, so that what passes is the opening's area times the way of the gate.

    Parameters
    ----------
    radius_cells : R / h of a round opening; None: a slot.
    points_across : points of a cell along x.

    With weights that are straight lines, the inner nodes of a round opening stand for R^2 / 2 - R h / 2 + h^2 / 6 per
    radian, the node at its edge for R h. Rings of finite width add h^2 / (12 k^2), k across a cell.
    """
    if radius_cells is None:
        return 0.5
    return 0.5 - (1.0 / 6.0 + 1.0 / (12.0 * points_across**2)) / radius_cells


@frozen
class FloorRow:
    """What lies below a row of nodes.

    Parameters
    ----------
    row : of the nodes on its line.
    first, last : columns of the nodes at the edges of the opening.
    contact : how it acts.

    """

    row: int
    first: int
    last: int
    contact: Coulomb | NoSlip

    @ti.func
    def slot(self, i, j):
        """The column."""
        return i

    @ti.func
    def normal(self, i, j):
        """Downwards."""
        return 0.0, -1.0


@frozen
class OpenFloor(FloorRow):
    """The floor beside the opening; it stands still."""

    name: str = "floor"
    motion: tuple[float, float] = (0.0, 0.0)

    @ti.func
    def holds(self, i, j):
        """Whether node (i, j) lies on the floor, or inside it."""
        return j <= self.row and (i < self.first or i > self.last)


@frozen
class Edges(FloorRow):
    """The nodes at the edges of the opening."""

    name: str = "edges"
    motion: tuple[float, float] = (0.0, 0.5)

    @ti.func
    def holds(self, i, j):
        """Whether node (i, j) is one of them."""
        return j == self.row and (i == self.first or i == self.last)


@frozen
class Gate(FloorRow):
    """What the sand in the opening stands on: it sinks with the plate velocity, and the sand with it.

    A gate that recedes faster than sand can follow is an open one.
    """

    name: str = "gate"
    motion: tuple[float, float] = (0.0, 1.0)

    @ti.func
    def holds(self, i, j):
        """Whether node (i, j) lies in the opening."""
        return (j == self.row and i > self.first and i < self.last) or (
            j < self.row and i >= self.first and i <= self.last
        )
