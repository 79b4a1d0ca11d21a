"""Linear hat functions: the standard material point method, with its cell-crossing error."""

import numpy as np

from taichi_silo.mpm.frozen import frozen
from taichi_silo.mpm.language import ti
from taichi_silo.mpm.shapes import stable_step


@frozen
class Linear:
    """Two nodes an axis; the gradient jumps where a point crosses a cell edge."""

    half_size: float = 0.5  # a hat function ignores the domain, but the lattice of points sets the stable step

    PATCHES, NODES, DOMAIN = 1, 2, False

    @property
    def stable_fraction(self) -> float:
        """That of points in the middle of their share of a cell: 0.707 for one point, 0.61 for four, 0.53 for nine.

        Next to a cell edge a single point has no bound at all; this is the lattice at its first place.
        """
        places = np.arange(self.half_size, 1.0, 2.0 * self.half_size)
        return stable_step.fraction([1.0 - places, places], [0.0 * places - 1.0, 0.0 * places + 1.0])

    @ti.func
    def axis(self, x):
        """First node, two weights, two derivatives."""
        base = ti.floor(x)
        a = x - base
        one = 0.0 * a + 1.0
        return base, (1.0 - a, a), (0.0 - one, one)

    @ti.func
    def patch(self, number: ti.template(), x, y, domain):
        """The four corners of the cell."""
        i, sx, gx = self.axis(x)
        j, sy, gy = self.axis(y)
        return i, sx, gx, j, sy, gy
