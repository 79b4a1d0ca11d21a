"""A flat floor or a side wall with openings, and the gates that close them.

They hold the nodes on the wall's line and beyond it. Of what the node at an edge stands for, half lies on the wall and
half in the opening: it moves half as fast as the gate, so that what passes is the opening's width times the way of the
gate, and above an open gate it is free. In a round silo less of it lies in the opening (`pace_of_edge`). The nodes
beyond it belong to the gate, so that what has passed touches the wall no more.
"""

from collections.abc import Sequence

import numpy as np

from taichi_silo.mpm.field_memory import put
from taichi_silo.mpm.frozen import frozen
from taichi_silo.mpm.language import ti
from taichi_silo.mpm.runtime import real
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


@ti.data_oriented
class Gates:
    """How fast each of several gates moves, as a share of what its `motion` makes of the plate velocity.

    Parameters
    ----------
    count : of the gates; at first they all move as told.

    """

    def __init__(self, count: int):
        self.share = ti.field(real, shape=count)
        put(self.share, 1.0)

    def move(self, shares: Sequence[float]) -> None:
        """From now on they move with these shares."""
        put(self.share, np.array(shares, float))

    @ti.func
    def of(self, gate: ti.template()):
        """The share of a gate."""
        return self.share[gate]


@frozen
class AtOpening:
    """What lies beyond a line of nodes with an opening in it, that of a floor unless told otherwise.

    Parameters
    ----------
    row : of the nodes on its line; of a side wall their column.
    first, last : columns, or rows, of the nodes at the edges of the opening.
    contact : how it acts.
    axis : 1 for a floor, 0 for a wall at constant x.
    side : -1 if the sand lies at greater coordinates, +1 if at smaller ones.

    """

    row: int
    first: int
    last: int
    contact: Coulomb | NoSlip
    axis: int = 1
    side: int = -1

    @ti.func
    def slot(self, i, j):
        """The column, or the row."""
        return ti.select(self.axis == 0, j, i)

    @ti.func
    def beyond(self, i, j):
        """How many nodes node (i, j) lies beyond the line."""
        return (ti.select(self.axis == 0, i, j) - self.row) * self.side

    @ti.func
    def normal(self, i, j):
        """Unit normal out of the sand."""
        across = 1.0 if self.axis == 0 else 0.0
        return across * self.side, (1.0 - across) * self.side


@frozen
class OpenFloor(AtOpening):
    """The floor beside the opening; it stands still.

    Parameters
    ----------
    others : first and last column of further openings.

    """

    name: str = "floor"
    motion: tuple[float, float] = (0.0, 0.0)
    others: tuple[tuple[int, int], ...] = ()

    @ti.func
    def holds(self, i, j):
        """Whether node (i, j) lies on the floor, or inside it."""
        held = j <= self.row and (i < self.first or i > self.last)
        for first, last in ti.static(self.others):
            held = held and (i < first or i > last)
        return held


@frozen
class Edges(AtOpening):
    """The nodes at the edges of the opening.

    Parameters
    ----------
    gate, gates : its number among gates that move each at its own time; None: it goes with the plate velocity.

    """

    name: str = "edges"
    motion: tuple[float, float] = (0.0, 0.5)
    gate: int = 0
    gates: Gates | None = None

    @property
    def own_time(self) -> bool:
        """Whether it moves at a time of its own."""
        return self.gates is not None

    @ti.func
    def holds(self, i, j):
        """Whether node (i, j) is one of them."""
        along = self.slot(i, j)
        return self.beyond(i, j) == 0 and (along == self.first or along == self.last)


@frozen
class Gate(AtOpening):
    """What the sand in the opening stands on: it sinks with the plate velocity, and the sand with it.

    A gate that recedes faster than sand can follow is an open one. `gate` and `gates` are as of `Edges`.
    One that `carries` takes along what has passed it: from a side wall it would fall.
    """

    name: str = "gate"
    motion: tuple[float, float] = (0.0, 1.0)
    gate: int = 0
    gates: Gates | None = None
    carries: bool = False

    @property
    def own_time(self) -> bool:
        """Whether it moves at a time of its own."""
        return self.gates is not None

    @ti.func
    def holds(self, i, j):
        """Whether node (i, j) lies in the opening."""
        along, beyond = self.slot(i, j), self.beyond(i, j)
        return (beyond == 0 and along > self.first and along < self.last) or (
            beyond > 0 and along >= self.first and along <= self.last
        )
