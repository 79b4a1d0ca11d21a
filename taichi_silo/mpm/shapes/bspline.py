"""Quadratic B-splines: smooth gradients without domains."""

from taichi_silo.mpm.frozen import frozen
from taichi_silo.mpm.language import ti
from taichi_silo.mpm.shapes.ugimp import UniformGimp


@frozen
class QuadraticSpline:
    """Three nodes an axis: 3/4 - d^2 at a distance d < 1/2 from a node, (3/2 - |d|)^2 / 2 beyond.

    They do not depend on the points, and are those of uGIMP with one point a cell: a hat averaged over a whole cell is
    this spline. It goes on beyond walls, where the nodes have the velocity of the wall.
    """

    half_size: float = 0.5  # of the lattice of points; the spline does not depend on it

    PATCHES, NODES, DOMAIN = 1, 3, False

    @property
    def stable_fraction(self) -> float:
        """0.577."""
        return UniformGimp(0.5).stable_fraction

    @ti.func
    def axis(self, x):
        """First node, three weights, three derivatives."""
        base = ti.floor(x - 0.5)
        d = x - base - 1.0  # from the middle node, -1/2 to 1/2
        low, high = 0.5 - d, 0.5 + d
        return base, (0.5 * low * low, 0.75 - d * d, 0.5 * high * high), (0.0 - low, 0.0 - 2.0 * d, high)

    @ti.func
    def patch(self, number: ti.template(), x, y, domain):
        """Three nodes an axis."""
        i, sx, gx = self.axis(x)
        j, sy, gy = self.axis(y)
        return i, sx, gx, j, sy, gy
