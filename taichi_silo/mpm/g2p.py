"""Grid to particles: what a point gathers from its nodes, and how it moves, deforms and responds.

    v_p += sum_i S_ip dv_i,   x_p += dt sum_i S_ip v_i,   L_p = sum_i v_i (x) grad S_ip     (paper, section 3.1)

The eight slots are those of `p2g`. A function with an argument `points` works on point p of the fields as on the eight
points of group p of the vector unit (see `field_store`); the others work on fields. `t` is the number of the thread.
"""

from taichi_silo.mpm.language import ti
from taichi_silo.mpm.laws import several
from taichi_silo.mpm.point_weights import domain_of, offset_of_node, weights
from taichi_silo.mpm.simd.lane_maths import alike

TINY = 1e-9  # of a cell squared: points closer to each other than this have an affine velocity field without slope


# --- from the nodes ---------------------------------------------------------------------------------------------------


@ti.func
def gather(particles: ti.template(), grid: ti.template(), shape: ti.template(), field: ti.template(), p, t):
    """The eight slots of point p: velocity, its change, and the gradient [per cell] of a nodal field; sum S field_x."""
    v, dv = ti.Vector([0.0, 0.0]), ti.Vector([0.0, 0.0])
    along_x, along_y = ti.Vector([0.0, 0.0]), ti.Vector([0.0, 0.0])
    across = 0.0 * v[0]
    for patch in ti.static(range(shape.PATCHES)):
        i, sx, gx, j, sy, gy = weights(particles, grid, shape, p, t, patch)
        for b in ti.static(range(shape.NODES)):
            for a in ti.static(range(shape.NODES)):
                k = grid.node(ti.cast(i, ti.i32) + a, ti.cast(j, ti.i32) + b)
                s, node = sx[a] * sy[b], field[k]
                v += s * grid.velocity[k]
                dv += s * grid.change[k]
                along_x += gx[a] * sy[b] * node
                along_y += sx[a] * gy[b] * node
                across += s * node[0]
    return v[0], v[1], dv[0], dv[1], along_x[0], along_x[1], along_y[0], along_y[1], across


@ti.func
def gradient_of(points: ti.template(), grid: ti.template(), geometry: ti.template(), p, t, gathered):
    """Velocity gradient (xx, xy, yx, yy) from what `gather` found, and the strain rate around the axis [1/s]."""
    _vx, _vy, _dvx, _dvy, xx, yx, xy, yy, across = gathered
    per_dx, per_dy = 1.0 / grid.cell_size, 1.0 / grid.cell_height(t)
    hoop = alike(0.0, xx)
    if ti.static(geometry.HOOP):
        x, _y = points.read("position", p)
        hoop = across / x
    return xx * per_dx, xy * per_dy, yx * per_dx, yy * per_dy, hoop


@ti.func
def gradient(
    particles: ti.template(), grid: ti.template(), shape: ti.template(), field: ti.template(), geometry: ti.template(),
    p, t,
):  # fmt: skip
    """Gradient (xx, xy, yx, yy) of a nodal velocity at point p, and the strain rate around the axis [1/s]."""
    return gradient_of(particles, grid, geometry, p, t, gather(particles, grid, shape, field, p, t))


@ti.func
def at_point(particles: ti.template(), grid: ti.template(), shape: ti.template(), field: ti.template(), p, t):
    """The value (x, y) of a nodal field at point p."""
    value = ti.Vector([0.0, 0.0])
    for patch in ti.static(range(shape.PATCHES)):
        i, sx, _gx, j, sy, _gy = weights(particles, grid, shape, p, t, patch)
        for b in ti.static(range(shape.NODES)):
            for a in ti.static(range(shape.NODES)):
                value += sx[a] * sy[b] * field[grid.node(ti.cast(i, ti.i32) + a, ti.cast(j, ti.i32) + b)]
    return value


@ti.func
def affine_of(particles: ti.template(), grid: ti.template(), shape: ti.template(), p, t):
    """B D^-1 of the affine transfer: moments of the nodal velocity over those of the nodes' places [1/s]."""
    B = ti.Matrix([[0.0, 0.0], [0.0, 0.0]])
    D = ti.Matrix([[0.0, 0.0], [0.0, 0.0]])
    for patch in ti.static(range(shape.PATCHES)):
        i, sx, _gx, j, sy, _gy = weights(particles, grid, shape, p, t, patch)
        for b in ti.static(range(shape.NODES)):
            for a in ti.static(range(shape.NODES)):
                column, row = ti.cast(i, ti.i32) + a, ti.cast(j, ti.i32) + b
                r = offset_of_node(particles, grid, p, t, column, row)
                s = sx[a] * sy[b]
                B += s * grid.velocity[grid.node(column, row)].outer_product(r)
                D += s * r.outer_product(r)
    least = TINY * grid.cell_size**2
    D[0, 0], D[1, 1] = D[0, 0] + least, D[1, 1] + least
    C = B @ D.inverse()
    return C[0, 0], C[0, 1], C[1, 0], C[1, 1]


# --- the point itself -------------------------------------------------------------------------------------------------


@ti.func
def move(
    points: ti.template(), grid: ti.template(), transfer: ti.template(), control: ti.template(), p, step, gathered,
    second,
):  # fmt: skip
    """New velocity and position of point p; `second` is the velocity (x, y) that a second transfer brought back."""
    vx, vy, dvx, dvy = gathered[0], gathered[1], gathered[2], gathered[3]
    old_x, old_y = points.read("velocity", p)
    new_x = transfer.carried(old_x, vx, dvx, second[0], step.dt)
    new_y = transfer.carried(old_y, vy, dvy, second[1], step.dt)
    if ti.static(control.relaxation > 0.0):
        new_x = new_x + control.relaxation * step.dt * (vx - new_x)
        new_y = new_y + control.relaxation * step.dt * (vy - new_y)
    points.write("velocity", p, (new_x, new_y))
    x, y = points.read("position", p)
    origin = grid.velocity_of_origin(step)
    points.write("position", p, (x + step.dt * (vx - origin[0]), y + step.dt * (vy - origin[1])))


@ti.func
def deform(points: ti.template(), grid: ti.template(), shape: ti.template(), transfer: ti.template(), p, t, L, dt):
    """Convect the point's domain with a velocity gradient L [1/s]; keep L if the transfer gives it to the nodes."""
    xx, xy, yx, yy, _hoop = L
    if ti.static(transfer.GRADIENT == "strain"):
        points.write("affine", p, (xx, xy, yx, yy))
    if ti.static(shape.DOMAIN):
        dx, dy = grid.cell_size, grid.cell_height(t)
        domain = domain_of(points, shape, p, 1.0 / dx, 1.0 / dy)
        a, b, c, d = shape.convected(domain, (xx * dt, xy * dt * dy / dx, yx * dt * dx / dy, yy * dt))
        points.write("domain", p, (a * dx, b * dy, c * dx, d * dy))


@ti.func
def memory_of(points: ti.template(), law: ti.template(), p):
    """Intergranular strain (xx, yy, zz, xy) of point p; zeros for a law that does not remember."""
    if ti.static(law.REMEMBERS):
        return points.read("intergranular", p)
    nothing = alike(0.0, points.read("volume", p))
    return nothing, nothing, nothing, nothing


@ti.func
def before(points: ti.template(), law: ti.template(), p):
    """What the response of point p needs of its state before the step: void ratio, mass and the law's factors.

    The factors are a long chain of operations, each of which waits for the one before it, and need nothing from the
    nodes. Computed before the point gathers, the chain and the gathering run side by side in the processor.
    """
    volume, mass = points.read("volume", p), points.read("mass", p)
    void_ratio = volume * law.grain_density / mass - 1.0
    return void_ratio, mass, several.factors(law, points, p, points.read("stress", p), void_ratio)


@ti.func
def respond(known, points: ti.template(), law: ti.template(), p, D, spin, length, d_bar, dt):
    """Stress and volume of point p after a strain rate D of norm `length` and its non-local mean d_bar [1/s].

    `known` is what `before` gave.
    """
    void_ratio, mass, factors = known
    s0, s1, s2, s3, h0, h1, h2, h3, e = several.update_from(
        factors, law, points, p, points.read("stress", p), memory_of(points, law, p), void_ratio, D, spin, d_bar, dt
    )
    points.write("stress", p, (s0, s1, s2, s3))
    if ti.static(law.REMEMBERS):
        points.write("intergranular", p, (h0, h1, h2, h3))
    # separated grains fly apart, but land as loosely packed sand, not as less
    solid = mass * (1.0 / law.grain_density)
    points.write("volume", p, solid * (1.0 + several.loosest(law, points, p, e)))
    points.write("path", p, points.read("path", p) + length * dt)
