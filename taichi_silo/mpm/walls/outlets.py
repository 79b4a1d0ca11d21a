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


class OwnTime:
    """A wall that may move with a gate of its own: `gate` is its number among `gates`."""

    gates: Gates | None

    @property
    def own_time(self) -> bool:
        """Whether it moves at a time of its own."""
        return self.gates is not None


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

    @property
    def axis(self) -> int:
        """Along which its normal points."""
        return 1

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
class Edges(OwnTime, FloorRow):
    """The nodes at the edges of the opening.

    Parameters
    ----------
    gate, gates : its number among gates that move each at its own time; None: it goes with the plate velocity.

    """

    name: str = "edges"
    motion: tuple[float, float] = (0.0, 0.5)
    gate: int = 0
    gates: Gates | None = None

    @ti.func
    def holds(self, i, j):
        """Whether node (i, j) is one of them."""
        return j == self.row and (i == self.first or i == self.last)


@frozen
class Gate(OwnTime, FloorRow):
    """What the sand in the opening stands on: it sinks with the plate velocity, and the sand with it.

    A gate that recedes faster than sand can follow is an open one. `gate` and `gates` are as of `Edges`.
    """

    name: str = "gate"
    motion: tuple[float, float] = (0.0, 1.0)
    gate: int = 0
    gates: Gates | None = None

    @ti.func
    def holds(self, i, j):
        """Whether node (i, j) lies in the opening."""
        return (j == self.row and i > self.first and i < self.last) or (
            j < self.row and i >= self.first and i <= self.last
        )
