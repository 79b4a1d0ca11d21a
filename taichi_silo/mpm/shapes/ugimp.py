"""Generalised interpolation (Bardenhagen and Kober 2004) with domains of fixed size: uGIMP."""

from taichi_silo.mpm.frozen import frozen
from taichi_silo.mpm.language import ti
from taichi_silo.mpm.shapes import stable_step


@frozen
class UniformGimp:
    """Hat functions averaged over a point's domain, which keeps its initial size.

    With the domain from a to b = a + 2 l (measured from the first touched node, in cells, l <= 1/2) the averages are
    integrals of straight lines, so that weights and gradients need no case distinction.
    """

    half_size: float = 0.5  # l of the point's domain, in cells

    PATCHES, NODES, DOMAIN = 1, 3, False

    def __post_init__(self) -> None:
        if not 0.0 < self.half_size <= 0.5:
            raise ValueError(f"half size of a domain is {self.half_size} cells; it must be above 0 and at most 0.5")

    @property
    def stable_fraction(self) -> float:
        """0.577 for l = 1/2, 0.463 for l = 1/4."""
        start, end = stable_step.PLACES, stable_step.PLACES + 2.0 * self.half_size
        inside = [  # integrals of the hats of nodes 0, 1 and 2 over the domain
            ((1 - start) ** 2 - (1 - end).clip(0.0) ** 2) / 2.0,
            0.0 * start,
            (end - 1.0).clip(0.0) ** 2 / 2.0,
        ]
        inside[1] = 2.0 * self.half_size - inside[0] - inside[2]
        slopes = stable_step.hats(end)[1:] - stable_step.hats(start)[1:]
        return stable_step.fraction([s / (2.0 * self.half_size) for s in inside], slopes / (2.0 * self.half_size))

    @ti.func
    def axis(self, x):
        """First node, three weights, three derivatives."""
        start = x - self.half_size
        base = ti.floor(start)
        a = start - base
        if ti.static(self.half_size == 0.5):  # the domain always ends in the second cell
            low = 1.0 - a
            s0, s2 = 0.5 * low * low, 0.5 * a * a
            return base, (s0, 1.0 - s0 - s2, s2), (0.0 - low, low - a, a)
        b = a + 2.0 * self.half_size
        end = ti.min(b, 1.0)
        over = ti.max(b - 1.0, 0.0)
        s0 = ((1.0 - a) ** 2 - (1.0 - end) ** 2) * (0.25 / self.half_size)
        s2 = over * over * (0.25 / self.half_size)
        g0 = (a - end) * (0.5 / self.half_size)
        g2 = over * (0.5 / self.half_size)
        return base, (s0, 1.0 - s0 - s2, s2), (g0, 0.0 - g0 - g2, g2)

    @ti.func
    def patch(self, number: ti.template(), x, y, domain):
        """Three nodes an axis."""
        i, sx, gx = self.axis(x)
        j, sy, gy = self.axis(y)
        return i, sx, gx, j, sy, gy
