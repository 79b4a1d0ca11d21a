"""Convected particle domain interpolation: parallelograms that deform with the sand (CPDI1)."""

from taichi_silo.mpm.frozen import frozen
from taichi_silo.mpm.language import ti
from taichi_silo.mpm.shapes import stable_step

LONGEST = 2.0  # edge of a domain, in cells: a corner is at most so far from its point, which the grid's margin holds
FLATTEST = 0.5  # sine of the angle between the edges
CORNERS = ((-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0))


@frozen
class ConvectedDomain:
    """The shape functions are interpolated linearly between the corners of the parallelogram with edges r1, r2.

        phi_i = 1/4 sum_c S_i(x_c),    grad phi_i = sum_c S_i(x_c) (s1 r2 - s2 r1)' / (2 |r1 x r2|)

    S: hat functions, s1, s2 = +-1: signs of corner x_c = x + (s1 r1 + s2 r2) / 2, (a, b)' = (b, -a). Written from
    A. Sadeghirad, R. Brannon, J. Burghardt, Int. J. Numer. Meth. Eng. 86 (2011) 1435-1456, with the edges of the
    whole domain. So every corner is a patch of 2 x 2 hats; its vector goes into the derivatives.

    The guard: an edge longer than 2 cells is shortened (a corner must not reach through a wall, or into sand that moves
    otherwise), and a parallelogram that is folded, or whose edges are closer than 30 deg, becomes a square of its area.
    """

    half_size: float = 0.5
    guarded: bool = True

    PATCHES, NODES, DOMAIN = 4, 2, True

    @property
    def stable_fraction(self) -> float:
        """Of a lattice of squares: 0.707 for l = 1/2, 0.612 for l = 1/4."""
        start = stable_step.hats(stable_step.PLACES, 5)
        end = stable_step.hats(stable_step.PLACES + 2.0 * self.half_size, 5)
        return stable_step.fraction(0.5 * (start + end), (end - start) / (2.0 * self.half_size))

    @ti.func
    def patch(self, number: ti.template(), x, y, domain):
        """The four nodes around corner `number`."""
        s1, s2 = ti.static(CORNERS[number][0], CORNERS[number][1])
        a, b, c, d = domain
        turn = 0.5 / (a * d - b * c)
        xc, yc = x + 0.5 * (s1 * a + s2 * c), y + 0.5 * (s1 * b + s2 * d)
        i, j = ti.floor(xc), ti.floor(yc)
        u, v = xc - i, yc - j
        wx, wy = (s1 * d - s2 * b) * turn, (s2 * a - s1 * c) * turn
        sx, sy = (1.0 - u, u), (0.25 * (1.0 - v), 0.25 * v)
        gx = (4.0 * wx * (1.0 - u), 4.0 * wx * u)
        gy = (wy * (1.0 - v), wy * v)
        return i, sx, gx, j, sy, gy

    @ti.func
    def convected(self, domain, change):
        """Both edges r become r + (grad v dt) r, guarded."""
        a, b, c, d = domain
        xx, xy, yx, yy = change
        e, f = a + xx * a + xy * b, b + yx * a + yy * b
        g, h = c + xx * c + xy * d, d + yx * c + yy * d
        if ti.static(self.guarded):
            first, second = ti.sqrt(e * e + f * f) + 1e-30, ti.sqrt(g * g + h * h) + 1e-30
            p, q = ti.min(LONGEST / first, 1.0), ti.min(LONGEST / second, 1.0)
            e, f, g, h = p * e, p * f, q * g, q * h
            area = e * h - f * g
            flat = FLATTEST * p * first * q * second - area > 0.0
            side = ti.sqrt(ti.max(area, 0.01))
            zero = 0.0 * side
            e, f = ti.select(flat, side, e), ti.select(flat, zero, f)
            g, h = ti.select(flat, zero, g), ti.select(flat, side, h)
        return e, f, g, h
