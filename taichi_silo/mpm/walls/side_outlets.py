"""An opening in a side wall, and the gate that closes it (see `outlets`); the wall holds all rows but those of it."""

from taichi_silo.mpm.frozen import frozen
from taichi_silo.mpm.language import ti
from taichi_silo.mpm.walls.contact import Coulomb, NoSlip
from taichi_silo.mpm.walls.outlets import Gates, OwnTime


@frozen
class SideColumn(OwnTime):
    """What lies beyond a column of nodes.

    Parameters
    ----------
    column : of the nodes on its line.
    side : -1 of a left wall, +1 of a right one.
    first, last : rows of the nodes at the edges of the opening.
    contact : how it acts.
    name, motion : as of all walls.
    gate, gates : its number among gates that move each at its own time.
    carries : whether it takes along what has passed it, which would fall.

    """

    column: int
    side: int
    first: int
    last: int
    contact: Coulomb | NoSlip
    name: str
    motion: tuple[float, float]
    gate: int
    gates: Gates
    carries: bool = False

    @property
    def axis(self) -> int:
        """Along which its normal points."""
        return 0

    @ti.func
    def slot(self, i, j):
        """The row."""
        return j

    @ti.func
    def beyond(self, i, j):
        """How many nodes node (i, j) lies beyond the line."""
        return (i - self.column) * self.side

    @ti.func
    def normal(self, i, j):
        """Out of the silo."""
        return 1.0 * self.side, 0.0


@frozen
class SideEdges(SideColumn):
    """The nodes at the edges of the opening."""

    @ti.func
    def holds(self, i, j):
        """Whether node (i, j) is one of them."""
        return i == self.column and (j == self.first or j == self.last)


@frozen
class SideGate(SideColumn):
    """What the sand in the opening leans on."""

    @ti.func
    def holds(self, i, j):
        """Whether node (i, j) lies in the opening."""
        beyond = self.beyond(i, j)
        return (beyond == 0 and j > self.first and j < self.last) or (beyond > 0 and j >= self.first and j <= self.last)
