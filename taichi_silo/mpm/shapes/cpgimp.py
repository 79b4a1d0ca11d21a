"""Generalised interpolation whose domains grow and shrink with the sand along the axes: contiguous-particle GIMP."""

from taichi_silo.mpm.frozen import frozen
from taichi_silo.mpm.language import ti
from taichi_silo.mpm.shapes.ugimp import UniformGimp

LEAST, MOST = 0.05, 1.0  # half size of a domain, in cells: four nodes an axis hold a domain of two cells


@frozen
class ContiguousGimp:
    """Hat functions averaged over a rectangle of half sizes l_i = l_i0 F_ii (F: deformation gradient).

    Rectangles know nothing of shear, and a body that turns by a right angle squeezes F_ii to zero: the half sizes are
    kept between 0.05 and 1 cell. Source: S. Bardenhagen, E. Kober, CMES 5 (2004) 477-495.
    """

    half_size: float = 0.5

    PATCHES, NODES, DOMAIN = 1, 4, True

    @property
    def stable_fraction(self) -> float:
        """That of domains of the first size."""
        return UniformGimp(self.half_size).stable_fraction

    @ti.func
    def axis(self, x, half):
        """First node, four weights, four derivatives of a domain from a to b <= a + 2, measured from the first node.

        Integrals of the hats' straight sides. A weight next to zero is a square, never a difference: round-off in it
        would be divided by a nodal mass as small.
        """
        base = ti.floor(x - half)
        a = x - half - base
        b = a + 2.0 * half
        per = 0.5 / half
        first, second, third = ti.min(b, 1.0), ti.min(ti.max(b - 1.0, 0.0), 1.0), ti.max(b - 2.0, 0.0)
        s0, g0 = 0.5 * ((1.0 - a) ** 2 - (1.0 - first) ** 2) * per, (a - first) * per
        s2, g2 = (0.5 * second * second + third * (1.0 - 0.5 * third)) * per, (second - third) * per
        s3, g3 = 0.5 * third * third * per, third * per
        return base, (s0, 1.0 - s0 - s2 - s3, s2, s3), (g0, 0.0 - g0 - g2 - g3, g2, g3)

    @ti.func
    def patch(self, number: ti.template(), x, y, domain):
        """Four nodes an axis, the last one often without weight."""
        i, sx, gx = self.axis(x, ti.min(ti.max(0.5 * domain[0], LEAST), MOST))
        j, sy, gy = self.axis(y, ti.min(ti.max(0.5 * domain[3], LEAST), MOST))
        return i, sx, gx, j, sy, gy

    @ti.func
    def convected(self, domain, change):
        """Both edges r become r + (grad v dt) r."""
        a, b, c, d = domain
        xx, xy, yx, yy = change
        return a + xx * a + xy * b, b + yx * a + yy * b, c + xx * c + xy * d, d + yx * c + yy * d
