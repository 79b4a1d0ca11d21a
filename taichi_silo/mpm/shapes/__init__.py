"""Shape functions: sums of products of one-dimensional weights.

The contract of a shape, a frozen dataclass:

`half_size`
    half the edge of a point's first domain, in cells: 1/2 for one point a cell, 1/4 for four.
`PATCHES`, `NODES`
    a point touches PATCHES rectangles of NODES x NODES nodes: one, or one for each corner of its domain.
`DOMAIN`
    whether points carry a domain: its edge vectors r1, r2, convected with the sand.
`patch(number, x, y, domain)`
    of a place (x, y) and a domain (r1x, r1y, r2x, r2y) in cells, node k at k: the first touched node, the weights and
    their derivatives along x, then the same along y. Node (a, b) of the patch has the weight sx[a] sy[b] and the
    gradient (gx[a] sy[b], sx[a] gy[b]). Scalars and lanes alike, no branches.
`convected(domain, change)`
    the domain [in cells] after a step of velocity gradient times dt (xx, xy, yx, yy), pulled back to what the shape
    can carry. Only where DOMAIN.
`stable_fraction`
    largest stable time step over h / c on a regular lattice of points in the plane, wherever the lattice lies: see
    `bound.py`.

A new shape is one file with these members and one name below.
"""

from typing import Any

from taichi_silo.mpm.shapes.bspline import QuadraticSpline
from taichi_silo.mpm.shapes.cpdi import ConvectedDomain
from taichi_silo.mpm.shapes.cpgimp import ContiguousGimp
from taichi_silo.mpm.shapes.linear import Linear
from taichi_silo.mpm.shapes.ugimp import UniformGimp

SHAPES: dict[str, type[Any]] = {
    "linear": Linear,
    "ugimp": UniformGimp,
    "cpgimp": ContiguousGimp,
    "cpdi": ConvectedDomain,
    "bspline": QuadraticSpline,
}

__all__ = ["SHAPES", "ContiguousGimp", "ConvectedDomain", "Linear", "QuadraticSpline", "UniformGimp"]
