"""Weights and derivatives between a point and the nodes that it touches.

`points` is whatever can read a field of a point: `Particles`, or a store (see `field_store`).
"""

from taichi_silo.mpm.grid import MARGIN
from taichi_silo.mpm.language import ti
from taichi_silo.mpm.simd.lane_maths import larger, smaller


@ti.func
def domain_of(points: ti.template(), shape: ti.template(), p, per_dx, per_dy):
    """Edges (r1x, r1y, r2x, r2y) of the point's domain in cells; zeros for a shape without domains."""
    if ti.static(shape.DOMAIN):
        ax, ay, bx, by = points.read("domain", p)
        return ax * per_dx, ay * per_dy, bx * per_dx, by * per_dy
    return 0.0 * per_dx, 0.0 * per_dx, 0.0 * per_dx, 0.0 * per_dx


@ti.func
def weights(points: ti.template(), grid: ti.template(), shape: ti.template(), p, t, patch: ti.template()):
    """First column, weights and derivatives along x, first row, the same along y, of one patch of nodes of a point.

    Columns and rows are whole numbers, but of a real type; derivatives are per cell.
    """
    cell_height = grid.cell_height(t)
    per_dx, per_dy = 1.0 / grid.cell_size, 1.0 / cell_height
    x, y = points.read("position", p)
    domain = domain_of(points, shape, p, per_dx, per_dy)
    return weights_at(grid, shape, patch, x * per_dx, y * per_dy, domain)


@ti.func
def weights_at(grid: ti.template(), shape: ti.template(), patch: ti.template(), x, y, domain):
    """The same around a place in cells."""
    i, sx, gx, j, sy, gy = shape.patch(patch, x, y, domain)
    i, j = i + MARGIN, j + MARGIN
    # a point that has left the grid (the guard will stop the run) must not write outside it
    if ti.static(not grid.periodic):
        i = larger(smaller(i, float(grid.columns - shape.NODES)), 0.0)
    j = larger(smaller(j, float(grid.rows - shape.NODES)), 0.0)
    return i, sx, gx, j, sy, gy


@ti.func
def offset_of_node(particles: ti.template(), grid: ti.template(), p, t, i, j):
    """Vector from point p to node (i, j) [m]."""
    node = ti.Vector([(i - MARGIN) * grid.cell_size, (j - MARGIN) * grid.cell_height(t)])
    return node - particles.position[p]
