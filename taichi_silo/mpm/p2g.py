"""Particles to grid: mass, momentum and internal force that a point gives to its nodes.

With S_ip the weight of node i at point p (paper, section 3.1)

    m_i = sum_p S_ip m_p,   (m v)_i = sum_p S_ip m_p v_p,   f_i = -sum_p V_p sigma_p . grad S_ip

Between a point and a node stand eight slots, each a sum of a value times a weight:

    weight           S     S             S           dS/dx     dS/dy
    point to node    mass  momentum (2)  hoop force  force (2) force (2)
    node to point    velocity (2), its change (2)    d/dx (2)  d/dy (2)

Formulas only: who loops over the points, and in which order they are added, is the executor's business. `t` is the
number of the thread, which says which copy of the sums and of the grid's height it uses.
"""

from taichi_silo.mpm.language import ti
from taichi_silo.mpm.point_weights import offset_of_node
from taichi_silo.mpm.simd.lane_maths import alike
from taichi_silo.mpm.tensors import shifted


@ti.func
def point_contributions(points: ti.template(), grid: ti.template(), surroundings: ti.template(), p, t):
    """The eight slots that point p gives: kg/m, kg m/s /m, then forces [N/m] before the weights."""
    m, volume = points.read("mass", p), points.read("volume", p)
    vx, vy = points.read("velocity", p)
    xx, yy, zz, xy = shifted(points.read("stress", p), surroundings.ambient_pressure)
    hoop = alike(0.0, volume)
    if ti.static(surroundings.geometry.HOOP):
        x, _y = points.read("position", p)
        hoop = 0.0 - volume * zz / x
    bx, by = volume * (-1.0 / grid.cell_size), volume * (-1.0 / grid.cell_height(t))
    return m, m * vx, m * vy, hoop, bx * xx, bx * xy, by * xy, by * yy


@ti.func
def scatter(
    fields: ti.template(), transfer: ti.template(), surroundings: ti.template(), p, t, motion: ti.template(),
    force: ti.template(),
):  # fmt: skip
    """Add mass and momentum (`motion`) and internal force (`force`) of point p to the sums of its nodes."""
    m, mvx, mvy, hoop, xx, xy, yx, yy = point_contributions(fields, fields.grid, surroundings, p, t)
    for patch in ti.static(fields.patches()):
        i, sx, gx, j, sy, gy = fields.touched(p, t, patch)
        for b in ti.static(range(len(sy))):
            for a in ti.static(range(len(sx))):
                column, row = ti.cast(i, ti.i32) + a, ti.cast(j, ti.i32) + b
                k = t * fields.grid.nodes + fields.grid.node(column, row)
                s, dx, dy = sx[a] * sy[b], gx[a] * sy[b], sx[a] * gy[b]
                if ti.static(motion):
                    given = ti.Vector([mvx, mvy])
                    if ti.static(transfer.GRADIENT != "none"):
                        L, r = (
                            fields.particles.affine[p],
                            offset_of_node(fields.particles, fields.grid, p, t, column, row),
                        )
                        given += m * ti.Vector([L[0] * r[0] + L[1] * r[1], L[2] * r[0] + L[3] * r[1]])
                    fields.add(fields.grid.mass, k, s * m)
                    fields.add(fields.grid.momentum, k, s * given)
                if ti.static(force):
                    fields.add(fields.grid.force, k, ti.Vector([s * hoop + dx * xx + dy * yx, dx * xy + dy * yy]))


@ti.func
def second_scatter(fields: ti.template(), p, t, velocity):
    """Add the momentum of point p at another velocity (x, y) [m/s] to the sums of its nodes once more."""
    for patch in ti.static(fields.patches()):
        i, sx, _gx, j, sy, _gy = fields.touched(p, t, patch)
        for b in ti.static(range(len(sy))):
            for a in ti.static(range(len(sx))):
                k = t * fields.grid.nodes + fields.grid.node(ti.cast(i, ti.i32) + a, ti.cast(j, ti.i32) + b)
                fields.add(fields.grid.momentum, k, fields.particles.mass[p] * sx[a] * sy[b] * velocity)
